//! What rims promise: corners, owners, sides held to their share.

use super::*;
use crate::base::Heights;

fn bumpy(width: usize, height: usize) -> Tile {
    let heights = (0..width * height).map(|i| ((i * 2_654_435_761) >> 7 & 15) as f32).collect();
    Tile::from_heights(width, height, Heights::F32(heights))
}

fn rim(tile: &Tile, last: (bool, bool)) -> Rim {
    rim_of(tile, Sides::FINAL, last)
}

fn rim_of(tile: &Tile, sides: Sides, (last_column, last_row): (bool, bool)) -> Rim {
    let place = TilePlace { last_column, last_row, ..TilePlace::alone(tile.width(), tile.height()) };
    Rim::with_sides(
        tile,
        3.0,
        sides,
        &[],
        &TileChains::default(),
        &place,
        &mut MinLink::default(),
        &CancelToken::default(),
    )
    .expect("nobody cancels")
}

#[test]
fn sides_are_held_to_their_share_and_links_are_short() {
    let wave = |i: usize| ((i % 33) as f64 * 0.7).sin() * 9.0 + ((i / 33) as f64 * 0.5).cos() * 8.0;
    let tile = Tile::from_heights(33, 21, Heights::F64((0..33 * 21).map(wave).collect()));
    for (share, short_links) in [(1.0, false), (0.5, false), (1.0, true), (0.5, true)] {
        let rim = rim_of(&tile, Sides { share, short_links }, (false, true));
        let walk = &rim.domain.loops[0];
        for (i, &from) in walk.iter().enumerate() {
            let [p, q] = [from, walk[(i + 1) % walk.len()]].map(|v| rim.domain.vertices[v as usize]);
            let (dx, dy) = ((q.at.x - p.at.x) / STEPS, (q.at.y - p.at.y) / STEPS);
            let cells = dx.abs().max(dy.abs());
            let quarter = if dy == 0 { 8 } else { 5 };
            assert!(!short_links || cells <= quarter, "a link of {cells} cells");
            for k in 1..cells {
                let at = Point { x: p.at.x + dx / cells * k * STEPS, y: p.at.y + dy / cells * k * STEPS };
                let (column, row) = at.sample().expect("a sample");
                let height = p.height + (q.height - p.height) * f64::from(k) / f64::from(cells);
                assert!((tile.at(column, row) - height).abs() <= share * 3.0 + 1e-9, "{column}, {row}");
            }
        }
    }
    let count = |share, short_links| rim_of(&tile, Sides { share, short_links }, (true, true)).domain.vertices.len();
    assert!(count(0.5, false) > count(1.0, false));
    assert!(count(0.5, true) >= count(0.5, false));
}

#[test]
fn the_loop_goes_around_the_tile_with_the_ground_to_its_left() {
    let tile = bumpy(13, 9);
    for last in [(false, false), (true, false), (false, true), (true, true)] {
        let rim = rim(&tile, last);
        assert_eq!(rim.domain.area(), 2 * 16 * 12 * 8);
        assert_eq!(rim.owned.total() as usize + rim.foreign.len(), rim.domain.vertices.len());
        assert_eq!(rim.domain.loops[0].len(), rim.domain.vertices.len());
        let mut places: Vec<Point> = rim.domain.vertices.iter().map(|v| v.at).collect();
        places.sort();
        places.dedup();
        assert_eq!(places.len(), rim.domain.vertices.len());
    }
}

#[test]
fn neighbours_agree_on_their_seam() {
    let left = bumpy(13, 9);
    // The right neighbour's west side has the same samples as the left one's east side.
    let mut heights = vec![0.0; 13 * 9];
    (0..9).for_each(|row| heights[row * 13] = left.at(12, row) as f32);
    let right = Tile::from_heights(13, 9, Heights::F32(heights));
    agree(&left, &right);
    // And the same weights, whatever theirs are elsewhere.
    let weight = |row: usize| [0.0, 0.3, 4.0][row % 3];
    let weights = |column: usize, elsewhere: f64| {
        (0..13 * 9).map(|i| if i % 13 == column { weight(i / 13) } else { elsewhere }).collect()
    };
    agree(&left.clone().with_weights(weights(12, 0.7)), &right.clone().with_weights(weights(0, 9.0)));
    // Beside a tile without weights, where one has them elsewhere only: for a hole that it bridges.
    let elsewhere = (0..13 * 9).map(|i| if i % 13 == 0 { 1.0 } else { 0.0 }).collect();
    agree(&left, &right.with_weights(elsewhere));
}

fn agree(left: &Tile, right: &Tile) {
    for sides in [Sides::FINAL, Sides { share: 0.5, short_links: true }] {
        agree_with(left, right, sides);
    }
}

fn agree_with(left: &Tile, right: &Tile, sides: Sides) {
    let (a, b) = (rim_of(left, sides, (false, false)), rim_of(right, sides, (true, false)));
    let at = |i: u32| b.domain.vertices[(b.owned.before_west() + i) as usize];
    let borrowed = a.foreign.iter().zip(&a.domain.vertices[a.owned.total() as usize..]);
    let mut seen = 0;
    for (foreign, vertex) in borrowed {
        if let Foreign::East(ordinal) = foreign {
            assert_eq!((at(*ordinal).at.y, at(*ordinal).height), (vertex.at.y, vertex.height));
            seen += 1;
        }
    }
    assert_eq!(seen, b.owned.west);
}
