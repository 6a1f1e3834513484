//! Judges a written mesh against its raster, sharing no code with whatever made it.
//!
//! In comes a raster and a path; out comes a [`Verdict`]: is the surface within the tolerance at every sample of the
//! ground (with an importance raster: is error × weight), and is it one surface over exactly the ground, without cracks,
//! T-junctions, folds or overlaps? Places are recovered on the lattice of quarter cells, where all geometry is exact; near
//! ties with the tolerance are settled by exact arithmetic.
//!
//! The *ground* is known from the raster alone: every closed cell with four heights, and of every cell with three the closed
//! triangle of the three (a half cell). Small holes may be bridged ([`GroundOptions`]): their samples count as if they had one.
//! A sample has a height unless its stored value is the nodata mark or NaN, or a
//! mask or alpha band says that it has none (`heights`). Where all samples have one, the ground is the
//! rectangle of their centres.
//!
//! Passes over the raster find the holes that are bridged (`holes`) and the strip that may be bare (`strip`), where they are
//! asked for. Two passes over the file put vertices, triangles, edges and corners in order by external sorts
//! (`base/external`; what the faces around an edge or a vertex have in common meets before the sort, `gather`); then
//! triangles, and edges of one face, sweep over the raster from the first row to the last (`sweep`, `ground`,
//! `boundary` or `rim`). Memory is bounded whatever the raster and the mesh, by about 60 MiB (12 more with an importance
//! raster, one for each thread) beside GDAL's own cache, more where there are lines (`lines`): every type that buffers says how much.
//!
//! All threads of the current rayon pool work on one band of rows at a time (`band`), each on rows of its own, while one of
//! them reads the next. A row sees its triangles in the order of the sort (`feed`), whichever band and thread it falls to, and
//! rows are put together in their order: so the verdict is the same, bit for bit, whatever the threads and the bands.
//!
//! # Why that is enough
//!
//! Let the faces be free of three faults:
//!
//! 1. Every face turns counter-clockwise and has an area (`faces`).
//! 2. Every edge has two faces that run along it in opposite directions, or one (`edges`). Edges are pairs of vertices.
//! 3. The edges of one face, directed as their faces are, make up the directed boundary of the ground: each of them runs
//!    along sides and diagonals of cells that have ground on one side alone, the same side as its face, and each quarter
//!    of each such side or diagonal belongs to one edge (`segments`).
//!
//! Then the faces cover each point of the ground exactly once, and no other point. For let f(p) be the number of faces with
//! the point p inside; by (1) all of them count the same way, so none can make up for another. Where p crosses edges, f
//! changes by the number of those that run one way less that of those that run the other way. In this the edges of two faces
//! cancel out by (2). So f changes only where edges of one face run, and there, by (3), just as the number does that is 1 in
//! the ground and 0 elsewhere. Both are 0 far away, so they are the same.
//!
//! All else follows. Closed faces are in the ground, so none touches a sample without a height. The area is that of the
//! ground, and every sample of it is covered. There is no crack: an edge inside the ground has two faces of the same two
//! vertices. There is no T-junction: a vertex in the midst of an edge would have faces around it that overlap with those of
//! the edge; nor on the boundary, where ground meets ground at a point alone (a *pinch*) only at a sample without a height
//! to its left and to its right, or above and below, and there each part is a wedge of at most a right angle, so no edge
//! passes through. What follows is counted all the same, by other code, and says better what is wrong with a mesh.
//! Beside that, two vertices at one place are a fault, which makes the parts of a pinch share theirs, and vertices in no
//! face are.
//!
//! # Where the ground may be trimmed
//!
//! With [`GroundOptions::trim`] the mesh may end short of the ground in a *strip*, the cells with a corner near a sample
//! without a height. The other cells are the *core*. (1) and (2) are asked for as before; in place of (3), of the edges of one
//! face (`rim`, `bare`):
//!
//! 4. None lies on another or crosses it, be it in part.
//! 5. With f = 0 to the left of all edges, and f greater by 1 to the right of an edge with its face there, less by 1 to the
//!    right of an edge with its face to the left, f is 0 or 1 everywhere.
//! 6. Where f = 1 there is ground.
//! 7. In the core f = 1.
//! 8. Every region where there is ground and f = 0, joined across lines with more than a point in common, borders on what
//!    is no ground, along a side. Outside of the raster there is none.
//!
//! All vertices lie on quarter rows' lines. So within a quarter row, between two lines, no edge begins or ends: each that is
//! there crosses it from the line above to that below, and so do the sides of cells and half cells, whose ends are on samples.
//! Two straight sides are in order between the lines if they are at both; places there are fractions, compared exactly. In
//! edges sorted by where they cross the line above, then by that below, neighbours tell whether all are in order (4), sums
//! along the row give f (5), and a span of the mesh is in the ground, or of the core in the mesh, if its ends are at both
//! lines (6, 7). Edges along a line are held against each other there (4). Bare spans of neighbouring quarter rows are of one
//! region where they overlap on the line between them (8): f is 0 above and below, so no edge is in between, by (4).
//!
//! f is the number of faces with a point inside, by the argument above: it holds whatever the edges of one face are. So the
//! faces cover each point of the core once, each of the rest of the ground once at most, and no other point.
//!
//! There is no crack. Let an edge of one face have faces on both sides of one of its inner points. That on the other side ends
//! there, as no two faces overlap, with an edge that lies on the first. It is not the same pair of vertices, by (2). Were it an
//! edge of two faces, the second would overlap with the face of the first edge; so it is one of one face, against (4).
//! Therefore beside edges of one face there is no ground, or bare ground, and that is open to what is no ground, by (8). There is
//! no T-junction: a vertex in the midst of an edge of two faces has faces that overlap with those. What may be is a
//! vertex that touches an edge of one face from its bare side, in a point.
//!
//! Samples of the ground outside of the strip are covered, each is within the tolerance where it is covered (`sweep`,
//! `ground`).
//!
//! # Where it ends at outlines
//!
//! With [`VerifyOptions::lines`] that have a cutline, the mesh is to cover the part of the ground that is inside of outlines
//! (`lines/inside`), which for this are noded on the lattice of quarter cells; half cells that they come into are no ground. Then (1),
//! (2), (4) and (5) are asked for, and in place of the others:
//!
//! 9. f = 1 where there is ground inside, and f = 0 elsewhere.
//!
//! Noded outlines neither begin nor end nor cross each other within a quarter row, nor do they cross sides of cells there, nor the
//! diagonals of the half cells that are left. So what is inside is a row of spans as well, and so is what it has in common with the ground,
//! and neighbours tell as before (6, 7). There is no bare ground for faces to enclose. Samples tell nothing more of what is covered:
//! each in a face is within the tolerance, and those in no face have none of that ground at them.
//!
//! # Between samples
//!
//! With [`VerifyOptions::max_stray`] triangles also reach the row below their last one, and those between two rows are kept
//! (`strays`): edges are followed from one row of cells to the next (`walk`), where they cross rows and columns their heights
//! are held against the two samples beside (`edge`, `limit`), and so are vertices that stand on no sample. An edge of two
//! faces is followed for that one of them alone which has it downwards. One of a single face is followed if the ground may be
//! trimmed; otherwise it runs along sides and diagonals of cells, which it does not cross but at samples, or is a fault. Why these
//! places are enough is said in `docs/guarantees.md`.
//!
//! Architecture invariant: nothing here imports an engine, a spool or a sink.

