use std::cmp::Ordering;

use super::weighted::{WeightedLine, WeightedSection};
use crate::control::{CancelToken, Cancelled};
use crate::exact;

/// Finds polylines with the fewest links, one after the other, reusing its memory.
#[derive(Debug, Default)]
pub struct MinLink {
    ways: Vec<Way>,
    sums: Sums,
    inverses: Vec<f64>,
    layer: Vec<usize>,
    next_layer: Vec<usize>,
}

/// The best way from a sample to the end of the line.
#[derive(Debug, Clone, Copy)]
struct Way {
    links: u32,
    squares: f64,
    next: usize,
}

/// Samples between two looks at the cancellation token.
const SAMPLES_BETWEEN_CHECKS: usize = 256;

impl MinLink {
    /// The polyline with the fewest links through samples of a line, each link within the tolerance.
    ///
    /// `heights` are the samples along the line, one cell apart; the result is the indices of the vertices, ascending,
    /// both ends among them. A link i–j is feasible if every sample between lies within `tolerance` (`<=`, exactly) of
    /// the straight line through samples i and j. `forced` are indices that must be vertices, in any order.
    ///
    /// Shortest path over the graph of feasible links, breadth first from the far end; of the paths with the fewest links
    /// the one with the least sum of squared errors, of these the lexicographically smallest. Greedily taking the
    /// farthest feasible link is not optimal when vertices are samples (Silva, Mitchell & Kaufman 1995, Initialization,
    /// uses it).
    ///
    /// Cost: O(n·L), with L the reach of a link until no straight line fits; O(n) memory.
    ///
    /// # Errors
    /// [`Cancelled`].
    ///
    /// # Panics
    /// If there are fewer than two heights, or a forced index is out of range.
    pub fn path(
        &mut self,
        heights: &[f64],
        tolerance: f64,
        forced: &[usize],
        cancel: &CancelToken,
    ) -> Result<Vec<usize>, Cancelled> {
        self.path_over(heights, None, tolerance, forced, cancel)
    }

    /// As [`MinLink::path`], but a link is feasible only if the weighted error, too, is within its limit
    /// ([`ChannelError::limit`]) at every sample between; the sum that decides among equally short paths is that of the
    /// squares of weighted errors.
    ///
    /// Cost: each link within the tolerance is tested sample by sample, O(n·L²) at the worst.
    ///
    /// # Errors
    /// [`Cancelled`].
    ///
    /// # Panics
    /// As [`MinLink::path`].
    ///
    /// [`ChannelError::limit`]: crate::channels::ChannelError::limit
    pub fn path_weighted(
        &mut self,
        heights: &[f64],
        line: WeightedLine<'_>,
        tolerance: f64,
        forced: &[usize],
        cancel: &CancelToken,
    ) -> Result<Vec<usize>, Cancelled> {
        self.path_over(heights, Some(line), tolerance, forced, cancel)
    }

    fn path_over(
        &mut self,
        heights: &[f64],
        channels: Option<WeightedLine<'_>>,
        tolerance: f64,
        forced: &[usize],
        cancel: &CancelToken,
    ) -> Result<Vec<usize>, Cancelled> {
        assert!(heights.len() >= 2, "a line of {} samples", heights.len());
        let mut stops: Vec<usize> = forced.iter().copied().chain([0, heights.len() - 1]).collect();
        stops.sort_unstable();
        stops.dedup();
        assert!(stops[stops.len() - 1] < heights.len(), "forced vertices {forced:?} of {} samples", heights.len());
        let mut vertices = vec![0];
        for section in stops.windows(2) {
            let heights = &heights[section[0]..=section[1]];
            let weighted = channels.map(|line| WeightedSection::new(line, heights, section[0], tolerance));
            self.find_ways(heights, weighted.as_ref(), tolerance, cancel)?;
            let end = section[1] - section[0];
            let mut at = 0;
            while at < end {
                at = self.ways[at].next;
                vertices.push(section[0] + at);
            }
        }
        Ok(vertices)
    }

