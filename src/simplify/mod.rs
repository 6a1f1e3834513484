//! The main job, end to end: a height field in, a certified mesh out.
//!
//! [`triangulate`] cuts the field into tiles and works on them in parallel, each from load to spool by one thread with
//! memory of its own; nothing is shared between tiles but the spool's file. [`Mesh::write`] then numbers the vertices
//! and hands them and the triangles to a sink, tile after tile. The bytes written depend on the samples and on
//! [`Params`], not on threads or the order of tiles.

mod budget;
mod disk;
mod error;
mod mesh;
mod pool;
mod probe;
mod tiles;

pub use budget::{BudgetTooSmall, Plan, default_budget};
pub use disk::{DiskTooSmall, DiskUse, check_disk};
pub use error::Error;
pub use mesh::{Mesh, Summary};
pub use probe::{probe_density, probe_field};
pub use tiles::{TileTimes, grid, must_keep_channels, triangulate, triangulate_into};

use std::path::PathBuf;

use crate::raster::exact;
use crate::triangulate::Feasibility;

#[cfg(test)]
mod channel_tests;
#[cfg(test)]
mod tests;

/// What decides the mesh, and where temporary files go.
#[derive(Debug, Clone)]
pub struct Params {
    /// The largest vertical distance allowed between the surface and any sample, in the heights' units; at least 0.
    pub max_error: f64,
    /// Which triangles may be used.
    pub feasibility: Feasibility,
    /// A tile's side in cells; 0 makes one tile of the whole raster.
    pub tile: usize,
    /// The folder of temporary files.
    pub temp_dir: PathBuf,
}

/// The tile size where none is asked for, in cells. Its samples fit a core's cache, and fixed seams cost little at it.
pub const DEFAULT_TILE: usize = 512;

impl Params {
    /// Everything as usual but the tolerance.
    pub fn new(max_error: f64) -> Params {
        Params { max_error, feasibility: Feasibility::default(), tile: DEFAULT_TILE, temp_dir: std::env::temp_dir() }
    }

    /// What of this decides the bytes of a tile, by name, equal exactly if the bytes are.
    pub fn named(&self) -> Vec<(&'static str, String)> {
        let feasibility = match self.feasibility {
            Feasibility::Weak => "weak",
            Feasibility::Strong => "strong",
        };
        vec![
            ("max error", exact(self.max_error)),
            ("feasibility", feasibility.to_string()),
            ("tile", self.tile.to_string()),
            ("engine", "greedy cuts".to_string()),
        ]
    }
}