mod band;
mod bare;
mod between;
mod boundary;
mod cells;
mod corners;
mod crossing;
mod edge;
mod edges;
mod error;
mod exact;
mod faces;
mod feed;
mod finding;
mod gather;
mod grid;
mod ground;
mod heights;
mod holes;
mod joins;
mod limit;
mod line;
mod lines;
mod observe;
mod outline;
mod pace;
mod plane;
mod ranges;
mod rim;
mod row;
mod runs;
mod samples;
mod segments;
mod spans;
mod stray_verdict;
mod strays;
mod strip;
mod surface;
mod sweep;
mod task;
#[cfg(test)]
mod tests;
mod triangle;
mod valued;
mod verdict;
mod vertices;
mod walk;
mod weighted;

use std::path::{Path, PathBuf};

use crate::base::Band;
use crate::base::channels::ChannelBands;
use crate::base::control::{Control, Stage};
use crate::base::external::Scratch;
use crate::base::features::Feature;
use crate::formats::{self, MeshReader, ReadOptions};
use crate::job::rules;

pub use error::VerifyError;
pub use finding::{EdgePlace, FacePlace, Finding, MapPlace, SamplePlace, SidePlace, TouchPlace, VertexPlace};
pub use heights::HeightReader;
pub use lines::{LinesVerdict, RequiredLines, StretchPlace, verify_lines};
pub use observe::{ObservedRows, Observer, RowObserver};
pub use stray_verdict::{StrayVerdict, WorstStray};
pub use verdict::{CutlineVerdict, TrimVerdict, Verdict, WeightedWorst, WorstSample};
pub use weighted::{ChannelRange, WeightedVerdict, WorstWeighted};

