//! What sinks ask for: bounds of vertices, corners of triangles.

use std::sync::{Arc, Mutex};

use crate::base::control::Control;
use crate::base::{GeoTransform, Heights};
use crate::field::Field;
use crate::formats::{Bounds, Contents, Needs, Sink, SinkError};
use crate::job::{Mesh, Params, Quality, triangulate};
use crate::testing::in_memory;

#[derive(Default)]
struct Seen {
    bounds: Option<Bounds>,
    vertices: Vec<[f64; 3]>,
    triangles: Vec<[u64; 3]>,
    corners: Vec<[[f64; 3]; 3]>,
}

struct Asking(Needs, Arc<Mutex<Seen>>);

impl Sink for Asking {
    fn needs(&self) -> Needs {
        self.0
    }
    fn begin(&mut self, contents: &Contents<'_>) -> Result<(), SinkError> {
        self.1.lock().expect("whole").bounds = contents.bounds;
        Ok(())
    }
    fn vertices(&mut self, vertices: &[[f64; 3]], _: &[&[f64]]) -> Result<(), SinkError> {
        self.1.lock().expect("whole").vertices.extend_from_slice(vertices);
        Ok(())
    }
    fn triangles(&mut self, triangles: &[[u64; 3]], corners: &[[[f64; 3]; 3]]) -> Result<(), SinkError> {
        assert_eq!(corners.len(), if self.0.corners { triangles.len() } else { 0 });
        let mut seen = self.1.lock().expect("whole");
        seen.triangles.extend_from_slice(triangles);
        seen.corners.extend_from_slice(corners);
        Ok(())
    }
    fn finish(self: Box<Self>) -> Result<(), SinkError> {
        Ok(())
    }
}

fn seen(mesh: &Mesh, bounds: bool, corners: bool) -> Seen {
    let seen = Arc::new(Mutex::new(Seen::default()));
    mesh.write(Box::new(Asking(Needs { bounds, corners, ..Needs::default() }, seen.clone())), &Control::default())
        .expect("written");
    std::mem::take(&mut *seen.lock().expect("whole"))
}

#[test]
fn corners_are_the_vertices_and_bounds_are_those_of_all() {
    let (width, height) = (90, 70);
    let hill = |i: usize| {
        let (x, y) = ((i % width) as f64, (i / width) as f64);
        if (x - 50.0).hypot(y - 30.0) < 6.0 {
            f64::NAN
        } else {
            (x / 7.0).sin() * 30.0 + (y / 5.0).cos() * 20.0 + x * y / 100.0
        }
    };
    for (quality, tile) in [(Quality::None, 16), (Quality::Fast, 16), (Quality::Balanced, 32), (Quality::None, 0)] {
        for turn in [-1.0, 1.0] {
            let field = Field::from_heights(width, height, Heights::F64((0..width * height).map(hill).collect()));
            let map = GeoTransform::new([500.0, 2.0, 0.25, 900.0, -0.5, turn * 2.0], width, height).expect("a map");
            let field = field.expect("a field").with_geo_transform(map);
            let params = in_memory(&Params { quality, tile, ..Params::new(1.5) });
            let mesh = triangulate(&field, &params, &Control::default()).expect("a mesh");
            let Seen { bounds, vertices, triangles, corners } = seen(&mesh, true, true);
            assert!(triangles.len() > 50);
            let expected: Vec<[[f64; 3]; 3]> = triangles.iter().map(|t| t.map(|v| vertices[v as usize])).collect();
            assert_eq!(corners, expected, "{quality:?} {tile}");
            let least = |i: usize| vertices.iter().map(|v| v[i]).fold(f64::INFINITY, f64::min);
            let most = |i: usize| vertices.iter().map(|v| v[i]).fold(f64::NEG_INFINITY, f64::max);
            assert_eq!(bounds, Some(Bounds { min: [0, 1, 2].map(least), max: [0, 1, 2].map(most) }));
            let plain = seen(&mesh, false, false);
            assert_eq!((plain.bounds, plain.vertices, plain.triangles), (None, vertices, triangles));
        }
    }
}
