//! What decides a mesh, as numbers and choices: [`Params`], and which features of a run they ask for.

use std::path::PathBuf;
use std::sync::Arc;

use super::lines::Lines;
use super::{EngineChoice, Error, Goal, Quality, VertexHeights, passes, rules};
use crate::base::features::{Feature, FeatureSet};
use crate::base::tiling::TileGrid;
use crate::base::{PointSet, Tolerance, exact_double};
use crate::field::Field;
use crate::kernel::boundary::MAX_CELLS;
use crate::kernel::breaklines::TwoHeights;
use crate::kernel::polish::{Schedule, Tuning};
use crate::kernel::triangulate::Feasibility;

/// What decides the mesh, and where temporary files go.
#[derive(Debug, Clone)]
pub struct Params {
    /// The largest vertical distance allowed between the surface and any sample, in the heights' units; at least 0. Where
    /// the field has weights ([`crate::field::Field::with_importance`]), the largest distance × weight.
    pub tolerance: Tolerance,
    /// Which triangles may be used.
    pub feasibility: Feasibility,
    /// What triangulates the tiles.
    pub engine: EngineChoice,
    /// How far the surface may stray between samples, in tolerances ([`Task::max_stray`](crate::kernel::triangulate::Task::max_stray)):
    /// at least 1, infinite for any; `None` for [`rules::default_max_stray`].
    pub max_stray: Option<f64>,
    /// How much work goes into fewer triangles once the engine is done. It does not go with all features
    /// ([`super::rules`]).
    pub quality: Quality,
    /// What heights the vertices have that polishing moves.
    pub heights: VertexHeights,
    /// What is chosen of polishing beside that.
    pub tuning: Tuning,
    /// What ends the refinement beside the tolerance.
    pub goal: Goal,
    /// A tile's side in cells; 0 makes one tile of the whole raster.
    pub tile: usize,
    /// How many cells the rim of the ground may lose where samples are missing, so that it has fewer vertices: 0 to
    /// [`crate::kernel::boundary::MAX_CELLS`].
    pub trim: u32,
    /// Samples that become vertices of the mesh. Not every engine can take them ([`super::rules`]).
    pub points: Option<Arc<PointSet>>,
    /// Lines that become edges of the mesh. Not every engine can take them ([`super::rules`]).
    pub breaklines: Option<Arc<Lines>>,
    /// The folder of temporary files.
    pub temp_dir: PathBuf,
}

/// The tile size where none is asked for, in cells. Its samples fit a core's cache, and fixed seams cost little at it.
pub const DEFAULT_TILE: usize = 512;

impl Params {
    /// Everything as usual but the tolerance.
    pub fn new(max_error: f64) -> Params {
        Params {
            tolerance: Tolerance::new(max_error),
            feasibility: Feasibility::default(),
            engine: EngineChoice::default(),
            max_stray: None,
            quality: Quality::default(),
            heights: VertexHeights::default(),
            tuning: Tuning::default(),
            goal: Goal::default(),
            tile: DEFAULT_TILE,
            trim: 0,
            points: None,
            breaklines: None,
            temp_dir: std::env::temp_dir(),
        }
    }

    /// What of the features of a run these ask for. Options of an engine count where they are not as usual.
    pub fn features(&self) -> FeatureSet {
        let Params { goal, tuning, .. } = self;
        let wanted = [
            (Feature::VertexBudget, goal.max_points.is_some()),
            (Feature::TriangleBudget, goal.max_triangles.is_some()),
            (Feature::RmsGoal, goal.max_rms.is_some()),
            (Feature::Points, self.points.as_ref().is_some_and(|p| !p.is_empty())),
            (Feature::Trim, self.trim > 0),
            (Feature::Polishing, self.quality != Quality::None),
            (Feature::FittedHeights, self.heights == VertexHeights::Fitted),
            (Feature::MinAngle, tuning.min_angle.is_some_and(|floor| floor > 0.0)),
            (Feature::MaxStray, self.max_stray.is_some_and(f64::is_finite)),
            (Feature::PolishingNumbers, tuning.schedule.is_some()),
            (Feature::StrongPolishEdges, tuning.strong_edges),
            (Feature::StrongFeasibility, self.feasibility == Feasibility::Strong),
        ];
        let wanted: FeatureSet = wanted.into_iter().filter(|(_, is_wanted)| *is_wanted).map(|(f, _)| f).collect();
        let lines = self.breaklines.as_ref().map_or(FeatureSet::default(), |lines| lines.features());
        wanted.and(self.engine.features()).and(lines)
    }

