//! Lines of a vector layer, in columns and rows of a raster.

use std::path::{Path, PathBuf};

use gdal::vector::{Feature, FieldValue, Geometry, OGRwkbGeometryType, geometry_type_flatten, geometry_type_has_z};

use super::Raster;
use super::shapes::{Placer, ShapesError, for_each_geometry};
use crate::base::control::CancelToken;
use crate::base::external::Scratch;
use crate::base::plainly::Plainly;
use crate::base::{LineWriter, Polylines};

/// Where lines come from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LineSource {
    /// A file, or any name OGR opens.
    pub path: PathBuf,
    /// The layer; the first where none is named.
    pub layer: Option<String>,
}

/// Reads a layer of lines (LineString or MultiLineString; m is ignored, and z, unless lines are to be `with_heights`) and brings them to
/// the samples of `raster`, or of the window of it that is looked at. An empty line is one without vertices; features without geometry
/// are counted.
///
/// Vertices are transformed to the raster's CRS where both have one, and lines that are bent there are given further ones, a tenth
/// of a cell exact; where one has none, coordinates are taken as they are. Heights always are.
///
/// Memory: 32 bytes per vertex of a line, and of all that are held `in_memory`; and what OGR's driver takes.
///
/// # Errors
/// [`ShapesError`]: nothing to open, no such layer, a feature that is no line, or has no heights where there should be some, a CRS there
/// is no way from.
pub fn read_lines(
    raster: &Raster,
    source: &LineSource,
    with_heights: bool,
    in_memory: &LineMemory,
    cancel: &CancelToken,
) -> Result<Polylines, ShapesError> {
    let from = (source.path.as_path(), source.layer.as_deref());
    let what = if with_heights { ("lines", "a line or lines with heights") } else { ("lines", "a line or lines") };
    let take = |placer: &Placer, geometry: &Geometry, (id, _): (u64, &Feature<'_>), found: &mut Vec<Line>| {
        lines(placer, geometry, id, with_heights, found)
    };
    read(raster, from, what, (with_heights, in_memory), cancel, take)
}

/// Reads a layer of lines as [`read_lines`] does, each feature of which says in a text field whether its heights count: `raster` or
/// `line`. Gives those of which they do not, then those of which they do.
///
/// # Errors
/// [`ShapesError`], as [`read_lines`]; and a feature that has something else in the field, or no such field.
pub fn read_lines_by_field(
    raster: &Raster,
    source: &LineSource,
    field: &str,
    in_memory: &LineMemory,
    cancel: &CancelToken,
) -> Result<[Polylines; 2], ShapesError> {
    let from = (source.path.as_path(), source.layer.as_deref());
    let one = format!("a line or lines with the text raster or line in field {field}");
    let take = |placer: &Placer, geometry: &Geometry, (id, feature): (u64, &Feature<'_>), found: &mut Vec<Line>| {
        lines(placer, geometry, id, has_own_heights(feature, field)?, found)
    };
    let scratch = Scratch::new(in_memory.temp_dir.as_deref(), cancel.clone());
    let mut writers =
        [false, true].map(|with_heights| LineWriter::new(scratch.clone(), with_heights, in_memory.vertices / 2));
    let keep = |line: Line| {
        let writer = &mut writers[usize::from(line.with_heights)];
        Ok(writer.push(line.feature, line.vertices, line.heights)?)
    };
    let without_geometry = for_each_geometry(raster, from, ("lines", &one), cancel, take, keep)?;
    let [of_raster, own] = writers;
    Ok([of_raster.finish()?.beside(without_geometry), own.finish()?])
}

/// Whether a feature says that its own heights count.
fn has_own_heights(feature: &Feature<'_>, field: &str) -> Result<bool, String> {
    match value(feature, field)? {
        Some(FieldValue::StringValue(text)) if text == "raster" => Ok(false),
        Some(FieldValue::StringValue(text)) if text == "line" => Ok(true),
        Some(FieldValue::StringValue(text)) => Err(format!("the text {text:?} in field {field}")),
        None => Err(format!("nothing in field {field}")),
        Some(_) => Err(format!("a field {field} of numbers, not of text")),
    }
}

/// What a feature has in a field.
fn value(feature: &Feature<'_>, field: &str) -> Result<Option<FieldValue>, String> {
    let index = feature.field_index(field).map_err(|_| {
        let mut names: Vec<String> = feature.fields().map(|(name, _)| name).collect();
        names.sort_unstable();
        format!("no field {field} among {}", if names.is_empty() { "none".to_string() } else { names.join(", ") })
    })?;
    feature.field(index).map_err(|_| format!("nothing that can be read in field {field}"))
}

