//! How coordinates stand in a file: less an origin, times factors, perhaps in single precision.

use super::GeoTransform;

/// How places on the map and heights stand in a file: less an origin, times factors, perhaps in single precision.
///
/// Each format says it in its own words, so that whoever reads the file finds map coordinates, and the sample at which a
/// vertex stands. Both directions are defined here, operation by operation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CoordinateFrame {
    /// What is taken from x and y.
    pub origin: (f64, f64),
    /// What x and y, less the origin, are multiplied by; above 0. Metres in a degree, most often, where it is not 1.
    pub xy_scale: (f64, f64),
    /// What heights are multiplied by; above 0.
    pub z_scale: f64,
    /// Whether x, y and z are written in single precision.
    pub single: bool,
}

impl Default for CoordinateFrame {
    fn default() -> Self {
        CoordinateFrame::PLAIN
    }
}

impl CoordinateFrame {
    /// Map coordinates and heights as they are.
    pub const PLAIN: CoordinateFrame =
        CoordinateFrame { origin: (0.0, 0.0), xy_scale: (1.0, 1.0), z_scale: 1.0, single: false };

    /// Whether x and y in the file are other than on the map but for rounding.
    pub fn is_local(&self) -> bool {
        (self.origin, self.xy_scale) != (CoordinateFrame::PLAIN.origin, CoordinateFrame::PLAIN.xy_scale)
    }

    /// Whether heights keep their digits where they are multiplied by [`CoordinateFrame::z_scale`].
    pub fn scales_exactly(&self) -> bool {
        self.z_scale.log2().fract() == 0.0
    }

    /// What is written of a place: `(x − X) × S`, each operation rounded to double, then perhaps to single precision.
    pub fn written_place(&self, (x, y): (f64, f64)) -> (f64, f64) {
        (self.rounded((x - self.origin.0) * self.xy_scale.0), self.rounded((y - self.origin.1) * self.xy_scale.1))
    }

    /// What is written of a height: `height × F`, rounded to double, then perhaps to single precision.
    pub fn written_height(&self, height: f64) -> f64 {
        self.rounded(height * self.z_scale)
    }

    /// The height of what is written: `z ÷ F`, rounded to double.
    pub fn height(&self, z: f64) -> f64 {
        z / self.z_scale
    }

    /// The place on the map of what is written, up to rounding.
    pub fn on_the_map(&self, (x, y): (f64, f64)) -> (f64, f64) {
        (x / self.xy_scale.0 + self.origin.0, y / self.xy_scale.1 + self.origin.1)
    }

    /// The lattice point that is written as exactly this, bit for bit; `None` if there is none.
    pub fn lattice(&self, transform: &GeoTransform, at: (f64, f64)) -> Option<(i64, i64)> {
        let (x, y) = self.nearest_lattice(transform, at)?;
        let written = self.written_place(transform.apply(x, y));
        (written.0.to_bits() == at.0.to_bits() && written.1.to_bits() == at.1.to_bits()).then_some((x, y))
    }

    /// The lattice point nearest to what is written; `None` if it is out of any raster's range.
    pub fn nearest_lattice(&self, transform: &GeoTransform, at: (f64, f64)) -> Option<(i64, i64)> {
        let (x, y) = self.on_the_map(at);
        transform.nearest_lattice(x, y)
    }

    /// Whether every lattice point of a raster of this size is found again: neighbours stay apart.
    pub fn tells_apart(&self, transform: &GeoTransform, width: usize, height: usize) -> bool {
        let (far_x, far_y) = (4 * (width as i64 - 1), 4 * (height as i64 - 1));
        let corners = [(0, 0), (far_x, 0), (0, far_y), (far_x, far_y)].map(|(x, y)| transform.apply(x, y));
        let largest = |of: fn((f64, f64)) -> f64| {
            corners.iter().map(|&(x, y)| of((x - self.origin.0, y - self.origin.1)).abs()).fold(0.0, f64::max)
        };
        // At most so much is lost in rounding; there is more of it in doubles where there is a factor.
        let doubles = if self.xy_scale == (1.0, 1.0) { f64::EPSILON } else { 3.0 * f64::EPSILON };
        let half_step = if self.single { f64::from(f32::EPSILON) / 2.0 } else { doubles };
        let (dx, dy) = (largest(|p| p.0) * half_step, largest(|p| p.1) * half_step);
        let [_, xp, xl, _, yp, yl] = transform.coefficients();
        let determinant = transform.determinant().abs();
        let columns = (yl.abs() * dx + xl.abs() * dy) / determinant;
        let rows = (yp.abs() * dx + xp.abs() * dy) / determinant;
        // Half a lattice step is an eighth of a cell; the rest is for rounding on the way back.
        columns < 1.0 / 16.0 && rows < 1.0 / 16.0
    }

    fn rounded(&self, value: f64) -> f64 {
        if self.single { f64::from(value as f32) } else { value }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn lattice_points_come_back_where_they_are_told_apart(
            corner in (-1e7f64..1e7, -1e7f64..1e7), cell in 1e-3f64..1e2, turn in -0.9f64..0.9, single: bool, near: bool,
            xy_scale in proptest::prop_oneof![Just((1.0, 1.0)), (1e-3f64..1e6, 1e-3f64..1e6)],
            (x, y) in (0i64..40_000, 0i64..40_000),
        ) {
            let size = 10_001;
            let Ok(transform) = GeoTransform::new([corner.0, cell, cell * turn, corner.1, cell * turn, -cell], size, size)
            else { return Ok(()) };
            let origin = if near { (corner.0.round(), corner.1.round()) } else { (0.0, 0.0) };
            let frame = CoordinateFrame { origin, xy_scale, z_scale: 1.0, single };
            prop_assert!(!near || frame.tells_apart(&transform, size, size));
            if frame.tells_apart(&transform, size, size) {
                prop_assert_eq!(frame.lattice(&transform, frame.written_place(transform.apply(x, y))), Some((x, y)));
            }
        }
    }
}
