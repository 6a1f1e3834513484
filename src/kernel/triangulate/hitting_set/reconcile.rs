//! Heights of shared corners, reconciled: each in turn is moved to where the samples around it want it.

use super::shared::near_sample;
use crate::base::Tile;
use crate::base::control::{CancelToken, Cancelled};
use crate::base::lattice::Point;
use crate::base::mesh::{TileMesh, Vertex};
use crate::kernel::quantum::Quantum;
use crate::kernel::triangulate::feasible::{Plane, Spans};

/// How often every vertex is moved. More change little.
const ROUNDS: usize = 3;
/// Vertices between two looks at the cancellation token.
const VERTICES_BETWEEN_CHECKS: usize = 256;

/// Moves the heights of all vertices but the first `fixed`. With the others as they are, a sample under a vertex's triangles is
/// within its limit for an interval of heights; the height is put in the middle of what all have in common, or half-way between
/// the two that are farthest apart. Vertices are at samples, and stay within the limits of these.
pub(super) fn heights(
    tile: &Tile,
    tolerance: f64,
    fixed: usize,
    mesh: &mut TileMesh,
    cancel: &CancelToken,
) -> Result<(), Cancelled> {
    let Some(quantum) = Quantum::of(tolerance) else { return Ok(()) };
    let stars = Stars::new(mesh);
    for _ in 0..ROUNDS {
        for v in fixed..mesh.vertices.len() {
            if v.is_multiple_of(VERTICES_BETWEEN_CHECKS) {
                cancel.check()?;
            }
            let (mut least, mut most) = (f64::NEG_INFINITY, f64::INFINITY);
            for &corner in stars.of(v) {
                let (t, i) = (corner / 3, corner as usize % 3);
                let corners = mesh.corners(mesh.triangles[t as usize]);
                let (from, to) = wanted(tile, tolerance, [corners[i], corners[(i + 1) % 3], corners[(i + 2) % 3]]);
                (least, most) = (least.max(from), most.min(to));
            }
            let Vertex { at, height } = mesh.vertices[v];
            let place = at.sample().expect("vertices at samples");
            let raised = quantum.round(height + (least + most) / 2.0);
            mesh.vertices[v] = near_sample(tile, tolerance, place, raised);
        }
    }
    Ok(())
}

/// By how much the first corner of a triangle may rise, from and to, so that every sample is within its limit: perhaps from more
/// than to.
fn wanted(tile: &Tile, tolerance: f64, [a, b, c]: [Vertex; 3]) -> (f64, f64) {
    let (plane, spans) = (Plane::new(a, b, c), Spans::new(a.at, b.at, c.at));
    let (mut from, mut to) = (f64::NEG_INFINITY, f64::INFINITY);
    for row in spans.rows() {
        let (first, last) = spans.columns(row);
        for column in first..=last {
            let at = Point::of_sample(column, row);
            let share = plane.share_of_a(at);
            if share > 0.0 {
                let gap = tile.at(column as usize, row as usize) - plane.at(at);
                let limit = tile.limit(column as usize, row as usize, tolerance);
                (from, to) = (from.max((gap - limit) / share), to.min((gap + limit) / share));
            }
        }
    }
    (from, to)
}

/// The corners of triangles at every vertex, as 3t + i.
struct Stars {
    starts: Vec<u32>,
    corners: Vec<u32>,
}

impl Stars {
    fn new(mesh: &TileMesh) -> Stars {
        let mut starts = vec![0u32; mesh.vertices.len() + 1];
        let corners = mesh.triangles.as_flattened();
        corners.iter().for_each(|&v| starts[v as usize + 1] += 1);
        (1..starts.len()).for_each(|v| starts[v] += starts[v - 1]);
        let (mut next, mut sorted) = (starts.clone(), vec![0; corners.len()]);
        for (corner, &v) in (0u32..).zip(corners) {
            sorted[next[v as usize] as usize] = corner;
            next[v as usize] += 1;
        }
        Stars { starts, corners: sorted }
    }

    fn of(&self, v: usize) -> &[u32] {
        &self.corners[self.starts[v] as usize..self.starts[v + 1] as usize]
    }
}
