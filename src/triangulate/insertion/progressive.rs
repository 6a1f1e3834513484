//! Insertion in an order that whole rasters can agree on: the rim is not there from the start but comes vertex by vertex,
//! each when the errors inside have come down to its own.
//!
//! Every insertion has a [`Key`]. Within a tile keys ascend, and those of rim vertices are the same in both tiles that
//! share them, so all insertions of a raster have one order, and what comes before a cut is, in every tile, a beginning
//! of what the tile does by itself. That is how a budget for a whole raster is spent without tiles talking
//! (`simplify::goal`).

use super::refine::Refinement;
use crate::control::Cancelled;
use crate::mesh::Domain;

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

    /// A vertex of a side: its level, the tile that owns it, its place among those of the tile's sides.
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
    /// Its place among all.
    pub key: Key,
    /// What it did to the sum of squared errors over the samples that the tile owns; 0 where nobody asks.
    pub squares: f64,
}

/// What a tile's insertion in order is given beside its task.
#[derive(Debug, Clone, Copy)]
pub struct Order<'a> {
    /// A key for every vertex of the domain; [`Key::FIRST`] for the corners.
    pub keys: &'a [Key],
    /// The tile's number.
    pub tile: u64,
    /// The last key whose insertion is made. Where squared errors are wanted, what is there from the start is told first,
    /// with [`Key::FIRST`].
    pub cut: Key,
    /// The most insertions; events end there.
    pub most: u64,
    /// Whether squared errors are wanted; then whether the tile owns its last column and its last row.
    pub squares: Option<(bool, bool)>,
}

/// The domain with only those vertices on its loops that are there from the start.
pub(super) fn beginning(domain: &Domain, keys: &[Key]) -> Domain {
    let first = |l: &Vec<u32>| l.iter().copied().filter(|&v| keys[v as usize] == Key::FIRST).collect();
    Domain {
        vertices: domain.vertices.clone(),
        loops: domain.loops.iter().map(first).collect(),
        points: domain.points.clone(),
    }
}

impl Refinement<'_> {
    /// Inserts vertices of the rim and candidates in the order of their keys, up to the cut; `told` hears of each.
    pub(super) fn run_in_order(&mut self, order: Order<'_>, mut told: impl FnMut(Event)) -> Result<(), Cancelled> {
        if let Some(owns) = order.squares {
            let all = 0..self.surface.topology.len();
            let squares = all.map(|t| self.squares_of(t, owns)).sum();
            told(Event { key: Key::FIRST, squares });
        }
        let mut rim: Vec<(Key, u32)> = order.keys.iter().copied().zip(0..).filter(|(k, _)| *k != Key::FIRST).collect();
        rim.sort_unstable();
        let mut rim = rim.into_iter().peekable();
        let (mut envelope, mut inside, mut insertions, mut near) = (f64::INFINITY, 0, 0u64, 0);
        while insertions < order.most {
            if insertions.is_multiple_of(256) {
                self.cancel.check()?;
            }
            let best = self.candidates.best();
            let expected = best.map(|(_, c)| envelope.min(c.score));
            let on_rim = rim.next_if(|(k, _)| *k <= order.cut && expected.is_none_or(|e| k.error() >= e));
            let key = match (on_rim, best, expected) {
                (Some((key, vertex)), ..) => {
                    near = self.insert_on_rim(near, vertex);
                    key
                }
                (None, Some((t, candidate)), Some(error)) => {
                    let key = Key::of_interior(error, order.tile, inside);
                    if key > order.cut {
                        break;
                    }
                    near = self.insert(t, candidate.sample);
                    inside += 1;
                    key
                }
                _ => break,
            };
            envelope = envelope.min(key.error());
            insertions += 1;
            let squares = order.squares.map_or(0.0, |owns| self.squares_changed(near, owns));
            told(Event { key, squares });
        }
        Ok(())
    }

    /// Puts a vertex of the domain onto the locked edge it is on. A triangle at it.
    fn insert_on_rim(&mut self, near: u32, vertex: u32) -> u32 {
        let at = self.surface.at(vertex);
        let site = self.surface.locate(near, at);
        let connected = self.surface.connect(vertex, site);
        let t = connected.unwrap_or_else(|| panic!("a vertex of the rim at {at:?} is on its edge, found {site:?}"));
        self.update(t);
        t
    }

    /// The change of the sum of squares by what was done around the vertex at corner 2 of `t`.
    pub(super) fn squares_changed(&mut self, t: u32, owns: (bool, bool)) -> f64 {
        let mut star = std::mem::take(self.star);
        self.surface.topology.star(t, &mut star);
        let mut change = 0.0;
        for &t in &star {
            change += self.squares_of(t, owns);
        }
        *self.star = star;
        change
    }

    /// How much a triangle's sum of squares has grown since it was last asked for.
    pub(super) fn squares_of(&mut self, t: u32, owns: (bool, bool)) -> f64 {
        let now = super::squares::of_triangle(self.scanner.tile, self.surface.corners(t), owns);
        now - self.squares.replace(t, now)
    }
}
