//! Whether one line or one plane is within the tolerance of some samples. Where none is, two to four of the samples prove it,
//! and that is looked at exactly; what rounding leaves open counts as within, which can only make a lower bound smaller.

use terrabite::base::Tile;
use terrabite::base::exact::within;
use terrabite::kernel::triangulate::hitting_set::excludes_planes;

/// Column and row.
pub(crate) type At = (i32, i32);

/// The samples of a tile, none missing, and the tolerance.
#[derive(Clone, Copy)]
pub(crate) struct Samples<'a> {
    pub(crate) tile: &'a Tile,
    pub(crate) tolerance: f64,
}

/// Twice the area of the triangle `a`, `b`, `c`, positive on one side of ab.
pub(crate) fn orient(a: At, b: At, c: At) -> i64 {
    let (ux, uy, vx, vy) = (b.0 - a.0, b.1 - a.1, c.0 - a.0, c.1 - a.1);
    i64::from(ux) * i64::from(vy) - i64::from(uy) * i64::from(vx)
}

pub(crate) fn gcd(a: i32, b: i32) -> i32 {
    if b == 0 { a.abs() } else { gcd(b, a % b) }
}

impl Samples<'_> {
    pub(crate) fn height(&self, (column, row): At) -> f64 {
        self.tile.at(column as usize, row as usize)
    }

    /// Three of the samples on the segment pq that no line is within the tolerance of, or none.
    pub(crate) fn bend(&self, p: At, q: At) -> Option<[At; 3]> {
        let n = gcd(q.0 - p.0, q.1 - p.1);
        let at = |i: i32| (p.0 + (q.0 - p.0) / n * i, p.1 + (q.1 - p.1) / n * i);
        // Most pairs that have a bend are found out by their middle.
        if n > 1 && self.bends([p, at(n / 2), q], [0, n / 2, n]) {
            return Some([p, at(n / 2), q]);
        }
        let heights: Vec<f64> = (0..=n).map(|i| self.height(at(i))).collect();
        [1.0, -1.0].into_iter().find_map(|sign| {
            let [i, j, k] = farthest_above(&heights, sign)?;
            let found = [i, j, k].map(|i| at(i as i32));
            self.bends(found, [i, j, k].map(|i| i as i32)).then_some(found)
        })
    }

    /// Whether no line is within the tolerance of three samples, which follow one another at these places of a line.
    fn bends(&self, samples: [At; 3], [i, j, k]: [i32; 3]) -> bool {
        let [a, b, c] = samples.map(|s| self.height(s));
        let terms = [(i64::from(k - j), a), (i64::from(i - k), b), (i64::from(j - i), c)];
        !within(&terms, 2 * i64::from(k - i), self.tolerance)
    }

    /// Whether four samples prove that no plane is within the tolerance of them, exactly.
    pub(crate) fn refute(&self, samples: [At; 4]) -> bool {
        let certificate = samples.map(|(column, row)| (column as usize, row as usize));
        excludes_planes(self.tile, self.tolerance, &certificate)
    }

    /// Four of these samples that no plane is within the tolerance of, or none. The first three are not on one line.
    ///
    /// The plane of least maximum error, by the simplex method on its dual: four samples and signs, whose plane is off by
    /// the same at all of them; the sample that is farthest from it comes in, and one goes out. It ends as soon as the plane
    /// is within the tolerance, or its four samples prove that none is.
    pub(crate) fn warp(&self, samples: &[At]) -> Option<[At; 4]> {
        let &[a, b, c, d, ..] = samples else { return None };
        let weights = [orient(b, c, d), -orient(a, c, d), orient(a, b, d), -orient(a, b, c)];
        let mut basis = [0, 1, 2, 3].map(|i| (i, if weights[i] < 0 { -1.0 } else { 1.0 }));
        let column = |(i, sign): (usize, f64)| {
            [sign, sign * f64::from(samples[i].0 - a.0), sign * f64::from(samples[i].1 - a.1), 1.0]
        };
        let base = self.height(a);
        let height = |i: usize| self.height(samples[i]) - base;
        let mut inverse = inverted(basis.map(column))?;
        for _ in 0..MOST_EXCHANGES {
            // Prices: the plane's three numbers, and by how much it is off at the four samples.
            let mut price = [0.0; 4];
            for (row, (i, sign)) in inverse.iter().zip(basis) {
                for (p, x) in price.iter_mut().zip(row) {
                    *p += sign * height(i) * x;
                }
            }
            if price[3] > self.tolerance && self.refute(basis.map(|(i, _)| samples[i])) {
                return Some(basis.map(|(i, _)| samples[i]));
            }
            let residual = |i: usize| {
                let (x, y) = (f64::from(samples[i].0 - a.0), f64::from(samples[i].1 - a.1));
                height(i) - (price[0] + price[1] * x + price[2] * y)
            };
            let (mut farthest, mut most) = (0, 0.0f64);
            for i in 0..samples.len() {
                let off = residual(i);
                if off.abs() > most.abs() {
                    (farthest, most) = (i, off);
                }
            }
            if most.abs() <= self.tolerance || most.abs() <= price[3] {
                return None;
            }
            let entering = (farthest, most.signum());
            let moves = inverse.map(|row| row.iter().zip(column(entering)).map(|(x, y)| x * y).sum::<f64>());
            let ratio = |i: usize| if moves[i] > 1e-9 { inverse[i][3] / moves[i] } else { f64::INFINITY };
            let out = (0..4).min_by(|&i, &j| ratio(i).total_cmp(&ratio(j)))?;
            if ratio(out).is_infinite() {
                return None;
            }
            let pivot = inverse[out].map(|x| x / moves[out]);
            for i in 0..4 {
                inverse[i] = if i == out { pivot } else { subtracted(inverse[i], moves[i], pivot) };
            }
            basis[out] = entering;
        }
        None
    }
}

