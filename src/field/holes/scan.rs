//! What a window has of missing samples, as runs.

use super::{Beside, Run};
use crate::base::Validity;
use crate::base::Window;
use crate::field::load::Missing;
use crate::field::{Field, FieldError};

/// What a window has to tell of holes.
pub(super) struct Scan {
    pub(super) window: Window,
    /// Missing samples, by rows.
    runs: Vec<Run>,
    /// Heights that may lie beside a hole, by rows: those next to a missing sample of the window, and all at its border,
    /// where the missing one may lie in the next window.
    beside: Vec<Beside>,
}

/// Memory that is used again from window to window.
#[derive(Default)]
pub(super) struct Scratch {
    values: Vec<f64>,
    stored: Vec<u64>,
    validity: Validity,
    is_near: Vec<bool>,
}

impl Scan {
    pub(super) fn of(field: &Field, window: Window, scratch: &mut Scratch) -> Result<Scan, FieldError> {
        let Scratch { values, stored, validity, is_near } = scratch;
        validity.reset(window, (field.width, field.height));
        field.load_values(window, values, stored, Missing::MarkedWithin(validity))?;
        let mut scan = Scan { window, runs: Vec::new(), beside: Vec::new() };
        // Of the runs, where those of a row begin.
        let mut starts = vec![0];
        for row in 0..window.height {
            scan.find_runs(validity.row(row), row);
            starts.push(scan.runs.len());
        }
        let column = |c: u32| c as usize - window.column;
        for row in 0..window.height {
            let own = starts[row]..starts[row + 1];
            let around = starts[row.saturating_sub(1)]..starts[(row + 2).min(window.height)];
            let is_border = row == 0 || row + 1 == window.height;
            if around.is_empty() && !is_border {
                scan.add_height(values, (0, row));
                if window.width > 1 {
                    scan.add_height(values, (window.width - 1, row));
                }
                continue;
            }
            is_near.clear();
            is_near.resize(window.width, is_border);
            (is_near[0], is_near[window.width - 1]) = (true, true);
            for &(_, first, last) in &scan.runs[around] {
                is_near[column(first)..=column(last)].fill(true);
            }
            for &(_, first, last) in &scan.runs[own.clone()] {
                is_near[column(first).saturating_sub(1)] = true;
                is_near[(column(last) + 1).min(window.width - 1)] = true;
            }
            for &(_, first, last) in &scan.runs[own] {
                is_near[column(first)..=column(last)].fill(false);
            }
            is_near.iter().enumerate().filter(|(_, n)| **n).for_each(|(c, _)| scan.add_height(values, (c, row)));
        }
        Ok(scan)
    }

    /// Adds the runs of missing samples of a row; its flags are none where nothing is missing.
    fn find_runs(&mut self, is_valid: &[bool], row: usize) {
        let mut end = 0;
        for run in is_valid.chunk_by(|a, b| a == b) {
            let first = end;
            end += run.len();
            if !run[0] {
                let column = |c: usize| (self.window.column + c) as u32;
                self.runs.push(((self.window.row + row) as u32, column(first), column(end - 1)));
            }
        }
    }

    fn add_height(&mut self, values: &[f64], (column, row): (usize, usize)) {
        let height = values[row * self.window.width + column];
        self.beside.push(((self.window.row + row) as u32, (self.window.column + column) as u32, height));
    }

    /// The memory it takes.
    pub(super) fn bytes(&self) -> u64 {
        (self.runs.capacity() * 12 + self.beside.capacity() * 16) as u64
    }
}

/// The rows of windows that lie side by side, put together one after the other.
pub(super) struct Rows<'a> {
    /// What is left of the windows' runs and heights.
    left: Vec<(&'a [Run], &'a [Beside])>,
    next: usize,
    end: usize,
    runs: Vec<(u32, u32)>,
    beside: Vec<(u32, f64)>,
}

impl<'a> Rows<'a> {
    pub(super) fn new(band: &'a [Scan]) -> Rows<'a> {
        let window = band[0].window;
        let left = band.iter().map(|scan| (scan.runs.as_slice(), scan.beside.as_slice())).collect();
        Rows { left, next: window.row, end: window.row + window.height, runs: Vec::new(), beside: Vec::new() }
    }

    /// Goes on to the next row, if there is one, and tells its number.
    pub(super) fn next_row(&mut self) -> Option<usize> {
        let row = self.next;
        if row == self.end {
            return None;
        }
        self.next += 1;
        self.runs.clear();
        self.beside.clear();
        for (runs, beside) in &mut self.left {
            let ours = runs.partition_point(|run| run.0 as usize <= row);
            for &(_, first, last) in &runs[..ours] {
                match self.runs.last_mut() {
                    Some(before) if before.1 + 1 == first => before.1 = last,
                    _ => self.runs.push((first, last)),
                }
            }
            *runs = &runs[ours..];
            let ours = beside.partition_point(|sample| sample.0 as usize <= row);
            self.beside.extend(beside[..ours].iter().map(|&(_, column, height)| (column, height)));
            *beside = &beside[ours..];
        }
        Some(row)
    }

    /// The row's missing samples: first and last columns, ascending, never one run right behind another.
    pub(super) fn runs(&self) -> &[(u32, u32)] {
        &self.runs
    }

    /// Heights of the row that may lie beside a missing sample, by columns.
    pub(super) fn beside(&self) -> &[(u32, f64)] {
        &self.beside
    }
}
