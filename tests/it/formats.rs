//! Rasters of every format that GDAL can write here: the table of `docs/rasters.md`.

use std::path::Path;

use gdal::raster::RasterCreationOptions;
use gdal::{Dataset, DriverManager};

use terrabite::base::Window;
use terrabite::base::control::CancelToken;
use terrabite::raster::View;
use terrabite::verify::HeightReader;

use crate::util::{Dem, Folder, Kind, terrabite};

const DOCS: &str = include_str!("../../docs/rasters.md");

enum Outcome {
    Passes,
    /// Refused, with these words.
    Refused(&'static [&'static str]),
}
use Outcome::{Passes, Refused};

/// A copy of a small raster in another format.
struct Case {
    driver: &'static str,
    name: &'static str,
    kind: Kind,
    options: &'static [&'static str],
    outcome: Outcome,
    /// The band that holds the heights, where the outcome is that it must be named; `None` where no band does.
    band: Option<&'static str>,
    /// How far heights may be from those of the source, by what the format keeps.
    off: f64,
}

const fn case(driver: &'static str, name: &'static str, kind: Kind) -> Case {
    Case { driver, name, kind, options: &[], outcome: Passes, band: None, off: 0.0 }
}

fn cases() -> Vec<Case> {
    use Kind::{Byte, Float32, Float64, Int16, Int32, UInt16};
    vec![
        case("COG", "dem_cog.tif", Float32),
        case("VRT", "dem.vrt", Float64),
        case("HFA", "dem.img", Float32),
        Case { options: &["COMPRESSED=YES"], ..case("HFA", "packed.img", Int16) },
        case("AAIGrid", "dem.asc", Int16),
        case("AAIGrid", "dem_real.asc", Float32),
        case("PNG", "dem8.png", Byte),
        case("PNG", "dem16.png", UInt16),
        Case { off: 12.0, ..case("JPEG", "dem.jpg", Byte) },
        Case { options: &["QUALITY=100", "REVERSIBLE=YES"], ..case("JP2OpenJPEG", "dem.jp2", Int16) },
        case("ENVI", "dem.dat", Float32),
        case("EHdr", "dem.bil", Int16),
        case("ERS", "dem.ers", Float32),
        case("PCIDSK", "dem.pix", Float32),
        Case { options: &["PCRASTER_VALUESCALE=VS_SCALAR"], ..case("PCRaster", "dem.map", Float32) },
        case("ILWIS", "dem.mpr", Float32),
        case("SAGA", "dem.sdat", Float32),
        case("RST", "dem.rst", Float32),
        case("GSAG", "ascii.grd", Float64),
        case("GSBG", "binary.grd", Float32),
        case("GS7BG", "seven.grd", Float64),
        case("netCDF", "dem.nc", Float32),
        case("GRIB", "dem.grb2", Float64),
        case("MRF", "dem.mrf", Int16),
        case("NITF", "dem.ntf", Int16),
        case("FITS", "dem.fits", Float64),
        case("HDF4Image", "dem.hdf", Int32),
        case("BT", "dem.bt", Float32),
        case("XYZ", "dem.xyz", Float64),
        Case { off: 0.01, ..case("HF2", "dem.hf2", Float32) },
        case("ZMap", "dem.zmap", Float64),
        case("SIGDEM", "dem.sigdem", Float64),
        Case {
            outcome: Refused(&["found red", "--band 4"]),
            band: Some("4"),
            off: 0.01,
            ..case("NWT_GRD", "dem_nwt.grd", Float32)
        },
        Case { outcome: Refused(&["found red", "--encoding", "--band 1"]), ..case("MBTiles", "dem.mbtiles", Byte) },
        case("GTX", "dem.gtx", Float32),
        case("RRASTER", "dem.grd", Float32),
        case("PDS4", "dem.xml", Float32),
        case("VICAR", "dem.vic", Float32),
        case("ISIS3", "dem.cub", Float32),
        case("LAN", "dem.lan", Int16),
        case("KRO", "dem.kro", Float32),
        case("PNM", "dem.pgm", UInt16),
        case("Zarr", "dem.zarr", Float32),
        case("BAG", "dem.bag", Float32),
        Case { options: &["RASTER_TABLE=dem", "TILE_FORMAT=PNG"], ..case("GPKG", "dem.gpkg", Byte) },
        case("BMP", "dem.bmp", Byte),
        case("GIF", "dem.gif", Byte),
        Case { outcome: Refused(&["the numbers of colours in a table", "--band 1"]), ..case("XPM", "dem.xpm", Byte) },
    ]
}

