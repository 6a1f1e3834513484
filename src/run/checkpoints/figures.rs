//! Statistics of residuals, as accuracy standards for elevation data define them.

use serde::Serialize;

/// Residuals of checkpoints: the height of the surface less that of the checkpoint.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Residuals {
    /// How many.
    pub count: u64,
    /// Their mean.
    pub mean: f64,
    /// Their median: of an even number the mean of the two in the middle.
    pub median: f64,
    /// The root of their mean square.
    pub rmse: f64,
    /// Their standard deviation around the mean, of a sample (n − 1); 0 of one.
    pub standard_deviation: f64,
    /// The 95th percentile of their absolute values, by linear interpolation between ranks: rank 0.95 · (n − 1) + 1.
    pub p95: f64,
    /// The largest absolute value.
    pub max: f64,
}

impl Residuals {
    /// Of these, in any order; `None` of none.
    pub(super) fn of(residuals: impl Iterator<Item = f64>) -> Option<Residuals> {
        let mut sorted: Vec<f64> = residuals.collect();
        sorted.sort_by(f64::total_cmp);
        let count = sorted.len();
        let largest = sorted.iter().fold(0.0f64, |largest, r| largest.max(r.abs()));
        let mean = sorted.iter().sum::<f64>() / count as f64;
        let mean_of_squares = sorted.iter().map(|r| r * r).sum::<f64>() / count as f64;
        let around: f64 = sorted.iter().map(|r| (r - mean) * (r - mean)).sum();
        let mut absolute: Vec<f64> = sorted.iter().map(|r| r.abs()).collect();
        absolute.sort_by(f64::total_cmp);
        (count > 0).then(|| Residuals {
            count: count as u64,
            mean,
            median: (sorted[(count - 1) / 2] + sorted[count / 2]) / 2.0,
            rmse: mean_of_squares.sqrt(),
            standard_deviation: (around / (count as f64 - 1.0).max(1.0)).sqrt(),
            p95: percentile(&absolute, 0.95),
            max: largest,
        })
    }
}

/// A percentile of sorted values, interpolated between ranks.
fn percentile(sorted: &[f64], share: f64) -> f64 {
    let rank = share * (sorted.len() - 1) as f64;
    let lower = sorted[rank as usize];
    let upper = sorted[(rank as usize + 1).min(sorted.len() - 1)];
    lower + (rank - rank.floor()) * (upper - lower)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_of_a_few_by_hand() {
        let found = Residuals::of([0.3, -0.1, 0.0, 0.2, -0.4].into_iter()).unwrap();
        let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
        assert_eq!((found.count, found.median, found.max), (5, 0.0, 0.4));
        assert!(near(found.mean, 0.0) && near(found.rmse, 0.06f64.sqrt()));
        assert!(near(found.standard_deviation, (0.3f64 / 4.0).sqrt()));
        // Sorted: 0, 0.1, 0.2, 0.3, 0.4; rank 0.95 · 4 + 1 = 4.8.
        assert!(near(found.p95, 0.38));
        let two = Residuals::of([1.0, 2.0].into_iter()).unwrap();
        assert_eq!((two.median, two.p95, two.mean), (1.5, 1.95, 1.5));
        let one = Residuals::of([-3.0].into_iter()).unwrap();
        assert_eq!((one.standard_deviation, one.p95, one.median), (0.0, 3.0, -3.0));
        assert_eq!(Residuals::of(std::iter::empty()), None);
    }
}
