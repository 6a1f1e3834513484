//! Masks: which samples a raster says are there, whoever opens it.

use super::{SampleType, with_sample_type};

/// What GDAL says of the mask of a band (`GetMaskFlags`).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct MaskFlags {
    /// All samples are there.
    pub all_valid: bool,
    /// One mask is for all bands.
    pub per_dataset: bool,
    /// It is an alpha band.
    pub alpha: bool,
    /// It is made of a nodata tag.
    pub nodata: bool,
}

impl MaskFlags {
    /// Whether GDAL's mask is one of the file, and is asked: a mask band, or one value for each band together
    /// (`NODATA_VALUES`). What GDAL makes of the band's own nodata tag is not asked, as [`super::Marks`] say it, nor what it
    /// makes of alpha, see [`Masks::alpha_band`].
    pub fn is_of_file(self) -> bool {
        !self.all_valid && !self.alpha && (!self.nodata || self.per_dataset)
    }
}

/// What says that samples are missing, beside marks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Masks {
    /// GDAL's mask of the file.
    pub file: bool,
    /// The alpha band, from 1.
    pub alpha: Option<usize>,
}

impl Masks {
    /// The masks that count for a band of `bands`, from 1. `is_alpha` is asked which of them are alpha.
    pub fn of(flags: MaskFlags, band: usize, bands: usize, is_alpha: impl Fn(usize) -> bool) -> Masks {
        Masks { file: flags.is_of_file(), alpha: Masks::alpha_band(band, bands, is_alpha) }
    }

    /// The alpha band that counts for a band, from 1: the last one that is said to be alpha, of whatever type, unless it is that
    /// band. `is_alpha` is asked for bands from 1 to `bands`. (GDAL's own masks heed alpha bands of bytes and UInt16 only, of two
    /// or four bands, and none together with a nodata tag.)
    pub fn alpha_band(band: usize, bands: usize, is_alpha: impl Fn(usize) -> bool) -> Option<usize> {
        (1..=bands).rev().find(|number| is_alpha(*number)).filter(|number| *number != band)
    }

    /// Whether there is one.
    pub fn are_some(self) -> bool {
        self.file || self.alpha.is_some()
    }
}

/// Clears the mask where alpha is 0 or NaN: nothing is there. `stored` are values of this type, as many as `mask` has bytes,
/// aligned to it.
///
/// # Panics
/// If it is not.
pub fn mask_by_alpha(sample_type: SampleType, stored: &[u8], mask: &mut [u8]) {
    with_sample_type!(sample_type, T => {
        for (valid, value) in mask.iter_mut().zip(bytemuck::cast_slice::<u8, T>(stored)) {
            // NaN is equal to nothing, itself included.
            #[allow(clippy::eq_op)]
            if *value == T::default() || *value != *value {
                *valid = 0;
            }
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_alpha_band_counts_unless_it_is_looked_at() {
        let alpha = |band, alphas: &[usize]| Masks::alpha_band(band, 4, |number| alphas.contains(&number));
        assert_eq!(
            (alpha(1, &[]), alpha(1, &[2, 4]), alpha(4, &[2, 4]), alpha(1, &[2])),
            (None, Some(4), None, Some(2))
        );
    }

    #[test]
    fn gdals_mask_is_asked_where_it_says_more_than_the_tag() {
        let flags = MaskFlags::default();
        assert!(flags.is_of_file() && MaskFlags { per_dataset: true, nodata: true, ..flags }.is_of_file());
        let others = [
            MaskFlags { all_valid: true, ..flags },
            MaskFlags { nodata: true, ..flags },
            MaskFlags { alpha: true, per_dataset: true, ..flags },
        ];
        assert!(!others.iter().any(|flags| flags.is_of_file()));
    }

    #[test]
    fn alpha_of_zero_and_nan() {
        let mut mask = [255; 4];
        let alpha = [1.0f32, 0.0, f32::NAN, -1.0];
        mask_by_alpha(SampleType::F32, bytemuck::cast_slice(&alpha), &mut mask);
        assert_eq!(mask, [255, 0, 0, 255]);
    }
}
