//! Joining runs of missing samples to voids, row by row.

use super::{Beside, Run};

/// Missing samples joined to holes, row by row, from top to bottom.
///
/// Runs of a row join with those of the row before that they touch, over corners, too. A group that touches an edge of the
/// raster or has too many samples is only remembered as such; one that no run of a row joins is complete. Time: O(runs of
/// two rows) a row, and the smaller of two groups that meet is moved to the larger.
pub(super) struct Components {
    size: (usize, usize),
    most: u64,
    row: usize,
    /// The last row's runs with their groups, and its heights.
    runs: Vec<(u32, u32, u32)>,
    beside: Vec<(u32, f64)>,
    groups: Vec<Group>,
    bytes: u64,
}

/// A hole: its samples in runs, and the heights to the left and the right, above and below.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Hole {
    pub(super) samples: u64,
    /// Ascending.
    pub(super) runs: Vec<Run>,
    /// Ascending, each place once.
    pub(super) beside: Vec<Beside>,
}

#[derive(Debug, Default)]
struct Group {
    /// The group it has become part of, or itself.
    parent: u32,
    /// Whether it is no hole, or too large.
    is_out: bool,
    last_row: usize,
    hole: Hole,
}

/// What a run and a height take in a list that grows by doubling.
const RUN_BYTES: u64 = 24;
const BESIDE_BYTES: u64 = 32;

impl Hole {
    fn bytes(&self) -> u64 {
        self.runs.len() as u64 * RUN_BYTES + self.beside.len() as u64 * BESIDE_BYTES
    }
}

impl Components {
    pub(super) fn new(width: usize, height: usize, most: u64) -> Components {
        let (runs, beside, groups) = (Vec::new(), Vec::new(), Vec::new());
        Components { size: (width, height), most, row: 0, runs, beside, groups, bytes: 0 }
    }

    /// The memory that undecided groups take.
    pub(super) fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Takes the next row: its runs of missing samples, ascending and apart from each other, and of its heights those beside
    /// missing samples of this row and the rows above and below, by columns. `complete` is called with the holes of at most
    /// so many samples that end above it.
    pub(super) fn row<E>(
        &mut self,
        runs: &[(u32, u32)],
        beside: &[(u32, f64)],
        mut complete: impl FnMut(Hole) -> Result<(), E>,
    ) -> Result<(), E> {
        let before = std::mem::take(&mut self.runs);
        let runs = self.join(&before, runs);
        for &(first, last, group) in &before {
            let row = self.row;
            self.note(group, between(beside, first, last).iter().map(|&(column, height)| (row, column, height)));
        }
        let above = std::mem::take(&mut self.beside);
        for &(first, last, group) in &runs {
            let row = self.row;
            let ends = [first.wrapping_sub(1), last + 1].into_iter().flat_map(|c| between(beside, c, c));
            self.note(group, ends.map(|&(column, height)| (row, column, height)));
            let above = between(&above, first, last).iter();
            self.note(group, above.map(|&(column, height)| (row - 1, column, height)));
        }
        self.runs = runs;
        self.beside = above;
        self.beside.clear();
        self.beside.extend_from_slice(beside);
        self.end_row(&mut complete)
    }

    /// Finds the groups of a row's runs.
    fn join(&mut self, before: &[(u32, u32, u32)], runs: &[(u32, u32)]) -> Vec<(u32, u32, u32)> {
        let (width, height) = self.size;
        let mut next = 0;
        let mut joined = Vec::with_capacity(runs.len());
        for &(first, last) in runs {
            while next < before.len() && before[next].1 + 1 < first {
                next += 1;
            }
            let touched = before[next..].iter().take_while(|run| run.0 <= last + 1);
            let mut group = None;
            for &(_, _, other) in touched {
                group = Some(self.unite(group.unwrap_or(other), other));
            }
            let group = group.unwrap_or_else(|| {
                let parent = self.groups.len() as u32;
                self.groups.push(Group { parent, ..Group::default() });
                parent
            });
            let is_at_edge = self.row == 0 || self.row + 1 == height || first == 0 || last as usize + 1 == width;
            let root = &mut self.groups[group as usize];
            root.last_row = self.row;
            root.hole.samples += u64::from(last - first + 1);
            if root.is_out || is_at_edge || root.hole.samples > self.most {
                self.rule_out(group);
            } else {
                root.hole.runs.push((self.row as u32, first, last));
                self.bytes += RUN_BYTES;
            }
            joined.push((first, last, group));
        }
        joined
    }

