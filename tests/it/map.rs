//! Where meshes lie on the map, and how coordinates are written.

use std::path::Path;

use gdal::spatial_ref::SpatialRef;
use gdal::{Dataset, DatasetOptions, GdalOpenFlags, Metadata};
use terrabite::formats::ply::read::{PlyError, PlyFile};

use crate::util::{Dem, Folder, Kind, terrabite};

/// North up, south up, mirrored, turned, sheared, far away, tiny.
const TRANSFORMS: [[f64; 6]; 7] = [
    [500_000.0, 10.0, 0.0, 5_200_000.0, 0.0, -10.0],
    [500_000.0, 10.0, 0.0, 5_200_000.0, 0.0, 10.0],
    [500_000.0, -10.0, 0.0, 5_200_000.0, 0.0, -10.0],
    [500_000.0, 8.0, 6.0, 5_200_000.0, 6.0, -8.0],
    [500_000.0, 9.7, 3.3, 5_200_000.0, -1.1, -4.9],
    [-3e9, 0.1, 0.0, 7e9, 0.0, -0.1],
    [12.123_456_789, 1e-5, 0.0, 47.987_654_321, 0.0, -1e-5],
];

fn vertices(path: &Path) -> (Vec<String>, Vec<[f64; 3]>) {
    let mut mesh = PlyFile::open(path).unwrap();
    let mut all = Vec::new();
    mesh.for_each_vertex(|_, vertex| {
        all.push(vertex);
        Ok::<(), PlyError>(())
    })
    .unwrap();
    (mesh.comments().to_vec(), all)
}

fn edit(path: &str, change: impl FnOnce(&mut Dataset)) {
    let flags = GdalOpenFlags::GDAL_OF_UPDATE | GdalOpenFlags::GDAL_OF_RASTER;
    let options = DatasetOptions { open_flags: flags, ..DatasetOptions::default() };
    let mut dataset = Dataset::open_ex(path, options).unwrap();
    change(&mut dataset);
    dataset.close().unwrap();
}

#[test]
fn every_geotransform_and_every_way_of_writing_passes() {
    let folder = Folder::new();
    let tin = folder.at("tin.ply");
    for transform in TRANSFORMS {
        let dem = Dem::new(60, 50).kind(Kind::Float64).heights(|c, r| crate::util::hills(c, r) / 7.0);
        let dem = dem.geo_transform(transform).write(&folder, "dem.tif");
        for options in [
            vec![],
            vec!["--local"],
            vec!["--precision", "float"],
            vec!["--z-scale", "0.3048", "--local"],
            vec!["--z-scale", "1000", "--precision", "float", "--quality", "none"],
            vec!["--precision", "float", "--heights", "fitted"],
            vec!["--z-scale", "3.3", "--heights", "fitted", "--window", "5,6,41,33"],
        ] {
            let window = options.iter().position(|o| *o == "--window").map_or(&[][..], |at| &options[at..at + 2]);
            let simplify = ["simplify", &dem, &tin, "--max-error", "0.25", "--overwrite", "--tile", "20", "-q"];
            terrabite(simplify.into_iter().chain(options.iter().copied())).succeeds();
            let verify = ["verify", &dem, &tin, "--max-error", "0.25", "-q"];
            let run = terrabite(verify.into_iter().chain(window.iter().copied()));
            assert_eq!(run.code, Some(0), "{transform:?} {options:?}: {run:#?}");
        }
    }
}

#[test]
fn a_sample_stands_at_the_centre_of_its_pixel_whatever_pixels_are() {
    let folder = Folder::new();
    for pixel_is in ["Area", "Point"] {
        let dem = Dem::new(20, 20).on_the_map().write(&folder, "dem.tif");
        edit(&dem, |d| d.set_metadata_item("AREA_OR_POINT", pixel_is, "").unwrap());
        // Written anew, with the tie point where it belongs.
        let copy = folder.at("copy.tif");
        let dataset = Dataset::open(&dem).unwrap();
        dataset.create_copy(&dataset.driver(), &copy, &Default::default()).unwrap().close().unwrap();
        assert_eq!(terrabite(["info", &copy, "--json"]).json()["reference"]["pixel_is"], pixel_is);
        let tin = folder.at("tin.ply");
        terrabite(["simplify", &copy, &tin, "--max-error", "1", "--overwrite"]).succeeds();
        let (_, vertices) = vertices(&folder.join("tin.ply"));
        assert!(vertices.iter().any(|v| v[..2] == [500_005.0, 5_199_995.0]), "{pixel_is}: {vertices:?}");
        terrabite(["verify", &copy, &tin, "--max-error", "1"]).succeeds();
    }
}

