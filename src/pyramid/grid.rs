//! The finest grid, its tiles, and how fine each level is.

use super::Body;
use super::error::{BoundBy, PyramidError};

/// Samples at whole multiples of 180° ÷ 2ᴳ, counted from 180° W and 90° N: the same grid for every raster.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Grid {
    /// G.
    pub exponent: u32,
}

/// The finest grid there can be: 0.3 mm on the Earth.
pub(super) const MAX_EXPONENT: u32 = 26;
/// The coarsest: a tile of level 0 has 128 cells across.
pub(super) const MIN_EXPONENT: u32 = 7;

impl Grid {
    /// Cells from pole to pole; there are twice as many around.
    pub fn rows(&self) -> i64 {
        1 << self.exponent
    }

    /// Cells around.
    pub fn columns(&self) -> i64 {
        2 << self.exponent
    }

    /// Degrees in a cell: exact, as 180 has a factor that is a power of two.
    pub fn cell(&self) -> f64 {
        180.0 / self.rows() as f64
    }

    /// The longitude of a column, from −180° on; columns beyond the last begin anew.
    pub fn longitude(&self, column: i64) -> f64 {
        column.rem_euclid(self.columns()) as f64 * self.cell() - 180.0
    }

    /// The latitude of a row.
    pub fn latitude(&self, row: i64) -> f64 {
        90.0 - row as f64 * self.cell()
    }

    /// Cells along the side of a tile.
    pub fn cells(&self, level: u32) -> i64 {
        self.rows() >> level
    }
}

/// A tile, as its address has it: columns from 180° W, rows from the south.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TileKey {
    /// The level; two tiles at 0.
    pub level: u32,
    /// The column.
    pub x: u32,
    /// The row, from the south.
    pub y: u32,
}

impl TileKey {
    /// The first column and row of its samples.
    pub fn origin(&self, grid: Grid) -> (i64, i64) {
        let cells = grid.cells(self.level);
        let from_north = (1i64 << self.level) - 1 - i64::from(self.y);
        (i64::from(self.x) * cells, from_north * cells)
    }

    /// The tile around it one level up.
    pub fn parent(&self) -> TileKey {
        TileKey { level: self.level - 1, x: self.x / 2, y: self.y / 2 }
    }

    /// The tile `east` columns and `north` rows from this one, around the antimeridian; `None` beyond a pole.
    pub fn neighbour(&self, east: i32, north: i32) -> Option<TileKey> {
        let columns = 2i64 << self.level;
        let y = i64::from(self.y) + i64::from(north);
        if !(0..1i64 << self.level).contains(&y) {
            return None;
        }
        let x = (i64::from(self.x) + i64::from(east)).rem_euclid(columns);
        Some(TileKey { x: x as u32, y: y as u32, ..*self })
    }
}

impl std::fmt::Display for TileKey {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}/{}", self.level, self.x, self.y)
    }
}

/// What is asked of the levels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LevelOptions {
    /// The largest error at the finest level, in metres.
    pub(super) max_error: f64,
    /// The finest level; `None` for the rule.
    pub(super) max_level: Option<u32>,
    /// No level's error is larger than this times the client's.
    pub(super) error_factor: f64,
}

/// One level.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Level {
    /// Its number.
    pub level: u32,
    /// ε: how far the surface may be from samples of the finest grid, in metres.
    pub max_error: f64,
    /// The client's error, E.
    pub client_error: f64,
    /// How many parts tiles are cut into each way, so that triangles do not sag too far under the ellipsoid.
    pub parts: u32,
}

/// Cells of a tile of the finest level, if the tolerance does not ask for larger ones.
const FINEST_CELLS: i64 = 128;

/// The share of a level's error that a triangle's sag may take.
const SAG_SHARE: f64 = 0.25;

/// Parts are cut no finer: the corners of 128 each way are a quarter of the vertices that a tile may have.
pub(super) const MAX_PARTS: u32 = 128;

