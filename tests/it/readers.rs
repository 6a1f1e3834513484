//! Written meshes in readers that others wrote: trimesh, meshio, plyfile, ugrid-checks and the netCDF library from PyPI,
//! Khronos's validator, glTF Transform and meshoptimizer's decoder from npm, admesh, xmllint, ncdump and ogrinfo from
//! Debian. Those that take longer to install are in `scripts/readers.py` (`make test-readers`).

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::{Value, json};
use terrabite::base::channels::{Channel, Number};
use terrabite::base::staged::StagedFile;
use terrabite::formats::{Contents, Header, PlySink, Sink};

use crate::util::{Dem, Folder, Kind, Run, hills, made_once, terrabite};

const PACKAGES: [&str; 8] = [
    "meshio==5.3.5",
    "netCDF4==1.7.5.1.post1",
    "numpy==2.3.5",
    "pillow==13.0.0",
    "plyfile==1.1.5",
    "quantized-mesh-tile==0.7.0",
    "trimesh==5.2.0",
    "ugrid-checks==0.2.0",
];

/// With all that they need.
const NODE_PACKAGES: [&str; 6] = [
    "@gltf-transform/core@4.5.1",
    "@gltf-transform/extensions@4.5.1",
    "gltf-validator@2.0.0-dev.3.10",
    "ktx-parse@1.1.0",
    "meshoptimizer@1.3.0",
    "property-graph@4.1.0",
];

/// Set where the package indexes cannot be reached.
const SKIP: &str = "TERRABITE_SKIP_READERS";

pub(crate) fn are_skipped() -> bool {
    let skipped = std::env::var_os(SKIP).is_some_and(|v| v == "1");
    if skipped {
        eprintln!("skipped: {SKIP}=1");
    }
    skipped
}

/// A raster, its mesh as PLY in map coordinates, and further meshes of it, each with what a reader is to find in it.
struct Meshes {
    folder: Folder,
    dem: String,
    cases: Vec<Value>,
}

const SIZE: (usize, usize) = (120, 90);
const MISSING: f64 = -9999.0;

/// Numbers of single precision, as --precision float is to lose nothing of them.
fn heights(column: usize, row: usize) -> f64 {
    hills(column, row) + 0.125 * (column % 5) as f64
}

/// Two grounds, one of them with a lake.
fn island(column: usize, row: usize) -> f64 {
    let lake = (column as i64 - 30).pow(2) + (row as i64 - 40).pow(2) <= 60;
    if lake || (70..=75).contains(&column) { MISSING } else { heights(column, row) }
}

/// Three grounds, one of them with a lake; two touch at a sample alone, over a corner.
fn pinch(column: usize, row: usize) -> f64 {
    let lake = (column as i64 - 30).pow(2) + (row as i64 - 20).pow(2) <= 60;
    let (first, second) = (column <= 60 && row <= 44, column >= 60 && row >= 46);
    let third = (80..=110).contains(&column) && (5..=35).contains(&row);
    let touch = (column, row) == (60, 45);
    if !lake && (first || second || third || touch) { heights(column, row) } else { MISSING }
}

/// A quarter of a metre a cell in UTM, where singles are 0.5 m apart.
fn on_the_map(heights: fn(usize, usize) -> f64) -> Dem {
    let dem = Dem::new(SIZE.0, SIZE.1).kind(Kind::Float32).heights(heights).nodata(MISSING).epsg(32633);
    dem.geo_transform([500_000.12, 0.25, 0.0, 5_200_000.77, 0.0, -0.25])
}

impl Meshes {
    /// Of a raster with these heights.
    fn of(dem: &Dem, heights: fn(usize, usize) -> f64) -> Meshes {
        let folder = Folder::new();
        let dem = dem.write(&folder, "dem.tif");
        // Without a place on the map, a raster lies at the origin, with its first row on top.
        let transform = gdal::Dataset::open(&dem).unwrap().geo_transform();
        let transform = transform.unwrap_or([0.0, 1.0, 0.0, 0.0, 0.0, -1.0]);
        let samples = (0..SIZE.0 * SIZE.1).flat_map(|i| heights(i % SIZE.0, i / SIZE.0).to_le_bytes());
        folder.with("heights", samples.collect::<Vec<u8>>());
        let mut meshes = Meshes { folder, dem, cases: Vec::new() };
        meshes.make("ply", "reference.ply", &[]);
        meshes.cases[0]["samples"] = json!({"file": meshes.folder.at("heights"), "transform": transform});
        meshes
    }

