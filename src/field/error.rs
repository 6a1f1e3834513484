//! Why samples cannot be used.

use std::path::PathBuf;

use crate::base::control::Cancelled;
use crate::base::decimal::Decimal;
use crate::base::{Mark, RasterError};

/// Why a height field cannot be made or read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FieldError {
    /// The raster itself.
    #[error(transparent)]
    Raster(#[from] RasterError),
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// The temporary file for decoded samples cannot be made or written.
    #[error("{}: the temporary file of decoded samples ({bytes} bytes) failed: {source}", dir.display())]
    Temporary {
        /// The folder of temporary files.
        dir: PathBuf,
        /// How large the file was to be.
        bytes: u64,
        /// What the system said.
        source: std::io::Error,
    },
    /// The raster's file cannot be mapped.
    #[error("{}: cannot be mapped into memory: {source}", path.display())]
    Map {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The mapped file became shorter while it was in use.
    #[error("{}: expected {expected} bytes as when the run began, found {found}: the file changed while it was in use", path.display())]
    Truncated {
        /// The raster.
        path: PathBuf,
        /// Its length when it was mapped.
        expected: u64,
        /// Its length now.
        found: u64,
    },
    /// It was asked for, but the raster's file cannot be used where it lies.
    #[error("{}: cannot be mapped in place: {reason}", path.display())]
    NotInPlace {
        /// The raster.
        path: PathBuf,
        /// Why not.
        reason: String,
    },
    /// The temporary file of heights in bridged holes cannot be made, written or read.
    #[error("{}: the temporary file of bridged holes failed: {source}", dir.display())]
    HolesFile {
        /// The folder of temporary files.
        dir: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// Holes that may be bridged take too much memory before it is known whether they are.
    #[error(
        "{}: expected holes that are found in {budget_bytes} bytes of memory, found more at row {row}",
        path.display()
    )]
    HolesTooLarge {
        /// The raster.
        path: PathBuf,
        /// The row by which they do.
        row: usize,
        /// What they may take.
        budget_bytes: u64,
    },
    /// A sample of a channel has no value where there is a height.
    #[error(
        "{}: expected a value wherever there is a height, found a missing sample ({found}) at column {column}, \
         row {row}",
        path.display()
    )]
    Nodata {
        /// The raster.
        path: PathBuf,
        /// The sample's column.
        column: usize,
        /// The sample's row.
        row: usize,
        /// What is stored there.
        found: String,
    },
    /// A sample is infinite, or beyond ±10³⁰.
    #[error(transparent)]
    NotAHeight(Box<NotAHeight>),
    /// A sample of an importance raster is missing, no number, negative, or beyond 10³⁰.
    #[error(
        "{}: expected a weight from 0 to 1e30 everywhere, found {found} at column {column}, row {row}: an \
         importance raster has no missing samples",
        path.display()
    )]
    NotAWeight {
        /// The importance raster.
        path: PathBuf,
        /// The sample's column.
        column: usize,
        /// The sample's row.
        row: usize,
        /// What is there.
        found: String,
    },
    /// A 64-bit integer that no double equals.
    #[error(
        "{}: expected integers that a double holds exactly (up to 2^53), found {found} at column {column}, row {row}",
        path.display()
    )]
    Inexact {
        /// The raster.
        path: PathBuf,
        /// The sample's column.
        column: usize,
        /// The sample's row.
        row: usize,
        /// The stored integer.
        found: i128,
    },
    /// The weights are not as many as the heights.
    #[error("{}: expected {} × {} weights, one for every sample, found {} × {}", path.display(), expected.0, expected.1, found.0, found.1)]
    OtherSize {
        /// The importance raster.
        path: PathBuf,
        /// Samples of the heights, across and down.
        expected: (usize, usize),
        /// Of the weights.
        found: (usize, usize),
    },
    /// An array's length is not width × height, or a side is shorter than 2.
    #[error("expected width × height = {width} × {height} heights, each side at least 2, found {found}")]
    Shape {
        /// Samples across.
        width: usize,
        /// Samples down.
        height: usize,
        /// How many there are.
        found: usize,
    },
}

/// A sample that is infinite, or beyond ±10³⁰, and that no mark says is missing.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{}: expected heights within ±1e30, found {} at column {column}, row {row}{}", path.display(), Decimal(*height), self.stored())]
pub struct NotAHeight {
    /// The raster.
    pub path: PathBuf,
    /// The sample's column.
    pub column: usize,
    /// The sample's row.
    pub row: usize,
    /// The height.
    pub height: f64,
    /// The number that is stored.
    pub stored: f64,
    /// The raster's nodata tag, which the stored number is not like.
    pub tag: Option<Mark>,
}

impl NotAHeight {
    fn stored(&self) -> String {
        let stored = match self.stored == self.height {
            true => String::new(),
            false => format!(", stored as {}", Decimal(self.stored)),
        };
        match self.tag {
            Some(Mark::Real(tag)) if tag == self.stored || f64::from(tag as f32) == self.stored => {
                format!("{stored}; that is the nodata tag, in place of which other marks were given")
            }
            Some(tag) => format!("{stored}; the nodata tag is {tag}, which is another number"),
            None => format!("{stored}; the raster has no nodata tag"),
        }
    }
}

impl FieldError {
    /// What is wrong with a sample, of a raster of weights.
    pub(super) fn about_a_weight(self) -> FieldError {
        match self {
            FieldError::Nodata { path, column, row, found } => {
                FieldError::NotAWeight { path, column, row, found: format!("a nodata sample ({found})") }
            }
            FieldError::NotAHeight(sample) => {
                let NotAHeight { path, column, row, height, .. } = *sample;
                FieldError::NotAWeight { path, column, row, found: Decimal(height).to_string() }
            }
            other => other,
        }
    }
}
