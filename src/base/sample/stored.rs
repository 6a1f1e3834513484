//! What a stored type must tell to become a height, and which stored values are none.

use super::{Mark, Marks, NEARNESS, Scaling, ValidRange};
use crate::base::exact::MAX_HEIGHT;

/// What a stored type must tell to become a height.
pub(crate) trait Stored: bytemuck::Pod + PartialOrd {
    fn to_f64(self) -> f64;
    fn to_i128(self) -> i128;
    /// Whether a double holds it exactly.
    fn exact(self) -> bool;
    /// The mark in this type, if it marks anything there.
    fn of_mark(mark: Mark) -> Option<Self>;
    /// Whether the value is like a mark of its type that it does not equal.
    fn is_near(self, mark: Self) -> bool;
    /// The ends of what may be like a mark; may be wider than what is.
    fn around(mark: Self) -> (Self, Self);
    /// Whether there are values that are no numbers.
    const HAS_NAN: bool;
}

macro_rules! integers {
    ($($t:ty: $exact:expr);* $(;)?) => {$(
        impl Stored for $t {
            const HAS_NAN: bool = false;
            #[inline(always)]
            fn to_f64(self) -> f64 {
                self as f64
            }
            fn to_i128(self) -> i128 {
                self as i128
            }
            #[inline(always)]
            fn exact(self) -> bool {
                const EXACT: fn($t) -> bool = $exact;
                EXACT(self)
            }
            fn of_mark(mark: Mark) -> Option<Self> {
                let whole = match mark {
                    // Beyond the type's range it marks nothing; the fraction is cut off.
                    Mark::Real(v) if size_of::<$t>() < 8 && <$t>::MIN as f64 <= v && v <= <$t>::MAX as f64 => v as i128,
                    Mark::Real(_) => return None,
                    Mark::I64(v) => i128::from(v),
                    Mark::U64(v) => i128::from(v),
                };
                <$t>::try_from(whole).ok()
            }
            fn is_near(self, _: Self) -> bool {
                false
            }
            fn around(mark: Self) -> (Self, Self) {
                (mark, mark)
            }
        }
    )*};
}
integers!(
    u8: |_| true; i8: |_| true; u16: |_| true; i16: |_| true; u32: |_| true; i32: |_| true;
    u64: |v| v <= 1 << 53; i64: |v| v.unsigned_abs() <= 1 << 53;
);

macro_rules! floats {
    ($($t:ty),*) => {$(
        impl Stored for $t {
            const HAS_NAN: bool = true;
            #[inline(always)]
            fn to_f64(self) -> f64 {
                f64::from(self)
            }
            fn to_i128(self) -> i128 {
                self as i128
            }
            #[inline(always)]
            fn exact(self) -> bool {
                true
            }
            fn of_mark(mark: Mark) -> Option<Self> {
                match mark {
                    Mark::Real(v) => Some(v as $t),
                    Mark::I64(v) => Some(v as $t),
                    Mark::U64(v) => Some(v as $t),
                }
            }
            fn is_near(self, mark: Self) -> bool {
                (self - mark).abs() < NEARNESS as $t * (self + mark).abs()
            }
            fn around(mark: Self) -> (Self, Self) {
                // |v − m| < n·|v + m| keeps v within 2n/(1 − n)·|m| of m; a sum that overflows is like anything finite
                // beyond half of the largest number, of the same sign.
                let reach = 4.0 * NEARNESS as $t * mark.abs();
                let half = <$t>::MAX / 2.0;
                match (mark.is_finite(), mark > half / 2.0, mark < -half / 2.0) {
                    (true, true, _) => ((mark - reach).min(0.0), <$t>::MAX),
                    (true, _, true) => (<$t>::MIN, (mark + reach).max(0.0)),
                    (true, false, false) => (mark - reach, mark + reach),
                    (false, ..) => (mark, mark),
                }
            }
        }
    )*};
}
floats!(f32, f64);

