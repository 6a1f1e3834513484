//! Faces: clockwise, without an area, nowhere near the raster.

use crate::formats::MeshReader;

use super::VerifyError;
use super::corners::{UseKey, use_sort};
use super::edges::{EdgeKey, edge_sort};
use super::finding::{FacePlace, Finding};
use super::gather::Gather;
use super::grid::{Grid, orientation};
use super::observe::Observer;
use super::pace::Pace;
use super::triangle::{TRIANGLE_WORDS, Triangle};
use super::vertices::{Vertex, VertexStore};
use crate::base::external::{Scratch, Sorted, Sorter};

/// Bytes of the sort of triangles.
const TRIANGLE_BYTES: usize = 16 << 20;
/// Faces that are taken at a time.
const CHUNK: usize = 16 << 10;

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
pub(super) struct FaceSorts<'s> {
    /// Triangles that touch samples, and those between two rows if they were asked for, by first row.
    pub(super) triangles: Sorted<'s, TRIANGLE_WORDS>,
    pub(super) edges: Gather<'s, EdgeKey>,
    /// The corners of all faces.
    pub(super) uses: Gather<'s, UseKey>,
}

/// Reads the faces once: judges each by itself and sorts what has to be seen in order.
///
/// Memory use is constant: the sorts', and 24 bytes for each face of a chunk. Triangles that lie between two rows of samples are
/// kept if `between` says so.
pub(super) fn read_faces<'s>(
    mesh: &mut dyn MeshReader,
    vertices: &mut VertexStore<'s>,
    grid: &Grid,
    between: bool,
    (scratch, observer): (&'s Scratch, Option<&mut dyn Observer>),
    pace: &mut Pace<'_>,
) -> Result<(FaceFindings, FaceSorts<'s>), VerifyError> {
    let triangles = Sorter::new(scratch, TRIANGLE_BYTES);
    let (edges, uses) = (edge_sort(scratch), use_sort(scratch));
    let mut faces =
        Faces { grid, vertices, found: FaceFindings::default(), triangles, edges, uses, between, observer, count: 0 };
    let mut chunk = Vec::with_capacity(CHUNK);
    mesh.for_each_face(|_, corners| {
        chunk.push(corners);
        if chunk.len() == CHUNK {
            faces.take(&chunk)?;
            pace.pass(CHUNK as u64)?;
            chunk.clear();
        }
        Ok::<(), VerifyError>(())
    })?;
    faces.take(&chunk)?;
    pace.pass(chunk.len() as u64)?;
    let Faces { found, triangles, edges, uses, .. } = faces;
    Ok((found, FaceSorts { triangles: triangles.finish()?, edges, uses }))
}

/// What is made of faces.
struct Faces<'a, 's, 'o> {
    grid: &'a Grid,
    vertices: &'a mut VertexStore<'s>,
    found: FaceFindings,
    triangles: Sorter<'s, TRIANGLE_WORDS>,
    edges: Gather<'s, EdgeKey>,
    uses: Gather<'s, UseKey>,
    between: bool,
    observer: Option<&'o mut dyn Observer>,
    /// How many have been taken.
    count: u64,
}

impl Faces<'_, '_, '_> {
    /// Takes the next faces: corners and edges on one thread, places on another.
    fn take(&mut self, faces: &[[u64; 3]]) -> Result<(), VerifyError> {
        let Faces { grid, vertices, found, triangles, edges, uses, between, observer, count } = self;
        let by_number = || {
            faces.iter().try_for_each(|&[a, b, c]| {
                [a, b, c].into_iter().try_for_each(|vertex| uses.push(UseKey::record(vertex)))?;
                // An edge from a vertex to itself joins nothing; its face is found degenerate.
                let sides = [(a, b), (b, c), (c, a)].into_iter().filter(|(from, to)| from != to);
                sides.map(|(from, to)| EdgeKey::record(from, to)).try_for_each(|record| edges.push(record))
            })
        };
        let by_place = || {
            (*count..).zip(faces).try_for_each(|(face, &[a, b, c])| {
                let corners = [vertices.get(a)?, vertices.get(b)?, vertices.get(c)?];
                let Some(triangle) = found.judge(grid, face, corners) else { return Ok(()) };
                if let Some(observer) = observer {
                    observer.face(triangle.corners, triangle.heights);
                }
                let (first, last) = if *between { triangle.rows_around(grid) } else { triangle.rows(grid) };
                if first <= last {
                    triangles.push(triangle.words(first))?;
                }
                Ok::<(), VerifyError>(())
            })
        };
        let (numbers, places) = rayon::join(by_number, by_place);
        *count += faces.len() as u64;
        numbers.and(places)
    }
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
