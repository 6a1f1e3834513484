//! The mesh of a part of a tile: of all of it where triangles are flat enough, else of one of k × k.
//!
//! A part of up to [`MOST_CELLS`] cells is made from all samples. A larger one is made from every 2ᵏ-th sample, at a share of
//! the tolerance, and one of that many cells from every eighth where hardly any of those become vertices; the inner vertices are taken over, Delaunay on the lattice of the format. In either case whoever measures the tile as
//! decoded may ask for further vertices, which are inserted into the triangles there are (`lattice`).

mod fit;
mod lattice;

use std::collections::HashMap;

use super::budget::MOST_IN_PART;
use super::error::PyramidError;
use super::fall::Fall;
use super::lines::{Line, Sides, Vertex, collar, free_on_line, near_inside};
use super::outline::THINNED;
use super::own::{Along, OnSide};
use super::quantize::{SPAN, coordinate};
use super::rim;
use super::samples::{Block, Patch, Samples};
use crate::base::control::CancelToken;
use crate::base::lattice::Point;
use crate::base::mesh::{self, Domain, TileMesh};
use crate::base::{Heights, Tile};
use crate::kernel::polish;
use crate::kernel::seam::{Limits, MinLink};
use crate::kernel::triangulate::insertion::{self, GreedyInsertion};
use crate::kernel::triangulate::{EngineScratch, Feasibility, Task};

/// The most cells across a part that is made from all of its samples.
const MOST_CELLS: i64 = 512;

/// A part of that many cells is made from every eighth sample where no more of those become vertices inside.
const FEW_VERTICES: usize = 8;

/// The share of the tolerance that the mesh of every 2ᵏ-th sample is made at: those between are measured afterwards.
const THINNED_SHARE: f64 = 0.9;

/// A part: its square of the tile, in cells from the tile's north-west corner, and what it is made for.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    /// The tile's first sample on the grid.
    pub(super) origin: (i64, i64),
    /// Cells along the tile's side.
    pub(super) tile_cells: i64,
    /// The part's first sample in the tile.
    pub(super) first: (i64, i64),
    /// Cells along the part's side.
    pub(super) cells: i64,
    /// How far the mesh may be from samples, places and heights not rounded yet.
    pub(super) tolerance: f64,
    /// The same of its sides.
    pub(super) tolerance_of_sides: f64,
    /// Vertices stand at multiples of it.
    pub(super) snap: i64,
    /// Polishing keeps the surface between samples within this multiple of the tolerance from their heights.
    pub(super) max_stray: f64,
    /// How the ellipsoid curves there.
    pub(super) fall: Fall,
}

impl Place {
    /// Whether a vertex can stand inside, off the rim.
    pub(super) fn has_inside(&self, vertex: &Vertex) -> bool {
        let (column, row) = (vertex.column - self.first.0, vertex.row - self.first.1);
        if let Some((u, v)) = vertex.place {
            let is_between = |at: i64, first: i64| {
                let [first, last] = [first, first + self.cells].map(|at| coordinate(at, self.tile_cells));
                first < at && at < last
            };
            return is_between(u, self.first.0) && is_between(v, self.tile_cells - self.first.1 - self.cells);
        }
        let is_snapped = vertex.column % self.snap == 0 && vertex.row % self.snap == 0;
        is_snapped && column > 0 && row > 0 && column < self.cells && row < self.cells
    }
}

/// The mesh of a part.
#[derive(Debug, Clone, Default)]
pub(super) struct Part {
    /// Those of the rim come first.
    pub(super) vertices: Vec<Vertex>,
    /// How many are on the rim.
    pub(super) rim: usize,
    /// Counter-clockwise as seen from above.
    pub(super) triangles: Vec<[u32; 3]>,
}

/// Memory for parts, reused.
#[derive(Default)]
pub(super) struct PartMaker {
    sides: Sides,
    min_link: MinLink,
    engine: EngineScratch,
    insertion: insertion::Scratch,
    polish: polish::Scratch,
    block: Block,
    /// The heights of a block less the fall of the ellipsoid.
    flat: Vec<f64>,
    mesh: TileMesh,
}

impl PartMaker {
    /// One that shares what has been read.
    pub(super) fn beside(block: &Block) -> PartMaker {
        PartMaker { sides: Sides::beside(block), block: block.beside(), ..PartMaker::default() }
    }

    /// Begins another tile.
    pub(super) fn begin(&mut self) {
        self.sides.begin();
    }

