//! Lower bounds against other code: rational numbers instead of bounds on rounding, all triples and fours instead of hulls and
//! exchanges, and on small grids all triangles there are.

use std::collections::HashSet;

use num_rational::BigRational;
use terrabite::base::{Heights, Tile};

use super::samples::{At, Samples, gcd, orient};
use super::{Bounds, lower_bounds, weighed};

/// Rough ground of whole numbers, by a multiplicative generator.
fn ground(width: usize, height: usize, seed: u64, rough: u64) -> Tile {
    let mut state = seed | 1;
    let mut noise = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) % (rough + 1)
    };
    let heights = (0..width * height).map(|i| {
        let (x, y) = ((i % width) as f32, (i / width) as f32);
        ((x * x + 2.0 * x * y - y * y) / 3.0).round() + noise() as f32
    });
    Tile::from_heights(width, height, Heights::F32(heights.collect()))
}

fn rational(z: f64) -> BigRational {
    BigRational::from_float(z).expect("a finite number")
}

/// Whether some plane is within the tolerance of all samples: if one is within it of any three on a line and of any four.
struct Naive<'a> {
    tile: &'a Tile,
    tolerance: f64,
}

impl Naive<'_> {
    fn height(&self, at: At) -> BigRational {
        rational(self.tile.at(at.0 as usize, at.1 as usize))
    }

    /// Σ wᵢzᵢ against ε Σ |wᵢ|.
    fn exceeds(&self, terms: &[(i64, At)]) -> bool {
        let whole = |w: i64| rational(w as f64);
        let zero = rational(0.0);
        let sum: BigRational = terms.iter().map(|&(w, at)| whole(w) * self.height(at)).sum();
        let limit = whole(terms.iter().map(|(w, _)| w.abs()).sum()) * rational(self.tolerance);
        (if sum < zero { -sum } else { sum }) > limit
    }

    fn three_bend(&self, a: At, b: At, c: At) -> bool {
        let place = |p: At| i64::from(p.0 - a.0) * i64::from(c.0 - a.0) + i64::from(p.1 - a.1) * i64::from(c.1 - a.1);
        self.exceeds(&[(place(c) - place(b), a), (-place(c), b), (place(b), c)])
    }

    fn bends(&self, p: At, q: At) -> bool {
        let n = gcd(q.0 - p.0, q.1 - p.1);
        let at = |i: i32| (p.0 + (q.0 - p.0) / n * i, p.1 + (q.1 - p.1) / n * i);
        (0..=n).any(|i| (i + 1..=n).any(|j| (j + 1..=n).any(|k| self.three_bend(at(i), at(j), at(k)))))
    }

    fn four_warp(&self, [a, b, c, d]: [At; 4]) -> bool {
        let weights = [orient(b, c, d), -orient(a, c, d), orient(a, b, d), -orient(a, b, c)];
        self.exceeds(&[(weights[0], a), (weights[1], b), (weights[2], c), (weights[3], d)])
    }
}

/// All sets of samples of a small grid that closed triangles cut out, as bits.
fn traces(samples: &[At]) -> HashSet<u32> {
    let bit = |keep: &dyn Fn(At) -> bool| {
        samples.iter().enumerate().filter(|&(_, &p)| keep(p)).fold(0u32, |m, (i, _)| m | 1 << i)
    };
    let mut halves: HashSet<u32> = HashSet::from([0, bit(&|_| true)]);
    for &a in samples {
        for &b in samples.iter().filter(|&&b| b != a) {
            let along = |p: At| (p.0 - a.0) * (b.0 - a.0) + (p.1 - a.1) * (b.1 - a.1);
            // What is to the left of the line, and of what is on it all that comes after, or before, some sample.
            for &c in samples.iter().filter(|&&c| orient(a, b, c) == 0) {
                halves.insert(bit(&|p| orient(a, b, p) > 0 || orient(a, b, p) == 0 && along(p) >= along(c)));
                halves.insert(bit(&|p| orient(a, b, p) > 0 || orient(a, b, p) == 0 && along(p) > along(c)));
                halves.insert(bit(&|p| orient(a, b, p) > 0 || orient(a, b, p) == 0 && along(p) <= along(c)));
                halves.insert(bit(&|p| orient(a, b, p) > 0 || orient(a, b, p) == 0 && along(p) < along(c)));
            }
        }
    }
    let pairs: HashSet<u32> = halves.iter().flat_map(|a| halves.iter().map(move |b| a & b)).collect();
    pairs.iter().flat_map(|a| halves.iter().map(move |b| a & b)).collect()
}

/// All samples of a tile, by rows.
fn all(tile: &Tile) -> Vec<At> {
    (0..tile.height() as i32).flat_map(|r| (0..tile.width() as i32).map(move |c| (c, r))).collect()
}

