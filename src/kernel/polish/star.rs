//! The star of a vertex as a function of the vertex's height.
//!
//! The error at a sample is linear in the height of the apex. So the raster is read once per place (`read`); energy, best
//! height and derivatives come from what was noted then.

use super::energy::{Meter, ONSET, PULL, energies, largest, total};
use super::lanes::{Kernel, LANES, Lanes, run};
use super::net::{Fit, NONE};
use super::ring::Ring;
use super::scan::Sample;
use crate::base::Heights;
use crate::base::lattice::{Point, STEPS};
use crate::base::mesh::Vertex;
use crate::kernel::triangulate::feasible::{Plane, Spans};

/// Newton steps for a height, at most; most end after three.
const NEWTON_STEPS: usize = 6;
/// They end where the energy falls by less than this share, or the height changes by less than this share of ε.
const SETTLED: f32 = 0.01;
/// How much the energy may fall, as a multiple of slope² ÷ curve: a Newton step promises half of it, and more comes where violations
/// end on the way.
const HOPE: f32 = 1.0;
/// After a step that was too long, this share of it is tried.
const BACKTRACK: f32 = 0.3;

/// Every sample of a star, once per triangle: error + share · rise is its error, in tolerances, when the apex is `rise`
/// tolerances higher than it was when the star was read.
///
/// Memory: 10 bytes per sample of the largest star.
#[derive(Debug, Default)]
pub(super) struct Star {
    share: Vec<f32>,
    error: Vec<f32>,
    parts: Vec<Part>,
    /// Sums at the height that it was read with, where they are known.
    at_rest: Option<Sums>,
}

/// Sums over samples at one height of the apex.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    energy: f32,
    /// First and second derivative of the energy with respect to the rise.
    slope: f32,
    curve: f32,
}

/// What belongs to one triangle.
#[derive(Debug, Clone, Copy)]
struct Part {
    /// Its samples, from here,
    start: usize,
    /// to here, filled up to whole lanes with numbers that count nothing;
    end: usize,
    /// and, with strong feasibility, the places on its spokes that are farthest from the grid's surface, to here.
    behind: usize,
    /// The plane's rise per lattice step across and down, in tolerances.
    gradient: [f64; 2],
}

/// [`Sums`] by lanes, and the largest error.
#[derive(Clone, Copy)]
struct Totals<E> {
    energy: E,
    worst: E,
    slope: E,
    curve: E,
}

impl Star {
    /// Reads the star of an apex inside its ring.
    pub(super) fn read(&mut self, ring: &Ring, apex: Vertex, meter: &Meter<'_>) {
        self.parts.clear();
        self.at_rest = None;
        match &meter.tile().heights {
            Heights::F32(heights) => run(Read { star: self, ring, apex, meter, heights }),
            Heights::F64(heights) => run(Read { star: self, ring, apex, meter, heights }),
        }
    }

    /// The rise of the apex that has the least energy, about, and that energy; any energy not below `limit` where there is no
    /// hope that it is.
    pub(super) fn best_rise(&self, limit: f32) -> (f32, f32) {
        let end = self.parts.last().map_or(0, |p| p.behind);
        run(Newton { share: &self.share[..end], error: &self.error[..end], at_rest: self.at_rest, limit })
    }

    /// How the samples of triangle i fit when the apex is `rise` tolerances higher.
    pub(super) fn fit(&self, i: usize, rise: f32) -> Fit {
        let Part { start, end, .. } = self.parts[i];
        let (share, error) = (&self.share[start..end], &self.error[start..end]);
        run(FitAt { share, error, rise })
    }

    /// The Gauss–Newton step of the apex: lattice steps across and down, tolerances up.
    ///
    /// When the apex of a plane with the gradient (p, q) goes by (x, y, z), the error at a sample changes by its share of
    /// z − p·x − q·y, to first order: two sums per triangle are all that is needed of the samples. Damped a little. It stays
    /// where it is across or down unless it is `free` to go there.
    pub(super) fn step(&mut self, free: [bool; 2]) -> [f64; 3] {
        const DAMPING: f64 = 1e-3;
        let mut all = Sums::default();
        let (mut slope, mut curve) = ([0.0f64; 3], [[0.0f64; 3]; 3]);
        for &Part { start, behind, gradient: [p, q], .. } in &self.parts {
            let (share, error) = (&self.share[start..behind], &self.error[start..behind]);
            let sums = run(AtRest { share, error });
            all =
                Sums { energy: all.energy + sums.energy, slope: all.slope + sums.slope, curve: all.curve + sums.curve };
            let along = [if free[0] { -p } else { 0.0 }, if free[1] { -q } else { 0.0 }, 1.0];
            for i in 0..3 {
                slope[i] += f64::from(sums.slope) * along[i];
                for j in 0..3 {
                    curve[i][j] += f64::from(sums.curve) * along[i] * along[j];
                }
            }
        }
        self.at_rest = Some(all);
        for (i, row) in curve.iter_mut().enumerate() {
            row[i] = row[i] * (1.0 + DAMPING) + 1e-9;
        }
        solve(curve, slope.map(|s| -s))
    }
}

