//! The ways to judge the mesh's outline.

use super::VerifyError;
use super::boundary::Boundary;
use super::finding::{EdgePlace, Finding};
use super::ground::Settled;
use super::rim::{Rim, RimFindings};
use super::segments::BoundaryFindings;

/// Where the mesh is to end.
pub(super) enum Outline<'s> {
    /// Where the ground does.
    Ground(Boundary<'s>),
    /// There, or within a strip of it.
    Trimmed(Rim<'s>),
    /// There, or at outlines.
    Cut(Rim<'s>),
}

/// What has been found out about the mesh's boundary.
#[derive(Debug, Default)]
pub(super) struct OutlineFindings {
    pub(super) boundary: BoundaryFindings,
    /// Edges of one face that could be on the ground's boundary and are not.
    pub(super) astray: Finding<EdgePlace>,
    /// Where it may be trimmed.
    pub(super) rim: Option<RimFindings>,
    /// Where it is to end at outlines.
    pub(super) cut: Option<RimFindings>,
}

impl Outline<'_> {
    /// Holds the mesh's boundary against the next rows.
    pub(super) fn follow(&mut self, settled: &mut Settled<'_>) -> Result<(), VerifyError> {
        match self {
            Outline::Ground(boundary) => boundary.follow(&mut settled.segments),
            Outline::Trimmed(rim) | Outline::Cut(rim) => rim.follow(settled),
        }
    }

    pub(super) fn found(self) -> OutlineFindings {
        match self {
            Outline::Ground(boundary) => {
                let astray = boundary.astray();
                OutlineFindings { boundary: boundary.found, astray, ..OutlineFindings::default() }
            }
            Outline::Trimmed(rim) => OutlineFindings { rim: Some(rim.found()), ..OutlineFindings::default() },
            Outline::Cut(rim) => OutlineFindings { cut: Some(rim.found()), ..OutlineFindings::default() },
        }
    }
}
