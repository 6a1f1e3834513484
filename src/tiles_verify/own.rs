//! How far tiles are from the samples of the raster itself, which the promise names where they count (`own_samples`), and else not:
//! it is one of the finest grid.
//!
//! Each sample's place and height are transformed by themselves, without the grid, and the tile of every level that it lies in is
//! met along the normal there. A sample counts where the grid has heights all around it: elsewhere the surface runs down to the
//! height outside. The raster is read by windows, whose samples are brought to the ellipsoid once for all levels.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use rayon::prelude::*;
use serde::Serialize;

use super::decode::Decoded;
use super::ellipsoid::{Ellipsoid, Point};
use super::facets::Facets;
use super::known::Known;
use super::own_rows::{InRows, OnEllipsoid, ROUNDING};
use super::scan::{Lattice, Limits};
use super::tile::Tile;
use super::{TilesVerifyRequest, read};
use crate::base::control::{Control, Stage};
use crate::base::{Tile as Block, Window};
use crate::field::{Field, FieldOptions, LoadScratch};
use crate::pyramid::{Grid, Patch, Promise, PyramidError, SampleBlock, Samples, TileKey};
use crate::raster::{Geodesy, Ways};

/// What the raster's own samples are like at a level.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct OwnSamples {
    /// Samples that were compared.
    pub samples: u64,
    /// The largest distance from one, in metres along the normal of the ellipsoid.
    pub largest_error: f64,
    /// Samples that are farther than the level's error.
    pub above: u64,
    /// Their share.
    pub share_above: f64,
}

impl OwnSamples {
    fn merge(&mut self, other: &OwnSamples) {
        self.samples += other.samples;
        self.largest_error = self.largest_error.max(other.largest_error);
        self.above += other.above;
        self.share_above = if self.samples == 0 { 0.0 } else { self.above as f64 / self.samples as f64 };
    }
}

/// What samples are compared with.
pub(super) struct OwnTask<'a> {
    pub(super) request: &'a TilesVerifyRequest,
    pub(super) promise: &'a Promise,
    pub(super) ellipsoid: &'a Ellipsoid,
    pub(super) grid_samples: &'a Samples,
    pub(super) tiles: &'a BTreeSet<TileKey>,
    /// Those whose triangles tile their square.
    pub(super) tiling: &'a BTreeSet<TileKey>,
    /// Of every level, the largest error that was found so far.
    pub(super) known: Vec<Known>,
}

/// Samples of the raster that are read at a time, across and down.
const WINDOW: usize = 512;

/// Samples of the grid that are read at a time: windows around which there are more, near a pole, are cut into quarters.
const PATCH: usize = 1 << 20;

/// What a window takes: of each sample what is read, its place, and to which tile it belongs, in a list that grows by doubling; and the samples
/// of the grid around.
pub(super) const BYTES_OF_WINDOW: u64 =
    (WINDOW * WINDOW * (17 + 3 * 8 + size_of::<Place>() + 2 * 8) + PATCH * 10) as u64;

/// Samples that are transformed together.
const RUN: usize = 64;

/// A sample of the raster on the ellipsoid.
struct Place {
    /// Columns and rows of the finest grid, from 180° W and 90° N.
    at: (f64, f64),
    foot: (Point, Point),
    height: f64,
}

/// One thread's means.
#[derive(Default)]
struct Scratch {
    ways: Option<Ways>,
    block: Block,
    load: LoadScratch,
    around: SampleBlock,
}

