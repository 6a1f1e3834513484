//! One tile by itself: whether its triangles tile the square, its lists are complete, its header is right, and how far it is
//! from the samples.

use std::collections::HashSet;

use super::decode::{Decoded, LAST};
use super::ellipsoid::{Ellipsoid, Meridian, Parallel, Point, across, less, times};
use super::findings::{Findings, Kind};
use crate::pyramid::{Grid, Patch, PyramidError, SampleBlock, Samples, TileKey};

/// A tile that is judged.
pub(super) struct Tile<'a> {
    pub(super) key: TileKey,
    pub(super) grid: Grid,
    pub(super) ellipsoid: &'a Ellipsoid,
    pub(super) decoded: &'a Decoded,
    points: Vec<Point>,
}

/// How far a tile is from its samples.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Distance {
    /// Samples that it owns: those on its northern and western border, and inside.
    pub(super) owned: u64,
    /// Samples, its whole border included.
    pub(super) samples: u64,
    pub(super) largest: f64,
}

/// What an error may be off by, in metres, on level ground; steeper triangles have it more often.
const ROUNDING: f64 = 2e-8;

impl<'a> Tile<'a> {
    pub(super) fn new(key: TileKey, grid: Grid, ellipsoid: &'a Ellipsoid, decoded: &'a Decoded) -> Tile<'a> {
        let mut tile = Tile { key, grid, ellipsoid, decoded, points: Vec::new() };
        tile.points = (0..decoded.vertices.len()).map(|i| tile.point(i)).collect();
        tile
    }

    /// Degrees along a side.
    fn side(&self) -> f64 {
        180.0 / 2f64.powi(self.key.level as i32)
    }

    /// Longitude and latitude of a vertex.
    pub(super) fn place(&self, u: f64, v: f64) -> (f64, f64) {
        let side = self.side();
        let (west, south) = (f64::from(self.key.x) * side - 180.0, f64::from(self.key.y) * side - 90.0);
        (west + side * (u / f64::from(LAST)), south + side * (v / f64::from(LAST)))
    }

    pub(super) fn point(&self, vertex: usize) -> Point {
        let [u, v, _] = self.decoded.vertices[vertex];
        let (lon, lat) = self.place(f64::from(u), f64::from(v));
        self.ellipsoid.point(lon, lat, self.decoded.height(vertex))
    }

    /// Whether a vertex is on a pole.
    fn is_on_pole(&self, vertex: u32) -> bool {
        let v = self.decoded.vertices[vertex as usize][1];
        let last = (1u32 << self.key.level) - 1;
        (v == 0 && self.key.y == 0) || (v == LAST && self.key.y == last)
    }

    /// Judges its triangles, lists and header.
    pub(super) fn judge_shape(&self, findings: &mut Findings) {
        let key = self.key;
        let vertices = &self.decoded.vertices;
        let mut edges = HashSet::new();
        let mut area = 0i64;
        for t in &self.decoded.triangles {
            let [a, b, c] = t.map(|i| vertices[i as usize].map(i64::from));
            let doubled = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
            if doubled <= 0 {
                findings.add(Kind::Shape, || format!("tile {key}: triangle {t:?} is turned over or has no area"));
            }
            area += doubled;
            for (from, to) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                if !edges.insert((from, to)) {
                    findings.add(Kind::Shape, || format!("tile {key}: two triangles on one side of an edge"));
                }
            }
        }
        let is_on = |i: u32, side: usize| {
            let [u, v, _] = vertices[i as usize];
            [u == 0, v == 0, u == LAST, v == LAST][side]
        };
        let mut at_pole = 0;
        for &(from, to) in edges.iter().filter(|(from, to)| !edges.contains(&(*to, *from))) {
            if (0..4).any(|side| is_on(from, side) && is_on(to, side)) {
                continue;
            }
            // Triangles with a side on a pole have no area in space, and are left out.
            at_pole += u32::from(self.is_on_pole(from) || self.is_on_pole(to));
            if !(self.is_on_pole(from) || self.is_on_pole(to)) {
                findings.add(Kind::Shape, || format!("tile {key}: an edge inside has a triangle on one side only"));
            }
        }
        let whole = 2 * i64::from(LAST) * i64::from(LAST);
        if area != whole && at_pole == 0 {
            findings.add(Kind::Shape, || format!("tile {key}: triangles cover {area} of {whole}, doubled"));
        }
        let places: HashSet<[u16; 2]> = vertices.iter().map(|v| [v[0], v[1]]).collect();
        if places.len() != vertices.len() {
            findings.add(Kind::Shape, || format!("tile {key}: two vertices at one place"));
        }
        let mut border = 0;
        for (side, name) in ["west", "south", "east", "north"].iter().enumerate() {
            let listed: HashSet<u32> = self.decoded.sides[side].iter().copied().collect();
            let expected: HashSet<u32> = (0..vertices.len() as u32).filter(|&i| is_on(i, side)).collect();
            border += expected.len();
            if listed != expected || listed.len() != self.decoded.sides[side].len() {
                findings
                    .add(Kind::Sides, || format!("tile {key}: the list of its {name} side is not its vertices there"));
            }
        }
        if ![[0, 0], [0, LAST], [LAST, 0], [LAST, LAST]].iter().all(|corner| places.contains(corner)) {
            findings.add(Kind::Sides, || format!("tile {key}: a corner is missing"));
        }
        if vertices.len() + 2 * border > 65_536 {
            findings.add(Kind::Sides, || format!("tile {key}: more vertices than readers number with skirts"));
        }
        if self.decoded.normals.is_none() {
            findings.add(Kind::Format, || format!("tile {key}: normals are missing"));
        }
        self.judge_header(findings);
    }

    fn judge_header(&self, findings: &mut Findings) {
        let key = self.key;
        let (centre, radius) = self.decoded.sphere;
        let farthest = self.points.iter().map(|p| times(less(*p, centre), less(*p, centre)).sqrt()).fold(0.0, f64::max);
        if farthest > radius || radius > 2.0 * farthest + 1.0 {
            findings.add(Kind::Header, || {
                format!("tile {key}: the farthest vertex is {farthest} m from the centre of a sphere of {radius}")
            });
        }
        let off = less(self.decoded.centre, centre);
        if times(off, off).sqrt() > radius {
            findings.add(Kind::Header, || format!("tile {key}: its centre is not in its sphere"));
        }
        if !self.points.iter().all(|&point| self.ellipsoid.hides_later(self.decoded.occlusion_point, point)) {
            findings.add(Kind::Header, || format!("tile {key}: a vertex can be seen where its occlusion point cannot"));
        }
        if self.decoded.maximum <= self.decoded.minimum {
            findings.add(Kind::Header, || format!("tile {key}: its least height is not below its greatest"));
        }
    }

    /// Finds how far it is from the samples of the grid, along the normals.
    pub(super) fn distance(
        &self,
        samples: &Samples,
        block: &mut SampleBlock,
        allowed: f64,
        findings: &mut Findings,
    ) -> Result<Distance, PyramidError> {
        let cells = self.grid.cells(self.key.level);
        let origin = self.key.origin(self.grid);
        let mut distance = Distance::default();
        const WINDOW: i64 = 128;
        let facets: Vec<Facet> = self.decoded.triangles.iter().map(|&t| self.facet(t, cells)).collect();
        for ((left, top), (width, height)) in samples.windows(origin, cells, WINDOW) {
            let patch = Patch { column: origin.0 + left, row: origin.1 + top, width, height, step: 1 };
            if !samples.has_any(patch) {
                continue;
            }
            samples.read(patch, block)?;
            let (width, height) = (width as i64, height as i64);
            let buckets = Buckets::new(&facets, (left, top), (width, height));
            let lon = |c: i64| self.grid.longitude(origin.0 + c);
            let lat = |r: i64| self.grid.latitude(origin.1 + r);
            let meridians: Vec<Meridian> = (left..left + width).map(|c| Meridian::of(lon(c))).collect();
            let parallels: Vec<Parallel> = (top..top + height).map(|r| self.ellipsoid.parallel(lat(r))).collect();
            for i in (0..block.inside.len()).filter(|&i| block.inside[i]) {
                let (c, r) = (left + i as i64 % width, top + i as i64 / width);
                let place = parallels[(r - top) as usize].foot(meridians[(c - left) as usize]);
                let error = self.error(&facets, buckets.at(c, r), (c, r), place, block.heights[i], cells);
                distance.samples += 1;
                distance.owned += u64::from(c < cells && r < cells);
                distance.largest = distance.largest.max(error);
                if error.is_nan() || error > allowed {
                    let key = self.key;
                    let (lon, lat) = (lon(c), lat(r));
                    findings.add(Kind::Promise, || {
                                format!("tile {key}: at {lon}°, {lat}° the surface is {error} m from the sample, allowed are {allowed}")
                            });
                }
            }
        }
        Ok(distance)
    }

    /// The largest error among the triangles that the normal meets.
    fn error(
        &self,
        facets: &[Facet],
        near: &[u32],
        (column, row): (i64, i64),
        (foot, normal): (Point, Point),
        height: f64,
        cells: i64,
    ) -> f64 {
        let met = near.iter().filter_map(|&facet| facets[facet as usize].meet(foot, normal, true));
        let error = |(found, doubt): (f64, f64)| (found - height).abs() + doubt;
        if let Some(largest) = met.map(error).reduce(f64::max) {
            return largest;
        }
        // Beyond the chord of a border: the triangle at that border goes on.
        let at = [column, cells - row, cells - column, row];
        let side = (0..4).min_by_key(|&side| at[side]).unwrap_or(0);
        let along = if side % 2 == 0 { row as f64 } else { column as f64 };
        let at_border = facets.iter().find(|facet| facet.reaches(side, along, cells as f64));
        at_border.and_then(|facet| facet.meet(foot, normal, false)).map_or(f64::INFINITY, error)
    }

    fn facet(&self, triangle: [u32; 3], cells: i64) -> Facet {
        let points = triangle.map(|i| self.points[i as usize]);
        let scale = cells as f64 / f64::from(LAST);
        let places = triangle.map(|i| {
            let [u, v, _] = self.decoded.vertices[i as usize];
            [f64::from(u) * scale, f64::from(LAST - v) * scale]
        });
        let mut reach = [1.0f64, 1.0];
        for (i, j) in [(0, 1), (1, 2), (2, 0)] {
            let middle: Point = std::array::from_fn(|k| 0.5 * (points[i][k] + points[j][k]));
            let (lon, lat, _) = self.ellipsoid.geodetic(middle);
            let straight = [0.5 * (places[i][0] + places[j][0]), 0.5 * (places[i][1] + places[j][1])];
            let (west, north) = self.place(0.0, f64::from(LAST));
            let cell = self.grid.cell();
            let columns = ((lon - west + 180.0).rem_euclid(360.0) - 180.0) / cell - straight[0];
            let rows = (north - lat) / cell - straight[1];
            reach = [reach[0].max(2.0 * columns.abs() + 1.0), reach[1].max(2.0 * rows.abs() + 1.0)];
        }
        let bounds = [0, 1].map(|k| {
            let (low, high) =
                places.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p[k]), h.max(p[k])));
            (low - reach[k], high + reach[k])
        });
        let (one, other) = (less(points[1], points[0]), less(points[2], points[0]));
        let plane = across(one, other);
        let longest = [one, other, less(other, one)].iter().map(|e| times(*e, *e).sqrt()).fold(0.0, f64::max);
        // A shift of this many metres at an edge is rounding.
        let size = times(plane, plane).sqrt();
        let slack = (1e-7 * longest / size).min(0.01);
        Facet { first: points[0], one, other, plane, size, slack, bounds, places }
    }
}

