//! The layer of a file that has the mesh.

use std::fs::File;
use std::io::Read;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use gdal::vector::{Feature, Layer, LayerAccess, OGRFieldType, OGRwkbGeometryType};
use gdal::{Dataset, DatasetOptions, GdalOpenFlags, Metadata};

use super::wkb::{self, Corners};
use super::{OgrError, facts};
use crate::base::LineType;
use crate::base::channels::{Channel, Number};
use crate::base::control::CancelToken;
use crate::formats::{Crs, Header};
use crate::raster::{About, GdalName, reason};

/// Features, or triangles, between two looks at the cancellation token.
const BETWEEN_CHECKS: u64 = 1024;

/// Is handed a feature and its triangles; those of a large one come some at a time.
type FeatureVisitor<'a> = dyn FnMut(&Feature<'_>, &[Corners]) -> Result<ControlFlow<()>, OgrError> + 'a;

/// A file that GDAL has open for reading, and which of its layers is the mesh.
#[derive(Debug)]
pub(super) struct MeshLayer {
    path: PathBuf,
    dataset: Dataset,
    _name: GdalName,
    index: usize,
    /// The layer of edges that follow lines, in a file of terrabite's.
    lines: Option<usize>,
    cancel: CancelToken,
}

/// What terrabite calls that layer.
const LINES: &str = "tin_breaklines";

/// The field of it that says of what type lines are, where it is there.
const TYPE: &str = "type";

/// The drivers for a file without a mark: those that read nothing but the file.
const DRIVERS: &[&str] =
    &["GPKG", "FlatGeobuf", "SQLite", "ESRI Shapefile", "GeoJSON", "GeoJSONSeq", "CSV", "GML", "DXF"];

impl MeshLayer {
    pub(super) fn open(path: &Path, cancel: &CancelToken) -> Result<MeshLayer, OgrError> {
        let io = |source| OgrError::Io { path: path.to_path_buf(), source };
        let is_file = path.metadata().map_err(io)?.is_file();
        let drivers = if is_file { marked(path, &beginning(path).map_err(io)?)? } else { None };
        let _about = About::opening(path);
        let failed = |reason| OgrError::Open { path: path.to_path_buf(), reason };
        let name = GdalName::of(path).map_err(|e| failed(format!("its name is no UTF-8, and no link to it: {e}")))?;
        let options = DatasetOptions {
            open_flags: GdalOpenFlags::GDAL_OF_READONLY
                | GdalOpenFlags::GDAL_OF_VECTOR
                | GdalOpenFlags::GDAL_OF_VERBOSE_ERROR,
            allowed_drivers: drivers.or(Some(DRIVERS)),
            ..DatasetOptions::default()
        };
        let dataset = Dataset::open_ex(name.path(), options)
            .map_err(|e| failed(reason(&e).trim_start_matches(&format!("{}: ", name.path().display())).to_string()))?;
        let (index, lines) = only(path, &dataset)?;
        Ok(MeshLayer { path: path.to_path_buf(), dataset, _name: name, index, lines, cancel: cancel.clone() })
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    pub(super) fn layer(&self) -> Result<Layer<'_>, OgrError> {
        let failed = |e| OgrError::Open { path: self.path.clone(), reason: reason(&e) };
        self.dataset.layer(self.index).map_err(failed)
    }

    /// What the layer itself says: its CRS.
    pub(super) fn header(&self) -> Result<Header, OgrError> {
        let Some(crs) = self.layer()?.spatial_ref() else { return Ok(Header::default()) };
        let code = crs.auth_name().zip(crs.auth_code().ok()).map(|(authority, code)| format!("{authority}:{code}"));
        let name = crs.name().unwrap_or_default();
        // What GDAL makes of a file that has none.
        if name.starts_with("Undefined ") {
            return Ok(Header::default());
        }
        let named = code.as_ref().map_or(name.clone(), |code| format!("{code} ({name})"));
        let definition = code.or_else(|| crs.to_wkt().ok());
        Ok(Header { crs: Crs { definition, name: Some(named), ..Crs::default() }, ..Header::default() })
    }

