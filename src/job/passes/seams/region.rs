//! The part of a mesh in one tile of the shifted grid, put together from chunks and made a chunk again.

use std::collections::HashMap;

use super::lines::Lines;
use crate::base::Window;
use crate::base::handed_over::DENSE;
use crate::base::lattice::{Point, STEPS};
use crate::base::mesh::{TileMesh, Vertex};
use crate::base::tiling::{TileGrid, TileId, TilePlace};
use crate::job::spool::Chunk;
use crate::kernel::seam::{Foreign, RimCounts};

/// The part of a mesh that lies in one tile of the shifted grid, put together from the tiles it overlaps.
///
/// A vertex belongs to the region it lies in; its lower lines are a region's own, its upper ones are not, but at the
/// raster's end. Triangles with all vertices in one region are its inside. All others straddle: nobody changes them, and
/// their vertices, the *shared* ones, stay what they are. The region of least number that has a vertex of such a triangle
/// owns it.
///
/// Memory: that of a tile mesh; while it is put together also 29 bytes per vertex, a chunk of another pass and its encoded
/// form.
#[derive(Debug, Default)]
pub(super) struct Region {
    id: TileId,
    window: Window,
    /// The triangles inside, over the vertices in the region: the shared ones by rows and columns, then those that are
    /// locked for other reasons, then those that are free.
    pub(super) mesh: TileMesh,
    pub(super) shared: u32,
    pub(super) locked: u32,
    /// Vertices that were on a line between tiles, and are free now; in no order.
    pub(super) seams: Vec<u32>,
    /// Straddling triangles that the region owns.
    owned: Vec<[Corner; 3]>,
    /// Straddling triangles of whomever, where they may pass over the region.
    passing: Vec<[Vertex; 3]>,
    foreign: Vec<Foreign>,
    scratch: Scratch,
}

/// A vertex of a straddling triangle that the region owns.
#[derive(Debug, Clone, Copy)]
enum Corner {
    Own(u32),
    Foreign(u32),
}

#[derive(Debug, Default)]
struct Scratch {
    /// Of the chunk that is read: numbers of its vertices in the region's mesh.
    numbers: Vec<u32>,
    /// Vertices on lines between tiles, which come with several chunks.
    on_lines: HashMap<Point, u32>,
    borrowed: HashMap<(TileId, Point), u32>,
    kinds: Vec<Kind>,
    sides: Vec<(u32, u32)>,
    order: Vec<u32>,
}

/// What may become of a vertex.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Kind {
    Shared,
    Locked,
    Free,
}

const NONE: u32 = u32::MAX;

/// Vertices whose sides are listed at a time: about 48 bytes for each.
const VERTICES_AT_A_TIME: u32 = 1 << 15;

impl Region {
    /// Begins with a region of no triangles.
    pub(super) fn begin(&mut self, place: &TilePlace) {
        self.id = place.id;
        self.window = place.window;
        self.mesh.clear();
        self.owned.clear();
        self.passing.clear();
        self.foreign.clear();
        self.scratch.on_lines.clear();
        self.scratch.borrowed.clear();
        self.scratch.kinds.clear();
    }

