//! `simplify`: the report, as text and as JSON.

use std::path::Path;

use indicatif::BinaryBytes;
use serde::Serialize;

use super::goal::GoalReport;
use super::print;
use super::simplify_channels::ChannelReport;
use super::simplify_map::MapReport;
use super::warnings::Shown;
use crate::base::decimal::Decimal;
use crate::base::lattice::STEPS;
use crate::base::{Cutline, Encoding};
use crate::field::{Access, Field, Holes};
use crate::job::plan::Estimate;
use crate::job::work_dir::Finished;
use crate::job::{EngineChoice, Mesh, Params, Plan, Quality, Summary, TileTimes, VertexHeights};
use crate::kernel::measure::ShapeStats;
use crate::kernel::triangulate::Feasibility;
use crate::raster::{PointCounts, Points, Raster};

/// What `simplify` tells in the end.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Report {
    input: String,
    output: String,
    access: Access,
    /// The band of the heights, of how many, and what it is said to hold.
    band: usize,
    bands: usize,
    band_description: String,
    /// Null where heights are not stored as colours.
    encoding: Option<Encoding>,
    /// Null where errors are not weighted.
    importance: Option<ImportanceReport>,
    /// Columns and rows before the samples meant, and samples across and down; null where they are the whole raster.
    window: Option<[usize; 4]>,
    /// Null where all of the raster is meant, or of the window.
    cutline: Option<CutlineReport>,
    map: Option<MapReport>,
    /// Those on the ground that have heights: the mesh covers them and is within the tolerance there.
    samples: u64,
    /// Samples that are no heights, and heights that no ground reaches: in no cell with two others beside them.
    nodata_samples: u64,
    stray_samples: u64,
    /// Holes that are bridged, and their samples: the mesh covers them and is bound to nothing there. Null where none were to be.
    bridged_holes: Option<u64>,
    bridged_samples: Option<u64>,
    /// Samples on the ground that trimming has left bare.
    trimmed_samples: u64,
    /// The least and the largest height.
    height_range: Option<[f64; 2]>,
    triangles: u64,
    vertices: u64,
    samples_per_triangle: f64,
    /// Null where only a budget was given.
    tolerance: Option<f64>,
    /// Null where the tolerance is all that was asked for.
    goal: Option<GoalReport>,
    engine: EngineChoice,
    quality: Quality,
    heights: VertexHeights,
    feasibility: Feasibility,
    relaxed_triangles: u64,
    tile_cells: usize,
    error: ErrorReport,
    /// Null without polishing.
    shape: Option<ShapeReport>,
    /// Null where there are none.
    channels: Option<ChannelReport>,
    seconds: Seconds,
    samples_per_second: f64,
    /// The largest resident size of the process so far; null where the system does not tell.
    peak_memory_bytes: Option<u64>,
    temporary_bytes: u64,
    /// Tiles that an earlier run had left in the work dir; null where there is none.
    tiles_found: Option<u64>,
    /// What became of the points; null where there are none.
    points: Option<PointsReport>,
    plan: Plan,
    /// What the user should know of the inputs.
    warnings: Shown,
}

/// The weights, and what they made of the errors.
#[derive(Debug, Clone, Serialize)]
struct ImportanceReport {
    file: String,
    access: Access,
    /// The largest error × weight.
    weighted_max: f64,
}

/// Polygons outside of which samples count as samples without a height.
#[derive(Debug, Clone, Serialize)]
struct CutlineReport {
    file: String,
    polygons: u64,
    vertices: u64,
}

/// Points that were asked to be vertices.
#[derive(Debug, Clone, Serialize)]
struct PointsReport {
    file: String,
    layer: String,
    #[serde(flatten)]
    counts: PointCounts,
}

/// What a run will need, before it begins.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Needs {
    /// How the density was found.
    #[serde(skip)]
    pub(super) found_by: &'static str,
    pub(super) estimate: Estimate,
    pub(super) memory: Plan,
    /// Null without a work dir.
    pub(super) work_dir: Option<WorkDirReport>,
    /// What the user should know of the inputs.
    pub(super) warnings: Shown,
}

/// What is left to be done in a work dir.
#[derive(Debug, Clone, Serialize)]
pub(super) struct WorkDirReport {
    /// Tiles of the first pass in all.
    pub(super) tiles: u64,
    /// Tiles of the second pass in all, over the seams; 0 where there is none.
    pub(super) seams: u64,
    /// What is there of both.
    pub(super) finished: Finished,
}