/// Solves a system with a symmetric, positive definite matrix, by elimination.
fn solve([[a, b, c], [_, d, e], [_, _, f]]: [[f64; 3]; 3], [x, y, z]: [f64; 3]) -> [f64; 3] {
    let (p, q) = (b / a, c / a);
    let (d, e, f, y, z) = (d - p * b, e - p * c, f - q * c, y - p * x, z - q * x);
    let r = e / d;
    let (f, z) = (f - r * e, z - r * y);
    let z = z / f;
    let y = (y - e * z) / d;
    [(x - b * y - c * z) / a, y, z]
}

struct Read<'a, 'b, H> {
    star: &'a mut Star,
    ring: &'a Ring,
    apex: Vertex,
    meter: &'a Meter<'b>,
    heights: &'a [H],
}

/// A triangle along one of its rows: error and share at the first sample, and from one to the next.
#[derive(Clone, Copy)]
struct Line<H> {
    error: [f32; 2],
    share: [f32; 2],
    reference: H,
}

impl<H: Sample> Kernel for Read<'_, '_, H> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(mut self, _: L) {
        let mut len = 0;
        for i in 0..self.ring.triangles() {
            let [from, to] = self.ring.edge(i);
            let corners = [self.apex, from, to];
            let start = len;
            let plane = Plane::new(corners[0], corners[1], corners[2]);
            len = self.samples(corners, &plane, len);
            let end = len;
            if let Some(tester) = self.meter.edges() {
                let spokes = [corners[1], corners[2]].map(|q| tester.edge_extremes(self.apex, q));
                self.star.make_room(len);
                self.star.clear_lane(len);
                for (j, &(deviation, share)) in spokes.as_flattened().iter().enumerate() {
                    self.star.error[len + j] = (deviation * self.meter.per_tolerance()) as f32;
                    self.star.share[len + j] = share as f32;
                }
                len += LANES;
            }
            let gradient = plane.gradient().map(|g| g * self.meter.per_tolerance());
            self.star.parts.push(Part { start, end, behind: len, gradient });
        }
    }
}

impl<H: Sample> Read<'_, '_, H> {
    /// Notes the samples of a triangle from position `len` on; returns the position behind them.
    #[inline(always)]
    fn samples(&mut self, [a, b, c]: [Vertex; 3], plane: &Plane, mut len: usize) -> usize {
        let (tile, per_tolerance) = (self.meter.tile(), self.meter.per_tolerance());
        let spans = Spans::new(a.at, b.at, c.at);
        let reference = H::of(a.height);
        let offset = (a.height - reference.to_f64()) * per_tolerance;
        let [across, down] = plane.gradient().map(|g| g * per_tolerance);
        let (error_step, share_step) = ((across * f64::from(STEPS)) as f32, plane.share_step() as f32);
        for half in spans.halves() {
            for row in half.first..=half.last {
                let (first, last) = half.columns(row);
                if first > last {
                    continue;
                }
                let (index, count) = (row as usize * tile.width + first as usize, (last - first + 1) as usize);
                let at = Point::of_sample(first, row);
                let (x, y) = (f64::from(at.x - a.at.x), f64::from(at.y - a.at.y));
                let error = [(across * x + down * y + offset) as f32, error_step];
                let share = [plane.share_of_a(at) as f32, share_step];
                self.star.make_room(len + count);
                self.row(index, count, Line { error, share, reference }, len);
                len += count;
            }
        }
        self.star.make_room(len);
        self.star.clear_lane(len);
        len.next_multiple_of(LANES)
    }

    /// Whole lanes; what is written behind the row's end will be written over.
    #[inline(always)]
    fn row(&mut self, index: usize, count: usize, line: Line<H>, len: usize) {
        let (per_tolerance, weights) = (self.meter.per_tolerance() as f32, &self.meter.tile().weights);
        let mut first = 0;
        while first < count {
            let lane = self.heights[index + first..].first_chunk::<LANES>().expect("a tile is padded");
            let along: [f32; LANES] = std::array::from_fn(|i| first as f32 + i as f32);
            let mut error: [f32; LANES] = std::array::from_fn(|i| {
                line.error[0] + line.error[1] * along[i] - lane[i].above(line.reference) * per_tolerance
            });
            let mut share: [f32; LANES] = std::array::from_fn(|i| line.share[0] + line.share[1] * along[i]);
            if !weights.is_empty() {
                let weights = weights[index + first..].first_chunk::<LANES>().expect("a tile is padded");
                error = std::array::from_fn(|i| error[i] * weights[i] as f32);
                share = std::array::from_fn(|i| share[i] * weights[i] as f32);
            }
            *self.star.error[len + first..].first_chunk_mut().expect("there is room") = error;
            *self.star.share[len + first..].first_chunk_mut().expect("there is room") = share;
            first += LANES;
        }
    }
}

