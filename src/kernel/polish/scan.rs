//! The samples of a triangle, row by row and in lanes: how far it is from them.
//!
//! [`HeightScan`] is about heights, with weights or without; `channels` has the rows where there are channels.

use super::energy::{ONSET, PULL, energies, largest};
use super::four_rows::{RowFinder, Slope};
use super::lanes::{FOUR, Kernel, LANES, Lanes};
use super::net::{Fit, NONE};
use crate::base::lattice::{Point, STEPS};
use crate::base::mesh::Vertex;
use crate::kernel::triangulate::feasible::{Plane, Spans};

pub(super) const INDEX: [f32; LANES] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];

/// Which of the lanes count, by how many samples are left of a row: factors, as branches would undo the lanes.
pub(super) const COUNTS: [[f32; LANES]; LANES + 1] = {
    let mut counts = [[0.0; LANES]; LANES + 1];
    let mut left = 0;
    while left <= LANES {
        let mut i = 0;
        while i < left {
            counts[left][i] = 1.0;
            i += 1;
        }
        left += 1;
    }
    counts
};

/// Heights as they are stored, brought to single precision relative to a corner.
pub(super) trait Sample: Copy {
    fn of(height: f64) -> Self;
    fn to_f64(self) -> f64;
    fn above(self, reference: Self) -> f32;
}

impl Sample for f32 {
    fn of(height: f64) -> f32 {
        height as f32
    }
    fn to_f64(self) -> f64 {
        f64::from(self)
    }
    #[inline(always)]
    fn above(self, reference: f32) -> f32 {
        self - reference
    }
}

impl Sample for f64 {
    fn of(height: f64) -> f64 {
        height
    }
    fn to_f64(self) -> f64 {
        self
    }
    #[inline(always)]
    fn above(self, reference: f64) -> f32 {
        (self - reference) as f32
    }
}

/// What is asked of a triangle's samples.
pub(super) struct Question {
    pub(super) corners: [Vertex; 3],
    pub(super) width: usize,
    pub(super) per_tolerance: f64,
    pub(super) limit: f32,
    /// From one row that is read to the next: a power of two.
    pub(super) stride: i32,
}

impl Question {
    #[inline(always)]
    pub(super) fn frame(self) -> Frame {
        let Question { corners: [a, b, c], width, per_tolerance, limit, stride } = self;
        let (spans, plane) = (Spans::new(a.at, b.at, c.at), Plane::new(a, b, c));
        Frame { spans, plane, height_of_a: a.height, width, per_tolerance, limit, stride }
    }
}

/// A triangle that is measured.
pub(super) struct Frame {
    pub(super) spans: Spans,
    pub(super) plane: Plane,
    pub(super) height_of_a: f64,
    pub(super) width: usize,
    pub(super) per_tolerance: f64,
    pub(super) limit: f32,
    /// From one row that is read to the next: a power of two.
    pub(super) stride: i32,
}

/// Samples of a row.
#[derive(Clone, Copy)]
pub(super) struct Run {
    /// The place of the first one in the tile.
    pub(super) index: usize,
    pub(super) count: usize,
    /// Where the first one is.
    pub(super) first: Point,
}

/// Measures a triangle by heights. The triangle is set up where the lanes are: apart it took a fifth of all.
pub(super) struct HeightScan<'a, H, const WEIGHTED: bool> {
    pub(super) question: Question,
    pub(super) heights: &'a [H],
    /// Empty, or one for every height.
    pub(super) weights: &'a [f64],
}

impl<H: Sample, const WEIGHTED: bool> Kernel for HeightScan<'_, H, WEIGHTED> {
    type Output = Fit;

    #[inline(always)]
    fn run<L: Lanes>(self, on: L) -> Fit {
        let HeightScan { question, heights, weights } = self;
        Scan::<H, WEIGHTED> { frame: question.frame(), heights, weights }.measure(on)
    }
}

