//! Paths of the fewest links along a line of samples.

use std::cmp::Ordering;

use super::limits::{Allowed, Capped, Limits};
use super::weighted::{WeightedLine, WeightedSection};
use crate::base::control::{CancelToken, Cancelled};
use crate::base::exact;

/// Finds polylines with the fewest links, one after the other, reusing its memory.
#[derive(Debug, Default)]
pub struct MinLink {
    ways: Vec<Way>,
    sums: Sums,
    inverses: Vec<f64>,
    layer: Vec<usize>,
    next_layer: Vec<usize>,
    /// Whether a link from the first sample to each is feasible.
    is_next: Vec<bool>,
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
    /// both ends among them. A link i–j is feasible if every sample between lies within its limit (`<=`, exactly) of
    /// the straight line through samples i and j: `limits` is one tolerance for all, or a slice as long as `heights`.
    /// `forced` are indices that must be vertices, in any order.
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
    /// If there are fewer than two heights, limits are not as many, or a forced index is out of range.
    pub fn path<'a>(
        &mut self,
        heights: &[f64],
        limits: impl Into<Limits<'a>>,
        forced: &[usize],
        cancel: &CancelToken,
    ) -> Result<Vec<usize>, Cancelled> {
        self.path_over(heights, limits.into(), None, forced, cancel)
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
    /// [`ChannelError::limit`]: crate::base::channels::ChannelError::limit
    pub fn path_weighted(
        &mut self,
        heights: &[f64],
        line: WeightedLine<'_>,
        tolerance: f64,
        forced: &[usize],
        cancel: &CancelToken,
    ) -> Result<Vec<usize>, Cancelled> {
        self.path_over(heights, Limits::Same(tolerance), Some(line), forced, cancel)
    }

    fn path_over(
        &mut self,
        heights: &[f64],
        limits: Limits<'_>,
        channels: Option<WeightedLine<'_>>,
        forced: &[usize],
        cancel: &CancelToken,
    ) -> Result<Vec<usize>, Cancelled> {
        assert!(heights.len() >= 2, "a line of {} samples", heights.len());
        let mut stops: Vec<usize> = forced.iter().copied().chain([0, heights.len() - 1]).collect();
        stops.sort_unstable();
        stops.dedup();
        assert!(stops[stops.len() - 1] < heights.len(), "forced vertices {forced:?} of {} samples", heights.len());
        if let Limits::Each(each) = limits {
            assert_eq!(each.len(), heights.len(), "limits of a line");
        }
        let mut vertices = vec![0];
        for section in stops.windows(2) {
            let range = section[0]..=section[1];
            let heights = &heights[range.clone()];
            let highest = heights.iter().fold(0.0f64, |m, z| m.max(z.abs()));
            match (limits, channels) {
                (Limits::Same(tolerance), None) => self.find_ways(heights, None, highest, tolerance, cancel)?,
                (Limits::Same(tolerance), Some(line)) => {
                    let weighted = WeightedSection::new(line, heights, section[0], tolerance);
                    self.find_ways(heights, Some(&weighted), highest, tolerance, cancel)?;
                }
                (Limits::Each(limits), channels) => {
                    assert!(channels.is_none(), "channels of a line with a limit for each sample");
                    let capped = Capped::new(&limits[range], highest);
                    self.find_ways(heights, None, highest, capped, cancel)?;
                }
            }
            let end = section[1] - section[0];
            let mut at = 0;
            while at < end {
                at = self.ways[at].next;
                vertices.push(section[0] + at);
            }
        }
        Ok(vertices)
    }

    /// Breadth first from the far end, one layer of samples with equally many links after the other, until one of them can be
    /// linked to the first sample. So where two links are enough it is O(n).
    fn find_ways(
        &mut self,
        heights: &[f64],
        weighted: Option<&WeightedSection<'_>>,
        highest: f64,
        allowed: impl Allowed,
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
        // What a slope can be off by through rounding, generously: a share, and half of the smallest number there is.
        let doubt = (2.0 * highest + allowed.largest()) * (8.0 * f64::EPSILON) + f64::from_bits(2);
        self.layer.clear();
        self.layer.push(end);
        self.is_next.clear();
        self.is_next.resize(heights.len(), false);
        if weighted.is_none() {
            let line = Line { heights, allowed, to: 0, doubt, inverses: &self.inverses };
            line.for_each_feasible((1..).zip(&heights[1..]), |next| self.is_next[next] = true);
        }
        let mut links = 0;
        while self.ways[0].links == u32::MAX {
            links += 1;
            // Ascending, so that of equal ways the lexicographically smallest is met first.
            self.layer.sort_unstable();
            for &next in self.layer.iter().filter(|&&next| self.is_next[next]) {
                let squares = self.sums.squares(heights, 0, next) + self.ways[next].squares;
                if squares < self.ways[0].squares || self.ways[0].links > links {
                    self.ways[0] = Way { links, squares, next };
                }
            }
            if self.ways[0].links == links {
                return Ok(());
            }
            for (scanned, &to) in self.layer.iter().enumerate() {
                if scanned.is_multiple_of(SAMPLES_BETWEEN_CHECKS) {
                    cancel.check()?;
                }
                let line = Line { heights, allowed, to, doubt, inverses: &self.inverses };
                let rest = self.ways[to].squares;
                let lowest = weighted.map_or(0, |w| w.lowest(to));
                let before = (lowest..to).rev().zip(heights[lowest..to].iter().rev());
                line.for_each_feasible(before, |from| {
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

/// Slopes seen from one sample, towards the samples before it, or those behind it.
struct Line<'a, A> {
    heights: &'a [f64],
    allowed: A,
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

impl<A: Allowed> Line<'_, A> {
    /// Calls `visit` with those of the samples `from` which the link to this one is feasible; they follow one another from the nearest on.
    ///
    /// The slopes of lines that pass sample k within its limit are an interval; the link from `from` is feasible if
    /// its slope lies in the intersection of the intervals of all samples between. The two samples that bound the
    /// intersection are kept, so that a near tie is settled exactly against them alone. Slopes are rises per cell of
    /// distance, seen from this sample.
    fn for_each_feasible<'a>(&self, samples: impl Iterator<Item = (usize, &'a f64)>, mut visit: impl FnMut(usize)) {
        let mut low = Bound { slope: f64::NEG_INFINITY, sample: self.to };
        let mut high = Bound { slope: f64::INFINITY, sample: self.to };
        for ((from, &height), &inverse) in samples.zip(&self.inverses[1..]) {
            let rise = height - self.heights[self.to];
            let slope = rise * inverse;
            let above = self.clears(slope - low.slope, || self.compare(from, 0, low.sample, -1));
            let below = self.clears(high.slope - slope, || self.compare(high.sample, 1, from, 0));
            if above && below {
                visit(from);
            }
            let limit = self.allowed.at(from);
            let floor = (rise - limit) * inverse;
            if self.clears(floor - low.slope, || self.compare(from, -1, low.sample, -1)) {
                low = Bound { slope: floor, sample: from };
            }
            let ceiling = (rise + limit) * inverse;
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

    /// Compares, exactly, the slopes to the heights of samples `a` and `b` raised by `up_a` and `up_b` times their limits.
    fn compare(&self, a: usize, up_a: i64, b: usize, up_b: i64) -> Ordering {
        let (da, db) = (self.to.abs_diff(a) as i64, self.to.abs_diff(b) as i64);
        exact::sign(&[
            (db, self.heights[a]),
            (-da, self.heights[b]),
            (da - db, self.heights[self.to]),
            (db * up_a, self.allowed.at(a)),
            (-da * up_b, self.allowed.at(b)),
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

    fn weighted(heights: &[f64], limits: &[f64], forced: &[usize]) -> Vec<usize> {
        MinLink::default().path(heights, limits, forced, &CancelToken::default()).expect("nobody cancels")
    }

    fn feasible(heights: &[f64], limits: &[f64], i: usize, j: usize) -> bool {
        (i + 1..j).all(|k| {
            let (a, b, c) = ((j - k) as i64, (k - i) as i64, (j - i) as i64);
            exact::within(&[(a, heights[i]), (b, heights[j]), (-c, heights[k])], c, limits[k])
        })
    }

    fn squares(heights: &[f64], i: usize, j: usize) -> f64 {
        let line = |k: usize| heights[i] + (heights[j] - heights[i]) * (k - i) as f64 / (j - i) as f64;
        (i + 1..j).map(|k| (heights[k] - line(k)).powi(2)).sum()
    }

    /// All subsets of the samples between: (links, squared error) of the best.
    fn exhaustive(heights: &[f64], limits: &[f64]) -> (usize, f64) {
        let inner = heights.len() - 2;
        let mut best = (usize::MAX, f64::INFINITY);
        for mask in 0u32..1 << inner {
            let mut path = vec![0];
            path.extend((0..inner).filter(|b| mask >> b & 1 == 1).map(|b| b + 1));
            path.push(heights.len() - 1);
            if path.len() - 1 > best.0 || !path.windows(2).all(|l| feasible(heights, limits, l[0], l[1])) {
                continue;
            }
            let error: f64 = path.windows(2).map(|l| squares(heights, l[0], l[1])).sum();
            if path.len() - 1 < best.0 || error < best.1 {
                best = (path.len() - 1, error);
            }
        }
        best
    }

    /// Tight, wide, and none at all.
    fn limit() -> impl Strategy<Value = f64> {
        prop_oneof![Just(0.0), Just(1.0), Just(2.0), 0.0f64..5.0, Just(1e-6), Just(exact::MAX_TOLERANCE)]
    }

    proptest! {
        #[test]
        fn is_as_short_and_as_close_as_exhaustive_search(
            heights in prop::collection::vec(prop_oneof![(-6i32..6).prop_map(f64::from), -6.0f64..6.0], 2..12),
            tolerance in prop_oneof![Just(0.0), Just(1.0), Just(2.0), 0.0f64..5.0],
        ) {
            let path = min_link(&heights, tolerance, &[]);
            let limits = vec![tolerance; heights.len()];
            prop_assert_eq!(&weighted(&heights, &limits, &[]), &path);
            prop_assert!(path.windows(2).all(|l| feasible(&heights, &limits, l[0], l[1])));
            let (links, error) = exhaustive(&heights, &limits);
            prop_assert_eq!(path.len() - 1, links);
            let ours: f64 = path.windows(2).map(|l| squares(&heights, l[0], l[1])).sum();
            prop_assert!(ours <= error + 1e-9 * (1.0 + error), "{} against {}", ours, error);
        }

        #[test]
        fn so_it_is_where_every_sample_has_a_limit_of_its_own(
            line in prop::collection::vec((prop_oneof![(-6i32..6).prop_map(f64::from), -6.0f64..6.0], limit()), 2..12),
        ) {
            let (heights, limits): (Vec<f64>, Vec<f64>) = line.into_iter().unzip();
            let path = weighted(&heights, &limits, &[]);
            prop_assert!(path.windows(2).all(|l| feasible(&heights, &limits, l[0], l[1])));
            let (links, error) = exhaustive(&heights, &limits);
            prop_assert_eq!(path.len() - 1, links);
            let ours: f64 = path.windows(2).map(|l| squares(&heights, l[0], l[1])).sum();
            prop_assert!(ours <= error + 1e-9 * (1.0 + error), "{} against {}", ours, error);
        }

        /// Everything by 2⁻¹⁰⁷⁴, the smallest number: nothing is lost, and nothing may be decided otherwise.
        #[test]
        fn the_smallest_heights_take_as_many_links(
            heights in prop::collection::vec((-60i32..60).prop_map(f64::from), 2..40),
            tolerance in (0i32..50).prop_map(f64::from),
        ) {
            let small: Vec<f64> = heights.iter().map(|z| z * f64::from_bits(1)).collect();
            let path = min_link(&small, tolerance * f64::from_bits(1), &[]);
            prop_assert_eq!(path.len(), min_link(&heights, tolerance, &[]).len());
        }

        #[test]
        fn forced_samples_are_vertices(
            heights in prop::collection::vec(-6.0f64..6.0, 9), forced in prop::collection::vec(0usize..9, 0..4),
        ) {
            let path = min_link(&heights, 3.0, &forced);
            prop_assert!(forced.iter().all(|f| path.contains(f)));
            prop_assert!(path.windows(2).all(|l| feasible(&heights, &[3.0; 9], l[0], l[1])));
            let limits: Vec<f64> = (0..9).map(f64::from).collect();
            let path = weighted(&heights, &limits, &forced);
            prop_assert!(forced.iter().all(|f| path.contains(f)));
            prop_assert!(path.windows(2).all(|l| feasible(&heights, &limits, l[0], l[1])));
        }
    }

    #[test]
    fn a_flat_line_is_one_link_even_at_tolerance_zero() {
        assert_eq!(min_link(&[7.0; 513], 0.0, &[]), [0, 512]);
        let slope: Vec<f64> = (0..513).map(|k| f64::from(k) * 0.5 - 8000.0).collect();
        assert_eq!(min_link(&slope, 0.0, &[]), [0, 512]);
    }

    #[test]
    fn samples_that_are_free_cost_nothing() {
        let heights: Vec<f64> = (0..513).map(|k| f64::from(k * k % 101)).collect();
        let mut limits = vec![exact::MAX_TOLERANCE; 513];
        assert_eq!(weighted(&heights, &limits, &[]), [0, 512]);
        // But for one that is not.
        limits[200] = 0.0;
        assert_eq!(weighted(&heights, &limits, &[]).len(), 3);
    }

    #[test]
    fn an_error_equal_to_the_tolerance_is_within() {
        assert_eq!(min_link(&[0.0, 1.0, 0.0], 1.0, &[]), [0, 2]);
        assert_eq!(min_link(&[0.0, 1.0, 0.0], 1.0f64.next_down(), &[]), [0, 1, 2]);
    }
}
