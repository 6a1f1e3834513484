//! A vertex beside the raster's rim goes onto it.
//!
//! Weakly feasible slivers cost nothing and can be seen. In a raster of one tile many stand along its rim, which is as it was
//! made until the second pass frees it. The move saves a triangle and keeps the exact test.

use super::hole::Hole;
use super::improve::LONGEST_RING;
use super::judge::Judge;
use super::net::{Fit, NONE, Net};
use super::order::Order;
use super::removal::VISITS_BETWEEN_CHECKS;
use crate::base::control::Cancelled;
use crate::base::lattice::{Point, STEPS, orient};
use crate::base::mesh::Vertex;

/// Places tried on the rim: where the vertex is opposite, and this many cells to either side.
const ASIDE: [i32; 5] = [0, 1, -1, 2, -2];

/// The memory of the move.
#[derive(Debug, Default)]
pub(super) struct OntoRim {
    hole: Hole,
    fits: Vec<Fit>,
}

impl OntoRim {
    /// Moves vertices that have a triangle with an edge on the raster's rim onto that edge, where that can be: each saves the
    /// triangle.
    pub(super) fn sweep(&mut self, net: &mut Net, order: &mut Order, judge: &Judge<'_>) -> Result<(), Cancelled> {
        for i in 0..order.raster.len() {
            if i % VISITS_BETWEEN_CHECKS == 0 {
                judge.cancel.check()?;
            }
            let v = order.raster[i];
            if net.is_free(v) && self.put_on_rim(net, v, judge) {
                order.make_due(v);
                self.hole.ring.iter().for_each(|&r| order.make_due(r));
            }
        }
        Ok(())
    }

    fn put_on_rim(&mut self, net: &mut Net, v: u32, judge: &Judge<'_>) -> bool {
        let OntoRim { hole, fits } = self;
        let has_rim = hole.around(net, v, LONGEST_RING) && hole.triangles.len() == hole.ring.len();
        let Some(edge) = hole.outer.iter().position(|&outer| outer == NONE).filter(|_| has_rim) else { return false };
        let k = hole.ring.len();
        let ends = [hole.ring[edge], hole.ring[(edge + 1) % k]];
        let [a, b] = ends.map(|r| net.vertex(r).at);
        if !net.rim.joins(a, b) || net.is_fixed(ends[0], ends[1]) {
            return false;
        }
        let at = net.vertex(v).at;
        let round = |along: i32, aside: i32| (along + STEPS / 2).div_euclid(STEPS) * STEPS + aside * STEPS;
        let place = |aside: i32| match a.x == b.x {
            true => Point { x: a.x, y: round(at.y, aside) },
            false => Point { x: round(at.x, aside), y: a.y },
        };
        let between =
            |p: &Point| (p.x - a.x).signum() * (p.x - b.x).signum() + (p.y - a.y).signum() * (p.y - b.y).signum() < 0;
        let sharpest = judge.angles.bound(hole.corners(net));
        let found = ASIDE.into_iter().map(place).filter(between).find_map(|p| {
            let (column, row) = p.sample()?;
            let apex = Vertex { at: p, height: judge.meter.tile().at(column, row) };
            fits.clear();
            let fit = |i: usize| {
                let [q, r] = [hole.ring[i], hole.ring[(i + 1) % k]].map(|r| net.vertex(r));
                let corners = [apex, q, r];
                let may_be = orient(p, q.at, r.at) > 0 && sharpest.allows(corners) && judge.feasible(corners);
                (may_be && judge.may_join(apex, q) && judge.may_join(apex, r))
                    .then(|| judge.settle(corners, judge.meter.fit(corners, f32::INFINITY)))
            };
            let all = (0..k).filter(|&i| i != edge).map(|i| fit(i).map(|fit| fits.push(fit)));
            let is_whole = all.into_iter().all(|fit| fit.is_some());
            is_whole.then_some(apex)
        });
        let Some(apex) = found else { return false };
        *net.vertex_mut(v).0 = apex;
        let others = (0..k).filter(|&i| i != edge).map(|i| hole.triangles[i]);
        for (t, &fit) in others.zip(fits.iter()) {
            net.triangle_mut(t).fit = fit;
        }
        net.drop_rim_triangle(hole.triangles[edge]);
        true
    }
}
