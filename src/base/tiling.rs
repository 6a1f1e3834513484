//! How a raster is cut into tiles.

use crate::base::Window;
use crate::base::lattice::MAX_TILE_CELLS;

/// The grid of tiles over a raster: `columns` × `rows` tiles that share their rim samples.
///
/// Tiles begin at multiples of the tile size; the last two of a row (and of a column) share what is left evenly, so
/// that none is a sliver. The cut depends on the raster's size and the tile size alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TileGrid {
    across: Cut,
    down: Cut,
}

/// One tile's place in the grid.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
pub struct TileId {
    /// Tiles to its left.
    pub column: usize,
    /// Tiles above it.
    pub row: usize,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Cut {
    cells: usize,
    tile: usize,
    count: usize,
    /// Lines run through the middle of tiles instead of between them.
    shifted: bool,
}

impl Cut {
    fn new(cells: usize, tile: usize) -> Cut {
        let tile = if tile == 0 { cells } else { tile.min(cells) };
        Cut { cells, tile, count: cells.div_ceil(tile), shifted: false }
    }

    /// The cut whose lines run through the middle of this one's tiles. Where there is one tile, there is no line to
    /// leave, and it stays. `None`: a tile has no middle.
    fn shifted(self) -> Option<Cut> {
        let least = (0..self.count).rev().take(2).map(|i| self.start(i + 1) - self.start(i)).min();
        match self.count {
            1 => Some(self),
            count => (least >= Some(2)).then_some(Cut { count: count + 1, shifted: true, ..self }),
        }
    }

    /// The first sample of tile `i`; of tile `count`: the last sample of all.
    fn start(&self, i: usize) -> usize {
        if self.shifted {
            let tiles = Cut { count: self.count - 1, shifted: false, ..*self };
            return match i {
                0 => 0,
                _ if i == self.count => self.cells,
                _ => (tiles.start(i - 1) + tiles.start(i)) / 2,
            };
        }
        if i == self.count {
            self.cells
        } else if i + 1 == self.count && i > 0 {
            let before = (i - 1) * self.tile;
            before + (self.cells - before).div_ceil(2)
        } else {
            i * self.tile
        }
    }
}

impl TileGrid {
    /// Cuts `width` × `height` samples into tiles of `tile` cells; 0 makes one tile.
    pub fn new(width: usize, height: usize, tile: usize) -> TileGrid {
        TileGrid { across: Cut::new(width - 1, tile), down: Cut::new(height - 1, tile) }
    }

    /// The grid whose lines run through the middle of these tiles, so that it has their lines inside its own tiles,
    /// which are no larger, one more each way. `None` where there is no line, or tiles have no middle.
    pub fn shifted(&self) -> Option<TileGrid> {
        let cut = || Some(TileGrid { across: self.across.shifted()?, down: self.down.shifted()? });
        if self.len() == 1 { None } else { cut() }
    }

    /// Whether every tile fits the lattice's exact arithmetic.
    pub fn fits_lattice(&self) -> bool {
        self.across.tile <= MAX_TILE_CELLS && self.down.tile <= MAX_TILE_CELLS
    }

    /// Tiles across.
    pub fn columns(&self) -> usize {
        self.across.count
    }

    /// Tiles down.
    pub fn rows(&self) -> usize {
        self.down.count
    }

    /// All tiles.
    pub fn len(&self) -> usize {
        self.columns() * self.rows()
    }

    /// Never: a raster has at least one cell.
    pub fn is_empty(&self) -> bool {
        false
    }

    /// Tile number `index`, counted row by row.
    pub fn tile(&self, index: usize) -> TileId {
        TileId { column: index % self.columns(), row: index / self.columns() }
    }

    /// The number of a tile, counted row by row.
    pub fn index(&self, id: TileId) -> usize {
        id.row * self.columns() + id.column
    }

    /// The samples of a tile, rim included.
    pub fn window(&self, id: TileId) -> Window {
        let (column, row) = (self.across.start(id.column), self.down.start(id.row));
        let (right, bottom) = (self.across.start(id.column + 1), self.down.start(id.row + 1));
        Window { column, row, width: right - column + 1, height: bottom - row + 1 }
    }

    /// The most samples a tile has.
    pub fn largest(&self) -> usize {
        (self.across.tile + 1) * (self.down.tile + 1)
    }

    /// Whether the tile is the last of its row.
    pub fn is_last_column(&self, id: TileId) -> bool {
        id.column + 1 == self.columns()
    }

    /// Whether the tile is in the last row.
    pub fn is_last_row(&self, id: TileId) -> bool {
        id.row + 1 == self.rows()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn tiles_share_rims_and_none_is_a_sliver(width in 2usize..3000, height in 2usize..50, tile in 0usize..700) {
            let grid = TileGrid::new(width, height, tile);
            let mut right = 0;
            for column in 0..grid.columns() {
                let w = grid.window(TileId { column, row: 0 });
                prop_assert_eq!(w.column, right);
                right = w.column + w.width - 1;
                let cells = w.width - 1;
                prop_assert!(tile == 0 || cells <= tile);
                prop_assert!(grid.columns() == 1 || 2 * cells >= tile, "{} cells", cells);
            }
            prop_assert_eq!(right, width - 1);
        }

        #[test]
        fn shifted_tiles_have_the_lines_inside(width in 2usize..3000, height in 2usize..50, tile in 0usize..700) {
            let grid = TileGrid::new(width, height, tile);
            let Some(shifted) = grid.shifted() else {
                prop_assert!(grid.len() == 1 || tile < 4);
                return Ok(());
            };
            let of = |grid: &TileGrid, column| grid.window(TileId { column, row: 0 });
            let mut right = 0;
            for column in 0..shifted.columns() {
                let w = of(&shifted, column);
                prop_assert_eq!(w.column, right);
                prop_assert!(w.width >= 2 && w.len() <= grid.largest());
                right = w.column + w.width - 1;
                if shifted.columns() > 1 && column > 0 && column < grid.columns() {
                    let line = of(&grid, column).column;
                    prop_assert!(w.column < line && line < right, "{} in {:?}", line, w);
                }
            }
            prop_assert_eq!(right, width - 1);
        }
    }
}
