//! The tolerance test without rounding: signs of sums of (integer × double), by floating-point expansions.
//!
//! Every test of the engines comes down to |Σ wᵢ·zᵢ| ≤ s·ε with integer weights (orientations) and doubles that are
//! heights. A fast evaluation with an error bound settles all but near ties; those are settled here with Shewchuk's
//! expansions (Adaptive Precision Floating-Point Arithmetic, 1997, sections 2.4 to 2.7): a sum is kept as doubles of
//! increasing magnitude that do not overlap, so the last one carries the sign.

use std::cmp::Ordering;

/// The most terms a test may have.
const MAX_TERMS: usize = 8;

/// Heights beyond this are refused before they get here, so that no product overflows.
pub const MAX_HEIGHT: f64 = 1e30;

/// A tolerance that allows everything heights can do; larger ones are no different.
pub const MAX_TOLERANCE: f64 = 4.0 * MAX_HEIGHT;

/// The most a sample's importance can weigh, as far as [`limit`] is used.
pub const MAX_WEIGHT: f64 = 1e30;

/// The largest error allowed where errors weigh `weight`: the largest double t with t · `weight` ≤ `tolerance`, exactly,
/// but at most [`MAX_TOLERANCE`]. A weight of 0 allows everything, a weight of 1 the tolerance itself (up to
/// [`MAX_TOLERANCE`]). Both numbers are finite and at least 0.
pub fn limit(weight: f64, tolerance: f64) -> f64 {
    if weight == 0.0 {
        return MAX_TOLERANCE;
    }
    // The quotient is rounded to the nearest double: it is the one looked for, or the one after.
    let nearest = (tolerance / weight).min(MAX_TOLERANCE);
    // Correctly rounded, the difference has the sign of the exact one as long as it does not underflow, and it is a
    // multiple of units of 2⁻¹⁰⁴ of the product: a small tolerance is raised, with the quotient, by a power of two.
    const RAISE: f64 = (1u128 << 127) as f64 * (1u128 << 73) as f64;
    let raise = if tolerance < 1.0 { RAISE } else { 1.0 };
    let exceeds = (nearest * raise).mul_add(weight, -(tolerance * raise)) > 0.0;
    if exceeds { nearest.next_down() } else { nearest }
}

/// Whether |Σ wᵢ·zᵢ| ≤ `scale` · `tolerance`, exactly. Weights and `scale` are below 2⁵³ in magnitude, `scale` is
/// positive, every zᵢ is finite and within [`MAX_HEIGHT`], the tolerance within [`MAX_TOLERANCE`]. At most eight terms.
pub fn within(terms: &[(i64, f64)], scale: i64, tolerance: f64) -> bool {
    debug_assert!(terms.len() <= MAX_TERMS, "{} terms", terms.len());
    let (mut sum, mut magnitude) = (0.0f64, 0.0f64);
    for &(w, z) in terms {
        let product = w as f64 * z;
        sum += product;
        magnitude += product.abs();
    }
    let limit = scale as f64 * tolerance;
    // One rounding per product, at most seven per sum, one in the limit: far below 16 units of 2⁻⁵³.
    let doubt = (magnitude + limit) * (16.0 * f64::EPSILON);
    let excess = sum.abs() - limit;
    if excess.abs() > doubt {
        return excess < 0.0;
    }
    exactly_within(terms, scale, tolerance)
}

/// |Σ wᵢ·zᵢ| ÷ `scale`, correctly rounded: the double nearest to the exact quotient, of two the even one. The same limits as
/// for [`within`], at most six terms.
pub fn quotient(terms: &[(i64, f64)], scale: i64) -> f64 {
    debug_assert!(terms.len() + 2 <= MAX_TERMS, "{} terms", terms.len());
    let mut doubled = Expansion::ZERO;
    for &(w, z) in terms {
        doubled.add_product(2.0 * w as f64, z);
    }
    if doubled.sign() < 0.0 {
        doubled.parts[..doubled.len].iter_mut().for_each(|part| *part = -*part);
    }
    // Twice the sum less scale · (q + neighbour): positive if the sum is beyond the middle between the two.
    let beyond = |q: f64, neighbour: f64| {
        let mut difference = doubled;
        difference.add_product(-(scale as f64), q);
        difference.add_product(-(scale as f64), neighbour);
        difference.sign()
    };
    let is_odd = |q: f64| q.to_bits() & 1 == 1;
    let mut q = doubled.parts[..doubled.len].iter().sum::<f64>() / 2.0 / scale as f64;
    loop {
        let (up, down) = (q.next_up(), q.next_down());
        let above = beyond(q, up);
        if above > 0.0 || (above == 0.0 && is_odd(q)) {
            q = up;
            continue;
        }
        let below = if q > 0.0 { beyond(q, down) } else { 1.0 };
        if below < 0.0 || (below == 0.0 && is_odd(q)) {
            q = down;
            continue;
        }
        return q;
    }
}

