//! Vertices of sides for the raster's own samples: those that lie within a band of a side's line bind it at their feet. A side stays a
//! function of its line, its ends and the level, as bands do.
//!
//! A side that is off at a foot gets a vertex there, with the height of the sample; then the samples of the grid on its new links
//! are looked at once more, and the worst of all become vertices until none is off. Where a foot is beside a sample of the grid that is
//! nearer to it than the sample that it is of, there is none: between two such vertices the side would be a wall. The sample then
//! is far enough from the line to have a vertex of its own.

use super::store::{OwnSample, OwnStore, Rectangle};
use super::{BAND_STEPS, band};
use crate::pyramid::error::PyramidError;
use crate::pyramid::fall::Fall;
use crate::pyramid::grid::Grid;
use crate::pyramid::lines::Line;
use crate::pyramid::quantize::{SPAN, snap};
use crate::pyramid::rim;

/// The share of the tolerance that a side may be off by at the foot of a sample; the rest is for what surrounds the sample.
const SHARE: f64 = 0.75;

/// The least slant of the way from a sample of the grid on the line to one beside it, for a vertex at the foot of the latter.
const SLANT: f64 = 0.25;

/// A vertex of a side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::pyramid) struct OnSide {
    /// The sample of the grid that it is, or one near it, in cells from the line's first.
    pub(in crate::pyramid) at: i64,
    /// Its coordinate in the format, from the west or the north.
    pub(in crate::pyramid) lattice: i64,
    pub(in crate::pyramid) height: f64,
}

/// Where a line lies in its tile.
#[derive(Debug, Clone, Copy)]
pub(in crate::pyramid) struct Along {
    pub(in crate::pyramid) line: Line,
    /// Its first sample along it, in cells from the tile's north-western corner.
    pub(in crate::pyramid) first: i64,
    /// Cells along the tile's side.
    pub(in crate::pyramid) tile_cells: i64,
    /// That of a square with this side.
    pub(in crate::pyramid) fall: Fall,
}

impl Along {
    /// A sample of the grid as a vertex, rounded that way along the line.
    pub(in crate::pyramid) fn sample(&self, at: i64, height: f64, away: i64) -> OnSide {
        let (cells, place) = (self.tile_cells, self.first + at);
        // Rows count from the south in the format.
        let lattice = match self.line.down {
            true => SPAN - rim::rounded(cells - place, cells, -away),
            false => rim::rounded(place, cells, away),
        };
        OnSide { at, lattice, height }
    }

    /// Which way a sample is rounded as a vertex, given which of the line's are samples of the raster.
    pub(in crate::pyramid) fn away(&self, inside: &[bool], at: i64) -> i64 {
        if rim::counts(self.tile_cells) { rim::away_on_line(inside, at as usize) } else { 0 }
    }

    /// The place of the lattice nearest to one on the line.
    fn nearest(&self, at: f64, height: f64) -> OnSide {
        let lattice = ((self.first as f64 + at) * SPAN as f64 / self.tile_cells as f64).round() as i64;
        let snap = snap(self.tile_cells);
        let sample = (at / snap as f64).round() as i64 * snap;
        OnSide { at: sample.clamp(0, self.line.length), lattice, height }
    }

    /// By how much a link of one cell sags, times four: a longer one sags by as much as its length squared is more.
    fn bend(&self) -> f64 {
        let Fall { body, grid, top, cells } = self.fall;
        let (across, along) = body.bends(grid, if self.line.down { top + cells / 2 } else { top });
        if self.line.down { along } else { across }
    }

    /// Where a vertex is, in cells from the line's first sample.
    fn place(&self, vertex: &OnSide) -> f64 {
        vertex.lattice as f64 * self.tile_cells as f64 / SPAN as f64 - self.first as f64
    }
}

/// What a side is bound by at a place.
struct Bound {
    at: f64,
    height: f64,
    limit: f64,
    /// What mends it; `None` where nothing may.
    vertex: Option<OnSide>,
}

/// The samples of the grid on a line.
pub(in crate::pyramid) struct OnLine<'a> {
    pub(in crate::pyramid) heights: &'a [f64],
    pub(in crate::pyramid) inside: &'a [bool],
    /// How far the side may be from each.
    pub(in crate::pyramid) limits: &'a [f64],
}

/// A side with what the raster's own samples ask for; `vertices` are those without.
pub(in crate::pyramid) fn refine(
    (own, grid): (&OwnStore, Grid),
    along: Along,
    vertices: &[OnSide],
    on_line: &OnLine<'_>,
    tolerance: f64,
) -> Result<Vec<OnSide>, PyramidError> {
    let feet = feet((own, grid), &along, SHARE * tolerance)?;
    let mut refined = vec![vertices[0]];
    for link in vertices.windows(2) {
        split(&along, (link[0], link[1]), &feet, false, on_line, &mut refined);
    }
    Ok(refined)
}

