//! How high the raster's own samples are in tiles: heights of the format have to reach them.

use std::collections::BTreeMap;

use super::band;
use super::store::{OwnStore, Rectangle};
use crate::pyramid::error::PyramidError;
use crate::pyramid::grid::{Grid, TileKey};
use crate::pyramid::quantize::Relief;

/// Cells of the grid along a square whose samples are read at a time.
const PIECE: f64 = 256.0;

/// The least and the greatest height of the samples that may become vertices of a tile.
pub(in crate::pyramid) fn relief(own: &OwnStore, grid: Grid, tile: TileKey) -> Result<Option<Relief>, PyramidError> {
    let (first, last) = ends(grid, tile);
    let band = band(grid.cells(tile.level));
    let all = Rectangle { columns: (first.0 - band, last.0 + band), rows: (first.1 - band, last.1 + band) };
    of(own, all)
}

/// Adds the samples beside tiles that may become vertices of their sides, for all levels above the finest, whose own samples
/// they have from there.
pub(in crate::pyramid) fn widen(
    own: &OwnStore,
    grid: Grid,
    reliefs: &mut [BTreeMap<TileKey, Relief>],
) -> Result<(), PyramidError> {
    let coarser = reliefs.len().saturating_sub(1);
    for (&tile, relief) in reliefs[..coarser].iter_mut().flatten() {
        let ((left, top), (right, bottom)) = ends(grid, tile);
        let band = band(grid.cells(tile.level));
        let beside = |at: f64| (at - band, at + band);
        let (across, down) = ((left - band, right + band), (top - band, bottom + band));
        for (columns, rows) in
            [(across, beside(top)), (across, beside(bottom)), (beside(left), down), (beside(right), down)]
        {
            *relief = of(own, Rectangle { columns, rows })?.map_or(*relief, |found| relief.with(found));
        }
    }
    Ok(())
}

/// A tile's first and last columns and rows.
fn ends(grid: Grid, tile: TileKey) -> ((f64, f64), (f64, f64)) {
    let ((column, row), cells) = (tile.origin(grid), grid.cells(tile.level));
    ((column as f64, row as f64), ((column + cells) as f64, (row + cells) as f64))
}

fn of(own: &OwnStore, rectangle: Rectangle) -> Result<Option<Relief>, PyramidError> {
    let Rectangle { columns: (left, right), rows: (top, bottom) } = rectangle;
    let starts = |first: f64, last: f64| (0..=((last - first) / PIECE) as u64).map(move |i| first + i as f64 * PIECE);
    let (mut found, mut relief) = (Vec::new(), None);
    for (row, column) in starts(top, bottom).flat_map(|row| starts(left, right).map(move |column| (row, column))) {
        let (columns, rows) = ((column, right.min(column + PIECE)), (row, bottom.min(row + PIECE)));
        own.read(Rectangle { columns, rows }, &mut found)?;
        relief = relief.into_iter().chain(found.iter().map(|sample| Relief::of(sample.height))).reduce(Relief::with);
    }
    Ok(relief)
}