use boundary::Boundary;
use corners::{VertexFindings, read_vertices};
use edges::{EdgeFindings, match_edges};
use faces::{FaceFindings, FaceSorts, read_faces};
use grid::Grid;
use holes::find_bridges;
use limit::StrayLimit;
use outline::Outline;
use pace::Pace;
use rim::Rim;
use runs::RunFlags;
use samples::{BandReader, Bands, flag};
use strays::Held;
use strip::find_strip;
use sweep::{Comparison, sweep};
use weighted::judge_weighted;

/// What a mesh is held to, and where temporary files go.
#[derive(Debug, Clone)]
pub struct VerifyOptions<'a> {
    /// The vertical distance allowed at every sample, in the raster's unit; at most this, `<=`, is within.
    pub max_error: f64,
    /// A limit on straying, as a multiple F of `max_error`, at least 1; `None` judges no straying.
    ///
    /// A *side* is the segment between two neighbouring samples of a row or a column that both have a height; those with a
    /// bridged sample are none. Along every side, as far as faces cover it, the surface is to lie between the two heights, give
    /// or take F × `max_error`; with an importance raster distance × weight is what counts, by the smaller weight of the
    /// two. Vertices inside a cell are held in the same way to all its heights, four or three, unless one of its samples is
    /// bridged. The limit is the smallest double that is F × `max_error` or more, and comparisons with it are exact.
    /// [`StrayVerdict`] says what was found. In meshes of [`ChannelBands::planar`] all heights are 0.
    pub max_stray: Option<f64>,
    /// A raster of weights: at every sample distance × weight is to be at most `max_error`. It has the grid of the raster.
    pub importance: Option<&'a Band>,
    /// Lines whose heights of their own count beside them: where the lesser of a sample's height h and those of lines is `low` and the
    /// larger is `high`, the surface is to be from `low` − `max_error` to `high` + `max_error`. A line is beside a sample if a place of
    /// it is in one of the closed cells around the sample. Whether edges follow lines is another question: [`verify_lines`]. Outlines of a
    /// [cutline](crate::base::LineKind::Cutline) are where the mesh is to end.
    pub lines: Option<&'a RequiredLines>,
    /// Where temporary files are made, about 200 bytes per triangle; `None` is the system's place for them.
    pub temp_dir: Option<PathBuf>,
}

/// Which ground a mesh is to cover, where it is not that of the samples with a height.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct GroundOptions {
    /// Holes up to this number of samples are bridged. A *hole* is a group of samples without a height, eight neighbours to a
    /// sample, that has none in the raster's first or last row or column. The ground goes on over it as if its samples had
    /// heights, and the surface there may have any.
    pub fill_holes: u64,
    /// Where samples without a height that are not bridged are within this number of columns and rows (the larger of the two),
    /// the ground may be bare. 0: nowhere.
    pub trim: u32,
}