/// The sign of Σ wᵢ·zᵢ, exactly; the same limits as for [`within`].
pub fn sign(terms: &[(i64, f64)]) -> Ordering {
    let (mut sum, mut magnitude) = (0.0f64, 0.0f64);
    for &(w, z) in terms {
        let product = w as f64 * z;
        sum += product;
        magnitude += product.abs();
    }
    if sum.abs() > magnitude * (16.0 * f64::EPSILON) {
        return sum.total_cmp(&0.0);
    }
    if let Some(sum) = sum_of_integers(terms) {
        return sum.cmp(&0);
    }
    let mut exact = Expansion::ZERO;
    for &(w, z) in terms {
        exact.add_product(w as f64, z);
    }
    // Components are never zero, and an empty sum is +0.
    exact.sign().total_cmp(&0.0)
}

/// The sum where every zᵢ is an integer, as ties mostly are: on flat ground and in integer rasters.
fn sum_of_integers(terms: &[(i64, f64)]) -> Option<i128> {
    let mut sum = 0i128;
    for &(w, z) in terms {
        sum += i128::from(w) * i128::from(integer(z)?);
    }
    Some(sum)
}

/// An integer below 2⁵³, so that eight products with weights below 2⁵³ fit an `i128`.
fn integer(z: f64) -> Option<i64> {
    let whole = z as i64;
    (whole as f64 == z && whole.unsigned_abs() < 1 << 53).then_some(whole)
}

fn exactly_within(terms: &[(i64, f64)], scale: i64, tolerance: f64) -> bool {
    if let (Some(sum), Some(tolerance)) = (sum_of_integers(terms), integer(tolerance)) {
        return sum.abs() <= i128::from(scale) * i128::from(tolerance);
    }
    let mut sum = Expansion::ZERO;
    for &(w, z) in terms {
        sum.add_product(w as f64, z);
    }
    // |S| ≤ L ⟺ S − L ≤ 0 and S + L ≥ 0
    let (mut below, mut above) = (sum, sum);
    below.add_product(-(scale as f64), tolerance);
    above.add_product(scale as f64, tolerance);
    below.sign() <= 0.0 && above.sign() >= 0.0
}

/// A sum of doubles, exact: components of increasing magnitude, not overlapping, none zero.
#[derive(Clone, Copy)]
struct Expansion {
    parts: [f64; 2 * (MAX_TERMS + 1)],
    len: usize,
}

impl Expansion {
    const ZERO: Expansion = Expansion { parts: [0.0; 2 * (MAX_TERMS + 1)], len: 0 };

    fn add_product(&mut self, a: f64, b: f64) {
        let product = a * b;
        // The rounding error of a product is a double; fused multiply-add gives it, in hardware or in software alike.
        let error = a.mul_add(b, -product);
        self.add(error);
        self.add(product);
    }

    /// Shewchuk's grow-expansion, dropping zeros on the way.
    fn add(&mut self, value: f64) {
        let mut carry = value;
        let mut kept = 0;
        for i in 0..self.len {
            let (sum, error) = two_sum(carry, self.parts[i]);
            carry = sum;
            if error != 0.0 {
                self.parts[kept] = error;
                kept += 1;
            }
        }
        if carry != 0.0 {
            self.parts[kept] = carry;
            kept += 1;
        }
        self.len = kept;
    }

    /// The largest component: it has the sign of the whole.
    fn sign(&self) -> f64 {
        if self.len == 0 { 0.0 } else { self.parts[self.len - 1] }
    }
}

