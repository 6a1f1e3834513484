//! The error of a finished tile mesh, measured over every sample in a pass of its own.
//!
//! Nothing an engine noted on its way is used: every triangle is scanned again. A tile counts the samples it owns (a
//! sample on a seam belongs to the tile to its right or below, as seam vertices do), so that over all tiles every
//! sample is counted once. Where samples are missing, `ground` says who owns which, and who has seen which.

mod ground;
mod heights;
mod shape;
mod weighted;

pub use heights::{Extent, HeightStats};
pub use shape::{ANGLES, OVERSHOOTS, ShapeStats, shape};
pub use weighted::{WeightedStats, measure_weighted};

use std::ops::RangeInclusive;

use self::ground::Ground;
pub(crate) use self::ground::owns;
use crate::base::exact::MAX_TOLERANCE;
use crate::base::lattice::Point;
use crate::base::mesh::{TileMesh, Vertex};
use crate::base::tiling::TilePlace;
use crate::base::{Heights, Tile};
use crate::kernel::triangulate::feasible::{Plane, Spans};

/// How finely errors are sorted, from 0 to the tolerance.
pub const BINS: usize = 256;

/// Errors over a set of samples: vertical distances between surface and samples, in the heights' units.
#[derive(Debug, Clone, PartialEq)]
pub struct ErrorStats {
    /// How many samples were measured: those on the ground that have heights, but for what is trimmed.
    pub samples: u64,
    /// How many are no heights, or outside of the outlines that the mesh ends at.
    pub nodata: u64,
    /// How many are heights but in no cell with two others beside them, so that no ground reaches them.
    pub stray: u64,
    /// How many are on the ground as samples of bridged holes, without a height to measure by.
    pub bridged: u64,
    /// How many of those measured are beside lines with heights of their own: their errors are those beyond the interval between
    /// sample and line.
    pub beside: u64,
    /// How many are on the ground but left bare, as the rim is trimmed ([`crate::kernel::boundary`]).
    pub trimmed: u64,
    /// The largest error.
    pub max: f64,
    /// The largest error × weight; where errors are not weighted, the largest error.
    pub weighted_max: f64,
    /// Column and row of a sample that has it: the first, in the order of measuring.
    pub worst: (u64, u64),
    /// Sum of the squares of all errors.
    pub squares: f64,
    /// How many samples have an error (× weight) in each [`BINS`]-th of the tolerance; errors of 0 and 1/256 ε in the
    /// first.
    pub histogram: Box<[u64; BINS]>,
    /// The largest weighted error, where there are channels.
    pub extended: Option<WeightedStats>,
    /// The shapes of the triangles, where somebody has looked at them ([`shape`]).
    pub shape: Option<Box<ShapeStats>>,
    /// The heights of the samples, where somebody has looked at them ([`HeightStats::of`]).
    pub heights: Option<HeightStats>,
}

impl Default for ErrorStats {
    fn default() -> Self {
        let (max, worst, squares) = (0.0, (0, 0), 0.0);
        let histogram = Box::new([0; BINS]);
        let (samples, nodata, stray, bridged, beside, trimmed) = (0, 0, 0, 0, 0, 0);
        let (extended, shape, heights) = (None, None, None);
        ErrorStats {
            samples,
            nodata,
            stray,
            bridged,
            beside,
            trimmed,
            max,
            weighted_max: max,
            worst,
            squares,
            histogram,
            extended,
            shape,
            heights,
        }
    }
}

impl ErrorStats {
    /// Adds those of other samples. Sums of squares are rounded: add in a fixed order for the same bits.
    pub fn add(&mut self, other: &ErrorStats) {
        if other.max > self.max || self.samples == 0 {
            (self.max, self.worst) = (other.max, other.worst);
        }
        self.weighted_max = self.weighted_max.max(other.weighted_max);
        self.extended = WeightedStats::larger(self.extended, other.extended);
        if let Some(other) = &other.shape {
            self.shape.get_or_insert_default().add(other);
        }
        if let Some(other) = &other.heights {
            self.heights.get_or_insert_default().add(other);
        }
        self.samples += other.samples;
        self.nodata += other.nodata;
        self.stray += other.stray;
        self.bridged += other.bridged;
        self.beside += other.beside;
        self.trimmed += other.trimmed;
        self.squares += other.squares;
        for (sum, count) in self.histogram.iter_mut().zip(other.histogram.iter()) {
            *sum += count;
        }
    }

