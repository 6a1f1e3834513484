use super::{Raster, RasterError};
use crate::base::GeoTransform;

/// How far apart samples of two rasters may be on the map, in cells, and count as the same: geotransforms are kept as
/// decimals by some formats, and rounded.
const ROUNDING_CELLS: f64 = 0.01;

impl Raster {
    /// The raster `other`, cut like this one where it is as large as the whole of this one.
    ///
    /// # Errors
    /// As [`Raster::clip`].
    pub fn clip_alike(&self, other: Raster) -> Result<Raster, RasterError> {
        match self.window() {
            Some(window) if other.whole_size() == self.whole_size() => other.clip(window),
            _ => Ok(other),
        }
    }

    /// Makes sure that the samples of `other` lie on those of this raster: as many across and down, and at the same
    /// places on the map, up to rounding, where both rasters are georeferenced.
    ///
    /// # Errors
    /// [`RasterError::OtherGrid`].
    pub fn same_grid(&self, other: &Raster) -> Result<(), RasterError> {
        let (width, height) = (self.width(), self.height());
        let differs = |what, expected, found| {
            let (path, of) = (other.path().to_path_buf(), self.path().to_path_buf());
            Err(RasterError::OtherGrid { path, of, what, expected, found })
        };
        if (width, height) != (other.width(), other.height()) {
            let size = |(across, down): (usize, usize)| format!("{across} × {down} samples");
            return differs("size", size((width, height)), size((other.width(), other.height())));
        }
        let (ours, theirs) = (self.geo_transform(), other.geo_transform());
        let georeferenced = self.is_georeferenced() && other.is_georeferenced();
        if georeferenced && !agree(ours, theirs, width, height) {
            let numbers = |transform: GeoTransform| transform.coefficients().map(|c| c.to_string()).join(", ");
            return differs("geotransform", numbers(ours), numbers(theirs));
        }
        Ok(())
    }
}

/// Whether the corners of a raster come to lie at the same places: then, the maps being affine, all its samples do.
fn agree(a: GeoTransform, b: GeoTransform, width: usize, height: usize) -> bool {
    let [_, xp, xl, _, yp, yl] = a.coefficients();
    let determinant = a.determinant();
    let (far_x, far_y) = (4 * (width as i64 - 1), 4 * (height as i64 - 1));
    [(0, 0), (far_x, 0), (0, far_y), (far_x, far_y)].into_iter().all(|(x, y)| {
        let ((ax, ay), (bx, by)) = (a.apply(x, y), b.apply(x, y));
        let (dx, dy) = (bx - ax, by - ay);
        let (columns, rows) = ((dx * yl - dy * xl) / determinant, (dy * xp - dx * yp) / determinant);
        columns.abs() <= ROUNDING_CELLS && rows.abs() <= ROUNDING_CELLS
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounded_decimals_agree_and_a_shift_does_not() {
        let transform = |c| GeoTransform::new(c, 1000, 800).expect("a transform");
        let exact = transform([-71.0, 1.0 / 1200.0, 0.0, -32.0, 0.0, -1.0 / 1200.0]);
        let rounded = transform([-71.0, 0.000_833_333_333, 0.0, -32.0, 0.0, -0.000_833_333_333]);
        let shifted = transform([-71.0 + 0.5 / 1200.0, 1.0 / 1200.0, 0.0, -32.0, 0.0, -1.0 / 1200.0]);
        let flipped = transform([-71.0, 1.0 / 1200.0, 0.0, -32.0, 0.0, 1.0 / 1200.0]);
        assert!(agree(exact, exact, 1000, 800) && agree(exact, rounded, 1000, 800));
        assert!(!agree(exact, shifted, 1000, 800) && !agree(exact, flipped, 1000, 800));
    }
}
