//! Edges that go on from each other as lines, for formats that have lines.

use crate::base::{LineEdge, LineType};

/// Points of a line at the most: longer ones go on as another.
const MOST: usize = 1024;

/// Joins edges to lines as they come. Memory: one line.
#[derive(Debug, Default)]
pub(super) struct Joiner {
    points: Vec<[f64; 3]>,
    line_type: LineType,
}

/// The points of a line, and its type.
pub(super) type Joined = (Vec<[f64; 3]>, LineType);

impl Joiner {
    /// Takes the next edge. Where it does not go on from the one before it, or is of another type, gives the line so far.
    pub(super) fn push(&mut self, LineEdge { ends: [from, to], line_type }: LineEdge<[f64; 3]>) -> Option<Joined> {
        let goes_on = self.points.last().is_some_and(|last| last.map(f64::to_bits) == from.map(f64::to_bits));
        let is_same = goes_on && line_type == self.line_type;
        let line = if is_same && self.points.len() < MOST { None } else { self.finish() };
        if self.points.is_empty() {
            self.points.push(from);
            self.line_type = line_type;
        }
        self.points.push(to);
        line
    }

    /// The last line, if there is one.
    pub(super) fn finish(&mut self) -> Option<Joined> {
        Some((std::mem::take(&mut self.points), self.line_type)).filter(|(points, _)| !points.is_empty())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_become_lines_and_lines_the_same_edges() {
        let point = |x: usize| [x as f64, 0.0, -0.0];
        let edge = |from, to, line_type| LineEdge { ends: [point(from), point(to)], line_type };
        let [hard, soft] = [LineType::Hard, LineType::Soft];
        let long = (0..2 * MOST).map(|x| edge(x, x + 1, hard));
        let few = [edge(9, 4, hard), edge(7, 8, hard), edge(8, 0, soft)];
        let edges: Vec<LineEdge<[f64; 3]>> = few.into_iter().chain(long).collect();
        let mut joiner = Joiner::default();
        let mut lines: Vec<Joined> = edges.iter().filter_map(|edge| joiner.push(*edge)).collect();
        lines.extend(joiner.finish());
        assert!(joiner.finish().is_none());
        let told: Vec<(usize, LineType)> = lines.iter().map(|(points, of)| (points.len(), *of)).collect();
        assert_eq!(told, [(2, hard), (2, hard), (2, soft), (MOST, hard), (MOST, hard), (3, hard)]);
        let edges_of = |(points, line_type): &Joined| {
            points.windows(2).map(|w| LineEdge { ends: [w[0], w[1]], line_type: *line_type }).collect::<Vec<_>>()
        };
        assert_eq!(lines.iter().flat_map(edges_of).collect::<Vec<_>>(), edges);
    }
}
