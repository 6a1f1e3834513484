//! Faces: clockwise, without an area, nowhere near the raster.

use crate::formats::MeshReader;

use super::VerifyError;
use super::finding::{FacePlace, Finding};
use super::grid::{Grid, orientation};
use super::pace::Pace;
use super::triangle::{TRIANGLE_WORDS, Triangle};
use super::vertices::{Vertex, VertexStore};
use crate::base::external::{Scratch, Sorted, Sorter};

/// Bytes of the three sorts that are filled side by side.
const TRIANGLE_BYTES: usize = 16 << 20;
const EDGE_BYTES: usize = 12 << 20;
const USE_BYTES: usize = 4 << 20;

/// What one pass over the faces finds by itself.
#[derive(Debug, Default)]
pub(super) struct FaceFindings {
    pub(super) clockwise: Finding<FacePlace>,
    pub(super) degenerate: Finding<FacePlace>,
    pub(super) unplaced: Finding<FacePlace>,
    /// Twice the sum of the signed areas, counter-clockwise on the map positive, in lattice steps squared.
    pub(super) double_area: i128,
}

/// What it leaves to be looked at in another order.
#[derive(Debug)]
pub(super) struct FaceSorts<'s> {
    /// Triangles that touch samples, by first row.
    pub(super) triangles: Sorted<'s, TRIANGLE_WORDS>,
    /// `[low vertex, high vertex, face · 2 + (1 where the face runs from high to low)]`.
    pub(super) edges: Sorted<'s, 3>,
    /// The corners of all faces.
    pub(super) uses: Sorted<'s, 1>,
}

/// Reads the faces once: judges each by itself and sorts what has to be seen in order.
pub(super) fn read_faces<'s>(
    mesh: &mut dyn MeshReader,
    vertices: &mut VertexStore<'_>,
    grid: &Grid,
    scratch: &'s Scratch,
    pace: &mut Pace<'_>,
) -> Result<(FaceFindings, FaceSorts<'s>), VerifyError> {
    let mut found = FaceFindings::default();
    let mut triangles = Sorter::new(scratch, TRIANGLE_BYTES);
    let mut edges = Sorter::new(scratch, EDGE_BYTES);
    let mut uses = Sorter::new(scratch, USE_BYTES);
    mesh.for_each_face(|face, corners| {
        pace.tick()?;
        for (from, to) in [(corners[0], corners[1]), (corners[1], corners[2]), (corners[2], corners[0])] {
            uses.push([from])?;
            // An edge from a vertex to itself joins nothing; its face is found degenerate.
            if from != to {
                edges.push([from.min(to), from.max(to), face * 2 + u64::from(from > to)])?;
            }
        }
        let corners = [vertices.get(corners[0])?, vertices.get(corners[1])?, vertices.get(corners[2])?];
        let Some(triangle) = found.judge(grid, face, corners) else { return Ok(()) };
        let (first, last) = triangle.rows(grid);
        if first <= last {
            triangles.push(triangle.words(first))?;
        }
        Ok::<(), VerifyError>(())
    })?;
    let sorts = FaceSorts { triangles: triangles.finish()?, edges: edges.finish()?, uses: uses.finish()? };
    Ok((found, sorts))
}

impl FaceFindings {
    /// Which way the face turns, and the triangle to be held against the samples, whichever way that is.
    fn judge(&mut self, grid: &Grid, face: u64, corners: [Vertex; 3]) -> Option<Triangle> {
        let place = || grid.face(face, corners[0]);
        let [Some(a), Some(b), Some(c)] = corners.map(|v| v.place) else {
            self.unplaced.add(place);
            return None;
        };
        let double_area = orientation(a, b, c) * grid.map_turn();
        self.double_area += double_area;
        match double_area {
            0 => self.degenerate.add(place),
            ..0 => self.clockwise.add(place),
            _ => {}
        }
        Triangle::new(face, [a, b, c], corners.map(|v| v.z))
    }
}
