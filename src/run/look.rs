//! A look at all heights of a raster: their range, and what hints that samples are missing that nothing marks, or marked
//! that are heights.
//!
//! `info` looks always; `simplify` and `verify` where what they saw on their way may be worth a warning.

use crate::base::Window;
use crate::base::control::{Cancelled, Control, Stage};
use crate::base::warning::{Warning, WarningCode};
use crate::base::{Band, Mark, Marks, NEAR_VOID, RasterError};
use crate::verify::HeightReader;

/// Samples read at a time, about.
const SAMPLES: usize = 1 << 20;

/// How many samples of a kind there are, and the first of them by rows.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Found {
    /// How many.
    pub count: u64,
    /// Column, row and value of the first.
    pub first: Option<(usize, usize, f64)>,
}

impl Found {
    fn note(&mut self, column: usize, row: usize, value: f64) {
        self.count += 1;
        self.first.get_or_insert((column, row, value));
    }
}

/// What a look has found.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Look {
    /// The least and the largest valid height; `None` where there is none.
    pub range: Option<(f64, f64)>,
    /// Samples with a height.
    pub valid: u64,
    /// Samples without.
    pub missing: u64,
    /// Samples that are missing for their nearness to a mark that they do not equal.
    pub by_nearness: Found,
    /// Samples that are missing as they equal a nodata tag of 0.
    pub zeros: Found,
    /// Heights within three columns and rows of a void that lie more than max − min beyond the range of all that are
    /// farther away.
    pub near_voids: Found,
}

