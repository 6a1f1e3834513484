//! Parts of meshes that end at the raster's rim, and the limit on straying: nothing that is promised is lost.

use std::collections::{HashMap, HashSet};

use proptest::prelude::*;

use super::*;
use crate::base::control::CancelToken;
use crate::base::exact;
use crate::base::lattice::STEPS;
use crate::base::mesh::{Domain, Vertex};
use crate::base::tiling::TilePlace;
use crate::kernel::seam::{MinLink, Rim};
use crate::kernel::triangulate::Engine;
use crate::kernel::triangulate::conformance::{check, tile, tolerances};
use crate::kernel::triangulate::cuts::GreedyCuts;
use crate::kernel::triangulate::insertion::{GreedyInsertion, mend_part, mend_tile};
use crate::testing::cases;

/// The corners of a tile that is a raster of its own come first among the vertices of its rim.
const CORNERS: u32 = 4;

/// A mesh of a whole raster, its loop read off it: vertices that are on it first.
fn with_its_rim(mesh: &TileMesh) -> (Domain, TileMesh) {
    let sides = || mesh.triangles.iter().flat_map(|t| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])]);
    let all: HashSet<(u32, u32)> = sides().collect();
    let ahead: HashMap<u32, u32> = sides().filter(|&(a, b)| !all.contains(&(b, a))).collect();
    let mut walk = vec![0];
    while ahead[&walk[walk.len() - 1]] != 0 {
        walk.push(ahead[&walk[walk.len() - 1]]);
    }
    assert_eq!(walk.len(), ahead.len(), "one loop");
    let mut order = walk.clone();
    order.extend((0..mesh.vertices.len() as u32).filter(|v| !walk.contains(v)));
    let mut numbers = vec![0; order.len()];
    (0..).zip(&order).for_each(|(new, &old): (u32, _)| numbers[old as usize] = new);
    let vertices: Vec<Vertex> = order.iter().map(|&v| mesh.vertices[v as usize]).collect();
    let triangles = mesh.triangles.iter().map(|t| t.map(|v| numbers[v as usize])).collect();
    let domain = Domain {
        vertices: vertices[..walk.len()].to_vec(),
        loops: vec![(0..walk.len() as u32).collect()],
        ..Domain::default()
    };
    (domain, TileMesh { vertices, triangles, relaxed: mesh.relaxed })
}

/// How many places there are at which a mesh strays too far: an oracle that looks at every edge at every line it crosses.
fn strays(task: &Task<'_>, mesh: &TileMesh) -> usize {
    let mut count = 0;
    if task.max_stray == f64::INFINITY {
        return 0;
    }
    for t in &mesh.triangles {
        let corners = mesh.corners(*t);
        for i in 0..3 {
            let (p, q) = (corners[i], corners[(i + 1) % 3]);
            count += [true, false].map(|columns| strays_along(task, p, q, columns)).iter().sum::<usize>();
        }
    }
    count
}

fn strays_along(task: &Task<'_>, p: Vertex, q: Vertex, columns: bool) -> usize {
    let place = |v: Vertex| {
        let (x, y) = (i64::from(v.at.x), i64::from(v.at.y));
        if columns { (x, y) } else { (y, x) }
    };
    let (p, q) = if place(p) < place(q) { (p, q) } else { (q, p) };
    let ((a, c), (b, d)) = (place(p), place(q));
    let steps = i64::from(STEPS);
    let lines = if columns { task.tile.width() } else { task.tile.height() } as i64;
    let strays = |line: &i64| {
        let at = line * steps;
        if !(a < at && at < b) {
            return false;
        }
        // The edge is at along ÷ unit there, counted in samples.
        let along = c * (b - a) + (d - c) * (at - a);
        let unit = (b - a) * steps;
        if along % unit == 0 {
            return false;
        }
        let first = along.div_euclid(unit);
        let sample = |i: i64| if columns { (*line as usize, i as usize) } else { (i as usize, *line as usize) };
        let [(c0, r0), (c1, r1)] = [sample(first), sample(first + 1)];
        let z = [task.tile.at(c0, r0), task.tile.at(c1, r1)];
        let span = b - a;
        let height = [(b - at, p.height), (at - a, q.height)];
        let limit = task.tile.limit(c0, r0, task.tolerance).max(task.tile.limit(c1, r1, task.tolerance));
        let above = |z: f64| exact::sign(&[height[0], height[1], (-span, z)]);
        // F × limit is a product of small numbers in these tests: exact.
        let within = |z: f64| exact::within(&[height[0], height[1], (-span, z)], span, task.max_stray * limit);
        let (least, largest) = (z[0].min(z[1]), z[0].max(z[1]));
        above(largest).is_gt() && !within(largest) || above(least).is_lt() && !within(least)
    };
    (0..lines).filter(strays).count()
}

