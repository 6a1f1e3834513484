//! What makes a sample important (section 3), beside its own error: measures behind one trait.
//!
//! The guarantee knows nothing of this: whatever the measure, samples beyond the tolerance are candidates and no others
//! are. A measure says which of them comes first, within a triangle and among triangles.

use super::options::Measure;
use super::scan::{Candidate, Scan, Scanner};
use crate::base::Tile;
use crate::base::lattice::{Point, orient};
use crate::base::mesh::Vertex;

/// A measure of importance.
pub(super) trait Importance {
    /// How much a sample of a triangle beyond the tolerance is wanted; `error` is its error, the
    /// weighted one where there are channels.
    fn of(&self, triangle: &Triangle<'_>, column: i32, row: i32, error: f64) -> f64;

    /// How many of a triangle's samples, those with the largest errors, are asked about: all, unless asking is costly.
    fn asked(&self) -> usize {
        usize::MAX
    }
}

/// A triangle of the surface over the samples.
pub(super) struct Triangle<'a> {
    pub(super) tile: &'a Tile,
    pub(super) corners: [Vertex; 3],
    pub(super) scan: &'a Scan,
}

/// The measure of choice with what it has found out about a tile; `None` is the local error, which needs no asking.
pub(super) fn prepare(measure: Measure, tile: &Tile) -> Option<Box<dyn Importance>> {
    match measure {
        Measure::LocalError => None,
        Measure::Curvature(smoothing) => Some(Box::new(Curvature::new(tile, smoothing))),
        Measure::GlobalError => Some(Box::new(GlobalError)),
        Measure::Product(smoothing) => Some(Box::new(Product(Curvature::new(tile, smoothing)))),
    }
}

/// The candidate of a triangle by a measure.
pub(super) fn candidate(
    scanner: &Scanner<'_>,
    corners: [Vertex; 3],
    locked: [bool; 3],
    measure: &dyn Importance,
    beyond: &mut Vec<Candidate>,
) -> Option<Candidate> {
    let tile = scanner.tile;
    let scan = Scan::of(tile, corners).without(locked);
    beyond.clear();
    scanner.each_beyond(&scan, corners, |candidate| beyond.push(candidate));
    let by_score = |a: &Candidate, b: &Candidate| b.score.total_cmp(&a.score).then(a.sample.cmp(&b.sample));
    if beyond.len() > measure.asked() {
        beyond.select_nth_unstable_by(measure.asked(), by_score);
        beyond.truncate(measure.asked());
    }
    let triangle = Triangle { tile, corners, scan: &scan };
    let width = tile.width() as u64;
    let asked = beyond.iter().map(|c| {
        let (column, row) = ((c.sample % width) as i32, (c.sample / width) as i32);
        Candidate { score: measure.of(&triangle, column, row, c.score), sample: c.sample }
    });
    asked.min_by(by_score)
}

/// The squared Frobenius norm of the Hessian, the sum of the squares of the principal curvatures, by central differences
/// on the field smoothed with a Gaussian (3.2). Beyond the tile the field goes on as it is at the rim, and where samples are
/// missing as it is beside them, so a tile's measure is a function of its own samples.
struct Curvature {
    width: usize,
    of: Vec<f64>,
}

impl Curvature {
    fn new(tile: &Tile, smoothing: f64) -> Curvature {
        let (width, height) = (tile.width(), tile.height());
        let heights = smooth(tile, &gaussian(smoothing));
        let at = |column: i64, row: i64| {
            let column = column.clamp(0, width as i64 - 1) as usize;
            let row = row.clamp(0, height as i64 - 1) as usize;
            heights[row * width + column]
        };
        let squared = |i: usize| {
            let (c, r) = ((i % width) as i64, (i / width) as i64);
            let here = 2.0 * at(c, r);
            let xx = at(c - 1, r) - here + at(c + 1, r);
            let yy = at(c, r - 1) - here + at(c, r + 1);
            let xy = 0.25 * (at(c + 1, r + 1) - at(c - 1, r + 1) - at(c + 1, r - 1) + at(c - 1, r - 1));
            xx * xx + 2.0 * xy * xy + yy * yy
        };
        Curvature { width, of: (0..width * height).map(squared).collect() }
    }

    fn squared(&self, column: i32, row: i32) -> f64 {
        self.of[row as usize * self.width + column as usize]
    }
}

impl Importance for Curvature {
    fn of(&self, _: &Triangle<'_>, column: i32, row: i32, _: f64) -> f64 {
        self.squared(column, row)
    }
}

/// Error times curvature (3.4): two measures whose units have nothing to do with each other.
struct Product(Curvature);

impl Importance for Product {
    fn of(&self, _: &Triangle<'_>, column: i32, row: i32, error: f64) -> f64 {
        error * self.0.squared(column, row).sqrt()
    }
}

