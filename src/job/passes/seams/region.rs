//! The part of a mesh in one tile of a pass's grid, put together from chunks of the pass before and made a chunk again.

use std::collections::HashMap;

use super::lines::Lines;
use crate::base::handed_over::DENSE;
use crate::base::lattice::{Point, STEPS};
use crate::base::mesh::{TileMesh, Vertex};
use crate::base::tiling::{TileGrid, TileId, TilePlace};
use crate::base::{RasterRim, Window};
use crate::job::spool::Chunk;
use crate::kernel::breaklines::TileChains;
use crate::kernel::seam::{Foreign, RimCounts};

/// Where the chunks of a region come from, and where they go.
#[derive(Debug, Clone, Copy)]
pub(in crate::job::passes) struct Way {
    /// The grid of the pass before.
    pub(in crate::job::passes) from: TileGrid,
    /// Whether its tiles have rims, so that their triangles lie in one tile each: those of the first pass.
    pub(in crate::job::passes) has_rims: bool,
    /// The tile of that grid with the least column and row that is read.
    pub(in crate::job::passes) first_read: TileId,
    /// The grid of the regions.
    pub(in crate::job::passes) to: TileGrid,
    /// Whether the region's chunk is a part of the mesh, and not read by another pass.
    pub(in crate::job::passes) is_last: bool,
}

/// The part of a mesh that lies in one tile of a pass's grid, put together from the tiles of the grid before that it
/// overlaps.
///
/// A vertex belongs to the region it lies in; its lower lines are a region's own, its upper ones are not, but at the
/// raster's end. Triangles with all vertices in one region are its inside. All others straddle: nobody changes them, and
/// their vertices, the *shared* ones, stay what they are.
///
/// A chunk that another pass is to read has every straddling triangle that may pass over the region, whoever else has it,
/// and the vertices of others with their heights. In the last pass each is in one chunk: that of the region of least number
/// that has a vertex of it, which names those of others.
///
/// Memory: that of a tile mesh; while it is put together also 30 bytes per vertex, a chunk of another pass and its encoded
/// form.
#[derive(Debug, Default)]
pub(super) struct Region {
    id: TileId,
    window: Window,
    /// Where the region ends because the raster does.
    pub(super) rim: RasterRim,
    is_last: bool,
    /// The triangles inside, over the vertices in the region: the shared ones, first those that are still to be polished
    /// around, each by rows and columns, then those that are locked for other reasons, then those that are free. In the last
    /// pass shared ones are not told apart.
    pub(super) mesh: TileMesh,
    pending: u32,
    pub(super) shared: u32,
    pub(super) locked: u32,
    /// Vertices that were on the sides of tiles, have been locked since, and are free now; in no order.
    pub(super) seams: Vec<u32>,
    /// Straddling triangles of the region's chunk.
    straddling: Vec<[Corner; 3]>,
    /// In the last pass: straddling triangles of whomever, where they may pass over the region.
    passing: Vec<[Vertex; 3]>,
    /// Vertices of others that straddling triangles of the chunk have, with places of this tile, and the regions they are in.
    beyond: Vec<(TileId, Vertex)>,
    scratch: Scratch,
}

/// A vertex of a straddling triangle.
#[derive(Debug, Clone, Copy)]
enum Corner {
    Own(u32),
    Beyond(u32),
}

