//! The wall through a line: the raster's surface above it, and whether an edge keeps to it.
//!
//! Between four samples that surface is bilinear, so it is linear along rows and columns of samples. An edge is held to it where it
//! crosses these.

use crate::base::Tile;
use crate::base::exact;
use crate::base::lattice::{Point, STEPS, distance2, dot};
use crate::base::mesh::Vertex;
use crate::kernel::polish::near_surface;
use crate::kernel::quantum::Quantum;

/// The vertex on the surface at a place of a cell with four heights: at a sample with its height, elsewhere rounded to short numbers
/// where the tolerance lets them. `None` where no double is within the tolerance of the surface.
pub(super) fn vertex(tile: &Tile, at: Point, tolerance: f64) -> Option<Vertex> {
    if let Some((column, row)) = at.sample() {
        return Some(Vertex { at, height: tile.at(column, row) });
    }
    let [(column, right), (row, lower)] = [at.x, at.y].map(|v| (v.div_euclid(STEPS), v.rem_euclid(STEPS)));
    let (left, upper) = (STEPS - right, STEPS - lower);
    let corners = [(0, 0, left * upper), (1, 0, right * upper), (0, 1, left * lower), (1, 1, right * lower)];
    let part = |(i, j, share): (i32, i32, i32)| match share {
        0 => 0.0,
        _ => f64::from(share) * tile.at((column + i) as usize, (row + j) as usize),
    };
    let height = corners.into_iter().map(part).sum::<f64>() / f64::from(STEPS * STEPS);
    let near = |height: f64| Some(Vertex { at, height }).filter(|&vertex| near_surface(tile, vertex, tolerance));
    let short = Quantum::of(tolerance).and_then(|quantum| quantum.round(height));
    short.and_then(near).or_else(|| near(height))
}

/// Whether an edge is within the tolerance of the surface wherever it crosses rows and columns of samples, exactly; where samples
/// have weights, within the smaller limit of the two it passes between. All cells that it passes have four heights.
pub(super) fn keeps_to_surface(tile: &Tile, tolerance: f64, p: Vertex, q: Vertex) -> bool {
    [true, false].into_iter().all(|columns| crosses_within(tile, tolerance, p, q, columns))
}

/// Whether an edge is within the tolerance of these heights of a line at its places that are nearest to them, exactly.
pub(super) fn keeps_to_heights(tolerance: f64, p: Vertex, q: Vertex, passed: &[Vertex]) -> bool {
    let all = distance2(p.at, q.at);
    passed.iter().all(|place| {
        let along = dot(p.at, q.at, place.at).clamp(0, all);
        exact::within(&[(all, place.height), (along - all, p.height), (-along, q.height)], all, tolerance)
    })
}

/// Whether all samples that an edge passes over, its ends left out, are within what `stands` gives for each: a height, and the distance
/// allowed from it.
pub(super) fn keeps_to_samples(p: Vertex, q: Vertex, stands: impl Fn((usize, usize)) -> (f64, f64)) -> bool {
    let (dx, dy) = (i64::from(q.at.x - p.at.x), i64::from(q.at.y - p.at.y));
    let mut parts = (dx.abs(), dy.abs());
    while parts.1 != 0 {
        parts = (parts.1, parts.0 % parts.1);
    }
    // Places of the lattice on the edge are so many, evenly.
    let all = parts.0;
    (1..all).all(|done| {
        let at = Point { x: p.at.x + (dx / all * done) as i32, y: p.at.y + (dy / all * done) as i32 };
        at.sample().is_none_or(|sample| {
            let (height, limit) = stands(sample);
            exact::within(&[(all, height), (done - all, p.height), (-done, q.height)], all, limit)
        })
    })
}

fn crosses_within(tile: &Tile, tolerance: f64, p: Vertex, q: Vertex, columns: bool) -> bool {
    // Across the lines, then along them; from the lower line to the higher.
    let place = |v: Vertex| if columns { (v.at.x, v.at.y) } else { (v.at.y, v.at.x) };
    let (near, far) = if place(p) <= place(q) { (p, q) } else { (q, p) };
    let (from, to) = (place(near), place(far));
    let (span, run, steps) = (i64::from(to.0 - from.0), i64::from(to.1 - from.1), i64::from(STEPS));
    (from.0.div_euclid(STEPS) + 1..=(to.0 - 1).div_euclid(STEPS)).all(|line| {
        let done = i64::from(line * STEPS - from.0);
        let cell = span * steps;
        let along = i64::from(from.1) * span + run * done;
        let (whole, part) = (along.div_euclid(cell), along.rem_euclid(cell));
        let sample =
            |along: i64| if columns { (line as usize, along as usize) } else { (along as usize, line as usize) };
        let (before, after) = (sample(whole), sample(if part == 0 { whole } else { whole + 1 }));
        let terms = [
            (cell - part, tile.at(before.0, before.1)),
            (part, tile.at(after.0, after.1)),
            (-steps * (span - done), near.height),
            (-steps * done, far.height),
        ];
        let limit = [before, after].map(|(column, row)| tile.limit(column, row, tolerance));
        exact::within(&terms, cell, limit[0].min(limit[1]))
    })
}
