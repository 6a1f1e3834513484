//! The numbers of a mesh, row by row: what is near on the ground is near in memory.
//!
//! Engines number vertices and triangles as they make them, which leads all over a tile. Polishing goes through it in raster
//! order, so with such numbers a step finds what it needs where the one before was.

use crate::base::mesh::TileMesh;

/// Numbers the vertices from `locked` on in raster order, and triangles in the order of their last corners.
pub(super) fn number_by_rows(locked: u32, mesh: &mut TileMesh) {
    let TileMesh { vertices, triangles, .. } = mesh;
    let mut order: Vec<u32> = (locked..vertices.len() as u32).collect();
    order.sort_unstable_by_key(|&v| (vertices[v as usize].at.y, vertices[v as usize].at.x));
    let mut numbers: Vec<u32> = (0..vertices.len() as u32).collect();
    (locked..).zip(&order).for_each(|(number, &v)| numbers[v as usize] = number);
    let sorted: Vec<_> = order.iter().map(|&v| vertices[v as usize]).collect();
    vertices[locked as usize..].copy_from_slice(&sorted);
    drop((order, sorted));

    triangles.as_flattened_mut().iter_mut().for_each(|v| *v = numbers[*v as usize]);
    // Counted by their last corners; then each has the place of the first.
    let last = |t: &[u32; 3]| t[0].max(t[1]).max(t[2]) as usize;
    let mut places = numbers;
    places.fill(0);
    triangles.iter().for_each(|t| places[last(t)] += 1);
    let mut sum = 0;
    places.iter_mut().for_each(|place| sum += std::mem::replace(place, sum));
    let mut sorted = vec![[0; 3]; triangles.len()];
    for t in triangles.iter() {
        let place = &mut places[last(t)];
        sorted[*place as usize] = *t;
        *place += 1;
    }
    triangles.copy_from_slice(&sorted);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::lattice::Point;
    use crate::base::mesh::Vertex;

    #[test]
    fn the_same_triangles_from_row_to_row() {
        let places = [(0, 9), (9, 9), (7, 5), (0, 0), (3, 5), (9, 0), (4, 2)];
        let vertices = places.map(|(x, y)| Vertex { at: Point::of_sample(x, y), height: f64::from(10 * y + x) });
        let triangles = vec![[5, 3, 6], [0, 1, 2], [2, 4, 0], [6, 4, 2], [4, 6, 3]];
        let mut mesh = TileMesh { vertices: vertices.to_vec(), triangles, ..TileMesh::default() };
        let corners = |mesh: &TileMesh| mesh.triangles.iter().map(|&t| mesh.corners(t)).collect::<Vec<_>>();
        let before = corners(&mesh);
        number_by_rows(2, &mut mesh);
        assert_eq!(mesh.vertices[..2], vertices[..2], "locked vertices stay");
        assert_eq!(mesh.vertices[2..], [3, 5, 6, 4, 2].map(|v: usize| vertices[v]), "others stand in raster order");
        let after = corners(&mesh);
        assert!(after.len() == before.len() && before.iter().all(|t| after.contains(t)), "{after:?} of {before:?}");
        let last: Vec<u32> = mesh.triangles.iter().map(|t| *t.iter().max().unwrap()).collect();
        assert!(last.is_sorted(), "{last:?}");
    }
}
