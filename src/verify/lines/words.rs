//! Places as words: by rows, then by columns.

use super::Spot;
use crate::verify::VerifyError;

/// The most samples across or down.
pub(in crate::verify) const LONGEST: i64 = 1 << 30;

/// Bits of a column of the lattice.
const BITS: u32 = 32;

/// Bits of a word below the row of cells that a place is in.
pub(super) const ROW_OF_PLACE: u32 = BITS + 2;

/// Bits of the word of a sample below its row.
pub(super) const ROW_OF_SAMPLE: u32 = BITS;

/// Of a place of the lattice, or of a sample as column and row; neither is below 0.
pub(super) fn word((x, y): Spot) -> u64 {
    (y as u64) << BITS | x as u64
}

pub(super) fn spot(word: u64) -> Spot {
    (i64::from(word as u32), (word >> BITS) as i64)
}

/// The first word of a row of the lattice.
pub(super) fn first_of(y: i64) -> u64 {
    word((0, y))
}

/// Makes sure that places of a raster are words.
pub(super) fn check((width, height): (i64, i64)) -> Result<(), VerifyError> {
    if width.max(height) > LONGEST { Err(VerifyError::LongRaster { width, height }) } else { Ok(()) }
}
