//! The windows: 120 × 120 samples of a raster and the tolerance that goes with them, by a rule.

use terrabite::base::{Band, Heights, Tile};

use super::franklin;
use crate::paper::{Outcome, load};

/// Samples along each side, as in both papers.
const SIDE: usize = 120;
/// At most every tenth sample is taken: a quadrangle of 1,201 × 1,201 samples becomes a window.
const MOST: usize = 10;
/// Tolerances that are tried: these times powers of ten.
const STEPS: [f64; 9] = [1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0];
/// Between what Franklin's algorithm takes in the papers, 1,297 and 2,822 triangles, in the middle of their ratio.
const TRIANGLES: f64 = 1_900.0;

/// 120 × 120 samples in the middle of a raster, taken as they are at the largest stride up to 10 that fits.
pub(crate) struct Window {
    /// Every how many-th sample of a row and of a column.
    pub(crate) stride: usize,
    /// Column and row of the first sample in the raster.
    pub(crate) first: (usize, usize),
    /// The samples.
    pub(crate) tile: Tile,
}

impl Window {
    /// The window of a raster.
    pub(crate) fn of(raster: &str) -> Outcome<Window> {
        let whole = load(raster)?;
        let shorter = whole.width().min(whole.height());
        let stride = ((shorter - 1) / (SIDE - 1)).min(MOST);
        if stride == 0 {
            return Err(format!("{raster}: fewer than {SIDE} samples along a side").into());
        }
        let span = stride * (SIDE - 1) + 1;
        let first = ((whole.width() - span) / 2, (whole.height() - span) / 2);
        let place = |i: usize| (first.0 + stride * (i % SIDE), first.1 + stride * (i / SIDE));
        if (0..SIDE * SIDE).map(place).any(|(column, row)| !whole.validity().is_valid(column as i32, row as i32)) {
            return Err(format!("{raster}: a sample is missing in the window").into());
        }
        let heights = (0..SIDE * SIDE).map(place).map(|(column, row)| whole.at(column, row) as f32).collect();
        Ok(Window { stride, first, tile: Tile::from_heights(SIDE, SIDE, Heights::F32(heights)) })
    }

    /// The samples, row by row.
    pub(crate) fn heights(&self) -> impl Iterator<Item = f64> {
        (0..SIDE * SIDE).map(|i| self.tile.at(i % SIDE, i / SIDE))
    }

    /// The least and the largest height.
    pub(crate) fn range(&self) -> (f64, f64) {
        self.heights().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), h| (low.min(h), high.max(h)))
    }

    /// The same samples as the band of a raster.
    pub(crate) fn band(&self) -> Outcome<Band> {
        Ok(Band::of_singles("window", (SIDE, SIDE), self.heights().map(|h| h as f32).collect())?)
    }
}

/// The tolerance with which Franklin's algorithm, edges swapped by the circle, comes nearest to 1,900 triangles, and how
/// many it takes.
pub(crate) fn tolerance_of(window: &Window) -> Outcome<(f64, usize)> {
    // Read as text would be: 0.15 is not 15 times the double nearest to 0.01.
    let all = (-2..=3).flat_map(|power| STEPS.map(|step| format!("{step}e{power}")));
    let mut nearest: Option<(f64, usize)> = None;
    let distance = |triangles: usize| (triangles as f64 / TRIANGLES).ln().abs();
    for text in all {
        let tolerance: f64 = text.parse()?;
        let triangles = franklin(Default::default(), window, tolerance)?.triangles.len();
        if nearest.is_none_or(|(_, best)| distance(triangles) < distance(best)) {
            nearest = Some((tolerance, triangles));
        }
    }
    let nearest = nearest.ok_or("no tolerance was tried")?;
    if (1_300..=2_800).contains(&nearest.1) {
        Ok(nearest)
    } else {
        Err(format!("no tolerance fits: {nearest:?}").into())
    }
}
