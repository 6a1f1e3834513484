//! Which samples have a height, for `verify` and `preview`.
//!
//! A sample has none if its stored value is NaN or like a mark ([`Mark`]), if its height is outside of the valid range, if a
//! mask or alpha band says so, or if it is outside of the cutline. `base/sample/stored` says the same for the engines, in
//! code of its own.

use crate::base::{Band, Mark, NEARNESS, RasterError, SampleType, Window, with_sample_type};

/// Reads the heights of windows of a band.
///
/// Memory: the stored samples of the largest window read so far, a byte for each where there is a mask, another where there
/// is a cutline.
#[derive(Debug)]
pub struct HeightReader<'b> {
    band: &'b Band,
    words: Vec<u64>,
    mask: Vec<u8>,
    inside: Vec<bool>,
}

impl<'b> HeightReader<'b> {
    /// A reader of a band.
    pub fn new(band: &'b Band) -> HeightReader<'b> {
        HeightReader { band, words: Vec::new(), mask: Vec::new(), inside: Vec::new() }
    }

    /// The band.
    pub fn band(&self) -> &'b Band {
        self.band
    }

    /// Reads a window as heights, scale and offset applied, rows one after the other; NaN where a sample has no height.
    ///
    /// # Errors
    /// [`RasterError::Read`], most often.
    ///
    /// # Panics
    /// If `out` is not `window.len()` long, or the window is not inside the band.
    pub fn read(&mut self, window: Window, out: &mut [f64]) -> Result<(), RasterError> {
        let Some(cutline) = self.band.cutline() else { return self.read_marked(window, out) };
        cutline.mask(window, &mut self.inside);
        if !self.inside.contains(&true) {
            out.fill(f64::NAN);
            return Ok(());
        }
        self.read_marked(window, out)?;
        out.iter_mut().zip(&self.inside).filter(|(_, inside)| !**inside).for_each(|(v, _)| *v = f64::NAN);
        Ok(())
    }

    /// The same, whatever the cutline says.
    ///
    /// # Errors
    /// As [`HeightReader::read`].
    ///
    /// # Panics
    /// As [`HeightReader::read`].
    pub fn read_marked(&mut self, window: Window, out: &mut [f64]) -> Result<(), RasterError> {
        assert_eq!(out.len(), window.len(), "heights of {window:?}");
        let band = self.band;
        let stored = self.read_native(window)?;
        with_sample_type!(band.sample_type(), T => heights_of(band, bytemuck::cast_slice::<u8, T>(stored), out));
        if band.has_mask() {
            self.mask.resize(window.len(), 0);
            band.read_mask(window, &mut self.mask)?;
            out.iter_mut().zip(&self.mask).filter(|(_, m)| **m == 0).for_each(|(v, _)| *v = f64::NAN);
        }
        Ok(())
    }

    /// Reads a window of stored values as doubles: exactly, but for 64-bit integers beyond 2⁵³.
    ///
    /// # Errors
    /// As [`HeightReader::read`].
    ///
    /// # Panics
    /// As [`HeightReader::read`].
    pub fn read_stored(&mut self, window: Window, out: &mut [f64]) -> Result<(), RasterError> {
        assert_eq!(out.len(), window.len(), "values of {window:?}");
        let sample_type = self.band.sample_type();
        let stored = self.read_native(window)?;
        with_sample_type!(sample_type, T => doubles(bytemuck::cast_slice::<u8, T>(stored), out));
        Ok(())
    }

    fn read_native(&mut self, window: Window) -> Result<&[u8], RasterError> {
        let bytes = window.len() * self.band.sample_type().bytes();
        self.words.resize(bytes.div_ceil(8), 0);
        let stored = &mut bytemuck::cast_slice_mut(&mut self.words)[..bytes];
        self.band.read(window, stored)?;
        Ok(stored)
    }

    /// Whether a stored value, as a double, is missing by its nearness to a mark alone: none equals it.
    pub fn is_missing_by_nearness(&self, stored: f64) -> bool {
        let values = &self.band.marks().values;
        let like = |mark: &Mark| likeness(*mark, self.band.sample_type());
        let equal = |like: Like| match like {
            Like::Single(m) => stored == f64::from(m),
            Like::Double(m) => stored == m,
            _ => true,
        };
        let mut near = values.iter().map(like).filter(|l| is_like(stored, *l)).peekable();
        near.peek().is_some() && !near.any(equal)
    }
}

fn doubles<T: Number>(stored: &[T], out: &mut [f64]) {
    out.iter_mut().zip(stored).for_each(|(double, stored)| *double = stored.double());
}

