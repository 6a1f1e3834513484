//! Which samples have a height, for `verify` and `preview`.
//!
//! A sample has none if its stored value is NaN or like a mark ([`Mark`]), if its height is outside of the valid range, if a
//! mask or alpha band says so, or if it is outside of the cutline. `field/stored` says the same for the engines, in code of
//! its own.

use super::marks::NEARNESS;
use super::read::Stored;
use super::{Mark, Raster, RasterError, SampleType, with_sample_type};
use crate::base::Window;

impl Raster {
    /// Reads a window as heights, scale and offset applied, rows one after the other; NaN where a sample has no height.
    ///
    /// # Errors
    /// [`RasterError::Read`]; [`RasterError::Gdal`] when GDAL cannot tell whether there is a mask.
    ///
    /// # Panics
    /// If `out` is not `window.len()` long, or the window is not inside the raster.
    pub fn read_valid_heights(&self, window: Window, out: &mut [f64]) -> Result<(), RasterError> {
        let mut inside = Vec::new();
        if let Some(cutline) = &self.cutline {
            cutline.mask(window, &mut inside);
            if !inside.contains(&true) {
                out.fill(f64::NAN);
                return Ok(());
            }
        }
        self.read_marked_heights(window, out)?;
        // Empty where there is no cutline.
        out.iter_mut().zip(inside).filter(|(_, inside)| !inside).for_each(|(v, _)| *v = f64::NAN);
        Ok(())
    }

    /// The same, whatever the cutline says.
    pub(super) fn read_marked_heights(&self, window: Window, out: &mut [f64]) -> Result<(), RasterError> {
        assert_eq!(out.len(), window.len(), "heights of {window:?}");
        let bytes = window.len() * self.sample_type().bytes();
        let mut words = vec![0u64; bytes.div_ceil(8)];
        let stored = &mut bytemuck::cast_slice_mut(&mut words)[..bytes];
        self.read_native(window, stored)?;
        with_sample_type!(self.sample_type(), T => self.heights_of(bytemuck::cast_slice::<u8, T>(stored), out));
        if self.has_mask()? {
            let mut mask = vec![0; window.len()];
            self.read_mask(window, &mut mask)?;
            out.iter_mut().zip(mask).filter(|(_, m)| *m == 0).for_each(|(v, _)| *v = f64::NAN);
        }
        Ok(())
    }

    fn heights_of<T: Stored>(&self, stored: &[T], out: &mut [f64]) {
        out.iter_mut().zip(stored).for_each(|(height, stored)| *height = stored.double());
        self.scale(out);
        for mark in &self.marks().values {
            match likeness(*mark, self.sample_type()) {
                Like::Nothing => {}
                // The frequent one, without a branch for each sample.
                Like::Small(m) => strike_out(stored, out, |s| s.double() == m),
                like => strike_out(stored, out, |s| is_like(s, like)),
            }
        }
        if let Some(valid) = self.marks().valid {
            out.iter_mut().filter(|v| !valid.contains(**v)).for_each(|v| *v = f64::NAN);
        }
    }

    /// Whether a stored value, as a double, is missing by its nearness to a mark alone: none equals it.
    pub(super) fn is_missing_by_nearness(&self, stored: f64) -> bool {
        let values = &self.marks().values;
        let like = |mark: &Mark| likeness(*mark, self.sample_type());
        let equal = |like: Like| match like {
            Like::Single(m) => stored == f64::from(m),
            Like::Double(m) => stored == m,
            _ => true,
        };
        let mut near = values.iter().map(like).filter(|l| is_like(stored, *l)).peekable();
        near.peek().is_some() && !near.any(equal)
    }
}

/// How stored values are compared with a mark.
#[derive(Debug, Clone, Copy)]
enum Like {
    Nothing,
    /// Equality, of integers of up to 32 bits, which doubles hold.
    Small(f64),
    Whole(i128),
    Single(f32),
    Double(f64),
}

fn likeness(mark: Mark, sample_type: SampleType) -> Like {
    match (mark, sample_type) {
        (Mark::I64(mark), _) => Like::Whole(i128::from(mark)),
        (Mark::U64(mark), _) => Like::Whole(i128::from(mark)),
        (Mark::Real(mark), SampleType::F16) => Like::Single(half::f16::from_f64(mark).to_f32()),
        (Mark::Real(mark), SampleType::F32) => Like::Single(mark as f32),
        (Mark::Real(mark), SampleType::F64) => Like::Double(mark),
        (Mark::Real(value), _) if mark.is_reachable(sample_type) => Like::Small(value.trunc()),
        (Mark::Real(_), _) => Like::Nothing,
    }
}

