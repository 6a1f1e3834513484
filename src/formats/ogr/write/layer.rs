//! A layer of triangles in a file of GDAL's.

use std::path::{Path, PathBuf};

use gdal::errors::GdalError;
use gdal::spatial_ref::{AxisMappingStrategy, SpatialRef};
use gdal::vector::{Feature, FieldDefn, Geometry, LayerAccess, LayerOptions, OGRFieldType, OGRwkbGeometryType};
use gdal::{Dataset, DriverManager, Metadata};

use super::driver::{Driver, Settings};
use super::link::Link;
use super::wkb;
use crate::base::channels::{Channel, Number};
use crate::formats::joiner::Joined;
use crate::formats::{OgrGeometry, SinkError};
use crate::raster::{About, reason};

/// The layer's name.
const LAYER: &str = "tin";

/// The name of the layer of edges that follow lines, the second one.
const LINES: &str = "tin_breaklines";

/// Its field for types, where these are marked.
const TYPE: &str = "type";

/// The number of no layer.
const NO_LAYER: usize = 1 << 20;

/// The item of the layer's metadata that has the header.
const HEADER: &str = "terrabite";

/// The CRS of coordinates that are no CRS's, or of one that is not told. Without any a GeoPackage says that they are degrees.
const NO_CRS: &str = "ENGCRS[\"Undefined Cartesian SRS\",EDATUM[\"Unknown\"],CS[Cartesian,2],AXIS[\"easting\",east],\
    AXIS[\"northing\",north],LENGTHUNIT[\"metre\",1]]";

/// What a layer is to be.
pub(super) struct Plan<'a> {
    pub(super) driver: &'static Driver,
    pub(super) geometry: OgrGeometry,
    pub(super) attributes: &'a [Channel],
    /// The definition of the CRS of the coordinates, if there is one.
    pub(super) crs: Option<&'a str>,
    /// What the file says of itself.
    pub(super) header: String,
    /// Whether there are edges that follow lines.
    pub(super) has_lines: bool,
    /// Whether these have a field that says of what type they are.
    pub(super) lines_have_types: bool,
}

/// The file that GDAL has open. Dropped, it is closed, complete or not.
#[derive(Debug)]
pub(super) struct TinLayer {
    dataset: Dataset,
    link: Link,
    /// What the user calls the file.
    path: PathBuf,
    driver: &'static Driver,
    geometry: OgrGeometry,
    numbers: Vec<Number>,
    features: u64,
    /// `None` without a layer for them.
    lines: Option<u64>,
    lines_have_types: bool,
    wkb: Vec<u8>,
}

impl TinLayer {
    /// Creates the file behind `link`, which is not there yet.
    pub(super) fn create(link: Link, path: &Path, plan: &Plan<'_>) -> Result<TinLayer, SinkError> {
        let Plan { driver, geometry, attributes, .. } = *plan;
        let _about = About::opening(path);
        let _settings = Settings::of(driver);
        let failed = |error| library(path, &reason(&error));
        let kind = DriverManager::get_driver_by_name(driver.name).map_err(failed)?;
        let mut dataset = kind.create_vector_only(link.path()).map_err(failed)?;
        fill_in(&mut dataset, plan).map_err(failed)?;
        let numbers = attributes.iter().map(|attribute| attribute.number).collect();
        Ok(TinLayer {
            dataset,
            link,
            path: path.to_path_buf(),
            driver,
            geometry,
            numbers,
            features: 0,
            lines: plan.has_lines.then_some(0),
            lines_have_types: plan.lines_have_types,
            wkb: Vec::new(),
        })
    }

