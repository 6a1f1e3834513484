//! The feasible-tilt sweep.
//!
//! The planes through an edge have one free parameter, the tilt. A sample with the height h at the distance d from the
//! edge's line is within ε of those whose tilt is in [(h − ε − base) ÷ d, (h + ε − base) ÷ d], the base being the height
//! of the edge's line at the foot of the sample's perpendicular, read beyond the edge's ends if need be.
//!
//! The triangles over the edge whose apexes are on one ray are nested. So the samples are read in the order in which the
//! growing triangle reaches them, each once, and the intervals are intersected on the way: an apex on the ray makes a
//! feasible triangle exactly if its own tilt is in the intersection when the triangle has grown to it. When the
//! intersection is empty, no apex farther out does.
//!
//! ```text
//!            ·                     between two triangles of the ray lie two wedges, and in each row of samples
//!           ╱│╲                    up to two spans
//!          ╱░·░╲
//!         ╱░╱ ╲░╲
//!        a ─────── b
//! ```

use super::frame::Frame;
use super::outline::Outline;
use super::ray::{Ray, STEPS_OF_RAY, Step, Steps, away, step_from, step_up_to};
use crate::base::lattice::{Point, orient};
use crate::base::mesh::Vertex;
use crate::base::{Heights, Tile};

/// What a sweep along one ray has found: the tilts allowed at each step, as far as it came.
#[derive(Debug, Clone)]
pub(super) struct Sweep {
    tilts: [Tilts; STEPS_OF_RAY as usize + 1],
    /// The steps that were reached. At the last one the intersection may be empty.
    reached: std::ops::Range<Step>,
}

/// An interval of tilts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Tilts {
    pub(super) low: f64,
    pub(super) high: f64,
}

impl Tilts {
    const ALL: Tilts = Tilts { low: f64::NEG_INFINITY, high: f64::INFINITY };

    #[inline(always)]
    fn intersect(&mut self, other: Tilts) {
        self.low = self.low.max(other.low);
        self.high = self.high.min(other.high);
    }

    #[inline(always)]
    pub(super) fn contains(&self, tilt: f64) -> bool {
        self.low <= tilt && tilt <= self.high
    }

    #[inline(always)]
    fn is_empty(&self) -> bool {
        self.low > self.high
    }
}

/// Rounding makes intervals wider, never narrower: by this share of the numbers that a height above the edge comes
/// from. So an empty intersection is empty.
const DOUBT: f64 = 16.0 * f64::EPSILON;

/// About as many samples are read at first, before any step is looked at; from then on an octave of steps at a time.
const FIRST_SAMPLES: f64 = 64.0;
const STEPS_AT_ONCE: Step = 8;

/// Of triangles with more samples than this, only some of the rows are read, about so many samples: exact tests come
/// cheaper than reading all of a large triangle for each ray, and what some samples rule out is ruled out.
pub(super) const ENOUGH_SAMPLES: f64 = 64.0;

impl Default for Sweep {
    fn default() -> Sweep {
        Sweep { tilts: [Tilts::ALL; STEPS_OF_RAY as usize + 1], reached: 0..0 }
    }
}

impl Sweep {
    /// Sweeps the steps of a range. Returns those whose nearest sample is an apex that the sweep predicts to be
    /// feasible; as the sample is not quite on the ray, and large triangles are not read in full, an exact test has to
    /// decide. `enough` is the number of samples up to which they are.
    #[inline(always)]
    pub(super) fn run(
        &mut self,
        tile: &Tile,
        tolerance: f64,
        frame: &Frame,
        ray: &Ray,
        steps: std::ops::Range<Step>,
        enough: f64,
    ) -> Steps {
        match &tile.heights {
            Heights::F32(heights) => self.run_over(&Ground { tile, heights, tolerance, frame, ray, enough }, steps),
            Heights::F64(heights) => self.run_over(&Ground { tile, heights, tolerance, frame, ray, enough }, steps),
        }
    }

    #[inline(always)]
    fn run_over<R: Copy + Into<f64>>(&mut self, ground: &Ground<'_, R>, steps: std::ops::Range<Step>) -> Steps {
        let Ground { tile, frame, ray, .. } = *ground;
        self.tilts[steps.start as usize..].fill(Tilts::ALL);
        self.reached = steps.start..steps.start;
        let mut inner = Outline::EMPTY;
        let mut allowed = Tilts::ALL;
        let (mut feasible, mut last) = (0, None);
        let mut end = step_from(FIRST_SAMPLES / frame.samples());
        while self.reached.end < steps.end {
            end = end.max(self.reached.end + STEPS_AT_ONCE).min(steps.end);
            let outer = Outline::new(frame, ray.place(frame, end - 1), (tile.width(), tile.height()));
            let stride = (frame.samples() * away(end - 1) / ground.enough).max(1.0) as i32;
            ground.read_between(&inner, &outer, stride, self.reached.end, &mut self.tilts);
            for step in self.reached.end..end {
                allowed.intersect(self.tilts[step as usize]);
                self.tilts[step as usize] = allowed;
                self.reached.end = step + 1;
                if allowed.is_empty() {
                    return feasible;
                }
                // Where steps are closer together than samples, the first step at a sample stands for it.
                let apex = apex(tile, frame, ray, step).filter(|v| last.replace(v.at) != Some(v.at));
                if apex.is_some_and(|v| allowed.contains(tilt(frame, v))) {
                    feasible |= 1 << step;
                }
            }
            inner = outer;
        }
        feasible
    }

