//! Where the surface strays from the heights of the samples around it, between samples.
//!
//! A *side* is the segment between two neighbouring samples of a row or a column that both have a height. Along a side the
//! surface is linear but where edges of the mesh cross it, and at vertices on it: these are judged, each against the two heights.
//! A vertex inside a cell is judged against those of its corners. What is at samples is judged elsewhere.

use rayon::prelude::*;

use super::band::TASKS;
use super::between::{Kind, Rows, Sheet, Site, Worst};
use super::finding::{Finding, SidePlace};
use super::grid::Grid;
use super::limit::StrayLimit;
use super::lines::Unbound;
use super::plane::Plane;
use super::samples::Samples;
use super::stray_verdict::{StrayVerdict, WorstStray};

/// What has been found out about straying.
#[derive(Debug, Default)]
pub(super) struct StrayFindings {
    /// Sides and cells with points beyond the limit.
    pub(super) beyond: Finding<SidePlace>,
    pub(super) worst: Option<WorstStray>,
    /// What counts of the worst.
    counted: f64,
}

impl StrayFindings {
    /// Under this limit.
    pub(super) fn verdict(self, limit: &StrayLimit) -> StrayVerdict {
        StrayVerdict { max_stray: limit.factor, limit: limit.most, beyond: self.beyond, worst: self.worst }
    }
}

/// What the surface between samples is held to.
#[derive(Debug, Clone, Copy)]
pub(super) struct Held<'l> {
    pub(super) limit: StrayLimit,
    /// Whether edges of one face need not run along sides and diagonals of cells.
    pub(super) trims: bool,
    /// The cells where it is held to nothing, where there are lines.
    pub(super) unbound: Option<&'l Unbound>,
}

/// Some rows of samples, and where the surface strays from them: sides in these rows, and what is between each and the row
/// above it.
///
/// Memory use: a byte for each sample, and some 100 for each row.
pub(super) struct Strays<'s> {
    grid: Grid,
    held: Held<'s>,
    sheet: Sheet<'s>,
    marks: Vec<u8>,
    worst: Vec<Option<Worst>>,
}

impl<'s> Strays<'s> {
    /// Of the rows from `first_row` on. `above` is the row above them, where there is one.
    pub(super) fn new(
        grid: Grid,
        held: Held<'s>,
        first_row: i64,
        above: Option<Samples<'s>>,
        samples: Samples<'s>,
    ) -> Self {
        let width = grid.width as usize;
        let rows = samples.heights.len() / width;
        let sheet = Sheet { width, rows: (first_row, first_row + rows as i64), above, samples };
        Strays { grid, held, sheet, marks: vec![0; samples.heights.len()], worst: vec![None; rows] }
    }

    /// Holds a batch of faces against the rows.
    pub(super) fn compare(&mut self, planes: &[Plane]) {
        let (sheet, held, width) = (self.sheet, self.held, self.sheet.width);
        let rows = self.worst.len().div_ceil(TASKS * rayon::current_num_threads());
        let tasks = self.worst.par_chunks_mut(rows).zip(self.marks.par_chunks_mut(rows * width));
        tasks.enumerate().for_each(|(task, (worst, marks))| {
            let sheet = sheet.part(task * rows, worst.len());
            let mut rows = Rows { sheet, held, marks, worst };
            planes.iter().for_each(|plane| rows.compare(plane));
        });
    }

    /// Adds what has been found about the rows, once all their faces have passed.
    pub(super) fn add_to(&self, found: &mut StrayFindings) {
        let lines = (self.sheet.rows.0..).zip(self.marks.chunks(self.sheet.width)).zip(&self.worst);
        for ((row, marks), worst) in lines {
            for (column, mark) in (0..).zip(marks).filter(|(_, mark)| **mark != 0) {
                let kinds = [Kind::Column, Kind::Cell, Kind::Row].into_iter();
                for kind in kinds.filter(|kind| mark & *kind as u8 != 0) {
                    found.beyond.add(|| self.side(Site { kind, column, row }));
                }
            }
            if let Some(worst) = worst
                && worst.beyond.counted > found.counted
            {
                found.counted = worst.beyond.counted;
                found.worst = Some(self.worst(worst));
            }
        }
    }

    fn side(&self, site: Site) -> SidePlace {
        let [from, to] = site.ends().map(|(column, row)| self.grid.sample(column, row));
        SidePlace { from, to }
    }

    fn worst(&self, worst: &Worst) -> WorstStray {
        let (column, row) = worst.place;
        let (x, y) = self.grid.transform.place(column, row);
        let tolerance = self.held.limit.tolerance;
        WorstStray {
            stray: worst.beyond.by,
            weight: worst.weight,
            tolerances: (tolerance > 0.0).then_some(worst.beyond.counted / tolerance),
            column,
            row,
            x,
            y,
            side: self.side(worst.site),
            surface_height: worst.surface,
            raster_heights: worst.range,
        }
    }
}
