//! Whether a triangle may be used: the fast filter before the exact test.

use std::cell::Cell;
use std::ops::{Add, Mul, Sub};

use super::channels::ChannelRows;
use super::stray::{self, Side};
use super::weighted::WeightedRows;
use super::{Plane, Spans, edge};
use crate::base::channels::ChannelError;
use crate::base::lattice::{MAX_SPAN, Point};
use crate::base::mesh::Vertex;
use crate::base::{Heights, PADDING, Tile};
use crate::kernel::triangulate::Feasibility;

/// Tests candidate triangles over one tile.
#[derive(Debug, Clone, Copy)]
pub struct Tester<'a> {
    tile: &'a Tile,
    tolerance: f64,
    feasibility: Feasibility,
    max_stray: stray::Limit,
}

impl<'a> Tester<'a> {
    /// A tester for one tile; `tolerance` is at least 0. Where the tile has weights, what is within the tolerance is error
    /// × weight: every sample is held to [`Tile::limit`]. Where it has channels, triangles have their corners on samples, and
    /// the weighted error of every sample is held to [`ChannelError::limit`] as well, in doubles.
    pub fn new(tile: &'a Tile, tolerance: f64, feasibility: Feasibility) -> Tester<'a> {
        Tester { tile, tolerance, feasibility, max_stray: stray::Limit::new(f64::INFINITY, tolerance) }
    }

    /// With a limit on straying as well: [`Task::max_stray`](crate::kernel::triangulate::Task::max_stray).
    pub fn with_max_stray(self, factor: f64) -> Tester<'a> {
        Tester { max_stray: stray::Limit::new(factor, self.tolerance), ..self }
    }

    /// What is asked of a triangle.
    pub fn feasibility(&self) -> Feasibility {
        self.feasibility
    }

    /// The largest vertical distance allowed.
    pub fn tolerance(&self) -> f64 {
        self.tolerance
    }

