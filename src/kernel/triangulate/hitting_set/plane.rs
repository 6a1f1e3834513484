//! The plane of least maximum error over the samples of a rectangle, as a linear programme.
//!
//! Its unknowns are the plane's three coefficients and its error t, which is to be least. Samples are added one by one,
//! in a fixed order that scatters them, and the optimum changes only with one that is farther than t: it is then among those
//! that decide it (Seidel 1990). Where Seidel solves a programme of one variable fewer, the new sample here takes the
//! place of that one of the four that decide which leaves the largest t (the basis exchange of Sharir & Welzl 1992),
//! and samples are gone through in turn until all are within t. As t only grows, a subset that no plane fits is told as
//! soon as four of its samples say so, and these are the proof.

use crate::base::Tile;
use crate::base::exact;
use crate::base::lattice::{Point, orient};

#[cfg(test)]
mod tests;

/// A rectangle of samples: columns and rows from the first to the last, both among them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Region {
    pub(super) first: (usize, usize),
    pub(super) last: (usize, usize),
}

impl Region {
    pub(super) fn width(&self) -> usize {
        self.last.0 - self.first.0 + 1
    }

    pub(super) fn height(&self) -> usize {
        self.last.1 - self.first.1 + 1
    }

    /// Upper left, upper right, lower right, lower left.
    pub(super) fn corners(&self) -> [(usize, usize); 4] {
        let (Region { first, last }, corner) = (self, |column, row| (column, row));
        [*first, corner(last.0, first.1), *last, corner(first.0, last.1)]
    }

    /// Whether it is one sample wide or tall.
    pub(super) fn is_thin(&self) -> bool {
        self.width() == 1 || self.height() == 1
    }
}

/// A plane over a rectangle of samples, in doubles.
#[derive(Debug, Clone, Copy)]
pub struct Plane {
    origin: (f64, f64),
    base: f64,
    /// Height above `base` at the origin, and the rise to the next column and the next row.
    constant: f64,
    slope: [f64; 2],
}

impl Plane {
    /// Its height at a column and row.
    pub fn at(&self, (column, row): (usize, usize)) -> f64 {
        self.base + self.above(column as f64 - self.origin.0, row as f64 - self.origin.1)
    }

    #[inline(always)]
    fn above(&self, x: f64, y: f64) -> f64 {
        self.constant + self.slope[0] * x + self.slope[1] * y
    }
}

/// At most four samples that no plane is within the tolerance of, as columns and rows; some perhaps twice.
pub type Certificate = [(usize, usize); 4];

/// Whether no plane is within the tolerance (the limits, where samples have weights) of four samples, exactly.
///
/// Four places depend on each other by Σ wᵢ = 0 and Σ wᵢ·pᵢ = 0, with areas as weights. A plane's heights there sum up
/// to 0 with them, so its errors sum up to Σ wᵢ·zᵢ, and one of them is more than its limit if that is more than Σ |wᵢ|
/// · limitᵢ. By Farkas' lemma no plane fits only then. Where all places are on a line the same holds for three of them.
pub fn excludes_planes(tile: &Tile, tolerance: f64, samples: &Certificate) -> bool {
    let at = |i: usize| Point { x: samples[i].0 as i32, y: samples[i].1 as i32 };
    let area = |i, j, k| orient(at(i), at(j), at(k));
    let weights = [area(1, 2, 3), -area(0, 2, 3), area(0, 1, 3), -area(0, 1, 2)];
    if weights != [0; 4] {
        return exceeds_limits(tile, tolerance, samples, weights);
    }
    // Along a line columns tell places apart, or rows do.
    let place = |i: usize| i64::from(at(i).x) * (1 << 20) + i64::from(at(i).y);
    [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]].into_iter().any(|[i, j, k]| {
        let mut weights = [0; 4];
        (weights[i], weights[j], weights[k]) = (place(k) - place(j), place(i) - place(k), place(j) - place(i));
        exceeds_limits(tile, tolerance, samples, weights)
    })
}

fn exceeds_limits(tile: &Tile, tolerance: f64, samples: &Certificate, weights: [i64; 4]) -> bool {
    let scale: i64 = weights.iter().map(|w| w.abs()).sum();
    let heights = [0, 1, 2, 3].map(|i| (weights[i], tile.at(samples[i].0, samples[i].1)));
    if !tile.is_weighted() {
        return scale > 0 && !exact::within(&heights, scale, tolerance);
    }
    let limit = |i: usize| tile.limit(samples[i].0, samples[i].1, tolerance);
    [1, -1].into_iter().any(|side| {
        let mut terms = [(0, 0.0); 8];
        for i in 0..4 {
            terms[i] = (side * heights[i].0, heights[i].1);
            terms[4 + i] = (-weights[i].abs(), limit(i));
        }
        exact::sign(&terms).is_gt()
    })
}