    /// Writes triangles: polygons, each a feature; or TINs of so many triangles. Each triangle has its values corner by
    /// corner.
    pub(super) fn write(
        &mut self,
        triangles: &[[[f64; 3]; 3]],
        values: &[f64],
        of_tin: usize,
    ) -> Result<(), SinkError> {
        let _about = About::reading(&self.path);
        let _settings = Settings::of(self.driver);
        let written = if self.driver.has_transactions {
            let transaction = self.dataset.start_transaction();
            let mut features = Features { geometry: self.geometry, numbers: &self.numbers, wkb: &mut self.wkb };
            transaction.and_then(|transaction| {
                let written = features.write(&transaction, triangles, values, of_tin)?;
                transaction.commit()?;
                Ok(written)
            })
        } else {
            let mut features = Features { geometry: self.geometry, numbers: &self.numbers, wkb: &mut self.wkb };
            features.write(&self.dataset, triangles, values, of_tin)
        };
        self.features += written.map_err(|error| library(&self.path, &said(&self.dataset, &error)))?;
        Ok(())
    }

    /// Writes lines, each a feature of the second layer.
    pub(super) fn write_lines(&mut self, lines: &[Joined]) -> Result<(), SinkError> {
        let _about = About::reading(&self.path);
        let _settings = Settings::of(self.driver);
        let wkb = &mut self.wkb;
        let written = self.dataset.start_transaction().and_then(|transaction| {
            let layer = transaction.layer(1)?;
            for (points, line_type) in lines {
                let mut feature = Feature::new(layer.defn())?;
                if self.lines_have_types {
                    feature.set_field_string(0, line_type.name())?;
                }
                wkb::line(wkb, points);
                feature.set_geometry(Geometry::from_wkb(wkb)?)?;
                feature.create(&layer)?;
            }
            transaction.commit()
        });
        written.map_err(|error| library(&self.path, &said(&self.dataset, &error)))?;
        *self.lines.as_mut().expect("a layer for them") += lines.len() as u64;
        Ok(())
    }

    /// Closes the file and makes sure that everything is in it: GDAL before 3.7 says nothing of what fails then.
    pub(super) fn close(self) -> Result<(), SinkError> {
        let TinLayer { mut dataset, link, path, driver, features, lines, .. } = self;
        let _about = About::reading(&path);
        let _settings = Settings::of(driver);
        let failed = |error| library(&path, &reason(&error));
        dataset.flush_cache().and_then(|()| dataset.close()).map_err(failed)?;
        let found = Dataset::open(link.path()).and_then(|dataset| {
            let layer = dataset.layer(0)?;
            let found_lines = lines.map(|_| dataset.layer(1).map(|layer| layer.feature_count())).transpose()?;
            Ok(((layer.feature_count(), found_lines), layer.metadata_item(HEADER, "").is_some()))
        });
        let (found, has_header) = found.map_err(failed)?;
        let has_end = (driver.has_end)(link.path(), features).map_err(|e| library(&path, &e.to_string()))?;
        if found != (features, lines) || has_header != driver.keeps_header || !has_end {
            return Err(library(&path, "GDAL has not written all of it: a full disk, most often"));
        }
        Ok(())
    }
}

/// Makes the layer with its fields and its header.
fn fill_in(dataset: &mut Dataset, plan: &Plan<'_>) -> gdal::errors::Result<()> {
    let srs = plan.crs.and_then(spatial_ref).or_else(|| spatial_ref(NO_CRS).filter(|_| plan.driver.needs_crs));
    let mut layer = dataset.create_layer(LayerOptions {
        name: LAYER,
        srs: srs.as_ref(),
        ty: match plan.geometry {
            OgrGeometry::Polygon => OGRwkbGeometryType::wkbPolygon25D,
            OgrGeometry::Tin => OGRwkbGeometryType::wkbTINZ,
        },
        options: Some(plan.driver.layer_options),
    })?;
    for Channel { name, number } in plan.attributes {
        let kind = match number {
            Number::U8 => OGRFieldType::OFTInteger,
            Number::F32 | Number::F64 => OGRFieldType::OFTReal,
        };
        for corner in 1..=3 {
            FieldDefn::new(&format!("{name}_{corner}"), kind)?.add_to_layer(&layer)?;
        }
    }
    if plan.driver.keeps_header {
        layer.set_metadata_item(HEADER, &plan.header, "")?;
    }
    if plan.has_lines {
        // GDAL makes tables where they are needed first: that of the triangles is to come before the other.
        dataset.flush_cache()?;
        let lines = dataset.create_layer(LayerOptions {
            name: LINES,
            srs: srs.as_ref(),
            ty: OGRwkbGeometryType::wkbLineString25D,
            options: Some(plan.driver.layer_options),
        })?;
        if plan.lines_have_types {
            FieldDefn::new(TYPE, OGRFieldType::OFTString)?.add_to_layer(&lines)?;
        }
    }
    Ok(())
}

