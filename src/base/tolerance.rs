//! The tolerance of a run: what was asked for, and what engines keep to.

use super::exact::MAX_TOLERANCE;

/// The largest error allowed: what was asked for, and what is kept of it for the mesh.
///
/// The two differ where something else takes a share, such as the rounding of heights in the output. It is decided once,
/// before work begins; engines are given [`Tolerance::kept`], reports say [`Tolerance::asked`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerance {
    asked: f64,
    kept: f64,
    lost: f64,
}

impl Tolerance {
    /// No limit: something else ends the refinement.
    pub const OPEN: Tolerance = Tolerance::new(f64::INFINITY);

    /// A tolerance that is kept as it is asked for. The number may be anything: [`Tolerance::is_usable`] judges it.
    pub const fn new(asked: f64) -> Tolerance {
        Tolerance { asked, kept: asked, lost: 0.0 }
    }

    /// The same with less kept of it: `loss` is the largest error that comes on top of the mesh's own, at least 0. What is
    /// kept and the loss are together no more than what was kept before, whatever the rounding. Where the loss is larger
    /// than that, 0 is kept. An open tolerance stays open, and no loss changes nothing.
    pub fn less(self, loss: f64) -> Tolerance {
        if loss == 0.0 {
            return self;
        }
        let kept = if self.is_open() { self.kept } else { (self.kept - loss).next_down().max(0.0) };
        let lost = if self.lost == 0.0 { loss } else { (self.lost + loss).next_up() };
        Tolerance { kept, lost, ..self }
    }

    /// Another tolerance that loses as much.
    pub fn at(self, asked: f64) -> Tolerance {
        Tolerance::new(asked).less(self.lost)
    }

    /// What of any tolerance is not kept.
    pub fn lost(&self) -> f64 {
        self.lost
    }

    /// What was asked for; infinite where the tolerance is open.
    pub fn asked(&self) -> f64 {
        self.asked
    }

    /// What tiles work with, a finite number. Larger tolerances than heights can need change nothing, and would overflow:
    /// there is an end at [`MAX_TOLERANCE`]. (Where errors weigh more than 1, it could matter at numbers that nobody asks
    /// for.)
    pub fn kept(&self) -> f64 {
        self.kept.min(MAX_TOLERANCE)
    }

    /// Whether there is no limit.
    pub fn is_open(&self) -> bool {
        self.asked == f64::INFINITY
    }

    /// Whether it is at least 0, finite or open.
    pub fn is_usable(&self) -> bool {
        self.asked >= 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_lost_is_not_kept() {
        let whole = Tolerance::new(1.0);
        assert_eq!((whole.asked(), whole.kept(), whole.less(0.0)), (1.0, 1.0, whole));
        let less = whole.less(0.3);
        assert_eq!(less.asked(), 1.0);
        assert!(less.kept() < 0.7 && less.kept() > 0.699);
        assert_eq!(whole.less(2.0).kept(), 0.0);
    }

    #[test]
    fn there_is_an_end_to_tolerances() {
        let open = Tolerance::OPEN.less(1.0);
        assert_eq!((open.asked(), open.kept()), (f64::INFINITY, MAX_TOLERANCE));
        assert_eq!(open.at(3.0), Tolerance::new(3.0).less(1.0));
        assert!(Tolerance::OPEN.is_open() && Tolerance::OPEN.is_usable());
        assert_eq!(Tolerance::OPEN.kept(), MAX_TOLERANCE);
        assert_eq!(Tolerance::new(1e300).kept(), MAX_TOLERANCE);
        assert!(!Tolerance::new(1e300).is_open());
        assert!(![-1.0, f64::NAN, f64::NEG_INFINITY].iter().any(|&asked| Tolerance::new(asked).is_usable()));
    }
}