/// Judges the file `mesh`, of any format in [`formats::FORMATS`], against `raster`, reading both once or twice from beginning
/// to end.
///
/// The verdict depends on the two files and the tolerance alone, not on the number of threads.
///
/// # Errors
/// [`VerifyError`] when either cannot be read or is damaged, when the raster has infinite heights, when the importance raster
/// has another grid or anything but weights where there are heights, when temporary files fail, or on cancellation. A mesh
/// that is merely wrong is a verdict.
pub fn verify(
    raster: &Band,
    mesh: &Path,
    options: &VerifyOptions<'_>,
    control: &Control<'_>,
) -> Result<Verdict, VerifyError> {
    verify_ground(raster, mesh, options, GroundOptions::default(), None, control)
}

/// Does what [`verify`] does, and judges the weighted error of heights and channels as well.
///
/// # Errors
/// As [`verify`]; [`VerifyError::Emphasis`]; [`VerifyError::Mesh`] if the mesh lacks an attribute;
/// [`VerifyError::Incompatible`] if there is an importance raster: the weighted error of channels has no weights of samples.
///
/// # Panics
/// If there is no channel.
pub fn verify_with_channels(
    raster: &Band,
    mesh: &Path,
    options: &VerifyOptions<'_>,
    channels: &ChannelBands,
    control: &Control<'_>,
) -> Result<Verdict, VerifyError> {
    verify_ground(raster, mesh, options, GroundOptions::default(), Some(channels), control)
}

/// Does what [`verify`] does, or with channels [`verify_with_channels`], on another ground.
///
/// # Errors
/// As theirs. Weights and channels may be missing where holes are bridged.
///
/// # Panics
/// As [`verify_with_channels`], where there are channels.
pub fn verify_ground(
    raster: &Band,
    mesh: &Path,
    options: &VerifyOptions<'_>,
    ground: GroundOptions,
    channels: Option<&ChannelBands>,
    control: &Control<'_>,
) -> Result<Verdict, VerifyError> {
    let mut mesh = open(raster, mesh, options, control)?;
    verify_mesh(raster, mesh.as_mut(), options, ground, channels, control)
}

/// Opens a mesh that is to be judged, once it is certain that it can be with these options.
///
/// # Errors
/// [`VerifyError::Tolerance`] and others of options that are none; [`VerifyError::Mesh`].
pub fn open(
    raster: &Band,
    mesh: &Path,
    options: &VerifyOptions<'_>,
    control: &Control<'_>,
) -> Result<Box<dyn MeshReader>, VerifyError> {
    limit(raster, options)?;
    let reading = ReadOptions { cancel: control.cancel.clone(), temp_dir: options.temp_dir.clone() };
    Ok(formats::open(mesh, None, &reading)?)
}

/// Does what [`verify_ground`] does with a mesh that is open, such as one in arrays.
///
/// # Errors
/// As [`verify_ground`].
///
/// # Panics
/// As [`verify_with_channels`], where there are channels.
pub fn verify_mesh(
    raster: &Band,
    mesh: &mut dyn MeshReader,
    options: &VerifyOptions<'_>,
    ground: GroundOptions,
    channels: Option<&ChannelBands>,
    control: &Control<'_>,
) -> Result<Verdict, VerifyError> {
    verify_observed(raster, mesh, options, ground, channels, None, control)
}

/// Does what [`verify_mesh`] does, and tells an observer, if there is one. That takes 4 bytes more for each sample of a band at most.
///
/// # Errors
/// As [`verify_mesh`]; [`VerifyError::Observer`].
///
/// # Panics
/// As [`verify_with_channels`], where there are channels.
pub fn verify_observed(
    raster: &Band,
    mesh: &mut dyn MeshReader,
    options: &VerifyOptions<'_>,
    ground: GroundOptions,
    channels: Option<&ChannelBands>,
    observer: Option<&mut dyn Observer>,
    control: &Control<'_>,
) -> Result<Verdict, VerifyError> {
    if let Some(channels) = channels {
        assert!(!channels.bands.is_empty(), "no channel to judge");
        let attributes = if channels.planar { Feature::Image } else { Feature::Attributes };
        let importance = options.importance.map(|_| Feature::Importance);
        rules::check_samples(importance.into_iter().chain([attributes]).collect())?;
        if !(0.0..=1.0).contains(&channels.emphasis) {
            return Err(VerifyError::Emphasis { found: channels.emphasis });
        }
    }
    judge(raster, mesh, options, ground, channels, (None, observer), control)
}

