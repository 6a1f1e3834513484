//! Everything that was found out about a mesh.

use serde::Serialize;

use super::finding::{EdgePlace, FacePlace, Finding, MapPlace, SamplePlace, TouchPlace, VertexPlace};
use super::{LinesVerdict, StrayVerdict, WeightedVerdict};
use crate::base::decimal::Decimal;

/// Everything that was found out about a mesh. It passes if [`Verdict::failures`] is empty.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Verdict {
    /// The vertical distance that was allowed; where errors are weighted, distance × weight.
    pub tolerance: f64,
    /// Whether errors are weighted by an importance raster.
    #[serde(rename = "has_importance")]
    pub weighted: bool,
    /// Samples of the raster: of the ground, bridged, without a height, and without ground.
    #[serde(rename = "raster_samples")]
    pub samples: u64,
    /// Samples with a height in the ground, which is every cell with four heights and half of every cell with three. Each
    /// is to be in a triangle, and within the tolerance.
    #[serde(rename = "samples")]
    pub checked: u64,
    /// Samples without a height that are not bridged.
    #[serde(rename = "missing_samples")]
    pub nodata: u64,
    /// Holes that are bridged.
    #[serde(rename = "filled_voids")]
    pub bridged_holes: u64,
    /// Their samples. Each is to be in a triangle, at any height.
    #[serde(rename = "filled_samples")]
    pub bridged: u64,
    /// Samples with a height, but in no cell with three. Nothing is asked of a mesh there, so this is no failure.
    #[serde(rename = "isolated")]
    pub without_ground: Finding<SamplePlace>,
    /// The least and the largest height of the raster; `None` where no sample has one.
    pub height_range: Option<[f64; 2]>,
    /// Vertices of the mesh.
    pub vertices: u64,
    /// Faces of the mesh.
    pub triangles: u64,
    /// Where a surface is farthest from its sample; `None` where no sample is covered.
    pub worst: Option<WorstSample>,
    /// Where error × weight is largest; `None` where errors are not weighted, or no sample is covered.
    #[serde(rename = "worst_by_importance")]
    pub weighted_worst: Option<WeightedWorst>,
    /// Root of the mean squared vertical error over the covered samples; 0 where there is none.
    pub rms_error: f64,
    /// Samples farther from a surface than the tolerance, exactly; where errors are weighted, with an error × weight above
    /// it.
    pub above_tolerance: Finding<SamplePlace>,
    /// What was found out about straying; `None` where it was not judged.
    pub stray: Option<StrayVerdict>,
    /// Samples of the ground in no triangle.
    pub uncovered: Finding<SamplePlace>,
    /// Samples in the interior of one triangle and also in another.
    pub overlapped: Finding<SamplePlace>,
    /// Samples without a height in a triangle, its edges and corners included.
    #[serde(rename = "touched_missing")]
    pub touched_nodata: Finding<TouchPlace>,
    /// Faces that turn clockwise, seen from above on the map.
    pub clockwise: Finding<FacePlace>,
    /// Faces whose corners lie on one line.
    pub degenerate: Finding<FacePlace>,
    /// Faces that could not be judged because a corner is nowhere near the raster.
    pub unplaced: Finding<FacePlace>,
    /// Twice the sum of the faces' areas, counter-clockwise positive, in squared quarter cells.
    pub double_area: i128,
    /// Twice the area of the ground, in squared quarter cells.
    pub expected_double_area: i128,
    /// Edges of one face only that do not run along the boundary of the ground with their face on the ground's side: cracks
    /// and T-junctions inside, ground that is missed or exceeded at the boundary.
    pub unmatched_edges: Finding<EdgePlace>,
    /// Edges of more than two faces.
    pub overused_edges: Finding<EdgePlace>,
    /// Edges that two faces share in the same direction.
    pub same_direction_edges: Finding<EdgePlace>,
    /// Sides and diagonals of cells on the ground's boundary that edges of one face do not follow, or not all along.
    pub boundary_gaps: Finding<MapPlace>,
    /// Those that several such edges follow.
    pub boundary_doubled: Finding<MapPlace>,
    /// Vertices at the place of another one.
    pub duplicate_vertices: Finding<VertexPlace>,
    /// Vertices that no face uses.
    pub unused_vertices: Finding<VertexPlace>,
    /// Vertices whose x, y are not, bit for bit, the geotransform applied to a point of the quarter-cell lattice.
    pub off_lattice: Finding<VertexPlace>,
    /// Vertices beyond the rectangle of sample centres.
    pub outside: Finding<VertexPlace>,
    /// Vertices whose height is NaN or infinite.
    pub heights_not_finite: Finding<VertexPlace>,
    /// What the mesh's boundary comes to, where the ground may be trimmed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub trim: Option<TrimVerdict>,
    /// What the mesh's boundary comes to, where it is to be that of a cutline.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cutline: Option<CutlineVerdict>,
    /// What channels come to, where the mesh was judged with some.
    #[serde(rename = "attributes", skip_serializing_if = "Option::is_none")]
    pub extended: Option<WeightedVerdict>,
    /// Samples beside lines with heights of their own, where the surface may be anywhere between sample and line.
    #[serde(skip_serializing_if = "is_none")]
    pub beside_lines: u64,
    /// What became of breaklines, where the mesh was judged with some.
    #[serde(rename = "breaklines", skip_serializing_if = "Option::is_none")]
    pub lines: Option<LinesVerdict>,
}

