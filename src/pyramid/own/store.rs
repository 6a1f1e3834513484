//! The raster's own samples in a file, by blocks of the finest grid.
//!
//! The raster is read by windows. Each has room for its samples at a place of its own in the file, where they lie block by block; what
//! it does not need stays a hole. Behind them is a list of the runs of samples of a block, and how many runs there are. So the
//! bytes do not depend on the order in which windows are read.

use std::fs::File;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::ROUNDING;
use crate::base::control::{Control, Stage};
use crate::base::faults::{self, Point};
use crate::base::{Tile, Window};
use crate::field::{FieldError, LoadScratch};
use crate::pyramid::error::PyramidError;
use crate::pyramid::grid::Grid;
use crate::pyramid::prepare::Prepared;
use crate::pyramid::samples::{Block, Patch, Samples};
use crate::pyramid::source::Source;
use crate::raster::Ways;

/// Samples of the raster that are read at a time, across and down.
pub(in crate::pyramid) const WINDOW: usize = 512;

/// Cells of the grid along a block: sides of tiles have to read what is beside their lines.
const BLOCK: usize = 32;

/// Columns that are transformed together, from a multiple of it on: PROJ may choose among several ways by the mean of places.
const RUN: usize = 64;

/// Longitude, latitude, height.
type Record = [f64; 3];

/// The row and column of the block that a record is of, and the record.
type InBlock = ((u64, u64), Record);

/// Block row, block column, first record, records.
type Run = [u64; 4];

/// A sample of the raster.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::pyramid) struct OwnSample {
    /// In cells of the grid, from the corner that was asked for.
    pub(in crate::pyramid) column: f64,
    pub(in crate::pyramid) row: f64,
    /// In degrees.
    pub(in crate::pyramid) lon: f64,
    pub(in crate::pyramid) lat: f64,
    /// Above the ellipsoid, in metres.
    pub(in crate::pyramid) height: f64,
}

/// A rectangle of the grid, in cells from 180° W and 90° N; both ends count.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::pyramid) struct Rectangle {
    pub(in crate::pyramid) columns: (f64, f64),
    pub(in crate::pyramid) rows: (f64, f64),
}

/// The raster's own samples.
pub(crate) struct OwnStore {
    grid: Grid,
    file: File,
    folder: PathBuf,
    /// In the order of blocks.
    runs: Vec<Run>,
}

/// One thread's means.
#[derive(Default)]
struct Scratch {
    ways: Option<Ways>,
    tile: Tile,
    load: LoadScratch,
    block: Block,
}

impl OwnStore {
    /// Writes the samples of a raster that count to a file, which is in a folder.
    pub(in crate::pyramid) fn make(
        prepared: &Prepared,
        samples: &Samples,
        (file, folder): (File, &Path),
        control: &Control<'_>,
    ) -> Result<OwnStore, PyramidError> {
        // Threads share the source, not the dataset.
        let (source, path) = (&prepared.source, prepared.raster.path());
        let field = &source.field;
        let (width, height) = (field.width(), field.height());
        let corners = (0..height).step_by(WINDOW).flat_map(|row| (0..width).step_by(WINDOW).map(move |c| (c, row)));
        let windows: Vec<Window> = corners
            .map(|(column, row)| {
                let (width, height) = (WINDOW.min(width - column), WINDOW.min(height - row));
                Window { column, row, width, height }
            })
            .collect();
        let mut store = OwnStore { grid: samples.grid, file, folder: folder.to_path_buf(), runs: Vec::new() };
        control.progress.begin(Stage::Decode, windows.len() as u64, (width * height) as u64);
        let one = |scratch: &mut Scratch, (number, &window): (usize, &Window)| {
            control.cancel.check()?;
            faults::reach(Point::DecodeUnit);
            let first = number as u64 * (WINDOW * WINDOW) as u64;
            let runs = store.write((source, path), samples, window, first, scratch)?;
            control.progress.step(Stage::Decode, (window.width * window.height) as u64);
            Ok(runs)
        };
        let runs: Result<Vec<Vec<Run>>, PyramidError> =
            windows.par_iter().enumerate().map_init(Scratch::default, one).collect();
        control.progress.end(Stage::Decode);
        store.runs = runs?.concat();
        store.runs.sort_unstable();
        let mut list: Vec<u8> = bytemuck::cast_slice(&store.runs).to_vec();
        list.extend((store.runs.len() as u64).to_ne_bytes());
        store.file.write_all_at(&list, store.bytes()).map_err(|e| store.failed(e))?;
        Ok(store)
    }

