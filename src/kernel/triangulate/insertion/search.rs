//! Which sample of a triangle is farthest from it, in lanes, compiled for what the processor has: wider lanes change no result.
//!
//! Heights in single precision are compared in single precision first, twice as many at a time and without their places. That
//! tells in which rows the farthest sample can be, or that none is beyond the tolerance. Doubles decide in those rows.

use super::scan::{Farthest, Scan};
use crate::base::{Heights, PADDING, Tile};
use crate::kernel::triangulate::feasible::doubt_in_singles;

/// Doubles compared together: rows of triangles are short, and eight were measured to take a third longer.
const LANES: usize = 4;
const LANE: [f64; LANES] = [0.0, 1.0, 2.0, 3.0];

/// Singles compared together.
const WIDE: usize = PADDING;
const PLACE: [f32; WIDE] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];

/// In how many parts of its rows at most it is remembered how far a triangle is from them in single precision.
const PARTS: usize = 64;

/// What heights and planes in single precision are below: with more a difference might be no number.
const LARGE: f64 = 1e30;

/// The farthest sample of a closed triangle; of samples that are equally far the first one. Where it is closer than the
/// tolerance by more than any rounding, its distance is only about right, and which sample it is remains open.
///
/// Neither closures nor functions: those are not always inlined into what is compiled for the processor, and then their
/// code is for the oldest one.
pub(super) struct Search<'a> {
    pub(super) scan: &'a Scan,
    pub(super) tile: &'a Tile,
    pub(super) tolerance: f64,
}

impl pulp::NullaryFnOnce for Search<'_> {
    type Output = Farthest;

    #[inline(always)]
    fn call(self) -> Farthest {
        let Search { scan, tile, tolerance } = self;
        match &tile.heights {
            Heights::F32(heights) => scan.farthest_in_singles(heights, tolerance),
            Heights::F64(heights) => scan.farthest(heights, |_| true),
        }
    }
}

impl Scan {
    /// See [`Search`].
    #[inline(always)]
    fn farthest_in_singles(&self, heights: &[f32], tolerance: f64) -> Farthest {
        let base = self.base();
        let reference = base as f32;
        let offset = base - f64::from(reference);
        let reach = self.reach() + offset.abs();
        let are_small = reach + base.abs() < LARGE;
        if !are_small {
            return self.farthest(heights, |_| true);
        }
        let (first_row, last_row) = (*self.spans.rows().start(), *self.spans.rows().end());
        let mut rows_of_part = 1;
        while last_row - first_row >= PARTS as i32 * rows_of_part {
            rows_of_part *= 2;
        }
        let shift = rows_of_part.trailing_zeros();
        let part_of = |row: i32| ((row - first_row) >> shift) as usize % PARTS;
        let per_area = 1.0 / self.area();
        let step = (self.step() * per_area) as f32;
        let mut parts = [0.0f32; PARTS];
        let mut farthest = 0.0;
        for row in first_row..=last_row {
            let (first, last) = self.columns(row);
            if first > last {
                continue;
            }
            let start = (self.start(first, row) * per_area + offset) as f32;
            let index = row as usize * self.width() + first as usize;
            let count = (last - first + 1) as usize;
            let lanes = heights[index..index + count.next_multiple_of(WIDE)].as_chunks::<WIDE>().0;
            let of_row = largest_in_row(lanes, count, Line { start, step, reference });
            let part = &mut parts[part_of(row)];
            *part = larger(*part, of_row);
            farthest = larger(farthest, of_row);
        }
        let farthest = f64::from(farthest);
        let doubt = 4.0 * doubt_in_singles(reach, farthest);
        if farthest + doubt < tolerance - self.doubt(tolerance) {
            return Farthest { error: farthest, sample: 0 };
        }
        let enough = farthest - doubt;
        self.farthest(heights, |row| f64::from(parts[part_of(row)]) >= enough)
    }

