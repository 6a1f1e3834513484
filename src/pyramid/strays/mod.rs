//! Edges of a tile that stray: between samples of the grid, beyond the heights around them by more than they may.
//!
//! A *side* is the segment between two neighbouring samples of a row or a column that are both of the raster. Where an edge crosses it, the edge
//! is to lie between the heights of the two, give or take the limit. A tile that keeps its error has few that do not, most of them beside
//! vertices that it was mended by. A sample of the side becomes a vertex; where both are vertices, the part is triangulated anew, Delaunay.
//!
//! A side with a sample on a line of parts may be crossed by an edge that no vertex inside of the part does away with: the polyline on the
//! line is what it is. Beside the raster's rim and its voids cliffs begin, which are off by more between samples than at them. Such sides are tried, and
//! nothing is promised of them.
//!
//! **How fast.** Edges are nearly straight on the grid, and heights along them nearly linear; by how much they are not is bounded. Where
//! that cannot matter, a few operations tell that a crossing is within the limit. Elsewhere it is found on the edge in space.

mod mend;
mod steep;

use std::collections::BTreeMap;

pub(super) use self::mend::Straightened;
use super::body::{Angle, Body, Vector, length, minus};
use super::error::PyramidError;
use super::facet::reach;
use super::quantize::SPAN;
use super::samples::{Block, Patch, Samples};
use super::surface::Surface;
use crate::base::control::CancelToken;

/// What is kept of a limit for rounding, as a share of it, and in metres.
const MARGIN: (f64, f64) = (1e-9, 1e-5);

/// Samples that are read at a time, across and down.
const WINDOW: i64 = 64;

/// Rounds in which a crossing is looked for, at the most.
const ROUNDS: usize = 60;

/// The side that an edge strays from most, of those that count most.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stray {
    /// The part of the edge.
    pub(super) owner: u32,
    /// Column and row of the side's samples in the tile, the nearer one first.
    pub(super) side: [(i64, i64); 2],
    /// Whether one of them is on a line of parts, or beside a sample that the raster gives no height.
    pub(super) is_free: bool,
    /// How far beyond its heights the edge is, in metres.
    pub(super) by: f64,
}

impl Stray {
    /// Which of an edge's counts most.
    fn weight(&self) -> impl PartialOrd + use<> {
        (!self.is_free, self.by)
    }
}

/// What edges are compared with.
pub(super) struct Straightness<'a> {
    pub(super) body: &'a Body,
    pub(super) samples: &'a Samples,
    /// How far edges may be beyond the heights around, in metres.
    pub(super) limit: f64,
    /// How far the surface is from samples at the most.
    pub(super) max_error: f64,
    /// Cells of a part.
    pub(super) part_cells: i64,
    pub(super) cancel: &'a CancelToken,
}

/// An edge inside of a tile.
struct Edge {
    owner: u32,
    /// Columns and rows of its ends in the tile.
    places: [[f64; 2]; 2],
    heights: [f64; 2],
    /// Its ends in space, from the middle of the ellipsoid.
    ends: [Vector; 2],
    /// How far points of it may be from the straight line, in columns and rows, and in metres.
    reach: [f64; 2],
    sag: f64,
}

impl Edge {
    /// Whether it may be in a square, by its first and last column and row.
    fn meets(&self, square: &[[f64; 2]; 2]) -> bool {
        (0..2).all(|k| {
            let [a, b] = self.places.map(|place| place[k]);
            a.min(b) - self.reach[k] <= square[1][k] && a.max(b) + self.reach[k] >= square[0][k]
        })
    }

    fn is_near(&self, first: [i64; 2], size: [usize; 2]) -> bool {
        let last = [0, 1].map(|k| (first[k] + size[k] as i64) as f64);
        self.meets(&[first.map(|at| at as f64), last])
    }
}

