//! The limit on straying along one edge: between samples, a surface stays in the range of the heights around it.
//!
//! A *side* is the segment between two neighbouring samples of a row or a column that both have a height. Along it a mesh is
//! linear but where its edges cross, and at samples it is within the tolerance; so it is enough to look at the crossings.
//! There an edge is to lie between the two heights, give or take a multiple of the tolerance. Diagonals of cells do not
//! count. Heights in doubles settle all but near ties; those are settled exactly.

use crate::base::exact;
use crate::base::lattice::STEPS;
use crate::base::mesh::Vertex;
use crate::base::{Heights, Tile};

/// A bound of the rounding error of a crossing's height less a limit, as a share of the largest height of the edge and the
/// limit together: six roundings of numbers at most twice that.
const DOUBT: f64 = 16.0 * f64::EPSILON;
/// What is closer to a sample than this part of a cell is at it: crossings have denominators below 2²², and are found to
/// better than 2⁻²⁵.
const AT_SAMPLE: f64 = 1.0 / (1u64 << 24) as f64;

/// How far an edge may be from the range of the two samples of a side that it crosses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Limit {
    factor: f64,
    tolerance: f64,
    /// Where samples have no weights.
    plain: f64,
}

/// A side that an edge crosses beyond the limit: column and row of its two samples, the nearer one first.
pub type Side = [(usize, usize); 2];

impl Limit {
    pub(super) fn new(factor: f64, tolerance: f64) -> Limit {
        Limit { factor, tolerance, plain: product_down(factor, tolerance) }
    }

    pub(super) fn is_none(&self) -> bool {
        self.factor == f64::INFINITY
    }

    /// What holds on a side: the larger of its samples' limits, times the factor.
    fn on(&self, tile: &Tile, [p, q]: Side) -> f64 {
        if !tile.is_weighted() {
            return self.plain;
        }
        let weight = tile.weight(p.0, p.1).min(tile.weight(q.0, q.1));
        product_down(self.factor, exact::limit(weight, self.tolerance))
    }
}

/// The largest double up to the product of two numbers that are not negative, as far as tolerances go.
fn product_down(a: f64, b: f64) -> f64 {
    let product = a * b;
    let is_above = product.is_finite() && a.mul_add(b, -product) < 0.0;
    if is_above { product.next_down() } else { product }.min(exact::MAX_TOLERANCE)
}

/// Visits the crossings of the edge p–q that are beyond the limit until one is taken. Returns whether one was.
pub(super) fn any(tile: &Tile, limit: &Limit, p: Vertex, q: Vertex, mut visit: impl FnMut(Side) -> bool) -> bool {
    if limit.is_none() {
        return false;
    }
    match &tile.heights {
        Heights::F32(heights) => Edge { tile, heights, limit, p, q }.any(&mut visit),
        Heights::F64(heights) => Edge { tile, heights, limit, p, q }.any(&mut visit),
    }
}

/// The integer below a number that is not next to one. By an addition that leaves no room for a fraction: a conversion that saturates
/// takes several times as long.
#[inline(always)]
fn floor(value: f64) -> i32 {
    const NO_FRACTION: f64 = 1.5 * (1u64 << 52) as f64;
    (value - 0.5 + NO_FRACTION).to_bits() as i32
}

/// One instruction each, as no number here is none.
#[inline(always)]
fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// [`Edge::is_doubtful`] along columns and rows, compiled for what the processor has.
struct Doubtful<'a, 'b, H> {
    edge: &'a Edge<'b, H>,
    walks: [Walk; 2],
}

impl<H: Copy + Into<f64>> pulp::WithSimd for Doubtful<'_, '_, H> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> bool {
        self.edge.is_doubtful(self.walks[0]) || self.edge.is_doubtful(self.walks[1])
    }
}

/// Steps from a line to those that are looked at with it.
const LANE: [f64; 4] = [0.0, STEPS as f64, 2.0 * STEPS as f64, 3.0 * STEPS as f64];

