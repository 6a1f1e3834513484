//! Scan conversion of a triangle for its candidate: the sample that is farthest from it.
//!
//! The error of a sample is |S|/A with S = w_b·(z_b − z_a) + w_c·(z_c − z_a) − A·(h − z_a), the weights orientations and
//! A their sum. S is carried from sample to sample by one addition (the incremental plane of section 4.3) in doubles,
//! where integer heights make it exact: then samples that tie, tie, in every triangle that sees them, and the fixed rule
//! (the first by row and column) decides alike in every algorithm. Other heights are off by a bound ([`DOUBT`]); where
//! it leaves the tolerance open, exact arithmetic answers.

use super::search::Search;
use crate::base::Tile;
use crate::base::lattice::{Point, STEPS, orient};
use crate::base::mesh::Vertex;
use crate::kernel::triangulate::feasible::{Plane, Spans, Surfaces, coarse_doubles};

/// A sample that may become a vertex.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Candidate {
    /// How much it is wanted: its error, or what another measure makes of it.
    pub(super) score: f64,
    /// Row · width + column.
    pub(super) sample: u64,
}

/// Finds candidates over one tile.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scanner<'a> {
    pub(super) tile: &'a Tile,
    pub(super) tolerance: f64,
}

/// A bound of the rounding error of |S|/A, as a share of (reach of the plane above a corner + tolerance): S has fewer
/// than twelve roundings, each of a number at most twice A·(reach + tolerance) near a tie; farther from it the error
/// grows more slowly than the distance.
pub(super) const DOUBT: f64 = 64.0 / (1u64 << 53) as f64;

/// What is closer to a weighted limit than this share of it is looked at exactly.
const CLOSE: f64 = 1.0 / (1u64 << 40) as f64;

/// The farthest sample of a triangle, and what is known of its distance.
#[derive(Debug, Clone, Copy)]
pub(super) struct Farthest {
    pub(super) error: f64,
    pub(super) sample: u64,
}