#[test]
fn other_georeferencing_is_refused_with_the_way_out() {
    let folder = Folder::new();
    let dem = Dem::new(20, 20).write(&folder, "dem.tif");
    let bands = r#"<VRTRasterBand dataType="Int16" band="1"><SimpleSource>
        <SourceFilename relativeToVRT="1">dem.tif</SourceFilename><SourceBand>1</SourceBand></SimpleSource></VRTRasterBand>"#;
    let with = |what: &str| format!(r#"<VRTDataset rasterXSize="20" rasterYSize="20">{what}{bands}</VRTDataset>"#);
    let points = r#"<GCPList Projection="EPSG:32633"><GCP Id="1" Pixel="0" Line="0" X="5e5" Y="5e6"/>
        <GCP Id="2" Pixel="20" Line="0" X="5.1e5" Y="5e6"/><GCP Id="3" Pixel="0" Line="20" X="5e5" Y="5.1e6"/></GCPList>"#;
    let rpc = r#"<Metadata domain="RPC"><MDI key="LINE_OFF">10</MDI></Metadata>"#;
    let arrays = r#"<Metadata domain="GEOLOCATION"><MDI key="X_DATASET">lon.tif</MDI></Metadata>"#;
    for (what, found) in [(points, "3 ground control points"), (rpc, "(RPC)"), (arrays, "geolocation arrays")] {
        let vrt = folder.with("dem.vrt", with(what));
        let run = terrabite(["simplify", &vrt, &folder.at("tin.ply"), "--max-error", "1"]);
        run.fails(1, &["dem.vrt", "expected a geotransform", found, "gdalwarp -t_srs", "gdal_translate -a_ullr"]);
    }
    // With a geotransform they do no harm.
    let both = format!("<GeoTransform>0,1,0,0,0,-1</GeoTransform>{rpc}");
    let vrt = folder.with("dem.vrt", with(&both));
    terrabite(["simplify", &vrt, &folder.at("tin.ply"), "--max-error", "1"]).succeeds();
    drop(dem);
}

#[test]
fn the_report_tells_what_coordinates_mean() {
    let folder = Folder::new();
    let said = |dem: Dem, crs: Option<&str>, unit: &str| {
        let dem = dem.write(&folder, "dem.tif");
        edit(&dem, |d| {
            if let Some(crs) = crs {
                d.set_spatial_ref(&SpatialRef::from_definition(crs).unwrap()).unwrap();
            }
        });
        let tin = folder.at("tin.ply");
        let run = terrabite(["simplify", &dem, &tin, "--max-error", "1", "--overwrite"]).succeeds();
        assert!(unit.is_empty() || run.out.contains(unit), "{}", run.out);
        (run.out, vertices(&folder.join("tin.ply")).0)
    };
    let (report, comments) = said(Dem::new(20, 20), None, "");
    assert!(report.contains("no georeferencing: plain pixel coordinates"), "{report}");
    assert!(!comments.iter().any(|c| c.starts_with("crs:")), "{comments:?}");
    let (report, comments) = said(Dem::new(20, 20).on_the_map(), None, "");
    assert!(report.contains("EPSG:32633 (WGS 84 / UTM zone 33N), unit metre"), "{report}");
    assert!(comments.contains(&"crs:EPSG:32633".to_string()), "{comments:?}");
    let degrees = [350.0, 0.5, 0.0, 47.0, 0.0, -0.5];
    let (report, comments) = said(Dem::new(20, 20).geo_transform(degrees), Some("EPSG:4326"), "");
    for words in
        ["EPSG:4326 (WGS 84): degrees across", "longitudes beyond 180 kept", "a projected CRS makes them alike"]
    {
        assert!(report.contains(words), "{report}");
    }
    assert!(comments.contains(&"crs:EPSG:4326".to_string()), "{comments:?}");
    let (report, _) = said(Dem::new(20, 20).on_the_map(), Some("EPSG:25832+5783"), "");
    assert!(report.contains("DHHN92 height, unit metre"), "{report}");
    let (_, comments) = said(Dem::new(20, 20).on_the_map(), Some("+proj=laea +lat_0=3 +lon_0=5 +ellps=GRS80"), "");
    let crs = comments.iter().find(|c| c.starts_with("crs:")).unwrap();
    assert!(crs.starts_with("crs:PROJCS[") && !crs.contains('\n'), "{crs}");
}

#[test]
fn what_is_written_is_said_in_the_header() {
    let folder = Folder::new();
    let dem = Dem::new(40, 30).on_the_map().write(&folder, "dem.tif");
    let tin = folder.at("tin.ply");
    let options = ["--local", "--z-scale", "2.5", "--json"];
    let run = terrabite(["simplify", &dem, &tin, "--max-error", "2"].into_iter().chain(options)).succeeds();
    assert_eq!(run.json()["map"]["offset"], serde_json::json!([500_200.0, 5_199_900.0]));
    assert_eq!((&run.json()["map"]["z_scale"], &run.json()["tolerance"]), (&2.5.into(), &2.0.into()));
    let (comments, vertices) = vertices(&folder.join("tin.ply"));
    assert!(comments.contains(&"offset 500200 5199900".to_string()), "{comments:?}");
    assert!(comments.contains(&"z_scale 2.5".to_string()) && comments.contains(&"max_error 2".to_string()));
    // Nobody who knows nothing of offsets is to take the coordinates for the CRS's.
    assert!(comments.contains(&"map crs EPSG:32633".to_string()), "{comments:?}");
    assert!(!comments.iter().any(|c| c.starts_with("crs:")), "{comments:?}");
    assert!(vertices.iter().all(|v| v[0].abs() <= 200.0 && v[1].abs() <= 300.0 && v[2] >= 75.0 && v[2] <= 300.0));
    // A file that says nothing of it, or something else, is another surface.
    let bytes = std::fs::read(&tin).unwrap();
    for (said, instead) in [("z_scale 2.5", "z_scale 2.4"), ("offset 500200", "offset 500210")] {
        let at = bytes.windows(said.len()).position(|w| w == said.as_bytes()).unwrap();
        let mut changed = bytes.clone();
        changed[at..at + said.len()].copy_from_slice(instead.as_bytes());
        let changed = folder.with("changed.ply", changed);
        assert_eq!(terrabite(["verify", &dem, &changed, "--max-error", "2", "-q"]).code, Some(1), "{instead}");
    }
    let png = folder.at("tin.png");
    let run = terrabite(["preview", &dem, &tin, &png, "--mode", "error", "--max-error", "2"]).succeeds();
    let largest: f64 = run.out.trim().rsplit(' ').next().unwrap().parse().unwrap();
    assert!(largest <= 2.0, "{}", run.out);
}

#[test]
fn a_raster_without_any_height_has_none_to_lose() {
    let folder = Folder::new();
    let dem = Dem::new(40, 30).kind(Kind::Float64).heights(|_, _| f64::NAN).write(&folder, "dem.tif");
    let options = ["--max-error", "1", "--precision", "float"];
    let run = terrabite(["simplify", &dem, &folder.at("tin.ply")].into_iter().chain(options));
    run.fails(1, &[&dem, "there is no ground to triangulate"]);
}

#[test]
fn what_single_precision_loses_is_taken_from_the_tolerance() {
    let folder = Folder::new();
    let high = Dem::new(40, 30).kind(Kind::Float64).heights(|c, r| 1e6 + crate::util::hills(c, r) / 7.0);
    let dem = high.on_the_map().write(&folder, "dem.tif");
    let tin = folder.at("tin.ply");
    let simplify = |tolerance: &'static str, options: &[&str]| {
        let all = ["simplify", &dem, &tin, "--max-error", tolerance, "--overwrite", "--json"];
        terrabite(all.iter().chain(options))
    };
    let run = simplify("1", &["--precision", "float"]).succeeds();
    let kept = run.json()["map"]["kept_for_rounding"].as_f64().unwrap();
    assert!(kept > 0.05 && kept < 0.07, "{kept}");
    terrabite(["verify", &dem, &tin, "--max-error", "1"]).succeeds();
    let words = ["dem.tif", "at most half of the tolerance 0.1", "found a loss of up to", "--precision double"];
    simplify("0.1", &["--precision", "float"]).fails(1, &words);
    simplify("0", &["--z-scale", "0.3"]).fails(1, &["half of the tolerance 0", "--z-scale 1"]);
    simplify("0.1", &["--z-scale", "0.3"]).succeeds();
    simplify("0", &["--z-scale", "0.5"]).succeeds();
    terrabite(["verify", &dem, &tin, "--max-error", "0"]).succeeds();
    let goal = |rms: &'static str| {
        let options = ["--max-rms", rms, "--precision", "float", "--overwrite"];
        terrabite(["simplify", &dem, &tin].into_iter().chain(options))
    };
    goal("0.1").fails(1, &["at most half of the root mean square 0.1"]);
    goal("0.5").succeeds();
    let verdict = terrabite(["verify", &dem, &tin, "--max-error", "9", "--json"]).succeeds().json();
    assert!(verdict["rms_error"].as_f64().unwrap() <= 0.5, "{verdict}");
    let weights = Dem::new(40, 30).heights(|_, _| 1.0).on_the_map().write(&folder, "weights.tif");
    for options in [&["--precision", "float"][..], &["--z-scale", "0.3048"]] {
        simplify("1", &[&["--importance", &weights], options].concat()).succeeds();
        terrabite(["verify", &dem, &tin, "--max-error", "1", "--importance", &weights]).succeeds();
    }
    // Ten times the loss counts, which is most of the tolerance.
    let heavy =
        Dem::new(40, 30).heights(|c, r| f64::from((c, r) == (20, 10)) * 10.0).on_the_map().write(&folder, "heavy.tif");
    let run = simplify("4", &["--precision", "float", "--importance", &heavy]).succeeds();
    assert!(run.json()["map"]["kept_for_rounding"].as_f64().unwrap() < 0.07);
    terrabite(["verify", &dem, &tin, "--max-error", "4", "--importance", &heavy]).succeeds();
    simplify("1", &["--precision", "float", "--importance", &heavy])
        .fails(1, &["half of the tolerance 1", "--precision double"]);
    simplify("1", &["--precision", "float", "--attributes", "1", "--quality", "none"])
        .fails(2, &["--attributes cannot be combined with --precision float: ", "; use --precision double\n"]);
    // Heights of 16 bits lose nothing.
    let dem = Dem::new(40, 30).on_the_map().write(&folder, "dem.tif");
    let run = terrabite(["simplify", &dem, &tin, "--max-error", "0", "--precision", "float", "--overwrite", "--json"]);
    assert_eq!(run.succeeds().json()["map"]["kept_for_rounding"], 0.0);
    terrabite(["verify", &dem, &tin, "--max-error", "0"]).succeeds();
}

