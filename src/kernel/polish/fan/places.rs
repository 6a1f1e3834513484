//! What witnesses say of all places around a vertex at once: a lane for each.
//!
//! Where an apex goes within its ring, the triangles to it change, and with them the one that a sample is under. On which
//! side of the spokes the sample is tells which, and its weights. Coordinates are relative to the sample, in single precision, which
//! has room for the products in rings up to 500 cells wide; in wider ones a sample beside a spoke may count in the triangle beyond it,
//! which steers as well.

use crate::base::lattice::STEPS;
use crate::base::mesh::Vertex;
use crate::kernel::polish::energy::{Meter, ONSET, PULL, energies, energy};
use crate::kernel::polish::lanes::{Kernel, LANES, Lanes, run};
use crate::kernel::polish::ring::Ring;
use crate::kernel::polish::witnesses::Witness;

/// A place in steps across and down and tolerances up from the middle.
type Offset = [f32; 3];

/// Up to eight places for an apex.
#[derive(Debug, Default)]
pub(super) struct Places {
    middle: Middle,
    apexes: Vec<Vertex>,
    /// Across, down and up: those of the apexes.
    offsets: [[f32; LANES]; 3],
    ring: Vec<Offset>,
    triangles: usize,
    heard: Vec<Heard>,
    /// Sums of the energies that were heard, and the largest share of a limit.
    sums: [f32; LANES],
    worst: [f32; LANES],
    is_left: [bool; LANES],
}

/// What offsets are from.
#[derive(Debug, Clone, Copy, Default)]
struct Middle {
    x: i32,
    y: i32,
    height: f64,
}

impl Middle {
    fn offset(self, v: Vertex, meter: &Meter<'_>) -> Offset {
        let up = (v.height - self.height) * meter.per_tolerance();
        [(v.at.x - self.x) as f32, (v.at.y - self.y) as f32, up as f32]
    }
}

/// What a witness says of every place.
#[derive(Debug, Clone, Copy)]
struct Heard {
    witness: Witness,
    said: Said,
}

#[derive(Debug, Clone, Copy)]
struct Said {
    /// The number of the triangle that it is under; less than 0 if it is under none.
    triangle: [f32; LANES],
    /// How far that is from it, as a share of its limit.
    share: [f32; LANES],
    energy: [f32; LANES],
}

impl Places {
    /// Begins anew, with places for the apex of a ring.
    pub(super) fn begin(
        &mut self,
        ring: &Ring,
        centre: Vertex,
        apexes: impl Iterator<Item = Vertex>,
        meter: &Meter<'_>,
    ) {
        let middle = Middle { x: centre.at.x, y: centre.at.y, height: centre.height };
        self.middle = middle;
        self.apexes.clear();
        self.apexes.extend(apexes);
        self.offsets = Default::default();
        for (i, &apex) in self.apexes.iter().enumerate() {
            let offset = middle.offset(apex, meter);
            (0..3).for_each(|axis| self.offsets[axis][i] = offset[axis]);
        }
        self.ring.clear();
        self.ring.extend(ring.vertices.iter().map(|&v| middle.offset(v, meter)));
        self.triangles = ring.triangles();
        self.heard.clear();
        (self.sums, self.worst) = Default::default();
        self.is_left = std::array::from_fn(|i| i < self.apexes.len());
    }

    /// Hears a witness about all places, unless it has been heard.
    pub(super) fn hear(&mut self, ring: &Ring, witness: &Witness, meter: &Meter<'_>) {
        if self.heard.iter().any(|heard| heard.witness.at() == witness.at()) {
            return;
        }
        let said = if meter.tile().channel_error.is_some() {
            self.one_by_one(ring, witness, meter)
        } else {
            let at = self.middle.offset(witness.vertex(), meter);
            run(Hearing { places: self, at, weight: witness.weight(meter) as f32 })
        };
        for i in 0..LANES {
            self.sums[i] += said.energy[i];
            self.worst[i] = if said.share[i] > self.worst[i] { said.share[i] } else { self.worst[i] };
        }
        self.heard.push(Heard { witness: *witness, said });
    }

