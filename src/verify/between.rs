//! Rows of samples, and points of the surface between them: where edges cross rows and columns, and vertices that stand on no
//! sample.

use super::edge::Edge;
use super::grid::STEPS;
use super::limit::{Beyond, Mean};
use super::plane::{Plane, U};
use super::samples::{Samples, flag};
use super::strays::Held;
use super::walk::{Crossed, Walk};

/// What samples a point of the surface is between.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Site {
    pub(super) kind: Kind,
    /// Of the two or four samples the first column, and the last row.
    pub(super) column: i64,
    pub(super) row: i64,
}

/// As a bit of a mark.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// In the column, between the row above and the row.
    Column = 1,
    /// In the cell between the column and the next, the row above and the row.
    Cell = 2,
    /// In the row, between the column and the next.
    Row = 4,
}

impl Site {
    /// The first and the last of the samples, column and row.
    pub(super) fn ends(self) -> [(i64, i64); 2] {
        let Site { kind, column, row } = self;
        match kind {
            Kind::Column => [(column, row - 1), (column, row)],
            Kind::Cell => [(column, row - 1), (column + 1, row)],
            Kind::Row => [(column, row), (column + 1, row)],
        }
    }

    /// The cells that it is in or between, by column and row of their first samples.
    fn cells(self) -> impl Iterator<Item = (i64, i64)> {
        let Site { kind, column, row } = self;
        let other = match kind {
            Kind::Column => (column - 1, row - 1),
            Kind::Cell => (column, row - 1),
            Kind::Row => (column, row),
        };
        [(column, row - 1), other].into_iter()
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
pub(super) struct Worst {
    pub(super) beyond: Beyond,
    pub(super) weight: Option<f64>,
    pub(super) site: Site,
    /// Column and row, with fractions.
    pub(super) place: (f64, f64),
    pub(super) surface: f64,
    pub(super) range: [f64; 2],
}

/// Rows of samples, the row above them where there is one.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sheet<'s> {
    pub(super) width: usize,
    /// The first row, and the first one after.
    pub(super) rows: (i64, i64),
    pub(super) above: Option<Samples<'s>>,
    pub(super) samples: Samples<'s>,
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
    pub(super) fn part(&self, first: usize, count: usize) -> Sheet<'s> {
        let top = self.rows.0 + first as i64;
        let samples = self.samples.part(first * self.width..(first + count) * self.width);
        Sheet { rows: (top, top + count as i64), above: self.row(top - 1), samples, ..*self }
    }
}

/// Some rows that one thread works on.
pub(super) struct Rows<'b> {
    pub(super) sheet: Sheet<'b>,
    pub(super) held: Held<'b>,
    pub(super) marks: &'b mut [u8],
    pub(super) worst: &'b mut [Option<Worst>],
}

impl Rows<'_> {
    /// Holds a face against them.
    pub(super) fn compare(&mut self, plane: &Plane) {
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
                None if self.held.trims => Edge::new(q, p).expect("it begins at one of its ends"),
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
                let surely_within = (self.held.limit.most - slack) * (1.0 - 4.0 * U);
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
        let is_settled = self.held.limit.most >= SMALLEST_LIMIT || weight.is_none();
        if seems_beyond <= -point.slack || is_settled && most <= self.held.limit.most && most < before {
            return;
        }
        let Some(beyond) = self.held.limit.judge(&point.mean, range, weight) else { return };
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
    /// needs two heights, a cell three. Where a sample is bridged, or may be bare, nothing is asked, nor beside lines and in lakes.
    fn range(&self, site: Site) -> Option<([f64; 2], Option<f64>)> {
        let [(left, above), (right, below)] = site.ends();
        if self.held.unbound.is_some_and(|unbound| site.cells().any(|(column, row)| unbound.has(column, row))) {
            return None;
        }
        let (mut range, mut weight) = ([f64::INFINITY, f64::NEG_INFINITY], None::<f64>);
        let (mut missing, mut is_exempt) = (0, false);
        for row in above..=below {
            let samples = self.sheet.row(row)?;
            for at in left as usize..=right as usize {
                let height = samples.heights[at];
                is_exempt |= samples.flags(at) & (flag::BRIDGED | flag::NEAR) != 0 || samples.is_widened(at);
                if height.is_nan() {
                    missing += 1;
                    continue;
                }
                range = [range[0].min(height), range[1].max(height)];
                if let Some(weights) = samples.weights {
                    weight = Some(weight.map_or(weights[at], |weight| weight.min(weights[at])));
                }
            }
        }
        let may_miss = if site.kind == Kind::Cell { 1 } else { 0 };
        (missing <= may_miss && !is_exempt).then_some((range, weight))
    }
}
