//! Greedy cuts in the conformance suite, and what sweeps cost.

use super::*;
use crate::base::control::CancelToken;
use crate::kernel::triangulate::conformance::{conformance, rim, tile};

conformance!(plain, GreedyCuts::PLAIN);
conformance!(improved, GreedyCuts::IMPROVED);

/// Sweeps are what the improved order spends its time on. (That no edge is swept twice is asserted where they are made.)
#[test]
fn every_edge_is_swept_at_most_once() {
    let cancel = CancelToken::default();
    for kind in 0..3 {
        let tile = tile(90, 80, 11, kind);
        let rim = rim(&tile, 1.0);
        for feasibility in [Feasibility::Weak, Feasibility::Strong] {
            let (mut mesh, mut scratch) = (TileMesh::default(), Scratch::default());
            let task = Task {
                tile: &tile,
                domain: &rim.domain,
                tolerance: 1.0,
                feasibility,
                max_stray: f64::INFINITY,
                cancel: &cancel,
            };
            GreedyCuts::IMPROVED.cut(&task, &mut scratch, &mut mesh).expect("nobody cancels");
            let swept = scratch.improved.seen.len();
            assert!(swept > 0 && swept < 3 * mesh.triangles.len(), "{swept} of {}", mesh.triangles.len());
        }
    }
}
