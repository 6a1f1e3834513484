//! Edges between places, held against answers that take their time.

use proptest::prelude::*;

use super::*;
use crate::base::tiling::TileGrid;
use crate::base::{Heights, Polylines};
use crate::kernel::breaklines::tests::set;
use crate::kernel::breaklines::{Breaklines, Pieces};

#[test]
fn the_distance_to_an_edge_is_exact() {
    let at = |x, y| Point { x, y };
    let cell = FINE;
    // Beside it, before it and behind it.
    for (place, cells) in [(at(8, 4), 1.0), (at(-4, 0), 1.0), (at(20, 3), 1.25)] {
        let shift = (cells * cell as f64) as i64;
        let edge = [at(0, 0), at(16, 0)];
        assert!(is_near(place, edge, shift) && !is_near(place, edge, shift - 1));
    }
    assert!(is_near(at(2, 2), [at(0, 0), at(9, 9)], 0));
}

impl Along<'_> {
    /// [`Along::fewest`] without a short answer, and without passing over what is reached.
    fn fewest_the_long_way(&self, obstacles: &Obstacles) -> Vec<usize> {
        let last = self.vertices.len() - 1;
        let mut before = vec![NONE; last + 1];
        let mut layer = vec![0];
        while before[last] == NONE {
            let mut next = Vec::new();
            for &from in layer.iter().rev() {
                let (mut to, mut refused) = (from + 1, 0);
                while to <= last && refused < PATIENCE {
                    let is_reached = before[to] != NONE;
                    let may_join = is_reached || to == from + 1 || self.may_join(from, to, false, obstacles);
                    if may_join && !is_reached {
                        before[to] = from;
                        next.push(to);
                    }
                    refused = if may_join { 0 } else { refused + 1 };
                    to += 1;
                }
            }
            next.sort_unstable();
            layer = next;
        }
        let ends = std::iter::successors(Some(last), |&i| Some(before[i]).filter(|&b| b != NONE));
        let mut chain: Vec<usize> = ends.collect();
        chain.reverse();
        chain
    }

    /// How many edges are known at once; each of them must be one that may be used.
    fn count_sure(&self, obstacles: &Obstacles) -> usize {
        let mut around = Around::new(self, obstacles);
        let last = self.vertices.len() - 1;
        let mut count = 0;
        for from in 0..=last {
            let mut reach = Reach::new(from);
            for to in from + 2..=last {
                if reach.is_sure(to, &mut around) {
                    let ends = [from, to].map(|place| self.vertices[place]);
                    assert!(self.is_free(from, to, obstacles), "{ends:?} is sure, and may not be used");
                    count += 1;
                }
            }
        }
        count
    }
}

const SIZE: (usize, usize) = (46, 38);

/// Ground that is level, tilted, folded or rough, some of it missing.
fn ground(kind: u8, seed: u32, gaps: u32) -> Tile {
    let hash = |i: usize| (i as u32).wrapping_mul(2_654_435_761).wrapping_add(seed).wrapping_mul(0x9e37_79b9);
    let height = |i: usize| {
        let (x, y) = ((i % SIZE.0) as f64, (i / SIZE.0) as f64);
        let noise = f64::from(hash(i) >> 22) / 1024.0;
        match kind {
            0 => 7.5,
            1 => 0.3 * x - 0.7 * y,
            2 => (x - 20.0).abs() + 0.3 * noise,
            3 => (x / 9.0).sin() * 2.0 + y / 8.0,
            _ => 4.0 * noise,
        }
    };
    let mut tile = Tile::from_heights(SIZE.0, SIZE.1, Heights::F64((0..SIZE.0 * SIZE.1).map(height).collect()));
    let missing = (0..SIZE.0 * SIZE.1).filter(|&i| hash(i + 1) >> 22 < gaps);
    if gaps > 0 {
        tile.validity.reset(Window { column: 0, row: 0, width: SIZE.0, height: SIZE.1 }, SIZE);
        missing.for_each(|i| tile.validity.mark((i % SIZE.0) as i32, (i / SIZE.0) as i32));
    }
    tile
}

