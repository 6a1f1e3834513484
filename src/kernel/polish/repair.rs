//! Remove and repair: a vertex goes although what fills its hole violates the tolerance a little; then vertices of
//! violating triangles move and edges turn until nothing does, or everything is as it was.

use super::angles::Sharpest;
use super::filling::{Filler, Weigher};
use super::hole::Hole;
use super::improve::{Demand, Improver, Search, Tried};
use super::judge::Judge;
use super::net::{Fit, NONE, Net};
use super::order::{Errand, Order};
use super::removal::VISITS_BETWEEN_CHECKS;
use super::witnesses::Witnesses;
use crate::base::control::Cancelled;
use crate::base::lattice::distance2;
use crate::base::mesh::Vertex;

/// How far an attempt goes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Patience {
    /// By how much the energy may rise when the vertex goes.
    pub(super) cap: f32,
    /// Rounds of moving and turning.
    pub(super) rounds: usize,
    /// Share to which a round must bring down the energy of violating triangles for another one to follow.
    pub(super) shrink: f32,
    /// What the energy of violating triangles may be with one round to go.
    pub(super) last_reach: f32,
    /// Whether heights are fitted.
    pub(super) fitted: bool,
    /// How vertices are moved in the first round.
    pub(super) search: Search,
    /// Whether their first step is halved from round to round.
    pub(super) finer: bool,
    /// Vertices with longer rings are left alone.
    pub(super) longest_ring: usize,
}

/// How many times as much energy a round can bring down as the next one can: a round that brings it down at all brings it
/// to a fifth.
const GAIN_OF_A_ROUND: f32 = 5.0;
/// The same where heights are fitted.
const GAIN_FITTED: f32 = 2.5;

impl Patience {
    /// How much energy violating triangles may have for a round to follow: with more than the rounds that are left bring
    /// down there is no hope. Where heights are fitted, the first round tells more than what was there before.
    fn reach(&self, round: usize) -> f32 {
        if self.fitted && round == 0 {
            return f32::INFINITY;
        }
        let gain = if self.fitted { GAIN_FITTED } else { GAIN_OF_A_ROUND };
        self.last_reach * gain.powi((self.rounds - round) as i32 - 1)
    }

    /// How vertices are moved in a round.
    fn search(&self, round: usize) -> Search {
        Search { halvings: if self.finer { round as u32 } else { 0 }, ..self.search }
    }
}

/// The memory of remove-and-repair.
#[derive(Debug, Default)]
pub(super) struct Repair {
    hole: Hole,
    filler: Filler<Fit>,
    witnesses: Witnesses,
    tried: Vec<Tried>,
    open: Vec<(u32, u32, u32)>,
    improver: Improver,
    violating: Vec<u32>,
    /// Free corners of violating triangles, each with the square of its distance from where one of these is worst.
    corners: Vec<(i64, u32)>,
}

impl Repair {
    /// Measures every triangle; to be done before anything else here.
    pub(super) fn measure(net: &mut Net, judge: &Judge<'_>) {
        for t in 0..net.triangles.len() as u32 {
            if net.triangles[t as usize].alive() {
                measure(net, t, judge);
            }
        }
    }

    /// Tries every vertex that is due, once, in raster order. Returns how many went.
    pub(super) fn sweep(
        &mut self,
        net: &mut Net,
        order: &mut Order,
        judge: &Judge<'_>,
        patience: Patience,
    ) -> Result<usize, Cancelled> {
        let mut gone = 0;
        for i in 0..order.raster.len() {
            if i % VISITS_BETWEEN_CHECKS == 0 {
                judge.cancel.check()?;
            }
            let v = order.raster[i];
            if net.is_free(v) && order.take_due(v, Errand::Remove) && self.attempt(net, v, judge, patience) {
                gone += 1;
                for t in net.journal.changed() {
                    let triangle = net.triangles[t as usize];
                    if triangle.alive() {
                        triangle.corners.iter().for_each(|&c| order.make_due(c));
                    }
                }
            }
        }
        Ok(gone)
    }

    /// Moves every free vertex and, if that is asked for, turns every edge, once, where that brings the energy down and
    /// violates nothing, if something at it has changed.
    pub(super) fn relax(
        &mut self,
        net: &mut Net,
        order: &mut Order,
        judge: &Judge<'_>,
        search: Search,
        turns: bool,
    ) -> Result<(), Cancelled> {
        for i in 0..order.raster.len() {
            if i % VISITS_BETWEEN_CHECKS == 0 {
                judge.cancel.check()?;
            }
            let v = order.raster[i];
            let visit = net.is_free(v) && order.take_due(v, Errand::Move);
            if visit && self.improver.relocate(net, v, search, Demand::Feasible, judge) {
                order.make_due(v);
                self.improver.ring().iter().for_each(|&r| order.make_due(r));
            }
        }
        if !turns {
            return Ok(());
        }
        for side in 0..3 * net.triangles.len() as u32 {
            if (side as usize).is_multiple_of(8 * VISITS_BETWEEN_CHECKS) {
                judge.cancel.check()?;
            }
            let triangle = &net.triangles[side as usize / 3];
            let visit = triangle.alive() && triangle.corners.iter().any(|&v| order.is_due(v, Errand::Turn));
            if visit && self.improver.flip(net, side, Demand::Feasible, judge) {
                self.improver.ring().iter().for_each(|&r| order.make_due(r));
            }
        }
        order.clear_due(Errand::Turn);
        Ok(())
    }

