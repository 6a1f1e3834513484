//! From a raster to a folder of tiles.

use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use rayon::prelude::*;

use super::budget::Memory;
use super::error::{BoundBy, PyramidError};
use super::grid::{Level, MAX_PARTS, TileKey};
use super::ground::Ground;
use super::kept::{Kept, KeptTile};
use super::manifest::{LAYER, Layer, PROMISE, Promise, SCHEMA};
use super::prepare::{Prepared, open};
use super::quantize::{SPAN, Steps, UNROUNDED};
use super::report::{LevelReport, TilesReport};
use super::samples::Block;
use super::tile::{LevelTask, TileMaker};
use super::voids::{VoidAs, with_voids};
use super::write::{self, StagedSet};
use super::{TilesRequest, encode, normals};
use crate::base::control::{Control, Stage};
use crate::base::faults::{self, Point};
use crate::job::plan::peak_memory;

/// Makes a set of tiles.
pub(super) fn make(request: &TilesRequest, control: &Control<'_>) -> Result<TilesReport, PyramidError> {
    let started = Instant::now();
    check_output(request)?;
    let prepared = open(request, control)?;
    let memory = &Memory::to_make(&prepared, request)?;
    memory.install(move || make_of(&prepared, request, memory, started, control))
}

fn make_of(
    prepared: &Prepared,
    request: &TilesRequest,
    memory: &Memory,
    started: Instant,
    control: &Control<'_>,
) -> Result<TilesReport, PyramidError> {
    let Some(dir) = &request.work_dir else {
        let ground = Ground::find(prepared, request, control)?;
        return Making::new(request, &ground, None, memory, control).set(Some(prepared), started);
    };
    let kept = Kept::open(dir, &prepared.job(request)?)?;
    if let Some(there) = kept.report_of(request).transpose() {
        return ended(kept, there, request, control);
    }
    let overwrite = request.overwrite || kept.dir().has_committed(&request.output);
    let made = write::check(&request.output, overwrite)
        .and_then(|()| Ground::kept(&kept, prepared, request, control))
        .and_then(|ground| Making::new(request, &ground, Some(&kept), memory, control).set(Some(prepared), started));
    ended(kept, made, request, control)
}

/// Finds an output that cannot be made, before the long run.
pub(super) fn check_output(request: &TilesRequest) -> Result<(), PyramidError> {
    let (output, work_dir) = (&request.output, &request.work_dir);
    // A work dir may have an output of its own there.
    write::check(output, request.overwrite || work_dir.is_some())?;
    let absolute = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    if work_dir.as_ref().is_some_and(|dir| absolute(dir).starts_with(absolute(output))) {
        return Err(PyramidError::Occupied { path: output.clone(), found: "the work dir in it".to_string() });
    }
    Ok(())
}

/// What becomes of a work dir once its set is there, or is not.
pub(super) fn ended(
    kept: Kept,
    made: Result<TilesReport, PyramidError>,
    request: &TilesRequest,
    control: &Control<'_>,
) -> Result<TilesReport, PyramidError> {
    match made {
        Ok(report) => {
            if !request.keep_work_dir {
                kept.finish(control);
            }
            Ok(report)
        }
        Err(error) => Err(kept.explain(error)),
    }
}

/// A set of tiles, or a part of it, while it is made.
pub(super) struct Making<'a> {
    request: &'a TilesRequest,
    ground: &'a Ground,
    kept: Option<&'a Kept>,
    memory: &'a Memory,
    control: &'a Control<'a>,
    found: AtomicU64,
}

/// What was found of the tiles of a level.
pub(super) struct MadeLevel {
    level: Level,
    report: LevelReport,
    /// Those that nobody has made, where they are only looked for.
    missing: Vec<TileKey>,
}

