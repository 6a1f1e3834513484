//! netCDF and its kin: columns and rows lie where the file lists them, or the raster is refused.

use gdal::programs::raster::{MultiDimTranslateDestination, multi_dim_translate};
use gdal::{Dataset, DatasetOptions, DriverManager, GdalOpenFlags};

use crate::util::{Axis, Cube, Dem, Folder, terrabite};

fn steps(first: f64, step: f64, count: usize) -> impl Iterator<Item = f64> {
    (0..count).map(move |i| first + i as f64 * step)
}

/// Latitudes as on a Mercator map, from 0 to 60 degrees: GDAL takes them for even.
fn mercator() -> Vec<f64> {
    let radians = |i: usize| (i as f64 / 6.0).to_radians();
    (0..453).map(|i| radians(i).sinh().atan().to_degrees()).collect()
}

fn longitudes(count: usize) -> Axis {
    Axis::new("lon", steps(10.0, 0.5, count))
}

/// Copies all arrays into a file of another format.
fn translated(cube: &str, driver: &str, to: &str) {
    let open_flags = GdalOpenFlags::GDAL_OF_READONLY | GdalOpenFlags::GDAL_OF_MULTIDIM_RASTER;
    let cube = Dataset::open_ex(cube, DatasetOptions { open_flags, ..Default::default() }).unwrap();
    let options = vec!["-of", driver].try_into().unwrap();
    let to = MultiDimTranslateDestination::path(to).unwrap();
    multi_dim_translate(&[cube], to, Some(options)).unwrap().close().unwrap();
}

fn is_there(driver: &str) -> bool {
    DriverManager::get_driver_by_name(driver).is_ok()
}

#[test]
fn uneven_rows_are_refused_however_the_file_is_named() {
    if !is_there("netCDF") {
        return;
    }
    let folder = Folder::new();
    let words = ["expected columns and rows within a tenth of a cell", "39.8 cells away", "cdo remapbil,GRID"];
    let mut latitudes = mercator();
    for name in ["south_first.nc", "north_first.nc"] {
        let cube = Cube::new(Axis::new("lat", latitudes.iter().copied()), longitudes(60));
        let file = cube.write(&folder, name, |r, _| r as f64);
        terrabite(["info", &file]).fails(1, &words).fails(1, &[name, "'lat' lists at 37.23"]);
        terrabite(["info", &format!("NETCDF:\"{file}\":z")]).fails(1, &words);
        let newer = folder.at(&format!("newer_{name}"));
        translated(&file, "netCDF", &newer);
        assert!(std::fs::read(&newer).unwrap().starts_with(b"\x89HDF"));
        terrabite(["info", &newer]).fails(1, &words);
        terrabite(["simplify", &newer, &folder.at("tin.ply"), "--max-error", "1"]).fails(1, &words);
        latitudes.reverse();
    }
}

#[test]
fn a_gap_in_the_columns_is_refused() {
    if !is_there("netCDF") {
        return;
    }
    let folder = Folder::new();
    let longitudes = steps(10.0, 0.5, 31).map(|x| if x < 15.0 { x } else { x + 1.0 });
    let file = Cube::new(Axis::new("lat", steps(50.0, -0.5, 21)), Axis::new("lon", longitudes)).write(
        &folder,
        "dem.nc",
        |r, _| r as f64,
    );
    terrabite(["info", &file]).fails(1, &["found column 10, which 'lon' lists at 16, put at 15.33", "1.3 cells away"]);
}

#[test]
fn even_axes_pass_in_every_order_and_unit() {
    if !is_there("netCDF") {
        return;
    }
    let folder = Folder::new();
    let cubes = [
        Cube::new(Axis::new("lat", steps(50.0, -0.5, 21)), longitudes(31)),
        Cube::new(Axis::new("lat", steps(40.0, 0.5, 21)), longitudes(31)),
        // A little less than a tenth of a cell away from even.
        Cube::new(Axis::new("lat", steps(40.0, 0.5, 21).map(|y| if y == 45.0 { 45.04 } else { y })), longitudes(31)),
        // Across the date line, and from 0 to 360.
        Cube::new(
            Axis::new("lat", steps(50.0, -0.5, 21)),
            Axis::new("lon", steps(170.0, 0.5, 41).map(|x| if x >= 180.0 { x - 360.0 } else { x })),
        ),
        Cube::new(Axis::new("lat", steps(50.0, -0.5, 21)), Axis::new("lon", steps(0.0, 10.0, 36))),
        Cube::new(Axis::new("y", steps(5e6, 100.0, 21)), Axis::new("x", steps(4e5, 100.0, 31))),
        // Coordinates without a word of what they are.
        Cube::new(Axis::new("latitude", steps(50.0, -0.5, 21)), Axis::new("longitude", steps(10.0, 0.5, 31))),
    ];
    for (i, cube) in cubes.iter().enumerate() {
        let file = cube.write(&folder, &format!("{i}.nc"), |r, c| (10 * r + c) as f64);
        let info = terrabite(["info", &file, "--json"]);
        assert_eq!(info.code, Some(0), "number {i}: {info:#?}");
    }
}

