//! The edges of chains in the order in which they follow each other along lines.

use super::Chains;
use crate::kernel::breaklines::graph::Graph;
use crate::kernel::breaklines::{Place, Segment};

impl Chains {
    /// The edges, each once, as numbers of ends: from where a line ends or several meet to where one does again, in the order of
    /// the places where they begin; then rings. Where one goes on from another it begins with the end that was the last.
    ///
    /// Memory while it works: some 100 bytes for each edge.
    pub fn along_lines(&self) -> Vec<[u32; 2]> {
        let mut segments: Vec<Segment> = self.edges.iter().map(|edge| edge.ends.map(|(place, _)| place)).collect();
        segments.dedup();
        let graph = Graph::new(&segments);
        let number = |place: &Place| self.number(*place).expect("an end of an edge is one of all ends") as u32;
        let mut edges = Vec::with_capacity(segments.len());
        graph.walk(
            |place| graph.beside(place).len() != 2,
            |way| edges.extend(way.windows(2).map(|pair| [number(&pair[0]), number(&pair[1])])),
        );
        edges
    }

    fn number(&self, place: Place) -> Option<usize> {
        self.ends.binary_search_by_key(&place, |end| end.0).ok()
    }
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
            edges.iter().map(|edge| ChainEdge { edge: edge.map(vertex), sets: 1, inside: None }).collect(),
        )])
    }

    fn places(chains: &Chains) -> Vec<[(i64, i64); 2]> {
        let place = |end: u32| {
            let (place, height) = chains.ends()[end as usize];
            assert_eq!(place.x as f64, height);
            (place.x, place.y)
        };
        chains.along_lines().into_iter().map(|edge| edge.map(place)).collect()
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
    }
}
