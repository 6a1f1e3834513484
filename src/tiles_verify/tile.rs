//! One tile by itself: whether its triangles tile the square, its lists are complete, its header is right, and how far it is
//! from the samples of the grid.

use rustc_hash::FxHashSet;

use super::decode::{Decoded, LAST};
use super::ellipsoid::{Ellipsoid, Meridian, Parallel, Point, less, times};
use super::facets::Facets;
use super::findings::{Findings, Kind};
use super::scan::{Lattice, Limits};
use crate::pyramid::{Grid, Patch, PyramidError, SampleBlock, Samples, TileKey, VoidAs};

/// Samples that are read at a time, across and down.
const WINDOW: i64 = 256;

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

    /// Judges its triangles, lists and header; says whether triangles tile the square.
    pub(super) fn judge_shape(&self, findings: &mut Findings) -> bool {
        let key = self.key;
        let vertices = &self.decoded.vertices;
        let mut edges = FxHashSet::default();
        edges.reserve(3 * self.decoded.triangles.len());
        let mut area = 0i64;
        let mut is_tiling = true;
        for t in &self.decoded.triangles {
            let [a, b, c] = t.map(|i| vertices[i as usize].map(i64::from));
            let doubled = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
            if doubled <= 0 {
                findings.add(Kind::Shape, || format!("tile {key}: triangle {t:?} is turned over or has no area"));
                is_tiling = false;
            }
            area += doubled;
            for (from, to) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                if !edges.insert((from, to)) {
                    findings.add(Kind::Shape, || format!("tile {key}: two triangles on one side of an edge"));
                    is_tiling = false;
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
            is_tiling = false;
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
        is_tiling &= area == whole;
        let places: FxHashSet<[u16; 2]> = vertices.iter().map(|v| [v[0], v[1]]).collect();
        if places.len() != vertices.len() {
            findings.add(Kind::Shape, || format!("tile {key}: two vertices at one place"));
            is_tiling = false;
        }
        let mut border = 0;
        for (side, name) in ["west", "south", "east", "north"].iter().enumerate() {
            let listed: FxHashSet<u32> = self.decoded.sides[side].iter().copied().collect();
            let expected: FxHashSet<u32> = (0..vertices.len() as u32).filter(|&i| is_on(i, side)).collect();
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
        is_tiling
    }

    fn judge_header(&self, findings: &mut Findings) {
        let key = self.key;
        // Nearer to the centre it is not sure which normals meet a triangle.
        let (least, deepest) = (self.decoded.minimum, -0.5 * self.ellipsoid.b);
        if least < deepest {
            findings.add(Kind::Header, || {
                format!(
                    "tile {key}: its least height is {least} m, expected none below {deepest} m, half way to the centre"
                )
            });
        }
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

    /// How far beyond the edge of a hole a place may be and count as on the triangle there, in metres: a step of the lattice. `None` without
    /// holes.
    pub(super) fn beside_hole(&self) -> Option<f64> {
        self.has_holes.then(|| self.side().to_radians() * self.ellipsoid.a / f64::from(LAST))
    }

    /// The same in columns and rows beside a triangle, generously.
    pub(super) fn beside_hole_in_cells(&self, corners: [Point; 3]) -> [f64; 2] {
        let Some(metres) = self.beside_hole() else { return [0.0; 2] };
        let cells = self.grid.cells(self.key.level) as f64;
        let cell = self.grid.cell().to_radians();
        let least = 1.0 + cells / f64::from(LAST);
        let from_axis = corners.iter().map(|p| p[0].hypot(p[1])).fold(f64::INFINITY, f64::min);
        [least.max(2.0 * metres / (from_axis * cell)).min(cells), least]
    }

    /// Finds how far it is from the samples of the grid, along the normals. One of its level is as far as `known`.
    pub(super) fn distance(
        &self,
        samples: &Samples,
        block: &mut SampleBlock,
        (limits, is_tiling): (Limits, bool),
        findings: &mut Findings,
    ) -> Result<Distance, PyramidError> {
        let cells = self.grid.cells(self.key.level);
        let origin = self.key.origin(self.grid);
        let mut distance = Distance { largest: limits.known, ..Distance::default() };
        let facets = Facets::of(self, is_tiling);
        let numbers = |first: i64, count: usize| (0..count as i64).map(move |i| (first + i) as f64).collect::<Vec<_>>();
        for ((left, top), (width, height)) in samples.windows(origin, cells, WINDOW) {
            let patch = Patch { column: origin.0 + left, row: origin.1 + top, width, height, step: 1 };
            if !samples.has_any(patch) && !self.has_holes {
                continue;
            }
            samples.read(patch, block)?;
            let lon = |i: usize| self.grid.longitude(origin.0 + left + i as i64);
            let lat = |i: usize| self.grid.latitude(origin.1 + top + i as i64);
            let meridians: Vec<Meridian> = (0..width).map(|i| Meridian::of(lon(i))).collect();
            let parallels: Vec<Parallel> = (0..height).map(|i| self.ellipsoid.parallel(lat(i))).collect();
            // Beside holes, ground outside of the raster is looked for, too.
            let is_ground = |(inside, is_void): (&bool, &bool)| *inside || !is_void;
            let ground: Option<Vec<bool>> =
                self.has_holes.then(|| block.inside.iter().zip(&block.is_void).map(is_ground).collect());
            let (columns, rows) = (numbers(left, width), numbers(top, height));
            let lattice = Lattice {
                columns: &columns,
                rows: &rows,
                meridians: &meridians,
                parallels: &parallels,
                heights: &block.heights,
                stride: width,
                covers: ground.as_ref().unwrap_or(&block.inside),
                binds: &block.inside,
            };
            let mut found = facets.scan(&lattice, Limits { known: distance.largest, ..limits });
            let mut around = None;
            for i in std::mem::take(&mut found.unmet) {
                let (at, height) = ((columns[i % width], rows[i / width]), block.heights[i]);
                let place = parallels[i / width].foot(meridians[i % width]);
                let near = around.get_or_insert_with(|| facets.around(&lattice));
                let error = near.error(at, place, height);
                if block.inside[i] {
                    found.add(i, error, limits.allowed);
                } else if error == f64::INFINITY {
                    let (key, lon, lat) = (self.key, lon(i % width), lat(i / width));
                    findings.add(Kind::Shape, || {
                        format!("tile {key}: at {lon}°, {lat}° is a hole where the raster has no void")
                    });
                }
            }
            for (row, inside) in block.inside.chunks_exact(width).enumerate() {
                let count = |inside: &[bool]| inside.iter().filter(|inside| **inside).count() as u64;
                let is_last = (left + width as i64 > cells, top + row as i64 >= cells);
                distance.samples += count(inside);
                distance.owned += match is_last {
                    (_, true) => 0,
                    (is_last, false) => count(&inside[..width - usize::from(is_last)]),
                };
            }
            distance.largest = distance.largest.max(found.largest);
            for (i, error) in found.beyond {
                let (key, lon, lat, allowed) = (self.key, lon(i % width), lat(i / width), limits.allowed);
                findings.add(Kind::Promise, || {
                    format!(
                        "tile {key}: at {lon}°, {lat}° the surface is {error} m from the sample, allowed are {allowed}"
                    )
                });
            }
        }
        Ok(distance)
    }
}
