//! What is found in single precision first, against what doubles find by themselves.

use super::super::scan::Scanner;
use crate::base::lattice::{Point, STEPS, orient};
use crate::base::mesh::Vertex;
use crate::base::{Heights, Tile};

const SIDE: i32 = 150;

/// Steps through numbers that look like chance.
struct Chance(u64);

impl Chance {
    fn below(&mut self, end: i32) -> i32 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        ((self.0 >> 33) % end as u64) as i32
    }
}

/// Heights that tie, heights that do not, waves, a level, the largest numbers there are, the smallest, and what is small far
/// away from zero.
const GROUNDS: [fn(i32, i32) -> f32; 7] = [
    |column, row| ((column * 31 + row * 17) % 7) as f32,
    |column, row| 3000.0 + ((column * 7919 + row * 104_729) % 1009) as f32 * 0.37,
    |column, row| (column as f32 * 0.1).sin() * 40.0 + (row as f32 * 0.07).cos() * 30.0,
    |_, _| 5.0,
    |column, row| if (column + row) % 2 == 0 { 3e38 } else { -3e38 },
    |column, row| (column * row % 11) as f32 * 1e-44,
    |column, row| 1e6 + (column * row % 5) as f32 * 0.0625,
];

#[test]
fn singles_find_the_candidates_of_doubles() {
    let (mut chance, mut found, mut none) = (Chance(7), 0, 0);
    for ground in GROUNDS {
        let heights: Vec<f32> = (0..SIDE * SIDE).map(|i| ground(i % SIDE, i / SIDE)).collect();
        let in_doubles = Heights::F64(heights.iter().map(|&h| f64::from(h)).collect());
        let range = heights.iter().fold((f32::MAX, f32::MIN), |(low, high), &h| (low.min(h), high.max(h)));
        let range = f64::from(range.1) - f64::from(range.0);
        let side = SIDE as usize;
        let tiles = [Heights::F32(heights), in_doubles].map(|heights| Tile::from_heights(side, side, heights));
        for i in 0..1500 {
            // Large triangles and small ones, by turns, on samples or between them.
            let size = [SIDE, 40, 9][i % 3];
            let origin = [chance.below(SIDE - size + 1), chance.below(SIDE - size + 1)];
            let steps = if i % 2 == 0 { STEPS } else { 1 };
            let corners = [(); 3].map(|()| {
                let mut place = |from: i32| from * STEPS + chance.below((size - 1) * STEPS / steps + 1) * steps;
                let at = Point { x: place(origin[0]), y: place(origin[1]) };
                let height = tiles[1].at((at.x / STEPS) as usize, (at.y / STEPS) as usize);
                // Some have heights of their own.
                let off = [0.0, 0.0, 0.1, 1e-9][chance.below(4) as usize];
                Vertex { at, height: height + off * range }
            });
            let [a, b, c] = corners.map(|v| v.at);
            if orient(a, b, c) <= 0 {
                continue;
            }
            let locked = [i % 5 == 0, false, i % 7 == 0];
            for share in [0.0, 0.01, 0.3, 0.9] {
                let tolerance = range * share;
                let [singles, doubles] =
                    tiles.each_ref().map(|tile| Scanner { tile, tolerance }.candidate(corners, locked));
                assert_eq!(singles, doubles, "{corners:?} at {tolerance}");
                *if singles.is_some() { &mut found } else { &mut none } += 1;
            }
        }
    }
    assert!(found > 5000 && none > 3000, "{found} found, {none} times none");
}
