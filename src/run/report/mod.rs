//! What a run tells in the end, and what it will need: one vocabulary for the JSON of all commands.
//!
//! [`Report`] and [`Needs`] serialise to JSON; their fields' names are the schema, whose number is [`SCHEMA`]. Their `lines` are
//! the same for people. Counts of samples mean the same everywhere, in a verdict of `verify` too:
//!
//! | name | samples |
//! |---|---|
//! | `raster_samples` | all of the raster, or of the window |
//! | `samples` | on the ground, with a height: covered and within the tolerance |
//! | `missing_samples` | without a height, filled voids left out |
//! | `isolated_samples` | with a height, but in no cell with two others: on no ground |
//! | `filled_samples` | of voids that are filled, `filled_voids` in number: covered, bound by no tolerance |
//! | `trimmed_samples` | on the ground, left uncovered where the rim was simplified |

mod layers;
mod needs;
mod text;

use serde::Serialize;

use super::Request;
use super::attributes::Ranged;
use super::coordinates::Written;
use super::scene::Scene;
use crate::base::channels::{Channel, Ranges};
use crate::base::lattice::STEPS;
use crate::base::warning::Warnings;
use crate::base::{Band, Encoding, LineKind, PointCounts, Reference};
use crate::field::{Access, Field};
use crate::formats::Format;
use crate::job::plan::{Plan, peak_memory};
use crate::job::{EngineChoice, Goal, Mesh, Outcome, Params, Quality, Summary, TileTimes, VertexHeights};
use crate::kernel::measure::{ErrorStats, ShapeStats, WeightedStats};
use crate::kernel::triangulate::Feasibility;

pub use layers::{CutlineReport, LinesReport, PointsReport};
pub use needs::{Needs, WorkDirState};
pub use text::{BinaryBytes, Line, band, grouped, heights, place};

/// The number of the JSON's schema. It grows when a field changes its name or meaning, not when one is added.
pub const SCHEMA: u32 = 1;

/// What a run tells in the end.
#[derive(Debug, Clone, Serialize)]
#[allow(missing_docs)]
pub struct Report {
    /// See [`SCHEMA`].
    pub schema: u32,
    pub input: String,
    pub output: String,
    /// The format of the output.
    pub format: &'static str,
    /// How the samples were read.
    pub access: Access,
    /// The band of the heights, of how many, and what it is said to hold.
    pub band: usize,
    pub bands: usize,
    pub band_description: String,
    /// Null where heights are not stored as colours.
    pub encoding: Option<Encoding>,
    /// Null where all errors weigh the same.
    pub importance: Option<ImportanceReport>,
    /// Columns and rows before the samples meant, and samples across and down; null where they are the whole raster.
    pub window: Option<[usize; 4]>,
    /// Null where all of the raster is meant, or of the window.
    pub cutline: Option<CutlineReport>,
    pub map: MapReport,
    /// See the table of [`crate::run::report`].
    pub raster_samples: u64,
    pub samples: u64,
    pub missing_samples: u64,
    pub isolated_samples: u64,
    pub filled_voids: u64,
    pub filled_samples: u64,
    pub trimmed_samples: u64,
    /// The least and the largest height.
    pub height_range: Option<[f64; 2]>,
    pub triangles: u64,
    pub vertices: u64,
    pub samples_per_triangle: f64,
    /// What the mesh keeps to: what was asked for, or what was found for a goal; null where insertion stopped at a budget.
    pub tolerance: Option<f64>,
    /// Null where the tolerance is all that was asked for.
    pub goal: Option<GoalReport>,
    pub engine: EngineChoice,
    pub quality: Quality,
    pub heights: VertexHeights,
    pub feasibility: Feasibility,
    /// How far the surface may stray between samples, in tolerances; null where there is no limit.
    pub max_stray: Option<f64>,
    /// Triangles that are weakly feasible only, where strong feasibility was asked for.
    pub relaxed_triangles: u64,
    pub tile_cells: usize,
    pub error: ErrorReport,
    /// Null without polishing.
    pub shape: Option<ShapeReport>,
    /// Null where there are none.
    pub attributes: Option<AttributeReport>,
    pub seconds: Seconds,
    pub samples_per_second: f64,
    /// The largest resident size of the process so far; null where the system does not tell.
    pub peak_memory_bytes: Option<u64>,
    pub temporary_bytes: u64,
    /// Tiles that an earlier run had left in the work dir; null where there is none.
    pub tiles_found: Option<u64>,
    /// What became of the points; null where there are none.
    pub points: Option<PointsReport>,
    /// What became of breaklines; null where there are none.
    pub breaklines: Option<LinesReport>,
    /// What became of the outlines of lakes; null where there are none.
    pub lakes: Option<LinesReport>,
    /// Samples in lakes, those without a height among them.
    pub samples_in_lakes: u64,
    /// What became of the outlines of footprints; null where there are none.
    pub footprints: Option<LinesReport>,
    /// What became of the outlines of a cutline that the mesh ends at; null where there are none. Then `cutline` is null.
    pub exact_cutline: Option<LinesReport>,
    /// Samples beside lines with heights of their own: the surface may be anywhere between sample and line there.
    pub beside_lines: u64,
    /// The memory that was planned.
    pub memory: Plan,
    /// What the user should know of the inputs and the output.
    pub warnings: Warnings,
    /// The mesh to be looked at, if that was asked for.
    #[serde(skip)]
    pub scene: Option<Scene>,
}