impl Scanner<'_> {
    /// The candidate of a triangle with positive orientation: of the samples of the closed triangle that are farther
    /// than the tolerance, the farthest; of equal ones the first.
    ///
    /// Samples on `locked` edges do not count.
    pub(super) fn candidate(&self, corners: [Vertex; 3], locked: [bool; 3]) -> Option<Candidate> {
        let scan = Scan::of(self.tile, corners).without(locked);
        if self.tile.is_weighted() || self.tile.channel_error.is_some() {
            return self.scored_candidate(&scan, corners);
        }
        let search = Search { scan: &scan, tile: self.tile, tolerance: self.tolerance };
        self.settle(&scan, corners, pulp::Arch::new().dispatch(search))
    }

    /// The candidate of a triangle whose farthest sample, up to rounding, is known.
    #[inline(always)]
    pub(super) fn settle(&self, scan: &Scan, [a, b, c]: [Vertex; 3], best: Farthest) -> Option<Candidate> {
        let doubt = scan.doubt(self.tolerance);
        if best.error > self.tolerance + doubt {
            return Some(Candidate { score: best.error, sample: best.sample });
        }
        if best.error < self.tolerance - doubt {
            return None;
        }
        self.candidate_in_doubt(Plane::new(a, b, c), scan, doubt)
    }

    /// The same where errors have weights: what is wanted most is the largest product of both (section 6). Or where there
    /// are channels: then it is the largest weighted error (section 4.6).
    fn scored_candidate(&self, scan: &Scan, corners: [Vertex; 3]) -> Option<Candidate> {
        let mut best: Option<Candidate> = None;
        self.each_beyond(scan, corners, |candidate| {
            if best.is_none_or(|b| candidate.score > b.score) {
                best = Some(candidate);
            }
        });
        best
    }

    /// Visits all samples of a closed triangle that are beyond the tolerance, exactly, or whose weighted error is beyond
    /// its limit ([`crate::base::channels::ChannelError::limit`]) where there are channels. Scores are errors: times their
    /// weights where there are any, and weighted errors where there are channels.
    pub(super) fn each_beyond(&self, scan: &Scan, [a, b, c]: [Vertex; 3], mut visit: impl FnMut(Candidate)) {
        let plane = Plane::new(a, b, c);
        // Most samples are far below their limits, and are told so without a division: a limit is tolerance ÷ weight but for
        // its rounding, which the share covers, as it does the limit's part in the doubt. Nothing may underflow there.
        let (settled, rounding) = (self.tolerance * (1.0 - CLOSE), DOUBT * scan.reach() + coarse_doubles(scan.reach()));
        let settles = self.tile.channel_error.is_none() && settled > f64::MIN_POSITIVE / CLOSE;
        let limit_in_channels = self.tile.channel_error.as_ref().map_or(f64::INFINITY, |e| e.limit(self.tolerance));
        for row in scan.spans.rows() {
            let (first, last) = scan.columns(row);
            for column in first..=last {
                let height = self.tile.at(column as usize, row as usize);
                let error = scan.error(column, row, height);
                let weight = self.tile.weight(column as usize, row as usize);
                if settles && (error + rounding) * weight < settled {
                    continue;
                }
                let counted = scan.counted(self.tile, column, row, height);
                let limit = self.tile.limit(column as usize, row as usize, self.tolerance);
                let doubt = scan.doubt(limit);
                let beyond = error > limit + doubt
                    || counted > limit_in_channels && !scan.has_corner(column, row)
                    || error >= limit - doubt && !plane.within(Point::of_sample(column, row), height, limit);
                if beyond {
                    let score = counted * weight;
                    visit(Candidate { score, sample: row as u64 * self.tile.width as u64 + column as u64 });
                }
            }
        }
    }

    /// The farthest sample of a triangle that is neither a corner nor on one of its locked edges.
    pub(super) fn farthest_inside(&self, corners: [Vertex; 3], locked: [bool; 3]) -> Option<u64> {
        let scan = Scan::new(self.tile.width, corners).without(locked);
        let mut best: Option<Farthest> = None;
        for row in scan.spans.rows() {
            let (first, last) = scan.columns(row);
            for column in first..=last {
                let p = Point::of_sample(column, row);
                let error = scan.error(column, row, self.tile.at(column as usize, row as usize));
                let taken = corners.iter().any(|v| v.at == p);
                if !taken && best.is_none_or(|b| error > b.error) {
                    best = Some(Farthest { error, sample: row as u64 * self.tile.width as u64 + column as u64 });
                }
            }
        }
        best.map(|b| b.sample)
    }

    /// The same where the farthest is near the tolerance: sample by sample, exactly.
    #[cold]
    #[inline(never)]
    fn candidate_in_doubt(&self, plane: Plane, scan: &Scan, doubt: f64) -> Option<Candidate> {
        let mut best: Option<Candidate> = None;
        for row in scan.spans.rows() {
            let (first, last) = scan.columns(row);
            for column in first..=last {
                let height = self.tile.at(column as usize, row as usize);
                let error = scan.error(column, row, height);
                if error < self.tolerance - doubt || best.is_some_and(|b| b.score >= error) {
                    continue;
                }
                if !plane.within(Point::of_sample(column, row), height, self.tolerance) {
                    let sample = row as u64 * self.tile.width as u64 + column as u64;
                    best = Some(Candidate { score: error, sample });
                }
            }
        }
        best
    }
}

/// Apart from [`Scan::counted`], where it would cost tiles without channels a few percent.
#[inline(never)]
fn weighted(surfaces: &Surfaces, tile: &Tile, column: i32, row: i32) -> f64 {
    let error = tile.channel_error.as_ref().expect("surfaces of channels");
    surfaces.weighted(tile, error, (column as usize, row as usize)).min(f64::MAX)
}

/// A triangle, ready to be held against samples.
pub(super) struct Scan {
    pub(super) spans: Spans,
    width: usize,
    corners: [Vertex; 3],
    /// Heights of b and c above a.
    rise: [f64; 2],
    area: f64,
    /// Edges whose samples do not count.
    locked: [bool; 3],
    /// What S grows by from one sample of a row to the next, apart from the sample itself.
    step: f64,
    /// Where there are channels.
    surfaces: Option<Box<Surfaces>>,
}

impl Scan {
    /// Of a tile's heights, and of its channels where it has some.
    pub(super) fn of(tile: &Tile, corners: [Vertex; 3]) -> Scan {
        let mut scan = Scan::new(tile.width, corners);
        if tile.channel_error.is_some() {
            let mut surfaces = Box::<Surfaces>::default();
            surfaces.set(tile, corners);
            scan.surfaces = Some(surfaces);
        }
        scan
    }

