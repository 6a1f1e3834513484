//! Eight numbers in single precision side by side: what the processor has in one register, or an array.
//!
//! Sums go by lanes in one fixed order whatever the machine, so they are the same everywhere. Arrays alone would do, were
//! the compiler sure to keep them together: in loops with sums it takes them apart into pairs.

use pulp::bytemuck::cast;

use crate::base::PADDING;

pub(super) const LANES: usize = PADDING;

/// How many doubles there are side by side.
pub(super) const FOUR: usize = LANES / 2;

/// Arithmetic on eight numbers, and on four doubles.
pub(super) trait Lanes: Copy {
    type Eight: Copy;
    type Four: Copy;
    fn of(self, values: [f32; LANES]) -> Self::Eight;
    fn parts(self, a: Self::Eight) -> [f32; LANES];
    fn add(self, a: Self::Eight, b: Self::Eight) -> Self::Eight;
    fn sub(self, a: Self::Eight, b: Self::Eight) -> Self::Eight;
    fn mul(self, a: Self::Eight, b: Self::Eight) -> Self::Eight;
    fn div(self, a: Self::Eight, b: Self::Eight) -> Self::Eight;
    fn abs(self, a: Self::Eight) -> Self::Eight;
    /// `yes` where a is greater than b, else `no`.
    fn if_greater(self, a: Self::Eight, b: Self::Eight, yes: Self::Eight, no: Self::Eight) -> Self::Eight;

    /// The sum, by halves: ((a + e) + (c + g)) + ((b + f) + (d + h)).
    fn total(self, a: Self::Eight) -> f32;

    #[inline(always)]
    fn all(self, value: f32) -> Self::Eight {
        self.of([value; LANES])
    }

    /// The first where it is greater, else the second.
    fn max(self, a: Self::Eight, b: Self::Eight) -> Self::Eight;

    fn doubles(self, values: [f64; FOUR]) -> Self::Four;
    fn of_doubles(self, a: Self::Four) -> [f64; FOUR];
    fn add_doubles(self, a: Self::Four, b: Self::Four) -> Self::Four;
    fn mul_doubles(self, a: Self::Four, b: Self::Four) -> Self::Four;
    /// `yes` where a is less than b, else `no`.
    fn if_less(self, a: Self::Four, b: Self::Four, yes: Self::Four, no: Self::Four) -> Self::Four;

    #[inline(always)]
    fn all_doubles(self, value: f64) -> Self::Four {
        self.doubles([value; FOUR])
    }
}

/// Arrays.
#[derive(Clone, Copy)]
pub(super) struct Array;

impl Lanes for Array {
    type Eight = [f32; LANES];
    type Four = [f64; FOUR];

    #[inline(always)]
    fn of(self, values: [f32; LANES]) -> [f32; LANES] {
        values
    }
    #[inline(always)]
    fn parts(self, a: [f32; LANES]) -> [f32; LANES] {
        a
    }
    #[inline(always)]
    fn add(self, a: [f32; LANES], b: [f32; LANES]) -> [f32; LANES] {
        std::array::from_fn(|i| a[i] + b[i])
    }
    #[inline(always)]
    fn sub(self, a: [f32; LANES], b: [f32; LANES]) -> [f32; LANES] {
        std::array::from_fn(|i| a[i] - b[i])
    }
    #[inline(always)]
    fn mul(self, a: [f32; LANES], b: [f32; LANES]) -> [f32; LANES] {
        std::array::from_fn(|i| a[i] * b[i])
    }
    #[inline(always)]
    fn div(self, a: [f32; LANES], b: [f32; LANES]) -> [f32; LANES] {
        std::array::from_fn(|i| a[i] / b[i])
    }
    #[inline(always)]
    fn abs(self, a: [f32; LANES]) -> [f32; LANES] {
        a.map(f32::abs)
    }
    #[inline(always)]
    fn if_greater(self, a: [f32; LANES], b: [f32; LANES], yes: [f32; LANES], no: [f32; LANES]) -> [f32; LANES] {
        std::array::from_fn(|i| if a[i] > b[i] { yes[i] } else { no[i] })
    }
    #[inline(always)]
    fn total(self, [a, b, c, d, e, f, g, h]: [f32; LANES]) -> f32 {
        ((a + e) + (c + g)) + ((b + f) + (d + h))
    }
    #[inline(always)]
    fn max(self, a: [f32; LANES], b: [f32; LANES]) -> [f32; LANES] {
        std::array::from_fn(|i| if a[i] > b[i] { a[i] } else { b[i] })
    }
    #[inline(always)]
    fn doubles(self, values: [f64; FOUR]) -> [f64; FOUR] {
        values
    }
    #[inline(always)]
    fn of_doubles(self, a: [f64; FOUR]) -> [f64; FOUR] {
        a
    }
    #[inline(always)]
    fn add_doubles(self, a: [f64; FOUR], b: [f64; FOUR]) -> [f64; FOUR] {
        std::array::from_fn(|i| a[i] + b[i])
    }
    #[inline(always)]
    fn mul_doubles(self, a: [f64; FOUR], b: [f64; FOUR]) -> [f64; FOUR] {
        std::array::from_fn(|i| a[i] * b[i])
    }
    #[inline(always)]
    fn if_less(self, a: [f64; FOUR], b: [f64; FOUR], yes: [f64; FOUR], no: [f64; FOUR]) -> [f64; FOUR] {
        std::array::from_fn(|i| if a[i] < b[i] { yes[i] } else { no[i] })
    }
}

