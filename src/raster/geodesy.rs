//! From a raster to longitude, latitude and ellipsoidal height, sample by sample.

use gdal::spatial_ref::{CoordTransform, SpatialRef};

use super::Raster;
use super::crs::transform;
use super::gdal_error::reason;
use crate::base::metres_in;

/// What longitudes and latitudes are taken on where the raster lies on the Earth.
const EARTH: &str = "EPSG:4326";
/// The same with ellipsoidal heights.
const EARTH_WITH_HEIGHTS: &str = "EPSG:4979";
/// Half axes that are of the Earth, in metres.
const EARTH_RADII: std::ops::Range<f64> = 6.3e6..6.4e6;

/// Why a raster cannot be brought to longitude, latitude and ellipsoidal height. No message names the raster.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GeodesyError {
    /// It lies nowhere.
    #[error("expected a geographic or projected CRS and a geotransform, found {found}")]
    Local {
        /// What there is.
        found: String,
    },
    /// PROJ knows no exact way.
    #[error("found no transformation from {from} to {to} that is more than a guess: {reason}")]
    NoWay {
        /// The raster's CRS.
        from: String,
        /// The CRS of the tiles.
        to: String,
        /// What GDAL says, shortened.
        reason: String,
    },
    /// There is no transformation of heights, most often since a grid of the geoid is missing.
    #[error("found no transformation of heights from {vertical} to ellipsoidal heights: PROJ has no grid for it here")]
    NoGrid {
        /// The vertical CRS.
        vertical: String,
        /// The definition that projinfo takes.
        from: String,
    },
    /// The definition of a vertical CRS is none.
    #[error("expected a vertical CRS such as EPSG:5773, found {found}: {reason}")]
    NotVertical {
        /// What was given.
        found: String,
        /// What GDAL says.
        reason: String,
    },
    /// Geoids of other bodies are not known.
    #[error("expected no vertical CRS on another body than the Earth, found {vertical}")]
    OtherBody {
        /// The vertical CRS.
        vertical: String,
    },
    /// The unit of heights is not known.
    #[error("expected heights in a unit of length, found {unit}")]
    Unit {
        /// What the band says.
        unit: String,
    },
}

/// How a raster's places and heights become longitude, latitude and ellipsoidal height. Any thread can use it: each makes
/// [`Ways`] of its own.
#[derive(Debug, Clone)]
pub struct Geodesy {
    /// The larger and the smaller half axis of the ellipsoid, in metres.
    pub radii: (f64, f64),
    /// Heights as the vertical CRS has them; empty where they are taken as ellipsoidal.
    pub vertical: String,
    /// Longitude and latitude, as WKT or a code.
    geographic: String,
    /// x and y of the raster, as WKT.
    horizontal: String,
    /// x, y and height of the raster, as WKT, where there is a vertical CRS.
    with_heights: Option<String>,
    /// What a stored height is multiplied with to become one of the vertical CRS, or metres above the ellipsoid.
    factor: f64,
    /// Whether x and y are longitude and latitude already.
    pub is_geographic: bool,
}

/// The transformations of one thread.
pub struct Ways {
    /// From longitude and latitude to x and y; `None` where they are the same.
    to_raster: Option<CoordTransform>,
    to_geographic: Option<CoordTransform>,
    heights: Option<CoordTransform>,
    factor: f64,
}

