//! A kind of fault: how often, and where first.

use serde::Serialize;

/// How often something is wrong, and where first.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Finding<P> {
    /// How often.
    pub count: u64,
    /// The first place, in the order of the rows, faces, vertices or vertex pairs; `None` where there is none.
    pub first: Option<P>,
}

impl<P> Default for Finding<P> {
    fn default() -> Self {
        Finding { count: 0, first: None }
    }
}

impl<P> Finding<P> {
    /// Counts one; places come in order, so the first to come stays.
    pub(super) fn add(&mut self, place: impl FnOnce() -> P) {
        self.add_all(1, place);
    }

    /// Counts several, perhaps none, by the place of the first of them.
    pub(super) fn add_all(&mut self, count: u64, place: impl FnOnce() -> P) {
        if count > 0 {
            self.count += count;
            self.first.get_or_insert_with(place);
        }
    }

    /// These, then those.
    pub(super) fn and(self, then: Finding<P>) -> Finding<P> {
        Finding { count: self.count + then.count, first: self.first.or(then.first) }
    }
}

/// A sample of the raster.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SamplePlace {
    /// Column, from 0.
    pub column: u64,
    /// Row, from 0.
    pub row: u64,
    /// Map x.
    pub x: f64,
    /// Map y.
    pub y: f64,
}

/// A side between two neighbouring samples of a row or a column, or a cell, by two of its corners.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SidePlace {
    /// The left or upper sample; of a cell the one to the left and above.
    pub from: SamplePlace,
    /// The right or lower sample; of a cell the one to the right and below.
    pub to: SamplePlace,
}

/// A point on the map.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MapPlace {
    /// Map x.
    pub x: f64,
    /// Map y.
    pub y: f64,
}

/// A vertex of the mesh.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct VertexPlace {
    /// Its index in the file, from 0.
    pub vertex: u64,
    /// Map x.
    pub x: f64,
    /// Map y.
    pub y: f64,
}

/// A face of the mesh, by its first corner.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FacePlace {
    /// Its index in the file, from 0.
    pub face: u64,
    /// The first corner's map x.
    pub x: f64,
    /// The first corner's map y.
    pub y: f64,
}

/// A sample in a face.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct TouchPlace {
    /// The sample.
    #[serde(flatten)]
    pub sample: SamplePlace,
    /// The first face with the sample in it, by its index in the file, from 0.
    pub face: u64,
}

/// An edge of the mesh.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct EdgePlace {
    /// The end with the lower index.
    pub from: VertexPlace,
    /// The end with the higher index.
    pub to: VertexPlace,
}

impl std::fmt::Display for SamplePlace {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "column {}, row {} ({} {})", self.column, self.row, self.x, self.y)
    }
}

impl std::fmt::Display for SidePlace {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} to {}", self.from, self.to)
    }
}

impl std::fmt::Display for MapPlace {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "({} {})", self.x, self.y)
    }
}

impl std::fmt::Display for VertexPlace {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "vertex {} ({} {})", self.vertex, self.x, self.y)
    }
}

impl std::fmt::Display for FacePlace {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "face {} ({} {})", self.face, self.x, self.y)
    }
}

impl std::fmt::Display for TouchPlace {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}, in face {}", self.sample, self.face)
    }
}

impl std::fmt::Display for EdgePlace {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} to {}", self.from, self.to)
    }
}
