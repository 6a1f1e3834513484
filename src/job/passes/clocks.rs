//! Where the time of the tiles goes.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

/// Seconds of all threads together, by what a tile goes through.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize)]
pub struct TileTimes {
    /// Copying samples out of the field.
    pub load: f64,
    /// The sides.
    pub seams: f64,
    /// The engine.
    pub engine: f64,
    /// Polishing.
    pub polish: f64,
    /// Measuring the errors of the finished mesh.
    pub measure: f64,
    /// Keeping the finished tile, and reading those that others have kept.
    pub spool: f64,
}

impl TileTimes {
    /// Adds the seconds of other tiles.
    pub fn plus(self, other: TileTimes) -> TileTimes {
        TileTimes {
            load: self.load + other.load,
            seams: self.seams + other.seams,
            engine: self.engine + other.engine,
            polish: self.polish + other.polish,
            measure: self.measure + other.measure,
            spool: self.spool + other.spool,
        }
    }
}

#[derive(Default)]
pub(super) struct Clocks {
    pub(super) load: Clock,
    pub(super) seams: Clock,
    pub(super) engine: Clock,
    pub(super) polish: Clock,
    pub(super) measure: Clock,
    pub(super) spool: Clock,
}

impl Clocks {
    pub(super) fn read(&self) -> TileTimes {
        TileTimes {
            load: self.load.seconds(),
            seams: self.seams.seconds(),
            engine: self.engine.seconds(),
            polish: self.polish.seconds(),
            measure: self.measure.seconds(),
            spool: self.spool.seconds(),
        }
    }
}

/// Nanoseconds, added up over threads.
#[derive(Default)]
pub(super) struct Clock(AtomicU64);

impl Clock {
    pub(super) fn time<T>(&self, work: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let result = work();
        self.0.fetch_add(start.elapsed().as_nanos() as u64, Ordering::Relaxed);
        result
    }

    fn seconds(&self) -> f64 {
        self.0.load(Ordering::Relaxed) as f64 * 1e-9
    }
}