impl Raster {
    /// How this raster comes to longitude, latitude and ellipsoidal height. `vertical` names a vertical CRS for a raster
    /// that has none, or another than it has.
    ///
    /// # Errors
    /// [`GeodesyError`].
    pub fn geodesy(&self, vertical: Option<&str>) -> Result<Geodesy, GeodesyError> {
        let local = |found: &str| GeodesyError::Local { found: found.to_string() };
        if !self.is_georeferenced() {
            return Err(local("no geotransform"));
        }
        let crs = self.dataset.spatial_ref().map_err(|_| local("no CRS"))?;
        if !(crs.is_geographic() || crs.is_projected()) {
            return Err(local(&self.crs_name()));
        }
        let text = |crs: &SpatialRef| crs.to_wkt().map_err(|e| local(&reason(&e)));
        let horizontal = horizontal_part(&text(&crs)?);
        let flat = SpatialRef::from_wkt(&horizontal).map_err(|e| local(&reason(&e)))?;
        let axes = (flat.semi_major(), flat.semi_minor());
        let (Ok(semi_major), Ok(semi_minor)) = axes else { return Err(local("a CRS without an ellipsoid")) };
        let is_earth = EARTH_RADII.contains(&semi_major);
        let geographic = match is_earth {
            true => EARTH.to_string(),
            false => text(&flat.geog_cs().map_err(|e| local(&reason(&e)))?)?,
        };
        let radii = if is_earth { (6_378_137.0, 6_356_752.314_245_179) } else { (semi_major, semi_minor) };
        let reference = self.reference();
        let vertical_part = match vertical {
            Some(given) => Some(vertical_crs(given)?),
            None => part_of(&text(&crs)?, "VERT_CS"),
        };
        let unit = self.rasterband().map(|b| b.unit()).unwrap_or_default();
        let metres = match unit.as_str() {
            "" => None,
            unit => Some(metres_in(unit).ok_or_else(|| GeodesyError::Unit { unit: unit.to_string() })?),
        };
        let name = vertical.map_or(reference.vertical_crs, str::to_string);
        let (with_heights, factor) = match vertical_part {
            None => (None, metres.unwrap_or(1.0)),
            Some(_) if !is_earth => return Err(GeodesyError::OtherBody { vertical: name }),
            Some(part) => {
                let own = part_of(&part, "UNIT").and_then(|unit| unit.split(',').nth(1)?.parse::<f64>().ok());
                // A band that names no unit has that of its vertical CRS.
                let factor = metres.map_or(1.0, |metres| metres / own.unwrap_or(1.0));
                (Some(format!("COMPD_CS[\"raster\",{horizontal},{part}]")), factor)
            }
        };
        let vertical = if with_heights.is_some() { name } else { String::new() };
        let is_geographic = flat.is_geographic();
        let geodesy = Geodesy { radii, vertical, geographic, horizontal, with_heights, factor, is_geographic };
        geodesy.ways().map(|_| geodesy)
    }
}

impl Geodesy {
    /// Makes the transformations for one thread.
    ///
    /// # Errors
    /// [`GeodesyError::NoWay`], [`GeodesyError::NoGrid`].
    pub fn ways(&self) -> Result<Ways, GeodesyError> {
        let crs = |text: &str| SpatialRef::from_definition(text);
        let between = |from: &str, to: &str| transform(&crs(from)?, &crs(to)?);
        let no_way = |error: &gdal::errors::GdalError| GeodesyError::NoWay {
            from: name(&self.horizontal),
            to: name(&self.geographic),
            reason: reason(error).chars().take(200).collect(),
        };
        let to_raster = between(&self.geographic, &self.horizontal).map_err(|e| no_way(&e))?;
        let to_geographic = between(&self.horizontal, &self.geographic).map_err(|e| no_way(&e))?;
        let heights = match &self.with_heights {
            None => None,
            Some(from) => between(from, EARTH_WITH_HEIGHTS).map_err(|_| GeodesyError::NoGrid {
                vertical: self.vertical.clone(),
                from: codes(&self.horizontal, from),
            })?,
        };
        Ok(Ways { to_raster, to_geographic, heights, factor: self.factor })
    }
}

impl Ways {
    /// Longitudes and latitudes, in degrees, become x and y of the raster's map. What has no place there becomes infinite.
    pub fn to_raster(&self, x: &mut [f64], y: &mut [f64]) {
        along(self.to_raster.as_ref(), x, y, &mut []);
    }

    /// The other way round.
    pub fn to_geographic(&self, x: &mut [f64], y: &mut [f64]) {
        along(self.to_geographic.as_ref(), x, y, &mut []);
    }

