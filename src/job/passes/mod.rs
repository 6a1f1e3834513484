//! Passes: what a run does with its tiles, as values.
//!
//! A [`Pass`] goes over the tiles of a grid and makes a chunk of each; it may need chunks of the pass before. [`passes`]
//! says which ones a run makes, [`run_pass`] makes any range of the tiles of one: with the chunks that it needs from
//! wherever they are, into any spool. A tile's chunk depends on samples, [`Params`] and the chunks that it needs, never on
//! the range it was made in, so ranges may be made in any order, at any place, and put together. [`super::triangulate`] is
//! all passes over all of their tiles.
//!
//! `tiles` is the first pass, from samples to polished tiles whose rims are locked; `seams` are those that follow, which
//! polish the seams. `survey` is what comes before them under a goal, `gather` what comes after them where others have made the chunks; `workspace` is
//! what one thread needs for a tile in any pass.
//!
//! - Architecture invariant: a pass reads samples and the chunks that it needs, and nothing else.

mod clocks;
mod gather;
mod pool;
mod seams;
mod survey;
#[cfg(test)]
mod tests;
mod tiles;
mod workspace;

pub use clocks::TileTimes;
pub(super) use gather::{Gathered, gather, must_be_of_samples, same_samples};
pub(super) use pool::Pool;
pub(super) use survey::{End, check_corners, error_needs, lowest};
pub(super) use tiles::TileMaker;

use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;

use self::clocks::Clocks;
use self::seams::{SeamMaker, Way};
use self::workspace::Workspace;
use super::chains::{self, ChainStore};
use super::order::in_cache_order;
use super::spool::{Chunk, Chunks, Spool};
use super::{Error, Params, Quality};
use crate::base::control::{Control, Stage};
use crate::base::faults::{self, Point};
use crate::base::features::FeatureSet;
use crate::base::tiling::{TileGrid, TileId, TilePlace, TileTooLong};
use crate::base::{Tile, Window};
use crate::field::Field;
use crate::kernel::seam::Sides;

/// A pass over the tiles of a grid, each of which becomes a chunk.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pass {
    name: PassName,
    grid: TileGrid,
    needs: Option<(PassName, TileGrid)>,
    links: Links,
}

/// What a pass is called.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PassName {
    /// From samples to tiles: there is always one.
    Tiles,
    /// Polishing with the seams, over the tiles of the grid shifted both ways ([`TileGrid::shifted`]).
    Seams,
    /// Polishing where lines of the shifted grid have crossed seams that run down, over the tiles of the grid shifted across
    /// ([`TileGrid::shifted_across`]).
    Across,
    /// The same where seams run across, over the tiles of the grid shifted down ([`TileGrid::shifted_down`]).
    Down,
}

/// How long links of the sides of tiles are.
///
/// Where straying is limited, a long link may be in the way of what the samples beside it ask for, in all passes. So seldom that
/// the run is made again then, with short links ([`Sides::short_links`]).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(in crate::job) enum Links {
    /// As long as they can be.
    Fewest,
    /// At most a quarter of a side.
    Short,
}

impl PassName {
    /// All there are, in the order of a run.
    pub const ALL: [PassName; 4] = [PassName::Tiles, PassName::Seams, PassName::Across, PassName::Down];
}

impl Pass {
    fn tiles(grid: TileGrid) -> Pass {
        Pass { name: PassName::Tiles, grid, needs: None, links: Links::Fewest }
    }

    /// The pass of this name over the tiles of a grid, which needs this one's chunks.
    fn then(&self, name: PassName, grid: TileGrid) -> Pass {
        Pass { name, grid, needs: Some((self.name, self.grid)), links: self.links }
    }

    /// What it is called.
    pub fn name(&self) -> PassName {
        self.name
    }

    /// Where its chunks are kept, among those of all passes of a run.
    pub fn folder(&self) -> &'static str {
        folder_of(self.links, self.name)
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
        let pass = *self;
        self.needs.into_iter().flat_map(move |(_, grid)| {
            let (first, last) = pass.overlapped(grid, tile);
            let columns = first.column..=last.column;
            (first.row..=last.row)
                .flat_map(move |row| columns.clone().map(move |column| grid.index(TileId { column, row })))
        })
    }

    /// The first and the last tile of a grid that one of the pass's own tiles has more than a line in common with.
    fn overlapped(&self, grid: TileGrid, tile: usize) -> (TileId, TileId) {
        let Window { column, row, width, height } = self.grid.place(tile).window;
        (grid.owner(column, row), grid.owner(column + width - 2, row + height - 2))
    }

    /// The tile of the pass that takes over what is known of a tile of the pass before: of those that need it, one.
    fn takes_over(&self, needed: usize) -> TileId {
        let (_, grid) = self.needs.expect("a pass that reads chunks");
        let Window { column, row, .. } = grid.place(needed).window;
        self.grid.owner(column, row)
    }

    /// Where the chunks of a tile's region come from, and where they go.
    fn way(&self, tile: usize, is_last: bool) -> Way {
        let (name, from) = self.needs.expect("a pass that reads chunks");
        let (first_read, _) = self.overlapped(from, tile);
        Way { from, has_rims: name == PassName::Tiles, first_read, to: self.grid, is_last }
    }

    fn stage(&self) -> Stage {
        match self.name {
            PassName::Tiles => Stage::Triangulate,
            PassName::Seams => Stage::Seams,
            PassName::Across => Stage::CrossingsAcross,
            PassName::Down => Stage::CrossingsDown,
        }
    }
}

