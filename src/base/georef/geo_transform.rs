//! From columns and rows to the map: the one definition.

/// The affine map from the lattice of quarter cells to map coordinates.
///
/// The sample at column `c`, row `r` lies on lattice point (4c, 4r) and at the centre of its pixel on the map. Both
/// directions are defined here once, operation by operation in IEEE doubles and without fused multiply-add, so that
/// whoever reads a written vertex can check it bit for bit.
///
/// Of a window of a raster, lattice points are counted from the window's first sample, and have the coordinates, bit for
/// bit, that the whole raster gives them ([`GeoTransform::of_window`]).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GeoTransform {
    coefficients: [f64; 6],
    /// Column and row, in the raster that the coefficients are of, of the sample on lattice point (0, 0).
    origin: (i64, i64),
}

/// Lattice steps in one cell.
const STEPS: f64 = 4.0;

impl GeoTransform {
    /// What a raster without georeferencing is given: x = column + ½, y = −(row + ½).
    pub const DEFAULT: GeoTransform = GeoTransform { coefficients: [0.0, 1.0, 0.0, 0.0, 0.0, -1.0], origin: (0, 0) };

    /// From GDAL's six coefficients: x = c0 + P·c1 + L·c2, y = c3 + P·c4 + L·c5, with P, L in pixels from the
    /// raster's corner.
    ///
    /// # Errors
    /// A sentence if the map is not finite, not invertible, or so far from its origin that neighbouring lattice points
    /// of a raster of `width` × `height` samples share a coordinate.
    pub fn new(coefficients: [f64; 6], width: usize, height: usize) -> Result<GeoTransform, &'static str> {
        if coefficients.iter().any(|c| !c.is_finite()) {
            return Err("expected finite coefficients");
        }
        let transform = GeoTransform { coefficients, origin: (0, 0) };
        if transform.determinant() == 0.0 || !transform.determinant().is_finite() {
            return Err("it maps the raster onto a line or a point");
        }
        let (w, h) = (4 * (width as i64 - 1), 4 * (height as i64 - 1));
        for (x, y) in [(0, 0), (w, 0), (0, h), (w, h), (1, 1), (w - 1, 1), (1, h - 1), (w - 1, h - 1)] {
            let (mx, my) = transform.apply(x, y);
            if transform.lattice(mx, my) != Some((x, y)) {
                return Err("a quarter of a cell is below the resolution of a double so far from the origin");
            }
        }
        Ok(transform)
    }

    /// The same map for a window whose first sample is at this column and row of what the map is of now.
    pub fn of_window(self, column: usize, row: usize) -> GeoTransform {
        let (first_column, first_row) = self.origin;
        GeoTransform { origin: (first_column + column as i64, first_row + row as i64), ..self }
    }

    /// GDAL's six coefficients. Of a window they are those of the whole raster: its own would be rounded.
    pub fn coefficients(&self) -> [f64; 6] {
        self.coefficients
    }

    /// Negative where rows run against the map's y axis (north-up rasters): then a turn that is counter-clockwise in
    /// (column, row) is clockwise on the map.
    pub fn determinant(&self) -> f64 {
        let [_, xp, xl, _, yp, yl] = self.coefficients;
        xp * yl - xl * yp
    }

    /// Map coordinates of a lattice point: with P = x/4 + ½ and L = y/4 + ½ (exact, counted in the whole raster),
    /// `(c0 + P·c1) + L·c2` and `(c3 + P·c4) + L·c5`, each operation rounded to double.
    pub fn apply(&self, x: i64, y: i64) -> (f64, f64) {
        let (x, y) = (x + STEPS as i64 * self.origin.0, y + STEPS as i64 * self.origin.1);
        self.apply_to(x as f64 / STEPS + 0.5, y as f64 / STEPS + 0.5)
    }

    /// Map coordinates of a place between samples: column and row with fractions, whole numbers at the centres of samples.
    pub fn place(&self, column: f64, row: f64) -> (f64, f64) {
        self.apply_to(column + self.origin.0 as f64 + 0.5, row + self.origin.1 as f64 + 0.5)
    }

    fn apply_to(&self, p: f64, l: f64) -> (f64, f64) {
        let [x0, xp, xl, y0, yp, yl] = self.coefficients;
        ((x0 + p * xp) + l * xl, (y0 + p * yp) + l * yl)
    }

    /// The lattice point that maps to exactly these coordinates, bit for bit; `None` if there is none.
    pub fn lattice(&self, map_x: f64, map_y: f64) -> Option<(i64, i64)> {
        let (x, y) = self.nearest_lattice(map_x, map_y)?;
        let (fx, fy) = self.apply(x, y);
        (fx.to_bits() == map_x.to_bits() && fy.to_bits() == map_y.to_bits()).then_some((x, y))
    }

    /// Column and row of a place on the map, with fractions: whole numbers at the centres of samples, up to rounding.
    pub fn sample_coordinates(&self, map_x: f64, map_y: f64) -> (f64, f64) {
        let [x0, xp, xl, y0, yp, yl] = self.coefficients;
        let (dx, dy, det) = (map_x - x0, map_y - y0, self.determinant());
        let p = (dx * yl - dy * xl) / det;
        let l = (dy * xp - dx * yp) / det;
        (p - 0.5 - self.origin.0 as f64, l - 0.5 - self.origin.1 as f64)
    }

    /// The lattice point nearest to these coordinates; `None` if they are not finite or out of any raster's range.
    pub fn nearest_lattice(&self, map_x: f64, map_y: f64) -> Option<(i64, i64)> {
        let (column, row) = self.sample_coordinates(map_x, map_y);
        let (x, y) = ((column * STEPS).round(), (row * STEPS).round());
        const FAR: f64 = (1u64 << 40) as f64;
        (x.abs() < FAR && y.abs() < FAR).then_some((x as i64, y as i64))
    }
}

