//! Clarkson's reweighting: a small hitting set of a set system, or a small cover (the paper's section 4, Figure 4).
//!
//! Elements are ranges that cover points; wanted are few elements that together cover every point. In the paper elements are
//! triangles; here they are whatever [`Elements`] says.

/// Elements and the points that they cover.
pub trait Elements {
    /// How many elements there are.
    fn elements(&self) -> usize;

    /// How many points there are.
    fn points(&self) -> usize;

    /// Whether an element covers a point.
    fn covers(&self, element: usize, point: usize) -> bool;

    /// The first point that none of these elements covers.
    fn missed_by(&self, elements: &[usize]) -> Option<usize> {
        (0..self.points()).find(|&point| !elements.iter().any(|&element| self.covers(element, point)))
    }
}

/// What a search has come to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct HittingSet {
    /// The elements that cover every point, ascending, each once, and none that the others make needless.
    pub chosen: Vec<usize>,
    /// How many elements there are.
    pub elements: usize,
    /// How many different elements had been drawn, before needless ones went. (The paper keeps them.)
    pub drawn: usize,
    /// The size c that the search believed the least hitting set to have: doubled from 1 on until one was found.
    pub believed: usize,
    /// Iterations in which weights were doubled, with the last c.
    pub successful: usize,
    /// All iterations with the last c.
    pub iterations: usize,
}

/// Finds elements that cover every point: O(c log c) of them, where c is the size of the fewest that do; `None` where a
/// point is in no element. The same seed gives the same set.
///
/// For a given c elements are drawn with probabilities proportional to their weights, all 1 at first. If a point is
/// covered by none that was drawn, and the elements that cover it weigh less than 1/2c of all, these are doubled. Where
/// c elements cover all points, there are at most [`most_successful`] such iterations; after that c was too small.
/// Cost: elements × iterations, and what it costs to find a point that the elements drawn miss, as often.
pub fn hitting_set(system: &impl Elements, seed: u64) -> Option<HittingSet> {
    let all: Vec<usize> = (0..system.elements()).collect();
    if system.missed_by(&all).is_some() {
        return None;
    }
    if system.points() == 0 {
        return Some(HittingSet {
            chosen: Vec::new(),
            elements: system.elements(),
            drawn: 0,
            believed: 0,
            successful: 0,
            iterations: 0,
        });
    }
    let mut random = Random(seed);
    let mut believed = 1;
    loop {
        if let Some(found) = search(system, believed, &mut random) {
            return Some(found);
        }
        believed *= 2;
    }
}

/// The most iterations in which weights are doubled, where c of n elements cover all points: 4c·log₂(n/c), and 4c where that is
/// more. Each time
/// the weight of all grows by less than the share 1/2c, and one of the c doubles.
pub fn most_successful(believed: usize, elements: usize) -> usize {
    let (c, n) = (believed as f64, elements as f64);
    (4.0 * c * (n / c).log2().max(1.0)).floor() as usize
}

/// How many elements are drawn: enough for a net of all points whose elements weigh 1/2c, with probability above a half.
fn sample_size(believed: usize) -> usize {
    let c = believed as f64;
    (4.0 * c * (c + 1.0).log2()).ceil() as usize
}

/// What has no success so often in a row, c being too small or chance being against it, ends a search.
const PATIENCE: usize = 64;

fn search(system: &impl Elements, believed: usize, random: &mut Random) -> Option<HittingSet> {
    let count = system.elements();
    let mut weights = vec![1.0f64; count];
    let (mut successful, mut in_vain, mut iterations) = (0, 0, 0);
    let most = most_successful(believed, count);
    let size = sample_size(believed);
    loop {
        iterations += 1;
        let chosen = if size >= count { (0..count).collect() } else { draw(&weights, size, random) };
        let Some(point) = system.missed_by(&chosen) else {
            let drawn = chosen.len();
            return Some(HittingSet {
                chosen: needed(system, chosen),
                elements: count,
                drawn,
                believed,
                successful,
                iterations,
            });
        };
        let total: f64 = weights.iter().sum();
        let around: Vec<usize> = (0..count).filter(|&element| system.covers(element, point)).collect();
        let weight: f64 = around.iter().map(|&element| weights[element]).sum();
        if weight < total / (2.0 * believed as f64) {
            around.into_iter().for_each(|element| weights[element] *= 2.0);
            (successful, in_vain) = (successful + 1, 0);
        } else {
            in_vain += 1;
        }
        if successful > most || in_vain > PATIENCE {
            return None;
        }
        if total > 1e250 {
            // Only shares matter.
            weights.iter_mut().for_each(|weight| *weight /= total);
        }
    }
}

