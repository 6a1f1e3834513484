//! How many samples have which error, finely enough for shares.

/// Bins from 0 to the tolerance.
const WITHIN: usize = 1024;
/// Bins of one doubling beyond the tolerance, and doublings that are told apart.
const OF_DOUBLING: usize = 32;
const DOUBLINGS: usize = 64;

/// Counts of distances, in bins: 1024 of the same size from 0 to the tolerance, and beyond it 32 for each doubling. Counts add up
/// to the same in any order. Memory: 24 KiB.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Histogram {
    scale: f64,
    counts: Vec<u64>,
}

impl Histogram {
    /// For distances that are about so large; 0 is taken for 1.
    pub(super) fn new(tolerance: f64) -> Histogram {
        let scale = if tolerance > 0.0 { tolerance } else { 1.0 };
        Histogram { scale, counts: vec![0; WITHIN + OF_DOUBLING * DOUBLINGS] }
    }

    /// Counts a distance.
    #[inline(always)]
    pub(super) fn count(&mut self, distance: f64) {
        let ratio = distance / self.scale;
        let bin = if ratio < 1.0 { (ratio * WITHIN as f64) as usize } else { beyond(ratio) };
        self.counts[bin] += 1;
    }

    pub(super) fn add(&mut self, other: &Histogram) {
        self.counts.iter_mut().zip(&other.counts).for_each(|(sum, count)| *sum += count);
    }

    /// How many were counted.
    pub(super) fn total(&self) -> u64 {
        self.counts.iter().sum()
    }

    /// The distance that this share does not exceed, rounded up to the end of its bin, but never above the largest one.
    pub(super) fn share(&self, share: f64, largest: f64) -> f64 {
        let wanted = (share * self.total() as f64).ceil() as u64;
        let mut seen = 0;
        let found = self.counts.iter().position(|count| {
            seen += count;
            seen >= wanted
        });
        // The last bin has no end.
        let bin = found.filter(|bin| bin + 1 < self.counts.len());
        bin.map_or(largest, |bin| (end_of(bin) * self.scale).min(largest))
    }
}

/// The bin of a distance of at least the tolerance, from the bits of the ratio: exponent, and the first five of the mantissa.
fn beyond(ratio: f64) -> usize {
    let steps = (ratio.to_bits() >> 47) - (1f64.to_bits() >> 47);
    WITHIN + (steps as usize).min(OF_DOUBLING * DOUBLINGS - 1)
}

/// Where a bin ends, as a multiple of the tolerance.
fn end_of(bin: usize) -> f64 {
    match bin.checked_sub(WITHIN) {
        None => (bin + 1) as f64 / WITHIN as f64,
        Some(steps) => f64::from_bits(((1f64.to_bits() >> 47) + steps as u64 + 1) << 47),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_no_smaller_than_what_sorting_finds_and_hardly_larger() {
        for tolerance in [0.0, 0.3, 5.0] {
            let scale = if tolerance > 0.0 { tolerance } else { 1.0 };
            let mut values: Vec<f64> = (0..5000u32).map(|i| f64::from(i.pow(2)) / 9e6 * scale).collect();
            let mut histogram = Histogram::new(tolerance);
            values.iter().rev().for_each(|v| histogram.count(*v));
            values.sort_by(f64::total_cmp);
            let largest = values[values.len() - 1];
            for share in [0.001, 0.5, 0.9, 0.95, 0.99, 1.0] {
                let sorted = values[(share * values.len() as f64).ceil() as usize - 1];
                let found = histogram.share(share, largest);
                assert!(
                    sorted <= found && found <= sorted * (1.0 + 1.0 / 32.0) + scale / 1024.0,
                    "{share}: {sorted} {found}"
                );
            }
            assert_eq!((histogram.total(), histogram.share(1.0, largest)), (5000, largest));
        }
        let mut far = Histogram::new(1e-300);
        [0.0, f64::MAX].into_iter().for_each(|v| far.count(v));
        assert_eq!(far.share(1.0, f64::MAX), f64::MAX);
        assert_eq!(Histogram::new(1.0).share(0.5, 0.0), 0.0);
    }
}