    /// Breadth first from the far end, one layer of samples with equally many links after the other, until the layer
    /// of the first sample is complete. On flat ground that is one layer of one sample: O(n).
    fn find_ways(
        &mut self,
        heights: &[f64],
        weighted: Option<&WeightedSection<'_>>,
        tolerance: f64,
        cancel: &CancelToken,
    ) -> Result<(), Cancelled> {
        let end = heights.len() - 1;
        self.sums.fill(heights);
        while self.inverses.len() <= end {
            self.inverses.push(1.0 / self.inverses.len() as f64);
        }
        self.ways.clear();
        self.ways.resize(heights.len(), Way { links: u32::MAX, squares: f64::INFINITY, next: end });
        self.ways[end] = Way { links: 0, squares: 0.0, next: end };
        let highest = heights.iter().fold(0.0f64, |m, z| m.max(z.abs()));
        // What a slope can be off by through rounding, generously.
        let doubt = (2.0 * highest + tolerance) * (8.0 * f64::EPSILON);
        self.layer.clear();
        self.layer.push(end);
        let mut links = 0;
        while self.ways[0].links == u32::MAX {
            links += 1;
            // Ascending, so that of equal ways the lexicographically smallest is met first.
            self.layer.sort_unstable();
            for (scanned, &to) in self.layer.iter().enumerate() {
                if scanned.is_multiple_of(SAMPLES_BETWEEN_CHECKS) {
                    cancel.check()?;
                }
                let line = Line { heights, tolerance, to, doubt, inverses: &self.inverses };
                let rest = self.ways[to].squares;
                let lowest = weighted.map_or(0, |w| w.lowest(to));
                line.for_each_feasible(lowest, |from| {
                    let way = &mut self.ways[from];
                    if way.links < links {
                        return;
                    }
                    let squares = match weighted {
                        None => self.sums.squares(heights, from, to),
                        Some(weighted) => match weighted.squares(from, to) {
                            None => return,
                            Some(squares) => squares,
                        },
                    };
                    if way.links > links {
                        way.links = links;
                        self.next_layer.push(from);
                    }
                    let squares = squares + rest;
                    if squares < way.squares {
                        (way.squares, way.next) = (squares, to);
                    }
                });
            }
            self.layer.clear();
            std::mem::swap(&mut self.layer, &mut self.next_layer);
        }
        Ok(())
    }
}

/// Slopes seen from one sample, towards the samples before it.
struct Line<'a> {
    heights: &'a [f64],
    tolerance: f64,
    to: usize,
    doubt: f64,
    /// 1/n for every distance n.
    inverses: &'a [f64],
}

/// A bound of the feasible slopes, and the sample that sets it.
#[derive(Clone, Copy)]
struct Bound {
    slope: f64,
    sample: usize,
}

impl Line<'_> {
    /// Calls `visit` with every `from` for which the link to this sample is feasible, descending, down to `lowest`.
    ///
    /// The slopes of lines that pass sample k within the tolerance are an interval; the link from `from` is feasible if
    /// its slope lies in the intersection of the intervals of all samples between. The two samples that bound the
    /// intersection are kept, so that a near tie is settled exactly against them alone. Slopes are rises per cell of
    /// distance, seen from this sample.
    fn for_each_feasible(&self, lowest: usize, mut visit: impl FnMut(usize)) {
        let mut low = Bound { slope: f64::NEG_INFINITY, sample: self.to };
        let mut high = Bound { slope: f64::INFINITY, sample: self.to };
        let before = (lowest..self.to).rev().zip(self.heights[lowest..self.to].iter().rev());
        for ((from, &height), &inverse) in before.zip(&self.inverses[1..]) {
            let rise = height - self.heights[self.to];
            let slope = rise * inverse;
            let above = self.clears(slope - low.slope, || self.compare(from, 0, low.sample, -1));
            let below = self.clears(high.slope - slope, || self.compare(high.sample, 1, from, 0));
            if above && below {
                visit(from);
            }
            let floor = (rise - self.tolerance) * inverse;
            if self.clears(floor - low.slope, || self.compare(from, -1, low.sample, -1)) {
                low = Bound { slope: floor, sample: from };
            }
            let ceiling = (rise + self.tolerance) * inverse;
            if self.clears(high.slope - ceiling, || self.compare(high.sample, 1, from, 1)) {
                high = Bound { slope: ceiling, sample: from };
            }
            if low.slope > high.slope + 2.0 * self.doubt {
                return;
            }
        }
    }

    /// Whether a difference of slopes is ≥ 0, exactly where rounding leaves it in doubt.
    #[inline(always)]
    fn clears(&self, difference: f64, exact: impl FnOnce() -> Ordering) -> bool {
        if difference.abs() > self.doubt { difference > 0.0 } else { exact() != Ordering::Less }
    }

    /// Compares, exactly, the slopes to the heights of samples `a` and `b` raised by `up_a` and `up_b` tolerances.
    fn compare(&self, a: usize, up_a: i64, b: usize, up_b: i64) -> Ordering {
        let (da, db) = ((self.to - a) as i64, (self.to - b) as i64);
        exact::sign(&[
            (db, self.heights[a]),
            (-da, self.heights[b]),
            (da - db, self.heights[self.to]),
            (db * up_a - da * up_b, self.tolerance),
        ])
    }
}

/// Prefix sums for the squared error of a link in constant time; heights are taken relative to the first.
#[derive(Debug, Default)]
struct Sums {
    base: f64,
    h: Vec<f64>,
    kh: Vec<f64>,
    hh: Vec<f64>,
}

impl Sums {
    fn fill(&mut self, heights: &[f64]) {
        self.base = heights[0];
        self.h.clear();
        self.kh.clear();
        self.hh.clear();
        let (mut h, mut kh, mut hh) = (0.0, 0.0, 0.0);
        for (k, height) in heights.iter().enumerate() {
            let z = height - self.base;
            h += z;
            kh += k as f64 * z;
            hh += z * z;
            self.h.push(h);
            self.kh.push(kh);
            self.hh.push(hh);
        }
    }

