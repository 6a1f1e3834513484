//! The chains of all lines of a raster, by place.

mod along;

pub(crate) use along::type_of;

use std::sync::Arc;

use super::{ChainEdge, Inside, Place, SetBits};
use crate::base::Window;
use crate::base::lattice::{Point, STEPS};
use crate::base::mesh::Vertex;

/// An end of an edge, on the lattice of the raster.
pub type End = (Place, f64);

/// What became of the chains of lines.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize)]
pub struct ChainCounts {
    /// Edges of the mesh that follow lines; those that lines of several sets of a kind share count in the first.
    pub edges: u64,
    /// Segments of lines that have none, since they lie in no cell with four heights.
    pub off_ground: u64,
}

/// An edge of a chain, on the lattice of the raster.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlacedEdge {
    /// Places and heights, the lower place first.
    pub ends: [End; 2],
    /// The sets of lines that it is of.
    pub sets: SetBits,
    /// What it has to its left, as [`ChainEdge::inside`].
    pub inside: Option<bool>,
}

/// The edges of the chains of some tiles. Memory: some 80 bytes for each.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Chains {
    /// In order.
    edges: Vec<PlacedEdge>,
    /// All ends, each once, in order.
    ends: Vec<End>,
}

impl Chains {
    /// Edges of tiles, with the windows of these.
    pub fn new(tiles: impl IntoIterator<Item = (Window, Vec<ChainEdge>)>) -> Chains {
        let of_tile = |(window, edges): (Window, Vec<ChainEdge>)| {
            let global = move |v: Vertex| {
                let at = |local: i32, first: usize| i64::from(local) + first as i64 * i64::from(STEPS);
                (Place { y: at(v.at.y, window.row), x: at(v.at.x, window.column) }, v.height)
            };
            edges.into_iter().map(move |ChainEdge { edge, sets, inside }| (edge.map(global), sets, inside))
        };
        let sorted = |([a, b], sets, inside): ([End; 2], SetBits, Option<bool>)| match a.0 <= b.0 {
            true => PlacedEdge { ends: [a, b], sets, inside },
            false => PlacedEdge { ends: [b, a], sets, inside: inside.map(|is_left| !is_left) },
        };
        Chains::of(tiles.into_iter().flat_map(of_tile).map(sorted).collect())
    }

    /// These edges, in any order.
    pub fn of(mut edges: Vec<PlacedEdge>) -> Chains {
        edges.sort_unstable_by_key(|edge| edge.ends.map(|end| end.0));
        let mut ends: Vec<End> = edges.iter().flat_map(|edge| edge.ends).collect();
        ends.sort_unstable_by_key(|end| end.0);
        ends.dedup_by_key(|end| end.0);
        Chains { edges, ends }
    }

    /// The edges, by their lower ends, then by the others.
    pub fn edges(&self) -> &[PlacedEdge] {
        &self.edges
    }

    /// All ends of edges, each once: their places on the lattice of the raster, by rows, then by columns, and their heights.
    pub fn ends(&self) -> &[End] {
        &self.ends
    }
}

/// The edges of chains in a tile.
#[derive(Debug, Clone, Default)]
pub struct TileChains {
    /// Their ends, with places of the tile.
    edges: Vec<[Vertex; 2]>,
    /// Those of the mesh's border, with the mesh to the left.
    border: Vec<[Vertex; 2]>,
    /// Where the mesh is to be, if that is not all of the ground.
    inside: Option<Arc<Inside>>,
    /// All ends, those of edges beyond its sides among them, each once, by rows, then by columns.
    vertices: Vec<Vertex>,
}

impl TileChains {
    /// Replaces what is there by the edges that lie in a window, rim included, and by all of these `ends` that do, those of edges outside
    /// among them. Both are given in their order, and there may be more of them.
    pub(crate) fn fill(
        &mut self,
        window: Window,
        inside: Option<&Arc<Inside>>,
        edges: impl Iterator<Item = PlacedEdge>,
        ends: impl Iterator<Item = End>,
    ) {
        self.edges.clear();
        self.border.clear();
        self.vertices.clear();
        self.inside = inside.cloned();
        let steps = i64::from(STEPS);
        let range = |first: usize, count: usize| first as i64 * steps..=(first + count - 1) as i64 * steps;
        let (columns, rows) = (range(window.column, window.width), range(window.row, window.height));
        let is_in = |end: &End| columns.contains(&end.0.x) && rows.contains(&end.0.y);
        let local = |(place, height): End| Vertex {
            at: Point { x: (place.x - columns.start()) as i32, y: (place.y - rows.start()) as i32 },
            height,
        };
        for edge in edges.filter(|edge| edge.ends.iter().all(is_in)) {
            let [a, b] = edge.ends.map(local);
            self.edges.push([a, b]);
            self.border.extend(edge.inside.map(|is_left| if is_left { [a, b] } else { [b, a] }));
        }
        self.vertices.extend(ends.filter(is_in).map(local));
    }

    /// The edges.
    pub fn edges(&self) -> &[[Vertex; 2]] {
        &self.edges
    }

    /// The edges that are the mesh's border by a line's doing, with the mesh to the left ([`crate::base::lattice::orient`] > 0).
    pub(crate) fn border(&self) -> &[[Vertex; 2]] {
        &self.border
    }

    /// Where the mesh is to be, if that is not all of the ground.
    pub(crate) fn inside(&self) -> Option<&Inside> {
        self.inside.as_deref()
    }

    /// The ends of edges, those of edges beyond its sides among them, each once, by rows, then by columns.
    pub fn vertices(&self) -> &[Vertex] {
        &self.vertices
    }

    /// The end of an edge at a place.
    pub fn at(&self, at: Point) -> Option<Vertex> {
        self.find(at).ok().map(|i| self.vertices[i])
    }

    /// The edges as numbers of vertices, the lower first, in order: of those whose ends are both among these.
    pub fn numbered(&self, vertices: impl Iterator<Item = Vertex>) -> Vec<(u32, u32)> {
        if self.edges.is_empty() {
            return Vec::new();
        }
        let mut numbers = vec![u32::MAX; self.vertices.len()];
        for (number, vertex) in (0..).zip(vertices) {
            if let Ok(i) = self.find(vertex.at) {
                numbers[i] = number;
            }
        }
        let number = |v: &Vertex| numbers[self.find(v.at).expect("an end of an edge is one of all ends")];
        let both = self.edges.iter().map(|[a, b]| (number(a), number(b)));
        let known = both.filter(|&(a, b)| a != u32::MAX && b != u32::MAX);
        let mut edges: Vec<(u32, u32)> = known.map(|(a, b)| (a.min(b), a.max(b))).collect();
        edges.sort_unstable();
        edges
    }

    /// Adds all that a mesh depends on to a checksum; nothing where there are no ends of edges.
    pub(crate) fn hash(&self, hasher: &mut crc32fast::Hasher) {
        let edges = self.edges.iter().chain(&self.border).flatten();
        for Vertex { at, height } in edges.chain(&self.vertices) {
            hasher.update(bytemuck::cast_slice(&[at.x, at.y]));
            hasher.update(&height.to_ne_bytes());
        }
        let counts = [self.edges.len(), self.border.len()].map(|count| count as u64);
        if !self.vertices.is_empty() {
            hasher.update(bytemuck::cast_slice(&counts));
        }
    }

    fn find(&self, at: Point) -> Result<usize, usize> {
        self.vertices.binary_search_by_key(&(at.y, at.x), |v| (v.at.y, v.at.x))
    }
}
