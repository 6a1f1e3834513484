//! Rasters with samples without a height: what the ground is, and every way to miss it.

use proptest::prelude::*;

use super::scene::{Mesh, NORTH_UP, SOUTH_UP, Scene, TURNED};
use crate::verify::Verdict;
use crate::verify::grid::orientation;

/// Patterns, `#` a height, `.` none: by name, with the samples of the ground, and those without any.
pub(super) const PATTERNS: [(&str, &[&str], (u64, u64)); 20] = [
    ("full", &["###", "###"], (6, 0)),
    ("hole", &["#####", "#####", "##.##", "#####", "#####"], (24, 0)),
    ("large hole", &["######", "#....#", "#.##.#", "#....#", "######"], (12, 8)),
    ("lake with an island", &["#######", "#.....#", "#.###.#", "#.###.#", "#.....#", "#######"], (18, 10)),
    ("islands", &["##..##", "##..##", "......", "###...", "###..#"], (14, 1)),
    ("pinch", &["##.", ".#.", ".##"], (5, 0)),
    ("other pinch", &["#..", "###", "..#"], (5, 0)),
    ("pinches of a half cell", &["##.##", ".###.", "..#..", ".##.."], (10, 0)),
    ("falling band", &["##...", "###..", "..###", "...##"], (10, 0)),
    ("rising band", &["...##", "..###", "###..", "##..."], (10, 0)),
    ("two holes that meet at a corner", &["######", "##.###", "###.##", "######"], (22, 0)),
    ("holes on either side of a sample", &["#####", "#####", "#.#.#", "#####", "#####"], (23, 0)),
    ("neck of single samples", &["##...##", "#######", "##...##"], (14, 1)),
    ("half cells, each way", &[".##.", "####", "####", ".##."], (12, 0)),
    ("lone half cells", &["##.##", "#...#", ".....", "#...#", "##.##"], (12, 0)),
    ("staircase", &["#.....", "##....", "###...", "####..", "#####."], (15, 0)),
    ("chessboard", &["#.#.#", ".#.#.", "#.#.#"], (0, 8)),
    ("first and last row and column", &[".....", ".###.", ".###.", "....."], (6, 0)),
    ("two", &["..", "##"], (0, 2)),
    ("none", &["...", "..."], (0, 0)),
];

/// Heights on no plane, NaN where there are none.
pub(super) fn samples(rows: &[&str]) -> Vec<f64> {
    let marks = rows.iter().flat_map(|row| row.bytes());
    marks.enumerate().map(|(i, mark)| if mark == b'#' { ((i * i) % 7) as f64 } else { f64::NAN }).collect()
}

fn pattern(name: &str) -> &'static [&'static str] {
    PATTERNS.iter().find(|p| p.0 == name).unwrap().1
}

pub(super) fn scene(rows: &[&str]) -> Scene {
    let (samples, width) = (samples(rows), rows[0].len());
    let mesh = Mesh::of_cells(width, &samples, || true);
    Scene { width, height: rows.len(), transform: NORTH_UP, samples, mesh }
}

fn spoilt(rows: &[&str], spoil: impl FnOnce(&mut Scene)) -> Verdict {
    let mut scene = scene(rows);
    assert!(scene.judge(0.0).unwrap().passes());
    spoil(&mut scene);
    let verdict = scene.judge(100.0).unwrap();
    assert!(!verdict.passes(), "{verdict}");
    verdict
}

impl Mesh {
    /// The vertex at a sample, made if there is none.
    fn at(&mut self, column: i64, row: i64) -> u64 {
        let place = (4 * column, 4 * row);
        let found = self.places.iter().position(|p| *p == place);
        found.unwrap_or_else(|| {
            self.places.push(place);
            self.heights.push(0.0);
            self.places.len() - 1
        }) as u64
    }

    /// Adds the triangle of three samples, whichever way round they are given.
    pub(super) fn add(&mut self, corners: [(i64, i64); 3]) {
        let [a, b, c] = corners.map(|(column, row)| self.at(column, row));
        let turn = orientation(self.places[a as usize], self.places[b as usize], self.places[c as usize]);
        self.faces.push(if turn < 0 { [a, b, c] } else { [a, c, b] });
    }

