//! The verifier's lines against those that meshes are made with.

use proptest::prelude::*;

use super::*;
use crate::base::{LineKind, LineSet, Polylines};
use crate::kernel::breaklines::Breaklines;

fn places() -> impl Strategy<Value = Vec<Vec<(f64, f64)>>> {
    let number = prop_oneof![
        -2.0..9.0f64,
        (-8..40i32).prop_map(|v| f64::from(v) / 4.0),
        (-8..40i32).prop_map(|v| f64::from(v) / 8.0),
        (0..7i32).prop_map(f64::from),
    ];
    prop::collection::vec(prop::collection::vec((number.clone(), number), 0..6), 1..6)
}

proptest! {
    #[test]
    fn both_find_the_same_segments(lines in places()) {
        let set = LineSet { kind: LineKind::Breaklines, lines: Polylines::new(lines), shift: 0.5 };
        let theirs = Breaklines::new(std::slice::from_ref(&set), (8, 7)).expect("near lines");
        let theirs: Vec<[Spot; 2]> = theirs.segments().iter().map(|s| s.map(|p| (p.x, p.y))).collect();
        let mut pieces = Vec::new();
        places::cut((0, &set), (8, 7), &mut pieces).expect("near lines");
        let mut ours: Vec<[Spot; 2]> = noding::noded(pieces).iter().map(|(piece, _)| piece.ends).collect();
        ours.sort_unstable_by_key(|s| s.map(|(x, y)| (y, x)));
        prop_assert_eq!(ours, theirs);
    }

    /// Bit for bit, whichever way a line is drawn and whatever it crosses.
    #[test]
    fn both_find_the_same_heights(lines in places(), slopes in prop::array::uniform3(-3.0..3.0f64)) {
        let plane = |&(x, y): &(f64, f64)| slopes[0] + slopes[1] * x + slopes[2] * (y * x).sin();
        let heights = lines.iter().map(|line| line.iter().map(plane).collect()).collect();
        let set = |lines| LineSet { kind: LineKind::Breaklines, lines, shift: 0.5 };
        let sets = [set(Polylines::new(lines.clone()).with_heights(heights)), set(Polylines::new(lines))];
        let theirs = Breaklines::new(&sets, (8, 7)).expect("near lines");
        let ours = RequiredLines::new(&sets, (8, 7), 1e9).expect("near lines");
        prop_assert_eq!(ours.segments.len(), theirs.segments().len());
        for (&(x, y), &height) in &ours.levels {
            let level = theirs.height_at(crate::kernel::breaklines::Place { y, x });
            prop_assert_eq!(level.map(f64::to_bits), Some(height.to_bits()), "at {}, {}", x, y);
        }
        prop_assert_eq!(theirs.height_range().is_some(), ours.have_heights());
        prop_assert!(theirs.check_heights(0.0).is_ok() == RequiredLines::new(&sets, (8, 7), 0.0).is_ok());
    }
}

#[test]
fn stretches_go_from_where_lines_end_or_meet_to_where_they_do_again() {
    let ring = [[(4, 0), (8, 4)], [(0, 4), (4, 8)], [(4, 0), (0, 4)], [(8, 4), (4, 8)]];
    let of = |segments: &[[Spot; 2]], set: u16| segments.iter().map(|&s| (s, 1 << set)).collect::<Vec<_>>();
    let ring = of(&ring, 0);
    let all = |found: &[([Spot; 2], u16)]| {
        let found = graph::stretches(found.iter());
        found.into_iter().map(|(places, _)| (places[0], places[places.len() - 1], places.len())).collect::<Vec<_>>()
    };
    assert_eq!(all(&ring), [((4, 0), (4, 0), 5)]);
    let tail = [[(8, 4), (9, 4)], [(9, 4), (12, 5)]];
    assert_eq!(all(&[ring.clone(), of(&tail, 0)].concat()), [((8, 4), (8, 4), 5), ((8, 4), (12, 5), 3)]);
    // Where other lines begin to share a stretch, one ends.
    let shared = [of(&tail[..1], 0), of(&tail[1..], 1)].concat();
    assert_eq!(all(&shared), [((8, 4), (9, 4), 2), ((9, 4), (12, 5), 2)]);
}
