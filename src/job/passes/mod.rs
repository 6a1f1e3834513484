//! Passes: what a run does with its tiles, as values.
//!
//! A [`Pass`] goes over the tiles of a grid and makes a chunk of each; it may need chunks of the pass before. [`passes`]
//! says which ones a run makes, [`run_pass`] makes any range of the tiles of one: with the chunks that it needs from
//! wherever they are, into any spool. A tile's chunk depends on samples, [`Params`] and the chunks that it needs, never on
//! the range it was made in, so ranges may be made in any order, at any place, and put together. [`super::triangulate`] is
//! all passes over all of their tiles.
//!
//! `tiles` is the first pass, from samples to polished tiles whose rims are locked; `seams` the second, which polishes the
//! seams. `survey` is what comes before them under a goal; `workspace` is what one thread needs for a tile in any pass.
//!
//! - Architecture invariant: a pass reads samples and the chunks that it needs, and nothing else.

mod clocks;
mod pool;
mod seams;
mod survey;
#[cfg(test)]
mod tests;
mod tiles;
mod workspace;

pub use clocks::TileTimes;
pub(super) use survey::{End, check_corners, error_needs, lowest};
pub(super) use tiles::TileMaker;

use std::ops::Range;

use rayon::prelude::*;

use self::clocks::Clocks;
use self::pool::Pool;
use self::seams::SeamMaker;
use self::workspace::Workspace;
use super::order::in_cache_order;
use super::spool::{Chunks, Spool};
use super::{Error, Params, Quality};
use crate::base::control::{Control, Stage};
use crate::base::faults::{self, Point};
use crate::base::features::FeatureSet;
use crate::base::tiling::{TileGrid, TilePlace, TileTooLong};
use crate::field::Field;

/// A pass over the tiles of a grid, each of which becomes a chunk.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pass {
    name: PassName,
    grid: TileGrid,
    needs: Option<(PassName, TileGrid)>,
}

/// What a pass is called.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PassName {
    /// From samples to tiles: there is always one.
    Tiles,
    /// Polishing with the seams, over the tiles of the shifted grid ([`TileGrid::shifted`]).
    Seams,
}

impl Pass {
    fn tiles(grid: TileGrid) -> Pass {
        Pass { name: PassName::Tiles, grid, needs: None }
    }

    fn seams(grid: TileGrid, shifted: TileGrid) -> Pass {
        Pass { name: PassName::Seams, grid: shifted, needs: Some((PassName::Tiles, grid)) }
    }

    /// What it is called.
    pub fn name(&self) -> PassName {
        self.name
    }

    /// The tiles that it makes chunks of.
    pub fn grid(&self) -> TileGrid {
        self.grid
    }

    /// The pass whose chunks it reads, if it reads any.
    pub fn needs(&self) -> Option<PassName> {
        self.needs.map(|(name, _)| name)
    }

    /// The tiles of that pass whose chunks one of its own tiles is made from, at most four, ascending. None where it reads
    /// none.
    ///
    /// # Panics
    /// If there is no such tile.
    pub fn needed(&self, tile: usize) -> impl Iterator<Item = usize> + use<> {
        assert!(tile < self.grid.len(), "tile {tile} of {}", self.grid.len());
        let (shifted, id) = (self.grid, self.grid.tile(tile));
        self.needs.into_iter().flat_map(move |(_, grid)| {
            // Where there are as many tiles one way, the grid is not shifted that way.
            let before = |is_shifted: bool, at: usize| if is_shifted { at.saturating_sub(1) } else { at };
            let rows = before(shifted.rows() > grid.rows(), id.row)..=id.row.min(grid.rows() - 1);
            let columns = before(shifted.columns() > grid.columns(), id.column)..=id.column.min(grid.columns() - 1);
            rows.flat_map(move |row| columns.clone().map(move |column| row * grid.columns() + column))
        })
    }

    fn stage(&self) -> Stage {
        match self.name {
            PassName::Tiles => Stage::Triangulate,
            PassName::Seams => Stage::Seams,
        }
    }
}

/// The passes of a run over a raster of this size, in their order: each needs the chunks of the one before at the most.
///
/// # Errors
/// [`Error::Tile`] if a tile is longer than places in it can be exact.
pub fn passes(width: usize, height: usize, params: &Params) -> Result<Vec<Pass>, Error> {
    Ok(passes_over(grid(width, height, params)?, params.quality))
}

