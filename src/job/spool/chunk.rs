//! The mesh of one tile, as it is kept until all are there.

use crate::base::handed_over::{DENSE, clear};
use crate::base::mesh::{TileMesh, Vertex};
use crate::kernel::measure::ErrorStats;
use crate::kernel::seam::{Foreign, Rim, RimCounts};

/// One finished tile: what it owns, and references to what it borrows. Immutable once written.
///
/// Triangles number vertices in this order: those owned on the rim, those borrowed, those inside. `vertices` holds the
/// owned ones (rim, then inside) with tile-local places; of those inside the vertices of the domain's loops come first, then
/// its points. On the rim there may be vertices that only neighbours have triangles at.
///
/// The tiles of a shifted grid ([`crate::base::tiling::TileGrid::shifted`]) have no rim: what stands in its place are the
/// vertices of triangles that lie in other tiles as well. In the mesh others borrow them ([`Foreign::At`]), by their places,
/// rows first. A chunk that is not the mesh's, because another pass works on it, has every triangle that may pass over its
/// tile, and for what it borrows the vertices alone, no names.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Chunk {
    /// The tile's number in its grid.
    pub tile: usize,
    /// How many of the vertices are rim vertices, by kind.
    pub rim: RimCounts,
    /// The vertices the tile owns.
    pub vertices: Vec<Vertex>,
    /// Owned vertices that others find by their places, instead of a rim.
    pub shared: u32,
    /// How many of those, the first ones, the next pass is to polish around.
    pub pending: u32,
    /// The vertices its neighbours own; nothing in a shifted grid that another pass works on.
    pub foreign: Vec<Foreign>,
    /// Those vertices themselves, with places of this tile; nothing where nobody is to work on the chunk.
    pub borrowed: Vec<Vertex>,
    /// Triangles, with positive orientation on the lattice.
    pub triangles: Vec<[u32; 3]>,
    /// Further values at the owned vertices, by name.
    pub attributes: Vec<Attribute>,
    /// The errors measured over the samples the tile owns.
    pub errors: ErrorStats,
    /// Triangles whose strong feasibility was relaxed.
    pub relaxed: u64,
    /// The checksum of what it was made from: of the heights and weights ([`crate::base::Tile::checksum`]), and of chains of breaklines.
    pub samples_checksum: u32,
}

/// A named value at every owned vertex of a chunk.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Attribute {
    /// What sinks call it.
    pub name: String,
    /// One value per owned vertex.
    pub values: Vec<f64>,
}

/// What has to be known of a chunk to number its vertices.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ChunkCounts {
    /// Owned rim vertices, by kind.
    pub rim: RimCounts,
    /// [`Chunk::shared`].
    pub shared: u32,
    /// Owned vertices, rim and inside.
    pub vertices: u64,
    /// Triangles.
    pub triangles: u64,
}

impl Chunk {
    /// Fills the chunk with a tile mesh over `rim`, made from samples of this checksum. It takes the mesh, and leaves an
    /// empty one with memory of its own.
    pub fn fill(&mut self, tile: usize, rim: &Rim, mesh: &mut TileMesh, errors: ErrorStats, samples_checksum: u32) {
        // Vertices of loops inside and points of the domain are the tile's own, as all that is inside.
        let used = rim.owned.total() as usize - rim.idle.len();
        let inside = rim.on_sides();
        self.tile = tile;
        self.rim = rim.owned;
        self.relaxed = mesh.relaxed;
        self.take(mesh);
        let behind = self.vertices.len() - used;
        (self.shared, self.pending) = (0, 0);
        self.foreign.clone_from(&rim.foreign);
        self.borrowed.clear();
        self.borrowed.extend(self.vertices.drain(used..inside));
        if !rim.idle.is_empty() {
            let mut owned = self.vertices[..used].to_vec();
            rim.idle.iter().for_each(|&(place, vertex)| owned.insert(place as usize, vertex));
            self.vertices.splice(..used, owned);
            let idle: Vec<u32> = rim.idle.iter().map(|(place, _)| *place).collect();
            let in_use = (0..rim.owned.total()).filter(|place| idle.binary_search(place).is_err());
            let behind = (rim.owned.total()..).take(behind);
            let numbers: Vec<u32> = in_use.chain(behind).collect();
            self.triangles.as_flattened_mut().iter_mut().for_each(|i| *i = numbers[*i as usize]);
        }
        self.attributes.clear();
        self.errors = errors;
        self.samples_checksum = samples_checksum;
    }

    /// Takes the vertices and triangles of a mesh, and leaves an empty one.
    pub(in crate::job) fn take(&mut self, mesh: &mut TileMesh) {
        std::mem::swap(&mut self.vertices, &mut mesh.vertices);
        std::mem::swap(&mut self.triangles, &mut mesh.triangles);
        mesh.hand_over();
    }

    /// Forgets vertices, triangles and attributes. Their memory is kept if they were not many.
    pub(in crate::job) fn hand_over(&mut self) {
        clear(&mut self.vertices, DENSE / 2);
        clear(&mut self.triangles, DENSE);
        self.attributes.clear();
    }

    /// How many vertices it borrows.
    pub fn borrows(&self) -> usize {
        self.foreign.len().max(self.borrowed.len())
    }

    /// How many of its own vertices come before those it borrows.
    pub fn before_borrowed(&self) -> usize {
        let RimCounts { corners, north, west, east, south } = self.rim;
        // Counts from a file may be anything: their sum is more than 32 bits hold.
        [corners.count_ones(), north, west, east, south, self.shared].into_iter().map(|count| count as usize).sum()
    }

    /// Gives the owned vertices the attributes `names`; `value` is that of one of them at a vertex. To be called after
    /// [`Chunk::fill`], which leaves none.
    pub fn set_attributes<'a>(
        &mut self,
        names: impl IntoIterator<Item = &'a str>,
        value: impl Fn(usize, Vertex) -> f64,
    ) {
        let named = names.into_iter().enumerate();
        self.attributes = named
            .map(|(i, name)| {
                let values = self.vertices.iter().map(|&vertex| value(i, vertex)).collect();
                Attribute { name: name.to_string(), values }
            })
            .collect();
    }

    /// The counts that numbering needs.
    pub fn counts(&self) -> ChunkCounts {
        let (vertices, triangles) = (self.vertices.len() as u64, self.triangles.len() as u64);
        ChunkCounts { rim: self.rim, shared: self.shared, vertices, triangles }
    }
}
