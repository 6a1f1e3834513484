//! A triangle of a tile's surface: which samples it may have, which it has, and how far it is from them.
//!
//! **Which it may have.** Longitude and latitude of a point of a triangle are those of the corners, weighted as the point is, up to
//! ½ Σ wᵢ H |Aᵢ − X|² ≤ H L² ÷ 6, if L is the longest side and H bounds the second derivatives on the triangle (Taylor at X; the first
//! order cancels, and Σ wᵢ |Aᵢ − X|² = Σ wᵢ wⱼ |Aᵢ − Aⱼ|²). For the longitude H = 1 ÷ p², p the distance from the axis; for the
//! latitude H = (1 + 3e²) ÷ ρ² + 1 ÷ ρp, ρ the distance from the centre of curvature. So samples are looked for between straight
//! lines on the grid and that much beyond. Where that is far beyond, near a pole, the columns of each row are found by solving for
//! the longitudes that are on the inner side of the edges ([`Edge`]), between those of its corners: a tile is not more than half of the way
//! around, and the normal at a place is in the plane of its meridian.

use std::f64::consts::PI;

use super::Body;
use super::body::{Vector, cross, dot, length, minus};
use super::quantize::SPAN;
use super::surface::Surface;

/// What rounding adds to an error at a sample of the grid, in metres on level ground.
pub(super) const DOUBT: f64 = 1e-8;

/// How far outside of an edge a sample may be and count as on it, in metres: on a meridian that is a border all of them are.
const SLACK: f64 = 1e-7;

/// How far beyond the ends of a chord at the border a place may be along it and count as beside it, in cells: numbers are rounded.
const ALONG: f64 = 1e-6;

/// What the quick way to an error may be off by, in metres on level ground: it subtracts numbers as large as the ellipsoid.
const MARGIN: f64 = 1e-6;

/// The edges of a triangle, by its corners.
const EDGES: [(usize, usize); 3] = [(0, 1), (1, 2), (2, 0)];

/// A triangle that samples are looked for under.
pub(super) struct Facet {
    corners: [Vector; 3],
    /// Column and row of the corners, in cells.
    flat: [(f64, f64); 3],
    normal: Vector,
    length: f64,
    /// What normal and corners have in common, from the middle of the ellipsoid.
    offset: f64,
    /// Where its edges lie on the tile's border: the axis that they follow there.
    border: [Option<Axis>; 3],
    /// How far its points may be from where straight lines have them, in columns and rows; infinite for all columns.
    reach: (f64, f64),
    /// Where `reach` says little of columns.
    polar: Option<Box<Polar>>,
}

/// A triangle near a pole.
struct Polar {
    /// The edges that are no border.
    edges: Vec<Edge>,
    /// How columns lie on longitudes.
    columns: Columns,
    /// Between which samples may be in it.
    ends: (f64, f64),
}

/// An edge AB: ((A − S) × (B − S)) · N = (A × B) · N − (A − B) · (S × N), which is α cos λ + β sin λ + γ along a parallel.
struct Edge {
    /// A × B, from the middle of the ellipsoid.
    product: Vector,
    /// A − B.
    difference: Vector,
    /// What counts as on it: more than slack and rounding are.
    margin: f64,
}

/// What a facet near a pole takes beside itself.
pub(super) const POLAR_BYTES: u64 = (3 * size_of::<Edge>() + size_of::<Polar>()) as u64;

/// The longitudes of a tile's columns, in radians.
#[derive(Debug, Clone, Copy)]
pub(super) struct Columns {
    /// Of the first.
    pub(super) west: f64,
    /// From one to the next.
    pub(super) cell: f64,
    /// Cells in the tile.
    pub(super) count: i64,
}

impl Columns {
    /// The columns of an arc, given its middle and half of its length; of no tile's arc are both ends in it and the middle not.
    fn of_arc(&self, middle: f64, half: f64) -> (f64, f64) {
        let width = 0.5 * self.cell * self.count as f64;
        if half + width >= PI {
            return (0.0, self.count as f64);
        }
        let from_west = (middle - self.west + PI - width).rem_euclid(2.0 * PI) - PI + width;
        ((from_west - half) / self.cell, (from_west + half) / self.cell)
    }
}

impl Edge {
    fn new(a: Vector, b: Vector) -> Edge {
        let difference = minus(a, b);
        Edge { product: cross(a, b), difference, margin: 1e-5 * length(difference) }
    }

