//! Which samples have a height.
//!
//! A sample has one unless its stored value is the mark of nodata or NaN, a mask or alpha band says that it has none, or it
//! is outside of the cutline.

use super::{Nodata, Raster, RasterError, SampleType, Window};

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
        self.read_stored(window, out)?;
        match self.nodata() {
            Nodata::None => {}
            Nodata::Real(mark) => {
                // To single precision a mark is rounded: it is written with more digits than the samples have.
                let mark = if self.sample_type() == SampleType::F32 { f64::from(mark as f32) } else { mark };
                out.iter_mut().filter(|v| **v == mark).for_each(|v| *v = f64::NAN);
            }
            Nodata::I64(mark) => self.strike_out(window, out, mark)?,
            Nodata::U64(mark) => self.strike_out(window, out, mark)?,
        }
        self.scale(out);
        if self.has_mask()? {
            let mut mask = vec![0; window.len()];
            self.read_mask(window, &mut mask)?;
            out.iter_mut().zip(mask).filter(|(_, m)| *m == 0).for_each(|(v, _)| *v = f64::NAN);
        }
        // Empty where there is no cutline.
        out.iter_mut().zip(inside).filter(|(_, inside)| !inside).for_each(|(v, _)| *v = f64::NAN);
        Ok(())
    }

    /// Doubles do not tell large whole numbers apart, so these are read once more as they are.
    fn strike_out<T>(&self, window: Window, out: &mut [f64], mark: T) -> Result<(), RasterError>
    where
        T: bytemuck::Pod + Default + PartialEq,
    {
        let mut stored = vec![T::default(); window.len()];
        self.read_native(window, bytemuck::cast_slice_mut(&mut stored))?;
        out.iter_mut().zip(stored).filter(|(_, v)| *v == mark).for_each(|(h, _)| *h = f64::NAN);
        Ok(())
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
        raster.with_nodata("2").expect("a mark").read_valid_heights(WINDOW, &mut out).expect("read");
        assert_eq!(valid(out), [true, false, true, false, true, false]);
    }
}
