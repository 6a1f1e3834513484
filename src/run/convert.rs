//! From one format of meshes to another, without the raster.

mod frame;
mod marks;

use std::path::PathBuf;

use serde::Serialize;

use self::frame::{Step, frame};
use super::report::SCHEMA;
use super::{Coordinates, IN_MEMORY, RunError, Warned, prepare};
use crate::base::CoordinateFrame;
use crate::base::channels::{Channel, Number};
use crate::base::control::{Control, Stage};
use crate::base::external::{Scratch, Store, StoreWriter};
use crate::base::staged::StagedFile;
use crate::base::warning::{Warning, WarningCode, Warnings};
use crate::formats::{
    self, Attributes, Bounds, Contents, Format, Header, HeaderKept, Marks, MeshReader, Precision, ReadOptions, Setup,
    Sink, SinkOption, SinkOptions,
};

/// Vertices or triangles handed on at a time.
const BATCH: usize = 1 << 16;

/// What normals are called among attributes.
const NORMALS: [&str; 3] = ["nx", "ny", "nz"];

/// A mesh that is to be written in another format: everything that the command `convert` can be asked for.
#[derive(Debug, Clone)]
pub struct ConvertRequest {
    /// The mesh.
    pub input: PathBuf,
    /// Its format; `None` goes by its content and its extension.
    pub input_format: Option<&'static Format>,
    /// The mesh to be made.
    pub output: PathBuf,
    /// Its format; `None` goes by the extension.
    pub format: Option<&'static Format>,
    /// Options of that format.
    pub sink: SinkOptions,
    /// How coordinates are written, where the format leaves a choice. What is local or single in the input already stays so.
    pub coordinates: Coordinates,
    /// Whether an existing output is replaced.
    pub overwrite: bool,
    /// The folder of temporary files; `None` is the system's.
    pub temp_dir: Option<PathBuf>,
}

/// What became of a mesh in another format.
#[derive(Debug, Clone, Serialize)]
#[allow(missing_docs)]
pub struct ConvertReport {
    /// See [`SCHEMA`].
    pub schema: u32,
    pub input: String,
    pub input_format: &'static str,
    pub output: String,
    pub format: &'static str,
    pub vertices: u64,
    pub triangles: u64,
    /// Edges that follow lines, as far as they are marked in the output.
    pub edges: u64,
    /// What vertices have beside their places.
    pub attributes: Vec<Channel>,
    /// How coordinates are written: less this, times this, heights times this.
    pub offset: (f64, f64),
    pub xy_scale: (f64, f64),
    pub z_scale: f64,
    /// "double" or "float".
    pub precision: &'static str,
    /// How far heights are from those of the input at the most.
    pub loss: f64,
    /// The tolerance that the input names and the loss together; null where it names none.
    pub max_error: Option<f64>,
    /// What was left out, and what else the user should know.
    pub warnings: Warnings,
}

impl ConvertRequest {
    /// A mesh in the format that the output's extension names.
    pub fn new(input: impl Into<PathBuf>, output: impl Into<PathBuf>) -> ConvertRequest {
        ConvertRequest {
            input: input.into(),
            input_format: None,
            output: output.into(),
            format: None,
            sink: SinkOptions::default(),
            coordinates: Coordinates::default(),
            overwrite: false,
            temp_dir: None,
        }
    }
}

/// Writes a mesh in another format.
///
/// Coordinates stay as they are, bit for bit, unless the format holds only single precision, or metres, or others are asked for: then
/// they are what a run with this format would have written, so that [`super::verify`] finds the same samples under them. What heights lose by that
/// is added to the tolerance that the header names. Attributes, CRS and the rest of the header go as far as the format keeps
/// them; what it does not is told by warnings.
///
/// The mesh is read three times at the most, and once more for edges that follow lines. Memory: some buffers, 32 MiB where such edges
/// are read by places; temporary files: 24 bytes a vertex where the format wants the corners of triangles or the ends of such edges.
///
/// # Errors
/// [`RunError`]; nothing is left under the output's name then.
pub fn convert(request: &ConvertRequest, control: &Control<'_>) -> Result<ConvertReport, RunError> {
    let warned = Warned::new(control);
    let target = target(request)?;
    let input_format = match request.input_format {
        Some(format) => format,
        None => formats::recognised(&request.input)?,
    };
    StagedFile::check(&request.output, request.overwrite, &[request.input.as_path()])?;
    let reading = ReadOptions { cancel: control.cancel.clone(), temp_dir: request.temp_dir.clone() };
    let mut reader = (input_format.reader)(&request.input, &reading)?;
    let report = write(request, target, reader.as_mut(), &warned, control)?;
    Ok(ConvertReport { input_format: input_format.name, ..report })
}