/// Adds the vertices after the first of a link, up to its last. The samples of the grid count on links that are new.
fn split(
    along: &Along,
    (from, to): (OnSide, OnSide),
    feet: &[Bound],
    is_new: bool,
    on_line: &OnLine<'_>,
    refined: &mut Vec<OnSide>,
) {
    let ends = (along.place(&from), along.place(&to));
    let bend = along.bend();
    let off = |bound: &Bound| {
        let length = ends.1 - ends.0;
        let share = ((bound.at - ends.0) / length).clamp(0.0, 1.0);
        let sag = bend * length * length * share * (1.0 - share);
        let off = (from.height + share * (to.height - from.height) - sag - bound.height).abs();
        let vertex = bound.vertex.filter(|v| from.lattice < v.lattice && v.lattice < to.lattice)?;
        (off > bound.limit).then_some((off / bound.limit, vertex))
    };
    let feet_here = &feet[feet.partition_point(|b| b.at < ends.0)..feet.partition_point(|b| b.at <= ends.1)];
    // An end on the lattice may be beyond the last sample, which it stands for.
    let last = (ends.1.floor() as usize).min(on_line.heights.len() - 1);
    let samples = is_new.then(|| (ends.0.ceil().max(0.0) as usize)..last + 1);
    let samples = samples.into_iter().flatten().map(|i| sample_bound(along, i, on_line));
    let worst = feet_here.iter().filter_map(off).chain(samples.filter_map(|bound| off(&bound)));
    match worst.reduce(|a, b| if b.0 > a.0 { b } else { a }) {
        None => refined.push(to),
        Some((_, vertex)) => {
            split(along, (from, vertex), feet, true, on_line, refined);
            split(along, (vertex, to), feet, true, on_line, refined);
        }
    }
}

/// What a sample of the grid on a line binds.
fn sample_bound(along: &Along, i: usize, on_line: &OnLine<'_>) -> Bound {
    let OnLine { heights, inside, limits } = on_line;
    let snap = snap(along.tile_cells) as usize;
    let to = ((i + snap / 2) / snap * snap).min(heights.len() - 1);
    // A vertex that can stand beyond the raster only has the height of the sample that it is for.
    let height = heights[if inside[i] && !inside[to] { i } else { to }];
    Bound {
        at: i as f64,
        height: heights[i],
        limit: limits[i],
        vertex: Some(along.sample(to as i64, height, along.away(inside, to as i64))),
    }
}

/// What samples in the band of a line bind, in the order of their feet.
fn feet((own, grid): (&OwnStore, Grid), along: &Along, limit: f64) -> Result<Vec<Bound>, PyramidError> {
    let Along { line, tile_cells, .. } = *along;
    let band = band(tile_cells);
    let step = tile_cells as f64 / SPAN as f64;
    let ends = |first: i64, runs: bool| match runs {
        true => (first as f64, (first + line.length) as f64),
        // What is in the band is decided below, the same from both sides of the antimeridian.
        false => (first as f64 - 1.01 * band, first as f64 + 1.01 * band),
    };
    let rectangle = Rectangle { columns: ends(line.column, !line.down), rows: ends(line.row, line.down) };
    let mut found = Vec::new();
    own.read(rectangle, &mut found)?;
    let bound = |sample: &OwnSample| {
        let (at, beside) = match line.down {
            true => (sample.row - line.row as f64, columns_from(grid, line.column, sample.lon)),
            false => (sample.column - line.column as f64, sample.row - line.row as f64),
        };
        let (beside, along_line) = (beside.abs(), (at - at.round()).abs());
        let is_wall = beside > BAND_STEPS * step && along_line < SLANT * beside;
        let vertex = (!is_wall).then(|| along.nearest(at, sample.height));
        (beside <= band).then_some(Bound { at, height: sample.height, limit, vertex })
    };
    let mut feet: Vec<Bound> = found.iter().filter_map(bound).collect();
    feet.sort_by(|a, b| a.at.total_cmp(&b.at).then(a.height.total_cmp(&b.height)));
    Ok(feet)
}

/// How many columns a longitude is east of a column, the same for all numbers that the column has.
fn columns_from(grid: Grid, column: i64, lon: f64) -> f64 {
    let around = grid.columns() as f64;
    let columns = (lon + 180.0) / grid.cell() - column.rem_euclid(grid.columns()) as f64;
    if columns > 0.5 * around { columns - around } else { columns }
}
