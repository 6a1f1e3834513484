//! The verifier's lines against those that meshes are made with.

use proptest::prelude::*;

use super::*;
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
        let lines = Polylines::new(lines);
        let theirs = Breaklines::new(&lines, (8, 7), 0.5).expect("near lines");
        let theirs: Vec<[Spot; 2]> = theirs.segments().iter().map(|s| s.map(|p| (p.x, p.y))).collect();
        let mut ours = noding::noded(places::cut(&lines, (8, 7)).expect("near lines"));
        ours.sort_unstable_by_key(|s| s.map(|(x, y)| (y, x)));
        prop_assert_eq!(ours, theirs);
    }
}

#[test]
fn stretches_go_from_where_lines_end_or_meet_to_where_they_do_again() {
    let ring = [[(4, 0), (8, 4)], [(0, 4), (4, 8)], [(4, 0), (0, 4)], [(8, 4), (4, 8)]];
    assert_eq!(graph::stretches(ring.iter().collect()), [[(4, 0), (0, 4), (4, 8), (8, 4), (4, 0)]]);
    let tail = [[(8, 4), (9, 4)], [(9, 4), (12, 5)]];
    let found = graph::stretches(ring.iter().chain(&tail).collect());
    let ends: Vec<(Spot, Spot, usize)> = found.iter().map(|s| (s[0], s[s.len() - 1], s.len())).collect();
    assert_eq!(ends, [((8, 4), (8, 4), 5), ((8, 4), (12, 5), 3)]);
}
