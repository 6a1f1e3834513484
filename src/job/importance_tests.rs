//! Selective fidelity, end to end: what is promised of error × weight, and what weights do to a mesh.

use gdal::DriverManager;
use gdal::raster::Buffer;
use proptest::prelude::*;

use super::tests::{Told, certify_weighted, engines, geotiff, qualities, terrain, told};
use super::*;
use crate::base::Band;
use crate::base::Heights;
use crate::base::control::Control;
use crate::field::{Choice, Field, FieldError, FieldOptions};
use crate::kernel::triangulate::Feasibility;
use crate::testing;

fn field(width: usize, height: usize, heights: Heights) -> Field {
    Field::from_heights(width, height, heights).expect("a field")
}

fn weighted(width: usize, height: usize, heights: Heights, weights: Vec<f64>) -> Field {
    field(width, height, heights)
        .with_importance(field(width, height, Heights::F64(weights)))
        .expect("weights that fit")
}

fn made(field: &Field, params: &Params) -> Mesh {
    triangulate(field, params, &Control::default()).expect("a mesh")
}

fn one_weight() -> impl Strategy<Value = f64> {
    prop_oneof![Just(0.0), Just(0.3), Just(1.0), Just(2.0), Just(1e6), Just(1e30), 0.0f64..3.0]
}