/// Registers of eight.
#[derive(Clone, Copy)]
struct Register<S>(S);

impl<S: pulp::Simd> Lanes for Register<S> {
    type Eight = S::f32s;
    type Four = S::f64s;

    #[inline(always)]
    fn of(self, values: [f32; LANES]) -> S::f32s {
        cast(values)
    }
    #[inline(always)]
    fn parts(self, a: S::f32s) -> [f32; LANES] {
        cast(a)
    }
    #[inline(always)]
    fn add(self, a: S::f32s, b: S::f32s) -> S::f32s {
        self.0.add_f32s(a, b)
    }
    #[inline(always)]
    fn sub(self, a: S::f32s, b: S::f32s) -> S::f32s {
        self.0.sub_f32s(a, b)
    }
    #[inline(always)]
    fn mul(self, a: S::f32s, b: S::f32s) -> S::f32s {
        self.0.mul_f32s(a, b)
    }
    #[inline(always)]
    fn div(self, a: S::f32s, b: S::f32s) -> S::f32s {
        self.0.div_f32s(a, b)
    }
    #[inline(always)]
    fn abs(self, a: S::f32s) -> S::f32s {
        self.0.abs_f32s(a)
    }
    #[inline(always)]
    fn if_greater(self, a: S::f32s, b: S::f32s, yes: S::f32s, no: S::f32s) -> S::f32s {
        self.0.select_f32s(self.0.greater_than_f32s(a, b), yes, no)
    }
    #[inline(always)]
    fn total(self, a: S::f32s) -> f32 {
        self.0.reduce_sum_f32s(a)
    }
    #[inline(always)]
    fn max(self, a: S::f32s, b: S::f32s) -> S::f32s {
        // Of registers of eight there are those of x86 alone, whose maximum is the second where neither is greater.
        self.0.max_f32s(a, b)
    }
    #[inline(always)]
    fn doubles(self, values: [f64; FOUR]) -> S::f64s {
        cast(values)
    }
    #[inline(always)]
    fn of_doubles(self, a: S::f64s) -> [f64; FOUR] {
        cast(a)
    }
    #[inline(always)]
    fn add_doubles(self, a: S::f64s, b: S::f64s) -> S::f64s {
        self.0.add_f64s(a, b)
    }
    #[inline(always)]
    fn mul_doubles(self, a: S::f64s, b: S::f64s) -> S::f64s {
        self.0.mul_f64s(a, b)
    }
    #[inline(always)]
    fn if_less(self, a: S::f64s, b: S::f64s, yes: S::f64s, no: S::f64s) -> S::f64s {
        self.0.select_f64s(self.0.less_than_f64s(a, b), yes, no)
    }
}

/// Work on lanes.
pub(super) trait Kernel {
    type Output;
    fn run<L: Lanes>(self, lanes: L) -> Self::Output;
}

/// Runs a kernel, compiled for what the processor has.
#[inline(always)]
pub(super) fn run<K: Kernel>(kernel: K) -> K::Output {
    pulp::Arch::new().dispatch(Dispatched(kernel))
}

struct Dispatched<K>(K);

impl<K: Kernel> pulp::WithSimd for Dispatched<K> {
    type Output = K::Output;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) -> K::Output {
        if size_of::<S::f32s>() == size_of::<[f32; LANES]>() { self.0.run(Register(simd)) } else { self.0.run(Array) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Everything that lanes can do, bit for bit.
    struct Everything([f32; LANES], [f32; LANES]);

    impl Kernel for Everything {
        type Output = (Vec<[u32; LANES]>, Vec<[u64; FOUR]>);

        #[inline(always)]
        fn run<L: Lanes>(self, on: L) -> Self::Output {
            let (a, b) = (on.of(self.0), on.of(self.1));
            let results = [
                on.add(a, b),
                on.sub(a, b),
                on.mul(a, b),
                // Not by 0: nothing says which sign a number that is none has.
                on.div(a, on.add(on.abs(b), on.all(1.0))),
                on.abs(a),
                on.max(a, b),
                on.if_greater(a, b, b, on.all(7.0)),
                on.all(on.total(b)),
            ];
            let double = |values: [f32; LANES]| on.doubles([values[0], values[2], values[3], values[5]].map(f64::from));
            let (a, b) = (double(self.0), double(self.1));
            let doubles = [on.add_doubles(a, b), on.mul_doubles(a, b), on.if_less(a, b, b, on.all_doubles(7.0))];
            let singles = results.map(|r| on.parts(r).map(f32::to_bits)).to_vec();
            (singles, doubles.map(|r| on.of_doubles(r).map(f64::to_bits)).to_vec())
        }
    }

    #[test]
    fn registers_do_what_arrays_do() {
        let a = [1.5, -0.0, f32::INFINITY, -3.25, 1e-40, 0.1, 2e38, f32::MIN_POSITIVE];
        let b = [0.7, 0.0, 1.0, -3.25, 1e-39, -0.3, 3e38, -1.0];
        assert_eq!(run(Everything(a, b)), Everything(a, b).run(Array));
        assert_eq!(run(Everything(b, a)), Everything(b, a).run(Array));
    }
}
