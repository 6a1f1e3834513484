//! The rim of a tile where samples are missing: the loops around its ground.
//!
//! On a side a vertex stands wherever the ground on either side of the line begins, ends, or has a corner; both
//! neighbours see that from the line and the two beside it. Between such vertices the side is a shortest path, as it is
//! where nothing is missing. Inside the tile, a vertex stands at every turn of the boundary and wherever loops touch, and
//! between them, too, there is a shortest path over the samples of the straight run.

use std::collections::{BTreeMap, BTreeSet};

use super::boundary::{Boundary, Step, WAYS, octants};
use super::chained::OnSide;
use super::cut::cut;
use super::rim::{Corner, Forced, place_of, vertex};
use super::runs::{Hold, Runs};
use super::{Foreign, Rim, RimCounts, Side};
use crate::base::Tile;
use crate::base::control::Cancelled;
use crate::base::lattice::Point;
use crate::base::mesh::{Domain, Vertex};
use crate::base::tiling::TilePlace;
use crate::kernel::breaklines::TileChains;

/// Computes the rim of a tile that is not whole.
pub(super) fn rim(
    runs: &mut Runs<'_>,
    forced: &Forced,
    chains: &TileChains,
    place: &TilePlace,
) -> Result<Rim, Cancelled> {
    let all = named(runs, forced, chains, place)?;
    let tile = runs.tile;
    let boundary = Boundary::new(tile.validity(), tile.width(), tile.height());
    let sample = |&(column, row): &(usize, usize)| (row * tile.width() + column) as u32;
    let on_sides: BTreeSet<Point> = all.iter().map(|n| n.vertex.at).collect();
    let named: Vec<Named> = all.into_iter().filter(|n| n.is_used).collect();
    let on_rim: BTreeMap<Point, usize> = named.iter().enumerate().map(|(i, n)| (n.vertex.at, i)).collect();
    let (points, on_boundary): (Vec<_>, Vec<_>) = forced.inside.iter().partition(|p| !boundary.passes(sample(p)));
    let of_chains = forced.of_chains.iter().filter(|p| boundary.passes(sample(p)));
    let mut forced: Vec<u32> = on_boundary.iter().chain(of_chains).map(sample).collect();
    forced.sort_unstable();

    let mut loops = Vec::new();
    let is_fixed = |before: Step, step: Step| match on_side(tile, step.sample) {
        true => on_sides.contains(&place_at(tile, step.sample)),
        false => {
            let turns = before.way != step.way;
            turns || boundary.is_pinched(step.sample) || forced.binary_search(&step.sample).is_ok()
        }
    };
    for steps in boundary.loops() {
        loops.push(with_chains(tile, chains, &vertices_of(runs, &steps, is_fixed)?));
    }
    if let Some(inside) = chains.inside() {
        loops = cut(&loops, chains, inside, (place.window, tile.far_corner()));
    }

    // Of the named vertices those that the tile's ground has.
    let mut numbers = vec![u32::MAX; named.len()];
    loops.iter().flatten().filter_map(|s| on_rim.get(s)).for_each(|&i| numbers[i] = 0);
    let mut rim = Rim { owned: owned(&named), ..Rim::default() };
    let (mut vertices, mut idle) = (Vec::new(), Vec::new());
    for (i, &Named { vertex, name, .. }) in named.iter().enumerate() {
        if numbers[i] == 0 {
            numbers[i] = vertices.len() as u32;
            vertices.push(vertex);
            rim.foreign.extend(name);
        } else if name.is_none() {
            idle.push((i as u32, vertex));
        }
    }
    let mut pinches: BTreeMap<Point, u32> = BTreeMap::new();
    let mut number = |at: Point| {
        if let Some(&i) = on_rim.get(&at) {
            return numbers[i];
        }
        let place = at.sample();
        let mut add = || {
            let of_chain = || chains.at(at).unwrap_or_else(|| panic!("a vertex between samples at {at:?}"));
            vertices.push(place.map_or_else(of_chain, |place| vertex(tile, place)));
            vertices.len() as u32 - 1
        };
        // Where loops are cut, any vertex may be one of several corners.
        let is_pinched = place.is_some_and(|place| boundary.is_pinched(sample(&place)));
        if is_pinched || chains.inside().is_some() { *pinches.entry(at).or_insert_with(add) } else { add() }
    };
    let loops = loops.iter().map(|l| l.iter().map(|&at| number(at)).collect()).collect();
    let points = points.into_iter().map(|place| vertex(tile, place)).collect();
    Ok(Rim { domain: Domain { vertices, loops, points, ..Domain::default() }, idle, ..rim })
}