fn passes_over(grid: TileGrid, quality: Quality) -> Vec<Pass> {
    let seams = shifted(grid, quality).map(|shifted| Pass::seams(grid, shifted));
    std::iter::once(Pass::tiles(grid)).chain(seams).collect()
}

/// How a raster of this size is cut: the grid of the first pass.
///
/// # Errors
/// [`Error::Tile`] if a tile is longer than places in it can be exact.
pub fn grid(width: usize, height: usize, params: &Params) -> Result<TileGrid, Error> {
    TileGrid::exact(width, height, params.tile).map_err(|TileTooLong { limit, found }| Error::Tile { limit, found })
}

/// The grid of the second pass, where polishing is worth one.
pub(super) fn shifted(grid: TileGrid, quality: Quality) -> Option<TileGrid> {
    match quality {
        Quality::None | Quality::Fast => None,
        Quality::Balanced | Quality::Best => grid.shifted(),
    }
}

/// What all tiles of a run have in common.
#[derive(Clone, Copy)]
pub struct Job<'a> {
    pub(super) field: &'a Field,
    pub(super) params: &'a Params,
    /// How far the surface may stray, in tolerances.
    pub(super) max_stray: f64,
    pub(super) control: &'a Control<'a>,
    pub(super) grid: TileGrid,
    /// The grid of the second pass, if there is one.
    pub(super) shifted: Option<TileGrid>,
    /// Where tiles end, under a goal.
    pub(super) end: Option<End>,
}

impl<'a> Job<'a> {
    /// A run over a field; nothing is read yet.
    ///
    /// # Errors
    /// [`Error`]: parameters that do not go with the field, or with each other.
    pub fn new(field: &'a Field, params: &'a Params, control: &'a Control<'a>) -> Result<Job<'a>, Error> {
        params.check(field)?;
        let grid = grid(field.width(), field.height(), params)?;
        let max_stray = params.straying(params.features().and(FeatureSet::of_field(field)));
        Ok(Job { field, params, max_stray, control, grid, shifted: shifted(grid, params.quality), end: None })
    }

    /// The job once every tile has told how its insertion goes, so that it is known where all of them end; the same
    /// where there is no goal. Goes over all tiles, on the threads of the current rayon pool.
    ///
    /// # Errors
    /// [`Error`]; a budget that is too small is told of before all work where that can be known.
    pub fn surveyed(self) -> Result<Job<'a>, Error> {
        Ok(Job { end: survey::find_end(&self)?, ..self })
    }

    /// See [`passes`].
    pub fn passes(&self) -> Vec<Pass> {
        passes_over(self.grid, self.params.quality)
    }
}

/// What came of a range of a pass's tiles. Ranges add up.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PassResult {
    /// Tiles whose chunks the spool had already.
    pub found: u64,
    /// Where the time went.
    pub times: TileTimes,
    /// Samples that trimming has left bare, by the chunks that were made.
    bare: u64,
    /// Samples that trimming has left bare, by those chunks of the pass before that are counted here. Over all tiles of a
    /// pass that needs another the two are the same.
    trimmed: u64,
}

impl PassResult {
    /// Adds what came of other tiles.
    pub fn plus(self, other: PassResult) -> PassResult {
        PassResult {
            found: self.found + other.found,
            times: self.times.plus(other.times),
            bare: self.bare + other.bare,
            trimmed: self.trimmed + other.trimmed,
        }
    }

    /// Makes sure that the mesh leaves bare what trimming has, no more and no less. To be asked of what came of all tiles
    /// of a pass together.
    ///
    /// # Panics
    /// If not: polishing is broken, and its mesh must not be written.
    pub fn check_bare(&self) {
        assert_eq!(self.bare, self.trimmed, "bare samples, and samples that have been trimmed");
    }
}

