//! Lines, chains and meshes held against the constrained Delaunay triangulations of the crate `spade`, which has exact predicates and
//! a mesh structure of its own.
//!
//! It refuses a constraint that crosses another, and divides one at every vertex that it passes over. So segments that cross, overlap
//! or touch without a node, stretches that no edge follows or that are followed twice, edges that are missing or that a flip has taken
//! away, and triangles that are no constrained Delaunay triangulation's are all differences between its edges and ours.

use std::collections::{BTreeMap, BTreeSet};

use proptest::prelude::*;
use spade::handles::FixedVertexHandle;
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};

use super::tests::{chains_of, line, lines_of, set};
use super::*;
use crate::base::control::CancelToken;
use crate::base::lattice::{Point, dot, in_circle, orient};
use crate::base::mesh::{Domain, TileMesh};
use crate::base::tiling::TilePlace;
use crate::base::{Heights, Tile};
use crate::kernel::seam::{MinLink, Rim, Sides};
use crate::kernel::triangulate::Feasibility;
use crate::kernel::triangulate::conformance::{check, triangulate};
use crate::kernel::triangulate::cuts::GreedyCuts;
use crate::kernel::triangulate::insertion::GreedyInsertion;

/// A place as numbers.
type At = (i64, i64);

/// Edges, the lower end of each first.
type Edges = BTreeSet<[At; 2]>;

/// A constrained triangulation of spade's.
#[derive(Default)]
struct Theirs {
    triangulation: ConstrainedDelaunayTriangulation<Point2<f64>>,
    vertices: BTreeMap<At, FixedVertexHandle>,
}

impl Theirs {
    fn insert(&mut self, (x, y): At) -> FixedVertexHandle {
        let insert = || self.triangulation.insert(Point2::new(x as f64, y as f64)).expect("a small number");
        *self.vertices.entry((x, y)).or_insert_with(insert)
    }

    fn insert_all(&mut self, places: impl Iterator<Item = At>) {
        for place in places {
            self.insert(place);
        }
    }

    /// Makes an edge that crosses none of those before it; whether there is none that it would cross.
    fn constrain(&mut self, [a, b]: [At; 2]) -> bool {
        let (a, b) = (self.insert(a), self.insert(b));
        let is_free = self.triangulation.can_add_constraint(a, b);
        if is_free {
            self.triangulation.add_constraint(a, b);
        }
        is_free
    }

    fn edges(&self, only_constraints: bool) -> Edges {
        let all = self.triangulation.undirected_edges().filter(|edge| !only_constraints || edge.is_constraint_edge());
        all.map(|edge| edge.positions().map(|p| (p.x as i64, p.y as i64))).map(sorted).collect()
    }
}

fn sorted([a, b]: [At; 2]) -> [At; 2] {
    [a.min(b), a.max(b)]
}

fn of_segments(lines: &Breaklines) -> Edges {
    lines.segments().iter().map(|segment| sorted(segment.map(|p| (p.x, p.y)))).collect()
}

fn of_chains(chains: &TileChains) -> Edges {
    chains.edges().iter().map(|edge| sorted(edge.map(|v| at(v.at)))).collect()
}

fn at(p: Point) -> At {
    (i64::from(p.x), i64::from(p.y))
}

const SIZE: (usize, usize) = (9, 8);

/// No four samples are on a plane, but by chance.
fn rough(seed: u32) -> Tile {
    let height =
        |i: usize| f64::from((i as u32).wrapping_mul(2_654_435_761).wrapping_add(seed).wrapping_mul(0x9e37_79b9) >> 8);
    Tile::from_heights(SIZE.0, SIZE.1, Heights::F64((0..SIZE.0 * SIZE.1).map(height).collect()))
}

/// The ground of a tile that is a whole raster.
fn ground(tile: &Tile, points: &[(usize, usize)], chains: &TileChains, tolerance: f64) -> Domain {
    let (cancel, place) = (CancelToken::default(), TilePlace::alone(SIZE.0, SIZE.1));
    let rim = Rim::with_sides(tile, tolerance, Sides::FINAL, points, chains, &place, &mut MinLink::default(), &cancel);
    rim.expect("nobody cancels").domain
}

/// What greedy insertion makes of it.
fn inserted(tile: &Tile, chains: &TileChains, tolerance: f64) -> TileMesh {
    let domain = ground(tile, &[], chains, tolerance);
    triangulate(&GreedyInsertion::default(), tile, &domain, tolerance, Feasibility::Weak)
}