/// Does what [`convert`] does with a mesh that is open, such as one in arrays. Of the input in the request only what messages call
/// it counts.
///
/// # Errors
/// As [`convert`].
pub fn convert_mesh(
    mesh: &mut dyn MeshReader,
    request: &ConvertRequest,
    control: &Control<'_>,
) -> Result<ConvertReport, RunError> {
    write(request, target(request)?, mesh, &Warned::new(control), control)
}

/// The format of the output, which takes what is asked of it.
fn target(request: &ConvertRequest) -> Result<&'static Format, RunError> {
    let target = prepare::format_of(&request.output, request.format)?;
    prepare::check_options(&request.output, request.sink.asked(), target)?;
    Ok(target)
}

fn write(
    request: &ConvertRequest,
    target: &'static Format,
    reader: &mut dyn MeshReader,
    warned: &Warned<'_>,
    control: &Control<'_>,
) -> Result<ConvertReport, RunError> {
    let inputs = [request.input.as_path()];
    let mut conversion = Conversion::plan(request, target, reader)?;
    conversion.tell_of_losses(warned);
    let staged = StagedFile::create(&request.output, request.overwrite, &inputs)?;
    let edges = conversion.write(request, staged, reader, warned, control)?;
    let Conversion { frame, loss, header, kept, .. } = conversion;
    Ok(ConvertReport {
        schema: SCHEMA,
        input: request.input.display().to_string(),
        input_format: IN_MEMORY,
        output: request.output.display().to_string(),
        format: target.name,
        vertices: reader.vertex_count(),
        triangles: reader.face_count(),
        edges,
        attributes: kept,
        offset: frame.origin,
        xy_scale: frame.xy_scale,
        z_scale: frame.z_scale,
        precision: if frame.single { "float" } else { "double" },
        loss,
        max_error: header.tolerance,
        warnings: warned.take(),
    })
}

/// What is to be written.
struct Conversion {
    request_output: PathBuf,
    target: &'static Format,
    source_frame: CoordinateFrame,
    frame: CoordinateFrame,
    bounds: Option<Bounds>,
    loss: f64,
    header: Header,
    kept: Vec<Channel>,
    left: Vec<String>,
    has_normals: bool,
}

impl Conversion {
    fn plan(
        request: &ConvertRequest,
        target: &'static Format,
        reader: &mut dyn MeshReader,
    ) -> Result<Conversion, RunError> {
        let given = reader.header().clone();
        let source = given.frame;
        let single = source.single || request.coordinates.single || !target.precisions.contains(&Precision::Double);
        let read = bounds(reader)?;
        let frame = frame(&given, target, Coordinates { single, ..request.coordinates }, read);
        let frame = frame.map_err(|found| RunError::Placed { path: request.input.clone(), found })?;
        let step = Step { from: source, to: frame };
        let mut loss: f64 = 0.0;
        let mut written = Bounds::EMPTY;
        reader.for_each_vertex(|index, vertex| {
            let found = step.take(vertex);
            if !found.iter().all(|v| v.is_finite()) {
                return Err(RunError::NotFinite { path: request.output.clone(), vertex: index, found });
            }
            written = written.with(found);
            loss = loss.max((frame.height(found[2]) - source.height(vertex[2])).abs());
            Ok::<(), RunError>(())
        })?;
        let (kept, left, has_normals) = attributes(target, reader.attributes());
        let tolerance = given.tolerance.map(|tolerance| tolerance + loss);
        let header = Header { frame, tolerance, ..given };
        let bounds = (reader.vertex_count() > 0).then_some(written);
        let request_output = request.output.clone();
        Ok(Conversion {
            request_output,
            target,
            source_frame: source,
            frame,
            bounds,
            loss,
            header,
            kept,
            left,
            has_normals,
        })
    }

