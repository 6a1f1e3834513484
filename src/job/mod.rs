//! The main job, end to end: a height field in, a certified mesh out.
//!
//! [`triangulate`] cuts the field into tiles and works on them in parallel, each from load to spool by one thread with
//! memory of its own; nothing is shared between tiles but the spool's file. [`Mesh::write`] then numbers the vertices
//! and hands them and the triangles to a sink, tile after tile. The bytes written depend on the samples and on
//! [`Params`], not on threads or the order of tiles.

mod chains;
mod error;
mod goal;
pub(crate) mod lines;
mod marks;
mod mesh;
pub mod normals;
mod order;
mod params;
mod passes;
pub mod plan;
mod quality;
pub mod rules;
mod search;
pub mod shards;
#[cfg(test)]
mod sink_tests;
pub mod spool;
mod triangulate;
pub mod update;
pub mod work_dir;

pub use crate::kernel::polish::Heights as VertexHeights;
pub use crate::kernel::triangulate::EngineChoice;
pub use error::Error;
pub use goal::{Budget, Goal, GoalTooSmall, Outcome};
pub use lines::Lines;
pub use mesh::{Mesh, Summary};
pub use params::{DEFAULT_TILE, Params};
pub use passes::{Job, Pass, PassName, PassResult, TileTimes, grid, passes, run_pass};
pub use plan::{
    BudgetTooSmall, DiskTooSmall, DiskUse, Expected, Load, Plan, check_disk, default_budget, probe, probe_field,
};
pub use quality::Quality;
pub use search::{Figures, Searched, Store};
pub use triangulate::{MakeSpool, triangulate, triangulate_into};

#[cfg(test)]
mod breakline_tests;
#[cfg(test)]
mod channel_tests;
#[cfg(test)]
mod cutline_tests;
#[cfg(test)]
mod goal_nodata_tests;
#[cfg(test)]
mod importance_tests;
#[cfg(test)]
mod lake_tests;
#[cfg(test)]
mod nodata_tests;
#[cfg(test)]
pub(crate) mod pair_tests;
#[cfg(test)]
mod points_tests;
#[cfg(test)]
mod reader_tests;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod trim_tests;
