//! Parts on the lattice of the format: triangulated, put right where rounding has turned triangles over, and given further vertices.

use super::fit::Ground;
use super::{MOST_CELLS, Part, PartMaker, Place, domain};
use crate::base::lattice::Point;
use crate::base::mesh;
use crate::kernel::triangulate::insertion::{self, Rim, delaunay, is_not_delaunay};
use crate::pyramid::error::PyramidError;
use crate::pyramid::lines::Vertex;
use crate::pyramid::quantize::SPAN;
use crate::pyramid::samples::{Patch, Samples};

impl PartMaker {
    /// Triangulates a rim and vertices inside of it, Delaunay. A vertex that comes to lie on the rim or on another is left out.
    pub(super) fn triangulate(&mut self, place: &Place, rim: &[Vertex], inside: &[Vertex]) -> Part {
        let all: Vec<Vertex> = rim.iter().chain(inside).copied().collect();
        let mut numbered = all.iter().enumerate().map(|vertex| numbered(place, vertex));
        let domain = domain(numbered.by_ref().take(rim.len()).collect());
        delaunay(&domain, numbered, &mut self.insertion, &mut self.mesh);
        self.part(&all, rim.len())
    }

    /// Puts a part right in which rounding has turned triangles over: edges are turned, or if that is not enough all is triangulated anew.
    pub(super) fn straightened(&mut self, place: &Place, part: Part) -> Part {
        self.load(place, &part);
        if insertion::untangle(&mut self.insertion, &mut self.mesh) {
            return self.part(&part.vertices, part.rim);
        }
        self.renewed(place, &part)
    }

    /// Triangulates a part's vertices anew, Delaunay.
    pub(in crate::pyramid) fn renewed(&mut self, place: &Place, part: &Part) -> Part {
        let (rim, inside) = part.vertices.split_at(part.rim);
        self.triangulate(place, rim, inside)
    }

    /// Gives a part further vertices. Each splits the triangle or the edge that it comes to lie on; then edges opposite the vertex are turned
    /// where that is better. All other triangles stay. A vertex on the rim or at the place of another is left out.
    pub(in crate::pyramid) fn insert(
        &mut self,
        samples: &Samples,
        place: &Place,
        part: &Part,
        more: &[Vertex],
    ) -> Result<Part, PyramidError> {
        self.load(place, part);
        let all: Vec<Vertex> = part.vertices.iter().chain(more).copied().collect();
        self.put_in(samples, place, &all, part.vertices.len()..all.len(), Rim::Locked)?;
        Ok(self.part(&all, part.rim))
    }

    /// Gives a part another rim, which has all vertices of its own and others between. These split the edges that they lie on; were one
    /// not to lie on any, all would be triangulated anew.
    pub(super) fn with_rim(
        &mut self,
        samples: &Samples,
        place: &Place,
        part: &Part,
        rim: &[Vertex],
    ) -> Result<Part, PyramidError> {
        let (own, inside) = part.vertices.split_at(part.rim);
        let all: Vec<Vertex> = rim.iter().chain(inside).copied().collect();
        let mut own = own.iter().peekable();
        let (kept, new): (Vec<usize>, Vec<usize>) =
            (0..rim.len()).partition(|&i| own.next_if(|vertex| **vertex == rim[i]).is_some());
        self.load(place, part);
        let numbers = kept.into_iter().chain(rim.len()..all.len());
        self.mesh.vertices.iter_mut().zip(numbers).for_each(|(vertex, number)| vertex.height = number as f64);
        self.put_in(samples, place, &all, new.into_iter(), Rim::Free)?;
        if self.mesh.vertices.len() != all.len() {
            return Ok(self.triangulate(place, rim, inside));
        }
        let number = |i: u32| self.mesh.vertices[i as usize].height as u32;
        let triangles = self.mesh.triangles.iter().map(|&[a, b, c]| [a, c, b].map(number)).collect();
        Ok(Part { vertices: all, rim: rim.len(), triangles })
    }

    /// Inserts some of these vertices. Where one of the triangles beside an edge is beyond the tolerance, or would be if it were turned, the better way is the
    /// one that is less far from the samples; else, and in parts that are not made from all samples, it is Delaunay.
    fn put_in(
        &mut self,
        samples: &Samples,
        place: &Place,
        all: &[Vertex],
        numbers: impl Iterator<Item = usize>,
        rim: Rim,
    ) -> Result<(), PyramidError> {
        let more = numbers.map(|number| numbered(place, (number, &all[number])));
        if place.cells > MOST_CELLS {
            insertion::insert(more, rim, is_not_delaunay, &mut self.insertion, &mut self.mesh);
            return Ok(());
        }
        let (column, row) = (place.origin.0 + place.first.0, place.origin.1 + place.first.1);
        let side = place.cells as usize + 1;
        samples.read(Patch { column, row, width: side, height: side, step: 1 }, &mut self.block)?;
        let ground = Ground { block: &self.block, place };
        let turns = |corners: [mesh::Vertex; 4]| {
            let [x, y, p, q] = corners.map(|vertex| &all[vertex.height as usize]);
            let error = |first, second| ground.error(first).max(ground.error(second));
            let (as_it_is, turned) = (error([x, p, y], [y, q, x]), error([x, p, q], [q, p, y]));
            match as_it_is.max(turned) <= place.tolerance {
                true => is_not_delaunay(corners),
                false => turned < as_it_is,
            }
        };
        insertion::insert(more, rim, turns, &mut self.insertion, &mut self.mesh);
        Ok(())
    }

    /// Takes a part up to work on it; heights carry the numbers of vertices through.
    fn load(&mut self, place: &Place, part: &Part) {
        self.mesh.clear();
        self.mesh.vertices.extend(part.vertices.iter().enumerate().map(|vertex| numbered(place, vertex)));
        self.mesh.triangles.extend(part.triangles.iter().map(|&[a, b, c]| [a, c, b]));
    }

    /// The part that has come of it.
    fn part(&self, vertices: &[Vertex], rim: usize) -> Part {
        let vertices = self.mesh.vertices.iter().map(|v| vertices[v.height as usize]).collect();
        let triangles = self.mesh.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
        Part { vertices, rim, triangles }
    }
}

/// A vertex on the lattice of the format, rows running down, its number in place of its height.
fn numbered(place: &Place, (number, vertex): (usize, &Vertex)) -> mesh::Vertex {
    let (u, v) = vertex.coordinates(place.tile_cells);
    mesh::Vertex { at: Point { x: u as i32, y: (SPAN - v) as i32 }, height: number as f64 }
}
