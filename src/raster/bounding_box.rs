//! The window of a box on the map.

use gdal::spatial_ref::SpatialRef;

use super::crs::{transform, transformed};
use super::gdal_error::reason;
use super::{Raster, RasterError};
use crate::base::Window;

/// A rectangle on a map, its sides included.
#[derive(Debug, Clone, PartialEq)]
pub struct BoundingBox {
    /// The least x and y.
    pub min: (f64, f64),
    /// The largest.
    pub max: (f64, f64),
    /// The CRS, in any form GDAL takes; `None` is that of the raster. x is east, or longitude, whatever the authority says.
    pub crs: Option<String>,
}

/// Places along a side of a box that are looked for in another CRS, where its sides may be bent.
const PLACES: u32 = 65;

impl Raster {
    /// The samples inside a box, as a window: the smallest one that holds all of them. Where the box is not parallel to
    /// the rows and columns (a raster that is turned, another CRS), it holds samples outside of the box, too. Of a box in
    /// another CRS, 65 × 65 places are transformed.
    ///
    /// # Errors
    /// [`RasterError::BoxCrs`] if there is no way from the box's CRS to the raster's, [`RasterError::EmptyBox`] if there
    /// are less than 2 × 2 samples inside.
    pub fn window_of(&self, bounds: &BoundingBox) -> Result<Window, RasterError> {
        let places = self.places_of(bounds)?;
        Window::between(&places, (self.width(), self.height())).map_err(|(columns, rows)| RasterError::EmptyBox {
            path: self.path().to_path_buf(),
            columns,
            rows,
            extent: self.extent(),
            crs: self.crs_name(),
        })
    }

    /// Places of the box, as column and row with fractions.
    fn places_of(&self, bounds: &BoundingBox) -> Result<Vec<(f64, f64)>, RasterError> {
        let ((left, bottom), (right, top)) = (bounds.min, bounds.max);
        let failed = |name: &str, reason: String| RasterError::BoxCrs {
            path: self.path().to_path_buf(),
            from: name.to_string(),
            to: self.crs_name(),
            reason,
        };
        let transform = match &bounds.crs {
            None => None,
            Some(name) => {
                let from = SpatialRef::from_definition(name).map_err(|e| failed(name, reason(&e)))?;
                let to = self.dataset.spatial_ref().map_err(|_| failed(name, "the raster has no CRS".to_string()))?;
                transform(&from, &to).map_err(|e| failed(name, reason(&e)))?
            }
        };
        let steps = if transform.is_some() { PLACES - 1 } else { 1 };
        let part = |low: f64, high: f64, i: u32| low + (high - low) * (f64::from(i) / f64::from(steps));
        let mut places = Vec::new();
        for (i, j) in (0..=steps).flat_map(|i| (0..=steps).map(move |j| (i, j))) {
            let at = (part(left, right, i), part(bottom, top, j));
            let (x, y) = transformed(transform.as_ref(), at).ok_or_else(|| {
                let name = bounds.crs.as_deref().unwrap_or_default();
                failed(name, format!("{}, {} has no place there", at.0, at.1))
            })?;
            places.push(self.geo_transform().sample_coordinates(x, y));
        }
        Ok(places)
    }

    /// The least x and y of samples, and the largest.
    pub fn extent(&self) -> [f64; 4] {
        self.geo_transform().extent(self.width(), self.height())
    }
}
