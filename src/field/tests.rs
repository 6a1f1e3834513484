//! Fields of every way to the samples give the same tiles.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use gdal::DriverManager;
use gdal::raster::{Buffer, RasterCreationOptions};
use proptest::prelude::*;

use super::*;
use crate::base::control::Control;
use crate::base::{Band, Heights, RasterError, SampleType, Tile, Window, Windows};
use crate::raster::Raster;

fn window(column: usize, row: usize, width: usize, height: usize) -> Window {
    Window { column, row, width, height }
}

#[test]
fn marks_nan_and_refuses_infinite_and_misshapen() {
    let field = |v: Vec<f64>| Field::from_heights(2, 2, Heights::F64(v));
    let load = |v| field(v).expect("a shape").load(window(0, 0, 2, 2), &mut Tile::default());
    let mut tile = Tile::default();
    let hole = field(vec![-7.0, 1.0, f64::NAN, 2.0]).expect("a shape");
    hole.load(window(0, 0, 2, 2), &mut tile).expect("a hole");
    assert!(!tile.validity().is_whole() && !tile.validity().is_valid(0, 1) && tile.validity().is_valid(1, 1));
    assert_eq!((tile.at(0, 1), tile.at(0, 0), tile.at(1, 1)), (0.0, -7.0, 2.0));
    // Where it lies beside the window, the window is whole in itself only.
    hole.load(window(0, 0, 2, 1), &mut tile).expect("heights");
    assert!(!tile.validity().is_whole() && tile.validity().row(0) == [true, true]);
    field(vec![0.0; 4]).expect("a shape").load(window(0, 0, 2, 2), &mut tile).expect("heights");
    assert!(tile.validity().is_whole());
    assert!(
        matches!(load(vec![0.0, -f64::INFINITY, 0.0, 0.0]), Err(FieldError::NotAHeight(s)) if (s.column, s.row) == (1, 0))
    );
    assert!(matches!(load(vec![0.0, 0.0, 0.0, 2e30]), Err(FieldError::NotAHeight(s)) if (s.column, s.row) == (1, 1)));
    assert!(matches!(field(vec![0.0; 3]), Err(FieldError::Shape { found: 3, .. })));
}

/// Found by the fuzzer of jobs: what lay beyond the limit by rounding was refused only beside a hole.
#[test]
fn singles_just_beyond_the_limit_are_refused_whatever_lies_beside_them() {
    for beside in [0.0, f32::NAN] {
        let heights = Heights::F32(vec![1e30, beside, 0.0, 0.0]);
        let field = Field::from_heights(2, 2, heights).expect("a shape");
        let loaded = field.load(window(0, 0, 2, 2), &mut Tile::default());
        assert!(matches!(loaded, Err(FieldError::NotAHeight(s)) if (s.column, s.row) == (0, 0)));
    }
}

proptest! {
    #[test]
    fn a_window_is_what_the_array_holds(
        width in 2usize..20, height in 2usize..20, seed in any::<u32>(), corner in any::<(u16, u16, u16, u16)>(),
    ) {
        let heights: Vec<f32> = (0..width * height).map(|i| (i as u32 ^ seed) as u16 as f32).collect();
        let field = Field::from_heights(width, height, Heights::F32(heights.clone())).unwrap();
        let (c, r) = (corner.0 as usize % width, corner.1 as usize % height);
        let w = window(c, r, 1 + corner.2 as usize % (width - c), 1 + corner.3 as usize % (height - r));
        let mut tile = Tile::default();
        field.load(w, &mut tile).unwrap();
        for row in 0..w.height {
            for column in 0..w.width {
                prop_assert_eq!(tile.at(column, row) as f32, heights[(r + row) * width + c + column]);
            }
        }
    }
}

