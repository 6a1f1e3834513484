//! The rim of a surface: the edges that belong to one triangle only, and the walls below them.

use std::fs::File;

use super::Corner;
use crate::base::external::{Scratch, ScratchError, Sorter};

/// Triangles that are looked at together.
pub(super) const AT_ONCE: usize = 1 << 17;

/// Edges gathered before they are written.
const GATHERED: usize = 16 << 10;

/// Bytes of each of the two sorts.
const SORT_BYTES: usize = 16 << 20;

/// An edge of a triangle: its lower vertex; twice its higher one, and 1 more if it goes down from that; the places of its
/// start and its end, two numbers in a word.
type Edge = [u64; 5];

/// An edge with one of its ends: that vertex, the direction from there to the other end, and whether it ends there; then the
/// places.
type End = [u64; 6];

/// Edges that wait for their opposites; a power of two.
const WAITING: usize = 1 << 14;

/// The edges that came last, each at the place that its vertices tell: most opposites come soon.
struct Waiting(Vec<Option<[u64; 3]>>);

impl Waiting {
    /// Takes an edge, and its opposite out if that is here. What had its place is handed back.
    fn take(&mut self, edge: [u64; 3]) -> Option<[u64; 3]> {
        let [low, high, _] = edge;
        let mixed = (low ^ (high / 2).rotate_left(32)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let slot = &mut self.0[(mixed >> 40) as usize % WAITING];
        match slot.replace(edge) {
            Some(other) if (other[0], other[1] ^ 1) == (low, high) => {
                *slot = None;
                None
            }
            other => other,
        }
    }
}

/// Takes triangles, and keeps the edges that have no opposite among those that came with them.
#[derive(Debug, Default)]
pub(super) struct Rim {
    file: Option<File>,
    /// Records in the file.
    filed: u64,
    latest: Vec<Edge>,
}

/// One triangle of a wall, below the edge between two vertices: that at the vertical edge where the edge starts, or the other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Wall {
    pub(super) from: Corner,
    pub(super) to: Corner,
    pub(super) is_at_the_start: bool,
}

impl Rim {
    /// The next triangles, at most [`AT_ONCE`]; `corners` tells the places of each.
    pub(super) fn take<E: From<ScratchError>>(
        &mut self,
        triangles: &[[u64; 3]],
        corners: impl Fn(usize) -> Result<[Corner; 3], E>,
        scratch: &Scratch,
    ) -> Result<(), E> {
        // Lower vertex, higher vertex with the direction, number of the edge.
        let (mut edges, mut waiting) = (Vec::new(), Waiting(vec![None; WAITING]));
        for (i, triangle) in triangles.iter().enumerate() {
            for side in 0..3 {
                let (a, b) = (triangle[side], triangle[(side + 1) % 3]);
                if a != b {
                    edges.extend(waiting.take([a.min(b), 2 * a.max(b) + u64::from(a > b), (3 * i + side) as u64]));
                }
            }
        }
        edges.extend(waiting.0.into_iter().flatten());
        edges.sort_unstable();
        for group in edges.chunk_by(is_beside) {
            for &[low, high, number] in unmatched(group) {
                let (i, side) = (number as usize / 3, number as usize % 3);
                let places = corners(i)?;
                let [p, q, r] = packed(places[side], places[(side + 1) % 3]);
                self.push([low, high, p, q, r], scratch)?;
            }
        }
        Ok(())
    }

    fn push(&mut self, edge: Edge, scratch: &Scratch) -> Result<(), ScratchError> {
        self.latest.push(edge);
        if self.latest.len() < GATHERED {
            return Ok(());
        }
        if self.file.is_none() {
            self.file = Some(scratch.file()?);
        }
        scratch.write(self.file.as_ref().expect("made above"), &self.latest)?;
        self.filed += self.latest.len() as u64;
        self.latest.clear();
        Ok(())
    }

    /// The edges of the rim, once all triangles have come.
    pub(super) fn edges(self, scratch: &Scratch) -> Result<Edges<'_>, ScratchError> {
        let mut sorter = Sorter::<5>::new(scratch, SORT_BYTES);
        let mut piece = vec![[0; 5]; GATHERED];
        for first in (0..self.filed).step_by(GATHERED) {
            // Only full pieces are filed.
            scratch.read(self.file.as_ref().expect("records were filed"), first, &mut piece)?;
            piece.iter().try_for_each(|edge| sorter.push(*edge))?;
        }
        self.latest.iter().try_for_each(|edge| sorter.push(*edge))?;
        drop(piece);
        let mut edges = Edges { count: 0, ends: Sorter::new(scratch, SORT_BYTES) };
        let mut group: Vec<Edge> = Vec::new();
        for edge in sorter.finish()? {
            let edge = edge?;
            if group.last().is_some_and(|last| !is_beside(last, &edge)) {
                edges.take(&group)?;
                group.clear();
            }
            group.push(edge);
        }
        edges.take(&group)?;
        Ok(edges)
    }
}

/// The edges of a rim.
#[derive(Debug)]
pub(super) struct Edges<'s> {
    count: u64,
    ends: Sorter<'s, 6>,
}

