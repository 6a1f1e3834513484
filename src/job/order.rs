//! The order of a chunk's triangles and vertices: that in which readers, graphics cards and compressors like them.

use super::spool::Chunk;

/// Orders the triangles of a chunk so that each shares vertices with those just before it (meshoptimizer's order for vertex
/// caches), and the vertices inside by their first use. Vertices that others borrow stay where they are. The mesh as a set of
/// triangles is the same, as is the first corner of each triangle; the order depends on the chunk alone.
pub(super) fn in_cache_order(chunk: &mut Chunk) {
    if chunk.triangles.is_empty() {
        return;
    }
    let before = chunk.before_borrowed();
    let first_inside = before + chunk.foreign.len();
    let vertices = chunk.vertices.len() + chunk.foreign.len();
    let ordered = meshopt::optimize_vertex_cache(chunk.triangles.as_flattened(), vertices);
    chunk.triangles.as_flattened_mut().copy_from_slice(&ordered);
    // The new places of vertices inside, counted from the first of them, and the old ones in their new order.
    let inside = vertices - first_inside;
    let mut places = vec![u32::MAX; inside];
    let mut order = Vec::with_capacity(inside);
    for vertex in chunk.triangles.as_flattened_mut().iter_mut().filter(|v| **v as usize >= first_inside) {
        let old = *vertex as usize - first_inside;
        if places[old] == u32::MAX {
            places[old] = order.len() as u32;
            order.push(old as u32);
        }
        *vertex = first_inside as u32 + places[old];
    }
    // In no triangle: there are none today.
    order.extend((0..inside as u32).filter(|&old| places[old as usize] == u32::MAX));
    reorder(&mut chunk.vertices[before..], &order);
    chunk.attributes.iter_mut().for_each(|attribute| reorder(&mut attribute.values[before..], &order));
}

/// Puts into place i what is at place `order[i]`.
fn reorder<T: Copy>(values: &mut [T], order: &[u32]) {
    let old = values.to_vec();
    values.iter_mut().zip(order).for_each(|(value, &place)| *value = old[place as usize]);
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::base::lattice::Point;
    use crate::base::mesh::Vertex;
    use crate::job::spool::Attribute;
    use crate::kernel::seam::{Foreign, RimCounts};

    /// Each triangle as what stands at its corners, turned so that the least comes first.
    fn triangles(chunk: &Chunk) -> Vec<[(i32, u64); 3]> {
        let before = chunk.before_borrowed();
        let corner = |i: u32| {
            let i = i as usize;
            let own = |at: usize| (chunk.vertices[at].at.x, chunk.attributes[0].values[at].to_bits());
            match i.checked_sub(before) {
                None => own(i),
                Some(k) if k < chunk.foreign.len() => (-1 - k as i32, 0),
                Some(_) => own(i - chunk.foreign.len()),
            }
        };
        let mut all: Vec<_> = chunk.triangles.iter().map(|t| t.map(corner)).collect();
        all.sort_unstable();
        all
    }

    proptest! {
        #[test]
        fn the_mesh_stays_the_same(
            (shared, foreign, inside) in (0u32..5, 0usize..5, 3u32..40),
            picks in proptest::collection::vec([any::<prop::sample::Index>(), any::<prop::sample::Index>(), any::<prop::sample::Index>()], 0..80),
        ) {
            let owned = shared + inside;
            let vertex = |i: u32| Vertex { at: Point { x: i as i32, y: 0 }, height: f64::from(i) };
            let total = owned as usize + foreign;
            let triangles_of = |[a, b, c]: [prop::sample::Index; 3]| {
                let (a, b, c) = (a.index(total), b.index(total), c.index(total));
                (a != b && b != c && a != c).then_some([a as u32, b as u32, c as u32])
            };
            let mut chunk = Chunk {
                rim: RimCounts::default(),
                shared,
                vertices: (0..owned).map(vertex).collect(),
                foreign: vec![Foreign::SouthEast; foreign],
                triangles: picks.into_iter().filter_map(triangles_of).collect(),
                attributes: vec![Attribute { name: "a".into(), values: (0..owned).map(|i| f64::from(i) / 2.0).collect() }],
                ..Chunk::default()
            };
            let (before, given) = (chunk.clone(), triangles(&chunk));
            in_cache_order(&mut chunk);
            prop_assert_eq!(triangles(&chunk), given);
            prop_assert_eq!(&chunk.vertices[..shared as usize], &before.vertices[..shared as usize]);
            // Vertices inside come in the order of their first use.
            let first = shared as usize + foreign;
            let mut next = first;
            for &v in chunk.triangles.as_flattened().iter().filter(|v| **v as usize >= first) {
                prop_assert!(v as usize <= next);
                next = next.max(v as usize + 1);
            }
        }
    }
}
