//! The part of a region's mesh around some of its vertices, taken out to be polished by itself and put back.

use crate::base::handed_over::DENSE;
use crate::base::mesh::TileMesh;

/// What lies around some vertices of a mesh. Its border is locked, so that what is done to it stays near them, and costs
/// what it has, not what the mesh has.
///
/// Memory: that of its mesh, and 5 bytes for each vertex of the whole.
#[derive(Debug, Default)]
pub(super) struct Part {
    pub(super) mesh: TileMesh,
    /// Vertices of the part that stay: those that the whole has locked, and those of its border; the first ones.
    pub(super) locked: u32,
    /// The vertices it lies around.
    pub(super) centres: Vec<u32>,
    /// Of those that stay, their numbers in the whole.
    stay: Vec<u32>,
    /// Whether a vertex of the whole is so near that it may change, unless it is locked.
    near: Vec<bool>,
    /// Numbers of the whole's vertices in the part; then those after it is put back.
    numbers: Vec<u32>,
}

const NONE: u32 = u32::MAX;

impl Part {
    /// Takes from a mesh, whose first `locked` vertices stay, all triangles with a vertex at most `rings` edges away from the
    /// centres, none of which is locked.
    pub(super) fn take(&mut self, whole: &mut TileMesh, locked: u32, centres: &[u32], rings: usize) {
        self.find_near(whole, centres, rings);
        let Part { mesh, stay, near, numbers, .. } = self;
        mesh.clear();
        stay.clear();
        numbers.clear();
        numbers.resize(whole.vertices.len(), NONE);
        whole.triangles.retain(|&t| {
            let is_part = t.iter().any(|&v| near[v as usize]);
            if is_part {
                mesh.triangles.push(t);
                // They are in use; their numbers follow.
                t.iter().for_each(|&v| numbers[v as usize] = 0);
            }
            !is_part
        });
        let stays = |v: u32| v < locked || !near[v as usize];
        let in_use = (0..whole.vertices.len() as u32).filter(|&v| numbers[v as usize] != NONE);
        let (first, then): (Vec<u32>, Vec<u32>) = in_use.partition(|&v| stays(v));
        for (number, &v) in (0..).zip(first.iter().chain(&then)) {
            numbers[v as usize] = number;
            mesh.vertices.push(whole.vertices[v as usize]);
        }
        mesh.triangles.as_flattened_mut().iter_mut().for_each(|v| *v = numbers[*v as usize]);
        self.locked = first.len() as u32;
        self.stay = first;
        self.centres.clear();
        self.centres.extend(centres.iter().map(|&v| numbers[v as usize]).filter(|&v| v != NONE));
        // What may change leaves the whole.
        let mut left = 0;
        for v in 0..whole.vertices.len() as u32 {
            let stays = v < locked || !near[v as usize];
            numbers[v as usize] = if stays { left } else { NONE };
            if stays {
                whole.vertices[left as usize] = whole.vertices[v as usize];
                left += 1;
            }
        }
        whole.vertices.truncate(left as usize);
        whole.triangles.as_flattened_mut().iter_mut().for_each(|v| *v = numbers[*v as usize]);
    }

    /// Puts the part back, whose vertices that stay are the first ones as before. The whole's first vertices keep their
    /// numbers.
    pub(super) fn put_back(&mut self, whole: &mut TileMesh) {
        let Part { mesh, stay, numbers, .. } = self;
        let (stayed, first) = (stay.len() as u32, whole.vertices.len() as u32);
        whole.vertices.extend_from_slice(&mesh.vertices[stay.len()..]);
        let number = |v: u32| if v < stayed { numbers[stay[v as usize] as usize] } else { first + v - stayed };
        whole.triangles.extend(mesh.triangles.iter().map(|t| t.map(number)));
        if whole.triangles.len() > DENSE {
            *self = Part::default();
        }
    }

    /// Finds the vertices at most `rings` edges away from the centres.
    fn find_near(&mut self, whole: &TileMesh, centres: &[u32], rings: usize) {
        let near = &mut self.near;
        near.clear();
        near.resize(whole.vertices.len(), false);
        centres.iter().for_each(|&v| near[v as usize] = true);
        for _ in 0..rings {
            let beside = whole.triangles.iter().filter(|t| t.iter().any(|&v| near[v as usize]));
            let ring: Vec<u32> = beside.flatten().copied().collect();
            ring.into_iter().for_each(|v| near[v as usize] = true);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::lattice::Point;
    use crate::base::mesh::Vertex;

    /// A square of cells, two triangles each.
    fn square(cells: u32) -> TileMesh {
        let side = cells + 1;
        let vertex =
            |i: u32| Vertex { at: Point::of_sample((i % side) as i32, (i / side) as i32), height: f64::from(i) };
        let corners = (0..cells * cells).map(|i| i / cells * side + i % cells);
        let triangles = corners.flat_map(|i| [[i, i + 1, i + side + 1], [i, i + side + 1, i + side]]).collect();
        TileMesh { vertices: (0..side * side).map(vertex).collect(), triangles, relaxed: 0 }
    }

    fn sorted(mesh: &TileMesh) -> Vec<[(i32, i32); 3]> {
        let mut all: Vec<_> = mesh.triangles.iter().map(|&t| mesh.corners(t).map(|v| (v.at.x, v.at.y))).collect();
        all.sort_unstable();
        all
    }

    #[test]
    fn what_is_put_back_is_where_it_was() {
        let (before, locked) = (square(9), 23);
        for (centres, rings) in [(vec![], 2), (vec![44], 0), (vec![44, 30], 1), (vec![25], 3), (vec![55], 20)] {
            let (mut whole, mut part) = (before.clone(), Part::default());
            part.take(&mut whole, locked, &centres, rings);
            let (inside, outside) = (sorted(&part.mesh), sorted(&whole));
            assert_eq!(inside.len() + outside.len(), before.triangles.len());
            // Around a vertex and 0 edges more: its six triangles.
            assert!(rings > 0 || inside.len() == 6);
            // Nothing outside has a vertex that may change.
            let free: Vec<(i32, i32)> =
                part.mesh.vertices[part.locked as usize..].iter().map(|v| (v.at.x, v.at.y)).collect();
            assert!(outside.as_flattened().iter().all(|at| !free.contains(at)));
            let places: Vec<Point> = part.centres.iter().map(|&v| part.mesh.vertices[v as usize].at).collect();
            assert_eq!(places, centres.iter().map(|&v| before.vertices[v as usize].at).collect::<Vec<_>>());
            part.put_back(&mut whole);
            assert_eq!(sorted(&whole), sorted(&before));
            assert_eq!(whole.vertices.len(), before.vertices.len());
            assert_eq!(whole.vertices[..locked as usize], before.vertices[..locked as usize]);
        }
    }
}
