//! Which tile of another grid a place or a triangle lies in.

use crate::base::lattice::{Point, STEPS};
use crate::base::tiling::{TileGrid, TileId, TilePlace};

/// The lines of a grid near one tile, of that grid or of another one of a run, whose tiles are as large.
///
/// A tile of a run's grids meets at most two tiles of another one each way, so these are enough for places in a tile that
/// meets this one.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lines {
    /// The tile of the grid before the first line of each kind.
    first: TileId,
    /// Where they are on the tile's lattice, ascending; beyond it where there is none.
    x: [i32; LINES],
    y: [i32; LINES],
}

/// How many lines can be near a tile each way: one on either side of it and one through it, or two ends and one beyond.
const LINES: usize = 3;

impl Lines {
    /// Those of `grid` near a tile, on the lattice of that tile.
    pub(crate) fn new(grid: TileGrid, place: &TilePlace) -> Lines {
        let window = place.window;
        let owner = grid.owner(window.column, window.row);
        let first = TileId { column: owner.column.saturating_sub(1), row: owner.row.saturating_sub(1) };
        let line = |is_there: bool, at: usize, from: usize| {
            if is_there { (at as i64 - from as i64) as i32 * STEPS } else { i32::MAX }
        };
        let after = |last: usize, at: usize| (at.min(last), at <= last);
        let x = std::array::from_fn(|i| {
            let (column, is_there) = after(grid.columns() - 1, first.column + 1 + i);
            line(is_there, grid.window(TileId { column, row: 0 }).column, window.column)
        });
        let y = std::array::from_fn(|i| {
            let (row, is_there) = after(grid.rows() - 1, first.row + 1 + i);
            line(is_there, grid.window(TileId { column: 0, row }).row, window.row)
        });
        Lines { first, x, y }
    }

    /// The tile of the grid that a place lies in: its upper and left lines are a tile's own.
    pub(crate) fn region(&self, at: Point) -> TileId {
        let passed = |lines: &[i32; LINES], at: i32| lines.iter().filter(|&&line| at >= line).count();
        TileId { column: self.first.column + passed(&self.x, at.x), row: self.first.row + passed(&self.y, at.y) }
    }

    /// The tiles that a triangle lies in.
    pub(crate) fn span(&self, corners: [Point; 3]) -> Span {
        let [a, b, c] = corners;
        let least = Point { x: a.x.min(b.x).min(c.x), y: a.y.min(b.y).min(c.y) };
        let most = Point { x: a.x.max(b.x).max(c.x), y: a.y.max(b.y).max(c.y) };
        Span { first: self.region(least), last: self.region(most) }
    }

    /// Whether a triangle lies in more than one of them.
    pub(crate) fn straddles(&self, corners: [Point; 3]) -> bool {
        !self.span(corners).is_one()
    }
}

/// The tiles that the box of a triangle meets: a rectangle of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Span {
    pub(crate) first: TileId,
    pub(crate) last: TileId,
}

impl Span {
    /// Whether it is one tile, so that the triangle lies inside of it.
    pub(crate) fn is_one(&self) -> bool {
        self.first == self.last
    }

    pub(crate) fn has(&self, tile: TileId) -> bool {
        let Span { first, last } = self;
        (first.column..=last.column).contains(&tile.column) && (first.row..=last.row).contains(&tile.row)
    }
}
