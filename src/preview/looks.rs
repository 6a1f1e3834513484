//! Whether seams and the raster's rim can be seen: the hillshade of a mesh against the raster's, along lines and elsewhere.

use std::path::Path;

use super::PreviewError;
use super::mesh::for_each_triangle;
use super::relief::{Light, slope};
use super::scan::points_inside;
use super::vertical::{cell_size, percentile, rises, steepness};
use crate::base::control::Control;
use crate::base::tiling::{TileGrid, TileId};
use crate::base::{Band, Window};
use crate::formats::{self, ReadOptions};
use crate::raster::View;
use crate::verify::HeightReader;

/// How far the hillshade of a mesh is from its raster's.
///
/// The light comes from the upper left, 45° high; shades go from 0 to 1. A cell has two of them: that of its four samples
/// (the plane of least squares through them), and that of the facet at the cell's middle, the mean of all facets where it
/// lies on an edge. Their difference counts, without sign. Cells with fewer than four heights, or no facet at their
/// middle, do not.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Looks {
    /// What heights were multiplied by, beyond true proportions.
    pub vertical_scale: f64,
    /// Cells beyond both strips: neither within two cells of a tile line nor of the rim.
    pub elsewhere: Strip,
    /// Cells within two cells of a tile line, but not of the rim; `None` if there are none.
    pub tile_lines: Option<Strip>,
    /// Cells within two cells of a line through the middle of tiles. They are elsewhere, too; `None` if there are none.
    pub shifted_lines: Option<Strip>,
    /// Cells within two cells of the raster's rim.
    pub rim: Option<Strip>,
}

/// Some cells of a raster.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Strip {
    /// How many count.
    pub cells: usize,
    /// The difference of the hillshades that 999 in 1,000 of them do not exceed.
    pub difference: f64,
    /// How many times as large it is as elsewhere; `None` if it is 0 there.
    pub ratio: Option<f64>,
}

/// Cells on either side of a line that belong to it.
const NEAR: usize = 2;
/// The share of cells whose difference counts.
const MOST: f64 = 0.999;
/// What 19 of 20 slopes are shaded as, at most: gentle, so that shades follow slopes and hardly any is black or white.
const GENTLE: f64 = 0.2;

/// Holds the hillshade of a mesh against that of its raster, cut into tiles of `tile` cells (0: one tile). Heights are
/// multiplied by `factor`, beyond true proportions; `None` makes 19 of 20 slopes of the raster 0.2 (11°) at most.
///
/// Memory: six bytes for each cell of the raster.
///
/// # Errors
/// [`PreviewError`]
pub fn looks(
    raster: &Path,
    mesh: &Path,
    tile: usize,
    factor: Option<f64>,
    control: &Control,
) -> Result<Looks, PreviewError> {
    let band = View::default().open(raster, &control.cancel)?.to_band()?;
    band.holds_rows(band.width())?;
    let factor = match factor {
        Some(given) => given,
        None => steepness(&band, 1, 0.95, control)?.map_or(1.0, |steep| GENTLE / steep),
    };
    let light = Light::new(cell_size(&band), factor);
    let shades = shades(&band, mesh, &light, control)?;
    let Differences { mut elsewhere, mut tile_lines, mut shifted_lines, mut rim } =
        differences(&band, shades, &light, tile, control)?;
    let most = percentile(&mut elsewhere, MOST).map_or(0.0, f64::from);
    let strip = |values: &mut Vec<f32>| {
        let difference = f64::from(percentile(values, MOST)?);
        Some(Strip { cells: values.len(), difference, ratio: (most > 0.0).then(|| difference / most) })
    };
    Ok(Looks {
        vertical_scale: factor,
        elsewhere: strip(&mut elsewhere).unwrap_or(Strip { cells: 0, difference: 0.0, ratio: None }),
        tile_lines: strip(&mut tile_lines),
        shifted_lines: strip(&mut shifted_lines),
        rim: strip(&mut rim),
    })
}

