//! What of the lines lies on the ground, and the pieces between places that must be ends of edges.

use super::inside::cells_of;
use super::{Breaklines, Place, Segment, SetBits};
use crate::base::lattice::STEPS;
use crate::base::tiling::TileGrid;
use crate::base::{Cell, PointSet, Tile, Window};

const CELL: i64 = STEPS as i64;

/// What surrounds a segment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Surroundings {
    /// Whether it lies in a cell with four heights.
    pub is_ground: bool,
    /// Whether a cell at either end is not whole, of those that the raster has.
    pub ends_at_void: [bool; 2],
}

/// What surrounds each of these segments of `lines`, which a tile of a raster of `size` samples has, rim included.
pub fn surroundings(
    lines: &Breaklines,
    tile: &Tile,
    window: Window,
    size: (usize, usize),
    segments: &[Segment],
) -> Vec<Surroundings> {
    let cell = |(column, row): (i64, i64)| match is_in(size, (column, row)) {
        true => tile.validity().cell((column - window.column as i64) as i32, (row - window.row as i64) as i32),
        false => Cell::Empty,
    };
    let is_at_void = |p: Place| cells_of([p, p]).any(|place| is_in(size, place) && cell(place) != Cell::Whole);
    let of = |&segment: &Segment| Surroundings {
        is_ground: lines.cells_beside(segment).any(|place| cell(place) == Cell::Whole),
        ends_at_void: segment.map(is_at_void),
    };
    segments.iter().map(of).collect()
}

/// Whether a raster has a cell.
fn is_in((width, height): (usize, usize), (column, row): (i64, i64)) -> bool {
    column >= 0 && row >= 0 && column < width as i64 - 1 && row < height as i64 - 1
}

impl Breaklines {
    /// The closed cells that a segment lies in, by column and row, as far as ground in them is inside beside the segment.
    pub fn cells_beside(&self, segment: Segment) -> impl Iterator<Item = (i64, i64)> {
        let sides = self.inside.as_ref().map_or([true; 2], |inside| inside.sides(segment));
        // Two cells share a segment along a side: the first is to the left, or above.
        let [a, b] = segment;
        let is_between = |along: i64| along.rem_euclid(CELL) == 0;
        let is_shared = a.x == b.x && is_between(a.x) || a.y == b.y && is_between(a.y);
        let is_inside = move |i: usize| if is_shared { sides[i] } else { sides[0] || sides[1] };
        cells_of(segment).enumerate().filter(move |(i, _)| is_inside(*i)).map(|(_, cell)| cell)
    }
}

/// Pieces of lines between two places that are ends of edges, by the tile that they lie in.
#[derive(Debug, Default)]
pub struct Pieces {
    /// In the order of tiles, then of the first two places.
    pieces: Vec<Stretch>,
}

/// A piece between two places that are ends of edges.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Stretch {
    /// The number of its tile.
    pub(super) tile: usize,
    pub(super) places: Vec<Place>,
    /// The sets of lines that it is of.
    pub(super) sets: SetBits,
}

