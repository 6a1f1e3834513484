//! A band: what is known of samples that are not in memory, and the one way to them.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::warning::Warning;
use super::{
    Cutline, Encoding, GeoTransform, Mark, Marks, Metres, RasterError, Reference, SampleType, Scaling, Window,
    metres_in,
};

/// Reads stored values, wherever they are: GDAL does it for rasters, other programs for what they hold.
///
/// Called from several threads at once. The same window has the same values whenever it is read, until a run ends.
///
/// ```
/// use terrabite::base::{Band, RasterError, SampleType, Window, Windows};
///
/// /// A slope, made when it is asked for.
/// struct Slope;
///
/// impl Windows for Slope {
///     fn read(&self, window: Window, out: &mut [u8]) -> Result<(), RasterError> {
///         let samples = out.chunks_exact_mut(4);
///         for (i, sample) in samples.enumerate() {
///             let (column, row) = (window.column + i % window.width, window.row + i / window.width);
///             sample.copy_from_slice(&((2 * column + row) as f32).to_ne_bytes());
///         }
///         Ok(())
///     }
/// }
///
/// let band = Band::new("slope", (4000, 3000), SampleType::F32, std::sync::Arc::new(Slope))?;
/// let mut samples = [0; 8];
/// band.read(Window { column: 5, row: 1, width: 2, height: 1 }, &mut samples)?;
/// assert_eq!(samples[..4], 11f32.to_ne_bytes());
/// # Ok::<(), RasterError>(())
/// ```
pub trait Windows: Send + Sync {
    /// Reads a window as it is stored, in the machine's byte order, row by row from the first column on. `out` has as many
    /// bytes as the window has samples of [`Band::sample_type`], and is aligned to 8 bytes. The window is inside the band.
    ///
    /// # Errors
    /// [`RasterError::Read`], most often.
    fn read(&self, window: Window, out: &mut [u8]) -> Result<(), RasterError>;

    /// Reads what a mask says of a window, a byte for every sample, 0 where none is there. Asked only where
    /// [`Band::has_mask`] says that there is one.
    ///
    /// # Errors
    /// [`RasterError::Read`], most often.
    fn read_mask(&self, window: Window, out: &mut [u8]) -> Result<(), RasterError> {
        let _ = window;
        out.fill(255);
        Ok(())
    }

    /// Where the samples lie in a file that can be mapped.
    ///
    /// # Errors
    /// Why there is none, as the end of the sentence "is not mapped: …".
    fn plain_layout(&self) -> Result<PlainLayout, String> {
        Err("its samples come from a program".to_string())
    }

    /// Gives up what is held for further reading, such as open files. Reading goes on as before, after the cost of opening.
    fn release(&self) {}
}

/// Where the blocks of an uncompressed GeoTIFF lie, so that its samples can be used in place.
///
/// Blocks hold rows of samples in the machine's byte order and nothing else; a block may begin at any byte. Tiles at
/// the right and lower rim are padded to the full block, the last strip is not. Blocks are those of the whole raster, also
/// where a band is only a window of it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PlainLayout {
    /// The file that holds the blocks.
    pub file: PathBuf,
    /// Samples across and down the whole raster.
    pub whole: (usize, usize),
    /// Column and row of the band's first sample in it.
    pub first: (usize, usize),
    /// Samples across one block.
    pub block_width: usize,
    /// Samples down one block.
    pub block_height: usize,
    /// Blocks across.
    pub blocks_across: usize,
    /// Byte offsets of the blocks in the file, row by row.
    pub offsets: Vec<u64>,
}

/// One band of a raster, or a window of it: size, type, marks and place, and the way to its stored values.
///
/// A clone shares the way to the samples. Memory: some hundred bytes, and what the way to the samples holds.
#[derive(Clone)]
pub struct Band {
    pub(crate) path: PathBuf,
    pub(crate) size: (usize, usize),
    pub(crate) number: usize,
    /// How many bands its raster has.
    pub(crate) bands: usize,
    pub(crate) block: (usize, usize),
    pub(crate) sample_type: SampleType,
    pub(crate) scaling: Scaling,
    pub(crate) marks: Marks,
    /// Whether somebody has said them, and not only the raster.
    pub(crate) marks_are_said: bool,
    /// The words by which nodata values were said, if they were.
    pub(crate) nodata_words: Vec<String>,
    pub(crate) tag: Option<Mark>,
    /// Where a nodata tag of 0 counts that nobody named: where such tags come from, as the end of a sentence.
    pub(crate) zero_tag: Option<&'static str>,
    pub(crate) has_mask: bool,
    pub(crate) cutline: Option<Arc<Cutline>>,
    pub(crate) geo_transform: Option<GeoTransform>,
    /// Where the window begins, for the default geotransform.
    pub(crate) first: (usize, usize),
    pub(crate) reference: Reference,
    pub(crate) crs: Option<String>,
    pub(crate) description: String,
    /// The description, or else the colour.
    pub(crate) title: String,
    /// How its heights are stored as colours, if they are.
    pub(crate) encoding: Option<Encoding>,
    /// Which part of its raster it is, if not all.
    pub(crate) window: Option<Window>,
    /// The CRS in Esri's dialect of WKT.
    pub(crate) esri_wkt: Option<String>,
    /// What a user should know of it, as far as opening it tells.
    pub(crate) warnings: Vec<Warning>,
    pub(crate) colour: Option<&'static str>,
    /// Whether reading a sample again costs as much as the first time, as on another machine.
    pub(crate) is_remote: bool,
    /// What else tells this view of the samples from others.
    pub(crate) view: Vec<(&'static str, String)>,
    pub(crate) windows: Arc<dyn Windows>,
}

impl std::fmt::Debug for Band {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "band {} of {}, {} × {}", self.number, self.path.display(), self.size.0, self.size.1)
    }
}

