//! Tiles made in parts, by processes on one machine or on many: laid out once, made by any number of them, merged in the end.
//!
//! Whoever lays a run out brings the samples of the grid into the work dir, and finds the relief of every tile. From then on
//! nobody needs the raster, and tiles depend on no other: there is one pass. Where a tile cannot be made from parts of a size
//! ([`super::make`]), its level is made again from smaller ones, and that is noted: tiles that others have made from
//! larger ones count as missing.

use std::path::{Path, PathBuf};
use std::time::Instant;

use serde::Serialize;

use super::TilesRequest;
use super::budget::Memory;
use super::error::PyramidError;
use super::grid::TileKey;
use super::ground::Ground;
use super::kept::Kept;
use super::make::{Making, check_output, ended};
use super::manifest::SCHEMA;
use super::prepare::open;
use super::report::TilesReport;
use crate::base::control::{Control, Stage};
use crate::job::shards::{Shard, Share};

/// A run that has been laid out for shards.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TilesLayout {
    /// The version of this report.
    pub schema: u32,
    /// The work dir.
    pub work_dir: PathBuf,
    /// Samples of the grid in the rectangle around the raster, which the work dir has 8 bytes of each of.
    pub grid_samples: u64,
    /// How many tiles each level has, from 0 on.
    pub tiles: Vec<u64>,
    /// Wall clock.
    pub seconds: f64,
}

impl std::fmt::Display for TilesLayout {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let tiles: u64 = self.tiles.iter().sum();
        writeln!(f, "work dir  {}", self.work_dir.display())?;
        writeln!(f, "grid      {} samples, of 8 bytes each", self.grid_samples)?;
        writeln!(f, "pass      1: {tiles} tiles of levels 0 to {}", self.tiles.len().saturating_sub(1))?;
        write!(f, "time      {:.1} s", self.seconds)
    }
}

/// What a process has done of its shard.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TilesShare {
    /// The version of this report.
    pub schema: u32,
    /// The work dir.
    pub work_dir: PathBuf,
    /// The shard, as "3/64".
    pub shard: String,
    /// Its tiles. None waits for others.
    #[serde(flatten)]
    pub share: Share,
    /// Wall clock.
    pub seconds: f64,
}

impl std::fmt::Display for TilesShare {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        writeln!(f, "shard  {}", self.shard)?;
        writeln!(f, "tiles  {} made, {} found", self.share.made, self.share.found)?;
        write!(f, "time   {:.1} s", self.seconds)
    }
}

/// Lays a run out in [`TilesRequest::work_dir`], which keeps what is there of the same request. `words` are those of the command that
/// asks for it, after the program's name: other processes follow them. The raster is not needed afterwards.
///
/// # Errors
/// [`PyramidError`].
pub fn lay_out_tiles(
    request: &TilesRequest,
    words: Vec<String>,
    control: &Control<'_>,
) -> Result<TilesLayout, PyramidError> {
    let (started, dir) = (Instant::now(), dir(request)?);
    let prepared = open(request, control)?;
    let memory = &Memory::to_bring(&prepared, request)?;
    memory.install(move || {
        let kept = Kept::open(dir, &prepared.job(request)?)?;
        let laid_out = Ground::kept(&kept, &prepared, request, control).and_then(|ground| {
            prepared.must_be_unchanged()?;
            kept.lay_out(words).map(|()| ground)
        });
        let ground = match laid_out {
            Ok(ground) => ground,
            // There is nothing that the same command could go on from.
            Err(error) if error.is_final() || !kept.has_samples() => {
                kept.finish(control);
                return Err(error);
            }
            Err(error) => return Err(kept.explain(error)),
        };
        let area = ground.samples.area;
        Ok(TilesLayout {
            schema: SCHEMA,
            work_dir: dir.to_path_buf(),
            grid_samples: area.width as u64 * area.height as u64,
            tiles: ground.keys().iter().map(|level| level.len() as u64).collect(),
            seconds: started.elapsed().as_secs_f64(),
        })
    })
}

/// Makes a shard of a run that has been laid out with the same request in [`TilesRequest::work_dir`]. Tiles that are there are not made
/// again. Any number of processes may be at it at once, also at the same shard.
///
/// # Errors
/// [`PyramidError`]; tiles that were finished by then are kept.
pub fn work_on_tiles(request: &TilesRequest, shard: Shard, control: &Control<'_>) -> Result<TilesShare, PyramidError> {
    let (started, dir) = (Instant::now(), dir(request)?);
    let kept = Kept::join_laid_out(dir)?;
    let ground = Ground::laid_out(&kept, request)?;
    let memory = &Memory::to_work(&ground, request)?;
    let making = Making::new(request, &ground, Some(&kept), memory, control);
    let tiles = share(&ground, shard);
    let count: u64 = tiles.iter().map(|level| level.len() as u64).sum();
    memory.install(|| {
        control.progress.begin(Stage::Triangulate, count, count);
        let all = tiles.iter().enumerate();
        all.into_iter().try_for_each(|(level, keys)| making.level(level, keys, None, true).map(|_| ()))
    })?;
    control.progress.end(Stage::Triangulate);
    let found = making.found();
    Ok(TilesShare {
        schema: SCHEMA,
        work_dir: dir.to_path_buf(),
        shard: shard.to_string(),
        share: Share { tiles: count, made: count - found, found, waiting: 0 },
        seconds: started.elapsed().as_secs_f64(),
    })
}

/// Writes the set of a run whose tiles are all there: the bytes that [`super::tiles`] writes for the same request. The work dir goes,
/// unless [`TilesRequest::keep_work_dir`] says otherwise.
///
/// # Errors
/// [`PyramidError`]; where tiles are missing, [`PyramidError::Missing`]. Nothing is left under the output's name then.
pub fn merge_tiles(request: &TilesRequest, control: &Control<'_>) -> Result<TilesReport, PyramidError> {
    let (started, dir) = (Instant::now(), dir(request)?);
    check_output(request)?;
    let kept = Kept::open_laid_out(dir)?;
    if let Some(there) = kept.report_of(request).transpose() {
        return ended(kept, there, request, control);
    }
    let made = Ground::laid_out(&kept, request).and_then(|ground| {
        let memory = &Memory::to_merge(&ground, request)?;
        memory.install(|| Making::new(request, &ground, Some(&kept), memory, control).set(None, started))
    });
    match made {
        // The message says what is to be done.
        Err(error @ (PyramidError::Missing { .. } | PyramidError::Gone { .. })) => Err(error),
        made => ended(kept, made, request, control),
    }
}

fn dir(request: &TilesRequest) -> Result<&Path, PyramidError> {
    request.work_dir.as_deref().ok_or(PyramidError::NoWorkDir)
}

/// The tiles of a shard, level by level. Shards cost about the same: a tile counts by its samples, and is of the shard in whose share
/// of all samples, one tile after the other, the middle of its own is.
fn share(ground: &Ground, shard: Shard) -> Vec<Vec<TileKey>> {
    let keys = ground.keys();
    // Doubled, so that there is a middle; a tile costs something even if it has none.
    let cost = |tile: &TileKey| 2 * (ground.samples_in(*tile) + 1);
    let total: u128 = keys.iter().flatten().map(cost).sum();
    let mut before = 0;
    let mut is_ours = |tile: &TileKey| {
        let middle = before + cost(tile) / 2;
        before += cost(tile);
        shard.has(middle, total)
    };
    keys.into_iter().map(|level| level.into_iter().filter(|tile| is_ours(tile)).collect()).collect()
}
