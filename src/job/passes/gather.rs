//! Chunks of a pass that others have made, looked through before they become a mesh, or before another run takes them over.

use rayon::prelude::*;

use super::pool::Pool;
use super::{Job, Pass, Workspace};
use crate::job::Error;
use crate::job::spool::Spool;

/// What there is of a pass.
#[derive(Debug, Clone, Default)]
pub(in crate::job) struct Gathered {
    /// How many tiles have no sound chunk.
    pub(in crate::job) missing: usize,
    /// The first of them, ascending.
    pub(in crate::job) first_missing: Vec<usize>,
    /// Edges that stray farther than they may.
    pub(in crate::job) astray: u64,
    /// Samples that are bare.
    pub(in crate::job) bare: u64,
}

impl Gathered {
    /// How many missing tiles are named.
    const NAMED: usize = 8;

    fn plus(mut self, other: Gathered) -> Gathered {
        self.first_missing.extend(other.first_missing);
        self.first_missing.sort_unstable();
        self.first_missing.truncate(Gathered::NAMED);
        Gathered {
            missing: self.missing + other.missing,
            first_missing: self.first_missing,
            astray: self.astray + other.astray,
            bare: self.bare + other.bare,
        }
    }
}

/// Tells of those chunks of another run's pass that are sound and were made from the samples that their tiles have now; of the tiles
/// that `is_asked` says. On the threads of the current rayon pool.
///
/// # Errors
/// [`Error`]: the raster, or what there is of a chunk, cannot be read.
pub(in crate::job) fn same_samples(
    job: &Job<'_>,
    pass: &Pass,
    spool: &Spool,
    is_asked: &(dyn Fn(usize) -> bool + Sync),
    tell: &(dyn Fn(usize) + Sync),
) -> Result<(), Error> {
    let (Job { field, control, .. }, tiles) = (job, pass.grid.len());
    control.progress.begin(pass.stage(), tiles as u64, field.width() as u64 * field.height() as u64);
    let workspaces = Pool::default();
    (0..tiles).into_par_iter().try_for_each(|tile| {
        control.cancel.check()?;
        let place = pass.grid.place(tile);
        workspaces.with(|shared: &mut Workspace| {
            if is_asked(tile) && spool.find(tile, &mut shared.chunk, &mut shared.encoded)? {
                let [then, now] = shared.compare(job, place.window)?;
                if then == now {
                    tell(tile);
                }
                shared.hand_over();
            }
            Ok::<(), Error>(())
        })?;
        control.progress.found(pass.stage(), place.owned_samples());
        Ok::<(), Error>(())
    })?;
    control.progress.end(pass.stage());
    Ok(())
}

/// Makes sure that chunks of a pass were made from the samples that their tiles have now, on the threads of the current rayon pool.
///
/// # Errors
/// [`Error`]: the raster has changed, or a chunk cannot be read.
pub(in crate::job) fn must_be_of_samples(
    job: &Job<'_>,
    pass: &Pass,
    spool: &Spool,
    tiles: &[usize],
) -> Result<(), Error> {
    let workspaces = Pool::default();
    tiles.par_iter().try_for_each(|&tile| {
        job.control.cancel.check()?;
        workspaces.with(|shared: &mut Workspace| {
            spool.read(tile, &mut shared.chunk, &mut shared.encoded)?;
            shared.check_samples(job, pass.grid.place(tile).window)?;
            shared.hand_over();
            Ok::<(), Error>(())
        })
    })
}

/// Looks through all chunks of a pass on the threads of the current rayon pool, so that the spool knows them. Reads each once,
/// and the samples of its tile where [`Spool::check_samples`] asks for that.
///
/// # Errors
/// [`Error`]: what is there cannot be read, or was made from other samples.
pub(in crate::job) fn gather(job: &Job<'_>, pass: &Pass, spool: &Spool) -> Result<Gathered, Error> {
    let (Job { field, control, .. }, tiles) = (job, pass.grid.len());
    let samples = field.width() as u64 * field.height() as u64;
    control.progress.begin(pass.stage(), tiles as u64, samples);
    let workspaces = Pool::default();
    let each = (0..tiles).into_par_iter().map(|tile| {
        control.cancel.check()?;
        let place = pass.grid.place(tile);
        let gathered = workspaces.with(|shared: &mut Workspace| {
            if !spool.find(tile, &mut shared.chunk, &mut shared.encoded)? {
                return Ok(Gathered { missing: 1, first_missing: vec![tile], ..Gathered::default() });
            }
            if spool.check_samples() {
                shared.check_samples(job, place.window)?;
            }
            let errors = &shared.chunk.errors;
            let astray = errors.shape.as_ref().map_or(0, |shape| shape.astray);
            let gathered = Gathered { astray, bare: errors.trimmed, ..Gathered::default() };
            shared.hand_over();
            Ok::<Gathered, Error>(gathered)
        })?;
        control.progress.found(pass.stage(), place.owned_samples());
        Ok::<Gathered, Error>(gathered)
    });
    let all = each.try_reduce(Gathered::default, |a, b| Ok(a.plus(b)))?;
    control.progress.end(pass.stage());
    Ok(all)
}
