//! Whether a triangle may be used: scan conversion and the tolerance test, exact on every path.
//!
//! [`Tester`] takes candidate triangles of an engine over one tile. A row of samples is compared with the triangle's
//! plane in the heights' own precision, against limits moved by a bound of the rounding error of *this* triangle; what
//! the limits leave in doubt goes to [`crate::base::exact`]. The answer is that of real arithmetic. `weighted` does the same for
//! tiles whose samples have weights, and so a limit each; `channels` tests what channels add to the error. `edge` is the strong test of an edge, `stray` the limit on what edges do
//! between samples.

mod channels;
mod edge;
mod plane;
mod spans;
mod stray;
mod surfaces;
mod tester;
mod weighted;

pub(crate) use plane::{Plane, RowShares};
pub(crate) use spans::{INWARD, NO_FRACTION, Slant, Spans};
pub use stray::Side;
pub(crate) use surfaces::Surfaces;
pub use tester::Tester;
pub(super) use tester::{coarse_doubles, doubt_in_singles};

#[cfg(test)]
mod tests;
