//! Stored values that Python holds, read window by window: an array of numpy, or an object that reads a raster.
//!
//! Threads of a run attach themselves to the interpreter for as long as a window is copied, so that nobody writes to the array
//! meanwhile. Nothing of an array is kept beyond that.

use std::path::{Path, PathBuf};

use bytemuck::NoUninit;
use numpy::{Element, PyArray2, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::prelude::*;
use terrabite::base::{Encoding, Masks, RasterError, SampleType, Window, Windows, mask_by_alpha};

/// Runs `$body` with `$t` as the Rust type of the samples, or gives `None` for a type that arrays of numpy do not have here.
macro_rules! with_element {
    ($sample_type:expr, $t:ident => $body:expr) => {
        match $sample_type {
            SampleType::U8 => with_element!(@ u8, $t, $body),
            SampleType::I8 => with_element!(@ i8, $t, $body),
            SampleType::U16 => with_element!(@ u16, $t, $body),
            SampleType::I16 => with_element!(@ i16, $t, $body),
            SampleType::U32 => with_element!(@ u32, $t, $body),
            SampleType::I32 => with_element!(@ i32, $t, $body),
            SampleType::U64 => with_element!(@ u64, $t, $body),
            SampleType::I64 => with_element!(@ i64, $t, $body),
            SampleType::F32 => with_element!(@ f32, $t, $body),
            SampleType::F64 => with_element!(@ f64, $t, $body),
            SampleType::F16 => None,
        }
    };
    (@ $concrete:ty, $t:ident, $body:expr) => {{
        type $t = $concrete;
        Some($body)
    }};
}
pub(crate) use with_element;

/// The type of samples that numpy calls so.
pub(crate) fn sample_type(dtype: &str) -> Option<SampleType> {
    Some(match dtype {
        "uint8" => SampleType::U8,
        "int8" => SampleType::I8,
        "uint16" => SampleType::U16,
        "int16" => SampleType::I16,
        "uint32" => SampleType::U32,
        "int32" => SampleType::I32,
        "uint64" => SampleType::U64,
        "int64" => SampleType::I64,
        "float32" => SampleType::F32,
        "float64" => SampleType::F64,
        _ => return None,
    })
}

/// Copies a window of an array in rows, all of whose samples lie one after the other.
fn copy<T: Element + NoUninit>(array: &Bound<'_, PyArray2<T>>, window: Window, out: &mut [u8]) -> Result<(), String> {
    let shape = array.shape();
    let inside = shape[0] >= window.row + window.height && shape[1] >= window.column + window.width;
    if !inside || !array.is_c_contiguous() {
        return Err("the array has another shape than it had".to_string());
    }
    let width = shape[1];
    let samples = array.try_readonly().map_err(|e| e.to_string())?;
    let samples = samples.as_slice().map_err(|e| e.to_string())?;
    let row_bytes = window.width * size_of::<T>();
    for (row, out) in (window.row..).zip(out.chunks_exact_mut(row_bytes)) {
        let first = row * width + window.column;
        out.copy_from_slice(bytemuck::cast_slice(&samples[first..first + window.width]));
    }
    Ok(())
}

/// Does something with the interpreter; what fails is told as a window that could not be read.
fn attached(
    name: &Path,
    window: Window,
    read: impl for<'py> FnOnce(Python<'py>) -> Result<(), String>,
) -> Result<(), RasterError> {
    let found = Python::try_attach(read).unwrap_or_else(|| Err("the interpreter has ended".to_string()));
    found.map_err(|reason| {
        let Window { column, row, width, height } = window;
        RasterError::Read { path: name.to_path_buf(), column, row, width, height, reason }
    })
}

/// A two-dimensional array and the mask that may come with it, true where nothing is there.
pub(crate) struct ArrayWindows<T> {
    pub(crate) name: PathBuf,
    pub(crate) array: Py<PyArray2<T>>,
    pub(crate) mask: Option<Py<PyArray2<bool>>>,
}

