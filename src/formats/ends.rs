//! Which vertices edges end at, for formats that have lines by places.

use std::path::Path;

use super::{EdgeVisitor, ReadError};
use crate::base::external::{Scratch, ScratchError, Sorter};
use crate::base::{LineEdge, LineType};

/// Bytes of each of the two sorts.
const SORT_BYTES: usize = 16 << 20;

/// In the place of a vertex where there is none.
const NONE: u64 = u64::MAX;

/// Takes vertices and ends of edges, by their places, and finds the vertex at every end: the first at the same place, bit for bit.
///
/// Memory: two sorts of 16 MiB. Temporary files: at most 80 bytes for each vertex and 100 for each end.
pub(super) struct Ends<'s> {
    scratch: &'s Scratch,
    /// Places, whether it is an end, and its number; for an end twice that, and 1 where its edge is soft.
    places: Sorter<'s, 5>,
    ends: u64,
}

impl<'s> Ends<'s> {
    pub(super) fn new(scratch: &'s Scratch) -> Ends<'s> {
        Ends { scratch, places: Sorter::new(scratch, SORT_BYTES), ends: 0 }
    }

    /// A vertex.
    pub(super) fn vertex(&mut self, number: u64, place: [f64; 3]) -> Result<(), ScratchError> {
        let [x, y, z] = place.map(f64::to_bits);
        self.places.push([x, y, z, 0, number])
    }

    /// The next points of a line of a type: every two that follow each other are an edge.
    pub(super) fn line(&mut self, points: &[[f64; 3]], line_type: LineType) -> Result<(), ScratchError> {
        let soft = u64::from(line_type == LineType::Soft);
        for place in points.windows(2).flatten() {
            let [x, y, z] = place.map(f64::to_bits);
            self.places.push([x, y, z, 1, self.ends << 1 | soft])?;
            self.ends += 1;
        }
        Ok(())
    }

    /// Hands every edge to `visit`, in the order in which they came, until it breaks. `path` is the mesh, for errors.
    pub(super) fn visit(self, path: &Path, visit: &mut EdgeVisitor<'_>) -> Result<(), ReadError> {
        let mut vertices = Sorter::<2>::new(self.scratch, SORT_BYTES);
        let mut last: Option<([u64; 3], u64)> = None;
        for record in self.places.finish()? {
            let [x, y, z, is_end, number] = record?;
            let found = last.filter(|(place, _)| *place == [x, y, z]);
            match (is_end, found) {
                (0, None) => last = Some(([x, y, z], number)),
                (0, Some(_)) => {}
                (_, found) => vertices.push([number, found.map_or(NONE, |(_, vertex)| vertex)])?,
            }
        }
        let mut vertices = vertices.finish()?;
        let mut edge = 0;
        while let (Some(from), Some(to)) = (vertices.next(), vertices.next()) {
            let ([number, from], [_, to]) = (from?, to?);
            if from == NONE || to == NONE {
                return Err(ReadError::EdgeEnd { path: path.to_path_buf(), edge, found: "place" });
            }
            let line_type = if number & 1 == 0 { LineType::Hard } else { LineType::Soft };
            if visit(edge, LineEdge { ends: [from, to], line_type }).is_break() {
                return Ok(());
            }
            edge += 1;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use super::*;

    #[test]
    fn ends_are_the_first_vertices_at_their_places() {
        let scratch = Scratch::new(None, Default::default());
        let of = |lines: &[&[[f64; 3]]]| {
            let mut ends = Ends::new(&scratch);
            for (number, x) in (0..).zip([5.0, 0.0, 3.0, -0.0, 3.0]) {
                ends.vertex(number, [x, 1.0, 2.0]).expect("taken");
            }
            let types = [LineType::Hard, LineType::Soft];
            lines.iter().zip(types).try_for_each(|(line, line_type)| ends.line(line, line_type)).expect("taken");
            let mut found = Vec::new();
            let visited = ends.visit(Path::new("tin"), &mut |index, edge| {
                assert_eq!(index, found.len() as u64);
                found.push(edge);
                ControlFlow::Continue(())
            });
            visited.map(|()| found)
        };
        let [five, zero, three, less] = [5.0, 0.0, 3.0, -0.0].map(|x: f64| [x, 1.0, 2.0]);
        let found = of(&[&[three, five, less], &[zero, three]]).expect("vertices");
        let edge = |ends, line_type| LineEdge { ends, line_type };
        let [hard, soft] = [LineType::Hard, LineType::Soft];
        assert_eq!(found, [edge([2, 0], hard), edge([0, 3], hard), edge([1, 2], soft)]);
        assert!(of(&[]).expect("none").is_empty());
        let error = of(&[&[three, five], &[zero, [3.0, 1.0, 2.5]]]).expect_err("no vertex").to_string();
        assert_eq!(error, "tin: edge 1: expected two vertices, found another place");
    }
}
