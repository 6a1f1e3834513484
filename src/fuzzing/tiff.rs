//! Fuzzing: GeoTIFFs, mapped and read.

use super::temp_dir;
use crate::base::Tile;
use crate::base::Window;
use crate::base::control::Control;
use crate::field::{Choice, Field, FieldError, FieldOptions};
use crate::raster::{Raster, quiet_gdal};

/// Larger rasters are opened, not read: a file of any size may claim any.
const MOST_SAMPLES: usize = 1 << 14;

/// A TIFF of any bytes is opened or refused; where its samples can be used in place, they are those that GDAL reads.
pub fn tiff(bytes: &[u8]) {
    // GDAL is not to take it for another format, some of which name files of their own.
    if ![b"II*\0", b"II+\0", b"MM\0*", b"MM\0+"].iter().any(|mark| bytes.starts_with(*mark)) {
        return;
    }
    quiet_gdal();
    let folder = tempfile::tempdir_in(temp_dir()).expect("a folder");
    let path = folder.path().join("dem.tif");
    std::fs::write(&path, bytes).expect("written");
    for band in 1..=2 {
        let Ok(raster) = Raster::open(&path, band) else { return };
        compare(&raster);
        let (width, height) = (raster.width(), raster.height());
        let window =
            Window { column: width / 3, row: height / 3, width: width - width / 3, height: height - height / 3 };
        if let Ok(clipped) = raster.clip(window) {
            compare(&clipped);
        }
    }
}

fn compare(raster: &Raster) {
    let Ok(band) = raster.to_band() else { return };
    let layout = band.plain_layout();
    let open = |choice| {
        let options = FieldOptions { temp_dir: temp_dir(), choice, ..FieldOptions::default() };
        Field::open(&band, &options, &Control::default())
    };
    let Ok(in_place) = open(Choice::InPlace) else { return };
    assert!(layout.is_ok());
    if raster.width().saturating_mul(raster.height()) > MOST_SAMPLES {
        return;
    }
    let Ok(by_gdal) = open(Choice::Windows) else { return };
    let (width, height) = (raster.width(), raster.height());
    let whole = Window { column: 0, row: 0, width, height };
    for window in
        [whole, Window { column: width / 2, row: height / 2, width: width - width / 2, height: height - height / 2 }]
    {
        let (mut mapped, mut read) = (Tile::default(), Tile::default());
        match (in_place.load(window, &mut mapped), by_gdal.load(window, &mut read)) {
            // GDAL could not read it: nobody knows what is right.
            (_, Err(FieldError::Raster(_))) => {}
            (Ok(()), Ok(())) => {
                assert_eq!(mapped.validity().is_whole(), read.validity().is_whole());
                for (column, row) in (0..window.height).flat_map(|r| (0..window.width).map(move |c| (c, r))) {
                    let is_valid = |tile: &Tile| tile.validity().is_valid(column as i32, row as i32);
                    let of = |tile: &Tile| (tile.at(column, row).to_bits(), is_valid(tile));
                    assert_eq!(of(&mapped), of(&read), "sample {column}, {row} of {window:?}");
                }
                assert_eq!(mapped.checksum(), read.checksum());
            }
            (mapped, read) => {
                let told = |found: Result<(), FieldError>| found.err().map(|e| e.to_string());
                assert_eq!(told(mapped), told(read));
            }
        }
    }
}