    /// One that was made, in a file with a name. `None` where it is not whole.
    pub(in crate::pyramid) fn open(
        grid: Grid,
        (file, folder): (File, &Path),
    ) -> Result<Option<OwnStore>, PyramidError> {
        let mut store = OwnStore { grid, file, folder: folder.to_path_buf(), runs: Vec::new() };
        let length = store.file.metadata().map_err(|e| store.failed(e))?.len();
        let Some(end) = length.checked_sub(size_of::<u64>() as u64) else { return Ok(None) };
        let mut count = [0; size_of::<u64>()];
        store.file.read_exact_at(&mut count, end).map_err(|e| store.failed(e))?;
        let count = u64::from_ne_bytes(count);
        let Some(first) = count.checked_mul(size_of::<Run>() as u64).and_then(|bytes| end.checked_sub(bytes)) else {
            return Ok(None);
        };
        store.runs.resize(count as usize, Run::default());
        let list = bytemuck::cast_slice_mut(&mut store.runs);
        store
            .file
            .read_exact_at(list, first)
            .map_err(|source| PyramidError::File { path: folder.to_path_buf(), source })?;
        Ok((store.bytes() == first).then_some(store))
    }

    /// What samples take, up to the list of runs.
    pub(in crate::pyramid) fn bytes(&self) -> u64 {
        let end = |run: &Run| run[2].saturating_add(run[3]).saturating_mul(size_of::<Record>() as u64);
        self.runs.iter().map(end).max().unwrap_or(0)
    }

    fn failed(&self, source: std::io::Error) -> PyramidError {
        FieldError::Temporary { dir: self.folder.clone(), bytes: self.bytes(), source }.into()
    }

    /// Writes the samples of a window of the raster, from a place in the file on, and says which blocks they are of.
    fn write(
        &self,
        (source, path): (&Source, &Path),
        samples: &Samples,
        window: Window,
        first: u64,
        scratch: &mut Scratch,
    ) -> Result<Vec<Run>, PyramidError> {
        let mut found = self.places((source, path), window, scratch)?;
        found.sort_by_key(|(block, _)| *block);
        let (mut runs, mut records) = (Vec::new(), Vec::new());
        for of_block in found.chunk_by(|a, b| a.0 == b.0) {
            let before = records.len();
            self.inside(samples, of_block, &mut scratch.block, &mut records)?;
            let ((row, column), count) = (of_block[0].0, records.len() - before);
            if count > 0 {
                runs.push([row, column, first + before as u64, count as u64]);
            }
        }
        let at = first * size_of::<Record>() as u64;
        self.file.write_all_at(bytemuck::cast_slice(&records), at).map_err(|e| self.failed(e))?;
        Ok(runs)
    }

    /// Columns and rows of the grid.
    fn on_grid(&self, [lon, lat, _]: Record) -> (f64, f64) {
        ((lon + 180.0) / self.grid.cell(), (90.0 - lat) / self.grid.cell())
    }

    /// The samples of a window that have a height and a place, and the row and column of the block that each is of.
    fn places(
        &self,
        (source, path): (&Source, &Path),
        window: Window,
        scratch: &mut Scratch,
    ) -> Result<Vec<InBlock>, PyramidError> {
        let Scratch { ways, tile, load, .. } = scratch;
        source.field.load_with(window, tile, load)?;
        let ways = match ways {
            Some(ways) => &*ways,
            None => {
                let failed = |source| PyramidError::Geodesy { path: path.to_path_buf(), source };
                ways.insert(source.geodesy.ways().map_err(failed)?)
            }
        };
        let transform = source.field.geo_transform();
        let mut found = Vec::with_capacity(window.width * window.height);
        for row in 0..window.height {
            for start in (0..window.width).step_by(RUN) {
                let is_valid = |&column: &usize| tile.validity().is_valid(column as i32, row as i32);
                let run: Vec<usize> = (start..(start + RUN).min(window.width)).filter(is_valid).collect();
                let on_map = |&c: &usize| transform.place((window.column + c) as f64, (window.row + row) as f64);
                let (mut x, mut y): (Vec<f64>, Vec<f64>) = run.iter().map(on_map).unzip();
                let mut heights: Vec<f64> = run.iter().map(|&column| tile.at(column, row)).collect();
                ways.to_ellipsoidal(&mut x.clone(), &mut y.clone(), &mut heights);
                ways.to_geographic(&mut x, &mut y);
                for ((lon, lat), height) in x.into_iter().zip(y).zip(heights) {
                    if lon.is_finite() && lat.abs() <= 90.0 && height.is_finite() {
                        let record = [(lon + 180.0).rem_euclid(360.0) - 180.0, lat, height];
                        let (column, row) = self.on_grid(record);
                        let block = |at: f64| (at.max(0.0) / BLOCK as f64) as u64;
                        found.push(((block(row), block(column)), record));
                    }
                }
            }
        }
        Ok(found)
    }