fn rim_of(tile: &Tile, tolerance: f64, cancel: &CancelToken) -> Rim {
    let place = TilePlace::alone(tile.width(), tile.height());
    Rim::new(tile, tolerance, &[], &place, &mut MinLink::default(), cancel).expect("nobody cancels")
}

/// Everything from an engine to the polished rim; every promise is checked at the end, and straying in between.
fn all_of_it(task: &Task<'_>, engine: &dyn Engine, options: &Options) -> (TileMesh, TileMesh) {
    let (mut memory, mut scratch, mut mesh) = (Default::default(), Scratch::default(), TileMesh::default());
    let rim = RasterRim::of(&TilePlace::alone(task.tile.width(), task.tile.height()));
    engine.triangulate(task, &mut memory, &mut mesh).expect("nobody cancels");
    let mut domain = task.domain.clone();
    let left = mend_tile(task, &mut domain, &mut memory, &mut mesh).expect("nobody cancels");
    assert_eq!(domain.loops, task.domain.loops, "sides stay");
    check(task.tile, task.domain, &mesh, task.tolerance);
    let none_left = if left == 0 { 0 } else { usize::MAX };
    assert!(strays(task, &mesh) <= none_left);
    polish(task, options, &mut scratch, &mut mesh).expect("nobody cancels");
    check(task.tile, task.domain, &mesh, task.tolerance);
    assert!(strays(task, &mesh) <= none_left);
    let polished = mesh.clone();
    let left = mend_part(task, rim, &mut memory, &mut mesh).expect("nobody cancels");
    assert_eq!((left, strays(task, &mesh)), (0, 0));
    let all: Vec<u32> = (0..mesh.vertices.len() as u32).collect();
    let part = Part { locked: CORNERS, centres: &all, rim };
    polish_around(task, options, &part, &mut scratch, &mut mesh).expect("nobody cancels");
    let (domain, walked) = with_its_rim(&mesh);
    check(task.tile, &domain, &walked, task.tolerance);
    assert_eq!(domain.area(), task.domain.area());
    assert_eq!(strays(task, &mesh), 0);
    assert_eq!(mesh.vertices[..CORNERS as usize], polished.vertices[..CORNERS as usize], "corners stay");
    (polished, mesh)
}

proptest! {
    #![proptest_config(cases(60, 400))]

    #[test]
    fn no_edge_strays_and_the_rim_is_free(
        width in 2usize..22, height in 2usize..22, seed in any::<u64>(), kind in 0u8..4,
        tolerance in tolerances(), weighted in any::<bool>(), max_stray in prop::sample::select(vec![1.0, 1.5, 4.0, f64::INFINITY]),
        fitted in any::<bool>(), strong in any::<bool>(), by_cuts in any::<bool>(),
    ) {
        let mut tile = tile(width, height, seed, kind);
        if weighted {
            let weight = |i: usize| [0.0, 0.5, 1.0, 2.0][(seed.rotate_left(i as u32) % 4) as usize];
            tile = tile.with_weights((0..width * height).map(weight).collect());
        }
        let cancel = CancelToken::default();
        let rim = rim_of(&tile, tolerance, &cancel);
        let feasibility = if strong { Feasibility::Strong } else { Feasibility::Weak };
        let task = Task { tile: &tile, domain: &rim.domain, tolerance, feasibility, max_stray, cancel: &cancel };
        let heights = if fitted { Heights::Fitted } else { Heights::Sampled };
        let options = Options { effort: Effort::Balanced, heights, ..Options::default() };
        let engine: &dyn Engine = if by_cuts { &GreedyCuts::PLAIN } else { &GreedyInsertion::default() };
        all_of_it(&task, engine, &options);
    }
}