/// The mesh's shade of every cell, row by row; NaN where there is no facet.
fn shades(band: &Band, mesh: &Path, light: &Light, control: &Control) -> Result<Vec<f32>, PreviewError> {
    let (width, height) = (band.width() - 1, band.height() - 1);
    let (mut sums, mut facets) = (vec![0.0f32; width * height], vec![0u16; width * height]);
    let mut mesh = formats::open(mesh, None, &ReadOptions { cancel: control.cancel.clone(), temp_dir: None })?;
    let window = Window { column: 0, row: 0, width: band.width(), height: band.height() };
    for_each_triangle(mesh.as_mut(), &[], &band.geo_transform(), window, control, |triangle| {
        let Some((across, down)) = slope(triangle) else { return };
        let shade = light.shade(across, down);
        // The middle of cell i lies at i + ½.
        let corners = triangle.map(|corner| (corner.column - 0.5, corner.row - 0.5));
        points_inside(corners, 0..width, 0..height, |x, y| {
            sums[y * width + x] += shade;
            facets[y * width + x] = facets[y * width + x].saturating_add(1);
        });
    })?;
    // 0 ÷ 0 is NaN.
    sums.iter_mut().zip(facets).for_each(|(sum, facets)| *sum /= f32::from(facets));
    Ok(sums)
}

/// The differences of cells, those of shifted lines twice.
struct Differences {
    elsewhere: Vec<f32>,
    tile_lines: Vec<f32>,
    shifted_lines: Vec<f32>,
    rim: Vec<f32>,
}

/// Differences take the place of the shades.
fn differences(
    band: &Band,
    mut shades: Vec<f32>,
    light: &Light,
    tile: usize,
    control: &Control,
) -> Result<Differences, PreviewError> {
    let (width, height) = (band.width() - 1, band.height() - 1);
    let grid = TileGrid::new(band.width(), band.height(), tile);
    let tiles = Near::inner_lines_of(Some(&grid), width, height);
    let shifted = Near::inner_lines_of(grid.shifted().as_ref(), width, height);
    let rim = Near::new(&[0, width], width, &[0, height], height);
    let mut sorted = Differences { elsewhere: vec![], tile_lines: vec![], shifted_lines: vec![], rim: vec![] };
    let mut kept = 0;
    let mut reader = HeightReader::new(band);
    let mut heights = vec![0.0; 2 * band.width()];
    for row in 0..height {
        control.cancel.check()?;
        reader.read(Window { column: 0, row, width: band.width(), height: 2 }, &mut heights)?;
        let (upper, lower) = heights.split_at(band.width());
        for column in 0..width {
            let (across, down) = rises([upper[column], upper[column + 1], lower[column], lower[column + 1]]);
            let difference = (shades[row * width + column] - light.shade(across, down)).abs();
            if difference.is_nan() {
                continue;
            }
            if rim.holds(column, row) {
                sorted.rim.push(difference);
            } else if tiles.holds(column, row) {
                sorted.tile_lines.push(difference);
            } else {
                if shifted.holds(column, row) {
                    sorted.shifted_lines.push(difference);
                }
                shades[kept] = difference;
                kept += 1;
            }
        }
    }
    shades.truncate(kept);
    Ok(Differences { elsewhere: shades, ..sorted })
}

/// The cells near some lines of samples.
struct Near {
    columns: Vec<bool>,
    rows: Vec<bool>,
}

impl Near {
    /// `columns` of samples are lines, in a raster that is `width` cells wide; the same for rows.
    fn new(columns: &[usize], width: usize, rows: &[usize], height: usize) -> Near {
        let near = |lines: &[usize], cells: usize| {
            let mut near = vec![false; cells];
            lines.iter().for_each(|&line| near[line.saturating_sub(NEAR)..(line + NEAR).min(cells)].fill(true));
            near
        };
        Near { columns: near(columns, width), rows: near(rows, height) }
    }

    /// The lines between the tiles of a grid.
    fn inner_lines_of(grid: Option<&TileGrid>, width: usize, height: usize) -> Near {
        let Some(grid) = grid else { return Near::new(&[], width, &[], height) };
        let columns: Vec<_> = (1..grid.columns()).map(|column| grid.window(TileId { column, row: 0 }).column).collect();
        let rows: Vec<_> = (1..grid.rows()).map(|row| grid.window(TileId { column: 0, row }).row).collect();
        Near::new(&columns, width, &rows, height)
    }

