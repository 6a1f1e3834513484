//! The rectangle of samples, on the lattice and on the map.

use crate::base::{Band, CoordinateFrame, GeoTransform};
use crate::formats::MeshReader;

use super::finding::{EdgePlace, FacePlace, MapPlace, SamplePlace, VertexPlace};
use super::vertices::Vertex;

/// Lattice steps from one sample to the next.
pub(super) const STEPS: i64 = 4;

/// The rectangle of sample centres, on the lattice and on the map.
#[derive(Debug, Clone, Copy)]
pub(super) struct Grid {
    /// Samples across.
    pub(super) width: i64,
    /// Samples down.
    pub(super) height: i64,
    pub(super) transform: GeoTransform,
    /// How the mesh's file has places and heights.
    pub(super) frame: CoordinateFrame,
}

impl Grid {
    /// For a mesh over a raster. A file in single precision whose coordinates do not tell lattice points apart is taken at
    /// its word: places are what is written, exactly.
    pub(super) fn of(raster: &Band, mesh: &dyn MeshReader) -> Grid {
        let (width, height, transform) = (raster.width(), raster.height(), raster.geo_transform());
        let frame = mesh.header().frame;
        let single = frame.single && frame.tells_apart(&transform, width, height);
        Grid { width: width as i64, height: height as i64, transform, frame: CoordinateFrame { single, ..frame } }
    }

    /// The lattice point that stands in the file as x, y, bit for bit.
    pub(super) fn lattice(&self, x: f64, y: f64) -> Option<(i64, i64)> {
        self.frame.lattice(&self.transform, (x, y))
    }

    /// The lattice point nearest to what stands in the file as x, y.
    pub(super) fn nearest_lattice(&self, x: f64, y: f64) -> Option<(i64, i64)> {
        self.frame.nearest_lattice(&self.transform, (x, y))
    }

    /// The lattice point in the corner of last row and column; the first one is (0, 0).
    pub(super) fn far_corner(&self) -> (i64, i64) {
        (STEPS * (self.width - 1), STEPS * (self.height - 1))
    }

    pub(super) fn contains(&self, (x, y): (i64, i64)) -> bool {
        let (far_x, far_y) = self.far_corner();
        (0..=far_x).contains(&x) && (0..=far_y).contains(&y)
    }

    /// 1 where a counter-clockwise turn on the map is positive in (column, row), −1 where it is negative.
    pub(super) fn map_turn(&self) -> i128 {
        if self.transform.determinant() < 0.0 { -1 } else { 1 }
    }

    pub(super) fn map(&self, (x, y): (i64, i64)) -> MapPlace {
        let (x, y) = self.transform.apply(x, y);
        MapPlace { x, y }
    }

    pub(super) fn sample(&self, column: i64, row: i64) -> SamplePlace {
        let MapPlace { x, y } = self.map((STEPS * column, STEPS * row));
        SamplePlace { column: column as u64, row: row as u64, x, y }
    }

    pub(super) fn vertex(&self, index: u64, vertex: Vertex) -> VertexPlace {
        let MapPlace { x, y } = vertex.place.map_or(MapPlace { x: f64::NAN, y: f64::NAN }, |p| self.map(p));
        VertexPlace { vertex: index, x, y }
    }

    pub(super) fn edge(&self, (a, va): (u64, Vertex), (b, vb): (u64, Vertex)) -> EdgePlace {
        EdgePlace { from: self.vertex(a, va), to: self.vertex(b, vb) }
    }

    pub(super) fn face(&self, face: u64, first_corner: Vertex) -> FacePlace {
        let VertexPlace { x, y, .. } = self.vertex(0, first_corner);
        FacePlace { face, x, y }
    }
}

/// Twice the signed area of a triangle: positive where a, b, c turn from the x axis (columns) towards the y axis
/// (rows). Exact: coordinates stay below 2⁴¹.
pub(super) fn orientation(a: (i64, i64), b: (i64, i64), c: (i64, i64)) -> i128 {
    let (abx, aby) = (i128::from(b.0 - a.0), i128::from(b.1 - a.1));
    let (acx, acy) = (i128::from(c.0 - a.0), i128::from(c.1 - a.1));
    abx * acy - aby * acx
}
