//! From a raster to a folder of tiles.

use std::collections::BTreeMap;
use std::time::Instant;

use rayon::prelude::*;

use super::error::PyramidError;
use super::grid::{Grid, Level, LevelOptions, MAX_PARTS, TileKey, levels};
use super::manifest::{LAYER, Layer, PROMISE, Promise, SCHEMA};
use super::quantize::{Relief, SPAN, Steps};
use super::report::{LevelReport, TilesReport};
use super::samples::{Block, Patch, Samples};
use super::source::{Scratch, Source};
use super::tile::{LevelTask, TileMaker};
use super::write::StagedSet;
use super::{Body, TilesRequest, encode, normals};
use crate::base::control::{Control, Stage};
use crate::field::{Field, FieldOptions};
use crate::raster::Raster;

/// A raster on the finest grid.
pub(super) struct Prepared {
    pub(super) raster: Raster,
    pub(super) source: Source,
    pub(super) body: Body,
    pub(super) vertical: String,
}

/// Opens a raster, and finds out how it lies on its ellipsoid.
pub(super) fn open(request: &TilesRequest, control: &Control<'_>) -> Result<Prepared, PyramidError> {
    let path = &request.input;
    let raster = request.view.open(path, &control.cancel)?;
    raster.warnings().iter().for_each(|warning| control.progress.warn(warning));
    let geodesy = raster.geodesy(request.vertical_crs.as_deref());
    let geodesy = geodesy.map_err(|source| PyramidError::Geodesy { path: path.clone(), source })?;
    let body = Body { semi_major: geodesy.radii.0, semi_minor: geodesy.radii.1 };
    let vertical = geodesy.vertical.clone();
    let options = FieldOptions { temp_dir: request.temp_dir(), ..FieldOptions::default() };
    let field = Field::open(&raster.to_band()?, &options, control)?;
    Ok(Prepared { raster, source: Source::new(field, geodesy), body, vertical })
}

/// Brings all samples to the finest grid, into a temporary file.
pub(super) fn resample(
    prepared: &Prepared,
    grid: Grid,
    request: &TilesRequest,
    control: &Control<'_>,
) -> Result<Samples, PyramidError> {
    let source = &prepared.source;
    let area = source.area(grid)?;
    let fill = |scratch: &mut Scratch, first: (i64, i64), heights: &mut [f64]| {
        source.fill(grid, area, scratch, first, heights)
    };
    let folder = request.temp_dir();
    Samples::make(grid, area, request.outside, &folder, || source.scratch(), fill, control)
}

