//! Engines that refine in an order that a whole raster can agree on, so that they can end at a budget.
//!
//! Every insertion has a [`Key`]. Within a tile keys ascend, and those of rim vertices are the same in both tiles that
//! share them, so all insertions of a raster have one order, and what comes before a cut is, in every tile, a beginning
//! of what the tile does by itself. That is how a budget for a whole raster is spent without tiles talking (`job::goal`).

use super::{Engine, EngineScratch, Task};
use crate::base::control::Cancelled;
use crate::base::mesh::TileMesh;

/// An engine that inserts vertex after vertex, each where the error is largest, and can end anywhere.
pub trait Progressive: Engine {
    /// Triangulates as far as a cut in the order of all insertions of a raster, see [`Order`]: the vertices of the rim
    /// whose keys lie before it are inserted each in its turn, and `told` hears of every insertion, of what is there from
    /// the start first. The tolerance is one that all may come down to, not one that all do.
    ///
    /// # Errors
    /// [`Cancelled`], with a mesh of no use.
    fn triangulate_in_order(
        &self,
        task: &Task<'_>,
        order: Order<'_>,
        scratch: &mut EngineScratch,
        mesh: &mut TileMesh,
        told: &mut dyn FnMut(Event),
    ) -> Result<(), Cancelled>;
}

/// The place of an insertion among all of a raster: falling error; at equal errors rims before interiors, then by tile,
/// then by ordinal.
///
/// The error is the least so far (the envelope): a tile's errors may go up again, its keys do not go back.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Key {
    /// All bits of the error turned over: errors are not negative, so their bits ascend as they do.
    rank: u64,
    interior: bool,
    tile: u64,
    ordinal: u64,
}

impl Key {
    /// Before all others: what is there from the start.
    pub const FIRST: Key = Key { rank: 0, interior: false, tile: 0, ordinal: 0 };

    /// A vertex of a rim: its level, the tile that owns it, its place among those of the tile's rim.
    pub fn of_rim(level: f64, tile: u64, ordinal: u64) -> Key {
        Key { rank: !level.to_bits(), interior: false, tile, ordinal }
    }

    /// An insertion inside a tile, the `ordinal`th.
    pub fn of_interior(envelope: f64, tile: u64, ordinal: u64) -> Key {
        Key { rank: !envelope.to_bits(), interior: true, tile, ordinal }
    }

    /// The last of all with errors of at least this much.
    pub fn last_of(error: f64) -> Key {
        Key::last_of_rank(!error.to_bits())
    }

    /// The last of all with this rank: the bits of an error, turned over.
    pub fn last_of_rank(rank: u64) -> Key {
        Key { rank, interior: true, tile: u64::MAX, ordinal: u64::MAX }
    }

    /// The bits of the error, turned over: ranks ascend as errors fall.
    pub fn rank(&self) -> u64 {
        self.rank
    }

    /// The key as four numbers, for files.
    pub fn words(&self) -> [u64; 4] {
        [self.rank, u64::from(self.interior), self.tile, self.ordinal]
    }

    /// The key that [`Key::words`] made these of.
    pub fn from_words([rank, interior, tile, ordinal]: [u64; 4]) -> Key {
        Key { rank, interior: interior != 0, tile, ordinal }
    }

    /// The error.
    pub fn error(&self) -> f64 {
        f64::from_bits(!self.rank)
    }

    /// Whether it is of a vertex inside a tile.
    pub fn is_interior(&self) -> bool {
        self.interior
    }
}

/// One insertion of a tile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Event {
    /// Its place among all; [`Key::FIRST`] for all that is there from the start.
    pub key: Key,
    /// The triangles that it added to the tile.
    pub triangles: u64,
    /// What it did to the sum of squared errors over the tile's share of samples; 0 where nobody asks.
    pub squares: f64,
}

/// What a tile's insertion in order is given beside its task.
#[derive(Debug, Clone, Copy)]
pub struct Order<'a> {
    /// The vertices of the domain's loops that are not there from the start, by their keys.
    pub rim: &'a [(Key, u32)],
    /// The tile's number.
    pub tile: u64,
    /// The last key whose insertion is made.
    pub cut: Key,
    /// The most insertions; events end there.
    pub most: u64,
    /// Where squared errors are wanted: of which samples.
    pub squares: Option<Share<'a>>,
}

/// Which samples of a tile count, so that over all tiles each does once.
#[derive(Debug, Clone, Copy)]
pub enum Share<'a> {
    /// All but those in the last column and row, unless the tile has them.
    Rectangle {
        /// Whether it has the last column.
        last_column: bool,
        /// Whether it has the last row.
        last_row: bool,
    },
    /// These, row by row, of a tile where samples are missing: all on the ground but some on its sides.
    Ground(&'a [bool]),
}

impl Share<'_> {
    /// All of a tile without gaps.
    pub const ALL: Share<'static> = Share::Rectangle { last_column: true, last_row: true };
}
