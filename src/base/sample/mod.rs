//! What stored samples are: their types, scale and offset, what marks them as missing, heights that are stored as colours.
//!
//! What a mark means is stated at [`Mark`] and reckoned twice: for the engines in `stored`, and for `verify` in code of its
//! own, so that one checks the other. Whoever brings samples, GDAL or another program, brings stored values and marks; what
//! is missing is decided here alone.

mod encoding;
mod marks;
mod masks;
mod sample_type;
pub(crate) mod stored;

pub use encoding::Encoding;
pub(crate) use marks::zero_tag;
pub use marks::{Mark, Marks, NEARNESS, NO_MARK, TAG, ValidRange};
pub use masks::{MaskFlags, Masks, mask_by_alpha};
pub(crate) use sample_type::with_sample_type;
pub use sample_type::{SampleType, Scaling};
