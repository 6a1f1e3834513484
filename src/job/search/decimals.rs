//! Tolerances that can be said: numbers of four decimals.

/// The nearest number with four significant digits.
pub(super) fn tidy(tolerance: f64) -> f64 {
    format!("{tolerance:.3e}").parse().unwrap_or(tolerance)
}

/// The next such number above; where four digits tell no more apart, the next number.
pub(super) fn next_above(tolerance: f64) -> f64 {
    let tidied = tidy(tolerance);
    let above = if tidied > tolerance { tidied } else { tidy(tidied + unit(tidied)) };
    above.max(tolerance.next_up())
}

/// The next such number below, likewise; 0 at the least.
pub(super) fn next_below(tolerance: f64) -> f64 {
    let tidied = tidy(tolerance);
    let below = tidied - unit(tidied);
    // Below a power of ten steps are a tenth.
    let below = if tidied < tolerance { tidied } else { tidy(tidied - unit(below)) };
    below.min(tolerance.next_down()).max(0.0)
}

/// A unit in the fourth digit; of 0 none.
fn unit(tolerance: f64) -> f64 {
    if tolerance == 0.0 {
        return 0.0;
    }
    let text = format!("{tolerance:.3e}");
    let exponent = text.split_once('e').map_or("0", |(_, exponent)| exponent);
    format!("1e{}", exponent.parse::<i32>().unwrap_or(0) - 3).parse().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_digits() {
        assert_eq!([tidy(12.3456), tidy(1.0), tidy(0.000123456), tidy(0.0)], [12.35, 1.0, 0.0001235, 0.0]);
        assert_eq!([next_above(1.0), next_above(9.999), next_above(0.5)], [1.001, 10.0, 0.5001]);
        assert_eq!(
            [next_below(1.0), next_below(1.001), next_below(0.9999), next_below(1.0005)],
            [0.9999, 1.0, 0.9998, 1.0]
        );
        let least = f64::from_bits(1);
        assert_eq!(
            [next_above(0.0), next_above(least), next_below(least), next_below(0.0)],
            [least, 2.0 * least, 0.0, 0.0]
        );
        assert_eq!([next_above(1e300), next_below(1e-300)], [1.001e300, 9.999e-301]);
    }
}
