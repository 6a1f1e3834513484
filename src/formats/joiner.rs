//! Edges that go on from each other as lines, for formats that have lines.

/// Points of a line at the most: longer ones go on as another.
const MOST: usize = 1024;

/// Joins edges to lines as they come. Memory: one line.
#[derive(Debug, Default)]
pub(super) struct Joiner {
    points: Vec<[f64; 3]>,
}

impl Joiner {
    /// Takes the next edge. Where it does not go on from the one before it, gives the points of the line so far.
    pub(super) fn push(&mut self, [from, to]: [[f64; 3]; 2]) -> Option<Vec<[f64; 3]>> {
        let goes_on = self.points.last().is_some_and(|last| last.map(f64::to_bits) == from.map(f64::to_bits));
        let line = if goes_on && self.points.len() < MOST { None } else { self.finish() };
        if self.points.is_empty() {
            self.points.push(from);
        }
        self.points.push(to);
        line
    }

    /// The points of the last line, if there is one.
    pub(super) fn finish(&mut self) -> Option<Vec<[f64; 3]>> {
        Some(std::mem::take(&mut self.points)).filter(|points| !points.is_empty())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_become_lines_and_lines_the_same_edges() {
        let point = |x: usize| [x as f64, 0.0, -0.0];
        let long = (0..2 * MOST).map(|x| [point(x), point(x + 1)]);
        let edges: Vec<[[f64; 3]; 2]> = [[point(9), point(4)], [point(7), point(8)]].into_iter().chain(long).collect();
        let mut joiner = Joiner::default();
        let mut lines: Vec<Vec<[f64; 3]>> = edges.iter().filter_map(|edge| joiner.push(*edge)).collect();
        lines.extend(joiner.finish());
        assert!(joiner.finish().is_none());
        assert_eq!(lines.iter().map(Vec::len).collect::<Vec<_>>(), [2, 2, MOST, MOST, 3]);
        let again: Vec<[[f64; 3]; 2]> = lines.iter().flat_map(|line| line.windows(2).map(|w| [w[0], w[1]])).collect();
        assert_eq!(again, edges);
    }
}
