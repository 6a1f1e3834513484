//! What lies inside of polygons whose outlines are the mesh's border, on the lattice.
//!
//! Between two neighbouring rows of lattice places no segment begins, ends or crosses another. So there the inside is a row of trapezoids,
//! from a segment of the border to the next one. A place is inside where it is in any polygon, and in one where the way to it crosses
//! the polygon's outlines an odd number of times.

use super::lakes::{PARTS, across, odd};
use super::{Place, Segment};
use crate::base::lattice::{Point, STEPS};
use crate::base::{SampleCut, Tile, Window};

const CELL: i64 = STEPS as i64;

/// A part of the inside between two rows of lattice places.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Trapezoid {
    /// The upper row.
    row: i64,
    left: Segment,
    right: Segment,
}

/// The inside of all polygons over a raster. Memory: 80 bytes for each row of places that a segment of the border passes, 16 for each
/// cell.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Inside {
    /// By rows, then from the left to the right.
    trapezoids: Vec<Trapezoid>,
    /// The closed cells that segments of the border lie in, by row and column, each once.
    crossed: Vec<(i64, i64)>,
    /// The raster's samples.
    size: (usize, usize),
}

/// What of a window is inside.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Extent {
    All,
    Nothing,
    Some,
}

impl Inside {
    /// The share of the raster that is inside, to a few roundings.
    pub(super) fn share(&self) -> f64 {
        // In strips a step high.
        let width = |t: &Trapezoid| across(t.right, t.row, 1) - across(t.left, t.row, 1);
        let steps = self.trapezoids.iter().map(|t| width(t) as f64).sum::<f64>() / PARTS as f64;
        let cells = (self.size.0 - 1) as f64 * (self.size.1 - 1) as f64;
        steps / (CELL * CELL) as f64 / cells
    }

