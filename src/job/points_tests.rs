//! Points all the way from a set to a written mesh, with an engine that makes vertices of them and of nothing else.

use std::path::Path;
use std::sync::Arc;

use super::tests::{geotiff, terrain};
use super::*;
use crate::base::PointSet;
use crate::base::Window;
use crate::base::control::{CancelToken, Cancelled, Control};
use crate::base::lattice::{Point, orient};
use crate::base::mesh::TileMesh;
use crate::base::staged::StagedFile;
use crate::base::{Heights, Tile};
use crate::field::Field;
use crate::formats::{Header, PlySink};
use crate::job::spool::{Chunk, Spool};
use crate::kernel::measure::{Bare, measure};
use crate::kernel::seam::{MinLink, Rim};
use crate::kernel::triangulate::cuts::GreedyCuts;
use crate::kernel::triangulate::hitting_set::HittingSet;
use crate::kernel::triangulate::insertion::GreedyInsertion;
use crate::kernel::triangulate::{Capabilities, Engine, EngineScratch, Task};
use crate::raster::Raster;
use crate::testing;
use crate::verify::{VerifyOptions, verify};

/// Cuts ears off the loop, then splits the triangle or the edge that a point lies in. Knows no tolerance.
struct PointsOnly;

impl Engine for PointsOnly {
    fn name(&self) -> &'static str {
        "points only"
    }

    fn capabilities(&self) -> Capabilities {
        Capabilities { points: true, ..Capabilities::default() }
    }

    fn bytes_per_sample(&self) -> u64 {
        0
    }

    fn identity(&self) -> String {
        self.name().to_string()
    }

    fn triangulate(&self, task: &Task<'_>, _: &mut EngineScratch, mesh: &mut TileMesh) -> Result<(), Cancelled> {
        mesh.clear();
        mesh.vertices.extend(task.domain.fixed());
        let at: Vec<Point> = mesh.vertices.iter().map(|v| v.at).collect();
        mesh.triangles = ears(task.domain.loops[0].clone(), &at);
        for point in task.domain.vertices.len() as u32..at.len() as u32 {
            let turn = |a: u32, b: u32| orient(at[a as usize], at[b as usize], at[point as usize]);
            let holds = |[a, b, c]: &[u32; 3]| turn(*a, *b) >= 0 && turn(*b, *c) >= 0 && turn(*c, *a) >= 0;
            let (hit, rest): (Vec<_>, Vec<_>) = mesh.triangles.drain(..).partition(holds);
            assert!(hit.len() == 1 || hit.len() == 2, "{} triangles hold a point", hit.len());
            mesh.triangles = rest;
            let edges = hit.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
            mesh.triangles.extend(edges.filter(|&(a, b)| turn(a, b) > 0).map(|(a, b)| [a, b, point]));
        }
        Ok(())
    }
}

/// The first ear that holds no other corner, again and again.
fn ears(mut ring: Vec<u32>, at: &[Point]) -> Vec<[u32; 3]> {
    let mut triangles = Vec::new();
    while ring.len() >= 3 {
        let n = ring.len();
        let ear = |i: usize| [ring[(i + n - 1) % n], ring[i], ring[(i + 1) % n]];
        let turn = |a: u32, b: u32, c: u32| orient(at[a as usize], at[b as usize], at[c as usize]);
        let free = |&i: &usize| {
            let [a, b, c] = ear(i);
            let inside = |&&p: &&u32| turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0;
            turn(a, b, c) > 0 && ring.iter().filter(|p| ![a, b, c].contains(p)).find(inside).is_none()
        };
        let Some(i) = (0..n).find(free) else { panic!("no ear of {ring:?}") };
        triangles.push(ear(i));
        ring.remove(i);
    }
    triangles
}