/// How features are made.
struct Features<'a> {
    geometry: OgrGeometry,
    numbers: &'a [Number],
    wkb: &'a mut Vec<u8>,
}

impl Features<'_> {
    /// Returns how many there are.
    fn write(
        &mut self,
        dataset: &Dataset,
        triangles: &[[[f64; 3]; 3]],
        values: &[f64],
        of_tin: usize,
    ) -> gdal::errors::Result<u64> {
        let layer = dataset.layer(0)?;
        let of_feature = match self.geometry {
            OgrGeometry::Polygon => 1,
            OgrGeometry::Tin => of_tin,
        };
        let mut written = 0;
        let mut values = values.chunks(3 * self.numbers.len().max(1));
        for triangles in triangles.chunks(of_feature) {
            let mut feature = Feature::new(layer.defn())?;
            match self.geometry {
                OgrGeometry::Polygon => wkb::polygon(self.wkb, &triangles[0]),
                OgrGeometry::Tin => wkb::tin(self.wkb, triangles),
            }
            feature.set_geometry(Geometry::from_wkb(self.wkb)?)?;
            if let Some(values) = values.next() {
                self.set(&mut feature, values)?;
            }
            feature.create(&layer)?;
            written += 1;
        }
        Ok(written)
    }

    fn set(&self, feature: &mut Feature<'_>, values: &[f64]) -> gdal::errors::Result<()> {
        for (attribute, number) in self.numbers.iter().enumerate() {
            for corner in 0..3 {
                let (field, value) = (3 * attribute + corner, values[corner * self.numbers.len() + attribute]);
                match number {
                    Number::U8 => feature.set_field_integer(field, value as i32)?,
                    // SQLite has no -0; nor has any other of these files, so that they say the same.
                    Number::F32 | Number::F64 => feature.set_field_double(field, value + 0.0)?,
                }
            }
        }
        Ok(())
    }
}

/// GDAL's words for a failure. Where the bindings give a code alone, they give the message with the next null pointer.
fn said(dataset: &Dataset, error: &GdalError) -> String {
    match (error, dataset.layer(NO_LAYER).err()) {
        (GdalError::OgrError { .. }, Some(GdalError::NullPointer { msg, .. })) if !msg.trim().is_empty() => msg,
        _ => reason(error),
    }
}

fn library(path: &Path, message: &str) -> SinkError {
    SinkError::Library { path: path.to_path_buf(), message: message.to_string() }
}

/// The CRS of a definition: an authority's code or WKT. GDAL would take other texts for names of files or addresses. `None` for
/// what it does not understand: a layer without a CRS.
fn spatial_ref(definition: &str) -> Option<SpatialRef> {
    let is_word = |text: &str| !text.is_empty() && text.chars().all(|c| c.is_ascii_alphanumeric() || "_.".contains(c));
    let is_code = definition.split_once(':').is_some_and(|(authority, code)| is_word(authority) && is_word(code));
    let is_wkt = definition.trim_end().ends_with([']', ')']);
    let mut crs = match (is_code, is_wkt) {
        (true, _) => SpatialRef::from_definition(definition),
        (_, true) => SpatialRef::from_wkt(definition),
        _ => return None,
    }
    .ok()?;
    crs.set_axis_mapping_strategy(AxisMappingStrategy::TraditionalGisOrder);
    Some(crs)
}