/// A sample as the programme sees it: its place is moved by less than a millionth of a cell, so that no three are on a
/// line and every four decide a plane. What that does to heights is below the rounding of heights, and proofs are made
/// without it.
#[derive(Debug, Clone, Copy, Default)]
struct Sample {
    x: f64,
    y: f64,
    z: f64,
    /// Errors count in multiples of this: 1 ÷ weight.
    unit: f64,
    place: (usize, usize),
}

/// Four samples, the plane with equal errors at them, and that error.
#[derive(Debug, Clone, Copy)]
struct Basis {
    samples: [Sample; 4],
    error: f64,
    /// Heights at the origin and slopes, as in [`Plane`].
    plane: [f64; 3],
}

fn area(a: &Sample, b: &Sample, c: &Sample) -> f64 {
    (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)
}

impl Basis {
    fn new(samples: [Sample; 4]) -> Basis {
        let [a, b, c, d] = &samples;
        let weights = [area(b, c, d), -area(a, c, d), area(a, b, d), -area(a, b, c)];
        let sum: f64 = weights.iter().zip(&samples).map(|(w, s)| w * s.z).sum();
        let scale: f64 = weights.iter().zip(&samples).map(|(w, s)| w.abs() * s.unit).sum();
        let error = sum.abs() / scale;
        // Through three of them, those that lie apart most: at each the plane is the error away, on the side of its weight.
        let farthest = (0..4).reduce(|i, j| if weights[j].abs() > weights[i].abs() { j } else { i }).unwrap_or(0);
        let [a, b, c] = [1, 2, 3].map(|k| (farthest + k) % 4).map(|i| {
            let Sample { x, y, z, unit, .. } = samples[i];
            (x, y, z - error * unit * weights[i].signum() * sum.signum())
        });
        let (ux, uy, uz) = (b.0 - a.0, b.1 - a.1, b.2 - a.2);
        let (vx, vy, vz) = (c.0 - a.0, c.1 - a.1, c.2 - a.2);
        let double = ux * vy - uy * vx;
        let (across, down) = ((uz * vy - vz * uy) / double, (ux * vz - vx * uz) / double);
        Basis { samples, error, plane: [a.2 - across * a.0 - down * a.1, across, down] }
    }

    #[inline(always)]
    fn residual(&self, sample: &Sample) -> f64 {
        let [constant, across, down] = self.plane;
        (sample.z - (constant + across * sample.x + down * sample.y)).abs()
    }

    fn certificate(&self) -> Certificate {
        self.samples.map(|sample| sample.place)
    }

    fn excludes_planes(&self, tile: &Tile, tolerance: f64) -> bool {
        self.error > tolerance && excludes_planes(tile, tolerance, &self.certificate())
    }

    /// With another sample in the place of the one that leaves the largest error.
    fn exchanged(&self, sample: Sample) -> Basis {
        let with = |i: usize| {
            let mut samples = self.samples;
            samples[i] = sample;
            Basis::new(samples)
        };
        (1..4).map(with).fold(with(0), |best, basis| if basis.error > best.error { basis } else { best })
    }
}

/// The plane of least maximum error over a rectangle of samples, from column and row of the first to those of the last;
/// or four of them that no plane is within the tolerance of, which [`excludes_planes`] confirms exactly. The plane is
/// off by rounding, and is to be tested: where the tolerance is the least error or next to it, it may fail all the
/// same. Where fewer than four samples have a height it is level.
///
/// # Panics
/// If a sample is outside the tile.
pub fn least_plane(
    tile: &Tile,
    tolerance: f64,
    first: (usize, usize),
    last: (usize, usize),
) -> Result<Plane, Certificate> {
    least(tile, tolerance, Region { first, last })
}

/// More exchanges than this are never needed but where rounding decides; then the plane found so far is taken.
const MOST_EXCHANGES: u32 = 1000;
/// What errors may be off by, as a share of the heights' range around the first sample.
const NOISE: f64 = 1e-10;