/// Simplifies and verifies, or says what went wrong.
fn tried(dem: &str, tin: &str, outcome: &Outcome) -> Result<(), String> {
    tried_with(dem, tin, outcome, &[])
}

/// The same with options for `simplify`.
fn tried_with(dem: &str, tin: &str, outcome: &Outcome, options: &[&str]) -> Result<(), String> {
    let run = ["simplify", dem, tin, "--max-error", "2", "--overwrite", "-q"];
    let run = terrabite(run.iter().chain(options));
    match outcome {
        Passes if run.code != Some(0) => Err(format!("simplify: {}", run.err)),
        Passes => match terrabite(["verify", dem, tin, "--max-error", "2"]) {
            run if run.code == Some(0) => Ok(()),
            run => Err(format!("verify: {}{}", run.err, run.out)),
        },
        Refused(words) if run.code == Some(1) && words.iter().all(|w| run.err.contains(w)) => Ok(()),
        Refused(_) => Err(format!("expected to be refused: {run:?}")),
    }
}

/// How far the heights of a copy are from those of its source, at most; infinitely where one is missing.
fn farthest_height(copy: &Path, band: Option<&str>, kind: Kind, base: &str) -> Option<f64> {
    let heights = |path: &Path, band: usize| {
        let raster = View::of_band(band).open(path, &CancelToken::default()).unwrap();
        let window = Window { column: 0, row: 0, width: raster.width(), height: raster.height() };
        let mut heights = vec![0.0; window.len()];
        HeightReader::new(&raster.to_band().unwrap()).read(window, &mut heights).unwrap();
        heights
    };
    let (found, expected) = (heights(copy, band.map_or(1, |b| b.parse().unwrap())), heights(Path::new(base), 1));
    assert_eq!(found.len(), expected.len(), "{} of {kind:?}", copy.display());
    let distance = |(f, e): (&f64, &f64)| if f.is_nan() { f64::INFINITY } else { (f - e).abs() };
    found.iter().zip(&expected).map(distance).reduce(f64::max)
}

/// Three bands of colours in a GeoPackage are no heights.
#[test]
fn pictures_in_a_geopackage_are_refused() {
    let folder = Folder::new();
    let base =
        Dem::new(60, 50).kind(Kind::Byte).bands(3).option("PHOTOMETRIC=RGB").on_the_map().write(&folder, "b.tif");
    let driver = DriverManager::get_driver_by_name("GPKG").unwrap();
    let options: RasterCreationOptions = ["TILE_FORMAT=PNG"].into_iter().collect();
    let copied = Dataset::open(&base).unwrap().create_copy(&driver, folder.join("p.gpkg"), &options);
    copied.and_then(Dataset::close).unwrap();
    let run = terrabite(["simplify", &folder.at("p.gpkg"), &folder.at("tin.ply"), "--max-error", "2"]);
    run.fails(1, &["p.gpkg", "found red", "--encoding", "--band 1"]);
}

