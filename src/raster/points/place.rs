//! The sample nearest to a point.

use gdal::errors::GdalError;
use gdal::spatial_ref::{CoordTransform, SpatialRef};

use crate::base::GeoTransform;
use crate::raster::Raster;
use crate::raster::crs::{transform, transformed};

/// Finds the samples of a raster at places on a map.
pub(super) struct Placer {
    /// From the CRS of the points to the raster's; `None` where they are the same, or one of them is not known.
    transform: Option<CoordTransform>,
    geo_transform: GeoTransform,
    width: usize,
    height: usize,
}

impl Placer {
    /// For points in `crs`. Without one, or where the raster has none, coordinates are taken as the raster's own.
    pub(super) fn new(raster: &Raster, crs: Option<&SpatialRef>) -> Result<Placer, GdalError> {
        let (width, height) = (raster.width(), raster.height());
        let transform = match (crs, raster.dataset.spatial_ref()) {
            (Some(from), Ok(to)) => transform(from, &to)?,
            _ => None,
        };
        Ok(Placer { transform, geo_transform: raster.geo_transform(), width, height })
    }

    /// The raster's own coordinates of a place; `None` if it has none there.
    pub(super) fn on_the_map(&self, at: (f64, f64)) -> Option<(f64, f64)> {
        transformed(self.transform.as_ref(), at)
    }

    /// Column and row of the sample nearest to a place; of several that are equally near, the one of the lowest column
    /// and row. `None` if the place lies more than half a cell outside the samples' centres.
    pub(super) fn sample(&self, at: (f64, f64)) -> Option<(usize, usize)> {
        let (x, y) = self.on_the_map(at)?;
        let (column, row) = self.geo_transform.sample_coordinates(x, y);
        Some((nearest(column, self.width)?, nearest(row, self.height)?))
    }
}

/// The whole number from 0 to `count` − 1 that is nearest to `at`, the lower of two.
fn nearest(at: f64, count: usize) -> Option<usize> {
    (-0.5..=count as f64 - 0.5).contains(&at).then(|| (at - 0.5).ceil().max(0.0) as usize)
}

#[cfg(test)]
mod tests {
    use super::nearest;

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
    }
}
