//! The curvature of the ellipsoid in samples: heights above it, less its fall below a plane that touches it, are heights above that plane,
//! in which a chord is a straight line. Meshes made of these sag as little as the tolerance asks for, and no more of it need be set aside.
//!
//! Of columns and rows dλ and dφ apart, N cos²φ dλ² ÷ 2 for each column squared and M dφ² ÷ 2 for each row squared are the fall, N and M
//! being the radii of curvature across and along the meridian. Linear functions of the column or the row change no error of a mesh, so it does not
//! matter where the plane touches: the fall is counted from the middle of a square, in columns by the radii of each row. So it is the same on the side
//! that two squares share, bit for bit, and a function of the side and its length alone.
//!
//! That a chord lies beside the line between its ends is not in it: it matters as much as the fall where the ground is as steep as 45°, but the triangles
//! of steep ground are small. Nor is the fall beyond second order: in squares of 5.6°, the largest that the usual levels of the Earth have, it is off by 2 % of the largest sag
//! at latitudes up to 60°.

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
        let of_row = along * self.squared(row);
        let square = *self;
        move |column| across * square.squared(column) + of_row
    }

    /// The square of how far a column or a row is from the middle, in cells.
    fn squared(&self, at: i64) -> f64 {
        let from_middle = at as f64 - 0.5 * self.cells as f64;
        from_middle * from_middle
    }

    /// Adds to `into` the heights of a row less the fall, those of the columns that `squares` is of.
    pub(super) fn flatten(&self, row: i64, heights: &[f64], squares: &[f64], into: &mut Vec<f64>) {
        let (across, along) = self.body.bends(self.grid, self.top + row);
        let of_row = along * self.squared(row);
        into.extend(heights.iter().zip(squares).map(|(height, squared)| height - (across * squared + of_row)));
    }

    /// What [`Fall::flatten`] takes.
    pub(super) fn squares(&self, step: i64) -> Vec<f64> {
        (0..=self.cells / step).map(|column| self.squared(column * step)).collect()
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
    use super::super::body::{cross, dot, minus};
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

    /// How far triangles with their corners on the ellipsoid are below its samples, along the normals there.
    #[test]
    fn what_triangles_sag_is_in_it() {
        const K: i64 = 16;
        let triangles =
            [[(0, 0), (0, K), (K, 0)], [(0, 0), (0, 8), (8, 0)], [(8, 0), (K, 8), (K, 0)], [(0, 0), (0, K), (K, 8)]];
        for (degrees, exponent) in [(5.625, 9), (0.703_125, 12)] {
            for north in [2.8125, 45.0, 61.875] {
                let grid = Grid { exponent };
                let square = Fall { body: EARTH, grid, top: ((90.0 - north) / grid.cell()) as i64, cells: K };
                let angles = |column: i64, row: i64| {
                    (Angle::of(grid.longitude(column)), Angle::of(grid.latitude(square.top + row)))
                };
                let at = |(column, row): (i64, i64)| {
                    let (lon, lat) = angles(column, row);
                    EARTH.point(lon, lat, 0.0)
                };
                let most = 0.02 * EARTH.sag(degrees);
                for triangle in triangles {
                    let [a, b, c] = triangle.map(at);
                    let face = cross(minus(b, a), minus(c, a));
                    let falls = triangle.map(|(column, row)| square.along_row(row)(column));
                    let turn = |p: (i64, i64), q: (i64, i64), r: (i64, i64)| {
                        (q.1 - p.1) * (r.0 - p.0) - (q.0 - p.0) * (r.1 - p.1)
                    };
                    let [p, q, r] = triangle;
                    for sample in (0..=K).flat_map(|row| (0..=K).map(move |column| (column, row))) {
                        let weights = [turn(q, r, sample), turn(r, p, sample), turn(p, q, sample)];
                        if weights.iter().any(|weight| *weight < 0) {
                            continue;
                        }
                        let (lon, lat) = angles(sample.0, sample.1);
                        let sag = -dot(face, minus(a, at(sample))) / dot(face, Body::normal(lon, lat));
                        let weighted = weights.iter().zip(falls).map(|(weight, fall)| *weight as f64 * fall);
                        let found = weighted.sum::<f64>() / turn(p, q, r) as f64 - square.along_row(sample.1)(sample.0);
                        assert!(
                            (found - sag).abs() < most,
                            "{found} for {sag} at {sample:?} of {triangle:?}, {degrees}° at {north}"
                        );
                    }
                }
            }
        }
    }
}