    /// Adds what the region has of a tile.
    pub(super) fn add(&mut self, grid: TileGrid, shifted: TileGrid, chunk: &Chunk) {
        let place = grid.place(chunk.tile);
        let window = place.window;
        let lines = Lines::new(shifted, &place);
        let [dx, dy] = [(window.column, self.window.column), (window.row, self.window.row)]
            .map(|(from, to)| (from as i64 - to as i64) as i32 * STEPS);
        let (rim, borrowed) = (chunk.before_borrowed(), chunk.borrowed.len());
        let vertex = |i: u32| match i as usize {
            i if i < rim => chunk.vertices[i],
            i if i < rim + borrowed => chunk.borrowed[i - rim],
            i => chunk.vertices[i - borrowed],
        };
        self.scratch.numbers.clear();
        self.scratch.numbers.resize(chunk.vertices.len() + borrowed, NONE);
        // Lists that double would take up to twice what they hold.
        let is_inside = |t: &[u32; 3]| t.iter().all(|&i| lines.region(vertex(i).at) == self.id);
        self.mesh.triangles.reserve_exact(chunk.triangles.iter().filter(|t| is_inside(t)).count());
        let all = chunk.vertices.iter().chain(&chunk.borrowed);
        self.mesh.vertices.reserve_exact(all.filter(|v| lines.region(v.at) == self.id).count());
        for &triangle in &chunk.triangles {
            let vertices = triangle.map(vertex);
            let regions = vertices.map(|v| lines.region(v.at));
            let here = vertices.map(|v| Vertex { at: Point { x: v.at.x + dx, y: v.at.y + dy }, ..v });
            let number = |region: &mut Region, i: usize, kind: Kind| {
                let on_line = (triangle[i] as usize) < rim + borrowed;
                region.number(triangle[i], on_line, here[i], kind)
            };
            if regions.iter().all(|&r| r == self.id) {
                let corners = [0, 1, 2].map(|i| number(self, i, Kind::Free));
                self.mesh.triangles.push(corners);
                continue;
            }
            if regions[0] == regions[1] && regions[1] == regions[2] {
                continue;
            }
            if self.may_pass(here) {
                self.passing.push(here);
            }
            let id = self.id;
            for i in (0..3).filter(|&i| regions[i] == id) {
                number(self, i, Kind::Shared);
            }
            if regions.iter().min_by_key(|r| (r.row, r.column)) == Some(&self.id) {
                let corners = [0, 1, 2].map(|i| match regions[i] == self.id {
                    true => Corner::Own(number(self, i, Kind::Shared)),
                    false => Corner::Foreign(self.foreign(shifted, regions[i], here[i].at)),
                });
                self.owned.push(corners);
            }
        }
    }

    /// The number of a chunk's vertex in the mesh. Of the kinds it is given the least stays.
    fn number(&mut self, of_chunk: u32, on_line: bool, vertex: Vertex, kind: Kind) -> u32 {
        let Region { mesh, scratch: Scratch { numbers, on_lines, kinds, .. }, .. } = self;
        let number = &mut numbers[of_chunk as usize];
        if *number == NONE {
            let mut new = || {
                mesh.vertices.push(vertex);
                kinds.push(Kind::Free);
                mesh.vertices.len() as u32 - 1
            };
            *number = if on_line { *on_lines.entry(vertex.at).or_insert_with(new) } else { new() };
        }
        let known = &mut kinds[*number as usize];
        *known = kind.min(*known);
        *number
    }

    /// The number of a vertex of another region among those that are borrowed.
    fn foreign(&mut self, shifted: TileGrid, owner: TileId, at: Point) -> u32 {
        let Region { id, window, foreign, .. } = self;
        let new = || {
            let theirs = shifted.window(owner);
            let local = |at: i32, here: usize, there: usize| at + (here as i64 - there as i64) as i32 * STEPS;
            let at = Point { x: local(at.x, window.column, theirs.column), y: local(at.y, window.row, theirs.row) };
            let across = owner.column as i64 - id.column as i64;
            foreign.push(Foreign::At { across: across as i32, down: (owner.row - id.row) as u32, at });
            foreign.len() as u32 - 1
        };
        *self.scratch.borrowed.entry((owner, at)).or_insert_with(new)
    }

    /// Whether a triangle's box meets the window.
    fn may_pass(&self, corners: [Vertex; 3]) -> bool {
        let meets = |places: [i32; 3], samples: usize| {
            let far = (samples as i32 - 1) * STEPS;
            places.iter().any(|&p| p >= 0) && places.iter().any(|&p| p <= far)
        };
        meets(corners.map(|v| v.at.x), self.window.width) && meets(corners.map(|v| v.at.y), self.window.height)
    }

