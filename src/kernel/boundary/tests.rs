//! Simplified rims of voids against naive ones.

use proptest::prelude::*;

use super::ear::{Ear, Occupied};
use super::*;
use crate::base::Heights;
use crate::base::Window;
use crate::base::lattice::orient;
use crate::field::Field;

/// A window of a raster in which `.` is missing and all other heights are 1.
fn tile(rows: &[String], window: Window) -> Tile {
    let heights = rows.concat().bytes().map(|b| if b == b'.' { f32::NAN } else { 1.0 }).collect();
    let field = Field::from_heights(rows[0].len(), rows.len(), Heights::F32(heights)).expect("a field");
    let mut tile = Tile::default();
    field.load(window, &mut tile).expect("loads");
    tile
}

fn text(width: usize, height: usize, is_missing: impl Fn(usize, usize) -> bool) -> Vec<String> {
    let row = |row| (0..width).map(|column| if is_missing(column, row) { '.' } else { 'x' }).collect();
    (0..height).map(row).collect()
}

struct Places(Vec<(i32, i32)>);

impl Occupied for Places {
    fn is_occupied(&self, column: i32, row: i32) -> bool {
        self.0.contains(&(column, row))
    }
}

/// Whether the interior of a triangle with positive orientation meets that of a cell: if no side of either parts them.
fn meets_cell(corners: [Point; 3], (column, row): (i32, i32)) -> bool {
    let cell = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(dx, dy)| Point::of_sample(column + dx, row + dy));
    let parts = |a: Point, b: Point, others: &[Point]| others.iter().all(|&p| orient(a, b, p) <= 0);
    !(0..3).any(|i| parts(corners[i], corners[(i + 1) % 3], &cell))
        && !(0..4).any(|i| parts(cell[i], cell[(i + 1) % 4], &corners))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn an_ear_takes_what_lies_in_it(
        places in prop::array::uniform3((0i32..14, 0i32..11)), missing in prop::collection::vec((0usize..14, 0usize..11), 0..5),
        occupied in prop::collection::vec((0i32..14, 0i32..11), 0..3), cells in 1u32..9,
    ) {
        let mut corners = places.map(|(column, row)| Point::of_sample(column, row));
        let area = orient(corners[0], corners[1], corners[2]);
        prop_assume!(area != 0);
        if area < 0 {
            corners.swap(0, 2);
        }
        let rows = text(14, 11, |column, row| missing.contains(&(column, row)));
        let tile = tile(&rows, Window { column: 0, row: 0, width: 14, height: 11 });
        let strip = Strip::new(&tile, cells);
        let near = |(column, row): (i32, i32)| {
            let away = |&(c, r): &(usize, usize)| (c as i32 - column).abs().max((r as i32 - row).abs());
            missing.iter().any(|place| away(place) <= cells as i32)
        };
        let [before, tip, after] = corners;
        let inside = |p: Point| (0..3).all(|i| orient(corners[i], corners[(i + 1) % 3], p) >= 0);
        let (mut lost, mut may_go) = (0, true);
        for place in (0..11).flat_map(|row| (0..14).map(move |column| (column, row))) {
            let p = Point::of_sample(place.0, place.1);
            if inside(p) {
                may_go &= corners.contains(&p) || !occupied.contains(&place);
                if orient(before, after, p) != 0 {
                    lost += 1;
                    may_go &= near(place);
                }
            }
            if place.0 < 13 && place.1 < 10 && meets_cell(corners, place) {
                may_go &= [(0, 0), (1, 0), (0, 1), (1, 1)].iter().any(|d| near((place.0 + d.0, place.1 + d.1)));
            }
        }
        let found = Ear { before, tip, after }.samples_lost(&strip, &Places(occupied));
        prop_assert_eq!(found, may_go.then_some(lost));
    }

    #[test]
    fn the_strip_is_what_is_near(
        missing in prop::collection::vec((0usize..12, 0usize..9), 0..6), cells in 1u32..6,
        (column, row) in (0usize..6, 0usize..5), (width, height) in (2usize..7, 2usize..5),
    ) {
        let rows = text(12, 9, |column, row| missing.contains(&(column, row)));
        let tile = tile(&rows, Window { column, row, width, height });
        let strip = Strip::new(&tile, cells);
        // Of the samples beyond the window, those beside it are known.
        let known = |&(c, r): &(usize, usize)| (column..=column + width + 1).contains(&(c + 1)) && (row..=row + height + 1).contains(&(r + 1));
        for (c, r) in (0..height).flat_map(|r| (0..width).map(move |c| (c, r))) {
            let away = |&(mc, mr): &(usize, usize)| (column + c).abs_diff(mc).max((row + r).abs_diff(mr));
            let near = missing.iter().filter(|m| known(m)).any(|m| away(m) <= cells as usize);
            prop_assert_eq!(strip.has(c as i32, r as i32), near, "{}, {}", c, r);
        }
    }
}
