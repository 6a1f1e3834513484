//! What tiles are made from: the samples of the finest grid, which levels there are, and the relief of every tile.

use std::collections::BTreeMap;
use std::fs::File;
use std::path::Path;
use std::sync::Arc;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::error::PyramidError;
use super::grid::{Grid, Level, LevelOptions, TileKey, levels};
use super::kept::Kept;
use super::outline::Count;
use super::own::{self, OwnStore};
use super::prepare::{Prepared, bring, resample};
use super::quantize::Relief;
use super::samples::{Block, Patch, Samples};
use super::source::Area;
use super::store::{self, Store};
use super::voids::VoidAs;
use super::{Body, TilesRequest};
use crate::base::control::Control;

/// What was found out of a raster beside its samples, as it is kept. Whoever has it and the samples needs no raster.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Facts {
    /// The job that it belongs to.
    stamp: [u8; 4],
    /// Of the samples, where they are kept.
    checksum: u32,
    /// The same of the raster's own samples; 0 where they do not count.
    own_checksum: u32,
    grid_exponent: u32,
    /// [`Area`].
    area: (i64, i64, usize, usize),
    /// Of the store: blocks across and down, and which are in it.
    blocks: (usize, usize),
    runs: Vec<u64>,
    sums: Vec<u32>,
    pub(super) body: Body,
    pub(super) vertical: String,
    pub(super) crs: String,
    pub(super) view: BTreeMap<String, String>,
    /// Column, row, least and greatest height of the tiles of the finest level, and whether they have voids; none once they are in
    /// [`Ground::reliefs`].
    reliefs: Vec<(u32, u32, f64, f64, bool)>,
}

impl Facts {
    /// Whether it belongs to a job.
    pub(super) fn is_of(&self, stamp: [u8; 4]) -> bool {
        self.stamp == stamp
    }

    /// The same of a job.
    pub(super) fn of_job(self, stamp: [u8; 4]) -> Facts {
        Facts { stamp, ..self }
    }

    fn grid(&self) -> Grid {
        Grid { exponent: self.grid_exponent }
    }

    /// The samples in a store of theirs.
    fn samples(&self, store: Store, outside: f64) -> Samples {
        let (column, row, width, height) = self.area;
        Samples::of(self.grid(), store, Area { column, row, width, height }, outside)
    }
}

/// What tiles are made from.
pub(super) struct Ground {
    pub(super) facts: Facts,
    pub(super) samples: Samples,
    /// From level 0 on.
    pub(super) levels: Vec<Level>,
    /// Of all tiles of each level.
    pub(super) reliefs: Vec<BTreeMap<TileKey, Relief>>,
}

impl Ground {
    /// Finds it out of a raster. Samples go to a temporary file.
    pub(super) fn find(
        prepared: &Prepared,
        request: &TilesRequest,
        control: &Control<'_>,
    ) -> Result<Ground, PyramidError> {
        let grid = prepared.source.grid(request.grid_factor.trailing_zeros())?;
        let levels = levels_of(&prepared.body, grid, request)?;
        let mut samples = resample(prepared, grid, request, control)?;
        if request.own_samples {
            let folder = request.temp_dir();
            let own = OwnStore::make(prepared, &samples, (store::temporary(&folder)?, &folder), control)?;
            samples.own = Some(Arc::new(own));
        }
        let facts = facts(prepared, &samples, &levels, (0, 0), control)?;
        Ground::of(facts, samples, levels, request.void_as)
    }

