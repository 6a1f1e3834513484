use std::path::{Path, PathBuf};

use super::decode::decode;
use super::map::map;
use super::store::{Bytes, Offsets, Store};
use super::{FieldError, Heights, Tile};
use crate::control::Control;
use crate::exact::MAX_HEIGHT;
use crate::raster::{
    GeoTransform, Nodata, PlainLayout, Raster, SampleType, Scaling, Window, plain_layout, with_sample_type,
};

/// The samples of a raster of any size, readable from any number of threads.
pub struct Field {
    pub(super) name: PathBuf,
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) sample_type: SampleType,
    pub(super) scaling: Scaling,
    pub(super) nodata: Nodata,
    pub(super) geo_transform: GeoTransform,
    pub(super) store: Store,
    pub(super) access: Access,
}

/// How a field came to be readable.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case", tag = "how")]
pub enum Access {
    /// The raster's own file is mapped.
    InPlace,
    /// Decoded into a temporary file.
    Decoded {
        /// Why it could not be mapped in place.
        reason: String,
        /// The temporary file's size.
        bytes: u64,
    },
    /// Given as an array.
    Memory,
}

/// Where and how to decode what cannot be mapped in place.
#[derive(Debug, Clone)]
pub struct FieldOptions {
    /// The folder of the temporary file.
    pub temp_dir: PathBuf,
}

impl Default for FieldOptions {
    fn default() -> Self {
        FieldOptions { temp_dir: std::env::temp_dir() }
    }
}

impl Field {
    /// Makes the samples of `raster` readable: maps them in place where the file allows it, else decodes them into an
    /// unlinked temporary file, on the threads of the current rayon pool. Memory: one window per thread.
    ///
    /// # Errors
    /// [`FieldError`]; nothing is left behind.
    pub fn open(raster: &Raster, options: &FieldOptions, control: &Control<'_>) -> Result<Field, FieldError> {
        let (store, access) = match plain_layout(raster).and_then(|layout| map_in_place(raster, layout)) {
            Ok(store) => (store, Access::InPlace),
            Err(reason) => {
                let (store, bytes) = decode(raster, options, control)?;
                (store, Access::Decoded { reason, bytes })
            }
        };
        Ok(Field {
            name: raster.path().to_path_buf(),
            width: raster.width(),
            height: raster.height(),
            sample_type: raster.sample_type(),
            scaling: raster.scaling(),
            nodata: raster.nodata(),
            geo_transform: raster.geo_transform(),
            store,
            access,
        })
    }

    /// A field over `width` × `height` heights in memory, row by row, with the default geotransform.
    ///
    /// # Errors
    /// [`FieldError::Shape`].
    pub fn from_heights(width: usize, height: usize, heights: Heights) -> Result<Field, FieldError> {
        let (found, sample_type, bytes) = match heights {
            Heights::F32(v) => (v.len(), SampleType::F32, bytemuck::cast_slice(&v).to_vec()),
            Heights::F64(v) => (v.len(), SampleType::F64, bytemuck::cast_slice(&v).to_vec()),
        };
        if width < 2 || height < 2 || width.checked_mul(height) != Some(found) {
            return Err(FieldError::Shape { width, height, found });
        }
        let store = Store {
            bytes: Bytes::Owned(bytes),
            block_width: width,
            block_height: height,
            blocks_across: 1,
            offsets: Offsets::Regular,
            sample_bytes: sample_type.bytes(),
        };
        Ok(Field {
            name: PathBuf::from("heights in memory"),
            width,
            height,
            sample_type,
            scaling: Scaling::NONE,
            nodata: Nodata::None,
            geo_transform: GeoTransform::DEFAULT,
            store,
            access: Access::Memory,
        })
    }

    /// The same field placed elsewhere on the map.
    pub fn with_geo_transform(self, geo_transform: GeoTransform) -> Field {
        Field { geo_transform, ..self }
    }

    /// Samples across.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Samples down.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Where the samples lie on the map.
    pub fn geo_transform(&self) -> GeoTransform {
        self.geo_transform
    }

    /// How the samples are reached.
    pub fn access(&self) -> &Access {
        &self.access
    }

    /// What messages call it: the raster's path.
    pub fn name(&self) -> &Path {
        &self.name
    }

