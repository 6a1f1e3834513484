//! Which samples of a tile are heights.

use super::SampleCut;
use crate::base::Window;

/// How far from a void, a missing sample, a sample is *near* it, in columns and rows: interpolation of other programs mixes voids
/// and heights so far.
pub const NEAR_VOID: usize = 3;

/// Which samples of a window are heights, and which of those one sample around it: neighbours see the same ground on
/// both sides of their common line. Samples of bridged holes count as valid.
///
/// The ground is every cell with four valid samples, and of every cell with three the triangle of these. Memory: nothing
/// where every sample is valid, else one byte per sample, another where holes are bridged, and another where an outline cuts the ground.
///
/// Such an outline takes cells away as a whole: those far outside of it, and half cells that it comes into. Of the others it may have a part,
/// so that not all samples on cells that are ground are on the ground.
#[derive(Debug, Clone, Default)]
pub struct Validity {
    width: usize,
    height: usize,
    /// Whether the field goes on to the left, above, to the right and below.
    beyond: [bool; 4],
    /// Row by row, the samples around among them. Empty where all are valid.
    flags: Vec<bool>,
    /// Which samples are valid although they have no height, in the same order. Empty where none is.
    bridged: Vec<bool>,
    /// What an outline leaves, in the same order. Empty where it leaves all.
    cut: Vec<SampleCut>,
    by_nearness: bool,
}

/// What of a cell is ground. Corners are counted around: upper left, upper right, lower right, lower left.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cell {
    /// Nothing.
    Empty,
    /// The triangle of the three other corners.
    Without(u8),
    /// All of it.
    Whole,
}

impl Cell {
    /// By which of its corners are valid.
    fn of(valid: [bool; 4]) -> Cell {
        match valid.iter().filter(|v| **v).count() {
            4 => Cell::Whole,
            3 => Cell::Without(valid.iter().position(|v| !v).unwrap_or(0) as u8),
            _ => Cell::Empty,
        }
    }
}

impl Validity {
    /// Everything valid so far, of a window of a field of this size.
    pub(crate) fn reset(&mut self, window: Window, (width, height): (usize, usize)) {
        (self.width, self.height) = (window.width, window.height);
        let (right, bottom) = (window.column + window.width, window.row + window.height);
        self.beyond = [window.column > 0, window.row > 0, right < width, bottom < height];
        self.flags.clear();
        self.bridged.clear();
        self.cut.clear();
        self.by_nearness = false;
    }

    /// Notes that a sample is missing for its nearness to a mark that it does not equal.
    pub(crate) fn note_nearness(&mut self) {
        self.by_nearness = true;
    }

    /// Whether a sample is missing for its nearness to a mark that it does not equal.
    pub(crate) fn by_nearness(&self) -> bool {
        self.by_nearness
    }

    /// Takes a sample's height away. Counted from the window's corner; −1 is before it.
    pub(crate) fn mark(&mut self, column: i32, row: i32) {
        if self.flags.is_empty() {
            self.begin();
        }
        let index = self.index(column, row);
        self.flags[index] = false;
    }

    /// Makes a sample without a height valid, as one of a bridged hole.
    pub(crate) fn bridge(&mut self, column: i32, row: i32) {
        let index = self.index(column, row);
        self.flags[index] = true;
        self.bridged.resize(self.flags.len(), false);
        self.bridged[index] = true;
    }

    /// Takes the ground away that an outline does not leave: of every sample of the window and those around, row by row.
    pub(crate) fn cut(&mut self, cut: Vec<SampleCut>) {
        assert_eq!(cut.len(), (self.width + 2) * (self.height + 2), "samples of the window and around");
        if self.flags.is_empty() {
            self.begin();
        }
        self.cut = cut;
    }

    /// What an outline leaves at a sample, if there is one.
    fn cut_at(&self, column: i32, row: i32) -> Option<SampleCut> {
        (!self.cut.is_empty()).then(|| self.cut[self.index(column, row)])
    }

    /// Whether a sample is outside of the outline that the ground ends at.
    pub fn is_outside(&self, column: i32, row: i32) -> bool {
        self.cut_at(column, row).is_some_and(SampleCut::is_outside)
    }

    /// Outside the field nothing is valid.
    fn begin(&mut self) {
        self.flags.resize((self.width + 2) * (self.height + 2), true);
        let (right, bottom) = (self.width as i32, self.height as i32);
        let [left_there, upper_there, right_there, lower_there] = self.beyond;
        for (there, column) in [(left_there, -1), (right_there, right)] {
            for row in (-1..=bottom).filter(|_| !there) {
                let index = self.index(column, row);
                self.flags[index] = false;
            }
        }
        for (there, row) in [(upper_there, -1), (lower_there, bottom)] {
            for column in (-1..=right).filter(|_| !there) {
                let index = self.index(column, row);
                self.flags[index] = false;
            }
        }
    }