/// Makes the chunks of a range of a pass's tiles and appends them to `out`, on the threads of the current rayon pool. A
/// tile whose chunk `out` has already is not made again.
///
/// `inputs` has the chunks of the pass that this one needs, those of [`Pass::needed`] at least. Memory: one workspace per
/// busy thread (a tile's samples, what its engine or polishing needs, and its mesh), whatever the size of the field.
///
/// # Errors
/// [`Error`]; chunks that were finished by then are in `out`.
///
/// # Panics
/// If there is no such pass in the job, the range is not one of its tiles, `out` is for another number of tiles, `inputs`
/// are missing or for another number of tiles, or there is a goal and the job has not been [`Job::surveyed`].
pub fn run_pass(
    job: &Job<'_>,
    pass: &Pass,
    tiles: Range<usize>,
    inputs: Option<&dyn Chunks>,
    out: &Spool,
) -> Result<PassResult, Error> {
    assert!(job.passes().contains(pass), "{pass:?} is a pass of the job");
    assert!(tiles.end <= pass.grid.len(), "tiles {tiles:?} of {}", pass.grid.len());
    assert_eq!(out.tiles(), pass.grid.len(), "chunks of a spool for this grid");
    assert_eq!(inputs.map(Chunks::tiles), pass.needs.map(|(_, grid)| grid.len()), "chunks that the pass needs");
    assert_eq!(job.end.is_some(), !job.params.goal.is_none(), "a goal that has been surveyed");
    let run = Run { job, pass, inputs, clocks: &Clocks::default() };
    let result = match pass.name {
        PassName::Tiles => run.tiles::<TileMaker>(tiles, out),
        PassName::Seams => run.tiles::<SeamMaker>(tiles, out),
    }?;
    Ok(PassResult { times: run.clocks.read(), ..result })
}

/// What the tiles of a pass have in common.
#[derive(Clone, Copy)]
struct Run<'a> {
    job: &'a Job<'a>,
    pass: &'a Pass,
    inputs: Option<&'a dyn Chunks>,
    clocks: &'a Clocks,
}

/// What one thread needs to make tiles of a pass; reused from tile to tile.
trait Maker: Default + Send {
    /// What every pass needs.
    fn shared(&mut self) -> &mut Workspace;

    /// Makes a tile and fills the chunk of [`Maker::shared`].
    fn make(&mut self, run: &Run<'_>, place: &TilePlace) -> Result<(), Error>;

    /// With the tile's chunk in [`Maker::shared`], made or found: its [`PassResult::bare`] and [`PassResult::trimmed`].
    /// The chunk may be lost.
    fn count_bare(&mut self, _run: &Run<'_>, _place: &TilePlace) -> Result<(u64, u64), Error> {
        Ok((0, 0))
    }
}

impl Run<'_> {
    /// Whether the pass's chunks are the mesh.
    fn is_last(&self) -> bool {
        self.job.passes().last() == Some(self.pass)
    }

    fn tiles<M: Maker>(&self, tiles: Range<usize>, out: &Spool) -> Result<PassResult, Error> {
        let (Job { control, .. }, stage) = (self.job, self.pass.stage());
        let samples = tiles.clone().map(|tile| self.pass.grid.place(tile).owned_samples()).sum();
        control.progress.begin(stage, tiles.len() as u64, samples);
        let makers = Pool::default();
        let each = tiles.into_par_iter().map(|tile| {
            control.cancel.check()?;
            faults::reach(Point::TileBegun);
            makers.with(|maker: &mut M| self.provide(maker, tile, out))
        });
        let result = each.try_reduce(PassResult::default, |a, b| Ok(a.plus(b)))?;
        out.sync()?;
        control.progress.end(stage);
        Ok(result)
    }

    /// Sees to it that the spool has a tile's chunk.
    fn provide<M: Maker>(&self, maker: &mut M, tile: usize, out: &Spool) -> Result<PassResult, Error> {
        let place = self.pass.grid.place(tile);
        let shared = maker.shared();
        let found = out.find(tile, &mut shared.chunk, &mut shared.encoded)?;
        if !found {
            maker.make(self, &place)?;
            if self.is_last() {
                in_cache_order(&mut maker.shared().chunk);
            }
            let Workspace { chunk, encoded, .. } = maker.shared();
            self.clocks.spool.time(|| out.append(chunk, encoded))?;
        } else if out.check_samples() {
            // The raster may have changed since.
            shared.check_samples(self.job.field, place.window)?;
        }
        let samples = maker.shared().chunk.errors.all_samples();
        let (bare, trimmed) = maker.count_bare(self, &place)?;
        maker.shared().hand_over();
        let progress = self.job.control.progress;
        if found {
            progress.found(self.pass.stage(), samples);
        } else {
            progress.step(self.pass.stage(), samples);
        }
        Ok(PassResult { found: u64::from(found), times: TileTimes::default(), bare, trimmed })
    }
}