    /// What is kept of a job; where nothing is, it is found out of the raster and kept. Where the raster may have changed since, its
    /// samples are brought to the grid once more, and compared.
    pub(super) fn kept(
        kept: &Kept,
        prepared: &Prepared,
        request: &TilesRequest,
        control: &Control<'_>,
    ) -> Result<Ground, PyramidError> {
        let earlier = kept.read_facts()?;
        let expected = earlier.as_ref().map(|facts| (facts.checksum, facts.own_checksum));
        if let Some(facts) = earlier.filter(|_| kept.dir().has_same_samples())
            && let Some(ground) = Ground::open(kept, facts, request)?
        {
            return Ok(ground);
        }
        let grid = prepared.source.grid(request.grid_factor.trailing_zeros())?;
        let levels = levels_of(&prepared.body, grid, request)?;
        let make = |file: (File, &Path)| bring(prepared, grid, request.outside, file, control);
        let (mut samples, checksum) = kept.bring_samples(&request.input, expected.map(|e| e.0), make)?;
        let mut own_checksum = 0;
        if request.own_samples {
            let make = |file: (File, &Path)| OwnStore::make(prepared, &samples, file, control);
            let (own, found) = kept.bring_own(&request.input, expected.map(|e| e.1), make)?;
            (samples.own, own_checksum) = (Some(Arc::new(own)), found);
        }
        let facts = facts(prepared, &samples, &levels, (checksum, own_checksum), control)?;
        kept.write_facts(&facts)?;
        Ground::of(facts, samples, levels, request.void_as)
    }

    /// What a run has been laid out with.
    pub(super) fn laid_out(kept: &Kept, request: &TilesRequest) -> Result<Ground, PyramidError> {
        let ground = kept.read_facts()?.map(|facts| Ground::open(kept, facts, request)).transpose()?.flatten();
        ground.ok_or_else(|| PyramidError::Gone { dir: kept.dir().path().to_path_buf() })
    }

    fn open(kept: &Kept, facts: Facts, request: &TilesRequest) -> Result<Option<Ground>, PyramidError> {
        let Some(store) = kept.open_samples(facts.blocks, (&facts.runs, &facts.sums))? else { return Ok(None) };
        let levels = levels_of(&facts.body, facts.grid(), request)?;
        let mut samples = facts.samples(store, request.outside);
        if request.own_samples {
            let Some(own) = kept.open_own(facts.grid())? else { return Ok(None) };
            samples.own = Some(Arc::new(own));
        }
        Ground::of(facts, samples, levels, request.void_as).map(Some)
    }

    fn of(mut facts: Facts, samples: Samples, levels: Vec<Level>, void_as: VoidAs) -> Result<Ground, PyramidError> {
        let finest = levels.last().expect("there is level 0").level;
        let relief = |(x, y, low, high, has_void)| (TileKey { level: finest, x, y }, Relief { low, high, has_void });
        let of_finest = std::mem::take(&mut facts.reliefs).into_iter().map(relief).collect();
        let mut reliefs = upwards(of_finest, finest, void_as, samples.outside);
        samples.own.as_ref().map_or(Ok(()), |own| own::widen(own, samples.grid, &mut reliefs))?;
        Ok(Ground { facts, samples, levels, reliefs })
    }

    /// Tiles of all levels.
    pub(super) fn tiles(&self) -> u64 {
        self.reliefs.iter().map(|level| level.len() as u64).sum()
    }

    /// The tiles of each level.
    pub(super) fn keys(&self) -> Vec<Vec<TileKey>> {
        self.reliefs.iter().map(|level| level.keys().copied().collect()).collect()
    }

    /// How many samples of the rectangle around the raster a tile has: what it costs to make, about.
    pub(super) fn samples_in(&self, tile: TileKey) -> u128 {
        let (grid, area) = (self.samples.grid, self.samples.area);
        let (cells, (column, row)) = (grid.cells(tile.level), tile.origin(grid));
        let overlap = |first: i64, start: i64, count: usize| {
            (first + cells).min(start + count as i64).saturating_sub(first.max(start)).max(0) as u128
        };
        let around = [-grid.columns(), 0, grid.columns()];
        let across: u128 = around.iter().map(|shift| overlap(column + shift, area.column, area.width)).sum();
        across * overlap(row, area.row, area.height)
    }
}

pub(super) fn levels_of(body: &Body, grid: Grid, request: &TilesRequest) -> Result<Vec<Level>, PyramidError> {
    let TilesRequest { max_error, max_level, error_factor, .. } = *request;
    levels(body, grid, &LevelOptions { max_error, max_level, error_factor })
}

