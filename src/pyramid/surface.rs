//! The surface of a tile as readers decode it: its parts put together on the lattice of the format, and every vertex in space.

use rustc_hash::FxHashMap;

use super::Body;
use super::body::{Angle, Vector, minus};
use super::facet::Columns;
use super::grid::{Grid, TileKey};
use super::part::Part;
use super::quantize::{HeightLattice, SPAN, Steps};

/// A vertex as it is written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SurfaceVertex {
    /// From the west.
    pub(super) u: i64,
    /// From the south.
    pub(super) v: i64,
    /// In steps above the least height.
    pub(super) quantum: i64,
    /// The sample that it stands for, in cells from the tile's north-west corner.
    pub(super) sample: (i64, i64),
    /// Where it is decoded to, from [`Surface::centre`].
    pub(super) at: Vector,
}

impl SurfaceVertex {
    /// Whether it is on the border of its tile.
    pub(super) fn is_on_border(&self) -> bool {
        [0, SPAN].contains(&self.u) || [0, SPAN].contains(&self.v)
    }
}

/// A tile as it is written.
#[derive(Debug, Clone)]
pub(super) struct Surface {
    pub(super) tile: TileKey,
    pub(super) lattice: HeightLattice,
    /// A point near the tile, from the middle of the ellipsoid.
    pub(super) centre: Vector,
    pub(super) vertices: Vec<SurfaceVertex>,
    /// Counter-clockwise from outside.
    pub(super) triangles: Vec<[u32; 3]>,
    /// Which part each triangle is of.
    pub(super) owners: Vec<u32>,
    /// Those of no area, with a side on a pole.
    at_pole: Vec<[u32; 3]>,
}

/// A vertex on the lattice of a tile, as a number.
pub(super) type Corner = u64;

/// Where a coordinate lies in a tile, from its south-western corner on.
pub(super) fn degrees(grid: Grid, tile: TileKey, u: f64, v: f64) -> (f64, f64) {
    let (column, row) = tile.origin(grid);
    let cells = grid.cells(tile.level);
    let side = cells as f64 * grid.cell();
    (grid.longitude(column) + u / SPAN as f64 * side, grid.latitude(row + cells) + v / SPAN as f64 * side)
}

impl Surface {
    /// Puts parts together. Triangles of no area, with a side on a pole, are left out.
    pub(super) fn of(body: &Body, grid: Grid, tile: TileKey, steps: &Steps, parts: &[Part]) -> Surface {
        let cells = grid.cells(tile.level);
        let lattice = steps.lattice(tile);
        let place = |u: f64, v: f64, height: f64| {
            let (lon, lat) = degrees(grid, tile, u, v);
            body.point(Angle::of(lon), Angle::of(lat), height)
        };
        let middle = SPAN as f64 / 2.0;
        let centre = place(middle, middle, 0.0);
        let border = |coordinate: i64| if coordinate == 0 { -1 } else { i32::from(coordinate == SPAN) };
        let mut surface = Surface {
            tile,
            lattice,
            centre,
            vertices: Vec::new(),
            triangles: Vec::new(),
            owners: Vec::new(),
            at_pole: Vec::new(),
        };
        let mut numbers = FxHashMap::default();
        let first_row = tile.origin(grid).1;
        for (owner, part) in parts.iter().enumerate() {
            let mut own = Vec::with_capacity(part.vertices.len());
            for vertex in &part.vertices {
                let (u, v) = vertex.coordinates(cells);
                own.push(*numbers.entry((u, v)).or_insert_with(|| {
                    let (east, north) = (border(u), border(v));
                    let step = if (east, north) == (0, 0) { lattice.step } else { steps.on_border(tile, east, north) };
                    let quantum = lattice.quantize(vertex.height, step);
                    let at = minus(place(u as f64, v as f64, lattice.height(quantum)), centre);
                    let sample = (vertex.column, vertex.row);
                    surface.vertices.push(SurfaceVertex { u, v, quantum, sample, at });
                    surface.vertices.len() as u32 - 1
                }));
            }
            let triangles = part.triangles.iter().map(|t| t.map(|i| own[i as usize]));
            for triangle in triangles {
                let on_side = |v: i64| triangle.iter().filter(|&&i| surface.vertices[i as usize].v == v).count();
                let on_north = first_row == 0 && on_side(SPAN) >= 2;
                let on_south = first_row + cells == grid.rows() && on_side(0) >= 2;
                if !on_north && !on_south {
                    surface.triangles.push(triangle);
                    surface.owners.push(owner as u32);
                } else {
                    surface.at_pole.push(triangle);
                }
            }
        }
        surface
    }