#[test]
fn a_picture_says_its_vertical_scale() {
    let folder = Folder::new();
    let (tin, png) = (folder.at("tin.ply"), folder.at("tin.png"));
    // Cells of 0.01°, at 33.2° south; a slope of 1 in 100 along columns.
    let degrees = Dem::new(40, 41).kind(Kind::Float64).heights(|_, row| 11.09 * row as f64);
    let dem = degrees.geo_transform([-71.0, 0.01, 0.0, -33.0, 0.0, -0.01]).epsg(4326).write(&folder, "degrees.tif");
    terrabite(["simplify", &dem, &tin, "--max-error", "0"]).succeeds();
    let run = terrabite(["preview", &dem, &tin, &png]).succeeds();
    let said = "vertical scale 70 (chosen), 1° = 93.2 km × 110.9 km at 33.2° S";
    assert_eq!(run.out.lines().last(), Some(said), "{}", run.out);
    let options = ["--vertical-exaggeration", "2.5", "--overwrite"];
    let run = terrabite(["preview", &dem, &tin, &png].into_iter().chain(options)).succeeds();
    assert_eq!(run.out.lines().last(), Some("vertical scale 2.5, 1° = 93.2 km × 110.9 km at 33.2° S"), "{}", run.out);
    let run = terrabite(["preview", &dem, &tin, &png, "--mode", "error", "--overwrite"]).succeeds();
    assert!(!run.out.contains("vertical scale"), "{}", run.out);
}
