//! Which tile of the shifted grid a place or a triangle lies in.

use crate::base::lattice::{Point, STEPS};
use crate::base::tiling::{TileGrid, TileId, TilePlace};

/// The lines of the shifted grid through one tile.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lines {
    tile: TileId,
    /// Where they are on the tile's lattice; beyond it where there is none.
    x: i32,
    y: i32,
}

impl Lines {
    /// Those through a tile of the grid that is shifted.
    pub(crate) fn new(shifted: TileGrid, place: &TilePlace) -> Lines {
        let TilePlace { id: tile, window, .. } = *place;
        let last = TileId { column: shifted.columns() - 1, row: shifted.rows() - 1 };
        let after = TileId { column: last.column.min(tile.column + 1), row: last.row.min(tile.row + 1) };
        let begins = shifted.window(after);
        let line = |is_there: bool, at: usize, from: usize| {
            if is_there { (at - from) as i32 * STEPS } else { i32::MAX }
        };
        Lines {
            tile,
            x: line(last.column > 0, begins.column, window.column),
            y: line(last.row > 0, begins.row, window.row),
        }
    }

    /// The tile of the shifted grid that a place of the tile lies in.
    pub(crate) fn region(&self, at: Point) -> TileId {
        let (right, below) = (usize::from(at.x >= self.x), usize::from(at.y >= self.y));
        TileId { column: self.tile.column + right, row: self.tile.row + below }
    }

    /// Whether a triangle lies in more than one of them.
    pub(crate) fn straddles(&self, corners: [Point; 3]) -> bool {
        let [a, b, c] = corners.map(|p| self.region(p));
        a != b || b != c
    }
}