impl Straightness<'_> {
    /// The edges that stray.
    pub(super) fn find(&self, surface: &Surface, block: &mut Block) -> Result<Vec<Stray>, PyramidError> {
        let grid = self.samples.grid;
        let cells = grid.cells(surface.tile.level);
        let origin = surface.tile.origin(grid);
        let steep = self.steep(surface);
        if steep.is_empty() {
            return Ok(Vec::new());
        }
        let mut edges = self.edges(surface);
        let mut found = BTreeMap::new();
        let around = |a: [[f64; 2]; 2], b: &[[f64; 2]; 2]| {
            [[0, 1].map(|k| a[0][k].min(b[0][k])), [0, 1].map(|k| a[1][k].max(b[1][k]))]
        };
        let all = steep.iter().fold(steep[0], around);
        edges.retain(|edge| edge.meets(&all));
        for ((left, top), (width, height)) in self.samples.windows(origin, cells, WINDOW) {
            self.cancel.check()?;
            // Sides between this window and the next are this one's; samples around them are looked at, too.
            let size = [width + 3, height + 3];
            let (column, row) = (origin.0 + left - 1, origin.1 + top - 1);
            let patch = Patch { column, row, width: size[0], height: size[1], step: 1 };
            let is_in = |square: &[[f64; 2]; 2]| {
                let meets = |k: usize, first: i64, count: usize| {
                    square[0][k] <= (first + count as i64) as f64 && square[1][k] >= first as f64
                };
                meets(0, left, width) && meets(1, top, height)
            };
            if !steep.iter().any(is_in) || !self.samples.has_any(patch) {
                continue;
            }
            self.samples.read(patch, block)?;
            let window = Window { task: self, first: [left - 1, top - 1], size, patch, block };
            let near = edges.iter().enumerate().filter(|(_, edge)| edge.is_near([left, top], [width, height]));
            for (number, edge) in near {
                let mut take = |stray: Stray| {
                    let known = found.entry(number).or_insert(stray);
                    if stray.weight() > known.weight() {
                        *known = stray;
                    }
                };
                window.judge(edge, 0, &mut take);
                window.judge(edge, 1, &mut take);
            }
        }
        Ok(found.into_values().collect())
    }

    /// Every edge that is not on the border, once.
    fn edges(&self, surface: &Surface) -> Vec<Edge> {
        let grid = self.samples.grid;
        let (cells, cell) = (grid.cells(surface.tile.level), grid.cell().to_radians());
        let scale = cells as f64 / SPAN as f64;
        let is_on_border = |[a, b]: [u32; 2]| {
            let [a, b] = [a, b].map(|i| &surface.vertices[i as usize]);
            let is_on = |a: i64, b: i64| a == b && (a == 0 || a == SPAN);
            is_on(a.u, b.u) || is_on(a.v, b.v)
        };
        let sides = surface
            .triangles
            .iter()
            .zip(&surface.owners)
            .flat_map(|(&[a, b, c], &owner)| [[a, b], [b, c], [c, a]].map(|ends| (ends, owner)));
        let inner = sides.filter(|(ends, _)| ends[0] < ends[1] && !is_on_border(*ends));
        let edge = |(numbers, owner): ([u32; 2], u32)| {
            let vertices = numbers.map(|i| surface.vertices[i as usize]);
            let ends = vertices.map(|v| [0, 1, 2].map(|k| v.at[k] + surface.centre[k]));
            let long = length(minus(ends[1], ends[0]));
            let (columns, rows) = reach(self.body, [ends[0], ends[1], ends[1]], cell);
            Edge {
                owner,
                places: vertices.map(|v| [v.u as f64 * scale, (SPAN - v.v) as f64 * scale]),
                heights: vertices.map(|v| surface.lattice.height(v.quantum)),
                ends,
                reach: [columns, rows],
                // An eighth, were the ellipsoid a sphere.
                sag: long * long * self.body.semi_major / (6.0 * self.body.semi_minor * self.body.semi_minor),
            }
        };
        inner.map(edge).collect()
    }

    fn limit(&self) -> f64 {
        self.limit * (1.0 - MARGIN.0) - MARGIN.1
    }

    /// Whether a sample is on a line of parts.
    fn is_on_line(&self, (column, row): (i64, i64)) -> bool {
        column % self.part_cells == 0 || row % self.part_cells == 0
    }
}

/// Samples of a tile.
struct Window<'a> {
    task: &'a Straightness<'a>,
    /// The first column and row in the tile, and how many there are.
    first: [i64; 2],
    size: [usize; 2],
    patch: Patch,
    block: &'a Block,
}

