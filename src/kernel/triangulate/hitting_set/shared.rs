//! Where squares meet: between them lies a line of cells without samples, and at their corners a cell that up to four of them
//! have a sample at. One vertex stands there for all.

use super::Corners;
use super::plane::Region;
use super::squares::{Square, vertex};
use crate::base::Tile;
use crate::base::mesh::Vertex;
use crate::kernel::quantum::Quantum;

/// Squares of a tile, and which of them holds a sample: of several the first. Samples in none are squares of their own.
struct Map<'a> {
    tile: &'a Tile,
    squares: &'a [Square],
    owners: Vec<u32>,
}

const NOBODY: u32 = u32::MAX;

impl<'a> Map<'a> {
    fn new(tile: &'a Tile, squares: &'a [Square]) -> Map<'a> {
        let mut owners = vec![NOBODY; tile.width() * tile.height()];
        for (number, square) in (0u32..).zip(squares) {
            let Region { first, last } = square.region();
            for row in first.1..=last.1 {
                let samples = &mut owners[row * tile.width() + first.0..=row * tile.width() + last.0];
                samples.iter_mut().filter(|owner| **owner == NOBODY).for_each(|owner| *owner = number);
            }
        }
        Map { tile, squares, owners }
    }

    /// The square's plane at a sample; none where the sample is missing.
    fn plane(&self, (column, row): (usize, usize)) -> Option<Slope> {
        if !self.tile.validity().has_height(column as i32, row as i32) {
            return None;
        }
        Some(match self.owners[row * self.tile.width() + column] {
            NOBODY => Slope::level((column, row), self.tile.at(column, row)),
            number => Slope::of(&self.squares[number as usize]),
        })
    }

    /// The cells at corners of squares, by squares, then by samples that are in none; most of them again and again.
    fn cells(&self) -> impl Iterator<Item = (usize, usize)> {
        let width = self.tile.width();
        let lone = (0..self.owners.len()).filter(|&i| self.owners[i] == NOBODY).map(move |i| (i % width, i / width));
        let of_squares = self.squares.iter().map(|square| (square.first, square.last));
        of_squares.chain(lone.map(|place| (place, place))).flat_map(|(first, last)| cells_around(first, last))
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
    fn level((column, row): (usize, usize), height: f64) -> Slope {
        Slope { middle: (column as f64, row as f64), height, slope: [0.0; 2] }
    }

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

/// A vertex for every cell at which corners of squares meet, inside the tile and on its ground: at that of the cell's
/// samples which is least far from all planes that meet there. With [`Corners::Free`] its height is half-way between
/// these, where that is within the sample's limit; else it is the sample's. Squares of one sample may be left out of
/// the list. Memory: 6 bytes a sample, and the vertices.
pub(super) fn corners(tile: &Tile, tolerance: f64, squares: &[Square], corners: Corners) -> Vec<Vertex> {
    let map = Map::new(tile, squares);
    let quantum = Quantum::of(tolerance).filter(|_| corners == Corners::Free);
    let (across, down) = (tile.width() - 1, tile.height() - 1);
    let is_whole = tile.validity().is_whole();
    let is_inside = |&(column, row): &(usize, usize)| {
        let inside = column > 0 && row > 0 && column < across && row < down;
        inside && (is_whole || tile.validity().is_ground(column as i32, row as i32))
    };
    let (mut met, mut taken) = (vec![false; across * down], vec![false; tile.width() * tile.height()]);
    let mut found = Vec::new();
    for cell in map.cells().filter(|&(column, row)| column < across && row < down) {
        if std::mem::replace(&mut met[cell.1 * across + cell.0], true) {
            continue;
        }
        let planes = corners_of(cell).map(|place| map.plane(place));
        let heights = |place: (usize, usize)| planes.iter().flatten().map(move |plane| plane.at(place));
        let gap = |place: (usize, usize)| {
            let height = tile.at(place.0, place.1);
            heights(place).map(|at| (at - height).abs()).fold(0.0, f64::max)
        };
        let places = corners_of(cell).into_iter().filter(is_inside).map(|place| (gap(place), place));
        let Some((_, place)) = places.reduce(|best, other| if other.0 < best.0 { other } else { best }) else {
            continue;
        };
        if std::mem::replace(&mut taken[place.1 * tile.width() + place.0], true) {
            continue;
        }
        let (least, most) =
            (heights(place).fold(f64::INFINITY, f64::min), heights(place).fold(f64::NEG_INFINITY, f64::max));
        let middle = quantum.and_then(|quantum| quantum.round((least + most) / 2.0));
        found.push(near_sample(tile, tolerance, place, middle));
    }
    found
}

/// The cells at a square's corners: beyond its first and last samples. Those beyond the tile have numbers that no cell has.
fn cells_around(first: (usize, usize), last: (usize, usize)) -> [(usize, usize); 4] {
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