/// See [`Pass::folder`].
pub(super) fn folder_of(links: Links, name: PassName) -> &'static str {
    let [fewest, short] = match name {
        PassName::Tiles => ["", "short-tiles"],
        PassName::Seams => ["seams", "short-seams"],
        PassName::Across => ["across", "short-across"],
        PassName::Down => ["down", "short-down"],
    };
    match links {
        Links::Fewest => fewest,
        Links::Short => short,
    }
}

/// The passes of a run over a raster of this size, in their order: each needs the chunks of the one before at the most.
///
/// # Errors
/// [`Error::Tile`] if a tile is longer than places in it can be exact.
pub fn passes(width: usize, height: usize, params: &Params) -> Result<Vec<Pass>, Error> {
    let polishes_seams = polishes_seams(params.quality, params.straying(params.features()));
    Ok(passes_over(grid(width, height, params)?, polishes_seams))
}

/// The passes over the tiles of a grid; only the first one, if seams are not polished. Two follow at the least where there are
/// lines, so that each place of the raster's rim is inside of a tile of one of them; and one where there is a single tile.
pub(super) fn passes_over(grid: TileGrid, polishes_seams: bool) -> Vec<Pass> {
    let mut passes = vec![Pass::tiles(grid)];
    let later = [
        (PassName::Seams, grid.shifted()),
        (PassName::Across, grid.shifted_across()),
        (PassName::Down, grid.shifted_down()),
    ];
    for (name, grid) in later.into_iter().filter(|_| polishes_seams) {
        let Some(grid) = grid else { continue };
        // Without lines one way a grid may be one that has been gone over, with what has no rim.
        let is_new = passes[1..].iter().all(|pass| pass.grid != grid);
        if is_new {
            let next = passes[passes.len() - 1].then(name, grid);
            passes.push(next);
        }
    }
    passes
}

/// How a raster of this size is cut: the grid of the first pass.
///
/// # Errors
/// [`Error::Tile`] if a tile is longer than places in it can be exact.
pub fn grid(width: usize, height: usize, params: &Params) -> Result<TileGrid, Error> {
    TileGrid::exact(width, height, params.tile).map_err(|TileTooLong { limit, found }| Error::Tile { limit, found })
}

/// Whether seams are worth polishing, or need mending: where straying is limited, and a locked seam may be in the way of that.
pub(super) fn polishes_seams(quality: Quality, max_stray: f64) -> bool {
    match quality {
        Quality::None | Quality::Fast => max_stray.is_finite(),
        Quality::Balanced | Quality::Best => true,
    }
}

/// The part of the tolerance that sides are held to which later passes polish. With all of it, slivers stand beside them.
const PROVISIONAL: f64 = 0.5;

/// What all tiles of a run have in common.
#[derive(Clone)]
pub struct Job<'a> {
    pub(super) field: &'a Field,
    pub(super) params: &'a Params,
    /// How far the surface may stray, in tolerances.
    pub(super) max_stray: f64,
    pub(super) links: Links,
    pub(super) control: &'a Control<'a>,
    pub(super) grid: TileGrid,
    /// Whether passes follow the first one where there are seams.
    pub(super) polishes_seams: bool,
    /// Where tiles end, under a goal.
    pub(super) end: Option<End>,
    /// The chains of breaklines, where there are some and it is known what they are.
    pub(super) chains: Option<Arc<ChainStore>>,
}

