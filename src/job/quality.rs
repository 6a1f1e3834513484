//! The dial of quality: how much polishing follows the engine.

use serde::Serialize;

use super::Params;
use crate::kernel::polish::{self, Effort};

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
