//! Numbers of vertices across tiles.

use super::{Chunk, ChunkCounts, Spool, SpoolError};
use crate::base::lattice::Point;
use crate::base::mesh::Vertex;
use crate::base::tiling::{TileGrid, TileId};
use crate::kernel::seam::Foreign;

/// The numbers of all vertices of a mesh: tile after tile, each tile's own vertices in their order.
///
/// A number is a prefix sum over the tiles before plus a place among the owner's vertices, which follows from the
/// owner's counts, or on a shifted grid from the places of those it shares. Only two rows of tiles are held at a time,
/// with 8 bytes a shared vertex; rows are visited in order. With vertices ([`Ids::with_vertices`]) it is 24 bytes more for each
/// vertex that a tile owns on its rim or shares.
#[derive(Debug)]
pub struct Ids<'a> {
    spool: &'a Spool,
    grid: TileGrid,
    has_vertices: bool,
    row: usize,
    /// Tiles of this row and the next.
    rows: [Vec<Owner>; 2],
}

/// What numbers of a tile's vertices follow from.
#[derive(Debug)]
struct Owner {
    /// The number of its first vertex.
    first: u64,
    counts: ChunkCounts,
    /// Places of the vertices it shares, in their order, which is that of rows and columns.
    shared: Vec<Point>,
    /// The vertices that others may borrow, with places of the owner; empty where nobody asks for them.
    lent: Vec<Vertex>,
}