    /// Numbers that a feature has for each of its corners: fields `NAME_1`, `NAME_2` and `NAME_3`.
    pub(super) fn attributes(&self) -> Result<Vec<Channel>, OgrError> {
        let numbers = [OGRFieldType::OFTInteger, OGRFieldType::OFTInteger64, OGRFieldType::OFTReal];
        let layer = self.layer()?;
        let fields = layer.defn().fields().filter(|field| numbers.contains(&field.field_type()));
        let names: Vec<String> = fields.map(|field| field.name()).collect();
        let is_there = |name: &str, corner: u8| names.iter().any(|n| *n == format!("{name}_{corner}"));
        let candidates = names.iter().filter_map(|name| name.strip_suffix("_1"));
        let attributes =
            candidates.filter(|name| !["x", "y", "z"].contains(name) && is_there(name, 2) && is_there(name, 3));
        Ok(attributes.map(|name| Channel { name: name.to_string(), number: Number::F64 }).collect())
    }

    /// Which fields an attribute is.
    pub(super) fn fields(&self, attribute: &str) -> Result<[usize; 3], OgrError> {
        let layer = self.layer()?;
        let names: Vec<String> = layer.defn().fields().map(|field| field.name()).collect();
        let mut fields = [0; 3];
        for (field, corner) in fields.iter_mut().zip(1..) {
            let name = format!("{attribute}_{corner}");
            *field = names.iter().position(|n| *n == name).ok_or_else(|| OgrError::Header {
                path: self.path.clone(),
                expected: "attributes that are fields".to_string(),
                found: name,
            })?;
        }
        Ok(fields)
    }

    /// Hands every feature with its triangles to `visit`, until it breaks. Returns how many features there are.
    pub(super) fn for_each_feature(&self, visit: &mut FeatureVisitor<'_>) -> Result<u64, OgrError> {
        let _about = About::reading(&self.path);
        let mut layer = self.layer()?;
        layer.reset_feature_reading();
        let (mut count, mut triangles) = (0, Vec::new());
        for feature in layer.features() {
            if count % BETWEEN_CHECKS == 0 {
                self.cancel.check()?;
            }
            triangles.clear();
            self.triangles(&feature, count, &mut triangles)?;
            count += 1;
            for triangles in triangles.chunks(BETWEEN_CHECKS as usize) {
                if triangles.len() > 1 {
                    self.cancel.check()?;
                }
                if visit(&feature, triangles)?.is_break() {
                    return Ok(count);
                }
            }
        }
        Ok(count)
    }

    /// Whether lines of the other layer have types.
    pub(super) fn lines_have_types(&self) -> bool {
        let layer = self.lines.and_then(|lines| self.dataset.layer(lines).ok());
        layer.is_some_and(|layer| layer.defn().field_index(TYPE).is_ok())
    }

    /// Hands the points of every line of the other layer, and its type, to `visit`.
    pub(super) fn for_each_line(
        &self,
        mut visit: impl FnMut(&[[f64; 3]], LineType) -> Result<(), OgrError>,
    ) -> Result<(), OgrError> {
        let Some(lines) = self.lines else { return Ok(()) };
        let _about = About::reading(&self.path);
        let failed = |e| OgrError::Open { path: self.path.clone(), reason: reason(&e) };
        let have_types = self.lines_have_types();
        let mut layer = self.dataset.layer(lines).map_err(failed)?;
        for (index, feature) in (0..).zip(layer.features()) {
            if index % BETWEEN_CHECKS == 0 {
                self.cancel.check()?;
            }
            let expected = "a line with heights";
            let line_type = if have_types { self.line_type(&feature, index)? } else { LineType::Hard };
            visit(&self.parsed(&feature, index, expected, wkb::line)?, line_type)?;
        }
        Ok(())
    }

