//! Which of some chosen samples one triangle can hold together.
//!
//! Two samples that a triangle holds are compatible: a line is within the tolerance of all samples between them. More than two
//! are the corners of a convex polygon in the triangle, and one plane is within the tolerance of all samples of it.

use super::polygon::{hull, samples_of, triangle_leaves_out};
use super::samples::{At, Samples};

/// Chosen samples and which of them are compatible.
pub(crate) struct Chosen {
    /// The samples, by rows.
    pub(crate) at: Vec<At>,
    /// For each those of higher number that it is compatible with, ascending.
    pub(crate) after: Vec<Vec<u32>>,
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
        let after = (0..at.len()).map(compatible).collect();
        Chosen { at, after, number }
    }

    fn are_compatible(&self, i: u32, j: u32) -> bool {
        let (i, j) = (i.min(j), i.max(j));
        i == j || self.after[i as usize].binary_search(&j).is_ok()
    }
}

/// Looks for all sets.
pub(crate) struct Search<'a> {
    pub(crate) samples: Samples<'a>,
    pub(crate) chosen: &'a Chosen,
    /// Whether sets that fit one plane, but no triangle, are left out.
    pub(crate) triangles_only: bool,
    /// Every set that no other one has been made of, and others.
    pub(crate) sets: Vec<Vec<u32>>,
    /// How many planes were looked for.
    pub(crate) tests: u64,
    /// The search ends when there are so many sets.
    pub(crate) most: usize,
}

impl Search<'_> {
    /// All sets; `false` if there are too many.
    ///
    /// Each set of chosen samples that a convex polygon cuts out is made once: from the one without its last samples, whose
    /// polygon has grown by a later sample and has taken no earlier one in.
    pub(crate) fn run(&mut self) -> bool {
        for first in 0..self.chosen.at.len() as u32 {
            let later = self.chosen.after[first as usize].clone();
            self.grow(&[self.chosen.at[first as usize]], &[first], first, &later);
        }
        self.sets.len() < self.most
    }

    fn grow(&mut self, corners: &[At], members: &[u32], last: u32, later: &[u32]) {
        let mut is_leaf = true;
        let mut inside = Vec::new();
        for &next in later.iter().filter(|&&next| next > last && !members.contains(&next)) {
            if self.sets.len() >= self.most {
                return;
            }
            let polygon = hull(corners.iter().copied().chain([self.chosen.at[next as usize]]).collect());
            samples_of(&polygon, &mut inside);
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

    /// Whether a triangle may hold a convex polygon.
    fn fits(&mut self, polygon: &[At], inside: &[At]) -> bool {
        if polygon.len() < 3 {
            return true;
        }
        self.tests += 1;
        if self.samples.warp(inside).is_some() {
            return false;
        }
        !self.triangles_only || polygon.len() < 4 || triangle_leaves_out(polygon, &self.excluded(polygon, inside))
    }

    /// Samples near a polygon that no triangle holds together with it.
    fn excluded(&mut self, polygon: &[At], inside: &[At]) -> Vec<At> {
        const REACH: i32 = 8;
        let (width, height) = (self.samples.tile.width() as i32, self.samples.tile.height() as i32);
        let range = |of: fn(&At) -> i32, end: i32| {
            let values = || polygon.iter().map(of);
            let (low, high) = (values().min().unwrap_or(0), values().max().unwrap_or(0));
            (low - REACH).max(0)..=(high + REACH).min(end - 1)
        };
        let (columns, rows) = (range(|c| c.0, width), range(|c| c.1, height));
        let mut larger = Vec::new();
        let mut excluded = Vec::new();
        for row in rows {
            for column in columns.clone() {
                let at = (column, row);
                if inside.contains(&at) {
                    continue;
                }
                let grown = hull(polygon.iter().copied().chain([at]).collect());
                samples_of(&grown, &mut larger);
                self.tests += 1;
                if self.samples.warp(&larger).is_some() {
                    excluded.push(at);
                }
            }
        }
        excluded
    }
}