impl Band {
    /// A band of `width` × `height` samples of this type, read by `windows`. `name` is what messages call it. It has no
    /// scale, marks, mask, cutline or place on the map, and blocks of 256 × 256 samples, until it is said otherwise.
    ///
    /// # Errors
    /// [`RasterError::TooSmall`] below 2 × 2 samples.
    pub fn new(
        name: impl Into<PathBuf>,
        (width, height): (usize, usize),
        sample_type: SampleType,
        windows: Arc<dyn Windows>,
    ) -> Result<Band, RasterError> {
        let path = name.into();
        if width < 2 || height < 2 {
            return Err(RasterError::TooSmall { path, width, height });
        }
        Ok(Band {
            path,
            size: (width, height),
            number: 1,
            bands: 1,
            block: (width.min(256), height.min(256)),
            sample_type,
            scaling: Scaling::NONE,
            marks: Marks::default(),
            marks_are_said: false,
            nodata_words: Vec::new(),
            tag: None,
            zero_tag: None,
            has_mask: false,
            cutline: None,
            geo_transform: None,
            first: (0, 0),
            reference: Reference::none(),
            crs: None,
            description: String::new(),
            title: String::new(),
            encoding: None,
            window: None,
            esri_wkt: None,
            warnings: Vec::new(),
            colour: None,
            is_remote: false,
            view: Vec::new(),
            windows,
        })
    }

    /// The same with this scale and offset.
    pub fn with_scaling(self, scaling: Scaling) -> Band {
        Band { scaling, ..self }
    }

    /// The same with these marks of missing samples.
    pub fn with_marks(self, marks: Marks) -> Band {
        Band { marks, marks_are_said: true, ..self }
    }

    /// The same with a mask, see [`Windows::read_mask`].
    pub fn with_mask(self) -> Band {
        Band { has_mask: true, ..self }
    }

    /// The same placed on the map.
    pub fn with_geo_transform(self, geo_transform: GeoTransform) -> Band {
        let reference = Reference { georeferenced: true, ..self.reference };
        Band { geo_transform: Some(geo_transform), reference, ..self }
    }

    /// The same with coordinates of this meaning; `crs` is a code of an authority, such as `EPSG:32632`, or WKT.
    pub fn with_reference(self, reference: Reference, crs: Option<String>) -> Band {
        Band { reference, crs, ..self }
    }

    /// The same, best read in blocks of this size: samples across and down. Neither is 0.
    ///
    /// # Panics
    /// If one is.
    pub fn with_blocks(self, across: usize, down: usize) -> Band {
        assert!(across > 0 && down > 0, "blocks of {across} × {down} samples");
        Band { block: (across, down), ..self }
    }

    /// The same, on another machine: it is read once, into a temporary file, if nobody chooses otherwise.
    pub fn remote(self) -> Band {
        Band { is_remote: true, ..self }
    }

    /// The same, in which samples outside of the cutline have no height.
    pub fn with_cutline(self, cutline: Cutline) -> Band {
        Band { cutline: Some(Arc::new(cutline)), ..self }
    }

    /// What messages call it: the path of its raster.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Which band of its raster it is, from 1.
    pub fn number(&self) -> usize {
        self.number
    }

    /// Samples across (columns).
    pub fn width(&self) -> usize {
        self.size.0
    }

    /// Samples down (rows).
    pub fn height(&self) -> usize {
        self.size.1
    }

    /// All samples of it.
    pub fn samples(&self) -> u64 {
        self.size.0 as u64 * self.size.1 as u64
    }

    /// Whether it is on another machine.
    pub fn is_remote(&self) -> bool {
        self.is_remote
    }

    /// Samples across and down in one block: windows of whole blocks cost least.
    pub fn block_size(&self) -> (usize, usize) {
        self.block
    }

    /// The type of the stored samples.
    pub fn sample_type(&self) -> SampleType {
        self.sample_type
    }

    /// How heights follow from stored samples.
    pub fn scaling(&self) -> Scaling {
        self.scaling
    }

    /// What marks samples as missing.
    pub fn marks(&self) -> &Marks {
        &self.marks
    }

    /// The words by which nodata values were said in place of the tag; none where they were not, or not in words.
    pub fn nodata_words(&self) -> &[String] {
        &self.nodata_words
    }

    /// The raster's own nodata tag.
    pub fn tag(&self) -> Option<Mark> {
        self.tag
    }