/// The plane of least maximum error over those samples of a region that have a height, or a proof that none is within the
/// tolerance. Cost: measured close to linear in the samples for a plane, and mostly far less for a proof.
pub(super) fn least(tile: &Tile, tolerance: f64, region: Region) -> Result<Plane, Certificate> {
    let mut walk = Walk::new(tile, region);
    let mut first = [Sample::default(); 4];
    let mut known = 0;
    while known < 4 {
        let Some(sample) = walk.next().filter(|_| walk.passed <= walk.count) else {
            return Ok(walk.level(first[0].z));
        };
        first[known] = sample;
        known += 1;
    }
    let (mut basis, mut exchanges, mut reach) = (Basis::new(first), 0, 0.0f64);
    if basis.excludes_planes(tile, tolerance) {
        return Err(basis.certificate());
    }
    // All samples in turn, until each has been within the error of one and the same basis.
    let mut settled = walk.passed;
    while let Some(sample) = walk.next() {
        if walk.passed - settled > walk.count || exchanges == MOST_EXCHANGES {
            break;
        }
        reach = reach.max(sample.z.abs());
        if basis.residual(&sample) <= basis.error * sample.unit + NOISE * reach {
            continue;
        }
        let exchanged = basis.exchanged(sample);
        // What is not larger is the rounding of places that lie almost on a line.
        if exchanged.error > basis.error {
            basis = exchanged;
            (settled, exchanges) = (walk.passed, exchanges + 1);
            if basis.excludes_planes(tile, tolerance) {
                return Err(basis.certificate());
            }
        }
    }
    let [constant, across, down] = basis.plane;
    Ok(Plane { constant, slope: [across, down], ..walk.level(0.0) })
}

/// The samples of a region in an order that scatters them, the same for every region of a size: steps of about the golden
/// section of their number.
struct Walk<'a> {
    tile: &'a Tile,
    region: Region,
    width: usize,
    count: usize,
    stride: usize,
    index: usize,
    /// Samples passed, without a height or with one, again in every round.
    passed: usize,
    base: f64,
}

impl<'a> Walk<'a> {
    fn new(tile: &'a Tile, region: Region) -> Walk<'a> {
        // What is one sample wide counts twice, side by side: then a plane is as good as a line.
        let twice = |len: usize| if len == 1 { 2 } else { len };
        let (width, height) = (twice(region.width()), twice(region.height()));
        let count = width * height;
        let mut stride = (count as f64 * GOLDEN) as usize | 1;
        while common_divisor(stride, count) > 1 {
            stride += 2;
        }
        let base = tile.at(region.first.0, region.first.1);
        Walk { tile, region, width, count, stride: stride % count, index: SEED % count, passed: 0, base }
    }

    fn level(&self, constant: f64) -> Plane {
        let origin = (self.region.first.0 as f64, self.region.first.1 as f64);
        Plane { origin, base: self.base, constant, slope: [0.0; 2] }
    }

    /// The next sample that binds, again and again; none where there is none.
    #[inline(always)]
    fn next(&mut self) -> Option<Sample> {
        for _ in 0..self.count {
            let (x, y) = ((self.index % self.width) as u32, (self.index / self.width) as u32);
            self.passed += 1;
            self.index += self.stride;
            if self.index >= self.count {
                self.index -= self.count;
            }
            let Region { first, last } = self.region;
            let place = ((first.0 + x as usize).min(last.0), (first.1 + y as usize).min(last.1));
            if !self.tile.validity.is_whole() && !self.tile.validity.has_height(place.0 as i32, place.1 as i32) {
                continue;
            }
            let mut unit = 1.0;
            if self.tile.is_weighted() {
                unit = 1.0 / self.tile.weight(place.0, place.1);
                if unit > LARGEST_UNIT {
                    continue;
                }
            }
            let [move_x, move_y] = moves(x, y);
            let z = self.tile.at(place.0, place.1) - self.base;
            return Some(Sample { x: f64::from(x) + move_x, y: f64::from(y) + move_y, z, unit, place });
        }
        None
    }
}

const GOLDEN: f64 = 0.618_033_988_75;
/// Where the walk begins.
const SEED: usize = 0x5eed;
/// Samples whose errors weigh less bind nothing.
const LARGEST_UNIT: f64 = 1e12;

fn common_divisor(a: usize, b: usize) -> usize {
    if b == 0 { a } else { common_divisor(b, a % b) }
}

/// By what a place is moved: up to 2⁻²⁰ of a cell either way.
#[inline(always)]
fn moves(x: u32, y: u32) -> [f64; 2] {
    let mut hash = x.wrapping_mul(0x9e37_79b1) ^ y.wrapping_mul(0x85eb_ca77);
    for factor in [0x7feb_352d, 0x846c_a68b] {
        hash = (hash ^ (hash >> 16)).wrapping_mul(factor);
    }
    hash ^= hash >> 15;
    const UNIT: f64 = 1.0 / (1u64 << 35) as f64;
    [f64::from((hash & 0xffff) as i32 - 0x8000) * UNIT, f64::from((hash >> 16) as i32 - 0x8000) * UNIT]
}
