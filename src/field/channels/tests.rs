//! Fields with attributes: values, names, ranges.

use std::path::{Path, PathBuf};

use gdal::raster::{Buffer, GdalType, RasterCreationOptions};

use super::*;
use crate::base::Tile;
use crate::base::channels::Number;

const SIZE: (usize, usize) = (70, 40);

/// Value of a sample in a band.
fn value(band: usize, column: usize, row: usize) -> f64 {
    ((column * 7 + row * 13 + band * 31) % 251) as f64
}

fn geotiff<T: GdalType + Copy>(
    folder: &Path,
    bands: usize,
    options: &[&str],
    adorn: impl FnOnce(&gdal::Dataset),
) -> PathBuf {
    let path = folder.join("bands.tif");
    let options: RasterCreationOptions = options.iter().copied().collect();
    let driver = gdal::DriverManager::get_driver_by_name("GTiff").expect("GTiff");
    let dataset = driver.create_with_band_type_with_options::<T, _>(&path, SIZE.0, SIZE.1, bands, &options);
    let dataset = dataset.expect("a raster");
    for band in 1..=bands {
        let values = (0..SIZE.0 * SIZE.1).map(|i| value(band, i % SIZE.0, i / SIZE.0)).collect();
        dataset.rasterband(band).expect("a band").write((0, 0), SIZE, &mut Buffer::new(SIZE, values)).expect("written");
    }
    adorn(&dataset);
    dataset.close().expect("closed");
    path
}

fn whole() -> Window {
    Window { column: 0, row: 0, width: SIZE.0, height: SIZE.1 }
}

fn options(path: &Path, bands: &[usize]) -> ChannelBands {
    let bands = bands.iter().map(|&number| crate::testing::band(path, number)).collect();
    ChannelBands { bands, emphasis: 0.5, planar: false }
}

#[test]
fn channels_are_loaded_beside_heights_whichever_way() {
    let folder = tempfile::tempdir().expect("a folder");
    for interleave in ["INTERLEAVE=BAND", "INTERLEAVE=PIXEL"] {
        let path = geotiff::<i16>(folder.path(), 4, &[interleave], |_| {});
        let raster = crate::testing::band(&path, 2);
        let channels = options(&path, &[4, 1]);
        let ranges = find_ranges(&raster, &channels, &Control::default()).expect("ranges");
        assert_eq!((ranges.heights, ranges.unit), (Range { min: 0.0, max: 250.0 }, 250.0));
        for choice in [Choice::Auto, Choice::Windows, Choice::Decode] {
            let field_options = FieldOptions { choice, ..FieldOptions::default() };
            let field = Field::open_extended(&raster, &field_options, &channels, &ranges, &Control::default());
            let (field, mut tile) = (field.expect("a field"), Tile::default());
            let window = Window { column: 3, row: 5, width: 50, height: 30 };
            field.load(window, &mut tile).expect("values");
            for (column, row) in [(0, 0), (49, 0), (17, 29), (49, 29)] {
                assert_eq!(tile.at(column, row), value(2, 3 + column, 5 + row));
                assert_eq!(tile.channel_at(0, column, row), value(4, 3 + column, 5 + row));
                assert_eq!(tile.channel_at(1, column, row), value(1, 3 + column, 5 + row));
            }
            let heights_only = Field::open(&raster, &field_options, &Control::default()).expect("a field");
            let mut plain = tile.clone();
            heights_only.load(window, &mut plain).expect("heights");
            assert!(plain.channels.is_empty() && plain.channel_error.is_none());
            assert_ne!(plain.checksum(), tile.checksum());
        }
    }
}

#[test]
fn a_planar_image_is_level_and_bytes_have_the_range_of_their_type() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = geotiff::<u8>(folder.path(), 3, &[], |_| {});
    let raster = crate::testing::band(&path, 1);
    let channels = ChannelBands { emphasis: 1.0, planar: true, ..options(&path, &[1, 2, 3]) };
    let ranges = find_ranges(&raster, &channels, &Control::default()).expect("ranges");
    assert_eq!((ranges.unit, ranges.channels[2]), (255.0, Range { min: 0.0, max: 255.0 }));
    let field = Field::open_extended(&raster, &FieldOptions::default(), &channels, &ranges, &Control::default());
    let (field, mut tile) = (field.expect("a field"), Tile::default());
    field.load(whole(), &mut tile).expect("values");
    assert_eq!((tile.at(69, 39), tile.channel_at(2, 69, 39)), (0.0, value(3, 69, 39)));
    let names: Vec<(&str, Number)> = field.channels().iter().map(|c| (c.name.as_str(), c.number)).collect();
    assert_eq!(names, [("red", Number::U8), ("green", Number::U8), ("blue", Number::U8)]);
    // Grey levels: a difference of 3 in each of three bands is 3.
    let error = field.channel_error().expect("an error");
    assert!((error.weighted(0.0, [3.0, -3.0, 3.0]) - 3.0).abs() < 1e-12);
}

#[test]
fn names_come_from_descriptions_and_never_twice() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = geotiff::<f32>(folder.path(), 4, &[], |dataset| {
        use gdal::Metadata;
        for (band, description) in [(1, "near infrared"), (2, "near infrared"), (3, "z")] {
            dataset.rasterband(band).expect("a band").set_description(description).expect("described");
        }
    });
    let bands = options(&path, &[1, 2, 3, 4, 1]).bands;
    let names: Vec<String> = channels_of(&bands).into_iter().map(|c| c.name).collect();
    assert_eq!(names, ["near_infrared", "band_2", "band_3", "band_4", "band_1"]);
    assert!(channels_of(&bands).iter().all(|c| c.number == Number::F32));
}

#[test]
fn samples_without_a_value_are_refused_by_band() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = geotiff::<f64>(folder.path(), 2, &[], |dataset| {
        let mut hole = Buffer::new((1, 1), vec![f64::NAN]);
        dataset.rasterband(2).expect("a band").write((11, 7), (1, 1), &mut hole).expect("written");
    });
    let raster = crate::testing::band(&path, 1);
    let found = find_ranges(&raster, &options(&path, &[2]), &Control::default()).expect_err("a hole");
    assert!(matches!(found, FieldError::Nodata { column: 11, row: 7, .. }), "{found}");
    assert!(found.to_string().contains("(band 2)"), "{found}");
}
