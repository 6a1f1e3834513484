//! How far a triangle is from its samples, in numbers that can be minimised.
//!
//! With t = |error| · weight / tolerance, or where there are channels the larger one of |error| / tolerance and the weighted
//! error / tolerance, the energy of a sample is max(0, t − 0.97)² + 10⁻⁴·t⁴: violations count, and a little
//! what may become one. With strong feasibility an edge counts as one more sample, where it is farthest from the grid's
//! surface. Summed in single precision, in lanes and in one fixed order, so that every machine steers alike.
//! It only steers: what is kept has passed the exact test.

use super::channels::ChannelScan;
use super::lanes::{Kernel, LANES, Lanes, run};
use super::net::{Fit, NONE};
use super::witnesses::Witnesses;
use crate::base::lattice::{Point, STEPS};
use crate::base::mesh::Vertex;
use crate::base::{Heights, Tile};
use crate::kernel::triangulate::Feasibility;
use crate::kernel::triangulate::feasible::{Plane, Spans, Tester};

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

/// Where violations begin to count, a little before they are some.
pub(super) const ONSET: f32 = 0.97;
/// The weight of t⁴. Anything from 5·10⁻⁵ to 3·10⁻⁴ does; with 10⁻³ one per cent more triangles are left.
pub(super) const PULL: f32 = 1e-4;
/// Rows between two looks whether the limit is passed.
const ROWS_BETWEEN_LOOKS: i32 = 4;

/// Measures triangles of one tile. The tolerance is positive.
#[derive(Debug, Clone, Copy)]
pub(super) struct Meter<'a> {
    tile: &'a Tile,
    per_tolerance: f64,
    /// For the edges, where they count.
    edges: Option<Tester<'a>>,
}

impl<'a> Meter<'a> {
    pub(super) fn new(tester: Tester<'a>, tolerance: f64) -> Meter<'a> {
        let edges = (tester.feasibility() == Feasibility::Strong).then_some(tester);
        Meter { tile: tester.tile(), per_tolerance: 1.0 / tolerance, edges }
    }

    /// Whether energies are numbers: not if the tolerance is 0 or next to it.
    pub(super) fn is_of_use(&self) -> bool {
        self.per_tolerance < 1e30
    }

    pub(super) fn tile(&self) -> &'a Tile {
        self.tile
    }

    pub(super) fn per_tolerance(&self) -> f64 {
        self.per_tolerance
    }

    /// What measures edges, where they count.
    pub(super) fn edges(&self) -> Option<&Tester<'a>> {
        self.edges.as_ref()
    }

    /// Measures a triangle with positive orientation. Stops once its energy is above `limit`; what it then returns is
    /// above it, too.
    pub(super) fn fit(&self, corners: [Vertex; 3], limit: f32) -> Fit {
        self.with_edges(self.scan(corners, limit, 1), corners, limit)
    }

    /// Adds a triangle's edges, where they count, to how its samples fit.
    pub(super) fn with_edges(&self, mut fit: Fit, corners: [Vertex; 3], limit: f32) -> Fit {
        if let Some(tester) = &self.edges {
            let [a, b, c] = corners;
            for (p, q) in [(a, b), (b, c), (c, a)] {
                if fit.energy > limit {
                    break;
                }
                let t = (tester.edge_deviation(p, q) * self.per_tolerance) as f32;
                fit.energy += energy(t);
                if t > fit.worst {
                    (fit.worst, fit.place) = (t, NONE);
                }
            }
        }
        fit
    }

    /// Remembers where a triangle is worst, if that is known.
    pub(super) fn note(&self, fit: Fit, witnesses: &mut Witnesses) {
        if fit.place != NONE {
            witnesses.note(fit.place as usize, self);
        }
    }

    /// Makes a place a witness, if it is a sample.
    pub(super) fn call(&self, at: Point, witnesses: &mut Witnesses) {
        if let Some((column, row)) = at.sample() {
            witnesses.note(row * self.tile.width + column, self);
        }
    }

    /// About the energy of a triangle's samples, from every `stride`th row alone: small errors count `stride` times, as
    /// those of rows between will be like them; violations count once.
    pub(super) fn coarse_energy(&self, corners: [Vertex; 3], limit: f32, stride: i32) -> f32 {
        self.scan(corners, limit, stride).energy
    }

    fn scan(&self, [a, b, c]: [Vertex; 3], limit: f32, stride: i32) -> Fit {
        let frame = Frame {
            spans: Spans::new(a.at, b.at, c.at),
            plane: Plane::new(a, b, c),
            height_of_a: a.height,
            width: self.tile.width,
            per_tolerance: self.per_tolerance,
            limit,
            stride,
        };
        let weights = &self.tile.weights[..];
        if let Some(error) = &self.tile.channel_error {
            return match &self.tile.heights {
                Heights::F32(heights) => run(ChannelScan::new(frame, self.tile, heights, error, [a, b, c])),
                Heights::F64(heights) => run(ChannelScan::new(frame, self.tile, heights, error, [a, b, c])),
            };
        }
        match &self.tile.heights {
            Heights::F32(heights) => run(Scan::<_, false> { frame, heights, weights }),
            Heights::F64(heights) if weights.is_empty() => run(Scan::<_, false> { frame, heights, weights }),
            Heights::F64(heights) => run(Scan::<_, true> { frame, heights, weights }),
        }
    }
}

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