/// A vertex on a side or at a corner, whichever of the tiles there has it.
struct Named {
    vertex: Vertex,
    side: Result<Side, Corner>,
    /// What it is called, unless the tile owns it.
    name: Option<Foreign>,
    /// Whether it is at the ground of any tile. Where outlines end the mesh, sides go on outside of them.
    is_used: bool,
}

/// All of them: those the tile owns first, in the order in which it numbers them.
fn named(
    runs: &mut Runs<'_>,
    forced: &Forced,
    chains: &TileChains,
    tile_place: &TilePlace,
) -> Result<Vec<Named>, Cancelled> {
    let tile = runs.tile;
    let (right, bottom) = (tile.width() - 1, tile.height() - 1);
    let mut named = Vec::new();
    // What stands between samples is of a chain, and that is of the mesh.
    let is_used = |vertex: &Vertex| {
        let sample = vertex.at.sample().filter(|_| chains.inside().is_some());
        sample.is_none_or(|(column, row)| tile.validity().is_ground(column as i32, row as i32))
    };
    for corner in Corner::ALL {
        let place = corner.place(tile);
        if octants(tile.validity(), place.0 as i32, place.1 as i32) != 0 {
            let (vertex, name) = (vertex(tile, place), corner.name(tile_place));
            named.push(Named { vertex, side: Err(corner), name, is_used: is_used(&vertex) });
        }
    }
    type Place<'a> = &'a dyn Fn(usize) -> (usize, usize);
    type Name = Option<fn(u32) -> Foreign>;
    let sides: [(Side, usize, &[usize], Place<'_>, Name); 4] = [
        (Side::North, tile.width(), &forced.north, &|i| (i, 0), None),
        (Side::West, tile.height(), &forced.west, &|i| (0, i), None),
        (Side::East, tile.height(), &forced.east, &|i| (right, i), (!tile_place.last_column).then_some(Foreign::East)),
        (Side::South, tile.width(), &forced.south, &|i| (i, bottom), (!tile_place.last_row).then_some(Foreign::South)),
    ];
    for (side, len, forced, place, name) in sides {
        let line = if matches!(side, Side::North | Side::South) { LEVEL } else { UPRIGHT };
        let ends_here = match side {
            Side::North => tile_place.id.row == 0,
            Side::West => tile_place.id.column == 0,
            Side::East => tile_place.last_column,
            Side::South => tile_place.last_row,
        };
        let on_side = OnSide::new(chains, side, tile.far_corner());
        let samples = vertices_between_corners(runs, line, ends_here, len, &on_side.force(forced), place)?;
        let along = on_side.merge(samples.into_iter().map(|i| vertex(tile, place(i))));
        let mut ordinal = 0;
        named.extend(along.into_iter().map(|vertex| {
            let (name, is_used) = (name.map(|name| name(ordinal)), is_used(&vertex));
            ordinal += u32::from(is_used);
            Named { vertex, side: Ok(side), name, is_used }
        }));
    }
    named.sort_by_key(|n| n.name.is_some());
    Ok(named)
}

fn owned(named: &[Named]) -> RimCounts {
    let mut counts = RimCounts::default();
    for n in named.iter().filter(|n| n.name.is_none()) {
        match n.side {
            Err(corner) => counts.corners |= corner.bit(),
            Ok(Side::North) => counts.north += 1,
            Ok(Side::West) => counts.west += 1,
            Ok(Side::East) => counts.east += 1,
            Ok(Side::South) => counts.south += 1,
        }
    }
    counts
}

/// Which octants of a sample on a line between tiles lie on its one side and on its other, and which along the way to the
/// next sample of the line.
#[derive(Debug, Clone, Copy)]
struct Line {
    halves: [u8; 2],
    onwards: u8,
}

const LEVEL: Line = Line { halves: [0b0000_1111, 0b1111_0000], onwards: 0b1000_0001 };
const UPRIGHT: Line = Line { halves: [0b1100_0011, 0b0011_1100], onwards: 0b0000_0110 };

impl Line {
    /// Whether there is no ground on one side of the line, onwards from a sample with these octants.
    fn has_void(&self, octants: u8) -> bool {
        self.halves.iter().any(|half| octants & half & self.onwards == 0)
    }

    /// Whether the ground on a side of the line begins, ends or has a corner at a sample with these octants.
    fn is_broken(&self, octants: u8) -> bool {
        self.halves.iter().any(|half| octants & half != 0 && octants & half != *half)
    }
}

/// The vertices of a side, as places along it: a function of the samples on its line and of where the ground is beside it.
/// `ends_here`: whether the raster ends at the side.
fn vertices_between_corners(
    runs: &mut Runs<'_>,
    line: Line,
    ends_here: bool,
    len: usize,
    forced: &[usize],
    place: impl Fn(usize) -> (usize, usize),
) -> Result<Vec<usize>, Cancelled> {
    let tile = runs.tile;
    let octants = |i: usize| octants(tile.validity(), place(i).0 as i32, place(i).1 as i32);
    let (mut vertices, mut from, mut from_octants) = (Vec::new(), 0, octants(0));
    for to in 1..len {
        let (is_corner, to_octants) = (to + 1 == len, octants(to));
        if !is_corner && !line.is_broken(to_octants) {
            continue;
        }
        if from_octants & line.onwards != 0 {
            let forced: Vec<usize> = forced.iter().filter(|f| (from..to).contains(f)).map(|f| f - from).collect();
            let is_final = !ends_here && line.has_void(from_octants);
            let hold = if is_final { runs.beside_void() } else { runs.on_side(len) };
            let between = runs.between(to - from + 1, &forced, hold, |i| place(from + i))?;
            vertices.extend(between.into_iter().map(|i| from + i));
        }
        if !is_corner {
            vertices.push(to);
        }
        (from, from_octants) = (to, to_octants);
    }
    Ok(vertices)
}

/// A loop through samples as places, and those of chains on it. It is straight, along one of the eight ways, from sample to sample.
fn with_chains(tile: &Tile, chains: &TileChains, samples: &[u32]) -> Vec<Point> {
    let mut places = Vec::with_capacity(samples.len());
    for (i, &sample) in samples.iter().enumerate() {
        let [p, q] = [sample, samples[(i + 1) % samples.len()]].map(|sample| place_at(tile, sample));
        places.push(p);
        if !chains.vertices().is_empty() {
            let (dx, dy) = (q.x - p.x, q.y - p.y);
            let between =
                (1..dx.abs().max(dy.abs())).map(|i| Point { x: p.x + dx.signum() * i, y: p.y + dy.signum() * i });
            places.extend(between.filter(|at| at.sample().is_none() && chains.at(*at).is_some()));
        }
    }
    places
}

fn place_at(tile: &Tile, sample: u32) -> Point {
    let (column, row) = place_of(tile, sample);
    Point::of_sample(column as i32, row as i32)
}

fn on_side(tile: &Tile, sample: u32) -> bool {
    let (column, row) = place_of(tile, sample);
    column == 0 || row == 0 || column + 1 == tile.width() || row + 1 == tile.height()
}

/// The samples of a loop that become vertices: the fixed ones, and between them, inside the tile, a shortest path.
fn vertices_of(
    runs: &mut Runs<'_>,
    steps: &[Step],
    is_fixed: impl Fn(Step, Step) -> bool,
) -> Result<Vec<u32>, Cancelled> {
    let (tile, count) = (runs.tile, steps.len());
    let fixed: Vec<usize> = (0..count).filter(|&i| is_fixed(steps[(i + count - 1) % count], steps[i])).collect();
    let mut vertices = Vec::new();
    for (n, &from) in fixed.iter().enumerate() {
        vertices.push(steps[from].sample);
        let len = match fixed.get(n + 1) {
            Some(to) => to - from + 1,
            None => count - from + fixed[0] + 1,
        };
        // What is between on a side, was fixed there.
        if len > 2 && !on_side(tile, steps[(from + 1) % count].sample) {
            let ((column, row), (dx, dy)) = (place_of(tile, steps[from].sample), WAYS[steps[from].way as usize]);
            let place = |i: usize| ((column as i32 + dx * i as i32) as usize, (row as i32 + dy * i as i32) as usize);
            // Links inside the tile are its own: they are split where that is needed.
            let between = runs.between(len, &[], Hold::TOLERANCE, place)?;
            vertices.extend(between.into_iter().map(|i| steps[(from + i) % count].sample));
        }
    }
    Ok(vertices)
}