    /// Whether the place counts where heights become ellipsoidal; else x and y may be empty.
    pub fn has_datum(&self) -> bool {
        self.heights.is_some()
    }

    /// Heights of the raster at x and y of its map become ellipsoidal, in metres; x and y are of no use afterwards. What has
    /// no height there, as it is beyond the grid of a geoid, becomes infinite.
    pub fn to_ellipsoidal(&self, x: &mut [f64], y: &mut [f64], heights: &mut [f64]) {
        heights.iter_mut().for_each(|height| *height *= self.factor);
        if let Some(transform) = &self.heights {
            along(Some(transform), x, y, heights);
        }
    }
}

/// Transforms all places. One that has no place in the other CRS becomes infinite, and does not touch others: PROJ reports
/// an error for all of them together, so they are tried one by one then.
fn along(transform: Option<&CoordTransform>, x: &mut [f64], y: &mut [f64], z: &mut [f64]) {
    let Some(transform) = transform else { return };
    let (x0, y0, z0) = (x.to_vec(), y.to_vec(), z.to_vec());
    if transform.transform_coords(x, y, z).is_ok() {
        return;
    }
    for i in 0..x.len() {
        let (mut one_x, mut one_y) = ([x0[i]], [y0[i]]);
        let mut one_z: Vec<f64> = z0.get(i).copied().into_iter().collect();
        let done = transform.transform_coords(&mut one_x, &mut one_y, &mut one_z).is_ok();
        (x[i], y[i]) = if done { (one_x[0], one_y[0]) } else { (f64::INFINITY, f64::INFINITY) };
        if let Some(height) = z.get_mut(i) {
            *height = if done { one_z[0] } else { f64::INFINITY };
        }
    }
}

/// A vertical CRS as WKT.
fn vertical_crs(given: &str) -> Result<String, GeodesyError> {
    let wrong = |reason: String| GeodesyError::NotVertical { found: given.to_string(), reason };
    let crs = SpatialRef::from_definition(given).map_err(|e| wrong(reason(&e)))?;
    if !crs.is_vertical() || crs.is_compound() {
        return Err(wrong("it is no vertical CRS".to_string()));
    }
    crs.to_wkt().map_err(|e| wrong(reason(&e)))
}

/// The first part of a WKT 1 text that has this keyword, with all its brackets.
fn part_of(wkt: &str, keyword: &str) -> Option<String> {
    let begin = wkt.find(&format!("{keyword}["))?;
    let (mut depth, mut quoted) = (0, false);
    for (at, byte) in wkt.bytes().enumerate().skip(begin) {
        match byte {
            b'"' => quoted = !quoted,
            b'[' if !quoted => depth += 1,
            b']' if !quoted => {
                depth -= 1;
                if depth == 0 {
                    return Some(wkt[begin..=at].to_string());
                }
            }
            _ => {}
        }
    }
    None
}

/// The horizontal part of a compound CRS; another one is its own.
fn horizontal_part(wkt: &str) -> String {
    if !wkt.starts_with("COMPD_CS[") {
        return wkt.to_string();
    }
    part_of(wkt, "PROJCS").or_else(|| part_of(wkt, "GEOGCS")).unwrap_or_else(|| wkt.to_string())
}

/// A compound CRS as `EPSG:HORIZONTAL+VERTICAL`, where both parts have a code; else its text.
fn codes(horizontal: &str, compound: &str) -> String {
    let code = |text: &str| SpatialRef::from_wkt(text).ok()?.auth_code().ok();
    let vertical = part_of(compound, "VERT_CS").and_then(|part| code(&part));
    match code(horizontal).zip(vertical) {
        Some((horizontal, vertical)) => format!("EPSG:{horizontal}+{vertical}"),
        None => compound.to_string(),
    }
}

/// What messages call a CRS.
fn name(definition: &str) -> String {
    match SpatialRef::from_definition(definition) {
        Ok(crs) => super::open::crs_name(&crs),
        Err(_) => definition.to_string(),
    }
}
