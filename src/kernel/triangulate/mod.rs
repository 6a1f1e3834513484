//! Engines: from one tile and the loops around its ground to a tile mesh.
//!
//! In come the samples of a [`Tile`] and a [`Domain`]; out goes a [`TileMesh`] whose surface is within the tolerance at
//! every sample the domain's ground covers. Engines do no I/O, never assume that the ground is a rectangle, and know
//! nothing of other tiles. `feasible` answers whether a triangle may be used; `cuts` is the greedy cuts engine, `insertion` the
//! greedy insertion engine.

#[cfg(test)]
pub(crate) mod conformance;
pub mod cuts;
pub mod feasible;
pub mod insertion;

use crate::base::Tile;
use crate::base::control::{CancelToken, Cancelled};
use crate::base::mesh::{Domain, TileMesh};

/// Which triangles may be used (Silva, Mitchell & Kaufman 1995, section 2).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Feasibility {
    /// Every sample under the closed triangle is within the tolerance of it.
    #[default]
    Weak,
    /// Also wherever its edges cross edges and diagonals of the grid: the triangle is within the tolerance of the
    /// piecewise linear surface over the samples. A tile's engine may have to relax this to weak, and counts it.
    Strong,
}

/// What an engine is given.
#[derive(Debug, Clone, Copy)]
pub struct Task<'a> {
    /// The samples.
    pub tile: &'a Tile,
    /// The ground to cover.
    pub domain: &'a Domain,
    /// The largest vertical distance allowed, in the heights' units; at least 0. Where the tile has weights, distance ×
    /// weight: each sample is held to its [`Tile::limit`].
    pub tolerance: f64,
    /// Which triangles may be used.
    pub feasibility: Feasibility,
    /// Asked now and then whether to go on.
    pub cancel: &'a CancelToken,
}

/// A way to triangulate a tile.
pub trait Engine: Sync {
    /// Memory that the engine reuses from tile to tile; it carries nothing from one to the next.
    type Scratch: Default + Send;

    /// Whether it keeps the weighted error of tiles with channels within [`ChannelError::limit`]. One that does not is
    /// never given such a tile.
    ///
    /// [`ChannelError::limit`]: crate::base::channels::ChannelError::limit
    const KEEPS_CHANNELS: bool = false;

    /// Whether the engine makes vertices of the domain's points ([`Domain::points`]). One that does not is given none.
    fn preinserts(&self) -> bool {
        false
    }

    /// Triangulates the task's ground into `mesh`, replacing what is in it and reusing its memory. The same task gives
    /// the same mesh, always and everywhere.
    ///
    /// # Errors
    /// [`Cancelled`], with a mesh of no use.
    fn triangulate(&self, task: &Task<'_>, scratch: &mut Self::Scratch, mesh: &mut TileMesh) -> Result<(), Cancelled>;
}
