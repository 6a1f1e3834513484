//! Normals against what planes and spheres have, with one tile and with many.

use std::sync::{Arc, Mutex};

use super::{NormalSource, Normals};
use crate::base::control::Control;
use crate::base::{CoordinateFrame, GeoTransform, Heights};
use crate::field::Field;
use crate::formats::{Contents, Sink, SinkError};
use crate::job::{Params, Quality, triangulate};
use crate::testing::in_memory;

type Seen = Arc<Mutex<Vec<([f64; 3], [f64; 3])>>>;

struct Listener(Seen);

impl Sink for Listener {
    fn begin(&mut self, contents: &Contents<'_>) -> Result<(), SinkError> {
        assert!(contents.has_normals);
        let names: Vec<&str> = contents.attributes.iter().map(|a| a.name.as_str()).collect();
        assert_eq!(names, ["nx", "ny", "nz"]);
        Ok(())
    }
    fn vertices(&mut self, vertices: &[[f64; 3]], attributes: &[&[f64]]) -> Result<(), SinkError> {
        let mut seen = self.0.lock().expect("whole");
        let normals = (0..vertices.len()).map(|i| [attributes[0][i], attributes[1][i], attributes[2][i]]);
        seen.extend(vertices.iter().copied().zip(normals));
        Ok(())
    }
    fn triangles(&mut self, _: &[[u64; 3]], _: &[[[f64; 3]; 3]]) -> Result<(), SinkError> {
        Ok(())
    }
    fn finish(self: Box<Self>) -> Result<(), SinkError> {
        Ok(())
    }
}

/// Vertices and their normals, in the order of places.
fn normals(field: &Field, tile: usize, normals: Normals, frame: CoordinateFrame) -> Vec<([f64; 3], [f64; 3])> {
    let params = in_memory(&Params { tile, quality: Quality::Balanced, ..Params::new(0.5) });
    let mesh = triangulate(field, &params, &Control::default()).expect("a mesh");
    let seen = Seen::default();
    let source = NormalSource { normals, field, frame };
    mesh.write_if(Box::new(Listener(seen.clone())), Some(source), &Control::default(), &|| Ok(())).expect("written");
    let mut seen = std::mem::take(&mut *seen.lock().expect("whole"));
    seen.sort_unstable_by(|a, b| a.partial_cmp(b).expect("numbers"));
    seen
}

fn field(transform: GeoTransform, height: impl Fn(f64, f64) -> f64) -> Field {
    let (width, height_of) = (70, height);
    let heights = (0..70 * 60).map(|i| height_of((i % width) as f64, (i / width) as f64)).collect();
    Field::from_heights(width, 60, Heights::F64(heights)).expect("a field").with_geo_transform(transform)
}

const FRAMES: [CoordinateFrame; 2] =
    [CoordinateFrame::PLAIN, CoordinateFrame { origin: (3.0, 4.0), xy_scale: (2.0, 4.0), z_scale: 0.5, single: false }];

/// Rows from north to south, the other way, and turned.
fn transforms() -> [GeoTransform; 3] {
    [[0.0, 2.0, 0.0, 0.0, 0.0, -2.0], [0.0, 2.0, 0.0, 0.0, 0.0, 3.0], [5.0, 1.0, 0.5, 7.0, 0.25, -2.0]]
        .map(|coefficients| GeoTransform::new(coefficients, 70, 60).expect("a transform"))
}

#[test]
fn a_plane_has_one_normal() {
    for transform in transforms() {
        // 3x − 2y on the map.
        let plane = field(transform, |c, r| {
            let (x, y) = transform.apply(4 * c as i64, 4 * r as i64);
            3.0 * x - 2.0 * y
        });
        for frame in FRAMES {
            let (sx, sy) = frame.xy_scale;
            let steep = [-3.0 * frame.z_scale / sx, 2.0 * frame.z_scale / sy, 1.0];
            let length = steep.iter().map(|v| v * v).sum::<f64>().sqrt();
            for kind in [Normals::Gradient, Normals::Area] {
                for (_, normal) in normals(&plane, 32, kind, frame) {
                    let off = normal.iter().zip(steep).map(|(n, s)| (n - s / length).abs()).fold(0.0, f64::max);
                    assert!(off < 1e-6, "{kind:?} {normal:?} {steep:?}");
                }
            }
        }
    }
}