/// A triangle that is measured.
pub(super) struct Frame {
    spans: Spans,
    pub(super) plane: Plane,
    height_of_a: f64,
    width: usize,
    pub(super) per_tolerance: f64,
    limit: f32,
    /// From one row that is read to the next: a power of two.
    stride: i32,
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

struct Scan<'a, H, const WEIGHTED: bool> {
    frame: Frame,
    heights: &'a [H],
    /// Empty, or one for every height.
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

    /// How the triangle fits its samples.
    #[inline(always)]
    fn measure<L: Lanes>(&self, on: L) -> Fit {
        let frame = self.frame();
        let Frame { spans, plane, .. } = frame;
        let reference = H::of(frame.height_of_a);
        let offset = frame.height_of_a - reference.to_f64();
        let per_tolerance = frame.per_tolerance;
        let mut sums = Sums { energy: on.all(0.0), worst: on.all(0.0), place: on.all(0.0) };
        let (gradient, origin) = (plane.gradient(), plane.origin());
        let [across, down] = gradient.map(|g| g * per_tolerance);
        let offset = offset * per_tolerance;
        let step = (across * f64::from(STEPS)) as f32;
        let stride = frame.stride;
        let mut until_look = ROWS_BETWEEN_LOOKS;
        'halves: for half in spans.halves() {
            let mut row = next_multiple(half.first, stride);
            while row <= half.last {
                let (first, last) = half.columns(row);
                if first <= last {
                    let index = row as usize * frame.width + first as usize;
                    let at = Point::of_sample(first, row);
                    let (x, y) = (f64::from(at.x - origin.x), f64::from(at.y - origin.y));
                    let start = (across * x + down * y + offset) as f32;
                    let run = Run { index, count: (last - first + 1) as usize, first: at };
                    sums = self.row(run, Line { start, step, reference }, sums, on);
                }
                row += stride;
                until_look -= 1;
                if until_look == 0 {
                    if on.total(sums.energy) > frame.limit {
                        break 'halves;
                    }
                    until_look = ROWS_BETWEEN_LOOKS;
                }
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

impl<H: Sample, const WEIGHTED: bool> Kernel for Scan<'_, H, WEIGHTED> {
    type Output = Fit;

    #[inline(always)]
    fn run<L: Lanes>(self, on: L) -> Fit {
        self.measure(on)
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

/// The energies of eight errors.
#[inline(always)]
pub(super) fn energies<L: Lanes>(on: L, t: L::Eight, pull: L::Eight) -> L::Eight {
    let over = on.max(on.sub(t, on.all(ONSET)), on.all(0.0));
    let t2 = on.mul(t, t);
    on.add(on.mul(over, over), on.mul(pull, on.mul(t2, t2)))
}

/// The energy of one error, as a share of the tolerance.
pub(super) fn energy(t: f32) -> f32 {
    let (over, t2) = (t - ONSET, t * t);
    let over = if over > 0.0 { over } else { 0.0 };
    over * over + PULL * (t2 * t2)
}

/// A fixed tree of additions.
#[inline(always)]
pub(super) fn total(&[a, b, c, d, e, f, g, h]: &[f32; LANES]) -> f32 {
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}

#[inline(always)]
pub(super) fn largest(&[a, b, c, d, e, f, g, h]: &[f32; LANES]) -> f32 {
    let max = |a: f32, b: f32| if b > a { b } else { a };
    max(max(max(a, e), max(c, g)), max(max(b, f), max(d, h)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::lattice::Point;

    #[test]
    fn one_violation_among_samples_on_the_plane() {
        let mut heights = vec![0.0f32; 144];
        heights[12 * 2 + 3] = 3.0;
        let tile = Tile::from_heights(12, 12, Heights::F32(heights));
        let at = |c, r| Vertex { at: Point::of_sample(c, r), height: 0.0 };
        let tester = Tester::new(&tile, 2.0, Feasibility::Weak);
        let fit = Meter::new(tester, 2.0).fit([at(0, 0), at(11, 0), at(0, 11)], f32::INFINITY);
        let t = 1.5f32;
        assert_eq!((fit.worst, fit.place), (t, 12 * 2 + 3));
        assert!((fit.energy - ((t - ONSET).powi(2) + PULL * t.powi(4))).abs() < 1e-6, "{fit:?}");
    }
}