/// The corners that a message tells to `gdal_translate -a_ullr`.
fn corners(message: &str) -> [f64; 4] {
    let numbers = message.split_once("-a_ullr ").unwrap().1.split(' ').map_while(|word| word.parse().ok());
    numbers.collect::<Vec<f64>>().try_into().unwrap()
}

#[test]
fn axes_that_gdal_makes_nothing_of_are_refused_with_the_corners_that_mend_it() {
    if !is_there("netCDF") {
        return;
    }
    let folder = Folder::new();
    let arc_seconds = |first: f64, step: f64| Axis::new("lat", steps(first, step / 3600.0, 256));
    let longitudes = Axis::new("lon", steps(-105.7, 1.0 / 3600.0, 256));
    let north = 47.423;
    // Heights are a thousand in the north and nothing in the south.
    let cubes = [
        (Cube::new(arc_seconds(north, -1.0), longitudes.clone()).single(), true),
        (Cube::new(arc_seconds(north - 255.0 / 3600.0, 1.0), longitudes.clone()).single(), false),
        (Cube::new(arc_seconds(north, -1.0), longitudes).dimensions("y", "x"), true),
    ];
    for (i, (cube, north_first)) in cubes.into_iter().enumerate() {
        let height =
            |r: usize, _| if north_first { 1000.0 * (255 - r) as f64 / 255.0 } else { 1000.0 * r as f64 / 255.0 };
        let file = cube.write(&folder, &format!("{i}.nc"), height);
        let words = ["expected a geotransform", "columns ('lon') and rows ('lat')", "found none", "upside down"];
        let run = terrabite(["info", &file]).fails(1, &words);
        // With these corners, the row that is shown first has its heights.
        let [_, top, _, bottom] = corners(&run.err);
        let shown = Dataset::open(&file).unwrap().rasterband(1).unwrap().read_as::<f64>((9, 0), (1, 1), (1, 1), None);
        let first_is_north = shown.unwrap().data()[0] > 500.0;
        assert_eq!(first_is_north, top > bottom, "number {i}: {}", run.err);
        let (north_edge, south_edge) = (top.max(bottom), top.min(bottom));
        assert!((north_edge - north - 0.5 / 3600.0).abs() < 1e-5, "{north_edge}");
        assert!((north_edge - south_edge - 256.0 / 3600.0).abs() < 1e-5, "{south_edge}");
    }
    let few = Cube::new(Axis::new("lat", mercator().into_iter().step_by(20)), Axis::new("lon", steps(0.0, 0.5, 30)));
    let file = few.write(&folder, "uneven.nc", |r, _| r as f64);
    terrabite(["info", &file]).fails(1, &["expected a geotransform", "cdo remapbil,GRID"]);
}

#[test]
fn hdf5_and_zarr_list_axes_too() {
    if !is_there("netCDF") {
        return;
    }
    let folder = Folder::new();
    let even = Cube::new(Axis::new("lat", steps(50.0, -0.5, 21)), longitudes(31));
    let even = even.write(&folder, "even.nc", |r, _| r as f64);
    if is_there("HDF5") {
        translated(&even, "netCDF", &folder.at("even.h5"));
        let words = ["expected a geotransform", "gdal_translate -a_ullr 9.75 50.25 25.25 39.75"];
        terrabite(["info", &folder.at("even.h5")]).fails(1, &words);
        terrabite(["info", &format!("HDF5:\"{}\"://z", folder.at("even.h5"))]).fails(1, &words);
    }
    if is_there("Zarr") {
        translated(&even, "Zarr", &folder.at("even.zarr"));
        terrabite(["info", &folder.at("even.zarr")]).succeeds();
        let uneven = Cube::new(Axis::new("lat", mercator()), longitudes(60)).write(&folder, "dem.nc", |r, _| r as f64);
        translated(&uneven, "Zarr", &folder.at("uneven.zarr"));
        terrabite(["info", &folder.at("uneven.zarr")]).fails(1, &["expected a geotransform", "cdo remapbil,GRID"]);
    }
}