    /// Takes a vertex out, or leaves everything as it was.
    fn attempt(&mut self, net: &mut Net, v: u32, judge: &Judge<'_>, patience: Patience) -> bool {
        if !self.hole.around(net, v, patience.longest_ring) {
            return false;
        }
        let before: f32 = self.hole.triangles.iter().map(|&t| net.triangles[t as usize].fit.energy).sum();
        let ring = self.hole.ring.iter().map(|&r| net.vertex(r));
        self.witnesses.clear();
        judge.meter.call(net.vertex(v).at, &mut self.witnesses);
        let sharpest = judge.angles.bound(self.hole.corners(net));
        let witnesses = &mut self.witnesses;
        let mut weigher = LeastEnergy { judge, sharpest, witnesses, known: Fit::default() };
        if self.filler.fill(ring, f64::from(before + patience.cap), &mut weigher).is_none() {
            return false;
        }
        net.begin();
        net.refill(&self.hole, &self.filler.triangles, v, &mut self.open);
        net.drop_vertex(v);
        for (&t, &fit) in self.hole.triangles.iter().zip(&self.filler.found) {
            net.triangle_mut(t).fit = judge.settle(net.corners(t), fit);
        }
        if self.mend(net, judge, patience) && all_feasible(net, judge) {
            net.commit();
            return true;
        }
        net.roll_back();
        false
    }

    /// Moves and turns until no changed triangle violates the tolerance. Returns whether it came to that.
    fn mend(&mut self, net: &mut Net, judge: &Judge<'_>, patience: Patience) -> bool {
        self.tried.clear();
        let mut before = f32::INFINITY;
        for round in 0..=patience.rounds {
            let energy = self.find_violating(net);
            if self.violating.is_empty() {
                return true;
            }
            let promising = energy <= before * patience.shrink;
            if round == patience.rounds || !promising || energy > patience.reach(round) {
                return false;
            }
            before = energy;
            self.list_corners(net, judge);
            let search = patience.search(round);
            for &(_, v) in &self.corners {
                self.improver.relocate_new(net, v, search, &mut self.tried, judge);
            }
            for &t in &self.violating {
                // What the moves have mended stays as it is.
                if net.triangles[t as usize].fit.worst <= 1.0 {
                    continue;
                }
                for side in 3 * t..3 * t + 3 {
                    self.improver.flip(net, side, Demand::Better, judge);
                }
            }
        }
        false
    }

    /// Lists the changed triangles that violate the tolerance; returns their energy.
    fn find_violating(&mut self, net: &Net) -> f32 {
        self.violating.clear();
        let violates = |&t: &u32| {
            let triangle = &net.triangles[t as usize];
            triangle.alive() && triangle.fit.worst > 1.0
        };
        self.violating.extend(net.journal.changed().filter(violates));
        self.violating.iter().map(|&t| net.triangles[t as usize].fit.energy).sum()
    }

    /// Lists the free corners of violating triangles, those first that are closest to where one of theirs is worst: these have the
    /// largest share in the error, and once they have mended it the others may stay.
    fn list_corners(&mut self, net: &Net, judge: &Judge<'_>) {
        self.corners.clear();
        for &t in &self.violating {
            let triangle = &net.triangles[t as usize];
            let worst = judge.meter.place(triangle.fit);
            let free = triangle.corners.into_iter().filter(|&v| !net.is_locked(v));
            let away = |v: u32| worst.map_or(i64::MAX, |at| distance2(at, net.vertex(v).at));
            self.corners.extend(free.map(|v| (away(v), v)));
        }
        self.corners.sort_unstable_by_key(|&(away, v)| (v, away));
        self.corners.dedup_by_key(|&mut (_, v)| v);
        self.corners.sort_unstable();
    }
}

fn measure(net: &mut Net, t: u32, judge: &Judge<'_>) {
    let corners = net.corners(t);
    net.triangle_mut(t).fit = judge.settle(corners, judge.meter.fit(corners, f32::INFINITY));
}

/// The exact test of everything an attempt has changed. An edge with an unchanged triangle on its other side, or none,
/// was there before.
fn all_feasible(net: &Net, judge: &Judge<'_>) -> bool {
    let alive = |&t: &u32| net.triangles[t as usize].alive();
    let feasible = |t: u32| {
        let corners = net.corners(t);
        let may_be = |i: usize| {
            let twin = net.triangles[t as usize].twins[i];
            // One between two changed triangles is asked for in one of them.
            let is_new = twin != NONE && twin / 3 > t && net.journal.has_changed(twin / 3);
            !is_new || judge.may_join(corners[i], corners[(i + 1) % 3])
        };
        judge.feasible(corners) && (0..3).all(may_be)
    };
    net.journal.changed().filter(alive).all(feasible)
}

/// Any triangle, by its energy.
struct LeastEnergy<'a, 'b> {
    judge: &'a Judge<'b>,
    sharpest: Sharpest,
    witnesses: &'a mut Witnesses,
    known: Fit,
}

impl Weigher for LeastEnergy<'_, '_> {
    type Known = Fit;

    fn known(&self) -> Fit {
        self.known
    }

    fn triangle(&mut self, corners: [Vertex; 3], budget: f64) -> f64 {
        let limit = budget as f32;
        if self.witnesses.speak_against(corners, limit, &self.judge.meter) || !self.sharpest.allows(corners) {
            return f64::INFINITY;
        }
        let fit = self.judge.meter.fit(corners, limit);
        if fit.energy >= limit {
            self.judge.meter.note(fit, self.witnesses);
        }
        self.known = fit;
        f64::from(fit.energy)
    }

    /// What is wrong with an edge is in the energy, too.
    fn chord(&mut self, _: Vertex, _: Vertex) -> bool {
        true
    }
}