/// Makes a set of tiles on the threads of the current rayon pool.
pub(super) fn make(request: &TilesRequest, control: &Control<'_>) -> Result<TilesReport, PyramidError> {
    let started = Instant::now();
    let staged = StagedSet::create(&request.output, request.overwrite, request.gzip)?;
    let prepared = open(request, control)?;
    let grid = prepared.source.grid(request.grid_factor.trailing_zeros())?;
    let options =
        LevelOptions { max_error: request.max_error, max_level: request.max_level, error_factor: request.error_factor };
    let plan = levels(&prepared.body, grid, &options)?;
    let samples = resample(&prepared, grid, request, control)?;
    let finest = plan.last().expect("there is level 0").level;
    let reliefs = reliefs(&samples, finest, control)?;
    if reliefs.is_empty() {
        return Err(PyramidError::Nothing { path: request.input.clone() });
    }
    let resampled = started.elapsed().as_secs_f64();
    let all = upwards(reliefs, finest, request.outside);
    let tiles = all.iter().map(|level| level.len() as u64).sum();
    control.progress.begin(Stage::Triangulate, tiles, tiles);
    let (mut reports, mut made) = (Vec::new(), Vec::new());
    for (level, reliefs) in plan.iter().zip(&all) {
        let (level, report) = make_level(&prepared.body, &samples, *level, reliefs, &staged, control)?;
        made.push(level);
        reports.push(report);
    }
    control.progress.end(Stage::Triangulate);
    let keys: Vec<Vec<TileKey>> = all.iter().map(|level| level.keys().copied().collect()).collect();
    let name = request.input.file_stem().unwrap_or_default().to_string_lossy();
    staged.put_json(LAYER, &Layer::of(&name, grid, &keys))?;
    let promise = Promise {
        schema: SCHEMA,
        generator: format!("terrabite {}", env!("CARGO_PKG_VERSION")),
        grid_exponent: grid.exponent,
        semi_major: prepared.body.semi_major,
        semi_minor: prepared.body.semi_minor,
        vertical_crs: prepared.vertical.clone(),
        vertical_crs_given: request.vertical_crs.clone(),
        outside: request.outside,
        max_error: request.max_error,
        error_factor: request.error_factor,
        gzip: request.gzip,
        levels: made,
    };
    staged.put_json(PROMISE, &promise)?;
    control.cancel.check()?;
    staged.commit(request.overwrite)?;
    Ok(TilesReport {
        schema: SCHEMA,
        output: request.output.clone(),
        crs: prepared.raster.crs_name(),
        vertical_crs: prepared.vertical,
        grid_exponent: grid.exponent,
        grid_samples: samples.area.width as u64 * samples.area.height as u64,
        temporary_bytes: samples.store.bytes() + prepared.source.field.decoded_bytes(),
        levels: reports,
        seconds_resampling: resampled,
        seconds: started.elapsed().as_secs_f64(),
    })
}

/// Where the tiles of a level that the raster may touch are.
fn candidates(samples: &Samples, level: u32) -> Vec<TileKey> {
    let cells = samples.grid.cells(level);
    let rows = samples.area.row / cells..=(samples.area.row + samples.area.height as i64 - 1) / cells;
    let last = samples.area.column + samples.area.width as i64 - 1;
    // A sample on a line is of the tiles on both sides.
    let columns = (samples.area.column - 1).div_euclid(cells)..=last.div_euclid(cells);
    let around = 2i64 << level;
    let from_south = |row: i64| (1i64 << level) - 1 - row;
    let mut keys: Vec<TileKey> = rows
        .flat_map(|row| [row - 1, row])
        .filter(|row| (0..1i64 << level).contains(row))
        .flat_map(|row| {
            let key =
                move |column: i64| TileKey { level, x: column.rem_euclid(around) as u32, y: from_south(row) as u32 };
            columns.clone().map(key)
        })
        .collect();
    keys.sort_unstable();
    keys.dedup();
    keys
}

/// Samples that are read at a time, across and down.
const WINDOW: i64 = 256;

/// The relief of all tiles of the finest level that have a sample of the raster.
fn reliefs(samples: &Samples, finest: u32, control: &Control<'_>) -> Result<BTreeMap<TileKey, Relief>, PyramidError> {
    let cells = samples.grid.cells(finest);
    let relief = |block: &mut Block, &tile: &TileKey| {
        control.cancel.check()?;
        let (column, row) = tile.origin(samples.grid);
        let mut found = None;
        let mut is_inside = false;
        for ((left, top), (width, height)) in samples.windows((column, row), cells, WINDOW) {
            let patch = Patch { column: column + left, row: row + top, width, height, step: 1 };
            samples.read(patch, block)?;
            is_inside |= block.inside.contains(&true);
            let heights = block.heights.iter().copied().map(Relief::of);
            found = found.into_iter().chain(heights).reduce(Relief::with);
        }
        if !samples.has_all((column, row), cells) {
            found = found.map(|relief| relief.with(Relief::of(samples.outside)));
        }
        Ok::<_, PyramidError>(found.filter(|_| is_inside).map(|relief| (tile, relief)))
    };
    let keys = candidates(samples, finest);
    let found: Result<Vec<_>, PyramidError> = keys.par_iter().map_init(Block::default, relief).collect();
    Ok(found?.into_iter().flatten().collect())
}

