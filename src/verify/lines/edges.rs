//! Edges of the mesh between places of lines, in the order of their first places.

use super::Spot;
use super::required::RequiredLines;
use super::words::word;
use crate::base::control::CancelToken;
use crate::base::external::{Scratch, Sorted, Sorter, StoreWriter};
use crate::formats::MeshReader;
use crate::verify::VerifyError;
use crate::verify::gather::MIX;
use crate::verify::grid::Grid;

/// Bytes of the sort; tests go to the file.
const EDGE_BYTES: usize = if cfg!(test) { 1 << 10 } else { 8 << 20 };

/// Bits of the filter for each place of a line, and the most of them, both as powers of two.
const FILTER: (u32, u32) = (4, if cfg!(test) { 9 } else { 27 });

/// Segments that are read at a time.
const SEGMENTS: usize = 1 << 16;

/// An edge of the mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Edge {
    /// Words, the smaller one first.
    pub(super) ends: [u64; 2],
    /// Of the two vertices.
    pub(super) heights: [f64; 2],
    /// Whether it is within the tolerance of the raster's surface, as far as it has been judged.
    pub(super) is_on_surface: bool,
}

/// An edge as words.
pub(super) type EdgeRecord = [u64; 4];

impl Edge {
    pub(super) fn record(&self) -> EdgeRecord {
        let ([a, b], [from, to]) = (self.ends, self.heights.map(f64::to_bits));
        [a, b, from, to]
    }

    pub(super) fn of_record([a, b, from, to]: EdgeRecord, is_on_surface: bool) -> Edge {
        Edge { ends: [a, b], heights: [from, to].map(f64::from_bits), is_on_surface }
    }
}

/// Tells most places that are of no line from those that are.
struct Filter {
    bits: Vec<u64>,
    /// How many, as a power of two.
    size: u32,
}

impl Filter {
    fn of(lines: &RequiredLines, rows: i64) -> Result<Filter, VerifyError> {
        let wanted = lines.segment_count().max(1).ilog2() + 1 + FILTER.0;
        let size = wanted.clamp(6, FILTER.1);
        let mut filter = Filter { bits: vec![0; 1 << (size - 6)], size };
        let mut row = 0;
        while row < rows {
            let strip = lines.strip(row..rows, SEGMENTS);
            row = strip.end;
            for spot in lines.segments(strip)?.flat_map(|(ends, _)| ends) {
                for bit in filter.of_place(word(spot)) {
                    filter.bits[(bit >> 6) as usize] |= 1 << (bit & 63);
                }
            }
        }
        Ok(filter)
    }

    /// The bits of a place.
    fn of_place(&self, place: u64) -> [u64; 2] {
        let first = (place ^ place >> 29).wrapping_mul(MIX);
        let second = (first ^ first >> 32).wrapping_mul(MIX);
        [first, second].map(|hash| hash >> (64 - self.size))
    }

    /// Whether a place may be of a line; if not, it is of none.
    fn may_have(&self, spot: Spot) -> bool {
        self.of_place(word(spot)).iter().all(|bit| self.bits[(bit >> 6) as usize] >> (bit & 63) & 1 == 1)
    }
}

/// Stands for the place of a vertex that is on no line.
const NOWHERE: u64 = u64::MAX;

/// All edges between places of lines, and some others, each as often as faces have it, in order. Where vertices share a place each edge has
/// the heights of its own. Vertices pass by `see` beside that, with their places on the lattice.
///
/// Memory: 32 MiB, of which a half is a filter.
pub(super) fn edges_beside<'s>(
    mesh: &mut dyn MeshReader,
    (grid, lines): (&Grid, &RequiredLines),
    mut see: impl FnMut(u64, [f64; 3], Spot),
    scratch: &'s Scratch,
    cancel: &CancelToken,
) -> Result<Sorted<'s, 4>, VerifyError> {
    let filter = Filter::of(lines, grid.height)?;
    let mut vertices = StoreWriter::<2>::new(scratch)?;
    mesh.for_each_vertex(|vertex, [x, y, z]| {
        cancel.check()?;
        let place = grid.lattice(x, y).filter(|spot| grid.contains(*spot));
        place.iter().for_each(|spot| see(vertex, [x, y, z], *spot));
        let height = grid.frame.height(z);
        let place = place.filter(|spot| height.is_finite() && filter.may_have(*spot)).map_or(NOWHERE, word);
        Ok::<(), VerifyError>(vertices.push([place, height.to_bits()])?)
    })?;
    drop(filter);
    let mut vertices = vertices.finish()?;
    let mut edges = Sorter::new(scratch, EDGE_BYTES);
    mesh.for_each_face(|_, corners| {
        cancel.check()?;
        let mut ends = [[0; 2]; 3];
        for (end, corner) in ends.iter_mut().zip(corners) {
            *end = vertices.get(corner)?;
        }
        for (a, b) in [(0, 1), (1, 2), (2, 0)] {
            let (low, high) = if ends[a][0] <= ends[b][0] { (ends[a], ends[b]) } else { (ends[b], ends[a]) };
            if high[0] != NOWHERE && low[0] != high[0] {
                edges.push([low[0], high[0], low[1], high[1]])?;
            }
        }
        Ok::<(), VerifyError>(())
    })?;
    Ok(edges.finish()?)
}
