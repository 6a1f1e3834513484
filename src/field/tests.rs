//! Fields of every way to the samples give the same tiles.

use gdal::DriverManager;
use gdal::raster::{Buffer, RasterCreationOptions};
use proptest::prelude::*;

use super::*;
use crate::base::control::Control;
use crate::base::{Heights, Tile, Window};
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
    for choice in [Choice::Windows, Choice::Decode, Choice::Auto] {
        let options = FieldOptions { choice, ..FieldOptions::default() };
        let field = Field::open(&raster.to_band().expect("a band"), &options, &Control::default()).expect("a field");
        let mut tile = Tile::default();
        for (column, row, width, height) in [(0, 0, 300, 200), (60, 50, 40, 81), (100, 52, 20, 20), (0, 0, 50, 50)] {
            field.load(window(column, row, width, height), &mut tile).expect("heights");
            let left = column.saturating_sub(1)..(column + width + 1).min(300);
            let whole = left.clone().all(|c| (row.max(1) - 1..(row + height + 1).min(200)).all(|r| !is_missing(c, r)));
            assert_eq!(tile.validity().is_whole(), whole, "{choice:?} at {column}, {row}");
            for (c, r) in left.flat_map(|c| (row.max(1) - 1..(row + height + 1).min(200)).map(move |r| (c, r))) {
                let (x, y) = (c as i32 - column as i32, r as i32 - row as i32);
                assert_eq!(tile.validity().is_valid(x, y), !is_missing(c, r), "{choice:?}: sample {c}, {r}");
            }
            for (c, r) in (0..width).flat_map(|c| (0..height).map(move |r| (c, r))) {
                let expected = if is_missing(column + c, row + r) { 0 } else { at(column + c, row + r) % 97 };
                assert_eq!(tile.at(c, r), expected as f64);
            }
        }
    }
}
