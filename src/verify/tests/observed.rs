//! What observers are told, whatever the threads and bands.

use std::error::Error;
use std::sync::Mutex;

use super::scene::{Mesh, NORTH_UP, Scene};
use crate::base::control::Control;
use crate::verify::{GroundOptions, ObservedRows, Observer, RowObserver, VerifyOptions, judge, open};

/// Heights and errors of rows, and the heights above.
type Noted = (usize, Vec<f64>, Vec<f32>, Vec<f64>);

fn noted(rows: &ObservedRows<'_>) -> Noted {
    (rows.first_row, rows.heights.to_vec(), rows.errors.to_vec(), rows.above.to_vec())
}

#[derive(Default)]
struct OfRows(Mutex<Vec<Noted>>);

struct Watcher {
    of_rows: OfRows,
    rows: Vec<Noted>,
    needs_errors: bool,
}

impl RowObserver for OfRows {
    fn rows(&self, rows: &ObservedRows<'_>) {
        self.0.lock().unwrap().push(noted(rows));
    }
}

impl Observer for Watcher {
    fn face(&mut self, _: [(i64, i64); 3], _: [f64; 3]) {}

    fn row_observer(&self) -> Option<&dyn RowObserver> {
        Some(&self.of_rows)
    }

    fn needs_errors(&self) -> bool {
        self.needs_errors
    }

    fn rows(&mut self, rows: &ObservedRows<'_>) -> Result<(), Box<dyn Error + Send + Sync>> {
        self.rows.push(noted(rows));
        Ok(())
    }
}

/// More triangles than are held at a time, every sample with a height a vertex that is off.
fn dense() -> Scene {
    let (width, height) = (110, 90);
    let sample = |i: usize| if i % 83 == 5 { f64::NAN } else { (i * i % 64) as f64 / 4.0 };
    let samples: Vec<f64> = (0..width * height).map(sample).collect();
    let mut mesh = Mesh::of_cells(width, &samples, || true);
    assert!(mesh.faces.len() > 16 << 10);
    mesh.heights.iter_mut().enumerate().for_each(|(i, height)| *height += (i % 9) as f64 / 8.0 - 0.5);
    Scene { width, height, transform: NORTH_UP, samples, mesh }
}

#[test]
fn each_row_is_told_once_with_its_errors() {
    let scene = dense();
    let mut errors = vec![f32::NAN; scene.samples.len()];
    for (&(x, y), height) in scene.mesh.places.iter().zip(&scene.mesh.heights) {
        let at = y as usize / 4 * scene.width + x as usize / 4;
        errors[at] = (height - scene.samples[at]) as f32;
    }
    let check = |noted: &[Noted]| {
        let mut row = 0;
        for (first_row, heights, found, above) in noted {
            assert_eq!(*first_row, row);
            let start = row * scene.width;
            let samples = start..start + heights.len();
            let same = |found: &[f64], expected: &[f64]| {
                assert_eq!(found.len(), expected.len());
                assert!(found.iter().zip(expected).all(|(a, b)| a == b || a.is_nan() && b.is_nan()));
            };
            same(heights, &scene.samples[samples.clone()]);
            same(above, &scene.samples[start.saturating_sub(scene.width)..start]);
            for (found, expected) in found.iter().zip(&errors[samples]) {
                assert!(found.is_nan() && expected.is_nan() || (found - expected).abs() < 1e-5, "{found} {expected}");
            }
            row += heights.len() / scene.width;
        }
        assert_eq!(row, scene.height);
    };
    for (threads, band_rows, needs_errors) in [(1, 90, false), (3, 90, true), (3, 7, false), (2, 31, true)] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut watcher = Watcher { of_rows: OfRows::default(), rows: Vec::new(), needs_errors };
        let verdict = scene.compare(&scene.mesh_ply(), |raster, mesh, temp_dir| {
            let options = VerifyOptions {
                lines: None,
                max_error: 1.0,
                max_stray: None,
                importance: None,
                temp_dir: Some(temp_dir),
            };
            let mut mesh = open(raster, mesh, &options, &Control::default())?;
            let watching: (Option<usize>, Option<&mut dyn Observer>) = (Some(band_rows), Some(&mut watcher));
            let ground = GroundOptions::default();
            pool.install(|| judge(raster, mesh.as_mut(), &options, ground, None, watching, &Control::default()))
        });
        assert_eq!(verdict.unwrap().above_tolerance.count, 0);
        let mut of_rows = watcher.of_rows.0.into_inner().unwrap();
        of_rows.sort_by_key(|(row, ..)| *row);
        assert!(of_rows.iter().all(|(_, heights, errors, _)| heights.len() == errors.len()));
        check(&of_rows);
        if needs_errors {
            assert!(watcher.rows.iter().all(|(_, heights, errors, _)| heights.len() == errors.len()));
        }
        check(&watcher.rows);
    }
}