    /// Whether an apex that need not be on the ray swept may be feasible, as far as the sweep can tell; it is given by its
    /// coordinates and its tilt. What is not allowed is infeasible.
    #[inline(always)]
    pub(super) fn allows(&self, ray: &Ray, (along, away): (f64, f64), tilt: f64) -> bool {
        // The triangle to the last step inside the apex's own triangle is a part of that. (A little less, for rounding.)
        match step_up_to(ray.exit(along, away) * (1.0 - 1e-9)) {
            Some(step) if step >= self.reached.start && !self.reached.is_empty() => {
                self.tilts[step.min(self.reached.end - 1) as usize].contains(tilt)
            }
            _ => true,
        }
    }
}

/// The vertex at the sample nearest to a step, if it is inside the tile and to the left of the edge.
#[inline(always)]
pub(super) fn apex(tile: &Tile, frame: &Frame, ray: &Ray, step: Step) -> Option<Vertex> {
    let (column, row) = ray.place(frame, step);
    let (column, row) = ((column + 0.5).floor(), (row + 0.5).floor());
    if !(column >= 0.0 && row >= 0.0 && column < tile.width() as f64 && row < tile.height() as f64) {
        return None;
    }
    let at = Point::of_sample(column as i32, row as i32);
    let left = orient(frame.a.at, frame.b.at, at) > 0;
    left.then(|| Vertex { at, height: tile.at(column as usize, row as usize) })
}

/// What is swept.
struct Ground<'a, R> {
    tile: &'a Tile,
    heights: &'a [R],
    tolerance: f64,
    frame: &'a Frame,
    ray: &'a Ray,
    enough: f64,
}

impl<R: Copy + Into<f64>> Ground<'_, R> {
    /// Reads the samples of one outline that are not in another, in every `stride`th row of the tile, and intersects the
    /// interval of the step at which the triangle reaches each (none before `first`) with the sample's.
    #[inline(always)]
    fn read_between(&self, inner: &Outline, outer: &Outline, stride: i32, first: Step, tilts: &mut [Tilts]) {
        let (top, bottom) = outer.rows();
        let mut row = (top + stride - 1) / stride * stride;
        while row <= bottom {
            let (left, right) = outer.columns(row);
            let (inner_left, inner_right) = inner.columns(row);
            if inner_left > inner_right {
                self.read(row, (left, right), first, tilts);
            } else {
                self.read(row, (left, inner_left - 1), first, tilts);
                self.read(row, (inner_right + 1, right), first, tilts);
            }
            row += stride;
        }
    }

    #[inline(always)]
    fn read(&self, row: i32, (left, right): (i32, i32), first: Step, tilts: &mut [Tilts]) {
        if left > right {
            return;
        }
        let Ground { frame, ray, tolerance, .. } = *self;
        let index = row as usize * self.tile.width();
        let samples = &self.heights[index + left as usize..=index + right as usize];
        let (number, row) = (row as usize, frame.row(row));
        let magnitude = frame.magnitude() + tolerance;
        for (i, &height) in samples.iter().enumerate() {
            let (along, away) = frame.in_row(&row, f64::from(left + i as i32));
            let arrival = ray.arrival(along, away);
            // Samples on the edge are within the tolerance already; others are outside if they never arrive.
            if !(away > 0.0 && arrival > 0.0) {
                continue;
            }
            let above = frame.above(along, height.into());
            let allowed = self.tile.limit(left as usize + i, number, tolerance);
            let reach = allowed + (above.abs() + magnitude) * DOUBT;
            let inverse = 1.0 / away;
            let step = step_from(arrival).max(first);
            tilts[step as usize].intersect(Tilts { low: (above - reach) * inverse, high: (above + reach) * inverse });
        }
    }
}

