//! The heights of the finest grid: the bilinear surface of the raster's samples, at the place that each sample of the grid
//! has on the raster, exactly transformed.
//!
//! A height depends on the raster, the grid and the place, not on the window that is read. PROJ may choose among several
//! ways by the mean of the places that it is given together, so they are given in the same runs of [`RUN`] columns always.

use std::sync::{Arc, Mutex, PoisonError};

use super::error::PyramidError;
use super::grid::{Grid, MAX_EXPONENT, MIN_EXPONENT};
use crate::base::{Band, GeoTransform, RasterError, SampleType, Tile, Window, Windows};
use crate::field::{Field, FieldError, LoadScratch};
use crate::raster::{Geodesy, GeodesyError, Ways};

/// Columns that are transformed together, from a multiple of it on.
const RUN: i64 = 64;

/// How far beyond the outermost samples a place may be and count as on them, in cells: geotransforms are rounded.
const ROUNDING: f64 = 1e-6;

/// The part of the grid that the raster may cover.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Area {
    /// The first column, from −columns on: an area may go over the antimeridian.
    pub(crate) column: i64,
    /// The first row.
    pub(crate) row: i64,
    pub(crate) width: usize,
    pub(crate) height: usize,
}

/// The raster, and how it lies under the grid.
pub(super) struct Source {
    pub(super) field: Arc<Field>,
    pub(super) geodesy: Geodesy,
    transform: GeoTransform,
    /// Columns in 360°, where x is the longitude.
    period: Option<f64>,
    /// What is wrong with a sample of the raster, where a window could not be read for it.
    wrong: Mutex<Option<FieldError>>,
}

impl Source {
    pub(super) fn new(field: Arc<Field>, geodesy: Geodesy) -> Source {
        let transform = field.geo_transform();
        let [_, dx, turn, _, other_turn, _] = transform.coefficients();
        let is_upright = turn == 0.0 && other_turn == 0.0;
        let period = (geodesy.is_geographic && is_upright).then(|| 360.0 / dx.abs());
        Source { field, geodesy, transform, period, wrong: Mutex::default() }
    }

    /// Why the samples of the grid cannot be read, in the words of the raster's own where one of those is to blame.
    pub(super) fn explain(&self, error: FieldError) -> PyramidError {
        self.wrong.lock().unwrap_or_else(PoisonError::into_inner).take().unwrap_or(error).into()
    }

    fn failed(&self, source: GeodesyError) -> PyramidError {
        PyramidError::Geodesy { path: self.field.name().to_path_buf(), source }
    }

    /// Columns and rows of the raster at places of the grid; infinite where there is none.
    fn columns_and_rows(&self, ways: &Ways, lon: &mut [f64], lat: &mut [f64]) {
        ways.to_raster(lon, lat);
        for (x, y) in lon.iter_mut().zip(lat) {
            let (column, row) = self.transform.sample_coordinates(*x, *y);
            (*x, *y) = (self.around(column), row);
        }
    }

    /// A raster of longitudes may count from 0° or beyond 180°.
    fn around(&self, column: f64) -> f64 {
        let last = (self.field.width() - 1) as f64;
        let Some(period) = self.period else { return column };
        [column, column + period, column - period]
            .into_iter()
            .find(|c| (-ROUNDING..=last + ROUNDING).contains(c))
            .unwrap_or(column)
    }

