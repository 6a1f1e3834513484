//! The chains of all lines of a raster, by place.

mod along;

use std::sync::Arc;

use super::{ChainEdge, Inside, Place, SetBits};
use crate::base::Window;
use crate::base::lattice::{Point, STEPS};
use crate::base::mesh::Vertex;

/// An end of an edge, on the lattice of the raster.
type End = (Place, f64);

/// What became of the chains of lines.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize)]
pub struct ChainCounts {
    /// Edges of the mesh that follow lines.
    pub edges: u64,
    /// Segments of lines that have none, since they lie in no cell with four heights.
    pub off_ground: u64,
}

/// The edges of all chains. Memory: some 80 bytes for each.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Chains {
    /// In order, the lower end of each first.
    edges: Vec<[End; 2]>,
    /// What each has to its left, as [`ChainEdge::inside`]; none where no line is the mesh's border.
    insides: Vec<Option<bool>>,
    /// Where the mesh is to be, if that is not all of the ground.
    inside: Option<Arc<Inside>>,
    /// All ends, each once, in order.
    ends: Vec<End>,
    /// For each set of lines.
    counts: Vec<ChainCounts>,
}

impl Chains {
    /// Edges of tiles, with the windows of these; `off_ground` is how many segments of each set of lines were left out.
    pub fn new(tiles: impl IntoIterator<Item = (Window, Vec<ChainEdge>)>, off_ground: Vec<u64>) -> Chains {
        let of_tile = |(window, edges): (Window, Vec<ChainEdge>)| {
            let global = move |v: Vertex| {
                let at = |local: i32, first: usize| i64::from(local) + first as i64 * i64::from(STEPS);
                (Place { y: at(v.at.y, window.row), x: at(v.at.x, window.column) }, v.height)
            };
            edges.into_iter().map(move |ChainEdge { edge, sets, inside }| (edge.map(global), sets, inside))
        };
        let sorted = |([a, b], sets, inside): ([End; 2], SetBits, Option<bool>)| match a.0 <= b.0 {
            true => ([a, b], sets, inside),
            false => ([b, a], sets, inside.map(|is_left| !is_left)),
        };
        let mut found: Vec<_> = tiles.into_iter().flat_map(of_tile).map(sorted).collect();
        let count = |(number, off_ground): (usize, u64)| {
            let edges = found.iter().filter(|(_, sets, _)| sets & 1 << number != 0).count() as u64;
            ChainCounts { edges, off_ground }
        };
        let counts = off_ground.into_iter().enumerate().map(count).collect();
        found.sort_unstable_by_key(|(edge, _, _)| edge.map(|end| end.0));
        let edges: Vec<[End; 2]> = found.iter().map(|(edge, _, _)| *edge).collect();
        let is_border = found.iter().any(|(_, _, inside)| inside.is_some());
        let insides = found.into_iter().filter(|_| is_border).map(|(_, _, inside)| inside).collect();
        let mut ends: Vec<End> = edges.as_flattened().to_vec();
        ends.sort_unstable_by_key(|end| end.0);
        ends.dedup_by_key(|end| end.0);
        Chains { edges, insides, inside: None, ends, counts }
    }

    /// The same where the mesh is to end with this inside.
    pub(crate) fn within_outlines(self, inside: Option<Arc<Inside>>) -> Chains {
        Chains { inside, ..self }
    }

    /// How many edges each set of lines has, and what of it has none. An edge may be of several.
    pub fn counts(&self) -> &[ChainCounts] {
        &self.counts
    }

    /// The edges that lie in a window, rim included, and all ends of edges that do, those of edges outside among them. Replaces what is
    /// in `found`.
    pub fn within(&self, window: Window, found: &mut TileChains) {
        found.edges.clear();
        found.border.clear();
        found.vertices.clear();
        found.inside.clone_from(&self.inside);
        let steps = i64::from(STEPS);
        let range = |first: usize, count: usize| first as i64 * steps..=(first + count - 1) as i64 * steps;
        let (columns, rows) = (range(window.column, window.width), range(window.row, window.height));
        let is_above = |low: Place| low.y < *rows.start();
        let first = self.edges.partition_point(|[low, _]| is_above(low.0));
        let edges = &self.edges[first..];
        let ends = &self.ends[self.ends.partition_point(|end| is_above(end.0))..];
        let local = |(place, height): End| Vertex {
            at: Point { x: (place.x - columns.start()) as i32, y: (place.y - rows.start()) as i32 },
            height,
        };
        let is_in = |end: &End| columns.contains(&end.0.x) && rows.contains(&end.0.y);
        let edges = edges.iter().take_while(|[low, _]| low.0.y <= *rows.end());
        let is_whole = |edge: &&[End; 2]| edge.iter().all(is_in);
        found.edges.extend(edges.clone().filter(is_whole).map(|edge| edge.map(local)));
        let insides = self.insides.get(first..).unwrap_or_default();
        found.border.extend(edges.zip(insides).filter(|(edge, _)| is_whole(edge)).filter_map(|(edge, inside)| {
            let [a, b] = edge.map(local);
            inside.map(|is_left| if is_left { [a, b] } else { [b, a] })
        }));
        let ends = ends.iter().take_while(|end| end.0.y <= *rows.end());
        found.vertices.extend(ends.filter(|end| is_in(end)).map(|&end| local(end)));
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

    fn find(&self, at: Point) -> Result<usize, usize> {
        self.vertices.binary_search_by_key(&(at.y, at.x), |v| (v.at.y, v.at.x))
    }
}
