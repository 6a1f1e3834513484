//! Lines over a raster, as they are read.

// Layers alone have so many lines.
#[cfg_attr(not(feature = "gdal"), allow(dead_code))]
mod filed;

use std::sync::Arc;

use super::LineType;
use super::external::ScratchError;
use super::features::{Feature, FeatureSet};
use filed::Filed;

#[cfg(feature = "gdal")]
pub(crate) use filed::LineWriter;

/// Lines, in columns and rows with fractions: sample (c, r) stands at (c, r). Nothing is said of their order or of what they do to
/// each other. Where a program gives them they are on the map until they are brought to columns and rows.
///
/// Memory: 16 bytes per vertex, 24 with heights; those that are in a temporary file take 8 for each line.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Polylines {
    lines: Arc<Vec<Vec<(f64, f64)>>>,
    without_geometry: u64,
    /// As many as there are vertices, where lines have heights of their own; else none.
    heights: Option<Arc<Vec<Vec<f64>>>>,
    /// Of which feature each line is a part, where they do not count one by one.
    features: Option<Arc<Vec<u64>>>,
    /// Where the lines are, if they are not in memory.
    filed: Option<Arc<Filed>>,
    line_type: LineType,
}

impl Polylines {
    /// The most pieces between rows and columns that lines may have in all, where they have to be held in memory.
    pub const MAX_SEGMENTS: usize = 4_000_000;

    /// The farthest vertex, in cells: what is reckoned from it fits 128 bits.
    pub const FARTHEST: f64 = (1u64 << 40) as f64;

    /// The most that edges may be shifted, in cells.
    pub const MAX_SHIFT: f64 = 16.0;

    /// How far edges may be from a line where nothing is said of it, in cells.
    pub const USUAL_SHIFT: f64 = 0.5;

    /// These lines. Coordinates are finite.
    pub fn new(lines: Vec<Vec<(f64, f64)>>) -> Polylines {
        Polylines { lines: Arc::new(lines), ..Polylines::default() }
    }

    /// The same lines, of a layer in which so many features have no geometry.
    pub fn beside(self, without_geometry: u64) -> Polylines {
        Polylines { without_geometry, ..self }
    }

    /// How many features of their layer have no geometry.
    pub fn without_geometry(&self) -> u64 {
        self.without_geometry
    }

    /// The same lines with a height at every vertex.
    ///
    /// # Panics
    /// If there are not as many heights as vertices.
    pub fn with_heights(self, heights: Vec<Vec<f64>>) -> Polylines {
        let counts = |lines: &mut dyn Iterator<Item = usize>| lines.collect::<Vec<_>>();
        let expected = counts(&mut self.lines.iter().map(Vec::len));
        assert_eq!(counts(&mut heights.iter().map(Vec::len)), expected, "heights of vertices");
        Polylines { heights: Some(Arc::new(heights)), ..self }
    }

    /// The same lines without heights.
    pub fn without_heights(self) -> Polylines {
        Polylines { heights: None, ..self }
    }

    /// The same lines as parts of these features, by number.
    ///
    /// # Panics
    /// If there is not one for each line.
    pub fn of_features(self, features: Vec<u64>) -> Polylines {
        assert_eq!(features.len(), self.lines.len(), "features of lines");
        Polylines { features: Some(Arc::new(features)), ..self }
    }

    /// The same lines, all of a type.
    pub fn of_type(self, line_type: LineType) -> Polylines {
        Polylines { line_type, ..self }
    }

    /// Their type.
    pub fn line_type(&self) -> LineType {
        self.line_type
    }

    /// Those of the lines, which are in memory, that are `wanted`, by number; each keeps that of its feature.
    pub fn only(&self, wanted: impl Fn(usize) -> bool) -> Polylines {
        let numbers: Vec<usize> = (0..self.lines.len()).filter(|line| wanted(*line)).collect();
        let of = |all: &[Vec<f64>]| numbers.iter().map(|&line| all[line].clone()).collect();
        Polylines {
            lines: Arc::new(numbers.iter().map(|&line| self.lines[line].clone()).collect()),
            heights: self.heights().map(|all| Arc::new(of(all))),
            features: Some(Arc::new(numbers.iter().map(|&line| self.feature(line)).collect())),
            ..self.clone()
        }
    }

