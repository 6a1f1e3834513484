//! Vertices at the raster's rim. Beside it the surface falls to the height outside, along triangles that may be as steep as a cliff. Were such
//! a vertex rounded to the lattice of the format towards the raster, the sample that it stands for would be under one of those, and off
//! by the rounding times the steepness. So it is rounded away from the raster: samples of the raster then lie under triangles between them.
//!
//! A single row of samples has the height outside on both sides. Where it is in the way, the ground is continued by a cell on either. Only what is on
//! a line of tiles or parts stays as it is: beside such a line vertices are rounded towards it.

use super::lines::Vertex;
use super::quantize::{SPAN, coordinate};

/// Tiles of more cells have so few places for each that rounding by a whole one would cost more than a cliff does.
const MOST_CELLS: i64 = 4096;

/// Which way is away from the raster: −1, 0 or 1 along columns, and along rows.
pub(super) type Away = (i64, i64);

/// Whether vertices at the rim are rounded away from the raster in tiles this wide.
pub(super) fn counts(tile_cells: i64) -> bool {
    tile_cells <= MOST_CELLS
}

/// Which way is away from the raster at one of its samples, given which of those around it are samples of the raster: those before, beside and after it,
/// row by row, and which way a line of parts is that it is beside.
pub(super) fn away(inside: [bool; 9], line: Away) -> Away {
    let outside = (0..9i64).zip(inside).filter(|(_, inside)| !inside).map(|(i, _)| (i % 3 - 1, i / 3 - 1));
    let (columns, rows) = outside.fold((0, 0), |(c, r), (column, row)| (c + column, r + row));
    let is_outside_on_line = |step: i64, stride: i64| step != 0 && !inside[(4 + step * stride) as usize];
    (
        if is_outside_on_line(line.0, 1) { line.0 } else { columns.signum() },
        if is_outside_on_line(line.1, 3) { line.1 } else { rows.signum() },
    )
}

/// Which way the nearest line of parts is from a sample that is one cell away from it; no way from any other sample. Parts are `cells` wide.
pub(super) fn line_beside((column, row): (i64, i64), cells: i64) -> Away {
    let way = |at: i64| i64::from(at.rem_euclid(cells) == cells - 1) - i64::from(at.rem_euclid(cells) == 1);
    (way(column), way(row))
}

/// The same on a line, along it. Its ends are those of other lines, too, and stay.
pub(super) fn away_on_line(inside: &[bool], at: usize) -> i64 {
    let is_end = at == 0 || at + 1 == inside.len();
    match is_end || !inside[at] {
        true => 0,
        false => i64::from(inside[at - 1]) - i64::from(inside[at + 1]),
    }
}

/// The coordinate of a sample on a side of `cells` cells, rounded down, to the nearest, or up.
pub(super) fn rounded(at: i64, cells: i64, towards: i64) -> i64 {
    match towards {
        0 => coordinate(at, cells),
        -1 => at * SPAN / cells,
        _ => (at * SPAN + cells - 1) / cells,
    }
}

/// The same vertex, rounded away from the raster, unless it has a place of its own.
pub(super) fn moved(vertex: Vertex, (columns, rows): Away, tile_cells: i64) -> Vertex {
    let place = (rounded(vertex.column, tile_cells, columns), rounded(tile_cells - vertex.row, tile_cells, -rows));
    let is_moved = vertex.place.is_none() && place != vertex.coordinates(tile_cells);
    if is_moved { Vertex { place: Some(place), ..vertex } } else { vertex }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_rounded_away() {
        for cells in [2, 128, 4096] {
            for at in 0..=cells {
                let [down, nearest, up] = [-1, 0, 1].map(|towards| rounded(at, cells, towards));
                assert!(down * cells <= at * SPAN && at * SPAN <= up * cells && up - down <= 1);
                assert!(down == nearest || up == nearest);
            }
            assert_eq!([0, cells].map(|at| [-1, 1].map(|towards| rounded(at, cells, towards))), [[0; 2], [SPAN; 2]]);
        }
    }

    #[test]
    fn away_is_where_the_raster_is_not() {
        let around = |rows: [&str; 3]| away(std::array::from_fn(|i| rows[i / 3].as_bytes()[i % 3] == b'#'), (0, 0));
        assert_eq!(around(["###", "###", "###"]), (0, 0));
        assert_eq!(around(["##.", "##.", "##."]), (1, 0));
        assert_eq!(around(["...", "##.", "##."]), (1, -1));
        assert_eq!(around(["###", "###", ".##"]), (-1, 1));
        assert_eq!(around([".#.", ".#.", ".#."]), (0, 0));
        // A single row, or column, beside a line: towards that, if it is outside there.
        let beside =
            |rows: [&str; 3], line: Away| away(std::array::from_fn(|i| rows[i / 3].as_bytes()[i % 3] == b'#'), line);
        assert_eq!([1, -1].map(|way| beside(["...", "###", "..."], (0, way))), [(0, 1), (0, -1)]);
        assert_eq!([1, -1].map(|way| beside([".#.", ".#.", ".##"], (way, 0))), [(1, -1), (-1, -1)]);
        assert_eq!(beside(["...", "###", "###"], (0, 1)), (0, -1));
        let columns = [0, 1, 2, 31, 32, 33].map(|at| line_beside((at, 5), 32));
        assert_eq!(columns, [(0, 0), (-1, 0), (0, 0), (1, 0), (0, 0), (-1, 0)]);
        assert_eq!(line_beside((17, 15), 16), (-1, 1));
        let line = [false, true, true, true, false, true, false];
        assert_eq!([0, 1, 2, 3, 4, 5].map(|at| away_on_line(&line, at)), [0, -1, 0, 1, 0, 0]);
        assert_eq!([0, 2].map(|at| away_on_line(&[true, false, true], at)), [0, 0]);
    }
}