proptest! {
    #![proptest_config(crate::testing::cases(128, 4000))]

    /// Segments may all be constraints, and stay as they are: none crosses another, lies on it or passes over a place.
    #[test]
    fn noded_lines_are_constraints(lines in prop::collection::vec(line(), 1..6)) {
        let lines = lines_of(lines, SIZE);
        let expected = of_segments(&lines);
        let mut theirs = Theirs::default();
        theirs.insert_all(expected.iter().flatten().copied());
        for &segment in &expected {
            prop_assert!(theirs.constrain(segment), "{:?} crosses another", segment);
        }
        prop_assert_eq!(theirs.edges(true), expected);
    }

    /// Where nothing may be left out but places on straight lines, edges lead over every segment and over nothing else.
    #[test]
    fn chains_without_a_shift_are_the_lines(lines in prop::collection::vec(line(), 1..5), seed in any::<u32>()) {
        let lines = Breaklines::new(&[set(Polylines::new(lines), 0.0)], SIZE).expect("near lines");
        let chains = chains_of(&rough(seed), &lines, 0.0);
        let expected = of_segments(&lines);
        let mut theirs = Theirs::default();
        theirs.insert_all(expected.iter().flatten().copied());
        for edge in of_chains(&chains) {
            prop_assert!(theirs.constrain(edge), "{:?} crosses another", edge);
        }
        prop_assert_eq!(theirs.edges(true), expected);
    }

    /// Inserted meshes are constrained Delaunay triangulations, up to diagonals between places on one circle.
    #[test]
    fn meshes_are_constrained_triangulations(
        lines in prop::collection::vec(line(), 1..5),
        seed in any::<u32>(),
        tolerance in prop_oneof![Just(0.0), 0.0..2e7f64],
    ) {
        let tile = rough(seed);
        let chains = chains_of(&tile, &lines_of(lines, SIZE), tolerance);
        let mesh = inserted(&tile, &chains, tolerance);
        let place = |v: u32| mesh.vertices[v as usize].at;
        let mut theirs = Theirs::default();
        theirs.insert_all(mesh.vertices.iter().map(|v| at(v.at)));
        let constraints = of_chains(&chains);
        for &edge in &constraints {
            prop_assert!(theirs.constrain(edge), "{:?} crosses another", edge);
        }
        // None of them passes over a vertex.
        prop_assert_eq!(theirs.edges(true), constraints.clone());
        prop_assert_eq!(mesh.triangles.len(), theirs.triangulation.num_inner_faces());
        let mut across: BTreeMap<[At; 2], Vec<(u32, [u32; 2])>> = BTreeMap::new();
        for &[a, b, c] in &mesh.triangles {
            for [a, b, c] in [[a, b, c], [b, c, a], [c, a, b]] {
                across.entry(sorted([at(place(a)), at(place(b))])).or_default().push((c, [a, b]));
            }
        }
        let ours: Edges = across.keys().copied().collect();
        prop_assert!(constraints.is_subset(&ours), "{:?} are missing", constraints.difference(&ours));
        let all = theirs.edges(false);
        prop_assert_eq!(ours.len(), all.len());
        for edge in ours.difference(&all) {
            let [(c, [a, b]), (d, _)] = across[edge][..] else { panic!("{edge:?} is on the rim, and not theirs") };
            // All four on one circle, with the edge and across it.
            let [a, b, c, d] = [a, b, c, d].map(place);
            prop_assert!(orient(a, d, c) > 0 && orient(d, b, c) > 0, "{:?} has no other diagonal", edge);
            prop_assert!(!in_circle(a, b, c, d), "{:?} is the worse diagonal", edge);
            prop_assert!(!in_circle(a, d, c, b), "{:?} is the better diagonal, and not theirs", edge);
        }
    }

    /// Greedy cuts eat the ground on both sides of every edge, and leave points uncovered until they are corners.
    #[test]
    fn cuts_keep_edges_and_points(
        lines in prop::collection::vec(line(), 0..5),
        points in prop::collection::btree_set((0..SIZE.1, 0..SIZE.0), 0..6),
        seed in any::<u32>(),
        flat in any::<bool>(),
        tolerance in prop_oneof![Just(0.0), 0.0..2e7f64],
    ) {
        let level = || Tile::from_heights(SIZE.0, SIZE.1, Heights::F64(vec![0.0; SIZE.0 * SIZE.1]));
        let tile = if flat { level() } else { rough(seed) };
        let lines = lines_of(lines, SIZE);
        let points: Vec<(usize, usize)> = points.into_iter().map(|(row, column)| (column, row)).collect();
        let chains = chains_of(&tile, &lines, tolerance);
        // Points on lines are ends of edges in a run; here they are left out.
        let edges = of_chains(&chains);
        let is_apart = |&(column, row): &(usize, usize)| {
            let p = Point::of_sample(column as i32, row as i32);
            edges.iter().all(|edge| {
                let [a, b] = edge.map(|(x, y)| Point { x: x as i32, y: y as i32 });
                orient(a, b, p) != 0 || dot(p, a, b) > 0
            })
        };
        let points: Vec<(usize, usize)> = points.into_iter().filter(is_apart).collect();
        let domain = ground(&tile, &points, &chains, tolerance);
        for cuts in [GreedyCuts::PLAIN, GreedyCuts::IMPROVED] {
            let mesh = triangulate(&cuts, &tile, &domain, tolerance, Feasibility::Weak);
            check(&tile, &domain, &mesh, tolerance);
            let at = |v: u32| at(mesh.vertices[v as usize].at);
            let sides = |t: &[u32; 3]| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]].map(|edge| sorted(edge.map(at)));
            let ours: Edges = mesh.triangles.iter().flat_map(sides).collect();
            prop_assert!(edges.is_subset(&ours), "{:?} are missing", edges.difference(&ours));
            let is_vertex = |&(column, row): &(usize, usize)| {
                mesh.vertices.iter().any(|v| v.at == Point::of_sample(column as i32, row as i32))
            };
            prop_assert!(points.iter().all(is_vertex));
        }
    }
}
