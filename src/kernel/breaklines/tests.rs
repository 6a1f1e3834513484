//! Lines on the lattice.

use proptest::prelude::*;

use super::noding::turn;
use super::pieces::Piece;
use super::*;
use crate::base::control::CancelToken;
use crate::base::lattice::Point;
use crate::base::mesh::TileMesh;
use crate::base::tiling::{TileGrid, TilePlace};
use crate::base::{Heights, Tile, Window};
use crate::kernel::polish;
use crate::kernel::seam::{MinLink, Rim, Sides};
use crate::kernel::triangulate::insertion::{GreedyInsertion, mend_tile};
use crate::kernel::triangulate::{Engine, EngineScratch, Feasibility, Task};

pub(super) fn lines_of(lines: Vec<Vec<(f64, f64)>>, size: (usize, usize)) -> Breaklines {
    Breaklines::new(&[set(Polylines::new(lines), 0.5)], size).expect("near lines")
}

pub(super) fn set(lines: Polylines, shift: f64) -> LineSet {
    LineSet { kind: LineKind::Breaklines, lines, shift }
}

fn counts(lines: &Breaklines) -> LineCounts {
    lines.counts().next().expect("a set").1
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

pub(super) fn line() -> impl Strategy<Value = Vec<(f64, f64)>> {
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
        let pieces = all.iter().map(|&[a, b]| Piece::new((0, 0), [(a, 0.0), (b, 0.0)]));
        prop_assert_eq!(noding::segments(&noding::node(pieces.collect())), all);
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
    let LineCounts { lines, left_out, segments, largest_rounding } = counts(&found);
    assert_eq!((lines, left_out, segments), (1, 0, 4));
    assert!((largest_rounding - 0.1f64.hypot(0.1)).abs() < 0.01 || largest_rounding < 0.1768, "{largest_rounding}");
}

#[test]
fn lines_that_come_to_nothing_are_counted() {
    let nothing = vec![vec![], vec![(1.0, 1.0)], vec![(1.01, 1.0), (1.02, 1.0)], vec![(-5.0, 2.0), (-1.0, 9.0)]];
    let found = lines_of([nothing, vec![vec![(0.0, 0.0), (1.0, 1.0)], vec![(1.0, 1.0), (0.0, 0.0)]]].concat(), (4, 4));
    assert_eq!((counts(&found).lines, counts(&found).left_out, found.segments().len()), (6, 4, 1));
    assert_eq!(found.named(), lines_of(vec![vec![(0.0, 0.0), (1.0, 1.0)]], (4, 4)).named());
}

#[test]
fn what_cannot_be_put_on_the_lattice_is_refused() {
    let far = Polylines::new(vec![vec![(0.0, 0.0), (1e300, 0.0)]]);
    assert!(matches!(Breaklines::new(&[set(far, 0.5)], (4, 4)), Err((_, LinesError::TooFar { .. }))));
    let long = Polylines::new(vec![(0..6000).map(|i| (0.0, f64::from(i % 2) * 999.0)).collect()]);
    assert_eq!(Breaklines::new(&[set(long, 0.5)], (4, 1000)), Err((LineKind::Breaklines, LinesError::TooMany)));
    for shift in [-0.5, 17.0, f64::NAN] {
        let wrong = set(Polylines::default(), shift);
        assert!(matches!(Breaklines::new(&[wrong], (4, 4)), Err((_, LinesError::Shift(_)))));
    }
}

/// The chains of lines in a tile that is a whole raster.
pub(super) fn chains_of(tile: &Tile, lines: &Breaklines, tolerance: f64) -> TileChains {
    let size = (tile.width(), tile.height());
    let window = Window { column: 0, row: 0, width: size.0, height: size.1 };
    let pieces = Pieces::new(lines, lines.segments(), &[], None, &TileGrid::new(size.0, size.1, 0), size);
    let cancel = CancelToken::default();
    let task = Thinning { tile, window, size, tolerance, lines, points: &[], cancel: &cancel };
    let made = pieces.by_tile().map(|(_, pieces)| (window, thin(&task, pieces).expect("heights in doubles")));
    let mut found = TileChains::default();
    let chains = Chains::new(made.collect::<Vec<_>>());
    found.fill(window, None, chains.edges().iter().copied(), chains.ends().iter().copied());
    found
}

/// Edges of chains that are none of the mesh.
fn missing(mesh: &TileMesh, chains: &TileChains) -> usize {
    let sides = mesh.triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
    let at = |v: u32| mesh.vertices[v as usize].at;
    let there: std::collections::HashSet<[Point; 2]> =
        sides.map(|(a, b)| [at(a).min(at(b)), at(a).max(at(b))]).collect();
    let edges = chains.edges().iter().map(|[a, b]| [a.at.min(b.at), a.at.max(b.at)]);
    edges.filter(|edge| !there.contains(edge)).count()
}

proptest! {
    /// In each of the stages that a tile's mesh goes through, with a limit on straying, too.
    #[test]
    fn edges_of_chains_are_there_after_every_stage(lines in prop::collection::vec(line(), 1..5), seed in any::<u32>()) {
        let (width, height) = (9, 8);
        let rough = |i: usize| f64::from((i as u32).wrapping_mul(2_654_435_761).wrapping_add(seed) >> 27);
        let tile = Tile::from_heights(width, height, Heights::F64((0..width * height).map(rough).collect()));
        let cancel = CancelToken::default();
        for tolerance in [1.0, 9.0] {
            let chains = chains_of(&tile, &lines_of(lines.clone(), (width, height)), tolerance);
            let place = TilePlace::alone(width, height);
            let rim = Rim::with_sides(&tile, tolerance, Sides::FINAL, &[], &chains, &place, &mut MinLink::default(), &cancel);
            let mut domain = rim.expect("nobody cancels").domain;
            let given = domain.clone();
            let (feasibility, max_stray) = (Feasibility::Weak, 1.0);
            let task = Task { tile: &tile, domain: &given, tolerance, feasibility, max_stray, cancel: &cancel };
            let (mut mesh, mut memory) = (TileMesh::default(), EngineScratch::default());
            GreedyInsertion::default().triangulate(&task, &mut memory, &mut mesh).expect("nobody cancels");
            prop_assert_eq!(missing(&mesh, &chains), 0, "inserted");
            mend_tile(&task, &mut domain, &mut memory, &mut mesh).expect("nobody cancels");
            prop_assert_eq!(missing(&mesh, &chains), 0, "mended");
            let task = Task { domain: &domain, max_stray: f64::INFINITY, ..task };
            polish::polish(&task, &Default::default(), &mut polish::Scratch::default(), &mut mesh).expect("nobody cancels");
            prop_assert_eq!(missing(&mesh, &chains), 0, "polished");
        }
    }
}

/// On a plane a line needs no more edges than it has corners, whatever crosses it.
#[test]
fn straight_lines_on_a_plane_are_single_edges() {
    let (width, height) = (30, 20);
    let plane = |i: usize| (i % width) as f64 * 0.5 + (i / width) as f64 * 0.25;
    let tile = Tile::from_heights(width, height, Heights::F64((0..width * height).map(plane).collect()));
    let lines = lines_of(vec![vec![(2.1, 3.3), (27.2, 9.4), (3.0, 17.2)]], (width, height));
    assert!(lines.segments().len() > 60);
    assert_eq!(chains_of(&tile, &lines, 0.1).edges().len(), 2);
    let crossed = lines_of(vec![vec![(2.1, 3.3), (27.2, 9.4)], vec![(14.6, 1.0), (14.6, 18.5)]], (width, height));
    assert_eq!(chains_of(&tile, &crossed, 0.1).edges().len(), 4);
}
