//! Where a tile's sides are the raster's own rim.

use super::lattice::{Point, STEPS};
use super::tiling::TilePlace;

/// Those sides of a tile that no other tile shares, because the raster ends there, as lines of the tile's lattice.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct RasterRim {
    columns: [Option<i32>; 2],
    rows: [Option<i32>; 2],
}

impl RasterRim {
    /// Those of a tile of a grid.
    pub fn of(place: &TilePlace) -> RasterRim {
        let far = |samples: usize| (samples as i32 - 1) * STEPS;
        let TilePlace { id, window, last_column, last_row, .. } = *place;
        RasterRim {
            columns: [(id.column == 0).then_some(0), last_column.then_some(far(window.width))],
            rows: [(id.row == 0).then_some(0), last_row.then_some(far(window.height))],
        }
    }

    /// Whether a place is on two sides.
    pub fn is_corner(&self, p: Point) -> bool {
        self.columns.contains(&Some(p.x)) && self.rows.contains(&Some(p.y))
    }

    /// Whether two places are on one of the sides.
    #[inline]
    pub fn joins(&self, p: Point, q: Point) -> bool {
        let on = |lines: [Option<i32>; 2], a: i32, b: i32| a == b && lines.contains(&Some(a));
        on(self.columns, p.x, q.x) || on(self.rows, p.y, q.y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_side_is_the_rasters_where_no_tile_follows() {
        let first = TilePlace { last_column: false, last_row: false, ..TilePlace::alone(5, 4) };
        let at = |x, y| Point { x, y };
        let rim = RasterRim::of(&first);
        assert!(rim.joins(at(0, 3), at(0, 9)) && rim.joins(at(1, 0), at(16, 0)));
        assert!(!rim.joins(at(0, 3), at(1, 0)), "around a corner");
        assert!(!rim.joins(at(16, 1), at(16, 2)) && !rim.joins(at(3, 12), at(4, 12)), "other tiles follow");
        assert!(!rim.joins(at(4, 4), at(4, 8)), "inside");
        assert!(rim.is_corner(at(0, 0)) && !rim.is_corner(at(16, 0)) && !rim.is_corner(at(0, 4)));
        let alone = RasterRim::of(&TilePlace::alone(5, 4));
        assert!(alone.joins(at(16, 1), at(16, 2)) && alone.joins(at(3, 12), at(4, 12)));
        assert!(!RasterRim::default().joins(at(0, 0), at(0, 4)));
    }
}
