//! How many samples have which error, finely enough for shares, and on ground of which slope.

use super::slopes::NO_CLASS;

/// Bins on each side of 0, up to the tolerance.
const WITHIN: usize = 1000;
/// Bins of both sides, what is at ε itself, and some that stay empty.
const BINS: usize = (2 * WITHIN).next_power_of_two();
/// Bins of one doubling beyond the tolerance, and doublings that are told apart.
const OF_DOUBLING: usize = 32;
const DOUBLINGS: usize = 64;
/// Bins of all classes of slopes, that of none among them, and some that stay empty.
const KEYS: usize = (NO_CLASS + 1).next_power_of_two() * BINS;

/// Where a sample is counted: by its class of slope and its bin.
pub(super) type Key = u16;

/// What turns errors into bins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bins {
    per_error: f32,
}

impl Bins {
    fn new(scale: f64) -> Bins {
        Bins { per_error: (WITHIN as f64 / scale) as f32 }
    }

    /// The bin of an error that is no farther from 0 than the tolerance; of others, any.
    #[inline(always)]
    pub(super) fn bin(self, error: f32) -> u32 {
        // A number so large that what is added to it has eight binary digits after the point: the last bits of the sum are the bin
        // and, below it, a fraction. That is several times as fast as to convert to a whole number. What is less than 1/512 of a
        // bin below the next one counts there.
        const MAGIC: f32 = (3u32 << (22 - FRACTION)) as f32;
        const FRACTION: u32 = 8;
        let sum = error * self.per_error + (MAGIC + WITHIN as f32);
        sum.to_bits() >> FRACTION & (BINS as u32 - 1)
    }
}

/// The key of a sample of this class in this bin.
#[inline(always)]
pub(super) fn key(class: u32, bin: u32) -> Key {
    (class * BINS as u32 + bin) as Key
}

/// The key of the same bin in no class.
#[inline(always)]
pub(super) fn unclassed(of: Key) -> Key {
    key(NO_CLASS as u32, u32::from(of) % BINS as u32)
}

/// The class of a key.
#[inline(always)]
pub(super) fn class_of(key: Key) -> usize {
    usize::from(key) / BINS
}

/// Counts of errors: from −ε to ε in 2000 bins of the same size, by signed error and by class of slope; beyond ε in 32 for each doubling,
/// by distance. Counts add up to the same in any order. Memory: 136 KiB.
#[derive(Debug, Clone)]
pub(super) struct Histogram {
    scale: f64,
    within: Box<[u32; KEYS]>,
    beyond: Vec<u32>,
}

/// The same for more samples than 32 bits count.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Total {
    scale: f64,
    within: Vec<u64>,
    beyond: Vec<u64>,
}

/// What one class of slope comes to, to a thousandth of the tolerance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Binned {
    pub(super) samples: u64,
    /// Of errors, each in the middle of its bin; 0 in the two bins beside it.
    pub(super) squares: f64,
    /// The farther end of the farthest bin.
    pub(super) max: f64,
}

impl Histogram {
    /// For errors that are about so large; 0 is taken for 1.
    pub(super) fn new(tolerance: f64) -> Histogram {
        let within = Box::new([0; KEYS]);
        Histogram { scale: scale(tolerance), within, beyond: vec![0; OF_DOUBLING * DOUBLINGS] }
    }

    /// Counts a sample.
    #[inline(always)]
    pub(super) fn count(&mut self, key: Key) {
        self.within[usize::from(key) % KEYS] += 1;
    }

    /// Counts samples.
    #[inline(always)]
    pub(super) fn count_all(&mut self, keys: &[Key]) {
        let (eights, last) = keys.as_chunks::<8>();
        // Written out, as the compiler leaves loops that change memory as they are.
        for [a, b, c, d, e, f, g, h] in eights {
            self.count(*a);
            self.count(*b);
            self.count(*c);
            self.count(*d);
            self.count(*e);
            self.count(*f);
            self.count(*g);
            self.count(*h);
        }
        last.iter().for_each(|key| self.count(*key));
    }

    /// Counts any error, in no class.
    pub(super) fn count_any(&mut self, error: f64) {
        let ratio = error.abs() / self.scale;
        if ratio <= 1.0 {
            // As `Bins::bin`: what is less than 1/512 of a bin below the next one counts there.
            let bin = (error / self.scale + 1.0) * WITHIN as f64 + 1.0 / 512.0;
            return self.count(key(NO_CLASS as u32, bin as u32));
        }
        // From the bits of the ratio: exponent, and the first five of the mantissa.
        let steps = (ratio.to_bits() >> 47) - (1f64.to_bits() >> 47);
        self.beyond[(steps as usize).min(OF_DOUBLING * DOUBLINGS - 1)] += 1;
    }
}

impl Total {
    pub(super) fn new(tolerance: f64) -> Total {
        Total { scale: scale(tolerance), within: vec![0; KEYS], beyond: vec![0; OF_DOUBLING * DOUBLINGS] }
    }