    /// Copies a window into `tile` as heights, reusing its memory.
    ///
    /// # Errors
    /// [`FieldError::Nodata`], [`FieldError::NotAHeight`], [`FieldError::Inexact`], each naming the first such sample of
    /// the window.
    ///
    /// # Panics
    /// If the window is not inside the field.
    pub fn load(&self, window: Window, tile: &mut Tile) -> Result<(), FieldError> {
        let inside = window.column + window.width <= self.width && window.row + window.height <= self.height;
        assert!(inside, "{window:?} of a field of {} × {}", self.width, self.height);
        tile.width = window.width;
        tile.height = window.height;
        if self.sample_type.fits_f32() && self.scaling.is_none() {
            let mut heights = match std::mem::take(&mut tile.heights) {
                Heights::F32(v) => v,
                Heights::F64(_) => Vec::new(),
            };
            heights.resize(window.len(), 0.0);
            let copied = with_sample_type!(self.sample_type, T => self.copy::<T, f32>(window, &mut heights));
            tile.heights = Heights::F32(heights);
            copied
        } else {
            let mut heights = match std::mem::take(&mut tile.heights) {
                Heights::F64(v) => v,
                Heights::F32(_) => Vec::new(),
            };
            heights.resize(window.len(), 0.0);
            let copied = with_sample_type!(self.sample_type, T => self.copy::<T, f64>(window, &mut heights));
            tile.heights = Heights::F64(heights);
            copied
        }
    }

    fn copy<T: Stored, H: Height>(&self, window: Window, out: &mut [H]) -> Result<(), FieldError> {
        let nodata = T::nodata(self.nodata);
        let scaling = (!self.scaling.is_none()).then_some(self.scaling);
        self.store.for_each_run(window, |row, column, bytes| {
            let start = row * window.width + column;
            let run = &mut out[start..start + bytes.len() / size_of::<T>()];
            let mut suspicious = false;
            for (height, stored) in run.iter_mut().zip(bytes.chunks_exact(size_of::<T>())) {
                let stored: T = bytemuck::pod_read_unaligned(stored);
                *height = H::of(stored, scaling);
                suspicious |= !height.usable() | nodata.is_some_and(|n| stored == n) | !stored.exact();
            }
            if !suspicious {
                return Ok(());
            }
            let bad = bytes.chunks_exact(size_of::<T>()).enumerate().find_map(|(i, stored)| {
                let stored: T = bytemuck::pod_read_unaligned(stored);
                self.refusal(stored, nodata, window.column + column + i, window.row + row)
            });
            bad.map_or(Ok(()), Err)
        })
    }

    /// Why the value stored at this place is no height, if it is none.
    fn refusal<T: Stored>(&self, stored: T, nodata: Option<T>, column: usize, row: usize) -> Option<FieldError> {
        let path = self.name.clone();
        let value = stored.to_f64();
        let height = self.scaling.height(value);
        if value.is_nan() || nodata == Some(stored) {
            return Some(FieldError::Nodata { path, column, row, found: value.to_string() });
        }
        if !stored.exact() {
            return Some(FieldError::Inexact { path, column, row, found: stored.to_i128() });
        }
        (!height.usable()).then_some(FieldError::NotAHeight { path, column, row, found: height })
    }
}

/// Maps the raster's own file, and makes sure through GDAL that the samples are where the layout says.
fn map_in_place(raster: &Raster, layout: PlainLayout) -> Result<Store, String> {
    let file = std::fs::File::open(&layout.file).map_err(|e| e.to_string())?;
    let mapped = map(&file).map_err(|e| format!("it cannot be mapped: {e}"))?;
    let sample_bytes = raster.sample_type().bytes();
    let tiled = layout.block_width != raster.width();
    for (index, &offset) in layout.offsets.iter().enumerate() {
        let left = raster.height() - (index / layout.blocks_across) * layout.block_height;
        let rows = if tiled { layout.block_height } else { layout.block_height.min(left) };
        let end = offset.checked_add((layout.block_width * rows * sample_bytes) as u64);
        if end.is_none_or(|end| end > mapped.len() as u64) {
            return Err(format!("its block {index} reaches beyond the end of the file: it is truncated"));
        }
    }
    let store = Store {
        bytes: Bytes::Mapped(mapped),
        block_width: layout.block_width,
        block_height: layout.block_height,
        blocks_across: layout.blocks_across,
        offsets: Offsets::Table(layout.offsets),
        sample_bytes,
    };
    agrees_with_gdal(raster, &store)?;
    Ok(store)
}