#[test]
fn every_format_that_can_be_written_here() {
    let mut wrong = Vec::new();
    for Case { driver: name, name: file, kind, options, outcome, band, off } in cases() {
        if !DOCS.contains(&format!("| {name} |")) {
            wrong.push(format!("{name}: not in docs/rasters.md"));
        }
        let Ok(driver) = DriverManager::get_driver_by_name(name) else {
            eprintln!("skipped: {name} is not built in");
            continue;
        };
        let folder = Folder::new();
        let base = Dem::new(60, 50).kind(kind).on_the_map().write(&folder, "base.tif");
        let options: RasterCreationOptions = options.iter().copied().collect();
        eprintln!("{name}: {file}");
        // A VRT looks at it again when it is closed.
        let source = Dataset::open(&base).unwrap();
        let copied = source.create_copy(&driver, folder.join(file), &options);
        if let Err(error) = copied.and_then(Dataset::close) {
            wrong.push(format!("{name}: cannot be made: {error}"));
            continue;
        }
        let tin = folder.at("tin.ply");
        if let Err(error) = tried(&folder.at(file), &tin, &outcome) {
            wrong.push(format!("{name} {file}: {error}"));
        }
        if let Refused(_) = outcome {
            let band = band.unwrap_or("1");
            let run = terrabite(["simplify", &folder.at(file), &tin, "--max-error", "2", "--band", band, "-q"]);
            assert_eq!(run.code, Some(0), "{run:?}");
        }
        let has_heights = matches!(outcome, Passes) || band.is_some();
        if has_heights && let Some(found) = farthest_height(&folder.join(file), band, kind, &base).filter(|d| *d > off)
        {
            wrong.push(format!("{name} {file}: heights are off by {found}, {off} is allowed"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn formats_of_one_degree() {
    let folder = Folder::new();
    for (name, file, cells) in [("SRTMHGT", "N46E015.hgt", 1200), ("DTED", "dem.dt0", 120)] {
        assert!(DOCS.contains(&format!("| {name} |")));
        let (side, cell) = (cells + 1, 1.0 / cells as f64);
        let transform = [15.0 - cell / 2.0, cell, 0.0, 47.0 + cell / 2.0, 0.0, -cell];
        let base = Dem::new(side, side).on_the_map().geo_transform(transform).epsg(4326).write(&folder, "base.tif");
        let driver = DriverManager::get_driver_by_name(name).unwrap();
        let copy = Dataset::open(&base).unwrap().create_copy(&driver, folder.join(file), &Default::default());
        copy.unwrap().close().unwrap();
        // A million samples need no polish.
        tried_with(&folder.at(file), &folder.at("tin.ply"), &Passes, &["--quality", "none"]).unwrap();
    }
}

#[test]
fn geotiffs_of_every_make() {
    let folder = Folder::new();
    let dem = || Dem::new(60, 50).on_the_map();
    let option = |options: &[&str]| options.iter().fold(dem(), |dem, option| dem.option(option));
    let all = [
        option(&["BIGTIFF=YES"]),
        option(&["BIGTIFF=YES", "ENDIANNESS=BIG"]).tiled(16),
        option(&["INTERLEAVE=PIXEL"]).bands(3),
        option(&["INTERLEAVE=BAND"]).bands(3).tiled(16),
        option(&["COMPRESS=LZW", "PREDICTOR=2"]),
        option(&["COMPRESS=DEFLATE", "PREDICTOR=3"]).kind(Kind::Float32),
        option(&["COMPRESS=PACKBITS"]),
        option(&["COMPRESS=ZSTD"]).tiled(32),
        option(&["COMPRESS=LERC"]).kind(Kind::Float32),
        option(&["NBITS=12"]).kind(Kind::UInt16),
        option(&["NBITS=16"]).kind(Kind::Float32),
        option(&["NBITS=1"]).kind(Kind::Byte).heights(|c, r| f64::from(u8::from((c / 9 + r / 7) % 2 == 0))),
        // Blocks of zeros that are not in the file.
        option(&["SPARSE_OK=TRUE"]).tiled(16).heights(|c, _| if c < 33 { 0.0 } else { c as f64 }),
        dem().scaling(0.1, -30.0),
        dem().kind(Kind::Byte).scaling(0.5, 100.0).compressed(),
    ];
    for (i, dem) in all.iter().enumerate() {
        let dem = dem.write(&folder, "dem.tif");
        tried(&dem, &folder.at("tin.ply"), &Passes).unwrap_or_else(|e| panic!("number {i}: {e}"));
    }
}

#[test]
fn overviews_are_not_what_is_meshed() {
    let folder = Folder::new();
    let base = Dem::new(300, 260).on_the_map().write(&folder, "base.tif");
    let driver = DriverManager::get_driver_by_name("COG").unwrap();
    let options: RasterCreationOptions = ["BLOCKSIZE=128", "OVERVIEWS=IGNORE_EXISTING"].into_iter().collect();
    let copy = Dataset::open(&base).unwrap().create_copy(&driver, folder.join("cog.tif"), &options).unwrap();
    assert!(copy.rasterband(1).unwrap().overview_count().unwrap() > 0);
    copy.close().unwrap();
    let [whole, cog] = [&base, &folder.at("cog.tif")].map(|dem| {
        tried(dem, &folder.at("tin.ply"), &Passes).unwrap();
        let tin = std::fs::read(folder.join("tin.ply")).unwrap();
        // The header names the file.
        let end = tin.windows(11).position(|w| w == b"end_header\n").unwrap();
        tin[end..].to_vec()
    });
    assert!(whole == cog);
}

#[test]
fn subdatasets_are_listed_and_opened_by_name() {
    let folder = Folder::new();
    let base = Dem::new(30, 20).bands(2).on_the_map().write(&folder, "base.tif");
    let Ok(driver) = DriverManager::get_driver_by_name("netCDF") else { return };
    let copy = Dataset::open(&base).unwrap().create_copy(&driver, folder.join("dems.nc"), &Default::default());
    copy.unwrap().close().unwrap();
    let (dems, tin) = (folder.at("dems.nc"), folder.at("tin.ply"));
    let words = ["expected a raster band, found none", "subdatasets", ":Band1'", ":Band2'"];
    terrabite(["simplify", &dems, &tin, "--max-error", "1"]).fails(1, &words);
    tried(&format!("NETCDF:\"{dems}\":Band2"), &tin, &Passes).unwrap();
}

#[test]
fn samples_that_are_no_heights_are_refused() {
    let folder = Folder::new();
    Dem::new(20, 20).kind(Kind::Byte).on_the_map().write(&folder, "dem.tif");
    let vrt = |number: &str, more: &str| {
        let band = format!(
            r#"<VRTRasterBand dataType="{number}" band="1">{more}<SimpleSource><SourceFilename
            relativeToVRT="1">dem.tif</SourceFilename><SourceBand>1</SourceBand></SimpleSource></VRTRasterBand>"#
        );
        folder.with("dem.vrt", format!(r#"<VRTDataset rasterXSize="20" rasterYSize="20">{band}</VRTDataset>"#))
    };
    let tin = folder.at("tin.ply");
    for number in ["CFloat32", "CFloat64", "CInt16", "CInt32"] {
        let run = terrabite(["simplify", &vrt(number, ""), &tin, "--max-error", "1", "--band", "1"]);
        run.fails(1, &["dem.vrt", "band 1: expected integer or real samples, found", "complex"]);
    }
    let colours = r#"<ColorInterp>Palette</ColorInterp><ColorTable><Entry c1="200" c2="0" c3="0"/></ColorTable>"#;
    let dem = vrt("Byte", colours);
    let words = ["dem.vrt", "numbers of colours in a table", "use --band 1", "gdal_translate -expand rgb"];
    terrabite(["simplify", &dem, &tin, "--max-error", "1"]).fails(1, &words);
    let words = ["dem.vrt", "numbers of colours in a table", "--attributes", "gdal_translate -expand rgb"];
    terrabite(["simplify", &dem, &tin, "--max-error", "1", "--image"]).fails(1, &words);
    terrabite(["simplify", &dem, &tin, "--max-error", "1", "--band", "1"]).succeeds();
    terrabite(["verify", &dem, &tin, "--max-error", "1", "--band", "1"]).succeeds();
}
