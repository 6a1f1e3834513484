//! Trimmed meshes against an arrangement of all their lines: every piece of the plane is looked at.

use std::collections::HashMap;

use num_rational::Ratio;
use proptest::prelude::*;
use rayon::prelude::*;

use super::ground::{Change, change};
use super::scene::{Mesh, NORTH_UP, SOUTH_UP, Scene};
use crate::verify::GroundOptions;
use crate::verify::grid::orientation;

type Number = Ratio<i128>;
type Point = (Number, Number);

fn point((x, y): (i64, i64)) -> Point {
    (Number::from(i128::from(x)), Number::from(i128::from(y)))
}

fn turn(a: Point, b: Point, c: Point) -> i32 {
    let turn = (b.0 - a.0) * (c.1 - a.1) - (b.1 - a.1) * (c.0 - a.0);
    i32::from(turn > Number::from(0)) - i32::from(turn < Number::from(0))
}

/// Cuts a convex polygon along a line.
fn cut(polygon: Vec<Point>, (a, b): (Point, Point)) -> Vec<Vec<Point>> {
    let turns: Vec<i32> = polygon.iter().map(|p| turn(a, b, *p)).collect();
    if !(turns.contains(&1) && turns.contains(&-1)) {
        return vec![polygon];
    }
    let side = |keep: i32| {
        let mut out = Vec::new();
        for i in 0..polygon.len() {
            let j = (i + 1) % polygon.len();
            let (p, q) = (polygon[i], polygon[j]);
            if turns[i] != -keep {
                out.push(p);
            }
            if turns[i] * turns[j] < 0 {
                let far = |r: Point| (b.0 - a.0) * (r.1 - a.1) - (b.1 - a.1) * (r.0 - a.0);
                let share = far(p) / (far(p) - far(q));
                out.push((p.0 + (q.0 - p.0) * share, p.1 + (q.1 - p.1) * share));
            }
        }
        out
    };
    vec![side(1), side(-1)]
}

