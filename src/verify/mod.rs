//! Judges a written mesh against its raster, sharing no code with whatever made it.
//!
//! In comes a raster and a path; out comes a [`Verdict`]: is the surface within the tolerance at every sample (with an
//! importance raster: is error × weight), and is it one surface, without cracks, T-junctions, folds or overlaps? Places are recovered on the lattice of quarter cells,
//! where all geometry is exact; near ties with the tolerance are settled by exact arithmetic.
//!
//! Two passes over the file put vertices, triangles, edges and corners in order by external sorts (`sort`); then the
//! triangles sweep over the raster from the first row to the last (`sweep`). Memory is bounded whatever the raster and
//! the mesh, by about 64 MiB (8 more with an importance raster) beside GDAL's own cache: every type that buffers says how much.
//!
//! Why that is enough: if every face turns counter-clockwise, every edge inside is shared by two faces in opposite
//! directions and the remaining edges run once around the rim, then the faces cover each point of the domain exactly
//! once. The area and the coverage of the samples follow from it; they are counted all the same, by other code.
//!
//! Architecture invariant: nothing here imports an engine, a spool or a sink.

mod corners;
mod edges;
mod error;
mod exact;
mod faces;
mod finding;
mod grid;
mod pace;
mod plane;
mod ranges;
mod samples;
mod scratch;
mod sort;
mod surface;
mod sweep;
#[cfg(test)]
mod tests;
mod triangle;
mod valued;
mod verdict;
mod vertices;
mod weighted;

use std::path::{Path, PathBuf};

use crate::control::{Control, Stage};
use crate::ply::PlyFile;
use crate::raster::Raster;

pub use error::VerifyError;
pub use finding::{EdgePlace, FacePlace, Finding, MapPlace, SamplePlace, VertexPlace};
pub use verdict::{Verdict, WeightedWorst, WorstSample};
pub use weighted::{ChannelRange, WeightedOptions, WeightedVerdict, WorstWeighted};

use corners::{VertexFindings, read_vertices};
use edges::{EdgeFindings, match_edges};
use faces::{FaceFindings, FaceSorts, read_faces};
use grid::Grid;
use pace::Pace;
use samples::{BandReader, Bands};
use scratch::Scratch;
use sweep::{Comparison, sweep};
use weighted::judge_weighted;

/// What a mesh is held to, and where temporary files go.
#[derive(Debug, Clone)]
pub struct VerifyOptions<'a> {
    /// The vertical distance allowed at every sample, in the raster's unit; at most this, `<=`, is within.
    pub max_error: f64,
    /// A raster of weights: at every sample distance × weight is to be at most `max_error`. It has the grid of the raster.
    pub importance: Option<&'a Raster>,
    /// Where temporary files are made, about 200 bytes per triangle; `None` is the system's place for them.
    pub temp_dir: Option<PathBuf>,
}

/// Judges the PLY file `mesh` against `raster`, reading both once or twice from beginning to end.
///
/// The verdict depends on the two files and the tolerance alone, not on the number of threads.
///
/// # Errors
/// [`VerifyError`] when either cannot be read or is damaged, when the raster has samples without a height, when the
/// importance raster has another grid or samples that are no weights, when temporary files fail, or on cancellation. A mesh that is merely wrong is a verdict.
pub fn verify(
    raster: &Raster,
    mesh: &Path,
    options: &VerifyOptions<'_>,
    control: &Control<'_>,
) -> Result<Verdict, VerifyError> {
    judge(raster, mesh, options, None, control)
}

/// Does what [`verify`] does, and judges the weighted error of heights and channels as well.
///
/// # Errors
/// As [`verify`]; [`VerifyError::Emphasis`]; [`VerifyError::Mesh`] if the mesh lacks an attribute.
///
/// # Panics
/// If there is no channel, or an importance raster: the weighted error of channels has no weights of samples.
pub fn verify_with_channels(
    raster: &Raster,
    mesh: &Path,
    options: &VerifyOptions<'_>,
    channels: &WeightedOptions,
    control: &Control<'_>,
) -> Result<Verdict, VerifyError> {
    assert!(!channels.bands.is_empty(), "no channel to judge");
    assert!(options.importance.is_none(), "channels beside an importance raster");
    if !(0.0..=1.0).contains(&channels.emphasis) {
        return Err(VerifyError::Emphasis { found: channels.emphasis });
    }
    judge(raster, mesh, options, Some(channels), control)
}

