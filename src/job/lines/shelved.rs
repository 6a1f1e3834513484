//! Lines in temporary files: their pieces sorted, noded strip by strip, and found again by place.
//!
//! Noding goes on in rounds, as it does in memory. A round takes the strips from the top. What of a strip is led where depends on the strip
//! and a row of cells on either side, as they were before the round; so the last row of cells of the strip above is kept as it was.
//! Strips with nothing new around them stay as they are. Places and pieces of all rounds are those that memory would have had.

use std::ops::Range;
use std::sync::Arc;

use crate::base::external::{Scratch, ScratchError, Shelves, Sorter};
use crate::base::lattice::STEPS;
use crate::base::tiling::TileGrid;
use crate::job::chains::in_bands;
use crate::kernel::breaklines::Breaklines;
use crate::kernel::breaklines::strips::{self, PieceRecord, ROWS, Strips, Summary, Tally};

/// Columns of the lattice whose pieces are in one list.
const COLUMNS: i64 = 256 * STEPS as i64;

/// Bytes of pieces in memory; tests go to the file.
const IN_MEMORY: usize = if cfg!(test) { 4 << 10 } else { 8 << 20 };

/// What a band of tiles takes for each of its segments, while its chains are found.
const PER_SEGMENT: u64 = 260;

/// And for each in the bands beside it.
const PER_SEGMENT_BESIDE: u64 = 64;

/// What lines take beside that: lists in memory, those of chains, and what each thread has of them in its tile.
const FIXED: u64 = 24 << 20;

/// Pieces while lines are cut.
pub(super) struct Sorting<'s> {
    scratch: &'s Scratch,
    sorter: Sorter<'s, 6>,
}

impl<'s> Sorting<'s> {
    pub(super) fn new(scratch: &'s Scratch) -> Sorting<'s> {
        Sorting { scratch, sorter: Sorter::new(scratch, IN_MEMORY) }
    }

    pub(super) fn push(&mut self, piece: PieceRecord) -> Result<(), ScratchError> {
        self.sorter.push(piece)
    }

    /// All pieces noded.
    pub(super) fn finish(
        self,
        mut strips: Strips,
        (_, height): (usize, usize),
    ) -> Result<(Shelved, Summary), ScratchError> {
        let count = ((height as i64 * i64::from(STEPS)) / ROWS + 1) as u32;
        let mut shelved = Shelved { shelves: Shelves::new(self.scratch.clone(), IN_MEMORY), strips: None, count };
        let (mut strip, mut number) = (Vec::new(), 0);
        for piece in self.sorter.finish()? {
            let piece = piece?;
            if strip_of(&piece) != number {
                shelved.put(number, &mut strip)?;
                number = strip_of(&piece);
            }
            strip.push(piece);
            if strip.len() > 1 << 16 {
                Strips::join(&mut strip);
            }
        }
        shelved.put(number, &mut strip)?;
        let mut is_new = vec![true; count as usize];
        while is_new.iter().any(|is_new| *is_new) {
            is_new = shelved.round(&is_new)?;
        }
        let mut tally = Tally::default();
        let mut touching = Vec::new();
        for number in 0..count {
            let mut records = std::mem::take(&mut touching);
            let strip = shelved.strip(number)?;
            records.extend_from_slice(&strip);
            let rows = i64::from(number) * ROWS..(i64::from(number) + 1) * ROWS;
            touching = strip.into_iter().filter(|piece| strips::high(piece).y == rows.end).collect();
            tally.add(&mut strips, rows, &records);
        }
        let summary = tally.finish(&strips);
        Ok((Shelved { strips: Some(strips), ..shelved }, summary))
    }
}

/// Noded pieces of lines by strips and columns.
#[derive(Debug)]
pub(super) struct Shelved {
    shelves: Shelves<6>,
    /// Once all pieces are noded.
    strips: Option<Strips>,
    /// How many strips there are.
    count: u32,
}

fn strip_of(piece: &PieceRecord) -> u32 {
    (strips::low(piece).y / ROWS) as u32
}

impl Shelved {
    fn put(&mut self, number: u32, strip: &mut Vec<PieceRecord>) -> Result<(), ScratchError> {
        Strips::join(strip);
        let column = |piece: &PieceRecord| (strips::low(piece).x / COLUMNS) as u32;
        let there: Vec<u32> = self.shelves.row(number).map(|(_, column)| column).collect();
        // The order within a list stays.
        strip.sort_by_key(column);
        for gone in there.iter().filter(|gone| strip.binary_search_by_key(*gone, column).is_err()) {
            self.shelves.put((number, *gone), &[])?;
        }
        for list in strip.chunk_by(|a, b| column(a) == column(b)) {
            self.shelves.put((number, column(&list[0])), list)?;
        }
        strip.clear();
        Ok(())
    }