impl<T: Element + NoUninit> Windows for ArrayWindows<T> {
    fn read(&self, window: Window, out: &mut [u8]) -> Result<(), RasterError> {
        attached(&self.name, window, |py| copy(self.array.bind(py), window, out))
    }

    fn read_mask(&self, window: Window, out: &mut [u8]) -> Result<(), RasterError> {
        let Some(mask) = &self.mask else {
            out.fill(255);
            return Ok(());
        };
        attached(&self.name, window, |py| {
            copy(mask.bind(py), window, out)?;
            out.iter_mut().for_each(|missing| *missing = if *missing == 0 { 255 } else { 0 });
            Ok(())
        })
    }
}

/// An object that opens a raster: `read(band, column, row, width, height)` gives stored values, `read_mask(column, row, width,
/// height)` a mask, `release()` closes what it holds.
pub(crate) struct ReaderWindows {
    pub(crate) name: PathBuf,
    pub(crate) reader: Py<PyAny>,
    pub(crate) number: usize,
    pub(crate) sample_type: SampleType,
    /// How heights are stored as colours, and the bands that have red, green and blue.
    pub(crate) encoded: Option<(Encoding, [usize; 3])>,
    pub(crate) masks: Masks,
    /// The type of the alpha band, where there is one that counts.
    pub(crate) alpha_type: SampleType,
}

impl ReaderWindows {
    /// Calls a method of the reader for a window, and copies what it gives.
    fn call(
        &self,
        py: Python<'_>,
        (method, band): (&str, Option<usize>),
        sample_type: SampleType,
        window: Window,
        out: &mut [u8],
    ) -> Result<(), String> {
        let Window { column, row, width, height } = window;
        let reader = self.reader.bind(py);
        let array = match band {
            Some(band) => reader.call_method1(method, (band, column, row, width, height)),
            None => reader.call_method1(method, (column, row, width, height)),
        };
        let array = array.map_err(|e| e.to_string())?;
        let whole = Window { column: 0, row: 0, width, height };
        let copied = with_element!(sample_type, T => {
            let array = array.cast::<PyArray2<T>>().map_err(|e| e.to_string())?;
            copy(array, whole, out)
        });
        copied.unwrap_or_else(|| Err("half floats are not read by windows".to_string()))
    }
}

impl Windows for ReaderWindows {
    fn read(&self, window: Window, out: &mut [u8]) -> Result<(), RasterError> {
        let Some((encoding, bands)) = self.encoded else {
            let band = ("read", Some(self.number));
            return attached(&self.name, window, |py| self.call(py, band, self.sample_type, window, out));
        };
        let mut colours = [const { Vec::new() }; 3];
        for (values, band) in colours.iter_mut().zip(bands) {
            values.resize(window.len(), 0u8);
            attached(&self.name, window, |py| self.call(py, ("read", Some(band)), SampleType::U8, window, values))?;
        }
        let [red, green, blue] = &colours;
        for (i, height) in bytemuck::cast_slice_mut::<u8, f64>(out).iter_mut().enumerate() {
            *height = encoding.height([red[i], green[i], blue[i]]);
        }
        Ok(())
    }

    fn read_mask(&self, window: Window, out: &mut [u8]) -> Result<(), RasterError> {
        if self.masks.file {
            attached(&self.name, window, |py| self.call(py, ("read_mask", None), SampleType::U8, window, out))?;
        } else {
            out.fill(255);
        }
        let Some(alpha) = self.masks.alpha else { return Ok(()) };
        let bytes = window.len() * self.alpha_type.bytes();
        let mut words = vec![0u64; bytes.div_ceil(8)];
        let stored = &mut bytemuck::cast_slice_mut(&mut words)[..bytes];
        attached(&self.name, window, |py| self.call(py, ("read", Some(alpha)), self.alpha_type, window, stored))?;
        mask_by_alpha(self.alpha_type, stored, out);
        Ok(())
    }

    fn release(&self) {
        // What cannot be closed is closed when the object goes.
        let _ = Python::try_attach(|py| self.reader.bind(py).call_method0("release").is_ok());
    }
}
