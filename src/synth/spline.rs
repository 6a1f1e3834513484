//! Fields known on a coarse lattice, carried to every sample by uniform cubic B-splines.
//!
//! Everything longer than a few samples is computed on nodes [`SPACING`] samples apart, which is what makes rich
//! landforms affordable. The spline is twice continuously differentiable and nearly round, so the lattice cannot be
//! seen. Nodes lie at multiples of the spacing of the whole terrain, never of the window, and each sample takes the
//! same sixteen nodes in the same order: windows agree bit for bit.

/// The weights of the four nodes around a sample, by its distance from the second of them.
const fn weights<const N: usize>() -> [[f64; 4]; N] {
    let mut table = [[0.0; 4]; N];
    let mut phase = 0;
    while phase < N {
        let t = phase as f64 / N as f64;
        let s = 1.0 - t;
        table[phase] = [
            s * s * s / 6.0,
            (3.0 * t * t * t - 6.0 * t * t + 4.0) / 6.0,
            (3.0 * s * s * s - 6.0 * s * s + 4.0) / 6.0,
            t * t * t / 6.0,
        ];
        phase += 1;
    }
    table
}

/// The nodes that a window of samples needs, `STEP` samples apart.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lattice<const STEP: usize> {
    /// Index of the first node across.
    pub(super) first_x: i64,
    /// Index of the first node down.
    pub(super) first_y: i64,
    /// Nodes across.
    pub(super) across: usize,
    /// Nodes down.
    pub(super) down: usize,
}

impl<const STEP: usize> Lattice<STEP> {
    const WEIGHTS: [[f64; 4]; STEP] = weights::<STEP>();

    pub(super) fn covering(column: usize, row: usize, width: usize, height: usize) -> Self {
        let across = (column + width - 1) / STEP - column / STEP + 4;
        let down = (row + height - 1) / STEP - row / STEP + 4;
        Lattice { first_x: (column / STEP) as i64 - 1, first_y: (row / STEP) as i64 - 1, across, down }
    }

    /// Node indices, row by row.
    pub(super) fn nodes(&self) -> impl Iterator<Item = (i64, i64)> + '_ {
        let across = self.across as i64;
        (0..self.down as i64).flat_map(move |j| (0..across).map(move |i| (self.first_x + i, self.first_y + j)))
    }

    /// The field on sample row `row`, from sample `column` on. `scratch` holds one row of nodes.
    pub(super) fn row(&self, field: &[f64], column: usize, row: usize, scratch: &mut Vec<f64>, out: &mut [f64]) {
        let top = ((row / STEP) as i64 - 1 - self.first_y) as usize * self.across;
        let w = Self::WEIGHTS[row % STEP];
        let line = |k: usize| &field[top + k * self.across..top + (k + 1) * self.across];
        let (a, b, c, d) = (line(0), line(1), line(2), line(3));
        scratch.clear();
        scratch.extend((0..self.across).map(|i| w[0] * a[i] + w[1] * b[i] + w[2] * c[i] + w[3] * d[i]));
        let lead = ((STEP - column % STEP) % STEP).min(out.len());
        let (head, body) = out.split_at_mut(lead);
        for (k, o) in head.iter_mut().enumerate() {
            *o = blend(&scratch[..4], &Self::WEIGHTS[column % STEP + k]);
        }
        let nodes = if lead > 0 { &scratch[1..] } else { &scratch[..] };
        let (cells, tail) = body.as_chunks_mut::<STEP>();
        for (cell, four) in cells.iter_mut().zip(nodes.windows(4)) {
            for (o, w) in cell.iter_mut().zip(&Self::WEIGHTS) {
                *o = blend(four, w);
            }
        }
        let rest = &nodes[cells.len()..];
        for (o, w) in tail.iter_mut().zip(&Self::WEIGHTS) {
            *o = blend(&rest[..4], w);
        }
    }
}

#[inline(always)]
fn blend(nodes: &[f64], w: &[f64; 4]) -> f64 {
    w[0] * nodes[0] + w[1] * nodes[1] + w[2] * nodes[2] + w[3] * nodes[3]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The definition, sample by sample.
    fn naive(value: impl Fn(i64, i64) -> f64, column: usize, row: usize) -> f64 {
        let (wx, wy) = (Lattice::<4>::WEIGHTS[column % 4], Lattice::<4>::WEIGHTS[row % 4]);
        let column_of = |i: usize| {
            let node = |j: usize| value((column / 4 + i) as i64 - 1, (row / 4 + j) as i64 - 1);
            wy[0] * node(0) + wy[1] * node(1) + wy[2] * node(2) + wy[3] * node(3)
        };
        blend(&[column_of(0), column_of(1), column_of(2), column_of(3)], &wx)
    }

    #[test]
    fn rows_agree_with_the_definition_wherever_the_window_begins() {
        let value = |i: i64, j: i64| super::super::hash::high(super::super::hash::hash(7, i, j));
        for (column, width) in [(0, 9), (1, 1), (1, 2), (2, 1), (3, 17), (5, 3), (6, 2), (7, 8), (1003, 4)] {
            let lattice = Lattice::<4>::covering(column, 5, width, 6);
            let field: Vec<f64> = lattice.nodes().map(|(i, j)| value(i, j)).collect();
            let mut out = vec![0.0; width];
            for row in 5..11 {
                lattice.row(&field, column, row, &mut Vec::new(), &mut out);
                for (k, &found) in out.iter().enumerate() {
                    assert_eq!(found, naive(value, column + k, row), "column {} row {row}", column + k);
                }
            }
        }
    }
}
