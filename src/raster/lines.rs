//! Lines of a vector layer, in columns and rows of a raster.

use std::collections::BTreeMap;
use std::path::PathBuf;

use gdal::vector::{Feature, Geometry, OGRwkbGeometryType, geometry_type_flatten, geometry_type_has_z};

use super::Raster;
use super::line_fields::{Said, has_own_heights, number, type_of};
use super::shapes::{Placer, ShapesError, Wrong, for_each_geometry};
use crate::base::control::CancelToken;
use crate::base::external::Scratch;
use crate::base::plainly::Plainly;
use crate::base::{LineType, LineWriter, Polylines};

/// Where lines come from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LineSource {
    /// A file, or any name OGR opens.
    pub path: PathBuf,
    /// The layer; the first where none is named.
    pub layer: Option<String>,
}

/// What is asked of the features of a layer of lines.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LineAsk {
    /// Whether lines are to have heights of their own, which they then need.
    pub with_heights: Said<bool>,
    /// Of what type lines are.
    pub types: Said<LineType>,
}

/// Reads a layer of lines (LineString or MultiLineString; m is ignored, and z of lines without heights of their own) and brings them to
/// the samples of `raster`, or of the window of it that is looked at. Gives those of each type, with heights of their own and without, as
/// far as there are some: at least one. An empty line is one without vertices; features without geometry are counted, with the first.
///
/// Vertices are transformed to the raster's CRS where both have one, and lines that are bent there are given further ones, a tenth
/// of a cell exact; where one has none, coordinates are taken as they are. Heights always are.
///
/// Memory: 32 bytes per vertex of a line, and of all that are held `in_memory`; and what OGR's driver takes.
///
/// # Errors
/// [`ShapesError`]: nothing to open, no such layer, a feature that is no line, or has no heights where there should be some, or nothing
/// of what is expected in a field; a CRS there is no way from.
pub fn read_lines(
    raster: &Raster,
    source: &LineSource,
    ask: &LineAsk,
    in_memory: &LineMemory,
    cancel: &CancelToken,
) -> Result<Vec<Polylines>, ShapesError> {
    let from = (source.path.as_path(), source.layer.as_deref());
    let take = |placer: &Placer, geometry: &Geometry, of: (u64, &Feature<'_>), found: &mut Vec<Line>| {
        let of_lines = OfLines {
            feature: of.0,
            with_heights: has_own_heights(&ask.with_heights, of)?,
            line_type: type_of(&ask.types, of)?,
            says_line: match &ask.with_heights {
                Said::Of(_) => None,
                Said::Field(name) => Some(name),
            },
        };
        lines(placer, geometry, of_lines, found)
    };
    let scratch = Scratch::new(in_memory.temp_dir.as_deref(), cancel.clone());
    let groups = [ask.with_heights.is_of_each(), ask.types.is_of_each()].map(|is_of_each| 1 + usize::from(is_of_each));
    let most = in_memory.vertices / groups.iter().product::<usize>();
    let mut writers: BTreeMap<(LineType, bool), LineWriter> = BTreeMap::new();
    let keep = |line: Line| {
        let new = || LineWriter::new(scratch.clone(), line.with_heights, most);
        let writer = writers.entry((line.line_type, line.with_heights)).or_insert_with(new);
        Ok(writer.push(line.feature, line.vertices, line.heights)?)
    };
    let without_geometry = for_each_geometry(raster, from, ("lines", "a line or lines"), cancel, take, keep)?;
    let finish = |((line_type, _), writer): ((LineType, bool), LineWriter)| Ok(writer.finish()?.of_type(line_type));
    let mut all = writers.into_iter().map(finish).collect::<Result<Vec<Polylines>, ShapesError>>()?;
    if let Some(first) = all.first_mut() {
        *first = std::mem::take(first).beside(without_geometry);
    }
    Ok(all)
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
    let take = |placer: &Placer, geometry: &Geometry, of: (u64, &Feature<'_>), found: &mut Vec<Line>| {
        let height = field.map_or(Ok(0.0), |field| number(field, of))?;
        Ok::<(), Wrong>(outlines(placer, geometry, (of.0, height), found)?)
    };
    let scratch = Scratch::new(in_memory.temp_dir.as_deref(), cancel.clone());
    let mut writer = LineWriter::new(scratch, field.is_some(), in_memory.vertices);
    let keep = |line: Line| Ok(writer.push(line.feature, line.vertices, line.heights)?);
    let without_geometry = for_each_geometry(raster, from, ("polygons", "a polygon or polygons"), cancel, take, keep)?;
    Ok(writer.finish()?.beside(without_geometry))
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
            found.push(Line { feature, vertices, heights, with_heights: true, line_type: LineType::Hard });
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
    line_type: LineType,
}

/// What holds lines in memory up to a number of vertices, and in a temporary file beyond that.
#[derive(Debug, Clone)]
pub struct LineMemory {
    /// Where temporary files are made; the system's folder where none is named.
    pub temp_dir: Option<PathBuf>,
    /// The most vertices in memory.
    pub vertices: usize,
}

/// What is known of the lines of a feature.
#[derive(Clone, Copy)]
struct OfLines<'a> {
    feature: u64,
    with_heights: bool,
    line_type: LineType,
    /// The field that says so of its heights, if it is one.
    says_line: Option<&'a str>,
}

impl OfLines<'_> {
    /// Heights are expected.
    fn without_heights(&self, found: String) -> Wrong {
        let says = self.says_line.map_or(String::new(), |field| format!(", whose field {field} says line"));
        Wrong::new(format!("a line or lines with heights in feature {}{says}", self.feature), found)
    }
}

fn lines(placer: &Placer, geometry: &Geometry, of: OfLines<'_>, found: &mut Vec<Line>) -> Result<(), Wrong> {
    let kind = geometry.geometry_type();
    let flat = geometry_type_flatten(kind);
    if flat == OGRwkbGeometryType::wkbMultiLineString {
        let mut parts = (0..geometry.geometry_count()).map(|i| geometry.get_geometry(i));
        return parts.try_for_each(|part| lines(placer, &part, of, found));
    }
    if flat != OGRwkbGeometryType::wkbLineString {
        return Err(geometry.geometry_name().into());
    }
    let OfLines { feature, with_heights, line_type, .. } = of;
    if with_heights && !geometry_type_has_z(kind) && !geometry.is_empty() {
        return Err(of.without_heights(format!("{} without heights (2-D)", geometry.geometry_name())));
    }
    let (vertices, heights) = placer.vertices_with_heights(geometry)?;
    if let Some(height) = heights.iter().find(|height| with_heights && !height.is_finite()) {
        return Err(of.without_heights(format!("a vertex with the height {}", Plainly(*height))));
    }
    found.push(Line { feature, vertices, heights, with_heights, line_type });
    Ok(())
}