    /// The columns of a row that are on its inner side, or so near that it does not matter.
    fn columns(&self, row: &Row, columns: &Columns) -> Option<(f64, f64)> {
        let m = row.from_axis * row.sin - row.from_equator * row.cos;
        let alpha = row.cos * self.product[0] + m * self.difference[1];
        let beta = row.cos * self.product[1] - m * self.difference[0];
        let (gamma, size) = (row.sin * self.product[2] + self.margin, libm::hypot(alpha, beta));
        if gamma <= -size {
            return None;
        }
        if gamma >= size {
            return Some((0.0, columns.count as f64));
        }
        Some(columns.of_arc(libm::atan2(beta, alpha), libm::acos(-gamma / size) + ARC_MARGIN))
    }
}

/// What arcs may be off by, in radians, as the cosine hardly changes where it is largest.
const ARC_MARGIN: f64 = 1e-7;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Axis {
    Columns,
    Rows,
}

/// A row of samples, as far as the quick way to errors needs to know.
pub(super) struct Row {
    /// Sine and cosine of the latitude.
    pub(super) sin: f64,
    pub(super) cos: f64,
    /// The distance of places on the ellipsoid from its axis, and from the plane of its equator.
    pub(super) from_axis: f64,
    pub(super) from_equator: f64,
}

/// Samples that are looked at together.
const LANES: usize = 8;

/// What a facet's errors in a row are reckoned from: the normal's part along the parallel changes with the column alone.
struct Quick {
    normal: [f64; 2],
    from_axis: f64,
    offset: f64,
    cos: f64,
    vertical: f64,
    tolerance: f64,
    margin: f64,
}

impl Quick {
    /// Error and facing, both times the normal's length.
    #[inline(always)]
    fn at(&self, cos: f64, sin: f64, height: f64) -> (f64, f64) {
        let along = self.normal[0] * cos + self.normal[1] * sin;
        let facing = self.cos * along + self.vertical;
        ((self.offset - self.from_axis * along) - height * facing, facing)
    }

    /// Whether the error at a sample may be above the tolerance.
    #[inline(always)]
    fn is_suspicious(&self, cos: f64, sin: f64, height: f64) -> bool {
        let (error, facing) = self.at(cos, sin, height);
        // What is not a number is suspicious, too.
        let is_within = error.abs() < self.tolerance * facing - self.margin;
        !is_within
    }

    /// The first of the samples with the largest error, about.
    fn farthest(&self, (cos, sin): (&[f64], &[f64]), heights: &[f64]) -> usize {
        let mut best = (f64::NEG_INFINITY, 0);
        for (i, ((&cos, &sin), &height)) in cos.iter().zip(sin).zip(heights).enumerate() {
            let (error, facing) = self.at(cos, sin, height);
            let error = error.abs() / facing;
            if error > best.0 {
                best = (error, i);
            }
        }
        best.1
    }
}

impl Facet {
    pub(super) fn new(surface: &Surface, triangle: [u32; 3], body: &Body, columns: Columns) -> Facet {
        let vertices = triangle.map(|i| surface.vertices[i as usize]);
        let corners = vertices.map(|v| v.at);
        let scale = columns.count as f64 / SPAN as f64;
        let flat = vertices.map(|v| (v.u as f64 * scale, (SPAN - v.v) as f64 * scale));
        let normal = cross(minus(corners[1], corners[0]), minus(corners[2], corners[0]));
        let points = corners.map(|c| [c[0] + surface.centre[0], c[1] + surface.centre[1], c[2] + surface.centre[2]]);
        let border = EDGES.map(|(i, j)| {
            let (a, b) = (&vertices[i], &vertices[j]);
            let is_on = |a: i64, b: i64| a == b && (a == 0 || a == SPAN);
            if is_on(a.v, b.v) { Some(Axis::Columns) } else { is_on(a.u, b.u).then_some(Axis::Rows) }
        });
        let reach = reach(body, points, columns.cell);
        let inner = || (0..3).filter(|&edge| border[edge].is_none()).map(|edge| EDGES[edge]);
        let width = flat.iter().fold(0.0f64, |width, p| width.max((p.0 - flat[0].0).abs()));
        let is_wide = reach.0 > 2.0 + 0.25 * width;
        let polar = is_wide.then(|| {
            // Slack is felt most by the samples next to the pole, which are a cell from it.
            let slack = 2.0 * SLACK / (0.99 * body.semi_minor * columns.cell * columns.cell) + 1e-6;
            let [a, b, c] = flat.map(|p| p.0);
            let ends = (a.min(b).min(c) - slack, a.max(b).max(c) + slack);
            Box::new(Polar { edges: inner().map(|(i, j)| Edge::new(points[i], points[j])).collect(), columns, ends })
        });
        Facet { corners, flat, normal, length: length(normal), offset: dot(normal, points[0]), border, reach, polar }
    }