/// Sets of a small grid that a triangle within the tolerance holds.
fn feasible(tile: &Tile, tolerance: f64, traces: &HashSet<u32>) -> Vec<u32> {
    let (samples, naive) = (all(tile), Naive { tile, tolerance });
    let n = samples.len();
    let mut refuted: Vec<u32> = Vec::new();
    for i in 0..n {
        for j in i + 1..n {
            for k in j + 1..n {
                // By rows, the middle one of three on a line is the second.
                let [a, b, c] = [i, j, k].map(|i| samples[i]);
                if orient(a, b, c) == 0 && naive.three_bend(a, b, c) {
                    refuted.push(1 << i | 1 << j | 1 << k);
                }
                for l in k + 1..n {
                    if naive.four_warp([i, j, k, l].map(|i| samples[i])) {
                        refuted.push(1 << i | 1 << j | 1 << k | 1 << l);
                    }
                }
            }
        }
    }
    traces.iter().copied().filter(|m| refuted.iter().all(|r| m & r != *r)).collect()
}

/// The fewest sets that cover everything. No other sets are needed than those that are in no larger one.
fn fewest(sets: &[u32], samples: usize) -> usize {
    let largest = |&set: &u32| sets.iter().all(|&other| other == set || other & set != set);
    let sets: Vec<u32> = sets.iter().copied().filter(largest).collect();
    let mut least = vec![usize::MAX; 1 << samples];
    let whole = (1usize << samples) - 1;
    least[0] = 0;
    for covered in 0..whole {
        if least[covered] == usize::MAX {
            continue;
        }
        let first = (!covered).trailing_zeros();
        for &set in sets.iter().filter(|&&set| set >> first & 1 == 1) {
            let next = covered | set as usize;
            least[next] = least[next].min(least[covered] + 1);
        }
    }
    least[whole]
}

/// Of each two of these samples one triangle holds one, says naive code.
fn check_incompatible(tile: &Tile, tolerance: f64, incompatible: &[At]) {
    let naive = Naive { tile, tolerance };
    for (i, &p) in incompatible.iter().enumerate() {
        assert!(incompatible[..i].iter().all(|&q| naive.bends(q, p)), "{p:?} at {tolerance}");
    }
}

/// Weights of all samples and of some: no triangle holds more than is said, and the bounds are below what is needed.
#[test]
fn all_triangles_of_small_grids_agree() {
    let (mut found, mut needed) = (0, 0);
    for (width, height) in [(4, 4), (5, 3), (3, 5)] {
        let samples = all(&ground(width, height, 0, 0));
        let traces = traces(&samples);
        for (seed, tolerance) in (0..4).flat_map(|seed| [0.0, 0.4, 1.0, 2.5].map(|tolerance| (seed, tolerance))) {
            let tile = ground(width, height, seed, 2 * seed);
            let Bounds { incompatible, weighed: some } = lower_bounds(&tile, tolerance);
            let every = weighed(Samples { tile: &tile, tolerance }, samples.clone()).expect("few sets");
            check_incompatible(&tile, tolerance, &incompatible);
            let sets = feasible(&tile, tolerance, &traces);
            let number = |at: &At| samples.iter().position(|s| s == at).expect("a sample");
            for (&set, weighed) in sets.iter().flat_map(|set| [(set, &some), (set, &every)]) {
                let inside = weighed.weights.iter().filter(|(at, _)| set >> number(at) & 1 == 1);
                let held: u64 = inside.map(|(_, weight)| weight).sum();
                assert!(
                    held <= weighed.heaviest,
                    "{set:b} of seed {seed} at {tolerance}: {held} of {}",
                    weighed.heaviest
                );
            }
            let fewest = fewest(&sets, samples.len()) as u64;
            let bounds = [incompatible.len() as u64, some.triangles(), every.triangles()];
            assert!(bounds.iter().all(|&bound| bound <= fewest), "seed {seed} at {tolerance}: {bounds:?} of {fewest}");
            (found, needed) = (found + every.triangles(), needed + fewest);
        }
    }
    // With all samples little is lost.
    assert!(needed > 100 && 10 * found >= 9 * needed, "{found} of {needed}");
}

#[test]
fn pairs_are_incompatible_in_rational_numbers() {
    for (seed, tolerance) in [(1, 1.5), (2, 4.0)] {
        let tile = ground(40, 30, seed, 12);
        let Bounds { incompatible, weighed } = lower_bounds(&tile, tolerance);
        assert!(incompatible.len() > 10, "{}", incompatible.len());
        check_incompatible(&tile, tolerance, &incompatible);
        assert!(weighed.triangles() >= incompatible.len() as u64, "{}", weighed.triangles());
    }
}
