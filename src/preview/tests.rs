//! Pictures: what is drawn where.

use std::path::{Path, PathBuf};

use super::colours::{EXCEEDED, NO_GROUND, UNCOVERED};
use super::*;
use crate::base::RasterError;
use crate::base::control::{CancelToken, Control};
use crate::base::staged::OutputError;
use crate::base::{GeoTransform, Window};
use crate::raster::{Part, View, ViewError};
use crate::synth::{StoredAs, SynthOptions, Terrain, TerrainOptions, synth};

pub(super) const WIDTH: usize = 161;
pub(super) const HEIGHT: usize = 121;

fn of_window(window: Window) -> View {
    View { part: Part::Window(window), ..View::default() }
}

/// A raster of synthetic ground, and regular meshes over it.
pub(super) struct Scene {
    folder: tempfile::TempDir,
    pub(super) heights: Vec<f64>,
}

pub(super) type Face = [u32; 3];

impl Scene {
    pub(super) fn new(terrain: TerrainOptions) -> Scene {
        let folder = tempfile::tempdir().expect("a folder");
        let options = SynthOptions {
            width: WIDTH,
            height: HEIGHT,
            terrain,
            stored_as: StoredAs::Float64,
            ..SynthOptions::default()
        };
        synth(&folder.path().join("raster.tif"), &options, &Control::default()).expect("a raster");
        let mut heights = vec![0.0; WIDTH * HEIGHT];
        let whole = Window { column: 0, row: 0, width: WIDTH, height: HEIGHT };
        Terrain::new(&terrain).expect("options").fill(whole, &mut heights);
        Scene { folder, heights }
    }

    pub(super) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Every sample is a vertex; faces span `step` cells, two to a square. Binary little-endian doubles.
    pub(super) fn mesh(&self, name: &str, faces: impl Iterator<Item = Face>) -> PathBuf {
        let transform = GeoTransform::new([300_000.0, 10.0, 0.0, 5_400_000.0, 0.0, -10.0], WIDTH, HEIGHT).expect("map");
        let mut body = Vec::new();
        for (k, height) in self.heights.iter().enumerate() {
            let (x, y) = transform.apply(4 * (k % WIDTH) as i64, 4 * (k / WIDTH) as i64);
            [x, y, *height].iter().for_each(|v| body.extend(v.to_le_bytes()));
        }
        let mut count = 0;
        for face in faces {
            body.push(3);
            face.iter().for_each(|i| body.extend(i.to_le_bytes()));
            count += 1;
        }
        let vertices = self.heights.len();
        let mut file = format!(
            "ply\nformat binary_little_endian 1.0\nelement vertex {vertices}\nproperty double x\nproperty double y\n\
             property double z\nelement face {count}\nproperty list uchar uint vertex_indices\nend_header\n"
        )
        .into_bytes();
        file.extend(body);
        let path = self.path(name);
        std::fs::write(&path, file).expect("a mesh");
        path
    }

    fn draw(&self, mesh: &Path, name: &str, options: &PreviewOptions) -> Result<PreviewReport, PreviewError> {
        preview(&self.path("raster.tif"), mesh, &self.path(name), options, &Control::default())
    }
}

pub(super) fn grid(step: usize) -> impl Iterator<Item = Face> + Clone {
    let squares = (0..HEIGHT - 1).step_by(step).flat_map(move |r| (0..WIDTH - 1).step_by(step).map(move |c| (r, c)));
    squares.flat_map(move |(r, c)| {
        let at = |down: usize, right: usize| ((r + down) * WIDTH + c + right) as u32;
        [[at(0, 0), at(step, 0), at(0, step)], [at(0, step), at(step, 0), at(step, step)]]
    })
}

fn errors() -> PreviewOptions {
    PreviewOptions { mode: Mode::Error, size: (320, 240), ..PreviewOptions::default() }
}

