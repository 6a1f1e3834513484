//! Where the surface strays from the heights of the samples around it, between samples.
//!
//! A *side* is the segment between two neighbouring samples of a row or a column that both have a height. Along a side the
//! surface is linear but where edges of the mesh cross it, and at vertices on it: these are judged, each against the two heights.
//! A vertex inside a cell is judged against those of its corners. What is at samples is judged elsewhere.

use rayon::prelude::*;

use super::band::TASKS;
use super::edge::Edge;
use super::finding::{Finding, SidePlace};
use super::grid::{Grid, STEPS};
use super::limit::{Beyond, Mean, StrayLimit};
use super::plane::{Plane, U};
use super::samples::{Samples, flag};
use super::verdict::WorstStray;
use super::walk::{Crossed, Walk};

/// What samples a point of the surface is between.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Site {
    kind: Kind,
    /// Of the two or four samples the first column, and the last row.
    column: i64,
    row: i64,
}

/// As a bit of a mark.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// In the column, between the row above and the row.
    Column = 1,
    /// In the cell between the column and the next, the row above and the row.
    Cell = 2,
    /// In the row, between the column and the next.
    Row = 4,
}

impl Site {
    /// The first and the last of the samples, column and row.
    fn ends(self) -> [(i64, i64); 2] {
        let Site { kind, column, row } = self;
        match kind {
            Kind::Column => [(column, row - 1), (column, row)],
            Kind::Cell => [(column, row - 1), (column + 1, row)],
            Kind::Row => [(column, row), (column + 1, row)],
        }
    }
}

/// A point of the surface that may be beyond the limit.
struct Point<'e> {
    edge: &'e Edge,
    mean: Mean,
    /// The surface's height, and by how much it may be off.
    surface: f64,
    slack: f64,
}

/// The point of a row that strays most, so far.
#[derive(Debug, Clone, Copy)]
struct Worst {
    beyond: Beyond,
    weight: Option<f64>,
    site: Site,
    /// Column and row, with fractions.
    place: (f64, f64),
    surface: f64,
    range: [f64; 2],
}

/// What has been found out about straying.
#[derive(Debug, Default)]
pub(super) struct StrayFindings {
    /// Sides and cells with points beyond the limit.
    pub(super) beyond: Finding<SidePlace>,
    pub(super) worst: Option<WorstStray>,
    /// What counts of the worst.
    counted: f64,
}

/// Some rows of samples, and where the surface strays from them: sides in these rows, and what is between each and the row
/// above it.
///
/// Memory use: a byte for each sample, and 120 for each row.
pub(super) struct Strays<'s> {
    grid: Grid,
    limit: StrayLimit,
    /// Whether edges of one face need not run along sides and diagonals of cells.
    trims: bool,
    sheet: Sheet<'s>,
    marks: Vec<u8>,
    worst: Vec<Option<Worst>>,
}

/// Rows of samples, the row above them where there is one.
#[derive(Debug, Clone, Copy)]
struct Sheet<'s> {
    width: usize,
    /// The first row, and the first one after.
    rows: (i64, i64),
    above: Option<Samples<'s>>,
    samples: Samples<'s>,
}

impl<'s> Sheet<'s> {
    fn row(&self, row: i64) -> Option<Samples<'s>> {
        if row < self.rows.0 {
            return self.above;
        }
        let first = (row - self.rows.0) as usize * self.width;
        Some(self.samples.part(first..first + self.width))
    }

    fn heights(&self, row: i64) -> Option<&'s [f64]> {
        if row < self.rows.0 {
            return self.above.map(|above| above.heights);
        }
        let first = (row - self.rows.0) as usize * self.width;
        Some(&self.samples.heights[first..first + self.width])
    }

    /// Some of the rows, counted from the first.
    fn part(&self, first: usize, count: usize) -> Sheet<'s> {
        let top = self.rows.0 + first as i64;
        let samples = self.samples.part(first * self.width..(first + count) * self.width);
        Sheet { rows: (top, top + count as i64), above: self.row(top - 1), samples, ..*self }
    }
}

