//! The main job, end to end: a height field in, a certified mesh out.
//!
//! [`triangulate`] cuts the field into tiles and works on them in parallel, each from load to spool by one thread with
//! memory of its own; nothing is shared between tiles but the spool's file. [`Mesh::write`] then numbers the vertices
//! and hands them and the triangles to a sink, tile after tile. The bytes written depend on the samples and on
//! [`Params`], not on threads or the order of tiles.

mod engine;
mod error;
mod goal;
mod in_order;
mod mesh;
pub mod plan;
mod pool;
mod shifted;
#[cfg(test)]
mod sink_tests;
pub mod spool;
mod tiles;
pub mod work_dir;

pub use crate::kernel::polish::Heights as VertexHeights;
pub use engine::{EngineChoice, Quality};
pub use error::Error;
pub use goal::{Budget, Goal, GoalTooSmall, Outcome};
pub use mesh::{Mesh, Summary};
pub use plan::{
    BudgetTooSmall, DiskTooSmall, DiskUse, Expected, Load, Plan, check_disk, default_budget, probe, probe_field,
};
pub use tiles::{MakeSpool, Pass, TileTimes, grid, triangulate, triangulate_into};

use std::path::PathBuf;
use std::sync::Arc;

use crate::base::PointSet;
use crate::base::exact_double;
use crate::base::tiling::TileGrid;
use crate::kernel::boundary::MAX_CELLS;
use crate::kernel::polish::{Schedule, Tuning};
use crate::kernel::triangulate::Feasibility;

#[cfg(test)]
mod channel_tests;
#[cfg(test)]
mod goal_nodata_tests;
#[cfg(test)]
mod importance_tests;
#[cfg(test)]
mod nodata_tests;
#[cfg(test)]
mod points_tests;
#[cfg(test)]
mod reader_tests;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod trim_tests;

/// What decides the mesh, and where temporary files go.
#[derive(Debug, Clone)]
pub struct Params {
    /// The largest vertical distance allowed between the surface and any sample, in the heights' units; at least 0. Where
    /// the field has weights ([`crate::field::Field::with_importance`]), the largest distance × weight.
    pub max_error: f64,
    /// Which triangles may be used.
    pub feasibility: Feasibility,
    /// What triangulates the tiles.
    pub engine: EngineChoice,
    /// How much work goes into fewer triangles once the engine is done. Without a goal only: a mesh that ends at a budget or
    /// a root mean square would not keep to it. Nor with channels ([`Params::takes_channels`]).
    pub quality: Quality,
    /// What heights the vertices have that polishing moves.
    pub heights: VertexHeights,
    /// What is chosen of polishing beside that.
    pub tuning: Tuning,
    /// What ends the refinement beside the tolerance. Only for engines that refine ([`Params::takes_goal`]).
    pub goal: Goal,
    /// A tile's side in cells; 0 makes one tile of the whole raster.
    pub tile: usize,
    /// How many cells the rim of the ground may lose where samples are missing, so that it has fewer vertices: 0 to
    /// [`crate::kernel::boundary::MAX_CELLS`].
    pub trim: u32,
    /// Samples that become vertices of the mesh. Only for engines that can take them ([`Params::takes_points`]).
    pub points: Option<Arc<PointSet>>,
    /// The folder of temporary files.
    pub temp_dir: PathBuf,
}

/// The tile size where none is asked for, in cells. Its samples fit a core's cache, and fixed seams cost little at it.
pub const DEFAULT_TILE: usize = 512;

impl Params {
    /// Everything as usual but the tolerance.
    pub fn new(max_error: f64) -> Params {
        Params {
            max_error,
            feasibility: Feasibility::default(),
            engine: EngineChoice::default(),
            quality: Quality::default(),
            heights: VertexHeights::default(),
            tuning: Tuning::default(),
            goal: Goal::default(),
            tile: DEFAULT_TILE,
            trim: 0,
            points: None,
            temp_dir: std::env::temp_dir(),
        }
    }

    /// Makes sure that the engine can make vertices of points, before any are read.
    ///
    /// # Errors
    /// [`Error::NoPreinsertion`].
    pub fn takes_points(&self) -> Result<(), Error> {
        if self.engine.preinserts() { Ok(()) } else { Err(Error::NoPreinsertion { engine: self.engine.name() }) }
    }