    /// Takes out the faces whose corners are all among these samples.
    pub(super) fn remove(&mut self, samples: &[(i64, i64)]) {
        let places = &self.places;
        let inside = |v: &u64| samples.iter().any(|&(c, r)| places[*v as usize] == (4 * c, 4 * r));
        self.faces.retain(|face| !face.iter().all(inside));
        let mut used: Vec<u64> = self.faces.iter().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        self.faces.iter_mut().flatten().for_each(|v| *v = used.binary_search(v).unwrap() as u64);
        self.places = used.iter().map(|&v| self.places[v as usize]).collect();
        self.heights = used.iter().map(|&v| self.heights[v as usize]).collect();
    }
}

#[test]
fn a_mesh_of_exactly_the_ground_passes_whatever_its_shape() {
    for (name, rows, (checked, without_ground)) in PATTERNS {
        for transform in [NORTH_UP, SOUTH_UP, TURNED] {
            let scene = Scene { transform, ..scene(rows) };
            let verdict = scene.judge(0.0).unwrap();
            assert!(verdict.passes(), "{name}: {verdict}");
            assert_eq!((verdict.checked, verdict.without_ground.count), (checked, without_ground), "{name}");
            assert_eq!(verdict.checked + verdict.nodata + verdict.without_ground.count, verdict.samples, "{name}");
            for bands in 1..=rows.len() {
                assert_eq!(scene.judge_in_bands(0.0, bands).unwrap(), verdict, "{name} by {bands} rows");
            }
        }
    }
}

#[test]
fn the_verdict_tells_what_was_asked_of_the_mesh() {
    let verdict = scene(&["##..", "##..", "...#"]).judge(0.0).unwrap();
    let text = verdict.to_string();
    assert!(
        text.contains(
            "ground: 4 samples; missing: 7; isolated, in no cell with three heights: 1, the first: column 3, row 2"
        ),
        "{text}"
    );
    assert!(text.contains("at every sample of the ground"), "{text}");
    let first = verdict.without_ground.first.unwrap();
    assert_eq!((first.column, first.row), (3, 2));
}

#[test]
fn every_face_is_missed() {
    for (name, rows, _) in PATTERNS {
        let whole = scene(rows);
        for face in 0..whole.mesh.faces.len() {
            let mut scene = whole.clone();
            scene.mesh.faces.remove(face);
            let verdict = scene.judge(0.0).unwrap();
            assert!(verdict.double_area < verdict.expected_double_area, "{name}, face {face}");
            assert!(verdict.boundary_gaps.count + verdict.unmatched_edges.count > 0, "{name}, face {face}: {verdict}");
        }
    }
}

#[test]
fn a_rectangle_over_a_hole_touches_nodata() {
    let verdict = spoilt(pattern("hole"), |s| s.mesh = Mesh::rectangle(5, 5));
    let first = verdict.touched_nodata.first.unwrap();
    assert_eq!((verdict.touched_nodata.count, first.sample.column, first.sample.row, first.face), (1, 2, 2, 0));
    assert!(verdict.to_string().contains("1 missing sample is in a triangle: column 2, row 2"), "{verdict}");
    // Four diagonals around the hole.
    assert_eq!(verdict.boundary_gaps.count, 4);
    assert_eq!(verdict.double_area - verdict.expected_double_area, 4 * 16);
}

#[test]
fn a_triangle_between_two_nodata_samples_is_found() {
    // The sample between the two is ground, and so are the half cells around; the triangle takes one nodata sample in.
    let verdict = spoilt(pattern("holes on either side of a sample"), |s| s.mesh.add([(1, 1), (1, 2), (2, 2)]));
    assert_eq!((verdict.touched_nodata.count, verdict.touched_nodata.first.unwrap().face), (1, 24));
    // It lies against the diagonal of a half cell, which was the ground's boundary.
    assert!(verdict.failures().len() > 2, "{verdict}");
}

#[test]
fn a_triangle_through_a_single_file_of_nodata_is_found() {
    let rows = ["#####", "#####", ".....", "#####", "#####"];
    let verdict = spoilt(&rows, |s| s.mesh.add([(1, 1), (2, 1), (1, 3)]));
    // Its edge runs past sample (1, 2) and the triangle touches nothing else without a height.
    assert_eq!(verdict.touched_nodata.count, 1);
    assert_eq!((verdict.unmatched_edges.count, verdict.boundary_gaps.count), (2, 1));
}