fn heights_of<T: Number>(band: &Band, stored: &[T], out: &mut [f64]) {
    doubles(stored, out);
    let scaling = band.scaling();
    if !scaling.is_none() {
        out.iter_mut().for_each(|v| *v = scaling.height(*v));
    }
    for mark in &band.marks().values {
        match likeness(*mark, band.sample_type()) {
            Like::Nothing => {}
            // The frequent one, without a branch for each sample.
            Like::Small(m) => strike_out(stored, out, |s| s.double() == m),
            like => strike_out(stored, out, |s| is_like(s, like)),
        }
    }
    if let Some(valid) = band.marks().valid {
        out.iter_mut().filter(|v| !valid.contains(**v)).for_each(|v| *v = f64::NAN);
    }
}

/// A stored sample as a number.
trait Number: Copy {
    /// The number, rounded where no double equals it.
    fn double(self) -> f64;

    /// The whole number, of integers.
    fn whole(self) -> i128;
}
macro_rules! numbers {
    ($($t:ty),*) => {$(
        impl Number for $t {
            fn double(self) -> f64 {
                self as f64
            }
            fn whole(self) -> i128 {
                self as i128
            }
        }
    )*};
}
numbers!(u8, i8, u16, i16, u32, i32, u64, i64, f32, f64);
impl Number for half::f16 {
    fn double(self) -> f64 {
        f64::from(self)
    }
    fn whole(self) -> i128 {
        f64::from(self) as i128
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
fn strike_out<T: Number>(stored: &[T], out: &mut [f64], is_missing: impl Fn(T) -> bool) {
    for (height, stored) in out.iter_mut().zip(stored) {
        *height = if is_missing(*stored) { f64::NAN } else { *height };
    }
}

fn is_like<T: Number>(stored: T, like: Like) -> bool {
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
    use crate::raster::Raster;

    const WINDOW: Window = Window { column: 0, row: 0, width: 3, height: 2 };

    /// Reads samples back, with a mark for those without a height.
    fn read<T: GdalType + Copy>(
        samples: [T; 6],
        adorn: impl FnOnce(&mut gdal::Dataset),
    ) -> (tempfile::TempDir, Raster, [f64; 6]) {
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
        HeightReader::new(&raster.to_band().expect("told")).read(WINDOW, &mut out).expect("read");
        (folder, raster, out)
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
        let (_, _, heights) = read([1i16, -9999, 3, 4, 5, -9998], tag(-9999.0));
        assert_eq!((heights[0], heights[5]), (0.5, -4999.0));
        assert_eq!(valid(heights), [true, false, true, true, true, true]);
        // −3.4028234663852886e38 has more digits than a single.
        let (_, _, heights) = read([f32::MIN, 1.0, f32::NAN, 2.0, 0.1, 0.0], tag(f64::from(f32::MIN) * (1.0 - 1e-12)));
        assert_eq!(valid(heights), [false, true, false, true, true, true]);
        let (_, _, heights) = read([1u8, 2, 255, 0, 5, 6], tag(-1.0));
        assert_eq!(valid(heights), [true; 6]);
    }

    #[test]
    fn large_whole_numbers_are_told_apart() {
        let mark = (1i64 << 53) + 1;
        let (_, _, heights) = read([mark - 1, mark, 0, 1, 2, mark + 1], |d| {
            d.rasterband(1).and_then(|mut b| b.set_no_data_value_i64(Some(mark))).expect("tagged");
        });
        assert_eq!(valid(heights), [true, false, true, true, true, true]);
    }

    #[test]
    fn one_mark_for_each_band_together_counts() {
        let (_folder, raster, heights) = read([1i16, -9999, 3, 4, 5, -9998], |d| {
            d.set_metadata_item("NODATA_VALUES", "-9999", "").expect("marked");
        });
        assert!(raster.has_mask().expect("told"));
        assert_eq!(valid(heights), [true, false, true, true, true, true]);
    }

    #[test]
    fn another_mark_takes_the_place_of_the_tag_and_the_mask_stays() {
        let (_folder, raster, heights) = read([1u8, 2, 3, 2, 1, 0], |d| {
            let mut band = d.rasterband(1).expect("the band");
            band.create_mask_band(false).expect("a mask");
            let mut mask = Buffer::new((3, 2), vec![255u8, 255, 255, 255, 255, 0]);
            band.open_mask_band().and_then(|mut m| m.write((0, 0), (3, 2), &mut mask)).expect("written");
        });
        assert_eq!(valid(heights), [true, true, true, true, true, false]);
        let mut out = [0.0; 6];
        let band = raster.with_nodata(&["2".to_string()]).and_then(|r| r.to_band()).expect("a mark");
        HeightReader::new(&band).read(WINDOW, &mut out).expect("read");
        assert_eq!(valid(out), [true, false, true, false, true, false]);
    }
}