    /// Another mesh of the same: how it is checked, what it is called, options. Gives its path and its report.
    fn make(&mut self, check: &str, name: &str, options: &[&str]) -> (String, Value) {
        let path = self.folder.at(name);
        let command = ["simplify", &self.dem, &path, "--max-error", "2", "--quality", "none", "--json"];
        let report = terrabite(command.iter().chain(options)).succeeds().json();
        let (options, reference) = (options.join(" "), self.folder.at("reference.ply"));
        let case = json!({"check": check, "file": path, "options": options, "reference": reference, "report": report});
        self.cases.push(case);
        (path, report)
    }
}

/// Opens all of them in Python. Gives the list of them, and the folder it is in.
fn check(all: &[Meshes]) -> (Folder, String) {
    let folder = Folder::new();
    let cases: Vec<Value> = all.iter().flat_map(|meshes| meshes.cases.clone()).collect();
    let cases = folder.with("cases.json", Value::from(cases).to_string());
    Run::of(Command::new(python()).arg(script("readers.py")).arg(&cases)).succeeds();
    (folder, cases)
}

/// The same, and in the readers from npm.
fn check_glb(all: &[Meshes]) {
    let (_folder, cases) = check(all);
    Run::of(Command::new("node").arg(script("readers.mjs")).arg(node_environment()).arg(cases)).succeeds();
}

fn script(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/it").join(name)
}

#[test]
fn trimesh_and_meshio_read_ply() {
    if are_skipped() {
        return;
    }
    let mut meshes = Meshes::of(&on_the_map(heights), heights);
    meshes.make("ply", "ascii.ply", &["--ascii"]);
    meshes.make("ply", "local.ply", &["--local"]);
    meshes.make("ply", "local-ascii.ply", &["--local", "--ascii", "--z-scale", "2"]);
    meshes.make("ply", "float.ply", &["--precision", "float"]);
    meshes.make("ply", "float-ascii.ply", &["--precision", "float", "--ascii", "--normals", "gradient"]);
    meshes.make("ply", "normals.ply", &["--normals", "area"]);
    let gaps = Meshes::of(&on_the_map(pinch), pinch);
    let dem = Dem::new(SIZE.0, SIZE.1);
    let plain = Meshes::of(&dem, hills);
    let south_up = Meshes::of(&dem.geo_transform([500.0, 2.0, 0.0, 100.0, 0.0, 2.0]), hills);
    check(&[meshes, gaps, plain, south_up]);
}

/// Two triangles whose vertices have the colours (10·i, 0, 255) and a heat of 0.5·i.
#[test]
fn trimesh_and_meshio_read_colours_and_other_attributes() {
    if are_skipped() {
        return;
    }
    let folder = Folder::new();
    let tin = folder.join("tin.ply");
    let channel = |name: &str, number| Channel { name: name.to_string(), number };
    let mut attributes = ["red", "green", "blue"].map(|name| channel(name, Number::U8)).to_vec();
    attributes.push(channel("heat", Number::F32));
    let mut sink = PlySink::new(StagedFile::create(&tin, false, &[]).unwrap(), Header::default());
    sink.begin(&Contents { vertices: 4, triangles: 2, attributes: &attributes, ..Contents::default() }).unwrap();
    let places = [[0.5, -0.5, 1.0], [0.5, -9.5, 2.0], [9.5, -9.5, 3.0], [9.5, -0.5, 4.0]];
    let red: Vec<f64> = (0..4).map(|i| 10.0 * f64::from(i)).collect();
    let heat: Vec<f64> = (0..4).map(|i| 0.5 * f64::from(i)).collect();
    sink.vertices(&places, &[&red, &[0.0; 4], &[255.0; 4], &heat]).unwrap();
    sink.triangles(&[[0, 1, 2], [0, 2, 3]], &[]).unwrap();
    Box::new(sink).finish().unwrap();
    let cases = folder.with("cases.json", json!([{"check": "colours", "file": folder.at("tin.ply")}]).to_string());
    Run::of(Command::new(python()).arg(script("readers.py")).arg(cases)).succeeds();
}

