//! How far the surface of a tile, as decoded, is from the samples of the finest grid, along the normal of the ellipsoid.
//!
//! **Which triangle a sample is judged by.** The normal at a sample's place meets a triangle of the surface where it passes
//! its three edges on the inner side: the sign of ((A − S) × (B − S)) · N for each edge AB, S the place on the ellipsoid and
//! N the normal. Two triangles that share an edge compute it with opposite signs, bit for bit, so that no sample falls between
//! them; one that is within 10⁻⁷ m of an edge is judged by both. Edges are chords, and those along a tile's border lie beside the parallel that it is: a sample between chord and
//! border is judged by the plane of the triangle at that chord.
//!
//! **How exactly.** Points in space are near 6.4·10⁶ m, where doubles are 10⁻⁹ m apart; they are taken relative to the tile's
//! centre, after sums of three products and a square root each. So every coordinate of A − S is off by less than 4·10⁻⁹ m,
//! and the height n·(A − S) ÷ n·N by less than 10⁻⁸ m × |n| ÷ n·N, which is [`DOUBT`] × the secant of the triangle's slope.
//! That is added to each error before it is compared with the tolerance: what passes keeps it.

use super::Body;
use super::body::{Angle, Vector, cross, dot, length, minus};
use super::error::PyramidError;
use super::lines::Vertex;
use super::quantize::{SPAN, snap};
use super::samples::{Block, Patch, Samples};
use super::surface::Surface;
use crate::base::control::CancelToken;

/// What rounding adds to an error, in metres on level ground.
const DOUBT: f64 = 1e-8;

/// How far outside of an edge a sample may be and count as on it, in metres: on a meridian that is a border all of them are.
const SLACK: f64 = 1e-7;

/// Samples that are read at a time, across and down.
const WINDOW: i64 = 256;

/// What a tile's errors are like.
#[derive(Debug, Clone, Default)]
pub(super) struct Measured {
    /// Samples of the raster.
    pub(super) samples: u64,
    /// The largest error.
    pub(super) max_error: f64,
    /// The farthest sample of every triangle that has one beyond the tolerance, as near to it as vertices can stand, and the
    /// part that the triangle is of.
    pub(super) failing: Vec<(u32, Vertex)>,
}

/// A triangle that samples are looked for under.
struct Facet {
    corners: [Vector; 3],
    /// Column and row of the corners, in cells.
    flat: [(f64, f64); 3],
    normal: Vector,
    length: f64,
    /// How long its edges are.
    sides: [f64; 3],
    /// How far the edges may be from straight lines on the grid, in columns and rows.
    bulge: (f64, f64),
}

impl Facet {
    fn new(
        surface: &Surface,
        triangle: [u32; 3],
        body: &Body,
        cells: i64,
        angle: &dyn Fn(f64, f64) -> (f64, f64),
    ) -> Facet {
        let vertices = triangle.map(|i| surface.vertices[i as usize]);
        let corners = vertices.map(|v| v.at);
        let scale = cells as f64 / SPAN as f64;
        let flat = vertices.map(|v| (v.u as f64 * scale, (SPAN - v.v) as f64 * scale));
        let normal = cross(minus(corners[1], corners[0]), minus(corners[2], corners[0]));
        let mut bulge = (0.0f64, 0.0f64);
        for (i, j) in [(0, 1), (1, 2), (2, 0)] {
            let middle: Vector = std::array::from_fn(|k| 0.5 * (corners[i][k] + corners[j][k]) + surface.centre[k]);
            let straight = (0.5 * (flat[i].0 + flat[j].0), 0.5 * (flat[i].1 + flat[j].1));
            let (lon, lat) = angle(straight.0, straight.1);
            let (east, north) = body.offset(middle, lon, lat);
            let (columns, rows) = angle(1.0, 1.0);
            let origin = angle(0.0, 0.0);
            bulge.0 = bulge.0.max((east / (columns - origin.0)).abs());
            bulge.1 = bulge.1.max((north / (rows - origin.1)).abs());
        }
        // It is largest near the middle of an edge; twice that and a cell are more than enough, and a sample that is missed
        // all the same is found not to be covered.
        let sides = [(0, 1), (1, 2), (2, 0)].map(|(i, j)| length(minus(corners[i], corners[j])));
        Facet {
            corners,
            flat,
            normal,
            length: length(normal),
            sides,
            bulge: (2.0 * bulge.0 + 1.0, 2.0 * bulge.1 + 1.0),
        }
    }