/// Why a look has come to nothing.
#[derive(Debug, thiserror::Error)]
pub enum LookError {
    /// The raster cannot be read.
    #[error(transparent)]
    Raster(#[from] RasterError),
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// The least and the largest number.
#[derive(Debug, Clone, Copy)]
struct Range(f64, f64);

impl Range {
    const EMPTY: Range = Range(f64::INFINITY, f64::NEG_INFINITY);

    fn add(&mut self, value: f64) {
        *self = Range(self.0.min(value), self.1.max(value));
    }

    fn is_empty(self) -> bool {
        self.0 > self.1
    }

    /// The range, widened at both ends by as much as it is wide.
    fn tripled(self) -> Range {
        let width = self.1 - self.0;
        Range(self.0 - width, self.1 + width)
    }

    fn holds(self, value: f64) -> bool {
        self.0 <= value && value <= self.1
    }
}

/// Looks at every sample of `raster`, once; where heights near voids lie far beyond all others, once more.
///
/// Memory: 18 bytes for each of about 2²⁰ samples, or of seven rows where that is more.
///
/// # Errors
/// [`LookError`]: the raster cannot be read, its rows are too long ([`Band::holds_rows`]), or the caller asked to stop.
/// Infinite heights are passed over.
pub fn look(band: &Band, control: &Control<'_>) -> Result<Look, LookError> {
    band.holds_rows(band.width())?;
    let mut look = Look::default();
    let (mut far, mut near) = (Range::EMPTY, Range::EMPTY);
    let mut reader = Reader::new(band);
    reader.for_each(control, |_, _, height, is_near| match height {
        Some(height) => {
            look.valid += 1;
            if is_near { near.add(height) } else { far.add(height) }
        }
        None => look.missing += 1,
    })?;
    look.by_nearness = reader.by_nearness;
    look.zeros = reader.zeros;
    let all = Range(far.0.min(near.0), far.1.max(near.1));
    look.range = (!all.is_empty()).then_some((all.0, all.1));
    let usual = far.tripled();
    let is_usual = usual.holds(near.0) && usual.holds(near.1);
    if !(far.is_empty() || near.is_empty() || is_usual) {
        let found = &mut look.near_voids;
        Reader::new(band).for_each(control, |column, row, height, is_near| {
            if let Some(height) = height.filter(|h| is_near && !usual.holds(*h)) {
                found.note(column, row, height);
            }
        })?;
    }
    Ok(look)
}

impl Look {
    /// What of it is worth a warning.
    pub fn warnings(&self, band: &Band) -> Vec<Warning> {
        let place = |found: &Found| {
            let (column, row, value) = found.first.unwrap_or_default();
            format!("{} at column {column}, row {row}", crate::base::decimal::Decimal(value))
        };
        let one = |found: &Found, code, message: String| {
            let file = band.path().to_path_buf();
            (found.count > 0).then_some(Warning { code, file, count: found.count, message })
        };
        let samples = |found: &Found| match found.count {
            1 => "1 sample".to_string(),
            count => format!("{count} samples"),
        };
        let marks = || band.marks().values.iter().map(Mark::to_string).collect::<Vec<_>>().join(" or ");
        let near = &self.by_nearness;
        let near = one(near, WarningCode::NearNodata, {
            let (samples, mark) = (samples(near), marks());
            format!("{samples} count as missing by being close to the nodata value {mark}, the first {}", place(near))
        });
        let zeros = &self.zeros;
        let zeros = one(zeros, WarningCode::ZeroNodata, {
            let origin = band.zero_tag.unwrap_or_default();
            format!("the nodata tag is 0{origin}: {} with that value count as missing", samples(zeros))
        });
        let voids = &self.near_voids;
        let voids = one(voids, WarningCode::NearVoids, {
            let samples = samples(voids);
            format!("{samples} beside voids lie far beyond the heights of all others, the first {}", place(voids))
        });
        [near, zeros, voids].into_iter().flatten().collect()
    }
}

/// Rows of a raster with the rows around them.
struct Reader<'r> {
    band: &'r Band,
    reader: HeightReader<'r>,
    /// Whether stored values must be looked at: samples may be missing by nearness, or by a tag of 0.
    asks_stored: bool,
    zero_tag: bool,
    by_nearness: Found,
    zeros: Found,
}

impl<'r> Reader<'r> {
    fn new(band: &'r Band) -> Reader<'r> {
        let Marks { values, .. } = band.marks();
        let zero_tag = band.zero_tag.is_some();
        let asks_stored = zero_tag || values.iter().any(|mark| matches!(mark, Mark::Real(v) if v.is_finite()));
        Reader {
            band,
            reader: HeightReader::new(band),
            asks_stored,
            zero_tag,
            by_nearness: Found::default(),
            zeros: Found::default(),
        }
    }

    /// Calls `visit(column, row, height, is near a void)` for every sample; outside of the cutline none has a height.
    fn for_each(
        &mut self,
        control: &Control<'_>,
        mut visit: impl FnMut(usize, usize, Option<f64>, bool),
    ) -> Result<(), LookError> {
        let (width, height) = (self.band.width(), self.band.height());
        let rows = (SAMPLES / width).max(1);
        let (mut heights, mut inside) = (Vec::new(), Vec::new());
        control.progress.begin(Stage::Ranges, height.div_ceil(rows) as u64, width as u64 * height as u64);
        for first in (0..height).step_by(rows) {
            control.cancel.check()?;
            let after = (first + rows).min(height);
            let (top, bottom) = (first.saturating_sub(NEAR_VOID), (after + NEAR_VOID).min(height));
            let window = Window { column: 0, row: top, width, height: bottom - top };
            heights.resize(window.len(), 0.0);
            self.reader.read_marked(window, &mut heights)?;
            let own = Window { row: first, height: after - first, ..window };
            inside.clear();
            if let Some(cutline) = self.band.cutline() {
                cutline.mask(own, &mut inside);
            }
            if self.asks_stored {
                self.look_at_stored(own, &heights[(first - top) * width..], &inside)?;
            }
            let near = near_voids(&heights, width);
            for (i, k) in ((first - top) * width..(after - top) * width).enumerate() {
                let is_inside = inside.get(i).is_none_or(|inside| *inside);
                let height = Some(heights[k]).filter(|h| is_inside && !h.is_nan());
                if height.is_none_or(f64::is_finite) {
                    visit(i % width, first + i / width, height, near[k]);
                }
            }
            control.progress.step(Stage::Ranges, own.len() as u64);
        }
        control.progress.end(Stage::Ranges);
        Ok(())
    }

    /// Finds out why samples of a window are missing, inside of the cutline where there is one.
    fn look_at_stored(&mut self, window: Window, heights: &[f64], inside: &[bool]) -> Result<(), RasterError> {
        if !heights[..window.len()].iter().any(|h| h.is_nan()) {
            return Ok(());
        }
        let mut stored = vec![0.0; window.len()];
        self.reader.read_stored(window, &mut stored)?;
        for (i, (stored, _)) in stored.iter().zip(heights).enumerate().filter(|(_, (_, h))| h.is_nan()) {
            if inside.get(i).is_some_and(|inside| !inside) {
                continue;
            }
            let (column, row) = (i % window.width, window.row + i / window.width);
            if self.zero_tag && *stored == 0.0 {
                self.zeros.note(column, row, *stored);
            } else if self.reader.is_missing_by_nearness(*stored) {
                self.by_nearness.note(column, row, *stored);
            }
        }
        Ok(())
    }
}

/// Which samples have a void within [`NEAR_VOID`] columns and rows.
fn near_voids(heights: &[f64], width: usize) -> Vec<bool> {
    let height = heights.len() / width;
    let mut near = vec![false; heights.len()];
    let mut along = vec![false; width];
    for (row, heights) in heights.chunks_exact(width).enumerate() {
        if !heights.iter().any(|h| h.is_nan()) {
            continue;
        }
        along.fill(false);
        for (column, _) in heights.iter().enumerate().filter(|(_, h)| h.is_nan()) {
            along[column.saturating_sub(NEAR_VOID)..(column + NEAR_VOID + 1).min(width)].fill(true);
        }
        for row in row.saturating_sub(NEAR_VOID)..(row + NEAR_VOID + 1).min(height) {
            let flags = &mut near[row * width..(row + 1) * width];
            flags.iter_mut().zip(&along).for_each(|(near, along)| *near |= along);
        }
    }
    near
}