/// The tilt of the plane through the edge and a vertex to its left.
#[inline(always)]
pub(super) fn tilt(frame: &Frame, v: Vertex) -> f64 {
    let (along, away) = frame.coordinates(v.at);
    frame.above(along, v.height) / away
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const SIDE: usize = 24;

    /// Whether all samples left of the edge and in the closed triangle a–b–v are within the tolerance of it; `None` if
    /// that is a matter of rounding.
    fn naive(tile: &Tile, tolerance: f64, a: Vertex, b: Vertex, v: (f64, f64, f64)) -> Option<bool> {
        let at = |p: Vertex| (f64::from(p.at.x) / 4.0, f64::from(p.at.y) / 4.0, p.height);
        let (a, b) = (at(a), at(b));
        let cross = |p: (f64, f64, f64), q: (f64, f64, f64), r: (f64, f64, f64)| {
            (q.0 - p.0) * (r.1 - p.1) - (q.1 - p.1) * (r.0 - p.0)
        };
        let area = cross(a, b, v);
        let mut in_doubt = false;
        for (row, column) in (0..SIDE).flat_map(|row| (0..SIDE).map(move |column| (row, column))) {
            let p = (column as f64, row as f64, tile.at(column, row));
            let weights = [cross(b, v, p) / area, cross(v, a, p) / area, cross(a, b, p) / area];
            if weights[2] <= 0.0 || weights.iter().any(|&w| w < -1e-9) {
                continue;
            }
            let gap = (weights[0] * a.2 + weights[1] * b.2 + weights[2] * v.2 - p.2).abs() - tolerance;
            let on_the_side = weights[..2].iter().any(|&w| w < 1e-9);
            match gap {
                g if g > 1e-9 && !on_the_side => return Some(false),
                g if g > -1e-9 => in_doubt = true,
                _ => {}
            }
        }
        (!in_doubt).then_some(true)
    }

    fn tile(seed: u64, rough: f64) -> Tile {
        let noise = |i: usize| ((i as u64 + 1).wrapping_mul(seed | 1).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40) as f64;
        let ground =
            |i: usize| (i % SIDE) as f64 * 0.7 - (i / SIDE) as f64 * 0.3 + noise(i) * rough / f64::from(1 << 24);
        Tile::from_heights(SIDE, SIDE, Heights::F64((0..SIDE * SIDE).map(ground).collect()))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        /// Apexes on the ray itself, wherever it is between samples, and of any height.
        #[test]
        fn the_sweep_answers_as_a_test_of_every_sample_would(
            seed in any::<u64>(), rough in 0.0f64..3.0, tolerance in 0.0f64..2.0, lean in -1.2f64..1.2,
            ends in prop::array::uniform4(0..SIDE), lift in prop::array::uniform2(-1.0f64..1.0),
            tilts in prop::array::uniform4(-1.0f64..1.0), first in 0u32..STEPS_OF_RAY,
        ) {
            let tile = tile(seed, rough);
            let vertex = |column: usize, row: usize, lift: f64| {
                Vertex { at: Point::of_sample(column as i32, row as i32), height: tile.at(column, row) + lift * tolerance }
            };
            let (a, b) = (vertex(ends[0], ends[1], lift[0]), vertex(ends[2], ends[3], lift[1]));
            if a.at == b.at { return Ok(()) }
            let (frame, ray) = (Frame::new(a, b), Ray { lean, farthest: 2.0 });
            let mut sweep = Sweep::default();
            let found = sweep.run(&tile, tolerance, &frame, &ray, first..STEPS_OF_RAY, f64::INFINITY);
            for step in first..STEPS_OF_RAY {
                let allowed = sweep.tilts[(step.min(sweep.reached.end - 1)) as usize];
                // The tilts at stake are those near the interval's ends, or near the ground's where it is empty.
                let middle = if allowed.low.is_finite() { (allowed.low + allowed.high) / 2.0 } else { 0.0 };
                let half = if allowed.low.is_finite() { (allowed.high - allowed.low).abs() } else { 1.0 };
                for tilt in tilts.map(|t| middle + t * half) {
                    let away = away(step);
                    let (column, row) = ray.place(&frame, step);
                    let along = 0.5 + lean * away;
                    let height = a.height + (b.height - a.height) * along + tilt * away;
                    if let Some(expected) = naive(&tile, tolerance, a, b, (column, row, height)) {
                        prop_assert_eq!(allowed.contains(tilt), expected, "step {} tilt {} of {:?}", step, tilt, allowed);
                    }
                }
                if found >> step & 1 == 1 {
                    prop_assert!(step < sweep.reached.end && !allowed.is_empty());
                    prop_assert!(apex(&tile, &frame, &ray, step).is_some_and(|v| allowed.contains(super::tilt(&frame, v))));
                }
            }
        }

        /// What other rays rule out is infeasible indeed.
        #[test]
        fn apexes_not_allowed_are_infeasible(
            seed in any::<u64>(), rough in 0.0f64..3.0, tolerance in 0.0f64..2.0, lean in -1.2f64..1.2,
            places in prop::array::uniform6(0..SIDE), enough in 1.0f64..300.0,
        ) {
            let tile = tile(seed, rough);
            let vertex = |i: usize| {
                let (column, row) = (places[2 * i], places[2 * i + 1]);
                Vertex { at: Point::of_sample(column as i32, row as i32), height: tile.at(column, row) }
            };
            let [a, b, v] = [0, 1, 2].map(vertex);
            let (a, b) = match orient(a.at, b.at, v.at) {
                0 => return Ok(()),
                o if o > 0 => (a, b),
                _ => (b, a),
            };
            let (frame, ray) = (Frame::new(a, b), Ray { lean, farthest: 2.0 });
            let mut sweep = Sweep::default();
            sweep.run(&tile, tolerance, &frame, &ray, 0..STEPS_OF_RAY, enough);
            if !sweep.allows(&ray, frame.coordinates(v.at), tilt(&frame, v)) {
                let (x, y) = v.at.sample().expect("a sample");
                prop_assert!(naive(&tile, tolerance, a, b, (x as f64, y as f64, v.height)) != Some(true));
            }
        }
    }
}