impl OwnTask<'_> {
    fn grid(&self) -> Grid {
        self.grid_samples.grid
    }

    /// Judges all samples, level by level.
    pub(super) fn judge(&self, control: &Control<'_>) -> Result<Vec<OwnSamples>, PyramidError> {
        let path = &self.request.input;
        let raster = self.request.view.open(path, &control.cancel)?;
        let wrong = |source| PyramidError::Geodesy { path: path.clone(), source };
        let geodesy = raster.geodesy(self.promise.vertical_crs_given.as_deref()).map_err(wrong)?;
        let temp_dir = self.request.temp_dir.clone().unwrap_or_else(std::env::temp_dir);
        let field = Field::open(&raster.to_band()?, &FieldOptions { temp_dir, ..FieldOptions::default() }, control)?;
        let (width, height) = (field.width(), field.height());
        let corners = (0..height).step_by(WINDOW).flat_map(|row| (0..width).step_by(WINDOW).map(move |c| (c, row)));
        let windows: Vec<Window> = corners
            .map(|(column, row)| {
                let (width, height) = (WINDOW.min(width - column), WINDOW.min(height - row));
                Window { column, row, width, height }
            })
            .collect();
        control.progress.begin(Stage::Compare, windows.len() as u64, windows.len() as u64);
        let judged: Result<Vec<Vec<OwnSamples>>, PyramidError> = windows
            .par_iter()
            .map_init(Scratch::default, |scratch, &window| {
                control.cancel.check()?;
                let mut found = vec![OwnSamples::default(); self.promise.levels.len()];
                self.window(&field, &geodesy, window, scratch, &mut found)?;
                control.progress.step(Stage::Compare, 1);
                Ok(found)
            })
            .collect();
        control.progress.end(Stage::Compare);
        let mut levels = vec![OwnSamples::default(); self.promise.levels.len()];
        for window in judged? {
            levels.iter_mut().zip(&window).for_each(|(level, found)| level.merge(found));
        }
        Ok(levels)
    }

    fn window(
        &self,
        field: &Field,
        geodesy: &Geodesy,
        window: Window,
        scratch: &mut Scratch,
        found: &mut [OwnSamples],
    ) -> Result<(), PyramidError> {
        let read = self.read(field, geodesy, window, scratch)?;
        let is_judged = match InRows::of(&read, window, self.grid_samples, self.ellipsoid) {
            Some(rows) => self.judge_rows(rows, &mut scratch.around, found)?,
            None => self.judge_scattered(self.places(&read), &mut scratch.around, found)?,
        };
        if is_judged {
            return Ok(());
        }
        let (left, top) = (window.width.div_ceil(2), window.height.div_ceil(2));
        for (column, width) in [(0, left), (left, window.width - left)] {
            for (row, height) in [(0, top), (top, window.height - top)] {
                if width > 0 && height > 0 {
                    let (column, row) = (window.column + column, window.row + row);
                    self.window(field, geodesy, Window { column, row, width, height }, scratch, found)?;
                }
            }
        }
        Ok(())
    }

    /// Judges samples in rows, where they are not too many to look at together.
    fn judge_rows(
        &self,
        mut rows: InRows,
        around: &mut SampleBlock,
        found: &mut [OwnSamples],
    ) -> Result<bool, PyramidError> {
        if !rows.keep_inside(self.grid_samples, around, PATCH)? {
            return Ok(false);
        }
        for (level, found) in (0..).zip(found) {
            // Ranges of columns and rows that are in one tile.
            let ranges = |places: &[f64], number: &dyn Fn(f64) -> u32| {
                let mut first = 0;
                let chunks = places.chunk_by(|a, b| number(*a) == number(*b));
                let range = |chunk: &[f64]| {
                    first += chunk.len();
                    (number(chunk[0]), first - chunk.len()..first)
                };
                chunks.map(range).collect::<Vec<_>>()
            };
            let across = ranges(&rows.columns, &|at| self.tile(level, (at, 0.0)).x);
            for (y, down) in ranges(&rows.rows, &|at| self.tile(level, (0.0, at)).y) {
                for (x, across) in &across {
                    let key = TileKey { level, x: *x, y };
                    if self.tiles.contains(&key) {
                        self.compare_rows(key, &rows, [across.clone(), down.clone()], found);
                    }
                }
            }
        }
        Ok(true)
    }

    /// Compares a tile with those in some columns and rows.
    fn compare_rows(&self, key: TileKey, of: &InRows, [across, down]: [Range<usize>; 2], found: &mut OwnSamples) {
        let stride = of.columns.len();
        let first = down.start * stride + across.start;
        let rows = down.clone().map(|row| &of.counts[row * stride..][across.clone()]);
        let count: usize = rows.map(|counts| counts.iter().filter(|counts| **counts).count()).sum();
        // What cannot be decoded has been found already.
        let file = self.request.tiles.join(format!("{key}.terrain"));
        let Some(decoded) = (count > 0).then(|| read(&file, self.promise.gzip).ok()).flatten() else { return };
        let tile = Tile::new(key, self.grid(), self.ellipsoid, &decoded, self.promise.void_as);
        let facets = Facets::of(&tile, self.tiling.contains(&key));
        let origin = key.origin(self.grid());
        let in_tile = |places: &[f64], origin: i64| places.iter().map(|at| at - origin as f64).collect::<Vec<_>>();
        let columns = in_tile(&of.columns[across.clone()], origin.0);
        let rows = in_tile(&of.rows[down.clone()], origin.1);
        let lattice = Lattice {
            columns: &columns,
            rows: &rows,
            meridians: &of.meridians[across.clone()],
            parallels: &of.parallels[down.clone()],
            heights: &of.heights[first..],
            stride,
            covers: &of.counts[first..],
            binds: &of.counts[first..],
        };
        let known = &self.known[key.level as usize];
        let allowed = self.promise.levels[key.level as usize].max_error;
        let mut scanned = facets.scan(&lattice, Limits { known: known.so_far(), allowed });
        let mut in_hole = 0;
        let mut around = None;
        for i in std::mem::take(&mut scanned.unmet) {
            let (column, row) = (i % stride, i / stride);
            let (at, height) = ((columns[column], rows[row]), lattice.heights[i]);
            let place = lattice.parallels[row].foot(lattice.meridians[column]);
            let near = around.get_or_insert_with(|| facets.around(&lattice));
            // Between samples of the grid there may be a hole.
            match near.error_met(at, place, height) {
                None if tile.has_holes => in_hole += 1,
                Some(error) => scanned.add(i, error, allowed),
                None => scanned.add(i, near.error(at, place, height), allowed),
            }
        }
        known.raise(scanned.largest);
        found.samples += (count - in_hole) as u64;
        found.largest_error = found.largest_error.max(scanned.largest);
        found.above += scanned.beyond.len() as u64;
    }

    /// Judges samples that lie anyhow, where they are not too many to look at together.
    fn judge_scattered(
        &self,
        mut places: Vec<Place>,
        around: &mut SampleBlock,
        found: &mut [OwnSamples],
    ) -> Result<bool, PyramidError> {
        if !self.keep_inside(&mut places, around)? {
            return Ok(false);
        }
        for (level, found) in (0..).zip(found) {
            let mut tiles: BTreeMap<TileKey, Vec<&Place>> = BTreeMap::new();
            // One after the other they are in one tile, as a rule.
            for run in places.chunk_by(|a, b| self.tile(level, a.at) == self.tile(level, b.at)) {
                tiles.entry(self.tile(level, run[0].at)).or_default().extend(run);
            }
            for (key, places) in tiles.into_iter().filter(|(key, _)| self.tiles.contains(key)) {
                // What cannot be decoded has been found already.
                let file = self.request.tiles.join(format!("{key}.terrain"));
                let Ok(decoded) = read(&file, self.promise.gzip) else { continue };
                found.merge(&self.compare(key, &decoded, &places));
            }
        }
        Ok(true)
    }

    /// The samples of a window on the ellipsoid, where they have a height and a place.
    fn read(
        &self,
        field: &Field,
        geodesy: &Geodesy,
        window: Window,
        scratch: &mut Scratch,
    ) -> Result<OnEllipsoid, PyramidError> {
        let Scratch { ways, block, load, .. } = scratch;
        field.load_with(window, block, load)?;
        let ways = match ways {
            Some(ways) => &*ways,
            None => {
                let wrong = |source| PyramidError::Geodesy { path: self.request.input.clone(), source };
                ways.insert(geodesy.ways().map_err(wrong)?)
            }
        };
        let transform = field.geo_transform();
        let none = || vec![f64::NAN; window.width * window.height];
        let mut found = OnEllipsoid { lon: none(), lat: none(), heights: none() };
        let all: Vec<(usize, usize)> = (0..window.height)
            .flat_map(|row| (0..window.width).map(move |column| (column, row)))
            .filter(|&(column, row)| block.validity().is_valid(column as i32, row as i32))
            .collect();
        for run in all.chunks(RUN) {
            let on_map = |&(column, row): &(usize, usize)| {
                transform.place((window.column + column) as f64, (window.row + row) as f64)
            };
            let (mut x, mut y): (Vec<f64>, Vec<f64>) = run.iter().map(on_map).unzip();
            let mut heights: Vec<f64> = run.iter().map(|&(column, row)| block.at(column, row)).collect();
            ways.to_ellipsoidal(&mut x.clone(), &mut y.clone(), &mut heights);
            ways.to_geographic(&mut x, &mut y);
            for ((&(column, row), height), (lon, lat)) in run.iter().zip(heights).zip(x.into_iter().zip(y)) {
                if lon.is_finite() && lat.abs() <= 90.0 && height.is_finite() {
                    let i = row * window.width + column;
                    (found.lon[i], found.lat[i], found.heights[i]) = (lon, lat, height);
                }
            }
        }
        Ok(found)
    }

    /// The samples that have a height and a place.
    fn places(&self, found: &OnEllipsoid) -> Vec<Place> {
        let cell = self.grid().cell();
        let all = found.lon.iter().zip(&found.lat).zip(&found.heights).filter(|(_, height)| !height.is_nan());
        let place = |((&lon, &lat), &height): ((&f64, &f64), &f64)| {
            let at = ((lon + 180.0).rem_euclid(360.0) / cell, (90.0 - lat) / cell);
            Place { at, foot: self.ellipsoid.foot(lon, lat), height }
        };
        all.map(place).collect()
    }

    /// Keeps the places with samples of the grid all around; `false` if those of all are too many to look at together.
    fn keep_inside(&self, places: &mut Vec<Place>, around: &mut SampleBlock) -> Result<bool, PyramidError> {
        let area = self.grid_samples.area;
        let columns = self.grid().columns() as f64;
        // From the area's first column on.
        let column = |place: &Place| (place.at.0 - area.column as f64).rem_euclid(columns);
        places.retain(|place| column(place) < area.width as f64);
        let ends = |of: &dyn Fn(&Place) -> f64| {
            places.iter().map(of).fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), at| (l.min(at), h.max(at)))
        };
        let ((west, east), (north, south)) = (ends(&column), ends(&|place| place.at.1));
        if places.is_empty() {
            return Ok(true);
        }
        let (left, top) = (west.floor() as i64, north.floor() as i64);
        let (width, height) = (east.floor() as usize + 2 - left as usize, south.floor() as usize + 2 - top as usize);
        if width * height > PATCH && places.len() > 1 {
            return Ok(false);
        }
        let patch = Patch { column: area.column + left, row: top, width, height, step: 1 };
        self.grid_samples.read(patch, around)?;
        places.retain(|place| {
            let (at, down) = (column(place) - left as f64, place.at.1 - top as f64);
            // One on a line of the grid needs no other.
            let on = |at: f64| (at + ROUNDING).floor() as usize..=(at - ROUNDING).ceil() as usize;
            on(down).all(|row| on(at).all(|column| around.inside[row * width + column]))
        });
        Ok(true)
    }

    /// The tile of a level that a place is in.
    fn tile(&self, level: u32, (column, row): (f64, f64)) -> TileKey {
        let cells = self.grid().cells(level) as f64;
        let last = (1u32 << level) - 1;
        let from_north = ((row / cells) as u32).min(last);
        TileKey { level, x: ((column / cells) as u32).min(2 * last + 1), y: last - from_north }
    }

    fn compare(&self, key: TileKey, decoded: &Decoded, places: &[&Place]) -> OwnSamples {
        let tile = Tile::new(key, self.grid(), self.ellipsoid, decoded, self.promise.void_as);
        let (column, row) = key.origin(self.grid());
        let in_tile = |place: &Place| (place.at.0 - column as f64, place.at.1 - row as f64);
        let mut window = [(f64::INFINITY, f64::NEG_INFINITY); 2];
        let with = |ends: &mut (f64, f64), at: f64| *ends = (ends.0.min(at), ends.1.max(at));
        for place in places {
            let (column, row) = in_tile(place);
            with(&mut window[0], column);
            with(&mut window[1], row);
        }
        let facets = Facets::of(&tile, false);
        let first = window.map(|ends| ends.0.floor() as i64);
        let size = [0, 1].map(|k| window[k].1.floor() as i64 + 1 - first[k]);
        let window = facets.over((first[0], first[1]), (size[0], size[1]));
        let allowed = self.promise.levels[key.level as usize].max_error;
        let mut found = OwnSamples::default();
        for place in places {
            let met = window.error_met(in_tile(place), place.foot, place.height);
            // Between samples of the grid there may be a hole.
            if tile.has_holes && met.is_none() {
                continue;
            }
            let error = met.unwrap_or_else(|| window.error(in_tile(place), place.foot, place.height));
            found.samples += 1;
            found.largest_error = found.largest_error.max(error);
            found.above += u64::from(error.is_nan() || error > allowed);
        }
        found
    }
}
