//! Whether a solid is one: a surface, its like on the floor, upright walls between them, and no gap.

use std::path::Path;

use super::StlError;
use super::triangles::{HEADER_BYTES, TRIANGLE_BYTES};
use crate::base::external::{Scratch, ScratchError, Sorter};
use crate::formats::ReadError;

/// Bytes of the sort.
const SORT_BYTES: usize = 16 << 20;

type Corner = [f32; 3];

/// Takes all triangles of a solid, in the order of the file.
pub(super) struct Closed<'s> {
    path: &'s Path,
    /// Triangles of the surface.
    tops: u64,
    /// z of the floor, once it is known.
    floor: Option<f32>,
    /// The last triangle of the surface.
    top: [Corner; 3],
    taken: u64,
    /// Edges: the places of both ends, the lower one first, two numbers in a word; twice the triangle, and 1 more for an edge from the
    /// higher place to the lower one.
    edges: Sorter<'s, 4>,
}

impl<'s> Closed<'s> {
    /// Of a solid whose surface has this many triangles.
    pub(super) fn new(path: &'s Path, tops: u64, scratch: &'s Scratch) -> Closed<'s> {
        let edges = Sorter::new(scratch, SORT_BYTES);
        Closed { path, tops, floor: None, top: [[0.0; 3]; 3], taken: 0, edges }
    }

    /// The next triangle.
    pub(super) fn take(&mut self, corners: [Corner; 3]) -> Result<(), ReadError> {
        self.check_place(corners)?;
        self.push_edges(corners)?;
        self.taken += 1;
        Ok(())
    }

    fn check_place(&mut self, corners: [Corner; 3]) -> Result<(), StlError> {
        let is_wall = self.taken >= 2 * self.tops;
        if is_wall {
            let [a, b, c] = corners.map(|[x, y, _]| [x, y].map(f32::to_bits));
            let is_upright = a == b || b == c || c == a;
            return if is_upright {
                Ok(())
            } else {
                Err(self.misplaced("a wall, which is upright".to_string(), corners))
            };
        }
        if self.taken.is_multiple_of(2) {
            self.top = corners;
            return Ok(());
        }
        let floor = *self.floor.get_or_insert(corners[0][2]);
        let [a, b, c] = self.top.map(|[x, y, _]| [x, y, floor]);
        let bits = |corners: [Corner; 3]| corners.map(|corner| corner.map(f32::to_bits));
        if bits(corners) != bits([a, c, b]) {
            return Err(self.misplaced(format!("the triangle before it, turned over and at {floor}"), corners));
        }
        if self.top.iter().any(|[_, _, z]| *z <= floor || z.is_nan()) || !floor.is_finite() {
            return Err(self.misplaced("a floor below the surface".to_string(), corners));
        }
        Ok(())
    }

    fn misplaced(&self, expected: String, found: [Corner; 3]) -> StlError {
        let (path, triangle) = (self.path.to_path_buf(), self.taken);
        StlError::Misplaced { path, offset: offset(triangle), triangle, expected, found }
    }

    fn push_edges(&mut self, corners: [Corner; 3]) -> Result<(), ScratchError> {
        for side in 0..3 {
            let [from, to] = [corners[side], corners[(side + 1) % 3]].map(place);
            if from == to {
                continue;
            }
            let [a, b] = [from.min(to), from.max(to)];
            let word = |low: u32, high: u32| u64::from(low) | u64::from(high) << 32;
            let last = 2 * self.taken + u64::from(from > to);
            self.edges.push([word(a[0], a[1]), word(a[2], b[0]), word(b[1], b[2]), last])?;
        }
        Ok(())
    }

    /// All have come.
    pub(super) fn finish(self) -> Result<(), ReadError> {
        let mut group = None;
        for record in self.edges.finish()? {
            let edge = Edge::of(record?);
            let balance = if edge.is_upward { 1 } else { -1 };
            group = match group {
                Some((first, found)) if Edge::is_beside(&first, &edge) => {
                    let of_majority: Edge = if found == 0 { edge } else { first };
                    Some((of_majority, found + balance))
                }
                found => {
                    check(self.path, found)?;
                    Some((edge, balance))
                }
            };
        }
        Ok(check(self.path, group)?)
    }
}

/// An edge of a triangle.
#[derive(Debug, Clone, Copy)]
struct Edge {
    ends: [Corner; 2],
    is_upward: bool,
    triangle: u64,
}

impl Edge {
    fn of([p, q, r, last]: [u64; 4]) -> Edge {
        let number = |word: u64| f32::from_bits(word as u32);
        let ends = [[number(p), number(p >> 32), number(q)], [number(q >> 32), number(r), number(r >> 32)]];
        Edge { ends, is_upward: last.is_multiple_of(2), triangle: last / 2 }
    }

    fn is_beside(&self, other: &Edge) -> bool {
        self.ends.map(place) == other.ends.map(place)
    }
}

/// Edges between the same two places, by how many there are more from the lower one to the higher one.
fn check(path: &Path, group: Option<(Edge, i64)>) -> Result<(), StlError> {
    match group {
        None | Some((_, 0)) => Ok(()),
        Some((Edge { ends: [low, high], triangle, .. }, balance)) => {
            let [from, to] = if balance > 0 { [low, high] } else { [high, low] };
            let path = path.to_path_buf();
            Err(StlError::Open { path, offset: offset(triangle), triangle, from, to })
        }
    }
}

fn offset(triangle: u64) -> u64 {
    HEADER_BYTES + TRIANGLE_BYTES * triangle
}

/// The same for both zeros.
fn place(corner: Corner) -> [u32; 3] {
    corner.map(|number| (number + 0.0).to_bits())
}
