//! A smooth field over one window, and the thresholds that give a field's share of the area.

use super::hash::{hash, high, key, low};
use super::spline::Lattice;
use super::terrain::FORMS;
use crate::base::Window;

/// A field of long waves, computed on the nodes around a window and read row by row.
pub(super) struct Patch {
    lattice: Lattice<FORMS>,
    column: usize,
    nodes: Vec<f64>,
    scratch: Vec<f64>,
    line: Vec<f64>,
}

impl Patch {
    /// `field` takes a place in samples.
    pub(super) fn new(window: Window, field: impl Fn(f64, f64) -> f64) -> Patch {
        let lattice = Lattice::covering(window.column, window.row, window.width, window.height);
        let place = |i: i64| (i * FORMS as i64) as f64;
        let nodes = lattice.nodes().map(|(i, j)| field(place(i), place(j))).collect();
        Patch { lattice, column: window.column, nodes, scratch: Vec::new(), line: vec![0.0; window.width] }
    }

    /// The field along one row of the window.
    pub(super) fn row(&mut self, row: usize) -> &[f64] {
        self.lattice.row(&self.nodes, self.column, row, &mut self.scratch, &mut self.line);
        &self.line
    }
}

/// The value that a field stays below on `share` of the area, from a fixed sample of places far and wide.
pub(super) fn quantile(seed: u64, share: f64, field: impl Fn(f64, f64) -> f64) -> f64 {
    const PLACES: usize = 1 << 14;
    const EXTENT: f64 = 1e7;
    let key = key(seed, 77);
    let mut values: Vec<f64> = (0..PLACES as i64)
        .map(|i| {
            let h = hash(key, i, 0);
            field(EXTENT * high(h), EXTENT * low(h))
        })
        .collect();
    values.sort_unstable_by(f64::total_cmp);
    values[((share * PLACES as f64) as usize).min(PLACES - 1)]
}