#[test]
fn ground_that_is_exceeded_without_touching_a_sample_is_found() {
    // A sliver of quarter cells, beyond the last column of heights.
    let rows = ["##...", "##...", "##..."];
    let verdict = spoilt(&rows, |s| {
        let first = s.mesh.places.len() as u64;
        s.mesh.places.extend([(9, 1), (10, 1), (9, 2)]);
        s.mesh.heights.extend([0.0; 3]);
        s.mesh.faces.push([first, first + 2, first + 1]);
    });
    assert_eq!((verdict.touched_nodata.count, verdict.overlapped.count, verdict.boundary_gaps.count), (0, 0, 0));
    assert_eq!((verdict.unmatched_edges.count, verdict.double_area - verdict.expected_double_area), (3, 1));
    let verdict = spoilt(&rows, |s| {
        // Against the coast: the edge there now has two faces, and the boundary goes elsewhere.
        let (a, b) = (s.mesh.at(1, 0), s.mesh.at(1, 1));
        let c = s.mesh.places.len() as u64;
        s.mesh.places.push((5, 2));
        s.mesh.heights.push(0.0);
        s.mesh.faces.push([a, b, c]);
    });
    assert_eq!((verdict.touched_nodata.count, verdict.boundary_gaps.count, verdict.unmatched_edges.count), (0, 1, 2));
}

#[test]
fn a_missing_half_cell_is_found_each_way() {
    let corners =
        [[(1, 0), (0, 1), (1, 1)], [(2, 0), (2, 1), (3, 1)], [(0, 2), (1, 2), (1, 3)], [(2, 2), (3, 2), (2, 3)]];
    for corners in corners {
        let verdict = spoilt(pattern("half cells, each way"), |s| {
            let at = corners.map(|(c, r)| s.mesh.at(c, r));
            let before = s.mesh.faces.len();
            s.mesh.faces.retain(|face| !face.iter().all(|v| at.contains(v)));
            assert_eq!(s.mesh.faces.len(), before - 1);
        });
        assert_eq!(verdict.expected_double_area - verdict.double_area, 16);
        // The diagonal is not followed; the two sides are, but are no boundary.
        assert_eq!((verdict.boundary_gaps.count, verdict.unmatched_edges.count), (1, 2));
        assert_eq!((verdict.uncovered.count, verdict.touched_nodata.count), (0, 0));
    }
}

#[test]
fn a_cell_that_is_cut_along_the_wrong_diagonal_is_found() {
    let verdict = spoilt(&["###", "##."], |s| {
        s.mesh.remove(&[(1, 0), (2, 0), (1, 1)]);
        s.mesh.add([(1, 0), (2, 0), (2, 1)]);
    });
    assert_eq!(verdict.touched_nodata.count, 1);
    assert_eq!(verdict.double_area, verdict.expected_double_area);
    assert!(verdict.boundary_gaps.count > 0 && verdict.unmatched_edges.count > 0);
}

#[test]
fn a_filled_hole_is_found() {
    let verdict = spoilt(pattern("hole"), |s| {
        s.mesh.add([(2, 1), (1, 2), (2, 3)]);
        s.mesh.add([(2, 1), (2, 3), (3, 2)]);
    });
    assert_eq!((verdict.touched_nodata.count, verdict.boundary_gaps.count), (1, 4));
    assert_eq!(verdict.unmatched_edges.count, 0);
    assert_eq!(verdict.double_area - verdict.expected_double_area, 4 * 16);
}