/// What is asked of trimmed meshes, piece by piece.
fn is_right(scene: &Scene, cells: i64) -> bool {
    let (width, height) = (scene.width as i64, scene.height as i64);
    let Mesh { places, faces, .. } = &scene.mesh;
    let used = |v: usize| faces.iter().flatten().any(|c| *c == v as u64);
    let alone = |v: usize| !places[..v].contains(&places[v]);
    let inside = |(x, y): (i64, i64)| (0..4 * width - 3).contains(&x) && (0..4 * height - 3).contains(&y);
    if !(0..places.len()).all(|v| used(v) && alone(v) && inside(places[v])) {
        return false;
    }
    let triangles: Vec<[(i64, i64); 3]> = faces.iter().map(|f| f.map(|v| places[v as usize])).collect();
    // Counter-clockwise on a map whose y runs up.
    if triangles.iter().any(|[a, b, c]| orientation(*a, *b, *c) >= 0) {
        return false;
    }
    let mut uses: HashMap<(u64, u64), [usize; 2]> = HashMap::new();
    for face in faces {
        for (p, q) in [(face[0], face[1]), (face[1], face[2]), (face[2], face[0])] {
            uses.entry((p.min(q), p.max(q))).or_default()[usize::from(p > q)] += 1;
        }
    }
    if uses.values().any(|u| u[0] > 1 || u[1] > 1) {
        return false;
    }
    let alone = uses.iter().filter(|(_, u)| u[0] + u[1] == 1);
    let rim: Vec<(Point, Point)> =
        alone.map(|((p, q), _)| (point(places[*p as usize]), point(places[*q as usize]))).collect();

    let exists = |c: i64, r: i64| (0..width).contains(&c) && (0..height).contains(&r);
    let valid = |c: i64, r: i64| exists(c, r) && !scene.samples[(r * width + c) as usize].is_nan();
    let near = |c: i64, r: i64| {
        let square = (r - cells..=r + cells).flat_map(|y| (c - cells..=c + cells).map(move |x| (x, y)));
        square.into_iter().any(|(x, y)| exists(x, y) && !valid(x, y))
    };
    let covers = |t: &[(i64, i64); 3], p: Point| {
        let turns = [(0, 1), (1, 2), (2, 0)].map(|(i, j)| turn(point(t[i]), point(t[j]), p));
        (turns.iter().all(|t| *t <= 0), turns.iter().all(|t| *t < 0))
    };
    let is_ground = |c: i64, r: i64| {
        (r - 1..=r).any(|y| {
            (c - 1..=c).any(|x| {
                [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)].iter().filter(|s| valid(s.0, s.1)).count() >= 3
            })
        })
    };
    for (c, r) in (0..height).flat_map(|r| (0..width).map(move |c| (c, r))) {
        let covered = triangles.iter().any(|t| covers(t, point((4 * c, 4 * r))).0);
        if covered && !valid(c, r) || !covered && valid(c, r) && is_ground(c, r) && !near(c, r) {
            return false;
        }
    }

    // The pieces, all of which are convex: bounded by whole lines, so that neighbours have whole sides in common.
    let corner = |x: i64, y: i64| point((4 * x, 4 * y));
    let mut lines: Vec<(Point, Point)> = Vec::new();
    lines.extend((0..height).map(|r| (corner(0, r), corner(1, r))));
    lines.extend((0..width).map(|c| (corner(c, 0), corner(c, 1))));
    for (c, r) in (0..height - 1).flat_map(|r| (0..width - 1).map(move |c| (c, r))) {
        lines.push((corner(c, r), corner(c + 1, r + 1)));
        lines.push((corner(c, r + 1), corner(c + 1, r)));
    }
    for [a, b, c] in &triangles {
        lines.extend([(point(*a), point(*b)), (point(*b), point(*c)), (point(*c), point(*a))]);
    }
    let mut pieces = vec![vec![corner(-1, -1), corner(width, -1), corner(width, height), corner(-1, height)]];
    for line in lines {
        pieces = pieces.into_iter().flat_map(|piece| cut(piece, line)).collect();
    }
    let inner = |p: &[Point]| {
        let third = Number::new(1, 3);
        ((p[0].0 + p[1].0 + p[2].0) * third, (p[0].1 + p[1].1 + p[2].1) * third)
    };
    let four = Number::from(4);
    let (mut ground, mut count) = (Vec::new(), Vec::new());
    for piece in &pieces {
        let p = inner(piece);
        let (c, r) = ((p.0 / four).floor().to_integer() as i64, (p.1 / four).floor().to_integer() as i64);
        let (u, v) = (p.0 - Number::from(i128::from(4 * c)), p.1 - Number::from(i128::from(4 * r)));
        let corners = [(c, r), (c + 1, r), (c, r + 1), (c + 1, r + 1)];
        let is_ground = match corners.map(|(c, r)| valid(c, r)) {
            [true, true, true, true] => true,
            [false, true, true, true] => u + v > four,
            [true, false, true, true] => v > u,
            [true, true, false, true] => u > v,
            [true, true, true, false] => u + v < four,
            _ => false,
        };
        let is_core = corners.iter().all(|&(c, r)| valid(c, r) && !near(c, r));
        let faces = triangles.iter().filter(|t| covers(t, p).1).count();
        if faces > usize::from(is_ground) || faces < usize::from(is_core) {
            return false;
        }
        ground.push(is_ground);
        count.push(faces);
    }
    let mut sides: HashMap<(Point, Point), Vec<usize>> = HashMap::new();
    for (index, piece) in pieces.iter().enumerate() {
        for (p, q) in (0..piece.len()).map(|i| (piece[i], piece[(i + 1) % piece.len()])) {
            sides.entry((p.min(q), p.max(q))).or_default().push(index);
        }
    }
    let mut group: Vec<usize> = (0..pieces.len()).collect();
    let mut open: Vec<bool> = ground.iter().map(|g| !g).collect();
    for ((p, q), owners) in &sides {
        let [a, b] = owners[..] else { continue };
        let on = |(s, t): &(Point, Point)| {
            let on = |r: Point| {
                turn(*s, *t, r) == 0
                    && s.0.min(t.0) <= r.0
                    && r.0 <= s.0.max(t.0)
                    && s.1.min(t.1) <= r.1
                    && r.1 <= s.1.max(t.1)
            };
            on(*p) && on(*q)
        };
        if count[a] == 1 && count[b] == 1 && rim.iter().any(on) {
            return false;
        }
        if count[a] + count[b] == 0 {
            if ground[a] && ground[b] {
                let (into, from) = (group[a], group[b]);
                group.iter_mut().filter(|g| **g == from).for_each(|g| *g = into);
            } else {
                (open[a], open[b]) = (true, true);
            }
        }
    }
    let bare = (0..pieces.len()).filter(|&i| ground[i] && count[i] == 0);
    bare.into_iter().all(|i| (0..pieces.len()).any(|j| group[j] == group[i] && open[j]))
}

