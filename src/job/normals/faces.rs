//! Normals from the triangles around vertices.

use super::{NormalSource, unit};
use crate::base::CoordinateFrame;
use crate::base::handed_over::make_room;
use crate::base::tiling::TileId;
use crate::job::spool::{Chunk, Ids};
use crate::job::{Error, Mesh};

/// Goes over the triangles of a row of chunks before the normals of that row are asked for: what borrows from a chunk is in its
/// row or in the one above. Memory: 24 bytes for each vertex that is lent, two rows of chunks at a time.
pub(in crate::job) struct Maker<'a> {
    mesh: &'a Mesh,
    frame: CoordinateFrame,
    ids: Ids<'a>,
    row: usize,
    /// Of this row of chunks and the next: what the triangles around each lent vertex add up to.
    lent: [Vec<Vec<[f64; 3]>>; 2],
    normals: Vec<[f64; 3]>,
}

impl<'a> Maker<'a> {
    pub(super) fn new(source: &NormalSource<'a>, mesh: &'a Mesh) -> Result<Maker<'a>, Error> {
        let ids = Ids::with_vertices(&mesh.spool, mesh.chunks)?;
        let lent = [Vec::new(), Vec::new()];
        let mut maker = Maker { mesh, frame: source.frame, ids, row: 0, lent, normals: Vec::new() };
        maker.lent[0] = maker.nothing(0);
        maker.add_row()?;
        Ok(maker)
    }

    pub(super) fn of_chunk(&mut self, chunk: &Chunk) -> Result<&[[f64; 3]], Error> {
        let tile = self.mesh.chunks.tile(chunk.tile);
        while self.row < tile.row {
            self.ids.next_row()?;
            self.row += 1;
            self.lent.swap(0, 1);
            self.add_row()?;
        }
        let (before, foreign) = (chunk.before_borrowed(), chunk.foreign.len());
        let mut sums = Vec::with_capacity(chunk.vertices.len());
        sums.extend_from_slice(&self.lent[0][tile.column]);
        sums.resize(chunk.vertices.len(), [0.0; 3]);
        self.for_each_corner(chunk, |corner, normal| {
            // Those that are lent have their sums already.
            if corner >= before + foreign {
                add(&mut sums[corner - foreign], normal);
            }
        });
        make_room(&mut self.normals, sums.len());
        self.normals.extend(sums.into_iter().map(unit));
        Ok(&self.normals)
    }

    /// Sums of nothing for a row of chunks; none where there is no such row.
    fn nothing(&self, row: usize) -> Vec<Vec<[f64; 3]>> {
        if row >= self.mesh.chunks.rows() {
            return Vec::new();
        }
        let lent = (0..self.mesh.chunks.columns()).map(|column| self.ids.lent(TileId { column, row }).len());
        lent.map(|vertices| vec![[0.0; 3]; vertices]).collect()
    }

    /// Adds the triangles of the current row of chunks to what is lent by it and by the next.
    fn add_row(&mut self) -> Result<(), Error> {
        self.lent[1] = self.nothing(self.row + 1);
        let (mut chunk, mut buffer) = (Chunk::default(), Vec::new());
        for column in 0..self.mesh.chunks.columns() {
            let tile = TileId { column, row: self.row };
            self.mesh.spool.read(self.mesh.chunks.index(tile), &mut chunk, &mut buffer)?;
            let before = chunk.before_borrowed();
            let mut lent = std::mem::take(&mut self.lent);
            self.for_each_corner(&chunk, |corner, normal| {
                let (owner, place) = if corner < before {
                    (tile, corner)
                } else if let Some(&foreign) = chunk.foreign.get(corner - before) {
                    self.ids.lender(tile, foreign)
                } else {
                    return;
                };
                add(&mut lent[owner.row - tile.row][owner.column][place], normal);
            });
            self.lent = lent;
        }
        Ok(())
    }

    /// Calls `visit` with every corner of every triangle, as the triangles count them, and the triangle's normal: upwards, twice
    /// as long as the triangle is large.
    fn for_each_corner(&self, chunk: &Chunk, mut visit: impl FnMut(usize, [f64; 3])) {
        let mut places = Vec::new();
        self.mesh.place_all(chunk, &self.ids, &mut places);
        let CoordinateFrame { xy_scale, z_scale, .. } = self.frame;
        for triangle in &chunk.triangles {
            let [a, b, c] = triangle.map(|corner| places[corner as usize]);
            let side = |from: [f64; 3], to: [f64; 3]| {
                [(to[0] - from[0]) * xy_scale.0, (to[1] - from[1]) * xy_scale.1, (to[2] - from[2]) * z_scale]
            };
            let ([ux, uy, uz], [vx, vy, vz]) = (side(a, b), side(a, c));
            let [x, y, z] = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
            // Triangles of a chunk turn one way on the lattice, which may be the other one on the map.
            let normal = if z < 0.0 { [-x, -y, -z] } else { [x, y, z] };
            triangle.iter().for_each(|corner| visit(*corner as usize, normal));
        }
    }
}

fn add(sum: &mut [f64; 3], more: [f64; 3]) {
    sum.iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
}