/// Width, height and pixels, by the decoder.
fn pixels(path: &Path) -> (usize, usize, Vec<[u8; 3]>) {
    let file = std::io::BufReader::new(std::fs::File::open(path).expect("a picture"));
    let mut reader = png::Decoder::new(file).read_info().expect("a PNG");
    let mut bytes = vec![0; reader.output_buffer_size().expect("a size")];
    let info = reader.next_frame(&mut bytes).expect("pixels");
    (info.width as usize, info.height as usize, bytes.as_chunks::<3>().0.to_vec())
}

#[test]
fn a_mesh_through_every_sample_has_no_error() {
    let scene = Scene::new(TerrainOptions::default());
    let mesh = scene.mesh("mesh.ply", grid(1));
    let report = scene.draw(&mesh, "out.png", &PreviewOptions { max_error: Some(0.5), ..errors() }).expect("drawn");
    assert_eq!(report.triangles, 2 * (WIDTH as u64 - 1) * (HEIGHT as u64 - 1));
    assert!(report.largest_error.expect("errors") < 1e-9, "{report:?}");
    let (width, height, found) = pixels(&scene.path("out.png"));
    assert_eq!((width, height), (report.width, report.height));
    assert_eq!(
        found.iter().filter(|p| [EXCEEDED, UNCOVERED].contains(p)).count(),
        2 * 12 * 12,
        "the legend's two marks"
    );
}

#[test]
fn errors_are_those_of_the_definition() {
    const STEP: usize = 8;
    let scene = Scene::new(TerrainOptions::default());
    let mut expected = 0.0f64;
    for (k, found) in scene.heights.iter().enumerate() {
        let (column, row) = (k % WIDTH, k / WIDTH);
        let (c, r) = ((column / STEP * STEP).min(WIDTH - 1 - STEP), (row / STEP * STEP).min(HEIGHT - 1 - STEP));
        let (u, v) = ((column - c) as f64 / STEP as f64, (row - r) as f64 / STEP as f64);
        let h = |down: usize, right: usize| scene.heights[(r + down * STEP) * WIDTH + c + right * STEP];
        let surface = if u + v <= 1.0 {
            h(0, 0) + u * (h(0, 1) - h(0, 0)) + v * (h(1, 0) - h(0, 0))
        } else {
            h(1, 1) + (1.0 - u) * (h(1, 0) - h(1, 1)) + (1.0 - v) * (h(0, 1) - h(1, 1))
        };
        expected = expected.max((surface - found).abs());
    }
    let mesh = scene.mesh("mesh.ply", grid(STEP));
    let found = scene.draw(&mesh, "out.png", &errors()).expect("drawn").largest_error.expect("errors");
    assert!((found - expected).abs() < 1e-9, "{found}, expected {expected}");
}

#[test]
fn the_order_of_faces_does_not_show_in_errors() {
    let scene = Scene::new(TerrainOptions::default());
    let mut faces: Vec<Face> = grid(4).collect();
    let one = scene.mesh("one.ply", faces.clone().into_iter());
    faces.reverse();
    faces.iter_mut().for_each(|f| f.rotate_left(1));
    let other = scene.mesh("other.ply", faces.into_iter());
    let options = PreviewOptions { view: of_window(Window { column: 33, row: 17, width: 50, height: 60 }), ..errors() };
    scene.draw(&one, "one.png", &options).expect("drawn");
    scene.draw(&other, "other.png", &options).expect("drawn");
    assert!(pixels(&scene.path("one.png")) == pixels(&scene.path("other.png")));
}

#[test]
fn nodata_and_bare_ground_are_told_apart() {
    let scene = Scene::new(TerrainOptions { seed: 11, nodata_share: 0.4, ..TerrainOptions::default() });
    let gaps = scene.heights.iter().filter(|h| h.is_nan()).count();
    assert!(gaps > 500 && gaps < WIDTH * HEIGHT - 500, "{gaps} gaps: another seed is needed");
    let valid = |f: &Face| f.iter().all(|&i| !scene.heights[i as usize].is_nan());
    let mesh = scene.mesh("mesh.ply", grid(1).filter(valid).take(4000));
    scene.draw(&mesh, "out.png", &PreviewOptions { size: (160, 120), ..errors() }).expect("drawn");
    let (width, _, found) = pixels(&scene.path("out.png"));
    let map: Vec<_> = (0..120).flat_map(|y| &found[y * width..y * width + 160]).collect();
    let count = |colour| map.iter().filter(|p| ***p == colour).count() as f64 / map.len() as f64;
    let share = gaps as f64 / (WIDTH * HEIGHT) as f64;
    assert!((count(NO_GROUND) - share).abs() < 0.03, "{} of the map is nodata, expected {share}", count(NO_GROUND));
    assert!(count(UNCOVERED) > 0.05);
}