fn line() -> impl Strategy<Value = Vec<(f64, f64)>> {
    let number = |last: usize| {
        let last = last as f64 - 1.0;
        prop_oneof![3 => -1.0..last + 1.0, 1 => (0.0..last).prop_map(f64::round), 1 => prop_oneof![Just(0.0), Just(last)]]
    };
    let place = (number(SIZE.0), number(SIZE.1));
    (prop::collection::vec(place, 2..5), 0..4u8).prop_map(|(mut line, way)| {
        for i in 1..line.len() {
            match way {
                // Back beside itself, and along a row.
                0 => line[i] = (line[i - 1].0 + 9.0 * (-1f64).powi(i as i32), line[i - 1].1 + 0.3),
                1 => line[i].1 = line[i - 1].1,
                _ => {}
            }
        }
        line
    })
}

proptest! {
    #![proptest_config(crate::testing::cases(96, 2000))]

    #[test]
    fn short_answers_are_the_long_ones(
        lines in prop::collection::vec(line(), 1..5),
        (kind, seed, gaps) in (0..5u8, any::<u32>(), prop_oneof![3 => Just(0u32), 1 => Just(2)]),
        (shift, tolerance) in (prop_oneof![Just(0.0), Just(0.5), Just(0.1), 0.0..4.0f64], prop_oneof![Just(0.0), 0.01..1.5f64]),
        points in prop::collection::vec((0..SIZE.0, 0..SIZE.1), 0..2),
    ) {
        let tile = ground(kind, seed, gaps);
        let lines = Breaklines::new(&[set(Polylines::new(lines), shift)], SIZE).expect("near lines");
        let pieces = Pieces::new(&lines, lines.segments(), &[], None, &TileGrid::new(SIZE.0, SIZE.1, 0), SIZE);
        let window = Window { column: 0, row: 0, width: SIZE.0, height: SIZE.1 };
        let cancel = CancelToken::default();
        let task = Thinning { tile: &tile, window, size: SIZE, tolerance, lines: &lines, points: &points, cancel: &cancel };
        for (_, of_tile) in pieces.by_tile() {
            let pieces: Vec<Vec<Point>> =
                of_tile.iter().map(|stretch| stretch.places.iter().map(|&p| task.local(p)).collect()).collect();
            let obstacles = task.obstacles(&pieces);
            for (number, stretch) in (0..).zip(of_tile) {
                // Off the ground heights are of no matter here.
                let vertex = |&place: &_| task.vertex(place).unwrap_or(Vertex { at: task.local(place), height: 0.0 });
                let vertices: Vec<Vertex> = stretch.places.iter().map(vertex).collect();
                let along = task.along(&vertices, number, stretch.sets);
                prop_assert_eq!(along.fewest(&obstacles), along.fewest_the_long_way(&obstacles));
                along.count_sure(&obstacles);
            }
        }
    }
}

/// Where it counts most edges are known at once: on level and on tilted ground, along a row and across.
#[test]
fn edges_over_planes_are_known_at_once() {
    for (kind, shift) in [(0, 0.5), (1, 0.5), (1, 16.0)] {
        let tile = ground(kind, 1, 0);
        for line in [vec![(1.2, 2.3), (44.1, 35.2)], vec![(1.0, 7.0), (44.0, 7.0)], vec![(3.1, 36.2), (7.9, 1.1)]] {
            let lines = Breaklines::new(&[set(Polylines::new(vec![line]), shift)], SIZE).expect("near lines");
            let pieces = Pieces::new(&lines, lines.segments(), &[], None, &TileGrid::new(SIZE.0, SIZE.1, 0), SIZE);
            let window = Window { column: 0, row: 0, width: SIZE.0, height: SIZE.1 };
            let cancel = CancelToken::default();
            let task = Thinning {
                tile: &tile,
                window,
                size: SIZE,
                tolerance: 0.1,
                lines: &lines,
                points: &[],
                cancel: &cancel,
            };
            let (_, pieces) = pieces.by_tile().next().expect("a line");
            let piece: Vec<Point> = pieces[0].places.iter().map(|&p| task.local(p)).collect();
            let vertices: Vec<Vertex> =
                pieces[0].places.iter().map(|&place| task.vertex(place).expect("a height")).collect();
            let obstacles = task.obstacles(std::slice::from_ref(&piece));
            let along = task.along(&vertices, 0, pieces[0].sets);
            let all = (vertices.len() - 1) * (vertices.len() - 2) / 2;
            let sure = along.count_sure(&obstacles);
            assert!(sure * 10 > all * 9, "{sure} of {all}");
        }
    }
}