    /// Whether a mask or an alpha band says which samples are there.
    pub fn has_mask(&self) -> bool {
        self.has_mask
    }

    /// What is outside of it has no height.
    pub fn cutline(&self) -> Option<&Arc<Cutline>> {
        self.cutline.as_ref()
    }

    /// Where samples lie on the map; the default one where nobody says.
    pub fn geo_transform(&self) -> GeoTransform {
        self.geo_transform.unwrap_or(GeoTransform::DEFAULT.of_window(self.first.0, self.first.1))
    }

    /// Whether it has a geotransform of its own.
    pub fn is_georeferenced(&self) -> bool {
        self.geo_transform.is_some()
    }

    /// What coordinates and heights mean.
    pub fn reference(&self) -> &Reference {
        &self.reference
    }

    /// The CRS as other programs take it from a mesh's header: its authority's code, else WKT; `None` where there is none.
    pub fn crs_definition(&self) -> Option<&str> {
        self.crs.as_deref()
    }

    /// What the band is said to hold, in words; empty where nothing is said.
    pub fn description(&self) -> &str {
        &self.description
    }

    /// What a user should know of it, as far as opening it tells.
    pub fn warnings(&self) -> &[Warning] {
        &self.warnings
    }

    /// The least x and y of the samples, and the largest.
    pub fn extent(&self) -> [f64; 4] {
        self.geo_transform().extent(self.width(), self.height())
    }

    /// Metres in a unit of x and of y in the middle of the raster, and in a unit of heights. What is not said is taken for
    /// metres.
    pub fn in_metres(&self) -> ((f64, f64), f64) {
        let [_, bottom, _, top] = self.extent();
        let heights = metres_in(&self.reference.height_unit).unwrap_or(1.0);
        (Metres::between(self.reference.metres, bottom, top), heights)
    }

    /// The colour it is said to have.
    pub(crate) fn colour(&self) -> Option<&'static str> {
        self.colour
    }

    /// Reads a window as it is stored, see [`Windows::read`].
    ///
    /// # Errors
    /// [`RasterError::Read`], most often.
    ///
    /// # Panics
    /// If the window is not inside the band, or `out` has another length.
    pub fn read(&self, window: Window, out: &mut [u8]) -> Result<(), RasterError> {
        self.check(window);
        assert_eq!(out.len(), window.len() * self.sample_type.bytes(), "buffer of {window:?}");
        self.windows.read(window, out)
    }

    /// Reads the mask of a window, see [`Windows::read_mask`]; all are there where there is no mask.
    ///
    /// # Errors
    /// [`RasterError::Read`], most often.
    ///
    /// # Panics
    /// If the window is not inside the band, or `out` has another length.
    pub fn read_mask(&self, window: Window, out: &mut [u8]) -> Result<(), RasterError> {
        self.check(window);
        assert_eq!(out.len(), window.len(), "mask of {window:?}");
        if self.has_mask {
            return self.windows.read_mask(window, out);
        }
        out.fill(255);
        Ok(())
    }

    fn check(&self, w: Window) {
        let inside = w.column + w.width <= self.width() && w.row + w.height <= self.height();
        assert!(inside, "{w:?} of a raster of {} × {}", self.width(), self.height());
    }

    /// Where the samples lie in a file that can be mapped, see [`Windows::plain_layout`].
    ///
    /// # Errors
    /// Why there is none.
    pub fn plain_layout(&self) -> Result<PlainLayout, String> {
        self.windows.plain_layout()
    }

    /// Gives up what is held for further reading, see [`Windows::release`].
    pub fn release(&self) {
        self.windows.release();
    }

    /// Makes sure that a row of this length can be held in memory: a file may claim any size.
    ///
    /// # Errors
    /// [`RasterError::Wide`].
    pub fn holds_rows(&self, found: usize) -> Result<(), RasterError> {
        /// As doubles, half a gibibyte.
        const LIMIT: usize = 1 << 26;
        if found <= LIMIT { Ok(()) } else { Err(RasterError::Wide { path: self.path.clone(), limit: LIMIT, found }) }
    }

    /// Makes sure that the samples of `other` lie on those of this band: as many across and down, and at the same places on
    /// the map, up to rounding, where both are georeferenced.
    ///
    /// # Errors
    /// [`RasterError::OtherGrid`].
    pub fn same_grid(&self, other: &Band) -> Result<(), RasterError> {
        let (width, height) = self.size;
        let differs = |what, expected, found| {
            let (path, of) = (other.path.clone(), self.path.clone());
            Err(RasterError::OtherGrid { path, of, what, expected, found })
        };
        if self.size != other.size {
            let size = |(across, down): (usize, usize)| format!("{across} × {down} samples");
            return differs("size", size(self.size), size(other.size));
        }
        let (ours, theirs) = (self.geo_transform(), other.geo_transform());
        let georeferenced = self.is_georeferenced() && other.is_georeferenced();
        if georeferenced && !ours.agrees(theirs, width, height) {
            let numbers = |transform: GeoTransform| transform.coefficients().map(|c| c.to_string()).join(", ");
            return differs("geotransform", numbers(ours), numbers(theirs));
        }
        Ok(())
    }
}