impl GeoTransform {
    /// Column and row, of a raster of `width` × `height` samples, of the sample nearest to a place on the map; of several that are
    /// equally near, the one of the lowest column and row. `None` if the place lies more than half a cell outside the samples'
    /// centres.
    pub fn nearest_sample(&self, (x, y): (f64, f64), (width, height): (usize, usize)) -> Option<(usize, usize)> {
        let (column, row) = self.sample_coordinates(x, y);
        Some((nearest(column, width)?, nearest(row, height)?))
    }
}

/// The whole number from 0 to `count` − 1 that is nearest to `at`, the lower of two.
fn nearest(at: f64, count: usize) -> Option<usize> {
    (-0.5..=count as f64 - 0.5).contains(&at).then(|| (at - 0.5).ceil().max(0.0) as usize)
}

/// How far apart samples of two rasters may be on the map, in cells, and count as the same: geotransforms are kept as
/// decimals by some formats, and rounded.
const ROUNDING_CELLS: f64 = 0.01;

impl GeoTransform {
    /// The least x and y of the samples of a raster, and the largest.
    pub fn extent(self, width: usize, height: usize) -> [f64; 4] {
        let (far_x, far_y) = (4 * (width as i64 - 1), 4 * (height as i64 - 1));
        let corners = [(0, 0), (far_x, 0), (0, far_y), (far_x, far_y)].map(|(x, y)| self.apply(x, y));
        corners.iter().fold([f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY], |e, &(x, y)| {
            [e[0].min(x), e[1].min(y), e[2].max(x), e[3].max(y)]
        })
    }