    /// Ellipsoidal heights at places of the raster, columns and rows, in runs of [`RUN`]; NaN where there is none.
    fn heights(&self, ways: &Ways, places: &[(f64, f64)], scratch: &mut Scratch) -> Result<Vec<f64>, PyramidError> {
        let mut heights = vec![f64::NAN; places.len()];
        let on = |&(column, row): &(f64, f64)| {
            Some((on_samples(column, self.field.width())?, on_samples(row, self.field.height())?))
        };
        let snapped: Vec<Option<(f64, f64)>> = places.iter().map(on).collect();
        let all = snapped.iter().flatten();
        let bounds = all.fold(None, |bounds: Option<[f64; 4]>, &(c, r)| {
            let [left, top, right, bottom] = bounds.unwrap_or([c, r, c, r]);
            Some([left.min(c), top.min(r), right.max(c), bottom.max(r)])
        });
        let Some([left, top, right, bottom]) = bounds else { return Ok(heights) };
        let window = Window {
            column: left as usize,
            row: top as usize,
            width: (right.ceil() as usize + 1).max(left as usize + 1) - left as usize,
            height: (bottom.ceil() as usize + 1).max(top as usize + 1) - top as usize,
        };
        self.field.load_with(window, &mut scratch.tile, &mut scratch.load)?;
        for (height, place) in heights.iter_mut().zip(&snapped) {
            if let Some((column, row)) = *place {
                *height = bilinear(&scratch.tile, column - window.column as f64, row - window.row as f64);
            }
        }
        self.to_ellipsoidal(ways, &snapped, &mut heights);
        Ok(heights)
    }

    /// Heights of the raster become ellipsoidal.
    fn to_ellipsoidal(&self, ways: &Ways, places: &[Option<(f64, f64)>], heights: &mut [f64]) {
        for (places, heights) in places.chunks(RUN as usize).zip(heights.chunks_mut(RUN as usize)) {
            let known: Vec<usize> = (0..heights.len()).filter(|&i| !heights[i].is_nan()).collect();
            let place = |&i: &usize| places[i].map_or((0.0, 0.0), |(column, row)| self.transform.place(column, row));
            let (mut x, mut y): (Vec<f64>, Vec<f64>) = known.iter().map(place).unzip();
            let mut z: Vec<f64> = known.iter().map(|&i| heights[i]).collect();
            ways.to_ellipsoidal(&mut x, &mut y, &mut z);
            for (&i, &height) in known.iter().zip(&z) {
                heights[i] = if height.is_finite() { height } else { f64::NAN };
            }
        }
    }

    /// The grid that is not coarser than the raster, or `finer` exponents finer than that.
    pub(super) fn grid(&self, finer: u32) -> Result<Grid, PyramidError> {
        let ways = self.geodesy.ways().map_err(|e| self.failed(e))?;
        let spacing = self.spacing(&ways).ok_or_else(|| self.nothing())?;
        let fits = |exponent: &u32| Grid { exponent: *exponent }.cell() <= spacing * (1.0 + 1e-9);
        let exponent = (MIN_EXPONENT..=MAX_EXPONENT).find(fits).map(|exponent| exponent + finer);
        match exponent.filter(|exponent| *exponent <= MAX_EXPONENT) {
            Some(exponent) => Ok(Grid { exponent }),
            None => {
                let (least, most) = (Grid { exponent: MAX_EXPONENT }.cell(), Grid { exponent: MIN_EXPONENT }.cell());
                Err(PyramidError::Spacing { path: self.field.name().to_path_buf(), least, most, found: spacing })
            }
        }
    }

    fn nothing(&self) -> PyramidError {
        PyramidError::Nothing { path: self.field.name().to_path_buf() }
    }

    /// The least distance of samples, in degrees of latitude; steps that go east more than north are measured along the
    /// parallel, where a cell of the grid is short, too.
    fn spacing(&self, ways: &Ways) -> Option<f64> {
        let (width, height) = (self.field.width() as f64, self.field.height() as f64);
        let mut least = f64::INFINITY;
        for (i, j) in (0..5).flat_map(|i| (0..5).map(move |j| (i, j))) {
            let (column, row) = ((width - 2.0) * f64::from(i) / 4.0, (height - 2.0) * f64::from(j) / 4.0);
            let at = [(column, row), (column + 1.0, row), (column, row + 1.0)].map(|(c, r)| self.transform.place(c, r));
            let (mut x, mut y) = (at.map(|p| p.0), at.map(|p| p.1));
            ways.to_geographic(&mut x, &mut y);
            if x.iter().chain(&y).any(|v| !v.is_finite()) || y[0].abs() > 89.9 {
                continue;
            }
            let shrink = libm::cos(y[0].to_radians());
            for other in [1, 2] {
                let east = (x[other] - x[0] + 540.0).rem_euclid(360.0) - 180.0;
                let north = y[other] - y[0];
                let (along, length) = ((east * shrink).abs(), libm::hypot(east * shrink, north));
                least = least.min(if along > north.abs() { length / shrink } else { length });
            }
        }
        least.is_finite().then_some(least)
    }

