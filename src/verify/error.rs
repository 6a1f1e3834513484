//! Why a mesh could not be judged.

use std::path::PathBuf;

use super::lines::{LONGEST, MAX_SEGMENTS};
use crate::base::control::Cancelled;
use crate::base::decimal::Decimal;
use crate::base::external::ScratchError;
use crate::base::plainly::Plainly;
use crate::base::{LineKind, RasterError};
use crate::formats::ReadError;
use crate::job::rules::Incompatible;

/// Why a mesh could not be judged. A mesh that was judged and failed is no error but a [`super::Verdict`].
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum VerifyError {
    /// The raster cannot be read.
    #[error(transparent)]
    Raster(#[from] RasterError),
    /// The mesh cannot be read, or is damaged.
    #[error(transparent)]
    Mesh(ReadError),
    /// The tolerance is no tolerance.
    #[error("expected a finite tolerance of 0 or more, found {found}")]
    Tolerance {
        /// The number as it was given.
        found: f64,
    },
    /// The limit on straying is none.
    #[error(
        "expected a limit on straying of 1 × the tolerance or more, found {found}: at samples the surface may be 1 × the \
         tolerance off, which is as far beyond the heights around them"
    )]
    Stray {
        /// The multiple as it was given.
        found: f64,
    },
    /// What the mesh is to be judged by does not go together.
    #[error(transparent)]
    Incompatible(#[from] Incompatible),
    /// The emphasis is no share.
    #[error("expected an emphasis from 0 to 1, found {found}")]
    Emphasis {
        /// The number as it was given.
        found: f64,
    },
    /// A channel has no value where there is a height.
    #[error("{}: band {band}, column {column}, row {row}: expected a finite value, as there is a height, found {found}", path.display())]
    NoValue {
        /// The raster.
        path: PathBuf,
        /// The channel's band, from 1.
        band: usize,
        /// The sample's column, from 0.
        column: usize,
        /// The sample's row, from 0.
        row: usize,
        /// What is there.
        found: String,
    },
    /// Outlines that have an inside are too long in all.
    #[error("expected at most {} pieces of outlines between rows and columns, found more", MAX_SEGMENTS)]
    ManyLines,
    /// Lines cannot be judged over such a raster.
    #[error("expected a raster of at most {LONGEST} columns and rows beneath lines, found {width} × {height}")]
    LongRaster {
        /// Columns.
        width: i64,
        /// Rows.
        height: i64,
    },
    /// A vertex of a line is farther away than numbers go.
    #[error("expected lines near the raster, found a vertex at column {}, row {}", Plainly(*column), Plainly(*row))]
    FarLine {
        /// With fractions.
        column: f64,
        /// With fractions.
        row: f64,
    },
    /// A height of a line's own is none.
    #[error("expected heights of lines from -1e30 to 1e30, found {} in feature {feature}", Plainly(*height))]
    LineHeight {
        /// The feature.
        feature: u64,
        /// What it has.
        height: f64,
    },
    /// Two lakes have ground in common.
    #[error("expected lakes apart from each other, found features {} and {} that overlap", features[0], features[1])]
    LakesOverlap {
        /// Theirs.
        features: [u64; 2],
    },
    /// Lines meet at a place where they have several heights.
    #[error(
        "expected one height at column {column}, row {row}, where lines meet, found {} in feature {} of the {} and {} in feature {} of the {}",
        heights[0], features[0], kinds[0].name(), heights[1], features[1], kinds[1].name()
    )]
    TwoHeights {
        /// With fractions.
        column: f64,
        /// With fractions.
        row: f64,
        /// The least and the largest.
        heights: [f64; 2],
        /// The features that have them.
        features: [u64; 2],
        /// What these are.
        kinds: [LineKind; 2],
    },
    /// A sample's height is infinite: no surface is within any distance of it.
    #[error("{}: column {column}, row {row}: expected a finite height, found {}", path.display(), Decimal(*found))]
    InfiniteSample {
        /// The raster.
        path: PathBuf,
        /// The sample's column, from 0.
        column: usize,
        /// The sample's row, from 0.
        row: usize,
        /// The height as it is.
        found: f64,
    },
    /// A sample of the importance raster is no weight.
    #[error("{}: column {column}, row {row}: expected a finite weight, 0 or above, found {found}", path.display())]
    NotAWeight {
        /// The importance raster.
        path: PathBuf,
        /// The sample's column, from 0.
        column: usize,
        /// The sample's row, from 0.
        row: usize,
        /// What is there.
        found: String,
    },
    /// A temporary file cannot be made, written or read back.
    #[error(transparent)]
    Scratch(ScratchError),
    /// An observer could not go on.
    #[error(transparent)]
    Observer(Box<dyn std::error::Error + Send + Sync>),
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl From<ReadError> for VerifyError {
    fn from(error: ReadError) -> VerifyError {
        match error {
            ReadError::Cancelled(stopped) => VerifyError::Cancelled(stopped),
            damaged => VerifyError::Mesh(damaged),
        }
    }
}

impl From<ScratchError> for VerifyError {
    fn from(error: ScratchError) -> VerifyError {
        match error {
            ScratchError::Cancelled(stopped) => VerifyError::Cancelled(stopped),
            file => VerifyError::Scratch(file),
        }
    }
}
