//! The strong test along one edge: against the grid's edges and diagonals.

use crate::base::Tile;
use crate::base::exact;
use crate::base::lattice::STEPS;
use crate::base::mesh::Vertex;

/// The three families of grid edges an edge can cross (section 2: six neighbours, the diagonals run from (x, y) to
/// (x+1, y+1) in columns and rows). A line of a family is where its coordinate is a multiple of a cell.
#[derive(Clone, Copy)]
enum Family {
    Vertical,
    Horizontal,
    Diagonal,
}

impl Family {
    /// (which line of the family, place along it) of a lattice point.
    fn coordinates(self, x: i32, y: i32) -> (i32, i32) {
        match self {
            Family::Vertical => (x, y),
            Family::Horizontal => (y, x),
            Family::Diagonal => (y - x, x),
        }
    }

    /// Column and row of a sample, given its line and its place along it, in cells.
    fn sample(self, line: i32, along: i32) -> (usize, usize) {
        let (column, row) = match self {
            Family::Vertical => (line, along),
            Family::Horizontal => (along, line),
            Family::Diagonal => (along, along + line),
        };
        (column as usize, row as usize)
    }
}

/// A crossing: |Σ terms| / scale is the distance between the edge and the grid surface there.
struct Crossing {
    terms: [(i64, f64); 4],
    scale: i64,
    /// Columns and rows of the two samples of the grid's edge.
    between: [(usize, usize); 2],
    /// Whether the third term is the edge's first end, and the fourth the second, or the other way round.
    near_is_p: bool,
}

impl Crossing {
    /// Between two samples counts what the more important one counts.
    fn weight(&self, tile: &Tile) -> f64 {
        let [p, q] = self.between;
        tile.weight(p.0, p.1).max(tile.weight(q.0, q.1))
    }

    /// Between two samples the smaller of their limits holds.
    fn limit(&self, tile: &Tile, tolerance: f64) -> f64 {
        if !tile.is_weighted() {
            return tolerance;
        }
        exact::limit(self.weight(tile), tolerance)
    }
}

/// Whether the straight line p–q stays within the tolerance of the grid surface, exactly; where the tile has weights,
/// within the smaller limit of the two samples it passes between. Crossings at samples are left to the weak test, which
/// reads them anyway.
pub(super) fn within(tile: &Tile, tolerance: f64, p: Vertex, q: Vertex) -> bool {
    crossings(tile, p, q, |c| exact::within(&c.terms, c.scale, c.limit(tile, tolerance)))
}

/// The largest distance between the line p–q and the grid surface between samples, rounded; times its weight, where the
/// tile has weights.
pub(super) fn deviation(tile: &Tile, p: Vertex, q: Vertex) -> f64 {
    let mut largest = 0.0f64;
    crossings(tile, p, q, |c| {
        let sum: f64 = c.terms.iter().map(|&(w, z)| w as f64 * z).sum();
        largest = largest.max(sum.abs() / c.scale as f64 * c.weight(tile));
        true
    });
    largest
}

/// The largest signed distances of the line p–q above and below the grid surface between samples, rounded, with the share
/// that p has in the line's height there; both times the weight.
pub(super) fn extremes(tile: &Tile, p: Vertex, q: Vertex) -> [(f64, f64); 2] {
    let mut extremes = [(0.0f64, 0.0f64); 2];
    crossings(tile, p, q, |c| {
        let weight = c.weight(tile);
        let sum: f64 = c.terms.iter().map(|&(w, z)| w as f64 * z).sum();
        let above = -sum / c.scale as f64 * weight;
        let [near, far] = [2, 3].map(|i| -c.terms[i].0 as f64 / c.scale as f64);
        let share = if c.near_is_p { near } else { far } * weight;
        if above > extremes[0].0 {
            extremes[0] = (above, share);
        } else if above < extremes[1].0 {
            extremes[1] = (above, share);
        }
        true
    });
    extremes
}

/// Visits the crossings until `visit` says no; returns whether it never did.
fn crossings(tile: &Tile, p: Vertex, q: Vertex, mut visit: impl FnMut(Crossing) -> bool) -> bool {
    for family in [Family::Vertical, Family::Horizontal, Family::Diagonal] {
        let ((line_p, along_p), (line_q, along_q)) =
            (family.coordinates(p.at.x, p.at.y), family.coordinates(q.at.x, q.at.y));
        // Walk from the lower line to the higher.
        let (from, to, near, far) = if line_p <= line_q {
            ((line_p, along_p), (line_q, along_q), p, q)
        } else {
            ((line_q, along_q), (line_p, along_p), q, p)
        };
        let span = i64::from(to.0 - from.0);
        let run = i64::from(to.1 - from.1);
        for line in from.0.div_euclid(STEPS) + 1..=(to.0 - 1).div_euclid(STEPS) {
            let done = i64::from(line * STEPS - from.0);
            let cell = span * i64::from(STEPS);
            let along = i64::from(from.1) * span + run * done;
            let (whole, part) = (along.div_euclid(cell), along.rem_euclid(cell));
            if part == 0 {
                continue;
            }
            let between = [whole, whole + 1].map(|i| family.sample(line, i as i32));
            // A half cell has no diagonal that its missing sample ends; beside a sample of a bridged hole nothing binds.
            let has_height = |&(column, row): &(usize, usize)| tile.validity.has_height(column as i32, row as i32);
            if !tile.validity.is_whole() && !between.iter().all(has_height) {
                continue;
            }
            let [before, after] = between.map(|(column, row)| tile.at(column, row));
            let steps = i64::from(STEPS);
            let crossing = Crossing {
                terms: [
                    (cell - part, before),
                    (part, after),
                    (-steps * (span - done), near.height),
                    (-steps * done, far.height),
                ],
                scale: cell,
                between,
                near_is_p: line_p <= line_q,
            };
            if !visit(crossing) {
                return false;
            }
        }
    }
    true
}
