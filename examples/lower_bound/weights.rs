//! Weights of samples, no set heavier than 1, and as heavy as may be together: a packing, found by multiplicative weights.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// A set and what it weighed when it was looked at last. Weights only fall.
struct Weighed {
    weight: f64,
    set: usize,
}

impl PartialEq for Weighed {
    fn eq(&self, other: &Weighed) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Weighed {}

impl PartialOrd for Weighed {
    fn partial_cmp(&self, other: &Weighed) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Weighed {
    fn cmp(&self, other: &Weighed) -> Ordering {
        self.weight.total_cmp(&other.weight).then(other.set.cmp(&self.set))
    }
}

/// Whole numbers, one for each of `count` samples, and the most that a set comes to: the sum of the numbers over that is a
/// lower bound. Every sample is in some set.
///
/// The heaviest set loses a share of its weight, again and again; of all states the best is kept.
pub(crate) fn weights(sets: &[Vec<u32>], count: usize) -> (Vec<u64>, u64) {
    let mut weight = vec![1.0f64; count];
    let of_set = |set: usize, weight: &[f64]| sets[set].iter().map(|&i| weight[i as usize]).sum::<f64>();
    let mut heap: BinaryHeap<Weighed> =
        (0..sets.len()).map(|set| Weighed { weight: of_set(set, &weight), set }).collect();
    let mut best = (0.0, weight.clone());
    for (share, steps) in [(0.1, 100), (0.03, 300), (0.01, 600)] {
        for _ in 0..steps {
            // The sum anew: differences would add up.
            let mut total: f64 = weight.iter().sum();
            for _ in 0..count {
                let Some(mut top) = heap.peek_mut() else { break };
                let now = of_set(top.set, &weight);
                if now < top.weight {
                    top.weight = now;
                    continue;
                }
                if total / now > best.0 {
                    best = (total / now, weight.clone());
                }
                for &i in &sets[top.set] {
                    total -= share * weight[i as usize];
                    weight[i as usize] *= 1.0 - share;
                }
            }
        }
    }
    let most = best.1.iter().copied().fold(0.0, f64::max);
    let whole: Vec<u64> = best.1.iter().map(|w| (w / most * UNITS) as u64).collect();
    let heaviest = sets.iter().map(|set| set.iter().map(|&i| whole[i as usize]).sum()).max().unwrap_or(1);
    (whole, heaviest)
}

/// The largest number of a sample.
const UNITS: f64 = 1e6;
