//! The boundary of the ground inside a tile, from sample to sample.

use crate::base::{Cell, Validity};

/// The eight ways from a sample to those around it, each a turn to the left of the one before: as (columns, rows).
pub(super) const WAYS: [(i32, i32); 8] = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)];

const EAST: u8 = 1;
const SOUTH: u8 = 1 << 2;
const WEST: u8 = 1 << 4;
const NORTH: u8 = 1 << 6;

/// The edges of the boundary, the ground to the left of each: per sample, the ways in which one sets out, as bits.
#[derive(Debug)]
pub(super) struct Boundary {
    width: usize,
    ways: Vec<u8>,
}

/// A sample that a loop comes by: row · width + column, and the way on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Step {
    pub(super) sample: u32,
    pub(super) way: u8,
}

impl Boundary {
    /// Of the ground in a tile of this size: its cells alone, whatever lies beyond.
    pub(super) fn new(validity: &Validity, width: usize, height: usize) -> Boundary {
        let mut ways = vec![0u8; width * height];
        let mut above = vec![Cell::Empty; width + 1];
        let mut cells = vec![Cell::Empty; width + 1];
        for row in 0..height {
            for (column, cell) in cells[1..width].iter_mut().enumerate() {
                // Below the last row there are none.
                *cell = if row + 1 < height { validity.cell(column as i32, row as i32) } else { Cell::Empty };
            }
            let at = |column: usize, row: usize| row * width + column;
            for column in 0..width {
                let (left, right) = (cells[column], cells[column + 1]);
                let (upper, lower) = (has_lower_edge(above[column + 1]), has_upper_edge(right));
                if lower && !upper {
                    ways[at(column, row)] |= EAST;
                } else if upper && !lower {
                    ways[at(column + 1, row)] |= WEST;
                }
                if row + 1 == height {
                    continue;
                }
                let (to_the_left, to_the_right) = (has_right_edge(left), has_left_edge(right));
                if to_the_right && !to_the_left {
                    ways[at(column, row + 1)] |= NORTH;
                } else if to_the_left && !to_the_right {
                    ways[at(column, row)] |= SOUTH;
                }
                // The third side of a half cell.
                let (dx, dy, way) = match right {
                    Cell::Without(0) => (0, 1, 7),
                    Cell::Without(1) => (0, 0, 1),
                    Cell::Without(2) => (1, 0, 3),
                    Cell::Without(_) => (1, 1, 5),
                    Cell::Empty | Cell::Whole => continue,
                };
                ways[at(column + dx, row + dy)] |= 1 << way;
            }
            std::mem::swap(&mut above, &mut cells);
        }
        Boundary { width, ways }
    }

    /// Whether several edges set out from a sample: loops touch there.
    pub(super) fn is_pinched(&self, sample: u32) -> bool {
        self.ways[sample as usize].count_ones() > 1
    }

    /// Whether a sample is on the boundary.
    pub(super) fn passes(&self, sample: u32) -> bool {
        self.ways[sample as usize] != 0
    }

    /// The loops, by their first samples in raster order. Each turns as far left as it can wherever it may choose, so that
    /// the ground to the left of every corner is one wedge.
    pub(super) fn loops(&self) -> Vec<Vec<Step>> {
        let mut left = self.ways.clone();
        let mut loops = Vec::new();
        for sample in 0..left.len() as u32 {
            while left[sample as usize] != 0 {
                let way = left[sample as usize].trailing_zeros() as u8;
                let first = Step { sample, way };
                let (mut steps, mut step) = (Vec::new(), first);
                loop {
                    left[step.sample as usize] &= !(1 << step.way);
                    steps.push(step);
                    step = self.after(step);
                    if step == first {
                        break;
                    }
                }
                loops.push(steps);
            }
        }
        loops
    }

    fn after(&self, Step { sample, way }: Step) -> Step {
        let (dx, dy) = WAYS[way as usize];
        let sample = (sample as i32 + dy * self.width as i32 + dx) as u32;
        // From a turn back to the left, by way of straight on, to a turn back to the right.
        let on = (0..7).map(|turn| (way + 3 + 8 - turn) % 8).find(|way| self.ways[sample as usize] >> way & 1 == 1);
        Step { sample, way: on.unwrap_or_else(|| panic!("the boundary ends at sample {sample}")) }
    }
}