fn is_none(count: &u64) -> bool {
    *count == 0
}

/// What was found out about the boundary of a mesh that may end short of the ground's.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct TrimVerdict {
    /// The ground may be bare where samples without a height are at most this number of columns and rows away.
    pub cells: u32,
    /// Samples of the ground that are bare there. They are not among those checked.
    #[serde(rename = "trimmed_samples")]
    pub trimmed: u64,
    /// Twice the area of the core, the cells that have no such sample for a corner, in squared quarter cells.
    pub core_double_area: i128,
    /// Stretches of quarter rows where the core is bare.
    pub bare_core: Finding<MapPlace>,
    /// Stretches of quarter rows where faces cover what is no ground.
    pub beyond_ground: Finding<MapPlace>,
    /// Edges of one face only that lie on another one or cross it: cracks, T-junctions, overlaps.
    pub crossed_edges: Finding<EdgePlace>,
    /// Edges of one face only beside which several faces lie upon each other.
    pub overlapping_edges: Finding<EdgePlace>,
    /// Regions of bare ground that border on nothing but faces.
    pub enclosed: Finding<MapPlace>,
}

/// What was found out about the boundary of a mesh that is to end at a cutline's own line. Then samples outside of it are among those
/// missing, and isolated are all inside that are in no face: where there is ground is told by quarter rows, samples or not.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct CutlineVerdict {
    /// Stretches of quarter rows inside where the ground is bare.
    pub bare: Finding<MapPlace>,
    /// Stretches of quarter rows where faces cover what is outside, or no ground.
    pub beyond: Finding<MapPlace>,
    /// Edges of one face only that lie on another one or cross it: cracks, T-junctions, overlaps.
    pub crossed_edges: Finding<EdgePlace>,
    /// Edges of one face only beside which several faces lie upon each other.
    pub overlapping_edges: Finding<EdgePlace>,
}

/// The sample that is farthest from the surface.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct WorstSample {
    /// The vertical distance: rounded; but where errors are not weighted, at most the tolerance if and only if the exact
    /// distance is.
    pub error: f64,
    /// Which sample; the first one in row order where several are as far.
    #[serde(flatten)]
    pub place: SamplePlace,
    /// The raster's height.
    pub raster_height: f64,
    /// The surface's height, rounded.
    pub surface_height: f64,
    /// The face it was measured in.
    pub face: u64,
}

/// The sample whose error weighs most.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct WeightedWorst {
    /// Error × weight: rounded, but at most the tolerance if and only if the exact product is.
    pub weighted_error: f64,
    /// The weight there.
    pub weight: f64,
    /// The sample; the first one in row order where several weigh as much.
    #[serde(flatten)]
    pub sample: WorstSample,
}

impl Verdict {
    /// Whether the mesh keeps the promise: within the tolerance at every sample, and one whole surface.
    pub fn passes(&self) -> bool {
        self.failures().is_empty()
    }