impl<'a> Job<'a> {
    /// A run over a field; nothing is read yet.
    ///
    /// # Errors
    /// [`Error`]: parameters that do not go with the field, or with each other.
    pub fn new(field: &'a Field, params: &'a Params, control: &'a Control<'a>) -> Result<Job<'a>, Error> {
        params.check(field)?;
        params.check_lines()?;
        let grid = grid(field.width(), field.height(), params)?;
        let max_stray = params.straying(params.features().and(FeatureSet::of_field(field)));
        let polishes_seams = polishes_seams(params.quality, max_stray);
        Ok(Job {
            field,
            params,
            max_stray,
            links: Links::Fewest,
            control,
            grid,
            polishes_seams,
            end: None,
            chains: None,
        })
    }

    /// The job once every tile has told how its insertion goes, so that it is known where all of them end, and once the chains of
    /// breaklines are found; the same where there is neither a goal nor a breakline. Goes over all tiles, on the threads of the current rayon pool.
    ///
    /// # Errors
    /// [`Error`]; a budget that is too small is told of before all work where that can be known.
    pub fn surveyed(self) -> Result<Job<'a>, Error> {
        let (end, chains) = (survey::find_end(&self)?, chains::find(&self)?.map(Arc::new));
        Ok(Job { end, chains, ..self })
    }

    /// See [`passes`].
    pub fn passes(&self) -> Vec<Pass> {
        let all = passes_over(self.grid, self.polishes_seams);
        all.into_iter().map(|pass| Pass { links: self.links, ..pass }).collect()
    }

    /// How the sides of tiles are made in the first pass.
    fn sides(&self) -> Sides {
        let are_polished = self.polishes_seams && self.params.quality != Quality::None;
        // A single tile has no side that another one shares: later passes change all of them.
        let short_links = self.links == Links::Short && self.grid.len() > 1;
        Sides { share: if are_polished { PROVISIONAL } else { 1.0 }, short_links }
    }

    /// The job with short links, if it is to be made again for what came of all passes with others.
    pub fn again(&self, result: &PassResult) -> Option<Job<'a>> {
        self.with_short_links().filter(|_| result.astray > 0)
    }

    /// The job with short links, if straying is limited and its links are longer.
    pub(super) fn with_short_links(&self) -> Option<Job<'a>> {
        let may_help = self.max_stray.is_finite() && self.links == Links::Fewest;
        may_help.then(|| Job { links: Links::Short, ..self.clone() })
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
    /// pass the two are the same; none but the last one that follows the first counts.
    trimmed: u64,
    /// Edges that stray farther than they may, in chunks of the last pass.
    astray: u64,
}

impl PassResult {
    /// Adds what came of other tiles.
    pub fn plus(self, other: PassResult) -> PassResult {
        PassResult {
            found: self.found + other.found,
            times: self.times.plus(other.times),
            bare: self.bare + other.bare,
            trimmed: self.trimmed + other.trimmed,
            astray: self.astray + other.astray,
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
/// are missing or for another number of tiles, or there is a goal or a breakline and the job has not been [`Job::surveyed`].
pub fn run_pass(
    job: &Job<'_>,
    pass: &Pass,
    tiles: Range<usize>,
    inputs: Option<&dyn Chunks>,
    out: &Spool,
) -> Result<PassResult, Error> {
    let passes = job.passes();
    let at = passes.iter().position(|p| p == pass).unwrap_or_else(|| panic!("{pass:?} is a pass of the job"));
    let later: Vec<TileGrid> = passes[at + 1..].iter().map(Pass::grid).collect();
    assert!(tiles.end <= pass.grid.len(), "tiles {tiles:?} of {}", pass.grid.len());
    assert_eq!(out.tiles(), pass.grid.len(), "chunks of a spool for this grid");
    assert_eq!(inputs.map(Chunks::tiles), pass.needs.map(|(_, grid)| grid.len()), "chunks that the pass needs");
    assert_eq!(job.end.is_some(), !job.params.goal.is_none(), "a goal that has been surveyed");
    assert_eq!(job.chains.is_some(), job.params.breaklines.is_some(), "breaklines that have been surveyed");
    let run = Run { job, pass, later: &later, inputs, clocks: &Clocks::default() };
    let result = match pass.name {
        PassName::Tiles => run.tiles::<TileMaker>(tiles, out),
        PassName::Seams | PassName::Across | PassName::Down => run.tiles::<SeamMaker>(tiles, out),
    }?;
    Ok(PassResult { times: run.clocks.read(), ..result })
}

/// What the tiles of a pass have in common.
#[derive(Clone, Copy)]
struct Run<'a> {
    job: &'a Job<'a>,
    pass: &'a Pass,
    /// The grids of the passes that follow; none if the pass's chunks are the mesh.
    later: &'a [TileGrid],
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
    /// Gives the vertices of a chunk of the mesh their channels. Chunks that another pass reads go without: it has the samples.
    fn set_attributes(&self, chunk: &mut Chunk, tile: &Tile) {
        if self.later.is_empty() {
            let names = self.job.field.channels().iter().map(|c| c.name.as_str());
            chunk.set_attributes(names, |channel, vertex| tile.channel_at_vertex(channel, vertex));
        }
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
            if self.later.is_empty() {
                in_cache_order(&mut maker.shared().chunk);
            }
            let Workspace { chunk, encoded, .. } = maker.shared();
            self.clocks.spool.time(|| out.append(chunk, encoded))?;
        } else if out.check_samples() {
            // The raster may have changed since.
            shared.check_samples(self.job, place.window)?;
        }
        let samples = place.owned_samples();
        let shape = maker.shared().chunk.errors.shape.as_ref().filter(|_| self.later.is_empty());
        let astray = shape.map_or(0, |shape| shape.astray);
        let (bare, trimmed) = maker.count_bare(self, &place)?;
        maker.shared().hand_over();
        let progress = self.job.control.progress;
        if found {
            progress.found(self.pass.stage(), samples);
        } else {
            progress.step(self.pass.stage(), samples);
        }
        Ok(PassResult { found: u64::from(found), times: TileTimes::default(), bare, trimmed, astray })
    }
}
