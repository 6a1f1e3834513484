//! Rows of samples, band by band.

use crate::base::Band;
use crate::base::Window;
use crate::base::decimal::Decimal;

use super::VerifyError;
use super::heights::HeightReader;
use super::lines::{Inside, RequiredLines};
use super::runs::RunFlags;

/// What passes before the sweep have found out about a sample, bit by bit.
pub(super) mod flag {
    /// It has no height and belongs to a hole that is bridged.
    pub(crate) const BRIDGED: u8 = 1;
    /// It is near samples without a height, where the ground may be trimmed.
    pub(crate) const NEAR: u8 = 2;
    /// It is outside of the outlines that the mesh is to end at.
    pub(crate) const OUTSIDE: u8 = 4;
}

/// Bands of whole rows of a raster: heights, NaN where there are none.
///
/// Memory use is constant: [`BandReader::SAMPLES`] samples of 8 bytes (as many again where the raster has 64-bit whole
/// numbers and a nodata value, or a byte each where it has a mask), or one row where that is more.
#[derive(Debug)]
pub(super) struct BandReader<'r> {
    reader: HeightReader<'r>,
    /// The raster has no heights: all are 0 where each of these bands has a value.
    level: Option<Vec<HeightReader<'r>>>,
    rows: usize,
    heights: Vec<f64>,
}

impl<'r> BandReader<'r> {
    /// Samples in a band, about.
    const SAMPLES: usize = 1 << 19;

    pub(super) fn new(raster: &'r Band) -> Self {
        let rows = (Self::SAMPLES / raster.width()).clamp(1, raster.height());
        // Whole blocks, where some fit: a block that two bands share is decoded twice.
        let block = raster.block_size().1.max(1);
        let rows = if rows > block { rows - rows % block } else { rows };
        BandReader { reader: HeightReader::new(raster), level: None, rows, heights: Vec::new() }
    }

    /// Heights of 0, of the raster's size, where each of `bands` has a value; none outside of its cutline.
    pub(super) fn level(raster: &'r Band, bands: &'r [Band]) -> Self {
        let rows = (Self::SAMPLES / raster.width()).clamp(1, raster.height());
        let level = Some(bands.iter().map(HeightReader::new).collect());
        BandReader { reader: HeightReader::new(raster), level, rows, heights: Vec::new() }
    }

    /// The same in bands of this number of rows.
    pub(super) fn by(self, rows: usize) -> Self {
        BandReader { rows, ..self }
    }

    /// The raster.
    pub(super) fn raster(&self) -> &'r Band {
        self.reader.band()
    }

    /// Rows in a band; the last one may have fewer.
    pub(super) fn rows(&self) -> usize {
        self.rows
    }

    /// How many bands there are.
    pub(super) fn count(&self) -> usize {
        self.raster().height().div_ceil(self.rows)
    }

    /// The heights of one band, row by row: finite, or NaN.
    pub(super) fn read(&mut self, band: usize) -> Result<&[f64], VerifyError> {
        let mut heights = std::mem::take(&mut self.heights);
        let result = self.read_into(band, &mut heights);
        self.heights = heights;
        result.map(|()| self.heights.as_slice())
    }

    /// The same, in place of what is in `heights`.
    fn read_into(&mut self, band: usize, heights: &mut Vec<f64>) -> Result<(), VerifyError> {
        let (width, row) = (self.raster().width(), band * self.rows);
        self.read_numbers_into(band, heights)?;
        // All are looked at, as vectors.
        if !heights.iter().fold(false, |found, h| found | h.is_infinite()) {
            return Ok(());
        }
        let at = heights.iter().position(|h| h.is_infinite()).expect("there is one");
        let (path, found) = (self.raster().path().to_path_buf(), heights[at]);
        Err(VerifyError::InfiniteSample { path, column: at % width, row: row + at / width, found })
    }

    /// The heights of a band that may have anything where there is no height.
    pub(super) fn read_numbers(&mut self, band: usize) -> Result<&[f64], VerifyError> {
        let mut heights = std::mem::take(&mut self.heights);
        let result = self.read_numbers_into(band, &mut heights);
        self.heights = heights;
        result.map(|()| self.heights.as_slice())
    }

    fn read_numbers_into(&mut self, band: usize, heights: &mut Vec<f64>) -> Result<(), VerifyError> {
        let row = band * self.rows;
        let height = self.rows.min(self.raster().height() - row);
        let window = Window { column: 0, row, width: self.raster().width(), height };
        heights.resize(window.len(), 0.0);
        let Some(bands) = &mut self.level else {
            return Ok(self.reader.read(window, heights)?);
        };
        heights.fill(0.0);
        let mut values = vec![0.0; window.len()];
        for band in bands {
            band.read(window, &mut values)?;
            heights.iter_mut().zip(&values).filter(|(_, v)| v.is_nan()).for_each(|(height, _)| *height = f64::NAN);
        }
        if let Some(cutline) = self.reader.band().cutline() {
            let mut inside = Vec::new();
            cutline.mask(window, &mut inside);
            heights.iter_mut().zip(inside).filter(|(_, inside)| !inside).for_each(|(height, _)| *height = f64::NAN);
        }
        Ok(())
    }

    /// The numbers of one band as weights of errors: finite and not negative wherever there is a height.
    fn read_weights(&mut self, band: usize, heights: &[f64], weights: &mut Vec<f64>) -> Result<(), VerifyError> {
        let (first_row, width) = (band * self.rows, self.raster().width());
        self.read_numbers_into(band, weights)?;
        let wrong = |(weight, height): (&f64, &f64)| !(*weight >= 0.0 && weight.is_finite() || height.is_nan());
        match weights.iter().zip(heights).position(wrong) {
            None => Ok(()),
            Some(at) => Err(VerifyError::NotAWeight {
                path: self.raster().path().to_path_buf(),
                column: at % width,
                row: first_row + at / width,
                found: number_or_nodata(weights[at]),
            }),
        }
    }
}

