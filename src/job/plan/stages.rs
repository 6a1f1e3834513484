//! What one thread holds of a tile, stage by stage: bytes for every sample, where every sample is a vertex and there are two
//! triangles for each.
//!
//! Stages hand memory over ([`crate::base::handed_over`]), so what counts is the one that takes the most, and beside it what
//! is there all the time: the samples, and what stages keep of ordinary tiles.

use super::Load;
use crate::base::handed_over::{KEPT_BYTES, KEPT_BYTES_PER_TRIANGLE};
use crate::job::Quality;

/// A mesh, or a chunk: 16 for its vertex, 12 for each triangle.
const MESH: u64 = 16 + 2 * 12;

/// An encoded chunk.
const ENCODED: u64 = MESH;

/// What polishing takes, the mesh included: see [`crate::kernel::polish::Scratch`]. While a mesh is loaded, its triangles
/// are there twice.
pub(crate) const POLISHING: u64 = MESH + 2 * 36 + 4;

/// What a region of a later pass takes when the last of its chunks is read: three quarters of its mesh, that chunk and
/// its encoded form; and numbers and kinds of vertices.
const GATHERING: u64 = MESH * 3 / 4 + MESH + ENCODED + 4 + 1;

/// What ordering takes ([`crate::job::order`]), the chunk included: the new triangles; in meshoptimizer, for each vertex three
/// numbers, for each triangle its corners, a number and a flag.
pub(super) const ORDERING: u64 = MESH + 2 * 12 + 3 * 4 + 2 * (12 + 4 + 1);

/// What a goal adds to the engine: sums of squared errors, 8 for each triangle, and what is told of an insertion, 56.
const GOAL: u64 = 2 * 8 + 56;

/// What trimming takes beside the samples, before there is a mesh: 3 bytes, and where every sample is a corner of a loop 72
/// for that, see [`crate::kernel::boundary`], and the loops.
const TRIMMING: u64 = 3 + 72 + 25;

/// What writing a chunk takes beside it, for a vertex: its number, and its place where corners are asked for.
const NUMBERS: u64 = 8 + 24;

/// What normals take: what they are made of, themselves, and both as columns.
const NORMALS: u64 = 3 * 24;

/// What the writer of a format takes.
const SINK: u64 = 12 << 20;

/// What a solid adds: walls along the rim, and the sort of its edges, see `formats::stl`.
const SOLID: u64 = 30 << 20;

/// What numbering takes of the two rows of tiles that are at hand, for each column of samples: where tiles lend each other
/// vertices along all of their sides, 32 bytes for each.
const NUMBERING: u64 = 2 * 4 * 32;

/// What writing the mesh takes when all tiles with up to so many samples are there: one chunk at a time.
pub(super) fn writing_bytes(load: &Load<'_>, samples: u64) -> u64 {
    let values = 8 * load.channels.len() as u64;
    let normals = if load.normals { NORMALS + samples_bytes(load) } else { 0 };
    let chunk = MESH + values + (ENCODED + values).max(NUMBERS).max(normals);
    let solid = if load.solid { SOLID } else { 0 };
    samples * chunk + SINK + solid + NUMBERING * load.band.width() as u64
}

/// What one thread holds of a tile with so many samples.
pub(super) fn thread_bytes(load: &Load<'_>, samples: u64) -> u64 {
    let kept = KEPT_BYTES.min(2 * samples * KEPT_BYTES_PER_TRIANGLE);
    samples * (samples_bytes(load) + stage_bytes(load)) + kept
}

/// The samples of a tile, for each: what loading it takes, its height, its validity, its weight, its channels.
pub(super) fn samples_bytes(load: &Load<'_>) -> u64 {
    let stored = load.bands().map(|band| band.sample_type().bytes()).max().unwrap_or(0) as u64;
    let is_weighted = load.importance.is_some() || load.holes;
    let is_single = !is_weighted && load.band.sample_type().fits_f32() && load.band.scaling().is_none();
    let heights = if is_single { 4 } else { 8 };
    let weights = if is_weighted { 8 } else { 0 };
    // Where holes are bridged, which samples of it are.
    let validity = if load.holes { 2 } else { 1 };
    // Where lines end the mesh, what they leave around samples.
    let cut = u64::from(load.lines_bytes > 0);
    stored + heights + weights + validity + cut + 8 * load.channels.len() as u64
}

/// The stage that takes the most, for each sample.
fn stage_bytes(load: &Load<'_>) -> u64 {
    let params = load.params;
    // Of a channel a chunk has its values at vertices, and has them encoded.
    let values = 8 * load.channels.len() as u64;
    let goal = if load.stops_in_order() { GOAL } else { 0 };
    let trimming = if params.trim > 0 { TRIMMING } else { 0 };
    let polishing = if params.quality == Quality::None { 0 } else { POLISHING };
    let gathering = if params.passes(load.grid) > 1 { GATHERING } else { 0 };
    let engine = params.engine.bytes_per_sample() + goal;
    let (ordering, keeping) = (ORDERING + values, MESH + ENCODED + 2 * values);
    [engine, trimming, polishing, gathering, ordering, keeping].into_iter().max().unwrap_or(0)
}