impl Star {
    /// Makes room for `len` numbers and one more lane.
    #[inline(always)]
    fn make_room(&mut self, len: usize) {
        if len + LANES > self.error.len() {
            self.grow(len + LANES);
        }
    }

    #[cold]
    fn grow(&mut self, len: usize) {
        self.error.resize(len + len / 4, 0.0);
        self.share.resize(len + len / 4, 0.0);
    }

    #[inline(always)]
    fn clear_lane(&mut self, from: usize) {
        self.error[from..from + LANES].fill(0.0);
        self.share[from..from + LANES].fill(0.0);
    }
}

/// How samples fit at one height.
struct FitAt<'a> {
    share: &'a [f32],
    error: &'a [f32],
    rise: f32,
}

impl Kernel for FitAt<'_> {
    type Output = Fit;

    #[inline(always)]
    fn run<L: Lanes>(self, on: L) -> Fit {
        let Totals { energy, worst, .. } = totals(on, self.share, self.error, self.rise);
        Fit { energy: total(&on.parts(energy)), worst: largest(&on.parts(worst)), place: NONE }
    }
}

/// Sums where the star was read.
struct AtRest<'a> {
    share: &'a [f32],
    error: &'a [f32],
}

impl Kernel for AtRest<'_> {
    type Output = Sums;

    #[inline(always)]
    fn run<L: Lanes>(self, on: L) -> Sums {
        totals(on, self.share, self.error, 0.0).sums(on)
    }
}

impl<E: Copy> Totals<E> {
    #[inline(always)]
    fn sums<L: Lanes<Eight = E>>(self, on: L) -> Sums {
        let [energy, slope, curve] = [self.energy, self.slope, self.curve].map(|sum| total(&on.parts(sum)));
        Sums { energy, slope, curve }
    }
}

struct Newton<'a> {
    share: &'a [f32],
    error: &'a [f32],
    /// Sums at no rise, where they are known.
    at_rest: Option<Sums>,
    limit: f32,
}

impl Kernel for Newton<'_> {
    type Output = (f32, f32);

    #[inline(always)]
    fn run<L: Lanes>(self, on: L) -> (f32, f32) {
        let (mut best, mut least, mut rise) = (0.0, f32::INFINITY, 0.0);
        let mut known = self.at_rest;
        for _ in 0..NEWTON_STEPS {
            let sums = known.take().unwrap_or_else(
                #[inline(always)]
                || totals(on, self.share, self.error, rise).sums(on),
            );
            let Sums { energy, slope, curve } = sums;
            let falls = energy < least;
            if !falls {
                rise = best + (rise - best) * BACKTRACK;
                continue;
            }
            let slows = least - energy < SETTLED * least;
            (best, least) = (rise, energy);
            if energy - HOPE * slope * slope / curve >= self.limit {
                return (best, f32::INFINITY);
            }
            let step = -slope / curve;
            let moves = step.abs() > SETTLED;
            if slows || !moves || !step.is_finite() {
                break;
            }
            rise += step;
        }
        (best, least)
    }
}

