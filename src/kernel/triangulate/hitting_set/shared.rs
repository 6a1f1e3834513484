//! Where squares meet: between them lies a line of cells without samples, and at their corners a cell that up to four of them
//! have a sample at. One vertex stands there for all.

use super::Corners;
use super::plane::Region;
use super::squares::{Square, vertex};
use crate::base::Tile;
use crate::base::mesh::Vertex;
use crate::kernel::quantum::Quantum;

/// Which square holds a sample: of several the first.
struct Owners {
    width: usize,
    of: Vec<u32>,
}

const NOBODY: u32 = u32::MAX;

impl Owners {
    fn new(tile: &Tile, squares: &[Square]) -> Owners {
        let width = tile.width();
        let mut of = vec![NOBODY; width * tile.height()];
        for (number, square) in (0u32..).zip(squares) {
            let Region { first, last } = square.region();
            for row in first.1..=last.1 {
                let samples = &mut of[row * width + first.0..=row * width + last.0];
                samples.iter_mut().filter(|owner| **owner == NOBODY).for_each(|owner| *owner = number);
            }
        }
        Owners { width, of }
    }

    /// The squares of the four corners of a cell; some may be the same.
    fn around(&self, cell: (usize, usize)) -> [u32; 4] {
        corners_of(cell).map(|(column, row)| self.of[row * self.width + column])
    }
}

fn corners_of((column, row): (usize, usize)) -> [(usize, usize); 4] {
    [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(x, y)| (column + x, row + y))
}

/// A square's plane, or one through the middle of its corners.
#[derive(Clone, Copy)]
struct Slope {
    middle: (f64, f64),
    height: f64,
    slope: [f64; 2],
}

impl Slope {
    fn of(square: &Square) -> Slope {
        let Region { first, last } = square.region();
        let [a, b, c, d] = square.heights;
        // Along a side of one sample there is no rise.
        let twice = |from: usize, to: usize| (2 * (to - from)).max(1) as f64;
        Slope {
            middle: ((first.0 + last.0) as f64 / 2.0, (first.1 + last.1) as f64 / 2.0),
            height: (a + b + c + d) / 4.0,
            slope: [(b - a + c - d) / twice(first.0, last.0), (d - a + c - b) / twice(first.1, last.1)],
        }
    }

    fn at(&self, (column, row): (usize, usize)) -> f64 {
        let [across, down] = self.slope;
        self.height + across * (column as f64 - self.middle.0) + down * (row as f64 - self.middle.1)
    }
}

/// A vertex for every cell at which corners of squares meet, inside the tile and on its ground: at that of the cell's samples which is
/// least far from all planes that meet there. With [`Corners::Free`] its height is half-way between these, where that is within the
/// sample's limit; else it is the sample's.
pub(super) fn corners(tile: &Tile, tolerance: f64, squares: &[Square], corners: Corners) -> Vec<Vertex> {
    let owners = Owners::new(tile, squares);
    let slopes: Vec<Slope> = squares.iter().map(Slope::of).collect();
    let quantum = Quantum::of(tolerance).filter(|_| corners == Corners::Free);
    let (across, down) = (tile.width() - 1, tile.height() - 1);
    let is_whole = tile.validity().is_whole();
    let is_inside = |&(column, row): &(usize, usize)| {
        let inside = column > 0 && row > 0 && column < across && row < down;
        inside && (is_whole || tile.validity().is_ground(column as i32, row as i32))
    };
    let (mut met, mut taken) = (vec![false; across * down], vec![false; tile.width() * tile.height()]);
    let mut found = Vec::new();
    for square in squares {
        for cell in cells_around(square).into_iter().filter(|&(column, row)| column < across && row < down) {
            if std::mem::replace(&mut met[cell.1 * across + cell.0], true) {
                continue;
            }
            let around = owners.around(cell).map(|number| slopes[number as usize]);
            let heights = |place: (usize, usize)| around.map(|slope| slope.at(place));
            let gap = |place: (usize, usize)| {
                let height = tile.at(place.0, place.1);
                heights(place).iter().map(|at| (at - height).abs()).fold(0.0, f64::max)
            };
            let places = corners_of(cell).into_iter().filter(is_inside).map(|place| (gap(place), place));
            let Some((_, place)) = places.reduce(|best, other| if other.0 < best.0 { other } else { best }) else {
                continue;
            };
            if std::mem::replace(&mut taken[place.1 * tile.width() + place.0], true) {
                continue;
            }
            let at = heights(place);
            let middle = (at.iter().copied().fold(f64::INFINITY, f64::min)
                + at.iter().copied().fold(f64::NEG_INFINITY, f64::max))
                / 2.0;
            found.push(near_sample(tile, tolerance, place, quantum.and_then(|quantum| quantum.round(middle))));
        }
    }
    found
}

/// The cells at a square's corners: beyond its first and last samples. Those beyond the tile have numbers that no cell has.
fn cells_around(square: &Square) -> [(usize, usize); 4] {
    let Region { first, last } = square.region();
    let before = (first.0.wrapping_sub(1), first.1.wrapping_sub(1));
    [before, (last.0, before.1), last, (before.0, last.1)]
}

/// A vertex at a sample, of this height if that is within the sample's limit, exactly; else of the sample's own.
pub(super) fn near_sample(tile: &Tile, tolerance: f64, place: (usize, usize), height: Option<f64>) -> Vertex {
    let own = tile.at(place.0, place.1);
    let limit = tile.limit(place.0, place.1, tolerance);
    let within = |height: &f64| crate::base::exact::within(&[(1, *height), (-1, own)], 1, limit);
    vertex(place, height.filter(within).unwrap_or(own))
}