    /// Makes sure that the engine keeps the weighted error of fields with channels, and that nothing stands beside it that
    /// is about heights alone: goals, because insertions of a whole raster are ordered by the vertical error, and
    /// polishing.
    ///
    /// # Errors
    /// [`Error::Channels`], [`Error::GoalWithChannels`], [`Error::PolishWithChannels`].
    pub fn takes_channels(&self) -> Result<(), Error> {
        if !self.engine.keeps_channels() {
            return Err(Error::Channels { engine: self.engine.name() });
        }
        if !self.goal.is_none() {
            return Err(Error::GoalWithChannels);
        }
        let quality = self.quality.name();
        if self.quality == Quality::None { Ok(()) } else { Err(Error::PolishWithChannels { quality }) }
    }

    /// Makes sure that fitted heights have somebody who fits them.
    ///
    /// # Errors
    /// [`Error::FittedWithoutPolish`].
    pub fn takes_heights(&self) -> Result<(), Error> {
        let unpolished = self.quality == Quality::None && self.heights == VertexHeights::Fitted;
        if unpolished { Err(Error::FittedWithoutPolish) } else { Ok(()) }
    }

    /// Makes sure that what is chosen of polishing is in its ranges, and that there is any.
    ///
    /// # Errors
    /// [`Error::TuningWithoutPolish`], [`Error::Schedule`], [`Error::MinAngle`].
    pub fn takes_tuning(&self) -> Result<(), Error> {
        if !(0.0..=60.0).contains(&self.tuning.min_angle) {
            return Err(Error::MinAngle(self.tuning.min_angle));
        }
        if let Some(schedule) = &self.tuning.schedule {
            schedule.check()?;
        }
        let untuned = self.quality != Quality::None || self.tuning == Tuning::default();
        if untuned { Ok(()) } else { Err(Error::TuningWithoutPolish) }
    }

    /// Makes sure that the rim is not trimmed by more than anybody means.
    ///
    /// # Errors
    /// [`Error::Trim`].
    pub fn takes_trim(&self) -> Result<(), Error> {
        if self.trim <= MAX_CELLS { Ok(()) } else { Err(Error::Trim(self.trim)) }
    }

    /// Makes sure that the engine can end where the goal says.
    ///
    /// # Errors
    /// [`Error::NoGoal`], [`Error::GoalWithPasses`], [`Error::GoalWithPolish`], [`Error::GoalWithTrim`].
    pub fn takes_goal(&self) -> Result<(), Error> {
        match self.engine {
            _ if self.goal.is_none() => Ok(()),
            _ if self.quality != Quality::None => Err(Error::GoalWithPolish { quality: self.quality.name() }),
            _ if self.trim > 0 => Err(Error::GoalWithTrim(self.trim)),
            EngineChoice::GreedyInsertion(options) if options == options.in_order() => Ok(()),
            EngineChoice::GreedyInsertion(_) => Err(Error::GoalWithPasses),
            EngineChoice::GreedyCuts(_) => Err(Error::NoGoal { engine: self.engine.name() }),
        }
    }

    /// How many passes a run makes over the tiles of a grid, each of which keeps its chunks until the end.
    pub fn passes(&self, grid: TileGrid) -> u64 {
        if tiles::shifted(grid, self).is_some() { 2 } else { 1 }
    }

    /// What of this decides the bytes of a tile, by name, equal exactly if the bytes are.
    pub fn named(&self) -> Vec<(&'static str, String)> {
        let feasibility = match self.feasibility {
            Feasibility::Weak => "weak",
            Feasibility::Strong => "strong",
        };
        let mut named = vec![
            ("max error", exact_double(self.max_error)),
            ("feasibility", feasibility.to_string()),
            ("tile", self.tile.to_string()),
            ("engine", self.engine.named()),
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
        if self.tuning.min_angle > 0.0 {
            named.push(("smallest angle", exact_double(self.tuning.min_angle)));
        }
        if self.tuning.strong_edges && self.feasibility == Feasibility::Weak {
            named.push(("edges in polishing", "strong".to_string()));
        }
        if self.trim > 0 {
            named.push(("trim", format!("{} cells", self.trim)));
        }
        if !self.goal.is_none() {
            named.push(("goal", self.goal.named()));
        }
        if let Some(points) = self.points.as_ref().filter(|p| !p.is_empty()) {
            named.push(("points", format!("{} samples with the checksum {:08x}", points.len(), points.checksum())));
        }
        named
    }
}