/// Sums over whole lanes, in one fixed order. (What is not asked for is not computed: this is inlined.)
#[inline(always)]
fn totals<L: Lanes>(on: L, share: &[f32], error: &[f32], rise: f32) -> Totals<L::Eight> {
    let zero = on.all(0.0);
    let mut sums = Totals { energy: zero, worst: zero, slope: zero, curve: zero };
    let (rise, onset) = (on.all(rise), on.all(ONSET));
    for (share, error) in share.as_chunks::<LANES>().0.iter().zip(error.as_chunks::<LANES>().0) {
        let (share, error) = (on.of(*share), on.of(*error));
        let t = on.add(error, on.mul(share, rise));
        let size = on.abs(t);
        // What an error is beyond the onset, with its sign.
        let over = on.if_greater(size, onset, on.sub(t, on.if_greater(t, zero, onset, on.all(-ONSET))), zero);
        let stiff = on.if_greater(size, onset, on.all(2.0), zero);
        let t2 = on.mul(t, t);
        sums.energy = on.add(sums.energy, energies(on, size, on.all(PULL)));
        sums.worst = on.max(size, sums.worst);
        let pull = on.mul(on.mul(on.all(4.0 * PULL), t2), t);
        sums.slope = on.add(sums.slope, on.mul(share, on.add(on.mul(on.all(2.0), over), pull)));
        let bend = on.add(stiff, on.mul(on.all(12.0 * PULL), t2));
        sums.curve = on.add(sums.curve, on.mul(on.mul(share, share), bend));
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Tile;
    use crate::kernel::triangulate::Feasibility;
    use crate::kernel::triangulate::feasible::Tester;

    fn tile(weighted: bool) -> Tile {
        let noise = |i: usize| ((i * 7919 % 101) as f64 * 0.07 - 3.0) * ((i / 23) as f64 * 0.2);
        let tile = Tile::from_heights(23, 19, Heights::F64((0..23 * 19).map(noise).collect()));
        let weights = (0..23 * 19).map(|i| (i % 4) as f64 * 0.5).collect();
        if weighted { tile.with_weights(weights) } else { tile }
    }

    fn ring() -> Ring {
        let places = [(2, 3), (40, 1), (84, 20), (80, 66), (31, 70), (1, 44)];
        Ring::closed(places.map(|(x, y)| Vertex { at: Point { x, y }, height: f64::from(x - y) * 0.01 }))
    }

    /// The meter, which reads every triangle anew, is the oracle.
    #[test]
    fn a_star_read_once_knows_its_fits_at_every_height() {
        let ring = ring();
        for tile in [tile(false), tile(true)] {
            let meter = Meter::new(Tester::new(&tile, 2.0, Feasibility::Weak), 2.0);
            let apex = Vertex { at: Point { x: 45, y: 33 }, height: 0.3 };
            let mut star = Star::default();
            star.read(&ring, apex, &meter);
            for rise in [-2.0f32, -0.3, 0.0, 0.7, 5.0] {
                let raised = Vertex { height: apex.height + f64::from(rise) * 2.0, ..apex };
                for i in 0..ring.triangles() {
                    let [from, to] = ring.edge(i);
                    let corners = [raised, from, to];
                    let (fit, known) = (meter.fit(corners, f32::INFINITY), star.fit(i, rise));
                    assert!((fit.worst - known.worst).abs() <= 1e-4 * fit.worst, "{fit:?} {known:?}");
                    assert!((fit.energy - known.energy).abs() <= 1e-3 * fit.energy, "{fit:?} {known:?}");
                }
            }
        }
    }

    #[test]
    fn three_equations() {
        let matrix = [[4.0, 1.0, -2.0], [1.0, 9.0, 3.0], [-2.0, 3.0, 16.0]];
        let [x, y, z] = [0.5, -2.0, 3.0];
        let right = matrix.map(|[a, b, c]| a * x + b * y + c * z);
        let solution = solve(matrix, right);
        assert!(solution.iter().zip([x, y, z]).all(|(s, t)| (s - t).abs() < 1e-12), "{solution:?}");
    }

    #[test]
    fn no_other_height_is_better_than_the_best_and_a_step_leads_down() {
        let (ring, tile) = (ring(), tile(false));
        let energy = |star: &Star, rise: f32| -> f32 { (0..ring.triangles()).map(|i| star.fit(i, rise).energy).sum() };
        for feasibility in [Feasibility::Weak, Feasibility::Strong] {
            let meter = Meter::new(Tester::new(&tile, 2.0, feasibility), 2.0);
            let apex = Vertex { at: Point { x: 45, y: 33 }, height: 9.0 };
            let mut star = Star::default();
            star.read(&ring, apex, &meter);
            let (rise, least) = star.best_rise(f32::INFINITY);
            assert_eq!(star.best_rise(least * 1.001), (rise, least), "what comes below the limit is not dropped");
            assert_eq!(star.best_rise(-1e9).1, f32::INFINITY);
            let [x, y, up] = star.step([true; 2]);
            assert!(rise < 0.0 && up < 0.0 && least < energy(&star, 0.0), "{rise} {least}");
            if feasibility == Feasibility::Weak {
                for other in [-0.1, -0.02, 0.02, 0.1] {
                    assert!(least <= energy(&star, rise + other) * 1.001, "{rise} {least}");
                }
            }
            let part = 0.3;
            let at = Point { x: 45 + (x * part).round() as i32, y: 33 + (y * part).round() as i32 };
            let before = energy(&star, 0.0);
            star.read(&ring, Vertex { at, height: 9.0 + up * part * 2.0 }, &meter);
            assert!(energy(&star, 0.0) < before);
        }
    }
}
