//! The dial of quality: how much polishing follows the engine.

use serde::Serialize;

use super::Params;
use crate::kernel::polish::{self, Caps, Effort, Schedule};

/// How much work goes into fewer triangles once the engine is done: the stage is [`polish`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Quality {
    /// None.
    None,
    /// [`Effort::Fast`].
    Fast,
    /// [`Effort::Balanced`].
    #[default]
    Balanced,
    /// [`Effort::Best`].
    Best,
}

impl Quality {
    /// What it is called.
    pub fn name(&self) -> &'static str {
        match self {
            Quality::None => "none",
            Quality::Fast => "fast",
            Quality::Balanced => "balanced",
            Quality::Best => "best",
        }
    }

    /// What it asks of polishing.
    pub fn effort(&self) -> Option<Effort> {
        match self {
            Quality::None => None,
            Quality::Fast => Some(Effort::Fast),
            Quality::Balanced => Some(Effort::Balanced),
            Quality::Best => Some(Effort::Best),
        }
    }
}

/// How meshes are polished, if they are.
pub(super) fn polishing(params: &Params) -> Option<polish::Options> {
    let effort = params.quality.effort()?;
    Some(polish::Options { effort, heights: params.heights, tuning: params.tuning })
}

/// A tile with fewer triangles than this is at most about ten edges wide.
const FEW: usize = 256;

/// Caps of patient polishing.
const PATIENT: Caps = match Caps::new(&[3.0, 6.0]) {
    Some(caps) => caps,
    None => panic!("two caps"),
};

/// How a tile of so many triangles is polished again, around what could not move before. Where a tile is only a few edges
/// wide, most of its mesh has been fitted to that, and it takes more patience to come away from it; there is little to be
/// patient with. Numbers that are given are kept to, and best effort is patient anyway.
pub(super) fn polishing_again(params: &Params, triangles: usize) -> Option<polish::Options> {
    let mut options = polishing(params)?;
    if options.tuning.schedule.is_none() && options.effort == Effort::Balanced && triangles < FEW {
        let usual = Schedule::preset(options.effort, options.heights);
        let (passes, rounds, reach) = (usual.passes.max(6), usual.rounds.max(8), usual.reach.max(1.0));
        options.tuning.schedule = Some(Schedule { passes, caps: PATIENT, rounds, reach, ..usual });
    }
    Some(options)
}