impl Mesh {
    /// Splits a face alone in the middle of an edge, where that is on the lattice: a T-junction if there is a face beyond.
    fn split(&mut self, face: usize, corner: usize) {
        let [a, b, c] = [0, 1, 2].map(|i| self.faces[face][(corner + i) % 3]);
        let [p, q] = [a, b].map(|v| self.places[v as usize]);
        let middle = ((p.0 + q.0) / 2, (p.1 + q.1) / 2);
        if (p.0 + q.0) % 2 == 0 && (p.1 + q.1) % 2 == 0 && !self.places.contains(&middle) {
            let new = self.places.len() as u64;
            self.places.push(middle);
            self.heights.push(0.0);
            self.faces[face] = [a, new, c];
            self.faces.push([new, b, c]);
        }
    }
}

prop_compose! {
    fn a_trimmed_scene()(width in 3usize..6, height in 3usize..6, share in 0.0f64..0.3)(
        size in Just((width, height)),
        transform in prop_oneof![Just(NORTH_UP), Just(SOUTH_UP)],
        gaps in proptest::collection::vec(0.0f64..1.0, width * height)
            .prop_map(move |s| s.into_iter().map(|gap| if gap < share { f64::NAN } else { 0.0 }).collect::<Vec<_>>()),
        diagonals in any::<u64>(),
        points in proptest::collection::vec((0i64..17, 0i64..17), 0..3),
        dropped in proptest::collection::vec(any::<proptest::sample::Index>(), 0..6),
        junctions in proptest::collection::vec(any::<[proptest::sample::Index; 2]>(), 0..2),
        changes in proptest::collection::vec(change(), 0..3),
    ) -> Scene {
        let mut state = diagonals | 1;
        let mut mesh = Mesh::of_cells(size.0, &gaps, || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            state >> 63 == 1
        });
        points.into_iter().for_each(|place| if mesh.covers(place) { mesh.insert(place, 1.0) });
        for index in dropped {
            if !mesh.faces.is_empty() {
                mesh.change(Change::Drop(index.index(mesh.faces.len())));
            }
        }
        for [face, corner] in junctions {
            if !mesh.faces.is_empty() {
                mesh.split(face.index(mesh.faces.len()), corner.index(3));
            }
        }
        changes.into_iter().for_each(|change| { mesh.change(change); });
        mesh.remove(&[]);
        Scene { width: size.0, height: size.1, transform, samples: gaps, mesh }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 512, ..ProptestConfig::default() })]
    #[test]
    fn what_passes_is_what_the_pieces_of_the_plane_tell(scene in a_trimmed_scene(), trim in 1u32..3, rows in 1usize..6) {
        let verdict = scene.judge_ground(1e6, GroundOptions { fill_holes: 0, trim }, rows).unwrap();
        prop_assert_eq!(verdict.passes(), is_right(&scene, i64::from(trim)), "{}", verdict);
    }
}

/// Every raster of 3 × 3 samples, and every choice of the faces of its cells.
#[test]
fn every_choice_of_faces_over_nine_samples_is_judged_rightly() {
    let passed: usize = (0..512u32)
        .into_par_iter()
        .map(|mask| {
            let samples: Vec<f64> = (0..9).map(|i| if mask >> i & 1 == 1 { 0.0 } else { f64::NAN }).collect();
            let whole = Mesh::of_cells(3, &samples, || mask % 3 > 0);
            let choices = 0..1u32 << whole.faces.len();
            let judge = |choice: u32| {
                let mut mesh = whole.clone();
                let chosen = whole.faces.iter().enumerate().filter(|(i, _)| choice >> i & 1 == 1);
                mesh.faces = chosen.map(|(_, face)| *face).collect();
                mesh.remove(&[]);
                let scene = Scene { width: 3, height: 3, transform: NORTH_UP, samples: samples.clone(), mesh };
                let passes = scene.judge_ground(0.0, GroundOptions { fill_holes: 0, trim: 1 }, 2).unwrap().passes();
                assert_eq!(passes, is_right(&scene, 1), "{mask:b} {choice:b}");
                passes
            };
            choices.filter(|choice| judge(*choice)).count()
        })
        .sum();
    assert!(passed > 512, "{passed}");
}