    /// Tells what the format does not keep.
    fn tell_of_losses(&self, warned: &Warned<'_>) {
        let file = self.request_output.clone();
        if !self.left.is_empty() {
            let message = format!("{} keeps no attributes like {}: left out", self.target.title, self.left.join(", "));
            let count = self.left.len() as u64;
            warned.tell(Warning { code: WarningCode::AttributesLost, file: file.clone(), count, message });
        }
        let Header { crs, heights, source, made_by, .. } = &self.header;
        let has_facts = crs.definition.is_some() || source.is_some() || made_by.is_some();
        let message = match self.target.header {
            HeaderKept::Frame if has_facts => "keeps neither the CRS nor what the mesh was made from",
            HeaderKept::AllButHeights if heights.unit.is_some() || heights.crs.is_some() => {
                "does not say what heights mean"
            }
            _ => return,
        };
        let message = format!("{} {message}", self.target.title);
        warned.tell(Warning { code: WarningCode::HeaderLost, file, count: 1, message });
    }

    /// Gives how many edges are marked.
    fn write(
        &mut self,
        request: &ConvertRequest,
        staged: StagedFile,
        reader: &mut dyn MeshReader,
        warned: &Warned<'_>,
        control: &Control<'_>,
    ) -> Result<u64, RunError> {
        let setup = Setup {
            header: self.header.clone(),
            loss: f64::INFINITY,
            as_is: true,
            options: request.sink,
            texture: None,
            temp_dir: request.temp_dir.clone(),
            cancel: control.cancel.clone(),
        };
        let mut sink = (self.target.sink)(staged, setup)?;
        let needs = sink.needs();
        let (vertices, triangles) = (reader.vertex_count(), reader.face_count());
        let steps = (vertices + triangles).div_ceil(BATCH as u64);
        control.progress.begin(Stage::Write, steps, 0);
        let bounds = self.bounds.filter(|_| needs.bounds);
        let has_normals = self.has_normals;
        let edges = match needs.edges {
            Marks::None => 0,
            Marks::Numbers | Marks::Places => reader.edge_count(),
        };
        if edges < reader.edge_count() {
            self.tell_of_edges(reader.edge_count(), warned);
        }
        let attributes = &self.kept;
        let (tolerance, edges_have_types) = (None, edges > 0 && reader.edges_have_types());
        sink.begin(&Contents {
            vertices,
            triangles,
            attributes,
            has_normals,
            tolerance,
            bounds,
            edges,
            edges_have_types,
        })?;
        let scratch = Scratch::new(request.temp_dir.as_deref(), control.cancel.clone());
        let step = Step { from: self.source_frame, to: self.frame };
        if needs.edges == Marks::Places && edges > 0 {
            marks::write_places(sink.as_mut(), reader, &scratch, |vertex| step.take(vertex))?;
        }
        let store = self.write_vertices(sink.as_mut(), reader, needs.corners.then_some(&scratch), control)?;
        write_triangles(sink.as_mut(), reader, store, control)?;
        if needs.edges == Marks::Numbers {
            marks::write_numbers(sink.as_mut(), reader)?;
        }
        sink.finish()?;
        control.progress.end(Stage::Write);
        Ok(edges)
    }

    fn tell_of_edges(&self, count: u64, warned: &Warned<'_>) {
        let message = format!("{} has no place for edges that follow lines: they are not marked", self.target.title);
        let file = self.request_output.clone();
        warned.tell(Warning { code: WarningCode::EdgesLost, file, count, message });
    }