    /// The samples.
    pub fn tile(&self) -> &'a Tile {
        self.tile
    }

    /// Whether the triangle with positive orientation may be used. The strong test is made along `new_edges` only:
    /// edges of the front have passed it, or were relaxed.
    pub fn feasible(&self, corners: [Vertex; 3], new_edges: &[(Vertex, Vertex)]) -> bool {
        self.weakly_feasible(corners)
            && (self.feasibility == Feasibility::Weak || new_edges.iter().all(|&(p, q)| self.strong_edge(p, q)))
    }

    /// Whether every sample under the closed triangle is within the tolerance of it. Exact; reads no sample twice, and
    /// rows far apart first, so that an infeasible triangle is mostly left early.
    pub fn weakly_feasible(&self, corners: [Vertex; 3]) -> bool {
        self.violation(corners).is_none()
    }

    /// The place of a sample under the closed triangle that is not within the tolerance of it: the first one that is
    /// come upon. None if the triangle is weakly feasible.
    pub fn violation(&self, [a, b, c]: [Vertex; 3]) -> Option<Point> {
        let scan = Scan {
            spans: Spans::new(a.at, b.at, c.at),
            plane: Plane::new(a, b, c),
            width: self.tile.width,
            tolerance: self.tolerance,
            violation: Cell::new(None),
        };
        // The same loops, compiled for what the processor has: wider lanes change no result.
        let arch = pulp::Arch::new();
        let (scan, weights) = (&scan, &self.tile.weights);
        let within = match &self.tile.heights {
            Heights::F32(heights) => arch.dispatch(AllRows(PlainRows::new(scan, heights, a.height))),
            Heights::F64(heights) if self.tile.is_weighted() => {
                arch.dispatch(AllRows(WeightedRows::new(scan, heights, weights, a.height)))
            }
            Heights::F64(heights) => arch.dispatch(AllRows(PlainRows::new(scan, heights, a.height))),
        };
        debug_assert_eq!(within, scan.violation.get().is_none());
        match &self.tile.channel_error {
            Some(error) if within => self.violation_in_channels(scan, error, [a, b, c]),
            _ => scan.violation.get(),
        }
    }

    /// The same of the weighted error, once heights are within the tolerance.
    #[inline(never)]
    fn violation_in_channels(&self, scan: &Scan, error: &ChannelError, corners: [Vertex; 3]) -> Option<Point> {
        let (arch, tile) = (pulp::Arch::new(), self.tile);
        match &tile.heights {
            Heights::F32(heights) => arch.dispatch(AllRows(ChannelRows::new(scan, (tile, heights), error, corners))),
            Heights::F64(heights) => arch.dispatch(AllRows(ChannelRows::new(scan, (tile, heights), error, corners))),
        };
        scan.violation.get()
    }

    /// Whether an edge that was not there before may be made: with strong feasibility if it passes the strong test, and
    /// always if it strays nowhere too far.
    pub fn may_join(&self, p: Vertex, q: Vertex) -> bool {
        // What is within the tolerance of the line between two samples is within it of their range.
        match self.feasibility {
            Feasibility::Strong => self.strong_edge(p, q),
            Feasibility::Weak => !self.strays(p, q),
        }
    }

    /// Whether an edge strays too far anywhere. Exact.
    pub fn strays(&self, p: Vertex, q: Vertex) -> bool {
        stray::any(self.tile, &self.max_stray, p, q, |_| true)
    }

    /// The sides at which an edge strays too far, exactly.
    pub fn list_strays(&self, p: Vertex, q: Vertex, into: &mut Vec<Side>) {
        into.clear();
        stray::any(self.tile, &self.max_stray, p, q, |side| {
            into.push(side);
            false
        });
    }

    /// Whether there is a limit on straying.
    pub fn limits_strays(&self) -> bool {
        !self.max_stray.is_none()
    }

    /// Whether an edge passes the strong test.
    pub fn strong_edge(&self, p: Vertex, q: Vertex) -> bool {
        edge::within(self.tile, self.tolerance, p, q)
    }

    /// The largest distance between an edge and the grid surface, between samples; times the greater weight of the two
    /// samples, where the tile has weights.
    pub fn edge_deviation(&self, p: Vertex, q: Vertex) -> f64 {
        edge::deviation(self.tile, p, q)
    }

    /// Where between samples an edge is farthest above and below the grid surface: by how much, signed and weighted like
    /// [`Tester::edge_deviation`], and the share that p has in the height of the edge there times the weight. Zeros where
    /// it is nowhere above, or nowhere below.
    pub fn edge_extremes(&self, p: Vertex, q: Vertex) -> [(f64, f64); 2] {
        edge::extremes(self.tile, p, q)
    }
}

/// A precision that rows are compared in.
pub(super) trait Real:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + PartialOrd + 'static
{
    /// A bound of a row comparison's rounding error, as a share of (reach of the plane + tolerance).
    ///
    /// With u the unit roundoff, P the reach and ε the tolerance, near a tie: the difference to the reference is off by
    /// u(P+ε), the row's first value by uP, the product of step and index (at most 2P) by 4uP with the step's own
    /// rounding, the sum by uP, the error by uε; less than 16u(P+ε) with room for the roundings of the limits. (Values
    /// in doubles before conversion are better by 2²⁹, and in the double kernel the factor is 32.) Farther from a tie
    /// the error grows more slowly than the distance to it.
    const DOUBT: f64;
    /// The smallest positive number.
    const SMALLEST: f64;
    const INDEX: [Self; LANES];
    fn of(value: f64) -> Self;
    fn to_f64(self) -> f64;
    fn magnitude(self) -> Self;
}

/// Samples compared together.
pub(super) const LANES: usize = PADDING;