/// How much the sum of errors over the triangle goes down if it is split at the sample (3.3). The paper's partial sums
/// that make this cheap on curves have no like in the plane (its own finding): every asking costs a scan of the triangle,
/// so only the worst samples are asked about. May be negative: one step of insertion can raise the sum.
struct GlobalError;

impl Importance for GlobalError {
    fn of(&self, triangle: &Triangle<'_>, column: i32, row: i32, _: f64) -> f64 {
        let height = triangle.tile.at(column as usize, row as usize);
        let p = Vertex { at: Point::of_sample(column, row), height };
        let [a, b, c] = triangle.corners;
        let parts = [[a, b, p], [b, c, p], [c, a, p]];
        let after: f64 = parts
            .into_iter()
            .filter(|[a, b, c]| orient(a.at, b.at, c.at) > 0)
            .map(|part| Scan::of(triangle.tile, part).sum_of_errors(triangle.tile))
            .sum();
        triangle.scan.sum_of_errors(triangle.tile) - after
    }

    fn asked(&self) -> usize {
        8
    }
}

/// The weights of a Gaussian from its middle on, as far as three standard deviations, normalised.
fn gaussian(deviation: f64) -> Vec<f64> {
    let reach = (3.0 * deviation).ceil() as usize;
    let mut weights: Vec<f64> = (0..=reach)
        .map(|k| {
            let k = k as f64 / deviation;
            exp_of_minus(0.5 * k * k)
        })
        .collect();
    let sum = weights[0] + 2.0 * weights[1..].iter().sum::<f64>();
    weights.iter_mut().for_each(|w| *w /= sum);
    weights
}

/// e^−x, x ≥ 0, by sums and products alone: a library's own would differ from machine to machine in the last bit, and
/// decide.
fn exp_of_minus(x: f64) -> f64 {
    let (mut part, mut squarings) = (x, 0);
    while part > 0.5 {
        part *= 0.5;
        squarings += 1;
    }
    let (mut term, mut sum) = (1.0, 1.0);
    for n in 1..20 {
        term *= part / f64::from(n);
        sum += term;
    }
    let mut result = 1.0 / sum;
    for _ in 0..squarings {
        result *= result;
    }
    result
}

fn smooth(tile: &Tile, weights: &[f64]) -> Vec<f64> {
    let (width, height) = (tile.width(), tile.height());
    let heights = filled(tile);
    let across: Vec<f64> =
        (0..width * height).map(|i| weighted(weights, i % width, width, |c| heights[i - i % width + c])).collect();
    (0..width * height).map(|i| weighted(weights, i / width, height, |r| across[r * width + i % width])).collect()
}

/// The heights; for a missing one that of the sample before it in the row, at the row's beginning of the first behind it.
fn filled(tile: &Tile) -> Vec<f64> {
    let mut heights = Vec::with_capacity(tile.width() * tile.height());
    for row in 0..tile.height() {
        let valid = |column: &usize| tile.validity().is_valid(*column as i32, row as i32);
        let mut last = (0..tile.width()).find(valid).map_or(0.0, |column| tile.at(column, row));
        heights.extend((0..tile.width()).map(|column| {
            last = if valid(&column) { tile.at(column, row) } else { last };
            last
        }));
    }
    heights
}

fn weighted(weights: &[f64], middle: usize, count: usize, value: impl Fn(usize) -> f64) -> f64 {
    let beside = |k: usize| value(middle.saturating_sub(k)) + value((middle + k).min(count - 1));
    weights.iter().enumerate().fold(0.0, |sum, (k, w)| sum + w * if k == 0 { value(middle) } else { beside(k) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Heights;

    #[test]
    fn a_gaussian_is_one_in_all() {
        for deviation in [0.01, 0.5, 1.0, 4.0] {
            let weights = gaussian(deviation);
            let sum = weights[0] + 2.0 * weights[1..].iter().sum::<f64>();
            assert!((sum - 1.0).abs() < 1e-12 && weights.is_sorted_by(|a, b| a >= b), "{deviation}: {weights:?}");
        }
        for x in [0.0, 0.3, 1.0, 17.0, 700.0] {
            assert!((exp_of_minus(x) / (-x).exp() - 1.0).abs() < 1e-12, "{x}");
        }
    }

    /// The Laplacian is 0 on a saddle; this measure is not (3.2).
    #[test]
    fn a_saddle_is_curved_and_a_plane_is_not() {
        let tile = |height: fn(f64, f64) -> f64| {
            let heights = (0..225).map(|i| height(f64::from(i % 15), f64::from(i / 15))).collect();
            Tile::from_heights(15, 15, Heights::F64(heights))
        };
        let saddle = Curvature::new(&tile(|x, y| 3.0 * x * x - 3.0 * y * y), 0.5);
        assert!((saddle.squared(7, 7) - 72.0).abs() < 1e-6, "{}", saddle.squared(7, 7));
        let plane = Curvature::new(&tile(|x, y| 3.0 * x - 2.0 * y), 1.0);
        assert!(plane.squared(7, 7) < 1e-18);
    }
}
