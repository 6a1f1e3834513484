//! Random meshes over random rasters, every sample against every triangle.

use num_bigint::BigInt;
use num_rational::BigRational;
use proptest::prelude::*;

use super::scene::{Mesh, NORTH_UP, SOUTH_UP, Scene, TURNED};
use crate::verify::grid::orientation;

/// Errors of every sample, exactly, by every triangle that holds it: nothing here is shared with the sweep.
fn errors(scene: &Scene) -> Vec<Vec<BigRational>> {
    let rational = |v: f64| BigRational::from_float(v).unwrap();
    let of_sample = |(index, &sample): (usize, &f64)| {
        let p = (4 * (index % scene.width) as i64, 4 * (index / scene.width) as i64);
        let mut found = Vec::new();
        for face in &scene.mesh.faces {
            let [a, b, c] = face.map(|v| scene.mesh.places[v as usize]);
            let weights = [orientation(p, b, c), orientation(a, p, c), orientation(a, b, p)];
            let area = orientation(a, b, c);
            if area == 0 || weights.iter().any(|w| w * area.signum() < 0) {
                continue;
            }
            let heights = face.map(|v| rational(scene.mesh.heights[v as usize]));
            let terms = weights.iter().zip(heights).map(|(&w, z)| z * BigInt::from(w));
            let error = rational(sample) - terms.sum::<BigRational>() / BigInt::from(area);
            found.push(if error < rational(0.0) { -error } else { error });
        }
        found
    };
    scene.samples.iter().enumerate().map(of_sample).collect()
}

/// Near enough for a comparison with rounded results.
fn to_f64(value: &BigRational) -> f64 {
    let scale = 1u64 << 60;
    let scaled = (value * BigInt::from(scale)).to_integer();
    scaled.to_string().parse::<f64>().unwrap() / scale as f64
}

/// Whole numbers, where ties are common, and others, where they are not.
pub(super) fn a_height() -> impl Strategy<Value = f64> {
    prop_oneof![3 => (-3i32..4).prop_map(f64::from), 1 => -3f64..4.0]
}

prop_compose! {
    fn scene()(width in prop_oneof![4 => 2usize..12, 1 => 12usize..40], height in 2usize..12)(
        size in Just((width, height)),
        transform in prop_oneof![Just(NORTH_UP), Just(SOUTH_UP), Just(TURNED)],
        samples in proptest::collection::vec(a_height(), width * height),
        rim in proptest::collection::vec(a_height(), 4),
        points in proptest::collection::vec(((0..4 * width as i64 - 3, 0..4 * height as i64 - 3), a_height()), 0..20),
        shuffle in any::<u64>(),
    ) -> Scene {
        let mut mesh = Mesh::rectangle(size.0, size.1);
        mesh.heights = rim;
        points.into_iter().for_each(|(place, z)| mesh.insert(place, z));
        // Faces in any order, from any corner on.
        let mut state = shuffle | 1;
        mesh.faces.sort_by_cached_key(|_| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            state >> 20
        });
        mesh.faces.iter_mut().enumerate().for_each(|(i, f)| f.rotate_left(i % 3));
        Scene { width: size.0, height: size.1, transform, samples, mesh }
    }
}