impl Real for f32 {
    const DOUBT: f64 = 16.0 / (1u64 << 24) as f64;
    const SMALLEST: f64 = f32::from_bits(1) as f64;
    const INDEX: [f32; LANES] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];
    #[inline(always)]
    fn of(value: f64) -> f32 {
        value as f32
    }
    #[inline(always)]
    fn to_f64(self) -> f64 {
        f64::from(self)
    }
    #[inline(always)]
    fn magnitude(self) -> f32 {
        self.abs()
    }
}

impl Real for f64 {
    const DOUBT: f64 = 32.0 / (1u64 << 53) as f64;
    const SMALLEST: f64 = f64::from_bits(1);
    const INDEX: [f64; LANES] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];
    #[inline(always)]
    fn of(value: f64) -> f64 {
        value
    }
    #[inline(always)]
    fn to_f64(self) -> f64 {
        self
    }
    #[inline(always)]
    fn magnitude(self) -> f64 {
        self.abs()
    }
}

pub(super) struct Scan {
    pub(super) spans: Spans,
    pub(super) plane: Plane,
    pub(super) width: usize,
    pub(super) tolerance: f64,
    /// Where the scan ended, if it did before the last row.
    pub(super) violation: Cell<Option<Point>>,
}

/// A test of one row after the other. Not a closure: those are not always inlined into what is compiled for the
/// processor, and then their code is for any.
pub(super) trait Rows {
    fn scan(&self) -> &Scan;
    /// Whether the samples of a row are within the tolerance.
    fn within(&self, row: i32) -> bool;
}

struct AllRows<T>(T);

impl<T: Rows> pulp::NullaryFnOnce for AllRows<T> {
    type Output = bool;

    #[inline(always)]
    fn call(self) -> bool {
        every_row(&self.0)
    }
}

/// Rows of samples that all have the tolerance as their limit.
struct PlainRows<'a, R> {
    scan: &'a Scan,
    heights: &'a [R],
    offset: f64,
    limits: Limits<R>,
}

impl<R: Real> Rows for PlainRows<'_, R> {
    #[inline(always)]
    fn scan(&self) -> &Scan {
        self.scan
    }

    #[inline(always)]
    fn within(&self, row: i32) -> bool {
        self.scan.row(self.heights, row, self.offset, self.limits)
    }
}

impl<'a, R: Real> PlainRows<'a, R> {
    #[inline(always)]
    fn new(scan: &'a Scan, heights: &'a [R], height_of_a: f64) -> Self {
        let reference = R::of(height_of_a);
        let reach = scan.plane.reach(reference.to_f64());
        let doubt = R::DOUBT * (reach + scan.tolerance) + coarse::<R>(reach);
        let limits = Limits {
            reference,
            step: R::of(scan.plane.step()),
            sure: R::of(scan.tolerance - doubt),
            never: R::of(scan.tolerance + doubt),
        };
        PlainRows { scan, heights, offset: height_of_a - reference.to_f64(), limits }
    }
}

/// With a flat plane at the reference a comparison is exact up to the rounding of the tolerance; else, among the smallest
/// numbers there are, the step loses absolutely, times as many samples as a row can have.
pub(super) fn coarse<R: Real>(reach: f64) -> f64 {
    if reach > 0.0 { R::SMALLEST * f64::from(MAX_SPAN) } else { 0.0 }
}

/// The same for doubles.
pub(in crate::kernel::triangulate) fn coarse_doubles(reach: f64) -> f64 {
    coarse::<f64>(reach)
}

/// How close to a limit an error may be wrong about it that is computed in single precision as the tester does, with the
/// largest distance of the plane from the reference within the triangle.
pub(in crate::kernel::triangulate) fn doubt_in_singles(reach: f64, limit: f64) -> f64 {
    f32::DOUBT * (reach + limit) + coarse::<f32>(reach)
}

/// Limits of |error|: up to `sure` it is within the tolerance, beyond `never` it is not.
#[derive(Clone, Copy)]
struct Limits<R> {
    reference: R,
    step: R,
    sure: R,
    never: R,
}

