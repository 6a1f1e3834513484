//! Numbers in messages: the shortest decimal that stands for the double, with at most 17 digits.

/// A double as people read it: `-9999`, `0.25`, `1.7976931348623157e308`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Decimal(pub f64);

impl std::fmt::Display for Decimal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let value = self.0;
        let plain = value == 0.0 || !value.is_finite() || (1e-5..1e16).contains(&value.abs());
        if plain { write!(f, "{value}") } else { write!(f, "{value:e}") }
    }
}

#[cfg(test)]
mod tests {
    use super::Decimal;

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
}