    /// Of heights alone.
    pub(super) fn new(width: usize, corners: [Vertex; 3]) -> Scan {
        let [a, b, c] = corners;
        let rise = [b.height - a.height, c.height - a.height];
        let area = orient(a.at, b.at, c.at) as f64;
        let cell = f64::from(STEPS);
        let step = cell * f64::from(c.at.y - a.at.y) * rise[0] + cell * f64::from(a.at.y - b.at.y) * rise[1];
        Scan {
            spans: Spans::new(a.at, b.at, c.at),
            width,
            corners,
            rise,
            area,
            locked: [false; 3],
            step,
            surfaces: None,
        }
    }

    /// The same without the samples on edges that are locked: edge i runs from corner i to the next.
    pub(super) fn without(self, locked: [bool; 3]) -> Scan {
        Scan { locked, ..self }
    }

    /// The samples that count of a row.
    #[inline(always)]
    pub(super) fn columns(&self, row: i32) -> (i32, i32) {
        let (first, last) = self.spans.columns(row);
        if self.locked == [false; 3] { (first, last) } else { self.trimmed(row, first, last) }
    }

    fn trimmed(&self, row: i32, mut first: i32, mut last: i32) -> (i32, i32) {
        let ends = |i: usize| (self.corners[i].at, self.corners[(i + 1) % 3].at);
        let on_locked = |column: i32| {
            let p = Point::of_sample(column, row);
            let on = |i: usize| orient(ends(i).0, ends(i).1, p) == 0;
            (0..3).any(|i| self.locked[i] && on(i))
        };
        // All of the row is on a level edge, else at most one sample at either end is on an edge.
        while first <= last && on_locked(first) {
            first += 1;
        }
        while first <= last && on_locked(last) {
            last -= 1;
        }
        (first, last)
    }

    /// Whether a corner is at this sample. (Its error is 0; but limits may be less.)
    fn has_corner(&self, column: i32, row: i32) -> bool {
        self.corners.iter().any(|v| v.at == Point::of_sample(column, row))
    }

    pub(super) fn width(&self) -> usize {
        self.width
    }

    /// The largest distance of the plane from corner a within the triangle.
    pub(super) fn reach(&self) -> f64 {
        self.rise[0].abs().max(self.rise[1].abs())
    }

    /// How close to a limit an error may be wrong about it.
    #[inline(always)]
    pub(super) fn doubt(&self, limit: f64) -> f64 {
        DOUBT * (self.reach() + limit) + coarse_doubles(self.reach())
    }

    /// The height of corner a.
    #[inline(always)]
    pub(super) fn base(&self) -> f64 {
        self.corners[0].height
    }

    #[inline(always)]
    pub(super) fn area(&self) -> f64 {
        self.area
    }

    #[inline(always)]
    pub(super) fn step(&self) -> f64 {
        self.step
    }

    /// A times the height of the plane above corner a, at a sample.
    #[inline(always)]
    pub(super) fn start(&self, column: i32, row: i32) -> f64 {
        let [a, b, c] = self.corners.map(|v| v.at);
        let p = Point::of_sample(column, row);
        orient(c, a, p) as f64 * self.rise[0] + orient(a, b, p) as f64 * self.rise[1]
    }

    /// What the error at one sample counts: the weighted error where there are channels. Neither is ever no number.
    #[inline(always)]
    pub(super) fn counted(&self, tile: &Tile, column: i32, row: i32, height: f64) -> f64 {
        match &self.surfaces {
            None => self.error(column, row, height),
            Some(surfaces) => weighted(surfaces, tile, column, row),
        }
    }

    /// The vertical error at one sample.
    #[inline(always)]
    pub(super) fn error(&self, column: i32, row: i32, height: f64) -> f64 {
        (self.start(column, row) - self.area * (height - self.corners[0].height)).abs() / self.area
    }

    /// The sum of what the errors of the samples of the closed triangle count.
    pub(super) fn sum_of_errors(&self, tile: &Tile) -> f64 {
        let mut sum = 0.0;
        for row in self.spans.rows() {
            let (first, last) = self.spans.columns(row);
            for column in first..=last {
                sum += self.counted(tile, column, row, tile.at(column as usize, row as usize));
            }
        }
        sum
    }
}
