//! How far tiles need to tell: what those before them have told bounds where the cut can lie.

use std::sync::{Mutex, PoisonError};

use super::{Goal, Told};
use crate::kernel::triangulate::progressive::Key;

/// How far tiles need to go when they tell of their insertions. It rises as they tell: once the tiles so far would exceed
/// a budget by themselves, the cut for all lies no later, and the others need not go beyond. Work is saved, never a
/// result changed.
#[derive(Debug)]
pub(in crate::job) struct Floor {
    budget: Option<Most>,
    state: Mutex<State>,
}

/// A budget: so much, and what an insertion takes of it.
type Most = (u64, fn(&Told) -> u64);

#[derive(Debug)]
struct State {
    /// What has been told, by the upper bits of the rank.
    spent: Vec<u64>,
    cut: Key,
}

/// The upper 16 bits of a rank: sign, exponent and 4 bits, steps of 6 % in error.
const SHIFT: u32 = 48;

impl Floor {
    /// Nothing told yet; errors of at least `lowest` are of interest at all.
    pub(in crate::job) fn new(goal: &Goal, lowest: f64) -> Floor {
        let points = goal.max_points.map(|most| -> Most { (most, |t| t.cost.points) });
        let triangles = goal.max_triangles.map(|most| -> Most { (most, |t| t.cost.triangles) });
        let state = State { spent: vec![0; 1 << (64 - SHIFT)], cut: Key::last_of(lowest) };
        Floor { budget: points.or(triangles), state: Mutex::new(state) }
    }

    /// The last key that is of interest.
    pub(in crate::job) fn cut(&self) -> Key {
        self.state.lock().unwrap_or_else(PoisonError::into_inner).cut
    }

    /// Takes into account what a tile has told.
    pub(in crate::job) fn raise(&self, told: &[Told]) {
        let Some((most, cost)) = self.budget else { return };
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        for t in told {
            state.spent[(t.key.rank() >> SHIFT) as usize] += cost(t);
        }
        let mut sum = 0;
        for bin in 0..state.spent.len() {
            sum += state.spent[bin];
            if sum > most {
                state.cut = state.cut.min(Key::last_of_rank((bin as u64) << SHIFT | ((1 << SHIFT) - 1)));
                return;
            }
        }
    }
}
