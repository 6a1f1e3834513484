//! Why lines cannot be used.

use crate::base::LineKind;
use crate::base::external::ScratchError;
use crate::kernel::breaklines::LinesError;

/// Why lines cannot be put on the lattice.
#[derive(Debug, thiserror::Error)]
pub(crate) enum LinesFailure {
    /// Those of a kind are not what they should be.
    #[error("{1}")]
    Lattice(LineKind, LinesError),
    /// They cannot be kept beside memory.
    #[error(transparent)]
    Scratch(#[from] ScratchError),
}
