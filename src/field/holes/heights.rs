//! Heights for the samples of filled voids.

use super::components::Hole;

/// Heights for the samples of a hole, run by run.
///
/// To the left and the right, above and below, the nearest samples outside of the hole have heights (a hole that reaches no
/// edge has all four): the mean of these, each by the inverse square of its distance, in this order, never beyond them.
/// O(n log n), whatever the shape; a mean over all samples around would be smoother, and quadratic. `is_single` rounds to
/// single precision.
pub(super) fn bridge(hole: &Hole, is_single: bool) -> Vec<f64> {
    let height = |row: u32, column: u32| {
        let found = hole.beside.binary_search_by_key(&(row, column), |&(row, column, _)| (row, column));
        hole.beside[found.unwrap_or_else(|_| panic!("no height at column {column}, row {row} beside a hole"))].2
    };
    let mut means: Vec<Mean> = Vec::with_capacity(hole.samples as usize);
    // By columns, then by rows, and the place in `means`.
    let mut upright = Vec::with_capacity(hole.samples as usize);
    for &(row, first, last) in &hole.runs {
        let (left, right) = (height(row, first - 1), height(row, last + 1));
        for column in first..=last {
            upright.push((column, row, means.len()));
            let mut mean = Mean::default();
            mean.add(left, column - first + 1);
            mean.add(right, last + 1 - column);
            means.push(mean);
        }
    }
    upright.sort_unstable();
    for run in upright.chunk_by(|a, b| a.0 == b.0 && a.1 + 1 == b.1) {
        let (column, first, last) = (run[0].0, run[0].1, run[run.len() - 1].1);
        let (above, below) = (height(first - 1, column), height(last + 1, column));
        for &(_, row, place) in run {
            means[place].add(above, row - first + 1);
            means[place].add(below, last + 1 - row);
        }
    }
    means.into_iter().map(|mean| mean.value()).map(|z| if is_single { f64::from(z as f32) } else { z }).collect()
}

/// A mean of heights by the inverse squares of their distances.
struct Mean {
    sum: f64,
    weights: f64,
    lowest: f64,
    highest: f64,
}

impl Default for Mean {
    fn default() -> Self {
        Mean { sum: 0.0, weights: 0.0, lowest: f64::INFINITY, highest: f64::NEG_INFINITY }
    }
}

impl Mean {
    fn add(&mut self, height: f64, distance: u32) {
        let weight = 1.0 / (f64::from(distance) * f64::from(distance));
        self.sum += height * weight;
        self.weights += weight;
        self.lowest = self.lowest.min(height);
        self.highest = self.highest.max(height);
    }

    /// Rounding may not take it beyond what it is a mean of.
    fn value(&self) -> f64 {
        (self.sum / self.weights).clamp(self.lowest, self.highest)
    }
}