impl<'a> Making<'a> {
    pub(super) fn new(
        request: &'a TilesRequest,
        ground: &'a Ground,
        kept: Option<&'a Kept>,
        memory: &'a Memory,
        control: &'a Control<'a>,
    ) -> Making<'a> {
        Making { request, ground, kept, memory, control, found: AtomicU64::new(0) }
    }

    /// Makes all tiles, and writes them. Without a raster tiles are only looked for that others have made.
    pub(super) fn set(&self, prepared: Option<&Prepared>, started: Instant) -> Result<TilesReport, PyramidError> {
        let TilesRequest { output, overwrite, .. } = self.request;
        let grid_done = started.elapsed().as_secs_f64();
        let announce = |path: &Path| self.kept.map_or(Ok(()), |kept| kept.dir().staging(path));
        let overwrite = *overwrite || self.kept.is_some_and(|kept| kept.dir().has_committed(output));
        let staged = StagedSet::create(output, overwrite, &announce)?;
        let (mut levels, mut reports, mut missing) = (Vec::new(), Vec::new(), Vec::new());
        self.control.progress.begin(Stage::Triangulate, self.ground.tiles(), self.ground.tiles());
        for (number, keys) in self.ground.keys().into_iter().enumerate() {
            let made = self.level(number, &keys, Some(&staged), prepared.is_some())?;
            levels.push(made.level);
            reports.push(made.report);
            missing.extend(made.missing);
        }
        self.control.progress.end(Stage::Triangulate);
        if !missing.is_empty() {
            return Err(PyramidError::Missing { missing, of: self.ground.tiles() });
        }
        self.manifests(&staged, levels)?;
        self.control.cancel.check()?;
        prepared.map_or(Ok(()), Prepared::must_be_unchanged)?;
        let report = || self.report(&reports, prepared, grid_done, started);
        if let Some(kept) = self.kept {
            kept.keep_report(&report(), &staged.list(self.ground.keys().into_iter().flatten())?)?;
        }
        let committing = || self.kept.map_or(Ok(()), |kept| kept.dir().committing());
        staged.commit(overwrite, &committing)?;
        Ok(report())
    }

    fn report(
        &self,
        levels: &[LevelReport],
        prepared: Option<&Prepared>,
        seconds_resampling: f64,
        started: Instant,
    ) -> TilesReport {
        let (facts, samples) = (&self.ground.facts, &self.ground.samples);
        let decoded = prepared.map_or(0, |prepared| prepared.source.field.decoded_bytes());
        TilesReport {
            schema: SCHEMA,
            output: self.request.output.clone(),
            crs: facts.crs.clone(),
            vertical_crs: facts.vertical.clone(),
            grid_exponent: samples.grid.exponent,
            grid_samples: samples.area.width as u64 * samples.area.height as u64,
            own_samples: samples.own.is_some(),
            memory: self.memory.fitted,
            peak_memory_bytes: peak_memory(),
            temporary_bytes: samples.store.bytes() + samples.own.as_ref().map_or(0, |own| own.bytes()) + decoded,
            tiles_found: self.found(),
            levels: levels.to_vec(),
            seconds_resampling,
            seconds: started.elapsed().as_secs_f64(),
        }
    }

    /// How many tiles were there.
    pub(super) fn found(&self) -> u64 {
        self.found.load(Ordering::Relaxed)
    }

    /// Writes what stands beside the tiles.
    fn manifests(&self, staged: &StagedSet, levels: Vec<Level>) -> Result<(), PyramidError> {
        let (request, facts, grid) = (self.request, &self.ground.facts, self.ground.samples.grid);
        let name = request.input.file_stem().unwrap_or_default().to_string_lossy();
        staged.put_json(LAYER, &Layer::of(&name, grid, &self.ground.keys()))?;
        let promise = Promise {
            schema: SCHEMA,
            generator: format!("terrabite {}", env!("CARGO_PKG_VERSION")),
            grid_exponent: grid.exponent,
            semi_major: facts.body.semi_major,
            semi_minor: facts.body.semi_minor,
            vertical_crs: facts.vertical.clone(),
            vertical_crs_given: request.vertical_crs.clone(),
            outside: request.outside,
            void_as: request.void_as,
            max_error: request.max_error,
            error_factor: request.error_factor,
            gzip: request.gzip,
            fine_heights: request.fine_heights,
            own_samples: request.own_samples,
            max_stray: request.promised_stray(),
            view: facts.view.clone(),
            levels,
        };
        staged.put_json(PROMISE, &promise)
    }

    /// Makes tiles of a level. Where one cannot be within the error, the ground being steep beside long chords, all are made
    /// again from parts of half the size; where those are as small as they can be, within what clients expect of the level, unless it is
    /// the finest.
    pub(super) fn level(
        &self,
        number: usize,
        keys: &[TileKey],
        staged: Option<&StagedSet>,
        makes: bool,
    ) -> Result<MadeLevel, PyramidError> {
        let started = Instant::now();
        let mut level = self.ground.levels[number];
        let (grid, reliefs, void_as) = (self.ground.samples.grid, &self.ground.reliefs[number], self.request.void_as);
        let loosest = self.request.error_factor * level.client_error;
        let is_finest = number + 1 == self.ground.levels.len();
        let cuts = void_as == VoidAs::Hole;
        let mut is_loosened = false;
        staged.map_or(Ok(()), |staged| staged.prepare(keys))?;
        loop {
            if !is_loosened && self.kept.is_some_and(|kept| kept.is_loosened(level.level)) {
                (is_loosened, level) = (true, Level { max_error: loosest, ..self.ground.levels[number] });
            }
            let needed = self.kept.map_or(0, |kept| kept.parts_needed(level.level, is_loosened));
            level.parts = level.parts.max(needed);
            let void = void_as.height(reliefs, level.max_error, grid.cells(level.level), self.ground.samples.outside);
            let (samples, reliefs) = (&self.ground.samples.with_voids(void), &with_voids(reliefs, void));
            let steps = Steps::of(reliefs, self.request.fine_heights.then_some(UNROUNDED));
            let cancel = &self.control.cancel;
            let (body, memory) = (&self.ground.facts.body, self.memory);
            let cut_finer = level.parts / self.ground.levels[number].parts;
            let max_stray = self.request.max_stray;
            let task = LevelTask { body, samples, level, cut_finer, steps: &steps, max_stray, cuts, memory, cancel };
            let found_before = self.found();
            let made: Result<Vec<Option<LevelReport>>, PyramidError> = keys
                .par_iter()
                .map_init(beside_each_other, |(maker, block), &tile| {
                    self.tile(&task, tile, maker, block, staged, makes)
                })
                .collect();
            let is_fine = level.parts >= MAX_PARTS || samples.grid.cells(level.level) / i64::from(level.parts) < 8;
            // All of these lead to the same: which of them is found first depends on threads.
            let is_unmade = made.as_ref().is_err_and(PyramidError::is_of_the_ground);
            match made {
                Err(_) if is_unmade && !is_fine => {
                    level.parts *= 2;
                    self.kept.map_or(Ok(()), |kept| kept.note_parts(level.level, level.parts, is_loosened))?;
                    self.found.store(found_before, Ordering::Relaxed);
                }
                Err(_) if is_unmade && !is_finest && level.max_error < loosest => {
                    // What its parts were for no longer holds.
                    (is_loosened, level) = (true, Level { max_error: loosest, ..self.ground.levels[number] });
                    self.kept.map_or(Ok(()), |kept| kept.note_loosened(level.level))?;
                    self.found.store(found_before, Ordering::Relaxed);
                }
                Err(error) => {
                    return Err(error.of_level(BoundBy::of(level.max_error, loosest, is_finest)));
                }
                Ok(tiles) => {
                    let mut report = LevelReport::new(&level);
                    tiles.iter().flatten().for_each(|tile| report.add(tile));
                    report.seconds = started.elapsed().as_secs_f64();
                    let missing = keys.iter().zip(&tiles).filter(|(_, tile)| tile.is_none());
                    let missing = missing.map(|(key, _)| *key).collect();
                    return Ok(MadeLevel { level, report, missing });
                }
            }
        }
    }

    /// Takes a tile over that is kept, or makes it; writes it. `None`: it is not there, and is not to be made.
    fn tile(
        &self,
        task: &LevelTask<'_>,
        tile: TileKey,
        maker: &mut TileMaker,
        block: &mut Block,
        staged: Option<&StagedSet>,
        makes: bool,
    ) -> Result<Option<LevelReport>, PyramidError> {
        self.control.cancel.check()?;
        let found = self.kept.map(|kept| kept.find(tile, &task.level)).transpose()?.flatten();
        let is_found = found.is_some();
        let KeptTile { report, content } = match found {
            Some(found) => {
                self.found.fetch_add(1, Ordering::Relaxed);
                found
            }
            None if !makes => return Ok(None),
            None => {
                faults::reach(Point::TileBegun);
                let made = make_tile(task, tile, maker, block, self.request.gzip)?;
                self.kept.map_or(Ok(()), |kept| kept.put(tile, &made))?;
                made
            }
        };
        staged.map_or(Ok(()), |staged| staged.put(tile, &content))?;
        match is_found {
            true => self.control.progress.found(Stage::Triangulate, 1),
            false => self.control.progress.step(Stage::Triangulate, 1),
        }
        Ok(Some(report))
    }
}

