//! What slivers beside a rim become: a vertex next to the raster's rim goes onto it, and edges of sharp triangles turn.
//!
//! Weakly feasible slivers cost nothing and can be seen. Most lie where something was locked: a tile's side, the raster's
//! rim. Neither move makes triangles more, and both keep the exact test.

use super::angles::sharpness;
use super::hole::Hole;
use super::improve::LONGEST_RING;
use super::judge::Judge;
use super::net::{Fit, NONE, Net, next, previous};
use super::order::Order;
use super::removal::VISITS_BETWEEN_CHECKS;
use crate::base::control::Cancelled;
use crate::base::lattice::{Point, STEPS, orient};
use crate::base::mesh::Vertex;

/// Triangles whose smallest angle has less than this as the square of its sine are slivers: 10°.
const SHARP: f64 = 0.030;
/// By how much the smallest angle must grow, in the square of its sine.
const BLUNTER: f64 = 1.2;
/// Places tried on the rim: where the vertex is opposite, and this many cells to either side.
const ASIDE: [i32; 5] = [0, 1, -1, 2, -2];

/// The memory of tidying.
#[derive(Debug, Default)]
pub(super) struct Tidy {
    hole: Hole,
    fits: Vec<Fit>,
}

impl Tidy {
    /// Moves vertices that have a triangle with an edge on the raster's rim onto that edge, where that can be: each saves the
    /// triangle.
    pub(super) fn onto_rim(&mut self, net: &mut Net, order: &mut Order, judge: &Judge<'_>) -> Result<(), Cancelled> {
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
        let Tidy { hole, fits } = self;
        let has_rim = hole.around(net, v, LONGEST_RING) && hole.triangles.len() == hole.ring.len();
        let Some(edge) = hole.outer.iter().position(|&outer| outer == NONE).filter(|_| has_rim) else { return false };
        let k = hole.ring.len();
        let [a, b] = [hole.ring[edge], hole.ring[(edge + 1) % k]].map(|r| net.vertex(r).at);
        if !net.rim.joins(a, b) {
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

    /// Turns edges of slivers where their triangles are then less sharp, within the tolerance, and keep all else.
    pub(super) fn turn_slivers(&mut self, net: &mut Net, judge: &Judge<'_>) -> Result<(), Cancelled> {
        for t in 0..net.triangles.len() as u32 {
            if (t as usize).is_multiple_of(VISITS_BETWEEN_CHECKS) {
                judge.cancel.check()?;
            }
            if net.triangles[t as usize].alive() && sharpness(net.corners(t)) < SHARP {
                let _ = (3 * t..3 * t + 3).any(|side| turn(net, side, judge));
            }
        }
        Ok(())
    }
}

/// Turns an edge if that makes the sharper of its triangles blunter.
fn turn(net: &mut Net, side: u32, judge: &Judge<'_>) -> bool {
    let twin = net.twin(side);
    if twin == NONE {
        return false;
    }
    let [p, q, r, s] = [side, next(side), previous(side), previous(twin)].map(|e| net.origin(e));
    if net.orient(p, s, r) <= 0 || net.orient(s, q, r) <= 0 {
        return false;
    }
    let (t, u) = (side / 3, twin / 3);
    let new = [[p, s, r], [s, q, r]].map(|corners| corners.map(|v| net.vertex(v)));
    let sharper = |both: [[Vertex; 3]; 2]| sharpness(both[0]).min(sharpness(both[1]));
    if sharper(new) < BLUNTER * sharper([net.corners(t), net.corners(u)]) {
        return false;
    }
    let may_be = new.iter().all(|&corners| judge.feasible(corners)) && judge.may_join(net.vertex(s), net.vertex(r));
    if may_be {
        net.flip(side);
        for (t, corners) in [t, u].into_iter().zip(new) {
            net.triangle_mut(t).fit = judge.settle(corners, judge.meter.fit(corners, f32::INFINITY));
        }
    }
    may_be
}
