//! The loops of a tile's ground while ears are cut off.

use super::ear::{Ear, Occupied};
use super::{Strip, Task, sample};
use crate::base::lattice::dot;
use crate::base::mesh::{Domain, Vertex};

/// The loops of a domain as corners that know their neighbours, and which samples they stand on.
///
/// Memory: 32 bytes per corner, one per sample.
pub(super) struct Loops {
    corners: Vec<Corner>,
    width: usize,
    occupied: Vec<bool>,
}

struct Corner {
    vertex: Vertex,
    index: u32,
    before: u32,
    after: u32,
    state: State,
}

#[derive(PartialEq, Eq)]
enum State {
    /// It may go.
    Free,
    /// It stays.
    Kept,
    Gone,
}

impl Loops {
    pub(super) fn new(domain: &Domain, task: &Task<'_>, fixed: usize) -> Loops {
        let (width, height) = (task.tile.width(), task.tile.height());
        let mut corners = Vec::new();
        let mut uses = vec![0u32; domain.vertices.len()];
        for l in &domain.loops {
            let (first, count) = (corners.len() as u32, l.len() as u32);
            for (i, &index) in (0..count).zip(l) {
                let vertex = domain.vertices[index as usize];
                let [before, after] = [count - 1, 1].map(|step| first + (i + step) % count);
                corners.push(Corner { vertex, index, before, after, state: State::Free });
                uses[index as usize] += 1;
            }
        }
        let is_point = |vertex: Vertex| {
            let (column, row) = sample(vertex.at);
            let place = (row as usize, column as usize);
            task.points.binary_search_by_key(&place, |&(column, row)| (row, column)).is_ok()
        };
        for corner in &mut corners {
            let index = corner.index as usize;
            if index < fixed || uses[index] > 1 || is_point(corner.vertex) {
                corner.state = State::Kept;
            }
        }
        let mut loops = Loops { corners, width, occupied: vec![false; width * height] };
        domain.fixed().for_each(|vertex| loops.occupy(vertex, true));
        loops
    }

    fn occupy(&mut self, vertex: Vertex, is_occupied: bool) {
        let (column, row) = sample(vertex.at);
        self.occupied[row as usize * self.width + column as usize] = is_occupied;
    }

    /// How many corners there were.
    pub(super) fn len(&self) -> u32 {
        self.corners.len() as u32
    }

    pub(super) fn vertex(&self, corner: u32) -> Vertex {
        self.corners[corner as usize].vertex
    }

    /// The corners before and after one.
    pub(super) fn beside(&self, corner: u32) -> [u32; 2] {
        let Corner { before, after, .. } = self.corners[corner as usize];
        [before, after]
    }

    /// The ear at a corner that may go: it turns left, or lies between its neighbours, and these have another one.
    pub(super) fn ear(&self, tip: u32) -> Option<Ear> {
        if self.corners[tip as usize].state != State::Free {
            return None;
        }
        let beside = self.beside(tip);
        let [before, after] = beside.map(|corner| self.vertex(corner).at);
        let ear = Ear { before, tip: self.vertex(tip).at, after };
        let is_last = self.corners[beside[1] as usize].after == beside[0];
        let area = ear.area();
        let is_ear = area > 0 || area == 0 && dot(ear.tip, before, after) < 0;
        (is_ear && !is_last).then_some(ear)
    }

    pub(super) fn samples_lost(&self, ear: &Ear, strip: &Strip<'_>) -> Option<u64> {
        ear.samples_lost(strip, self)
    }

    /// Cuts the ear at a corner off.
    pub(super) fn cut(&mut self, tip: u32) {
        let [before, after] = self.beside(tip);
        self.corners[before as usize].after = after;
        self.corners[after as usize].before = before;
        self.corners[tip as usize].state = State::Gone;
        self.occupy(self.vertex(tip), false);
    }

    /// What is left, as the loops of the domain: the first `fixed` vertices, then those in use, in their order.
    pub(super) fn store(&self, domain: &mut Domain, fixed: usize) {
        let mut numbers = vec![u32::MAX; domain.vertices.len()];
        (0..).zip(&mut numbers[..fixed]).for_each(|(i, number)| *number = i);
        let left = || self.corners.iter().filter(|corner| corner.state != State::Gone);
        left().for_each(|corner| numbers[corner.index as usize] = 0);
        let before = std::mem::take(&mut domain.vertices);
        for (number, vertex) in numbers.iter_mut().zip(before).filter(|(number, _)| **number != u32::MAX) {
            *number = domain.vertices.len() as u32;
            domain.vertices.push(vertex);
        }
        let mut corners = self.corners.iter();
        for l in &mut domain.loops {
            let left = corners.by_ref().take(l.len()).filter(|corner| corner.state != State::Gone);
            *l = left.map(|corner| numbers[corner.index as usize]).collect();
        }
    }
}

impl Occupied for Loops {
    fn is_occupied(&self, column: i32, row: i32) -> bool {
        self.occupied[row as usize * self.width + column as usize]
    }
}