/// A triangle, ready to be met by normals.
struct Facet {
    first: Point,
    one: Point,
    other: Point,
    plane: Point,
    /// How long `plane` is.
    size: f64,
    /// How far shares may be below 0.
    slack: f64,
    /// Columns and rows between which it is met.
    bounds: [(f64, f64); 2],
    places: [[f64; 2]; 3],
}

impl Facet {
    /// The height at which a normal meets it, and what rounding may add: foot + height · normal = first + p · one + q · other, by
    /// Cramer's rule. Without `inside` its whole plane counts.
    fn meet(&self, foot: Point, normal: Point, inside: bool) -> Option<(f64, f64)> {
        let facing = times(self.plane, normal);
        if facing <= 0.0 {
            return None;
        }
        let from = less(foot, self.first);
        if inside {
            let turned = across(normal, from);
            let p = times(turned, self.other) / facing;
            let q = -times(turned, self.one) / facing;
            if p < -self.slack || q < -self.slack || p + q > 1.0 + self.slack {
                return None;
            }
        }
        Some((-times(self.plane, from) / facing, ROUNDING * self.size / facing))
    }

    /// Whether it has an edge on a side (west, south, east, north) over this place along it.
    fn reaches(&self, side: usize, along: f64, cells: f64) -> bool {
        let (axis, at) = [(0, 0.0), (1, cells), (0, cells), (1, 0.0)][side];
        let on: Vec<f64> = self.places.iter().filter(|p| (p[axis] - at).abs() < 1e-6).map(|p| p[1 - axis]).collect();
        on.len() == 2 && (on[0].min(on[1]) - 0.5..=on[0].max(on[1]) + 0.5).contains(&along)
    }
}

