//! The edges of chains in the order in which they follow each other along lines.

use super::{Chains, PlacedEdge};
use crate::base::{LineEdge, LineType};
use crate::kernel::breaklines::graph::Graph;
use crate::kernel::breaklines::{Place, Segment, SetBits};

impl Chains {
    /// The edges, each once, as numbers of ends: from where a line ends or several meet to where one does again, in the order of
    /// the places where they begin; then rings. Where one goes on from another it begins with the end that was the last. An edge is
    /// soft where all its sets are among the `soft` ones.
    ///
    /// Memory while it works: some 100 bytes for each edge.
    pub fn along_lines(&self, soft: SetBits) -> Vec<LineEdge<u32>> {
        let of_edges = self.distinct();
        let segments: Vec<Segment> = of_edges.iter().map(|(segment, _)| *segment).collect();
        let graph = Graph::new(&segments);
        let number = |place: &Place| self.number(*place).expect("an end of an edge is one of all ends") as u32;
        let mut edges = Vec::with_capacity(segments.len());
        let edge = |pair: &[Place]| {
            let segment = [pair[0].min(pair[1]), pair[0].max(pair[1])];
            let found = of_edges.binary_search_by_key(&segment, |(segment, _)| *segment).expect("an edge on the way");
            LineEdge { ends: [number(&pair[0]), number(&pair[1])], line_type: type_of(of_edges[found].1, soft) }
        };
        graph.walk(|place| graph.beside(place).len() != 2, |way| edges.extend(way.windows(2).map(edge)));
        edges
    }

    /// The edges, each once, and the sets that it is of, in order.
    pub fn distinct(&self) -> Vec<(Segment, SetBits)> {
        let segment = |edge: &PlacedEdge| edge.ends.map(|(place, _)| place);
        let groups = self.edges.chunk_by(|a, b| segment(a) == segment(b));
        groups.map(|all| (segment(&all[0]), all.iter().fold(0, |bits, edge| bits | edge.sets))).collect()
    }

    fn number(&self, place: Place) -> Option<usize> {
        self.ends.binary_search_by_key(&place, |end| end.0).ok()
    }
}

/// The type of what these sets have in common: soft where all are among the `soft` ones.
pub(crate) fn type_of(sets: SetBits, soft: SetBits) -> LineType {
    if sets & !soft == 0 { LineType::Soft } else { LineType::Hard }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Window;
    use crate::base::lattice::Point;
    use crate::base::mesh::Vertex;
    use crate::kernel::breaklines::ChainEdge;

    fn chains(edges: &[[(i32, i32); 2]]) -> Chains {
        let vertex = |(x, y): (i32, i32)| Vertex { at: Point { x, y }, height: f64::from(x) };
        let window = Window { column: 0, row: 0, width: 9, height: 9 };
        Chains::new([(
            window,
            (0..)
                .zip(edges)
                .map(|(i, edge)| ChainEdge { edge: edge.map(vertex), sets: 1 << (i % 2), inside: None })
                .collect(),
        )])
    }

    fn places(chains: &Chains) -> Vec<[(i64, i64); 2]> {
        let place = |end: u32| {
            let (place, height) = chains.ends()[end as usize];
            assert_eq!(place.x as f64, height);
            (place.x, place.y)
        };
        chains.along_lines(0).into_iter().map(|edge| edge.map(place).ends).collect()
    }

    #[test]
    fn edges_follow_each_other_along_lines() {
        // A line over three edges, the first of which is there twice, a branch from its middle, and a ring.
        let line = [[(8, 4), (4, 0)], [(8, 4), (12, 4)], [(20, 5), (12, 4)], [(4, 0), (8, 4)]];
        let others = [[(12, 4), (12, 9)], [(1, 20), (5, 20)], [(5, 24), (5, 20)], [(5, 24), (1, 20)]];
        let found = places(&chains(&[&line[..], &others[..]].concat()));
        let expected = [
            [(4, 0), (8, 4)],
            [(8, 4), (12, 4)],
            [(12, 4), (20, 5)],
            [(12, 4), (12, 9)],
            [(1, 20), (5, 20)],
            [(5, 20), (5, 24)],
            [(5, 24), (1, 20)],
        ];
        assert_eq!(found, expected);
        assert!(places(&Chains::default()).is_empty());
        // Every other edge is of the second set; the edge of both is hard until both are soft.
        let all = chains(&[&line[..], &others[..]].concat());
        let soft = |sets| all.along_lines(sets).iter().map(|edge| edge.line_type == LineType::Soft).collect::<Vec<_>>();
        assert_eq!(soft(0b10), [false, true, false, false, true, false, true]);
        assert_eq!((soft(0), soft(0b11)), (vec![false; 7], vec![true; 7]));
    }
}