    fn root(&mut self, mut group: u32) -> u32 {
        while self.groups[group as usize].parent != group {
            let parent = self.groups[group as usize].parent;
            let grandparent = self.groups[parent as usize].parent;
            self.groups[group as usize].parent = grandparent;
            group = grandparent;
        }
        group
    }

    /// Makes one group of two; returns which.
    fn unite(&mut self, a: u32, b: u32) -> u32 {
        let (a, b) = (self.root(a), self.root(b));
        if a == b {
            return a;
        }
        let size = |group: u32| self.groups[group as usize].hole.bytes();
        let (larger, smaller) = if size(a) >= size(b) { (a, b) } else { (b, a) };
        let part = &mut self.groups[smaller as usize];
        part.parent = larger;
        let (is_out, last_row, mut hole) = (part.is_out, part.last_row, std::mem::take(&mut part.hole));
        let whole = &mut self.groups[larger as usize];
        whole.last_row = whole.last_row.max(last_row);
        whole.hole.samples += hole.samples;
        whole.hole.runs.append(&mut hole.runs);
        whole.hole.beside.append(&mut hole.beside);
        if is_out || whole.is_out || whole.hole.samples > self.most {
            self.rule_out(larger);
        }
        larger
    }

    fn rule_out(&mut self, group: u32) {
        let group = &mut self.groups[group as usize];
        group.is_out = true;
        self.bytes -= group.hole.bytes();
        (group.hole.runs, group.hole.beside) = (Vec::new(), Vec::new());
    }

    /// Keeps heights beside a group.
    fn note(&mut self, group: u32, beside: impl Iterator<Item = (usize, u32, f64)>) {
        let root = self.root(group);
        let Group { is_out: false, hole, .. } = &mut self.groups[root as usize] else { return };
        let known = hole.beside.len();
        hole.beside.extend(beside.map(|(row, column, height)| (row as u32, column, height)));
        self.bytes += (hole.beside.len() - known) as u64 * BESIDE_BYTES;
    }

    /// Hands over what is complete, and numbers the other groups anew.
    fn end_row<E>(&mut self, complete: &mut impl FnMut(Hole) -> Result<(), E>) -> Result<(), E> {
        let mut runs = std::mem::take(&mut self.runs);
        runs.iter_mut().for_each(|run| run.2 = self.root(run.2));
        let mut numbers = vec![0; self.groups.len()];
        let mut kept = Vec::new();
        for (number, mut group) in std::mem::take(&mut self.groups).into_iter().enumerate() {
            if group.parent as usize != number {
                continue;
            }
            if group.last_row == self.row {
                numbers[number] = kept.len() as u32;
                group.parent = kept.len() as u32;
                kept.push(group);
            } else if !group.is_out {
                let mut hole = group.hole;
                self.bytes -= hole.bytes();
                hole.runs.sort_unstable();
                hole.beside.sort_unstable_by_key(|&(row, column, _)| (row, column));
                hole.beside.dedup_by_key(|&mut (row, column, _)| (row, column));
                complete(hole)?;
            }
        }
        runs.iter_mut().for_each(|run| run.2 = numbers[run.2 as usize]);
        (self.runs, self.groups) = (runs, kept);
        self.row += 1;
        Ok(())
    }
}

/// Those of a row's heights that lie in these columns.
fn between(beside: &[(u32, f64)], first: u32, last: u32) -> &[(u32, f64)] {
    let start = beside.partition_point(|sample| sample.0 < first);
    let count = beside[start..].partition_point(|sample| sample.0 <= last);
    &beside[start..start + count]
}
