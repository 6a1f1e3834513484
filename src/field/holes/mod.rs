//! Small holes of a raster, bridged: ground where there are no samples.
//!
//! A *hole* is a group of samples without a height, connected over sides and corners, as large as it can be, none of which
//! lies in the first or last row or column. Those up to a given number of samples are *bridged*: their samples count as there
//! when it is told what ground is, so the mesh goes on over them, but no tolerance binds the surface to them. They stand at
//! heights of their own (`heights`), for the vertices that must stand somewhere: at corners of tiles, and where sides bend.
//!
//! In comes a [`Field`], read once from top to bottom, windows of a band in parallel (`scan`); row by row `components` joins
//! runs of missing samples; what is complete goes to `store`, from where a window finds its bridged samples. All of it is a
//! function of the samples and the number alone.
//!
//! Memory: what is missing in a band of windows and the samples beside it, and of holes that are not complete yet, that
//! touch no edge and are not too large so far, 12 bytes a run and 16 a sample beside them, twice that as lists grow.
//! [`HoleOptions::memory_bytes`] limits it. What is kept is on disk, but for 60 bytes per block of 512 × 512 samples with
//! bridged ones.

mod components;
mod heights;
mod scan;
mod store;

#[cfg(test)]
mod tests;

use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;

use self::components::{Components, Hole};
use self::heights::bridge;
use self::scan::{Rows, Scan};
use self::store::Records;
use super::decode::windows_of;
use super::{Field, FieldError};
use crate::base::control::{Control, Stage};
use crate::base::stored::{Sieve, Stored};
use crate::base::{Band, Window, with_sample_type};

/// Which holes are bridged, and what that may take.
#[derive(Debug, Clone)]
pub struct HoleOptions {
    /// The most samples of a hole that is bridged; 0 bridges none.
    pub most: u64,
    /// The most memory that finding them takes beyond what a window takes per thread.
    pub memory_bytes: u64,
    /// The folder of the temporary file of heights.
    pub temp_dir: PathBuf,
}

impl HoleOptions {
    /// Whether so many bytes may be in use, at a row.
    fn has_room(&self, field: &Field, row: usize, bytes: u64) -> Result<(), FieldError> {
        let budget_bytes = self.memory_bytes;
        let too_large = || FieldError::HolesTooLarge { path: field.name.clone(), row, budget_bytes };
        if bytes <= budget_bytes { Ok(()) } else { Err(too_large()) }
    }
}

/// The holes of a field that are bridged.
#[derive(Debug)]
pub struct Holes {
    records: Records,
    count: u64,
    samples: u64,
}

/// Samples without a height, as many in a row as there are: row, first and last column.
type Run = (u32, u32, u32);

/// A height that may lie beside a hole: row, column, height.
type Beside = (u32, u32, f64);

/// A sample of a bridged hole: its place in the field, and the height that stands for it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bridged {
    pub(super) column: u32,
    pub(super) row: u32,
    pub(super) height: f64,
}

impl Bridged {
    /// Its place among the samples of a window, by rows.
    pub(super) fn place_in(&self, window: Window) -> Option<usize> {
        let column = (self.column as usize).checked_sub(window.column).filter(|c| *c < window.width)?;
        let row = (self.row as usize).checked_sub(window.row).filter(|r| *r < window.height)?;
        Some(row * window.width + column)
    }
}

impl Holes {
    /// How many holes.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// How many samples they have together.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// The size of the temporary file.
    pub(super) fn bytes(&self) -> u64 {
        self.records.bytes()
    }

    /// Adds the bridged samples of a window, in no order.
    pub(super) fn within(&self, window: Window, found: &mut Vec<Bridged>) -> Result<(), FieldError> {
        self.records.within(window, found)
    }