    fn holds(&self, column: usize, row: usize) -> bool {
        self.columns[column] || self.rows[row]
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{HEIGHT, Scene, WIDTH, grid};
    use super::*;
    use crate::synth::TerrainOptions;

    const TILE: usize = 40;
    const FACTOR: f64 = 0.5;

    fn looks_of(scene: &Scene, name: &str, factor: Option<f64>) -> Looks {
        let mesh = scene.mesh(name, grid(5));
        looks(&scene.path("raster.tif"), &mesh, TILE, factor, &Control::default()).expect("looks")
    }

    /// The definition, cell by cell, for a mesh that is level: its shade is that of level ground.
    #[test]
    fn differences_are_those_of_the_definition() {
        let mut scene = Scene::new(TerrainOptions::default());
        let heights = std::mem::replace(&mut scene.heights, vec![0.0; WIDTH * HEIGHT]);
        let found = looks_of(&scene, "mesh.ply", Some(FACTOR));
        let within = |at: usize, lines: &[usize]| lines.iter().any(|&line| at + 2 >= line && at < line + 2);
        let mut expected: [Vec<f64>; 4] = Default::default();
        for (column, row) in (0..HEIGHT - 1).flat_map(|r| (0..WIDTH - 1).map(move |c| (c, r))) {
            let h = |right: usize, down: usize| heights[(row + down) * WIDTH + column + right];
            // Cells are 10 m wide.
            let dx = FACTOR * (h(1, 0) + h(1, 1) - h(0, 0) - h(0, 1)) / 20.0;
            let dy = FACTOR * (h(0, 1) + h(1, 1) - h(0, 0) - h(1, 0)) / 20.0;
            let shade = (0.5 * dx + 0.5 * dy + 0.5f64.sqrt()) / (1.0 + dx * dx + dy * dy).sqrt();
            let difference = (shade.clamp(0.0, 1.0) - 0.5f64.sqrt()).abs();
            if within(column, &[0, WIDTH - 1]) || within(row, &[0, HEIGHT - 1]) {
                expected[3].push(difference);
            } else if within(column, &[40, 80, 120]) || within(row, &[40, 80]) {
                expected[1].push(difference);
            } else {
                expected[0].push(difference);
                if within(column, &[20, 60, 100, 140]) || within(row, &[20, 60, 100]) {
                    expected[2].push(difference);
                }
            }
        }
        let strips = [Some(found.elsewhere), found.tile_lines, found.shifted_lines, found.rim];
        for (mut values, strip) in expected.into_iter().zip(strips) {
            values.sort_by(f64::total_cmp);
            let most = values[(values.len() * 999).div_ceil(1000) - 1];
            let strip = strip.expect("cells");
            assert_eq!(strip.cells, values.len());
            assert!((strip.difference - most).abs() < 1e-5, "{strip:?}, expected {most}");
            assert!((strip.ratio.expect("a ratio") * found.elsewhere.difference - most).abs() < 1e-5);
        }
    }

    #[test]
    fn what_is_spoiled_shows_where_it_is() {
        let mut scene = Scene::new(TerrainOptions::default());
        let whole = looks_of(&scene, "whole.ply", None);
        // Every tenth vertex of a tile line is lifted, as far as its triangles reach.
        (10..HEIGHT - 10).step_by(10).for_each(|row| scene.heights[row * WIDTH + 80] += 30.0);
        let lifted = looks_of(&scene, "lines.ply", None);
        let of = |strip: Option<Strip>| strip.expect("cells").difference;
        assert!(of(lifted.tile_lines) > 2.0 * of(whole.tile_lines), "{lifted:?}, before {whole:?}");
        assert_eq!(
            (lifted.vertical_scale, lifted.rim),
            (
                whole.vertical_scale,
                lifted.rim.map(|rim| Strip {
                    ratio: Some(rim.difference / lifted.elsewhere.difference),
                    ..whole.rim.expect("cells")
                })
            )
        );
    }

    #[test]
    fn one_tile_has_a_rim_and_no_lines() {
        let scene = Scene::new(TerrainOptions::default());
        let mesh = scene.mesh("mesh.ply", grid(5));
        let found = looks(&scene.path("raster.tif"), &mesh, 0, None, &Control::default()).expect("looks");
        assert!(found.tile_lines.is_none() && found.shifted_lines.is_none() && found.rim.is_some(), "{found:?}");
        assert_eq!(found.elsewhere.cells + found.rim.expect("cells").cells, (WIDTH - 1) * (HEIGHT - 1));
    }
}