fn has_upper_edge(cell: Cell) -> bool {
    !matches!(cell, Cell::Empty | Cell::Without(0 | 1))
}

fn has_right_edge(cell: Cell) -> bool {
    !matches!(cell, Cell::Empty | Cell::Without(1 | 2))
}

fn has_lower_edge(cell: Cell) -> bool {
    !matches!(cell, Cell::Empty | Cell::Without(2 | 3))
}

fn has_left_edge(cell: Cell) -> bool {
    !matches!(cell, Cell::Empty | Cell::Without(3 | 0))
}

/// The eighths of the disk around a sample that are ground: bit i from way i to the next.
pub(super) fn octants(validity: &Validity, column: i32, row: i32) -> u8 {
    if !validity.is_valid(column, row) {
        return 0;
    }
    // The corner of each quadrant's cell at the sample, and the one before it: what lies first as one turns left.
    let quadrants = [(0, 0, 0), (-1, 0, 1), (-1, -1, 2), (0, -1, 3)];
    quadrants.into_iter().enumerate().fold(0, |octants, (quadrant, (dx, dy, own))| {
        let both = match validity.cell(column + dx, row + dy) {
            Cell::Empty => 0,
            Cell::Whole => 0b11,
            // The corner opposite leaves the quadrant whole, those beside it one eighth.
            Cell::Without(corner) => match (corner + 4 - own) % 4 {
                1 => 0b10,
                3 => 0b01,
                _ => 0b11,
            },
        };
        octants | both << (2 * quadrant)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Window;
    use crate::base::{Heights, Tile};
    use crate::field::Field;

    fn tile(width: usize, rows: &[&str]) -> Tile {
        let heights = rows.concat().bytes().map(|b| if b == b'.' { f32::NAN } else { 1.0 }).collect();
        let field = Field::from_heights(width, rows.len(), Heights::F32(heights)).expect("a field");
        let mut tile = Tile::default();
        field.load(Window { column: 0, row: 0, width, height: rows.len() }, &mut tile).expect("loads");
        tile
    }

    fn loops(tile: &Tile) -> Vec<Vec<u32>> {
        let boundary = Boundary::new(tile.validity(), tile.width(), tile.height());
        boundary.loops().into_iter().map(|l| l.into_iter().map(|s| s.sample).collect()).collect()
    }

    #[test]
    fn half_cells_are_cut_along_their_third_side() {
        for (rows, triangle) in [
            ([".x", "xx"], vec![1, 3, 2]),
            (["x.", "xx"], vec![0, 3, 2]),
            (["xx", "x."], vec![0, 1, 2]),
            (["xx", ".x"], vec![0, 1, 3]),
        ] {
            assert_eq!(loops(&tile(2, &rows)), [triangle]);
        }
    }

    #[test]
    fn a_missing_sample_is_a_diamond_and_two_of_them_touch() {
        assert_eq!(loops(&tile(5, &["xxxxx", "xxxxx", "xx.xx", "xxxxx", "xxxxx"]))[1], [7, 11, 17, 13]);
        // Diamonds that share a sample are one loop.
        let both = loops(&tile(7, &["xxxxxxx", "xxxxxxx", "xx.x.xx", "xxxxxxx", "xxxxxxx"]));
        assert_eq!((both.len(), both[1].len()), (2, 8));
    }

    #[test]
    fn octants_of_a_sample() {
        let tile = tile(3, &["xxx", "xx.", "xxx"]);
        assert_eq!(octants(tile.validity(), 1, 1), 0b0111_1110);
        assert_eq!(octants(tile.validity(), 2, 2), 0b0001_0000);
        assert_eq!(octants(tile.validity(), 2, 0), 0b0000_1000);
        assert_eq!(octants(tile.validity(), 2, 1), 0);
        assert_eq!(octants(tile.validity(), 1, 2), 0b1111_0000);
    }
}