impl<'s> Strays<'s> {
    /// Of the rows from `first_row` on. `above` is the row above them, where there is one.
    pub(super) fn new(
        grid: Grid,
        (limit, trims): (StrayLimit, bool),
        first_row: i64,
        above: Option<Samples<'s>>,
        samples: Samples<'s>,
    ) -> Self {
        let width = grid.width as usize;
        let rows = samples.heights.len() / width;
        let sheet = Sheet { width, rows: (first_row, first_row + rows as i64), above, samples };
        Strays { grid, limit, trims, sheet, marks: vec![0; samples.heights.len()], worst: vec![None; rows] }
    }

    /// Holds a batch of faces against the rows.
    pub(super) fn compare(&mut self, planes: &[Plane]) {
        let (sheet, limit, trims, width) = (self.sheet, self.limit, self.trims, self.sheet.width);
        let rows = self.worst.len().div_ceil(TASKS * rayon::current_num_threads());
        let tasks = self.worst.par_chunks_mut(rows).zip(self.marks.par_chunks_mut(rows * width));
        tasks.enumerate().for_each(|(task, (worst, marks))| {
            let sheet = sheet.part(task * rows, worst.len());
            let mut rows = Rows { sheet, limit, trims, marks, worst };
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
        let tolerance = self.limit.tolerance;
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

/// Some rows that one thread works on.
struct Rows<'b> {
    sheet: Sheet<'b>,
    limit: StrayLimit,
    trims: bool,
    marks: &'b mut [u8],
    worst: &'b mut [Option<Worst>],
}

impl Rows<'_> {
    fn compare(&mut self, plane: &Plane) {
        let (corners, heights) = (plane.triangle.corners, plane.triangle.heights);
        let ys = corners.map(|corner| corner.1);
        let (low, high) = (ys[0].min(ys[1]).min(ys[2]), ys[0].max(ys[1]).max(ys[2]));
        let (first, after) = self.sheet.rows;
        if high <= STEPS * (first - 1) || low > STEPS * (after - 1) {
            return;
        }
        for (i, j) in [(0, 1), (1, 2), (2, 0)] {
            let (p, q) = ((corners[i], heights[i]), (corners[j], heights[j]));
            // Faces have their corners in one order. An edge of two faces is passed down by one of them, and up by the other.
            let edge = match Edge::new(p, q) {
                Some(edge) => edge,
                None if self.trims => Edge::new(q, p).expect("it begins at one of its ends"),
                None => continue,
            };
            if edge.is_finite() {
                self.cross(&edge);
            }
        }
        let between = |(x, y): (i64, i64)| (x | y) & (STEPS - 1) != 0;
        for (corner, height) in corners.into_iter().zip(heights).filter(|(corner, z)| between(*corner) && z.is_finite())
        {
            self.stand(corner, height);
        }
    }

    /// Judges where an edge crosses rows and columns.
    fn cross(&mut self, edge: &Edge) {
        let (upper, width) = (edge.upper, self.sheet.width as i64);
        for Crossed { row, columns: (first, last), in_row } in Walk::new(upper, edge.lower, self.sheet.rows) {
            let Some(here) = self.sheet.heights(row) else { continue };
            let quiet = self.quiet(row, edge.slack);
            let is_quiet = |surface: f64, a: f64, b: f64| {
                let (low, high) = if a < b { (a, b) } else { (b, a) };
                let above = surface - high;
                let below = low - surface;
                (if above > below { above } else { below }) <= quiet
            };
            if let Some(column) = in_row.filter(|column| (0..width - 1).contains(column)) {
                let (surface, at) = (edge.at_row(row), column as usize);
                if !is_quiet(surface, here[at], here[at + 1]) {
                    let point = Point { edge, mean: edge.mean_at_row(row), surface, slack: edge.slack };
                    self.judge(Site { kind: Kind::Row, column, row }, &point);
                }
            }
            let (first, last) = (first.max(0), last.min(width - 1));
            if first > last {
                continue;
            }
            let Some(above) = self.sheet.heights(row - 1) else { continue };
            for column in first..=last {
                let (surface, at) = (edge.at_column(column), column as usize);
                if !is_quiet(surface, above[at], here[at]) {
                    let point = Point { edge, mean: edge.mean_at_column(column), surface, slack: edge.slack };
                    self.judge(Site { kind: Kind::Column, column, row }, &point);
                }
            }
        }
    }

    /// Judges a vertex that stands on no sample.
    fn stand(&mut self, place: (i64, i64), height: f64) {
        let (column, line) = (place.0.div_euclid(STEPS), place.1.div_euclid(STEPS));
        let site = match (place.0.rem_euclid(STEPS), place.1.rem_euclid(STEPS)) {
            (_, 0) => Site { kind: Kind::Row, column, row: line },
            (0, _) => Site { kind: Kind::Column, column, row: line + 1 },
            _ => Site { kind: Kind::Cell, column, row: line + 1 },
        };
        let (first, after) = self.sheet.rows;
        let [(left, above), (right, _)] = site.ends();
        let above_is_there = above >= first || above + 1 == first && self.sheet.above.is_some();
        if left >= 0 && right < self.sheet.width as i64 && (first..after).contains(&site.row) && above_is_there {
            let edge = Edge::of_vertex(place, height);
            let point = Point { edge: &edge, mean: edge.mean_at_upper(), surface: height, slack: 0.0 };
            self.judge(site, &point);
        }
    }

    /// A point of a row whose surface seems to be beyond the range by this or less is neither beyond the limit nor the worst of its
    /// row. `slack` is by how much it may be off.
    fn quiet(&self, row: i64, slack: f64) -> f64 {
        let worst = self.worst[(row - self.sheet.rows.0) as usize].as_ref();
        match worst {
            None => -slack,
            // Weights are not known here.
            Some(_) if self.sheet.samples.weights.is_some() => -slack,
            Some(worst) => {
                let surely_within = (self.limit.most - slack) * (1.0 - 4.0 * U);
                surely_within.min((worst.beyond.counted - slack).next_down())
            }
        }
    }

    /// Judges a point between samples.
    #[cold]
    fn judge(&mut self, site: Site, point: &Point<'_>) {
        let Some((range, weight)) = self.range(site) else { return };
        let seems_beyond = (point.surface - range[1]).max(range[0] - point.surface);
        let worst = &mut self.worst[(site.row - self.sheet.rows.0) as usize];
        let before = worst.as_ref().map_or(0.0, |worst| worst.beyond.counted);
        let most = (seems_beyond + point.slack) * weight.unwrap_or(1.0) * (1.0 + 32.0 * U);
        // Products may underflow where limits are near the smallest numbers.
        const SMALLEST_LIMIT: f64 = 1e-200;
        let is_settled = self.limit.most >= SMALLEST_LIMIT || weight.is_none();
        if seems_beyond <= -point.slack || is_settled && most <= self.limit.most && most < before {
            return;
        }
        let Some(beyond) = self.limit.judge(&point.mean, range, weight) else { return };
        if !beyond.within {
            let at = (site.row - self.sheet.rows.0) as usize * self.sheet.width + site.column as usize;
            self.marks[at] |= site.kind as u8;
        }
        let (column, row) = point.edge.place(&point.mean);
        let place = match site.kind {
            Kind::Row => (column, site.row as f64),
            Kind::Column => (site.column as f64, row),
            Kind::Cell => (column, row),
        };
        let in_order = |(column, row): (f64, f64)| (row, column);
        let beats = |worst: &Worst| {
            beyond.counted > before || beyond.counted == before && in_order(place) < in_order(worst.place)
        };
        if worst.as_ref().map_or(beyond.counted > 0.0, beats) {
            *worst = Some(Worst { beyond, weight, site, place, surface: point.surface, range });
        }
    }

    /// The least and the largest of the heights around a point, and the least weight there; `None` where it is not judged: a side
    /// needs two heights, a cell three. Where a sample is bridged nothing is asked.
    fn range(&self, site: Site) -> Option<([f64; 2], Option<f64>)> {
        let [(left, above), (right, below)] = site.ends();
        let (mut range, mut weight) = ([f64::INFINITY, f64::NEG_INFINITY], None::<f64>);
        let (mut missing, mut is_bridged) = (0, false);
        for row in above..=below {
            let samples = self.sheet.row(row)?;
            for at in left as usize..=right as usize {
                let height = samples.heights[at];
                if height.is_nan() {
                    missing += 1;
                    is_bridged |= samples.flags(at) & flag::BRIDGED != 0;
                    continue;
                }
                range = [range[0].min(height), range[1].max(height)];
                if let Some(weights) = samples.weights {
                    weight = Some(weight.map_or(weights[at], |weight| weight.min(weights[at])));
                }
            }
        }
        let may_miss = if site.kind == Kind::Cell { 1 } else { 0 };
        (missing <= may_miss && !is_bridged).then_some((range, weight))
    }
}
