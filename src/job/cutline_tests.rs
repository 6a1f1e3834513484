//! Meshes that end at a cutline's own line, judged by the verifier, which reckons what is inside again.

use proptest::prelude::*;

use super::breakline_tests::{Line, Scene, qualities, scene};
use super::*;
use crate::testing::cases;

fn ring(size: (usize, usize)) -> impl Strategy<Value = Line> {
    let number = |last: usize| {
        let last = last as f64 - 1.0;
        prop_oneof![
            4 => -2.0..last + 2.0,
            1 => (0.0..last).prop_map(|v| (v * 4.0).round() / 4.0),
            1 => (0.0..last).prop_map(f64::round),
            1 => prop_oneof![Just(0.0), Just(last)],
        ]
    };
    (prop::collection::vec((number(size.0), number(size.1)), 3..8), any::<bool>()).prop_map(|(mut ring, is_right)| {
        // Along rows and columns, every other time.
        for i in (1..ring.len()).filter(|_| is_right) {
            if i % 2 == 1 { ring[i].1 = ring[i - 1].1.round() } else { ring[i].0 = ring[i - 1].0.round() }
        }
        ring.push(ring[0]);
        ring
    })
}

fn cutlines() -> impl Strategy<Value = Scene> {
    scene().prop_flat_map(|scene| {
        let polygons = prop::collection::vec(prop::collection::vec(ring(scene.size), 1..3), 1..4);
        (Just(scene), polygons).prop_map(|(scene, cutline)| Scene { cutline, ..scene })
    })
}

impl Scene {
    /// The mesh ends where it should, and edges follow all lines inside.
    fn certify_cut(&self, params: &Params) {
        let Some((mesh, verdict)) = self.made(params) else { return };
        assert_eq!(verdict.broken.count, 0, "{verdict:?}");
        let segments = params.breaklines.as_ref().expect("lines").segments().len() as u64;
        assert_eq!(verdict.segments, segments);
        let off_ground = mesh.chains().iter().map(|chains| chains.off_ground);
        assert!(verdict.off_ground <= off_ground.sum(), "{verdict:?}");
    }
}

proptest! {
    #![proptest_config(cases(150, 4000))]

    /// Outlines may cross themselves, each other and all lines, the raster's rim, seams and voids.
    #[test]
    fn meshes_end_at_outlines_over_random_rasters(
        scene in cutlines(), (quality, heights) in qualities(), tile in 2usize..20,
        tolerance in prop_oneof![Just(0.5), Just(3.0), Just(20.0)], has_lines in any::<bool>(),
    ) {
        let scene = Scene { lines: if has_lines { scene.lines.clone() } else { Vec::new() }, ..scene };
        scene.certify_cut(&Params { quality, heights, tile, ..scene.params(tolerance) });
    }
}
