//! What a raster says of its coordinates and heights.

use gdal::Metadata;
use gdal::spatial_ref::SpatialRef;

use super::Raster;
use crate::base::{Metres, Reference};

impl Raster {
    /// See [`Reference`].
    pub fn reference(&self) -> Reference {
        let crs = self.dataset.spatial_ref().ok();
        let geographic = crs.as_ref().is_some_and(|c| c.is_geographic());
        let node = |name: &str| {
            let value = crs.as_ref().and_then(|c| c.get_attr_value(name, 0).ok().flatten());
            value.unwrap_or_default()
        };
        let unit = match &crs {
            None => None,
            Some(crs) if geographic => crs.angular_units_name(),
            Some(crs) => crs.linear_units_name(),
        };
        let vertical_crs = node("VERT_CS");
        let band_unit = self.rasterband().map(|b| b.unit()).unwrap_or_default();
        let height_unit = match band_unit.is_empty() && !vertical_crs.is_empty() {
            true => node("VERT_CS|UNIT"),
            false => band_unit,
        };
        Reference {
            crs: self.crs_name(),
            georeferenced: self.is_georeferenced(),
            geographic,
            longitudes_beyond_180: geographic && self.extent()[2] > 180.0,
            unit: unit.unwrap_or_default(),
            metres: crs.as_ref().and_then(metres),
            vertical_crs,
            height_unit,
            pixel_is: self.dataset.metadata_item("AREA_OR_POINT", "").unwrap_or_default(),
        }
    }

    /// The CRS as other programs take it from a mesh's header: its authority's code; of a compound one without a code that of its
    /// horizontal part; else WKT; `None` where there is none.
    pub fn crs_definition(&self) -> Option<String> {
        let crs = self.dataset.spatial_ref().ok()?;
        match (crs.auth_name(), crs.auth_code()) {
            (Some(authority), Ok(code)) => Some(format!("{authority}:{code}")),
            _ => horizontal_code(&crs).or_else(|| crs.to_wkt().ok().filter(|wkt| !wkt.is_empty())),
        }
    }

    /// The CRS in Esri's dialect of WKT, as files beside a mesh have it (`.prj`); `None` where there is none, or where it cannot
    /// be said in that dialect.
    pub fn crs_esri_wkt(&self) -> Option<String> {
        let crs = self.dataset.spatial_ref().ok()?;
        crs.morph_to_esri().ok()?;
        crs.to_wkt().ok().filter(|wkt| !wkt.is_empty())
    }
}

/// The code of the horizontal part of a compound CRS.
fn horizontal_code(crs: &SpatialRef) -> Option<String> {
    let value = |name: &str, child| crs.get_attr_value(name, child).ok().flatten();
    value("COMPD_CS", 0)?;
    let kind = if value("PROJCS", 0).is_some() { "PROJCS|AUTHORITY" } else { "GEOGCS|AUTHORITY" };
    Some(format!("{}:{}", value(kind, 0)?, value(kind, 1)?))
}

/// How long the unit of x and y is in a CRS: its authority's code, or WKT; `None` where that is not known.
pub(crate) fn metres_of(definition: &str) -> Option<Metres> {
    metres(&SpatialRef::from_definition(definition).ok()?)
}

/// How long the unit of x and y is.
fn metres(crs: &SpatialRef) -> Option<Metres> {
    if !crs.is_geographic() {
        return Some(crs.linear_units()).filter(|metres| crs.is_projected() && *metres > 0.0).map(Metres::PerUnit);
    }
    let (semi_major, semi_minor) = (crs.semi_major().ok()?, crs.semi_minor().ok()?);
    Some(Metres::OnEllipsoid { semi_major, semi_minor, radians: crs.angular_units() }).filter(|_| semi_minor > 0.0)
}
