//! Edges: matched, overused, folded.

use super::VerifyError;
use super::boundary::{BoundaryEdge, EDGE_WORDS};
use super::finding::{EdgePlace, Finding};
use super::gather::{Counted, Gather, Key, MIX};
use super::grid::Grid;
use super::pace::Pace;
use super::rim;
use super::vertices::VertexStore;
use crate::base::external::{Scratch, Sorted, Sorter};

/// Bytes of the sort of edges that may be on the ground's boundary.
const BOUNDARY_BYTES: usize = 4 << 20;

/// How the faces hang together.
#[derive(Debug, Default)]
pub(super) struct EdgeFindings {
    pub(super) unmatched: Finding<EdgePlace>,
    pub(super) overused: Finding<EdgePlace>,
    pub(super) same_direction: Finding<EdgePlace>,
}

/// How faces run along an edge: `[low vertex, high vertex · 16 + 4 · faces that run from high to low + others]`, where 3 faces
/// are three or more.
#[derive(Debug)]
pub(super) struct EdgeKey;

impl EdgeKey {
    /// Of a face that runs along the edge.
    pub(super) fn record(from: u64, to: u64) -> Counted {
        [from.min(to), from.max(to) << 4 | if from > to { 4 } else { 1 }]
    }
}

impl Key for EdgeKey {
    fn is_same(a: Counted, b: Counted) -> bool {
        (a[0], a[1] >> 4) == (b[0], b[1] >> 4)
    }

    fn join(a: Counted, b: Counted) -> Counted {
        let sum = |shift: u32| ((a[1] >> shift & 3) + (b[1] >> shift & 3)).min(3) << shift;
        [a[0], a[1] & !15 | sum(2) | sum(0)]
    }

    fn hash([low, high]: Counted) -> u64 {
        (low.wrapping_mul(MIX) ^ high >> 4).wrapping_mul(MIX)
    }
}

/// For the edges of all faces. Memory: 0.5 MiB of slots, and a sort of 8.
pub(super) fn edge_sort(scratch: &Scratch) -> Gather<'_, EdgeKey> {
    Gather::new(scratch, 1 << 15, 8 << 20)
}

/// Matches the edges of all faces: two faces share an edge in opposite directions, or it may lie on the ground's
/// boundary, or where the ground is trimmed, which is found out when the rows of the raster pass. Gives the latter by rows.
///
/// A T-junction shows as unmatched edges: the long one on one side, the short ones on the other.
pub(super) fn match_edges<'s>(
    edges: Gather<'_, EdgeKey>,
    vertices: &mut VertexStore<'_>,
    grid: &Grid,
    trims: bool,
    scratch: &'s Scratch,
    pace: &mut Pace<'_>,
) -> Result<(EdgeFindings, Sorted<'s, EDGE_WORDS>), VerifyError> {
    let mut found = EdgeFindings::default();
    let mut boundary = Sorter::new(scratch, BOUNDARY_BYTES);
    let (mut edges, joined) = edges.finish()?;
    pace.pass(joined)?;
    while let Some(([low, high], records)) = edges.next()? {
        pace.pass(records)?;
        let (high, uses) = (high >> 4, [high & 3, high >> 2 & 3]);
        if uses == [1, 1] {
            continue;
        }
        let (a, b) = ((low, vertices.get(low)?), (high, vertices.get(high)?));
        let place = || grid.edge(a, b);
        match uses[0] + uses[1] {
            1 => {
                // A face that is counter-clockwise on the map lies to the positive side of its edges in (column, row),
                // or, where the map mirrors, of the way back.
                let low_to_high = (uses == [1, 0]) == (grid.map_turn() > 0);
                let (from, to) = if low_to_high { (a, b) } else { (b, a) };
                let record = match trims {
                    true => rim::record(grid, from, to),
                    false => BoundaryEdge::new(grid, from, to).map(|edge| edge.words(false)),
                };
                match record {
                    Some(words) => boundary.push(words)?,
                    None => found.unmatched.add(place),
                }
            }
            2 => found.same_direction.add(place),
            _ => found.overused.add(place),
        }
    }
    Ok((found, boundary.finish()?))
}