/// The weights, and what they made of the errors.
#[derive(Debug, Clone, Serialize)]
pub struct ImportanceReport {
    /// The raster.
    pub file: String,
    /// How it was read.
    pub access: Access,
    /// The largest error × weight.
    pub max_weighted_error: f64,
}

/// What coordinates mean, and how they are written.
#[derive(Debug, Clone, Serialize)]
pub struct MapReport {
    /// What coordinates and heights mean.
    #[serde(flatten)]
    pub reference: Reference,
    /// What is taken from x and y in the output.
    pub offset: (f64, f64),
    /// What x and y, less the offset, are multiplied by in the output: metres in a degree or a foot, where the format wants
    /// metres.
    pub xy_scale: (f64, f64),
    /// What heights are multiplied by in the output.
    pub z_scale: f64,
    /// "double" or "float".
    pub precision: &'static str,
    /// What of the tolerance is kept for what writing loses of heights.
    pub kept_for_rounding: f64,
}

/// How far a run under a goal came.
#[derive(Debug, Clone, Serialize)]
pub struct GoalReport {
    /// What was asked for.
    #[serde(flatten)]
    pub goal: Goal,
    /// The tolerance that was asked for beside it; null where none was.
    pub max_error: Option<f64>,
    /// Whether a quality was asked for, and all that were are reached.
    pub reached: Option<bool>,
    /// What ended the run.
    #[serde(flatten)]
    pub outcome: Outcome,
}

/// Further bands as attributes of vertices, and what became of their error.
#[derive(Debug, Clone, Serialize)]
pub struct AttributeReport {
    /// The bands, from 1.
    pub bands: Vec<usize>,
    /// What they are called, and their number types.
    pub attributes: Vec<Channel>,
    /// What they count in the error, from 0 to 1.
    pub weight: f64,
    /// Whether the raster is an image without heights.
    pub image: bool,
    /// What they are scaled by.
    pub ranges: Ranges,
    /// The largest error of heights and attributes together, and where.
    pub max_error: f64,
    /// Its column.
    pub column: u64,
    /// Its row.
    pub row: u64,
}

/// Vertical distances between mesh and samples, over all samples. The shares are those of distance × weight where there
/// are weights.
#[derive(Debug, Clone, Serialize)]
#[allow(missing_docs)]
pub struct ErrorReport {
    /// The largest, at this sample and place on the map.
    pub max: f64,
    pub column: u64,
    pub row: u64,
    pub x: f64,
    pub y: f64,
    /// The root of their mean square.
    pub rms: f64,
    /// Half, 90 %, 95 % and 99 % are at most so large.
    pub p50: f64,
    pub p90: f64,
    pub p95: f64,
    pub p99: f64,
    /// Samples in bins of the same size, from 0 to `histogram_end`. Not in JSON.
    #[serde(skip)]
    pub histogram: Vec<u64>,
    #[serde(skip)]
    pub histogram_end: f64,
}

