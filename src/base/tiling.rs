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

/// A tile of a grid and where it lies: all that follows from the grid alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TilePlace {
    /// Its number in the grid, counted row by row.
    pub index: usize,
    /// Its column and row in the grid.
    pub id: TileId,
    /// Its samples, rim included.
    pub window: Window,
    /// Whether it is the last tile of its row: then it owns its last column of samples.
    pub last_column: bool,
    /// Whether it is in the last row: then it owns its last row of samples.
    pub last_row: bool,
}

impl TilePlace {
    /// The place of a tile that is a whole raster of `width` × `height` samples.
    pub fn alone(width: usize, height: usize) -> TilePlace {
        let window = Window { column: 0, row: 0, width, height };
        TilePlace { index: 0, id: TileId::default(), window, last_column: true, last_row: true }
    }

    /// Column and row of its first sample in the raster.
    pub fn origin(&self) -> (u64, u64) {
        (self.window.column as u64, self.window.row as u64)
    }

    /// Columns and rows of samples that it owns: all but the last ones, which belong to the next tiles, where there are
    /// any. Over all tiles of a grid every sample is owned once.
    pub fn owned(&self) -> (usize, usize) {
        (self.window.width - usize::from(!self.last_column), self.window.height - usize::from(!self.last_row))
    }

    /// How many samples it owns.
    pub fn owned_samples(&self) -> u64 {
        let (columns, rows) = self.owned();
        columns as u64 * rows as u64
    }
}

/// A tile is longer than places in it can be exact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TileTooLong {
    /// The longest side that works, in cells.
    pub limit: usize,
    /// The longest side of the tile.
    pub found: usize,
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

    /// The tile that owns a sample.
    fn tile_at(&self, sample: usize) -> usize {
        let mut tile = (sample / self.tile).min(self.count - 1);
        // The last tiles share what is left, and shifted ones begin elsewhere: no more than two steps.
        while tile + 1 < self.count && self.start(tile + 1) <= sample {
            tile += 1;
        }
        while self.start(tile) > sample {
            tile -= 1;
        }
        tile
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

    /// The grid of [`TileGrid::new`], where places in its tiles are exact.
    ///
    /// # Errors
    /// [`TileTooLong`].
    pub fn exact(width: usize, height: usize, tile: usize) -> Result<TileGrid, TileTooLong> {
        let grid = TileGrid::new(width, height, tile);
        if grid.fits_lattice() {
            return Ok(grid);
        }
        let longest = width.max(height) - 1;
        Err(TileTooLong { limit: MAX_TILE_CELLS, found: if tile == 0 { longest } else { tile.min(longest) } })
    }

    /// The grid whose lines run through the middle of these tiles, so that it has their lines inside its own tiles,
    /// which are no larger, one more each way. Where there is no line, none is shifted. `None` where tiles have no middle.
    pub fn shifted(&self) -> Option<TileGrid> {
        Some(TileGrid { across: self.across.shifted()?, down: self.down.shifted()? })
    }

    /// The grid whose lines from top to bottom run through the middle of these tiles, and the others where they are. `None`
    /// where tiles have no middle.
    pub fn shifted_across(&self) -> Option<TileGrid> {
        Some(TileGrid { down: self.down, ..self.shifted()? })
    }

    /// The same with lines from left to right.
    pub fn shifted_down(&self) -> Option<TileGrid> {
        Some(TileGrid { across: self.across, ..self.shifted()? })
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

    /// The tile that owns a sample.
    pub fn owner(&self, column: usize, row: usize) -> TileId {
        TileId { column: self.across.tile_at(column), row: self.down.tile_at(row) }
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

    /// Where a tile lies, by its number.
    pub fn place(&self, index: usize) -> TilePlace {
        self.place_of(self.tile(index))
    }

    /// Where a tile lies, by its column and row.
    pub fn place_of(&self, id: TileId) -> TilePlace {
        TilePlace {
            index: self.index(id),
            id,
            window: self.window(id),
            last_column: id.column + 1 == self.columns(),
            last_row: id.row + 1 == self.rows(),
        }
    }
}

/// The middles of even parts of so many things; of no more parts than that.
pub fn spread(count: usize, parts: usize) -> impl Iterator<Item = usize> {
    let parts = count.min(parts);
    (0..parts).map(move |i| (2 * i + 1) * count / (2 * parts))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn middles_are_different_and_inside() {
        assert_eq!(spread(1, 3).collect::<Vec<_>>(), [0]);
        assert_eq!(spread(2, 3).collect::<Vec<_>>(), [0, 1]);
        assert_eq!(spread(3, 3).collect::<Vec<_>>(), [0, 1, 2]);
        assert_eq!(spread(100, 3).collect::<Vec<_>>(), [16, 50, 83]);
    }

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
        fn every_sample_is_owned_once(width in 2usize..300, height in 2usize..300, tile in 0usize..70) {
            let grid = TileGrid::new(width, height, tile);
            let shifted = [grid.shifted(), grid.shifted_across(), grid.shifted_down()];
            for grid in std::iter::once(grid).chain(shifted.into_iter().flatten()) {
                let places = || (0..grid.len()).map(|index| grid.place(index));
                prop_assert_eq!(places().map(|p| p.owned_samples()).sum::<u64>(), (width * height) as u64);
                for place in places() {
                    prop_assert_eq!(grid.place_of(place.id), place);
                    prop_assert_eq!(place.last_column, place.window.column + place.window.width == width);
                    prop_assert_eq!(place.last_row, place.window.row + place.window.height == height);
                    let (columns, rows) = place.owned();
                    for (column, row) in [(0, 0), (columns - 1, rows - 1)] {
                        prop_assert_eq!(grid.owner(place.window.column + column, place.window.row + row), place.id);
                    }
                }
            }
        }

        #[test]
        fn shifted_tiles_have_the_lines_inside(width in 2usize..3000, height in 2usize..50, tile in 0usize..700) {
            let grid = TileGrid::new(width, height, tile);
            let Some(shifted) = grid.shifted() else {
                prop_assert!(tile < 4);
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
