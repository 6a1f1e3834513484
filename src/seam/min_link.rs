use std::cmp::Ordering;

use crate::exact;

/// The polyline with the fewest links through samples of a line, each link within the tolerance.
///
/// `heights` are the samples along the line, one cell apart; the result is the indices of the vertices, ascending, both
/// ends among them. A link i–j is feasible if every sample between lies within `tolerance` (`<=`, exactly) of the
/// straight line through samples i and j. `forced` are indices that must be vertices, in any order.
///
/// Shortest path over the graph of feasible links, from the far end backwards; of the paths with the fewest links the
/// one with the least sum of squared errors, of these the lexicographically smallest. Greedily taking the farthest
/// feasible link is not optimal when vertices are samples (Silva, Mitchell & Kaufman 1995, Initialization, uses it).
///
/// Cost: O(n·L), with L the reach of a link until no straight line fits; O(n) memory.
///
/// # Panics
/// If there are fewer than two heights, or a forced index is out of range.
pub fn min_link(heights: &[f64], tolerance: f64, forced: &[usize]) -> Vec<usize> {
    assert!(heights.len() >= 2, "a line of {} samples", heights.len());
    let mut stops: Vec<usize> = forced.iter().copied().chain([0, heights.len() - 1]).collect();
    stops.sort_unstable();
    stops.dedup();
    assert!(stops[stops.len() - 1] < heights.len(), "forced vertices {forced:?} of {} samples", heights.len());
    let mut vertices = vec![0];
    for section in stops.windows(2) {
        let path = shortest_path(&heights[section[0]..=section[1]], tolerance);
        vertices.extend(path.into_iter().skip(1).map(|i| i + section[0]));
    }
    vertices
}

/// The best way from a sample to the end of the line.
#[derive(Clone, Copy)]
struct Way {
    links: u32,
    squares: f64,
    next: usize,
}

fn shortest_path(heights: &[f64], tolerance: f64) -> Vec<usize> {
    let end = heights.len() - 1;
    let sums = Sums::of(heights);
    let mut ways = vec![Way { links: 0, squares: 0.0, next: end }; heights.len()];
    for from in (0..end).rev() {
        let mut best = Way { links: u32::MAX, squares: f64::INFINITY, next: end };
        for_each_feasible(heights, tolerance, from, |to| {
            let rest = ways[to];
            if rest.links >= best.links {
                return;
            }
            let squares = sums.squares(heights, from, to) + rest.squares;
            // Equal ways keep the earlier `to`: it is lexicographically smaller.
            if rest.links + 1 < best.links || squares < best.squares {
                best = Way { links: rest.links + 1, squares, next: to };
            }
        });
        ways[from] = best;
    }
    let mut path = vec![0];
    let mut at = 0;
    while at < end {
        at = ways[at].next;
        path.push(at);
    }
    path
}

/// Calls `visit` with every `to` for which the link `from`–`to` is feasible, ascending.
///
/// The slopes of lines through `from` that pass sample k within the tolerance are an interval; the link to `to` is
/// feasible if its slope lies in the intersection of the intervals of all samples between. The two samples that bound
/// the intersection are kept, so that a near tie is settled exactly against them alone.
fn for_each_feasible(heights: &[f64], tolerance: f64, from: usize, mut visit: impl FnMut(usize)) {
    let line = Line { heights, tolerance, from };
    let (mut low, mut high): (Option<Bound>, Option<Bound>) = (None, None);
    let mut reach = 0.0f64;
    for to in from + 1..heights.len() {
        let distance = (to - from) as f64;
        let rise = heights[to] - heights[from];
        // What a slope here can be off by through rounding, generously.
        reach = reach.max(heights[to].abs());
        let doubt = (reach + heights[from].abs() + tolerance) * (8.0 * f64::EPSILON);
        let slope = rise / distance;
        let above = low.is_none_or(|b| line.clears(slope - b.slope, doubt, || line.compare(to, 0, b.sample, -1)));
        let below = high.is_none_or(|b| line.clears(b.slope - slope, doubt, || line.compare(b.sample, 1, to, 0)));
        if above && below {
            visit(to);
        }
        let floor = (rise - tolerance) / distance;
        if low.is_none_or(|b| line.clears(floor - b.slope, doubt, || line.compare(to, -1, b.sample, -1))) {
            low = Some(Bound { slope: floor, sample: to });
        }
        let ceiling = (rise + tolerance) / distance;
        if high.is_none_or(|b| line.clears(b.slope - ceiling, doubt, || line.compare(b.sample, 1, to, 1))) {
            high = Some(Bound { slope: ceiling, sample: to });
        }
        if let (Some(low), Some(high)) = (low, high)
            && low.slope > high.slope + 2.0 * doubt
        {
            return;
        }
    }
}

/// A bound of the feasible slopes, and the sample that sets it.
#[derive(Clone, Copy)]
struct Bound {
    slope: f64,
    sample: usize,
}

/// Slopes seen from one sample.
struct Line<'a> {
    heights: &'a [f64],
    tolerance: f64,
    from: usize,
}

impl Line<'_> {
    /// Whether a difference of slopes is ≥ 0, exactly where rounding leaves it in doubt.
    #[inline(always)]
    fn clears(&self, difference: f64, doubt: f64, exact: impl FnOnce() -> Ordering) -> bool {
        if difference.abs() > doubt { difference > 0.0 } else { exact() != Ordering::Less }
    }

    /// Compares, exactly, the slopes to the heights of samples `a` and `b` raised by `up_a` and `up_b` tolerances.
    fn compare(&self, a: usize, up_a: i64, b: usize, up_b: i64) -> Ordering {
        let (da, db) = ((a - self.from) as i64, (b - self.from) as i64);
        exact::sign(&[
            (db, self.heights[a]),
            (-da, self.heights[b]),
            (da - db, self.heights[self.from]),
            (db * up_a - da * up_b, self.tolerance),
        ])
    }
}

/// Prefix sums for the squared error of a link in constant time; heights are taken relative to the first.
struct Sums {
    base: f64,
    h: Vec<f64>,
    kh: Vec<f64>,
    hh: Vec<f64>,
}

impl Sums {
    fn of(heights: &[f64]) -> Sums {
        let base = heights[0];
        let running = |term: &dyn Fn(usize, f64) -> f64| {
            let mut sum = 0.0;
            heights
                .iter()
                .enumerate()
                .map(|(k, z)| {
                    sum += term(k, z - base);
                    sum
                })
                .collect()
        };
        Sums { base, h: running(&|_, z| z), kh: running(&|k, z| k as f64 * z), hh: running(&|_, z| z * z) }
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
