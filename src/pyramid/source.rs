//! The heights of the finest grid: the bilinear surface of the raster's samples, at the place that each sample of the grid
//! has on the raster, exactly transformed.
//!
//! A height depends on the raster, the grid and the place, not on the window that is read. PROJ may choose among several
//! ways by the mean of the places that it is given together, so they are given in the same runs of [`RUN`] columns always.

use std::ops::Range;

use super::error::PyramidError;
use super::grid::{Grid, MAX_EXPONENT, MIN_EXPONENT};
use super::store::BLOCK;
use super::voids::VOID;
use crate::base::{GeoTransform, Heights, Tile, Window};
use crate::field::{Field, LoadScratch};
use crate::raster::{Geodesy, GeodesyError, Ways};

/// Columns that are transformed together, from a multiple of it on: those of a block.
const RUN: i64 = BLOCK as i64;

/// How much farther than a box around a block's places is large the raster has to be from it to be passed by, in samples: ways
/// that PROJ chooses by place are not so far apart.
const ASIDE: f64 = 64.0;

/// Samples of the raster that are read at a time for a block of the grid.
pub(super) const MOST_OF_BLOCK: usize = 1 << 16;

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
    pub(super) field: Field,
    pub(super) geodesy: Geodesy,
    transform: GeoTransform,
    /// Columns in 360°, where x is the longitude.
    period: Option<f64>,
    /// Whether voids are told from what lies outside of the raster.
    marks_voids: bool,
}

impl Area {
    /// The first sample of the block that its first sample is in: blocks begin at whole multiples of their size.
    pub(super) fn first_block(&self) -> (i64, i64) {
        let down = |at: i64| at.div_euclid(BLOCK as i64) * BLOCK as i64;
        (down(self.column), down(self.row))
    }
}

