//! Numbers as a page shows them.

use crate::base::decimal::Decimal;

/// A number to five significant digits, without zeros at the end; very large and very small ones with a power of ten.
pub(super) fn figure(number: f64) -> String {
    let size = number.abs();
    if number == 0.0 || !number.is_finite() {
        return Decimal(number + 0.0).to_string();
    }
    if !(1e-4..1e9).contains(&size) {
        return format!("{number:.4e}");
    }
    let whole = size.log10().floor() as i32 + 1;
    let text = format!("{number:.*}", (5 - whole).clamp(0, 8) as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_string() } else { text }
}

/// Map coordinates as people write them: to the millimetre, or a hundred-millionth of a degree.
pub(super) fn coordinate(number: f64, is_degrees: bool) -> String {
    let text = format!("{number:.*}", if is_degrees { 8 } else { 3 });
    text.trim_end_matches('0').trim_end_matches('.').to_string()
}

/// A share in per cent, never 0 or 100 where it is not.
pub(super) fn percent(part: u64, all: u64) -> String {
    if all == 0 || part == 0 {
        return "0 %".to_string();
    }
    let share = part as f64 / all as f64 * 100.0;
    match part {
        _ if part == all => "100 %".to_string(),
        _ if share < 0.01 => "below 0.01 %".to_string(),
        _ if share >= 99.995 => "above 99.99 %".to_string(),
        _ => format!("{share:.2} %"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_have_five_digits() {
        let shown = |numbers: &[f64]| numbers.iter().map(|n| figure(*n)).collect::<Vec<_>>();
        assert_eq!(shown(&[0.0, -0.0, 5.0, 4.999_96, 123_456.7]), ["0", "0", "5", "5", "123457"]);
        assert_eq!(shown(&[0.012_345_67, -1.5, 1e-7, f64::INFINITY]), ["0.012346", "-1.5", "1.0000e-7", "inf"]);
    }

    #[test]
    fn shares_are_not_rounded_to_all_or_none() {
        assert_eq!([percent(0, 7), percent(7, 7), percent(1, 8)], ["0 %", "100 %", "12.50 %"]);
        assert_eq!([percent(1, 1_000_000), percent(999_999, 1_000_000)], ["below 0.01 %", "above 99.99 %"]);
    }
}