    fn write_vertices<'s>(
        &self,
        sink: &mut dyn Sink,
        reader: &mut dyn MeshReader,
        scratch: Option<&'s Scratch>,
        control: &Control<'_>,
    ) -> Result<Option<Store<'s, 3>>, RunError> {
        let step = Step { from: self.source_frame, to: self.frame };
        let names: Vec<&str> = self.kept.iter().map(|channel| channel.name.as_str()).collect();
        let mut store = scratch.map(StoreWriter::new).transpose()?;
        let turn = step.turn().filter(|_| self.has_normals);
        let mut vertices = Vec::with_capacity(BATCH);
        let mut values = vec![Vec::with_capacity(BATCH); names.len()];
        reader.for_each_vertex_with(&names, |_, vertex, attributes| {
            let vertex = step.take(vertex);
            if let Some(store) = &mut store {
                store.push(vertex.map(f64::to_bits))?;
            }
            vertices.push(vertex);
            values.iter_mut().zip(attributes).for_each(|(all, value)| all.push(*value));
            if let Some(turn) = &turn {
                // Normals come last.
                let of: [usize; 3] = std::array::from_fn(|i| values.len() - 3 + i);
                let turned = turn(of.map(|i| attributes[i]));
                of.into_iter()
                    .zip(turned)
                    .for_each(|(i, value)| values[i].last_mut().into_iter().for_each(|n| *n = value));
            }
            if vertices.len() == BATCH {
                hand_on(sink, &mut vertices, &mut values, control)?;
            }
            Ok::<(), RunError>(())
        })?;
        hand_on(sink, &mut vertices, &mut values, control)?;
        Ok(store.map(StoreWriter::finish).transpose()?)
    }
}

fn hand_on(
    sink: &mut dyn Sink,
    vertices: &mut Vec<[f64; 3]>,
    values: &mut [Vec<f64>],
    control: &Control<'_>,
) -> Result<(), RunError> {
    let slices: Vec<&[f64]> = values.iter().map(Vec::as_slice).collect();
    sink.vertices(vertices, &slices)?;
    vertices.clear();
    values.iter_mut().for_each(Vec::clear);
    control.progress.step(Stage::Write, 0);
    Ok(())
}

fn write_triangles(
    sink: &mut dyn Sink,
    reader: &mut dyn MeshReader,
    mut store: Option<Store<'_, 3>>,
    control: &Control<'_>,
) -> Result<(), RunError> {
    let (mut triangles, mut corners) = (Vec::with_capacity(BATCH), Vec::new());
    reader.for_each_face(|_, face| {
        triangles.push(face);
        if let Some(store) = &mut store {
            let mut places = [[0.0; 3]; 3];
            for (place, vertex) in places.iter_mut().zip(face) {
                *place = store.get(vertex)?.map(f64::from_bits);
            }
            corners.push(places);
        }
        if triangles.len() == BATCH {
            sink.triangles(&triangles, &corners)?;
            triangles.clear();
            corners.clear();
            control.progress.step(Stage::Write, 0);
        }
        Ok::<(), RunError>(())
    })?;
    Ok(sink.triangles(&triangles, &corners)?)
}

/// Between what the vertices lie, as the file has them; all of them must be somewhere.
pub(super) fn bounds(reader: &mut dyn MeshReader) -> Result<Bounds, RunError> {
    let mut bounds = Bounds::EMPTY;
    let path = reader.path().to_path_buf();
    reader.for_each_vertex(|index, vertex| {
        if !vertex.iter().all(|v| v.is_finite()) {
            return Err(RunError::NotFinite { path: path.clone(), vertex: index, found: vertex });
        }
        bounds = bounds.with(vertex);
        Ok(())
    })?;
    Ok(bounds)
}

/// Which attributes the format keeps, with normals last; the names of the others; and whether there are normals.
fn attributes(target: &Format, given: &[Channel]) -> (Vec<Channel>, Vec<String>, bool) {
    let is_normal = |channel: &&Channel| NORMALS.contains(&channel.name.as_str()) && channel.number == Number::F32;
    let has_normals = target.options.contains(&SinkOption::Normals) && given.iter().filter(is_normal).count() == 3;
    let is_kept = |channel: &&Channel| match target.attributes {
        Attributes::All => true,
        Attributes::Single => channel.number != Number::F64,
        Attributes::None => false,
    };
    let others = || given.iter().filter(|channel| !has_normals || !is_normal(channel));
    let mut kept: Vec<Channel> = others().filter(is_kept).cloned().collect();
    let left = others().filter(|channel| !is_kept(channel)).map(|channel| channel.name.clone()).collect();
    if has_normals {
        kept.extend(NORMALS.map(|name| Channel { name: name.to_string(), number: Number::F32 }));
    }
    (kept, left, has_normals)
}