    /// Samples that were measured and others.
    pub fn all_samples(&self) -> u64 {
        self.samples + self.nodata + self.stray + self.bridged + self.trimmed
    }

    /// Root of the mean square error.
    pub fn rms(&self) -> f64 {
        if self.samples == 0 { 0.0 } else { (self.squares / self.samples as f64).sqrt() }
    }

    /// The error (× weight) that a share of the samples does not exceed, to 1/256 of the tolerance, rounded up but never
    /// above the maximum.
    pub fn percentile(&self, share: f64, tolerance: f64) -> f64 {
        let wanted = (share * self.samples as f64).ceil() as u64;
        let mut seen = 0;
        for (bin, count) in self.histogram.iter().enumerate() {
            seen += count;
            // Errors beyond what was expected are all in the last.
            if seen >= wanted && bin + 1 < BINS {
                return (tolerance * (bin + 1) as f64 / BINS as f64).min(self.weighted_max);
            }
        }
        self.weighted_max
    }
}

/// What is known of a mesh's errors before they are measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Bound {
    /// None exceeds this tolerance.
    Within(f64),
    /// Nothing; they are about so large.
    Scale(f64),
}

impl Bound {
    /// The most that an error may be.
    fn tolerance(self) -> f64 {
        match self {
            Bound::Within(tolerance) => tolerance,
            Bound::Scale(_) => MAX_TOLERANCE,
        }
    }
}

impl From<f64> for Bound {
    fn from(tolerance: f64) -> Self {
        Bound::Within(tolerance)
    }
}

/// What of the ground a mesh may leave bare, in cells from the next missing sample, as [`crate::kernel::boundary`] counts them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Bare {
    /// Nothing.
    #[default]
    Nothing,
    /// So much, by what the tile knows: it is the one that was trimmed.
    Strip(u32),
    /// So much, where the tile knows; it is another than those that were trimmed, which may have known more of what is
    /// missing around. A sample on its sides then belongs to the tile to the lower right, whoever has ground at it: only
    /// that one is sure to see the triangle over it.
    StripOfOthers(u32),
}

/// Measures `mesh` over the samples that the tile owns by its place ([`TilePlace::owned`]). Where samples are missing,
/// those on the ground are measured, and the tile also owns what its neighbours to the right and below have no ground at. Samples that may be bare, and are, are counted only.
///
/// # Panics
/// If the triangles do not cover every sample the tile owns exactly once, but for what may be bare, or one that is missing; or if, where a [`Bound::Within`] says so, one is
/// farther than its limit (the tolerance, or [`Tile::limit`]) from its triangle, or its weighted error is larger: an engine
/// is broken, and its mesh must not be written. With channels, if a vertex does not lie on a sample.
pub fn measure(tile: &Tile, mesh: &TileMesh, bound: impl Into<Bound>, place: &TilePlace, bare: Bare) -> ErrorStats {
    let bound = bound.into();
    let stats = measure_heights(tile, mesh, bound, place, bare);
    let owned = if tile.validity.is_whole() { place.owned() } else { (tile.width, tile.height) };
    let extended = weighted::over_owned(tile, mesh, place.origin(), owned).map(|found| found.within(bound));
    ErrorStats { extended, ..stats }
}

