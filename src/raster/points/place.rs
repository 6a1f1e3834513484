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

    /// Column and row of the sample nearest to a place, see [`GeoTransform::nearest_sample`].
    pub(super) fn sample(&self, at: (f64, f64)) -> Option<(usize, usize)> {
        self.geo_transform.nearest_sample(self.on_the_map(at)?, (self.width, self.height))
    }
}
