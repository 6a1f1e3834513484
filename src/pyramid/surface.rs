//! The surface of a tile as readers decode it: its parts put together on the lattice of the format, and every vertex in space.

use std::collections::HashMap;

use super::Body;
use super::body::{Angle, Vector, minus};
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
}

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
        let mut surface =
            Surface { tile, lattice, centre, vertices: Vec::new(), triangles: Vec::new(), owners: Vec::new() };
        let mut numbers = HashMap::new();
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
                let rows = triangle.map(|i| tile.origin(grid).1 + surface.vertices[i as usize].sample.1);
                let on_pole = |pole: i64| rows.iter().filter(|&&row| row == pole).count();
                if on_pole(0) < 2 && on_pole(grid.rows()) < 2 {
                    surface.triangles.push(triangle);
                    surface.owners.push(owner as u32);
                }
            }
        }
        surface
    }
}
