//! Taking vertices out where feasible triangles fill the hole (Lee 1989's drop heuristic, without its measure of
//! importance: raster order was the best of five).

use super::angles::Sharpest;
use super::filling::{Filler, Weigher};
use super::hole::Hole;
use super::judge::Judge;
use super::net::Net;
use super::order::{Errand, Order};
use crate::base::control::Cancelled;
use crate::base::lattice::distance2;
use crate::base::mesh::Vertex;

/// The dynamic program's table grows with the square of a ring, the triangles it looks at with the cube: longer rings
/// lose ears instead, and rings longer than this, which are found on flat ground only, are left alone.
const LONGEST_CLIPPED: usize = 256;

/// Visits between two looks at the cancellation token.
pub(super) const VISITS_BETWEEN_CHECKS: usize = 256;

/// The memory of removal.
#[derive(Debug, Default)]
pub(super) struct Removal {
    hole: Hole,
    ring: Vec<Vertex>,
    filler: Filler<()>,
    open: Vec<(u32, u32, u32)>,
}

impl Removal {
    /// Sweeps until nothing goes any more, at most `most` times. Rings longer than `longest` lose ears. Returns how many
    /// vertices went.
    pub(super) fn sweeps(
        &mut self,
        most: u32,
        longest: usize,
        net: &mut Net,
        order: &mut Order,
        judge: &mut Judge<'_>,
    ) -> Result<usize, Cancelled> {
        let mut gone = 0;
        for _ in 0..most {
            match self.sweep(longest, net, order, judge)? {
                0 => break,
                n => gone += n,
            }
        }
        Ok(gone)
    }

    /// Tries every vertex that is due, once, in raster order. A vertex is due when a triangle at it is new. Returns how
    /// many went.
    fn sweep(
        &mut self,
        longest: usize,
        net: &mut Net,
        order: &mut Order,
        judge: &mut Judge<'_>,
    ) -> Result<usize, Cancelled> {
        let mut gone = 0;
        for i in 0..order.raster.len() {
            if i % VISITS_BETWEEN_CHECKS == 0 {
                judge.cancel.check()?;
            }
            let v = order.raster[i];
            if net.is_free(v) && order.take_due(v, Errand::Remove) && self.remove(longest, net, v, judge) {
                self.hole.ring.iter().for_each(|&r| order.make_due(r));
                gone += 1;
            }
        }
        Ok(gone)
    }

    fn remove(&mut self, longest: usize, net: &mut Net, v: u32, judge: &mut Judge<'_>) -> bool {
        if !self.hole.around(net, v, LONGEST_CLIPPED) {
            return false;
        }
        judge.forget();
        self.ring.clear();
        self.ring.extend(self.hole.ring.iter().map(|&r| net.vertex(r)));
        let fills = self.ring.len() <= longest;
        let sharpest = judge.angles.bound(self.hole.corners(net));
        if fills && !judge.can_cover(net.vertex(v).at, &self.ring, sharpest) {
            return false;
        }
        let ring = self.ring.iter().copied();
        let mut weigher = ShortChords { judge, sharpest };
        let filled = if fills {
            self.filler.fill(ring, f64::INFINITY, &mut weigher).is_some()
        } else {
            self.filler.clip(ring, &mut weigher)
        };
        if !filled {
            return false;
        }
        net.refill(&self.hole, &self.filler.triangles, v, &mut self.open);
        net.drop_vertex(v);
        true
    }
}

/// Feasible triangles only; among those, short chords. What is minimised hardly matters for the number of triangles.
struct ShortChords<'a, 'b> {
    judge: &'a mut Judge<'b>,
    sharpest: Sharpest,
}

impl Weigher for ShortChords<'_, '_> {
    type Known = ();

    fn known(&self) {}

    fn triangle(&mut self, [a, b, c]: [Vertex; 3], budget: f64) -> f64 {
        let weight = distance2(a.at, c.at) as f64;
        // The scan is made only where it decides.
        let fits = weight < budget && self.sharpest.allows([a, b, c]) && self.judge.fits([a, b, c]);
        if fits { weight } else { f64::INFINITY }
    }

    fn chord(&mut self, p: Vertex, q: Vertex) -> bool {
        self.judge.may_join(p, q)
    }
}