/// How weights lie over a raster: one for all, halves, or any.
fn weights(width: usize, height: usize) -> impl Strategy<Value = Vec<f64>> {
    prop_oneof![
        one_weight().prop_map(move |w| vec![w; width * height]),
        (one_weight(), one_weight())
            .prop_map(move |(a, b)| (0..width * height).map(|i| if i % width < width / 2 { a } else { b }).collect()),
        prop::collection::vec(one_weight(), width * height),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn what_is_written_passes_the_verifier_with_weights(
        (width, height, weights) in (2usize..40, 2usize..40).prop_flat_map(|(w, h)| (Just(w), Just(h), weights(w, h))),
        seed in any::<u64>(), kind in 0u8..4,
        max_error in prop_oneof![Just(0.0), Just(1.0), Just(2.5), 0.0f64..6.0, Just(1e6), Just(1e-250)],
        tile in prop_oneof![Just(0usize), 1usize..12, Just(16), Just(512)], strong in any::<bool>(),
        engine in prop::sample::select(engines()), (quality, vertices) in prop::sample::select(qualities()),
    ) {
        let noise = |i: usize| (i as u64 + 1).wrapping_mul(seed | 1).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 48;
        let heights: Vec<f64> = match kind {
            0 => (0..width * height).map(|i| (noise(i) % 9) as f64).collect(),
            1 => (0..width * height).map(|i| noise(i) as f64 * 1e-4).collect(),
            2 => terrain(seed % 64, width, height),
            _ => vec![-11.5; width * height],
        };
        let feasibility = if strong { Feasibility::Strong } else { Feasibility::Weak };
        let params = Params { feasibility, tile, engine, quality, heights: vertices, ..Params::new(max_error) };
        certify_weighted(width, height, &heights, Some(&weights), &params);
    }
}

/// Whatever type the heights are of: with weights they are all held in double precision.
#[test]
fn weights_of_one_change_nothing() {
    let (width, height) = (150, 110);
    let single: Vec<f32> = terrain(5, width, height).iter().map(|z| *z as f32).collect();
    let ones = vec![1.0; width * height];
    for feasibility in [Feasibility::Weak, Feasibility::Strong] {
        for max_error in [0.0, 3.0, 0.7] {
            let params = Params { feasibility, tile: 48, ..Params::new(max_error) };
            let heights = [
                Heights::F64(terrain(5, width, height)),
                Heights::F32(single.clone()),
                Heights::F32(single.iter().map(|z| z.round()).collect()),
            ];
            for heights in heights {
                let plain = made(&field(width, height, heights.clone()), &params);
                let unit = made(&weighted(width, height, heights, ones.clone()), &params);
                assert!(told(&plain) == told(&unit), "{params:?}");
                for (plain, unit) in plain.chunks().zip(unit.chunks()) {
                    assert_eq!(plain.expect("a chunk").errors, unit.expect("a chunk").errors);
                }
            }
        }
    }
}

/// Integers of a file, and weights of another type, read in each of the ways.
#[test]
fn weights_of_one_change_nothing_in_rasters_of_integers() {
    let (width, height) = (130, 90);
    let folder = testing::folder();
    let (dem, ones) = (folder.path().join("dem.tif"), folder.path().join("ones.tif"));
    let driver = DriverManager::get_driver_by_name("GTiff").expect("GTiff");
    let dataset = driver.create_with_band_type::<i16, _>(&dem, width, height, 1).expect("a raster");
    let heights: Vec<i16> = terrain(8, width, height).iter().map(|z| *z as i16).collect();
    let mut samples = Buffer::new((width, height), heights);
    dataset.rasterband(1).expect("a band").write((0, 0), (width, height), &mut samples).expect("written");
    dataset.close().expect("closed");
    geotiff(&ones, width, height, &vec![1.0; width * height]);
    let (dem, ones) = (testing::band(&dem, 1), testing::band(&ones, 1));
    let params = Params { tile: 40, ..Params::new(2.0) };
    let of = |importance: Option<&Band>, choice| {
        let options = FieldOptions { choice, ..FieldOptions::default() };
        let field = Field::open_with_importance(&dem, importance, &options, &Control::default()).expect("a field");
        told(&made(&field, &params))
    };
    let plain = of(None, Choice::Auto);
    for choice in [Choice::InPlace, Choice::Windows, Choice::Decode] {
        assert!(of(Some(&ones), choice) == plain, "{choice:?}");
    }
}

/// Triangles with their middle left of a column.
fn left_of(told: &Told, column: f64) -> usize {
    let x = |v: u64| told.vertices[v as usize][0];
    told.triangles.iter().filter(|t| t.iter().map(|&v| x(v)).sum::<f64>() / 3.0 < column).count()
}

#[test]
fn weight_draws_triangles_and_its_absence_frees_them() {
    let side = 256;
    let params = Params { tile: 64, ..Params::new(1.0) };
    let heights = || Heights::F64(terrain(4, side, side));
    let halves = |left: f64| (0..side * side).map(|i| if i % side < side / 2 { left } else { 1.0 }).collect();
    let on_the_left = |left: f64| {
        let told = told(&made(&weighted(side, side, heights(), halves(left)), &params));
        (left_of(&told, side as f64 / 2.0), told.triangles.len())
    };
    let (plain, all) = on_the_left(1.0);
    let (dense, _) = on_the_left(4.0);
    let (free, _) = on_the_left(0.0);
    assert!(dense > 2 * plain, "{dense} against {plain} of {all}");
    assert!(10 * free < plain, "{free} against {plain} of {all}");
}

#[test]
fn threads_do_not_change_what_weights_make() {
    let (width, height) = (200, 150);
    let weights: Vec<f64> = (0..width * height).map(|i| f64::from((i * 7919 % 13) as u32) * 0.3).collect();
    let field = weighted(width, height, Heights::F64(terrain(3, width, height)), weights);
    let params = Params { tile: 32, ..Params::new(4.0) };
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| told(&made(&field, &params)))
    };
    assert!(on(1) == on(3));
}

#[test]
fn weights_that_are_none_are_refused_where_they_are_met() {
    for wrong in [-1.0, f64::NAN, f64::INFINITY, 2e30, -5e-324] {
        let mut weights = vec![1.0; 12];
        weights[7] = wrong;
        let run =
            triangulate(&weighted(4, 3, Heights::F32(vec![0.0; 12]), weights), &Params::new(1.0), &Control::default());
        assert!(matches!(run, Err(Error::Field(FieldError::NotAWeight { column: 3, row: 1, .. }))), "{wrong}: {run:?}");
    }
    let other = field(4, 3, Heights::F32(vec![0.0; 12])).with_importance(field(3, 4, Heights::F32(vec![1.0; 12])));
    assert!(matches!(other, Err(FieldError::OtherSize { expected: (4, 3), found: (3, 4), .. })));
}