/// The limit on straying, once it is certain that the raster can be judged by with these options.
fn limit(raster: &Band, options: &VerifyOptions<'_>) -> Result<Option<StrayLimit>, VerifyError> {
    let tolerance = options.max_error;
    if !(tolerance.is_finite() && tolerance >= 0.0) {
        return Err(VerifyError::Tolerance { found: tolerance });
    }
    raster.holds_rows(raster.width())?;
    if let Some(importance) = options.importance {
        raster.same_grid(importance)?;
    }
    if let Some(lines) = options.lines {
        let others =
            [(Feature::MaxStray, options.max_stray.is_some()), (Feature::Importance, options.importance.is_some())];
        let others = others.into_iter().filter(|(_, is_asked)| *is_asked).map(|(feature, _)| feature);
        rules::check_samples(lines.features().and(others.collect()))?;
    }
    StrayLimit::new(options.max_stray, tolerance)
}

/// The raster passes in bands of this number of rows, where one is given, and is told to an observer.
fn judge(
    raster: &Band,
    mesh: &mut dyn MeshReader,
    options: &VerifyOptions<'_>,
    ground: GroundOptions,
    channels: Option<&ChannelBands>,
    (band_rows, mut observer): (Option<usize>, Option<&mut dyn Observer>),
    control: &Control<'_>,
) -> Result<Verdict, VerifyError> {
    let (tolerance, limit) = (options.max_error, limit(raster, options)?);
    if let Some(lines) = options.lines {
        let others = [(Feature::Trim, ground.trim > 0), (Feature::FilledVoids, ground.fill_holes > 0)];
        let others = others.into_iter().filter(|(_, is_asked)| *is_asked).map(|(feature, _)| feature);
        rules::check_samples(lines.features().and(others.collect()))?;
    }
    let scratch = Scratch::new(options.temp_dir.as_deref(), control.cancel.clone());
    let grid = Grid::of(raster, mesh);
    let (vertices, triangles) = (mesh.vertex_count(), mesh.face_count());

    // Each vertex passes when it is read and among the places, each face when it is read, by corners and by edges.
    let mut pace = Pace::begin(control, Stage::Sort, 2 * vertices + 7 * triangles);
    let (mut corner_findings, mut store, places) =
        read_vertices(mesh, &grid, (&scratch, reborrowed(&mut observer)), &mut pace)?;
    corner_findings.find_duplicates(&grid, places, &mut pace)?;
    let (face_findings, FaceSorts { triangles: by_row, edges, uses }) =
        read_faces(mesh, &mut store, &grid, limit.is_some(), (&scratch, reborrowed(&mut observer)), &mut pace)?;
    corner_findings.find_unused(&grid, &mut store, uses, &mut pace)?;
    let trims = ground.trim > 0;
    let inside = options.lines.and_then(RequiredLines::inside);
    let ends_anywhere = trims || inside.is_some();
    let (edge_findings, boundary) = match_edges(edges, &mut store, &grid, ends_anywhere, &scratch, &mut pace)?;
    drop(store);
    pace.end()?;

    let reader = || {
        let reader = match channels.filter(|c| c.planar) {
            Some(image) => BandReader::level(raster, &image.bands),
            None => BandReader::new(raster),
        };
        match band_rows {
            Some(rows) => reader.by(rows),
            None => reader,
        }
    };
    let mut bands = Bands::new(reader(), options.importance, options.lines);
    let find = |limit| find_bridges(reader(), limit, &scratch, control);
    let bridges = (ground.fill_holes > 0).then(|| find(ground.fill_holes)).transpose()?;
    let (bridged_holes, bridges) = bridges.map_or((0, None), |found| (found.holes, Some(found.runs)));
    let outline = if trims {
        let strip = find_strip(reader(), bridges, ground.trim, &scratch, control)?;
        bands = bands.with_flags(RunFlags::new(strip.bridged.into_records(), flag::BRIDGED));
        bands = bands.with_flags(RunFlags::new(strip.near.into_records(), flag::NEAR));
        Outline::Trimmed(Rim::new(grid, boundary, None))
    } else {
        bands = bridges.into_iter().fold(bands, |bands, runs| bands.with_flags(RunFlags::new(runs, flag::BRIDGED)));
        match inside {
            Some(_) => Outline::Cut(Rim::new(grid, boundary, inside)),
            None => Outline::Ground(Boundary::new(grid, boundary, &scratch)),
        }
    };
    let held = limit.map(|limit| Held { limit, trims, unbound: None });
    let held = (held, options.lines);
    let comparison = sweep(bands, grid, by_row, outline, (tolerance, held), (&scratch, observer), control)?;
    let of_channels = |c| judge_weighted(raster, mesh, tolerance, c, &scratch, control);
    let extended = channels.map(of_channels).transpose()?;
    let samples = raster.width() as u64 * raster.height() as u64;
    let sizes = Sizes { samples, vertices, triangles };
    let verdict =
        verdict((tolerance, limit), ground.trim, sizes, comparison, face_findings, edge_findings, corner_findings);
    Ok(Verdict { bridged_holes, extended, ..verdict })
}