/// Reads the outlines of a layer of polygons (Polygon or MultiPolygon; z and m are ignored), holes among them, as [`read_lines`] reads
/// lines. Each is closed. With a `field`, heights are its numbers.
///
/// # Errors
/// [`ShapesError`]: nothing to open, no such layer, a feature that is no polygon, or has no number in the field, a CRS there is no way
/// from.
pub fn read_outlines(
    raster: &Raster,
    source: &LineSource,
    field: Option<&str>,
    in_memory: &LineMemory,
    cancel: &CancelToken,
) -> Result<Polylines, ShapesError> {
    let from = (source.path.as_path(), source.layer.as_deref());
    let take = |placer: &Placer, geometry: &Geometry, (id, feature): (u64, &Feature<'_>), found: &mut Vec<Line>| {
        let height = field.map_or(Ok(0.0), |field| number(feature, field))?;
        outlines(placer, geometry, (id, height), found)
    };
    let one =
        field.map_or("a polygon or polygons".to_string(), |field| format!("polygons with numbers in field {field}"));
    read(raster, from, ("polygons", &one), (field.is_some(), in_memory), cancel, take)
}

/// The number that a feature has in a field.
fn number(feature: &Feature<'_>, field: &str) -> Result<f64, String> {
    match value(feature, field)? {
        Some(FieldValue::IntegerValue(whole)) => Ok(f64::from(whole)),
        Some(FieldValue::Integer64Value(whole)) => Ok(whole as f64),
        Some(FieldValue::RealValue(number)) if number.is_finite() => Ok(number),
        Some(FieldValue::RealValue(number)) => Err(format!("{number} in field {field}")),
        Some(FieldValue::StringValue(text)) => Err(format!("the text {text:?} in field {field}")),
        None => Err(format!("nothing in field {field}")),
        Some(_) => Err(format!("no number in field {field}")),
    }
}

fn outlines(
    placer: &Placer,
    geometry: &Geometry,
    (feature, height): (u64, f64),
    found: &mut Vec<Line>,
) -> Result<(), String> {
    let parts = || (0..geometry.geometry_count()).map(|i| geometry.get_geometry(i));
    match geometry_type_flatten(geometry.geometry_type()) {
        OGRwkbGeometryType::wkbMultiPolygon => {
            parts().try_for_each(|part| outlines(placer, &part, (feature, height), found))
        }
        OGRwkbGeometryType::wkbPolygon => parts().try_for_each(|ring| {
            let mut vertices = placer.vertices(&ring)?;
            if let Some(&first) = vertices.first().filter(|first| vertices.last() != Some(first)) {
                vertices.push(first);
            }
            let heights = vec![height; vertices.len()];
            found.push(Line { feature, vertices, heights, with_heights: true });
            Ok(())
        }),
        _ => Err(geometry.geometry_name()),
    }
}

/// A line of a feature.
#[derive(Debug)]
struct Line {
    feature: u64,
    vertices: Vec<(f64, f64)>,
    heights: Vec<f64>,
    /// Whether its heights count.
    with_heights: bool,
}

/// What holds lines in memory up to a number of vertices, and in a temporary file beyond that.
#[derive(Debug, Clone)]
pub struct LineMemory {
    /// Where temporary files are made; the system's folder where none is named.
    pub temp_dir: Option<PathBuf>,
    /// The most vertices in memory.
    pub vertices: usize,
}

fn read(
    raster: &Raster,
    from: (&Path, Option<&str>),
    what: (&'static str, &str),
    (with_heights, memory): (bool, &LineMemory),
    cancel: &CancelToken,
    take: impl Fn(&Placer, &Geometry, (u64, &Feature<'_>), &mut Vec<Line>) -> Result<(), String>,
) -> Result<Polylines, ShapesError> {
    let scratch = Scratch::new(memory.temp_dir.as_deref(), cancel.clone());
    let mut writer = LineWriter::new(scratch, with_heights, memory.vertices);
    let keep = |line: Line| Ok(writer.push(line.feature, line.vertices, line.heights)?);
    let without_geometry = for_each_geometry(raster, from, what, cancel, take, keep)?;
    Ok(writer.finish()?.beside(without_geometry))
}

fn lines(
    placer: &Placer,
    geometry: &Geometry,
    feature: u64,
    with_heights: bool,
    found: &mut Vec<Line>,
) -> Result<(), String> {
    let kind = geometry.geometry_type();
    let flat = geometry_type_flatten(kind);
    if flat == OGRwkbGeometryType::wkbMultiLineString {
        let mut parts = (0..geometry.geometry_count()).map(|i| geometry.get_geometry(i));
        return parts.try_for_each(|part| lines(placer, &part, feature, with_heights, found));
    }
    if flat != OGRwkbGeometryType::wkbLineString {
        return Err(geometry.geometry_name());
    }
    if with_heights && !geometry_type_has_z(kind) && !geometry.is_empty() {
        return Err(format!("{} without heights (2-D)", geometry.geometry_name()));
    }
    let (vertices, heights) = placer.vertices_with_heights(geometry)?;
    if let Some(height) = heights.iter().find(|height| with_heights && !height.is_finite()) {
        return Err(format!("a vertex with the height {}", Plainly(*height)));
    }
    found.push(Line { feature, vertices, heights, with_heights });
    Ok(())
}
