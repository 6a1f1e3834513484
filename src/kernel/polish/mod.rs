//! Polishing: from a finished tile mesh to one with far fewer triangles, under the same guarantee.
//!
//! In comes the mesh of any engine; out goes a mesh of the same ground, whose rim is untouched and whose every triangle
//! has passed the exact test. Vertices stand on samples and have their heights, or where that is asked for stand on the
//! lattice of quarter cells and have heights of their own. `net` is the mesh while it changes (`by_rows` numbers it),
//! `journal` what a move that fails takes back; `hole` and `filling` are how triangles are replaced, `judge` says which
//! may be used, `energy` how well they fit, by samples that `scan` reads (`four_rows` says which), with those of `channels` where there are some. `removal` takes vertices out where feasible triangles fill the hole;
//! `improve` moves vertices and turns edges (`fan` finds the place); `repair` takes vertices out and mends what that
//! breaks. `star` finds the height that fits best, and where to look for a better place; `fitting` says which heights and
//! places there are, `angles` how sharp triangles may be. `onto_rim` puts vertices beside the raster's rim onto it.
//! `schedule` says what is done when, `order` where; `lanes` is arithmetic on eight numbers at once.
//!
//! Nothing is random and nothing is timed: effort is counted, ties go by number. Method and figures: docs/quality.md.

mod angles;
mod by_rows;
mod channels;
mod energy;
mod fan;
mod filling;
mod fitting;
mod four_rows;
mod hole;
mod improve;
mod journal;
mod judge;
mod lanes;
mod net;
mod onto_rim;
mod order;
mod removal;
mod repair;
mod ring;
mod scan;
mod schedule;
mod star;
mod witnesses;

#[cfg(test)]
mod channel_tests;
#[cfg(test)]
mod part_tests;
#[cfg(test)]
mod tests;

use self::angles::Angles;
use self::fitting::Fitting;
use self::judge::Judge;
use self::net::Net;
use self::onto_rim::OntoRim;
use self::order::Order;
use self::removal::Removal;
use self::repair::Repair;
use self::schedule::Visit;
use crate::base::control::Cancelled;
use crate::base::lattice::Point;
use crate::base::mesh::TileMesh;
use crate::base::{RasterRim, Tile};
use crate::kernel::triangulate::feasible::Tester;
use crate::kernel::triangulate::{Feasibility, Task};

pub(in crate::kernel) use self::fitting::near_surface;
pub use self::schedule::{Caps, Schedule, ScheduleError};

/// How much work is put into fewer triangles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Effort {
    /// Vertices that can go without more ado go: a quarter of balanced effort's time.
    Fast,
    /// The most triangles saved for the time: vertices go and what that breaks is mended.
    #[default]
    Balanced,
    /// The same for as long as it pays at all: four times as long for five per cent fewer triangles.
    Best,
}

impl Effort {
    /// The floor for angles where nothing is said of it, in degrees.
    pub const fn min_angle(self) -> f64 {
        match self {
            Effort::Fast => 0.0,
            Effort::Balanced | Effort::Best => MIN_ANGLE,
        }
    }
}

/// Sharper triangles can be seen, and save little.
const MIN_ANGLE: f64 = 2.0;

/// What heights the vertices have that polishing moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Heights {
    /// Those of the samples they stand on.
    #[default]
    Sampled,
    /// Their own, fitted to the samples around, on the lattice of quarter cells: a quarter fewer triangles in hardly more
    /// time. Heights are multiples of a power of two from 1/2048 to 1/1024 of the tolerance; between samples a vertex is
    /// within the tolerance (the smallest limit, where samples have weights) of its cell's bilinear surface. At a
    /// tolerance of 0, or next to it, the same as sampled.
    Fitted,
}

/// How to polish.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Options {
    /// How much work to put in.
    pub effort: Effort,
    /// What heights vertices have.
    pub heights: Heights,
    /// What is not left to these two.
    pub tuning: Tuning,
}

/// What may be chosen beside effort and heights.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Tuning {
    /// What is done when, instead of what the effort says; see [`Schedule::check`].
    pub schedule: Option<Schedule>,
    /// Degrees, from 0 to 60. No triangle is made whose smallest angle, seen from above with square cells, is below this
    /// and below the smallest one of the triangles that make room for it. So triangles that were sharper at the start may
    /// stay. 0 allows any angle; `None` takes the floor of the effort, [`Effort::min_angle`].
    pub min_angle: Option<f64>,
    /// Makes edges pass the strong test, even if the task asks for weak feasibility only; edges that were there before may
    /// stay. (A strong task is never polished otherwise.)
    pub strong_edges: bool,
}

/// Memory that polishing reuses from tile to tile, but for dense ones; it carries nothing from one to the next.
///
/// For each triangle of the mesh that comes in 40 bytes, and 12 for itself while it is loaded and stored; 29 for each vertex,
/// 16 of them the vertex. So 116 bytes per sample at a time where every sample is a vertex, the mesh included; apart from that
/// a few kilobytes for the ring and the move in work. With fitted heights also 10 bytes per sample of the largest star.
#[derive(Debug, Default)]
pub struct Scratch {
    net: Net,
    order: Order,
    removal: Removal,
    repair: Repair,
    onto_rim: OntoRim,
}

