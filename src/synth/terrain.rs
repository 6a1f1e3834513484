//! The height at any place.

use super::erosion::Gullies;
use super::faults::Faults;
use super::gaps::Gaps;
use super::hash::{hash, high, key};
use super::lakes::Lakes;
use super::landscape::{Form, Landscape};
use super::noise::{Octave, fbm, octaves};
use super::options::{OptionError, TerrainOptions};
use super::spline::Lattice;
use crate::base::Window;

/// A ground without end: the height at every (column, row) from 0 on.
#[derive(Debug)]
pub struct Terrain {
    options: TerrainOptions,
    landscape: Landscape,
    gullies: Gullies,
    /// Waves without a direction between the large forms and the shortest ones.
    knolls: Vec<Octave>,
    detail_key: u64,
    faults: Option<Faults>,
    lakes: Option<Lakes>,
    gaps: Option<Gaps>,
}

/// Samples between the nodes of the large forms.
pub(super) const FORMS: usize = 16;
/// Samples between the nodes of the gullies.
const GULLIES: usize = 4;
/// Samples between the nodes of the shortest waves.
const DETAIL: usize = 2;
/// Form nodes between gully nodes.
const RATIO: usize = FORMS / GULLIES;
/// Gully nodes are counted from one form cell before the first sample, so that none is negative.
const LEAD: usize = RATIO;

/// Fields on the gully nodes of a window.
struct Ground {
    lattice: Lattice<GULLIES>,
    height: Vec<f64>,
    detail: Vec<f64>,
}

impl Terrain {
    /// # Errors
    /// [`OptionError`] when a number is out of its range.
    pub fn new(options: &TerrainOptions) -> Result<Terrain, OptionError> {
        options.check()?;
        let landscape = Landscape::new(options);
        Ok(Terrain {
            options: *options,
            lakes: Lakes::new(options, &landscape),
            landscape,
            gullies: Gullies::new(options.seed, options.relief_m),
            knolls: octaves(options.seed, 8, 44.0, 0.5, 2),
            detail_key: key(options.seed, 1),
            faults: Faults::new(options),
            gaps: Gaps::new(options.seed, options.nodata_share),
        })
    }

    /// The height of one sample in metres; NaN where there is none. A window costs far less per sample.
    pub fn height(&self, column: usize, row: usize) -> f64 {
        let mut out = [0.0];
        self.fill(Window { column, row, width: 1, height: 1 }, &mut out);
        out[0]
    }

    /// The heights of columns 0 to `out.len()` of one row; NaN where there is none.
    pub fn fill_row(&self, row: usize, out: &mut [f64]) {
        self.fill(Window { column: 0, row, width: out.len(), height: 1 }, out);
    }

    /// The heights of a window, rows one after the other; NaN where there is none. Every window gives a sample the
    /// same bits. Memory is a few times that of `out`; large windows are cheaper per sample than small ones.
    ///
    /// # Panics
    /// If `out` is not `window.len()` long.
    pub fn fill(&self, window: Window, out: &mut [f64]) {
        assert_eq!(out.len(), window.len(), "buffer of {window:?}");
        if window.is_empty() {
            return;
        }
        let Window { column, row, width, height } = window;
        let ground = self.ground(window);
        let fine = Lattice::<DETAIL>::covering(column, row, width, height);
        let waves: Vec<f64> = fine.nodes().map(|(i, j)| high(hash(self.detail_key, i, j))).collect();
        let (mut scratch, mut detail, mut wave) = (Vec::new(), vec![0.0; width], vec![0.0; width]);
        let mut faults = self.faults.as_ref().map(|f| f.over(window));
        let mut lakes = self.lakes.as_ref().map(|l| l.over(window, &self.landscape));
        let mut gaps = self.gaps.as_ref().map(|g| g.over(window));
        for (line, row) in out.chunks_exact_mut(width).zip(row..) {
            ground.lattice.row(&ground.height, column, row, &mut scratch, line);
            ground.lattice.row(&ground.detail, column, row, &mut scratch, &mut detail);
            fine.row(&waves, column, row, &mut scratch, &mut wave);
            for ((h, d), w) in line.iter_mut().zip(&detail).zip(&wave) {
                *h += d * w;
            }
            faults.iter_mut().for_each(|f| f.apply(row, line));
            lakes.iter_mut().for_each(|l| l.apply(row, line));
            gaps.iter_mut().for_each(|g| g.apply(row, line));
        }
    }

    /// Large forms, carried to the gully nodes, and the gullies cut into them.
    fn ground(&self, window: Window) -> Ground {
        let Window { column, row, width, height } = window;
        let lattice = Lattice::<GULLIES>::covering(column, row, width, height);
        // One node more on every side: slopes are differences of neighbours.
        let (left, top) = ((lattice.first_x - 1 + LEAD as i64) as usize, (lattice.first_y - 1 + LEAD as i64) as usize);
        let (across, down) = (lattice.across + 2, lattice.down + 2);
        let (forms, mountains) = self.forms(left, top, across, down);
        let relief = self.options.relief_m;
        let mut ground = Ground { lattice, height: Vec::new(), detail: Vec::new() };
        for (k, (i, j)) in lattice.nodes().enumerate() {
            let at = (k / lattice.across + 1) * across + k % lattice.across + 1;
            let step = 2.0 * GULLIES as f64;
            let slope = (
                relief * (forms[at + 1] - forms[at - 1]) / step,
                relief * (forms[at + across] - forms[at - across]) / step,
            );
            let (x, y) = ((i * GULLIES as i64) as f64, (j * GULLIES as i64) as f64);
            let depth = relief * (0.22 + mountains[at]) * 0.00028;
            let gain = 0.75 + 0.4 * self.options.roughness;
            let (cut, rest) = self.gullies.at(x, y, slope, depth, gain);
            let knolls = relief * (0.0010 + 0.0008 * mountains[at]) * fbm(&self.knolls, gain / 2.0, x, y);
            ground.height.push((relief * forms[at] + cut + knolls).max(-0.3 * relief));
            ground.detail.push((rest + 0.00005 * relief) * (0.5 + 5.0 * self.options.roughness));
        }
        ground
    }

    /// Heights and mountain shares on a rectangle of gully nodes, counted with [`LEAD`].
    fn forms(&self, left: usize, top: usize, across: usize, down: usize) -> (Vec<f64>, Vec<f64>) {
        let lattice = Lattice::<RATIO>::covering(left, top, across, down);
        let place = |i: i64| ((i - 1) * FORMS as i64) as f64;
        let nodes: Vec<Form> = lattice.nodes().map(|(i, j)| self.landscape.at(place(i), place(j))).collect();
        let spread = |field: Vec<f64>| {
            let (mut scratch, mut out) = (Vec::new(), vec![0.0; across * down]);
            for (line, row) in out.chunks_exact_mut(across).zip(top..) {
                lattice.row(&field, left, row, &mut scratch, line);
            }
            out
        };
        (spread(nodes.iter().map(|f| f.height).collect()), spread(nodes.iter().map(|f| f.mountain).collect()))
    }
}
