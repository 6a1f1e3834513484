use serde::Serialize;

use super::Params;
use crate::base::control::Cancelled;
use crate::base::mesh::TileMesh;
use crate::kernel::polish::{self, Effort};
use crate::kernel::triangulate::cuts::{Cuts, GreedyCuts};
use crate::kernel::triangulate::insertion::{GreedyInsertion, InsertionOptions};
use crate::kernel::triangulate::{Engine, Task};

/// The engine that triangulates tiles, and which of its variants.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum EngineChoice {
    /// [`GreedyCuts`].
    GreedyCuts(Cuts),
    /// [`GreedyInsertion`].
    GreedyInsertion(InsertionOptions),
}

impl Default for EngineChoice {
    fn default() -> Self {
        EngineChoice::GreedyInsertion(InsertionOptions::default())
    }
}

impl EngineChoice {
    /// What it is called in messages.
    pub fn name(&self) -> &'static str {
        match self {
            EngineChoice::GreedyCuts(_) => "greedy cuts",
            EngineChoice::GreedyInsertion(_) => "greedy insertion",
        }
    }

    /// [`Engine::preinserts`].
    pub fn preinserts(&self) -> bool {
        match *self {
            EngineChoice::GreedyCuts(cuts) => GreedyCuts { cuts }.preinserts(),
            EngineChoice::GreedyInsertion(options) => GreedyInsertion { options }.preinserts(),
        }
    }

    /// [`Engine::KEEPS_CHANNELS`].
    pub fn keeps_channels(&self) -> bool {
        match self {
            EngineChoice::GreedyCuts(_) => GreedyCuts::KEEPS_CHANNELS,
            EngineChoice::GreedyInsertion(_) => GreedyInsertion::KEEPS_CHANNELS,
        }
    }

    /// What of this decides the bytes of a tile, as text.
    pub(super) fn named(&self) -> String {
        match self {
            EngineChoice::GreedyCuts(Cuts::Plain) => "greedy cuts, plain".to_string(),
            EngineChoice::GreedyCuts(Cuts::Improved) => "greedy cuts, improved".to_string(),
            EngineChoice::GreedyInsertion(options) => format!("greedy insertion: {}", options.named()),
        }
    }

    /// What a thread needs for a tile, per sample, at the most: as many vertices as samples and twice as many triangles.
    ///
    /// Samples 8 and as they are stored 8, the mesh 16 + 24, its chunk 16 + 24 and the encoded chunk 16 + 24. Beside that
    /// greedy cuts have the nodes of the front and its queues, about 40: tiles of half a million triangles took 163.
    /// Greedy insertion has 24 bytes of half-edges and 24 of candidates and their heap a triangle, and its vertices beside
    /// the mesh's; data-dependent swapping keeps 8 more a triangle.
    pub(super) fn bytes_per_sample(&self) -> u64 {
        match self {
            EngineChoice::GreedyCuts(_) => 180,
            EngineChoice::GreedyInsertion(_) => 270,
        }
    }
}

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

    /// What it adds to what a thread needs for a tile, per sample: 33 bytes per vertex and 48 per triangle.
    pub(super) fn bytes_per_sample(&self) -> u64 {
        if *self == Quality::None { 0 } else { 130 }
    }
}

/// How meshes are polished, if they are.
pub(super) fn polishing(params: &Params) -> Option<polish::Options> {
    let effort = params.quality.effort()?;
    Some(polish::Options { effort, heights: params.heights, tuning: params.tuning })
}

/// The memory of whichever engine runs; that of the others stays empty.
#[derive(Default)]
pub(super) struct EngineScratch {
    cuts: <GreedyCuts as Engine>::Scratch,
    insertion: <GreedyInsertion as Engine>::Scratch,
    polish: polish::Scratch,
}

impl EngineScratch {
    /// [`Engine::triangulate`] by the engine of choice.
    pub(super) fn triangulate(
        &mut self,
        choice: EngineChoice,
        task: &Task<'_>,
        mesh: &mut TileMesh,
    ) -> Result<(), Cancelled> {
        match choice {
            EngineChoice::GreedyCuts(cuts) => GreedyCuts { cuts }.triangulate(task, &mut self.cuts, mesh),
            EngineChoice::GreedyInsertion(options) => {
                GreedyInsertion { options }.triangulate(task, &mut self.insertion, mesh)
            }
        }
    }

    /// Polishes the mesh of whichever engine.
    pub(super) fn polish(&mut self, params: &Params, task: &Task<'_>, mesh: &mut TileMesh) -> Result<(), Cancelled> {
        let Some(options) = polishing(params) else { return Ok(()) };
        polish::polish(task, &options, &mut self.polish, mesh)
    }

    /// The memory of greedy insertion.
    pub(super) fn insertion(&mut self) -> &mut <GreedyInsertion as Engine>::Scratch {
        &mut self.insertion
    }
}
