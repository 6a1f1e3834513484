use super::frame::Frame;
use super::places::nearest_sample;
use crate::field::Heights;
use crate::mesh::Vertex;
use crate::triangulate::feasible::Tester;

/// A ray from an edge's middle into the ground, by how far it leans: in units of the edge's length, the place at `away`
/// has `along` = ½ + lean · away.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ray {
    pub(super) lean: f64,
    /// The farthest candidate.
    pub(super) last: u32,
}

/// Candidates on a ray, as a set of bits: bit k stands for the place [`away`]`(k)`.
pub(super) type Candidates = u32;

/// Candidates of a ray: eight octaves of four.
pub(super) const CANDIDATES: u32 = 32;

/// A candidate's distance from the edge's line, in edge lengths: 2 for the last, four to an octave.
#[inline(always)]
pub(super) fn away(candidate: u32) -> f64 {
    f64::from_bits((FIRST + u64::from(candidate)) << MANTISSA_REST)
}

/// The least candidate that is at least so far away; [`CANDIDATES`] if none is.
#[inline(always)]
pub(super) fn candidate_at(away: f64) -> u32 {
    let above = ((away.to_bits().wrapping_sub(1)) >> MANTISSA_REST) + 1;
    above.saturating_sub(FIRST).min(u64::from(CANDIDATES)) as u32
}

/// A positive double's exponent and the two highest bits of its mantissa count quarters of octaves.
const MANTISSA_REST: u32 = 50;
const FIRST: u64 = (2.0f64.to_bits() >> MANTISSA_REST) + 1 - CANDIDATES as u64;

/// Candidates whose samples are read at once.
const WINDOW: u32 = 2;

/// A bound of the rounding error of a height above the edge, as a share of the numbers it comes from.
const DOUBT: f64 = 16.0 * f64::EPSILON;

impl Ray {
    pub(super) fn lean_away(&self, frame: &Frame, candidate: u32) -> (f64, f64) {
        let away = away(candidate);
        frame.place(0.5 + self.lean * away, away)
    }

    /// The vertex at the sample nearest to a candidate.
    pub(super) fn apex(&self, frame: &Frame, tester: &Tester<'_>, candidate: u32) -> Option<Vertex> {
        let (column, row) = self.lean_away(frame, candidate);
        nearest_sample(tester, column, row)
    }

    /// How far the triangle over the edge, growing along the ray, has grown when it reaches a place; infinite or
    /// negative where it never does.
    #[inline(always)]
    pub(super) fn arrival(&self, along: f64, away: f64) -> f64 {
        let aside = 2.0 * (along - self.lean * away) - 1.0;
        away / (1.0 - aside.abs())
    }
}

/// The feasible-tilt sweep: those of a ray's candidates from `first` on whose triangles over the edge are feasible, as
/// far as their apexes lie on the ray.
pub(super) fn sweep(tester: &Tester<'_>, frame: &Frame, ray: &Ray, first: u32) -> Candidates {
    match &tester.tile().heights {
        Heights::F32(heights) => sweep_heights(tester, heights, frame, ray, first),
        Heights::F64(heights) => sweep_heights(tester, heights, frame, ray, first),
    }
}

fn sweep_heights<R: Copy + Into<f64>>(
    tester: &Tester<'_>,
    heights: &[R],
    frame: &Frame,
    ray: &Ray,
    first: u32,
) -> Candidates {
    let mut tilts = Tilts::new();
    let mut feasible = 0;
    let mut inner = Outline::default();
    let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
    let mut next = first;
    while next <= ray.last {
        let end = (next + WINDOW - 1).min(ray.last);
        let outer = Outline::new(frame, ray.lean_away(frame, end), tester.tile().width(), tester.tile().height());
        tilts.read(tester, heights, frame, ray, &outer, &inner, next);
        for candidate in next..=end {
            low = low.max(tilts.low[candidate as usize]);
            high = high.min(tilts.high[candidate as usize]);
            if low > high {
                return feasible;
            }
            if let Some(apex) = ray.apex(frame, tester, candidate) {
                let (along, away) = frame.coordinates(apex.at);
                let tilt = frame.above(along, apex.height) / away;
                if away > 0.0 && low <= tilt && tilt <= high {
                    feasible |= 1 << candidate;
                }
            }
        }
        inner = outer;
        next = end + 1;
    }
    feasible
}

/// For each candidate, the tilts allowed by the samples that the triangle reaches on the way to it from the one before.
struct Tilts {
    low: [f64; CANDIDATES as usize + 1],
    high: [f64; CANDIDATES as usize + 1],
}

impl Tilts {
    fn new() -> Tilts {
        Tilts { low: [f64::NEG_INFINITY; CANDIDATES as usize + 1], high: [f64::INFINITY; CANDIDATES as usize + 1] }
    }