    /// Finds them in a field that is read by these windows: rows of windows of one height, from top to bottom, each from
    /// left to right.
    fn find(
        field: &Field,
        windows: &[Window],
        options: &HoleOptions,
        control: &Control<'_>,
    ) -> Result<Holes, FieldError> {
        control.progress.begin(Stage::Holes, windows.len() as u64, field.width as u64 * field.height as u64);
        let mut finder = Finder {
            components: Components::new(field.width, field.height, options.most),
            holes: Holes { records: Records::new(&options.temp_dir), count: 0, samples: 0 },
            is_single: field.sample_type.fits_f32() && field.scaling.is_none(),
            options,
        };
        let mut rest = windows;
        while !rest.is_empty() {
            let (together, later) = rest.split_at(whole_bands(rest, rayon::current_num_threads()));
            let held = AtomicU64::new(0);
            let scans = together.par_iter().map_init(Default::default, |scratch, &window| {
                control.cancel.check()?;
                let scan = Scan::of(field, window, scratch)?;
                let held = held.fetch_add(scan.bytes(), Ordering::Relaxed) + scan.bytes();
                options.has_room(field, window.row, held)?;
                control.progress.step(Stage::Holes, window.len() as u64);
                Ok::<Scan, FieldError>(scan)
            });
            let scans = scans.collect::<Result<Vec<Scan>, FieldError>>()?;
            let held = held.into_inner();
            for band in scans.chunk_by(|a, b| a.window.row == b.window.row) {
                let mut rows = Rows::new(band);
                while let Some(row) = rows.next_row() {
                    finder.take(field, row, rows.runs(), rows.beside(), held)?;
                }
            }
            rest = later;
        }
        control.progress.end(Stage::Holes);
        Ok(finder.holes)
    }
}

/// How many windows make whole bands of them, at least `wanted` if there are as many.
fn whole_bands(windows: &[Window], wanted: usize) -> usize {
    let ends = |&end: &usize| end == windows.len() || windows[end].row != windows[end - 1].row;
    (wanted.min(windows.len())..=windows.len()).find(ends).unwrap_or(windows.len())
}

struct Finder<'a> {
    components: Components,
    holes: Holes,
    /// Whether heights are to be those of single precision.
    is_single: bool,
    options: &'a HoleOptions,
}

/// What scanning a window takes per sample, generously: the value, as it is stored and as a double.
const BYTES_PER_SCANNED: usize = 16;

/// What the heights of a hole take per sample while they are found and written.
const BYTES_PER_SAMPLE: u64 = 80;

impl Finder<'_> {
    fn take(
        &mut self,
        field: &Field,
        row: usize,
        runs: &[(u32, u32)],
        beside: &[(u32, f64)],
        held: u64,
    ) -> Result<(), FieldError> {
        let Finder { components, holes, is_single, options } = self;
        components.row(runs, beside, |hole: Hole| {
            options.has_room(field, row, held + hole.samples * BYTES_PER_SAMPLE)?;
            holes.count += 1;
            holes.samples += hole.samples;
            holes.records.put(&hole, &bridge(&hole, *is_single))
        })?;
        options.has_room(field, row, held + components.bytes() + holes.records.head_bytes())
    }
}

impl Field {
    /// The same field with its holes of at most [`HoleOptions::most`] samples bridged: tiles have their samples as ground,
    /// at heights of their own, and weights of 0 there. Reads the samples once; where none can be missing, not at all.
    ///
    /// # Errors
    /// [`FieldError`], [`FieldError::HolesTooLarge`] among them.
    ///
    /// # Panics
    /// If the field has channels: they have no values in holes.
    pub fn with_holes_bridged(self, options: &HoleOptions, control: &Control<'_>) -> Result<Field, FieldError> {
        let windows = windows_of((self.width, self.height), self.block, BYTES_PER_SCANNED);
        self.bridged_by(&windows, options, control)
    }

    /// The same, read by these windows.
    fn bridged_by(self, windows: &[Window], options: &HoleOptions, control: &Control<'_>) -> Result<Field, FieldError> {
        assert!(self.channels.is_none(), "bridged holes beside channels");
        if options.most == 0 || !self.may_have_gaps() {
            return Ok(self);
        }
        let holes = Holes::find(&self, windows, options, control)?;
        Ok(Field { holes: (holes.count > 0).then_some(holes), ..self })
    }

    /// What is bridged of it.
    pub fn holes(&self) -> Option<&Holes> {
        self.holes.as_ref()
    }
}

/// Whether samples of a band may be without a height, so that it may have holes.
pub fn may_have_holes(band: &Band) -> bool {
    let by_value = with_sample_type!(band.sample_type(), T => {
        T::HAS_NAN || !Sieve::<T>::new(band.marks(), band.scaling()).is_empty()
    });
    by_value || band.cutline().is_some() || band.has_mask()
}