/// The observer, lent.
fn reborrowed<'o>(observer: &'o mut Option<&mut dyn Observer>) -> Option<&'o mut dyn Observer> {
    match observer {
        Some(observer) => Some(&mut **observer),
        None => None,
    }
}

struct Sizes {
    samples: u64,
    vertices: u64,
    triangles: u64,
}

fn verdict(
    (tolerance, limit): (f64, Option<StrayLimit>),
    trim: u32,
    sizes: Sizes,
    comparison: Comparison,
    faces: FaceFindings,
    edges: EdgeFindings,
    corners: VertexFindings,
) -> Verdict {
    let ground = comparison.ground;
    let cut = comparison.outline.cut;
    let expected_double_area = cut.as_ref().map_or(ground.double_area, |rim| rim.core_double_area);
    let cutline = cut.map(|rim| CutlineVerdict {
        bare: rim.bare_core,
        beyond: rim.beyond,
        crossed_edges: rim.crossed,
        overlapping_edges: rim.overlapping,
    });
    let trim = comparison.outline.rim.map(|rim| TrimVerdict {
        cells: trim,
        trimmed: ground.trimmed,
        core_double_area: rim.core_double_area,
        bare_core: rim.bare_core,
        beyond_ground: rim.beyond,
        crossed_edges: rim.crossed,
        overlapping_edges: rim.overlapping,
        enclosed: rim.enclosed,
    });
    Verdict {
        tolerance,
        weighted: comparison.weighted,
        samples: sizes.samples,
        checked: ground.checked,
        nodata: ground.nodata,
        bridged_holes: 0,
        bridged: ground.bridged,
        without_ground: ground.without_ground,
        height_range: comparison.range,
        vertices: sizes.vertices,
        triangles: sizes.triangles,
        worst: comparison.worst,
        weighted_worst: comparison.weighted_worst,
        rms_error: (comparison.sum_of_squares / comparison.covered.max(1) as f64).sqrt(),
        above_tolerance: comparison.above,
        beside_lines: comparison.beside,
        stray: limit.zip(comparison.strays).map(|(limit, found)| found.verdict(&limit)),
        uncovered: ground.uncovered,
        overlapped: comparison.overlapped,
        touched_nodata: comparison.touched,
        clockwise: faces.clockwise,
        degenerate: faces.degenerate,
        unplaced: faces.unplaced,
        double_area: faces.double_area,
        expected_double_area,
        unmatched_edges: edges.unmatched.and(comparison.outline.astray),
        overused_edges: edges.overused,
        same_direction_edges: edges.same_direction,
        boundary_gaps: comparison.outline.boundary.gaps,
        boundary_doubled: comparison.outline.boundary.doubled,
        duplicate_vertices: corners.duplicate,
        unused_vertices: corners.unused,
        off_lattice: corners.off_lattice,
        outside: corners.outside,
        heights_not_finite: corners.not_finite,
        trim,
        cutline,
        extended: None,
        lines: None,
    }
}