    /// Whether the corners of a raster of this size come to lie at the same places, up to rounding: then, the maps
    /// being affine, all its samples do.
    pub fn agrees(self, other: GeoTransform, width: usize, height: usize) -> bool {
        let [_, xp, xl, _, yp, yl] = self.coefficients();
        let determinant = self.determinant();
        let (far_x, far_y) = (4 * (width as i64 - 1), 4 * (height as i64 - 1));
        [(0, 0), (far_x, 0), (0, far_y), (far_x, far_y)].into_iter().all(|(x, y)| {
            let ((ax, ay), (bx, by)) = (self.apply(x, y), other.apply(x, y));
            let (dx, dy) = (bx - ax, by - ay);
            let (columns, rows) = ((dx * yl - dy * xl) / determinant, (dy * xp - dx * yp) / determinant);
            columns.abs() <= ROUNDING_CELLS && rows.abs() <= ROUNDING_CELLS
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn default_puts_samples_at_half_pixels() {
        assert_eq!(GeoTransform::DEFAULT.apply(0, 0), (0.5, -0.5));
        assert_eq!(GeoTransform::DEFAULT.apply(4 * 7, 4 * 3 + 1), (7.5, -3.75));
    }

    #[test]
    fn the_nearest_sample_and_the_lower_of_two() {
        let cases =
            [(-0.5, 0), (-0.2, 0), (0.5, 0), (0.5f64.next_up(), 1), (1.4, 1), (1.5, 1), (3.6, 4), (4.0, 4), (4.5, 4)];
        for (at, expected) in cases {
            assert_eq!(nearest(at, 5), Some(expected), "{at}");
        }
        for outside in [(-0.5f64).next_down(), 4.5f64.next_up(), f64::NAN, f64::INFINITY, -1e300] {
            assert_eq!(nearest(outside, 5), None, "{outside}");
        }
        assert_eq!(GeoTransform::DEFAULT.nearest_sample((2.6, -1.4), (5, 5)), Some((2, 1)));
    }

    #[test]
    fn refuses_what_cannot_be_inverted() {
        assert!(GeoTransform::new([0.0, 1.0, 2.0, 0.0, 2.0, 4.0], 10, 10).is_err());
        assert!(GeoTransform::new([0.0, f64::NAN, 0.0, 0.0, 0.0, 1.0], 10, 10).is_err());
        assert!(GeoTransform::new([1e18, 1.0, 0.0, 0.0, 0.0, -1.0], 10, 10).is_err());
    }

    proptest! {
        #[test]
        fn a_window_has_the_coordinates_of_the_whole(
            origin in (-1e7f64..1e7, -1e7f64..1e7), cell in 1e-4f64..1e3, turn in -0.9f64..0.9,
            column in 0usize..90_000, row in 0usize..90_000, x in 0i64..40_000, y in 0i64..40_000,
        ) {
            let coefficients = [origin.0, cell, cell * turn, origin.1, cell * turn, -cell];
            if let Ok(whole) = GeoTransform::new(coefficients, 100_001, 100_001) {
                let window = whole.of_window(column, row);
                let (mx, my) = window.apply(x, y);
                prop_assert_eq!((mx, my), whole.apply(x + 4 * column as i64, y + 4 * row as i64));
                prop_assert_eq!(window.lattice(mx, my), Some((x, y)));
                prop_assert_eq!(window.place(x as f64 / 4.0, y as f64 / 4.0), (mx, my));
                prop_assert_eq!(whole.of_window(column / 2, row / 2).of_window(column - column / 2, row - row / 2), window);
            }
        }

        #[test]
        fn lattice_points_come_back(
            origin in (-1e7f64..1e7, -1e7f64..1e7), cell in 1e-4f64..1e3, turn in -0.9f64..0.9,
            x in 0i64..400_000, y in 0i64..400_000,
        ) {
            let coefficients = [origin.0, cell, cell * turn, origin.1, cell * turn, -cell];
            if let Ok(transform) = GeoTransform::new(coefficients, 100_001, 100_001) {
                let (mx, my) = transform.apply(x, y);
                prop_assert_eq!(transform.lattice(mx, my), Some((x, y)));
            }
        }
    }

    #[test]
    fn rounded_decimals_agree_and_a_shift_does_not() {
        let transform = |c| GeoTransform::new(c, 1000, 800).expect("a transform");
        let exact = transform([-71.0, 1.0 / 1200.0, 0.0, -32.0, 0.0, -1.0 / 1200.0]);
        let rounded = transform([-71.0, 0.000_833_333_333, 0.0, -32.0, 0.0, -0.000_833_333_333]);
        let shifted = transform([-71.0 + 0.5 / 1200.0, 1.0 / 1200.0, 0.0, -32.0, 0.0, -1.0 / 1200.0]);
        let flipped = transform([-71.0, 1.0 / 1200.0, 0.0, -32.0, 0.0, 1.0 / 1200.0]);
        assert!(exact.agrees(exact, 1000, 800) && exact.agrees(rounded, 1000, 800));
        assert!(!exact.agrees(shifted, 1000, 800) && !exact.agrees(flipped, 1000, 800));
    }
}
