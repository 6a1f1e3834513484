//! Engines: from one tile and the loops around its ground to a tile mesh.
//!
//! In come the samples of a [`Tile`] and a [`Domain`]; out goes a [`TileMesh`] whose surface is within the tolerance at
//! every sample the domain's ground covers. Engines do no I/O, never assume that the ground is a rectangle, and know
//! nothing of other tiles. `feasible` answers whether a triangle may be used; `cuts` is the greedy cuts engine, `insertion`
//! the greedy insertion engine, `hitting_set` the one of hitting sets. `registry` lists the engines; `progressive` is what those have in common that can end at a
//! budget.

#[cfg(test)]
pub(crate) mod conformance;
pub mod cuts;
pub mod feasible;
pub mod hitting_set;
pub mod insertion;
pub mod progressive;
pub mod registry;

use std::any::Any;

use crate::base::Tile;
use crate::base::control::{CancelToken, Cancelled};
use crate::base::features::FeatureSet;
use crate::base::mesh::{Domain, TileMesh};

pub use self::progressive::Progressive;
pub use self::registry::EngineChoice;

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
    /// How far the surface may stray between samples, in tolerances: at least 1, infinite for any. On every side of a cell
    /// whose two samples have heights it stays between these, give or take this times the tolerance; where the tile has
    /// weights, times the larger of the two samples' limits. (So inside of a cell it stays between its least and greatest
    /// corner, give or take the same.)
    pub max_stray: f64,
    /// Asked now and then whether to go on.
    pub cancel: &'a CancelToken,
}

/// What an engine can do besides triangulating a tile within the tolerance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Capabilities {
    /// It makes vertices of the domain's points ([`Domain::points`]). An engine that does not is given none.
    pub points: bool,
    /// It makes edges of the domain's edges ([`Domain::edges`]). An engine that does not is given none.
    pub edges: bool,
    /// It keeps the weighted error of tiles with channels within [`ChannelError::limit`]. An engine that does not is never
    /// given such a tile.
    ///
    /// [`ChannelError::limit`]: crate::base::channels::ChannelError::limit
    pub channels: bool,
}

/// A way to triangulate a tile. The engines there are stand in [`registry`].
pub trait Engine: Send + Sync {
    /// What it is called in messages.
    fn name(&self) -> &'static str;

    /// What it can do.
    fn capabilities(&self) -> Capabilities;

    /// What the engine takes for a tile beside its samples, in bytes per sample, at the most: where every sample is a vertex,
    /// and there are twice as many triangles. The mesh is a part of it: 40 bytes.
    fn bytes_per_sample(&self) -> u64;

    /// Everything that decides the bytes of a tile, its options among them, as text: equal exactly if the bytes are.
    fn identity(&self) -> String;

    /// What of the features of a run it is, options that are not as usual among them: what does not go together with others
    /// stands in [`crate::job::rules`].
    fn features(&self) -> FeatureSet {
        FeatureSet::default()
    }

    /// The engine as one that can end anywhere. `None` where it cannot, or its options do not go with that.
    fn progressive(&self) -> Option<&dyn Progressive> {
        None
    }

    /// Triangulates the task's ground into `mesh`, replacing what is in it and reusing its memory. The same task gives
    /// the same mesh, always and everywhere; `scratch` lends memory and carries nothing from one tile to the next.
    ///
    /// # Errors
    /// [`Cancelled`], with a mesh of no use.
    fn triangulate(&self, task: &Task<'_>, scratch: &mut EngineScratch, mesh: &mut TileMesh) -> Result<(), Cancelled>;
}

/// The memory of an engine, reused from tile to tile: whichever engine works with it last.
#[derive(Default)]
pub struct EngineScratch(Option<Box<dyn Any + Send>>);

impl EngineScratch {
    /// The memory of an engine. It is made when the engine first asks, and kept until another one does.
    pub fn of<S: Default + Send + 'static>(&mut self) -> &mut S {
        if !self.0.as_ref().is_some_and(|memory| memory.is::<S>()) {
            self.0 = Some(Box::<S>::default());
        }
        self.0.as_mut().and_then(|memory| memory.downcast_mut()).expect("memory of this kind")
    }
}
