//! How far the edges of a tile stray from the heights of the grid, between its samples.
//!
//! A *side* is the segment between two neighbouring samples of a row or a column, both of which the raster gives a height. Where the
//! normal of the ellipsoid at a point of an edge meets a side, the point's height is to lie between those of the two samples, give
//! or take so many times the level's error. Of every edge inside of a tile the points are judged where it crosses columns and rows that lie
//! between its ends. Edges on the border of a tile run along a line of samples, and cross none. Sides with a sample on a line of tiles, or of their
//! parts, are beside what nothing inside of a part changes, and those with one beside a sample without a height are where cliffs begin: how far edges
//! stray there is told, and is no fault.
//!
//! Crossings are those of the edge in space: a column is the plane of a meridian, a row the cone of normals along a parallel. The height
//! of a crossing is off by less than 10⁻⁶ m, which is [`DOUBT`].

use rustc_hash::{FxHashMap, FxHashSet};
use serde::Serialize;

use super::decode::LAST;
use super::ellipsoid::{Meridian, Parallel, Point, less, times};
use super::findings::{Findings, Kind};
use super::known::Known;
use super::tile::Tile;
use crate::pyramid::{Patch, PyramidError, SampleBlock, Samples};

/// What is not beyond a limit by more is within it, in metres.
const DOUBT: f64 = 1e-6;

/// What is closer to a sample, in cells, is at it, where it is judged by the error.
const AT_SAMPLE: f64 = 1e-6;

/// Samples that are read at a time, across and down.
const WINDOW: i64 = 256;

/// Rounds in which a crossing with a row is looked for, at the most.
const ROUNDS: usize = 60;

/// How far edges stray from the heights of the grid, between its samples.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Strays {
    /// The most, in metres, but on sides that have a sample on a line of tiles or of their parts, or beside one without a height.
    pub largest: f64,
    /// The most on those.
    pub largest_left_out: f64,
    /// Edges that stray farther than is promised.
    pub beyond: u64,
}

/// The largest that were found of a level so far.
#[derive(Debug, Default)]
pub(super) struct KnownStrays {
    largest: Known,
    left_out: Known,
}

/// What edges of a tile are held to.
#[derive(Debug, Clone, Copy)]
pub(super) struct Held<'a> {
    /// How far they may stray, in metres.
    pub(super) limit: f64,
    /// Into how many parts the tile was cut, each way.
    pub(super) parts: u32,
    pub(super) known: &'a KnownStrays,
}

/// An edge: its ends in space, and their columns and rows in the tile.
struct Edge {
    ends: [Point; 2],
    places: [[f64; 2]; 2],
    /// How far its points may be from the straight line on the grid, in cells, and from the heights of one, in metres.
    bend: [f64; 2],
    /// The heights of its ends.
    heights: [f64; 2],
    /// How far it strays, where that counts, in metres.
    farthest: f64,
}

/// Where an edge meets a line of samples: where along the line, and how high.
struct Crossing {
    along: f64,
    height: f64,
}

impl Strays {
    /// What is the most in either.
    pub(super) fn with(self, other: Strays) -> Strays {
        Strays {
            largest: self.largest.max(other.largest),
            largest_left_out: self.largest_left_out.max(other.largest_left_out),
            beyond: self.beyond + other.beyond,
        }
    }
}

