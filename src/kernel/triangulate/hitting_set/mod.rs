//! Hitting sets (Agarwal & Desikan 1997): the samples are divided into squares that a plane fits, and these are stitched.
//!
//! `plane` is the linear programme that finds a square's plane, or four samples that no plane fits; `squares` divides a
//! tile by a quadtree, `sliding` covers it with squares at any place. `shared` puts one vertex where squares meet,
//! `reconcile` finds heights for these. The engine makes a constrained Delaunay triangulation of them over the loops of
//! a domain, inserts samples where the exact test fails, and merges: vertices go whose hole triangles within the
//! tolerance fill. So a mesh is within the tolerance whatever the squares were.
//!
//! `literal` is the paper's own stitching, for comparisons; `reweighting` its search for a hitting set in any set
//! system (section 4), `bichromatic` another problem that it solves (section 1). Method, departures and figures:
//! docs/hitting-set.md.

pub mod bichromatic;
mod literal;
mod plane;
mod reconcile;
pub mod reweighting;
mod shared;
mod sliding;
mod squares;

#[cfg(test)]
mod tests;

use self::squares::{Finder, Sides};
use super::insertion::{self, Rim};
use super::{Capabilities, Engine, EngineScratch, Task};
use crate::base::control::Cancelled;
use crate::base::features::{Feature, FeatureSet};
use crate::base::mesh::TileMesh;
use crate::kernel::polish::{self, Effort, Schedule, Tuning};

pub use self::literal::{Literal, Reading, stitch_literally};
pub use self::plane::{Certificate, Plane, excludes_planes, least_plane};
pub use self::sliding::LargestSquares;
pub use self::squares::{Counts, Partition, Square, Squares, partition};

/// What heights vertices have that corners of squares share.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Corners {
    /// Those of the samples that they stand on; in a [`partition`] a square's two triangles then have the samples at its
    /// corners as theirs (the paper's SP-B).
    #[default]
    Samples,
    /// Their own, multiples of the same power of two as fitted heights ([`polish::Heights::Fitted`]); in a [`partition`] all
    /// corners of a square are on one plane (SP-A). At a tolerance of 0, or next to it, the same as those of samples.
    Free,
}

/// How squares become a mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Stitching {
    /// Corners that meet are one vertex; samples are inserted where triangles are not within the tolerance.
    Shared,
    /// After that vertices go whose hole triangles within the tolerance fill.
    #[default]
    Merged,
}

/// Which variant of the engine is run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
pub struct HittingSetOptions {
    /// Which squares there are.
    pub squares: Squares,
    /// What heights shared corners have.
    pub corners: Corners,
    /// How squares become a mesh.
    pub stitching: Stitching,
}

/// The engine of hitting sets.
///
/// Squares are those of one plane each (SP-A), found from the samples alone: loops, points and straying bind what is
/// made of them. Cost: expected O(n log n) for n samples, close to O(n); with sliding squares a plane for every sample
/// and every size tried.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
#[serde(transparent)]
pub struct HittingSet {
    /// Which variant.
    pub options: HittingSetOptions,
}

/// The memory of the engine.
#[derive(Debug, Default)]
struct Scratch {
    insertion: insertion::Scratch,
    polish: polish::Scratch,
}

impl Engine for HittingSet {
    fn name(&self) -> &'static str {
        "hitting sets"
    }

    fn capabilities(&self) -> Capabilities {
        Capabilities { points: true, ..Capabilities::default() }
    }

    /// Insertion takes the most, with the vertices it begins with; merging follows. Of sliding squares there is one for
    /// every sample before one is chosen: 72 bytes, 17 of their order, and those chosen, a quarter of all at the most,
    /// in a list that doubles.
    fn bytes_per_sample(&self) -> u64 {
        match self.options.squares {
            Squares::Nested => 112,
            Squares::Sliding => 72 + 17 + 2 * 72 / 4,
        }
    }

    fn identity(&self) -> String {
        let HittingSetOptions { squares, corners, stitching } = self.options;
        format!("hitting sets: {squares:?}, {corners:?}, {stitching:?}")
    }

    fn features(&self) -> FeatureSet {
        let HittingSetOptions { squares, corners, stitching } = self.options;
        let asked = [
            (Feature::HittingSet, true),
            (Feature::Squares, squares == Squares::Sliding),
            (Feature::FreeCorners, corners == Corners::Free),
            (Feature::Stitching, stitching == Stitching::Shared),
        ];
        asked.into_iter().filter(|(_, is_asked)| *is_asked).map(|(feature, _)| feature).collect()
    }

    fn triangulate(&self, task: &Task<'_>, scratch: &mut EngineScratch, mesh: &mut TileMesh) -> Result<(), Cancelled> {
        task.cancel.check()?;
        let Scratch { insertion, polish } = scratch.of::<Scratch>();
        let (tile, tolerance) = (task.tile, task.tolerance);
        let squares = self.squares(task)?;
        let corners = shared::corners(tile, tolerance, &squares, self.options.corners);
        drop(squares);
        insertion::delaunay(task.domain, corners.into_iter(), insertion, mesh);
        if self.options.corners == Corners::Free {
            reconcile::heights(tile, tolerance, task.domain.fixed().count(), mesh, task.cancel)?;
        }
        insertion::refine(task, Rim::Locked, insertion, mesh)?;
        if self.options.stitching == Stitching::Merged {
            let tuning = Tuning { schedule: Some(Schedule::REMOVAL), ..Tuning::default() };
            let options = polish::Options { effort: Effort::Balanced, tuning, ..polish::Options::default() };
            polish::polish(task, &options, polish, mesh)?;
        }
        Ok(())
    }
}

impl HittingSet {
    /// The squares of more than one sample.
    fn squares(&self, task: &Task<'_>) -> Result<Vec<Square>, Cancelled> {
        let mut finder = Finder::new(task.tile, task.tolerance, Corners::Free);
        match self.options.squares {
            Squares::Nested => finder.nested(Sides::Apart, Square::is_wide, task.cancel),
            Squares::Sliding => sliding::cover(&mut finder, Square::is_wide, task.cancel),
        }
    }
}
