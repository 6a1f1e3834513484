//! A mesh as pages show it: all of it where it is small, else a copy of fewer triangles, which is for looking and nothing else.
//!
//! In come triangles by their corners, in a stream: those that a sink is given (`watched`), those that `verify` passes, or those of
//! a file ([`read()`]); out goes a [`Scene`]. A mesh that is too large is thinned while it comes (`gather`), by putting vertices
//! together that lie in one small square, and in the end by meshoptimizer's simplifier (`fewer`). So memory does not grow with
//! the mesh.

mod fewer;
mod gather;
mod read;
mod watched;

use crate::base::{CoordinateFrame, Metres, metres_in};

use super::coordinates::origin;

pub use read::{SceneReport, SceneRequest, read};

pub(super) use gather::Gatherer;
pub(super) use watched::Watched;

/// How many triangles of a mesh are shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Most {
    /// A mesh of at most so many is shown as it is.
    pub whole: usize,
    /// Of a larger one a copy of about so many at the most.
    pub copy: usize,
}

impl Most {
    /// As many as go into a page that is mailed.
    pub const OF_A_PAGE: Most = Most { whole: 200_000, copy: 100_000 };
}

/// A mesh to be looked at.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Scene {
    /// x, y on the map and height.
    pub vertices: Vec<[f64; 3]>,
    /// Triangles by their vertices, counter-clockwise on the map.
    pub triangles: Vec<[u32; 3]>,
    /// Triangles of the mesh.
    pub of: u64,
    /// Those that are left out because a corner is nowhere, or beyond ±10³⁰.
    pub left_out: u64,
    /// Whether these are other triangles than those of the mesh. No tolerance holds for a copy.
    pub is_copy: bool,
}

impl Scene {
    /// A copy of about so many triangles at the most.
    pub fn fewer(&self, most: usize) -> Scene {
        let mut copy = self.clone();
        fewer::reduce(&mut copy.vertices, &mut copy.triangles, most);
        Scene { is_copy: true, ..copy }
    }

    /// With vertices elsewhere; triangles that turn over by that are turned back.
    pub(super) fn placed(mut self, place: impl Fn([f64; 3]) -> [f64; 3]) -> Scene {
        self.vertices.iter_mut().for_each(|vertex| *vertex = place(*vertex));
        for triangle in &mut self.triangles {
            let [a, b, c] = triangle.map(|vertex| self.vertices[vertex as usize]);
            if (b[0] - a[0]) * (c[1] - a[1]) < (b[1] - a[1]) * (c[0] - a[0]) {
                triangle.swap(1, 2);
            }
        }
        self
    }

    /// How its coordinates fit into single precision, in metres, as far as the units are known.
    pub fn frame(&self, metres: Option<Metres>, height_unit: &str) -> CoordinateFrame {
        let [left, bottom, right, top] = self.extent();
        CoordinateFrame {
            origin: origin([left, bottom, right, top]),
            xy_scale: Metres::between(metres, bottom, top),
            z_scale: metres_in(height_unit).unwrap_or(1.0),
            single: true,
        }
    }

