//! One tile by itself: whether its triangles tile the square, its lists are complete, its header is right, and how far it is
//! from the samples of the grid.

use std::collections::HashSet;

use super::decode::{Decoded, LAST};
use super::ellipsoid::{Ellipsoid, Meridian, Parallel, Point, less, times};
use super::facets::Facets;
use super::findings::{Findings, Kind};
use crate::pyramid::{Grid, Patch, PyramidError, SampleBlock, Samples, TileKey, VoidAs};

/// A tile that is judged.
pub(super) struct Tile<'a> {
    pub(super) key: TileKey,
    pub(super) grid: Grid,
    pub(super) ellipsoid: &'a Ellipsoid,
    pub(super) decoded: &'a Decoded,
    /// Its vertices in space.
    pub(super) points: Vec<Point>,
    /// Whether triangles over voids are left out.
    pub(super) has_holes: bool,
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

impl<'a> Tile<'a> {
    pub(super) fn new(
        key: TileKey,
        grid: Grid,
        ellipsoid: &'a Ellipsoid,
        decoded: &'a Decoded,
        void_as: VoidAs,
    ) -> Tile<'a> {
        let has_holes = void_as == VoidAs::Hole;
        let mut tile = Tile { key, grid, ellipsoid, decoded, points: Vec::new(), has_holes };
        tile.points = (0..decoded.vertices.len()).map(|i| tile.point(i)).collect();
        tile
    }

    /// Degrees along a side.
    pub(super) fn side(&self) -> f64 {
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
    pub(super) fn is_on_pole(&self, vertex: u32) -> bool {
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
            // Elsewhere holes are cut, which are judged by themselves.
            if !(self.is_on_pole(from) || self.is_on_pole(to) || self.has_holes) {
                findings.add(Kind::Shape, || format!("tile {key}: an edge inside has a triangle on one side only"));
            }
        }
        let whole = 2 * i64::from(LAST) * i64::from(LAST);
        if area > whole || area != whole && at_pole == 0 && !self.has_holes {
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

    /// Judges whether the heights of its header are so far apart that CesiumJS keeps floats.
    pub(super) fn judge_range(&self, findings: &mut Findings) {
        let (key, range) = (self.key, self.decoded.maximum - self.decoded.minimum);
        if range < 4095.875 {
            findings.add(Kind::Header, || {
                format!("tile {key}: its least and greatest height are {range} m apart, expected 4095.875 or more")
            });
        }
    }

    /// How far its corners are from the heights that are promised where the raster has none; those of holes are nobody's.
    pub(super) fn beside(
        &self,
        samples: &Samples,
        void_as: VoidAs,
        block: &mut SampleBlock,
    ) -> Result<f64, PyramidError> {
        let cells = self.grid.cells(self.key.level);
        let origin = self.key.origin(self.grid);
        let mut farthest = 0.0f64;
        for (vertex, &[u, v, _]) in self.decoded.vertices.iter().enumerate() {
            if ![0, LAST].contains(&u) || ![0, LAST].contains(&v) {
                continue;
            }
            let at = |coordinate: u16| if coordinate == 0 { 0 } else { cells };
            let patch = Patch { column: origin.0 + at(u), row: origin.1 + at(LAST - v), width: 1, height: 1, step: 1 };
            samples.read(patch, block)?;
            let expected = match (block.inside[0], block.is_void[0], void_as) {
                (true, ..) | (_, true, VoidAs::Hole) => continue,
                (_, true, VoidAs::Height(height)) => height,
                _ => block.heights[0],
            };
            farthest = farthest.max((self.decoded.height(vertex) - expected).abs());
        }
        Ok(farthest)
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
        let facets = Facets::of(self, |_| true);
        for ((left, top), (width, height)) in samples.windows(origin, cells, WINDOW) {
            let patch = Patch { column: origin.0 + left, row: origin.1 + top, width, height, step: 1 };
            if !samples.has_any(patch) && !self.has_holes {
                continue;
            }
            samples.read(patch, block)?;
            let (width, height) = (width as i64, height as i64);
            let window = facets.over((left, top), (width, height));
            let lon = |c: i64| self.grid.longitude(origin.0 + c);
            let lat = |r: i64| self.grid.latitude(origin.1 + r);
            let meridians: Vec<Meridian> = (left..left + width).map(|c| Meridian::of(lon(c))).collect();
            let parallels: Vec<Parallel> = (top..top + height).map(|r| self.ellipsoid.parallel(lat(r))).collect();
            // Beside holes, ground outside of the raster is looked for, too.
            let is_judged = |i: usize| block.inside[i] || self.has_holes && !block.is_void[i];
            for i in (0..block.inside.len()).filter(|&i| is_judged(i)) {
                let (c, r) = (left + i as i64 % width, top + i as i64 / width);
                let place = parallels[(r - top) as usize].foot(meridians[(c - left) as usize]);
                let error = window.error((c as f64, r as f64), place, block.heights[i]);
                if !block.inside[i] {
                    if error == f64::INFINITY {
                        let (key, lon, lat) = (self.key, lon(c), lat(r));
                        findings.add(Kind::Shape, || {
                            format!("tile {key}: at {lon}°, {lat}° is a hole where the raster has no void")
                        });
                    }
                    continue;
                }
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
}
