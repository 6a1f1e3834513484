//! Numbers in messages: the shortest decimal that stands for the double, with at most 17 digits.

use std::io::Write;

/// Whether a text is a decimal beyond the largest double, which the standard library takes for infinity. Words that stand for
/// infinity are none.
pub(crate) fn is_too_large(text: &str) -> bool {
    text.parse().is_ok_and(f64::is_infinite) && text.contains(|c: char| c.is_ascii_digit())
}

/// A double as people read it: `-9999`, `0.25`, `1.7976931348623157e308`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Decimal(pub f64);

impl std::fmt::Display for Decimal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let value = self.0;
        if is_plain(value) { write!(f, "{value}") } else { write!(f, "{value:e}") }
    }
}

impl Decimal {
    /// Appends what it is displayed as, which takes a fifth of the time that the standard library's formatting takes.
    pub(crate) fn push_to(self, text: &mut Vec<u8>) {
        let value = self.0;
        if !value.is_finite() || !is_plain(value) {
            return write!(text, "{self}").expect("memory takes all");
        }
        let mut digits = zmij::Buffer::new();
        let digits = digits.format_finite(value);
        let digits = digits.strip_suffix(".0").unwrap_or(digits).as_bytes();
        text.extend_from_slice(digits);
        // Half way between two decimals zmij takes the even digit, the standard library the larger one.
        let point = rounded_to_even(value).and_then(|decimals| digits.len().checked_sub(decimals + 1));
        if point.is_some_and(|point| digits[point] == b'.')
            && let Some(last) = text.last_mut()
        {
            *last += 1;
        }
    }
}

/// With how many digits after the point a number is half way between two decimals, if the last digit of the smaller one (but for
/// the sign) is even.
fn rounded_to_even(value: f64) -> Option<usize> {
    let (bits, power) = (value.to_bits() & ((1 << 52) - 1) | 1 << 52, (value.to_bits() >> 52 & 0x7ff) as i64 - 1075);
    let zeros = bits.trailing_zeros();
    // value = odd × 2^-(decimals + 1), so value × 10^decimals = odd × 5^decimals / 2, and powers of 5 are 1 modulo 4.
    let decimals = -(power + i64::from(zeros)) - 1;
    if bits >> zeros & 3 == 1 { usize::try_from(decimals).ok() } else { None }
}

/// Whether it is displayed without an exponent.
fn is_plain(value: f64) -> bool {
    value == 0.0 || !value.is_finite() || (1e-5..1e16).contains(&value.abs())
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::{Decimal, is_too_large};

    #[test]
    fn infinity_is_a_word() {
        for text in ["1e400", "-1e400", "+1E309", "1.8e308"] {
            assert!(is_too_large(text), "{text}");
        }
        assert!(is_too_large(&"9".repeat(400)));
        for text in ["inf", "-inf", "+Infinity", "nan", "1e308", "-1e308", "1e-400", "0", "", "1e", "e1"] {
            assert!(!is_too_large(text), "{text}");
        }
    }

    #[test]
    fn at_most_seventeen_digits() {
        let text = |v: f64| Decimal(v).to_string();
        assert_eq!((text(-9999.0), text(0.25), text(0.0)), ("-9999".into(), "0.25".into(), "0".into()));
        assert_eq!(text(f64::MAX), "1.7976931348623157e308");
        assert_eq!(text(f64::from(f32::MIN)), "-3.4028234663852886e38");
        assert_eq!((text(1e-7), text(f64::NAN), text(f64::NEG_INFINITY)), ("1e-7".into(), "NaN".into(), "-inf".into()));
        for value in [f64::MAX, f64::MIN_POSITIVE, 1.0 / 3.0, 123_456_789_012_345.67, 1e16_f64.next_down()] {
            let digits = text(value).split('e').next().unwrap().chars().filter(char::is_ascii_digit).count();
            assert!(digits <= 18 && text(value).parse() == Ok(value), "{}", text(value));
        }
    }

    fn pushed(value: f64) -> String {
        let mut text = Vec::new();
        Decimal(value).push_to(&mut text);
        String::from_utf8(text).expect("digits")
    }

    #[test]
    fn pushed_is_displayed() {
        let ends = [0.0, 1e-5, 1e15, 1e16, 5e-324, f64::MIN_POSITIVE, f64::MAX, f64::INFINITY, f64::NAN, 1e22, 9.5e-5];
        let near = ends.iter().flat_map(|v| [*v, v.next_up(), v.next_down()]);
        let powers = (-1074..1024).map(|e| 2f64.powi(e)).flat_map(|v| [v, v.next_up(), v.next_down()]);
        let tens = (-323..309).map(|e| format!("1e{e}").parse().expect("a power")).flat_map(|v: f64| [v, v.next_up()]);
        let whole = (0..70_000).map(|i| f64::from(i) * 977.0);
        let hundredths = (0..70_000).map(|i| f64::from(i) / 100.0);
        let halves = (0..70_000).map(|i| (f64::from(i) * 977.0 + 1e6 * f64::from(i % 8)) / 16_384.0);
        for value in halves.chain(near).chain(powers).chain(tens).chain(whole).chain(hundredths).flat_map(|v| [v, -v]) {
            assert_eq!(pushed(value), Decimal(value).to_string());
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(20_000))]
        #[test]
        fn any_number_is_pushed_as_it_is_displayed(bits: u64, near in -1e9..1e9f64, single: f32) {
            for value in [f64::from_bits(bits), near, f64::from(near as f32), single.into()] {
                prop_assert_eq!(pushed(value), Decimal(value).to_string());
            }
        }
    }
}