/// Where so many exchanges have not decided, the plane counts as within the tolerance.
const MOST_EXCHANGES: usize = 100;

fn subtracted(row: [f64; 4], factor: f64, other: [f64; 4]) -> [f64; 4] {
    [0, 1, 2, 3].map(|i| row[i] - factor * other[i])
}

/// The inverse of the matrix with these columns.
fn inverted(columns: [[f64; 4]; 4]) -> Option<[[f64; 4]; 4]> {
    let mut rows = [0, 1, 2, 3].map(|r| [0, 1, 2, 3].map(|c| columns[c][r]));
    let mut inverse = [0, 1, 2, 3].map(|r| [0, 1, 2, 3].map(|c| if r == c { 1.0 } else { 0.0 }));
    for c in 0..4 {
        let pivot = (c..4).max_by(|&i, &j| rows[i][c].abs().total_cmp(&rows[j][c].abs()))?;
        rows.swap(c, pivot);
        inverse.swap(c, pivot);
        let by = rows[c][c];
        if by.abs() < 1e-9 {
            return None;
        }
        (rows[c], inverse[c]) = (rows[c].map(|x| x / by), inverse[c].map(|x| x / by));
        for r in (0..4).filter(|&r| r != c) {
            let factor = rows[r][c];
            (rows[r], inverse[r]) = (subtracted(rows[r], factor, rows[c]), subtracted(inverse[r], factor, inverse[c]));
        }
    }
    Some(inverse)
}

/// Of numbers in a row, that one which is farthest above the lower convex hull of all of them (below the upper one where
/// `sign` is −1), between the two of the hull that it is held against.
fn farthest_above(heights: &[f64], sign: f64) -> Option<[usize; 3]> {
    let at = |i: usize| sign * heights[i];
    let mut hull: Vec<usize> = Vec::new();
    for k in 0..heights.len() {
        while let [.., i, j] = hull[..] {
            if (at(j) - at(i)) * ((k - i) as f64) < (at(k) - at(i)) * ((j - i) as f64) {
                break;
            }
            hull.pop();
        }
        hull.push(k);
    }
    let between = hull.windows(2).flat_map(|w| (w[0] + 1..w[1]).map(|j| [w[0], j, w[1]]));
    let above = |&[i, j, k]: &[usize; 3]| at(j) - at(i) - (at(k) - at(i)) * (j - i) as f64 / (k - i) as f64;
    between.max_by(|a, b| above(a).total_cmp(&above(b)))
}