/// The shapes of the triangles, seen from above with square cells, and how far edges stray between samples.
#[derive(Debug, Clone, Serialize)]
#[allow(missing_docs)]
pub struct ShapeReport {
    /// The smallest angle of a triangle, in degrees: a share of the triangles has at most so much.
    pub angle_p5: f64,
    pub angle_p50: f64,
    /// How many triangles by the whole degrees of their smallest angle.
    pub smallest_angles: Vec<u64>,
    /// The share of the edges that stray farther than the tolerance from the grid's edges and diagonals, and how far the
    /// farthest does, in the units of the heights.
    pub edges_beyond: f64,
    pub overshoot_max: f64,
    /// What 99 % of the edges do not exceed, as a share of the tolerance.
    pub overshoot_p99: f64,
    /// How many edges stray farther than the limit on straying, where there is one: next to links of tiles' sides that could not be
    /// mended.
    pub edges_astray: u64,
}

impl ShapeReport {
    fn new(shape: &ShapeStats) -> ShapeReport {
        ShapeReport {
            angle_p5: shape.angle(0.05),
            angle_p50: shape.angle(0.5),
            smallest_angles: shape.angles.to_vec(),
            edges_beyond: shape.beyond_tolerance(),
            overshoot_max: shape.overshoot_max,
            overshoot_p99: shape.overshoot(0.99),
            edges_astray: shape.astray,
        }
    }
}

/// Seconds by stage, on the clock; `threads` are seconds of all threads together within `tiles`.
#[derive(Debug, Clone, Copy, Serialize)]
#[allow(missing_docs)]
pub struct Seconds {
    /// From before the raster is opened.
    pub total: f64,
    /// Opening the raster, joining lines, decoding samples where they cannot be mapped, and finding holes to bridge.
    pub open: f64,
    pub tiles: f64,
    pub write: f64,
    pub threads: TileTimes,
}

/// What a report is made from beside the mesh.
pub(super) struct Sources<'a> {
    pub(super) request: &'a Request<'a>,
    pub(super) format: &'static Format,
    pub(super) band: &'a Band,
    /// The layer of the points and what became of them.
    pub(super) points: Option<(&'a str, PointCounts)>,
    pub(super) ranged: Option<&'a Ranged<'a>>,
    pub(super) written: &'a Written,
    /// Whether there is a work dir.
    pub(super) continues: bool,
}

