//! Nested polylines: where no tolerance is given beforehand, a side for every tolerance at once.

/// A vertex between the ends of a side, and the tolerance below which the side has it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Level {
    /// The sample's place along the side.
    pub at: usize,
    /// Infinite where the vertex is always there.
    pub level: f64,
}

/// Splits a side of `len` samples at its farthest sample, and its parts likewise (Ramer 1972, Douglas & Peucker 1973),
/// until no sample is `beyond` the straight line of its part. A vertex's level is its error when it was split at, or the
/// least of those before it, so the vertices with levels above t are a side within t, and those for a smaller t are more
/// of the same. Vertices come by their places; `forced` ones have infinite levels.
///
/// `error(from, to, k)` is how far sample k is from the line between two others, `beyond(from, to, k)` whether that is
/// too far, exactly. The same samples give the same levels, so neighbours agree. Cost: O(n · depth).
pub fn levels(
    len: usize,
    forced: &[usize],
    error: impl Fn(usize, usize, usize) -> f64,
    beyond: impl Fn(usize, usize, usize) -> bool,
) -> Vec<Level> {
    let mut stops: Vec<usize> = forced.iter().copied().chain([0, len - 1]).collect();
    stops.sort_unstable();
    stops.dedup();
    let inner = &stops[1..stops.len() - 1];
    let mut found: Vec<Level> = inner.iter().map(|&at| Level { at, level: f64::INFINITY }).collect();
    let mut parts: Vec<(usize, usize, f64)> = stops.windows(2).map(|s| (s[0], s[1], f64::INFINITY)).collect();
    while let Some((from, to, level)) = parts.pop() {
        let mut farthest: Option<(f64, usize)> = None;
        for k in from + 1..to {
            let error = error(from, to, k);
            if farthest.is_none_or(|(most, _)| error > most) && beyond(from, to, k) {
                farthest = Some((error, k));
            }
        }
        let Some((error, at)) = farthest else { continue };
        let level = level.min(error);
        found.push(Level { at, level });
        parts.extend([(from, at, level), (at, to, level)]);
    }
    found.sort_unstable_by_key(|l| l.at);
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn error(heights: &[f64], from: usize, to: usize, k: usize) -> f64 {
        let along = (k - from) as f64 / (to - from) as f64;
        (heights[k] - (heights[from] + along * (heights[to] - heights[from]))).abs()
    }

    proptest! {
        #[test]
        fn every_tolerance_has_its_side(
            heights in prop::collection::vec(-9.0f64..9.0, 2..60), forced in prop::collection::vec(0usize..60, 0..3),
            floor in 0.0f64..3.0, tolerance in 0.0f64..9.0,
        ) {
            let forced: Vec<usize> = forced.into_iter().filter(|&f| f < heights.len()).collect();
            let found = levels(
                heights.len(), &forced, |a, b, k| error(&heights, a, b, k), |a, b, k| error(&heights, a, b, k) > floor,
            );
            prop_assert!(found.iter().all(|l| l.level > floor && l.at > 0 && l.at + 1 < heights.len()));
            let tolerance = tolerance.max(floor);
            let inner = found.iter().filter(|l| l.level > tolerance).map(|l| l.at);
            let side: Vec<usize> = std::iter::once(0).chain(inner).chain([heights.len() - 1]).collect();
            for link in side.windows(2) {
                prop_assert!((link[0] + 1..link[1]).all(|k| error(&heights, link[0], link[1], k) <= tolerance));
            }
            prop_assert!(forced.iter().all(|f| side.contains(f)));
        }
    }
}