    #[inline(always)]
    fn index(&self, column: i32, row: i32) -> usize {
        debug_assert!(column >= -1 && row >= -1 && column <= self.width as i32 && row <= self.height as i32);
        (row + 1) as usize * (self.width + 2) + (column + 1) as usize
    }

    /// How many samples of a window of this size are valid.
    pub(crate) fn count_valid(&self, width: usize, height: usize) -> usize {
        if self.is_whole() { width * height } else { (0..height).flat_map(|row| self.row(row)).filter(|v| **v).count() }
    }

    /// Whether every sample is valid and none of a bridged hole, those around the window among them.
    #[inline(always)]
    pub fn is_whole(&self) -> bool {
        self.flags.is_empty()
    }

    /// Whether a sample is valid. Outside the field none is, but where all are ([`Validity::is_whole`]) nobody should ask.
    #[inline(always)]
    pub fn is_valid(&self, column: i32, row: i32) -> bool {
        self.flags.is_empty() || self.flags[self.index(column, row)]
    }

    /// Whether a sample is one of a bridged hole: valid, at a height that nothing has measured.
    #[inline(always)]
    pub fn is_bridged(&self, column: i32, row: i32) -> bool {
        !self.bridged.is_empty() && self.bridged[self.index(column, row)]
    }

    /// Whether a sample is valid and has a height of its own.
    #[inline(always)]
    pub fn has_height(&self, column: i32, row: i32) -> bool {
        self.is_valid(column, row) && !self.is_bridged(column, row)
    }

    /// Whether the field goes on to the left, above, to the right and below the window.
    pub(crate) fn beyond(&self) -> [bool; 4] {
        self.beyond
    }

    /// The samples of a row of the window; empty where all are valid.
    pub(crate) fn row(&self, row: usize) -> &[bool] {
        if self.flags.is_empty() {
            return &[];
        }
        let start = self.index(0, row as i32);
        &self.flags[start..start + self.width]
    }

    /// What of the cell to the lower right of a sample is ground.
    #[inline]
    pub fn cell(&self, column: i32, row: i32) -> Cell {
        let at = |dx: i32, dy: i32| self.is_valid(column + dx, row + dy);
        let cell = Cell::of([at(0, 0), at(1, 0), at(1, 1), at(0, 1)]);
        match self.cut_at(column, row) {
            Some(cut) if cut.is_closed() || cut.is_crossed() && cell != Cell::Whole => Cell::Empty,
            _ => cell,
        }
    }

    /// Whether the ground of the cell in a quadrant of a sample touches it, inside of the outline if there is one. Quadrants are counted around: lower right,
    /// lower left, upper left, upper right.
    pub fn touches(&self, column: i32, row: i32, quadrant: usize) -> bool {
        let (dx, dy) = [(0, 0), (-1, 0), (-1, -1), (0, -1)][quadrant];
        let is_inside = self.cut_at(column, row).is_none_or(|cut| cut.has(quadrant));
        is_inside && self.is_valid(column, row) && self.cell(column + dx, row + dy) != Cell::Empty
    }

    /// Whether a sample is on the ground.
    pub fn is_ground(&self, column: i32, row: i32) -> bool {
        (0..4).any(|quadrant| self.touches(column, row, quadrant))
    }

    /// The flags, for checksums.
    pub(crate) fn bytes(&self) -> [&[u8]; 3] {
        let [flags, bridged] = [&self.flags, &self.bridged].map(|flags| bytemuck::cast_slice(flags));
        [flags, bridged, bytemuck::cast_slice(&self.cut)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ground_is_whole_and_half_cells() {
        let mut validity = Validity::default();
        // A window of 3 × 2 at the upper left of a field of 4 × 2.
        validity.reset(Window { column: 0, row: 0, width: 3, height: 2 }, (4, 2));
        assert!(validity.is_whole());
        validity.mark(1, 0);
        assert!(
            !validity.is_whole() && validity.is_valid(3, 1) && !validity.is_valid(-1, 0) && !validity.is_valid(3, 2)
        );
        assert_eq!([0, 1, 2].map(|c| validity.cell(c, 0)), [Cell::Without(1), Cell::Without(0), Cell::Whole]);
        assert_eq!(validity.cell(0, 1), Cell::Empty);
        assert!(validity.is_ground(0, 0) && !validity.is_ground(1, 0) && validity.is_ground(2, 0));
        assert!(validity.touches(2, 0, 0) && validity.touches(2, 0, 1) && !validity.touches(2, 0, 2));
        validity.mark(2, 1);
        assert_eq!([0, 1, 2].map(|c| validity.cell(c, 0)), [Cell::Without(1), Cell::Empty, Cell::Without(3)]);
        assert_eq!(validity.row(1), [true, true, false]);
    }
}