struct Scan<'a, H, const WEIGHTED: bool> {
    frame: Frame,
    heights: &'a [H],
    weights: &'a [f64],
}

/// The triangle along a row of samples, in tolerances above the reference.
#[derive(Clone, Copy)]
pub(super) struct Line<H> {
    start: f32,
    step: f32,
    reference: H,
}

/// Sums by lanes.
#[derive(Clone, Copy)]
pub(super) struct Sums<E> {
    energy: E,
    worst: E,
    /// The bits of where a lane's worst is, less the lane.
    place: E,
}

/// The errors of samples by rows: of the heights, or whatever else counts.
pub(super) trait Rows<H: Sample> {
    fn frame(&self) -> &Frame;

    /// Adds those of a row, in whole lanes. Those past the end do not count, and the tile has room for them
    /// ([`crate::base::PADDING`]).
    fn row<L: Lanes>(&self, run: Run, line: Line<H>, sums: Sums<L::Eight>, on: L) -> Sums<L::Eight>;

    /// The same for a row of no more samples than there are lanes, perhaps none: without a branch that would be as good as
    /// random.
    #[inline(always)]
    fn short_row<L: Lanes>(&self, run: Run, line: Line<H>, sums: Sums<L::Eight>, on: L) -> Sums<L::Eight> {
        self.row(run, line, sums, on)
    }

    /// How the triangle fits its samples. Whether the limit is passed is looked at after every four rows.
    #[inline(always)]
    fn measure<L: Lanes>(&self, on: L) -> Fit {
        let frame = self.frame();
        let Frame { spans, plane, .. } = frame;
        let reference = H::of(frame.height_of_a);
        let offset = frame.height_of_a - reference.to_f64();
        let per_tolerance = frame.per_tolerance;
        let mut sums = Sums { energy: on.all(0.0), worst: on.all(0.0), place: on.all(0.0) };
        let [across, down] = plane.gradient().map(|g| g * per_tolerance);
        let slope = Slope { origin: plane.origin(), across, down, start: offset * per_tolerance };
        let step = (across * f64::from(STEPS)) as f32;
        let stride = frame.stride;
        let rows_are_short = spans.longest_has_at_most(LANES, plane.area);
        let finder = RowFinder::new(spans, slope, stride, on);
        let (mut row, last_row) = (next_multiple(*spans.rows().start(), stride), *spans.rows().end());
        while row <= last_row {
            let rows = finder.rows_from(row, on);
            for i in 0..FOUR {
                let (first, last) = (rows.first[i], rows.last[i]);
                if rows_are_short || first <= last {
                    let index = row as usize * frame.width + first as usize;
                    let run = Run { index, count: (last - first + 1) as usize, first: Point::of_sample(first, row) };
                    let line = Line { start: rows.start[i], step, reference };
                    sums = if rows_are_short {
                        self.short_row(run, line, sums, on)
                    } else {
                        self.row(run, line, sums, on)
                    };
                }
                row += stride;
                if row > last_row {
                    break;
                }
            }
            if on.total(sums.energy) > frame.limit {
                break;
            }
        }
        let worst = on.parts(sums.worst);
        let mut fit = Fit { energy: on.total(sums.energy), worst: largest(&worst), place: NONE };
        if fit.worst > ONSET {
            let lane = worst.iter().position(|&w| w == fit.worst).unwrap_or(0);
            let first = on.parts(sums.place)[lane].to_bits();
            fit.place = if first < NOWHERE { first + lane as u32 } else { NONE };
        }
        fit
    }
}

/// The next row that is a multiple of a stride.
#[inline(always)]
fn next_multiple(row: i32, stride: i32) -> i32 {
    (row + stride - 1) & !(stride - 1)
}

/// Places are kept as the bits of finite numbers, below these. Tiles have fewer samples; if one had more, they would have no
/// place.
const NOWHERE: u32 = f32::MAX.to_bits();

