//! Cells near lines, where nothing limits how far the surface strays between samples.
//!
//! Edges of lines end between samples, and nothing may be put on them: triangles beside them may have to be long and thin. So a side of a
//! cell is bound only if neither of its two cells is within `reach` cells of one that a line runs in. Such a side is an
//! edge of every constrained Delaunay triangulation in which both its samples are vertices, as the circle over it holds no end of an
//! edge; so the limit can be kept there.

use super::Segment;
use crate::base::lattice::STEPS;
use crate::base::{Tile, Window};

/// Marks the cells of a tile that are no more than `reach` cells away, across or down, from a cell that a segment lies in. Segments are
/// sorted by rows.
pub(super) fn mark(tile: &mut Tile, window: Window, segments: &[Segment], reach: i64) {
    let steps = i64::from(STEPS);
    let (left, top) = (window.column as i64, window.row as i64);
    let (across, down) = (window.width as i64 - 1, window.height as i64 - 1);
    // A segment is no longer than a cell, and its first place is the upper one.
    let first = segments.partition_point(|[a, _]| a.y < (top - reach - 2) * steps);
    let near = segments[first..].iter().take_while(|[a, _]| a.y <= (top + down + reach + 1) * steps);
    let mut cells = Vec::new();
    for place in near.flatten() {
        // On a line between cells it is in those on both sides.
        let of = |along: i64, from: i64, count: i64| {
            let (low, high) = ((along + steps - 1).div_euclid(steps) - 1, along.div_euclid(steps));
            (low - reach - from).max(0)..(high + reach + 1 - from).min(count)
        };
        let columns = of(place.x, left, across);
        if columns.is_empty() {
            continue;
        }
        for row in of(place.y, top, down) {
            if cells.is_empty() {
                cells.resize((across * down) as usize, false);
            }
            let row = row * across;
            cells[(row + columns.start) as usize..(row + columns.end) as usize].fill(true);
        }
    }
    tile.unbound = cells;
}