#[test]
fn trimesh_and_meshio_read_obj() {
    if are_skipped() {
        return;
    }
    let mut meshes = Meshes::of(&on_the_map(heights), heights);
    meshes.make("obj", "map.obj", &[]);
    meshes.make("obj", "local.obj", &["--local"]);
    meshes.make("obj", "float.obj", &["--precision", "float"]);
    meshes.make("obj", "gradient.obj", &["--normals", "gradient"]);
    meshes.make("obj", "area.obj", &["--normals", "area", "--local"]);
    let image = image(&meshes.folder);
    meshes.make("obj", "texture.obj", &["--texture", &image]);
    let mut gaps = Meshes::of(&on_the_map(pinch), pinch);
    gaps.make("obj", "gaps.obj", &[]);
    check(&[meshes, gaps]);
}

#[test]
fn trimesh_and_meshio_read_stl() {
    if are_skipped() {
        return;
    }
    let mut meshes = Meshes::of(&on_the_map(heights), heights);
    meshes.make("stl", "map.stl", &[]);
    meshes.make("stl", "scaled.stl", &["--z-scale", "2"]);
    let mut degrees = Meshes::of(&in_degrees(), hills);
    degrees.make("stl", "degrees.stl", &[]);
    let mut gaps = Meshes::of(&on_the_map(island), island);
    gaps.make("stl", "gaps.stl", &[]);
    gaps.make("solid", "solid.stl", &["--base-depth", "10"]);
    gaps.make("solid", "deep.stl", &["--base-height", "-100"]);
    check(&[meshes, degrees, gaps]);
}

/// The raster's hills somewhere in the Alps, whose degrees become metres where a format has those alone.
fn in_degrees() -> Dem {
    let cell = 1.0 / 3600.0;
    Dem::new(SIZE.0, SIZE.1).epsg(4326).geo_transform([8.1, cell, 0.0, 46.3, 0.0, -cell])
}

#[test]
fn admesh_finds_nothing_to_mend_in_solids() {
    if are_skipped() {
        return;
    }
    for (name, heights, parts) in
        [("whole", heights as fn(usize, usize) -> f64, 1), ("island", island, 2), ("pinch", pinch, 3)]
    {
        let mut meshes = Meshes::of(&on_the_map(heights), heights);
        for base in [["--base-depth", "10"], ["--base-height", "0"]] {
            let (solid, report) = meshes.make("solid", &format!("{}.stl", base[0]), &base);
            let run = of_debian("admesh", "admesh", &[&solid]);
            let what = format!("{name} {base:?}: {run:#?}");
            assert!(run.out.contains("All facets connected.  No nearby check necessary."), "{what}");
            let value = |label: &str| admesh_value(&run.out, label).unwrap_or_else(|| panic!("{label}? {what}"));
            let facets = value("Number of facets");
            let [before, after] = facets[..] else { panic!("{what}") };
            // A like for each triangle on the floor, and two for each edge of the rim.
            assert!(before == after && before % 2.0 == 0.0, "{what}");
            assert!(before > 2.0 * report["triangles"].as_f64().unwrap(), "{what}");
            for label in ["1 disconnected edge", "2 disconnected edges", "3 disconnected edges"] {
                assert_eq!(value(&format!("Facets with {label}")), [0.0, 0.0], "{what}");
            }
            assert_eq!(value("Total disconnected facets"), [0.0, 0.0], "{what}");
            for label in ["Degenerate facets", "Edges fixed", "Facets removed", "Facets added", "Facets reversed"] {
                assert_eq!(value(label), [0.0], "{what}");
            }
            assert_eq!((value("Backwards edges"), value("Normals fixed")), (vec![0.0], vec![0.0]), "{what}");
            assert_eq!(value("Number of parts"), [f64::from(parts)], "{what}");
            // 30 m by 22.5 m at the most; heights are between 30 and 121.
            let volume = value("Volume")[0];
            assert!(volume > 10.0 * 300.0 && volume < 122.0 * 30.0 * 22.5, "{what}");
        }
    }
}

/// The numbers behind `label :` in what admesh prints, up to the next label.
fn admesh_value(printed: &str, label: &str) -> Option<Vec<f64>> {
    let (_, rest) = printed.split_once(label).filter(|(before, _)| before.ends_with(['\n', ' ']))?;
    let numbers = rest.lines().next()?.trim_start().strip_prefix(':')?.split_whitespace();
    let values: Vec<f64> = numbers.map_while(|word| word.parse().ok()).collect();
    (!values.is_empty()).then_some(values)
}