    /// The first and the last row and column where samples may be in it.
    pub(super) fn bounds(&self) -> [(f64, f64); 2] {
        let (columns, rows) = (self.flat.map(|p| p.0), self.flat.map(|p| p.1));
        let bounds = |[a, b, c]: [f64; 3], reach: f64| (a.min(b).min(c) - reach, a.max(b).max(c) + reach);
        let across = self.polar.as_ref().map_or_else(|| bounds(columns, self.reach.0), |polar| polar.ends);
        [across, bounds(rows, self.reach.1)]
    }

    /// The columns of a row between which samples may be in it.
    pub(super) fn columns(&self, row: f64, at: &Row) -> Option<(f64, f64)> {
        self.sides_of().columns(row, at)
    }

    /// The columns between which places of it are that lie from one row to another.
    pub(super) fn columns_between(&self, first: f64, last: f64) -> Option<(f64, f64)> {
        self.sides_of().columns_between(first, last)
    }

    /// What rows are asked about, one after the other.
    pub(super) fn sides_of(&self) -> Sides<'_> {
        let lines = EDGES.map(|(i, j)| {
            let (a, b) = if self.flat[i].1 <= self.flat[j].1 { (i, j) } else { (j, i) };
            let (a, b) = (self.flat[a], self.flat[b]);
            // Of a level one an end is enough: others begin or end at the other.
            let slope = if b.1 > a.1 { (b.0 - a.0) / (b.1 - a.1) } else { 0.0 };
            [a.1, b.1, a.0, slope]
        });
        Sides { facet: self, lines }
    }

    /// How high its plane is above the ellipsoid where a parallel and a meridian meet, given the meridian's cosine and sine, and the cosine between both
    /// normals there.
    pub(super) fn above(&self, row: &Row, (cos, sin): (f64, f64)) -> (f64, f64) {
        let (error, facing) = self.quick(row, 0.0).at(cos, sin, 0.0);
        (error / facing, facing / self.length)
    }

    fn quick(&self, row: &Row, tolerance: f64) -> Quick {
        Quick {
            normal: [self.normal[0], self.normal[1]],
            from_axis: row.from_axis,
            offset: self.offset - row.from_equator * self.normal[2],
            cos: row.cos,
            vertical: row.sin * self.normal[2],
            tolerance,
            margin: MARGIN * self.length,
        }
    }

    /// Calls `look` with the place of each sample of a row, among the columns and heights given, where the error may be above a
    /// tolerance; it answers with the tolerance from then on. Errors that are below the one that `peek` tells of the farthest sample
    /// do not count: along a fine row they may grow from one sample to the next.
    pub(super) fn each_suspicious(
        &self,
        row: &Row,
        (cos, sin): (&[f64], &[f64]),
        heights: &[f64],
        tolerance: f64,
        peek: impl Fn(usize) -> f64,
        mut look: impl FnMut(usize) -> f64,
    ) {
        let mut least = None;
        let mut quick = self.quick(row, tolerance);
        let lanes = heights.len() / LANES * LANES;
        for start in (0..heights.len()).step_by(LANES) {
            if start < lanes {
                let lane = |from: &[f64]| -> [f64; LANES] { from[start..start + LANES].try_into().expect("lanes") };
                let (cos, sin, heights) = (lane(cos), lane(sin), lane(heights));
                let mut any = false;
                for i in 0..LANES {
                    any |= quick.is_suspicious(cos[i], sin[i], heights[i]);
                }
                if !any {
                    continue;
                }
            }
            for i in start..(start + LANES).min(heights.len()) {
                if quick.is_suspicious(cos[i], sin[i], heights[i]) {
                    let least =
                        *least.get_or_insert_with(|| peek(i + quick.farthest((&cos[i..], &sin[i..]), &heights[i..])));
                    quick.tolerance = quick.tolerance.max(least);
                    if quick.is_suspicious(cos[i], sin[i], heights[i]) {
                        quick.tolerance = look(i).max(least);
                    }
                }
            }
        }
    }

    /// On which side of its edges a place is: from which on it counts as inside.
    fn sides(&self, place: Vector, normal: Vector) -> [bool; 3] {
        self.sides_within(place, normal, SLACK)
    }

    fn sides_within(&self, place: Vector, normal: Vector, slack: f64) -> [bool; 3] {
        let from = self.corners.map(|corner| minus(corner, place));
        EDGES.map(|(i, j)| {
            let side = length(minus(self.corners[i], self.corners[j]));
            dot(cross(from[i], from[j]), normal) >= -slack * side
        })
    }

    /// Whether the normal at a place meets it, or passes no edge of it farther outside than some metres.
    pub(super) fn has_within(&self, place: Vector, normal: Vector, slack: f64) -> bool {
        self.sides_within(place, normal, slack).iter().all(|&inside| inside)
    }

    /// Whether the normal at a place meets it.
    pub(super) fn has(&self, place: Vector, normal: Vector) -> bool {
        self.sides(place, normal).iter().all(|&inside| inside)
    }

    /// Whether a place, given its column and row, too, is beyond a chord of it that is a border of the tile.
    pub(super) fn is_passed(&self, place: Vector, normal: Vector, (column, row): (f64, f64)) -> bool {
        let sides = self.sides(place, normal);
        (0..3).any(|edge| {
            let (i, j) = EDGES[edge];
            let (at, [a, b]) = match self.border[edge] {
                None => return false,
                Some(Axis::Columns) => (column, [i, j].map(|i| self.flat[i].0)),
                Some(Axis::Rows) => (row, [i, j].map(|i| self.flat[i].1)),
            };
            !sides[edge] && (a.min(b) - ALONG..=a.max(b) + ALONG).contains(&at)
        })
    }

    /// How far a height is from its plane along the normal, with so much for rounding on level ground; infinite where it does not face up.
    pub(super) fn error(&self, place: Vector, normal: Vector, height: f64, doubt: f64) -> f64 {
        let facing = dot(self.normal, normal);
        if facing <= 0.0 {
            return f64::INFINITY;
        }
        let found = dot(self.normal, minus(self.corners[0], place)) / facing;
        (found - height).abs() + doubt * self.length / facing
    }
}