    fn line_type(&self, feature: &Feature<'_>, index: u64) -> Result<LineType, OgrError> {
        let text = feature.field_index(TYPE).and_then(|field| feature.field_as_string(field)).ok().flatten();
        text.as_deref().and_then(LineType::from_name).ok_or_else(|| OgrError::Feature {
            path: self.path.clone(),
            feature: feature.fid().unwrap_or(index),
            expected: format!("the text hard or soft in field {TYPE}"),
            found: text.map_or("nothing".to_string(), |text| format!("the text {text:?}")),
        })
    }

    fn triangles(&self, feature: &Feature<'_>, index: u64, triangles: &mut Vec<Corners>) -> Result<(), OgrError> {
        self.parsed(feature, index, "triangles with heights", |wkb| wkb::triangles(wkb, triangles))
    }

    /// What a geometry is in well-known binary.
    fn parsed<T>(
        &self,
        feature: &Feature<'_>,
        index: u64,
        expected: &str,
        parse: impl FnOnce(&[u8]) -> Result<T, String>,
    ) -> Result<T, OgrError> {
        let geometry = feature.geometry_by_index(0).map_err(|_| "no geometry".to_string());
        let wkb = geometry.and_then(|geometry| geometry.iso_wkb().map_err(|e| reason(&e)));
        wkb.and_then(|wkb| parse(&wkb)).map_err(|found| OgrError::Feature {
            path: self.path.clone(),
            feature: feature.fid().unwrap_or(index),
            expected: expected.to_string(),
            found,
        })
    }
}

fn beginning(path: &Path) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    File::open(path)?.take(100).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// The drivers for a file that bears a mark, whatever it is called. A database without its end is refused: SQLite takes what is
/// missing of the last page for zeros.
fn marked(path: &Path, beginning: &[u8]) -> Result<Option<&'static [&'static str]>, OgrError> {
    if beginning.starts_with(b"fgb") {
        return Ok(Some(&["FlatGeobuf"]));
    }
    if !beginning.starts_with(b"SQLite format 3\0") || beginning.len() < 100 {
        return Ok(None);
    }
    let number = |at: usize| u64::from(u32::from_be_bytes([0, 1, 2, 3].map(|i| beginning[at + i])));
    let page = match u64::from(u16::from_be_bytes([beginning[16], beginning[17]])) {
        1 => 1 << 16,
        bytes => bytes,
    };
    // The count of pages counts where the same program has written both numbers of changes, and none waits in another file.
    let is_counted = number(24) == number(92) && beginning[18..20] == [1, 1];
    let found = path.metadata().map_err(|source| OgrError::Io { path: path.to_path_buf(), source })?.len();
    let expected = page * number(28);
    if is_counted && found < expected {
        return Err(OgrError::Truncated { path: path.to_path_buf(), expected, found });
    }
    let is_package = [b"GPKG", b"GP10", b"GP11"].iter().any(|mark| beginning[68..72] == **mark);
    Ok(is_package.then_some(&["GPKG"]))
}

/// The number of the only layer with geometry; with it that of the edges that follow lines, if terrabite has written both.
fn only(path: &Path, dataset: &Dataset) -> Result<(usize, Option<usize>), OgrError> {
    let (mut layers, mut lines, mut is_ours) = (Vec::new(), None, false);
    for (index, layer) in dataset.layers().enumerate() {
        if layer.defn().geometry_type() != OGRwkbGeometryType::wkbNone {
            layers.push((index, layer.name()));
            lines = lines.or((layer.name() == LINES).then_some(index));
            is_ours |= layer.metadata_item(facts::ITEM, "").is_some();
        }
    }
    if let Some(lines) = lines.filter(|_| is_ours && layers.len() == 2) {
        let mesh = layers.iter().find(|(index, _)| *index != lines).expect("two layers");
        return Ok((mesh.0, Some(lines)));
    }
    match layers.as_slice() {
        [(index, _)] => Ok((*index, None)),
        [] => Err(OgrError::Layers { path: path.to_path_buf(), found: "none".to_string() }),
        several => {
            let names: Vec<&str> = several.iter().map(|(_, name)| name.as_str()).collect();
            Err(OgrError::Layers { path: path.to_path_buf(), found: names.join(", ") })
        }
    }
}
