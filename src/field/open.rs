//! Making samples readable: the choice of a way to them, and the field that comes of it.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::FieldError;
use super::channels::Channels;
use super::decode::{Decoded, decode, decoded_bytes};
use super::holes::Holes;
use super::in_place::map_in_place;
use super::partial::Partial;
use super::source::Source;
use super::store::{Bytes, Offsets, Store};
use crate::base::GeoTransform;
use crate::base::Heights;
use crate::base::control::Control;
use crate::base::{Band, Cutline, Mark, Marks, SampleType, Scaling, Watch};

/// The samples of a raster of any size, readable from any number of threads.
pub struct Field {
    pub(super) name: PathBuf,
    pub(super) width: usize,
    pub(super) height: usize,
    /// Samples across and down in the blocks of what it is read from.
    pub(super) block: (usize, usize),
    pub(super) sample_type: SampleType,
    pub(super) scaling: Scaling,
    pub(super) marks: Marks,
    /// The raster's own nodata tag, for messages.
    pub(super) tag: Option<Mark>,
    pub(super) geo_transform: GeoTransform,
    pub(super) source: Source,
    /// A byte for every sample, 0 where it is no height; where a mask or alpha band says so.
    pub(super) mask: Option<Source>,
    /// What is outside of it is no height.
    pub(super) cutline: Option<Arc<Cutline>>,
    pub(super) access: Access,
    pub(super) channels: Option<Channels>,
    /// Weights of errors, a field of the same size.
    pub(super) importance: Option<Box<Field>>,
    /// Holes that are bridged.
    pub(super) holes: Option<Holes>,
    /// What makes sure that the raster is still the same.
    pub(super) watches: Arc<[Box<dyn Watch>]>,
}

/// How a field came to be readable.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case", tag = "how")]
pub enum Access {
    /// The raster's own file is mapped.
    InPlace,
    /// Windows are read through GDAL when they are wanted.
    Windows {
        /// Why it could not be mapped in place.
        reason: String,
    },
    /// Decoded into a temporary file.
    Decoded {
        /// Why it could not be mapped in place, or read by windows.
        reason: String,
        /// The temporary file's size, where a part is decoded at the most.
        bytes: u64,
    },
    /// Given as an array.
    Memory,
}

/// How to make the samples of a raster readable.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Choice {
    /// What suits the raster: its own file mapped where it is plain and [`FieldOptions::maps_files`] allows it; windows through GDAL where it has blocks of a
    /// moderate size each way; decoded beforehand where a window would have to decode much more than itself, or to fetch it from another machine.
    #[default]
    Auto,
    /// Map the raster's own file; an error where that cannot be done.
    InPlace,
    /// Read windows through GDAL.
    Windows,
    /// Decode it into a temporary file.
    Decode,
}

/// How to make samples readable, and where temporary files go.
#[derive(Debug, Clone)]
pub struct FieldOptions {
    /// The folder of the temporary file, where there is one.
    pub temp_dir: PathBuf,
    /// Leave it to [`Choice::Auto`] unless you measure.
    pub choice: Choice,
    /// Whether [`Choice::Auto`] may map the raster's own file, which is faster than reading it. Where another process truncates
    /// a mapped file, the next look at it raises SIGBUS, which ends this process unless it is caught: programs may say yes.
    pub maps_files: bool,
    /// Whether a part of the raster is all that is wanted: then what has to be decoded is decoded when it is loaded for the first
    /// time, a few megabytes around it at once, and not beforehand.
    pub in_parts: bool,
}

impl Default for FieldOptions {
    fn default() -> Self {
        FieldOptions { temp_dir: std::env::temp_dir(), choice: Choice::default(), maps_files: false, in_parts: false }
    }
}

/// The largest block, in samples, that windows are read from without decoding everything beforehand.
const LARGEST_BLOCK: usize = 1 << 20;

/// What [`Choice::Auto`] comes down to for a raster, apart from whether its own file can be mapped.
pub fn suits_windows(band: &Band) -> bool {
    if band.is_remote() {
        // Every tile of every pass would fetch its blocks again.
        return false;
    }
    let (width, height) = band.block_size();
    let square_enough = width <= 4 * height && height <= 4 * width;
    width * height <= LARGEST_BLOCK && (square_enough || band.width() * band.height() <= LARGEST_BLOCK)
}

