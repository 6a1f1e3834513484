//! Rasters that cannot be judged, and samples of every type.

use std::path::Path;

use super::scene::{Mesh, Scene, write_raster};
use crate::base::RasterError;
use crate::base::control::{CancelToken, Control, Silent};
use crate::raster::Raster;
use crate::verify::{Verdict, VerifyError, VerifyOptions, verify};

const SIZE: (usize, usize) = (3, 2);

fn judge<T: gdal::raster::GdalType + Copy>(
    samples: [T; 6],
    adorn: impl FnOnce(&mut gdal::Dataset),
) -> Result<Verdict, VerifyError> {
    let dir = tempfile::tempdir().unwrap();
    let path = write_raster(&dir, SIZE, &samples, adorn);
    let mesh = dir.path().join("mesh.ply");
    std::fs::write(&mesh, Mesh::rectangle(SIZE.0, SIZE.1).ply([0.0, 1.0, 0.0, 0.0, 0.0, -1.0], SIZE)).unwrap();
    judge_files(&path, &mesh)
}

fn judge_files(raster: &Path, mesh: &Path) -> Result<Verdict, VerifyError> {
    let raster = Raster::open(raster, 1).unwrap();
    let options = VerifyOptions { lines: None, max_error: 10.0, max_stray: None, importance: None, temp_dir: None };
    verify(&raster.to_band().expect("a band"), mesh, &options, &Control::default())
}

fn mark_nodata(value: f64) -> impl FnOnce(&mut gdal::Dataset) {
    move |d| d.rasterband(1).unwrap().set_no_data_value(Some(value)).unwrap()
}

#[test]
fn nodata_of_every_kind_must_not_be_touched() {
    let at = |result: Result<Verdict, VerifyError>| {
        let verdict = result.unwrap();
        assert!(!verdict.passes() && verdict.nodata > 0, "{verdict}");
        let first = verdict.touched_nodata.first.unwrap().sample;
        (first.column, first.row)
    };
    assert_eq!(at(judge([0f32, 0.0, 0.0, 0.0, f32::NAN, 0.0], |_| {})), (1, 1));
    assert_eq!(at(judge([0f64, 0.0, -9999.0, 0.0, -9999.0, 0.0], mark_nodata(-9999.0))), (2, 0));
    assert_eq!(at(judge([0i16, 0, 0, -32768, 0, 0], mark_nodata(-32768.0))), (0, 1));
    assert_eq!(at(judge([1u8, 1, 1, 1, 1, 0], mark_nodata(0.0))), (2, 1));
    let masked = judge([1u8; 6], |d| {
        let mut band = d.rasterband(1).unwrap();
        band.create_mask_band(false).unwrap();
        let mut mask = gdal::raster::Buffer::new(SIZE, vec![255u8, 255, 255, 255, 0, 255]);
        band.open_mask_band().unwrap().write((0, 0), SIZE, &mut mask).unwrap();
    });
    assert_eq!(at(masked), (1, 1));
}

#[test]
fn a_nodata_value_that_no_sample_has_does_no_harm() {
    assert!(judge([1i16, 2, 3, 4, 5, 6], mark_nodata(-32768.0)).unwrap().passes());
    assert!(judge([1f32, 2.0, 3.0, 4.0, 5.0, 6.0], mark_nodata(f64::NAN)).unwrap().passes());
}

#[test]
fn infinite_samples_are_refused_by_name() {
    let result = judge([0f32, 0.0, f32::NEG_INFINITY, 0.0, 0.0, 0.0], |_| {});
    assert!(matches!(result, Err(VerifyError::InfiniteSample { column: 2, row: 0, .. })), "{result:?}");
}

#[test]
fn weights_that_are_none_are_refused_by_name() {
    for (wrong, found) in [(-0.5, "-0.5"), (f64::NAN, "nodata"), (f64::INFINITY, "inf")] {
        let mut weights = vec![1.0; 63];
        weights[9 + 4] = wrong;
        match Scene::flat().judge_weighted(1.0, &weights) {
            Err(VerifyError::NotAWeight { column: 4, row: 1, found: said, .. }) => {
                assert!(said.contains(found), "{said}")
            }
            other => panic!("{other:?}"),
        }
    }
    assert!(Scene::flat().judge_weighted(0.0, &[1e300; 63]).unwrap().passes());
}

#[test]
fn an_importance_raster_of_another_size_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    let other = crate::testing::band(&write_raster(&dir, (9, 8), &[1u8; 72], |_| {}), 1);
    let result = Scene::flat().judge_with("", 1.0, Some(&other));
    assert!(matches!(result, Err(VerifyError::Raster(RasterError::OtherGrid { .. }))), "{result:?}");
}

#[test]
fn a_missing_or_damaged_mesh_is_an_error() {
    let dir = tempfile::tempdir().unwrap();
    let raster = write_raster(&dir, SIZE, &[0u8; 6], |_| {});
    assert!(matches!(judge_files(&raster, &dir.path().join("none.ply")), Err(VerifyError::Mesh(_))));
    assert!(matches!(judge_files(&raster, &raster), Err(VerifyError::Mesh(_))));
}

#[test]
fn a_tolerance_below_zero_or_not_finite_is_refused() {
    for tolerance in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(Scene::flat().judge(tolerance), Err(VerifyError::Tolerance { .. })));
    }
    assert!(Scene::flat().judge(-0.0).unwrap().passes());
}

#[test]
fn a_cancelled_run_stops_and_a_missing_temp_dir_is_named() {
    let dir = tempfile::tempdir().unwrap();
    let raster = Raster::open(&write_raster(&dir, SIZE, &[0u8; 6], |_| {}), 1).unwrap();
    let mesh = dir.path().join("mesh.ply");
    std::fs::write(&mesh, Mesh::rectangle(3, 2).ply([0.0, 1.0, 0.0, 0.0, 0.0, -1.0], SIZE)).unwrap();
    let control = Control { cancel: CancelToken::default(), progress: &Silent };
    control.cancel.cancel();
    let options = VerifyOptions { lines: None, max_error: 0.0, max_stray: None, importance: None, temp_dir: None };
    assert!(matches!(
        verify(&raster.to_band().expect("a band"), &mesh, &options, &control),
        Err(VerifyError::Cancelled(_))
    ));
    let options = VerifyOptions {
        lines: None,
        max_error: 0.0,
        max_stray: None,
        importance: None,
        temp_dir: Some(dir.path().join("none")),
    };
    let result = verify(&raster.to_band().expect("a band"), &mesh, &options, &Control::default());
    assert!(matches!(result, Err(VerifyError::Scratch(_))), "{result:?}");
}
