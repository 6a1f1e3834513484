//! How a caller watches and stops a run: a cancellation token and a progress sink that reach every stage.

use super::warning::Warning;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A flag shared by the caller and the stages. Cloning shares it.
#[derive(Debug, Clone, Default)]
pub struct CancelToken(Arc<AtomicBool>);

impl CancelToken {
    /// Asks every stage to stop at its next safe point. May be called from any thread, and from a signal handler.
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether [`CancelToken::cancel`] has been called.
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// # Errors
    /// [`Cancelled`] once the token is cancelled.
    pub fn check(&self) -> Result<(), Cancelled> {
        if self.is_cancelled() { Err(Cancelled) } else { Ok(()) }
    }
}

/// The caller asked to stop.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("stopped before the end")]
pub struct Cancelled;

/// What is being worked on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Stage {
    /// Decoding the raster into the temporary tiled file.
    Decode,
    /// Finding holes that are to be bridged.
    Holes,
    /// Finding the ranges of heights and channels.
    Ranges,
    /// Finding out, tile by tile, where a goal for all of them is met.
    Survey,
    /// Triangulating tiles.
    Triangulate,
    /// Polishing once more, with the seams between tiles.
    Seams,
    /// Polishing where lines of that grid have crossed seams that run down.
    CrossingsAcross,
    /// The same where seams run across.
    CrossingsDown,
    /// Writing the output file.
    Write,
    /// Finding out which ground a mesh is to cover.
    Ground,
    /// Reading a mesh back and sorting it.
    Sort,
    /// Comparing a mesh with the raster.
    Compare,
    /// Making or drawing rows of a raster.
    Rows,
}

/// Told how far a run has come. Methods may be called from several threads at once and should return at once.
pub trait Progress: Sync {
    /// A stage begins; it has `steps` steps (tiles, block rows, bands) of `samples` samples in all.
    fn begin(&self, stage: Stage, steps: u64, samples: u64);
    /// One step that covered `samples` samples is done.
    fn step(&self, stage: Stage, samples: u64);
    /// One step that covers `samples` samples need not be done: an earlier run has left it.
    fn found(&self, stage: Stage, samples: u64) {
        self.step(stage, samples);
    }
    /// The stage is done.
    fn end(&self, stage: Stage);
    /// Something that a user should know although the run goes on.
    fn warn(&self, _warning: &Warning) {}
}

/// Nobody watches.
#[derive(Debug, Clone, Copy, Default)]
pub struct Silent;

impl Progress for Silent {
    fn begin(&self, _: Stage, _: u64, _: u64) {}
    fn step(&self, _: Stage, _: u64) {}
    fn end(&self, _: Stage) {}
}

/// What every long-running call is given.
#[derive(Clone)]
pub struct Control<'a> {
    /// Stops the run when cancelled.
    pub cancel: CancelToken,
    /// Is told how far it has come.
    pub progress: &'a dyn Progress,
}

impl Default for Control<'_> {
    fn default() -> Self {
        Control { cancel: CancelToken::default(), progress: &Silent }
    }
}

impl std::fmt::Debug for Control<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Control").field("cancel", &self.cancel).finish_non_exhaustive()
    }
}