impl Field {
    /// Makes the samples of `band` readable, see [`Choice`]. Decoding uses the threads of the current rayon pool, and
    /// a few megabytes for each.
    ///
    /// # Errors
    /// [`FieldError`]; nothing is left behind.
    pub fn open(band: &Band, options: &FieldOptions, control: &Control<'_>) -> Result<Field, FieldError> {
        let mapped = match options.choice {
            Choice::Auto if !options.maps_files => Err("files are not mapped, as requested".to_string()),
            Choice::Auto | Choice::InPlace => band.plain_layout().and_then(|layout| map_in_place(band, layout)),
            Choice::Windows | Choice::Decode => Err("as requested".to_string()),
        };
        let windows = |reason| {
            let windows = Arc::new(band.clone());
            let mask = band.has_mask().then(|| Source::Masks(windows.clone()));
            (Source::Windows(windows), mask, Access::Windows { reason })
        };
        let (source, mask, access) = match (mapped, options.choice) {
            (Ok(store), _) => (Source::Blocks(store), None, Access::InPlace),
            (Err(reason), Choice::InPlace) => {
                return Err(FieldError::NotInPlace { path: band.path().to_path_buf(), reason });
            }
            (Err(reason), Choice::Auto) if suits_windows(band) => windows(reason),
            (Err(reason), Choice::Windows) => windows(reason),
            (Err(reason), Choice::Auto | Choice::Decode) => {
                let (folder, bytes) = (options.temp_dir.as_path(), decoded_bytes(band));
                let (samples, mask) = if options.in_parts {
                    let band = Arc::new(band.clone());
                    let part = |is_mask| Partial::new(band.clone(), is_mask, folder).map(Source::Partial);
                    (part(false)?, band.has_mask().then(|| part(true)).transpose()?)
                } else {
                    let Decoded { samples, mask } = decode(band, folder, control)?;
                    (Source::Blocks(samples), mask.map(Source::Blocks))
                };
                (samples, mask, Access::Decoded { reason, bytes })
            }
        };
        Ok(Field {
            name: band.path().to_path_buf(),
            width: band.width(),
            height: band.height(),
            block: band.block_size(),
            sample_type: band.sample_type(),
            scaling: band.scaling(),
            marks: band.marks().clone(),
            tag: band.tag(),
            geo_transform: band.geo_transform(),
            source,
            mask,
            cutline: band.cutline().cloned(),
            access,
            channels: None,
            importance: None,
            holes: None,
            watches: Arc::default(),
        })
    }

    /// The same, with the weights of errors from an importance raster, where there is one, read in the same ways.
    ///
    /// # Errors
    /// [`FieldError`]; [`crate::base::RasterError::OtherGrid`] where `importance` does not lie on the samples of `band`.
    pub fn open_with_importance(
        band: &Band,
        importance: Option<&Band>,
        options: &FieldOptions,
        control: &Control<'_>,
    ) -> Result<Field, FieldError> {
        let Some(importance) = importance else { return Field::open(band, options, control) };
        band.same_grid(importance)?;
        let weights = Field::open(importance, options, control).map_err(FieldError::about_a_weight)?;
        Field::open(band, options, control)?.with_importance(weights)
    }

    /// The same field with weights: errors at a sample count as many times as `weights` says there. A weight of 0 lets
    /// the sample go free; what is no weight is refused when it is loaded.
    ///
    /// # Errors
    /// [`FieldError::OtherSize`].
    ///
    /// # Panics
    /// If the field has channels: their error has no weights.
    pub fn with_importance(self, weights: Field) -> Result<Field, FieldError> {
        assert!(self.channels.is_none(), "weights beside channels");
        let (expected, found) = ((self.width, self.height), (weights.width, weights.height));
        if expected != found {
            return Err(FieldError::OtherSize { path: weights.name, expected, found });
        }
        Ok(Field { importance: Some(Box::new(weights)), ..self })
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
            first: (0, 0),
        };
        Ok(Field {
            name: PathBuf::from("heights in memory"),
            width,
            height,
            block: (width, height),
            sample_type,
            scaling: Scaling::NONE,
            marks: Marks::default(),
            tag: None,
            geo_transform: GeoTransform::DEFAULT,
            source: Source::Blocks(store),
            mask: None,
            cutline: None,
            access: Access::Memory,
            channels: None,
            importance: None,
            holes: None,
            watches: Arc::default(),
        })
    }

    /// The same field, which refuses to load samples once a file has changed: whatever is made of several tiles is made of
    /// one band. `watches` have begun before it was opened.
    pub fn watched(self, watches: Arc<[Box<dyn Watch>]>) -> Field {
        Field { watches, ..self }
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

    /// The field of weights, where it has one.
    pub fn importance(&self) -> Option<&Field> {
        self.importance.as_deref()
    }

    /// The bytes of its temporary files, those of its weights, channels and bridged holes among them.
    pub fn decoded_bytes(&self) -> u64 {
        let bytes = |field: &Field| match field.access {
            Access::Decoded { bytes, .. } => bytes,
            Access::InPlace | Access::Windows { .. } | Access::Memory => 0,
        };
        let holes = self.holes().map_or(0, Holes::bytes);
        self.each().chain(self.importance()).map(bytes).sum::<u64>() + holes
    }

    /// What messages call it: the raster's path.
    pub fn name(&self) -> &Path {
        &self.name
    }
}
