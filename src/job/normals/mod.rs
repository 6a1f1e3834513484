//! Normals of vertices, in the coordinates of the output.

mod faces;
mod gradient;
#[cfg(test)]
mod tests;

use super::{Error, Mesh};
use crate::base::CoordinateFrame;
use crate::field::Field;
use crate::job::spool::Chunk;

/// What a vertex's normal is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Normals {
    /// That of the raster: of the gradient of the samples around the vertex. It does not depend on the mesh, so meshes of
    /// several tolerances, and of neighbouring rasters that overlap by two samples, agree.
    Gradient,
    /// The sum of the normals of the triangles around it, each as long as the triangle is large.
    Area,
}

/// What they are called, as attributes.
pub const NAMES: [&str; 3] = ["nx", "ny", "nz"];

/// How normals are found.
#[derive(Clone, Copy)]
pub struct NormalSource<'a> {
    /// What they are.
    pub normals: Normals,
    /// The samples.
    pub field: &'a Field,
    /// How the output has coordinates: normals are in these.
    pub frame: CoordinateFrame,
}

/// Finds the normals of chunks, in the order of their tiles.
pub(super) enum Maker<'a> {
    Gradient(gradient::Maker<'a>),
    Area(faces::Maker<'a>),
}

impl<'a> Maker<'a> {
    pub(super) fn new(source: &NormalSource<'a>, mesh: &'a Mesh) -> Result<Maker<'a>, Error> {
        Ok(match source.normals {
            Normals::Gradient => Maker::Gradient(gradient::Maker::new(source, mesh)),
            Normals::Area => Maker::Area(faces::Maker::new(source, mesh)?),
        })
    }

    /// The normals of the vertices that a chunk owns, in their order. Chunks come in the order of their tiles.
    pub(super) fn of_chunk(&mut self, chunk: &Chunk) -> Result<&[[f64; 3]], Error> {
        match self {
            Maker::Gradient(maker) => maker.of_chunk(chunk),
            Maker::Area(maker) => maker.of_chunk(chunk),
        }
    }
}

/// A vector of length 1 in this direction, rounded to single precision; straight up where there is none.
fn unit([x, y, z]: [f64; 3]) -> [f64; 3] {
    // Scaled first: squares of large numbers are infinite.
    let largest = x.abs().max(y.abs()).max(z.abs());
    if largest.is_nan() || largest == 0.0 || largest.is_infinite() {
        return [0.0, 0.0, 1.0];
    }
    let [x, y, z] = [x, y, z].map(|v| v / largest);
    let length = (x * x + y * y + z * z).sqrt();
    [x, y, z].map(|v| f64::from((v / length) as f32))
}
