//! Enough triangles for several runs, blocks, bands and batches.

use std::io::Write;

use super::scene::{Mesh, write_raster};
use crate::base::control::Control;
use crate::verify::{Verdict, VerifyOptions, verify};

/// A raster of a tilted plane, and one mesh vertex for every `step` samples.
fn plane(dir: &tempfile::TempDir, size: usize, step: usize) -> (std::path::PathBuf, Mesh) {
    let height = |column: usize, row: usize| (3 * column + row) as f64;
    let samples: Vec<f64> = (0..size * size).map(|i| height(i % size, i / size)).collect();
    let raster = write_raster(dir, (size, size), &samples, |_| {});
    let side = (size - 1) / step + 1;
    let mut mesh = Mesh::default();
    for (row, column) in (0..side * side).map(|i| (step * (i / side), step * (i % side))) {
        mesh.places.push((4 * column as i64, 4 * row as i64));
        mesh.heights.push(height(column, row));
    }
    for (row, column) in (0..(side - 1) * (side - 1)).map(|i| (i / (side - 1), i % (side - 1))) {
        let at = |c: usize, r: usize| ((row + r) * side + column + c) as u64;
        mesh.faces.extend([[at(0, 0), at(0, 1), at(1, 1)], [at(0, 0), at(1, 1), at(1, 0)]]);
    }
    (raster, mesh)
}

fn judge(dir: &tempfile::TempDir, raster: &std::path::Path, mesh: &Mesh, size: usize) -> Verdict {
    let path = dir.path().join("mesh.ply");
    let ply = mesh.ply([0.0, 1.0, 0.0, 0.0, 0.0, -1.0], (size, size));
    std::fs::File::create(&path).and_then(|mut f| f.write_all(ply.as_bytes())).unwrap();
    let options = VerifyOptions {
        lines: None,
        max_error: 0.0,
        max_stray: Some(1.0),
        importance: None,
        temp_dir: Some(dir.path().to_path_buf()),
    };
    verify(&crate::testing::band(raster, 1), &path, &options, &Control::default()).unwrap()
}

#[test]
fn a_mesh_larger_than_every_buffer_gives_the_same_verdict_in_any_order_and_with_any_threads() {
    let (size, step) = (2049, 4);
    let dir = tempfile::tempdir().unwrap();
    let (raster, mut mesh) = plane(&dir, size, step);
    let verdict = judge(&dir, &raster, &mesh, size);
    assert!(verdict.passes(), "{verdict}");
    assert_eq!(verdict.triangles, 2 * 512 * 512);
    // Every 1009th face, and around again: few faces share a block with the one before.
    let count = mesh.faces.len();
    // One sample to the right, and 30 above the plane: edges cross sides of cells.
    mesh.places[1000].0 += 4;
    mesh.heights[1000] += 33.0;
    mesh.faces = (0..count).map(|i| mesh.faces[i * 1009 % count]).collect();
    let [one, two, many] = [1, 2, 5].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| judge(&dir, &raster, &mesh, size))
    });
    let text = |verdict| serde_json::to_string(verdict).unwrap();
    assert_eq!((text(&one), text(&two)), (text(&many), text(&many)));
    // In samples, and between them.
    assert_eq!((many.failures().len(), many.worst.unwrap().error), (2, 30.0));
    assert!(many.stray.unwrap().beyond.count > 10, "{many}");
}

#[test]
fn triangles_that_reach_through_every_band_are_carried_along() {
    let size = 2049;
    let dir = tempfile::tempdir().unwrap();
    let (raster, mesh) = plane(&dir, size, size - 1);
    let verdict = judge(&dir, &raster, &mesh, size);
    assert!(verdict.passes(), "{verdict}");
}
