//! Stitching as the paper has it: the constrained Delaunay triangulation of the partition's edges (section 5), in two readings.

use std::collections::BTreeMap;

use super::Corners;
use super::plane::Region;
use super::shared::near_sample;
use super::squares::{Finder, Sides, Square, vertex};
use crate::base::Tile;
use crate::base::control::{CancelToken, Cancelled};
use crate::base::mesh::{Domain, TileMesh, Vertex};
use crate::kernel::quantum::Quantum;
use crate::kernel::triangulate::feasible::Tester;
use crate::kernel::triangulate::insertion;
use crate::kernel::triangulate::{Feasibility, Task};

/// What "the edges of the simplicial partition" are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reading {
    /// No sample is in two squares, and each square has corners of its own. Squares are joined by triangles over the cells between
    /// them, in which no sample lies. What section 5 says: triangles do not overlap, their vertices are at samples, and stitching
    /// adds triangles where there are no samples.
    Disjoint,
    /// Neighbours share the samples on their common side, and so their corners, whose heights are the mean of what the squares at
    /// them have. What the counts of Table 1 need. Such a mesh is not within the tolerance before it is repaired.
    Shared,
}

/// A stitched partition.
#[derive(Debug, Clone, Default)]
pub struct Literal {
    /// The mesh: of the whole tile, vertices on its sides where squares have corners; within the tolerance.
    pub mesh: TileMesh,
    /// How many triangles there were before those that fail the exact test were repaired by inserting the farthest samples.
    pub before_repair: usize,
    /// How many of these fail it.
    pub failing: usize,
}

/// Stitches the nested squares of a tile. With [`Corners::Free`] corners have heights of their own, also on the sides of the tile: a
/// mesh for a tile alone.
///
/// # Errors
/// [`Cancelled`].
///
/// # Panics
/// If the tile has missing samples.
pub fn stitch_literally(
    tile: &Tile,
    tolerance: f64,
    reading: Reading,
    corners: Corners,
    cancel: &CancelToken,
) -> Result<Literal, Cancelled> {
    assert!(tile.validity().is_whole(), "samples that are all there");
    let mut finder = Finder::new(tile, tolerance, corners);
    let sides = if reading == Reading::Disjoint { Sides::Apart } else { Sides::Shared };
    let squares = finder.nested(sides, |_| true, cancel)?;
    let domain = edges_of(tile, tolerance, &squares, corners);
    let (mut scratch, mut mesh) = (insertion::Scratch::default(), TileMesh::default());
    insertion::delaunay(&domain, std::iter::empty(), &mut scratch, &mut mesh);
    let tester = Tester::new(tile, tolerance, Feasibility::Weak);
    let fails = |&t: &[u32; 3]| !tester.weakly_feasible(mesh.corners(t));
    let (before_repair, failing) = (mesh.triangles.len(), mesh.triangles.iter().filter(|t| fails(t)).count());
    if failing > 0 {
        let (nothing, feasibility, max_stray) = (Domain::default(), Feasibility::Weak, f64::INFINITY);
        let task = Task { tile, domain: &nothing, tolerance, feasibility, max_stray, cancel };
        insertion::refine(&task, insertion::Rim::Free, &mut scratch, &mut mesh)?;
    }
    Ok(Literal { mesh, before_repair, failing })
}