/// All levels, from 0 to the finest.
///
/// # Errors
/// [`PyramidError::Level`] if a level is asked for that the grid is too coarse for.
pub(super) fn levels(body: &Body, grid: Grid, options: &LevelOptions) -> Result<Vec<Level>, PyramidError> {
    let by_cells = grid.exponent - FINEST_CELLS.trailing_zeros();
    let by_error = (0..by_cells).find(|&level| body.client_error(level) <= options.max_error).unwrap_or(by_cells);
    let finest = options.max_level.unwrap_or(by_error);
    // Two cells in a part, and parts as they are needed.
    let most = grid.exponent.saturating_sub(3);
    if finest > most {
        return Err(PyramidError::Level { expected: most, found: finest });
    }
    let mut error = options.max_error.min(options.error_factor * body.client_error(finest));
    let mut levels = Vec::new();
    for level in (0..=finest).rev() {
        let client_error = body.client_error(level);
        let sag = |parts: u32| body.sag(180.0 / (1u64 << level) as f64 / f64::from(parts));
        let most = MAX_PARTS.min((grid.cells(level) / 2) as u32);
        // The flattest triangles that are made allow no less; of the finest level no more is allowed than is asked for.
        let least = if level < finest { sag(most.max(1)) / SAG_SHARE } else { 0.0 };
        let max_error = error.max(least).min(options.error_factor * client_error);
        let fits = |&parts: &u32| sag(parts) <= SAG_SHARE * max_error;
        let parts = (0..).map(|i| 1u32 << i).take_while(|&parts| parts <= most).find(fits);
        let Some(parts) = parts else {
            let bound_by = BoundBy::of(max_error, options.error_factor * client_error, level == finest);
            return Err(PyramidError::Curvature { level, max_error, bound_by });
        };
        levels.push(Level { level, max_error, client_error, parts });
        error = 2.0 * max_error;
    }
    levels.reverse();
    Ok(levels)
}

#[cfg(test)]
mod tests {
    use super::*;

    const EARTH: Body = Body { semi_major: 6_378_137.0, semi_minor: 6_356_752.314_245_179 };
    const MOON: Body = Body { semi_major: 1_737_400.0, semi_minor: 1_737_400.0 };

    fn options(max_error: f64) -> LevelOptions {
        LevelOptions { max_error, max_level: None, error_factor: 1.0 }
    }

    #[test]
    fn the_finest_level_is_the_coarser_of_two() {
        let moon = levels(&MOON, Grid { exponent: 16 }, &options(20.0)).unwrap();
        assert_eq!((moon.len(), moon[9].max_error, moon[8].max_error), (10, 20.0, 40.0));
        let fine = levels(&EARTH, Grid { exponent: 24 }, &options(20.0)).unwrap();
        assert_eq!(fine.len(), 13);
        assert_eq!(fine[12].max_error, EARTH.client_error(12));
        assert!(fine.windows(2).all(|l| l[0].max_error <= 2.0 * l[1].max_error));
        assert!(fine.iter().all(|l| l.max_error <= l.client_error));
    }

    #[test]
    fn parts_are_those_of_the_earth() {
        let earth = levels(&EARTH, Grid { exponent: 20 }, &options(20.0)).unwrap();
        let parts: Vec<u32> = earth.iter().map(|l| l.parts).collect();
        assert_eq!(parts, [32, 32, 16, 16, 8, 8, 4, 4, 2, 2, 1, 1, 1]);
    }

    /// Triangles of coarse levels sag too far for what is asked of the finest; they are allowed as much as clients expect.
    #[test]
    fn coarse_levels_are_as_flat_as_they_can_be() {
        for max_error in [1.0, 0.05] {
            let options = LevelOptions { max_level: Some(11), ..options(max_error) };
            let earth = levels(&EARTH, Grid { exponent: 18 }, &options).unwrap();
            assert_eq!(earth[11].max_error, max_error);
            assert!(earth.iter().all(|l| l.max_error <= l.client_error && l.max_error >= max_error * f64::from(1 << (11 - l.level))));
            let loosened: Vec<&Level> =
                earth.windows(2).filter(|l| l[0].max_error > 2.0 * l[1].max_error).map(|l| &l[0]).collect();
            assert!(!loosened.is_empty() && loosened.iter().all(|l| l.parts == MAX_PARTS), "{loosened:?}");
        }
    }

    #[test]
    fn what_cannot_be_is_refused() {
        let grid = Grid { exponent: 9 };
        let deep = LevelOptions { max_level: Some(7), ..options(20.0) };
        assert!(matches!(levels(&EARTH, grid, &deep), Err(PyramidError::Level { expected: 6, found: 7 })));
        assert!(matches!(levels(&EARTH, grid, &options(0.5)), Err(PyramidError::Curvature { .. })));
    }

    #[test]
    fn tiles_have_their_places() {
        let grid = Grid { exponent: 8 };
        assert_eq!(TileKey { level: 0, x: 1, y: 0 }.origin(grid), (256, 0));
        assert_eq!(TileKey { level: 2, x: 0, y: 0 }.origin(grid), (0, 192));
        assert_eq!((grid.longitude(256), grid.latitude(64)), (0.0, 45.0));
        let corner = TileKey { level: 1, x: 0, y: 1 };
        assert_eq!(corner.neighbour(-1, -1), Some(TileKey { level: 1, x: 3, y: 0 }));
        assert_eq!(corner.neighbour(0, 1), None);
        assert_eq!(TileKey { level: 1, x: 3, y: 1 }.parent(), TileKey { level: 0, x: 1, y: 0 });
    }
}