    /// How many lines there are.
    pub fn count(&self) -> usize {
        if self.filed.is_some() {
            self.features.as_ref().map_or(0, |features| features.len())
        } else {
            self.lines.len()
        }
    }

    /// Whether lines have heights of their own.
    pub fn have_heights(&self) -> bool {
        self.filed.as_ref().map_or(self.heights.is_some(), |filed| filed.with_heights)
    }

    /// Some lines at a time, in memory and without their features, each with the number of the first; all at once where they are in memory.
    pub(crate) fn pieces(&self) -> Box<dyn Iterator<Item = Result<(usize, Polylines), ScratchError>> + '_> {
        match &self.filed {
            Some(filed) => Box::new(filed.pieces()),
            None => Box::new(std::iter::once(Ok((0, self.clone())))),
        }
    }

    /// The vertices of each line, where they are in memory: what bounds an inside always is.
    pub fn lines(&self) -> &[Vec<(f64, f64)>] {
        &self.lines
    }

    /// The heights of their own that the vertices of each line have, where they have some and are in memory.
    pub fn heights(&self) -> Option<&[Vec<f64>]> {
        self.heights.as_ref().map(|heights| heights.as_slice())
    }

    /// The number of the feature that a line is a part of.
    pub fn feature(&self, line: usize) -> u64 {
        self.features.as_ref().map_or(line as u64, |features| features[line])
    }

    /// The same lines without heights, each of which ends where it begins.
    pub fn closed(&self) -> Polylines {
        let closed = |line: &Vec<(f64, f64)>| {
            let open = line.first().filter(|first| line.last() != Some(first));
            line.iter().chain(open).copied().collect()
        };
        Polylines { lines: Arc::new(self.lines.iter().map(closed).collect()), heights: None, ..self.clone() }
    }

    /// The same lines with every vertex elsewhere.
    pub fn placed(&self, place: impl Fn(&(f64, f64)) -> (f64, f64)) -> Polylines {
        let lines = self.lines.iter().map(|line| line.iter().map(&place).collect()).collect();
        Polylines { lines: Arc::new(lines), ..self.clone() }
    }
}

/// Lines of one kind, and what edges along them are held to. All that is asked of edges in a run is a list of these.
#[derive(Debug, Clone, PartialEq)]
pub struct LineSet {
    /// What they are.
    pub kind: LineKind,
    /// Over the raster. Edges have the lines' own heights where these have some, else those of the raster's surface.
    pub lines: Polylines,
    /// How far edges may be from a line's places, at the most, in cells.
    pub shift: f64,
}

impl LineSet {
    /// What sets of lines ask of a run, each as its kind and whether its lines have heights of their own.
    pub fn features(sets: impl Iterator<Item = (LineKind, bool)>) -> FeatureSet {
        let of = |(kind, has_heights): (LineKind, bool)| {
            let heights = (kind == LineKind::Breaklines && has_heights).then_some(Feature::LineHeights);
            let cutline = (kind == LineKind::Cutline).then_some(Feature::Cutline);
            [kind.feature()].into_iter().chain(heights).chain(cutline)
        };
        sets.flat_map(of).collect()
    }
}

/// What lines are in a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LineKind {
    /// Breaklines: roads, walls, ridges.
    Breaklines,
    /// Outlines of lakes: level, and so is all that is inside.
    Lakes,
    /// Outlines of buildings and dams.
    Footprints,
    /// Outlines of polygons that the mesh ends at.
    Cutline,
}

impl LineKind {
    /// The feature of a run that asks for them.
    pub fn feature(self) -> Feature {
        match self {
            LineKind::Breaklines => Feature::Breaklines,
            LineKind::Lakes => Feature::Lakes,
            LineKind::Footprints => Feature::Footprints,
            LineKind::Cutline => Feature::ExactCutline,
        }
    }

    /// Whether they bound an inside. What lies outside of the raster is then drawn to its rim, and edges keep to every place.
    pub fn has_inside(self) -> bool {
        matches!(self, LineKind::Lakes | LineKind::Cutline)
    }

    /// What they are called.
    pub fn name(self) -> &'static str {
        match self {
            LineKind::Breaklines => "breaklines",
            LineKind::Lakes => "lakes",
            LineKind::Footprints => "footprints",
            LineKind::Cutline => "cutline",
        }
    }
}