    /// Makes a part of the tile.
    pub(super) fn make(
        &mut self,
        samples: &Samples,
        place: &Place,
        cancel: &CancelToken,
    ) -> Result<Part, PyramidError> {
        let Rim { vertices: rim, without_own } = self.rim(samples, place, cancel)?;
        let (column, row) = (place.origin.0 + place.first.0, place.origin.1 + place.first.1);
        if !samples.may_have(column, row, place.cells, place.cells) {
            return Ok(self.triangulate(place, &rim, &[]));
        }
        if let Some(part) = self.sparse(samples, place, &rim, cancel)? {
            return Ok(part);
        }
        let step = (place.cells / MOST_CELLS).max(1).max(place.snap);
        let side = (place.cells / step) as usize + 1;
        samples.read(Patch { column, row, width: side, height: side, step }, &mut self.block)?;
        let heights = &self.block.heights;
        if !self.block.inside.contains(&true) && heights.iter().all(|height| *height == heights[0]) {
            return Ok(self.triangulate(place, &rim, &[]));
        }
        if step > 1 {
            return self.of_some(place, &rim, step, cancel);
        }
        match without_own {
            None => self.of_all(place, &rim, cancel),
            // Engines take samples of the grid: they choose vertices inside.
            Some(samples_only) => {
                let part = self.of_all(place, &samples_only, cancel)?;
                self.with_rim(samples, place, &part, &rim)
            }
        }
    }

    /// The vertices around a part: its north side eastwards, then on clockwise as seen from above. Ground lies to the right
    /// there, which is left on the lattice, whose rows run down.
    fn rim(&mut self, samples: &Samples, place: &Place, cancel: &CancelToken) -> Result<Rim, PyramidError> {
        let Place { origin, first, cells, tolerance_of_sides: tolerance, snap, tile_cells, .. } = *place;
        let mut side = |column: i64, row: i64, down: bool| {
            let line = Line { column: origin.0 + column, row: origin.1 + row, length: cells, down };
            let fall = Fall { top: line.row, ..place.fall };
            let along = Along { line, first: if down { row } else { column }, tile_cells, fall };
            let found = self.sides.side(line, |sides| sides.find(samples, along, tolerance, snap, cancel))?;
            let at = |at: i64, height: f64| match down {
                true => Vertex::of_sample(column, row + at, height),
                false => Vertex::of_sample(column + at, row, height),
            };
            let on_tile = |&OnSide { at: near, lattice, height }: &OnSide| {
                let vertex = at(near, height);
                let (u, v) = vertex.coordinates(tile_cells);
                let place = if down { (u, SPAN - lattice) } else { (lattice, v) };
                Vertex { place: (place != (u, v)).then_some(place), ..vertex }
            };
            let plain: Vec<Vertex> = found.vertices.iter().map(on_tile).collect();
            let refined = found.refined.as_ref().map(|side| side.iter().map(on_tile).collect());
            Ok::<(Vec<Vertex>, Option<Vec<Vertex>>), PyramidError>((plain, refined))
        };
        let north = side(first.0, first.1, false)?;
        let east = side(first.0 + cells, first.1, true)?;
        let south = side(first.0, first.1 + cells, false)?;
        let west = side(first.0, first.1, true)?;
        let sides = [&north, &east, &south, &west];
        let plain = closed(sides.map(|side| &side.0[..]));
        let refined = closed(sides.map(|side| side.1.as_deref().unwrap_or(&side.0)));
        Ok(match refined == plain {
            true => Rim { vertices: plain, without_own: None },
            false => Rim { vertices: refined, without_own: Some(plain) },
        })
    }

    /// Makes a tile of the block, its heights less the fall of the ellipsoid, in which nothing binds the samples outside that are near others inside, nor those in
    /// marked voids that are near others; on the rim, the sides decide which are near, and voids bind nothing.
    fn tile(&mut self, place: &Place, step: i64) -> Tile {
        let side = (place.cells / step) as usize + 1;
        self.flat.clear();
        let squares = place.fall.squares(step);
        for (row, heights) in self.block.heights.chunks_exact(side).enumerate() {
            place.fall.flatten(row as i64 * step, heights, &squares, &mut self.flat);
        }
        let tile = Tile::from_heights(side, side, Heights::F64(std::mem::take(&mut self.flat)));
        let inside = &self.block.inside;
        if !inside.contains(&false) {
            return tile;
        }
        let is_void = &self.block.is_void;
        let on_rim = self.free_on_rim(side);
        let near = near_in_square(side, |i| inside[i]);
        let near_others = is_void.contains(&true).then(|| near_in_square(side, |i| !is_void[i]));
        let is_in_void = |i: usize| near_others.as_ref().is_some_and(|near| near[i] && is_void[i]);
        let weight = |i: usize| {
            let is_free = on_rim(i % side, i / side).unwrap_or(near[i] && !inside[i] || is_in_void(i));
            if is_free { 0.0 } else { 1.0 }
        };
        tile.with_weights((0..side * side).map(weight).collect())
    }