    /// Everything has been added: says which vertices stay, and puts them first. `points` are samples of the window that
    /// stay vertices, by rows, then by columns.
    pub(super) fn end(&mut self, points: &[(usize, usize)]) {
        self.lock_rim();
        let Region { mesh, passing, scratch: Scratch { kinds, numbers, order, on_lines, .. }, .. } = self;
        for (vertex, kind) in mesh.vertices.iter().zip(kinds.iter_mut()) {
            let sample = vertex.at.sample();
            if *kind == Kind::Free
                && sample.is_some_and(|(x, y)| points.binary_search_by_key(&(y, x), |p| (p.1, p.0)).is_ok())
            {
                *kind = Kind::Locked;
            }
        }
        let place = |v: u32| (mesh.vertices[v as usize].at.y, mesh.vertices[v as usize].at.x);
        order.clear();
        order.extend(0..mesh.vertices.len() as u32);
        order.sort_unstable_by_key(|&v| (kinds[v as usize], place(v)));
        let count = |last: Kind| order.partition_point(|&v| kinds[v as usize] <= last) as u32;
        (self.shared, self.locked) = (count(Kind::Shared), count(Kind::Locked));
        numbers.clear();
        numbers.resize(order.len(), NONE);
        for (new, &old) in (0..).zip(order.iter()) {
            numbers[old as usize] = new;
        }
        self.seams.clear();
        self.seams.extend(on_lines.values().map(|&v| numbers[v as usize]).filter(|&v| v >= self.locked));
        let before = std::mem::take(&mut mesh.vertices);
        mesh.vertices = Vec::with_capacity(before.len() + 3 * passing.len());
        mesh.vertices.extend(order.iter().map(|&v| before[v as usize]));
        drop(before);
        mesh.triangles.as_flattened_mut().iter_mut().for_each(|v| *v = numbers[*v as usize]);
        for corner in self.owned.as_flattened_mut() {
            if let Corner::Own(v) = corner {
                *v = numbers[*v as usize];
            }
        }
        if self.mesh.triangles.len() > DENSE {
            self.scratch = Scratch::default();
        }
    }

    /// Locks both ends of every side that one triangle inside has: those sides at a time whose lower end is one of a range of
    /// vertices.
    fn lock_rim(&mut self) {
        let Region { mesh, scratch: Scratch { kinds, sides, .. }, .. } = self;
        let count = mesh.vertices.len() as u32;
        for first in (0..count).step_by(VERTICES_AT_A_TIME as usize) {
            let range = first..first.saturating_add(VERTICES_AT_A_TIME);
            sides.clear();
            for &[a, b, c] in &mesh.triangles {
                let all = [(a, b), (b, c), (c, a)].map(|(p, q)| (p.min(q), p.max(q)));
                sides.extend(all.into_iter().filter(|(low, _)| range.contains(low)));
            }
            sides.sort_unstable();
            for edge in sides.chunk_by(|a, b| a == b).filter(|edge| edge.len() == 1) {
                for v in [edge[0].0, edge[0].1] {
                    kinds[v as usize] = kinds[v as usize].min(Kind::Locked);
                }
            }
        }
    }

    /// Lends the mesh together with all triangles that may pass over the region.
    pub(super) fn with_passing<T>(&mut self, look: impl FnOnce(&TileMesh) -> T) -> T {
        let (vertices, triangles) = (self.mesh.vertices.len(), self.mesh.triangles.len());
        self.mesh.triangles.reserve_exact(self.passing.len());
        self.mesh.vertices.reserve_exact(3 * self.passing.len());
        for corners in &self.passing {
            let first = self.mesh.vertices.len() as u32;
            self.mesh.vertices.extend_from_slice(corners);
            self.mesh.triangles.push([first, first + 1, first + 2]);
        }
        let result = look(&self.mesh);
        self.mesh.vertices.truncate(vertices);
        self.mesh.triangles.truncate(triangles);
        result
    }

    /// Fills a chunk of the shifted grid, whose errors are left to the caller. It takes the mesh.
    pub(super) fn fill(&mut self, tile: usize, chunk: &mut Chunk) {
        let (shared, borrowed) = (self.shared, self.foreign.len() as u32);
        (chunk.tile, chunk.rim, chunk.shared) = (tile, RimCounts::default(), shared);
        chunk.borrowed.clear();
        chunk.attributes.clear();
        chunk.relaxed = self.mesh.relaxed;
        chunk.take(&mut self.mesh);
        chunk.foreign.clone_from(&self.foreign);
        let number = |v: u32| if v < shared { v } else { v + borrowed };
        let of_corner = |corner: Corner| match corner {
            Corner::Own(v) => number(v),
            Corner::Foreign(i) => shared + i,
        };
        chunk.triangles.as_flattened_mut().iter_mut().for_each(|v| *v = number(*v));
        chunk.triangles.reserve_exact(self.owned.len());
        chunk.triangles.extend(self.owned.iter().map(|t| t.map(of_corner)));
    }
}