    /// The rows from which samples may be in it.
    fn rows(&self) -> (f64, f64) {
        let rows = self.flat.map(|p| p.1);
        let (low, high) = (rows[0].min(rows[1]).min(rows[2]), rows[0].max(rows[1]).max(rows[2]));
        (low - self.bulge.1, high + self.bulge.1)
    }

    /// The columns of a row between which samples may be in it.
    fn columns(&self, row: f64) -> Option<(f64, f64)> {
        let (top, bottom) = (row - self.bulge.1, row + self.bulge.1);
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for (i, j) in [(0, 1), (1, 2), (2, 0)] {
            let (a, b) = if self.flat[i].1 <= self.flat[j].1 { (i, j) } else { (j, i) };
            let (a, b) = (self.flat[a], self.flat[b]);
            if b.1 < top || a.1 > bottom {
                continue;
            }
            for at in [a.1.max(top), b.1.min(bottom)] {
                let share = if b.1 > a.1 { (at - a.1) / (b.1 - a.1) } else { 0.0 };
                let column = a.0 + share * (b.0 - a.0);
                (low, high) = (low.min(column), high.max(column));
            }
            if a.1 == b.1 {
                (low, high) = (low.min(b.0), high.max(b.0));
            }
        }
        (low <= high).then_some((low - self.bulge.0, high + self.bulge.0))
    }

    /// Whether the normal at a place meets it.
    fn has(&self, place: Vector, normal: Vector) -> bool {
        let [a, b, c] = self.corners.map(|corner| minus(corner, place));
        let edges = [(a, b), (b, c), (c, a)];
        edges.iter().zip(self.sides).all(|(&(p, q), side)| dot(cross(p, q), normal) >= -SLACK * side)
    }

    /// How far a height is from its plane along the normal, rounding included; infinite where it does not face up.
    fn error(&self, place: Vector, normal: Vector, height: f64) -> f64 {
        let facing = dot(self.normal, normal);
        if facing <= 0.0 {
            return f64::INFINITY;
        }
        let found = dot(self.normal, minus(self.corners[0], place)) / facing;
        (found - height).abs() + DOUBT * self.length / facing
    }
}

impl Body {
    /// How far a point's longitude and latitude are from these, in degrees.
    fn offset(&self, point: Vector, lon: f64, lat: f64) -> (f64, f64) {
        let around = Angle::of(lat);
        let e2 = self.eccentricity2();
        let across = self.semi_major / (1.0 - e2 * around.sin * around.sin).sqrt();
        let reach = libm::hypot(point[0], point[1]);
        // What lies above the ellipsoid counts little here.
        let found = libm::atan2(point[2] + e2 * across * around.sin, reach).to_degrees();
        let east = (libm::atan2(point[1], point[0]).to_degrees() - lon + 540.0).rem_euclid(360.0) - 180.0;
        (east, found - lat)
    }
}

/// Measures a tile at all samples of the raster.
pub(super) struct Meter<'a> {
    pub(super) body: &'a Body,
    pub(super) samples: &'a Samples,
    pub(super) cancel: &'a CancelToken,
}

impl Meter<'_> {
    /// Measures a tile.
    pub(super) fn measure(
        &self,
        surface: &Surface,
        tolerance: f64,
        block: &mut Block,
    ) -> Result<Measured, PyramidError> {
        let grid = self.samples.grid;
        let cells = grid.cells(surface.tile.level);
        let origin = surface.tile.origin(grid);
        let angle = |column: f64, row: f64| {
            let (west, north) = (grid.longitude(origin.0), grid.latitude(origin.1));
            (west + column * grid.cell(), north - row * grid.cell())
        };
        let facets = surface.triangles.iter().map(|&t| Facet::new(surface, t, self.body, cells, &angle));
        let facets: Vec<Facet> = facets.collect();
        let mut worst = vec![(0.0, Vertex { column: 0, row: 0, height: 0.0 }); facets.len()];
        let mut measured = Measured::default();
        for ((left, top), (width, height)) in self.samples.windows(origin, cells, WINDOW) {
            self.cancel.check()?;
            let patch = Patch { column: origin.0 + left, row: origin.1 + top, width, height, step: 1 };
            self.samples.read(patch, block)?;
            let window = Window { left, top, patch, surface, facets: &facets };
            window.measure(self.body, grid, cells, block, &mut worst, &mut measured);
        }
        for (triangle, &(error, vertex)) in worst.iter().enumerate() {
            measured.max_error = measured.max_error.max(error);
            if error > tolerance {
                measured.failing.push((surface.owners[triangle], vertex));
            }
        }
        Ok(measured)
    }
}