impl WorkDirReport {
    fn line(&self) -> String {
        let Finished { tiles, seams, bytes } = self.finished;
        let kept = match bytes {
            0 => String::new(),
            bytes => format!("; {} are kept", BinaryBytes(bytes)),
        };
        let second = match self.seams {
            0 => String::new(),
            all => format!(", {seams} of {all} in the second pass"),
        };
        format!("{tiles} of {} tiles are finished{second}{kept}", self.tiles)
    }
}

impl Needs {
    /// As names and values.
    pub(super) fn lines(&self) -> Vec<(&'static str, String)> {
        let Estimate { field_bytes, spool_bytes, survey_bytes, output_bytes, samples_per_triangle } = self.estimate;
        let temporary = field_bytes.saturating_add(spool_bytes).saturating_add(survey_bytes);
        let Plan { budget_bytes, threads, needed_bytes, .. } = self.memory;
        let mut lines = vec![
            ("density", format!("about {samples_per_triangle:.1} samples per triangle, {}", self.found_by)),
            (
                "memory",
                format!("up to {} of {} with {threads} threads", BinaryBytes(needed_bytes), BinaryBytes(budget_bytes)),
            ),
            ("disk", format!("{} of temporary files", BinaryBytes(temporary))),
            ("output", format!("about {}", BinaryBytes(output_bytes))),
        ];
        lines.extend(self.work_dir.as_ref().map(|report| ("work dir", report.line())));
        lines
    }
}

/// Vertical distances between mesh and samples, over all samples. The shares are those of distance × weight where there
/// are weights.
#[derive(Debug, Clone, Serialize)]
struct ErrorReport {
    max: f64,
    column: u64,
    row: u64,
    x: f64,
    y: f64,
    rms: f64,
    p50: f64,
    p95: f64,
    p99: f64,
}

/// The shapes of the triangles, seen from above with square cells, and how far edges stray between samples.
#[derive(Debug, Clone, Serialize)]
struct ShapeReport {
    /// The smallest angle of a triangle, in degrees: a share of the triangles has at most so much.
    angle_p5: f64,
    angle_p50: f64,
    /// How many triangles by the whole degrees of their smallest angle.
    smallest_angles: Vec<u64>,
    /// The share of the edges that stray farther than the tolerance from the grid's edges and diagonals, and how far the
    /// farthest does, in the units of the heights.
    edges_beyond: f64,
    overshoot_max: f64,
    /// What 99 % of the edges do not exceed, as a share of the tolerance.
    overshoot_p99: f64,
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
        }
    }

    fn line(&self) -> String {
        format!(
            "smallest angles: 5 % up to {:.0}°, half up to {:.0}°; edges between samples: {:.2} % stray beyond, up to {:.4}",
            self.angle_p5,
            self.angle_p50,
            100.0 * self.edges_beyond,
            self.overshoot_max
        )
    }
}

/// Seconds by stage, on the clock; `threads` are seconds of all threads together within `tiles`.
#[derive(Debug, Clone, Copy, Serialize)]
pub(super) struct Seconds {
    pub(super) total: f64,
    /// Opening the raster, decoding it where it cannot be mapped, and finding holes to bridge.
    pub(super) open: f64,
    pub(super) tiles: f64,
    pub(super) write: f64,
    pub(super) threads: TileTimes,
}

impl Report {
    pub(super) fn new(
        field: &Field,
        params: &Params,
        plan: Plan,
        output: &Path,
        summary: &Summary,
        seconds: Seconds,
        mesh: &Mesh,
    ) -> Report {
        let errors = &summary.errors;
        let (column, row) = errors.worst;
        let steps = i64::from(STEPS);
        let (x, y) = field.geo_transform().apply(column as i64 * steps, row as i64 * steps);
        let percentile = |share| errors.percentile(share, mesh.error_scale());
        Report {
            input: field.name().display().to_string(),
            output: output.display().to_string(),
            access: field.access().clone(),
            importance: field.importance().map(|weights| ImportanceReport {
                file: weights.name().display().to_string(),
                access: weights.access().clone(),
                weighted_max: errors.weighted_max,
            }),
            band: 1,
            bands: 1,
            band_description: String::new(),
            encoding: None,
            window: None,
            cutline: None,
            map: None,
            samples: errors.samples,
            nodata_samples: errors.nodata,
            stray_samples: errors.stray,
            bridged_holes: None,
            bridged_samples: None,
            trimmed_samples: errors.trimmed,
            triangles: summary.triangles,
            vertices: summary.vertices,
            samples_per_triangle: errors.samples as f64 / summary.triangles as f64,
            height_range: errors.heights.map(|h| h.all()).filter(|e| !e.is_empty()).map(|e| [e.min, e.max]),
            tolerance: Some(params.tolerance.asked()).filter(|t| t.is_finite()),
            goal: mesh.outcome().map(|outcome| GoalReport::new(params.goal, !params.tolerance.is_open(), outcome)),
            engine: params.engine,
            quality: params.quality,
            heights: params.heights,
            feasibility: params.feasibility,
            relaxed_triangles: summary.relaxed,
            tile_cells: params.tile,
            error: ErrorReport {
                max: errors.max,
                column,
                row,
                x,
                y,
                rms: errors.rms(),
                p50: percentile(0.5),
                p95: percentile(0.95),
                p99: percentile(0.99),
            },
            shape: errors.shape.as_deref().map(ShapeReport::new),
            channels: None,
            samples_per_second: errors.samples as f64 / seconds.total,
            seconds,
            peak_memory_bytes: peak_memory(),
            temporary_bytes: field.decoded_bytes() + mesh.spool_bytes(),
            tiles_found: None,
            points: None,
            plan,
            warnings: Shown::default(),
        }
    }

