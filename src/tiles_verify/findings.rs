//! What is wrong with a set of tiles: of each kind how often, and the first case.

use std::collections::BTreeMap;

/// Kinds of faults.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Kind {
    /// A manifest.
    Manifest,
    /// A file is missing, or one too many.
    Files,
    /// A file cannot be decoded.
    Format,
    /// Numbers of the header.
    Header,
    /// Triangles turned over, gaps or overlaps in a tile.
    Shape,
    /// Lists of border vertices.
    Sides,
    /// Samples beyond the error.
    Promise,
    /// Samples of the raster itself beyond the error, where it is promised there.
    OwnSamples,
    /// Edges that stray farther than is promised.
    Strays,
    /// Normals that are not those of the ground.
    Normals,
    /// Tiles of a level that do not meet.
    Borders,
    /// Gaps between tiles of two levels.
    Gaps,
}

/// Faults, each kind with its first case in the order of tiles.
#[derive(Debug, Clone, Default)]
pub(super) struct Findings(BTreeMap<Kind, (u64, String)>);

impl Findings {
    pub(super) fn add(&mut self, kind: Kind, what: impl FnOnce() -> String) {
        self.0.entry(kind).or_insert_with(|| (0, what())).0 += 1;
    }

    pub(super) fn merge(&mut self, other: Findings) {
        for (kind, (count, first)) in other.0 {
            self.0.entry(kind).or_insert((0, first)).0 += count;
        }
    }

    /// A sentence for each kind.
    pub(super) fn sentences(&self) -> Vec<String> {
        let sentence = |(count, first): &(u64, String)| match count {
            1 => first.clone(),
            count => format!("{first} ({} more of this kind)", count - 1),
        };
        self.0.values().map(sentence).collect()
    }
}
