//! Where bites may grow to: places on rays, and vertices of the front.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::Edge;
use super::frame::Frame;
use super::front::Front;
use super::obstacles::Obstacles;
use super::ray::{RAYS, STEPS_OF_RAY, Step, Steps, step_from};
use super::score::{Ending, Setting};
use super::sweep::{ENOUGH_SAMPLES, Sweep, apex, tilt};
use crate::base::lattice::Point;
use crate::base::mesh::Vertex;
use crate::kernel::triangulate::feasible::Tester;

/// The steps of an edge's rays that may still be apexes of feasible bites.
pub(super) type Prospects = [Steps; RAYS.len()];

/// Chooses the best bite from an edge, among places on its rays and vertices of the front.
///
/// Candidates are looked at in the order of the best score they can have, and the exact tests are made for those alone
/// that can still win.
#[derive(Debug, Default)]
pub(super) struct Apexes {
    obstacles: Obstacles,
    sweeps: [Sweep; RAYS.len()],
    candidates: BinaryHeap<Candidate>,
}

/// An apex, in the order of the best score it can have.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Candidate {
    bound: i64,
    place: Reverse<Point>,
    /// Bit for bit.
    height: u64,
    /// The ray and the step that it comes from; none for a node of the front.
    from: Option<(usize, Step)>,
}

impl Candidate {
    fn new(setting: &Setting<'_>, v: Vertex, from: Option<(usize, Step)>) -> Candidate {
        let bound = setting.bound(v.at, ending(from));
        Candidate { bound, place: Reverse(v.at), height: v.height.to_bits(), from }
    }

    fn vertex(&self) -> Vertex {
        Vertex { at: self.place.0, height: f64::from_bits(self.height) }
    }
}

fn ending(from: Option<(usize, Step)>) -> Ending {
    if from.is_some() { Ending::NewVertex } else { Ending::Node }
}

/// How near the edge's middle vertices of the front are taken for apexes, in edge lengths.
const NODE_REACH: f64 = 1.5;

/// How near the edge's line apexes are looked for, in cells.
const NEAREST: f64 = 0.75;

impl Apexes {
    /// The best bite from an edge that has not been swept, with its score, and what the sweep leaves to be tried later.
    /// The bite is feasible; that it is inside the ground is only likely.
    pub(super) fn sweep(
        &mut self,
        front: &Front,
        tester: &Tester<'_>,
        edge: Edge,
    ) -> (Option<(i64, Vertex)>, Prospects) {
        let setting = Setting::new(front, tester, edge);
        let Setting { frame, .. } = setting;
        self.look_around(&setting);
        let first = step_from(NEAREST / frame.length());
        let ends = RAYS.each_ref().map(|ray| step_from(self.obstacles.limit(ray)).max(first));
        let mut prospects =
            pulp::Arch::new().dispatch(SweepAll { sweeps: &mut self.sweeps, tester, frame: &frame, first, ends });
        self.candidates.clear();
        for (node, place) in self.obstacles.nodes().filter(|&(_, place)| is_near(place)) {
            let vertex = front.vertex(node);
            let tilt = tilt(&frame, vertex);
            if self.sweeps.iter().zip(&RAYS).all(|(sweep, ray)| sweep.allows(ray, place, tilt)) {
                self.candidates.push(Candidate::new(&setting, vertex, None));
            }
        }
        let best = self.best(&setting, &mut prospects, |v, ending| {
            setting.is_feasible(v) && (ending == Ending::NewVertex || setting.is_visible(v))
        });
        (best, prospects)
    }

    /// The best bite from an edge that has been swept, of what is left of its prospects. It is feasible and inside the
    /// ground.
    pub(super) fn next_best(
        &mut self,
        front: &Front,
        tester: &Tester<'_>,
        edge: Edge,
        prospects: &mut Prospects,
    ) -> Option<(i64, Vertex)> {
        let setting = Setting::new(front, tester, edge);
        self.look_around(&setting);
        for (ray, steps) in RAYS.iter().zip(&mut *prospects) {
            *steps &= steps_before(step_from(self.obstacles.limit(ray)));
        }
        self.candidates.clear();
        for (node, _) in self.obstacles.nodes().filter(|&(_, place)| is_near(place)) {
            self.candidates.push(Candidate::new(&setting, front.vertex(node), None));
        }
        self.best(&setting, prospects, |v, _| setting.is_visible(v) && setting.is_feasible(v))
    }

    fn look_around(&mut self, setting: &Setting<'_>) {
        let reach = RAYS.iter().map(|r| r.farthest).fold(NODE_REACH, f64::max);
        self.obstacles.look_around(setting.front, setting.edge, &setting.frame, reach);
    }

    /// The best of the candidates and the farthest prospects of each ray. A prospect that may not be used gives way to
    /// the next on its ray, for good: what is hidden or infeasible stays so.
    fn best(
        &mut self,
        setting: &Setting<'_>,
        prospects: &mut Prospects,
        may_be_used: impl Fn(Vertex, Ending) -> bool,
    ) -> Option<(i64, Vertex)> {
        for ray in 0..RAYS.len() {
            self.push_farthest(setting, prospects, ray);
        }
        let (mut least, mut best) = (0, None);
        let mut last = None;
        while let Some(candidate) = self.candidates.pop() {
            if candidate.bound <= least {
                break;
            }
            // A node found twice comes out twice running.
            if last.replace(candidate) == Some(candidate) {
                continue;
            }
            let (v, ending) = (candidate.vertex(), ending(candidate.from));
            if may_be_used(v, ending) {
                let score = setting.score(v, ending, least);
                if score > least {
                    (least, best) = (score, Some(v));
                }
            } else if let Some((ray, step)) = candidate.from {
                prospects[ray] &= !(1 << step);
                self.push_farthest(setting, prospects, ray);
            }
        }
        best.map(|v| (least, v))
    }

    fn push_farthest(&mut self, setting: &Setting<'_>, prospects: &Prospects, ray: usize) {
        let Some(step) = prospects[ray].checked_ilog2() else { return };
        let vertex = apex(setting.tester.tile(), &setting.frame, &RAYS[ray], step).expect("a step with an apex");
        self.candidates.push(Candidate::new(setting, vertex, Some((ray, step))));
    }
}

/// The sweeps of an edge's rays, compiled for what the processor has: wider lanes and rounding in hardware change no
/// result.
struct SweepAll<'a> {
    sweeps: &'a mut [Sweep; RAYS.len()],
    tester: &'a Tester<'a>,
    frame: &'a Frame,
    first: Step,
    ends: [Step; RAYS.len()],
}

impl pulp::WithSimd for SweepAll<'_> {
    type Output = Prospects;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _simd: S) -> Prospects {
        let SweepAll { sweeps, tester, frame, first, ends } = self;
        let mut prospects = Prospects::default();
        for (i, ray) in RAYS.iter().enumerate() {
            prospects[i] = sweeps[i].run(tester.tile(), tester.tolerance(), frame, ray, first..ends[i], ENOUGH_SAMPLES);
        }
        prospects
    }
}

fn is_near((along, away): (f64, f64)) -> bool {
    (along - 0.5) * (along - 0.5) + away * away < NODE_REACH * NODE_REACH
}

/// The steps before one.
fn steps_before(step: Step) -> Steps {
    if step < STEPS_OF_RAY { (1 << step) - 1 } else { Steps::MAX }
}