/// Looks at all samples.
fn facts(
    prepared: &Prepared,
    samples: &Samples,
    levels: &[Level],
    (checksum, own_checksum): (u32, u32),
    control: &Control<'_>,
) -> Result<Facts, PyramidError> {
    let finest = levels.last().expect("there is level 0").level;
    let reliefs = reliefs(samples, finest, control)?;
    if reliefs.is_empty() {
        return Err(PyramidError::Nothing { path: prepared.raster.path().to_path_buf() });
    }
    let Area { column, row, width, height } = samples.area;
    Ok(Facts {
        stamp: [0; 4],
        checksum,
        own_checksum,
        grid_exponent: samples.grid.exponent,
        area: (column, row, width, height),
        blocks: samples.store.size(),
        runs: samples.store.runs(),
        sums: samples.store.sums(),
        body: prepared.body,
        vertical: prepared.vertical.clone(),
        crs: prepared.raster.crs_name(),
        view: prepared.view()?,
        reliefs: reliefs
            .into_iter()
            .map(|(tile, relief)| (tile.x, tile.y, relief.low, relief.high, relief.has_void))
            .collect(),
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
        let side = cells as usize + 1;
        let (mut found, mut is_inside, mut has_void) = (None, false, false);
        let mut count = Count::NONE;
        if samples.each_outline((column, row), (side, side), |_, _, of_block| count = count.with(of_block))? {
            (is_inside, has_void) = (count.inside > 0, count.in_voids > 0);
            found = is_inside.then_some(Relief { low: count.low, high: count.high, has_void: false });
            if count.inside + count.in_voids < (side * side) as u64 {
                found = found.map(|relief| relief.with(Relief::of(samples.outside)));
            }
        } else {
            for ((left, top), (width, height)) in samples.windows((column, row), cells, WINDOW) {
                let patch = Patch { column: column + left, row: row + top, width, height, step: 1 };
                samples.read(patch, block)?;
                is_inside |= block.inside.contains(&true);
                has_void |= block.is_void.contains(&true);
                let heights = block.heights.iter().zip(&block.is_void).filter(|(_, is_void)| !**is_void);
                let heights = heights.map(|(&height, _)| Relief::of(height));
                found = found.into_iter().chain(heights).reduce(Relief::with);
            }
        }
        if !samples.has_all((column, row), cells) {
            found = found.map(|relief| relief.with(Relief::of(samples.outside)));
        }
        if let Some(own) = samples.own.as_ref().filter(|_| is_inside) {
            let heights = own::relief(own, samples.grid, tile)?;
            found = found.into_iter().chain(heights).reduce(Relief::with);
        }
        Ok::<_, PyramidError>(found.filter(|_| is_inside).map(|relief| (tile, Relief { has_void, ..relief })))
    };
    let keys = candidates(samples, finest);
    let found: Result<Vec<_>, PyramidError> = keys.par_iter().map_init(Block::default, relief).collect();
    Ok(found?.into_iter().flatten().collect())
}

/// The relief of all tiles of all levels, from that of the finest; at level 0 of both.
fn upwards(
    finest: BTreeMap<TileKey, Relief>,
    level: u32,
    void_as: VoidAs,
    outside: f64,
) -> Vec<BTreeMap<TileKey, Relief>> {
    let unseen = Relief { has_void: void_as.is_marked(), ..Relief::of(outside) };
    let mut all = vec![finest];
    for level in (0..level).rev() {
        let children = &all[all.len() - 1];
        let mut parents: BTreeMap<TileKey, (Relief, usize)> = BTreeMap::new();
        for (child, &relief) in children {
            let parent = parents.entry(child.parent()).or_insert((relief, 0));
            *parent = (parent.0.with(relief), parent.1 + 1);
        }
        debug_assert!(parents.keys().all(|key| key.level == level));
        // Where a child is missing, the ground outside is seen, or a void.
        let whole = |(relief, count): (Relief, usize)| if count < 4 { relief.with(unseen) } else { relief };
        all.push(parents.into_iter().map(|(key, found)| (key, whole(found))).collect());
    }
    let roots = all.last_mut().expect("the finest level");
    for x in 0..2 {
        roots.entry(TileKey { level: 0, x, y: 0 }).or_insert(unseen);
    }
    all.reverse();
    all
}