    /// Sum over the samples between of (height − line)², up to rounding: it only breaks ties.
    fn squares(&self, heights: &[f64], from: usize, to: usize) -> f64 {
        let (n, i) = ((to - from) as f64, from as f64);
        let (a, slope) = (heights[from] - self.base, (heights[to] - heights[from]) / n);
        // The line is c + slope·k; over from < k < to, with m samples.
        let c = a - slope * i;
        let m = n - 1.0;
        let (h, kh, hh) =
            (self.h[to - 1] - self.h[from], self.kh[to - 1] - self.kh[from], self.hh[to - 1] - self.hh[from]);
        let k = m * (i + i + n) / 2.0;
        let kk = m * i * i + i * n * m + n * m * (2.0 * n - 1.0) / 6.0;
        (hh - 2.0 * (c * h + slope * kh) + c * c * m + 2.0 * c * slope * k + slope * slope * kk).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn min_link(heights: &[f64], tolerance: f64, forced: &[usize]) -> Vec<usize> {
        MinLink::default().path(heights, tolerance, forced, &CancelToken::default()).expect("nobody cancels")
    }

    fn feasible(heights: &[f64], tolerance: f64, i: usize, j: usize) -> bool {
        (i + 1..j).all(|k| {
            let (a, b, c) = ((j - k) as i64, (k - i) as i64, (j - i) as i64);
            exact::within(&[(a, heights[i]), (b, heights[j]), (-c, heights[k])], c, tolerance)
        })
    }

    fn squares(heights: &[f64], i: usize, j: usize) -> f64 {
        let line = |k: usize| heights[i] + (heights[j] - heights[i]) * (k - i) as f64 / (j - i) as f64;
        (i + 1..j).map(|k| (heights[k] - line(k)).powi(2)).sum()
    }

    /// All subsets of the samples between: (links, squared error) of the best.
    fn exhaustive(heights: &[f64], tolerance: f64) -> (usize, f64) {
        let inner = heights.len() - 2;
        let mut best = (usize::MAX, f64::INFINITY);
        for mask in 0u32..1 << inner {
            let mut path = vec![0];
            path.extend((0..inner).filter(|b| mask >> b & 1 == 1).map(|b| b + 1));
            path.push(heights.len() - 1);
            if path.len() - 1 > best.0 || !path.windows(2).all(|l| feasible(heights, tolerance, l[0], l[1])) {
                continue;
            }
            let error: f64 = path.windows(2).map(|l| squares(heights, l[0], l[1])).sum();
            if path.len() - 1 < best.0 || error < best.1 {
                best = (path.len() - 1, error);
            }
        }
        best
    }

    proptest! {
        #[test]
        fn is_as_short_and_as_close_as_exhaustive_search(
            heights in prop::collection::vec(prop_oneof![(-6i32..6).prop_map(f64::from), -6.0f64..6.0], 2..12),
            tolerance in prop_oneof![Just(0.0), Just(1.0), Just(2.0), 0.0f64..5.0],
        ) {
            let path = min_link(&heights, tolerance, &[]);
            prop_assert!(path.windows(2).all(|l| feasible(&heights, tolerance, l[0], l[1])));
            let (links, error) = exhaustive(&heights, tolerance);
            prop_assert_eq!(path.len() - 1, links);
            let ours: f64 = path.windows(2).map(|l| squares(&heights, l[0], l[1])).sum();
            prop_assert!(ours <= error + 1e-9 * (1.0 + error), "{} against {}", ours, error);
        }

        #[test]
        fn forced_samples_are_vertices(
            heights in prop::collection::vec(-6.0f64..6.0, 9), forced in prop::collection::vec(0usize..9, 0..4),
        ) {
            let path = min_link(&heights, 3.0, &forced);
            prop_assert!(forced.iter().all(|f| path.contains(f)));
            prop_assert!(path.windows(2).all(|l| feasible(&heights, 3.0, l[0], l[1])));
        }
    }

    #[test]
    fn a_flat_line_is_one_link_even_at_tolerance_zero() {
        assert_eq!(min_link(&[7.0; 513], 0.0, &[]), [0, 512]);
        let slope: Vec<f64> = (0..513).map(|k| f64::from(k) * 0.5 - 8000.0).collect();
        assert_eq!(min_link(&slope, 0.0, &[]), [0, 512]);
    }

    #[test]
    fn an_error_equal_to_the_tolerance_is_within() {
        assert_eq!(min_link(&[0.0, 1.0, 0.0], 1.0, &[]), [0, 2]);
        assert_eq!(min_link(&[0.0, 1.0, 0.0], 1.0f64.next_down(), &[]), [0, 1, 2]);
    }
}