/// Elements without those that the others make needless: of those that cover the fewest points first.
fn needed(system: &impl Elements, chosen: Vec<usize>) -> Vec<usize> {
    let points = |element: usize| (0..system.points()).filter(move |&point| system.covers(element, point));
    let mut times = vec![0u32; system.points()];
    let mut order: Vec<(usize, usize)> = chosen.into_iter().map(|element| (points(element).count(), element)).collect();
    order.iter().for_each(|&(_, element)| points(element).for_each(|point| times[point] += 1));
    order.sort_unstable();
    order.retain(|&(_, element)| {
        let is_needed = points(element).any(|point| times[point] == 1);
        if !is_needed {
            points(element).for_each(|point| times[point] -= 1);
        }
        is_needed
    });
    let mut needed: Vec<usize> = order.into_iter().map(|(_, element)| element).collect();
    needed.sort_unstable();
    needed
}

/// Draws elements by weight, with replacement; ascending, each once.
fn draw(weights: &[f64], size: usize, random: &mut Random) -> Vec<usize> {
    let mut sums = Vec::with_capacity(weights.len());
    let mut sum = 0.0;
    for weight in weights {
        sum += weight;
        sums.push(sum);
    }
    let pick = |share: f64| sums.partition_point(|&upto| upto <= share * sum).min(weights.len() - 1);
    let mut chosen: Vec<usize> = (0..size).map(|_| pick(random.share())).collect();
    chosen.sort_unstable();
    chosen.dedup();
    chosen
}

/// Numbers as good as random (SplitMix64).
struct Random(u64);

impl Random {
    /// From 0 up to 1, without it.
    fn share(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Intervals over points 0, 1, …
    struct Intervals(Vec<(usize, usize)>, usize);

    impl Elements for Intervals {
        fn elements(&self) -> usize {
            self.0.len()
        }

        fn points(&self) -> usize {
            self.1
        }

        fn covers(&self, element: usize, point: usize) -> bool {
            (self.0[element].0..=self.0[element].1).contains(&point)
        }
    }

    /// The fewest intervals that cover all points: always the one that reaches farthest.
    fn fewest(system: &Intervals) -> Option<usize> {
        let (mut next, mut count) = (0, 0);
        while next < system.1 {
            let reach = system.0.iter().filter(|i| i.0 <= next && i.1 >= next).map(|i| i.1).max()?;
            (next, count) = (reach + 1, count + 1);
        }
        Some(count)
    }

    proptest! {
        #[test]
        fn every_point_is_covered_by_few(
            ends in prop::collection::vec((0usize..40, 0usize..12), 1..120), points in 1usize..40, seed in any::<u64>(),
        ) {
            let system = Intervals(ends.into_iter().map(|(from, len)| (from, from + len)).collect(), points);
            let found = hitting_set(&system, seed);
            prop_assert_eq!(&found, &hitting_set(&system, seed));
            let Some(fewest) = fewest(&system) else { prop_assert!(found.is_none()); return Ok(()) };
            let found = found.expect("all points are in intervals");
            prop_assert!((0..points).all(|p| found.chosen.iter().any(|&e| system.covers(e, p))));
            prop_assert!((fewest..=found.drawn).contains(&found.chosen.len()));
            let covers_without = |e: usize| {
                (0..points).all(|p| found.chosen.iter().any(|&other| other != e && system.covers(other, p)))
            };
            prop_assert!(!found.chosen.iter().any(|&e| covers_without(e)), "a needless element");
            prop_assert!(found.successful < found.iterations);
            // From the least cover on the iterations of the lemma are enough: c is not doubled again.
            prop_assert!(found.believed < 2 * fewest, "{} for {}", found.believed, fewest);
            prop_assert!(found.drawn <= sample_size(found.believed));
        }
    }

    #[test]
    fn no_points_need_nothing() {
        let found = hitting_set(&Intervals(vec![(0, 1)], 0), 1).expect("nothing to cover");
        assert!(found.chosen.is_empty());
    }
}
