//! Lines on the lattice.

use proptest::prelude::*;

use super::noding::turn;
use super::*;

fn lines_of(lines: Vec<Vec<(f64, f64)>>, size: (usize, usize)) -> Breaklines {
    Breaklines::new(&Polylines::new(lines), size, 0.5).expect("near lines")
}

/// Whether two segments have more than an end in common.
fn clash([a, b]: Segment, [c, d]: Segment) -> bool {
    let on = |p: Place, q: Place, r: Place| {
        let inside = (r.x - p.x) * (r.x - q.x) <= 0 && (r.y - p.y) * (r.y - q.y) <= 0;
        turn(p, q, r) == 0 && inside && r != p && r != q
    };
    let sides = |p, q, r, s| turn(p, q, r).signum() * turn(p, q, s).signum() < 0;
    sides(a, b, c, d) && sides(c, d, a, b) || on(a, b, c) || on(a, b, d) || on(c, d, a) || on(c, d, b)
}

fn line() -> impl Strategy<Value = Vec<(f64, f64)>> {
    let number =
        prop_oneof![(-3.0..9.0f64), (-8..40i32).prop_map(|v| f64::from(v) / 4.0), (0..6i32).prop_map(f64::from),];
    prop::collection::vec((number.clone(), number), 0..7)
}

proptest! {
    #[test]
    fn segments_lie_in_cells_and_have_no_more_than_ends_in_common(lines in prop::collection::vec(line(), 1..5)) {
        let found = lines_of(lines.clone(), (7, 6));
        let all = found.segments();
        prop_assert!(all.windows(2).all(|pair| pair[0] < pair[1]));
        for (i, &[a, b]) in all.iter().enumerate() {
            prop_assert!(a < b && (0..=24).contains(&a.x.min(b.x)) && a.x.max(b.x) <= 24 && a.y >= 0 && b.y <= 20);
            let within = |p: i64, q: i64| p.max(q) <= p.min(q).div_euclid(4) * 4 + 4;
            prop_assert!(within(a.x, b.x) && within(a.y, b.y), "{:?} to {:?}", a, b);
            for &other in &all[i + 1..] {
                prop_assert!(!clash([a, b], other), "{:?} to {:?}, {:?}", a, b, other);
            }
        }
        // The order of lines and their directions decide nothing.
        let turned = lines.into_iter().rev().map(|line| line.into_iter().rev().collect()).collect();
        let again = lines_of(turned, (7, 6));
        prop_assert_eq!(again.segments(), all);
        // What is noded stays.
        prop_assert_eq!(noding::node(all.to_vec()), all);
    }
}

#[test]
fn places_are_rounded_along_rows_and_columns() {
    let place = |x, y| Place { y, x };
    let found = lines_of(vec![vec![(0.1, 0.2), (2.6, 1.1)]], (5, 5));
    // x = 1 at y = 0.524, x = 2 at 0.884, y = 1 at x = 2.322.
    let expected = [
        [place(0, 1), place(4, 2)],
        [place(4, 2), place(8, 4)],
        [place(8, 4), place(9, 4)],
        [place(9, 4), place(10, 4)],
    ];
    assert_eq!(found.segments(), expected);
    let LineCounts { lines, left_out, segments, largest_rounding } = found.counts();
    assert_eq!((lines, left_out, segments), (1, 0, 4));
    assert!((largest_rounding - 0.1f64.hypot(0.1)).abs() < 0.01 || largest_rounding < 0.1768, "{largest_rounding}");
}

#[test]
fn lines_that_come_to_nothing_are_counted() {
    let nothing = vec![vec![], vec![(1.0, 1.0)], vec![(1.01, 1.0), (1.02, 1.0)], vec![(-5.0, 2.0), (-1.0, 9.0)]];
    let found = lines_of([nothing, vec![vec![(0.0, 0.0), (1.0, 1.0)], vec![(1.0, 1.0), (0.0, 0.0)]]].concat(), (4, 4));
    assert_eq!((found.counts().lines, found.counts().left_out, found.segments().len()), (6, 4, 1));
    assert_eq!(found.named(), lines_of(vec![vec![(0.0, 0.0), (1.0, 1.0)]], (4, 4)).named());
}

#[test]
fn what_cannot_be_put_on_the_lattice_is_refused() {
    let far = Polylines::new(vec![vec![(0.0, 0.0), (1e300, 0.0)]]);
    assert!(matches!(Breaklines::new(&far, (4, 4), 0.5), Err(LinesError::TooFar { .. })));
    let long = Polylines::new(vec![(0..6000).map(|i| (0.0, f64::from(i % 2) * 999.0)).collect()]);
    assert_eq!(Breaklines::new(&long, (4, 1000), 0.5), Err(LinesError::TooMany));
    for shift in [-0.5, 17.0, f64::NAN] {
        assert!(matches!(Breaklines::new(&Polylines::default(), (4, 4), shift), Err(LinesError::Shift(_))));
    }
}