impl Tile<'_> {
    /// Finds how far its edges stray.
    pub(super) fn strays(
        &self,
        samples: &Samples,
        block: &mut SampleBlock,
        held: Held<'_>,
        findings: &mut Findings,
    ) -> Result<Strays, PyramidError> {
        let cells = self.grid.cells(self.key.level);
        let origin = self.key.origin(self.grid);
        let mut edges = self.edges(cells as f64);
        let (largest, largest_left_out) = (held.known.largest.so_far(), held.known.left_out.so_far());
        let mut found = Strays { largest, largest_left_out, beyond: 0 };
        let part = (cells / i64::from(held.parts.max(1))).max(1);
        let windows = samples.windows(origin, cells, WINDOW);
        let numbers: Vec<(i64, i64)> = windows.iter().map(|((left, top), _)| (left / WINDOW, top / WINDOW)).collect();
        let lists = near_windows(&edges, &numbers);
        for ((left, top), (width, height)) in windows {
            // Sides between this window and the next are this one's; samples around them are looked at, too.
            let (left, top, across, down) = (left - 1, top - 1, width + 3, height + 3);
            let patch = Patch { column: origin.0 + left, row: origin.1 + top, width: across, height: down, step: 1 };
            if !samples.has_any(patch) {
                continue;
            }
            let number = ((left + 1) / WINDOW, (top + 1) / WINDOW);
            let Some(near) = lists.get(&number).filter(|near| !near.is_empty()) else { continue };
            samples.read(patch, block)?;
            let meridians = (left..left + across as i64).map(|c| Meridian::of(self.grid.longitude(origin.0 + c)));
            let parallels = (top..top + down as i64).map(|r| self.ellipsoid.parallel(self.grid.latitude(origin.1 + r)));
            let (meridians, parallels) = (meridians.collect(), parallels.collect());
            let cell = self.grid.cell().to_radians();
            let has_rim = block.inside.contains(&false);
            let (first, size) = ([left, top], [across, down]);
            let window = Window { first, size, meridians, parallels, cell, part, has_rim, block };
            for &edge in near {
                for axis in [0, 1] {
                    window.judge(self, &mut edges[edge as usize], axis, held.limit, &mut found);
                }
            }
        }
        held.known.largest.raise(found.largest);
        held.known.left_out.raise(found.largest_left_out);
        for edge in edges.iter().filter(|edge| edge.farthest > held.limit + DOUBT) {
            found.beyond += 1;
            let (key, limit, by) = (self.key, held.limit, edge.farthest);
            findings.add(Kind::Strays, || {
                let [[west, north], [east, south]] = edge.places.map(|[column, row]| {
                    let cell = self.grid.cell();
                    [self.grid.longitude(origin.0) + column * cell, self.grid.latitude(origin.1) - row * cell]
                });
                format!(
                    "tile {key}: the edge from {west}°, {north}° to {east}°, {south}° is {by} m beyond the heights around, between \
                     samples, allowed are {limit}"
                )
            });
        }
        Ok(found)
    }

    /// Every edge inside, once.
    fn edges(&self, cells: f64) -> Vec<Edge> {
        let last = f64::from(LAST);
        let vertices = &self.decoded.vertices;
        let is_on_border = |a: u32, b: u32| {
            let [a, b] = [a, b].map(|i| vertices[i as usize]);
            (0..2).any(|k| a[k] == b[k] && (a[k] == 0 || a[k] == LAST))
        };
        let mut seen = FxHashSet::default();
        let sides = self.decoded.triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
        let inner = sides.filter(|&(a, b)| !is_on_border(a, b) && seen.insert((a.min(b), a.max(b))));
        let edge = |(a, b): (u32, u32)| {
            let ends = [a, b].map(|i| self.points[i as usize]);
            let places = [a, b].map(|i| {
                let [u, v, _] = vertices[i as usize].map(f64::from);
                [u * cells / last, (last - v) * cells / last]
            });
            let heights = [a, b].map(|i| self.decoded.height(i as usize));
            Edge { ends, places, bend: self.bend(ends), heights, farthest: 0.0 }
        };
        inner.map(edge).collect()
    }

    /// How far a chord may be from the straight line between its ends on the grid, and from the heights along one: a second derivative
    /// times an eighth of its length's square.
    fn bend(&self, [a, b]: [Point; 2]) -> [f64; 2] {
        let along = less(b, a);
        let (square, half) = (times(along, along) / 8.0, 0.5 * times(along, along).sqrt());
        let from_axis = a[0].hypot(a[1]).min(b[0].hypot(b[1])) - half;
        let from_centre = self.ellipsoid.least_radius() + self.decoded.minimum.min(0.0) - half;
        let [columns, rows] = self.ellipsoid.bends(from_axis, from_centre);
        // Farther than the whole tile is as good as anywhere.
        let most = 4.0 * self.grid.cells(self.key.level) as f64;
        let cells = (columns.max(rows) * square / self.grid.cell().to_radians()).min(most);
        let sag = if from_centre > 0.0 { square / from_centre } else { f64::INFINITY };
        [cells + 1e-6, sag + DOUBT]
    }
}