#[test]
fn the_validator_gltf_transform_and_trimesh_read_glb() {
    if are_skipped() {
        return;
    }
    let mut meshes = Meshes::of(&on_the_map(heights), heights);
    meshes.make("glb", "map.glb", &[]);
    meshes.make("glb", "scaled.glb", &["--z-scale", "2"]);
    meshes.make("glb", "normals.glb", &["--normals", "gradient"]);
    let image = image(&meshes.folder);
    meshes.make("glb", "texture.glb", &["--texture", &image, "--normals", "area"]);
    meshes.make("compressed", "map-compressed.glb", &["--mesh-compression", "meshopt"]);
    let more = ["--mesh-compression", "meshopt", "--normals", "gradient"];
    meshes.make("compressed", "normals-compressed.glb", &more);
    let more = ["--mesh-compression", "meshopt", "--normals", "area", "--texture", &image];
    meshes.make("compressed", "texture-compressed.glb", &more);

    let mut gaps = Meshes::of(&on_the_map(pinch), pinch);
    gaps.make("glb", "gaps.glb", &[]);
    gaps.make("compressed", "gaps-compressed.glb", &["--mesh-compression", "meshopt"]);

    let mut degrees = Meshes::of(&in_degrees(), hills);
    degrees.make("glb", "degrees.glb", &[]);

    let dem = on_the_map(hills).kind(Kind::Byte).option("PHOTOMETRIC=MINISBLACK").option("ALPHA=NO");
    let mut colours = Meshes::of(&dem.nodata(255.0).bands(4).others(picture), hills);
    // With attributes there are other vertices.
    colours.cases.clear();
    let bands = ["--attributes", "2,3,4"];
    colours.make("ply", "colours.ply", &bands);
    colours.make("glb", "colours.glb", &bands);
    colours.make("compressed", "colours-compressed.glb", &[&bands[..], &["--mesh-compression", "meshopt"]].concat());
    let reference = colours.folder.at("colours.ply");
    colours.cases.iter_mut().for_each(|case| case["reference"] = reference.clone().into());
    check_glb(&[meshes, gaps, degrees, colours]);
}

/// Red grows to the east, green to the south.
fn picture(band: usize, column: usize, row: usize) -> f64 {
    match band % 3 {
        2 => 2.0 * column as f64,
        0 => 2.0 * row as f64,
        _ => 200.0,
    }
}

/// An image of the ground, four times as fine as the raster: [`picture`], in the bands from the first on.
fn image(folder: &Folder) -> String {
    fn first(column: usize, row: usize) -> f64 {
        picture(2, column / 4, row / 4)
    }
    fn others(band: usize, column: usize, row: usize) -> f64 {
        picture(band + 1, column / 4, row / 4)
    }
    let (width, height) = (4 * SIZE.0, 4 * SIZE.1);
    let image = Dem::new(width, height).kind(Kind::Byte).bands(3).heights(first).others(others).epsg(32633);
    let image = image.option("PHOTOMETRIC=RGB").geo_transform([500_000.12, 0.0625, 0.0, 5_200_000.77, 0.0, -0.0625]);
    image.write(folder, "image.tif")
}

#[test]
fn xmllint_reads_landxml() {
    if are_skipped() {
        return;
    }
    let mut all = Vec::new();
    for (heights, options) in [
        (heights as fn(usize, usize) -> f64, &[][..]),
        (heights, &["--local"]),
        (heights, &["--precision", "float"]),
        (pinch, &[]),
    ] {
        let mut meshes = Meshes::of(&on_the_map(heights), heights);
        let (path, report) = meshes.make("landxml", "tin.xml", options);
        let run = of_debian("xmllint", "libxml2-utils", &["--noout", &path]);
        assert_eq!((run.out.as_str(), run.err.as_str()), ("", ""));
        let asked = |path_in_it: &str| {
            of_debian("xmllint", "libxml2-utils", &["--xpath", path_in_it, &path]).out.trim().to_string()
        };
        let count = |name: &str| asked(&format!("count(//*[local-name()='{name}'])"));
        assert_eq!(count("P"), report["vertices"].to_string());
        assert_eq!(count("F"), report["triangles"].to_string());
        assert_eq!(count("Surface"), "1");
        assert_eq!(asked("string(//*[local-name()='Definition']/@surfType)"), "TIN");
        // Only coordinates of the map have a place in its CRS.
        let code = if options.is_empty() { "32633" } else { "" };
        assert_eq!(asked("string(//*[local-name()='CoordinateSystem']/@epsgCode)"), code);
        all.push(meshes);
    }
    check(&all);
}

