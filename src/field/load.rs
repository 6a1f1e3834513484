//! From stored samples to the heights of a tile.

use super::error::NotAHeight;
use super::holes::Bridged;
use super::{Field, FieldError};
use crate::base::Window;
use crate::base::decimal::Decimal;
use crate::base::exact::MAX_WEIGHT;
use crate::base::stored::{Height, Sieve, Stored, Why};
use crate::base::with_sample_type;
use crate::base::{Heights, Tile, Validity, padded};

/// What becomes of samples without a value.
pub(super) enum Missing<'a> {
    /// They are marked, also those one sample around the window, and stand at 0.
    Marked(&'a mut Validity),
    /// They are marked, those of the window alone, and stand at 0.
    MarkedWithin(&'a mut Validity),
    /// They stand at 0 where these are missing, too, and are refused elsewhere.
    RefusedWhere(&'a Validity),
    /// They are refused.
    Refused,
}

impl Missing<'_> {
    /// Whether a sample is known to be missing.
    fn is_known(&self, column: i32, row: i32) -> bool {
        match self {
            Missing::Marked(validity) | Missing::MarkedWithin(validity) => !validity.is_valid(column, row),
            Missing::RefusedWhere(validity) => !validity.is_valid(column, row),
            Missing::Refused => false,
        }
    }
}

/// Memory that loading a tile takes beside the tile: at most the stored samples of the window and of those around it, and
/// 16 bytes for every sample of a bridged hole. Reused from tile to tile.
#[derive(Debug, Default)]
pub struct LoadScratch {
    /// Samples as they are stored.
    stored: Vec<u64>,
    /// Samples of bridged holes.
    bridged: Vec<Bridged>,
}

impl Field {
    /// Copies a window into `tile` as heights, with weights where the field has them, and beside them the channels'
    /// values, reusing its memory. Samples that the nodata value, NaN, a mask or the cutline says are no heights are
    /// marked in [`Tile::validity`], but those of bridged holes; of weights and channels none may be missing where there is a height.
    ///
    /// # Errors
    /// [`FieldError::Nodata`], [`FieldError::NotAHeight`], [`FieldError::NotAWeight`], [`FieldError::Inexact`], each
    /// naming such a sample of the window; [`FieldError::Raster`] where windows are read from the raster itself, or where it
    /// has changed and is watched ([`Field::watched`]).
    ///
    /// # Panics
    /// If the window is not inside the field.
    pub fn load(&self, window: Window, tile: &mut Tile) -> Result<(), FieldError> {
        self.load_with(window, tile, &mut LoadScratch::default())
    }

    /// The same with memory of the caller's, where many tiles are loaded one after another.
    ///
    /// # Errors
    /// As [`Field::load`].
    ///
    /// # Panics
    /// As [`Field::load`].
    pub fn load_with(&self, window: Window, tile: &mut Tile, scratch: &mut LoadScratch) -> Result<(), FieldError> {
        let loaded = self.load_unwatched(window, tile, scratch);
        // Afterwards: what changes later is not in the tile. It is the reason of whatever is wrong with the samples, too.
        self.check_files()?;
        loaded
    }

    /// Makes sure that the raster's files are what they were when the field was opened.
    pub(crate) fn check_files(&self) -> Result<(), FieldError> {
        Ok(self.watches.iter().try_for_each(|watch| watch.check_files())?)
    }

    /// As [`Field::load_with`], for who calls [`Field::check_files`] when all is loaded, whether or not that went well.
    pub(crate) fn load_unwatched(
        &self,
        window: Window,
        tile: &mut Tile,
        scratch: &mut LoadScratch,
    ) -> Result<(), FieldError> {
        let inside = window.column + window.width <= self.width && window.row + window.height <= self.height;
        assert!(inside, "{window:?} of a field of {} × {}", self.width, self.height);
        tile.width = window.width;
        tile.height = window.height;
        tile.eased.clear();
        tile.unbound.clear();
        let Tile { heights, weights, validity, channels, .. } = &mut *tile;
        let LoadScratch { stored, bridged } = scratch;
        bridged.clear();
        if let Some(holes) = &self.holes {
            holes.within(self.around(window), bridged)?;
        }
        // Of a hole beside the window nothing but the validity is seen.
        let is_bridged = bridged.iter().any(|sample| sample.place_in(window).is_some());
        validity.reset(window, (self.width, self.height));
        channels.resize_with(self.channels().len(), Vec::new);
        let fields = self.channels.iter().flat_map(|c| &c.fields);
        if self.is_image() {
            // A sample of an image is there if every attribute is.
            for (field, values) in fields.clone().zip(&mut *channels) {
                field.load_values(window, values, stored, Missing::Marked(validity))?;
            }
        }
        let missing = Missing::Marked(validity);
        if self.fits_f32() && !is_bridged {
            let heights = heights.as_f32(window.len());
            with_sample_type!(self.sample_type, T => self.copy::<T, f32>(window, stored, heights, missing))?;
        } else {
            let heights = heights.as_f64(window.len());
            with_sample_type!(self.sample_type, T => self.copy::<T, f64>(window, stored, heights, missing))?;
        }
        match &self.importance {
            Some(importance) => importance.load_weights(window, stored, padded(weights, window.len()), validity)?,
            None if is_bridged => padded(weights, window.len()).fill(1.0),
            None => weights.clear(),
        }
        self.bridge(window, tile, bridged);
        if !self.is_image() {
            let Tile { channels, validity, .. } = &mut *tile;
            let validity = &*validity;
            fields.zip(channels).try_for_each(|(field, values)| {
                field.load_values(window, values, stored, Missing::RefusedWhere(validity))
            })?;
        }
        tile.channels.iter_mut().for_each(|values| _ = padded(values, window.len()));
        tile.channel_error = self.channels.as_ref().map(|c| c.error.clone());
        Ok(())
    }

    /// Puts the samples of bridged holes that are known of the tile on the ground.
    fn bridge(&self, window: Window, tile: &mut Tile, bridged: &[Bridged]) {
        let Tile { heights, weights, validity, .. } = tile;
        for sample in bridged {
            let (column, row) =
                (i64::from(sample.column) - window.column as i64, i64::from(sample.row) - window.row as i64);
            // It has a height only if the raster has changed, which is noticed elsewhere.
            if validity.is_valid(column as i32, row as i32) {
                continue;
            }
            validity.bridge(column as i32, row as i32);
            if let (Some(place), Heights::F64(heights)) = (sample.place_in(window), &mut *heights) {
                heights[place] = sample.height;
                weights[place] = 0.0;
            }
        }
    }

    /// Whether tiles of this field hold their heights in single precision, but where holes are bridged.
    pub fn fits_f32(&self) -> bool {
        self.importance.is_none() && self.sample_type.fits_f32() && self.scaling.is_none()
    }

    /// Whether any sample may be without a height, by all that is known without reading them.
    pub(crate) fn may_have_gaps(&self) -> bool {
        let by_value = with_sample_type!(self.sample_type, T => T::HAS_NAN || !self.sieve::<T>().is_empty());
        let by_attribute = self.is_image() && self.channels.iter().flat_map(|c| &c.fields).any(Field::may_have_gaps);
        by_value || by_attribute || self.mask.is_some() || self.cutline.is_some()
    }

    /// What of its stored values is missing.
    pub(super) fn sieve<T: Stored>(&self) -> Sieve<T> {
        Sieve::new(&self.marks, self.scaling)
    }

    /// Copies a window of an importance raster as weights.
    fn load_weights(
        &self,
        window: Window,
        stored: &mut Vec<u64>,
        out: &mut [f64],
        heights: &Validity,
    ) -> Result<(), FieldError> {
        let missing = Missing::RefusedWhere(heights);
        with_sample_type!(self.sample_type, T => self.copy::<T, f64>(window, stored, out, missing))
            .map_err(FieldError::about_a_weight)?;
        let Some(index) = out.iter().position(|weight| !(0.0..=MAX_WEIGHT).contains(weight)) else { return Ok(()) };
        Err(FieldError::NotAWeight {
            path: self.name.clone(),
            column: window.column + index % window.width,
            row: window.row + index / window.width,
            found: Decimal(out[index]).to_string(),
        })
    }

    pub(super) fn copy<T: Stored, H: Height>(
        &self,
        window: Window,
        scratch: &mut Vec<u64>,
        out: &mut [H],
        mut missing: Missing<'_>,
    ) -> Result<(), FieldError> {
        if self.mark_outside(window, &mut missing) {
            out.fill(H::ZERO);
            return Ok(());
        }
        let sieve = self.sieve::<T>();
        let (is_marked, has_more) = (sieve.is_marked(), sieve.has_more());
        // Where no sample can be missing, nobody need look around the window.
        let may_miss = !sieve.is_empty() || T::HAS_NAN || self.mask.is_some();
        let outer = match &missing {
            Missing::Marked(_) if may_miss => self.around(window),
            _ => window,
        };
        self.mark_masked(outer, window, &mut missing)?;
        let scaling = (!self.scaling.is_none()).then_some(self.scaling);
        let (left, top) = ((window.column - outer.column) as i32, (window.row - outer.row) as i32);
        let is_missing = |stored: T| sieve.missing(stored).is_some();
        self.source.for_each_run(&self.name, outer, scratch, |row, column, bytes| {
            let stored = bytes.chunks_exact(size_of::<T>()).map(bytemuck::pod_read_unaligned::<T>);
            let (row, first) = (row as i32 - top, column as i32 - left);
            let end = first + stored.len() as i32;
            let inner = first.max(0)..end.min(window.width as i32);
            let mut suspicious = false;
            if row < 0 || row >= window.height as i32 || inner.is_empty() {
                suspicious = stored.clone().any(is_missing);
            } else {
                let start = row as usize * window.width;
                let heights = &mut out[start + inner.start as usize..start + inner.end as usize];
                for (height, stored) in heights.iter_mut().zip(stored.clone().skip((inner.start - first) as usize)) {
                    *height = H::of(stored, scaling);
                    suspicious |= !height.usable() | sieve.suspects(stored, is_marked) | !stored.exact();
                }
                suspicious |= has_more && stored.clone().any(is_missing);
                // The sample before the window and the one behind.
                suspicious |= first < inner.start && stored.clone().next().is_some_and(is_missing);
                suspicious |= end > inner.end && stored.clone().next_back().is_some_and(is_missing);
            }
            if !suspicious {
                return Ok(());
            }
            for (column, stored) in (first..).zip(stored) {
                if missing.is_known(column, row) {
                    continue;
                }
                let within = inner.contains(&column) && row >= 0 && row < window.height as i32;
                match (&mut missing, sieve.missing(stored)) {
                    (Missing::Marked(validity) | Missing::MarkedWithin(validity), Some(why)) => {
                        validity.mark(column, row);
                        if why == Why::Near {
                            validity.note_nearness();
                        }
                    }
                    _ if !within => {}
                    (_, why) => {
                        let place = ((window.column as i64 + i64::from(column)) as usize, window.row + row as usize);
                        self.refusal(stored, why, place).map_or(Ok(()), Err)?;
                    }
                }
            }
            Ok(())
        })?;
        self.level_missing(window, out, &missing);
        Ok(())
    }

    /// The window and the samples around it.
    pub(super) fn around(&self, window: Window) -> Window {
        let (column, row) = (window.column.saturating_sub(1), window.row.saturating_sub(1));
        let (right, bottom) = (window.column + window.width, window.row + window.height);
        let (right, bottom) = ((right + 1).min(self.width), (bottom + 1).min(self.height));
        Window { column, row, width: right - column, height: bottom - row }
    }

    /// Marks what is outside of the cutline. Whether all of the window is, so that nothing need be read.
    fn mark_outside(&self, window: Window, missing: &mut Missing<'_>) -> bool {
        let Some(cutline) = &self.cutline else { return false };
        let (validity, outer) = match missing {
            Missing::Marked(validity) => (validity, self.around(window)),
            Missing::MarkedWithin(validity) => (validity, window),
            Missing::RefusedWhere(_) | Missing::Refused => return false,
        };
        let (left, top) = (window.column - outer.column, window.row - outer.row);
        let mut inside = Vec::new();
        cutline.mask(outer, &mut inside);
        for (row, inside) in inside.chunks_exact(outer.width).enumerate() {
            for (column, _) in inside.iter().enumerate().filter(|(_, inside)| !**inside) {
                validity.mark(column as i32 - left as i32, row as i32 - top as i32);
            }
        }
        let mut rows = inside.chunks_exact(outer.width).skip(top).take(window.height);
        !rows.any(|row| row[left..left + window.width].contains(&true))
    }

    /// Marks what a mask says is no height, or refuses it.
    fn mark_masked(&self, outer: Window, window: Window, missing: &mut Missing<'_>) -> Result<(), FieldError> {
        let Some(mask) = &self.mask else { return Ok(()) };
        let mut words = Vec::new();
        mask.for_each_run(&self.name, outer, &mut words, |row, column, bytes| {
            for (i, _) in bytes.iter().enumerate().filter(|(_, valid)| **valid == 0) {
                let (column, row) = (outer.column + column + i, outer.row + row);
                let place = (column as i32 - window.column as i32, row as i32 - window.row as i32);
                match missing {
                    Missing::Marked(validity) | Missing::MarkedWithin(validity) => validity.mark(place.0, place.1),
                    _ if missing.is_known(place.0, place.1) => {}
                    _ => {
                        let (path, found) = (self.name.clone(), "masked".to_string());
                        return Err(FieldError::Nodata { path, column, row, found });
                    }
                }
            }
            Ok(())
        })
    }

    /// Puts 0 where no value is.
    fn level_missing<H: Height>(&self, window: Window, out: &mut [H], missing: &Missing<'_>) {
        let validity = match missing {
            Missing::Marked(validity) | Missing::MarkedWithin(validity) => &**validity,
            Missing::RefusedWhere(validity) => validity,
            Missing::Refused => return,
        };
        for (row, values) in out.chunks_exact_mut(window.width).enumerate() {
            for (value, _) in values.iter_mut().zip(validity.row(row)).filter(|(_, valid)| !**valid) {
                *value = H::ZERO;
            }
        }
    }

    /// The refusal of the value stored at this place, if it is no height: it is missing, or cannot be used.
    fn refusal<T: Stored>(&self, stored: T, why: Option<Why>, (column, row): (usize, usize)) -> Option<FieldError> {
        let path = self.name.clone();
        let value = stored.to_f64();
        let height = self.scaling.height(value);
        if why.is_some() {
            return Some(FieldError::Nodata { path, column, row, found: Decimal(value).to_string() });
        }
        if !stored.exact() {
            return Some(FieldError::Inexact { path, column, row, found: stored.to_i128() });
        }
        let found = || NotAHeight { path, column, row, height, stored: value, tag: self.tag };
        (!height.usable()).then(|| FieldError::NotAHeight(Box::new(found())))
    }
}