#[test]
fn a_coast_cut_straight_is_found() {
    let rows = ["#####", "####.", "##...", "##..."];
    let verdict = spoilt(&rows, |s| {
        s.mesh.remove(&[(1, 1), (2, 1), (1, 2)]);
        s.mesh.add([(1, 1), (3, 1), (1, 3)]);
    });
    assert!(verdict.touched_nodata.count > 0 && verdict.unmatched_edges.count > 0 && verdict.boundary_gaps.count > 0);
    // From one step of a staircase to the next but one: within a quarter cell of the coast, and no nodata touched.
    let rows = ["#....", "##...", "##...", "###.."];
    let verdict = spoilt(&rows, |s| {
        s.mesh.remove(&[(0, 0), (0, 1), (1, 1)]);
        s.mesh.remove(&[(0, 1), (1, 1), (0, 2), (1, 2)]);
        s.mesh.add([(0, 0), (0, 2), (1, 2)]);
        s.mesh.add([(0, 0), (0, 1), (0, 2)]);
    });
    assert!(verdict.unmatched_edges.count > 0 && verdict.boundary_gaps.count > 0, "{verdict}");
    assert_eq!((verdict.touched_nodata.count, verdict.uncovered.count), (0, 1));
}

#[test]
fn an_island_that_is_left_out_is_found() {
    let verdict = spoilt(pattern("islands"), |s| s.mesh.remove(&[(4, 0), (5, 0), (4, 1), (5, 1)]));
    assert_eq!((verdict.uncovered.count, verdict.boundary_gaps.count, verdict.unmatched_edges.count), (4, 4, 0));
}

#[test]
fn a_pinch_of_two_vertices_is_found() {
    let verdict = spoilt(pattern("pinch"), |s| {
        let pinch = s.mesh.at(1, 1);
        let twin = s.mesh.places.len() as u64;
        s.mesh.places.push((4, 4));
        s.mesh.heights.push(s.mesh.heights[pinch as usize]);
        // The fan of the lower part.
        let places = &s.mesh.places;
        let lower = |face: &&mut [u64; 3]| face.iter().all(|v| places[*v as usize].1 >= 4);
        let corners = s.mesh.faces.iter_mut().filter(lower).flatten();
        corners.filter(|v| **v == pinch).for_each(|v| *v = twin);
    });
    assert_eq!((verdict.duplicate_vertices.count, verdict.failures().len()), (1, 1), "{verdict}");
}

#[test]
fn an_edge_along_a_coast_may_span_several_cells_and_end_between_samples() {
    let rows = ["#####", "#####", "....."];
    let mut scene = scene(&rows);
    let flat = |height: &mut f64| {
        if !height.is_nan() {
            *height = 0.0
        }
    };
    scene.samples.iter_mut().for_each(flat);
    scene.mesh = Mesh::rectangle(5, 2);
    scene.mesh.insert((7, 4), 0.0);
    scene.mesh.insert((16, 3), 0.0);
    let verdict = scene.judge(0.0).unwrap();
    assert!(verdict.passes(), "{verdict}");
}

#[test]
fn a_face_on_the_wrong_side_of_the_coast_is_found() {
    // The lower part mirrored up: its edges lie on the boundary, their faces do not.
    let rows = ["...", "...", "###", "###"];
    let verdict = spoilt(&rows, |s| {
        s.mesh = Mesh::rectangle(3, 2);
        s.mesh.places.iter_mut().for_each(|p| p.1 += 4);
    });
    assert_eq!((verdict.unmatched_edges.count, verdict.uncovered.count), (4, 3));
    assert_eq!(verdict.double_area, verdict.expected_double_area);
    assert_eq!(verdict.boundary_gaps.count, 2 + 2 + 1 + 1);
}

#[test]
fn infinite_heights_of_faces_over_nodata_count_where_there_are_heights() {
    let verdict = spoilt(pattern("hole"), |s| {
        s.mesh = Mesh::rectangle(5, 5);
        s.mesh.heights = vec![f64::NAN; 4];
    });
    assert_eq!((verdict.above_tolerance.count, verdict.touched_nodata.count, verdict.uncovered.count), (24, 1, 0));
}

#[test]
fn an_empty_raster_is_met_by_an_empty_mesh_alone() {
    let rows = ["...", "..."];
    let verdict = scene(&rows).judge(0.0).unwrap();
    assert!(verdict.passes() && verdict.worst.is_none() && verdict.nodata == 6);
    let verdict = spoilt(&rows, |s| s.mesh = Mesh::rectangle(3, 2));
    assert_eq!((verdict.touched_nodata.count, verdict.boundary_gaps.count), (6, 0));
}

