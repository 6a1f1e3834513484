//! Reports for people: lines of a name and a value.

use std::fmt;

use super::{
    AttributeReport, CutlineReport, GoalReport, LinesReport, MapReport, Needs, PointsReport, Report, Seconds,
    ShapeReport, WorkDirState,
};
use crate::base::decimal::Decimal;
use crate::base::{PointCounts, Reference};
use crate::field::Access;
use crate::job::plan::{Estimate, Plan};
use crate::job::work_dir::Finished;
use crate::job::{Budget, Searched};
use crate::kernel::breaklines::{ChainCounts, LineCounts};
use crate::kernel::triangulate::Feasibility;
use crate::run::ConvertReport;

/// A name and a value.
pub type Line = (&'static str, String);

impl Report {
    /// The report as names and values.
    pub fn lines(&self) -> Vec<Line> {
        let Seconds { total, open, tiles, write, threads: t } = self.seconds;
        let e = &self.error;
        let mut lines = vec![("samples", format!("{}, {}", grouped(self.samples), access(&self.access)))];
        if self.bands > 1 && self.encoding.is_none() {
            lines.push(("heights of", band(self.band, self.bands, &self.band_description)));
        }
        if let Some([min, max]) = self.height_range {
            lines.push(("range", format!("heights from {} to {}", Decimal(min), Decimal(max))));
        }
        if self.missing_samples > 0 {
            lines.push(("missing", self.missing()));
        }
        if self.filled_voids > 0 {
            let voids = counted(self.filled_voids, "void");
            lines.push(("filled", format!("{voids} of {}", counted(self.filled_samples, "sample"))));
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
        lines.extend(self.cutline.iter().map(|cutline| ("cutline", cutline.line())));
        lines.extend(self.map.lines());
        let place = format!("at column {}, row {} ({}, {})", e.column, e.row, e.x, e.y);
        let shares = format!("50 % up to {:.4}, 95 % {:.4}, 99 % {:.4}", e.p50, e.p95, e.p99);
        match &self.importance {
            None => lines.extend([
                ("max error", format!("{}{}, {place}", e.max, self.allowed())),
                ("errors", format!("RMS {:.4}; {shares}", e.rms)),
            ]),
            Some(weights) => lines.extend([
                ("importance", format!("{}, {}", weights.file, access(&weights.access))),
                (
                    "weighted",
                    format!("error × weight up to {}{}; {shares}", weights.max_weighted_error, self.allowed()),
                ),
                ("max error", format!("{}, {place}", e.max)),
                ("errors", format!("RMS {:.4}", e.rms)),
            ]),
        }
        lines.extend(self.attributes.iter().flat_map(AttributeReport::lines));
        lines.extend(self.shape.iter().map(|shape| ("shape", shape.line())));
        lines.extend(self.goal.iter().map(|goal| ("goal", goal.line(self.vertices, self.triangles))));
        if self.feasibility == Feasibility::Strong {
            lines.push(("relaxed", format!("{} triangles are weakly feasible only", grouped(self.relaxed_triangles))));
        }
        lines.extend(self.points.iter().map(|points| ("points", points.line())));
        lines.extend(self.breaklines.iter().map(|breaklines| ("breaklines", breaklines.line())));
        lines.extend(self.lakes.iter().map(|lakes| ("lakes", lakes.line())));
        lines.extend(self.footprints.iter().map(|footprints| ("footprints", footprints.line())));
        lines.extend(self.exact_cutline.iter().map(|cutline| ("cutline", cutline.line())));
        lines.extend((self.beside_lines > 0).then(|| {
            let samples = counted(self.beside_lines, "sample");
            ("beside lines", format!("{samples} between the raster's height and a line's"))
        }));
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

    fn allowed(&self) -> String {
        self.tolerance.map_or(String::new(), |tolerance| format!(" of {tolerance} allowed"))
    }

    fn missing(&self) -> String {
        let isolated = match self.isolated_samples {
            0 => String::new(),
            n => format!(", and {} isolated: heights in no cell with two others, not covered", grouped(n)),
        };
        format!("{} samples{isolated}", grouped(self.missing_samples))
    }

    fn memory(&self) -> String {
        let peak = self.peak_memory_bytes.map_or("unknown".to_string(), |b| BinaryBytes(b).to_string());
        let threads = counted(self.memory.threads as u64, "thread");
        format!("{peak} at its peak, of {} allowed; {threads}", BinaryBytes(self.memory.budget_bytes))
    }
}

impl Needs {
    /// What a run will need as names and values.
    pub fn lines(&self) -> Vec<Line> {
        let Estimate { field_bytes, spool_bytes, survey_bytes, output_bytes, samples_per_triangle } = self.estimate;
        let temporary = field_bytes.saturating_add(spool_bytes).saturating_add(survey_bytes);
        let Plan { budget_bytes, threads, needed_bytes, .. } = self.memory;
        let mut lines =
            vec![("density", format!("about {samples_per_triangle:.1} samples per triangle, {}", self.found_by))];
        lines.extend(self.tolerance.map(|tolerance| ("tolerance", format!("looked for, from about {tolerance} on"))));
        lines.extend(self.thread_seconds.map(|seconds| ("time", about(seconds, threads))));
        lines.extend([
            (
                "memory",
                format!(
                    "up to {} of {} with {}",
                    BinaryBytes(needed_bytes),
                    BinaryBytes(budget_bytes),
                    counted(threads as u64, "thread")
                ),
            ),
            ("disk", format!("{} of temporary files", BinaryBytes(temporary))),
            ("output", format!("about {}", BinaryBytes(output_bytes))),
        ]);
        lines.extend(self.work_dir.as_ref().map(|state| ("work dir", state.line())));
        lines
    }
}

/// About how long so many seconds of threads are on the clock.
fn about(seconds: f64, threads: usize) -> String {
    let clock = seconds / threads.max(1) as f64;
    let said = match clock {
        s if s < 90.0 => format!("{s:.0} s"),
        s if s < 5400.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    };
    format!("about {said} with {} here", counted(threads as u64, "thread"))
}

impl WorkDirState {
    fn line(&self) -> String {
        let Finished { tiles, seams, crossings, runs, bytes } = self.finished;
        let kept = match bytes {
            0 => String::new(),
            bytes => format!("; {} are kept", BinaryBytes(bytes)),
        };
        if runs > 0 {
            return format!("{} of the search finished{kept}", counted(runs, "run"));
        }
        let second = match self.seams {
            0 => String::new(),
            all => format!(", {seams} of {all} in the second pass"),
        };
        let last = match self.crossings {
            0 => String::new(),
            all => format!(", {crossings} of {all} in the last two"),
        };
        format!("{tiles} of {} tiles are finished{second}{last}{kept}", self.tiles)
    }
}

impl CutlineReport {
    fn line(&self) -> String {
        let polygons = counted(self.polygons, "polygon");
        let of = if self.file.is_empty() { String::new() } else { format!(", of {}", self.file) };
        format!("{polygons} with {} vertices{of}", grouped(self.vertices))
    }
}

impl LinesReport {
    fn line(&self) -> String {
        let LineCounts { lines, left_out, segments, .. } = self.counts;
        let read = format!("{} with {}", counted(lines, "line"), counted(segments, "segment"));
        let outside =
            if left_out > 0 { format!(", {} of the lines outside", grouped(left_out)) } else { String::new() };
        let ChainCounts { edges, off_ground } = self.chains;
        let soft = if self.soft_edges > 0 { format!(" ({} soft)", grouped(self.soft_edges)) } else { String::new() };
        let edges = counted(edges, "edge");
        format!("{edges}{soft} follow {read}, {} of these off the ground{outside}", grouped(off_ground))
    }
}

impl PointsReport {
    fn line(&self) -> String {
        let PointCounts { read, used, merged, outside } = self.counts;
        let [read, used, merged, outside] = [read, used, merged, outside].map(grouped);
        let of = if self.layer.is_empty() { String::new() } else { format!(" of layer {}", self.layer) };
        format!("{used} vertices from {read} points{of}; {merged} at a place taken, {outside} outside")
    }
}

impl GoalReport {
    /// `vertices` and `triangles` are what the mesh has.
    fn line(&self, vertices: u64, triangles: u64) -> String {
        if let Some(search) = &self.outcome.search {
            return self.searched(search, vertices, triangles);
        }
        let (what, used, most) = match self.outcome.ended_by {
            None => return format!("reached with all errors above {} inserted", self.outcome.threshold),
            Some(Budget::MaxPoints) => ("vertices", vertices, self.goal.max_points),
            Some(Budget::MaxTriangles) => ("triangles", triangles, self.goal.max_triangles),
        };
        let most = most.unwrap_or(used);
        let short = if self.fell_short() { "; the quality that was asked for is not reached" } else { "" };
        format!(
            "ended by the budget: {used} of {most} {what}, {} not spent; errors down to {} inserted{short}",
            most - used,
            self.outcome.threshold
        )
    }
}

impl GoalReport {
    /// What a search for a tolerance came to.
    fn searched(&self, search: &Searched, vertices: u64, triangles: u64) -> String {
        let runs = if search.runs == 1 { "1 run" } else { &format!("{} runs", search.runs) };
        let found = format!("tolerance {} found in {runs}", search.tolerance);
        let Some(budget) = self.outcome.ended_by else { return format!("reached: {found}") };
        let (what, used, most, beyond) = match budget {
            Budget::MaxPoints => ("vertices", vertices, self.goal.max_points, search.exceeded_vertices),
            Budget::MaxTriangles => ("triangles", triangles, self.goal.max_triangles, search.exceeded_triangles),
        };
        let most = most.unwrap_or(used);
        let share = 100.0 * used as f64 / most.max(1) as f64;
        let beyond = match (search.exceeded_at, beyond) {
            (Some(at), Some(beyond)) if share < 97.0 => format!("; at {at} there would be {}", grouped(beyond)),
            _ => String::new(),
        };
        let short = if self.fell_short() { "; the quality that was asked for is not reached" } else { "" };
        let (used, most) = (grouped(used), grouped(most));
        format!("ended by the budget: {used} of {most} {what}, {share:.1} %; {found}{beyond}{short}")
    }
}

impl AttributeReport {
    fn lines(&self) -> [Line; 2] {
        let ranges = self.attributes.iter().zip(&self.ranges.channels);
        let ranges: Vec<String> = ranges.map(|(c, r)| format!("{} {} to {}", c.name, r.min, r.max)).collect();
        let AttributeReport { max_error, column, row, weight, .. } = self;
        [
            ("attributes", format!("{}; weight {weight}, unit {}", ranges.join(", "), self.ranges.unit)),
            ("with heights", format!("errors of both up to {max_error}, at column {column}, row {row}")),
        ]
    }
}

impl ShapeReport {
    fn line(&self) -> String {
        format!(
            "smallest angles: 5 % up to {:.0}°, half up to {:.0}°; edges between samples: {:.2} % stray beyond, up to {:.4}",
            self.angle_p5,
            self.angle_p50,
            100.0 * self.edges_beyond,
            self.overshoot_max
        ) + &match self.edges_astray {
            0 => String::new(),
            edges => format!("; {edges} could not be kept within the limit on straying"),
        }
    }
}

impl ConvertReport {
    /// The report as names and values.
    pub fn lines(&self) -> Vec<Line> {
        let mut lines = vec![
            ("format", format!("{} from {}", self.format, self.input_format)),
            ("triangles", grouped(self.triangles)),
            ("vertices", grouped(self.vertices)),
        ];
        if !self.attributes.is_empty() {
            let names: Vec<&str> = self.attributes.iter().map(|channel| channel.name.as_str()).collect();
            lines.push(("attributes", names.join(", ")));
        }
        let written = written(self.offset, self.xy_scale, self.z_scale, self.precision);
        if !written.is_empty() {
            lines.push(("written", written.join("; ")));
        }
        if self.loss > 0.0 {
            lines.push(("loss", format!("heights are up to {:.1e} from those of the input", self.loss)));
        }
        lines.extend(self.max_error.map(|error| ("max error", error.to_string())));
        lines
    }
}

/// How coordinates stand in the output, in words.
fn written(offset: (f64, f64), xy_scale: (f64, f64), z_scale: f64, precision: &str) -> Vec<String> {
    let mut written = Vec::new();
    if offset != (0.0, 0.0) {
        written.push(format!("x less {}, y less {}", offset.0, offset.1));
    }
    if xy_scale != (1.0, 1.0) {
        written.push(format!("in metres: x × {}, y × {}", xy_scale.0, xy_scale.1));
    }
    if z_scale != 1.0 {
        written.push(format!("z is height × {z_scale}"));
    }
    if precision == "float" {
        written.push("single precision".to_string());
    }
    written
}

impl MapReport {
    fn lines(&self) -> Vec<Line> {
        let mut lines = vec![("map", place(&self.reference)), ("heights", heights(&self.reference))];
        lines.retain(|(_, value)| !value.is_empty());
        let mut written = written(self.offset, self.xy_scale, self.z_scale, self.precision);
        if self.kept_for_rounding > 0.0 {
            written.push(format!("{:.1e} of the tolerance is kept for rounding heights", self.kept_for_rounding));
        }
        if !written.is_empty() {
            lines.push(("written", written.join("; ")));
        }
        lines
    }
}

/// Where on the map coordinates are, in words.
pub fn place(reference: &Reference) -> String {
    let Reference { crs, georeferenced, geographic, longitudes_beyond_180, unit, .. } = reference;
    match (georeferenced, crs.as_str()) {
        (false, "none") => "no georeferencing: plain pixel coordinates, x = column + ½, y = −(row + ½)".to_string(),
        (false, crs) => format!("{crs}, but no geotransform: plain pixel coordinates, x = column + ½, y = −(row + ½)"),
        (true, "none") => "no CRS: coordinates as the geotransform has them".to_string(),
        (true, crs) if *geographic => {
            let beyond = if *longitudes_beyond_180 { ", longitudes beyond 180 kept as they are" } else { "" };
            format!("{crs}: {unit}s across{beyond}, heights in another unit; a projected CRS makes them alike")
        }
        (true, crs) => format!("{crs}, unit {}", if unit.is_empty() { "not said" } else { unit }),
    }
}

/// What heights are in, in words; empty where nothing is said.
pub fn heights(reference: &Reference) -> String {
    match (reference.vertical_crs.as_str(), reference.height_unit.as_str()) {
        ("", "") => String::new(),
        ("", unit) => format!("unit {unit}"),
        (crs, "") => format!("{crs}, unit not said"),
        (crs, unit) => format!("{crs}, unit {unit}"),
    }
}

/// Which of how many bands, and what it is said to hold, in words.
pub fn band(number: usize, of: usize, description: &str) -> String {
    let of = if of > 1 { format!(" of {of}") } else { String::new() };
    let said = if description.is_empty() { String::new() } else { format!(" ({description})") };
    format!("band {number}{of}{said}")
}

fn access(access: &Access) -> String {
    match access {
        Access::InPlace => "mapped in place".to_string(),
        Access::Windows { reason } => format!("read by windows: {reason}"),
        Access::Decoded { reason, .. } => format!("decoded: {reason}"),
        Access::Memory => "in memory".to_string(),
    }
}

/// A number of things: 1 void, 2 voids.
fn counted(number: u64, thing: &str) -> String {
    let s = if number == 1 { "" } else { "s" };
    format!("{} {thing}{s}", grouped(number))
}

/// 1234567 as 1 234 567.
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let groups: Vec<&str> =
        digits.as_bytes().rchunks(3).rev().map(|g| std::str::from_utf8(g).expect("digits")).collect();
    groups.join(" ")
}

/// Bytes with a binary prefix and two decimals: 1.50 KiB.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BinaryBytes(pub u64);

impl fmt::Display for BinaryBytes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const UNITS: [&str; 6] = ["KiB", "MiB", "GiB", "TiB", "PiB", "EiB"];
        if self.0 < 1024 {
            return write!(f, "{} B", self.0);
        }
        let unit = (63 - self.0.leading_zeros()) / 10;
        let value = self.0 as f64 / (1u64 << (10 * unit)) as f64;
        write!(f, "{value:.2} {}", UNITS[unit as usize - 1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_grouped_by_thousands() {
        assert_eq!(grouped(7), "7");
        assert_eq!(grouped(1_234_567), "1 234 567");
        assert_eq!(grouped(123_456), "123 456");
    }

    #[test]
    fn bytes_have_binary_prefixes() {
        let said = |bytes: u64| BinaryBytes(bytes).to_string();
        assert_eq!([said(0), said(1023), said(1024)], ["0 B", "1023 B", "1.00 KiB"]);
        assert_eq!([said(1536), said(5 << 30), said(u64::MAX)], ["1.50 KiB", "5.00 GiB", "16.00 EiB"]);
    }
}