struct Edge<'a, H> {
    tile: &'a Tile,
    heights: &'a [H],
    limit: &'a Limit,
    p: Vertex,
    q: Vertex,
}

/// The edge as it crosses lines of one family: from the lower line to the higher.
#[derive(Clone, Copy)]
struct Walk {
    /// Place across the lines and along them, in lattice steps.
    from: (i32, i32),
    to: (i32, i32),
    near: f64,
    far: f64,
    /// Whether lines are columns.
    columns: bool,
}

/// What a walk has from one lattice step to the next, across the lines: places along them, and heights.
struct Slopes {
    slope: f64,
    rise: f64,
}

impl Walk {
    /// The first and the last line that is crossed between the ends.
    #[inline(always)]
    fn lines(&self) -> (i32, i32) {
        (self.from.0.div_euclid(STEPS) + 1, (self.to.0 - 1).div_euclid(STEPS))
    }

    #[inline(always)]
    fn slopes(&self) -> Slopes {
        let per_step = 1.0 / f64::from(self.to.0 - self.from.0);
        Slopes { slope: f64::from(self.to.1 - self.from.1) * per_step, rise: (self.far - self.near) * per_step }
    }

    #[inline(always)]
    fn reach(&self) -> f64 {
        self.near.abs().max(self.far.abs())
    }

    fn sample(&self, line: i32, along: i32) -> (usize, usize) {
        let (line, along) = (line as usize, along as usize);
        if self.columns { (line, along) } else { (along, line) }
    }
}