/// Half floats are compared in single precision, in which they are so far apart that near is equal.
impl Stored for half::f16 {
    const HAS_NAN: bool = true;
    fn to_f64(self) -> f64 {
        f64::from(self)
    }
    fn to_i128(self) -> i128 {
        f64::from(self) as i128
    }
    fn exact(self) -> bool {
        true
    }
    fn of_mark(mark: Mark) -> Option<Self> {
        match mark {
            Mark::Real(v) => Some(half::f16::from_f64(v)),
            Mark::I64(_) | Mark::U64(_) => None,
        }
    }
    fn is_near(self, mark: Self) -> bool {
        self.to_f32().is_near(mark.to_f32())
    }
    fn around(mark: Self) -> (Self, Self) {
        (mark, mark)
    }
}

/// Which stored values of a type are missing, ready to be asked.
pub(crate) struct Sieve<T> {
    /// Marks that a value of the type can be like.
    marks: Vec<T>,
    /// The ends of what may be like the first mark; where there is none, nothing lies between them.
    first: (T, T),
    valid: Option<(ValidRange, Scaling)>,
}

/// Why a stored value is no height.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Why {
    /// It is no number, equals a mark or its height is not valid.
    Said,
    /// It is like a mark and equals none.
    Near,
}

impl<T: Stored> Sieve<T> {
    pub(crate) fn new(marks: &Marks, scaling: Scaling) -> Sieve<T> {
        let values: Vec<T> = marks.values.iter().filter_map(|mark| T::of_mark(*mark)).collect();
        let zero = T::zeroed();
        // Of integers no value is less than the least; of floats NaN lies between nothing.
        let first = values.first().map_or((zero, zero), |mark| T::around(*mark));
        Sieve { first, marks: values, valid: marks.valid.map(|valid| (valid, scaling)) }
    }

    /// Whether any value but NaN may be missing.
    pub(crate) fn is_empty(&self) -> bool {
        self.marks.is_empty() && self.valid.is_none()
    }

    /// Whether a value may be like the first mark: quick, and right where it says no.
    #[inline(always)]
    pub(crate) fn suspects(&self, stored: T, is_marked: bool) -> bool {
        is_marked & (stored >= self.first.0) & (stored <= self.first.1)
    }

    /// Whether there is a first mark, for [`Sieve::suspects`].
    pub(crate) fn is_marked(&self) -> bool {
        !self.marks.is_empty()
    }

    /// Whether there is more than [`Sieve::suspects`] asks for.
    pub(crate) fn has_more(&self) -> bool {
        self.marks.len() > 1 || self.valid.is_some()
    }

    /// Why a value is missing, if it is.
    pub(crate) fn missing(&self, stored: T) -> Option<Why> {
        let value = stored.to_f64();
        let outside = |(valid, scaling): (ValidRange, Scaling)| !valid.contains(scaling.height(value));
        if value.is_nan() || self.marks.contains(&stored) || self.valid.is_some_and(outside) {
            return Some(Why::Said);
        }
        self.marks.iter().any(|mark| stored.is_near(*mark)).then_some(Why::Near)
    }
}

/// Which of these numbers are missing as half floats.
#[cfg(test)]
pub(crate) fn missing_halves(marks: &Marks, scaling: Scaling, numbers: &[f32]) -> Vec<bool> {
    let sieve = Sieve::<half::f16>::new(marks, scaling);
    let halves = numbers.iter().map(|n| half::f16::from_f32(*n));
    halves.map(|half| sieve.missing(half).is_some()).collect()
}

/// The type heights are kept in.
pub(crate) trait Height: Copy {
    const ZERO: Self;
    fn of<T: Stored>(stored: T, scaling: Option<Scaling>) -> Self;
    fn usable(self) -> bool;
}
impl Height for f32 {
    const ZERO: f32 = 0.0;
    #[inline(always)]
    fn of<T: Stored>(stored: T, _: Option<Scaling>) -> f32 {
        stored.to_f64() as f32
    }
    #[inline(always)]
    fn usable(self) -> bool {
        // Rounded to single precision the limit lies beyond itself.
        self.abs() < MAX_HEIGHT as f32
    }
}
impl Height for f64 {
    const ZERO: f64 = 0.0;
    #[inline(always)]
    fn of<T: Stored>(stored: T, scaling: Option<Scaling>) -> f64 {
        scaling.map_or(stored.to_f64(), |s| s.height(stored.to_f64()))
    }
    #[inline(always)]
    fn usable(self) -> bool {
        self.abs() <= MAX_HEIGHT
    }
}