    /// What is wrong, one sentence for each kind of fault.
    pub fn failures(&self) -> Vec<String> {
        let mut out = Vec::new();
        let tolerance = self.tolerance;
        if self.weighted {
            let what = format!("an error × weight above {tolerance}");
            list(&mut out, &self.above_tolerance, "sample has", "samples have", &what);
        } else {
            list(&mut out, &self.above_tolerance, "sample is", "samples are", &format!("farther than {tolerance}"));
        }
        if let Some(extended) = &self.extended {
            let what = format!("above {tolerance} in the error of heights and attributes together");
            list(&mut out, &extended.above_tolerance, "sample is", "samples are", &what);
        }
        if let Some(stray) = &self.stray {
            out.extend(stray.failure(self));
        }
        if let Some(lines) = &self.lines {
            let what = "followed by edges of the mesh";
            list(&mut out, &lines.broken, "stretch of a breakline is not", "stretches of breaklines are not", what);
            list(&mut out, &lines.not_level, "vertex in a lake is", "vertices in lakes are", "not level with it");
        }
        list(&mut out, &self.uncovered, "sample is", "samples are", "in no triangle");
        list(&mut out, &self.overlapped, "sample is", "samples are", "in several triangles");
        list(&mut out, &self.touched_nodata, "missing sample is", "missing samples are", "in a triangle");
        list(&mut out, &self.clockwise, "face turns", "faces turn", "clockwise seen from above");
        list(&mut out, &self.degenerate, "face has", "faces have", "no area");
        list(&mut out, &self.unplaced, "face has", "faces have", "a corner nowhere near the raster");
        let (found, expected) = (self.double_area, self.expected_double_area);
        let least = self.trim.map_or(expected, |trim| trim.core_double_area);
        if !(least..=expected).contains(&found) {
            let core = self.trim.map_or(String::new(), |_| format!(" and that of its core {least}"));
            let what = format!("squared quarter cells where that of the ground is {expected}{core}");
            out.push(format!("twice the area is {found} {what}"));
        }
        if let Some(trim) = &self.trim {
            trim.list_failures(&mut out);
        }
        if let Some(cutline) = &self.cutline {
            cutline.list_failures(&mut out);
        }
        list(
            &mut out,
            &self.unmatched_edges,
            "edge has",
            "edges have",
            "a face on one side only and not the boundary of the ground (crack, T-junction, ground missed or exceeded)",
        );
        list(&mut out, &self.overused_edges, "edge has", "edges have", "more than two faces");
        list(&mut out, &self.same_direction_edges, "edge has", "edges have", "two faces on the same side (fold)");
        let (one, many) = ("stretch of the ground's boundary is", "stretches of the ground's boundary are");
        list(&mut out, &self.boundary_gaps, one, many, "not on the mesh's boundary");
        list(&mut out, &self.boundary_doubled, one, many, "followed by several edges");
        list(&mut out, &self.duplicate_vertices, "vertex is", "vertices are", "at the place of another");
        list(&mut out, &self.unused_vertices, "vertex is", "vertices are", "in no face");
        list(&mut out, &self.off_lattice, "vertex is", "vertices are", "off the lattice of quarter cells");
        list(&mut out, &self.outside, "vertex is", "vertices are", "outside the raster");
        list(&mut out, &self.heights_not_finite, "vertex has", "vertices have", "no finite height");
        out
    }
}

impl TrimVerdict {
    /// "3 cells"
    fn distance(&self) -> String {
        if self.cells == 1 { "1 cell".to_string() } else { format!("{} cells", self.cells) }
    }

    fn list_failures(&self, out: &mut Vec<String>) {
        let cells = self.distance();
        let (one, many) = ("stretch of a quarter row is", "stretches of quarter rows are");
        list(out, &self.bare_core, one, many, &format!("uncovered more than {cells} from missing samples"));
        list(out, &self.beyond_ground, one, many, "covered beyond the ground");
        list_edges(out, &self.crossed_edges, &self.overlapping_edges);
        let (one, many) = ("uncovered region of the ground is", "uncovered regions of the ground are");
        list(out, &self.enclosed, one, many, "enclosed by faces (crack, hole)");
    }
}

