//! The linear programme against brute force.

use super::*;
use crate::base::Heights;
use crate::kernel::triangulate::conformance;
use proptest::prelude::*;

/// The least maximum error as the largest that four samples, or three on a line, enforce: by brute force, in units of
/// nothing but doubles.
fn naive(tile: &Tile) -> f64 {
    let samples: Vec<(usize, usize)> =
        (0..tile.height()).flat_map(|row| (0..tile.width()).map(move |column| (column, row))).collect();
    let mut largest = 0.0f64;
    for (i, &a) in samples.iter().enumerate() {
        for (j, &b) in samples.iter().enumerate().skip(i + 1) {
            for (k, &c) in samples.iter().enumerate().skip(j + 1) {
                for &d in &samples[k + 1..] {
                    let at = |p: (usize, usize)| Point { x: p.0 as i32, y: p.1 as i32 };
                    let w = [
                        orient(at(b), at(c), at(d)),
                        -orient(at(a), at(c), at(d)),
                        orient(at(a), at(b), at(d)),
                        -orient(at(a), at(b), at(c)),
                    ];
                    let scale: i64 = w.iter().map(|w| w.abs()).sum();
                    let sum: f64 = w.iter().zip([a, b, c, d]).map(|(&w, p)| w as f64 * tile.at(p.0, p.1)).sum();
                    if scale > 0 {
                        largest = largest.max(sum.abs() / scale as f64);
                    }
                }
            }
        }
    }
    largest
}

fn whole(tile: &Tile) -> Region {
    Region { first: (0, 0), last: (tile.width() - 1, tile.height() - 1) }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(150))]

    #[test]
    fn the_plane_has_the_least_error(size in (2usize..6, 2usize..6), seed in any::<u64>(), kind in 0u8..4) {
        let tile = conformance::tile(size.0, size.1, seed, kind);
        let least_error = naive(&tile);
        let Ok(plane) = least(&tile, f64::INFINITY, whole(&tile)) else { panic!("anything fits") };
        let samples = (0..size.1).flat_map(|row| (0..size.0).map(move |column| (column, row)));
        let error = samples.map(|p| (plane.at(p) - tile.at(p.0, p.1)).abs()).fold(0.0, f64::max);
        prop_assert!((error - least_error).abs() <= 1e-4 * (1.0 + least_error), "{} for {}", error, least_error);
    }

    /// Exactly at the least error a plane fits, and below it four samples say that none does.
    #[test]
    fn what_does_not_fit_has_a_proof(
        size in (2usize..6, 2usize..6), seed in any::<u64>(), kind in 0u8..3, share in 0.01f64..2.0,
    ) {
        let tile = conformance::tile(size.0, size.1, seed, kind);
        let least_error = naive(&tile);
        let tolerance = least_error * share;
        match least(&tile, tolerance, whole(&tile)) {
            Err(certificate) => {
                prop_assert!(excludes_planes(&tile, tolerance, &certificate));
                prop_assert!(least_error > tolerance);
            }
            Ok(_) => prop_assert!(least_error <= tolerance * (1.0 + 1e-3), "{} for {}", tolerance, least_error),
        }
    }

    #[test]
    fn a_line_of_samples_is_held_to_a_line(len in 3usize..9, seed in any::<u64>(), upright in any::<bool>()) {
        let (width, height) = if upright { (1, len) } else { (len, 1) };
        let tile = conformance::tile(width, height, seed, 0);
        let z = |i: usize| if upright { tile.at(0, i) } else { tile.at(i, 0) };
        let mut least_error = 0.0f64;
        for i in 0..len { for j in i + 1..len { for k in j + 1..len {
            let (a, b) = ((k - j) as f64, (j - i) as f64);
            least_error = least_error.max((a * z(i) + b * z(k) - (a + b) * z(j)).abs() / (2.0 * (a + b)));
        } } }
        for (tolerance, fits) in [(least_error * 1.001 + 1e-9, true), (least_error * 0.999, least_error == 0.0)] {
            let fit = least(&tile, tolerance, whole(&tile));
            prop_assert_eq!(fit.is_ok(), fits, "{:?}", fit);
        }
    }
}

#[test]
fn weights_bind_where_they_are_large() {
    let tile = Tile::from_heights(3, 3, Heights::F64(vec![0.0, 0.0, 0.0, 0.0, 8.0, 0.0, 0.0, 0.0, 0.0]));
    let fits = |weight: f64, tolerance: f64| {
        let mut weights = vec![1.0; 9];
        weights[4] = weight;
        let tile = tile.clone().with_weights(weights);
        match least(&tile, tolerance, whole(&tile)) {
            Ok(_) => true,
            Err(certificate) => !excludes_planes(&tile, tolerance, &certificate),
        }
    };
    // The middle is 8 above the mean of opposite corners: 8 = t + t ÷ weight.
    assert!(fits(1.0, 4.01) && !fits(1.0, 3.99));
    assert!(fits(0.25, 1.61) && !fits(0.25, 1.59));
    assert!(fits(0.0, 0.1) && fits(4.0, 6.41) && !fits(4.0, 6.39));
}
