//! Fuzzing: meshes of every format, judged.

use std::path::Path;
use std::sync::OnceLock;

use gdal::DriverManager;
use gdal::raster::Buffer;

use super::naive::{self, Ground, Surface};
use super::temp_dir;
use crate::base::Band;
use crate::base::control::Control;
use crate::formats::{self, ReadError, ReadOptions};
use crate::raster::{Raster, quiet_gdal};
use crate::run::{ConvertRequest, convert};
use crate::verify::{VerifyOptions, verify};

pub(super) const SIDE: usize = 5;
pub(super) const TOLERANCE: f64 = 1.0;

/// Heights on no plane around a hole of one sample.
pub(super) fn heights() -> Vec<f64> {
    (0..SIDE * SIDE).map(|i| if i == SIDE * SIDE / 2 { f64::NAN } else { (i * i % 7) as f64 }).collect()
}

/// The raster that meshes are held against, made once a process, in memory.
fn raster() -> Band {
    static MADE: OnceLock<()> = OnceLock::new();
    let path = Path::new("/vsimem/terrabite-fuzzing.tif");
    MADE.get_or_init(|| {
        quiet_gdal();
        let driver = DriverManager::get_driver_by_name("GTiff").expect("GTiff");
        let dataset = driver.create_with_band_type::<f64, _>(path, SIDE, SIDE, 1).expect("a raster");
        let mut samples = Buffer::new((SIDE, SIDE), heights());
        dataset.rasterband(1).expect("a band").write((0, 0), (SIDE, SIDE), &mut samples).expect("written");
        dataset.close().expect("closed");
    });
    Raster::open(path, 1).and_then(|raster| raster.to_band()).expect("opens")
}

/// A file of any bytes, read as a mesh of the format with this name, is judged, or refused; and what passes is within the
/// tolerance of every sample and covers the ground. Attributes are read as well, and what is read is converted to PLY.
///
/// # Panics
/// If there is no such format, or a promise is broken.
pub fn mesh(format: &str, bytes: &[u8]) {
    let format = formats::by_name(format).expect("a format");
    let folder = tempfile::tempdir_in(temp_dir()).expect("a folder");
    let path = folder.path().join("mesh").with_extension(format.extensions[0]);
    std::fs::write(&path, bytes).expect("written");
    read_all(&path, folder.path());
    let options = VerifyOptions {
        lines: None,
        max_error: TOLERANCE,
        max_stray: None,
        importance: None,
        temp_dir: Some(folder.path().to_path_buf()),
    };
    let Ok(verdict) = verify(&raster(), &path, &options, &Control::default()) else {
        return;
    };
    assert!(!verdict.to_string().is_empty());
    if !verdict.passes() {
        return;
    }
    let mut mesh = formats::open(&path, None, &ReadOptions::default()).expect("a mesh");
    let frame = mesh.header().frame;
    let mut surface = Surface::default();
    mesh.for_each_vertex(|_, [x, y, z]| {
        let (sx, sy) = frame.xy_scale;
        surface.places.push(naive::place(x / sx + frame.origin.0, y / sy + frame.origin.1));
        surface.heights.push(z / frame.z_scale);
        Ok::<(), ReadError>(())
    })
    .expect("vertices");
    mesh.for_each_face(|_, face| {
        surface.faces.push(face.map(|v| v as usize));
        Ok::<(), ReadError>(())
    })
    .expect("faces");
    let heights = heights();
    let ground = Ground::new((SIDE, SIDE), &heights, &[]);
    ground.check(&surface, TOLERANCE).unwrap_or_else(|wrong| panic!("it passes, but {wrong}: {verdict}"));
}

/// Indices are in range, passes say the same again, and a conversion ends.
fn read_all(path: &Path, folder: &Path) {
    let options = ReadOptions { temp_dir: Some(folder.to_path_buf()), ..ReadOptions::default() };
    let Ok(mut mesh) = formats::open(path, None, &options) else { return };
    let names: Vec<String> = mesh.attributes().iter().map(|attribute| attribute.name.clone()).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let (vertices, faces, edges) = (mesh.vertex_count(), mesh.face_count(), mesh.edge_count());
    for _ in 0..2 {
        let mut found = 0;
        let all = mesh.for_each_vertex_with(&names, |index, _, values| {
            assert_eq!((index, values.len()), (found, names.len()));
            found += 1;
            Ok::<(), ReadError>(())
        });
        assert!(all.is_err() || found == vertices, "{found} of {vertices} vertices");
        let mut found = 0;
        let all = mesh.for_each_face(|index, face| {
            assert!(index == found && face.iter().all(|vertex| *vertex < vertices), "{face:?}");
            found += 1;
            Ok::<(), ReadError>(())
        });
        assert!(all.is_err() || found == faces, "{found} of {faces} faces");
        let mut found = 0;
        let all = mesh.for_each_edge(|index, edge| {
            assert!(index == found && edge.ends.iter().all(|vertex| *vertex < vertices), "{edge:?}");
            found += 1;
            Ok::<(), ReadError>(())
        });
        assert!(all.is_err() || found == edges, "{found} of {edges} edges");
    }
    let request = ConvertRequest { temp_dir: options.temp_dir, ..ConvertRequest::new(path, folder.join("out.ply")) };
    if convert(&request, &Control::default()).is_ok() {
        formats::open(&folder.join("out.ply"), None, &ReadOptions::default()).expect("what was written");
    }
}
