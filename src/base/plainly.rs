//! Numbers in messages.

/// A number in as few digits as are needed: powers of ten where it is very large or small.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Plainly(pub(crate) f64);

impl std::fmt::Display for Plainly {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let size = self.0.abs();
        if size.is_finite() && size != 0.0 && !(1e-6..1e15).contains(&size) {
            write!(f, "{:e}", self.0)
        } else {
            write!(f, "{}", self.0)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        let shown = [0.0, -12.25, 1e300, -2.5e-300, 999e12, f64::NAN].map(|number| Plainly(number).to_string());
        assert_eq!(shown, ["0", "-12.25", "1e300", "-2.5e-300", "999000000000000", "NaN"]);
    }
}