/// The squares' sides and diagonals as loops: around the tile one, and of every other edge one of two vertices, there and back, which
/// is ground on both sides. Subsets of one sample inside the tile are points.
fn edges_of(tile: &Tile, tolerance: f64, squares: &[Square], corners: Corners) -> Domain {
    let numbers = numbered(squares);
    let mut domain = Domain { vertices: meeting(tile, tolerance, squares, corners, &numbers), ..Domain::default() };
    let (right, bottom) = (tile.width() - 1, tile.height() - 1);
    let along = |places: &mut dyn Iterator<Item = (usize, usize)>| -> Vec<u32> {
        places.filter_map(|(column, row)| numbers.get(&(row, column)).copied()).collect()
    };
    let rim = [
        along(&mut (0..right).map(|column| (column, 0))),
        along(&mut (0..bottom).map(|row| (right, row))),
        along(&mut (1..=right).rev().map(|column| (column, bottom))),
        along(&mut (1..=bottom).rev().map(|row| (0, row))),
    ];
    domain.loops.push(rim.concat());
    let mut edges = Vec::new();
    for square in squares {
        let Region { first, last } = square.region();
        let is_inside = |line: usize, end: usize| line > 0 && line < end;
        for row in [first.1, last.1].into_iter().filter(|&row| is_inside(row, bottom)) {
            edges.extend(pairs(&along(&mut (first.0..=last.0).map(|column| (column, row)))));
        }
        for column in [first.0, last.0].into_iter().filter(|&column| is_inside(column, right)) {
            edges.extend(pairs(&along(&mut (first.1..=last.1).map(|row| (column, row)))));
        }
        if !square.region().is_thin() {
            let [a, b, c, d] = square.region().corners();
            let (from, to) = if square.falling { (a, c) } else { (b, d) };
            edges.extend(pairs(&[numbers[&(from.1, from.0)], numbers[&(to.1, to.0)]]));
        }
    }
    edges.sort_unstable();
    edges.dedup();
    domain.loops.extend(edges.into_iter().map(|(a, b)| vec![a, b]));
    keep_lone_apart(&mut domain);
    domain
}

/// Neighbours in a list, the lower number first.
fn pairs(numbers: &[u32]) -> Vec<(u32, u32)> {
    numbers.windows(2).map(|pair| (pair[0].min(pair[1]), pair[0].max(pair[1]))).collect()
}

/// The corners of squares, numbered by rows: row and column of each.
fn numbered(squares: &[Square]) -> BTreeMap<(usize, usize), u32> {
    let places = squares.iter().flat_map(|square| square.region().corners());
    let mut numbers: BTreeMap<(usize, usize), u32> = places.map(|(column, row)| ((row, column), 0)).collect();
    numbers.values_mut().zip(0..).for_each(|(number, count)| *number = count);
    numbers
}

/// A vertex for every corner: of the mean height where several squares have it.
fn meeting(
    tile: &Tile,
    tolerance: f64,
    squares: &[Square],
    corners: Corners,
    numbers: &BTreeMap<(usize, usize), u32>,
) -> Vec<Vertex> {
    let mut sums = vec![(0.0, 0u32); numbers.len()];
    for square in squares {
        let places = square.region().corners();
        for (i, (column, row)) in places.into_iter().enumerate().filter(|(i, place)| !places[..*i].contains(place)) {
            let height = square.heights[i];
            let sum = &mut sums[numbers[&(row, column)] as usize];
            (sum.0, sum.1) = (sum.0 + height, sum.1 + 1);
        }
    }
    let quantum = Quantum::of(tolerance).filter(|_| corners == Corners::Free);
    let meet = |(row, column): (usize, usize), (sum, count): (f64, u32)| {
        if count == 1 {
            // As its square has been tested with it.
            return vertex((column, row), sum);
        }
        let mean = quantum.and_then(|quantum| quantum.round(sum / f64::from(count)));
        near_sample(tile, tolerance, (column, row), mean)
    };
    numbers.keys().zip(sums).map(|(&place, sum)| meet(place, sum)).collect()
}

/// Makes points of vertices that no edge has, numbered behind the others.
fn keep_lone_apart(domain: &mut Domain) {
    let mut used = vec![false; domain.vertices.len()];
    domain.loops.iter().flatten().for_each(|&v| used[v as usize] = true);
    let (mut kept, mut numbers) = (Vec::new(), vec![0u32; used.len()]);
    for (v, &vertex) in domain.vertices.iter().enumerate() {
        if used[v] {
            numbers[v] = kept.len() as u32;
            kept.push(vertex);
        } else {
            domain.points.push(vertex);
        }
    }
    domain.vertices = kept;
    domain.loops.iter_mut().flatten().for_each(|v| *v = numbers[*v as usize]);
}