    fn one_by_one(&self, ring: &Ring, witness: &Witness, meter: &Meter<'_>) -> Said {
        let mut said = Said { triangle: [-1.0; LANES], share: [0.0; LANES], energy: [0.0; LANES] };
        for (i, &apex) in self.apexes.iter().enumerate() {
            if let Some((triangle, share)) = witness.under_fan(ring, apex, meter) {
                (said.triangle[i], said.share[i], said.energy[i]) =
                    (triangle as f32, share as f32, energy(share as f32));
            }
        }
        said
    }

    /// Takes the place of which least energy is known, if that is below `limit` and no witness farther than `farthest`.
    pub(super) fn next(&mut self, limit: f32, farthest: f32) -> Option<(usize, Vertex)> {
        let mut best = None;
        for i in 0..self.apexes.len() {
            let is_hopeful = self.is_left[i] && self.sums[i] < limit && self.worst[i] <= farthest;
            if is_hopeful && best.is_none_or(|best: usize| self.sums[i] < self.sums[best]) {
                best = Some(i);
            }
        }
        let best = best?;
        self.is_left[best] = false;
        Some((best, self.apexes[best]))
    }

    /// The energy that is known of a place's triangles, and its parts triangle by triangle.
    pub(super) fn known(&self, place: usize, parts: &mut Vec<f32>) -> f32 {
        parts.clear();
        parts.resize(self.triangles, 0.0);
        for Heard { said, .. } in &self.heard {
            if said.triangle[place] >= 0.0 {
                parts[said.triangle[place] as usize] += said.energy[place];
            }
        }
        self.sums[place]
    }

    /// The energy beyond the onset of the witnesses that are in none of every `stride`th row.
    pub(super) fn between_rows(&self, place: usize, stride: i32) -> f32 {
        let between = self.heard.iter().filter(|heard| (heard.witness.at().y / STEPS) % stride != 0);
        between.map(|heard| (heard.said.share[place] - ONSET).max(0.0).powi(2)).sum()
    }
}

struct Hearing<'a> {
    places: &'a Places,
    at: Offset,
    /// What a tolerance is as a share of the witness's limit.
    weight: f32,
}

impl Kernel for Hearing<'_> {
    type Output = Said;

    #[inline(always)]
    fn run<L: Lanes>(self, on: L) -> Said {
        let Hearing { places: Places { offsets, ring, triangles, .. }, at: [x, y, z], weight } = self;
        let zero = on.all(0.0);
        let [across, down, up] = [(0, x), (1, y), (2, z)].map(|(axis, of)| on.sub(on.of(offsets[axis]), on.all(of)));
        // Positive where the witness is to the left of the spoke.
        let side = |v: &Offset| on.sub(on.mul(across, on.all(v[1] - y)), on.mul(down, on.all(v[0] - x)));
        let first = side(&ring[0]);
        let (mut behind, mut error, mut area, mut triangle) = (first, zero, on.all(1.0), on.all(-1.0));
        for i in 0..*triangles {
            let closes = i + 1 == ring.len();
            let (p, q) = (&ring[i], &ring[if closes { 0 } else { i + 1 }]);
            let ahead = if closes { first } else { side(q) };
            // The weight of the apex is the same at all places.
            let of_apex = (p[0] - x) * (q[1] - y) - (p[1] - y) * (q[0] - x);
            let of_ring = on.sub(on.mul(behind, on.all(q[2] - z)), on.mul(ahead, on.all(p[2] - z)));
            let outside = on.max(ahead, on.sub(zero, behind));
            let keep = |old, new| on.if_greater(outside, zero, old, new);
            error = keep(error, on.add(on.mul(on.all(of_apex), up), of_ring));
            area = keep(area, on.add(on.all(of_apex), on.sub(behind, ahead)));
            triangle = keep(triangle, on.all(i as f32));
            behind = ahead;
        }
        let share = on.mul(on.div(on.abs(error), area), on.all(weight));
        let energy = energies(on, share, on.all(PULL));
        Said { triangle: on.parts(triangle), share: on.parts(share), energy: on.parts(energy) }
    }
}