/// The raster's normal depends on no tile.
#[test]
fn gradients_are_those_of_the_samples() {
    let height = |c: f64, r: f64| 40.0 * (c / 9.0).sin() + 30.0 * (r / 7.0).cos();
    let hills = field(GeoTransform::DEFAULT, height);
    for tile in [20, 0] {
        for ([x, y, _], normal) in normals(&hills, tile, Normals::Gradient, CoordinateFrame::PLAIN) {
            let (c, r) = (x - 0.5, -y - 0.5);
            let across = (height((c + 1.0).min(69.0), r) - height((c - 1.0).max(0.0), r))
                / ((c + 1.0).min(69.0) - (c - 1.0).max(0.0));
            let down = (height(c, (r + 1.0).min(59.0)) - height(c, (r - 1.0).max(0.0)))
                / ((r + 1.0).min(59.0) - (r - 1.0).max(0.0));
            let length = (1.0 + across * across + down * down).sqrt();
            let expected = [-across / length, down / length, 1.0 / length];
            assert!(normal.iter().zip(expected).all(|(n, e)| (n - e).abs() < 1e-6), "{c} {r} {normal:?} {expected:?}");
        }
    }
}

/// Sums over tiles are those of the whole: a naive sum over the triangles of the same mesh says the same.
#[test]
fn areas_add_up_across_tiles() {
    struct Whole(Seen, Vec<([f64; 3], [f64; 3])>, Arc<Mutex<Vec<[f64; 3]>>>);
    impl Sink for Whole {
        fn begin(&mut self, _: &Contents<'_>) -> Result<(), SinkError> {
            Ok(())
        }
        fn vertices(&mut self, vertices: &[[f64; 3]], attributes: &[&[f64]]) -> Result<(), SinkError> {
            let normals = (0..vertices.len()).map(|i| [attributes[0][i], attributes[1][i], attributes[2][i]]);
            self.1.extend(vertices.iter().copied().zip(normals));
            self.2.lock().expect("whole").resize(self.1.len(), [0.0; 3]);
            Ok(())
        }
        fn triangles(&mut self, triangles: &[[u64; 3]], _: &[[[f64; 3]; 3]]) -> Result<(), SinkError> {
            let mut sums = self.2.lock().expect("whole");
            for t in triangles {
                let [a, b, c] = t.map(|v| self.1[v as usize].0);
                let (u, v) = ([0, 1, 2].map(|i| b[i] - a[i]), [0, 1, 2].map(|i| c[i] - a[i]));
                let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
                t.iter().for_each(|&v| (0..3).for_each(|i| sums[v as usize][i] += n[i]));
            }
            Ok(())
        }
        fn finish(self: Box<Self>) -> Result<(), SinkError> {
            *self.0.lock().expect("whole") = self.1;
            Ok(())
        }
    }
    let hole = |c: f64, r: f64| (c - 40.0).hypot(r - 25.0) < 5.0;
    let height = |c: f64, r: f64| if hole(c, r) { f64::NAN } else { 40.0 * (c / 9.0).sin() + 30.0 * (r / 7.0).cos() };
    for transform in transforms() {
        let hills = field(transform, height);
        for (tile, quality) in [(20, Quality::Balanced), (20, Quality::None), (0, Quality::None)] {
            let params = in_memory(&Params { tile, quality, ..Params::new(0.5) });
            let mesh = triangulate(&hills, &params, &Control::default()).expect("a mesh");
            let (seen, sums) = (Seen::default(), Arc::default());
            let sink = Whole(seen.clone(), Vec::new(), Arc::clone(&sums));
            let source = NormalSource { normals: Normals::Area, field: &hills, frame: CoordinateFrame::PLAIN };
            mesh.write_if(Box::new(sink), Some(source), &Control::default(), &|| Ok(())).expect("written");
            let (seen, sums) = (seen.lock().expect("whole"), sums.lock().expect("whole"));
            assert!(seen.len() > 100);
            for ((place, found), sum) in seen.iter().zip(sums.iter()) {
                let length = sum.iter().map(|v| v * v).sum::<f64>().sqrt();
                assert!(
                    length == 0.0 || found.iter().zip(sum).all(|(f, s)| (f - s / length).abs() < 1e-6),
                    "{place:?}"
                );
            }
        }
    }
}