#[test]
fn weights_are_asked_for_where_there_are_heights() {
    let scene = scene(pattern("hole"));
    let mut weights = vec![1.0; 25];
    weights[12] = f64::NAN;
    assert!(scene.judge_weighted(0.0, &weights).unwrap().passes());
    weights[13] = f64::NAN;
    assert!(scene.judge_weighted(0.0, &weights).is_err());
}

/// Whether every point that is looked at lies in one face if it is in the ground, and in none if it is not. The points are
/// close enough together that some lie in every triangle of the lattice, and lie on hardly any edge.
fn covers_exactly(scene: &Scene) -> bool {
    const FINE: i64 = 32;
    let (across, down) = (4 * (scene.width as i64 - 1), 4 * (scene.height as i64 - 1));
    let valid = |c: i64, r: i64| {
        let inside = (0..scene.width as i64).contains(&c) && (0..scene.height as i64).contains(&r);
        inside && !scene.samples[(r * scene.width as i64 + c) as usize].is_nan()
    };
    let ground = |(x, y): (i64, i64)| {
        let (c, r) = (x.div_euclid(4 * FINE), y.div_euclid(4 * FINE));
        let (u, v) = (x.rem_euclid(4 * FINE), y.rem_euclid(4 * FINE));
        match [valid(c, r), valid(c + 1, r), valid(c, r + 1), valid(c + 1, r + 1)] {
            [true, true, true, true] => true,
            [false, true, true, true] => u + v > 4 * FINE,
            [true, false, true, true] => v > u,
            [true, true, false, true] => u > v,
            [true, true, true, false] => u + v < 4 * FINE,
            _ => false,
        }
    };
    let faces: Vec<[(i64, i64); 3]> = scene
        .mesh
        .faces
        .iter()
        .map(|f| f.map(|v| scene.mesh.places[v as usize]).map(|(x, y)| (FINE * x, FINE * y)))
        .collect();
    let lattice = (-8..down + 8).flat_map(|y| (-8..across + 8).map(move |x| (x, y)));
    let offsets = [(5, 3), (13, 29), (22, 7), (27, 18), (9, 19)];
    let points = lattice.flat_map(|(x, y)| offsets.map(|(u, v)| (FINE * x + u, FINE * y + v)));
    points.into_iter().all(|p| {
        let mut count = 0;
        for [a, b, c] in &faces {
            let turns = [orientation(*a, *b, p), orientation(*b, *c, p), orientation(*c, *a, p)];
            if turns.contains(&0) {
                return true;
            }
            count += usize::from(turns.iter().all(|t| *t < 0) || turns.iter().all(|t| *t > 0));
        }
        count == usize::from(ground(p))
    })
}

/// A way to change a mesh, by numbers that pick a face, a vertex and a place.
#[derive(Debug, Clone, Copy)]
pub(super) enum Change {
    Drop(usize),
    Double(usize),
    Reverse(usize),
    Move(usize, (i64, i64)),
    Point(usize, usize, usize),
    Add([usize; 3]),
    Split(usize),
    Merge(usize, usize),
}

pub(super) fn change() -> impl Strategy<Value = Change> {
    let any = || any::<u16>().prop_map(usize::from);
    prop_oneof![
        any().prop_map(Change::Drop),
        any().prop_map(Change::Double),
        any().prop_map(Change::Reverse),
        (any(), ((-5i64..6), (-5i64..6))).prop_map(|(v, by)| Change::Move(v, by)),
        (any(), any(), any()).prop_map(|(f, c, v)| Change::Point(f, c, v)),
        [any(), any(), any()].prop_map(Change::Add),
        any().prop_map(Change::Split),
        (any(), any()).prop_map(|(v, w)| Change::Merge(v, w)),
    ]
}

impl Mesh {
    /// Whether some face holds a place.
    pub(super) fn covers(&self, place: (i64, i64)) -> bool {
        self.faces.iter().any(|face| {
            let [a, b, c] = face.map(|v| self.places[v as usize]);
            [(a, b), (b, c), (c, a)].iter().all(|(p, q)| orientation(*p, *q, place) <= 0)
        })
    }