    /// Makes sure that a field can be triangulated with these parameters: that numbers are in their ranges, and that
    /// features go together, those of the field included.
    ///
    /// # Errors
    /// [`Error::Tolerance`], [`Error::Trim`], [`Error::MinAngle`], [`Error::MaxStray`], [`Error::Schedule`]; [`Error::Incompatible`] with all
    /// conflicts at once.
    pub fn check(&self, field: &Field) -> Result<(), Error> {
        // Under a goal the tolerance may be left open.
        let may_be_open = !self.goal.is_none();
        if !self.tolerance.is_usable() || self.tolerance.is_open() && !may_be_open {
            return Err(Error::Tolerance(self.tolerance.asked()));
        }
        if self.trim > MAX_CELLS {
            return Err(Error::Trim(self.trim));
        }
        if let Some(floor) = self.tuning.min_angle.filter(|floor| !(0.0..=60.0).contains(floor)) {
            return Err(Error::MinAngle(floor));
        }
        if let Some(limit) = self.max_stray.filter(|&limit| limit.is_nan() || limit < 1.0) {
            return Err(Error::MaxStray(limit));
        }
        if let Some(schedule) = &self.tuning.schedule {
            schedule.check()?;
        }
        Ok(rules::check(self.features().and(FeatureSet::of_field(field)))?)
    }

    /// Makes sure that lines which meet have one height there: within the tolerance of each other, or the same where there is a goal, as
    /// the tolerance is not known then.
    ///
    /// # Errors
    /// [`TwoHeights`].
    pub fn check_lines(&self) -> Result<(), TwoHeights> {
        let difference = if self.goal.is_none() { self.tolerance.kept() } else { 0.0 };
        self.breaklines.as_ref().map_or(Ok(()), |lines| lines.check_heights(difference))
    }

    /// Whether a tolerance is looked for whose mesh meets the goal, as insertion by itself cannot stop at it in order; with
    /// the features of a field ([`FeatureSet::of_field`]).
    pub fn is_searched(&self, field: FeatureSet) -> bool {
        !self.goal.is_none() && !rules::stops_in_order(self.features().and(field))
    }

    /// What decides the mesh of a search's run at a tolerance.
    pub fn at(&self, tolerance: f64) -> Params {
        Params { tolerance: self.tolerance.at(tolerance), goal: Goal::default(), ..self.clone() }
    }

    /// How far the surface may stray, with all features of a run.
    pub fn straying(&self, features: FeatureSet) -> f64 {
        self.max_stray.unwrap_or_else(|| rules::default_max_stray(features, self.quality))
    }

    /// The same, `None` where there is no limit.
    pub fn limit_on_straying(&self, features: FeatureSet) -> Option<f64> {
        Some(self.straying(features)).filter(|limit| limit.is_finite())
    }

    /// How many passes a run makes over the tiles of a grid. In a work dir each keeps its chunks until the end; else until the
    /// next one is done.
    pub fn passes(&self, grid: TileGrid) -> u64 {
        passes::passes_over(grid, passes::polishes_seams(self.quality, self.straying(self.features()))).len() as u64
    }

    /// What the pieces of breaklines are called among what is [named](Params::named).
    pub(super) const SEGMENTS: &str = "segments of lines";

    /// What of this decides the bytes of a tile, by name, equal exactly if the bytes are.
    pub fn named(&self) -> Vec<(&'static str, String)> {
        let feasibility = match self.feasibility {
            Feasibility::Weak => "weak",
            Feasibility::Strong => "strong",
        };
        let mut named = vec![
            (
                "max error",
                if self.tolerance.is_open() { "open".to_string() } else { exact_double(self.tolerance.kept()) },
            ),
            ("feasibility", feasibility.to_string()),
            ("tile", self.tile.to_string()),
            ("engine", self.engine.identity()),
            ("quality", self.quality.name().to_string()),
        ];
        if self.heights != VertexHeights::default() {
            named.push(("heights", format!("{:?}", self.heights).to_lowercase()));
        }
        if let Some((schedule, effort)) = self.tuning.schedule.zip(self.quality.effort())
            && schedule != Schedule::preset(effort, self.heights)
        {
            named.push(("polishing", schedule.named()));
        }
        if let Some(effort) = self.quality.effort() {
            named.push(("smallest angle", exact_double(self.tuning.min_angle.unwrap_or(effort.min_angle()))));
        }
        let max_stray = self.straying(self.features());
        if max_stray.is_finite() {
            named.push(("max stray", exact_double(max_stray)));
        }
        if self.tuning.strong_edges && self.feasibility == Feasibility::Weak {
            named.push(("edges in polishing", "strong".to_string()));
        }
        if self.trim > 0 {
            named.push(("trim", format!("{} cells", self.trim)));
        }
        named.extend(self.goal.named());
        if let Some(points) = self.points.as_ref().filter(|p| !p.is_empty()) {
            named.push(("points", format!("{} samples with the checksum {:08x}", points.len(), points.checksum())));
        }
        if let Some(lines) = &self.breaklines {
            let [sets, segments] = lines.named();
            named.push(("breaklines", sets));
            named.push((Params::SEGMENTS, segments));
        }
        named
    }
}

impl FeatureSet {
    /// What a field has: attributes or an image, importance weights, filled voids.
    pub fn of_field(field: &Field) -> FeatureSet {
        let attributes = match field.channels().len() {
            0 => None,
            // The level of an image is not read.
            count if field.each().count() == count => Some(Feature::Image),
            _ => Some(Feature::Attributes),
        };
        let importance = field.importance().map(|_| Feature::Importance);
        let voids = field.holes().map(|_| Feature::FilledVoids);
        [attributes, importance, voids].into_iter().flatten().collect()
    }
}
