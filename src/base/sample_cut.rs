//! What an outline that the ground ends at leaves of the ground around a sample.

/// Which quadrants of a sample have ground inside of the outline, and whether the cell to its lower right is ground at all.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(transparent)]
pub struct SampleCut(u8);

/// The cell is no ground, whatever heights there are.
const CLOSED: u8 = 1 << 4;

/// The outline comes into the cell: it is ground as a whole or not at all.
const CROSSED: u8 = 1 << 5;

const QUADRANTS: u8 = (1 << 4) - 1;

impl SampleCut {
    /// A sample outside of the outline, and a cell far from it.
    pub const FAR: SampleCut = SampleCut(CLOSED);

    /// Opens the cell to heights.
    pub fn open(&mut self) {
        self.0 &= !CLOSED;
    }

    /// Notes that the outline comes into the cell.
    pub fn cross(&mut self) {
        self.0 |= CROSSED;
    }

    /// Notes that a quadrant has ground inside. They are counted around: lower right, lower left, upper left, upper right.
    pub fn add(&mut self, quadrant: usize) {
        self.0 |= 1 << quadrant;
    }

    pub(super) fn has(self, quadrant: usize) -> bool {
        self.0 >> quadrant & 1 == 1
    }

    pub(super) fn is_outside(self) -> bool {
        self.0 & QUADRANTS == 0
    }

    pub(super) fn is_closed(self) -> bool {
        self.0 & CLOSED != 0
    }

    pub(super) fn is_crossed(self) -> bool {
        self.0 & CROSSED != 0
    }
}