    /// Whether the mesh has become another.
    pub(super) fn change(&mut self, change: Change) -> bool {
        let before = self.clone();
        let (faces, vertices) = (self.faces.len(), self.places.len());
        if faces == 0 {
            return false;
        }
        match change {
            Change::Drop(f) => {
                self.faces.remove(f % faces);
            }
            Change::Double(f) => self.faces.push(self.faces[f % faces]),
            Change::Reverse(f) => self.faces[f % faces].swap(0, 1),
            Change::Move(v, (x, y)) => {
                let place = &mut self.places[v % vertices];
                *place = (place.0 + x, place.1 + y);
            }
            Change::Point(f, c, v) => self.faces[f % faces][c % 3] = (v % vertices) as u64,
            Change::Add(corners) => self.faces.push(corners.map(|v| (v % vertices) as u64)),
            Change::Split(v) => {
                // One of the faces at a vertex gets a vertex of its own.
                let v = v % vertices;
                let twin = vertices as u64;
                self.places.push(self.places[v]);
                self.heights.push(self.heights[v]);
                self.faces.iter_mut().flatten().filter(|c| **c == v as u64).take(1).for_each(|c| *c = twin);
            }
            Change::Merge(v, w) => {
                let (v, w) = ((v % vertices) as u64, (w % vertices) as u64);
                self.faces.iter_mut().flatten().filter(|c| **c == v).for_each(|c| *c = w);
            }
        }
        before.places != self.places || before.faces != self.faces
    }
}

prop_compose! {
    fn a_raster_with_gaps()(width in 2usize..9, height in 2usize..8, share in 0.0f64..0.8)(
        size in Just((width, height)),
        transform in prop_oneof![Just(NORTH_UP), Just(SOUTH_UP), Just(TURNED)],
        samples in proptest::collection::vec((0.0f64..1.0, -9f64..9.0), width * height)
            .prop_map(move |s| s.into_iter().map(|(gap, h)| if gap < share { f64::NAN } else { h }).collect::<Vec<_>>()),
        diagonals in any::<u64>(),
    ) -> Scene {
        let mut state = diagonals | 1;
        let mesh = Mesh::of_cells(size.0, &samples, || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            state >> 63 == 1
        });
        Scene { width: size.0, height: size.1, transform, samples, mesh }
    }
}

proptest! {
    #[test]
    fn any_ground_in_cells_passes_at_tolerance_0(scene in a_raster_with_gaps(), rows in 1usize..8) {
        let verdict = scene.judge(0.0).unwrap();
        prop_assert!(verdict.passes(), "{}", verdict);
        prop_assert_eq!(verdict.nodata, scene.samples.iter().filter(|s| s.is_nan()).count() as u64);
        prop_assert_eq!(verdict.checked, scene.mesh.places.len() as u64);
        prop_assert_eq!(scene.judge_in_bands(0.0, rows).unwrap(), verdict);
        prop_assert!(covers_exactly(&scene));
    }

    #[test]
    fn any_change_of_such_a_mesh_fails(scene in a_raster_with_gaps(), change in change(), rows in 1usize..8) {
        let mut scene = scene;
        prop_assume!(scene.mesh.change(change));
        let verdict = scene.judge(0.0).unwrap();
        prop_assert!(!verdict.passes(), "{:?}: {}", change, verdict);
        prop_assert_eq!(scene.judge_in_bands(0.0, rows).unwrap().failures(), verdict.failures());
    }

    /// At a tolerance that nothing exceeds, a mesh passes if it covers the ground, once, and only then.
    #[test]
    fn what_passes_covers_exactly(
        scene in a_raster_with_gaps(), points in proptest::collection::vec((0i64..33, 0i64..29), 0..6),
        changes in proptest::collection::vec(change(), 1..4),
    ) {
        let mut scene = scene;
        points.into_iter().for_each(|place| if scene.mesh.covers(place) { scene.mesh.insert(place, 1.0) });
        let verdict = scene.judge(1e6).unwrap();
        prop_assert!(verdict.passes(), "{}", verdict);
        for change in changes {
            scene.mesh.change(change);
        }
        if scene.judge(1e6).unwrap().passes() {
            prop_assert!(covers_exactly(&scene));
        }
    }
}