/// The edges of a facet on the grid.
pub(super) struct Sides<'a> {
    facet: &'a Facet,
    /// The rows that each is between, its column in the first, and how many columns it goes on from row to row.
    lines: [[f64; 4]; 3],
}

impl Sides<'_> {
    /// See [`Facet::columns`].
    pub(super) fn columns(&self, row: f64, at: &Row) -> Option<(f64, f64)> {
        if let Some(polar) = &self.facet.polar {
            let Polar { edges, columns, ends } = &**polar;
            return edges.iter().try_fold(*ends, |(low, high), edge| {
                let (from, to) = edge.columns(at, columns)?;
                Some((low.max(from), high.min(to)))
            });
        }
        self.columns_between(row, row)
    }

    /// See [`Facet::columns_between`].
    pub(super) fn columns_between(&self, first: f64, last: f64) -> Option<(f64, f64)> {
        let Facet { polar, reach, .. } = self.facet;
        if let Some(polar) = polar {
            return Some(polar.ends);
        }
        let (first, last) = (first - reach.1, last + reach.1);
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for &[top, bottom, column, slope] in &self.lines {
            let (from, to) = (top.max(first), bottom.min(last));
            if from <= to {
                let (a, b) = (column + (from - top) * slope, column + (to - top) * slope);
                (low, high) = (low.min(a.min(b)), high.max(a.max(b)));
            }
        }
        (low <= high).then_some((low - reach.0, high + reach.0))
    }
}

/// How far points of a triangle may be from where straight lines have them, in columns and rows of `cell` radians: see above.
pub(super) fn reach(body: &Body, points: [Vector; 3], cell: f64) -> (f64, f64) {
    let side = EDGES.map(|(i, j)| length(minus(points[i], points[j])));
    let side = side[0].max(side[1]).max(side[2]);
    let least = |values: [f64; 3]| values[0].min(values[1]).min(values[2]);
    let e2 = body.eccentricity2();
    let rho = least(points.map(length)) - body.semi_major * e2 - side;
    let from_axis = least(points.map(|p| (p[0] * p[0] + p[1] * p[1]).sqrt()));
    // No point of a triangle is farther than this from the nearest corner.
    let p = from_axis - 0.58 * side;
    if rho <= 0.0 {
        return (f64::INFINITY, f64::INFINITY);
    }
    if p < 0.5 * from_axis {
        return (f64::INFINITY, side / (rho * cell) + 1e-3);
    }
    let columns = side * side / (6.0 * p * p) + 2.0 * SLACK / p;
    let rows = side * side / 6.0 * ((1.0 + 3.0 * e2) / (rho * rho) + 1.0 / (rho * p)) + 2.0 * SLACK / rho;
    // Coordinates are rounded.
    (columns / cell + 1e-6, rows / cell + 1e-6)
}