/// A number as a message tells it.
pub(super) fn number_or_nodata(number: f64) -> String {
    if number.is_nan() { "a nodata sample".to_string() } else { Decimal(number).to_string() }
}

/// The bands of a raster of heights, with those of its importance raster where there is one.
///
/// Memory use is that of one or two [`BandReader`]s.
#[derive(Debug)]
pub(super) struct Bands<'r> {
    heights: BandReader<'r>,
    weights: Option<BandReader<'r>>,
    lines: Option<&'r RequiredLines>,
    /// Where the mesh is to be, if that is not all of the ground.
    inside: Option<&'r Inside>,
    /// Samples beside those that have other heights, of all bands read.
    beside: u64,
    runs: Vec<RunFlags<'r>>,
}

/// The rows of one band, to be read into again: heights, weights, intervals and flags, none of the latter where there are none.
///
/// Memory use is constant: 8 bytes for each sample of a band, 8 more where there are weights, 16 beside lines with heights, a byte
/// where there are flags.
#[derive(Debug, Default)]
pub(super) struct Rows {
    heights: Vec<f64>,
    weights: Vec<f64>,
    lows: Vec<f64>,
    tops: Vec<f64>,
    flags: Vec<u8>,
}

impl Rows {
    /// Takes the last row of others in place of its own.
    pub(super) fn keep_last(&mut self, others: &Rows, width: usize) {
        fn last<T: Copy>(own: &mut Vec<T>, others: &[T], width: usize) {
            own.clear();
            own.extend_from_slice(&others[others.len().saturating_sub(width)..]);
        }
        last(&mut self.heights, &others.heights, width);
        last(&mut self.weights, &others.weights, width);
        last(&mut self.lows, &others.lows, width);
        last(&mut self.tops, &others.tops, width);
        last(&mut self.flags, &others.flags, width);
    }

    /// All of them.
    pub(super) fn samples(&self) -> Samples<'_> {
        fn some<T>(values: &[T]) -> Option<&[T]> {
            (!values.is_empty()).then_some(values)
        }
        Samples {
            heights: &self.heights,
            weights: some(&self.weights),
            intervals: some(&self.lows).zip(some(&self.tops)),
            flags: some(&self.flags),
        }
    }
}

/// Rows of samples: heights, NaN where there are none; weights as many as heights, or none where all errors weigh the same;
/// flags as many, or none where none is set anywhere. Beside lines with heights a sample stands for an interval; elsewhere
/// its ends are the same.
#[derive(Debug, Clone, Copy)]
pub(super) struct Samples<'s> {
    pub(super) heights: &'s [f64],
    pub(super) weights: Option<&'s [f64]>,
    /// Lower ends and upper ones.
    pub(super) intervals: Option<(&'s [f64], &'s [f64])>,
    pub(super) flags: Option<&'s [u8]>,
}

impl<'r> Bands<'r> {
    /// Whether there are weights.
    pub(super) fn are_weighted(&self) -> bool {
        self.weights.is_some()
    }

    pub(super) fn new(heights: BandReader<'r>, importance: Option<&'r Band>, lines: Option<&'r RequiredLines>) -> Self {
        let weights = importance.map(|raster| BandReader::new(raster).by(heights.rows()));
        let inside = lines.and_then(RequiredLines::inside);
        let lines = lines.filter(|lines| lines.have_heights());
        Bands { heights, weights, lines, inside, beside: 0, runs: Vec::new() }
    }

    /// How many samples of the bands that have been read are beside lines with other heights.
    pub(super) fn beside_lines(&self) -> u64 {
        self.beside
    }