/// What a thread makes tiles with.
fn beside_each_other() -> (TileMaker, Block) {
    let maker = TileMaker::default();
    let block = maker.block();
    (maker, block)
}

/// Makes a tile, and the bytes of its file.
fn make_tile(
    task: &LevelTask<'_>,
    tile: TileKey,
    maker: &mut TileMaker,
    block: &mut Block,
    gzip: bool,
) -> Result<KeptTile, PyramidError> {
    let (surface, measured) = task.make(tile, maker)?;
    let found = encode::numbered(&surface);
    if found > encode::MOST_VERTICES {
        return Err(PyramidError::Vertices { tile, found });
    }
    debug_assert!(surface.vertices.iter().all(|v| (0..=SPAN).contains(&v.quantum)));
    let normals = normals::encoded(task.body, task.samples, &surface, block)?;
    let bytes = encode::encode(task.body, &surface, &normals);
    let plain = bytes.len() as u64;
    let content = if gzip { write::compressed(&bytes) } else { bytes };
    let report = LevelReport {
        tiles: 1,
        triangles: surface.triangles.len() as u64,
        vertices: surface.vertices.len() as u64,
        samples: measured.samples,
        largest_error: measured.max_error,
        bytes: plain,
        bytes_in_files: content.len() as u64,
        ..LevelReport::new(&task.level)
    };
    Ok(KeptTile { report, content })
}
