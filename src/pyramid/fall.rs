//! The curvature of the ellipsoid in samples: heights above it, less its fall below a plane that touches it, are heights above that plane,
//! in which a chord is a straight line. Meshes made of these sag as little as the tolerance asks for, and no more of it need be set aside.
//!
//! Of columns and rows dλ and dφ apart, N cos²φ dλ² ÷ 2 for each column squared and M dφ² ÷ 2 for each row squared are the fall, N and M
//! being the radii of curvature across and along the meridian. Linear functions of the column or the row change no error of a mesh, so it does not
//! matter where the plane touches: the fall is counted from the middle of a square, in columns by the radii of each row. So it is the same on the side
//! that two squares share, bit for bit, and a function of the side and its length alone.
//!
//! That a chord lies beside the line between its ends is not in it: it matters as much as the fall where the ground is as steep as 45°, but the triangles
//! of steep ground are small. Nor is the fall beyond second order: in squares of 5.6°, the largest that the usual levels of the Earth have, it is off by 0.3 %.

use super::Body;
use super::body::Angle;
use super::grid::Grid;

/// The fall in a square of the grid.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fall {
    pub(super) body: Body,
    pub(super) grid: Grid,
    /// The first row of the square.
    pub(super) top: i64,
    /// Cells along its side.
    pub(super) cells: i64,
}

impl Fall {
    /// The fall along a row, in metres, both counted from the corner of the square.
    pub(super) fn along_row(&self, row: i64) -> impl Fn(i64) -> f64 + use<> {
        let (across, along) = self.body.bends(self.grid, self.top + row);
        let half = 0.5 * self.cells as f64;
        let from_middle = move |at: i64| at as f64 - half;
        let of_row = along * from_middle(row) * from_middle(row);
        move |column| across * from_middle(column) * from_middle(column) + of_row
    }

    /// The fall along its western side, or its northern one, from corner to corner. Those of the eastern and the southern are the same.
    pub(super) fn along_side(&self, down: bool) -> Vec<f64> {
        let along_north = self.along_row(0);
        (0..=self.cells).map(|at| if down { self.along_row(at)(0) } else { along_north(at) }).collect()
    }
}

impl Body {
    /// By how much the ellipsoid falls below a plane that touches it in a row of a grid, in metres: a column from there, and a row.
    pub(super) fn bends(&self, grid: Grid, row: i64) -> (f64, f64) {
        let (lat, cell) = (Angle::of(grid.latitude(row)), grid.cell().to_radians());
        let (across, along) = self.radii(lat);
        (0.5 * across * (lat.cos * cell) * (lat.cos * cell), 0.5 * along * cell * cell)
    }
}

#[cfg(test)]
mod tests {
    use super::super::body::{dot, minus};
    use super::*;

    const EARTH: Body = Body { semi_major: 6_378_137.0, semi_minor: 6_356_752.314_245_179 };

    fn fall(top: i64, cells: i64) -> Fall {
        Fall { body: EARTH, grid: Grid { exponent: 12 }, top, cells }
    }

    #[test]
    fn squares_agree_on_the_side_that_they_share() {
        let (upper, lower) = (fall(640, 64), fall(704, 64));
        let (south, north) = (upper.along_row(64), lower.along_row(0));
        assert_eq!(lower.along_side(false), (0..=64).map(south).collect::<Vec<f64>>());
        assert_eq!(lower.along_side(false), (0..=64).map(north).collect::<Vec<f64>>());
        assert_eq!(lower.along_side(true), (0..=64).map(|row| lower.along_row(row)(64)).collect::<Vec<f64>>());
    }

    /// The chord between two samples at the ellipsoid, measured along the normal at a sample between them.
    #[test]
    fn what_chords_sag_is_in_it() {
        for (top, cells) in [(300, 16), (1024, 64), (2016, 64), (3000, 32)] {
            let square = fall(top, cells);
            let place = |(column, row): (i64, i64)| {
                let (lon, lat) = (square.grid.longitude(column), square.grid.latitude(top + row));
                (Angle::of(lon), Angle::of(lat))
            };
            let half = cells / 2;
            for (from, to) in [((0, half), (cells, half)), ((half, 0), (half, cells)), ((0, 0), (cells, cells))] {
                let [a, b] = [from, to].map(|at| EARTH.point(place(at).0, place(at).1, 0.0));
                let middle = [0, 1, 2].map(|i| 0.5 * (a[i] + b[i]));
                let (lon, lat) = place((half, half));
                let sag = dot(minus(EARTH.point(lon, lat, 0.0), middle), Body::normal(lon, lat));
                let at = |(column, row): (i64, i64)| square.along_row(row)(column);
                let found = 0.5 * (at(from) + at(to)) - at((half, half));
                assert!((found / sag - 1.0).abs() < 0.01, "{found} for {sag} from {from:?} to {to:?} at {top}");
            }
        }
    }
}
