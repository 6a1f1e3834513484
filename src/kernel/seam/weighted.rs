//! The further test of a link where there are attributes.

use crate::base::channels::ChannelError;

/// The channels along a line, and what their errors count: the second half of the test of a link where there are some.
#[derive(Debug, Clone, Copy)]
pub struct WeightedLine<'a> {
    /// What errors count.
    pub error: &'a ChannelError,
    /// The values along the line, channel by channel, each as long as the line has heights.
    pub channels: &'a [Vec<f64>],
}

/// A stretch of a line, from one vertex it must have to the next.
pub(super) struct WeightedSection<'a> {
    line: WeightedLine<'a>,
    heights: &'a [f64],
    /// Where the stretch begins in the channels.
    first: usize,
    limit: f64,
    /// How far a link may be from a channel's sample, more or less: beyond it, the channel alone exceeds the limit.
    reaches: Vec<f64>,
}

impl<'a> WeightedSection<'a> {
    pub(super) fn new(line: WeightedLine<'a>, heights: &'a [f64], first: usize, tolerance: f64) -> WeightedSection<'a> {
        let limit = line.error.limit(tolerance);
        // What the slopes of `lowest` are off by is far below this: the limit allows for much more noise.
        let slack = 1e-3 * tolerance + (tolerance - limit);
        let reaches = line.error.scales().iter().map(|s| (limit.max(0.0) + slack) / s).collect();
        WeightedSection { line, heights, first, limit, reaches }
    }

    /// A sample from which on links to `to` can be feasible: from any before it, one channel alone exceeds the limit at
    /// some sample between. An intersection of intervals of slopes for each channel, as for heights, but roughly.
    pub(super) fn lowest(&self, to: usize) -> usize {
        let mut lowest = 0;
        for (values, reach) in self.line.channels.iter().zip(&self.reaches).filter(|(_, r)| r.is_finite()) {
            let values = &values[self.first..=self.first + to];
            let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
            for from in (lowest..to).rev() {
                let (rise, distance) = (values[from] - values[to], (to - from) as f64);
                low = low.max((rise - reach) / distance);
                high = high.min((rise + reach) / distance);
                if low > high {
                    lowest = from;
                    break;
                }
            }
        }
        lowest
    }

    /// The sum of the squares of the weighted errors at the samples between, if each is within the limit.
    pub(super) fn squares(&self, from: usize, to: usize) -> Option<f64> {
        let inverse = 1.0 / (to - from) as f64;
        let mut squares = 0.0;
        for between in from + 1..to {
            let share = (between - from) as f64 * inverse;
            let off = |values: &[f64]| values[from] + (values[to] - values[from]) * share - values[between];
            let channels = self.line.channels.iter().map(|values| off(&values[self.first..]));
            let error = self.line.error.weighted(off(self.heights), channels);
            // Not a number, where numbers are near the largest: no.
            if error.is_nan() || error > self.limit {
                return None;
            }
            squares += error * error;
        }
        Some(squares)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::channels::{Range, Ranges};
    use crate::base::control::CancelToken;
    use crate::base::exact;
    use crate::kernel::seam::MinLink;
    use proptest::prelude::*;

    struct Case {
        heights: Vec<f64>,
        channels: Vec<Vec<f64>>,
        error: ChannelError,
        tolerance: f64,
    }

    impl Case {
        fn new(samples: &[[f64; 3]], emphasis: f64, tolerance: f64) -> Case {
            let column = |i: usize| samples.iter().map(|s| s[i]).collect::<Vec<f64>>();
            let range = Range { min: -6.0, max: 6.0 };
            let ranges = Ranges { heights: range, channels: vec![range; 2], unit: range.width() };
            let error = ChannelError::new(emphasis, &ranges);
            Case { heights: column(0), channels: vec![column(1), column(2)], error, tolerance }
        }

        fn path(&self) -> Vec<usize> {
            let line = WeightedLine { error: &self.error, channels: &self.channels };
            let mut min_link = MinLink::default();
            min_link.path_weighted(&self.heights, line, self.tolerance, &[], &CancelToken::default()).unwrap()
        }

        /// The definition of a feasible link.
        fn feasible(&self, i: usize, j: usize) -> bool {
            (i + 1..j).all(|k| {
                let (a, b, c) = ((j - k) as i64, (k - i) as i64, (j - i) as i64);
                let terms = [(a, self.heights[i]), (b, self.heights[j]), (-c, self.heights[k])];
                let off = |v: &[f64]| v[i] + (v[j] - v[i]) * ((k - i) as f64 / (j - i) as f64) - v[k];
                let weighted = self.error.weighted(off(&self.heights), self.channels.iter().map(|v| off(v)));
                exact::within(&terms, c, self.tolerance) && weighted <= self.error.limit(self.tolerance)
            })
        }

        fn fewest_links(&self) -> usize {
            let mut links = vec![0usize; self.heights.len()];
            for j in 1..links.len() {
                links[j] = (0..j).filter(|&i| self.feasible(i, j)).map(|i| links[i] + 1).min().unwrap();
            }
            links[links.len() - 1]
        }
    }

    fn value() -> impl Strategy<Value = f64> {
        prop_oneof![(-6i32..7).prop_map(f64::from), -6.0f64..6.0]
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(512))]

        #[test]
        fn is_as_short_as_exhaustive_search_finds(
            samples in prop::collection::vec([value(), value(), value()], 2..24),
            emphasis in prop_oneof![Just(0.0), Just(0.5), Just(1.0), 0.0f64..1.0],
            tolerance in prop_oneof![Just(0.0), Just(1.0), Just(3.0), 0.0f64..9.0],
        ) {
            let case = Case::new(&samples, emphasis, tolerance);
            let path = case.path();
            prop_assert!(path.windows(2).all(|l| case.feasible(l[0], l[1])));
            prop_assert_eq!(path.len() - 1, case.fewest_links());
        }
    }

    #[test]
    fn a_side_without_relief_follows_its_colours() {
        let samples: Vec<[f64; 3]> = (0..60).map(|i| [0.0, if i < 30 { -5.0 } else { 5.0 }, 1.0]).collect();
        assert_eq!(Case::new(&samples, 1.0, 1.0).path(), [0, 29, 30, 59]);
    }
}
