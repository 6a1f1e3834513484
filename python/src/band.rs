//! Bands: what Python says of a raster, and the way to its stored values.

use std::path::PathBuf;
use std::sync::Arc;

use numpy::{PyArray2, PyArrayMethods, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use terrabite::base::{
    Band, BandFacts, BandPart, BandView, Encoding, Mark, MaskFlags, Masks, SampleType, Scaling, ValidRange, Window,
    Windows, is_scale_of_greys,
};

use crate::errors::{self, taken};
use crate::options::chosen;
use crate::windows::{ArrayWindows, ReaderWindows, sample_type, with_element};

/// What Python says of a raster: an object of `terrabite._facts.Facts`, attribute by attribute.
#[derive(FromPyObject)]
struct Facts {
    name: PathBuf,
    driver: String,
    size: (usize, usize),
    band: usize,
    colours: Vec<Option<String>>,
    dtypes: Vec<String>,
    colour_table: Option<Vec<[i16; 3]>>,
    block: (usize, usize),
    scale: f64,
    offset: f64,
    nodata: Option<Py<PyAny>>,
    /// All valid, per dataset, alpha, nodata.
    mask_flags: (bool, bool, bool, bool),
    transform: Option<[f64; 6]>,
    elsewhere: Option<String>,
    crs: String,
    esri_wkt: Option<String>,
    unit: String,
    description: String,
    pixel_is: String,
}

/// How it is to be looked at: an object of `terrabite._facts.View`.
#[derive(FromPyObject)]
struct View {
    is_named: bool,
    /// An image, all of whose bands are attributes.
    is_image: bool,
    nodata: Vec<String>,
    valid_range: Option<(f64, f64)>,
    window: Option<(usize, usize, usize, usize)>,
    between: Option<Vec<(f64, f64)>>,
    encoding: Option<String>,
    cutline: Vec<Vec<Vec<(f64, f64)>>>,
}

impl View {
    fn of_band(&self) -> PyResult<BandView> {
        let valid_range = match self.valid_range {
            Some((min, max)) if min <= max => Some(ValidRange { min, max }),
            None => None,
            // One of them may be NaN.
            Some((min, max)) => {
                let message =
                    format!("valid_range: expected two heights, the second not below the first, found {min}, {max}");
                return Err(PyValueError::new_err(message));
            }
        };
        let part = match (self.window, &self.between) {
            (None, None) => None,
            (Some((column, row, width, height)), None) => Some(BandPart::Window(Window { column, row, width, height })),
            (None, Some(places)) => Some(BandPart::Between(places.clone())),
            (Some(_), Some(_)) => return Err(PyValueError::new_err("window and bbox cannot be combined")),
        };
        let (is_named, nodata, encoding, cutline) =
            (self.is_named, self.nodata.clone(), self.encoding()?, self.cutline.clone());
        Ok(BandView { is_named, encoding, nodata, valid_range, part, cutline })
    }

    fn encoding(&self) -> PyResult<Option<Encoding>> {
        let known = [Encoding::TerrainRgb, Encoding::Terrarium].map(|encoding| (encoding.name(), encoding));
        chosen("encoding", self.encoding.as_ref(), &known)
    }
}

/// The colours that the library knows.
const COLOURS: [&str; 13] = [
    "red",
    "green",
    "blue",
    "alpha",
    "hue",
    "saturation",
    "lightness",
    "cyan",
    "magenta",
    "yellow",
    "black",
    "luminance",
    "chrominance",
];

impl Facts {
    fn sample_type(&self, band: usize) -> PyResult<SampleType> {
        let dtype = self.dtypes.get(band.wrapping_sub(1)).map_or("none", String::as_str);
        sample_type(dtype).ok_or_else(|| {
            let name = self.name.display();
            errors::of_band(&terrabite::base::RasterError::SampleType {
                path: PathBuf::from(name.to_string()),
                band,
                found: dtype.to_string(),
            })
        })
    }

    fn masks(&self) -> Masks {
        let (all_valid, per_dataset, alpha, nodata) = self.mask_flags;
        let flags = MaskFlags { all_valid, per_dataset, alpha, nodata };
        let is_alpha = |number: usize| self.colours[number - 1].as_deref() == Some("alpha");
        Masks::of(flags, self.band, self.colours.len(), is_alpha)
    }

    /// The tag in the terms of its type of samples.
    fn tag(&self, py: Python<'_>, sample_type: SampleType) -> PyResult<Option<Mark>> {
        let Some(nodata) = &self.nodata else { return Ok(None) };
        let nodata = nodata.bind(py);
        // A double in any case: rasterio has tags of 64-bit integers so, too. One that samples cannot have is told later.
        let exactly = match sample_type {
            SampleType::I64 => nodata.extract().ok().map(Mark::I64),
            SampleType::U64 => nodata.extract().ok().map(Mark::U64),
            _ => None,
        };
        let value: f64 = nodata.extract()?;
        let whole = || Mark::parse(&value.to_string(), sample_type).filter(|mark| !matches!(mark, Mark::Real(_)));
        Ok(Some(exactly.or_else(whole).unwrap_or(Mark::Real(value))))
    }

    fn of_band(self, py: Python<'_>) -> PyResult<BandFacts> {
        let (sample_type, masks) = (self.sample_type(self.band)?, self.masks());
        let tag = self.tag(py, sample_type)?;
        let known = |name: &Option<String>| COLOURS.into_iter().find(|known| name.as_deref() == Some(*known));
        Ok(BandFacts {
            path: self.name,
            driver: self.driver,
            size: self.size,
            number: self.band,
            colours: self.colours.iter().map(known).collect(),
            has_table: self.colour_table.is_some_and(|table| !is_scale_of_greys(&table)),
            bytes: self.dtypes.iter().map(|dtype| dtype == "uint8").collect(),
            block: self.block,
            sample_type,
            scaling: Scaling { scale: self.scale, offset: self.offset },
            tag,
            masks,
            geo_transform: self.transform,
            elsewhere: self.elsewhere,
            crs: self.crs,
            esri_wkt: self.esri_wkt,
            unit: self.unit,
            description: self.description,
            pixel_is: self.pixel_is,
        })
    }

    fn band(self, py: Python<'_>, view: &View, windows: Arc<dyn Windows>) -> PyResult<Band> {
        self.of_band(py)?.band(&view.of_band()?, windows).map_err(|error| errors::of_band(&error))
    }
}

/// One band of a raster: what is known of it, and the way to its stored values.
#[pyclass(name = "Band", module = "terrabite._terrabite", frozen)]
pub(crate) struct PyBand {
    pub(crate) band: Band,
}

#[pymethods]
impl PyBand {
    /// Over an array of two dimensions in C order, which is borrowed, and a mask of the same shape, true where nothing is there.
    #[staticmethod]
    fn of_array(
        array: &Bound<'_, PyUntypedArray>,
        mask: Option<&Bound<'_, PyArray2<bool>>>,
        facts: &Bound<'_, PyAny>,
        view: &Bound<'_, PyAny>,
    ) -> PyResult<PyBand> {
        let py = array.py();
        let (facts, view): (Facts, View) = (taken(facts)?, taken(view)?);
        let (name, sample_type) = (facts.name.clone(), facts.sample_type(1)?);
        let fits = |array: &Bound<'_, PyUntypedArray>| {
            array.ndim() == 2 && array.shape() == [facts.size.1, facts.size.0] && array.is_c_contiguous()
        };
        if !fits(array) || !mask.is_none_or(|mask| fits(mask.as_untyped())) {
            return Err(PyTypeError::new_err("expected an array of two dimensions in C order"));
        }
        let mask = mask.map(|mask| mask.clone().unbind());
        let windows = with_element!(sample_type, T => {
            let array = array.cast::<PyArray2<T>>()?.clone().unbind();
            Arc::new(ArrayWindows { name, array, mask }) as Arc<dyn Windows>
        });
        let windows = windows.ok_or_else(|| PyTypeError::new_err("half floats: call astype(\"float32\")"))?;
        Ok(PyBand { band: facts.band(py, &view, windows)? })
    }

    /// Read by an object, see [`ReaderWindows`].
    #[staticmethod]
    fn of_reader(reader: Py<PyAny>, facts: &Bound<'_, PyAny>, view: &Bound<'_, PyAny>) -> PyResult<PyBand> {
        let py = facts.py();
        let (facts, view): (Facts, View) = (taken(facts)?, taken(view)?);
        let masks = facts.masks();
        let alpha_type = masks.alpha.map_or(Ok(SampleType::U8), |band| facts.sample_type(band))?;
        let facts = facts.of_band(py)?;
        let (is_image, view) = (view.is_image, view.of_band()?);
        let failed = |error| errors::of_band(&error);
        if is_image {
            facts.expect_no_table().map_err(failed)?;
        }
        let encoded = match view.encoding {
            Some(encoding) => Some((encoding, facts.encoded_bands(encoding).map_err(failed)?)),
            None => None,
        };
        let (name, number, sample_type) = (facts.path.clone(), facts.number, facts.sample_type);
        let windows = ReaderWindows { name, reader, number, sample_type, encoded, masks, alpha_type };
        Ok(PyBand { band: facts.band(&view, Arc::new(windows)).map_err(failed)? })
    }

    /// Rows and columns.
    #[getter]
    fn shape(&self) -> (usize, usize) {
        (self.band.height(), self.band.width())
    }
}