/// The edges that may be in each of some windows, or a cell beside it; windows are numbered from the corner of the tile.
fn near_windows(edges: &[Edge], windows: &[(i64, i64)]) -> FxHashMap<(i64, i64), Vec<u32>> {
    let mut lists: FxHashMap<(i64, i64), Vec<u32>> = windows.iter().map(|&window| (window, Vec::new())).collect();
    let ends = |of: fn(&(i64, i64)) -> i64| Some((windows.iter().map(of).min()?, windows.iter().map(of).max()?));
    let (Some(across), Some(down)) = (ends(|window| window.0), ends(|window| window.1)) else { return lists };
    for (number, edge) in (0..).zip(edges) {
        let range = |k: usize, (first, last): (i64, i64)| {
            let [a, b] = edge.places.map(|place| place[k]);
            // Windows look at a cell before them and two behind.
            let low = ((a.min(b) - edge.bend[0] - 3.0) / WINDOW as f64).floor() as i64;
            let high = ((a.max(b) + edge.bend[0] + 3.0) / WINDOW as f64).floor() as i64;
            low.max(first)..=high.min(last)
        };
        let columns = range(0, across);
        for row in range(1, down) {
            for column in columns.clone() {
                if let Some(list) = lists.get_mut(&(column, row)) {
                    list.push(number);
                }
            }
        }
    }
    lists
}

/// Samples of a tile, and where they are.
struct Window<'a> {
    /// The first column and row in the tile, and how many there are.
    first: [i64; 2],
    size: [usize; 2],
    meridians: Vec<Meridian>,
    parallels: Vec<Parallel>,
    /// In radians.
    cell: f64,
    /// Cells of a part.
    part: i64,
    /// Whether it has samples that the raster gives no height.
    has_rim: bool,
    block: &'a SampleBlock,
}