    /// The farthest sample of those rows of the closed triangle that count. Lane by lane: each keeps the farthest it has seen; the
    /// lanes are compared once, in the end. Written so that the compiler makes vector code of it.
    #[inline(always)]
    fn farthest<H: Copy + Into<f64>>(&self, heights: &[H], counts: impl Fn(i32) -> bool) -> Farthest {
        // Two of them, as one would have to wait for itself in long rows.
        let mut bests = [Best::NONE; 2];
        for row in self.spans.rows() {
            if !counts(row) {
                continue;
            }
            let (first, last) = self.columns(row);
            if first > last {
                continue;
            }
            let offset = row as usize * self.width() + first as usize;
            let count = (last - first + 1) as usize;
            let start = self.start(first, row);
            let mut done = 0;
            while done + 2 * LANES <= count {
                for best in &mut bests {
                    best.see(self.sizes(heights, offset, start, done), offset + done);
                    done += LANES;
                }
            }
            while done < count {
                let mut sizes = self.sizes(heights, offset, start, done);
                for (size, lane) in sizes.iter_mut().zip(LANE) {
                    *size = if done as f64 + lane < count as f64 { *size } else { -1.0 };
                }
                bests[0].see(sizes, offset + done);
                done += LANES;
            }
        }
        let (mut size, mut sample) = (-1.0, 0.0);
        for best in bests {
            for ((of_lane, start), lane) in best.sizes.into_iter().zip(best.samples).zip(LANE) {
                if of_lane > size || of_lane == size && start + lane < sample {
                    (size, sample) = (of_lane, start + lane);
                }
            }
        }
        Farthest { error: size.max(0.0) / self.area(), sample: sample as u64 }
    }

    /// |S| at some samples of a row, from the one after `done` on: the row's first one is at `offset`, where S is `start` but for
    /// the sample itself.
    #[inline(always)]
    fn sizes<H: Copy + Into<f64>>(&self, heights: &[H], offset: usize, start: f64, done: usize) -> [f64; LANES] {
        let lane: &[H; LANES] = heights[offset + done..].first_chunk().expect("padding behind the samples");
        let (at, base) = (done as f64, self.base());
        let mut sizes = [0.0; LANES];
        for i in 0..LANES {
            let height: f64 = lane[i].into();
            sizes[i] = ((start + self.step() * (at + LANE[i])) - self.area() * (height - base)).abs();
        }
        sizes
    }
}

/// A triangle along a row, above a reference.
#[derive(Clone, Copy)]
struct Line {
    start: f32,
    step: f32,
    reference: f32,
}

/// How far the farthest of a row's samples is from the triangle, which stand in lanes; those past their number do not count.
#[inline(always)]
fn largest_in_row(lanes: &[[f32; WIDE]], count: usize, line: Line) -> f32 {
    let mut largest = [0.0f32; WIDE];
    let mut at = 0.0;
    let (last, whole) = lanes.split_last().expect("a row is not empty");
    for lane in whole {
        for i in 0..WIDE {
            largest[i] = larger(largest[i], line.distance(lane[i], at + PLACE[i]));
        }
        at += WIDE as f32;
    }
    let end = count as i32 as f32;
    for i in 0..WIDE {
        let distance = line.distance(last[i], at + PLACE[i]);
        largest[i] = larger(largest[i], if at + PLACE[i] < end { distance } else { 0.0 });
    }
    let [a, b, c, d, e, f, g, h] = largest;
    larger(larger(larger(a, e), larger(c, g)), larger(larger(b, f), larger(d, h)))
}

impl Line {
    #[inline(always)]
    fn distance(self, height: f32, place: f32) -> f32 {
        ((height - self.reference) - (self.start + self.step * place)).abs()
    }
}

#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if b > a { b } else { a }
}

/// The farthest sample that each lane has seen.
#[derive(Clone, Copy)]
struct Best {
    sizes: [f64; LANES],
    /// Its place, less the lane.
    samples: [f64; LANES],
}

impl Best {
    /// Half a negative: below every |S|, and no lane past the end ever wins.
    const NONE: Best = Best { sizes: [-0.5; LANES], samples: [0.0; LANES] };

    #[inline(always)]
    fn see(&mut self, sizes: [f64; LANES], sample: usize) {
        let sample = sample as f64;
        for ((best, at), size) in self.sizes.iter_mut().zip(&mut self.samples).zip(sizes) {
            let better = size > *best;
            *best = if better { size } else { *best };
            *at = if better { sample } else { *at };
        }
    }
}