#[test]
fn turned_rasters_without_axes_pass() {
    let Ok(driver) = DriverManager::get_driver_by_name("netCDF") else { return };
    let folder = Folder::new();
    let turned = Dem::new(30, 20).on_the_map().geo_transform([5e5, 8.0, 6.0, 5e6, 6.0, -8.0]).write(&folder, "dem.tif");
    let copy = Dataset::open(&turned).unwrap().create_copy(&driver, folder.join("dem.nc"), &Default::default());
    copy.unwrap().close().unwrap();
    terrabite(["info", &folder.at("dem.nc")]).succeeds();
}

/// The codes of warnings, and their sentences.
fn warnings(run: &crate::util::Run) -> Vec<(String, String)> {
    let json = run.json();
    let text = |w: &serde_json::Value, key: &str| w[key].as_str().unwrap().to_string();
    json["warnings"].as_array().unwrap().iter().map(|w| (text(w, "code"), text(w, "message"))).collect()
}

#[test]
fn swapped_axes_and_a_missing_grid_mapping_are_told() {
    if !is_there("netCDF") {
        return;
    }
    let folder = Folder::new();
    let (lat, lon) = (Axis::new("lat", steps(50.0, -0.5, 21)), longitudes(31));
    let height = |r: usize, c: usize| ((r * 7 + c * 3) % 11) as f64;
    let plain = Cube::new(lat.clone(), lon.clone()).write(&folder, "plain.nc", height);
    let found = warnings(&terrabite(["info", &plain, "--json"]).succeeds());
    assert!(
        matches!(&found[..], [(code, message)] if code == "no_grid_mapping" && message.contains("-a_srs")),
        "{found:?}"
    );
    let mapped = Cube::new(lat.clone(), lon.clone()).grid_mapping().write(&folder, "mapped.nc", height);
    assert_eq!(warnings(&terrabite(["info", &mapped, "--json"]).succeeds()), []);

    // GDAL warns of these, too: once each, however many threads open the file.
    let swapped = Cube::new(lon, lat).grid_mapping().write(&folder, "swapped.nc", height);
    let tin = folder.at("tin.ply");
    let simplify = ["simplify", &swapped, &tin, "--max-error", "1", "--tile", "8", "--threads", "4", "--overwrite"];
    let run = terrabite(simplify.iter().chain(&["--json"])).succeeds();
    let found = warnings(&run);
    let codes: Vec<&str> = found.iter().map(|(code, _)| code.as_str()).collect();
    assert_eq!(codes, ["swapped_axes", "gdal", "gdal"], "{found:?}");
    assert!(found[0].1.contains("columns are along 'lat' and its rows along 'lon'") && found[0].1.contains("ncpdq -a"));
    assert!(found[1].1.contains("(lat) is not a Longitude/X dimension"), "{found:?}");
    assert!(!run.err.contains("warning"), "{run:?}");
    let run = terrabite(simplify).succeeds();
    assert_eq!(run.err.matches("warning: ").count(), 3, "{run:?}");
    assert_eq!(run.err.matches(&format!("warning: {swapped}: dimension #")).count(), 2, "{run:?}");
    let run = terrabite(simplify.iter().chain(&["--quiet"])).succeeds();
    assert_eq!(run.err, "");
    let run = terrabite(["verify", &swapped, &tin, "--max-error", "1"]).succeeds();
    assert_eq!(run.err.matches("warning: ").count(), 3, "{run:?}");
}

#[test]
fn s_102_is_refused_by_name() {
    if !(is_there("netCDF") && is_there("HDF5")) || is_there("S102") {
        return;
    }
    let folder = Folder::new();
    let cube = Cube::new(Axis::new("lat", steps(50.0, -0.5, 21)), longitudes(31)).product("INT.IHO.S-102.2.1");
    translated(&cube.write(&folder, "cube.nc", |r, _| r as f64), "netCDF", &folder.at("102DE00.h5"));
    let words = ["102DE00.h5", "S-102", "does not read", "GDAL 3.8", "DEPTH_OR_ELEVATION=ELEVATION"];
    terrabite(["info", &folder.at("102DE00.h5")]).fails(1, &words);
}