/// a + b as a rounded sum and its exact error (Knuth).
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let b_part = sum - a;
    let a_part = sum - b_part;
    (sum, (a - a_part) + (b - b_part))
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_bigint::BigInt;
    use num_rational::BigRational;
    use proptest::prelude::*;

    /// The same question in rational numbers.
    fn oracle(terms: &[(i64, f64)], scale: i64, tolerance: f64) -> bool {
        let exact = |z: f64| BigRational::from_float(z).expect("finite");
        let sum: BigRational = terms.iter().map(|&(w, z)| BigRational::from(BigInt::from(w)) * exact(z)).sum();
        let limit = BigRational::from(BigInt::from(scale)) * exact(tolerance);
        sum <= limit && -sum <= limit
    }

    fn height() -> impl Strategy<Value = f64> {
        prop_oneof![
            (-9000i32..9000).prop_map(f64::from),
            (-9000.0f32..9000.0).prop_map(f64::from),
            -9000.0f64..9000.0,
            (-1e30f64..1e30),
            Just(5e-324),
            Just(-1e-310),
        ]
    }

    fn any_positive() -> impl Strategy<Value = f64> {
        (0..f64::MAX.to_bits()).prop_map(f64::from_bits)
    }

    #[test]
    fn limits_at_the_ends() {
        assert_eq!(limit(0.0, 0.0), MAX_TOLERANCE);
        assert_eq!(limit(-0.0, 1.0), MAX_TOLERANCE);
        assert_eq!(limit(3.0, 0.0), 0.0);
        assert_eq!(limit(f64::from_bits(1), 1.0), MAX_TOLERANCE);
        assert_eq!(limit(f64::MAX, f64::from_bits(1)), 0.0);
        // A third of 1 is above the double nearest to it.
        assert_eq!(limit(3.0, 1.0), 1.0 / 3.0);
        assert_eq!(limit(10.0, 1.0), 0.1f64.next_down());
    }

    proptest! {
        #[test]
        fn quotients_are_the_nearest_doubles(
            weights in proptest::collection::vec(-(1i64 << 40)..1 << 40, 4),
            heights in proptest::collection::vec(prop_oneof![
                (-9000i32..9000).prop_map(f64::from), -9000.0f64..9000.0, -1e-9f64..1e-9, Just(0.0), Just(-1e30),
            ], 4),
            scale in 1i64..1 << 41,
        ) {
            let terms: Vec<(i64, f64)> = weights.into_iter().zip(heights).collect();
            let exact = |z: f64| BigRational::from_float(z).expect("finite");
            let sum: BigRational = terms.iter().map(|&(w, z)| BigRational::from(BigInt::from(w)) * exact(z)).sum();
            let sum = sum / BigRational::from(BigInt::from(scale));
            let sum = if sum < exact(0.0) { -sum } else { sum };
            let found = quotient(&terms, scale);
            let distance = |q: f64| if exact(q) > sum { exact(q) - &sum } else { &sum - exact(q) };
            let neighbours = [found.next_up(), found.next_down().abs()];
            prop_assert!(neighbours.iter().all(|&n| distance(n) >= distance(found)), "{}", found);
            let is_tie = neighbours.iter().any(|&n| n != found && distance(n) == distance(found));
            prop_assert!(!is_tie || found.to_bits() & 1 == 0, "{}", found);
        }

        #[test]
        fn agrees_with_rational_numbers(
            terms in prop::collection::vec((-(1i64 << 42)..(1 << 42), height()), 1..=5),
            scale in 1i64..(1 << 42), tolerance in prop_oneof![0.0f64..100.0, Just(0.0), Just(5.0), Just(0.1)],
        ) {
            prop_assert_eq!(within(&terms, scale, tolerance), oracle(&terms, scale, tolerance));
        }

        #[test]
        fn limits_are_the_largest_doubles_allowed(
            weight in prop_oneof![
                Just(0.3), Just(1.0), Just(2.0), Just(1e6), 0.0f64..4.0, 1e-12f64..1e-6, 0.0f64..1e30, any_positive(),
            ],
            tolerance in prop_oneof![
                Just(0.0), Just(0.1), Just(5.0), 0.0f64..100.0, (0u64..1 << 54).prop_map(f64::from_bits), any_positive(),
            ],
        ) {
            let exact = |z: f64| BigRational::from_float(z).expect("finite");
            let allowed = |t: f64| exact(t) * exact(weight) <= exact(tolerance);
            let found = limit(weight, tolerance);
            prop_assert!((0.0..=MAX_TOLERANCE).contains(&found) && allowed(found), "{}", found);
            prop_assert!(found == MAX_TOLERANCE || !allowed(found.next_up()), "{}", found);
        }

        #[test]
        fn a_weight_of_one_is_the_tolerance(tolerance in any_positive()) {
            prop_assert_eq!(limit(1.0, tolerance), tolerance.min(MAX_TOLERANCE));
        }

        /// A tie, and one unit of least precision to either side of it.
        #[test]
        fn ties_are_within(w in 1i64..(1 << 40), z in -9000.0f64..9000.0, base in -9000i32..9000) {
            let base = f64::from(base);
            let terms = [(w, z), (-w, base)];
            let gap = BigRational::from_float(z).unwrap() - BigRational::from_float(base).unwrap();
            for tolerance in [(z - base).abs(), (z - base).abs().next_up(), (z - base).abs().next_down()] {
                let expected = BigRational::from_float(tolerance).unwrap() >= if z < base { -gap.clone() } else { gap.clone() };
                prop_assert_eq!(exactly_within(&terms, w, tolerance), expected);
                prop_assert_eq!(within(&terms, w, tolerance), expected);
            }
        }
    }
}