/// Which triangles may be met where in a window: squares of it, each with a list.
struct Buckets {
    first: (i64, i64),
    size: i64,
    across: i64,
    lists: Vec<Vec<u32>>,
}

impl Buckets {
    fn new(facets: &[Facet], first: (i64, i64), (width, height): (i64, i64)) -> Buckets {
        let size = 8;
        let (across, down) = ((width + size - 1) / size, (height + size - 1) / size);
        let mut lists = vec![Vec::new(); (across * down) as usize];
        let range = |(low, high): (f64, f64), first: i64, count: i64| {
            let bucket = |at: f64| ((at - first as f64) / size as f64).floor().clamp(-1.0, count as f64) as i64;
            bucket(low).max(0)..(bucket(high) + 1).min(count)
        };
        for (number, facet) in facets.iter().enumerate() {
            for row in range(facet.bounds[1], first.1, down) {
                for column in range(facet.bounds[0], first.0, across) {
                    lists[(row * across + column) as usize].push(number as u32);
                }
            }
        }
        Buckets { first, size, across, lists }
    }

    fn at(&self, column: i64, row: i64) -> &[u32] {
        let (c, r) = ((column - self.first.0) / self.size, (row - self.first.1) / self.size);
        &self.lists[(r * self.across + c) as usize]
    }
}