#[test]
fn plyfile_xmllint_and_ogrinfo_read_edges_of_breaklines() {
    if are_skipped() {
        return;
    }
    let mut meshes = Meshes::of(&on_the_map(heights), heights);
    let line = json!({"type": "LineString", "coordinates": [[500_001.1, 5_200_000.3], [500_014.2, 5_199_990.1]]});
    let crs = json!({"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::32633"}});
    let feature = json!({"type": "Feature", "properties": {}, "geometry": line});
    let lines = json!({"type": "FeatureCollection", "crs": crs, "features": [feature]});
    let lines = meshes.folder.with("lines.geojson", lines.to_string());
    let options = ["--breaklines", &lines];
    let (_, report) = meshes.make("edges", "edges.ply", &options);
    meshes.make("edges", "edges-ascii.ply", &[&options[..], &["--ascii"]].concat());
    let edges = report["breaklines"]["chains"]["edges"].as_u64().unwrap();
    assert!(edges > 5, "{report}");
    let (path, _) = meshes.make("ogr", "edges.xml", &options);
    let points = "string(//*[local-name()='SourceData']/*/*[@brkType='standard'])";
    let points = of_debian("xmllint", "libxml2-utils", &["--xpath", points, &path]).out;
    // A line that meets nothing is in one piece.
    assert_eq!(points.trim().split(' ').count() as u64, 3 * (edges + 1), "{points}");
    let (path, report) = meshes.make("ogr", "edges.gpkg", &options);
    let said = of_debian("ogrinfo", "gdal-bin", &["-al", "-so", &path]).out;
    let of = |label: &str| said.lines().filter_map(|line| line.strip_prefix(label)).collect::<Vec<_>>();
    assert_eq!(of("Layer name: "), ["tin", "tin_breaklines"]);
    assert_eq!(of("Geometry: "), ["3D Polygon", "3D Line String"]);
    assert_eq!(of("Feature Count: "), [report["triangles"].to_string().as_str(), "1"]);
    meshes.cases.retain(|case| case["check"] == "edges");
    check(&[meshes]);
}

#[test]
fn ugrid_checks_ncdump_and_the_netcdf_library_read_ugrid() {
    if are_skipped() {
        return;
    }
    let mut all = Vec::new();
    for (heights, options) in [
        (heights as fn(usize, usize) -> f64, &[][..]),
        (heights, &["--local", "--z-scale", "2"]),
        (heights, &["--precision", "float"]),
        (pinch, &[]),
    ] {
        let mut meshes = Meshes::of(&on_the_map(heights), heights);
        let (path, report) = meshes.make("ugrid", "tin.nc", options);
        assert_eq!(of_debian("ncdump", "netcdf-bin", &["-k", &path]).out.trim(), "64-bit offset");
        let header = of_debian("ncdump", "netcdf-bin", &["-h", &path]).out;
        for (dimension, count) in [("mesh2d_nNodes", "vertices"), ("mesh2d_nFaces", "triangles")] {
            let line = format!("\t{dimension} = {} ;\n", report[count]);
            assert!(header.contains(&line), "{line:?} in {header}");
        }
        all.push(meshes);
    }
    check(&all);
}