impl CutlineVerdict {
    fn list_failures(&self, out: &mut Vec<String>) {
        let (one, many) = ("stretch of a quarter row is", "stretches of quarter rows are");
        list(out, &self.bare, one, many, "uncovered inside of the cutline");
        list(out, &self.beyond, one, many, "covered beyond the cutline or the ground");
        list_edges(out, &self.crossed_edges, &self.overlapping_edges);
    }
}

fn list_edges(out: &mut Vec<String>, crossed: &Finding<EdgePlace>, overlapping: &Finding<EdgePlace>) {
    let what = "a face on one side only and on or across another such edge (crack, T-junction, overlap)";
    list(out, crossed, "edge has", "edges have", what);
    list(out, overlapping, "edge has", "edges have", "several faces upon each other beside it (overlap)");
}

/// "3 samples are in no triangle, the first at …"
fn list<P: std::fmt::Display>(out: &mut Vec<String>, finding: &Finding<P>, one: &str, many: &str, what: &str) {
    match (&finding.first, finding.count) {
        (None, _) => {}
        (Some(first), 1) => out.push(format!("1 {one} {what}: {first}")),
        (Some(first), count) => out.push(format!("{count} {many} {what}, the first: {first}")),
    }
}

impl std::fmt::Display for Verdict {
    /// Several lines: what was compared, the errors, and PASS, or FAIL with the failures.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        writeln!(f, "{} samples, {} vertices, {} triangles", self.samples, self.vertices, self.triangles)?;
        if let Some([min, max]) = self.height_range {
            writeln!(f, "heights from {} to {}", Decimal(min), Decimal(max))?;
        }
        if self.nodata + self.bridged > 0 {
            let Verdict { checked, nodata, bridged, bridged_holes, without_ground, .. } = self;
            write!(f, "ground: {checked} samples; missing: {nodata}")?;
            if *bridged > 0 {
                let voids = if *bridged_holes == 1 { "void" } else { "voids" };
                write!(f, "; filled: {bridged} in {bridged_holes} {voids}")?;
            }
            if let Some(trim) = &self.trim {
                write!(f, "; trimmed, uncovered within {} of missing samples: {}", trim.distance(), trim.trimmed)?;
            }
            match without_ground.first {
                None => writeln!(f)?,
                Some(first) => {
                    let count = without_ground.count;
                    writeln!(f, "; isolated, in no cell with three heights: {count}, the first: {first}")?;
                }
            }
        }
        if let Some(w) = &self.worst {
            writeln!(
                f,
                "max error {} at {}: raster {}, surface {}",
                w.error, w.place, w.raster_height, w.surface_height
            )?;
            if let Some(WeightedWorst { weighted_error, weight, sample }) = &self.weighted_worst {
                let WorstSample { error, place, .. } = sample;
                writeln!(f, "max error × weight {weighted_error} at {place}: error {error}, weight {weight}")?;
            }
            writeln!(f, "RMS error {}", self.rms_error)?;
        }
        if let Some(stray) = &self.stray {
            writeln!(f, "{stray}")?;
        }
        if self.beside_lines > 0 {
            writeln!(f, "{} samples beside lines with heights of their own", self.beside_lines)?;
        }
        if let Some(lines) = &self.lines {
            writeln!(f, "{lines}")?;
        }
        if let Some(w) = self.extended.as_ref().and_then(|w| w.worst) {
            writeln!(f, "max error of heights and attributes {} at {}", w.error, w.place)?;
        }
        let failures = self.failures();
        if failures.is_empty() {
            let what = if self.weighted { "error × weight within" } else { "within" };
            let samples = match self.trim {
                Some(TrimVerdict { trimmed: 1.., .. }) => "every covered sample of the ground",
                _ if self.nodata + self.bridged > 0 => "every sample of the ground",
                _ => "every sample",
            };
            let between = self
                .stray
                .as_ref()
                .map(|s| format!(" and {} of the heights around between samples", s.allowed(self.tolerance)));
            let between = between.unwrap_or_default();
            return write!(f, "PASS: {what} {} at {samples}{between}, without cracks or overlaps", self.tolerance);
        }
        write!(f, "FAIL")?;
        failures.iter().try_for_each(|failure| write!(f, "\n  {failure}"))
    }
}
