//! `verify --error-raster`: the signed error of every sample as a raster.

use std::fs;

use gdal::Dataset;

use crate::util::{Dem, Folder, Kind, flat, hills, terrabite};

/// Vertices and triangles of an ASCII PLY.
fn ascii_mesh(tin: &str) -> (Vec<[f64; 3]>, Vec<[usize; 3]>) {
    let text = fs::read_to_string(tin).unwrap();
    let count = |what: &str| -> usize {
        let line = text.lines().find_map(|line| line.strip_prefix(&format!("element {what} "))).unwrap();
        line.parse().unwrap()
    };
    let (vertices, faces) = (count("vertex"), count("face"));
    let mut lines = text.lines().skip_while(|line| *line != "end_header").skip(1);
    let numbers = |line: &str| -> Vec<f64> { line.split(' ').map(|word| word.parse().unwrap()).collect() };
    let places = lines.by_ref().take(vertices).map(|line| numbers(line)[..3].try_into().unwrap()).collect();
    let corners = |line: &str| numbers(line)[1..4].iter().map(|n| *n as usize).collect::<Vec<_>>().try_into().unwrap();
    (places, lines.take(faces).map(corners).collect())
}

/// The height of the surface at a place, by looking at all triangles; none where none has it.
fn surface((vertices, faces): &(Vec<[f64; 3]>, Vec<[usize; 3]>), x: f64, y: f64) -> Option<f64> {
    faces.iter().find_map(|face| {
        let [a, b, c] = face.map(|vertex| vertices[vertex]);
        let turn = |p: [f64; 3], q: [f64; 3]| (q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0]);
        let weights = [turn(b, c), turn(c, a), turn(a, b)];
        let area: f64 = weights.iter().sum();
        let inside = weights.iter().all(|w| w / area >= 0.0);
        inside.then(|| (weights[0] * a[2] + weights[1] * b[2] + weights[2] * c[2]) / area)
    })
}

fn with_gaps(column: usize, row: usize) -> f64 {
    let is_missing = (20..26).contains(&column) && (10..18).contains(&row) || (column, row) == (50, 40);
    if is_missing { -9999.0 } else { hills(column, row) }
}

#[test]
fn every_sample_has_the_height_of_the_surface_less_its_own() {
    let folder = Folder::new();
    let dem = Dem::new(300, 70).kind(Kind::Float64).nodata(-9999.0).heights(with_gaps).on_the_map();
    let (dem, tin) = (dem.write(&folder, "dem.tif"), folder.at("tin.ply"));
    terrabite(["simplify", &dem, &tin, "--max-error", "4.1", "--ascii", "--tile", "32"]).succeeds();
    let written = |threads: &str| {
        let out = folder.at(&format!("e{threads}.tif"));
        let run = ["verify", &dem, &tin, "--max-error", "4.1", "--error-raster", &out, "--json", "--threads", threads];
        let verdict = terrabite(run).succeeds().json();
        (out, verdict)
    };
    let (out, verdict) = written("1");
    for threads in ["2", "5"] {
        assert!(fs::read(&out).unwrap() == fs::read(written(threads).0).unwrap(), "{threads} threads");
    }
    let names = folder.names();
    assert_eq!(names, ["dem.tif", "e1.tif", "e2.tif", "e5.tif", "tin.ply"], "nothing else is left");

    let (raster, errors) = (Dataset::open(&dem).unwrap(), Dataset::open(&out).unwrap());
    assert_eq!(errors.geo_transform().unwrap(), raster.geo_transform().unwrap());
    assert_eq!(errors.spatial_ref().unwrap().auth_code().unwrap(), 32633);
    let band = errors.rasterband(1).unwrap();
    assert!(band.no_data_value().unwrap().is_nan());
    assert_eq!((band.block_size(), band.size()), ((256, 256), (300, 70)));
    let found = band.read_as::<f32>((0, 0), (300, 70), (300, 70), None).unwrap();

    let mesh = ascii_mesh(&tin);
    let [x0, dx, _, y0, _, dy] = raster.geo_transform().unwrap();
    let (mut largest, mut squares, mut measured) = (0.0f64, 0.0, 0);
    for (at, error) in found.data().iter().map(|e| f64::from(*e)).enumerate() {
        let (column, row) = (at % 300, at / 300);
        let height = with_gaps(column, row);
        let (x, y) = (x0 + (column as f64 + 0.5) * dx, y0 + (row as f64 + 0.5) * dy);
        match surface(&mesh, x, y).filter(|_| height != -9999.0) {
            Some(surface) => {
                assert!((error - (surface - height)).abs() < 1e-5, "{column}, {row}: {error}");
                (largest, squares, measured) = (largest.max(error.abs()), squares + error * error, measured + 1);
            }
            None => assert!(error.is_nan(), "{column}, {row}: {error}"),
        }
    }
    assert_eq!(verdict["samples"].as_u64(), Some(measured));
    assert!(largest <= 4.1 && largest > 3.0, "{largest}");
    assert!((largest - verdict["worst"]["error"].as_f64().unwrap()).abs() < 1e-6);
    assert!(((squares / measured as f64).sqrt() - verdict["rms_error"].as_f64().unwrap()).abs() < 1e-6);
}