impl Source {
    pub(super) fn new(field: Field, geodesy: Geodesy, marks_voids: bool) -> Source {
        let transform = field.geo_transform();
        let [_, dx, turn, _, other_turn, _] = transform.coefficients();
        let is_upright = turn == 0.0 && other_turn == 0.0;
        let period = (geodesy.is_geographic && is_upright).then(|| 360.0 / dx.abs());
        Source { field, geodesy, transform, period, marks_voids }
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

    /// Ellipsoidal heights at the places, columns and rows of the raster, in runs of [`RUN`]; NaN where there is none, [`VOID`] in
    /// voids, if those are marked.
    fn heights(&self, scratch: &mut Scratch) -> Result<Vec<f64>, PyramidError> {
        let Scratch { ways, places, tile, load, .. } = scratch;
        let mut heights = vec![f64::NAN; places.len()];
        let (width, height) = (self.field.width(), self.field.height());
        for place in places.iter_mut() {
            // NaN where there is no place.
            *place = (on_samples(place.0, width), on_samples(place.1, height));
            if place.0.is_nan() || place.1.is_nan() {
                *place = (f64::NAN, f64::NAN);
            }
        }
        self.on_raster(places, &mut heights, (tile, load))?;
        self.to_ellipsoidal(ways, places, &mut heights);
        if self.marks_voids {
            let on_raster = heights.iter_mut().zip(&*places).filter(|(_, place)| !place.0.is_nan());
            on_raster.filter(|(height, _)| height.is_nan()).for_each(|(height, _)| *height = VOID);
        }
        Ok(heights)
    }

    /// The raster's heights at places of it. Where they lie far apart, as beside the antimeridian, no more of it is read at a time
    /// than [`MOST_OF_BLOCK`] samples.
    fn on_raster(
        &self,
        places: &[(f64, f64)],
        heights: &mut [f64],
        (tile, load): (&mut Tile, &mut LoadScratch),
    ) -> Result<(), PyramidError> {
        let [mut left, mut top, mut right, mut bottom] = [f64::INFINITY, f64::INFINITY, 0.0, 0.0];
        for place in places.iter().filter(|place| !place.0.is_nan()) {
            (left, right) = (left.min(place.0), right.max(place.0));
            (top, bottom) = (top.min(place.1), bottom.max(place.1));
        }
        if left > right {
            return Ok(());
        }
        let window = Window {
            column: left as usize,
            row: top as usize,
            width: right.ceil() as usize + 1 - left as usize,
            height: bottom.ceil() as usize + 1 - top as usize,
        };
        if window.len() > MOST_OF_BLOCK && places.len() > 1 {
            let half = places.len() / 2;
            let (first, last) = heights.split_at_mut(half);
            self.on_raster(&places[..half], first, (&mut *tile, &mut *load))?;
            return self.on_raster(&places[half..], last, (tile, load));
        }
        self.field.load_unwatched(window, tile, load)?;
        let from_window = |&(column, row): &(f64, f64)| (column - window.column as f64, row - window.row as f64);
        let found = heights.iter_mut().zip(places.iter().map(from_window)).filter(|(_, place)| !place.0.is_nan());
        let size = (window.width, window.height);
        match (&tile.heights, tile.validity.is_whole()) {
            (Heights::F32(all), true) => found.for_each(|(height, place)| *height = between(all, size, place)),
            (Heights::F64(all), true) => found.for_each(|(height, place)| *height = between(all, size, place)),
            (_, false) => found.for_each(|(height, place)| *height = bilinear(tile, place.0, place.1)),
        }
        Ok(())
    }

    /// Heights of the raster become ellipsoidal.
    fn to_ellipsoidal(&self, ways: &Ways, places: &[(f64, f64)], heights: &mut [f64]) {
        if !ways.has_datum() {
            ways.to_ellipsoidal(&mut [], &mut [], heights);
            heights.iter_mut().filter(|height| !height.is_finite()).for_each(|height| *height = f64::NAN);
            return;
        }
        for (places, heights) in places.chunks(RUN as usize).zip(heights.chunks_mut(RUN as usize)) {
            let known: Vec<usize> = (0..heights.len()).filter(|&i| !heights[i].is_nan()).collect();
            let place = |&i: &usize| self.transform.place(places[i].0, places[i].1);
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
    /// parallel, where a cell of the grid is short, too. Around a pole that is no measure: a raster that has no other ground is
    /// measured in the plane there.
    fn spacing(&self, ways: &Ways) -> Option<f64> {
        let (width, height) = (self.field.width() as f64, self.field.height() as f64);
        let (mut least, mut least_around) = (f64::INFINITY, f64::INFINITY);
        for (i, j) in (0..5).flat_map(|i| (0..5).map(move |j| (i, j))) {
            let (column, row) = ((width - 2.0) * f64::from(i) / 4.0, (height - 2.0) * f64::from(j) / 4.0);
            let at = [(column, row), (column + 1.0, row), (column, row + 1.0)].map(|(c, r)| self.transform.place(c, r));
            let (mut x, mut y) = (at.map(|p| p.0), at.map(|p| p.1));
            ways.to_geographic(&mut x, &mut y);
            if x.iter().chain(&y).any(|v| !v.is_finite()) {
                continue;
            }
            if y[0].abs() > 89.9 {
                let plane = |i: usize| {
                    let (sin, cos) = libm::sincos(x[i].to_radians());
                    ((90.0 - y[i].abs()) * cos, (90.0 - y[i].abs()) * sin)
                };
                let ((u, v), beside) = (plane(0), [plane(1), plane(2)]);
                least_around = beside.iter().fold(least_around, |least, p| least.min(libm::hypot(p.0 - u, p.1 - v)));
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
        [least, least_around].into_iter().find(|found| found.is_finite())
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

/// A place along an axis of `samples` samples, if it is on or between them; else NaN.
fn on_samples(at: f64, samples: usize) -> f64 {
    let last = (samples - 1) as f64;
    if (-ROUNDING..=last + ROUNDING).contains(&at) { at.clamp(0.0, last) } else { f64::NAN }
}

/// The bilinear surface where no sample is missing.
fn between<T: Copy + Into<f64>>(heights: &[T], (width, height): (usize, usize), (column, row): (f64, f64)) -> f64 {
    // They are not below 0.
    let (left, top) = (column as usize, row as usize);
    let (right_share, lower_share) = (column - left as f64, row - top as f64);
    let (right, bottom) = ((left + 1).min(width - 1), (top + 1).min(height - 1));
    let at = |c: usize, r: usize, share: f64| share * heights[r * width + c].into();
    let (upper_share, left_share) = (1.0 - lower_share, 1.0 - right_share);
    let upper = at(left, top, left_share * upper_share) + at(right, top, right_share * upper_share);
    let lower = at(left, bottom, left_share * lower_share) + at(right, bottom, right_share * lower_share);
    upper + lower
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

/// What a thread keeps from block to block.
pub(super) struct Scratch {
    ways: Ways,
    /// The longitudes of a block's columns.
    longitudes: Vec<f64>,
    x: Vec<f64>,
    y: Vec<f64>,
    /// Columns and rows of the raster.
    places: Vec<(f64, f64)>,
    tile: Tile,
    load: LoadScratch,
}

impl Source {
    pub(super) fn scratch(&self) -> Result<Scratch, PyramidError> {
        let ways = self.geodesy.ways().map_err(|e| self.failed(e))?;
        let [longitudes, x, y] = [const { Vec::new() }; 3];
        let (tile, load) = (Tile::default(), LoadScratch::default());
        Ok(Scratch { ways, longitudes, x, y, places: Vec::new(), tile, load })
    }

    /// Fills the heights of a block of the grid, given its first sample, where it is of the area; says whether there are any.
    pub(super) fn fill(
        &self,
        grid: Grid,
        area: Area,
        scratch: &mut Scratch,
        (column, row): (i64, i64),
        heights: &mut [f64],
    ) -> Result<bool, PyramidError> {
        let clipped = |first: i64, from: i64, count: usize| {
            let local = |at: i64| (at - first).clamp(0, BLOCK as i64) as usize;
            local(from)..local(from + count as i64)
        };
        let rows = clipped(row, area.row, area.height);
        let columns = clipped(column, area.column, area.width);
        scratch.longitudes.clear();
        scratch.longitudes.extend((column..column + RUN).map(|c| grid.longitude(c)));
        if self.is_beside(grid, scratch, row, &rows) {
            return Ok(false);
        }
        scratch.places.clear();
        for r in rows.clone() {
            self.places(grid.latitude(row + r as i64), scratch);
        }
        let found = self.heights(scratch)?;
        let mut is_filled = false;
        for (r, found) in rows.zip(found.chunks(RUN as usize)) {
            let found = &found[columns.clone()];
            heights[r * BLOCK..][columns.clone()].copy_from_slice(found);
            is_filled |= !found.iter().all(|height| height.is_nan());
        }
        Ok(is_filled)
    }

    /// Adds the places on the raster of a row of a block.
    fn places(&self, latitude: f64, scratch: &mut Scratch) {
        let Scratch { ways, longitudes, x, y, places, .. } = scratch;
        x.clone_from(longitudes);
        y.clear();
        y.resize(x.len(), latitude);
        self.columns_and_rows(ways, x, y);
        places.extend(x.iter().copied().zip(y.iter().copied()));
    }

    /// Whether a block has nothing of the raster, as far as some of its rows tell: those lie farther off than a box around
    /// them is wide and high. Between the rows, a third of the block apart, no map strays as far as that.
    fn is_beside(&self, grid: Grid, scratch: &mut Scratch, row: i64, rows: &Range<usize>) -> bool {
        let Some(last) = rows.len().checked_sub(1) else { return true };
        scratch.places.clear();
        for share in 0..4 {
            self.places(grid.latitude(row + (rows.start + last * share / 3) as i64), scratch);
        }
        let [mut left, mut top, mut right, mut bottom] =
            [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
        for &(column, row) in &scratch.places {
            if !(column.is_finite() && row.is_finite()) {
                return false;
            }
            (left, right) = (left.min(column), right.max(column));
            (top, bottom) = (top.min(row), bottom.max(row));
        }
        let (across, down) = (right - left + ASIDE, bottom - top + ASIDE);
        let (width, height) = (self.field.width() as f64, self.field.height() as f64);
        left - across > width || right + across < 0.0 || top - down > height || bottom + down < 0.0
    }
}
