//! Ways from one CRS to another.

use gdal::errors::GdalError;
use gdal::spatial_ref::{AxisMappingStrategy, CoordTransform, CoordTransformOptions, SpatialRef};

use super::gdal_error::reason;

/// The way from one CRS to another; `None` where they are the same.
///
/// Axes are taken as x, y on either side, whatever the authority says: so geotransforms and vector files have them.
/// Transformations that merely ignore an unknown change of datum are not accepted: they can be hundreds of metres off
/// without a word.
pub(super) fn transform(from: &SpatialRef, to: &SpatialRef) -> Result<Option<CoordTransform>, GdalError> {
    let (mut from, mut to) = (from.clone(), to.clone());
    from.set_axis_mapping_strategy(AxisMappingStrategy::TraditionalGisOrder);
    to.set_axis_mapping_strategy(AxisMappingStrategy::TraditionalGisOrder);
    if from == to {
        return Ok(None);
    }
    let mut options = CoordTransformOptions::new()?;
    options.set_ballpark_allowed(false)?;
    CoordTransform::new_with_options(&from, &to, &options).map(Some)
}

/// One place transformed; `None` if it has none there.
pub(super) fn transformed(transform: Option<&CoordTransform>, (x, y): (f64, f64)) -> Option<(f64, f64)> {
    let Some(transform) = transform else { return Some((x, y)) };
    let (mut x, mut y) = ([x], [y]);
    transform.transform_coords(&mut x, &mut y, &mut []).ok()?;
    (x[0].is_finite() && y[0].is_finite()).then_some((x[0], y[0]))
}

/// Brings places on the map from one CRS, as GDAL takes its name, into another.
///
/// # Errors
/// Why that is not possible, as the end of a sentence.
pub(crate) fn bring_into(places: &mut [(f64, f64)], from: &str, into: &str) -> Result<(), String> {
    let crs = |name: &str| SpatialRef::from_definition(name).map_err(|e| reason(&e));
    let way = transform(&crs(from)?, &crs(into)?).map_err(|e| reason(&e))?;
    for place in places {
        let (x, y) = *place;
        *place = transformed(way.as_ref(), *place).ok_or_else(|| format!("{x}, {y} has no place there"))?;
    }
    Ok(())
}