impl Edges<'_> {
    /// How many there are.
    pub(super) fn count(&self) -> u64 {
        self.count
    }

    /// Edges between the same two vertices.
    fn take(&mut self, group: &[Edge]) -> Result<(), ScratchError> {
        for edge in unmatched(group) {
            let (low, high) = (edge[0], edge[1] / 2);
            let (start, end) = if edge[1] % 2 == 0 { (low, high) } else { (high, low) };
            let (from, to) = unpacked(edge);
            self.ends.push([start, direction(from, to), 0, edge[2], edge[3], edge[4]])?;
            self.ends.push([end, direction(to, from), 1, edge[2], edge[3], edge[4]])?;
            self.count += 1;
        }
        Ok(())
    }

    /// Hands on the walls, two triangles for each edge, vertex by vertex: after one that is at the start of its edge comes the
    /// one with which it shares the vertical edge below that vertex.
    ///
    /// Where the rim touches itself in a vertex, the vertical edge belongs to more than two triangles. Programs that match
    /// triangles as they come match those of one corner of the surface, and find no edge twice in one direction.
    pub(super) fn for_each_wall<E: From<ScratchError>>(
        self,
        mut visit: impl FnMut(Wall) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut group: Vec<End> = Vec::new();
        for end in self.ends.finish()? {
            let end = end?;
            if group.last().is_some_and(|last| last[0] != end[0]) {
                walls_at(&group).try_for_each(&mut visit)?;
                group.clear();
            }
            group.push(end);
        }
        walls_at(&group).try_for_each(&mut visit)
    }
}

/// The walls at one vertex, whose ends are in the order of their directions, counter-clockwise: the surface is on the left
/// of an edge that starts here, up to the next one that ends here.
fn walls_at(group: &[End]) -> impl Iterator<Item = Wall> {
    let wall = |end: &End| {
        let (from, to) = unpacked(end);
        Wall { from, to, is_at_the_start: end[2] == 0 }
    };
    let (starts, mut ends): (Vec<Wall>, Vec<Wall>) = group.iter().map(wall).partition(|wall| wall.is_at_the_start);
    if group.first().is_some_and(|first| first[2] == 1) {
        ends.rotate_left(1);
    }
    // There are as many ends as starts, as the rim of triangles consists of closed lines.
    starts.into_iter().zip(ends).flat_map(|(start, end)| [start, end])
}

fn is_beside<const N: usize>(a: &[u64; N], b: &[u64; N]) -> bool {
    (a[0], a[1] / 2) == (b[0], b[1] / 2)
}

/// Of sorted edges between the same two vertices, those for which there is none in the other direction.
fn unmatched<const N: usize>(group: &[[u64; N]]) -> &[[u64; N]] {
    let upward = group.partition_point(|edge| edge[1] % 2 == 0);
    let downward = group.len() - upward;
    if upward > downward { &group[downward..upward] } else { &group[2 * upward..] }
}

fn packed(from: Corner, to: Corner) -> [u64; 3] {
    let word = |a: f32, b: f32| u64::from(a.to_bits()) | u64::from(b.to_bits()) << 32;
    [word(from[0], from[1]), word(from[2], to[0]), word(to[1], to[2])]
}

/// The places of an edge, in the last three words of a record.
fn unpacked<const N: usize>(record: &[u64; N]) -> (Corner, Corner) {
    let number = |word: u64| f32::from_bits(word as u32);
    let [p, q, r] = [record[N - 3], record[N - 2], record[N - 1]];
    ([number(p), number(p >> 32), number(q)], [number(q >> 32), number(r), number(r >> 32)])
}

/// The direction from one place to another, as a number that grows counter-clockwise from east on.
fn direction(from: Corner, to: Corner) -> u64 {
    let [dx, dy] = [0, 1].map(|i| f64::from(to[i]) - f64::from(from[i]));
    let sum = dx.abs() + dy.abs();
    // Zero is never negative, so that numbers are in order as their bits are.
    let north = if sum > 0.0 { dy / sum + 0.0 } else { 0.0 };
    let quarters = match (dx < 0.0, dy < 0.0) {
        (true, _) => 2.0 - north,
        (false, true) => 4.0 + north,
        (false, false) => north,
    };
    quarters.to_bits()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_grow_counter_clockwise() {
        let around =
            [[1.0, 0.0], [1.0, 1.0], [0.0, 2.0], [-1.0, 1.0], [-3.0, 0.0], [-1.0, -1.0], [0.0, -1.0], [1.0, -1.0]];
        let numbers = around.map(|[x, y]| direction([0.5, 7.0, 1.0], [x + 0.5, y + 7.0, 2.0]));
        assert!(numbers.is_sorted_by(|a, b| a < b), "{numbers:?}");
        assert_eq!(direction([1.0; 3], [1.0; 3]), 0);
        assert_eq!(direction([-0.0; 3], [1.0, -0.0, 0.0]), 0);
    }

    #[test]
    fn edges_are_matched_as_often_as_they_have_opposites() {
        let edges = |ups: usize, downs: usize| [vec![[3u64, 8, 0]; ups], vec![[3, 9, 0]; downs]].concat();
        for (ups, downs) in [(0, 1), (1, 0), (1, 1), (3, 1), (1, 3), (2, 2)] {
            let group = edges(ups, downs);
            let left = unmatched(&group);
            assert_eq!(left, edges(ups.saturating_sub(downs), downs.saturating_sub(ups)));
        }
    }

    #[test]
    fn places_come_back() {
        let (from, to) = ([1.5, -2.25, 1e-30], [-0.0, f32::MAX, 7.0]);
        let [p, q, r] = packed(from, to);
        assert_eq!(unpacked(&[0, 0, p, q, r]), (from, to));
    }
}