    /// The least x and y, and the largest; zeros where there is nothing.
    pub fn extent(&self) -> [f64; 4] {
        let Some([x, y, _]) = self.vertices.first().copied() else { return [0.0; 4] };
        self.vertices.iter().fold([x, y, x, y], |[left, bottom, right, top], &[x, y, _]| {
            [left.min(x), bottom.min(y), right.max(x), top.max(y)]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wavy sheet of `side` × `side` squares, by the corners of its triangles.
    fn sheet(side: usize) -> impl Iterator<Item = [[f64; 3]; 3]> {
        let at = |x: usize, y: usize| {
            let (x, y) = (x as f64, y as f64);
            [500_000.0 + x, 5_200_000.0 + y, 20.0 * (x / 40.0).sin() * (y / 55.0).cos()]
        };
        (0..side * side).flat_map(move |i| {
            let (x, y) = (i % side, i / side);
            let [a, b, c, d] = [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)];
            [[a, b, c], [a, c, d]]
        })
    }

    fn gatherer(side: usize, most: Most) -> Gatherer {
        let end = side as f64;
        Gatherer::new([500_000.0, 5_200_000.0, 500_000.0 + end, 5_200_000.0 + end], most)
    }

    fn gathered(side: usize, most: Most) -> Scene {
        let mut gatherer = gatherer(side, most);
        sheet(side).for_each(|corners| gatherer.triangle(corners));
        gatherer.finish(2 * (side * side) as u64)
    }

    /// The same, where the vertices are told first.
    fn gathered_after_vertices(side: usize, most: Most) -> Scene {
        let (mut gatherer, of) = (gatherer(side, most), 2 * (side * side) as u64);
        gatherer.expect(of);
        sheet(side).flatten().for_each(|vertex| gatherer.vertex(vertex));
        sheet(side).for_each(|corners| gatherer.triangle(corners));
        assert!(gatherer.held().0 <= 2 * most.copy, "{:?}", gatherer.held());
        gatherer.finish(of)
    }

    /// Twice the area of all triangles on the map, and the least of one.
    fn areas(scene: &Scene) -> (f64, f64) {
        let area = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|vertex| scene.vertices[vertex as usize]);
            (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        };
        let all = scene.triangles.iter().map(area);
        (all.clone().sum(), all.fold(f64::INFINITY, f64::min))
    }

    #[test]
    fn a_small_mesh_is_itself() {
        let scene = gathered(30, Most { whole: 1800, copy: 100 });
        let expected: Vec<_> = sheet(30).collect();
        let found: Vec<_> = scene.triangles.iter().map(|t| t.map(|v| scene.vertices[v as usize])).collect();
        assert_eq!((found, scene.vertices.len(), scene.is_copy), (expected, 31 * 31, false));
    }

    #[test]
    fn a_large_mesh_is_a_copy_that_covers_the_same_ground() {
        let most = Most { whole: 1800, copy: 1000 };
        let scenes = [31, 300]
            .map(|side| [gathered(side, most), gathered_after_vertices(side, most)].map(|scene| (side, scene)));
        for (side, scene) in scenes.into_iter().flatten() {
            assert!(scene.is_copy && scene.of == 2 * (side * side) as u64);
            assert!((300..=most.copy).contains(&scene.triangles.len()), "{}", scene.triangles.len());
            let side = side as f64;
            let ((all, _), wanted) = (areas(&scene), 2.0 * side * side);
            assert!((all / wanted - 1.0).abs() < 0.1, "{all} of {wanted}");
            // It is near the sheet, whose slopes are below 1.
            let near = |[x, y, z]: [f64; 3]| {
                let (x, y) = ((x - 500_000.0) / 40.0, (y - 5_200_000.0) / 55.0);
                (20.0 * x.sin() * y.cos() - z).abs() < 1e-9
            };
            assert!(scene.vertices.iter().all(|v| near(*v)));
            let used: std::collections::BTreeSet<u32> = scene.triangles.iter().flatten().copied().collect();
            assert_eq!(used.len(), scene.vertices.len(), "vertices of no triangle are left out");
        }
    }

    #[test]
    fn memory_does_not_grow_with_the_mesh() {
        let most = Most { whole: 1000, copy: 500 };
        let mut gatherer = Gatherer::new([500_000.0, 5_200_000.0, 500_500.0, 5_200_500.0], most);
        // Triangles between places far apart: squares alone keep none of them together.
        let place = |i: u64| {
            let mixed = i.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 20;
            [500_000.0 + (mixed % 500) as f64, 5_200_000.0 + (mixed / 500 % 500) as f64, (mixed % 7) as f64]
        };
        for i in 0..200_000 {
            gatherer.triangle([place(3 * i), place(3 * i + 1), place(3 * i + 2)]);
            let (triangles, vertices) = gatherer.held();
            assert!(triangles <= 2 * most.whole + 1 && vertices <= 6 * most.whole + 3, "{triangles} {vertices}");
        }
        let scene = gatherer.finish(200_000);
        assert!(scene.triangles.len() <= most.whole, "{}", scene.triangles.len());
    }

    #[test]
    fn triangles_are_turned_upwards() {
        let scene = gathered(20, Most::OF_A_PAGE).placed(|[x, y, z]| [x, -y, z]);
        assert!(areas(&scene).1 > 0.0);
    }

    #[test]
    fn what_is_nowhere_is_left_out() {
        let mut gatherer = Gatherer::new([0.0, 0.0, 1.0, 1.0], Most::OF_A_PAGE);
        for height in [0.0, 1e30, f64::NAN, f64::NEG_INFINITY, -1e29] {
            gatherer.triangle([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, height]]);
        }
        let scene = gatherer.finish(5);
        assert_eq!((scene.triangles.len(), scene.left_out, scene.of), (2, 3, 5));
    }

    #[test]
    fn nothing_is_nothing() {
        let scene = Gatherer::new([f64::NAN; 4], Most::OF_A_PAGE).finish(0);
        assert_eq!((scene.vertices.len(), scene.triangles.len(), scene.extent()), (0, 0, [0.0; 4]));
    }
}