    /// Of polygons' outlines, which are closed, over a raster of this many samples: noded segments, each with the number of its polygon and how often it is run
    /// over. Gives also the segments of the border, in their order. The raster's own rim is none.
    pub(super) fn new(
        outlines: impl Iterator<Item = (Segment, u32, u32)>,
        size: (usize, usize),
    ) -> (Inside, Vec<Segment>) {
        let odd = odd(outlines);
        let mut crossings: Vec<(i64, i64, Segment, u32)> = Vec::new();
        for &(segment, polygon) in &odd {
            let rows = segment[0].y..segment[1].y;
            crossings.extend(rows.map(|row| (row, across(segment, row, 1), segment, polygon)));
        }
        crossings.sort_unstable();
        let mut inside = Inside { trapezoids: Vec::new(), crossed: Vec::new(), size };
        let (mut open, mut left, mut at_row) = (Vec::new(), None, i64::MIN);
        for group in crossings.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            let (row, _, segment, _) = group[0];
            if row != at_row {
                // Nothing is left of outlines that are closed.
                (at_row, left) = (row, None);
                open.clear();
            }
            let was_inside = !open.is_empty();
            for &(_, _, _, polygon) in group {
                match open.iter().position(|of| *of == polygon) {
                    Some(i) => _ = open.swap_remove(i),
                    None => open.push(polygon),
                }
            }
            match (was_inside, open.is_empty()) {
                (false, false) => left = Some(segment),
                (true, true) => {
                    inside.trapezoids.extend(left.take().map(|left| Trapezoid { row, left, right: segment }));
                }
                _ => {}
            }
        }
        let mut border: Vec<Segment> = odd.into_iter().map(|(segment, _)| segment).collect();
        border.dedup();
        border.retain(|&segment| inside.side(segment).is_some() && !inside.is_on_rim(segment));
        inside.crossed = border.iter().flat_map(|&segment| cells_of(segment)).map(|(c, r)| (r, c)).collect();
        inside.crossed.sort_unstable();
        inside.crossed.dedup();
        (inside, border)
    }

    /// Whether nothing is inside.
    pub(super) fn is_empty(&self) -> bool {
        self.trapezoids.is_empty()
    }

    pub(super) fn bytes(&self) -> u64 {
        (size_of_val(self.trapezoids.as_slice()) + size_of_val(self.crossed.as_slice())) as u64
    }

    fn is_on_rim(&self, [a, b]: Segment) -> bool {
        let last = |samples: usize| (samples as i64 - 1) * CELL;
        a.x == b.x && (a.x == 0 || a.x == last(self.size.0)) || a.y == b.y && (a.y == 0 || a.y == last(self.size.1))
    }

    /// The parts between a row of places and the next.
    fn row(&self, row: i64) -> &[Trapezoid] {
        let from = self.trapezoids.partition_point(|t| t.row < row);
        let count = self.trapezoids[from..].partition_point(|t| t.row == row);
        &self.trapezoids[from..from + count]
    }

    /// Whether it is inside to the left and to the right of a place between two rows (`half` is 1), or below a row (0), in parts of a
    /// step. On a row nothing begins or ends there.
    fn beside(&self, row: i64, half: i64, x: i64) -> [bool; 2] {
        let parts = self.row(row);
        let [before, from] = [
            parts.partition_point(|t| across(t.left, row, half) < x),
            parts.partition_point(|t| across(t.left, row, half) <= x),
        ];
        let ends_after = |count: usize, is_after: &dyn Fn(i64) -> bool| {
            count.checked_sub(1).is_some_and(|i| is_after(across(parts[i].right, row, half)))
        };
        [ends_after(before, &|right| right >= x), ends_after(from, &|right| right > x)]
    }

    /// Whether it is inside on either side of a segment, none of which lies on the border unless all does: to the left and to the
    /// right, or above and below where it is level.
    pub(super) fn sides(&self, [a, b]: Segment) -> [bool; 2] {
        if a.y < b.y {
            let row = a.y;
            return self.beside(row, 1, across([a, b], row, 1));
        }
        let middle = PARTS / 2 * (a.x + b.x);
        [self.above(a.y, middle), self.beside(a.y, 0, middle)[1]]
    }

    /// Whether it is inside just above a place on a row, at which nothing begins or ends.
    fn above(&self, line: i64, x: i64) -> bool {
        let parts = self.row(line - 1);
        let before = parts.partition_point(|t| across(t.left, line, 0) <= x);
        before.checked_sub(1).is_some_and(|i| across(parts[i].right, line, 0) > x)
    }

    /// The side of a segment that is inside where one alone is: 0 to the left or above, 1 to the right or below.
    pub(super) fn side(&self, segment: Segment) -> Option<usize> {
        match self.sides(segment) {
            [true, false] => Some(0),
            [false, true] => Some(1),
            _ => None,
        }
    }

    /// Whether it is inside to the left of an edge along a row, a column or a diagonal of cells ([`orient`] > 0), whose midst is nowhere on
    /// the border unless all of it is.
    ///
    /// [`orient`]: crate::base::lattice::orient
    pub(crate) fn is_left_of(&self, window: Window, [p, q]: [Point; 2]) -> bool {
        let global = |at: Point| Place {
            y: i64::from(at.y) + window.row as i64 * CELL,
            x: i64::from(at.x) + window.column as i64 * CELL,
        };
        let [p, q] = [p, q].map(global);
        if p.y == q.y {
            let middle = PARTS / 2 * (p.x + q.x);
            return if p.x < q.x { self.beside(p.y, 0, middle)[1] } else { self.above(p.y, middle) };
        }
        // At half of the first row down from the upper end.
        let [upper, lower] = if p.y < q.y { [p, q] } else { [q, p] };
        let x = PARTS * upper.x + PARTS / 2 * (lower.x - upper.x).signum();
        let [left, right] = self.beside(upper.y, 1, x);
        if p.y < q.y { left } else { right }
    }

    fn extent(&self, window: Window) -> Extent {
        // What opens cells next to the window is next to those.
        let columns = window.column as i64 - 2..(window.column + window.width) as i64 + 1;
        for row in window.row as i64 - 2..(window.row + window.height) as i64 + 1 {
            let from = self.crossed.partition_point(|cell| *cell < (row, columns.start));
            if self.crossed.get(from).is_some_and(|&(r, column)| r == row && column < columns.end) {
                return Extent::Some;
            }
        }
        // All cells are as one is.
        let row = window.row as i64 * CELL;
        match self.beside(row, 1, PARTS * (window.column as i64 * CELL) + PARTS / 2)[1] {
            true => Extent::All,
            false => Extent::Nothing,
        }
    }

    /// Takes from the ground of a tile the cells that are not next to the inside, and half cells that the border comes into. Tells it
    /// which quadrants of samples are inside.
    pub(super) fn cut(&self, tile: &mut Tile, window: Window) {
        let extent = self.extent(window);
        if extent == Extent::All {
            return;
        }
        let (width, height) = (window.width as i64, window.height as i64);
        let mut cut = vec![SampleCut::FAR; (window.width + 2) * (window.height + 2)];
        let index = |column: i64, row: i64| ((row + 1) * (width + 2) + column + 1) as usize;
        if extent == Extent::Nothing {
            return tile.cut(cut);
        }
        let (first_column, first_row) = (window.column as i64, window.row as i64);
        for row in -2..=height {
            for quarter in 0..CELL {
                let strip = (first_row + row) * CELL + quarter;
                for part in self.row(strip) {
                    let reach = |segment: Segment| {
                        let [from, to] = [0, 2].map(|half| across(segment, strip, half));
                        (from.min(to), from.max(to))
                    };
                    let cell = PARTS * CELL;
                    let from = reach(part.left).0.div_euclid(cell) - first_column;
                    let to = (reach(part.right).1 - 1).div_euclid(cell) - first_column;
                    // It, and the cells around.
                    for near in (row - 1).max(-1)..=(row + 1).min(height) {
                        for column in (from - 1).max(-1)..=(to + 1).min(width) {
                            cut[index(column, near)].open();
                        }
                    }
                }
            }
        }
        for row in -1..=height {
            let line = (first_row + row) * CELL;
            let crossed = self.crossed.partition_point(|cell| *cell < (first_row + row, first_column - 1));
            let of_row = self.crossed[crossed..].iter().take_while(|(r, _)| *r == first_row + row);
            for &(_, column) in of_row.take_while(|(_, column)| *column <= first_column + width) {
                cut[index(column - first_column, row)].cross();
            }
            // Above the line, then below it; quadrants are counted around from the lower right.
            for (strip, half, [right, left]) in [(line - 1, 2, [3, 2]), (line, 0, [0, 1])] {
                for part in self.row(strip) {
                    let at = |segment: Segment, half: i64| across(segment, strip, half);
                    let (from, to) = (at(part.left, half), at(part.right, half));
                    let cell = PARTS * CELL;
                    let first = (from + cell - 1).div_euclid(cell).max(first_column - 1);
                    let last = to.div_euclid(cell).min(first_column + width);
                    for column in first..=last {
                        let x = column * cell;
                        let sample = &mut cut[index(column - first_column, row)];
                        if to > x || at(part.right, 2 - half) > x {
                            sample.add(right);
                        }
                        if from < x || at(part.left, 2 - half) < x {
                            sample.add(left);
                        }
                    }
                }
            }
        }
        tile.cut(cut);
    }
}

/// The closed cells that a segment lies in, by column and row.
pub(super) fn cells_of([a, b]: Segment) -> impl Iterator<Item = (i64, i64)> {
    let range = |low: i64, high: i64| (high - 1).div_euclid(CELL)..=low.div_euclid(CELL);
    let columns = range(a.x.min(b.x), a.x.max(b.x));
    range(a.y, b.y).flat_map(move |row| columns.clone().map(move |column| (column, row)))
}