    /// Keeps a tile's memory for the next.
    fn done_with(&mut self, tile: Tile) {
        if let Heights::F64(heights) = tile.heights {
            self.flat = heights;
        }
    }

    /// A vertex of a mesh over every so-many-th sample of a part, with the height that the block has there.
    fn on_tile(&self, vertex: &mesh::Vertex, place: &Place, step: i64) -> Vertex {
        let (column, row) = vertex.at.sample().expect("vertices stand on samples");
        let (column, row) = (column as i64, row as i64);
        let height = self.block.heights[(row * (place.cells / step + 1) + column) as usize];
        Vertex::of_sample(place.first.0 + column * step, place.first.1 + row * step, height)
    }

    /// Whether samples of the rim are free, as [`Sides`] has it; those in voids, which it may bind, always are.
    fn free_on_rim(&self, side: usize) -> impl Fn(usize, usize) -> Option<bool> + use<> {
        let line = |at: &dyn Fn(usize) -> usize| {
            let on_line = |of: &[bool]| (0..side).map(|i| of[at(i)]).collect::<Vec<bool>>();
            let free = free_on_line(&on_line(&self.block.inside));
            let is_void = on_line(&self.block.is_void);
            free.iter().zip(&is_void).map(|(free, is_void)| *free || *is_void).collect::<Vec<bool>>()
        };
        let last = side - 1;
        let north = line(&|i| i);
        let south = line(&|i| last * side + i);
        let west = line(&|i| i * side);
        let east = line(&|i| i * side + last);
        move |column, row| match (column, row) {
            // A corner is a vertex of both of its sides.
            (c, 0) => Some(north[c]),
            (c, r) if r == last => Some(south[c]),
            (0, r) => Some(west[r]),
            (c, r) if c == last => Some(east[r]),
            _ => None,
        }
    }

    /// From all samples, with the rim as it is.
    fn of_all(&mut self, place: &Place, rim: &[Vertex], cancel: &CancelToken) -> Result<Part, PyramidError> {
        let tile = self.tile(place, 1);
        let local = |v: &Vertex| {
            let (column, row) = (v.column - place.first.0, v.row - place.first.1);
            let height = v.height - place.fall.along_row(row)(column);
            mesh::Vertex { at: Point::of_sample(column as i32, row as i32), height }
        };
        let domain = domain(rim.iter().map(local).collect());
        self.run(&tile, &domain, (place.tolerance, place.max_stray), cancel)?;
        self.done_with(tile);
        let inner = &self.mesh.vertices[rim.len()..];
        let inner = inner.iter().map(|v| self.at_rim(self.on_tile(v, place, 1), place));
        let vertices: Vec<Vertex> = rim.iter().copied().chain(inner).collect();
        let triangles = self.mesh.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
        let part = Part { vertices, rim: rim.len(), triangles };
        Ok(self.straightened(place, part))
    }

    /// A vertex inside of a part, of which all samples are in the block, rounded away from the raster where it is at its rim.
    fn at_rim(&self, vertex: Vertex, place: &Place) -> Vertex {
        if !rim::counts(place.tile_cells) {
            return vertex;
        }
        let side = place.cells as usize + 1;
        let (column, row) = ((vertex.column - place.first.0) as usize, (vertex.row - place.first.1) as usize);
        let inside = |c: usize, r: usize| self.block.inside[r * side + c];
        match inside(column, row) {
            true => {
                let around = std::array::from_fn(|i| inside(column + i % 3 - 1, row + i / 3 - 1));
                let line = rim::line_beside((vertex.column, vertex.row), place.cells);
                rim::moved(vertex, rim::away(around, line), place.tile_cells)
            }
            false => vertex,
        }
    }

    /// From every eighth sample, where all of those are of the raster and few of them become vertices.
    fn sparse(
        &mut self,
        samples: &Samples,
        place: &Place,
        rim: &[Vertex],
        cancel: &CancelToken,
    ) -> Result<Option<Part>, PyramidError> {
        let step = THINNED as i64;
        if place.cells != MOST_CELLS || place.snap > 1 {
            return Ok(None);
        }
        let (column, row) = (place.origin.0 + place.first.0, place.origin.1 + place.first.1);
        let side = (place.cells / step) as usize + 1;
        samples.read(Patch { column, row, width: side, height: side, step }, &mut self.block)?;
        if self.block.inside.contains(&false) {
            return Ok(None);
        }
        let inner = self.inner_of_some(place, step, cancel)?;
        Ok((inner.len() <= FEW_VERTICES).then(|| self.triangulate(place, rim, &inner)))
    }

