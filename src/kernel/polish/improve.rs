//! Moves that keep the number of triangles: a vertex goes to another place or height, an edge turns.

use super::fan::{Fan, Look, MOVE_SHARE};
use super::fitting::Fitting;
use super::hole::Hole;
use super::judge::{DOUBT, Judge};
use super::net::{NONE, Net, next, previous};
use crate::base::lattice::STEPS;
use crate::base::mesh::Vertex;

/// An edge turns only where the energy falls below this share: edges have few choices.
const FLIP_SHARE: f32 = 0.998;
/// Vertices with longer rings do not move.
pub(super) const LONGEST_RING: usize = 24;

/// What may be left behind by a move.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Demand {
    /// Less energy: a repair in progress.
    Better,
    /// Less energy, and every new triangle within the tolerance.
    Feasible,
}

/// How a vertex is moved.
#[derive(Debug, Clone, Copy)]
pub(super) struct Search {
    /// Rounds, at most.
    pub(super) rounds: u32,
    /// How many places are looked at in a round, where vertices stand on samples: the first of eight.
    pub(super) places: usize,
    /// How often the first step is halved.
    pub(super) halvings: u32,
    /// In how many of a star's rows places are compared first, where it has twice as many or more.
    pub(super) rows: u32,
    /// Whether vertices move, too, around which nothing violates; where heights are fitted, whether shorter steps are tried, too.
    pub(super) thorough: bool,
}

/// The best place that is found: the first step is a quarter of the way to the nearest neighbour, and a step that leads
/// nowhere is halved.
fn search(fan: &mut Fan, centre: Vertex, how: Search, demand: Demand, judge: &Judge<'_>) -> Vertex {
    fan.call_witnesses(&judge.meter);
    let farthest = if demand == Demand::Feasible { 1.0 + DOUBT } else { f32::INFINITY };
    let (mut apex, mut step) = (centre, ((fan.clearance(centre.at) / STEPS / 4) >> how.halvings).max(1));
    for _ in 0..how.rounds {
        let before = apex.at;
        let look = Look { step, places: how.places, share: MOVE_SHARE, farthest, rows: how.rows };
        apex = fan.look_around(apex, look, &judge.meter);
        if apex.at == before {
            if step == 1 {
                break;
            }
            step /= 2;
        }
    }
    apex
}

/// The best place and height that is found.
fn fit(fan: &mut Fan, centre: Vertex, how: Search, judge: &Judge<'_>, fitting: &Fitting) -> Vertex {
    let mut apex = centre;
    for _ in 0..how.rounds {
        let before = apex;
        apex = fan.step(apex, how.thorough, judge, fitting);
        if apex == before {
            break;
        }
    }
    apex
}

/// A vertex that was tried in vain, how, and what was around it: another star has another sum of energies, but for chance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Tried {
    vertex: u32,
    halvings: u32,
    energy: f32,
    ring: usize,
}

/// The memory of the moves.
#[derive(Debug, Default)]
pub(super) struct Improver {
    hole: Hole,
    fan: Fan,
}

impl Improver {
    /// The vertices around what the last move that succeeded has changed.
    pub(super) fn ring(&self) -> &[u32] {
        &self.hole.ring
    }

    /// Moves a free vertex over the samples around it; where heights are fitted, over the places around
    /// it and to a height of its own. Returns whether it moved.
    pub(super) fn relocate(&mut self, net: &mut Net, v: u32, how: Search, demand: Demand, judge: &Judge<'_>) -> bool {
        self.hole.around(net, v, LONGEST_RING) && self.relocate_in_hole(net, v, how, demand, judge)
    }

    /// The same for less energy, if the vertex has not been tried in vain with the same triangles around it, and some of
    /// them violates the tolerance or the search is thorough.
    pub(super) fn relocate_new(
        &mut self,
        net: &mut Net,
        v: u32,
        how: Search,
        tried: &mut Vec<Tried>,
        judge: &Judge<'_>,
    ) {
        if !self.hole.around(net, v, LONGEST_RING) {
            return;
        }
        let fits = self.hole.triangles.iter().map(|&t| net.triangles[t as usize].fit);
        let (energy, worst) = fits.fold((0.0f32, 0.0f32), |(sum, worst), fit| (sum + fit.energy, worst.max(fit.worst)));
        let now = Tried { vertex: v, halvings: how.halvings, energy, ring: self.hole.ring.len() };
        let is_in_vain = (worst <= 1.0 && !how.thorough) || tried.contains(&now);
        if !is_in_vain && !self.relocate_in_hole(net, v, how, Demand::Better, judge) {
            tried.push(now);
        }
    }

    /// Moves the vertex whose star is the hole.
    fn relocate_in_hole(&mut self, net: &mut Net, v: u32, how: Search, demand: Demand, judge: &Judge<'_>) -> bool {
        let Improver { hole, fan } = self;
        let centre = net.vertex(v);
        let fits = hole.triangles.iter().map(|&t| net.triangles[t as usize].fit);
        fan.reset(hole.ring.iter().map(|&r| net.vertex(r)), centre, fits, judge.angles);
        let apex = match &judge.fitting {
            None => search(fan, centre, how, demand, judge),
            Some(fitting) => fit(fan, centre, how, judge, fitting),
        };
        if apex == centre {
            return false;
        }
        let within = fan.settle(apex, judge);
        if demand == Demand::Feasible && !(within && fan.feasible(apex, judge)) {
            return false;
        }
        *net.vertex_mut(v).0 = apex;
        for (&t, &fit) in hole.triangles.iter().zip(&fan.fits) {
            net.triangle_mut(t).fit = fit;
        }
        true
    }

    /// Turns an edge if that lowers the energy of its two triangles.
    pub(super) fn flip(&mut self, net: &mut Net, side: u32, demand: Demand, judge: &Judge<'_>) -> bool {
        let twin = net.twin(side);
        if twin == NONE {
            return false;
        }
        let [p, q, r, s] = [side, next(side), previous(side), previous(twin)].map(|e| net.origin(e));
        if net.orient(p, s, r) <= 0 || net.orient(s, q, r) <= 0 {
            return false;
        }
        let corners = [[p, s, r], [s, q, r]].map(|t| t.map(|v| net.vertex(v)));
        let (t, u) = (side as usize / 3, twin as usize / 3);
        let sharpest = judge.angles.bound([side / 3, twin / 3].into_iter().map(|t| net.corners(t)));
        if !corners.iter().all(|&c| sharpest.allows(c)) {
            return false;
        }
        let limit = (net.triangles[t].fit.energy + net.triangles[u].fit.energy) * FLIP_SHARE;
        let first = judge.meter.fit(corners[0], limit);
        let hopeful = first.energy < limit;
        if !hopeful {
            return false;
        }
        let second = judge.meter.fit(corners[1], limit - first.energy);
        let better = first.energy + second.energy < limit;
        if !better {
            return false;
        }
        let (first, second) = (judge.settle(corners[0], first), judge.settle(corners[1], second));
        if demand == Demand::Feasible {
            let promising = first.worst <= 1.0 && second.worst <= 1.0;
            let may_turn =
                || corners.iter().all(|&c| judge.feasible(c)) && judge.may_join(net.vertex(s), net.vertex(r));
            if !promising || !may_turn() {
                return false;
            }
        }
        net.flip(side);
        self.hole.ring.clear();
        self.hole.ring.extend([p, s, q, r]);
        net.triangle_mut(t as u32).fit = first;
        net.triangle_mut(u as u32).fit = second;
        true
    }
}
