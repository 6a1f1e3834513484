//! The scene of a mesh in a file.

use std::path::PathBuf;

use super::{Gatherer, Most, Scene};
use crate::base::control::{Control, Stage};
use crate::base::external::{Scratch, StoreWriter};
use crate::formats::{self, Bounds, Format, Header, ReadOptions};
use crate::run::RunError;
use crate::run::convert::bounds;

/// A mesh that is to be looked at.
#[derive(Debug, Clone)]
pub struct SceneRequest {
    /// The mesh.
    pub mesh: PathBuf,
    /// Its format; `None` goes by its content and its extension.
    pub format: Option<&'static Format>,
    /// How much of it is shown.
    pub most: Most,
    /// The folder of temporary files; `None` is the system's.
    pub temp_dir: Option<PathBuf>,
}

/// A mesh that was read, and what it says of itself.
#[derive(Debug, Clone)]
pub struct SceneReport {
    /// What is shown.
    pub scene: Scene,
    /// What the file says.
    pub header: Header,
    /// Its format.
    pub format: &'static Format,
    /// Vertices of the mesh.
    pub vertices: u64,
    /// The least and the largest x, y on the map and height.
    pub bounds: Bounds,
}

/// Reads a mesh for looking at it.
///
/// The file is read three times. Memory: that of the triangles shown, about 250 bytes for each, and 12 MiB; temporary files: 24
/// bytes a vertex.
///
/// # Errors
/// [`RunError`], also for a vertex that is nowhere.
pub fn read(request: &SceneRequest, control: &Control<'_>) -> Result<SceneReport, RunError> {
    let format = match request.format {
        Some(format) => format,
        None => formats::recognised(&request.mesh)?,
    };
    let reading = ReadOptions { cancel: control.cancel.clone(), temp_dir: request.temp_dir.clone() };
    let mut reader = (format.reader)(&request.mesh, &reading)?;
    control.progress.begin(Stage::Sort, 3, 0);
    let header = reader.header().clone();
    let frame = header.frame;
    let placed = |[x, y, z]: [f64; 3]| {
        let (x, y) = frame.on_the_map((x, y));
        [x, y, frame.height(z)]
    };
    let written = bounds(reader.as_mut())?;
    control.progress.step(Stage::Sort, 0);
    // Factors are above 0: what is least stays so.
    let bounds = Bounds { min: placed(written.min), max: placed(written.max) };
    let scratch = Scratch::new(request.temp_dir.as_deref(), control.cancel.clone());
    let extent = [bounds.min[0], bounds.min[1], bounds.max[0], bounds.max[1]];
    let mut gatherer = Gatherer::new(extent, request.most);
    gatherer.expect(reader.face_count());
    let mut places = StoreWriter::<3>::new(&scratch)?;
    reader.for_each_vertex(|_, vertex| {
        let place = placed(vertex);
        gatherer.vertex(place);
        Ok::<(), RunError>(places.push(place.map(f64::to_bits))?)
    })?;
    let mut places = places.finish()?;
    control.progress.step(Stage::Sort, 0);
    reader.for_each_face(|_, face| {
        let mut corners = [[0.0; 3]; 3];
        for (corner, vertex) in corners.iter_mut().zip(face) {
            *corner = places.get(vertex)?.map(f64::from_bits);
        }
        gatherer.triangle(corners);
        Ok::<(), RunError>(())
    })?;
    let scene = gatherer.finish(reader.face_count());
    control.progress.end(Stage::Sort);
    Ok(SceneReport { scene, header, format, vertices: reader.vertex_count(), bounds })
}
