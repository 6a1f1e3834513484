//! Colours.

/// Samples beyond the tolerance.
pub(super) const EXCEEDED: [u8; 3] = [255, 0, 60];
/// Samples of the ground without a surface.
pub(super) const UNCOVERED: [u8; 3] = [0, 190, 255];
/// No height, or none around.
pub(super) const NO_GROUND: [u8; 3] = [70, 70, 78];

/// An error as a share of the scale's end. Cividis: even to the eye, also to colour-blind ones, and without red.
pub(super) fn scale(share: f64) -> [u8; 3] {
    let share = if share.is_nan() { 0.0 } else { share.clamp(0.0, 1.0) };
    colorous::CIVIDIS.eval_continuous(share).into_array()
}