impl Pieces {
    /// The pieces of these segments of `lines`, which are given in their order. Ends of edges are: where a line ends or several meet or
    /// begin to share a stretch, `further` places (in their order), `points`, and where a line comes to a line of the grid or leaves it; on a line of the
    /// grid also its corners; and the first place of a ring that has no other end. So what lies in a tile is decided by the segments
    /// in it and those that touch it.
    pub fn new(
        lines: &Breaklines,
        segments: &[Segment],
        further: &[Place],
        points: Option<&PointSet>,
        grid: &TileGrid,
        size: (usize, usize),
    ) -> Pieces {
        let graph = Graph::new(segments);
        let sets = |p: Place, q: Place| lines.sets_of([p.min(q), p.max(q)]);
        let is_meeting = |p: Place| match graph.beside(p) {
            &[(_, q), (_, r)] => sets(p, q) != sets(p, r),
            _ => true,
        };
        let is_point = |p: Place| {
            let on_sample = p.x % CELL == 0 && p.y % CELL == 0;
            on_sample && points.is_some_and(|all| all.has(((p.x / CELL) as usize, (p.y / CELL) as usize)))
        };
        let is_line = |along: i64, last: usize, start: &dyn Fn(usize) -> usize| {
            let sample = (along / CELL) as usize;
            along % CELL == 0 && (sample == last || start(sample) == sample)
        };
        let is_at_line = |p: Place| {
            let column = is_line(p.x, size.0 - 1, &|c| grid.window(grid.owner(c, 0)).column);
            let row = is_line(p.y, size.1 - 1, &|r| grid.window(grid.owner(0, r)).row);
            let beside = graph.beside(p);
            let leaves_column = column && beside.iter().any(|(_, q)| q.x != p.x);
            let leaves_row = row && beside.iter().any(|(_, q)| q.y != p.y);
            column && row || leaves_column || leaves_row
        };
        let is_end = |p: Place| is_meeting(p) || further.binary_search(&p).is_ok() || is_point(p) || is_at_line(p);
        let mut pieces = Vec::new();
        let mut add = |way: &[Place]| {
            let tile = tile_of([way[0], way[1]], grid, size);
            pieces.push(Stretch { tile, places: way.to_vec(), sets: sets(way[0], way[1]) });
        };
        graph.walk(is_end, |way| {
            let count = way.len() - 1;
            if way[0] != way[count] {
                return add(way);
            }
            // Three edges at least go around.
            for (from, to) in [(0, count / 3), (count / 3, 2 * count / 3), (2 * count / 3, count)] {
                add(&way[from..=to]);
            }
        });
        pieces.sort_unstable();
        Pieces { pieces }
    }

    /// By tiles: the number of each that has pieces, and its pieces.
    pub fn by_tile(&self) -> impl Iterator<Item = (usize, &[Stretch])> {
        self.pieces.chunk_by(|a, b| a.tile == b.tile).map(|pieces| (pieces[0].tile, pieces))
    }
}

/// The tile that a segment lies in, whichever end comes first; on a line between two, the lower or the one to the right.
pub fn tile_of([a, b]: Segment, grid: &TileGrid, (width, height): (usize, usize)) -> usize {
    let cell = |low: i64, last: usize| (low.div_euclid(CELL) as usize).min(last);
    grid.index(grid.owner(cell(a.x.min(b.x), width - 2), cell(a.y.min(b.y), height - 2)))
}

/// Segments by their ends.
pub(super) struct Graph {
    /// From a place to another, in order.
    ways: Vec<(Place, Place)>,
}

impl Graph {
    /// Of segments that are each there once.
    pub(super) fn new(segments: &[Segment]) -> Graph {
        let mut ways: Vec<(Place, Place)> = segments.iter().flat_map(|&[a, b]| [(a, b), (b, a)]).collect();
        ways.sort_unstable();
        Graph { ways }
    }

    fn number(&self, way: (Place, Place)) -> usize {
        self.ways.binary_search(&way).unwrap_or_else(|_| panic!("a segment from {:?} to {:?}", way.0, way.1))
    }

    /// The segments that leave a place.
    pub(super) fn beside(&self, p: Place) -> &[(Place, Place)] {
        let from = self.ways.partition_point(|(q, _)| *q < p);
        let count = self.ways[from..].iter().take_while(|(q, _)| *q == p).count();
        &self.ways[from..from + count]
    }

    /// Calls `take` with the places of every way between two ends, each once, in the order of first places. A ring without an end
    /// begins and ends at its first place.
    pub(super) fn walk(&self, is_end: impl Fn(Place) -> bool, mut take: impl FnMut(&[Place])) {
        let mut is_done = vec![false; self.ways.len()];
        let mut places = Vec::new();
        for only_ends in [true, false] {
            for (i, &(start, second)) in self.ways.iter().enumerate() {
                if is_done[i] || only_ends && !is_end(start) {
                    continue;
                }
                places.clear();
                places.extend([start, second]);
                let (mut before, mut at) = (start, second);
                is_done[i] = true;
                is_done[self.number((second, start))] = true;
                while at != start && !is_end(at) {
                    let beside = self.beside(at);
                    let next = beside.iter().map(|(_, to)| *to).find(|&to| to != before);
                    let next = next.unwrap_or_else(|| panic!("a line ends at {at:?}"));
                    is_done[self.number((at, next))] = true;
                    is_done[self.number((next, at))] = true;
                    places.push(next);
                    (before, at) = (at, next);
                }
                take(&places);
            }
        }
    }
}
