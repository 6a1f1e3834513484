//! The same verdict, whatever the threads and wherever bands of rows end.

use super::ground::{PATTERNS, scene};
use super::scene::{Mesh, SOUTH_UP, Scene, judge_file, write_raster};
use crate::base::{Cutline, Polygon};
use crate::verify::{GroundOptions, Verdict, VerifyOptions};

/// What a scene is judged with.
#[derive(Default)]
struct Setting {
    max_error: f64,
    max_stray: Option<f64>,
    ground: GroundOptions,
    weights: Option<Vec<f64>>,
    cutline: Option<Cutline>,
}

/// The verdict of one thread and one band, which other threads and bands must give, too.
fn same_verdict(scene: &Scene, setting: Setting) -> Verdict {
    let Setting { max_error, max_stray, ground, weights, cutline } = setting;
    let pools = [1, 2, 5].map(|threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap());
    let other = tempfile::tempdir().unwrap();
    let size = (scene.width, scene.height);
    let weights = weights.map(|weights| crate::testing::band(&write_raster(&other, size, &weights, |_| {}), 1));
    let judged = scene.compare(&scene.mesh_ply(), |raster, mesh, temp_dir| {
        let raster = match &cutline {
            Some(cutline) => raster.clone().with_cutline(cutline.clone()),
            None => raster.clone(),
        };
        let options =
            VerifyOptions { lines: None, max_error, max_stray, importance: weights.as_ref(), temp_dir: Some(temp_dir) };
        let judge = |rows| judge_file(&raster, mesh, &options, ground, Some(rows)).unwrap();
        let verdict = pools[0].install(|| judge(scene.height));
        let text = serde_json::to_string(&verdict).unwrap();
        for (pool, rows) in pools.iter().flat_map(|pool| (1..=scene.height).map(move |rows| (pool, rows))) {
            let other = serde_json::to_string(&pool.install(|| judge(rows))).unwrap();
            assert_eq!(other, text, "{} threads, bands of {rows} rows", pool.current_num_threads());
        }
        Ok(verdict)
    });
    judged.unwrap()
}

/// A relief that no few triangles follow, under triangles of all sizes: rows of samples as long as several vectors.
fn relief() -> Scene {
    let (width, height) = (61, 23);
    let relief = |column: usize, row: usize| ((column * column + 3 * row * column) % 17) as f64 / 8.0;
    let samples: Vec<f64> = (0..width * height).map(|i| relief(i % width, i / width)).collect();
    let mut mesh = Mesh::rectangle(width, height);
    for i in 0..60i64 {
        let place = (i * 37 % (4 * width as i64 - 3), i * i * 11 % (4 * height as i64 - 3));
        mesh.insert(place, relief(place.0 as usize / 4, place.1 as usize / 4));
    }
    Scene { width, height, transform: SOUTH_UP, samples, mesh }
}

#[test]
fn whole_rasters_and_weighted_ones() {
    let scene = relief();
    let far = same_verdict(&scene, Setting { max_error: 9.0, ..Setting::default() });
    assert!(far.passes() && far.rms_error > 0.0, "{far}");
    let near = same_verdict(&scene, Setting { max_error: 0.7, ..Setting::default() });
    assert!(near.above_tolerance.count > 100, "{near}");
    assert_eq!((near.worst, near.rms_error), (far.worst, far.rms_error));
    let weights = (0..scene.samples.len()).map(|i| (i % 5) as f64 / 4.0).collect();
    let setting = Setting { max_error: 0.7, weights: Some(weights), ..Setting::default() };
    assert!(same_verdict(&scene, setting).above_tolerance.count > 0);
}

#[test]
fn straying_is_the_same() {
    let scene = relief();
    let setting = || Setting { max_error: 0.6, max_stray: Some(1.0), ..Setting::default() };
    let stray = same_verdict(&scene, setting()).stray.unwrap();
    assert!(stray.beyond.count > 100 && stray.worst.unwrap().stray > 0.6, "{stray:?}");
    let weights: Vec<f64> = (0..scene.samples.len()).map(|i| (i % 5) as f64 / 4.0).collect();
    let weighted = same_verdict(&scene, Setting { weights: Some(weights), ..setting() }).stray.unwrap();
    assert!((1..stray.beyond.count).contains(&weighted.beyond.count), "{weighted:?}");
    let mut scene = scene;
    (0..scene.samples.len()).step_by(7).for_each(|i| scene.samples[i] = f64::NAN);
    let ground = GroundOptions { fill_holes: 1, trim: 1 };
    assert!(same_verdict(&scene, Setting { ground, ..setting() }).stray.unwrap().beyond.count > 0);
}

#[test]
fn gaps_trimmed_rims_and_filled_holes() {
    for (name, rows, _) in PATTERNS {
        assert!(same_verdict(&scene(rows), Setting::default()).passes(), "{name}");
        let ground = GroundOptions { fill_holes: 3, trim: 1 };
        same_verdict(&scene(rows), Setting { ground, ..Setting::default() });
    }
}

#[test]
fn meshes_over_what_a_cutline_leaves_out() {
    let mut polygon = Polygon::default();
    polygon.add_ring(&[(3.5, 2.5), (50.5, 4.5), (40.5, 20.5), (20.5, 10.5), (5.5, 19.5)]);
    let cutline = Some(Cutline::new(vec![polygon]));
    let verdict = same_verdict(&relief(), Setting { max_error: 9.0, cutline, ..Setting::default() });
    assert!(verdict.touched_nodata.count > 100 && verdict.boundary_gaps.count > 0, "{verdict}");
}

#[test]
fn meshes_with_every_fault() {
    let faults: [fn(&mut Mesh); 8] = [
        |mesh| {
            mesh.faces.remove(20);
        },
        |mesh| mesh.faces[20].swap(0, 1),
        |mesh| mesh.faces.push(mesh.faces[20]),
        |mesh| mesh.faces.extend([mesh.faces[20]; 4]),
        |mesh| mesh.faces[20][0] = mesh.faces[20][1],
        |mesh| mesh.places[30] = (17, 23),
        |mesh| mesh.places[2] = (400, 90),
        |mesh| mesh.heights[30] = f64::NAN,
    ];
    for fault in faults {
        let mut scene = relief();
        fault(&mut scene.mesh);
        scene.mesh.places.extend([(8, 8), scene.mesh.places[5]]);
        scene.mesh.heights.extend([0.0; 2]);
        let verdict = same_verdict(&scene, Setting { max_error: 9.0, max_stray: Some(2.0), ..Setting::default() });
        assert!(verdict.failures().len() > 2, "{verdict}");
        assert_eq!((verdict.unused_vertices.count, verdict.duplicate_vertices.count > 0), (2, true), "{verdict}");
    }
}