impl Scan {
    /// The samples of a row, if there are some: where the first one is, its place in the tile, and how many there are.
    #[inline(always)]
    pub(super) fn samples(&self, row: i32) -> Option<(Point, usize, usize)> {
        let (first, last) = self.spans.columns(row);
        let index = || row as usize * self.width + first as usize;
        (first <= last).then(|| (Point::of_sample(first, row), index(), (last - first + 1) as usize))
    }

    #[inline(always)]
    fn row<R: Real>(&self, heights: &[R], row: i32, offset: f64, limits: Limits<R>) -> bool {
        let (first, last) = self.spans.columns(row);
        if first > last {
            return true;
        }
        let start = R::of(self.plane.above_a(Point::of_sample(first, row)) + offset);
        let index = row as usize * self.width;
        let (samples, count) = (&heights[index + first as usize..], (last - first + 1) as usize);
        surely_within(samples, count, start, limits)
            || self.row_in_doubt(&samples[..count], Point::of_sample(first, row), start, limits)
    }

    /// Sample by sample, exactly where the limits leave it open.
    #[cold]
    #[inline(never)]
    fn row_in_doubt<R: Real>(&self, samples: &[R], first: Point, start: R, limits: Limits<R>) -> bool {
        let mut at = first;
        let mut index = R::of(0.0);
        for &sample in samples {
            let error = ((sample - limits.reference) - (start + limits.step * index)).magnitude();
            // An error that is no number is no doubt either: it is never within.
            let within =
                error <= limits.sure || error <= limits.never && self.plane.within(at, sample.to_f64(), self.tolerance);
            if !within {
                self.violation.set(Some(at));
                return false;
            }
            at.x += crate::base::lattice::STEPS;
            index = index + R::of(1.0);
        }
        true
    }
}

/// Triangles of fewer rows are read from the middle row on, where most samples are; larger ones at every
/// [`STRIDE`]th row first.
const FEW_ROWS: i32 = 12;
const STRIDE: i32 = 8;
/// Which of them, counted from a triangle's first.
const FIRST_ROWS: [i32; STRIDE as usize] = [4, 0, 2, 6, 1, 3, 5, 7];

/// Whether a test holds for every row of the triangle, asked in an order in which an infeasible one soon fails. (Plain
/// loops: iterators with steps were measured to be slower.)
#[inline(always)]
fn every_row(rows: &impl Rows) -> bool {
    let spans = &rows.scan().spans;
    let (first, last) = (*spans.rows().start(), *spans.rows().end());
    if first > last {
        return true;
    }
    let few = last - first < FEW_ROWS;
    let middle = spans.middle_row().clamp(first, last);
    let step = if few { 1 } else { STRIDE };
    let runs = if few { 2 } else { STRIDE };
    let mut run = 0;
    while run < runs {
        let (mut row, end) = match (few, run) {
            (true, 0) => (middle, last),
            (true, _) => (first, middle - 1),
            (false, _) => (first + FIRST_ROWS[run as usize], last),
        };
        while row <= end {
            if !rows.within(row) {
                return false;
            }
            row += step;
        }
        run += 1;
    }
    true
}

/// The fast path: whether the first `count` samples are within the tolerance beyond doubt. Most rows are shorter than
/// the lanes, so lanes are always whole and those past the end do not count; the tile has room for it ([`PADDING`]).
/// Written so that the compiler makes vector code of it.
#[inline(always)]
fn surely_within<R: Real>(samples: &[R], count: usize, start: R, limits: Limits<R>) -> bool {
    let end = R::of(count as i32 as f64);
    let mut base = R::of(0.0);
    let mut first = 0;
    while first < count {
        let lane = &samples[first..first + LANES];
        let mut within = true;
        for (&sample, i) in lane.iter().zip(R::INDEX) {
            let index = base + i;
            let error = ((sample - limits.reference) - (start + limits.step * index)).magnitude();
            within &= (error <= limits.sure) | (index >= end);
        }
        if !within {
            return false;
        }
        base = base + R::of(LANES as f64);
        first += LANES;
    }
    true
}