proptest! {
    #[test]
    fn errors_are_what_every_sample_against_every_triangle_says(
        scene in scene(), tolerance in prop_oneof![Just(0.0), Just(0.1), Just(1.0), Just(2.0), 0f64..5.0],
    ) {
        let verdict = scene.judge(tolerance).unwrap();
        let errors = errors(&scene);
        let limit = BigRational::from_float(tolerance).unwrap();
        let above = errors.iter().filter(|e| e.iter().any(|e| *e > limit)).count();
        prop_assert_eq!(verdict.above_tolerance.count, above as u64);
        let largest = errors.iter().flatten().max().unwrap();
        let worst = verdict.worst.unwrap();
        prop_assert!((worst.error - to_f64(largest)).abs() <= 1e-13, "{} {}", worst.error, largest);
        prop_assert_eq!(worst.error > tolerance, above > 0);
        let at = worst.place.row as usize * scene.width + worst.place.column as usize;
        prop_assert!(errors[at].iter().any(|e| (to_f64(e) - worst.error).abs() <= 1e-13));
        let squares: f64 = errors.iter().map(|e| to_f64(&e[0]).powi(2)).sum();
        prop_assert!((verdict.rms_error - (squares / errors.len() as f64).sqrt()).abs() <= 1e-13);
        // A whole mesh has no fault but its distance.
        prop_assert_eq!(verdict.failures().len(), usize::from(above > 0), "{}", verdict);
    }

    #[test]
    fn weighted_errors_are_what_every_sample_against_every_triangle_says(
        scene in scene(), tolerance in prop_oneof![Just(0.0), Just(0.1), Just(1.0), Just(2.0), 0f64..5.0],
        weights in proptest::collection::vec(prop_oneof![Just(0.0), Just(0.3), Just(1.0), Just(2.0), 0f64..4.0], 480),
    ) {
        let weights = &weights[..scene.samples.len()];
        let verdict = scene.judge_weighted(tolerance, weights).unwrap();
        let weighted = |(errors, weight): (Vec<BigRational>, &f64)| -> Vec<BigRational> {
            errors.into_iter().map(|e| e * BigRational::from_float(*weight).unwrap()).collect()
        };
        let errors: Vec<_> = errors(&scene).into_iter().zip(weights).map(weighted).collect();
        let limit = BigRational::from_float(tolerance).unwrap();
        let above = errors.iter().filter(|e| e.iter().any(|e| *e > limit)).count();
        prop_assert_eq!(verdict.above_tolerance.count, above as u64);
        prop_assert_eq!(verdict.failures().len(), usize::from(above > 0), "{}", verdict);
        let worst = verdict.weighted_worst.unwrap();
        let largest = to_f64(errors.iter().flatten().max().unwrap());
        prop_assert!((worst.weighted_error - largest).abs() <= 1e-13, "{} {}", worst.weighted_error, largest);
        prop_assert_eq!(worst.weighted_error > tolerance, above > 0);
        let at = worst.sample.place.row as usize * scene.width + worst.sample.place.column as usize;
        prop_assert_eq!(worst.weight, weights[at]);
        prop_assert!(errors[at].iter().any(|e| (to_f64(e) - worst.weighted_error).abs() <= 1e-13));
        // What weights do not concern is as it is without.
        let plain = scene.judge(tolerance).unwrap();
        prop_assert_eq!(verdict.uncovered, plain.uncovered);
        prop_assert!((verdict.worst.unwrap().error - plain.worst.unwrap().error).abs() <= 1e-13);
        prop_assert!((verdict.rms_error - plain.rms_error).abs() <= 1e-13);
        let ones = scene.judge_weighted(tolerance, &vec![1.0; scene.samples.len()]).unwrap();
        prop_assert_eq!(ones.above_tolerance, plain.above_tolerance);
    }

    #[test]
    fn coverage_is_what_every_sample_against_every_triangle_says(
        scene in scene(), dropped in any::<proptest::sample::Index>(), doubled in any::<proptest::sample::Index>(),
    ) {
        let mut scene = scene;
        let face = scene.mesh.faces[doubled.index(scene.mesh.faces.len())];
        scene.mesh.faces.remove(dropped.index(scene.mesh.faces.len()));
        scene.mesh.faces.push(face);
        let verdict = scene.judge(1.0).unwrap();
        prop_assert!(!verdict.passes());
        let errors = errors(&scene);
        prop_assert_eq!(verdict.uncovered.count, errors.iter().filter(|e| e.is_empty()).count() as u64);
    }

    #[test]
    fn any_faces_are_judged_without_a_panic(scene in scene(), faces in proptest::collection::vec(any::<[u8; 3]>(), 0..12)) {
        let mut scene = scene;
        let count = scene.mesh.places.len() as u64;
        scene.mesh.faces = faces.into_iter().map(|f| f.map(|v| u64::from(v) % count)).collect();
        let verdict = scene.judge(1.0).unwrap();
        let errors = errors(&scene);
        prop_assert_eq!(verdict.uncovered.count, errors.iter().filter(|e| e.is_empty()).count() as u64);
        let area: i128 = scene.mesh.faces.iter().map(|f| {
            let [a, b, c] = f.map(|v| scene.mesh.places[v as usize]);
            -orientation(a, b, c)
        }).sum();
        prop_assert_eq!(verdict.double_area, area);
    }
}
