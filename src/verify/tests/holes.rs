//! Holes that are bridged.

use gdal::DriverManager;
use gdal::raster::Buffer;

use super::ground::{samples, scene};
use super::scene::{Mesh, NORTH_UP, SOUTH_UP, Scene};
use crate::base::channels::ChannelBands;
use crate::base::control::Control;
use crate::verify::{GroundOptions, Verdict, VerifyOptions, verify_ground};

/// Two holes of two and three samples, and a gap at the edge.
const GAPS: &[&str] = &["#######.", "##.##.##", "#.##.###", "#####.##", "########"];

/// The mesh where bridged samples have heights far from all others.
fn bridged(rows: &[&str], holes: &[(usize, usize)]) -> Scene {
    let mut heights = samples(rows);
    holes.iter().for_each(|&(column, row)| heights[row * rows[0].len() + column] = 1e6);
    Scene { mesh: Mesh::of_cells(rows[0].len(), &heights, || true), ..scene(rows) }
}

fn judge(scene: &Scene, fill_holes: u64) -> Verdict {
    let ground = GroundOptions { fill_holes, trim: 0 };
    let verdict = scene.judge_ground(0.0, ground, 1).unwrap();
    for rows in 2..=scene.height {
        assert_eq!(scene.judge_ground(0.0, ground, rows).unwrap(), verdict, "{rows}");
    }
    let Verdict { checked, nodata, bridged, without_ground, samples, .. } = verdict;
    assert_eq!(checked + nodata + bridged + without_ground.count, samples);
    verdict
}

#[test]
fn a_mesh_over_bridged_holes_passes_whatever_its_heights_there() {
    let small = [(2, 1), (1, 2)];
    let all = [(2, 1), (1, 2), (5, 1), (4, 2), (5, 3)];
    for transform in [NORTH_UP, SOUTH_UP] {
        let scene = Scene { transform, ..bridged(GAPS, &small) };
        let verdict = judge(&scene, 2);
        assert!(verdict.passes(), "{verdict}");
        assert_eq!((verdict.bridged_holes, verdict.bridged, verdict.nodata, verdict.rms_error), (1, 2, 4, 0.0));
        assert!(verdict.to_string().contains("missing: 4; filled: 2 in 1 void"), "{verdict}");
        let verdict = judge(&Scene { transform, ..bridged(GAPS, &all) }, 3);
        assert!(verdict.passes(), "{verdict}");
        assert_eq!((verdict.bridged_holes, verdict.bridged, verdict.nodata, verdict.checked), (2, 5, 1, 34));
    }
    // The gap at the edge stays, however many samples a hole may have.
    assert!(judge(&bridged(GAPS, &all), u64::MAX).passes());
    assert!(!judge(&bridged(GAPS, &[(2, 1), (1, 2), (5, 1), (4, 2), (5, 3), (7, 0)]), u64::MAX).passes());
}

#[test]
fn a_hole_above_the_limit_is_not_covered() {
    let verdict = judge(&bridged(GAPS, &[(2, 1), (1, 2)]), 1);
    assert_eq!((verdict.touched_nodata.count, verdict.bridged_holes), (2, 0));
    assert!(!verdict.passes());
}

#[test]
fn a_hole_that_is_to_be_bridged_is_bare() {
    let verdict = judge(&scene(GAPS), 2);
    assert_eq!((verdict.uncovered.count, verdict.uncovered.first.unwrap().column), (2, 2));
    assert!(verdict.unmatched_edges.count > 0 && verdict.double_area < verdict.expected_double_area, "{verdict}");
    assert!(judge(&scene(GAPS), 1).passes());
}

#[test]
fn heights_beside_a_bridged_hole_are_judged_and_overlaps_on_it_are_found() {
    let mut off = bridged(GAPS, &[(2, 1), (1, 2)]);
    let beside = off.mesh.places.iter().position(|p| *p == (12, 4)).unwrap();
    off.mesh.heights[beside] += 1.0;
    assert_eq!(judge(&off, 2).above_tolerance.count, 1);
    let mut doubled = bridged(GAPS, &[(2, 1), (1, 2)]);
    let hole = doubled.mesh.places.iter().position(|p| *p == (8, 4)).unwrap() as u64;
    let face = *doubled.mesh.faces.iter().find(|f| f.contains(&hole)).unwrap();
    doubled.mesh.faces.push(face);
    assert!(judge(&doubled, 2).overused_edges.count > 0);
}

#[test]
fn weights_may_be_missing_where_a_hole_is_bridged() {
    let scene = bridged(GAPS, &[(2, 1), (1, 2)]);
    let mut weights = vec![1.0; 40];
    weights[8 + 2] = f64::NAN;
    let dir = tempfile::tempdir().unwrap();
    let path = super::scene::write_raster(&dir, (8, 5), &weights, |_| {});
    let importance = crate::testing::band(&path, 1);
    let verdict = scene.compare(&scene.mesh_ply(), |raster, mesh, temp_dir| {
        let options = VerifyOptions {
            lines: None,
            max_error: 0.0,
            max_stray: None,
            importance: Some(&importance),
            temp_dir: Some(temp_dir),
        };
        verify_ground(raster, mesh, &options, GroundOptions { fill_holes: 2, trim: 0 }, None, &Control::default())
    });
    assert!(verdict.unwrap().passes());
}

#[test]
fn channels_may_be_missing_where_a_hole_is_bridged() {
    let dir = tempfile::tempdir().unwrap();
    let (raster, mesh) = (dir.path().join("raster.tif"), dir.path().join("mesh.ply"));
    let driver = DriverManager::get_driver_by_name("GTiff").unwrap();
    let dataset = driver.create_with_band_type::<f32, _>(&raster, 3, 3, 2).unwrap();
    for (band, value) in [(1, 1.0), (2, 4.0)] {
        let samples = (0..9).map(|i| if i == 4 { f32::NAN } else { value }).collect();
        dataset.rasterband(band).unwrap().write((0, 0), (3, 3), &mut Buffer::new((3, 3), samples)).unwrap();
    }
    dataset.close().unwrap();
    let ply = "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double y\nproperty double z\n\
        property float band_2\nelement face 2\nproperty list uchar uint vertex_indices\nend_header\n\
        0.5 -0.5 1 4\n2.5 -0.5 1 4\n2.5 -2.5 1 4\n0.5 -2.5 1 4\n3 0 2 1\n3 0 3 2\n";
    std::fs::write(&mesh, ply).unwrap();
    let judge = |fill_holes: u64| {
        let options = VerifyOptions {
            lines: None,
            max_error: 0.0,
            max_stray: None,
            importance: None,
            temp_dir: Some(dir.path().to_path_buf()),
        };
        let channels = ChannelBands { bands: vec![crate::testing::band(&raster, 2)], emphasis: 0.5, planar: false };
        let ground = GroundOptions { fill_holes, trim: 0 };
        let raster = crate::testing::band(&raster, 1);
        verify_ground(&raster, &mesh, &options, ground, Some(&channels), &Control::default()).unwrap()
    };
    let verdict = judge(1);
    assert!(verdict.passes() && verdict.extended.is_some(), "{verdict}");
    assert!(!judge(0).passes());
}
