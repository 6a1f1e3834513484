//! How many samples have which error, finely enough for shares.

/// Bins on each side of 0, up to the tolerance.
pub(super) const WITHIN: usize = 1000;
/// Bins of both sides, what is at ε itself, and some that stay empty.
const BINS: usize = (2 * WITHIN).next_power_of_two();
/// Bins of one doubling beyond the tolerance, and doublings that are told apart.
const OF_DOUBLING: usize = 32;
const DOUBLINGS: usize = 64;

/// Counts of errors, in bins: from −ε to ε 2000 of the same size, by signed error; beyond ε 32 for each doubling, by distance. Counts
/// add up to the same in any order. Memory: 16 KiB.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Histogram {
    scale: f64,
    within: Vec<u32>,
    beyond: Vec<u32>,
}

/// The same for more samples than 32 bits count.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Total {
    scale: f64,
    within: Vec<u64>,
    beyond: Vec<u64>,
}

impl Histogram {
    /// For errors that are about so large; 0 is taken for 1.
    pub(super) fn new(tolerance: f64) -> Histogram {
        Histogram { scale: scale(tolerance), within: vec![0; BINS], beyond: vec![0; OF_DOUBLING * DOUBLINGS] }
    }

    /// Counts errors, none of which is farther from 0 than the tolerance.
    #[inline(always)]
    pub(super) fn count_within(&mut self, errors: &[f64]) {
        // A number so large that what is added to it has eight binary digits after the point: the last bits of the sum are the bin
        // and, below it, a fraction. That is several times as fast as to convert to a whole number. What is less than 1/512 of a
        // bin below the next one counts there.
        const MAGIC: f64 = (3u64 << (51 - FRACTION)) as f64;
        const FRACTION: u32 = 8;
        let per_error = WITHIN as f64 / self.scale;
        let within: &mut [u32; BINS] = self.within.as_mut_slice().try_into().expect("so many bins");
        for error in errors {
            let sum = error * per_error + (MAGIC + WITHIN as f64);
            within[(sum.to_bits() >> FRACTION) as usize % BINS] += 1;
        }
    }

    /// Counts any error.
    pub(super) fn count(&mut self, error: f64) {
        let ratio = error.abs() / self.scale;
        if ratio <= 1.0 {
            return self.count_within(&[error]);
        }
        // From the bits of the ratio: exponent, and the first five of the mantissa.
        let steps = (ratio.to_bits() >> 47) - (1f64.to_bits() >> 47);
        self.beyond[(steps as usize).min(OF_DOUBLING * DOUBLINGS - 1)] += 1;
    }
}

impl Total {
    pub(super) fn new(tolerance: f64) -> Total {
        Total { scale: scale(tolerance), within: vec![0; 2 * WITHIN], beyond: vec![0; OF_DOUBLING * DOUBLINGS] }
    }

    pub(super) fn add(&mut self, other: &Histogram) {
        let add = |(sum, count): (&mut u64, &u32)| *sum += u64::from(*count);
        let (within, at_end) = other.within.split_at(2 * WITHIN);
        self.within.iter_mut().zip(within).for_each(add);
        self.within[2 * WITHIN - 1] += at_end.iter().map(|count| u64::from(*count)).sum::<u64>();
        self.beyond.iter_mut().zip(&other.beyond).for_each(add);
    }

    /// How many were counted.
    pub(super) fn samples(&self) -> u64 {
        self.within.iter().chain(&self.beyond).sum()
    }

    /// How many have which signed error within the tolerance, in this number of bins, a divisor of 2000.
    pub(super) fn signed(&self, bins: usize) -> impl Iterator<Item = u64> {
        self.within.chunks(2 * WITHIN / bins).map(|bins| bins.iter().sum())
    }

    /// The distance that this share does not exceed, rounded up to the end of its bin, but never above the largest one.
    pub(super) fn share(&self, share: f64, largest: f64) -> f64 {
        let wanted = (share * self.samples() as f64).ceil() as u64;
        let mut seen = 0;
        let mut is_reached = |count: u64| {
            seen += count;
            seen >= wanted
        };
        let (negative, positive) = self.within.split_at(WITHIN);
        let end = |steps: usize| (steps + 1) as f64 / WITHIN as f64;
        if let Some(bin) = positive.iter().zip(negative.iter().rev()).position(|(a, b)| is_reached(a + b)) {
            return (end(bin) * self.scale).min(largest);
        }
        // The last bin has no end.
        let bin = self.beyond.iter().position(|count| is_reached(*count)).filter(|bin| bin + 1 < self.beyond.len());
        let end = |steps: usize| f64::from_bits(((1f64.to_bits() >> 47) + steps as u64 + 1) << 47);
        bin.map_or(largest, |bin| (end(bin) * self.scale).min(largest))
    }
}

fn scale(tolerance: f64) -> f64 {
    if tolerance > 0.0 { tolerance } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn total(tolerance: f64, errors: &[f64]) -> Total {
        let (mut histogram, mut total) = (Histogram::new(tolerance), Total::new(tolerance));
        errors.iter().for_each(|error| histogram.count(*error));
        total.add(&histogram);
        total
    }

    #[test]
    fn shares_are_no_smaller_than_what_sorting_finds_and_hardly_larger() {
        for tolerance in [0.0, 0.3, 5.0] {
            let scale = scale(tolerance);
            let value = |i: u32| f64::from(i.pow(2)) / 9e6 * scale * if i.is_multiple_of(3) { -1.0 } else { 1.0 };
            let errors: Vec<f64> = (0..5000u32).map(value).collect();
            let found = total(tolerance, &errors);
            let mut distances: Vec<f64> = errors.iter().map(|e| e.abs()).collect();
            distances.sort_by(f64::total_cmp);
            let largest = distances[distances.len() - 1];
            for share in [0.001, 0.5, 0.9, 0.95, 0.99, 1.0] {
                let sorted = distances[(share * distances.len() as f64).ceil() as usize - 1];
                let found = found.share(share, largest);
                let most = sorted * (1.0 + 1.0 / 32.0) + scale / 999.0;
                assert!(sorted <= found * (1.0 + f64::EPSILON) && found <= most, "{share}: {sorted} {found}");
            }
            assert_eq!((found.samples(), found.share(1.0, largest)), (5000, largest));
        }
        assert_eq!(total(1e-300, &[0.0, f64::MAX]).share(1.0, f64::MAX), f64::MAX);
        assert_eq!(Total::new(1.0).share(0.5, 0.0), 0.0);
    }

    #[test]
    fn signs_are_kept_within_the_tolerance() {
        let found = total(2.0, &[-2.0, -0.001, 0.0, 0.001, 1.0, 2.0, 2.1, -7.0]);
        let bins: Vec<u64> = found.signed(4).collect();
        assert_eq!(bins, [1, 1, 2, 2]);
    }
}
