//! Lakes: level water in hollows.

use super::hash::{hash, high, key, low};
use super::landscape::Landscape;
use super::noise::{Octave, fbm, floor, octaves, smoothstep};
use super::options::TerrainOptions;
use super::patch::{Patch, quantile};
use crate::base::Window;

/// Lakes, each at one level over its whole area.
///
/// Every cell of a coarse lattice holds one basin; a place belongs to its nearest basin and is lake where that basin
/// is nearer than the second nearest by more than a ratio of the basin's own. Shores are bent by noise. However large
/// the share of lakes, a rim of land is left between two of them, since their levels differ.
#[derive(Debug)]
pub(super) struct Lakes {
    key: u64,
    bend: [Vec<Octave>; 2],
    ratio: f64,
    relief_m: f64,
}

/// Samples from basin to basin.
const CELL: f64 = 260.0;
/// No lake reaches nearer to its neighbour than this ratio of squared distances.
const RIM: f64 = 0.93;
/// How far places are bent at most, in cells.
const BENT: f64 = 0.5;

#[derive(Debug, Clone, Copy)]
struct Basin {
    /// Place in cells.
    x: f64,
    y: f64,
    /// The basin's share of the ratio that makes the lake.
    size: f64,
    level_m: f64,
}

impl Lakes {
    /// `None` where there are none.
    pub(super) fn new(options: &TerrainOptions, landscape: &Landscape) -> Option<Lakes> {
        if options.lakes == 0.0 {
            return None;
        }
        let bend = [octaves(options.seed, 24, 130.0, 0.6, 4), octaves(options.seed, 25, 130.0, 0.6, 4)];
        let mut lakes = Lakes { key: key(options.seed, 23), bend, ratio: 0.0, relief_m: options.relief_m };
        lakes.ratio = quantile(options.seed, options.lakes, |x, y| {
            let (x, y) = (x / CELL + bent(&lakes.bend[0], x, y), y / CELL + bent(&lakes.bend[1], x, y));
            let ((i, j), ratio) = nearest(x, y, |i, j| lakes.place(i, j));
            if ratio < RIM { ratio / lakes.basin(i, j, landscape).size } else { f64::INFINITY }
        });
        Some(lakes)
    }

    pub(super) fn over(&self, window: Window, landscape: &Landscape) -> LakeRows {
        let bend = |i: usize| Patch::new(window, |x, y| bent(&self.bend[i], x, y));
        // Bending moves a place by half a cell at most, the nearest basins lie one cell around.
        let first = |at: usize| floor(at as f64 / CELL - BENT) - 1;
        let last = |at: usize| floor(at as f64 / CELL + BENT) + 1;
        let (left, top) = (first(window.column), first(window.row));
        let (right, bottom) = (last(window.column + window.width - 1), last(window.row + window.height - 1));
        let basins = (top..=bottom).flat_map(|j| (left..=right).map(move |i| (i, j)));
        let basins = basins.map(|(i, j)| self.basin(i, j, landscape)).collect();
        let across = (right - left + 1) as usize;
        LakeRows { ratio: self.ratio, column: window.column, left, top, across, basins, bend: [bend(0), bend(1)] }
    }

    /// A basin's place in cells: in the middle half of its cell.
    #[inline]
    fn place(&self, i: i64, j: i64) -> (f64, f64) {
        let h = hash(self.key, i, j);
        (i as f64 + 0.5 + 0.25 * high(h), j as f64 + 0.5 + 0.25 * low(h))
    }

    /// Few basins are large, and those in the mountains are small.
    fn basin(&self, i: i64, j: i64, landscape: &Landscape) -> Basin {
        let (x, y) = self.place(i, j);
        let form = landscape.at(x * CELL, y * CELL);
        let luck = 0.5 + 0.5 * high(hash(!self.key, i, j));
        let size = (0.03 + 0.97 * luck * luck * luck) * (1.0 - 0.85 * form.mountain);
        Basin { x, y, size, level_m: self.relief_m * form.height }
    }
}

/// How far a place is bent, in cells.
fn bent(octaves: &[Octave], x: f64, y: f64) -> f64 {
    (0.34 * fbm(octaves, 0.55, x, y)).clamp(-BENT, BENT)
}

/// The cell of the nearest basin of a place in cells, and how near it is: the ratio of the squared distances to it
/// and to the second nearest. Both are among the nine around, since basins keep to the middle of their cells.
#[inline]
fn nearest(x: f64, y: f64, place: impl Fn(i64, i64) -> (f64, f64)) -> ((i64, i64), f64) {
    let (cx, cy) = (floor(x), floor(y));
    let (mut first, mut second, mut cell) = (f64::INFINITY, f64::INFINITY, (cx, cy));
    for j in cy - 1..=cy + 1 {
        for i in cx - 1..=cx + 1 {
            let (px, py) = place(i, j);
            let d = (x - px) * (x - px) + (y - py) * (y - py);
            if d < first {
                (second, first, cell) = (first, d, (i, j));
            } else if d < second {
                second = d;
            }
        }
    }
    (cell, first / second)
}

/// The lakes of one window.
pub(super) struct LakeRows {
    ratio: f64,
    column: usize,
    left: i64,
    top: i64,
    across: usize,
    basins: Vec<Basin>,
    bend: [Patch; 2],
}

impl LakeRows {
    pub(super) fn apply(&mut self, row: usize, heights: &mut [f64]) {
        let [bend_x, bend_y] = &mut self.bend;
        let (bend_x, bend_y) = (bend_x.row(row), bend_y.row(row));
        let basin = |i: i64, j: i64| &self.basins[(j - self.top) as usize * self.across + (i - self.left) as usize];
        let y = row as f64 / CELL;
        for (k, h) in heights.iter_mut().enumerate() {
            let x = (self.column + k) as f64 / CELL;
            let ((i, j), ratio) = nearest(x + bend_x[k], y + bend_y[k], |i, j| (basin(i, j).x, basin(i, j).y));
            let Basin { size, level_m, .. } = *basin(i, j);
            let shore = (self.ratio * size).min(RIM);
            // The shore rises to the untouched ground before the next basin's land begins.
            let land = smoothstep(shore, (2.0 * shore).min(0.5 + 0.5 * shore), ratio);
            *h = level_m + (*h - level_m) * land;
        }
    }
}