    /// Leaves out triangles, and the vertices off the border that are in none of the others.
    pub(super) fn keep(&mut self, keeps: impl Fn(usize) -> bool) {
        self.at_pole.clear();
        let kept: Vec<usize> = (0..self.triangles.len()).filter(|&i| keeps(i)).collect();
        self.triangles = kept.iter().map(|&i| self.triangles[i]).collect();
        self.owners = kept.iter().map(|&i| self.owners[i]).collect();
        let mut is_kept: Vec<bool> = self.vertices.iter().map(SurfaceVertex::is_on_border).collect();
        self.triangles.as_flattened().iter().for_each(|&i| is_kept[i as usize] = true);
        let mut next = 0;
        let number = |&is_kept: &bool| {
            next += u32::from(is_kept);
            next.wrapping_sub(1)
        };
        let numbers: Vec<u32> = is_kept.iter().map(number).collect();
        self.triangles.as_flattened_mut().iter_mut().for_each(|i| *i = numbers[*i as usize]);
        let mut is_kept = is_kept.into_iter();
        self.vertices.retain(|_| is_kept.next() == Some(true));
    }

    /// Where its columns of samples are.
    pub(super) fn columns(&self, grid: Grid) -> Columns {
        let west = grid.longitude(self.tile.origin(grid).0).to_radians();
        Columns { west, cell: grid.cell().to_radians(), count: grid.cells(self.tile.level) }
    }

    /// The corners of a triangle, the same wherever it begins.
    pub(super) fn corners(&self, triangle: [u32; 3]) -> [Corner; 3] {
        let [a, b, c] = triangle.map(|i| {
            let SurfaceVertex { u, v, quantum, .. } = self.vertices[i as usize];
            ((u * (SPAN + 1) + v) * (SPAN + 1) + quantum) as Corner
        });
        if a < b && a < c {
            [a, b, c]
        } else if b < c {
            [b, c, a]
        } else {
            [c, a, b]
        }
    }

    /// Whether its triangles, those of no area among them, cover the square of the format once: every edge is one of two
    /// triangles, in both directions, or one and on the border, and their areas, those turned over less, are the square's.
    pub(super) fn is_closed(&self) -> bool {
        let triangles = self.triangles.iter().chain(&self.at_pole);
        let mut edges: Vec<(u32, u32)> = Vec::with_capacity(3 * self.triangles.len());
        let mut area = 0;
        for &[a, b, c] in triangles {
            edges.extend([(a, b), (b, c), (c, a)]);
            let [a, b, c] = [a, b, c].map(|i| &self.vertices[i as usize]);
            area += (b.u - a.u) * (c.v - a.v) - (b.v - a.v) * (c.u - a.u);
        }
        edges.sort_unstable();
        let is_once = edges.windows(2).all(|pair| pair[0] != pair[1]);
        let on_border = |&(a, b): &(u32, u32)| {
            let [a, b] = [a, b].map(|i| &self.vertices[i as usize]);
            let is_on = |a: i64, b: i64| a == b && (a == 0 || a == SPAN);
            is_on(a.u, b.u) || is_on(a.v, b.v)
        };
        let is_paired = |&(a, b): &(u32, u32)| edges.binary_search(&(b, a)).is_ok();
        is_once && area == 2 * SPAN * SPAN && edges.iter().all(|edge| is_paired(edge) || on_border(edge))
    }
}