    /// The pieces of a strip, in order.
    fn strip(&self, number: u32) -> Result<Vec<PieceRecord>, ScratchError> {
        let mut records = Vec::new();
        self.shelves.row(number).try_for_each(|list| self.shelves.get(list, &mut records))?;
        records.sort_unstable();
        Ok(records)
    }

    /// Leads all pieces once, and tells which strips have changed. Those do not whose surroundings have not.
    fn round(&mut self, is_new: &[bool]) -> Result<Vec<bool>, ScratchError> {
        let mut has_changed = vec![false; is_new.len()];
        let near = |i: usize| is_new[i.saturating_sub(1)..(i + 2).min(is_new.len())].contains(&true);
        // The strip above as it was, if it has been looked at, and what has come to lie on the line between.
        let (mut above, mut come): (Option<Vec<PieceRecord>>, Vec<PieceRecord>) = (None, Vec::new());
        for number in 0..self.count {
            let i = number as usize;
            if !near(i) && come.is_empty() {
                above = None;
                continue;
            }
            let end = (i64::from(number) + 1) * ROWS;
            let strip = self.strip(number)?;
            let last_row = |strip: Vec<PieceRecord>, end: i64| {
                let is_last = |piece: &PieceRecord| strips::high(piece).y > end - i64::from(STEPS);
                strip.into_iter().filter(is_last).collect::<Vec<_>>()
            };
            let mut led = strip.clone();
            if near(i) {
                let over = match above.take() {
                    Some(over) => over,
                    None if number > 0 => last_row(self.strip(number - 1)?, end - ROWS),
                    None => Vec::new(),
                };
                let mut below = if number + 1 < self.count { self.strip(number + 1)? } else { Vec::new() };
                below.retain(|piece| strips::low(piece).y < end + i64::from(STEPS));
                led = Strips::lead(&over, &strip, &below);
            }
            led.append(&mut come);
            Strips::join(&mut led);
            come = led.split_off(led.partition_point(|piece| strips::low(piece).y < end));
            if led != strip {
                has_changed[i] = true;
                self.put(number, &mut led)?;
            }
            above = Some(last_row(strip, end));
        }
        Ok(has_changed)
    }

    /// The lines whose pieces are in these rows and columns of the lattice, and some others.
    pub(super) fn lines(&self, rows: Range<i64>, columns: Range<i64>) -> Result<Arc<Breaklines>, ScratchError> {
        let strips = self.strips.as_ref().expect("noded pieces");
        let range =
            |range: Range<i64>, count: i64| (range.start / count) as u32..=(range.end / count).min(1 << 31) as u32;
        let (rows, lists) = (rows, range(columns.clone(), COLUMNS));
        let mut records = Vec::new();
        for number in range(rows.clone(), ROWS).take_while(|number| *number < self.count) {
            for list in self.shelves.row(number).filter(|(_, column)| lists.contains(column)) {
                let before = records.len();
                self.shelves.get(list, &mut records)?;
                let mut kept = before;
                for i in before..records.len() {
                    let [low, high] = [strips::low(&records[i]), strips::high(&records[i])];
                    if high.y >= rows.start
                        && low.y <= rows.end
                        && low.x >= columns.start - COLUMNS
                        && low.x <= columns.end
                    {
                        records.swap(kept, i);
                        kept += 1;
                    }
                }
                records.truncate(kept);
            }
        }
        Ok(Arc::new(strips.lines(&records)))
    }

    /// The memory that they and their chains take in a run over the tiles of a grid.
    pub(super) fn bytes(&self, grid: &TileGrid) -> u64 {
        let of_strip = |number: u32| self.shelves.row(number).map(|list| self.shelves.count(list) as u64).sum::<u64>();
        let segments: Vec<u64> = (0..self.count).map(of_strip).collect();
        let bands = in_bands(grid, ROWS, &segments);
        let of_band = |i: usize| {
            let beside = i.checked_sub(1).map_or(0, |above| bands[above]) + bands.get(i + 1).copied().unwrap_or(0);
            PER_SEGMENT * bands[i] + PER_SEGMENT_BESIDE * beside
        };
        FIXED + (0..bands.len()).map(of_band).max().unwrap_or(0)
    }
}