/// Takes the heights away where stored values are missing.
#[inline(always)]
fn strike_out<T: Stored>(stored: &[T], out: &mut [f64], is_missing: impl Fn(T) -> bool) {
    for (height, stored) in out.iter_mut().zip(stored) {
        *height = if is_missing(*stored) { f64::NAN } else { *height };
    }
}

fn is_like<T: Stored>(stored: T, like: Like) -> bool {
    match like {
        Like::Nothing => false,
        Like::Small(m) => stored.double() == m,
        Like::Whole(m) => stored.whole() == m,
        Like::Single(m) => {
            let v = stored.double() as f32;
            v == m || (v - m).abs() < NEARNESS as f32 * (v + m).abs()
        }
        Like::Double(m) => {
            let v = stored.double();
            v == m || (v - m).abs() < NEARNESS * (v + m).abs()
        }
    }
}
#[cfg(test)]
mod tests {
    use gdal::raster::{Buffer, GdalType};
    use gdal::{DriverManager, Metadata};

    use super::*;

    const WINDOW: Window = Window { column: 0, row: 0, width: 3, height: 2 };

    /// Reads samples back, with a mark for those without a height.
    fn read<T: GdalType + Copy>(samples: [T; 6], adorn: impl FnOnce(&mut gdal::Dataset)) -> (Raster, [f64; 6]) {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("raster.tif");
        let driver = DriverManager::get_driver_by_name("GTiff").expect("the driver");
        let mut dataset = driver.create_with_band_type::<T, _>(&path, 3, 2, 1).expect("a raster");
        adorn(&mut dataset);
        let mut buffer = Buffer::new((3, 2), samples.to_vec());
        dataset.rasterband(1).and_then(|mut b| b.write((0, 0), (3, 2), &mut buffer)).expect("written");
        dataset.close().expect("closed");
        let raster = Raster::open(&path, 1).expect("opened");
        let mut out = [0.0; 6];
        raster.read_valid_heights(WINDOW, &mut out).expect("read");
        (raster, out)
    }

    fn valid(heights: [f64; 6]) -> [bool; 6] {
        heights.map(|h| !h.is_nan())
    }

    #[test]
    fn marks_are_compared_with_what_is_stored() {
        let tag = |v: f64| {
            move |d: &mut gdal::Dataset| {
                let mut band = d.rasterband(1).expect("the band");
                band.set_no_data_value(Some(v)).expect("tagged");
                band.set_scale(0.5).expect("scaled");
            }
        };
        let (_, heights) = read([1i16, -9999, 3, 4, 5, -9998], tag(-9999.0));
        assert_eq!((heights[0], heights[5]), (0.5, -4999.0));
        assert_eq!(valid(heights), [true, false, true, true, true, true]);
        // −3.4028234663852886e38 has more digits than a single.
        let (_, heights) = read([f32::MIN, 1.0, f32::NAN, 2.0, 0.1, 0.0], tag(f64::from(f32::MIN) * (1.0 - 1e-12)));
        assert_eq!(valid(heights), [false, true, false, true, true, true]);
        let (_, heights) = read([1u8, 2, 255, 0, 5, 6], tag(-1.0));
        assert_eq!(valid(heights), [true; 6]);
    }

    #[test]
    fn large_whole_numbers_are_told_apart() {
        let mark = (1i64 << 53) + 1;
        let (_, heights) = read([mark - 1, mark, 0, 1, 2, mark + 1], |d| {
            d.rasterband(1).and_then(|mut b| b.set_no_data_value_i64(Some(mark))).expect("tagged");
        });
        assert_eq!(valid(heights), [true, false, true, true, true, true]);
    }

    #[test]
    fn one_mark_for_each_band_together_counts() {
        let (raster, heights) = read([1i16, -9999, 3, 4, 5, -9998], |d| {
            d.set_metadata_item("NODATA_VALUES", "-9999", "").expect("marked");
        });
        assert!(raster.has_mask().expect("told"));
        assert_eq!(valid(heights), [true, false, true, true, true, true]);
    }

    #[test]
    fn another_mark_takes_the_place_of_the_tag_and_the_mask_stays() {
        let (raster, heights) = read([1u8, 2, 3, 2, 1, 0], |d| {
            let mut band = d.rasterband(1).expect("the band");
            band.create_mask_band(false).expect("a mask");
            let mut mask = Buffer::new((3, 2), vec![255u8, 255, 255, 255, 255, 0]);
            band.open_mask_band().and_then(|mut m| m.write((0, 0), (3, 2), &mut mask)).expect("written");
        });
        assert_eq!(valid(heights), [true, true, true, true, true, false]);
        let mut out = [0.0; 6];
        raster.with_nodata(&["2"]).expect("a mark").read_valid_heights(WINDOW, &mut out).expect("read");
        assert_eq!(valid(out), [true, false, true, false, true, false]);
    }
}