impl Window<'_> {
    /// Looks at the crossings of an edge with the columns of the window, or with its rows.
    fn judge(&self, edge: &Edge, axis: usize, take: &mut impl FnMut(Stray)) {
        let other = 1 - axis;
        let [[from, to], [start, end]] =
            [axis, other].map(|k| edge.places.map(|place| place[k] - self.first[k] as f64));
        let (run, drift, rise) = (to - from, end - start, edge.heights[1] - edge.heights[0]);
        let across = edge.reach[axis] / run.abs();
        // How far off a crossing may be along the line, and in height.
        let slack = edge.reach[other] + across * drift.abs();
        let limit = self.task.limit() - edge.sag - across * rise.abs();
        let most = self.size[other] as f64 - 1.0;
        if run == 0.0 || start.max(end) + slack < 0.0 || start.min(end) - slack > most {
            return;
        }
        let (first, last) = (from.min(to).max(-1.0), from.max(to).min(self.size[axis] as f64));
        let (first, last) = (first.floor() as i64 + 1, last.ceil() as i64 - 1);
        for line in first.max(1)..=last.min(self.size[axis] as i64 - 3) {
            let share = (line as f64 - from) / run;
            let (along, height) = (start + share * drift, edge.heights[0] + share * rise);
            // What is not a number is looked at.
            let is_far = along + slack < 0.0 || along - slack > most;
            if is_far || slack < 2.0 && self.is_within(line, axis, [along - slack, along + slack], height, limit) {
                continue;
            }
            if let Some((along, height)) = self.crossing(edge, axis, line, share) {
                self.stray(edge, axis, line, along, height).into_iter().for_each(&mut *take);
            }
        }
    }

    /// Whether an edge is surely within the limit on all sides of a line between two places along it.
    #[inline(always)]
    fn is_within(&self, line: i64, axis: usize, [low, high]: [f64; 2], height: f64, limit: f64) -> bool {
        let last = self.size[1 - axis] as i64 - 3;
        let (stride, start) = match axis {
            0 => (self.size[0], line as usize),
            _ => (1, line as usize * self.size[0]),
        };
        for before in (low.floor() as i64).max(1)..=(high.floor() as i64).min(last) {
            let i = start + before as usize * stride;
            let (one, two) = (self.block.heights[i], self.block.heights[i + stride]);
            let beyond = (height - one.max(two)).max(one.min(two) - height);
            if beyond >= limit && self.block.inside[i] && self.block.inside[i + stride] {
                return false;
            }
        }
        true
    }

    /// Where an edge crosses a line, along it, and how high above the ellipsoid.
    fn crossing(&self, edge: &Edge, axis: usize, line: i64, share: f64) -> Option<(f64, f64)> {
        let at = |share: f64| {
            let [a, b] = edge.ends;
            let guess = edge.places.map(|place| place[1] - self.first[1] as f64);
            let point = [0, 1, 2].map(|k| a[k] + share * (b[k] - a[k]));
            self.locate(point, guess[0] + share * (guess[1] - guess[0]))
        };
        let off = |found: &([f64; 2], f64)| found.0[axis] - line as f64;
        let ([mut low, mut high], [mut below, mut above]) = ([0.0, 1.0], [0.0, 1.0].map(|share| off(&at(share))));
        if (below > 0.0) == (above > 0.0) {
            return None;
        }
        let (mut share, mut moved, mut best) = (share, None, None);
        for _ in 0..ROUNDS {
            let found = at(share);
            let beside = off(&found);
            best = Some((found.0[1 - axis], found.1));
            if beside.abs() < 1e-9 {
                break;
            }
            let is_low = (beside > 0.0) == (below > 0.0);
            // An end that stays once more counts for half.
            let kept = if moved == Some(is_low) { 0.5 } else { 1.0 };
            if is_low {
                (low, below, above) = (share, beside, kept * above);
            } else {
                (high, above, below) = (share, beside, kept * below);
            }
            moved = Some(is_low);
            share = low + below / (below - above) * (high - low);
        }
        best
    }

    /// Column and row in the window of a point in space, given a guess of the row, and its height.
    fn locate(&self, [x, y, z]: Vector, row: f64) -> ([f64; 2], f64) {
        let (body, grid) = (self.task.body, self.task.samples.grid);
        let cell = grid.cell().to_radians();
        let lon = Angle::of(grid.longitude(self.patch.column));
        let column = libm::atan2(y * lon.cos - x * lon.sin, x * lon.cos + y * lon.sin) / cell;
        let from_axis = libm::hypot(x, y);
        let mut row = row.round();
        let mut found = (row, f64::NAN);
        for _ in 0..ROUNDS {
            let lat = Angle::of(grid.latitude(self.patch.row + row as i64));
            let [foot, _, foot_rise] = body.point(Angle { sin: 0.0, cos: 1.0 }, lat, 0.0);
            let (out, up) = (from_axis - foot, z - foot_rise);
            let (north, height) = (up * lat.cos - out * lat.sin, out * lat.cos + up * lat.sin);
            // A meridian is a circle about there.
            let radius = body.radii(lat).1;
            let beside = -libm::atan2(north, radius + height) / cell;
            found = (row + beside, libm::hypot(north, radius + height) - radius);
            if beside.abs() <= 1.0 {
                break;
            }
            row += beside.round();
        }
        ([column, found.0], found.1)
    }

    /// A crossing, if it strays and is on a side of the window.
    fn stray(&self, edge: &Edge, axis: usize, line: i64, along: f64, height: f64) -> Option<Stray> {
        let before = along.floor();
        if before < 1.0 || before as usize + 2 >= self.size[1 - axis] {
            return None;
        }
        let sample = |beside: i64| {
            let at = before as i64 + beside;
            let (column, row) = if axis == 0 { (line, at) } else { (at, line) };
            ((self.first[0] + column, self.first[1] + row), row as usize * self.size[0] + column as usize)
        };
        let [(one, i), (two, j)] = [sample(0), sample(1)];
        let (heights, inside) = (&self.block.heights, &self.block.inside);
        let by = (height - heights[i].max(heights[j])).max(heights[i].min(heights[j]) - height);
        if !inside[i] || !inside[j] || by <= self.task.limit() {
            return None;
        }
        let side = if along - before > 0.5 { [two, one] } else { [one, two] };
        let around = |i: usize| (0..9).any(|k| !inside[i + k / 3 * self.size[0] + k % 3 - self.size[0] - 1]);
        let is_free = side.iter().any(|&sample| self.task.is_on_line(sample)) || around(i) || around(j);
        Some(Stray { owner: edge.owner, side, is_free, by })
    }
}
