//! Which of some chosen samples one triangle can hold together.
//!
//! Two samples that a triangle holds are compatible: a line is within the tolerance of all samples between them. More than two
//! are the corners of a convex polygon in the triangle, and one plane is within the tolerance of all samples of it.

use super::polygon::{hull, samples_of};
use super::samples::{At, Samples, orient};

/// Chosen samples and which of them are compatible.
pub(crate) struct Chosen {
    /// The samples, by rows.
    pub(crate) at: Vec<At>,
    /// For each those of higher number that it is compatible with, ascending.
    pub(crate) after: Vec<Vec<u32>>,
    /// The same as bits, both ways.
    compatible: Vec<Vec<u64>>,
    /// The number of a sample, or `u32::MAX`, by rows.
    number: Vec<u32>,
}

impl Chosen {
    /// Compares each with each.
    pub(crate) fn new(samples: &Samples<'_>, at: Vec<At>) -> Chosen {
        let width = samples.tile.width();
        let mut number = vec![u32::MAX; width * samples.tile.height()];
        for (i, &(column, row)) in at.iter().enumerate() {
            number[row as usize * width + column as usize] = i as u32;
        }
        let compatible =
            |i: usize| (i + 1..at.len()).filter(|&j| samples.bend(at[i], at[j]).is_none()).map(|j| j as u32).collect();
        let after: Vec<Vec<u32>> = (0..at.len()).map(compatible).collect();
        let mut compatible = vec![vec![0u64; at.len().div_ceil(64)]; at.len()];
        for (i, later) in after.iter().enumerate() {
            compatible[i][i / 64] |= 1 << (i % 64);
            for j in later.iter().map(|&j| j as usize) {
                compatible[i][j / 64] |= 1 << (j % 64);
                compatible[j][i / 64] |= 1 << (i % 64);
            }
        }
        Chosen { at, after, compatible, number }
    }

    fn are_compatible(&self, i: u32, j: u32) -> bool {
        self.compatible[i as usize][j as usize / 64] >> (j % 64) & 1 == 1
    }
}

/// Looks for all sets.
pub(crate) struct Search<'a> {
    pub(crate) samples: Samples<'a>,
    pub(crate) chosen: &'a Chosen,
    /// Every set that no other one has been made of, and others.
    pub(crate) sets: Vec<Vec<u32>>,
    /// How many more samples of polygons may be looked at.
    pub(crate) budget: usize,
}

impl Search<'_> {
    /// Finds all sets; `false` if the budget has ended before.
    ///
    /// Each set of chosen samples that a convex polygon cuts out is made once: from the one without its last samples, whose
    /// polygon has grown by a later sample and has taken no earlier one in.
    pub(crate) fn run(&mut self) -> bool {
        for first in 0..self.chosen.at.len() as u32 {
            let later = self.chosen.after[first as usize].clone();
            self.grow(&[self.chosen.at[first as usize]], &[first], first, &later);
        }
        self.budget > 0
    }

    fn grow(&mut self, corners: &[At], members: &[u32], last: u32, later: &[u32]) {
        let mut is_leaf = true;
        let mut inside = Vec::new();
        for &next in later.iter().filter(|&&next| next > last && !members.contains(&next)) {
            if self.budget == 0 {
                return;
            }
            let polygon = hull(corners.iter().copied().chain([self.chosen.at[next as usize]]).collect());
            if self.is_refuted_at_once(&polygon) {
                continue;
            }
            samples_of(&polygon, &mut inside);
            self.budget = self.budget.saturating_sub(inside.len());
            let width = self.samples.tile.width();
            let mut grown: Vec<u32> =
                inside.iter().map(|s| self.chosen.number[s.1 as usize * width + s.0 as usize]).collect();
            grown.retain(|&i| i != u32::MAX);
            grown.sort_unstable();
            let takes_earlier = grown.iter().any(|i| *i < next && !members.contains(i));
            let new = || grown.iter().copied().filter(|i| !members.contains(i));
            if takes_earlier || new().any(|i| !members.iter().all(|&j| self.chosen.are_compatible(i, j))) {
                continue;
            }
            if !self.fits(&polygon, &inside) {
                continue;
            }
            is_leaf = false;
            let left: Vec<u32> = later
                .iter()
                .copied()
                .filter(|&k| k > next && new().all(|i| self.chosen.are_compatible(i, k)))
                .collect();
            self.grow(&polygon, &grown, next, &left);
        }
        if is_leaf {
            self.sets.push(members.to_vec());
        }
    }

    /// Whether few samples of a convex polygon prove that no plane is within the tolerance of all.
    fn is_refuted_at_once(&self, polygon: &[At]) -> bool {
        let [a, rest @ ..] = polygon else { return false };
        rest.windows(2).any(|w| {
            let (b, c) = (w[0], w[1]);
            [(1, 1, 1), (2, 1, 1), (1, 2, 1), (1, 1, 2)].iter().any(|&(i, j, k)| {
                let mean = |a: i32, b: i32, c: i32| (i * a + j * b + k * c) / (i + j + k);
                let m = (mean(a.0, b.0, c.0), mean(a.1, b.1, c.1));
                let is_inside = [(*a, b), (b, c), (c, *a)].iter().all(|&(p, q)| orient(p, q, m) >= 0);
                is_inside && self.samples.refute([*a, b, c, m])
            })
        }) || rest.windows(3).any(|w| self.samples.refute([*a, w[0], w[1], w[2]]))
    }

    /// Whether a triangle may hold a convex polygon.
    fn fits(&mut self, polygon: &[At], inside: &[At]) -> bool {
        if polygon.len() < 3 {
            return true;
        }
        const FEW: usize = 48;
        if inside.len() > 2 * FEW {
            let some: Vec<At> = polygon.iter().chain(inside.iter().step_by(inside.len() / FEW)).copied().collect();
            if self.samples.warp(&some).is_some() {
                return false;
            }
        }
        self.samples.warp(inside).is_none()
    }
}
