//! What of an earlier run holds for a raster that has changed in part.
//!
//! A tile of the first pass depends on its samples, and its sides on which samples of the lines beside it are valid: it is taken over
//! if its samples and those of its neighbours are the same. A tile of a later pass depends on its samples and on the chunks that it
//! needs: it is taken over if its samples are the same and all of those were. Samples are compared by their checksum
//! ([`crate::base::Tile::checksum`]), 32 bits a tile.
//!
//! Lines may be others, too. What a tile has of them is in the checksum: samples that are eased, cells that are unbound, ground that is cut
//! away, and the chains that lie in it or end there. These depend on more than the tile's samples, so they are found anew, and compared.

use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;

use super::passes::{Job, Pass, same_samples};
use super::spool::Chunk;
use super::{Error, MakeSpool};
use crate::base::tiling::{TileGrid, TileId};

/// What was taken over.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize)]
pub struct TakenOver {
    /// Tiles of all passes.
    pub tiles: u64,
    /// Of these, how many were taken over.
    pub taken: u64,
}

/// One bit for each tile of a pass, set from any thread.
struct Bits(Vec<AtomicU64>);

impl Bits {
    fn new(tiles: usize) -> Bits {
        Bits((0..tiles.div_ceil(64)).map(|_| AtomicU64::new(0)).collect())
    }

    fn set(&self, tile: usize) {
        self.0[tile / 64].fetch_or(1 << (tile % 64), Ordering::Relaxed);
    }

    fn has(&self, tile: usize) -> bool {
        self.0[tile / 64].load(Ordering::Relaxed) >> (tile % 64) & 1 == 1
    }

    fn count(&self) -> u64 {
        self.0.iter().map(|word| u64::from(word.load(Ordering::Relaxed).count_ones())).sum()
    }
}

/// Takes over what holds of an earlier run of the same job on another state of the raster, or with other lines: copies those chunks.
/// The job's chains are found ([`Job::surveyed`]), where it has lines. `old` and `new` give
/// the spools of a pass.
///
/// Loads every tile of every pass, on the threads of the current rayon pool. Memory: a tile and a chunk for each busy thread, and
/// three bits for each tile of the raster.
///
/// # Errors
/// [`Error`].
pub fn take_over(job: &Job<'_>, old: &MakeSpool<'_>, new: &MakeSpool<'_>) -> Result<TakenOver, Error> {
    let mut sum = TakenOver::default();
    let mut before: Option<Bits> = None;
    for pass in job.passes() {
        let tiles = pass.grid().len();
        let (from, to) = (old(&pass)?, new(&pass)?);
        let same = Bits::new(tiles);
        let is_worth_a_look = |tile: usize| match &before {
            None => true,
            Some(taken) => pass.needed(tile).all(|needed| taken.has(needed)),
        };
        same_samples(job, &pass, &from, &is_worth_a_look, &|tile| same.set(tile))?;
        let taken = Bits::new(tiles);
        let copies = (0..tiles).into_par_iter().filter(|&tile| may_be_taken(&pass, &same, tile));
        copies.try_for_each_init(<(Chunk, Vec<u8>)>::default, |(chunk, encoded), tile| {
            job.control.cancel.check()?;
            from.read(tile, chunk, encoded)?;
            to.append(chunk, encoded)?;
            taken.set(tile);
            Ok::<(), Error>(())
        })?;
        to.sync()?;
        sum = TakenOver { tiles: sum.tiles + tiles as u64, taken: sum.taken + taken.count() };
        before = Some(taken);
    }
    Ok(sum)
}

/// Whether nothing that a tile depends on has changed, where `same` are those whose samples, and whose needed chunks, have not.
fn may_be_taken(pass: &Pass, same: &Bits, tile: usize) -> bool {
    match pass.needs() {
        Some(_) => same.has(tile),
        None => around(pass.grid(), tile).all(|neighbour| same.has(neighbour)),
    }
}

/// A tile and its neighbours, eight at the most.
fn around(grid: TileGrid, tile: usize) -> impl Iterator<Item = usize> {
    let TileId { column, row } = grid.tile(tile);
    let rows = row.saturating_sub(1)..(row + 2).min(grid.rows());
    let columns = column.saturating_sub(1)..(column + 2).min(grid.columns());
    rows.flat_map(move |row| columns.clone().map(move |column| grid.index(TileId { column, row })))
}