#[test]
fn a_plane_is_one_colour_without_seams() {
    let mut scene = Scene::new(TerrainOptions::default());
    scene.heights.iter_mut().enumerate().for_each(|(k, h)| *h = 2.0 * (k % WIDTH) as f64 - (k / WIDTH) as f64);
    let mesh = scene.mesh("mesh.ply", grid(5));
    let options = PreviewOptions { size: (333, 777), ..PreviewOptions::default() };
    let report = scene.draw(&mesh, "out.png", &options).expect("drawn");
    assert_eq!((report.width, report.height), (333, 250), "the window's proportions");
    let (_, _, found) = pixels(&scene.path("out.png"));
    assert!(found.iter().all(|p| *p == found[0]), "{:?}", found[0]);
}

#[test]
fn every_mode_draws() {
    let scene = Scene::new(TerrainOptions::default());
    let mesh = scene.mesh("mesh.ply", grid(10));
    let mut pictures = Vec::new();
    for mode in [Mode::Hillshade, Mode::Wireframe, Mode::Error, Mode::SideBySide] {
        let options = PreviewOptions { mode, overwrite: true, size: (200, 200), ..PreviewOptions::default() };
        scene.draw(&mesh, "out.png", &options).expect("drawn");
        pictures.push(std::fs::read(scene.path("out.png")).expect("a picture"));
    }
    pictures.dedup();
    assert_eq!(pictures.len(), 4);
}

#[test]
fn what_cannot_be_drawn_is_refused_and_leaves_nothing() {
    let scene = Scene::new(TerrainOptions::default());
    let mesh = scene.mesh("mesh.ply", grid(10));
    let refused = |options: PreviewOptions| scene.draw(&mesh, "out.png", &options).expect_err("refused");
    let window = |column, width| Window { column, row: 0, width, height: 10 };
    for window in [window(0, WIDTH + 1), window(WIDTH, 2), window(usize::MAX, 2), window(0, 1)] {
        let found = refused(PreviewOptions { view: of_window(window), ..errors() });
        assert!(matches!(found, PreviewError::View(ViewError::Raster(RasterError::Window { .. }))), "{window:?}");
    }
    let option = |options| match refused(options) {
        PreviewError::Option { option, .. } => option,
        other => panic!("{other}"),
    };
    assert_eq!(option(PreviewOptions { size: (0, 100), ..errors() }), "size");
    assert_eq!(option(PreviewOptions { max_error: Some(f64::NAN), ..errors() }), "max-error");
    assert_eq!(option(PreviewOptions { exaggeration: Some(0.0), ..errors() }), "vertical-exaggeration");
    assert!(matches!(scene.draw(&scene.path("none.ply"), "out.png", &errors()), Err(PreviewError::Mesh(_))));
    let cancel = CancelToken::default();
    cancel.cancel();
    let control = Control { cancel, ..Control::default() };
    let stopped = preview(&scene.path("raster.tif"), &mesh, &scene.path("out.png"), &errors(), &control);
    assert!(matches!(stopped, Err(PreviewError::Cancelled(_))));
    assert_eq!(std::fs::read_dir(scene.folder.path()).expect("a folder").count(), 2, "raster and mesh alone");
    std::fs::write(scene.path("out.png"), "mine").expect("written");
    assert!(matches!(refused(errors()), PreviewError::Output(OutputError::Exists { .. })));
    assert_eq!(std::fs::read(scene.path("out.png")).expect("kept"), b"mine");
}