/// The same of the heights alone, whatever channels there are. Vertices may lie anywhere.
///
/// # Panics
/// As [`measure`].
pub fn measure_heights(
    tile: &Tile,
    mesh: &TileMesh,
    bound: impl Into<Bound>,
    place: &TilePlace,
    bare: Bare,
) -> ErrorStats {
    let bound = bound.into();
    let (Bound::Within(scale) | Bound::Scale(scale)) = bound;
    let tolerance = bound.tolerance();
    let (owned, origin) = (place.owned(), place.origin());
    assert_eq!(
        (place.window.width, place.window.height),
        (tile.width, tile.height),
        "samples of the tile at {origin:?}"
    );
    let bins_per_error = if scale > 0.0 { BINS as f64 / scale } else { 0.0 };
    let by_samples = !tile.validity.is_whole() || bare != Bare::Nothing;
    let ground = by_samples.then(|| Ground::new(tile, owned, bare));
    let mut meter = Meter {
        tile,
        tolerance,
        bins_per_error,
        owned,
        ground,
        doubt: 0.0,
        stats: ErrorStats::default(),
        worst: (0, 0),
    };
    match &tile.heights {
        Heights::F32(heights) => mesh.triangles.iter().for_each(|&t| meter.triangle(heights, mesh.corners(t))),
        Heights::F64(heights) if tile.is_weighted() => {
            let samples = (heights.as_slice(), tile.weights.as_slice());
            mesh.triangles.iter().for_each(|&t| meter.weighted_triangle(samples, mesh.corners(t)));
        }
        Heights::F64(heights) => mesh.triangles.iter().for_each(|&t| meter.triangle(heights, mesh.corners(t))),
    }
    let mut stats = meter.stats;
    stats.worst = (origin.0 + meter.worst.0 as u64, origin.1 + meter.worst.1 as u64);
    match &meter.ground {
        None => assert_eq!(stats.samples, (owned.0 * owned.1) as u64, "samples covered of a tile at {origin:?}"),
        Some(ground) => ground.finish(tile, &mut stats),
    }
    if !tile.is_weighted() {
        stats.weighted_max = stats.max;
        let (max, worst) = (stats.max, stats.worst);
        assert!(max <= tolerance, "error {max} at sample {worst:?}, {tolerance} is allowed");
    }
    stats
}

/// Heights and weights of a tile.
type Weighted<'a> = (&'a [f64], &'a [f64]);

struct Meter<'a> {
    tile: &'a Tile,
    tolerance: f64,
    bins_per_error: f64,
    owned: (usize, usize),
    /// Where samples are missing, or may be bare.
    ground: Option<Ground>,
    /// What rounding does to the errors in a triangle, at most.
    doubt: f64,
    stats: ErrorStats,
    worst: (usize, usize),
}