    /// Makes intervals of the samples of some rows that are beside lines.
    fn widen(&mut self, lines: &RequiredLines, first_row: usize, rows: &mut Rows) -> Result<(), VerifyError> {
        let width = self.heights.raster().width();
        let after = first_row + rows.heights.len() / width;
        let mut near = lines.near(first_row as i64..after as i64)?.peekable();
        let flooded = || lines.flooded(first_row as i64..after as i64);
        if near.peek().is_none() && flooded().next().is_none() {
            return Ok(());
        }
        rows.lows.extend_from_slice(&rows.heights);
        rows.tops.extend_from_slice(&rows.heights);
        for ((row, column), [low, high]) in near {
            let at = (row as usize - first_row) * width + column as usize;
            let height = rows.heights[at];
            if height.is_nan() {
                continue;
            }
            (rows.lows[at], rows.tops[at]) = (height.min(low), height.max(high));
            self.beside += u64::from(rows.lows[at] < rows.tops[at]);
        }
        for (row, columns, level) in flooded() {
            for column in columns.start.max(0)..columns.end.min(width as i64) {
                let at = (row as usize - first_row) * width + column as usize;
                if !rows.heights[at].is_nan() {
                    self.beside -= u64::from(rows.lows[at] < rows.tops[at]);
                    (rows.lows[at], rows.tops[at]) = (level, level);
                }
            }
        }
        Ok(())
    }

    /// With flags of samples.
    pub(super) fn with_flags(mut self, runs: RunFlags<'r>) -> Self {
        self.runs.push(runs);
        self
    }

    /// How many bands there are.
    pub(super) fn count(&self) -> usize {
        self.heights.count()
    }

    /// Reads one band, the one after that of the call before.
    pub(super) fn read(&mut self, band: usize, rows: &mut Rows) -> Result<(), VerifyError> {
        let (first_row, width) = (band * self.heights.rows(), self.heights.raster().width());
        self.heights.read_into(band, &mut rows.heights)?;
        if let Some(weights) = &mut self.weights {
            weights.read_weights(band, &rows.heights, &mut rows.weights)?;
        }
        rows.lows.clear();
        rows.tops.clear();
        if let Some(lines) = self.lines {
            self.widen(lines, first_row, rows)?;
        }
        rows.flags.clear();
        if !self.runs.is_empty() || self.inside.is_some() {
            rows.flags.resize(rows.heights.len(), if self.inside.is_some() { flag::OUTSIDE } else { 0 });
        }
        if let Some(inside) = self.inside {
            let first = first_row as i64;
            for (row, columns) in inside.samples(first..first + (rows.heights.len() / width) as i64) {
                let line = (row - first) as usize * width;
                let columns = line + columns.start as usize..line + (columns.end as usize).min(width);
                rows.flags.get_mut(columns).unwrap_or_default().iter_mut().for_each(|flags| *flags &= !flag::OUTSIDE);
            }
        }
        self.runs.iter_mut().try_for_each(|runs| runs.set(first_row, width, &mut rows.flags, |_| Ok(())))
    }
}

impl<'s> Samples<'s> {
    /// Some of them.
    pub(super) fn part(self, range: std::ops::Range<usize>) -> Samples<'s> {
        Samples {
            heights: &self.heights[range.clone()],
            weights: self.weights.map(|weights| &weights[range.clone()]),
            intervals: self.intervals.map(|(lows, tops)| (&lows[range.clone()], &tops[range.clone()])),
            flags: self.flags.map(|flags| &flags[range]),
        }
    }

    /// The interval that one stands for, if it is one.
    pub(super) fn interval(&self, at: usize) -> Option<[f64; 2]> {
        self.intervals
            .map(|(lows, tops)| [lows[at], tops[at]])
            .filter(|[low, top]| low < top || *low != self.heights[at])
    }

    /// Their heights without those outside of the outlines that the mesh is to end at, if there are any.
    pub(super) fn inside(&self) -> Option<Vec<f64>> {
        let flags = self.flags.filter(|flags| flags.iter().any(|flags| flags & flag::OUTSIDE != 0))?;
        let inside = |(height, flags): (&f64, &u8)| if flags & flag::OUTSIDE == 0 { *height } else { f64::NAN };
        Some(self.heights.iter().zip(flags).map(inside).collect())
    }

    /// What is known of one of them.
    pub(super) fn flags(&self, at: usize) -> u8 {
        self.flags.map_or(0, |flags| flags[at])
    }

    /// Whether one with a height is judged by something else: it is beside a line with a height, or in a lake.
    pub(super) fn is_widened(&self, at: usize) -> bool {
        let height = self.heights[at];
        self.intervals.is_some_and(|(lows, tops)| lows[at] != height || tops[at] != height) && !height.is_nan()
    }
}
