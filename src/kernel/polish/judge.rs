//! Whether a triangle may be used, with a memory of what spoke against its like.

use super::angles::{Angles, Sharpest};
use super::channels::weighted_at;
use super::energy::Meter;
use super::fitting::Fitting;
use super::net::Fit;
use crate::base::control::CancelToken;
use crate::base::lattice::{Point, orient};
use crate::base::mesh::Vertex;
use crate::kernel::triangulate::feasible::Tester;
use crate::kernel::triangulate::{Feasibility, Task};

/// How many samples are remembered. More find more, but every candidate is compared with each.
const WITNESSES: usize = 6;

/// How close to the tolerance a measured error may be wrong about it, as a share. (It may be so elsewhere, too, where
/// heights are large and the tolerance is small: what is kept is tested.)
pub(super) const DOUBT: f32 = 1e-4;

/// The exact test, preceded by samples that have spoken against other triangles of the same hole: most infeasible
/// candidates fall by one of them, without a scan.
pub(super) struct Judge<'a> {
    tester: Tester<'a>,
    pub(super) meter: Meter<'a>,
    pub(super) cancel: &'a CancelToken,
    /// How vertices are fitted that move; else they stand on samples.
    pub(super) fitting: Option<Fitting>,
    /// How sharp triangles may be.
    pub(super) angles: Angles,
    tolerance: f64,
    /// Place, height and limit.
    witnesses: [(Point, f64, f64); WITNESSES],
    known: usize,
    /// A triangle of this hole that fits, if one is known.
    fits: Option<[Vertex; 3]>,
}

impl<'a> Judge<'a> {
    pub(super) fn new(task: &Task<'a>) -> Judge<'a> {
        let tester = Tester::new(task.tile, task.tolerance, task.feasibility).with_max_stray(task.max_stray);
        let meter = Meter::new(tester, task.tolerance);
        let witnesses = [(Point { x: 0, y: 0 }, 0.0, 0.0); WITNESSES];
        let (cancel, tolerance) = (task.cancel, task.tolerance);
        let (fitting, angles) = (None, Angles::ANY);
        Judge { tester, meter, cancel, fitting, angles, tolerance, witnesses, known: 0, fits: None }
    }

    pub(super) fn tolerance(&self) -> f64 {
        self.tolerance
    }

    /// Forgets what is known of a hole: another one follows.
    pub(super) fn forget(&mut self) {
        (self.known, self.fits) = (0, None);
    }

    /// Whether every sample under the triangle is within the tolerance. Never yes where the exact test says no.
    pub(super) fn fits(&mut self, corners: [Vertex; 3]) -> bool {
        if let Some(i) = (0..self.known).find(|&i| self.speaks_against(i, corners)) {
            // What spoke last will be asked first.
            self.witnesses[..=i].rotate_right(1);
            return false;
        }
        if self.fits == Some(corners) {
            return true;
        }
        let Some(place) = self.tester.violation(corners) else { return true };
        self.call(place);
        false
    }

    /// Whether some triangle between three vertices of a ring may be used that covers a sample inside it: if none may, nothing
    /// fills the ring. The sample becomes a witness.
    pub(super) fn can_cover(&mut self, place: Point, ring: &[Vertex], sharpest: Sharpest) -> bool {
        if place.sample().is_none() {
            return true;
        }
        self.call(place);
        for (i, &a) in ring.iter().enumerate() {
            for (j, &b) in ring.iter().enumerate().skip(i + 1) {
                let left = orient(a.at, b.at, place);
                if left < 0 {
                    continue;
                }
                for &c in &ring[j + 1..] {
                    let others = [orient(b.at, c.at, place), orient(c.at, a.at, place)];
                    let covers = others.iter().all(|&side| side >= 0) && left + others[0] + others[1] > 0;
                    if covers && sharpest.allows([a, b, c]) && self.fits([a, b, c]) {
                        self.fits = Some([a, b, c]);
                        return true;
                    }
                }
            }
        }
        false
    }

    /// Makes a sample a witness, the first to be asked.
    fn call(&mut self, place: Point) {
        let (column, row) = place.sample().expect("witnesses are samples");
        self.known = (self.known + 1).min(WITNESSES);
        self.witnesses[..self.known].rotate_right(1);
        let tile = self.tester.tile();
        // Refusing a triangle that is feasible by a rounding costs nothing that was promised; still, leave ties alone.
        let limit = tile.limit(column, row, self.tolerance) * (1.0 + 1e-9);
        self.witnesses[0] = (place, tile.at(column, row), limit);
    }

    /// The exact test alone.
    pub(super) fn feasible(&self, corners: [Vertex; 3]) -> bool {
        self.tester.weakly_feasible(corners)
    }

    /// Makes a measured fit say the truth about the tolerance: its worst error is at most 1 if the triangle, and where
    /// that is asked for its edges, are within it, and more if not. Only near ties are tested.
    pub(super) fn settle(&self, corners: [Vertex; 3], fit: Fit) -> Fit {
        if (fit.worst - 1.0).abs() > DOUBT {
            return fit;
        }
        let [a, b, c] = corners;
        let is_weak = self.tester.feasibility() == Feasibility::Weak;
        let edges = [(a, b), (b, c), (c, a)];
        let within = self.feasible(corners) && (is_weak || edges.iter().all(|&(p, q)| self.tester.strong_edge(p, q)));
        let worst = if within { fit.worst.min(1.0) } else { fit.worst.max(1.0 + DOUBT) };
        Fit { worst, ..fit }
    }

    fn speaks_against(&self, i: usize, [a, b, c]: [Vertex; 3]) -> bool {
        let (p, height, limit) = self.witnesses[i];
        let weights = [orient(b.at, c.at, p), orient(c.at, a.at, p), orient(a.at, b.at, p)];
        if weights.iter().any(|&w| w < 0) {
            return false;
        }
        let [wa, wb, wc] = weights.map(|w| w as f64);
        let error = wa * (a.height - height) + wb * (b.height - height) + wc * (c.height - height);
        if error.abs() > (wa + wb + wc) * limit {
            return true;
        }
        // Samples that have channels have the same limit everywhere.
        let (tile, sample) = (self.tester.tile(), p.sample().expect("witnesses are samples"));
        tile.channel_error.as_ref().is_some_and(|error| {
            weighted_at(tile, error, sample.1 * tile.width + sample.0, [a, b, c], [wa, wb, wc]) > limit
        })
    }

    /// Whether an edge that was not there before may be made: see [`Tester::may_join`].
    pub(super) fn may_join(&self, p: Vertex, q: Vertex) -> bool {
        self.tester.may_join(p, q)
    }
}
