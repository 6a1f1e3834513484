//! Filled voids against naive ones.

use std::collections::BTreeMap;

use proptest::prelude::*;

use super::*;
use crate::base::{Heights, Tile};

type Place = (usize, usize);

/// Which samples are bridged, and at what heights, by flood filling and by walking.
fn naive(width: usize, height: usize, heights: &[f64], most: usize) -> BTreeMap<Place, f64> {
    let at = |(column, row): Place| heights[row * width + column];
    let mut seen = vec![false; heights.len()];
    let mut bridged = BTreeMap::new();
    for start in 0..heights.len() {
        let (mut hole, mut open, mut is_at_edge) = (Vec::new(), vec![(start % width, start / width)], false);
        while let Some((column, row)) = open.pop() {
            if !at((column, row)).is_nan() || std::mem::replace(&mut seen[row * width + column], true) {
                continue;
            }
            hole.push((column, row));
            is_at_edge |= column == 0 || row == 0 || column + 1 == width || row + 1 == height;
            let columns = column.saturating_sub(1)..(column + 2).min(width);
            let rows = row.saturating_sub(1)..(row + 2).min(height);
            open.extend(columns.flat_map(|c| rows.clone().map(move |r| (c, r))));
        }
        if is_at_edge || hole.len() > most {
            continue;
        }
        for &(column, row) in &hole {
            let walk = |dx: isize, dy: isize| {
                let step =
                    |i: usize| (column.wrapping_add_signed(dx * i as isize), row.wrapping_add_signed(dy * i as isize));
                let distance = (1..).find(|&i| !at(step(i)).is_nan()).expect("a hole has an end");
                (at(step(distance)), distance as f64)
            };
            let ends = [walk(-1, 0), walk(1, 0), walk(0, -1), walk(0, 1)];
            let sum = ends.iter().fold(0.0, |sum, (z, d)| sum + z * (1.0 / (d * d)));
            let weights = ends.iter().fold(0.0, |sum, (_, d)| sum + 1.0 / (d * d));
            let [lowest, highest] = [f64::min as fn(f64, f64) -> f64, f64::max]
                .map(|pick| ends.iter().map(|end| end.0).reduce(pick).expect("four ends"));
            bridged.insert((column, row), (sum / weights).clamp(lowest, highest));
        }
    }
    bridged
}

fn options(most: usize) -> HoleOptions {
    HoleOptions { most: most as u64, memory_bytes: u64::MAX, temp_dir: std::env::temp_dir() }
}

fn windows(width: usize, height: usize, (across, down): (usize, usize)) -> Vec<Window> {
    let rows = (0..height).step_by(down);
    rows.flat_map(|row| (0..width).step_by(across).map(move |column| (column, row)))
        .map(|(column, row)| Window { column, row, width: across.min(width - column), height: down.min(height - row) })
        .collect()
}

fn field(width: usize, height: usize, heights: &[f64]) -> Field {
    Field::from_heights(width, height, Heights::F64(heights.to_vec())).expect("a field")
}

fn bridged(field: &Field, window: Window) -> BTreeMap<Place, f64> {
    let mut found = Vec::new();
    field.holes().map_or(Ok(()), |holes| holes.within(window, &mut found)).expect("read");
    let count = found.len();
    let found: BTreeMap<_, _> = found.iter().map(|b| ((b.column as usize, b.row as usize), b.height)).collect();
    assert_eq!(found.len(), count, "samples bridged twice");
    found
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    #[test]
    fn holes_are_those_of_a_flood_fill_however_they_are_read(
        (width, height) in (2usize..24, 2usize..24), seed in any::<u64>(), share in 1u64..10, most in 1usize..40,
        by in (1usize..26, 1usize..26), corner in (0usize..24, 0usize..24), blocky in any::<bool>(),
    ) {
        let noise = |i: u64| (i + 1).wrapping_mul(seed | 1).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40;
        let heights: Vec<f64> = (0..width * height).map(|i| {
            let place = if blocky { (i % width / 2 + 99 * (i / width / 3)) as u64 } else { i as u64 };
            if noise(place) % 10 < share { f64::NAN } else { (noise(i as u64 + 7) % 1000) as f64 / 8.0 }
        }).collect();
        let expected = naive(width, height, &heights, most);
        let field = field(width, height, &heights).bridged_by(&windows(width, height, by), &options(most), &Control::default());
        let field = field.expect("bridged");
        prop_assert_eq!(field.holes().map_or(0, Holes::samples), expected.len() as u64);
        prop_assert_eq!(bridged(&field, Window { column: 0, row: 0, width, height }), expected.clone());
        // A window and what is around it.
        let (column, row) = (corner.0 % width, corner.1 % height);
        let window = Window { column, row, width: (width - column).min(5), height: (height - row).min(7) };
        let mut tile = Tile::default();
        field.load(window, &mut tile).expect("loaded");
        let mut any = false;
        for (c, r) in (0..width).flat_map(|c| (0..height).map(move |r| (c, r))) {
            let (x, y) = (c as i32 - column as i32, r as i32 - row as i32);
            if x < -1 || y < -1 || x > window.width as i32 || y > window.height as i32 {
                continue;
            }
            let (z, filled) = (heights[r * width + c], expected.get(&(c, r)));
            prop_assert_eq!(tile.validity().is_valid(x, y), !z.is_nan() || filled.is_some());
            prop_assert_eq!(tile.validity().is_bridged(x, y), filled.is_some());
            prop_assert_eq!(tile.validity().is_whole() && z.is_nan(), false);
            if (0..window.width as i32).contains(&x) && (0..window.height as i32).contains(&y) {
                let at = tile.at(x as usize, y as usize);
                prop_assert_eq!(at, filled.copied().unwrap_or(if z.is_nan() { 0.0 } else { z }));
                prop_assert_eq!(tile.weight(x as usize, y as usize), if filled.is_some() { 0.0 } else { 1.0 });
                any |= filled.is_some();
            }
        }
        prop_assert_eq!(tile.is_weighted(), any);
    }
}

/// Two holes over several blocks of the store, more than waits in memory.
#[test]
fn large_holes_are_kept_on_disk() {
    let (width, height) = (1300, 1100);
    let mut heights: Vec<f64> = (0..width * height).map(|i| (i % width) as f64).collect();
    for (columns, rows) in [(100..700, 100..600), (800..1250, 500..1090)] {
        rows.for_each(|row: usize| heights[row * width..][columns.clone()].fill(f64::NAN));
    }
    let open = |most, memory_bytes| {
        let options = HoleOptions { memory_bytes, ..options(most) };
        field(width, height, &heights).with_holes_bridged(&options, &Control::default())
    };
    let whole = Window { column: 0, row: 0, width, height };
    let both = open(300_000, u64::MAX).expect("bridged");
    assert!(both.decoded_bytes() > 2_000_000);
    let found = bridged(&both, whole);
    assert_eq!(found.len(), 300_000 + 450 * 590);
    assert!(found.iter().all(|(_, z)| (99.0..1250.5).contains(z)));
    let smaller = open(299_999, u64::MAX).expect("bridged");
    assert_eq!(smaller.holes().map(|h| (h.count(), h.samples())), Some((1, 450 * 590)));
    // What is around them takes little, their heights take more.
    let refused = open(300_000, 1 << 20);
    assert!(matches!(refused, Err(FieldError::HolesTooLarge { row: 600, .. })), "{:?}", refused.err());
    assert!(open(1000, 1 << 20).expect("bridged").holes().is_none());
}