impl Report {
    pub(super) fn new(
        sources: &Sources<'_>,
        field: &Field,
        params: &Params,
        plan: Plan,
        summary: &Summary,
        seconds: Seconds,
        mesh: &Mesh,
    ) -> Report {
        let Sources { request, band, .. } = *sources;
        let errors = &summary.errors;
        let (filled_voids, filled_samples) = field.holes().map_or((0, 0), |voids| (voids.count(), voids.samples()));
        Report {
            schema: SCHEMA,
            input: field.name().display().to_string(),
            output: request.output.display().to_string(),
            format: sources.format.name,
            access: field.access().clone(),
            band: band.number(),
            bands: band.bands,
            band_description: band.title.clone(),
            encoding: band.encoding,
            importance: field.importance().map(|weights| ImportanceReport {
                file: weights.name().display().to_string(),
                access: weights.access().clone(),
                max_weighted_error: errors.weighted_max,
            }),
            window: band.window.map(|w| [w.column, w.row, w.width, w.height]),
            cutline: band.cutline().map(|cutline| CutlineReport::new(cutline, request)),
            map: MapReport::new(band, sources.written),
            raster_samples: band.samples(),
            samples: errors.samples,
            missing_samples: errors.nodata,
            isolated_samples: errors.stray,
            filled_voids,
            filled_samples,
            trimmed_samples: errors.trimmed,
            height_range: errors.heights.map(|h| h.all()).filter(|e| !e.is_empty()).map(|e| [e.min, e.max]),
            triangles: summary.triangles,
            vertices: summary.vertices,
            samples_per_triangle: errors.samples as f64 / summary.triangles as f64,
            tolerance: Some(mesh.tolerance().asked()).filter(|t| t.is_finite()),
            goal: mesh.outcome().map(|outcome| GoalReport::new(params, outcome)),
            engine: params.engine,
            quality: params.quality,
            heights: params.heights,
            feasibility: params.feasibility,
            max_stray: params.limit_on_straying(params.features()),
            relaxed_triangles: summary.relaxed,
            tile_cells: params.tile,
            error: ErrorReport::new(errors, field, mesh),
            shape: errors.shape.as_deref().map(ShapeReport::new),
            attributes: sources.ranged.map(|ranged| AttributeReport::new(ranged, errors)),
            samples_per_second: errors.samples as f64 / seconds.total,
            seconds,
            peak_memory_bytes: peak_memory(),
            temporary_bytes: field.decoded_bytes() + mesh.spool_bytes(),
            tiles_found: sources.continues.then(|| mesh.tiles_found()),
            breaklines: LinesReport::new(LineKind::Breaklines, request, params, mesh),
            lakes: LinesReport::new(LineKind::Lakes, request, params, mesh),
            samples_in_lakes: params.breaklines.as_ref().map_or(0, |lines| lines.in_lakes()),
            footprints: LinesReport::new(LineKind::Footprints, request, params, mesh),
            exact_cutline: LinesReport::new(LineKind::Cutline, request, params, mesh),
            beside_lines: errors.beside,
            points: sources.points.map(|(layer, counts)| PointsReport::new(layer, counts, request)),
            memory: plan,
            warnings: Warnings::default(),
            scene: None,
        }
    }

    /// Whether a quality was asked for that a budget did not allow.
    pub fn fell_short(&self) -> bool {
        self.goal.as_ref().is_some_and(GoalReport::fell_short)
    }
}

impl MapReport {
    fn new(band: &Band, written: &Written) -> MapReport {
        let Written { frame, loss, .. } = *written;
        MapReport {
            reference: band.reference().clone(),
            offset: frame.origin,
            xy_scale: frame.xy_scale,
            z_scale: frame.z_scale,
            precision: if frame.single { "float" } else { "double" },
            kept_for_rounding: loss,
        }
    }
}

impl GoalReport {
    fn new(params: &Params, outcome: Outcome) -> GoalReport {
        let goal = params.goal;
        let asked = !params.tolerance.is_open() || goal.max_rms.is_some();
        let max_error = Some(params.tolerance.asked()).filter(|asked| asked.is_finite());
        GoalReport { goal, max_error, reached: asked.then_some(outcome.ended_by.is_none()), outcome }
    }

    /// Whether a quality was asked for that a budget did not allow.
    pub fn fell_short(&self) -> bool {
        self.reached == Some(false)
    }
}

impl AttributeReport {
    fn new(ranged: &Ranged<'_>, errors: &ErrorStats) -> AttributeReport {
        let WeightedStats { max, worst: (column, row) } = errors.extended.unwrap_or_default();
        AttributeReport {
            bands: ranged.bands.bands.iter().map(Band::number).collect(),
            attributes: ranged.channels.clone(),
            weight: ranged.bands.emphasis,
            image: ranged.bands.planar,
            ranges: ranged.ranges.clone(),
            max_error: max,
            column,
            row,
        }
    }
}

impl ErrorReport {
    fn new(errors: &ErrorStats, field: &Field, mesh: &Mesh) -> ErrorReport {
        let (column, row) = errors.worst;
        let steps = i64::from(STEPS);
        let (x, y) = field.geo_transform().apply(column as i64 * steps, row as i64 * steps);
        let percentile = |share| errors.percentile(share, mesh.error_scale());
        ErrorReport {
            max: errors.max,
            column,
            row,
            x,
            y,
            rms: errors.rms(),
            p50: percentile(0.5),
            p90: percentile(0.9),
            p95: percentile(0.95),
            p99: percentile(0.99),
            histogram: errors.histogram.to_vec(),
            histogram_end: mesh.error_scale(),
        }
    }
}
