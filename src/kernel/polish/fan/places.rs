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
        // Without branches, which would be as good as random.
        let (mut least, mut best) = (limit, LANES);
        for i in 0..LANES {
            let is_better = self.is_left[i] & (self.sums[i] < least) & (self.worst[i] <= farthest);
            least = if is_better { self.sums[i] } else { least };
            best = if is_better { i } else { best };
        }
        *self.is_left.get_mut(best)? = false;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::channels::{ChannelError, Range, Ranges};
    use crate::base::lattice::Point;
    use crate::base::{Heights, Tile};
    use crate::kernel::polish::witnesses::Witnesses;
    use crate::kernel::triangulate::Feasibility;
    use crate::kernel::triangulate::feasible::Tester;

    const SIDE: usize = 24;

    fn tile() -> Tile {
        let noise = |i: usize| (i * 7919 % 101) as f64 * 0.07 + (i / SIDE) as f64;
        Tile::from_heights(SIDE, SIDE, Heights::F64((0..SIDE * SIDE).map(noise).collect()))
    }

    fn vertex(tile: &Tile, column: i32, row: i32) -> Vertex {
        Vertex { at: Point::of_sample(column, row), height: tile.at(column as usize, row as usize) }
    }

    /// Every witness, one after the other, is the oracle: for closed rings and open ones, samples with weights and with
    /// channels, and witnesses on spokes and beneath apexes, too.
    #[test]
    fn all_places_hear_what_each_would() {
        let weights = || (0..SIDE * SIDE).map(|i| (i % 3) as f64 * 0.5 + 0.25).collect();
        let range = |max| Range { min: 0.0, max };
        let ranges = Ranges { heights: range(32.0), channels: vec![range(7.0)], unit: 32.0 };
        let channels = || vec![(0..SIDE * SIDE).map(|i| (i * 31 % 7) as f64).collect()];
        let tiles =
            [tile(), tile().with_weights(weights()), tile().with_channels(channels(), ChannelError::new(0.5, &ranges))];
        for (tile, is_open) in tiles.iter().flat_map(|tile| [(tile, false), (tile, true)]) {
            // The open one ends on the first row, and its apexes are on it.
            let row = if is_open { 0 } else { 10 };
            let closed = vec![(2, 2), (12, 0), (21, 4), (22, 17), (11, 22), (3, 15)];
            let around = if is_open { vec![(22, 0), (12, 22), (1, 20), (2, 0)] } else { closed };
            let vertices = around.iter().map(|&(column, row)| vertex(tile, column, row)).collect();
            let ring = Ring { vertices, is_open };
            let meter = Meter::new(Tester::new(tile, 2.0, Feasibility::Weak), 2.0);
            let apexes = [(12, row), (8, row), (13, row), (9, row), (15, row)].map(|(c, r)| vertex(tile, c, r));
            let (mut places, mut witnesses) = (Places::default(), Witnesses::default());
            places.begin(&ring, apexes[0], apexes.into_iter(), &meter);
            let mut sums = [0.0f64; 5];
            let mut seen = 0;
            for sample in (0..SIDE * SIDE).step_by(5) {
                witnesses.clear();
                let witness = witnesses.note(sample, &meter).unwrap();
                places.hear(&ring, &witness, &meter);
                for (place, &apex) in apexes.iter().enumerate() {
                    let Some((_, share)) = witness.under_fan(&ring, apex, &meter) else { continue };
                    sums[place] += f64::from(energy(share as f32));
                    let heard = places.heard.last().unwrap().said;
                    assert!((f64::from(heard.share[place]) - share).abs() <= 1e-4 * share.max(1.0), "{sample} {place}");
                    assert!(heard.triangle[place] >= 0.0);
                    seen += 1;
                }
            }
            assert!(seen > 200, "{seen} witnesses under triangles");
            let mut parts = Vec::new();
            let mut least = 0.0;
            while let Some((place, apex)) = places.next(f32::INFINITY, f32::INFINITY) {
                let known = places.known(place, &mut parts);
                assert_eq!(apex, apexes[place]);
                assert!((f64::from(known) - sums[place]).abs() <= 1e-3 * sums[place], "{known} for {}", sums[place]);
                assert!((parts.iter().sum::<f32>() - known).abs() <= 1e-3 * known);
                assert!(least <= known, "the least comes first");
                least = known;
            }
            assert!(least > 0.0);
        }
    }

    #[test]
    fn a_place_that_a_witness_is_against_does_not_come() {
        let tile = tile();
        let ring = Ring::closed([(0, 0), (20, 0), (20, 20), (0, 20)].map(|(c, r)| vertex(&tile, c, r)));
        let meter = Meter::new(Tester::new(&tile, 0.5, Feasibility::Weak), 0.5);
        let apexes = [vertex(&tile, 10, 10), vertex(&tile, 12, 9)];
        let (mut places, mut witnesses) = (Places::default(), Witnesses::default());
        places.begin(&ring, apexes[0], apexes.into_iter(), &meter);
        let witness = witnesses.note(5 * SIDE + 11, &meter).unwrap();
        places.hear(&ring, &witness, &meter);
        places.hear(&ring, &witness, &meter);
        let said = places.heard[0].said;
        assert_eq!(places.heard.len(), 1, "nobody is heard twice");
        assert!(said.share[0] > 1.0);
        assert!(places.next(f32::INFINITY, 1.0).is_none());
        assert!(places.next(said.energy[0].min(said.energy[1]), f32::INFINITY).is_none());
        assert!(places.next(f32::INFINITY, f32::INFINITY).is_some());
    }
}