/// Compares the first and the last row of samples with what GDAL reads.
fn agrees_with_gdal(raster: &Raster, store: &Store) -> Result<(), String> {
    let sample_bytes = store.sample_bytes;
    let width = raster.width().min(4096);
    for (column, row) in [(0, 0), (raster.width() - width, raster.height() - 1)] {
        let window = Window { column, row, width, height: 1 };
        let mut words = vec![0u64; (width * sample_bytes).div_ceil(8)];
        let expected = &mut bytemuck::cast_slice_mut(&mut words)[..width * sample_bytes];
        raster.read_native(window, expected).map_err(|e| e.to_string())?;
        store.for_each_run(window, |_, column, bytes| {
            let at = column * sample_bytes;
            let same = expected[at..at + bytes.len()] == *bytes;
            if same { Ok(()) } else { Err(format!("its samples in row {row} are not stored as they are")) }
        })?;
    }
    Ok(())
}

/// What a stored type must tell to become a height.
trait Stored: bytemuck::Pod + PartialEq {
    fn to_f64(self) -> f64;
    fn to_i128(self) -> i128;
    /// Whether a double holds it exactly.
    fn exact(self) -> bool;
    /// The nodata value in this type, if it has one there.
    fn nodata(nodata: Nodata) -> Option<Self>;
}

macro_rules! stored {
    ($($t:ty: $exact:expr, $nodata:expr);* $(;)?) => {$(
        impl Stored for $t {
            #[inline(always)]
            fn to_f64(self) -> f64 {
                self as f64
            }
            fn to_i128(self) -> i128 {
                self as i128
            }
            #[inline(always)]
            fn exact(self) -> bool {
                const EXACT: fn($t) -> bool = $exact;
                EXACT(self)
            }
            fn nodata(nodata: Nodata) -> Option<Self> {
                const NODATA: fn(f64) -> Option<$t> = $nodata;
                match nodata {
                    Nodata::None => None,
                    Nodata::Real(v) => NODATA(v),
                    Nodata::I64(v) => Some(v as $t).filter(|n| *n as i128 == i128::from(v)),
                    Nodata::U64(v) => Some(v as $t).filter(|n| *n as i128 == i128::from(v)),
                }
            }
        }
    )*};
}
// A nodata tag beyond an integer type's range, or between its values, marks no sample; to a float type it is rounded.
stored!(
    u8: |_| true, |v| Some(v as u8).filter(|n| f64::from(*n) == v);
    i8: |_| true, |v| Some(v as i8).filter(|n| f64::from(*n) == v);
    u16: |_| true, |v| Some(v as u16).filter(|n| f64::from(*n) == v);
    i16: |_| true, |v| Some(v as i16).filter(|n| f64::from(*n) == v);
    u32: |_| true, |v| Some(v as u32).filter(|n| f64::from(*n) == v);
    i32: |_| true, |v| Some(v as i32).filter(|n| f64::from(*n) == v);
    u64: |v| v <= 1 << 53, |v| Some(v as u64).filter(|n| *n as f64 == v);
    i64: |v| v.unsigned_abs() <= 1 << 53, |v| Some(v as i64).filter(|n| *n as f64 == v);
    f32: |_| true, |v| Some(v as f32);
    f64: |_| true, Some;
);

/// The type heights are kept in.
trait Height: Copy {
    fn of<T: Stored>(stored: T, scaling: Option<Scaling>) -> Self;
    fn usable(self) -> bool;
}
impl Height for f32 {
    #[inline(always)]
    fn of<T: Stored>(stored: T, _: Option<Scaling>) -> f32 {
        stored.to_f64() as f32
    }
    #[inline(always)]
    fn usable(self) -> bool {
        self.abs() <= MAX_HEIGHT as f32
    }
}
impl Height for f64 {
    #[inline(always)]
    fn of<T: Stored>(stored: T, scaling: Option<Scaling>) -> f64 {
        scaling.map_or(stored.to_f64(), |s| s.height(stored.to_f64()))
    }
    #[inline(always)]
    fn usable(self) -> bool {
        self.abs() <= MAX_HEIGHT
    }
}