impl Meter<'_> {
    fn triangle<H: Copy + Into<f64>>(&mut self, heights: &[H], corners: [Vertex; 3]) {
        let [a, b, c] = corners;
        self.doubt = Plane::new(a, b, c).doubt();
        self.for_each_run(corners, |meter, run, at, start, plane| {
            meter.run(&heights[run], start, plane.step(), at, plane);
        });
    }

    fn weighted_triangle(&mut self, (heights, weights): Weighted<'_>, corners: [Vertex; 3]) {
        let [a, b, c] = corners;
        self.doubt = Plane::new(a, b, c).doubt();
        self.for_each_run(corners, |meter, run, at, start, plane| {
            meter.weighted_run(&heights[run.clone()], &weights[run], start, at, plane);
        });
    }

    /// Visits the runs of samples that a triangle owns: their places in the tile, column and row of the first and the
    /// surface there.
    #[inline(always)]
    fn for_each_run(
        &mut self,
        [a, b, c]: [Vertex; 3],
        mut visit: impl FnMut(&mut Self, RangeInclusive<usize>, (usize, usize), f64, &Plane),
    ) {
        let (spans, plane) = (Spans::new(a.at, b.at, c.at), Plane::new(a, b, c));
        if let Some(mut ground) = self.ground.take() {
            ground.for_each_run(&spans, |run, (column, row)| {
                let start = plane.at(Point::of_sample(column as i32, row as i32));
                visit(self, run, (column, row), start, &plane);
            });
            self.ground = Some(ground);
            return;
        }
        let (right_rim, lower_rim) = (self.tile.width as i32 - 1, self.tile.height as i32 - 1);
        for row in spans.rows() {
            let (first, last) = spans.own_columns(row, right_rim, lower_rim);
            // Triangles may reach beyond the tile.
            let (first, last) = (first.max(0), last.min(self.owned.0 as i32 - 1));
            if first > last || row as usize >= self.owned.1 {
                continue;
            }
            let base = row as usize * self.tile.width;
            let start = plane.at(Point::of_sample(first, row));
            let run = base + first as usize..=base + last as usize;
            visit(self, run, (first as usize, row as usize), start, &plane);
        }
    }

    /// Samples of a row, the surface at the first of them and its rise to the next, and where the first is. Runs are
    /// short, a handful of samples: nothing is gained by more than one at a time.
    #[inline(always)]
    fn run<H: Copy + Into<f64>>(&mut self, samples: &[H], start: f64, step: f64, at: (usize, usize), plane: &Plane) {
        let error = |i: i32, sample: H| (start + step * f64::from(i) - sample.into()).abs();
        let (mut squares, mut max) = (0.0, 0.0f64);
        for (i, &sample) in (0..).zip(samples) {
            let error = error(i, sample);
            squares += error * error;
            max = if error > max { error } else { max };
            // Through i32: to unsigned numbers the conversion is slow.
            self.stats.histogram[((error * self.bins_per_error) as i32 as usize).min(BINS - 1)] += 1;
        }
        self.stats.squares += squares;
        self.stats.samples += samples.len() as u64;
        if self.may_exceed(max) && self.stats.max < self.tolerance {
            let errors = (0..).zip(samples).map(|(i, &sample)| error(i, sample));
            self.raise_max(errors, at, plane);
        }
    }

    /// The most that an error may be, by what rounding leaves open.
    #[inline(always)]
    fn raised(&self, error: f64) -> f64 {
        error * (1.0 + 8.0 * f64::EPSILON) + self.doubt
    }

    /// Whether an error may be the largest so far.
    #[inline(always)]
    fn may_exceed(&self, error: f64) -> bool {
        if self.doubt == 0.0 { error > self.stats.max } else { self.raised(error) > self.stats.max }
    }

    /// The same where every sample has a weight.
    fn weighted_run(
        &mut self,
        heights: &[f64],
        weights: &[f64],
        start: f64,
        (column, row): (usize, usize),
        plane: &Plane,
    ) {
        let (step, mut squares) = (plane.step(), 0.0);
        let mut eased = self.tile.eased_from((row * self.tile.width + column) as u32);
        for ((i, &height), &weight) in (0..).zip(heights).zip(weights) {
            let surface = start + step * f64::from(i);
            let error = (surface - height).abs();
            let place = (column + i as usize, row);
            if error * weight > self.tolerance {
                self.expect_kept(place, height, error, plane);
            }
            let sample = (row * self.tile.width + place.0) as u32;
            let (mut height, mut weight, mut error) = (height, weight, error);
            if let Some((first, rest)) = eased.split_first().filter(|(first, _)| first.sample == sample) {
                eased = rest;
                self.stats.beside += u64::from(first.low < first.high);
                // The error is that beyond the interval.
                height = surface.clamp(first.low, first.high);
                (weight, error) = (1.0, (surface - height).abs());
            }
            squares += error * error;
            let weighted = (error * weight).min(self.tolerance);
            self.stats.histogram[((weighted * self.bins_per_error) as i32 as usize).min(BINS - 1)] += 1;
            if self.may_exceed(error) || self.raised(error) * weight > self.stats.weighted_max {
                self.raise_weighted_max(place, (height, weight), error, plane);
            }
        }
        self.stats.squares += squares;
        self.stats.samples += heights.len() as u64;
    }

    /// The largest errors, found exactly as in [`Meter::raise_max`].
    #[cold]
    fn raise_weighted_max(
        &mut self,
        (column, row): (usize, usize),
        (height, weight): (f64, f64),
        error: f64,
        plane: &Plane,
    ) {
        let place = Point::of_sample(column as i32, row as i32);
        let error = if self.doubt == 0.0 || error == 0.0 { error } else { plane.distance(place, height) };
        self.stats.weighted_max = self.stats.weighted_max.max((error * weight).min(self.tolerance));
        if error > self.stats.max {
            self.stats.max = error;
            self.worst = (column, row);
        }
    }

    /// Makes sure that a sample whose error, as it is rounded, seems to exceed its limit does not.
    #[cold]
    fn expect_kept(&self, (column, row): (usize, usize), height: f64, error: f64, plane: &Plane) {
        let limit = self.tile.limit(column, row, self.tolerance);
        let place = Point::of_sample(column as i32, row as i32);
        assert!(plane.within(place, height, limit), "error {error} at {column}, {row} of the tile, {limit} is allowed");
    }

    /// Errors that may be larger than those before, by what rounding leaves open, are found exactly: the largest one is the
    /// same whichever way others compute it.
    #[cold]
    fn raise_max(&mut self, errors: impl Iterator<Item = f64>, (column, row): (usize, usize), plane: &Plane) {
        for (error, column) in errors.zip(column..) {
            if self.may_exceed(error) {
                let place = Point::of_sample(column as i32, row as i32);
                let error = if self.doubt == 0.0 { error } else { plane.distance(place, self.tile.at(column, row)) };
                if error > self.stats.max {
                    self.stats.max = error;
                    self.worst = (column, row);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Window;

    #[test]
    fn a_plane_over_a_bump() {
        let mut heights = vec![0.0f32; 25];
        heights[12] = 3.0;
        heights[13] = -1.0;
        let tile = Tile::from_heights(5, 5, Heights::F32(heights));
        let vertex = |c, r| Vertex { at: Point::of_sample(c, r), height: 0.0 };
        let mesh = TileMesh {
            vertices: vec![vertex(0, 0), vertex(4, 0), vertex(4, 4), vertex(0, 4)],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            relaxed: 0,
        };
        let alone = TilePlace::alone(5, 5);
        let far = TilePlace { window: Window { column: 100, row: 200, ..alone.window }, ..alone };
        let all = measure(&tile, &mesh, 4.0, &far, Bare::Nothing);
        assert_eq!((all.samples, all.max, all.worst, all.squares), (25, 3.0, (102, 202), 10.0));
        assert_eq!(all.percentile(0.5, 4.0), 4.0 / 256.0);
        assert_eq!(all.percentile(1.0, 4.0), 3.0);
        let owned = measure(&tile, &mesh, 4.0, &TilePlace { last_column: false, ..alone }, Bare::Nothing);
        assert_eq!(owned.samples, 20);

        assert_eq!(all.weighted_max, 3.0);
        let mut weights = vec![1.0; 25];
        let unit = measure(&tile.clone().with_weights(weights.clone()), &mesh, 4.0, &far, Bare::Nothing);
        assert_eq!(unit, all);
        (weights[12], weights[13]) = (0.5, 2.0);
        let weighted = measure(&tile.clone().with_weights(weights.clone()), &mesh, 2.0, &alone, Bare::Nothing);
        assert_eq!((weighted.max, weighted.weighted_max, weighted.worst, weighted.squares), (3.0, 2.0, (2, 2), 10.0));
        assert_eq!(weighted.percentile(1.0, 2.0), 2.0);
        weights[12] = 0.7;
        let broken = || measure(&tile.with_weights(weights), &mesh, 2.0, &alone, Bare::Nothing);
        assert!(std::panic::catch_unwind(broken).is_err());
    }

    /// Among the smallest numbers there are, the step of a row is off by as much as the tolerance; the error found is not.
    #[test]
    fn errors_of_the_smallest_heights_are_exact() {
        const UNIT: f64 = f64::from_bits(1);
        let heights = (0..24).map(|i| (f64::from(i % 12) * 6.0 / 11.0).round() * UNIT).collect();
        let tile = Tile::from_heights(12, 2, Heights::F64(heights));
        let vertex = |c: i32, r: i32| Vertex { at: Point::of_sample(c, r), height: tile.at(c as usize, r as usize) };
        let mesh = TileMesh {
            vertices: vec![vertex(0, 0), vertex(11, 0), vertex(11, 1), vertex(0, 1)],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            relaxed: 0,
        };
        let measured = |tile: &Tile| measure(tile, &mesh, UNIT, &TilePlace::alone(12, 2), Bare::Nothing);
        // 0.4545… units at the most are none, rounded.
        assert_eq!((measured(&tile).samples, measured(&tile).max), (24, 0.0));
        let weighted = measured(&tile.clone().with_weights(vec![1.0; 24]));
        assert_eq!((weighted.max, weighted.weighted_max), (0.0, 0.0));
    }
}