impl Window<'_> {
    /// Judges the crossings of an edge with the columns of the window, or with its rows.
    fn judge(&self, tile: &Tile<'_>, edge: &mut Edge, axis: usize, limit: f64, found: &mut Strays) {
        let other = 1 - axis;
        let [[from, to], [from_along, to_along]] = [axis, other].map(|k| edge.places.map(|place| place[k]));
        let (mut low, mut high) = (from.min(to), from.max(to));
        // Only as far as it is in the window.
        if (to_along - from_along).abs() > 1.0 {
            let at = |along: f64| from + (along - from_along) / (to_along - from_along) * (to - from);
            let slack = edge.bend[0] * (1.0 + ((to - from) / (to_along - from_along)).abs());
            let [near, far] = [0, self.size[other] as i64 - 1].map(|i| at((self.first[other] + i) as f64));
            (low, high) = (low.max(near.min(far) - slack), high.min(near.max(far) + slack));
        }
        let (first, last) = (self.first[axis] + 1, self.first[axis] + self.size[axis] as i64 - 3);
        let across = edge.bend[0] / (to - from).abs();
        let off = edge.bend[0] + across * (to_along - from_along).abs();
        let higher = edge.bend[1] + across * (edge.heights[1] - edge.heights[0]).abs();
        let is_straight = off < 2.0;
        for line in (low.ceil() as i64).max(first)..=(high.floor() as i64).min(last) {
            if line as f64 <= from.min(to) || line as f64 >= from.max(to) {
                continue;
            }
            let share = (line as f64 - from) / (to - from);
            let guess = from_along + share * (to_along - from_along) - self.first[other] as f64;
            let number = (line - self.first[axis]) as usize;
            // What cannot be more than was found already is passed over.
            let height = edge.heights[0] + share * (edge.heights[1] - edge.heights[0]);
            let sides = || (guess - off).floor() as i64..=(guess + off).floor() as i64 + 1;
            let is_on_line = |at: i64| at.rem_euclid(self.part) == 0;
            let may_be_left_out = is_on_line(line)
                || self.has_rim
                || is_straight && sides().map(|at| self.first[other] + at).any(is_on_line);
            let left_out = if may_be_left_out { found.largest_left_out } else { f64::INFINITY };
            let known = found.largest.min(left_out).min(limit);
            if is_straight && self.most_beyond(axis, number, [guess - off, guess + off], height) + higher <= known {
                continue;
            }
            let crossing = match axis {
                0 => self.with_column(edge.ends, number, guess, tile),
                _ => self.with_row(edge.ends, number, guess, share),
            };
            let Some(Crossing { along, height }) = crossing else { continue };
            let before = along.floor();
            let is_at_sample = (along - before) < AT_SAMPLE || (along - before) > 1.0 - AT_SAMPLE;
            if before < 1.0 || before as usize + 2 >= self.size[other] || is_at_sample {
                continue;
            }
            let [i, j] = [0, 1].map(|beside| {
                let at = before as usize + beside;
                if axis == 0 { at * self.size[0] + number } else { number * self.size[0] + at }
            });
            if !self.block.inside[i] || !self.block.inside[j] {
                continue;
            }
            let [one, two] = [i, j].map(|i| self.block.heights[i]);
            let beyond = (height - one.max(two)).max(one.min(two) - height);
            let before = self.first[other] + before as i64;
            let is_beside_line = [line, before, before + 1].into_iter().any(is_on_line);
            if is_beside_line || self.is_at_rim(i) || self.is_at_rim(j) {
                found.largest_left_out = found.largest_left_out.max(beyond);
            } else {
                found.largest = found.largest.max(beyond);
                edge.farthest = edge.farthest.max(beyond);
            }
        }
    }

    /// Whether one of the samples around one has no height.
    fn is_at_rim(&self, i: usize) -> bool {
        (0..3).any(|row| {
            let start = i + row * self.size[0] - self.size[0] - 1;
            self.block.inside[start..start + 3].contains(&false)
        })
    }

    /// How far a height is beyond those of a side, at the most, between two places along a line.
    fn most_beyond(&self, axis: usize, number: usize, [low, high]: [f64; 2], height: f64) -> f64 {
        let (start, step) = if axis == 0 { (number, self.size[0]) } else { (number * self.size[0], 1) };
        let last = self.size[1 - axis] as i64 - 3;
        let mut most = f64::NEG_INFINITY;
        for before in (low.floor() as i64).max(1)..=(high.floor() as i64).min(last) {
            let i = start + before as usize * step;
            let [one, two] = [i, i + step].map(|i| self.block.heights[i]);
            if self.block.inside[i] && self.block.inside[i + step] {
                most = most.max((height - one.max(two)).max(one.min(two) - height));
            }
        }
        most
    }

    /// Where an edge crosses a meridian, which is one point of a plane.
    fn with_column(&self, [a, b]: [Point; 2], column: usize, guess: f64, tile: &Tile<'_>) -> Option<Crossing> {
        let meridian = self.meridians[column];
        let [east, to] = [a, b].map(|p| meridian.east(p));
        let point = on_edge([a, b], east / (east - to));
        // From the middle of the curvature at the nearest parallel, a meridian is a circle there.
        let last = self.parallels.len() as f64 - 1.0;
        let mut row = guess.round().clamp(0.0, last);
        for _ in 0..ROUNDS {
            let parallel = &self.parallels[row as usize];
            let (north, up) = parallel.seen_from_foot(meridian.forward(point), point[2]);
            let radius = tile.ellipsoid.along_meridian(parallel);
            let along = row - north.atan2(radius + up) / self.cell;
            let nearer = along.round().clamp(0.0, last);
            if nearer == row {
                return Some(Crossing { along, height: north.hypot(radius + up) - radius });
            }
            row = nearer;
        }
        None
    }

    /// Where an edge crosses the normals along a parallel, between its ends.
    fn with_row(&self, [a, b]: [Point; 2], row: usize, guess: f64, share: f64) -> Option<Crossing> {
        let parallel = &self.parallels[row];
        let seen = |p: Point| parallel.seen_from_foot(p[0].hypot(p[1]), p[2]);
        let ([mut low, mut high], [mut below, mut above]) = ([0.0, 1.0], [a, b].map(|p| seen(p).0));
        if (below > 0.0) == (above > 0.0) {
            return None;
        }
        let (mut at, mut moved) = (share, None);
        for _ in 0..ROUNDS {
            let point = on_edge([a, b], at);
            let (north, height) = seen(point);
            if north.abs() < 1e-7 {
                let last = self.meridians.len() as f64 - 1.0;
                let column = guess.round().clamp(0.0, last);
                let meridian = &self.meridians[column as usize];
                let turned = meridian.east(point).atan2(meridian.forward(point));
                return Some(Crossing { along: column + turned / self.cell, height });
            }
            // An end that stays once more counts for half, so that it does not stay for long.
            let is_low = (north > 0.0) == (below > 0.0);
            let share = if moved == Some(is_low) { 0.5 } else { 1.0 };
            match is_low {
                true => (low, below, above) = (at, north, share * above),
                false => (high, above, below) = (at, north, share * below),
            }
            moved = Some(is_low);
            at = low + below / (below - above) * (high - low);
        }
        None
    }
}

/// A point of an edge.
fn on_edge([a, b]: [Point; 2], share: f64) -> Point {
    let along = less(b, a);
    [0, 1, 2].map(|k| a[k] + share * along[k])
}