#[test]
fn a_free_rim_has_fewer_vertices() {
    let wave = |i: usize| {
        ((i % 60) as f64 * 0.2).sin() * 5.0 + ((i / 60) as f64 * 0.15).cos() * 4.0 + (i * 7919 % 101) as f64 * 0.006
    };
    let tile = Tile::from_heights(60, 60, crate::base::Heights::F64((0..3600).map(wave).collect()));
    let cancel = CancelToken::default();
    let rim = rim_of(&tile, 0.5, &cancel);
    let task = Task {
        tile: &tile,
        domain: &rim.domain,
        tolerance: 0.5,
        feasibility: Feasibility::Weak,
        max_stray: 1.5,
        cancel: &cancel,
    };
    for heights in [Heights::Sampled, Heights::Fitted] {
        let options = Options { effort: Effort::Balanced, heights, ..Options::default() };
        let (before, after) = all_of_it(&task, &GreedyInsertion::default(), &options);
        let far = tile.far_corner();
        let on_rim = |v: &&Vertex| v.at.x == 0 || v.at.y == 0 || v.at.x == far.x || v.at.y == far.y;
        let [rim_before, rim_after] = [&before, &after].map(|mesh| mesh.vertices.iter().filter(on_rim).count());
        println!(
            "{heights:?}: {} to {} triangles, {rim_before} to {rim_after} vertices on the rim",
            before.triangles.len(),
            after.triangles.len()
        );
        assert!(after.triangles.len() < before.triangles.len());
        let moved = after.vertices.iter().filter(|v| !before.vertices.iter().any(|w| w.at == v.at));
        assert!(moved.filter(on_rim).count() > 0, "vertices of the rim have moved along it");
    }
}

/// A fan of the four corners around a vertex one row below the upper side.
#[test]
fn a_vertex_beside_the_rim_goes_onto_it_where_the_ground_allows_that() {
    for (bump, goes) in [(0.0, true), (0.9, true), (50.0, false)] {
        // A ridge along the row of the vertex: on the upper side the vertex would leave it.
        let heights = (0..12 * 9).map(|i| if i / 12 == 1 { bump } else { 0.0 }).collect();
        let tile = Tile::from_heights(12, 9, crate::base::Heights::F64(heights));
        let cancel = CancelToken::default();
        let rim = rim_of(&tile, 60.0, &cancel);
        let corners = rim.domain.loops[0].clone();
        assert_eq!(corners.len(), CORNERS as usize);
        let (feasibility, max_stray) = (Feasibility::Weak, f64::INFINITY);
        let task = Task { tile: &tile, domain: &rim.domain, tolerance: 1.0, feasibility, max_stray, cancel: &cancel };
        let mut vertices = rim.domain.vertices.clone();
        vertices.push(Vertex { at: Point { x: 6 * STEPS, y: STEPS }, height: bump });
        let triangles = (0..4).map(|i| [CORNERS, corners[i], corners[(i + 1) % 4]]).collect();
        let mut mesh = TileMesh { vertices, triangles, relaxed: 0 };
        let (mut net, mut order) = (net::Net::default(), Order::default());
        let place = TilePlace::alone(tile.width(), tile.height());
        net.load_part(CORNERS, RasterRim::of(&place), &[], &mut mesh);
        order.reset(&net);
        OntoRim::default().sweep(&mut net, &mut order, &Judge::new(&task)).expect("nobody cancels");
        net.store(&mut mesh);
        let (at, far) = (mesh.vertices[CORNERS as usize].at, tile.far_corner());
        assert_eq!(at.x == 0 || at.y == 0 || at.x == far.x || at.y == far.y, goes, "{bump}: {at:?}");
        assert_eq!(mesh.triangles.len(), if goes { 3 } else { 4 });
        let (domain, walked) = with_its_rim(&mesh);
        assert_eq!(domain.loops[0].len(), if goes { 5 } else { 4 });
        if goes {
            check(&tile, &domain, &walked, 1.0);
        }
    }
}