#[test]
fn ogrinfo_reads_geopackage_and_flatgeobuf() {
    if are_skipped() {
        return;
    }
    for (heights, name, options) in [
        (heights as fn(usize, usize) -> f64, "tin.gpkg", &[][..]),
        (heights, "tin.fgb", &[]),
        (pinch, "tin.gpkg", &[]),
        (pinch, "tin.fgb", &[]),
        (heights, "tin.gpkg", &["--ogr-geometry", "tin"]),
        (heights, "tin.gpkg", &["--local"]),
        (heights, "tin.gpkg", &["--precision", "float"]),
    ] {
        let mut meshes = Meshes::of(&on_the_map(heights), heights);
        let (path, report) = meshes.make("ogr", name, options);
        let said = of_debian("ogrinfo", "gdal-bin", &["-al", "-so", &path]).out;
        let is_tin = options.contains(&"tin");
        let line = |label: &str| {
            said.lines().find_map(|line| line.strip_prefix(label)).unwrap_or_else(|| panic!("{label}? {said}"))
        };
        assert_eq!(line("Geometry: "), if is_tin { "3D TIN" } else { "3D Polygon" }, "{said}");
        // A TIN has 4096 triangles at the most.
        let triangles = report["triangles"].as_u64().unwrap();
        let features = if is_tin { triangles.div_ceil(4096) } else { triangles };
        assert_eq!(line("Feature Count: "), features.to_string(), "{said}");
        let is_local = report["map"]["offset"] != json!([0.0, 0.0]);
        // The very last line of a CRS is its code.
        assert_eq!(said.contains("\n    ID[\"EPSG\",32633]]\n"), !is_local, "{said}");
        let numbers = |c: char| !(c.is_ascii_digit() || c == '.' || c == '-');
        let extent = line("Extent: ").replace(") - (", " ");
        let extent: Vec<f64> = extent.split(numbers).filter_map(|word| word.parse().ok()).collect();
        // Samples stand at the centres of cells; ogrinfo prints six decimals.
        let [x, y] = [0, 1].map(|axis| report["map"]["offset"][axis].as_f64().unwrap());
        let expected = [500_000.245 - x, 5_199_978.395 - y, 500_029.995 - x, 5_200_000.645 - y];
        let is_near = extent.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 2e-6);
        assert!(extent.len() == 4 && is_near, "{expected:?}: {said}");
    }
}

/// Runs a program of Debian's to its end; it must succeed.
fn of_debian(program: &str, package: &str, arguments: &[&str]) -> Run {
    let there = Command::new(program).arg("--version").output();
    assert!(there.is_ok(), "{program}: {there:?}; `make setup` installs {package}, {SKIP}=1 skips this test");
    Run::of(Command::new(program).args(arguments)).succeeds()
}

/// The interpreter of a virtual environment with [`PACKAGES`], made under the target folder at the first run.
pub(crate) fn python() -> PathBuf {
    let parent = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let python = |environment: &Path| environment.join("bin/python");
    let usable = |environment: &Path| python(environment).exists();
    python(&made_once(parent, "readers", &PACKAGES.join("\n"), usable, |environment| {
        let made = Run::of(Command::new(system_python()).args(["-m", "venv"]).arg(environment));
        assert_eq!(made.code, Some(0), "python3 -m venv failed, `make setup` installs it: {made:#?}");
        let pip = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--only-binary=:all:"];
        let installed = Run::of(Command::new(python(environment)).args(pip).args(PACKAGES));
        assert_eq!(installed.code, Some(0), "PyPI cannot be reached? {SKIP}=1 skips this test: {installed:#?}");
    }))
}

/// A folder with [`NODE_PACKAGES`], made under the target folder at the first run.
fn node_environment() -> PathBuf {
    let parent = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let usable = |environment: &Path| environment.join("node_modules/gltf-validator").exists();
    made_once(parent, "readers-node", &NODE_PACKAGES.join("\n"), usable, |environment| {
        std::fs::create_dir(environment).unwrap();
        // Without one of its own, npm takes that of a folder above.
        std::fs::write(environment.join("package.json"), r#"{"private": true}"#).unwrap();
        let options = ["install", "--silent", "--no-audit", "--no-fund", "--ignore-scripts", "--save-exact"];
        let npm = Command::new("npm").args(options).args(NODE_PACKAGES).current_dir(environment).output();
        let npm = npm.unwrap_or_else(|error| panic!("npm: {error}; `make setup` installs it"));
        assert!(npm.status.success(), "npm's registry cannot be reached? {SKIP}=1 skips this test: {npm:?}");
    })
}

/// The first Python that can make environments for [`PACKAGES`]. The one of the path may be another than the system's,
/// without `venv` or too old; `scripts/setup.sh` looks at the same two.
fn system_python() -> &'static str {
    let suits = "import ensurepip, sys, venv; sys.exit(sys.version_info < (3, 11))";
    let can = |python: &&str| Command::new(python).args(["-c", suits]).output().is_ok_and(|o| o.status.success());
    let candidates = ["python3", "/usr/bin/python3"];
    candidates.into_iter().find(can).unwrap_or_else(|| panic!("no Python 3.11 with venv: `make setup` installs it"))
}