    /// The part of the grid that the raster may cover, generously.
    pub(super) fn area(&self, grid: Grid) -> Result<Area, PyramidError> {
        let ways = self.geodesy.ways().map_err(|e| self.failed(e))?;
        let (right, bottom) = ((self.field.width() - 1) as f64, (self.field.height() - 1) as f64);
        const STEPS: i32 = 200;
        let share = |i: i32| f64::from(i) / f64::from(STEPS);
        let rim = (0..STEPS)
            .map(|i| (right * share(i), 0.0))
            .chain((0..STEPS).map(|i| (right, bottom * share(i))))
            .chain((0..STEPS).map(|i| (right * share(STEPS - i), bottom)))
            .chain((0..STEPS).map(|i| (0.0, bottom * share(STEPS - i))));
        let (mut lon, mut lat): (Vec<f64>, Vec<f64>) = rim.map(|(c, r)| self.transform.place(c, r)).unzip();
        ways.to_geographic(&mut lon, &mut lat);
        let mut east: Option<(f64, f64, f64)> = None;
        let (mut south, mut north) = (f64::INFINITY, f64::NEG_INFINITY);
        let mut is_partial = false;
        for (lon, lat) in lon.into_iter().zip(lat) {
            if !(lon.is_finite() && lat.is_finite()) {
                is_partial = true;
                continue;
            }
            // From the one before by the shorter way round; a geographic raster counts on by itself.
            let (first, last, before) = east.unwrap_or((lon, lon, lon));
            let step =
                if self.period.is_some() { lon - before } else { (lon - before + 540.0).rem_euclid(360.0) - 180.0 };
            let lon = before + step;
            east = Some((first.min(lon), last.max(lon), lon));
            (south, north) = (south.min(lat), north.max(lat));
        }
        // Of a whole disc no place of the rim is on the globe.
        let (mut west, mut east, _) = east.unwrap_or((-180.0, 180.0, 0.0));
        // A pole inside is on no rim.
        for pole in [-90.0, 90.0] {
            let (mut x, mut y) = ([0.0], [pole]);
            self.columns_and_rows(&ways, &mut x, &mut y);
            let inside = (0.0..=right).contains(&x[0]) && (0.0..=bottom).contains(&y[0]);
            if inside && self.period.is_none() {
                (west, east) = (-180.0, 180.0);
                if pole < 0.0 { south = -90.0 } else { north = 90.0 }
            }
        }
        if is_partial {
            // Part of the rim lies beyond the projection: nothing is known.
            (west, east, south, north) = (-180.0, 180.0, -90.0, 90.0);
        }
        // Between the places of the rim it may bulge.
        let margin = 2.0 * grid.cell();
        let (wide, high) = (margin + 0.02 * (east - west), margin + 0.02 * (north - south));
        let bulges = if self.period.is_some() { (margin, margin) } else { (wide, high) };
        let column = |lon: f64| ((lon + 180.0) / grid.cell()).floor() as i64;
        let (mut first, mut last) = (column(west - bulges.0), column(east + bulges.0) + 1);
        if last - first >= grid.columns() {
            (first, last) = (0, grid.columns() - 1);
        }
        let row = |lat: f64| (((90.0 - lat) / grid.cell()).floor() as i64).clamp(0, grid.rows());
        let (top, bottom) = (row(north + bulges.1), (row(south - bulges.1) + 1).min(grid.rows()));
        Ok(Area { column: first, row: top, width: (last - first + 1) as usize, height: (bottom - top + 1) as usize })
    }
}