impl<H: Copy + Into<f64>> Edge<'_, H> {
    fn any(&self, visit: &mut impl FnMut(Side) -> bool) -> bool {
        let (p, q) = (self.p, self.q);
        let is_plain = !self.tile.is_weighted() && self.tile.validity.is_whole() && self.tile.unbound.is_empty();
        let walk = |columns: bool| {
            let place = |v: Vertex| if columns { (v.at.x, v.at.y) } else { (v.at.y, v.at.x) };
            let (a, b) = (place(p), place(q));
            let up = a.0 <= b.0;
            let ((from, near), (to, far)) =
                if up { ((a, p.height), (b, q.height)) } else { ((b, q.height), (a, p.height)) };
            Walk { from, to, near, far, columns }
        };
        let [across, down] = [walk(true), walk(false)];
        // Samples without heights and lines only take limits away.
        if !self.tile.is_weighted() && !pulp::Arch::new().dispatch(Doubtful { edge: self, walks: [across, down] }) {
            return false;
        }
        self.along(across, is_plain, visit) || self.along(down, is_plain, visit)
    }

    #[inline(always)]
    fn along(&self, walk: Walk, is_plain: bool, visit: &mut impl FnMut(Side) -> bool) -> bool {
        let (first, last) = walk.lines();
        if first > last {
            return false;
        }
        let Slopes { slope, rise } = walk.slopes();
        let reach = walk.reach();
        let (across, along) = self.strides(&walk);
        for line in first..=last {
            let done = f64::from(line * STEPS - walk.from.0);
            let place = (f64::from(walk.from.1) + slope * done) * (1.0 / f64::from(STEPS));
            let before = floor(place);
            let part = place - f64::from(before);
            let before = before as usize;
            if !(AT_SAMPLE..=1.0 - AT_SAMPLE).contains(&part) {
                continue;
            }
            let index = line as usize * across + before * along;
            let (z0, z1): (f64, f64) = (self.heights[index].into(), self.heights[index + along].into());
            let height = walk.near + rise * done;
            let (least, largest) = (smaller(z0, z1), larger(z0, z1));
            let beyond = larger(height - largest, least - height);
            let limit = if is_plain { Some(self.limit.plain) } else { self.limit_on(&walk, line, before) };
            let Some(limit) = limit else { continue };
            let doubt = DOUBT * (reach + limit);
            if beyond < limit - doubt {
                continue;
            }
            let strays = beyond > limit + doubt || !self.within(&walk, line, [least, largest], limit);
            if strays {
                let mut side = [before, before + 1].map(|i| walk.sample(line, i as i32));
                if part > 0.5 {
                    side.swap(0, 1);
                }
                if visit(side) {
                    return true;
                }
            }
        }
        false
    }

    /// What one line has the next sample after, and one place along it.
    #[inline(always)]
    fn strides(&self, walk: &Walk) -> (usize, usize) {
        if walk.columns { (1, self.tile.width) } else { (self.tile.width, 1) }
    }

    /// Whether a crossing may be beyond the limit of a tile that has no others: four at a time.
    #[inline(always)]
    fn is_doubtful(&self, walk: Walk) -> bool {
        const LANES: usize = 4;
        let (first, last) = walk.lines();
        if first > last {
            return false;
        }
        let Slopes { slope, rise } = walk.slopes();
        let (across, along) = self.strides(&walk);
        let near_limit = self.limit.plain - DOUBT * (walk.reach() + self.limit.plain);
        let (from, near) = (f64::from(walk.from.1), walk.near);
        let mut line = first;
        while line <= last {
            let start = f64::from(line * STEPS - walk.from.0);
            let (mut places, mut low, mut high) = ([0.0; LANES], [0.0f64; LANES], [0.0f64; LANES]);
            for i in 0..LANES {
                // Those past the last line are the last line's.
                let done = smaller(start + LANE[i], f64::from(last * STEPS - walk.from.0));
                places[i] = (from + slope * done) * (1.0 / f64::from(STEPS));
            }
            let mut befores = [0; LANES];
            for i in 0..LANES {
                befores[i] = floor(places[i]);
            }
            for i in 0..LANES {
                let index = (line + i as i32).min(last) as usize * across + befores[i] as usize * along;
                // Next to the tile's far side, at a sample, there is no other one.
                let other = (index + along).min(self.heights.len() - 1);
                (low[i], high[i]) = (self.heights[index].into(), self.heights[other].into());
            }
            let mut is_doubtful = false;
            for i in 0..LANES {
                let done = smaller(start + LANE[i], f64::from(last * STEPS - walk.from.0));
                let height = near + rise * done;
                let beyond = larger(height - larger(low[i], high[i]), smaller(low[i], high[i]) - height);
                let part = places[i] - f64::from(befores[i]);
                is_doubtful |= beyond >= near_limit && (AT_SAMPLE..=1.0 - AT_SAMPLE).contains(&part);
            }
            if is_doubtful {
                return true;
            }
            line += LANES as i32;
        }
        false
    }

    /// The limit on a side; none where a sample of it has no height, or where it is near a line.
    #[inline(never)]
    fn limit_on(&self, walk: &Walk, line: i32, before: usize) -> Option<f64> {
        let side = [before, before + 1].map(|i| walk.sample(line, i as i32));
        let has_height = |&(column, row): &(usize, usize)| self.tile.validity.has_height(column as i32, row as i32);
        let binds = self.tile.validity.is_whole() || side.iter().all(has_height);
        (binds && !self.tile.is_unbound(side)).then(|| self.limit.on(self.tile, side))
    }

    /// Whether the edge is within the limit of the range where it crosses a line, exactly.
    #[cold]
    #[inline(never)]
    fn within(&self, walk: &Walk, line: i32, [least, largest]: [f64; 2], limit: f64) -> bool {
        let span = i64::from(walk.to.0 - walk.from.0);
        let done = i64::from(line * STEPS - walk.from.0);
        let from = |z: f64| [(span, z), (done - span, walk.near), (-done, walk.far)];
        let is_above = exact::sign(&from(largest)).is_lt();
        let is_below = exact::sign(&from(least)).is_gt();
        (!is_above || exact::within(&from(largest), span, limit))
            && (!is_below || exact::within(&from(least), span, limit))
    }
}