fn judge(
    raster: &Raster,
    mesh: &Path,
    options: &VerifyOptions<'_>,
    channels: Option<&WeightedOptions>,
    control: &Control<'_>,
) -> Result<Verdict, VerifyError> {
    let tolerance = options.max_error;
    if !(tolerance.is_finite() && tolerance >= 0.0) {
        return Err(VerifyError::Tolerance { found: tolerance });
    }
    raster.holds_rows(raster.width())?;
    if let Some(importance) = options.importance {
        raster.same_grid(importance)?;
    }
    let scratch = Scratch::new(options.temp_dir.as_deref(), control.cancel.clone());
    let mut mesh = PlyFile::open(mesh)?;
    let grid = Grid::of(raster, &mesh);
    let (vertices, triangles) = (mesh.vertex_count(), mesh.face_count());

    // Each vertex passes when it is read and among the places, each face when it is read, by corners and by edges.
    let mut pace = Pace::begin(control, Stage::Sort, 2 * vertices + 7 * triangles);
    let (mut corner_findings, mut store, places) = read_vertices(&mut mesh, &grid, &scratch, &mut pace)?;
    corner_findings.find_duplicates(&grid, places, &mut pace)?;
    let (face_findings, FaceSorts { triangles: by_row, edges, uses }) =
        read_faces(&mut mesh, &mut store, &grid, &scratch, &mut pace)?;
    corner_findings.find_unused(&grid, &mut store, uses, &mut pace)?;
    let edge_findings = match_edges(edges, &mut store, &grid, &scratch, &mut pace)?;
    drop(store);
    pace.end()?;

    let planar = channels.is_some_and(|c| c.planar);
    let reader = if planar { BandReader::level(raster) } else { BandReader::new(raster)? };
    let comparison = sweep(Bands::new(reader, options.importance)?, grid, by_row, tolerance, &scratch, control)?;
    let of_channels = |c| judge_weighted(raster, &mut mesh, tolerance, c, &scratch, control);
    let extended = channels.map(of_channels).transpose()?;
    let samples = raster.width() as u64 * raster.height() as u64;
    let sizes = Sizes { samples, vertices, triangles };
    let verdict = verdict(tolerance, sizes, &grid, comparison, face_findings, edge_findings, corner_findings);
    Ok(Verdict { extended, ..verdict })
}

struct Sizes {
    samples: u64,
    vertices: u64,
    triangles: u64,
}

fn verdict(
    tolerance: f64,
    sizes: Sizes,
    grid: &Grid,
    comparison: Comparison,
    faces: FaceFindings,
    edges: EdgeFindings,
    corners: VertexFindings,
) -> Verdict {
    let covered = sizes.samples - comparison.uncovered.count;
    Verdict {
        tolerance,
        weighted: comparison.weighted,
        samples: sizes.samples,
        vertices: sizes.vertices,
        triangles: sizes.triangles,
        worst: comparison.worst,
        weighted_worst: comparison.weighted_worst,
        rms_error: (comparison.sum_of_squares / covered.max(1) as f64).sqrt(),
        above_tolerance: comparison.above,
        uncovered: comparison.uncovered,
        overlapped: comparison.overlapped,
        clockwise: faces.clockwise,
        degenerate: faces.degenerate,
        unplaced: faces.unplaced,
        double_area: faces.double_area,
        expected_double_area: grid.double_area(),
        unmatched_edges: edges.unmatched,
        overused_edges: edges.overused,
        same_direction_edges: edges.same_direction,
        rim_gaps: edges.rim_gaps,
        rim_doubled: edges.rim_doubled,
        duplicate_vertices: corners.duplicate,
        unused_vertices: corners.unused,
        off_lattice: corners.off_lattice,
        outside: corners.outside,
        heights_not_finite: corners.not_finite,
        extended: None,
    }
}