impl<'a> Ids<'a> {
    /// Numbers from the first row of tiles on.
    ///
    /// # Errors
    /// [`SpoolError`].
    pub fn new(spool: &'a Spool, grid: TileGrid) -> Result<Ids<'a>, SpoolError> {
        Ids::of_rows(spool, grid, false)
    }

    /// The same, and the vertices that tiles borrow from each other ([`Ids::borrowed`]). It reads every chunk.
    ///
    /// # Errors
    /// [`SpoolError`].
    pub fn with_vertices(spool: &'a Spool, grid: TileGrid) -> Result<Ids<'a>, SpoolError> {
        Ids::of_rows(spool, grid, true)
    }

    fn of_rows(spool: &'a Spool, grid: TileGrid, has_vertices: bool) -> Result<Ids<'a>, SpoolError> {
        let first = load(spool, grid, 0, 0, has_vertices)?;
        let mut ids = Ids { spool, grid, has_vertices, row: 0, rows: [first, Vec::new()] };
        ids.rows[1] = ids.load_after()?;
        Ok(ids)
    }

    /// Goes on to the next row of tiles.
    ///
    /// # Errors
    /// [`SpoolError`].
    pub fn next_row(&mut self) -> Result<(), SpoolError> {
        self.row += 1;
        self.rows.swap(0, 1);
        self.rows[1] = self.load_after()?;
        Ok(())
    }

    /// The numbers of a chunk's vertices, in the order its triangles count them: owned on the rim, borrowed, inside.
    ///
    /// # Panics
    /// If the chunk's tile is not in the current row.
    pub fn of_chunk(&self, chunk: &Chunk, into: &mut Vec<u64>) {
        let id = self.grid.tile(chunk.tile);
        assert_eq!(id.row, self.row, "tile {} is numbered with its row", chunk.tile);
        let first = self.rows[0][id.column].first;
        let (before, all) = (chunk.before_borrowed() as u64, chunk.vertices.len() as u64);
        into.clear();
        into.extend(first..first + before);
        into.extend(chunk.foreign.iter().map(|&foreign| self.of_foreign(id, foreign)));
        into.extend(first + before..first + all);
    }

    /// A vertex that a tile borrows: its owner, and the vertex with a place of the owner.
    ///
    /// # Panics
    /// If the tile is not in the current row, or vertices were not asked for.
    pub fn borrowed(&self, tile: TileId, foreign: Foreign) -> (TileId, Vertex) {
        let (owner, place) = self.find(tile, foreign);
        (owner, self.owner(owner.column, owner.row).lent[place as usize])
    }

    /// The owner of a vertex that a tile borrows, and its place among the vertices that the owner lends.
    ///
    /// # Panics
    /// If the tile is not in the current row.
    pub fn lender(&self, tile: TileId, foreign: Foreign) -> (TileId, usize) {
        let (owner, place) = self.find(tile, foreign);
        (owner, place as usize)
    }

    /// The vertices that a tile lends, with its own places.
    ///
    /// # Panics
    /// If the tile is not in the current row or the next.
    pub fn lent(&self, tile: TileId) -> &[Vertex] {
        &self.owner(tile.column, tile.row).lent
    }

    fn of_foreign(&self, tile: TileId, foreign: Foreign) -> u64 {
        let (owner, place) = self.find(tile, foreign);
        self.owner(owner.column, owner.row).first + place
    }

    /// The owner of a vertex, and its place among the owner's vertices.
    fn find(&self, tile: TileId, foreign: Foreign) -> (TileId, u64) {
        let (right, below) = (tile.column + 1, tile.row + 1);
        let at = |column, row, place| (TileId { column, row }, u64::from(place));
        match foreign {
            Foreign::East(ordinal) => {
                let counts = self.owner(right, tile.row).counts;
                at(right, tile.row, counts.rim.before_west() + ordinal)
            }
            Foreign::South(ordinal) => {
                let counts = self.owner(tile.column, below).counts;
                at(tile.column, below, counts.rim.before_north() + ordinal)
            }
            Foreign::NorthEast => self.of_corner(right, tile.row),
            Foreign::SouthWest => self.of_corner(tile.column, below),
            Foreign::SouthEast => self.of_corner(right, below),
            Foreign::At { across, down, at: point } => {
                let (column, row) = (tile.column.wrapping_add_signed(across as isize), tile.row + down as usize);
                let found = self.owner(column, row).shared.binary_search_by_key(&(point.y, point.x), |p| (p.y, p.x));
                let place = found.unwrap_or_else(|_| panic!("tile {tile:?} borrows {point:?}, which is not shared"));
                (TileId { column, row }, place as u64)
            }
        }
    }

    /// The corner between tiles: it is of the tile to its lower right, or of the last one there is.
    fn of_corner(&self, column: usize, row: usize) -> (TileId, u64) {
        let (last_column, last_row) = (self.grid.columns() - 1, self.grid.rows() - 1);
        let owner = TileId { column: column.min(last_column), row: row.min(last_row) };
        let bit = 1 << (u32::from(column > last_column) + 2 * u32::from(row > last_row));
        (owner, u64::from(self.owner(owner.column, owner.row).counts.rim.corner(bit)))
    }

    fn owner(&self, column: usize, row: usize) -> &Owner {
        &self.rows[row - self.row][column]
    }

    fn load_after(&self) -> Result<Vec<Owner>, SpoolError> {
        let Some(last) = self.rows[0].last() else { return Ok(Vec::new()) };
        if self.row + 1 >= self.grid.rows() {
            return Ok(Vec::new());
        }
        load(self.spool, self.grid, self.row + 1, last.first + last.counts.vertices, self.has_vertices)
    }
}

/// A row of tiles. Chunks are read only where they share something, or vertices are asked for.
fn load(spool: &Spool, grid: TileGrid, row: usize, first: u64, has_vertices: bool) -> Result<Vec<Owner>, SpoolError> {
    let start = grid.index(TileId { column: 0, row });
    let (mut chunk, mut buffer) = (Chunk::default(), Vec::new());
    let mut next = first;
    let counts = spool.counts(start..start + grid.columns())?;
    let owner = |(tile, counts): (usize, ChunkCounts)| {
        let first = next;
        next += counts.vertices;
        let (mut shared, mut lent) = (Vec::new(), Vec::new());
        if counts.shared > 0 || has_vertices {
            spool.read(tile, &mut chunk, &mut buffer)?;
            shared.extend(chunk.vertices[..counts.shared as usize].iter().map(|v| v.at));
        }
        if has_vertices {
            lent.extend_from_slice(&chunk.vertices[..chunk.before_borrowed()]);
        }
        Ok(Owner { first, counts, shared, lent })
    };
    (start..).zip(counts).map(owner).collect()
}