    /// Reads the samples between two outlines.
    #[inline(always)]
    #[allow(clippy::too_many_arguments)]
    fn read<R: Copy + Into<f64>>(
        &mut self,
        tester: &Tester<'_>,
        heights: &[R],
        frame: &Frame,
        ray: &Ray,
        outer: &Outline,
        inner: &Outline,
        next: u32,
    ) {
        for row in outer.first_row..=outer.last_row {
            let (left, right) = outer.columns(row);
            let (inner_left, inner_right) = inner.columns_or_none(row);
            if inner_left > inner_right {
                self.read_row(tester, heights, frame, ray, row, left, right, next);
            } else {
                self.read_row(tester, heights, frame, ray, row, left, inner_left - 1, next);
                self.read_row(tester, heights, frame, ray, row, inner_right + 1, right, next);
            }
        }
    }

    #[inline(always)]
    #[allow(clippy::too_many_arguments)]
    fn read_row<R: Copy + Into<f64>>(
        &mut self,
        tester: &Tester<'_>,
        heights: &[R],
        frame: &Frame,
        ray: &Ray,
        row: i32,
        left: i32,
        right: i32,
        next: u32,
    ) {
        if left > right {
            return;
        }
        let (along0, away0) = frame.coordinates(crate::lattice::Point::of_sample(left, row));
        let (along_step, away_step) = frame.step();
        let base = row as usize * tester.tile().width() + left as usize;
        let tolerance = tester.tolerance();
        let magnitude = frame.magnitude() + tolerance;
        for (i, &height) in heights[base..base + (right - left + 1) as usize].iter().enumerate() {
            let along = along0 + along_step * i as f64;
            let away = away0 + away_step * i as f64;
            if away < 1e-12 {
                continue;
            }
            let above = frame.above(along, height.into());
            let slack = tolerance + (above.abs() + magnitude) * DOUBT;
            let inverse = 1.0 / away;
            let arrival = ray.arrival(along, away);
            if !(arrival > 0.0) {
                continue;
            }
            let candidate = candidate_at(arrival).max(next) as usize;
            self.low[candidate] = self.low[candidate].max((above - slack) * inverse);
            self.high[candidate] = self.high[candidate].min((above + slack) * inverse);
        }
    }
}

/// The samples of a triangle whose apex need not be on the lattice, as a span of columns for each row.
#[derive(Debug, Clone, Copy)]
struct Outline {
    first_row: i32,
    last_row: i32,
    /// Two lines that bound the columns from the left and two from the right: at row 0, and per row.
    left: [(f64, f64); 2],
    right: [(f64, f64); 2],
    last_column: f64,
}

const NUDGE: f64 = 1e-7;

impl Default for Outline {
    fn default() -> Outline {
        Outline { first_row: 0, last_row: -1, left: [(0.0, 0.0); 2], right: [(0.0, 0.0); 2], last_column: 0.0 }
    }
}

impl Outline {
    fn new(frame: &Frame, apex: (f64, f64), width: usize, height: usize) -> Outline {
        let a = frame.place(0.0, 0.0);
        let b = frame.place(1.0, 0.0);
        let (mut left, mut right) = ([None; 2], [None; 2]);
        for (p, q) in [(a, b), (b, apex), (apex, a)] {
            let down = q.1 - p.1;
            let slope = (q.0 - p.0) / down;
            let line = Some((p.0 - slope * p.1, slope));
            let side = if down > 0.0 {
                &mut right
            } else if down < 0.0 {
                &mut left
            } else {
                continue;
            };
            side[usize::from(side[0].is_some())] = line;
        }
        let both = |side: [Option<(f64, f64)>; 2], none: f64| {
            let one = side[0].unwrap_or((none, 0.0));
            [one, side[1].unwrap_or(one)]
        };
        let rows = [a.1, b.1, apex.1];
        let (top, bottom) = rows.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(t, b), &r| (t.min(r), b.max(r)));
        Outline {
            first_row: ((top - NUDGE).ceil() as i32).max(0),
            last_row: ((bottom + NUDGE).floor() as i32).min(height as i32 - 1),
            left: both(left, 0.0),
            right: both(right, 0.0),
            last_column: (width - 1) as f64,
        }
    }

    #[inline(always)]
    fn columns(&self, row: i32) -> (i32, i32) {
        let row = f64::from(row);
        let at = |line: (f64, f64)| line.0 + line.1 * row;
        let left = at(self.left[0]).max(at(self.left[1])).max(0.0);
        let right = at(self.right[0]).min(at(self.right[1])).min(self.last_column);
        ((left + (1.0 - NUDGE)) as i32, (right + NUDGE).max(-1.0).floor() as i32)
    }

    #[inline(always)]
    fn columns_or_none(&self, row: i32) -> (i32, i32) {
        if row < self.first_row || row > self.last_row { (1, 0) } else { self.columns(row) }
    }
}