    /// What turns errors into bins of these.
    pub(super) fn bins(&self) -> Bins {
        Bins::new(self.scale)
    }

    pub(super) fn add(&mut self, other: &Histogram) {
        let add = |(sum, count): (&mut u64, &u32)| *sum += u64::from(*count);
        self.within.iter_mut().zip(other.within.iter()).for_each(add);
        self.beyond.iter_mut().zip(&other.beyond).for_each(add);
    }

    /// How many were counted.
    pub(super) fn samples(&self) -> u64 {
        self.within.iter().chain(&self.beyond).sum()
    }

    /// What was counted of a class.
    pub(super) fn of_class(&self, class: usize) -> Binned {
        let mut binned = Binned { samples: 0, squares: 0.0, max: 0.0 };
        let bins = &self.within[class * BINS..(class + 1) * BINS];
        for (bin, count) in bins.iter().enumerate().filter(|(_, count)| **count > 0) {
            let bin = bin.min(2 * WITHIN - 1);
            // Steps from 0 to its nearer end.
            let steps = if bin < WITHIN { WITHIN - 1 - bin } else { bin - WITHIN };
            let middle = if steps == 0 { 0.0 } else { (steps as f64 + 0.5) / WITHIN as f64 * self.scale };
            binned.samples += count;
            binned.squares += *count as f64 * middle * middle;
            binned.max = binned.max.max((steps + 1) as f64 / WITHIN as f64 * self.scale);
        }
        binned
    }

    /// The bins within the tolerance, all classes together.
    fn of_all_classes(&self) -> [u64; 2 * WITHIN] {
        let mut all = [0; 2 * WITHIN];
        for bins in self.within.chunks(BINS) {
            for (bin, count) in bins.iter().enumerate() {
                all[bin.min(2 * WITHIN - 1)] += count;
            }
        }
        all
    }

    /// How many have which signed error within the tolerance, in this number of bins, a divisor of 2000.
    pub(super) fn signed(&self, bins: usize) -> Vec<u64> {
        self.of_all_classes().chunks(2 * WITHIN / bins).map(|bins| bins.iter().sum()).collect()
    }

    /// The distances that these shares do not exceed, rounded up to the end of their bins, but never above the largest one.
    pub(super) fn shares(&self, shares: impl IntoIterator<Item = f64>, largest: f64) -> Vec<f64> {
        let (bins, samples) = (self.of_all_classes(), self.samples());
        shares.into_iter().map(|share| self.share((share * samples as f64).ceil() as u64, &bins, largest)).collect()
    }

    fn share(&self, wanted: u64, bins: &[u64; 2 * WITHIN], largest: f64) -> f64 {
        let mut seen = 0;
        let mut is_reached = |count: u64| {
            seen += count;
            seen >= wanted
        };
        let (negative, positive) = bins.split_at(WITHIN);
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
        errors.iter().for_each(|error| histogram.count_any(*error));
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
                let found = found.shares([share], largest)[0];
                let most = sorted * (1.0 + 1.0 / 32.0) + scale / 999.0;
                assert!(sorted <= found * (1.0 + f64::EPSILON) && found <= most, "{share}: {sorted} {found}");
            }
            assert_eq!((found.samples(), found.shares([1.0], largest)), (5000, vec![largest]));
        }
        assert_eq!(total(1e-300, &[0.0, f64::MAX]).shares([1.0], f64::MAX), [f64::MAX]);
        assert_eq!(Total::new(1.0).shares([0.5], 0.0), [0.0]);
    }

    #[test]
    fn signs_are_kept_within_the_tolerance() {
        let found = total(2.0, &[-2.0, -0.001, -1e-13, 0.0, 0.001, 1.0, 2.0, 2.1, -7.0]);
        assert_eq!(found.signed(4), [1, 1, 3, 2], "next to nothing has no sign");
    }

    #[test]
    fn classes_are_known_to_a_thousandth_of_the_tolerance() {
        let (mut histogram, mut total) = (Histogram::new(2.0), Total::new(2.0));
        let errors: Vec<f64> = (0..3000).map(|i| (f64::from(i) / 2999.0 - 0.3) * 2.0).collect();
        for error in &errors {
            histogram.count(key(3, total.bins().bin(*error as f32)));
        }
        histogram.count(key(5, total.bins().bin(0.0)));
        histogram.count_any(2.0);
        total.add(&histogram);
        let Binned { samples, squares, max } = total.of_class(3);
        let expected = errors.iter().map(|error| error * error).sum::<f64>();
        assert_eq!((samples, max), (3000, 1.402), "1.4 is where a bin begins");
        let rms = [squares, expected].map(|squares| (squares / 3000.0).sqrt());
        assert!((rms[0] - rms[1]).abs() < 2.0 / 1000.0, "{rms:?}");
        assert_eq!(total.of_class(5), Binned { samples: 1, squares: 0.0, max: 0.002 });
        assert_eq!(total.of_class(0), Binned { samples: 0, squares: 0.0, max: 0.0 });
    }
}