/// A window of a tile that is being measured.
struct Window<'a> {
    left: i64,
    top: i64,
    patch: Patch,
    surface: &'a Surface,
    facets: &'a [Facet],
}

impl Window<'_> {
    fn measure(
        &self,
        body: &Body,
        grid: super::Grid,
        cells: i64,
        block: &Block,
        worst: &mut [(f64, Vertex)],
        measured: &mut Measured,
    ) {
        let Patch { column, row, width, height, .. } = self.patch;
        let lons: Vec<Angle> = (0..width).map(|c| Angle::of(grid.longitude(column + c as i64))).collect();
        let lats: Vec<Angle> = (0..height).map(|r| Angle::of(grid.latitude(row + r as i64))).collect();
        let place = |c: usize, r: usize| {
            let place = minus(body.point(lons[c], lats[r], 0.0), self.surface.centre);
            (place, Body::normal(lons[c], lats[r]))
        };
        let mut is_seen = vec![false; width * height];
        let snap = snap(cells) as usize;
        let mut note = |facet: usize, c: usize, r: usize, error: f64| {
            if error > worst[facet].0 {
                // Windows begin at multiples of the snap. Where a vertex can stand beyond the raster only, it takes the
                // height of the sample that it is for.
                let (to_c, to_r) = (c / snap * snap, r / snap * snap);
                let snapped = to_r * width + to_c;
                let height = block.heights[if block.inside[snapped] { snapped } else { r * width + c }];
                worst[facet] = (error, Vertex { column: self.left + to_c as i64, row: self.top + to_r as i64, height });
            }
        };
        for (number, facet) in self.facets.iter().enumerate() {
            let (first, last) = facet.rows();
            let rows = clipped(first - self.top as f64, last - self.top as f64, height);
            for r in rows {
                let Some((low, high)) = facet.columns((self.top + r as i64) as f64) else { continue };
                for c in clipped(low - self.left as f64, high - self.left as f64, width) {
                    if !block.inside[r * width + c] {
                        continue;
                    }
                    let (at, normal) = place(c, r);
                    if facet.has(at, normal) {
                        is_seen[r * width + c] = true;
                        note(number, c, r, facet.error(at, normal, block.heights[r * width + c]));
                    }
                }
            }
        }
        for i in (0..is_seen.len()).filter(|&i| block.inside[i]) {
            measured.samples += 1;
            if is_seen[i] {
                continue;
            }
            let (c, r) = (i % width, i / width);
            let at_border = self.at_border((self.left + c as i64) as f64, (self.top + r as i64) as f64, cells as f64);
            let (facet, error) = match at_border {
                Some(facet) => {
                    let (at, normal) = place(c, r);
                    (facet, self.facets[facet].error(at, normal, block.heights[i]))
                }
                // Nothing covers it.
                None => (0, f64::INFINITY),
            };
            note(facet, c, r, error);
        }
    }

    /// The triangle at the border of the tile that is nearest to a sample beyond its chord.
    fn at_border(&self, column: f64, row: f64, cells: f64) -> Option<usize> {
        let distances = [column, cells - column, row, cells - row];
        let nearest = (0..4).min_by(|&a, &b| distances[a].total_cmp(&distances[b]))?;
        let is_on = |p: (f64, f64)| match nearest {
            0 => p.0 == 0.0,
            1 => p.0 >= cells,
            2 => p.1 == 0.0,
            _ => p.1 >= cells,
        };
        let (at, along) = if nearest < 2 { (row, 1) } else { (column, 0) };
        let coordinate = |p: (f64, f64)| if along == 1 { p.1 } else { p.0 };
        self.facets.iter().position(|facet| {
            [(0, 1), (1, 2), (2, 0)].into_iter().any(|(i, j)| {
                let (a, b) = (facet.flat[i], facet.flat[j]);
                let (low, high) = (coordinate(a).min(coordinate(b)), coordinate(a).max(coordinate(b)));
                is_on(a) && is_on(b) && (low - 0.5..=high + 0.5).contains(&at)
            })
        })
    }
}

/// The whole numbers between two, from 0 to below `count`.
fn clipped(low: f64, high: f64, count: usize) -> std::ops::Range<usize> {
    let first = low.ceil().clamp(0.0, count as f64) as usize;
    let end = (high.floor() + 1.0).clamp(0.0, count as f64) as usize;
    first..end.max(first)
}