    /// With what the user should know of the inputs.
    pub(super) fn warnings(self, warnings: Shown) -> Report {
        Report { warnings, ..self }
    }

    /// See [`Shown::print`].
    pub(super) fn print_warnings(&self) {
        self.warnings.print();
    }

    /// Which band of the raster it is, and which part.
    pub(super) fn raster(self, raster: &Raster) -> Report {
        Report {
            band: raster.band(),
            bands: raster.band_count(),
            band_description: raster.band_description(),
            encoding: raster.encoding(),
            window: raster.window().map(|w| [w.column, w.row, w.width, w.height]),
            ..self
        }
    }

    /// Of a run that bridges holes: those that it has found.
    pub(super) fn holes(self, holes: Option<&Holes>) -> Report {
        let (count, samples) = holes.map_or((0, 0), |holes| (holes.count(), holes.samples()));
        Report { bridged_holes: Some(count), bridged_samples: Some(samples), ..self }
    }

    /// Of a run inside polygons, read from this file.
    pub(super) fn cutline(self, file: &Path, cutline: &Cutline) -> Report {
        let (polygons, vertices) = cutline.counts();
        Report { cutline: Some(CutlineReport { file: file.display().to_string(), polygons, vertices }), ..self }
    }

    /// What coordinates mean and how they are written.
    pub(super) fn map(self, map: MapReport) -> Report {
        Report { map: Some(map), ..self }
    }

    /// Of a run with channels.
    pub(super) fn channels(self, channels: ChannelReport) -> Report {
        Report { channels: Some(channels), ..self }
    }

    /// Of a run with a work dir: how many finished tiles were there at its beginning.
    pub(super) fn tiles_found(self, tiles: u64) -> Report {
        Report { tiles_found: Some(tiles), ..self }
    }

    /// Of a run with points, read from this file.
    pub(super) fn points(self, file: &Path, points: &Points) -> Report {
        let (file, layer) = (file.display().to_string(), points.layer.clone());
        Report { points: Some(PointsReport { file, layer, counts: points.counts }), ..self }
    }