/// A place along an axis of `samples` samples, if it is on or between them.
fn on_samples(at: f64, samples: usize) -> Option<f64> {
    let last = (samples - 1) as f64;
    (-ROUNDING..=last + ROUNDING).contains(&at).then(|| at.clamp(0.0, last))
}

/// The bilinear surface; NaN where a sample that counts is missing.
fn bilinear(tile: &Tile, column: f64, row: f64) -> f64 {
    let (left, top) = (column.floor(), row.floor());
    let (right_share, lower_share) = (column - left, row - top);
    let at = |dc: usize, dr: usize, share: f64| {
        if share == 0.0 {
            return 0.0;
        }
        let (c, r) = (left as usize + dc, top as usize + dr);
        if tile.validity().is_valid(c as i32, r as i32) { share * tile.at(c, r) } else { f64::NAN }
    };
    let upper = at(0, 0, (1.0 - right_share) * (1.0 - lower_share)) + at(1, 0, right_share * (1.0 - lower_share));
    let lower = at(0, 1, (1.0 - right_share) * lower_share) + at(1, 1, right_share * lower_share);
    upper + lower
}

/// Memory for a window of the raster.
#[derive(Default)]
pub(super) struct Scratch {
    tile: Tile,
    load: LoadScratch,
}

/// The part of the grid that the raster may cover, as a band of heights; NaN where there is none.
struct Resampled {
    source: Arc<Source>,
    grid: Grid,
    area: Area,
}

impl Windows for Resampled {
    fn read(&self, window: Window, out: &mut [u8]) -> Result<(), RasterError> {
        let out: &mut [f64] = bytemuck::cast_slice_mut(out);
        let failed = |reason: String| {
            let Window { column, row, width, height } = window;
            RasterError::Read { path: self.source.field.name().to_path_buf(), column, row, width, height, reason }
        };
        let ways = self.source.geodesy.ways().map_err(|e| failed(e.to_string()))?;
        let mut scratch = Scratch::default();
        let first = self.area.column + window.column as i64;
        let end = first + window.width as i64;
        let mut places = Vec::new();
        for start in (first.div_euclid(RUN)..=(end - 1).div_euclid(RUN)).map(|run| run * RUN) {
            for rows in (0..window.height).step_by(RUN as usize) {
                let rows = rows..(rows + RUN as usize).min(window.height);
                places.clear();
                for row in rows.clone() {
                    let lat = self.grid.latitude(self.area.row + (window.row + row) as i64);
                    let mut x: Vec<f64> = (start..start + RUN).map(|c| self.grid.longitude(c)).collect();
                    let mut y = vec![lat; x.len()];
                    self.source.columns_and_rows(&ways, &mut x, &mut y);
                    places.extend(x.into_iter().zip(y));
                }
                let heights = self.source.heights(&ways, &places, &mut scratch).map_err(|e| match e {
                    PyramidError::Field(FieldError::Raster(e)) => e,
                    PyramidError::Field(e) => {
                        let reason = e.to_string();
                        *self.source.wrong.lock().unwrap_or_else(PoisonError::into_inner) = Some(e);
                        failed(reason)
                    }
                    other => failed(other.to_string()),
                })?;
                for (row, heights) in rows.zip(heights.chunks(RUN as usize)) {
                    for (column, &height) in (start..).zip(heights).filter(|(c, _)| (first..end).contains(c)) {
                        out[row * window.width + (column - first) as usize] = height;
                    }
                }
            }
        }
        Ok(())
    }
}

/// The band of the finest grid. Its first sample is that of the area.
pub(super) fn band(source: Arc<Source>, grid: Grid, area: Area) -> Result<Band, PyramidError> {
    let name = source.field.name().to_path_buf();
    let size = (area.width, area.height);
    Ok(Band::new(name, size, SampleType::F64, Arc::new(Resampled { source, grid, area }))?)
}
