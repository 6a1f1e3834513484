use crate::raster::{Nodata, Raster, SampleType, Window};

use super::VerifyError;

/// Bands of whole rows of a raster, checked to hold nothing but finite heights.
///
/// Memory use is constant: [`BandReader::SAMPLES`] samples of 8 bytes (as many again where the raster has a nodata
/// value, or a byte each where it has a mask), or one row where that is more.
#[derive(Debug)]
pub(super) struct BandReader<'r> {
    raster: &'r Raster,
    masked: bool,
    /// The raster has no heights: all are 0.
    level: bool,
    rows: usize,
    heights: Vec<f64>,
}

impl<'r> BandReader<'r> {
    /// Samples in a band, about.
    const SAMPLES: usize = 1 << 20;

    pub(super) fn new(raster: &'r Raster) -> Result<Self, VerifyError> {
        let rows = (Self::SAMPLES / raster.width()).clamp(1, raster.height());
        // Whole blocks, where some fit: a block that two bands share is decoded twice.
        let block = raster.block_size().1.max(1);
        let rows = if rows > block { rows - rows % block } else { rows };
        BandReader::of_rows(raster, rows)
    }

    /// Heights of 0, of the raster's size.
    pub(super) fn level(raster: &'r Raster) -> Self {
        let rows = (Self::SAMPLES / raster.width()).clamp(1, raster.height());
        BandReader { raster, masked: false, level: true, rows, heights: Vec::new() }
    }

    /// The same in bands of so many rows.
    pub(super) fn by(self, rows: usize) -> Self {
        BandReader { rows, ..self }
    }

    /// Bands of another raster's rows.
    fn of_rows(raster: &'r Raster, rows: usize) -> Result<Self, VerifyError> {
        Ok(BandReader { raster, masked: raster.has_mask()?, level: false, rows, heights: Vec::new() })
    }

    /// Rows in a band; the last one may have fewer.
    pub(super) fn rows(&self) -> usize {
        self.rows
    }

    /// How many bands there are.
    pub(super) fn count(&self) -> usize {
        self.raster.height().div_ceil(self.rows)
    }

    /// The heights of one band, row by row.
    pub(super) fn read(&mut self, band: usize) -> Result<&[f64], VerifyError> {
        let row = band * self.rows;
        let height = self.rows.min(self.raster.height() - row);
        let window = Window { column: 0, row, width: self.raster.width(), height };
        self.heights.resize(window.len(), 0.0);
        if self.level {
            return Ok(&self.heights);
        }
        self.raster.read_heights(window, &mut self.heights)?;
        self.refuse_nodata(window)?;
        if let Some(at) = self.heights.iter().position(|h| !h.is_finite()) {
            let (column, row) = (at % window.width, row + at / window.width);
            let (path, found) = (self.raster.path().to_path_buf(), self.heights[at]);
            return Err(match found.is_nan() {
                true => VerifyError::NodataUnsupported { path, column, row },
                false => VerifyError::InfiniteSample { path, column, row, found },
            });
        }
        Ok(&self.heights)
    }

    /// The numbers of one band as weights of errors: finite and not negative.
    fn read_weights(&mut self, band: usize) -> Result<&[f64], VerifyError> {
        let (first_row, width) = (band * self.rows, self.raster.width());
        let path = self.raster.path().to_path_buf();
        self.read(band).map_err(|error| match error {
            VerifyError::NodataUnsupported { path, column, row } => {
                VerifyError::NotAWeight { path, column, row, found: "a nodata sample".to_string() }
            }
            VerifyError::InfiniteSample { path, column, row, found } => {
                VerifyError::NotAWeight { path, column, row, found: found.to_string() }
            }
            other => other,
        })?;
        match self.heights.iter().position(|&weight| weight < 0.0) {
            None => Ok(&self.heights),
            Some(at) => {
                let (column, row, found) = (at % width, first_row + at / width, self.heights[at].to_string());
                Err(VerifyError::NotAWeight { path, column, row, found })
            }
        }
    }