    /// The report as names and values.
    pub(super) fn lines(&self) -> Vec<(&'static str, String)> {
        let Seconds { total, open, tiles, write, threads: t } = self.seconds;
        let e = &self.error;
        let mut lines = vec![("samples", format!("{}, {}", grouped(self.samples), access(&self.access)))];
        if self.bands > 1 && self.encoding.is_none() {
            lines.push(("heights of", print::band(self.band, self.bands, &self.band_description)));
        }
        if let Some([min, max]) = self.height_range {
            lines.push(("range", format!("heights from {} to {}", Decimal(min), Decimal(max))));
        }
        if self.nodata_samples > 0 {
            lines.push(("nodata", self.nodata()));
        }
        if let (Some(holes), Some(samples)) = (self.bridged_holes, self.bridged_samples) {
            lines.push((
                "bridged",
                format!("{} holes of {} samples without a height", grouped(holes), grouped(samples)),
            ));
        }
        if self.trimmed_samples > 0 {
            lines.push(("trimmed", format!("{} samples of the ground are not covered", grouped(self.trimmed_samples))));
        }
        lines.extend([
            ("triangles", format!("{}, {:.1} samples each", grouped(self.triangles), self.samples_per_triangle)),
            ("vertices", grouped(self.vertices)),
        ]);
        if let Some([column, row, width, height]) = self.window {
            let from = format!("from column {column}, row {row} of the raster on, where columns and rows count as 0");
            lines.push(("window", format!("{width} × {height} samples {from}")));
        }
        if let Some(CutlineReport { file, polygons, vertices }) = &self.cutline {
            let (polygons, vertices) = (grouped(*polygons), grouped(*vertices));
            lines.push(("cutline", format!("{polygons} polygons with {vertices} vertices, of {file}")));
        }
        lines.extend(self.map.iter().flat_map(MapReport::lines));
        let place = format!("at column {}, row {} ({}, {})", e.column, e.row, e.x, e.y);
        let shares = format!("50 % up to {:.4}, 95 % {:.4}, 99 % {:.4}", e.p50, e.p95, e.p99);
        match &self.importance {
            None => lines.extend([
                ("max error", format!("{}{}, {place}", e.max, self.allowed())),
                ("errors", format!("RMS {:.4}; {shares}", e.rms)),
            ]),
            Some(weights) => lines.extend([
                ("importance", format!("{}, {}", weights.file, access(&weights.access))),
                ("weighted", format!("error × weight up to {}{}; {shares}", weights.weighted_max, self.allowed())),
                ("max error", format!("{}, {place}", e.max)),
                ("errors", format!("RMS {:.4}", e.rms)),
            ]),
        }
        lines.extend(self.channels.iter().flat_map(ChannelReport::lines));
        if let Some(shape) = &self.shape {
            lines.push(("shape", shape.line()));
        }
        if let Some(goal) = &self.goal {
            lines.push(("goal", goal.line(self.vertices, self.triangles)));
        }
        if self.feasibility == Feasibility::Strong {
            lines.push(("relaxed", format!("{} triangles are weakly feasible only", grouped(self.relaxed_triangles))));
        }
        if let Some(points) = &self.points {
            lines.push(("points", points.line()));
        }
        if let Some(tiles @ 1..) = self.tiles_found {
            lines.push(("continued", format!("{} tiles were in the work dir", grouped(tiles))));
        }
        let rate = self.samples_per_second / 1e6;
        lines.extend([
            (
                "time",
                format!(
                    "{total:.2} s, {rate:.1} M samples/s: open {open:.2} s, tiles {tiles:.2} s, write {write:.2} s"
                ),
            ),
            (
                "threads",
                format!(
                    "load {:.2} s, seams {:.2} s, engine {:.2} s, polish {:.2} s, measure {:.2} s, spool {:.2} s",
                    t.load, t.seams, t.engine, t.polish, t.measure, t.spool
                ),
            ),
            ("memory", self.memory()),
            ("disk", format!("{} of temporary files", BinaryBytes(self.temporary_bytes))),
        ]);
        lines
    }
}

impl PointsReport {
    fn line(&self) -> String {
        let PointCounts { read, used, merged, outside } = self.counts;
        let [read, used, merged, outside] = [read, used, merged, outside].map(grouped);
        format!(
            "{used} vertices from {read} points of layer {}; {merged} at a place taken, {outside} outside",
            self.layer
        )
    }
}

impl Report {
    /// Whether a quality was asked for that a budget did not allow.
    pub(super) fn fell_short(&self) -> bool {
        self.goal.as_ref().is_some_and(GoalReport::fell_short)
    }

    fn allowed(&self) -> String {
        self.tolerance.map_or(String::new(), |tolerance| format!(" of {tolerance} allowed"))
    }

    fn nodata(&self) -> String {
        let stray = match self.stray_samples {
            0 => String::new(),
            n => format!(", and {} heights in no cell with two others: not covered", grouped(n)),
        };
        format!("{} samples{stray}", grouped(self.nodata_samples))
    }

    fn memory(&self) -> String {
        let peak = self.peak_memory_bytes.map_or("unknown".to_string(), |b| BinaryBytes(b).to_string());
        let threads =
            if self.plan.threads == 1 { "1 thread".to_string() } else { format!("{} threads", self.plan.threads) };
        format!("{peak} at its peak, of {} allowed; {threads}", BinaryBytes(self.plan.budget_bytes))
    }
}

fn access(access: &Access) -> String {
    match access {
        Access::InPlace => "mapped in place".to_string(),
        Access::Windows { reason } => format!("read by windows: {reason}"),
        Access::Decoded { reason, .. } => format!("decoded: {reason}"),
        Access::Memory => "in memory".to_string(),
    }
}

/// 1234567 as 1 234 567.
fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let groups: Vec<&str> =
        digits.as_bytes().rchunks(3).rev().map(|g| std::str::from_utf8(g).expect("digits")).collect();
    groups.join(" ")
}

/// The process's largest resident size, from the kernel.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix(" kB")?.trim().parse::<u64>().ok().map(|kib| kib << 10)
}

#[cfg(test)]
mod tests {
    #[test]
    fn numbers_are_grouped_by_thousands() {
        assert_eq!(super::grouped(7), "7");
        assert_eq!(super::grouped(1_234_567), "1 234 567");
        assert_eq!(super::grouped(123_456), "123 456");
    }
}
