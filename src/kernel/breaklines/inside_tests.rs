//! What is inside of outlines, against a count of what lies to the left.

use proptest::prelude::*;

use super::lakes::{PARTS, across};
use super::*;
use crate::base::lattice::Point;
use crate::base::{Cell, Heights, LineKind, LineSet, Polylines};

const SIZE: (usize, usize) = (9, 7);

/// Outlines through lattice places, which are closed.
fn set(rings: &[Vec<(i32, i32)>], features: &[u64]) -> LineSet {
    let place = |&(x, y): &(i32, i32)| (f64::from(x) / 4.0, f64::from(y) / 4.0);
    let lines = Polylines::new(rings.iter().map(|ring| ring.iter().map(place).collect()).collect()).closed();
    LineSet { kind: LineKind::Cutline, lines: lines.of_features(features.to_vec()), shift: 0.0 }
}

fn outlines(rings: &[Vec<(i32, i32)>], features: &[u64]) -> Breaklines {
    Breaklines::new(&[set(rings, features)], SIZE).expect("near lines")
}

/// All noded segments, with how often each is run over.
fn noded(rings: &[Vec<(i32, i32)>], features: &[u64]) -> Vec<pieces::Piece> {
    let mut found = Vec::new();
    found.extend(cut(&[set(rings, features)], SIZE).expect("near lines").0);
    noding::node(found)
}

proptest! {
    /// In the middle of each row of places, half a step and a little to the right of every place.
    #[test]
    fn it_is_inside_where_an_odd_number_of_sides_is_to_the_left(
        rings in prop::collection::vec(prop::collection::vec((-6i32..40, -6i32..32), 3..7), 1..4),
    ) {
        // Rings of two features: the first has one, the second all others.
        let features: Vec<u64> = (0..rings.len()).map(|i| u64::from(i > 0)).collect();
        let lines = outlines(&rings, &features);
        let inside = lines.inside().expect("a cutline");
        // Noded together, as sides of either are led through places of the other.
        let all = noded(&rings, &features);
        let is_odd = |row: i64, x: i64, feature: u64| {
            let of = |piece: &&pieces::Piece| {
                let [a, b] = piece.ends;
                features[piece.line as usize] == feature && (a.y..b.y).contains(&row) && across([a, b], row, 1) < x
            };
            all.iter().filter(of).map(|piece| piece.times).sum::<u32>() % 2 == 1
        };
        let mut tile = Tile::from_heights(SIZE.0, SIZE.1, Heights::F64(vec![0.0; SIZE.0 * SIZE.1]));
        let window = Window { column: 0, row: 0, width: SIZE.0, height: SIZE.1 };
        tile.validity.reset(window, SIZE);
        lines.cut(&mut tile, window);
        let mut touched = vec![false; SIZE.0 * SIZE.1];
        for row in 0..4 * (SIZE.1 as i64 - 1) {
            for x in 0..4 * (SIZE.0 as i64 - 1) {
                // No side is so near.
                let at = PARTS * x + PARTS / 2 + 1;
                let expected = is_odd(row, at, 0) || is_odd(row, at, 1);
                // An upright edge of one step, seen from both sides, where it is on no side.
                let edge = [Place { y: row, x }, Place { y: row + 1, x }];
                let clear = |at: i64| !all.iter().any(|piece| {
                    let [a, b] = piece.ends;
                    (a.y..b.y).contains(&row) && across([a, b], row, 1) == at
                });
                if clear(PARTS * x) {
                    let expected = is_odd(row, PARTS * x, 0) || is_odd(row, PARTS * x, 1);
                    prop_assert_eq!(inside.sides(edge), [expected; 2], "{:?}", edge);
                }
                touched[(row / 4) as usize * SIZE.0 + (x / 4) as usize] |= expected;
            }
        }
        for i in (0..touched.len()).filter(|&i| touched[i]) {
            prop_assert_eq!(tile.validity().cell((i % SIZE.0) as i32, (i / SIZE.0) as i32), Cell::Whole);
        }
        // Along the border it is inside on one side alone.
        for &segment in lines.segments() {
            let [left, right] = inside.sides(segment);
            prop_assert!(left != right);
            prop_assert_ne!(lines.has_inside_to_left(segment), lines.has_inside_to_left([segment[1], segment[0]]));
        }
    }
}

#[test]
fn quadrants_of_samples_and_edges_of_cells() {
    // From sample (2, 1) to (6, 1) to (6, 5) to (2, 5).
    let lines = outlines(&[vec![(8, 4), (24, 4), (24, 20), (8, 20)]], &[0]);
    let mut tile = Tile::from_heights(SIZE.0, SIZE.1, Heights::F64(vec![0.0; SIZE.0 * SIZE.1]));
    let window = Window { column: 0, row: 0, width: SIZE.0, height: SIZE.1 };
    tile.validity.reset(window, SIZE);
    lines.cut(&mut tile, window);
    let quadrants = |column, row| (0..4).filter(|&q| tile.validity().touches(column, row, q)).collect::<Vec<_>>();
    assert_eq!(quadrants(2, 1), [0]);
    assert_eq!(quadrants(4, 1), [0, 1]);
    assert_eq!(quadrants(6, 3), [1, 2]);
    assert_eq!(quadrants(3, 3), [0, 1, 2, 3]);
    assert!(quadrants(1, 1).is_empty() && tile.validity().is_outside(1, 1) && !tile.validity().is_outside(2, 5));
    // A cell around it is ground that is cut away later, farther ones are none.
    assert_eq!([0, 1, 2].map(|column| tile.validity().cell(column, 2)), [Cell::Empty, Cell::Whole, Cell::Whole]);
    let inside = lines.inside().expect("a cutline");
    let is_left =
        |p: (i32, i32), q: (i32, i32)| inside.is_left_of(window, [Point { x: p.0, y: p.1 }, Point { x: q.0, y: q.1 }]);
    // Rows run down: to the left of the way to the right is what is below.
    assert!(is_left((8, 4), (12, 4)) && !is_left((12, 4), (8, 4)) && is_left((12, 20), (8, 20)));
    assert!(is_left((8, 8), (8, 4)) && !is_left((8, 4), (8, 8)) && is_left((24, 4), (24, 8)));
    assert!(is_left((8, 4), (12, 8)) && is_left((12, 8), (8, 4)) && !is_left((4, 0), (8, 4)));
}