fn made(field: &Field, params: &Params, points: &PointSet) -> Mesh {
    let grid = grid(field.width(), field.height(), params).expect("a grid");
    let spool = Spool::new(&params.temp_dir, grid.len()).expect("a spool");
    let (mut tile, mut forced, mut mesh) = (Tile::default(), Vec::new(), TileMesh::default());
    let cancel = CancelToken::default();
    for index in 0..grid.len() {
        let place = grid.place(index);
        let window = place.window;
        field.load(window, &mut tile).expect("loaded");
        points.within(window, &mut forced);
        let tolerance = params.tolerance.kept();
        let rim = Rim::new(&tile, tolerance, &forced, &place, &mut MinLink::default(), &cancel).expect("a rim");
        let feasibility = params.feasibility;
        let task = Task {
            tile: &tile,
            domain: &rim.domain,
            tolerance,
            feasibility,
            max_stray: f64::INFINITY,
            cancel: &cancel,
        };
        PointsOnly.triangulate(&task, &mut EngineScratch::default(), &mut mesh).expect("a mesh");
        assert!(mesh.vertices.iter().copied().eq(rim.domain.fixed()));
        let errors = measure(&tile, &mesh, tolerance, &place, Bare::Nothing);
        let mut chunk = Chunk::default();
        chunk.fill(index, &rim, &mut mesh, errors, tile.checksum());
        spool.append(&chunk, &mut Vec::new()).expect("kept");
    }
    let (geo_transform, times) = (field.geo_transform(), TileTimes::default());
    Mesh {
        spool,
        grid,
        chunks: grid,
        geo_transform,
        channels: Vec::new(),
        tolerance: params.tolerance,
        error_scale: params.tolerance.kept(),
        outcome: None,
        chains: None,
        times,
        spool_bytes: 0,
        found: 0,
    }
}

/// A point lies wherever the written mesh has a vertex, and the other way round but for the tiles' corners.
#[test]
fn points_become_vertices_of_the_written_mesh() {
    let (width, height) = (40, 30);
    let folder = testing::folder();
    let (dem, tin) = (folder.path().join("dem.tif"), folder.path().join("tin.ply"));
    geotiff(&dem, width, height, &terrain(5, width, height));
    let raster = Raster::open(&dem, 1).expect("opens");
    let field =
        Field::open(&raster.to_band().expect("a band"), &Default::default(), &Control::default()).expect("a field");
    let params = Params { tile: 16, ..Params::new(1e6) };
    // Corners of tiles, seams, rims and ground.
    let points = PointSet::new([(0, 0), (16, 16), (16, 5), (7, 16), (39, 11), (3, 29), (8, 8), (9, 8), (31, 20)]);
    let mesh = made(&field, &params, &points);
    let sink = PlySink::new(StagedFile::create(&tin, false, &[Path::new(&dem)]).expect("staged"), Header::default());
    mesh.write(Box::new(sink), &Control::default()).expect("written");
    let options = VerifyOptions { lines: None, max_error: 1e6, max_stray: None, importance: None, temp_dir: None };
    let verdict = verify(&raster.to_band().expect("a band"), &tin, &options, &Control::default());
    let verdict = verdict.expect("judged");
    assert!(verdict.passes(), "{:?}", verdict.failures());
    let mut vertices = Vec::new();
    for chunk in mesh.chunks().map(|c| c.expect("a chunk")) {
        let Window { column, row, .. } = mesh.grid().window(mesh.grid().tile(chunk.tile));
        let places = chunk.vertices.iter().map(|v| v.at.sample().expect("a sample"));
        vertices.extend(places.map(|(c, r)| (column + c, row + r)));
    }
    let grid = mesh.grid();
    let corner = |i: usize| {
        let Window { column, row, width, height } = grid.window(grid.tile(i));
        [(column, row), (column + width - 1, row), (column, row + height - 1), (column + width - 1, row + height - 1)]
    };
    let expected = PointSet::new(points.iter().chain((0..grid.len()).flat_map(corner)));
    assert_eq!(vertices.len(), expected.len(), "every vertex is owned once");
    assert_eq!(PointSet::new(vertices), expected);
}

#[test]
fn every_engine_takes_points_and_they_identify_a_work_dir() {
    let field = Field::from_heights(9, 9, Heights::F64(vec![1.0; 81])).expect("a field");
    let with = |points: &[(usize, usize)]| {
        let points = Some(Arc::new(PointSet::new(points.iter().copied())));
        Params { points, ..Params::new(1.0) }
    };
    let engines: [EngineChoice; 4] = [
        GreedyInsertion::default().into(),
        GreedyCuts::PLAIN.into(),
        GreedyCuts::IMPROVED.into(),
        HittingSet::default().into(),
    ];
    for engine in engines {
        let mesh = triangulate(&field, &Params { engine, ..with(&[(3, 3)]) }, &Control::default());
        let chunk = mesh.expect("a mesh").chunks().next().expect("a tile").expect("a chunk");
        assert!(chunk.vertices.iter().any(|v| v.at == Point::of_sample(3, 3)), "{}", engine.name());
    }
    assert!(triangulate(&field, &with(&[]), &Control::default()).is_ok());
    assert_eq!(with(&[]).named(), Params::new(1.0).named());
    assert_eq!(with(&[(1, 2), (3, 4)]).named(), with(&[(3, 4), (1, 2)]).named());
    assert_ne!(with(&[(1, 2)]).named(), with(&[(2, 1)]).named());
}