#[test]
fn a_window_has_its_own_corner_and_a_mesh_that_fails_its_own_errors() {
    let folder = Folder::new();
    let dem = Dem::new(40, 30).on_the_map().heights(|c, r| if (c, r) == (12, 9) { 7.0 } else { 0.0 });
    let (dem, tin, out) = (dem.write(&folder, "dem.tif"), folder.at("tin.ply"), folder.at("e.tif"));
    let window = ["--window", "10,5,20,20"];
    terrabite(["simplify", &dem, &tin, "--max-error", "8"].iter().chain(&window)).succeeds();
    let judge = ["verify", &dem, &tin, "--max-error", "0.5", "--error-raster", &out];
    assert_eq!(terrabite(judge.iter().chain(&window)).code, Some(1));
    let errors = Dataset::open(&out).unwrap();
    assert_eq!(errors.raster_size(), (20, 20));
    assert_eq!(errors.geo_transform().unwrap(), [500_100.0, 10.0, 0.0, 5_199_950.0, 0.0, -10.0]);
    let at = |place| errors.rasterband(1).unwrap().read_as::<f32>(place, (1, 1), (1, 1), None).unwrap().data()[0];
    assert_eq!((at((2, 4)), at((3, 4))), (-7.0, 0.0), "the mesh is too low by 7 there");
}

#[test]
fn what_is_read_is_never_replaced() {
    let folder = Folder::new();
    let dem = Dem::new(9, 9).heights(|_, _| 0.0).write(&folder, "dem.tif");
    let tin = folder.with("tin.ply", flat(9, 9, 0.0));
    let judge = |out: &str, more: &[&str]| {
        let run = ["verify", &dem, &tin, "--max-error", "1", "--error-raster", out];
        terrabite(run.iter().chain(more))
    };
    for input in [&dem, &tin] {
        let before = fs::read(input).unwrap();
        for more in [&[][..], &["--overwrite"]] {
            judge(input, more).fails(1, &[input.as_str(), "input"]);
        }
        assert!(fs::read(input).unwrap() == before);
    }
    let out = folder.with("e.tif", "mine");
    judge(&out, &[]).fails(1, &["e.tif", "--overwrite"]);
    assert_eq!(fs::read(&out).unwrap(), b"mine");
    judge(&out, &["--overwrite"]).succeeds();
    assert_eq!(Dataset::open(&out).unwrap().raster_size(), (9, 9));
    judge(&folder.at("none/e.tif"), &[]).fails(1, &["none"]);
    // A mesh that cannot be read leaves nothing.
    let broken = folder.with("broken.ply", "ply\nformat");
    let run = terrabite(["verify", &dem, &broken, "--max-error", "1", "--error-raster", &folder.at("f.tif")]);
    run.fails(1, &["broken.ply"]);
    assert_eq!(folder.names(), ["broken.ply", "dem.tif", "e.tif", "tin.ply"]);
}
