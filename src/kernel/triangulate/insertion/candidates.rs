//! The candidates of all triangles, best first.

use super::scan::Candidate;

/// One candidate per triangle in a binary heap that knows where each triangle's is, so that it can be changed in place
/// (section 4.4, HEAP_CHANGE). The best is the one with the highest score; of equal ones that of the first sample (row,
/// then column), then that of the lowest triangle, so that the order of insertion never depends on how the heap grew.
///
/// Memory: 24 bytes per triangle.
#[derive(Debug, Default)]
pub(super) struct Candidates {
    of: Vec<Candidate>,
    /// Triangles.
    heap: Vec<u32>,
    /// Where in the heap a triangle is, or [`ABSENT`].
    places: Vec<u32>,
}

const ABSENT: u32 = u32::MAX;

impl Candidates {
    pub(super) fn clear(&mut self) {
        self.of.clear();
        self.heap.clear();
        self.places.clear();
    }

    /// Makes room for this number of triangles.
    pub(super) fn reserve(&mut self, triangles: usize) {
        self.of.reserve_exact(triangles.saturating_sub(self.of.len()));
        self.heap.reserve_exact(triangles.saturating_sub(self.heap.len()));
        self.places.reserve_exact(triangles.saturating_sub(self.places.len()));
    }

    /// The candidate of a triangle that has one.
    pub(super) fn get(&self, triangle: u32) -> Option<Candidate> {
        self.of.get(triangle as usize).copied().filter(|_| self.places[triangle as usize] != ABSENT)
    }

    /// The triangle with the best candidate.
    #[inline(always)]
    pub(super) fn best(&self) -> Option<(u32, Candidate)> {
        self.heap.first().map(|&t| (t, self.of[t as usize]))
    }

    /// Triangles with candidates, in no order that means anything.
    pub(super) fn triangles(&self) -> &[u32] {
        &self.heap
    }

    /// Gives a triangle another candidate, or none.
    pub(super) fn set(&mut self, triangle: u32, candidate: Option<Candidate>) {
        let index = triangle as usize;
        if index >= self.of.len() {
            self.of.resize(index + 1, Candidate::default());
            self.places.resize(index + 1, ABSENT);
        }
        let place = self.places[index];
        match (candidate, place) {
            (Some(candidate), ABSENT) => {
                self.of[index] = candidate;
                self.heap.push(triangle);
                self.rise(self.heap.len() - 1, triangle);
            }
            (Some(candidate), place) => {
                self.of[index] = candidate;
                self.settle(place as usize, triangle);
            }
            (None, ABSENT) => {}
            (None, place) => {
                self.places[index] = ABSENT;
                let last = self.heap.pop().unwrap_or(triangle);
                if last != triangle {
                    self.settle(place as usize, last);
                }
            }
        }
    }

    /// Whether the candidate of triangle `a` comes before that of `b`.
    #[inline(always)]
    fn before(&self, a: u32, b: u32) -> bool {
        let (ca, cb) = (&self.of[a as usize], &self.of[b as usize]);
        if ca.score != cb.score {
            return ca.score > cb.score;
        }
        (ca.sample, a) < (cb.sample, b)
    }

    fn put(&mut self, place: usize, triangle: u32) {
        self.heap[place] = triangle;
        self.places[triangle as usize] = place as u32;
    }

    fn settle(&mut self, place: usize, triangle: u32) {
        if place > 0 && self.before(triangle, self.heap[(place - 1) / 2]) {
            self.rise(place, triangle);
        } else {
            self.sink(place, triangle);
        }
    }

    fn rise(&mut self, mut place: usize, triangle: u32) {
        while place > 0 {
            let parent = (place - 1) / 2;
            let above = self.heap[parent];
            if !self.before(triangle, above) {
                break;
            }
            self.put(place, above);
            place = parent;
        }
        self.put(place, triangle);
    }

    fn sink(&mut self, mut place: usize, triangle: u32) {
        loop {
            let left = 2 * place + 1;
            if left >= self.heap.len() {
                break;
            }
            let right = left + 1;
            let smaller =
                if right < self.heap.len() && self.before(self.heap[right], self.heap[left]) { right } else { left };
            let below = self.heap[smaller];
            if !self.before(below, triangle) {
                break;
            }
            self.put(place, below);
            place = smaller;
        }
        self.put(place, triangle);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Against a plain list, searched from end to end.
        #[test]
        fn the_best_is_the_best(changes in prop::collection::vec((0u32..30, 0u8..5, 0u64..3, any::<bool>()), 1..200)) {
            let (mut heap, mut list) = (Candidates::default(), vec![None; 30]);
            for (t, score, sample, there) in changes {
                let candidate = there.then_some(Candidate { score: f64::from(score), sample });
                heap.set(t, candidate);
                list[t as usize] = candidate;
                let key = |(t, c): (u32, Candidate)| (-c.score, c.sample, t);
                let best = (0..30u32).filter_map(|t| list[t as usize].map(|c| (t, c)))
                    .min_by(|&a, &b| key(a).partial_cmp(&key(b)).expect("numbers"));
                prop_assert_eq!(heap.best(), best);
                prop_assert_eq!(heap.get(t), candidate);
                prop_assert_eq!(heap.triangles().len(), list.iter().flatten().count());
            }
        }
    }
}