/// A raster with a hole by its tag, one by NaN and one by a mask, and an infinity behind the mask.
#[test]
fn masks_tags_and_nan_mark_the_same_samples_whichever_way_they_are_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let (path, size) = (folder.path().join("masked.tif"), (300, 200));
    let options: RasterCreationOptions = ["TILED=YES", "BLOCKXSIZE=64", "BLOCKYSIZE=64"].into_iter().collect();
    let driver = DriverManager::get_driver_by_name("GTiff").expect("GTiff");
    let dataset = driver.create_with_band_type_with_options::<f32, _>(&path, size.0, size.1, 1, &options);
    let dataset = dataset.expect("a raster");
    let mut heights: Vec<f32> = (0..size.0 * size.1).map(|i| (i % 97) as f32).collect();
    let at = |column: usize, row: usize| row * size.0 + column;
    heights[at(99, 70)] = f32::NAN;
    heights[at(120, 51)] = -9999.0;
    let mut mask = vec![255u8; heights.len()];
    for column in 64..80 {
        (heights[at(column, 130)], mask[at(column, 130)]) = (f32::INFINITY, 0);
    }
    let mut band = dataset.rasterband(1).expect("a band");
    band.write((0, 0), size, &mut Buffer::new(size, heights)).expect("written");
    band.create_mask_band(true).expect("a mask");
    band.open_mask_band().expect("a mask").write((0, 0), size, &mut Buffer::new(size, mask)).expect("written");
    dataset.close().expect("closed");
    let raster = Raster::open(&path, 1).expect("opens").with_nodata(&["-9999".to_string()]).expect("a value");
    assert!(raster.has_mask().expect("told"));
    let is_missing = |column: usize, row: usize| {
        [(99, 70), (120, 51)].contains(&(column, row)) || row == 130 && (64..80).contains(&column)
    };
    let ways = [(Choice::Windows, false), (Choice::Decode, false), (Choice::Decode, true), (Choice::Auto, false)];
    for (choice, in_parts) in ways {
        let options = FieldOptions { choice, in_parts, ..FieldOptions::default() };
        let field = Field::open(&raster.to_band().expect("a band"), &options, &Control::default()).expect("a field");
        let mut tile = Tile::default();
        for (column, row, width, height) in [(0, 0, 300, 200), (60, 50, 40, 81), (100, 52, 20, 20), (0, 0, 50, 50)] {
            field.load(window(column, row, width, height), &mut tile).expect("heights");
            let left = column.saturating_sub(1)..(column + width + 1).min(300);
            let whole = left.clone().all(|c| (row.max(1) - 1..(row + height + 1).min(200)).all(|r| !is_missing(c, r)));
            assert_eq!(tile.validity().is_whole(), whole, "{options:?} at {column}, {row}");
            for (c, r) in left.flat_map(|c| (row.max(1) - 1..(row + height + 1).min(200)).map(move |r| (c, r))) {
                let (x, y) = (c as i32 - column as i32, r as i32 - row as i32);
                assert_eq!(tile.validity().is_valid(x, y), !is_missing(c, r), "{options:?}: sample {c}, {r}");
            }
            for (c, r) in (0..width).flat_map(|c| (0..height).map(move |r| (c, r))) {
                let expected = if is_missing(column + c, row + r) { 0 } else { at(column + c, row + r) % 97 };
                assert_eq!(tile.at(c, r), expected as f64);
            }
        }
    }
}

/// Heights of column + row, in blocks of 64 × 64, that count the samples they are asked for, and of which some may not be had.
#[derive(Default)]
struct Counted {
    asked: AtomicU64,
    is_away: AtomicBool,
}

impl Windows for Counted {
    fn read(&self, window: Window, out: &mut [u8]) -> Result<(), RasterError> {
        let Window { column, row, width, height } = window;
        if self.is_away.load(Ordering::Relaxed) {
            let (path, reason) = ("far.tif".into(), "no answer".to_string());
            return Err(RasterError::Read { path, column, row, width, height, reason });
        }
        self.asked.fetch_add(window.len() as u64, Ordering::Relaxed);
        for (i, sample) in out.chunks_exact_mut(8).enumerate() {
            sample.copy_from_slice(&((column + i % width + row + i / width) as f64).to_ne_bytes());
        }
        Ok(())
    }
}

#[test]
fn of_a_raster_in_parts_each_is_read_once_and_the_others_never() {
    let (counted, size) = (Arc::new(Counted::default()), (5000, 3000));
    let band = Band::new("far.tif", size, SampleType::F64, counted.clone()).expect("a band").with_blocks(64, 64);
    let options = FieldOptions { choice: Choice::Decode, in_parts: true, ..FieldOptions::default() };
    let field = Field::open(&band, &options, &Control::default()).expect("a field");
    assert_eq!(counted.asked.load(Ordering::Relaxed), 0);
    let check = |at: Window| {
        let mut tile = Tile::default();
        let loaded = field.load(at, &mut tile);
        let right = (0..at.len()).all(|i| {
            let (column, row) = (i % at.width, i / at.width);
            loaded.is_err() || tile.at(column, row) == (at.column + column + at.row + row) as f64
        });
        assert!(right, "{at:?}");
        loaded
    };
    // No answer, and nothing is taken for read.
    counted.is_away.store(true, Ordering::Relaxed);
    let error = check(window(1000, 1000, 300, 300)).expect_err("no answer").to_string();
    assert!(error.contains("far.tif") && error.contains("no answer"), "{error}");
    counted.is_away.store(false, Ordering::Relaxed);
    // Windows by windows, in the part from row 1000 on, by several threads at the same time.
    let windows = || (0..64).map(|i| window(i % 8 * 600, 1000 + i / 8 * 30, 700, 100));
    std::thread::scope(|scope| {
        for _ in 0..3 {
            scope.spawn(|| windows().for_each(|at| check(at).expect("heights")));
        }
    });
    let asked = counted.asked.load(Ordering::Relaxed);
    let rows = asked / size.0 as u64;
    assert!((310..=310 + 2 * 64).contains(&rows) && asked % size.0 as u64 == 0, "{asked} samples");
    check(window(0, 0, 5000, 3000)).expect("heights");
    assert_eq!(counted.asked.load(Ordering::Relaxed), 15_000_000);
}
