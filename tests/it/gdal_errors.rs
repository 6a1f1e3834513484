//! Failures that GDAL gives no words for: a sentence comes all the same.

use crate::util::{Dem, Folder, flat, terrabite};

/// The pixel function `mul` takes two sources; with one it fails without a message.
fn silent(folder: &Folder) -> String {
    Dem::new(20, 10).heights(|_, _| 3.0).write(folder, "dem.tif");
    folder.with(
        "silent.vrt",
        "<VRTDataset rasterXSize='20' rasterYSize='10'><VRTRasterBand dataType='Float32' band='1' \
         subClass='VRTDerivedRasterBand'><PixelFunctionType>mul</PixelFunctionType><SimpleSource><SourceFilename \
         relativeToVRT='1'>dem.tif</SourceFilename><SourceBand>1</SourceBand></SimpleSource></VRTRasterBand></VRTDataset>",
    )
}

#[track_caller]
fn refuses(arguments: &[&str], words: &[&str]) {
    let run = terrabite(arguments).fails(1, words);
    for decoration in ["CPL error", "error msg", "error number", "class: "] {
        assert!(!run.err.contains(decoration), "{run:#?}");
    }
}

#[test]
fn a_failure_without_words_becomes_a_sentence() {
    let folder = Folder::new();
    let vrt = silent(&folder);
    let (dem, tin, out) = (folder.at("dem.tif"), folder.with("flat.ply", flat(20, 10, 3.0)), folder.at("out.ply"));
    let words = [&format!("{vrt}: reading "), "failed: GDAL gave no reason", "gdalinfo -checksum", "pixel functions"];
    for access in ["auto", "windows", "decode"] {
        refuses(&["simplify", &vrt, &out, "--max-error", "1", "--access", access], &words);
    }
    refuses(&["simplify", &dem, &out, "--max-error", "1", "--importance", &vrt], &words);
    refuses(&["verify", &vrt, &tin, "--max-error", "1"], &words);
    refuses(&["preview", &vrt, &tin, &folder.at("out.png"), "--mode", "error"], &words);
    assert_eq!(folder.names(), ["dem.tif", "flat.ply", "silent.vrt"]);
}

#[test]
fn a_crs_that_is_none_is_called_so() {
    let folder = Folder::new();
    let dem = Dem::new(20, 10).on_the_map().write(&folder, "dem.tif");
    let bbox = ["--bbox", "1,2,3,4", "--bbox-crs", "EPSG:999999"];
    let run = terrabite(["info", &dem].iter().chain(&bbox));
    run.fails(1, &["EPSG:999999", "does not understand the definition of the CRS", "--bbox-crs"]);
}
