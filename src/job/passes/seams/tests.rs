//! Polishing with the seams: what tiles cost, and that points stay.

use std::sync::Arc;

use crate::base::PointSet;
use crate::base::lattice::{Point, STEPS};
use crate::job::tests::{mesh, terrain};
use crate::job::{Mesh, Params, Quality, VertexHeights};
use crate::testing;

fn triangles(mesh: &Mesh) -> u64 {
    mesh.chunks().map(|c| c.expect("a chunk").triangles.len() as u64).sum()
}

/// The places of all vertices on the raster's lattice.
fn places(mesh: &Mesh) -> Vec<(i64, i64)> {
    let steps = i64::from(STEPS);
    let of_chunk = |chunk: crate::job::spool::Chunk| {
        let window = mesh.chunks.window(mesh.chunks.tile(chunk.tile));
        let place = move |at: Point| {
            (window.column as i64 * steps + i64::from(at.x), window.row as i64 * steps + i64::from(at.y))
        };
        chunk.vertices.into_iter().map(move |v| place(v.at)).collect::<Vec<_>>()
    };
    mesh.chunks().flat_map(|chunk| of_chunk(chunk.expect("a chunk"))).collect()
}

/// With their seams left as they are laid, tiles like these cost four per cent. The fewer triangles, the more it varies.
#[test]
fn tiles_cost_next_to_nothing() {
    let ((width, height), most) = if testing::is_long() { ((385, 321), 1.005) } else { ((289, 225), 1.02) };
    let ground = terrain(11, width, height);
    for (quality, heights) in [
        (Quality::Balanced, VertexHeights::Sampled),
        (Quality::Balanced, VertexHeights::Fitted),
        (Quality::Best, VertexHeights::Sampled),
    ] {
        let of = |tile: usize| {
            let params = Params { tile, quality, heights, ..Params::new(0.5) };
            triangles(&mesh(width, height, ground.clone(), &params)) as f64
        };
        let (one, tiled) = (of(0), of(96));
        assert!(tiled <= most * one, "{tiled} triangles in tiles, {one} in one piece: {quality:?}, {heights:?}");
    }
}

#[test]
fn points_stay_where_they_are() {
    let (width, height) = (97, 97);
    let samples: Vec<(usize, usize)> = (0..97).step_by(8).flat_map(|row| [(32, row), (row, 64), (row, row)]).collect();
    let points = Arc::new(PointSet::new(samples.iter().copied()));
    let params = Params { tile: 32, points: Some(points), ..Params::new(1e3) };
    let found = places(&mesh(width, height, terrain(2, width, height), &params));
    let steps = i64::from(STEPS);
    for (column, row) in samples {
        assert!(found.contains(&(column as i64 * steps, row as i64 * steps)), "{column}, {row}");
    }
}