#[test]
fn numbers_have_four_digits() {
    let found = [0.0, 1.0, 0.5, 27.727_468, 12_345.6, 0.001_234_56, 1e-7, 1234.0].map(super::legend::number);
    assert_eq!(found, ["0", "1", "0.5", "27.73", "12346", "0.001235", "1.000e-7", "1234"]);
}

#[test]
fn colours_are_blended_between_vertices() {
    let scene = Scene::new(TerrainOptions::default());
    let mesh = scene.path("colours.ply");
    // The whole raster in two triangles: black to the left, red to the right.
    let (left, right, top, bottom) = (300_005.0, 301_605.0, 5_399_995.0, 5_398_795.0);
    let corners = [(left, top, 0), (left, bottom, 0), (right, bottom, 255), (right, top, 255)];
    let vertices: String = corners.iter().map(|(x, y, red)| format!("{x} {y} 0 {red} 0 7\n")).collect();
    let header = "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double y\nproperty double z\n\
        property uchar red\nproperty uchar green\nproperty uchar blue\nelement face 2\n\
        property list uchar uint vertex_indices\nend_header\n";
    std::fs::write(&mesh, format!("{header}{vertices}3 0 1 2\n3 0 2 3\n")).expect("a mesh");
    let options = PreviewOptions { mode: Mode::Colour, size: (160, 120), ..PreviewOptions::default() };
    scene.draw(&mesh, "colours.png", &options).expect("a picture");
    let (width, _, found) = pixels(&scene.path("colours.png"));
    for (x, red) in [(0, 1), (80, 128), (159, 254)] {
        assert_eq!(found[60 * width + x], [red, 0, 7], "column {x}");
    }
    let plain = scene.mesh("plain.ply", grid(8));
    let refused = scene.draw(&plain, "none.png", &options).expect_err("no colours");
    assert!(refused.to_string().contains("attribute \"red\""), "{refused}");
}

#[test]
fn gaps_are_background_and_half_cells_are_not() {
    let mut scene = Scene::new(TerrainOptions { seed: 11, nodata_share: 0.4, ..TerrainOptions::default() });
    // The gaps of the raster file; heights in them would be spikes.
    let gap: Vec<bool> = scene.heights.iter().map(|h| h.is_nan()).collect();
    let faces: Vec<Face> = (0..HEIGHT - 1)
        .flat_map(|r| (0..WIDTH - 1).map(move |c| r * WIDTH + c))
        .flat_map(|at| {
            let ring = [at, at + WIDTH, at + WIDTH + 1, at + 1];
            let valid: Vec<u32> = ring.into_iter().filter(|&i| !gap[i]).map(|i| i as u32).collect();
            match valid[..] {
                [a, b, c] => vec![[a, b, c]],
                [a, b, c, d] => vec![[a, b, c], [a, c, d]],
                _ => Vec::new(),
            }
        })
        .collect();
    assert!(faces.len() > 10_000);
    scene.heights.iter_mut().filter(|h| h.is_nan()).for_each(|h| *h = 0.0);
    let mesh = scene.mesh("mesh.ply", faces.into_iter());
    let options = PreviewOptions { mode: Mode::SideBySide, size: (640, 480), ..PreviewOptions::default() };
    scene.draw(&mesh, "out.png", &options).expect("drawn");
    let (width, _, found) = pixels(&scene.path("out.png"));
    let background = |p: [u8; 3]| p == [96, 112, 136];
    let (mut left, mut differ) = (0, 0);
    for (y, x) in (0..480).flat_map(|y| (0..640).map(move |x| (y, x))) {
        let (of_raster, of_mesh) = (found[y * width + x], found[y * width + 640 + 6 + x]);
        left += usize::from(background(of_raster));
        // Edges of triangles are drawn over the background, along coasts.
        differ += usize::from(background(of_raster) != background(of_mesh));
    }
    assert!(left > 10_000 && differ * 10 < left, "{left} pixels are background, {differ} in one picture alone");
}