/// Replaces `mesh`, a mesh of the task's ground that keeps the contract of [`TileMesh`], by one of at most as many
/// triangles that keeps it too.
///
/// The domain's vertices, points, loops and edges stay as they are. Other vertices are removed, moved and renumbered; with
/// sampled heights every one of them stands on a sample and has its height, with fitted ones those that have moved have
/// heights and places of their own ([`Heights`]). Every triangle that was not there before passes
/// the exact weak test and, where the tile has channels, that of their weighted error, and every edge that was not there before keeps [`Task::max_stray`]. With strong feasibility, every edge that was not there before also passes the strong test;
/// `mesh.relaxed` does not grow, and is never more than the triangles that have an edge which fails it. The same mesh and
/// task give the same result, always and everywhere.
///
/// [`Tuning::strong_edges`] and a strong task are polished alike; [`Tuning::min_angle`] never makes the smallest angle of
/// what is replaced smaller, nor than the floor.
///
/// # Errors
/// [`Cancelled`], with a mesh of no use.
///
/// # Panics
/// If the mesh does not keep the contract, or the schedule its ranges ([`Schedule::check`]); where the tile has channels, if
/// heights are to be fitted.
pub fn polish(task: &Task<'_>, options: &Options, scratch: &mut Scratch, mesh: &mut TileMesh) -> Result<(), Cancelled> {
    scratch.net.load(task.domain, mesh);
    scratch.polish(task, options, Visit::All, mesh)
}

/// What of a part of a mesh stays, and where it is polished.
#[derive(Debug, Clone, Copy)]
pub struct Part<'a> {
    /// The first vertices, which stay as they are, even those that no triangle has.
    pub locked: u32,
    /// Around which vertices it is polished: those that were locked before.
    pub centres: &'a [u32],
    /// Where the part ends because the raster does. Vertices there may move along it, and go.
    pub rim: RasterRim,
}

/// Polishes a part of a mesh, any triangles of it, around some of its vertices: what has been polished with those locked and is
/// to be without.
///
/// Both ends of every edge with one triangle are locked, unless the edge runs along the raster's rim; and a vertex that is not is
/// on two such edges of one side, or on none. Of the task's domain its edges count, between locked vertices: they stay. `mesh.relaxed` becomes the number of triangles
/// that have an edge that fails the strong test, where the task asks for that.
///
/// # Errors
/// [`Cancelled`], with a mesh of no use.
///
/// # Panics
/// If an edge has one triangle, an end that is not locked and is not on the raster's rim, or more than two.
pub fn polish_around(
    task: &Task<'_>,
    options: &Options,
    part: &Part<'_>,
    scratch: &mut Scratch,
    mesh: &mut TileMesh,
) -> Result<(), Cancelled> {
    scratch.net.load_part(part.locked, part.rim, &task.domain.edges, mesh);
    scratch.polish(task, options, Visit::Near(part.centres), mesh)
}

impl Scratch {
    /// Polishes the net that is loaded, which is `mesh`.
    fn polish(
        &mut self,
        task: &Task<'_>,
        options: &Options,
        visit: Visit<'_>,
        mesh: &mut TileMesh,
    ) -> Result<(), Cancelled> {
        let tuning = &options.tuning;
        let schedule = tuning.schedule.unwrap_or(Schedule::preset(options.effort, options.heights));
        schedule.check().unwrap_or_else(|error| panic!("a schedule: {error}"));
        let feasibility = if tuning.strong_edges { Feasibility::Strong } else { task.feasibility };
        let strict = Task { feasibility, ..*task };
        let mut judge = Judge::new(&strict);
        judge.angles = Angles::at_least(tuning.min_angle.unwrap_or(options.effort.min_angle()));
        let has_channels = task.tile.channel_error.is_some();
        assert!(!has_channels || options.heights == Heights::Sampled, "fitted heights of a tile with channels");
        judge.fitting = (options.heights == Heights::Fitted).then(|| Fitting::new(task.tolerance));
        self.order.reset(&self.net);
        self.work(&schedule, visit, &mut judge)?;
        self.order.hand_over();
        let relaxed = mesh.relaxed;
        self.net.store(mesh);
        // A part does not know how many of its triangles are.
        let most = if visit == Visit::All { relaxed } else { u64::MAX };
        let is_strong = task.feasibility == Feasibility::Strong;
        mesh.relaxed = match most {
            0 => 0,
            most => most.min(count_relaxed(task.tile, mesh, task.tolerance, |_| is_strong)),
        };
        Ok(())
    }
}

/// How many of the triangles that are wanted have an edge that fails the strong test.
pub(crate) fn count_relaxed(tile: &Tile, mesh: &TileMesh, tolerance: f64, wanted: impl Fn([Point; 3]) -> bool) -> u64 {
    let tester = Tester::new(tile, tolerance, Feasibility::Strong);
    let fails = |&t: &[u32; 3]| {
        let [a, b, c] = mesh.corners(t);
        wanted([a.at, b.at, c.at]) && [(a, b), (b, c), (c, a)].iter().any(|&(p, q)| !tester.strong_edge(p, q))
    };
    mesh.triangles.iter().filter(|t| fails(t)).count() as u64
}