    /// From every so-many-th sample.
    fn of_some(
        &mut self,
        place: &Place,
        rim: &[Vertex],
        step: i64,
        cancel: &CancelToken,
    ) -> Result<Part, PyramidError> {
        let inner = self.inner_of_some(place, step, cancel)?;
        Ok(self.triangulate(place, rim, &inner))
    }

    /// The vertices inside of a mesh of every so-many-th sample, with a rim of its own that only serves to choose them.
    fn inner_of_some(&mut self, place: &Place, step: i64, cancel: &CancelToken) -> Result<Vec<Vertex>, PyramidError> {
        let tile = self.tile(place, step);
        let tolerance = THINNED_SHARE * place.tolerance;
        let mut loop_ = Vec::new();
        let last = (place.cells / step) as usize;
        let sides: [&dyn Fn(usize) -> (usize, usize); 4] =
            [&|i| (i, 0), &|i| (last, i), &|i| (last - i, last), &|i| (0, last - i)];
        for at in sides {
            let heights: Vec<f64> = (0..=last).map(at).map(|(c, r)| tile.at(c, r)).collect();
            let limits: Vec<f64> = (0..=last).map(at).map(|(c, r)| tile.limit(c, r, tolerance)).collect();
            let path = self.min_link.path(&heights, Limits::Each(&limits), &[], cancel)?;
            let vertex =
                |&i: &usize| mesh::Vertex { at: Point::of_sample(at(i).0 as i32, at(i).1 as i32), height: heights[i] };
            loop_.extend(path[..path.len() - 1].iter().map(vertex));
        }
        let on_rim = loop_.len();
        self.run(&tile, &domain(loop_), (tolerance, place.max_stray), cancel)?;
        self.done_with(tile);
        Ok(self.mesh.vertices[on_rim..].iter().map(|v| self.on_tile(v, place, step)).collect())
    }

    /// Engine and polishing.
    fn run(
        &mut self,
        tile: &Tile,
        domain: &Domain,
        (tolerance, max_stray): (f64, f64),
        cancel: &CancelToken,
    ) -> Result<(), PyramidError> {
        let feasibility = Feasibility::Weak;
        let task = Task { tile, domain, tolerance, feasibility, max_stray, cancel };
        GreedyInsertion::default().triangulate_up_to(&task, MOST_IN_PART, &mut self.engine, &mut self.mesh)?;
        if self.mesh.vertices.len() >= MOST_IN_PART {
            // Whoever puts the tile together refuses it.
            return Ok(());
        }
        let options = polish::Options { effort: polish::Effort::Fast, ..polish::Options::default() };
        polish::polish(&task, &options, &mut self.polish, &mut self.mesh)?;
        Ok(())
    }
}

impl Part {
    /// Its vertices by their coordinates in the format.
    pub(super) fn places(&self, tile_cells: i64) -> HashMap<(i64, i64), usize> {
        self.vertices.iter().enumerate().map(|(i, vertex)| (vertex.coordinates(tile_cells), i)).collect()
    }
}

/// Which samples of a square are near others of a kind, along rows and columns.
fn near_in_square(side: usize, is_of_kind: impl Fn(usize) -> bool) -> Vec<bool> {
    let reach = collar(side as i64 - 1);
    let mut near = vec![false; side * side];
    for row in 0..side {
        let line = near_inside((row * side..(row + 1) * side).map(&is_of_kind), reach);
        near[row * side..][..side].copy_from_slice(&line);
    }
    for column in 0..side {
        let line = near_inside((0..side).map(|row| near[row * side + column]), reach);
        (0..side).for_each(|row| near[row * side + column] = line[row]);
    }
    near
}

/// The vertices around a part.
struct Rim {
    vertices: Vec<Vertex>,
    /// The same without what the raster's own samples ask for, where they ask for more.
    without_own: Option<Vec<Vertex>>,
}

/// The loop of four sides: the northern and the southern run east, the eastern and the western south.
fn closed([north, east, south, west]: [&[Vertex]; 4]) -> Vec<Vertex> {
    let mut rim = Vec::with_capacity(north.len() + east.len() + south.len() + west.len());
    rim.extend_from_slice(&north[..north.len() - 1]);
    rim.extend_from_slice(&east[..east.len() - 1]);
    rim.extend(south[1..].iter().rev());
    rim.extend(west[1..].iter().rev());
    rim
}

fn domain(rim: Vec<mesh::Vertex>) -> Domain {
    let loops = vec![(0..rim.len() as u32).collect()];
    Domain { vertices: rim, loops, ..Domain::default() }
}