    /// Adds those samples of a block that have samples of the grid all around.
    fn inside(
        &self,
        samples: &Samples,
        of_block: &[InBlock],
        block: &mut Block,
        records: &mut Vec<Record>,
    ) -> Result<(), PyramidError> {
        let places: Vec<(f64, f64)> = of_block.iter().map(|(_, record)| self.on_grid(*record)).collect();
        let ends = |of: &dyn Fn(&(f64, f64)) -> f64| {
            let (low, high) =
                places.iter().map(of).fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), at| (l.min(at), h.max(at)));
            // One beyond each, as places are rounded.
            (low.floor() as i64 - 1, (high - low) as usize + 5)
        };
        let ((column, width), (row, height)) = (ends(&|place| place.0), ends(&|place| place.1));
        samples.read(Patch { column, row, width, height, step: 1 }, block)?;
        let on = |at: f64, first: i64| {
            let from = |at: f64| (at as i64 - first) as usize;
            from((at + ROUNDING).floor())..=from((at - ROUNDING).ceil())
        };
        let is_inside = |&(c, r): &(f64, f64)| on(r, row).all(|r| on(c, column).all(|c| block.inside[r * width + c]));
        let kept = of_block.iter().zip(&places).filter(|(_, place)| is_inside(place));
        records.extend(kept.map(|((_, record), _)| *record));
        Ok(())
    }

    /// Reads the samples in a rectangle that is not wider than the grid; columns beyond its last begin anew. Their order is that of blocks.
    pub(in crate::pyramid) fn read(
        &self,
        rectangle: Rectangle,
        found: &mut Vec<OwnSample>,
    ) -> Result<(), PyramidError> {
        found.clear();
        let around = self.grid.columns() as f64;
        let Rectangle { columns, rows } = rectangle;
        let mut records: Vec<Record> = Vec::new();
        for turn in [-1.0, 0.0, 1.0] {
            let columns = (columns.0 - turn * around, columns.1 - turn * around);
            if columns.1 < 0.0 || columns.0 > around {
                continue;
            }
            let block = |at: f64| (at.max(0.0) / BLOCK as f64) as u64;
            let (left, right) = (block(columns.0), block(columns.1));
            let mut next = self.runs.partition_point(|run| run[0] < block(rows.0));
            while let Some(run) = self.runs.get(next).filter(|run| run[0] <= block(rows.1)) {
                let row = run[0];
                let of_row = &self.runs[next..];
                let of_row = &of_row[..of_row.partition_point(|run| run[0] == row)];
                next += of_row.len();
                let first = of_row.partition_point(|run| run[1] < left);
                let of_row = &of_row[first..];
                let of_row = &of_row[..of_row.partition_point(|run| run[1] <= right)];
                // Runs that follow one another in the file are read together.
                for runs in of_row.chunk_by(|a, b| a[2] + a[3] == b[2]) {
                    records.resize(runs.iter().map(|run| run[3] as usize).sum(), Record::default());
                    let at = runs[0][2] * size_of::<Record>() as u64;
                    let bytes = bytemuck::cast_slice_mut(&mut records);
                    self.file.read_exact_at(bytes, at).map_err(|e| self.failed(e))?;
                    for &record in &records {
                        let (column, row) = self.on_grid(record);
                        let is_in = |at: f64, ends: (f64, f64)| (ends.0..=ends.1).contains(&at);
                        if is_in(column, columns) && is_in(row, rows) {
                            let [lon, lat, height] = record;
                            found.push(OwnSample { column: column + turn * around, row, lon, lat, height });
                        }
                    }
                }
            }
        }
        Ok(())
    }
}
