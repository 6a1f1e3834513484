//! Which sides of triangles are one edge: every half-edge's twin, found without a list of edges.

/// Triangles as half-edges: 3t + i runs from corner i of triangle t to its next corner.
pub(in crate::kernel) trait HalfEdges {
    /// The corners of a triangle.
    fn corners(&self, t: u32) -> [u32; 3];
    /// What the twin of a half-edge has been set to.
    fn twin(&self, e: u32) -> u32;
    /// Sets it.
    fn set_twin(&mut self, e: u32, twin: u32);
}

/// No half-edge.
pub(in crate::kernel) const NONE: u32 = u32::MAX;

/// Finds the twin of every half-edge of `triangles` triangles; [`NONE`] for those that have none. `first` is memory, a number per
/// vertex.
///
/// Half-edges that `is_rim` names have no twin. Others may be without one where `may_be_lone` says so of their ends, the lower
/// first.
///
/// # Panics
/// If an edge has neither two sides in opposite directions nor one that may be lone.
pub(in crate::kernel) fn pair_sides(
    mesh: &mut impl HalfEdges,
    triangles: u32,
    first: &mut [u32],
    is_rim: impl Fn(u32, u32) -> bool,
    may_be_lone: impl Fn(u32, u32) -> bool,
) {
    chain_sides(mesh, triangles, first, is_rim);
    // By the higher end, then by number.
    let mut bucket: Vec<(u32, u32)> = Vec::new();
    for first in first {
        bucket.clear();
        let mut side = std::mem::replace(first, NONE);
        while side != NONE {
            bucket.push((high(mesh, side), side));
            let after = mesh.twin(side);
            mesh.set_twin(side, NONE);
            side = after;
        }
        bucket.sort_unstable();
        for sides in bucket.chunk_by(|a, b| a.0 == b.0) {
            match *sides {
                [(_, e), (_, f)] if ends(mesh, e) == swap(ends(mesh, f)) => {
                    mesh.set_twin(e, f);
                    mesh.set_twin(f, e);
                }
                [(high, e)] if may_be_lone(low(mesh, e), high) => {}
                _ => panic!("{} sides of the edge {:?}", sides.len(), ends(mesh, sides[0].1)),
            }
        }
    }
}

/// Chains the half-edges that are to have a twin by the lower number of their ends: that vertex has the first of them, each has
/// the next as its twin.
fn chain_sides(mesh: &mut impl HalfEdges, triangles: u32, first: &mut [u32], is_rim: impl Fn(u32, u32) -> bool) {
    first.fill(NONE);
    for e in 0..3 * triangles {
        let (a, b) = ends(mesh, e);
        let next = if is_rim(a, b) { NONE } else { std::mem::replace(&mut first[a.min(b) as usize], e) };
        mesh.set_twin(e, next);
    }
}

/// Where a half-edge begins and ends.
#[inline]
fn ends(mesh: &impl HalfEdges, e: u32) -> (u32, u32) {
    let corners = mesh.corners(e / 3);
    (corners[e as usize % 3], corners[(e as usize + 1) % 3])
}

fn low(mesh: &impl HalfEdges, e: u32) -> u32 {
    let (from, to) = ends(mesh, e);
    from.min(to)
}

fn high(mesh: &impl HalfEdges, e: u32) -> u32 {
    let (from, to) = ends(mesh, e);
    from.max(to)
}

fn swap((a, b): (u32, u32)) -> (u32, u32) {
    (b, a)
}