#[derive(Debug, Default)]
struct Scratch {
    /// Of the chunk that is read: numbers of its vertices in the region's mesh.
    numbers: Vec<u32>,
    /// Vertices that come with several chunks.
    known: HashMap<Point, u32>,
    /// Numbers of vertices of others.
    beyond: HashMap<Point, u32>,
    kinds: Vec<Kind>,
    /// Whether a vertex was on the side of a tile, and nobody has polished around it since.
    is_seam: Vec<bool>,
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
        self.rim = RasterRim::of(place);
        self.mesh.clear();
        self.straddling.clear();
        self.passing.clear();
        self.beyond.clear();
        let Scratch { known, beyond, kinds, is_seam, .. } = &mut self.scratch;
        known.clear();
        beyond.clear();
        kinds.clear();
        is_seam.clear();
    }

    /// Adds what the region has of a tile.
    pub(super) fn add(&mut self, way: &Way, chunk: &Chunk) {
        let place = way.from.place(chunk.tile);
        let window = place.window;
        let (old, new) = (Lines::new(way.from, &place), Lines::new(way.to, &place));
        let [dx, dy] = [(window.column, self.window.column), (window.row, self.window.row)]
            .map(|(from, to)| (from as i64 - to as i64) as i32 * STEPS);
        let (before, borrowed, id) = (chunk.before_borrowed(), chunk.borrowed.len(), self.id);
        let vertex = |i: u32| match i as usize {
            i if i < before => chunk.vertices[i],
            i if i < before + borrowed => chunk.borrowed[i - before],
            i => chunk.vertices[i - borrowed],
        };
        // Of the tiles that have a triangle and are read, the first one brings it.
        let brings = |corners: [Point; 3]| {
            let TileId { column, row } = old.span(corners).first;
            let first = way.first_read;
            way.has_rims || TileId { column: column.max(first.column), row: row.max(first.row) } == place.id
        };
        self.scratch.numbers.clear();
        self.scratch.numbers.resize(chunk.vertices.len() + borrowed, NONE);
        // Lists that double would take up to twice what they hold.
        let is_inside = |t: &&[u32; 3]| t.iter().all(|&i| new.region(vertex(i).at) == id);
        self.mesh.triangles.reserve_exact(chunk.triangles.iter().filter(is_inside).count());
        let all = chunk.vertices.iter().chain(&chunk.borrowed);
        self.mesh.vertices.reserve_exact(all.filter(|v| new.region(v.at) == id).count());
        for &triangle in &chunk.triangles {
            let vertices = triangle.map(vertex);
            let places = vertices.map(|v| v.at);
            let span = new.span(places);
            if !span.has(id) || !brings(places) {
                continue;
            }
            let here = vertices.map(|v| Vertex { at: Point { x: v.at.x + dx, y: v.at.y + dy }, ..v });
            let number = |region: &mut Region, i: usize, kind: Kind| {
                let is_shared = (triangle[i] as usize) < before + borrowed;
                region.number(triangle[i], is_shared, here[i], kind)
            };
            if span.is_one() {
                let corners = [0, 1, 2].map(|i| number(self, i, Kind::Free));
                self.mesh.triangles.push(corners);
                continue;
            }
            let regions = places.map(|at| new.region(at));
            let is_ours = !way.is_last || regions.iter().min_by_key(|r| (r.row, r.column)) == Some(&id);
            let corners = [0, 1, 2].map(|i| match regions[i] == id {
                true => Corner::Own(number(self, i, Kind::Shared)),
                false if is_ours => Corner::Beyond(self.beyond(regions[i], here[i])),
                false => Corner::Beyond(NONE),
            });
            if is_ours {
                self.straddling.push(corners);
            }
            if way.is_last {
                self.passing.push(here);
            }
        }
        let rim = chunk.vertices[..before].iter().chain(&chunk.borrowed).filter(|_| way.has_rims);
        let Scratch { known, is_seam, .. } = &mut self.scratch;
        // Whichever chunk has brought their triangles, it came before.
        for vertex in chunk.vertices[..chunk.pending as usize].iter().chain(rim) {
            let at = Point { x: vertex.at.x + dx, y: vertex.at.y + dy };
            if let Some(&number) = known.get(&at) {
                is_seam[number as usize] = true;
            }
        }
    }

    /// The number of a chunk's vertex in the mesh. Of the kinds it is given the least stays.
    fn number(&mut self, of_chunk: u32, is_shared: bool, vertex: Vertex, kind: Kind) -> u32 {
        let Region { mesh, scratch: Scratch { numbers, known, kinds, is_seam, .. }, .. } = self;
        let number = &mut numbers[of_chunk as usize];
        if *number == NONE {
            let mut new = || {
                mesh.vertices.push(vertex);
                kinds.push(Kind::Free);
                is_seam.push(false);
                mesh.vertices.len() as u32 - 1
            };
            *number = if is_shared { *known.entry(vertex.at).or_insert_with(new) } else { new() };
        }
        let kind_so_far = &mut kinds[*number as usize];
        *kind_so_far = kind.min(*kind_so_far);
        *number
    }

    /// The number of a vertex of another region among those beyond.
    fn beyond(&mut self, owner: TileId, vertex: Vertex) -> u32 {
        let Region { beyond, scratch, .. } = self;
        let new = || {
            beyond.push((owner, vertex));
            beyond.len() as u32 - 1
        };
        *scratch.beyond.entry(vertex.at).or_insert_with(new)
    }

    /// Everything has been added: says which vertices stay, and puts them first. `points` are samples of the window that
    /// stay vertices, by rows, then by columns; the ends of edges of `chains` stay, too.
    pub(super) fn end(&mut self, way: &Way, points: &[(usize, usize)], chains: &TileChains) {
        self.lock_rim();
        self.is_last = way.is_last;
        let Region { mesh, passing, scratch: Scratch { kinds, is_seam, numbers, order, .. }, .. } = self;
        for (vertex, kind) in mesh.vertices.iter().zip(kinds.iter_mut()) {
            let sample = vertex.at.sample();
            let is_point = || sample.is_some_and(|(x, y)| points.binary_search_by_key(&(y, x), |p| (p.1, p.0)).is_ok());
            if *kind == Kind::Free && (is_point() || chains.at(vertex.at).is_some()) {
                *kind = Kind::Locked;
            }
        }
        let is_pending = |v: u32| !way.is_last && kinds[v as usize] == Kind::Shared && is_seam[v as usize];
        let place = |v: u32| (mesh.vertices[v as usize].at.y, mesh.vertices[v as usize].at.x);
        order.clear();
        order.extend(0..mesh.vertices.len() as u32);
        order.sort_unstable_by_key(|&v| (kinds[v as usize], !is_pending(v), place(v)));
        let count = |last: Kind| order.partition_point(|&v| kinds[v as usize] <= last) as u32;
        self.pending = order.partition_point(|&v| is_pending(v)) as u32;
        (self.shared, self.locked) = (count(Kind::Shared), count(Kind::Locked));
        numbers.clear();
        numbers.resize(order.len(), NONE);
        for (new, &old) in (0..).zip(order.iter()) {
            numbers[old as usize] = new;
        }
        self.seams.clear();
        self.seams.extend(
            (self.locked..)
                .zip(&order[self.locked as usize..])
                .filter(|(_, old)| is_seam[**old as usize])
                .map(|(new, _)| new),
        );
        let before = std::mem::take(&mut mesh.vertices);
        mesh.vertices = Vec::with_capacity(before.len() + 3 * passing.len());
        mesh.vertices.extend(order.iter().map(|&v| before[v as usize]));
        drop(before);
        mesh.triangles.as_flattened_mut().iter_mut().for_each(|v| *v = numbers[*v as usize]);
        for corner in self.straddling.as_flattened_mut() {
            if let Corner::Own(v) = corner {
                *v = numbers[*v as usize];
            }
        }
        if self.mesh.triangles.len() > DENSE {
            self.scratch = Scratch::default();
        }
    }

    /// Locks both ends of every side that one triangle inside has, unless it runs along the raster's rim, where the raster's
    /// corners alone are locked: those sides at a time whose lower end is one of a range of vertices.
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
                let ends = [edge[0].0, edge[0].1];
                let [p, q] = ends.map(|v| mesh.vertices[v as usize].at);
                for (v, at) in ends.into_iter().zip([p, q]) {
                    if !self.rim.joins(p, q) || self.rim.is_corner(at) {
                        kinds[v as usize] = kinds[v as usize].min(Kind::Locked);
                    }
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

    /// Fills a chunk of the pass's grid, whose errors are left to the caller. It takes the mesh.
    pub(super) fn fill(&mut self, place: &TilePlace, to: TileGrid, chunk: &mut Chunk) {
        let (shared, beyond) = (self.shared, self.beyond.len() as u32);
        (chunk.tile, chunk.rim, chunk.shared, chunk.pending) =
            (place.index, RimCounts::default(), shared, self.pending);
        chunk.borrowed.clear();
        chunk.foreign.clear();
        chunk.attributes.clear();
        chunk.relaxed = self.mesh.relaxed;
        chunk.take(&mut self.mesh);
        if self.is_last {
            chunk.foreign.extend(self.beyond.iter().map(|&(owner, vertex)| name(place, to, owner, vertex.at)));
        } else {
            chunk.borrowed.extend(self.beyond.iter().map(|&(_, vertex)| vertex));
        }
        let number = |v: u32| if v < shared { v } else { v + beyond };
        let of_corner = |corner: Corner| match corner {
            Corner::Own(v) => number(v),
            Corner::Beyond(i) => shared + i,
        };
        chunk.triangles.as_flattened_mut().iter_mut().for_each(|v| *v = number(*v));
        chunk.triangles.reserve_exact(self.straddling.len());
        chunk.triangles.extend(self.straddling.iter().map(|t| t.map(of_corner)));
    }
}

/// The name that a tile has for the vertex of another, at a place of its own.
fn name(place: &TilePlace, grid: TileGrid, owner: TileId, at: Point) -> Foreign {
    let (here, there) = (place.window, grid.window(owner));
    let local = |at: i32, here: usize, there: usize| at + (here as i64 - there as i64) as i32 * STEPS;
    let at = Point { x: local(at.x, here.column, there.column), y: local(at.y, here.row, there.row) };
    let across = owner.column as i64 - place.id.column as i64;
    Foreign::At { across: across as i32, down: (owner.row - place.id.row) as u32, at }
}
