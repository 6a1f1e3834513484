//! The samples near missing ones: what may be lost.

use crate::base::{Tile, Validity};

/// The samples of a tile that are near one without a height, by columns and rows, as far as the tile knows: of
/// the samples beyond its window it knows those next to it. Outside of the raster nothing is missing.
///
/// Memory: one byte per sample, and one more while it is made.
#[derive(Debug)]
pub struct Strip<'a> {
    width: usize,
    flags: Vec<bool>,
    validity: &'a Validity,
}

impl Strip<'_> {
    /// The strip of this many cells. Four passes over the samples.
    pub fn new(tile: &Tile, cells: u32) -> Strip<'_> {
        let (width, height) = (tile.width(), tile.height());
        // With the samples around the window: first along rows, then along columns.
        let mut along = vec![false; width * (height + 2)];
        for (row, flags) in (-1..=height as i32).zip(along.chunks_exact_mut(width)) {
            mark_along(tile, row, cells, flags);
        }
        let mut flags = vec![false; width * height];
        let mut since = vec![u32::MAX; width];
        for row in 0..height + 2 {
            mark_across(&along, row, cells, &mut since, &mut flags);
        }
        since.fill(u32::MAX);
        for row in (0..height + 2).rev() {
            mark_across(&along, row, cells, &mut since, &mut flags);
        }
        Strip { width, flags, validity: tile.validity() }
    }

    /// Whether a sample of the window is in it.
    pub fn has(&self, column: i32, row: i32) -> bool {
        self.flags[row as usize * self.width + column as usize]
    }

    /// Whether a sample is one of a bridged hole: it has no height to lose.
    pub(super) fn is_bridged(&self, column: i32, row: i32) -> bool {
        self.validity.is_bridged(column, row)
    }

    /// Whether a corner of the cell to the lower right of a sample is in it.
    pub fn has_cell(&self, column: i32, row: i32) -> bool {
        [(0, 0), (1, 0), (0, 1), (1, 1)].iter().any(|&(dx, dy)| self.has(column + dx, row + dy))
    }
}

/// Marks what of a row is near a missing sample of the row.
fn mark_along(tile: &Tile, row: i32, cells: u32, flags: &mut [bool]) {
    let (width, validity) = (tile.width() as i32, tile.validity());
    let [left, above, right, below] = validity.beyond();
    if row < 0 && !above || row == tile.height() as i32 && !below {
        return;
    }
    let is_missing = |column: i32| match column {
        -1 if !left => false,
        column if column == width && !right => false,
        column => !validity.is_valid(column, row),
    };
    let mut mark = |columns: &mut dyn Iterator<Item = i32>| {
        let mut since = u32::MAX;
        for column in columns {
            since = if is_missing(column) { 0 } else { since.saturating_add(1) };
            if (0..width).contains(&column) && since <= cells {
                flags[column as usize] = true;
            }
        }
    };
    mark(&mut (-1..=width));
    mark(&mut (-1..=width).rev());
}

/// Marks what of a row is near something marked in the rows that have been seen, this one among them.
fn mark_across(along: &[bool], row: usize, cells: u32, since: &mut [u32], flags: &mut [bool]) {
    let width = since.len();
    let inside = row.checked_sub(1).and_then(|row| flags.get_mut(row * width..(row + 1) * width));
    for (since, is_near) in since.iter_mut().zip(&along[row * width..]) {
        *since = if *is_near { 0 } else { since.saturating_add(1) };
    }
    for (flag, since) in inside.into_iter().flatten().zip(since) {
        *flag |= *since <= cells;
    }
}