/// The relief of all tiles of all levels, from that of the finest; at level 0 of both.
fn upwards(finest: BTreeMap<TileKey, Relief>, level: u32, outside: f64) -> Vec<BTreeMap<TileKey, Relief>> {
    let mut all = vec![finest];
    for level in (0..level).rev() {
        let children = &all[all.len() - 1];
        let mut parents: BTreeMap<TileKey, (Relief, usize)> = BTreeMap::new();
        for (child, &relief) in children {
            let parent = parents.entry(child.parent()).or_insert((relief, 0));
            *parent = (parent.0.with(relief), parent.1 + 1);
        }
        debug_assert!(parents.keys().all(|key| key.level == level));
        // Where a child is missing, the ground outside is seen.
        let whole =
            |(relief, count): (Relief, usize)| if count < 4 { relief.with(Relief::of(outside)) } else { relief };
        all.push(parents.into_iter().map(|(key, found)| (key, whole(found))).collect());
    }
    let roots = all.last_mut().expect("the finest level");
    for x in 0..2 {
        roots.entry(TileKey { level: 0, x, y: 0 }).or_insert(Relief::of(outside));
    }
    all.reverse();
    all
}

/// Makes all tiles of a level. Where one cannot be within the error, the ground being steep beside long chords, all are made
/// again from parts of half the size.
fn make_level(
    body: &Body,
    samples: &Samples,
    mut level: Level,
    reliefs: &BTreeMap<TileKey, Relief>,
    staged: &StagedSet,
    control: &Control<'_>,
) -> Result<(Level, LevelReport), PyramidError> {
    let started = Instant::now();
    let steps = Steps::of(reliefs);
    let keys: Vec<TileKey> = reliefs.keys().copied().collect();
    staged.prepare(&keys)?;
    loop {
        let task = LevelTask { body, samples, level, steps: &steps, cancel: &control.cancel };
        let made: Result<Vec<LevelReport>, PyramidError> = keys
            .par_iter()
            .map_init(<(TileMaker, Block)>::default, |(maker, block), &tile| {
                make_tile(&task, tile, maker, block, staged, control)
            })
            .collect();
        let is_fine = level.parts >= MAX_PARTS || samples.grid.cells(level.level) / i64::from(level.parts) < 8;
        match made {
            Err(PyramidError::Unreachable { .. }) if !is_fine => level.parts *= 2,
            Err(error) => return Err(error),
            Ok(tiles) => {
                let mut report = LevelReport::new(&level);
                tiles.iter().for_each(|tile| report.add(tile));
                report.seconds = started.elapsed().as_secs_f64();
                return Ok((level, report));
            }
        }
    }
}

/// Makes and writes a tile.
fn make_tile(
    task: &LevelTask<'_>,
    tile: TileKey,
    maker: &mut TileMaker,
    block: &mut Block,
    staged: &StagedSet,
    control: &Control<'_>,
) -> Result<LevelReport, PyramidError> {
    let (surface, measured) = task.make(tile, maker)?;
    let found = encode::numbered(&surface);
    if found > encode::MOST_VERTICES {
        return Err(PyramidError::Vertices { tile, found });
    }
    debug_assert!(surface.vertices.iter().all(|v| (0..=SPAN).contains(&v.quantum)));
    let normals = normals::encoded(task.body, task.samples, &surface, block)?;
    let bytes = encode::encode(task.body, &surface, &normals);
    let in_file = staged.put(tile, &bytes)?;
    control.progress.step(Stage::Triangulate, 1);
    Ok(LevelReport {
        tiles: 1,
        triangles: surface.triangles.len() as u64,
        vertices: surface.vertices.len() as u64,
        samples: measured.samples,
        largest_error: measured.max_error,
        bytes: bytes.len() as u64,
        bytes_in_files: in_file,
        ..LevelReport::new(&task.level)
    })
}
