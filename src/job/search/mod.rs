//! Goals that are met by looking for a tolerance: the mesh is the one that a run with that tolerance makes, polishing and
//! all.
//!
//! A budget, or a root mean square, says nothing to a tile. Insertion by itself can stop at one in order
//! ([`crate::job::goal`]); what polishing leaves is known only when it is done. So whole runs are made at tolerances until
//! one's mesh meets the goal ([`Hunt`]). Counts fall about in proportion as the tolerance grows, so two runs are mostly enough,
//! if the first begins near: a few tiles are triangulated, then polished, at tolerances that lead there ([`Tiles`]).
//!
//! All decisions come of counts and sums in a fixed order, by sums, products and quotients alone; so the same tolerances
//! are tried on any machine. Counts are not monotone: the tolerance that is found is not "the smallest".

mod curve;
mod decimals;
mod figures;
mod hunt;
mod sample;
#[cfg(test)]
mod tests;
mod tiles;

pub use figures::Figures;
pub(super) use tiles::{Makers, RUN};

use self::hunt::{Aim, Hunt};
use self::tiles::Tiles;
use super::passes::Job;
use super::spool::{Spool, SpoolError};
use super::{Error, Mesh, Outcome, Params, Pass};
use crate::base::control::Control;
use crate::field::Field;

/// Where a run keeps its chunks, and where a search keeps what it has found out.
pub trait Store: Sync {
    /// The spool for a pass of the run, or of a search's run at a tolerance.
    ///
    /// # Errors
    /// [`SpoolError`].
    fn spool(&self, trial: Option<f64>, pass: &Pass) -> Result<Spool, SpoolError>;

    /// What has been noted of a tolerance that was tried in some way.
    ///
    /// # Errors
    /// [`Error`].
    fn recall(&self, _way: &str, _tolerance: f64) -> Result<Option<Figures>, Error> {
        Ok(None)
    }

    /// Notes what a tolerance came to that was tried in some way.
    ///
    /// # Errors
    /// [`Error`].
    fn note(&self, _way: &str, _tolerance: f64, _figures: &Figures) -> Result<(), Error> {
        Ok(())
    }

    /// The chunks of a search's run at a tolerance are of no use any more.
    ///
    /// # Errors
    /// [`Error`].
    fn forget(&self, _trial: f64) -> Result<(), Error> {
        Ok(())
    }
}

/// What a search has found out of a run before it is made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Expectation {
    /// The tolerance of the first run.
    pub(super) tolerance: f64,
    /// What its mesh may come to.
    pub(super) figures: Option<Figures>,
    /// Seconds of all threads together that a few tiles took, and what the first pass of a run may take, where that is known.
    pub(super) seconds: f64,
    pub(super) run_seconds: Option<f64>,
}

/// A run that ended between two tolerances.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Searched {
    /// The tolerance of the mesh.
    pub tolerance: f64,
    /// Whole runs that were made.
    pub runs: usize,
    /// The share of the budget that is spent, from 0 to 1; null where none is given.
    pub share: Option<f64>,
    /// The largest tolerance below that was tried and exceeds the budget; null where none did.
    pub exceeded_at: Option<f64>,
    /// How many triangles there were.
    pub exceeded_triangles: Option<u64>,
    /// How many vertices there were.
    pub exceeded_vertices: Option<u64>,
}

/// Makes the mesh that meets a goal, of tiles that `makers` make.
///
/// # Errors
/// [`Error`]; what becomes of finished tiles is the store's matter.
pub(super) fn triangulate(
    makers: Makers,
    store: &dyn Store,
    field: &Field,
    params: &Params,
    control: &Control<'_>,
) -> Result<Mesh, Error> {
    let job = Job::new(field, params, control)?;
    let mut tiles = Tiles::new(&job, Some(store), makers)?;
    let found = Hunt::new(&mut tiles, aim(params)).finish()?;
    let mesh = tiles.mesh(found.tolerance)?;
    let searched = Searched {
        tolerance: found.tolerance,
        runs: found.runs,
        share: params.goal.share(found.figures.vertices, found.figures.triangles),
        exceeded_at: found.beyond.map(|(tolerance, _)| tolerance),
        exceeded_triangles: found.beyond.map(|(_, figures)| figures.triangles),
        exceeded_vertices: found.beyond.map(|(_, figures)| figures.vertices),
    };
    let outcome = Outcome { ended_by: found.ended_by, threshold: found.tolerance, search: Some(searched) };
    Ok(Mesh { outcome: Some(outcome), ..mesh })
}

/// Finds out at which tolerance a search's first run is made. What it has tried is noted in the store.
///
/// # Errors
/// [`Error`].
pub(super) fn first_run(
    store: &dyn Store,
    field: &Field,
    params: &Params,
    control: &Control<'_>,
) -> Result<f64, Error> {
    let job = Job::new(field, params, control)?;
    let mut tiles = Tiles::new(&job, Some(store), Makers::Others)?;
    Ok(Hunt::new(&mut tiles, aim(params)).foretell()?.0)
}

/// Finds out where a search will begin, at a few tiles.
///
/// # Errors
/// [`Error`].
pub(super) fn foretell(field: &Field, params: &Params, control: &Control<'_>) -> Result<Expectation, Error> {
    let job = Job::new(field, params, control)?;
    let mut tiles = Tiles::new(&job, None, Makers::Here)?;
    let (tolerance, figures) = Hunt::new(&mut tiles, aim(params)).foretell()?;
    tiles.time(tolerance)?;
    let (seconds, run_seconds) = tiles.seconds();
    Ok(Expectation { tolerance, figures, seconds, run_seconds })
}

fn aim(params: &Params) -> Aim {
    // What rounding loses is at most half of any tolerance.
    let finest = 2.0 * params.tolerance.lost();
    let is_exact = params.goal.max_rms == Some(0.0);
    let coarsest = if is_exact { finest } else { params.tolerance.asked().max(finest) };
    Aim { goal: params.goal, coarsest, finest }
}