    fn refuse_nodata(&self, window: Window) -> Result<(), VerifyError> {
        let mut found = None;
        if self.masked {
            let mut mask = vec![0; window.len()];
            self.raster.read_mask(window, &mut mask)?;
            found = mask.iter().position(|&m| m == 0);
        }
        if self.raster.nodata() != Nodata::None {
            // Doubles for their alignment, to hold samples of any type.
            let mut stored = vec![0f64; window.len()];
            let bytes = window.len() * self.raster.sample_type().bytes();
            let stored = &mut bytemuck::cast_slice_mut(&mut stored)[..bytes];
            self.raster.read_native(window, stored)?;
            found = found.into_iter().chain(first_nodata(self.raster, stored)).min();
        }
        found.map_or(Ok(()), |at| {
            let (column, row) = (at % window.width, window.row + at / window.width);
            Err(VerifyError::NodataUnsupported { path: self.raster.path().to_path_buf(), column, row })
        })
    }
}

/// The bands of a raster of heights, with those of its importance raster where there is one.
///
/// Memory use is that of one or two [`BandReader`]s.
#[derive(Debug)]
pub(super) struct Bands<'r> {
    heights: BandReader<'r>,
    weights: Option<BandReader<'r>>,
}

/// Rows of samples; weights as many as heights, or none where all errors weigh the same.
#[derive(Debug, Clone, Copy)]
pub(super) struct Samples<'s> {
    pub(super) heights: &'s [f64],
    pub(super) weights: Option<&'s [f64]>,
}

impl<'r> Bands<'r> {
    /// Whether there are weights.
    pub(super) fn are_weighted(&self) -> bool {
        self.weights.is_some()
    }

    pub(super) fn new(heights: BandReader<'r>, importance: Option<&'r Raster>) -> Result<Self, VerifyError> {
        let weights = importance.map(|raster| BandReader::of_rows(raster, heights.rows())).transpose()?;
        Ok(Bands { heights, weights })
    }

    /// Rows in a band; the last one may have fewer.
    pub(super) fn rows(&self) -> usize {
        self.heights.rows()
    }

    /// How many bands there are.
    pub(super) fn count(&self) -> usize {
        self.heights.count()
    }

    /// One band, row by row.
    pub(super) fn read(&mut self, band: usize) -> Result<Samples<'_>, VerifyError> {
        let weights = self.weights.as_mut().map(|weights| weights.read_weights(band)).transpose()?;
        Ok(Samples { heights: self.heights.read(band)?, weights })
    }
}

impl<'s> Samples<'s> {
    /// Some of them.
    pub(super) fn part(self, range: std::ops::Range<usize>) -> Samples<'s> {
        Samples { heights: &self.heights[range.clone()], weights: self.weights.map(|weights| &weights[range]) }
    }
}

/// The first stored value that is the raster's mark of nodata.
fn first_nodata(raster: &Raster, stored: &[u8]) -> Option<usize> {
    match raster.nodata() {
        Nodata::None => None,
        Nodata::I64(mark) => bytemuck::cast_slice::<u8, i64>(stored).iter().position(|&v| v == mark),
        Nodata::U64(mark) => bytemuck::cast_slice::<u8, u64>(stored).iter().position(|&v| v == mark),
        // To single precision a mark is rounded. A NaN marks NaN, which no height may be anyway.
        Nodata::Real(mark) if raster.sample_type() == SampleType::F32 => {
            bytemuck::cast_slice::<u8, f32>(stored).iter().position(|&v| v == mark as f32)
        }
        #[allow(clippy::unnecessary_cast)]
        Nodata::Real(mark) => crate::raster::with_sample_type!(raster.sample_type(), T => {
            bytemuck::cast_slice::<u8, T>(stored).iter().position(|&v| v as f64 == mark)
        }),
    }
}