impl<H: Sample, const WEIGHTED: bool> Rows<H> for Scan<'_, H, WEIGHTED> {
    #[inline(always)]
    fn frame(&self) -> &Frame {
        &self.frame
    }

    #[inline(always)]
    fn row<L: Lanes>(&self, run: Run, line: Line<H>, mut sums: Sums<L::Eight>, on: L) -> Sums<L::Eight> {
        let Run { index, count, .. } = run;
        let row = Row::new(&self.frame, line, on);
        let samples = index..index + count.next_multiple_of(LANES);
        let lanes = self.heights[samples.clone()].as_chunks::<LANES>().0;
        let weights = if WEIGHTED { self.weights[samples].as_chunks::<LANES>().0 } else { &[] };
        let mut place = place_of(index);
        let (last, whole) = lanes.split_last().expect("a row is not empty");
        let mut at = on.of(INDEX);
        for (i, lane) in whole.iter().enumerate() {
            let mut t = row.errors(lane, at, on);
            if WEIGHTED {
                t = on.mul(t, on.of(weights[i].map(|w| w as f32)));
            }
            sums.add(t, row.pull, place, on);
            at = on.add(at, on.all(LANES as f32));
            place += LANES as u32;
        }
        let mut t = on.mul(row.errors(last, at, on), on.of(COUNTS[count - whole.len() * LANES]));
        if WEIGHTED {
            t = on.mul(t, on.of(weights[whole.len()].map(|w| w as f32)));
        }
        sums.add(t, row.pull, place, on);
        sums
    }

    #[inline(always)]
    fn short_row<L: Lanes>(&self, run: Run, line: Line<H>, mut sums: Sums<L::Eight>, on: L) -> Sums<L::Eight> {
        let Run { index, count, .. } = run;
        let row = Row::new(&self.frame, line, on);
        let lane = self.heights[index..].first_chunk::<LANES>().expect("a tile is padded");
        let mut t = on.mul(row.errors(lane, on.of(INDEX), on), on.of(COUNTS[count]));
        if WEIGHTED {
            let weights = self.weights[index..].first_chunk::<LANES>().expect("a tile is padded");
            t = on.mul(t, on.of(weights.map(|w| w as f32)));
        }
        sums.add(t, row.pull, place_of(index), on);
        sums
    }
}

/// The place of a sample, as far as places go.
#[inline(always)]
pub(super) fn place_of(index: usize) -> u32 {
    index.min(NOWHERE as usize) as u32
}

/// A [`Line`] in lanes.
pub(super) struct Row<E, H> {
    per_tolerance: E,
    pub(super) pull: E,
    start: E,
    step: E,
    reference: H,
}

impl<E, H: Sample> Row<E, H> {
    #[inline(always)]
    pub(super) fn new<L: Lanes<Eight = E>>(frame: &Frame, line: Line<H>, on: L) -> Self {
        Row {
            per_tolerance: on.all(frame.per_tolerance as f32),
            pull: on.all(PULL * frame.stride as f32),
            start: on.all(line.start),
            step: on.all(line.step),
            reference: line.reference,
        }
    }

    /// How far eight samples are from the triangle.
    #[inline(always)]
    pub(super) fn errors<L: Lanes<Eight = E>>(&self, lane: &[H; LANES], at: E, on: L) -> E
    where
        E: Copy,
    {
        let heights: [f32; LANES] = std::array::from_fn(|i| lane[i].above(self.reference));
        let above = on.mul(on.of(heights), self.per_tolerance);
        on.abs(on.sub(on.add(self.start, on.mul(self.step, at)), above))
    }
}

impl<E: Copy> Sums<E> {
    /// Adds eight errors; the first sample's is at `place`.
    #[inline(always)]
    pub(super) fn add<L: Lanes<Eight = E>>(&mut self, t: E, pull: E, place: u32, on: L) {
        self.energy = on.add(self.energy, energies(on, t, pull));
        self.place = on.if_greater(t, self.worst, on.all(f32::from_bits(place)), self.place);
        self.worst = on.max(t, self.worst);
    }
}
