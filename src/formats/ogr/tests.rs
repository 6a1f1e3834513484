//! What is in written files, files of other programs, and damaged ones.

use std::path::{Path, PathBuf};

use gdal::vector::{LayerAccess, OGRwkbGeometryType};
use gdal::{Dataset, DatasetOptions, GdalOpenFlags, Metadata};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::{Index, select};

use super::FORMAT;
use crate::base::CoordinateFrame;
use crate::base::channels::{Channel, Number};
use crate::base::staged::StagedFile;
use crate::formats::{
    Contents, Crs, Header, MeshReader, OgrGeometry, ReadError, ReadOptions, Setup, SinkError, SinkOptions, open,
};
use crate::raster::quiet_gdal;
use crate::testing;

const VERTICES: [[f64; 3]; 4] =
    [[500_000.12, 5_200_000.77, 0.1], [500_000.37, 5_200_000.77, 2.0], [500_000.37, 5_200_001.02, -3.5], [0.0; 3]];
const TRIANGLES: [[u64; 3]; 2] = [[0, 1, 2], [2, 3, 0]];

fn utm() -> Header {
    let crs = Crs { definition: Some("EPSG:32633".to_string()), ..Crs::default() };
    Header { crs, tolerance: Some(0.5), ..Header::default() }
}

fn written(path: &Path, setup: Setup, attributes: &[Channel], values: &[&[f64]]) -> Result<(), SinkError> {
    quiet_gdal();
    let mut sink = (FORMAT.sink)(StagedFile::create(path, false, &[]).expect("staged"), setup)?;
    sink.begin(&Contents { vertices: 4, triangles: 2, attributes, ..Contents::default() })?;
    sink.vertices(&VERTICES, values)?;
    sink.triangles(&TRIANGLES, &TRIANGLES.map(|t| t.map(|v| VERTICES[v as usize])))?;
    sink.finish()
}

fn setup(options: SinkOptions) -> Setup {
    Setup { header: utm(), options, ..Setup::default() }
}

fn tin() -> SinkOptions {
    SinkOptions { ogr_geometry: Some(OgrGeometry::Tin), ..SinkOptions::default() }
}

fn driver(name: &'static str) -> SinkOptions {
    SinkOptions { ogr_driver: Some(name), ..SinkOptions::default() }
}

fn channel(name: &str, number: Number) -> Channel {
    Channel { name: name.to_string(), number }
}

/// Vertices in the order in which triangles name them, with the attributes that there are; and triangles.
type Mesh = (Vec<([f64; 3], Vec<f64>)>, Vec<[u64; 3]>);

fn read(reader: &mut dyn MeshReader) -> Result<Mesh, ReadError> {
    let names: Vec<String> = reader.attributes().iter().map(|a| a.name.clone()).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    reader.for_each_vertex_with(&names, |_, place, values| {
        vertices.push((place, values.to_vec()));
        Ok::<(), ReadError>(())
    })?;
    reader.for_each_face(|_, face| {
        triangles.push(face);
        Ok::<(), ReadError>(())
    })?;
    Ok((vertices, triangles))
}

fn opened(path: &Path) -> Result<Box<dyn MeshReader>, ReadError> {
    quiet_gdal();
    open(path, Some(&FORMAT), &ReadOptions::default())
}

fn mesh(path: &Path) -> Result<Mesh, ReadError> {
    read(opened(path)?.as_mut())
}

fn plain() -> Mesh {
    (VERTICES.map(|place| (place, Vec::new())).to_vec(), TRIANGLES.to_vec())
}

/// A layer in text, with a geometry for each feature.
fn of_wkt(folder: &tempfile::TempDir, geometries: &[&str]) -> PathBuf {
    let path = folder.path().join("mesh.csv");
    let lines: Vec<String> = geometries.iter().map(|wkt| format!("1,\"{wkt}\"\n")).collect();
    std::fs::write(&path, format!("id,WKT\n{}", lines.concat())).expect("written");
    path
}

fn refusal(path: &Path) -> String {
    let error = mesh(path).expect_err("refused").to_string();
    let rest = error.strip_prefix(&format!("{}: ", path.display())).map(str::to_string);
    rest.unwrap_or_else(|| panic!("{error} does not begin with the file"))
}

#[test]
fn a_package_has_polygons_fields_a_crs_and_the_header() {
    let folder = testing::folder();
    let path = folder.path().join("mesh.gpkg");
    let attributes = [channel("red", Number::U8), channel("heat", Number::F64)];
    let values: [&[f64]; 2] = [&[0.0, 255.0, 7.0, 1.0], &[0.1, -1e300, 3.0, 4.0]];
    written(&path, setup(SinkOptions::default()), &attributes, &values).expect("written");

    let dataset = Dataset::open(&path).expect("a package");
    assert_eq!(dataset.layer_count(), 1);
    let mut layer = dataset.layer(0).expect("a layer");
    assert_eq!((layer.name(), layer.feature_count()), ("tin".to_string(), 2));
    assert_eq!(layer.defn().geometry_type(), OGRwkbGeometryType::wkbPolygon25D);
    assert_eq!(layer.spatial_ref().expect("a CRS").authority().expect("a code"), "EPSG:32633");
    let names: Vec<String> = layer.defn().fields().map(|field| field.name()).collect();
    assert_eq!(names, ["red_1", "red_2", "red_3", "heat_1", "heat_2", "heat_3"]);
    let header = "{\"attributes\":[{\"name\":\"red\",\"number\":\"u8\"},{\"name\":\"heat\",\"number\":\"f64\"}],\
                  \"facts\":[\"crs:EPSG:32633\",\"max_error 0.5\"],\"triangles\":2}";
    assert_eq!(layer.metadata_item("terrabite", "").as_deref(), Some(header));
    let feature = layer.features().next().expect("a feature");
    let fields: Vec<Option<f64>> = (0..6).map(|i| feature.field_as_double(i).expect("a field")).collect();
    assert_eq!(fields, [0.0, 255.0, 7.0, 0.1, -1e300, 3.0].map(Some));
    let mut ring = Vec::new();
    feature.geometry().expect("a geometry").get_geometry(0).get_points(&mut ring);
    let corner = |i: usize| (VERTICES[i][0], VERTICES[i][1], VERTICES[i][2]);
    assert_eq!(ring, [0, 1, 2, 0].map(corner));

    let mut reader = opened(&path).expect("a mesh");
    assert_eq!((reader.header(), reader.attributes()), (&utm(), &attributes[..]));
    let (vertices, triangles) = read(reader.as_mut()).expect("a mesh");
    let expected = (0..4).map(|i| (VERTICES[i], vec![values[0][i], values[1][i]])).collect::<Vec<_>>();
    assert_eq!((vertices, triangles), (expected, TRIANGLES.to_vec()));
}

#[test]
fn the_same_mesh_is_the_same_bytes() {
    for name in ["mesh.gpkg", "mesh.fgb"] {
        let bytes = [1, 2].map(|_| {
            let folder = testing::folder();
            let path = folder.path().join(name);
            written(&path, setup(SinkOptions::default()), &[], &[]).expect("written");
            let names: Vec<_> =
                folder.path().read_dir().expect("a folder").map(|e| e.expect("an entry").path()).collect();
            assert_eq!(names, [path.as_path()]);
            std::thread::sleep(std::time::Duration::from_millis(2));
            std::fs::read(&path).expect("a file")
        });
        assert!(bytes[0] == bytes[1], "{name}");
    }
}

#[test]
fn flat_geobuf_keeps_the_mesh_its_attributes_and_the_crs() {
    let folder = testing::folder();
    let path = folder.path().join("mesh.fgb");
    let attributes = [channel("red", Number::U8), channel("heat", Number::F32)];
    let values: [&[f64]; 2] = [&[0.0, 255.0, 7.0, 1.0], &[0.5, -0.25, 3.0, 4.0]];
    written(&path, setup(SinkOptions::default()), &attributes, &values).expect("written");
    let mut reader = opened(&path).expect("a mesh");
    assert_eq!(reader.header().crs.definition.as_deref(), Some("EPSG:32633"));
    assert_eq!(reader.header().crs.name.as_deref(), Some("EPSG:32633 (WGS 84 / UTM zone 33N)"));
    assert_eq!(reader.attributes(), [channel("red", Number::F64), channel("heat", Number::F64)]);
    let (vertices, triangles) = read(reader.as_mut()).expect("a mesh");
    let expected = (0..4).map(|i| (VERTICES[i], vec![values[0][i], values[1][i]])).collect::<Vec<_>>();
    assert_eq!((vertices, triangles), (expected, TRIANGLES.to_vec()));

    let whole = std::fs::read(&path).expect("a file");
    for cut in 0..whole.len() {
        std::fs::write(&path, &whole[..cut]).expect("cut");
        refusal(&path);
    }
}

#[test]
fn tins_have_many_triangles_or_one_with_its_attributes() {
    for name in ["mesh.gpkg", "mesh.fgb"] {
        for with_attributes in [false, true] {
            let folder = testing::folder();
            let path = folder.path().join(name);
            let (attributes, values): (&[Channel], &[&[f64]]) =
                if with_attributes { (&[channel("heat", Number::F64)], &[&[0.0, 1.0, 2.0, 3.0]]) } else { (&[], &[]) };
            written(&path, setup(tin()), attributes, values).expect("written");
            let dataset = Dataset::open(&path).expect("a file");
            let mut layer = dataset.layer(0).expect("a layer");
            assert_eq!(layer.feature_count(), 1 + u64::from(with_attributes));
            let feature = layer.features().next().expect("a feature");
            assert_eq!(feature.geometry().expect("one").geometry_type(), OGRwkbGeometryType::wkbTINZ);
            let (vertices, triangles) = mesh(&path).expect("a mesh");
            assert_eq!(triangles, TRIANGLES);
            for (i, (place, found)) in vertices.iter().enumerate() {
                assert_eq!((*place, found.first().copied()), (VERTICES[i], with_attributes.then_some(i as f64)));
            }
        }
    }
}

#[test]
fn zeros_have_no_sign_and_what_is_no_number_comes_back() {
    for name in ["mesh.gpkg", "mesh.fgb"] {
        let folder = testing::folder();
        let path = folder.path().join(name);
        let values: &[&[f64]] = &[&[-0.0, f64::NAN, f64::INFINITY, 5e-324]];
        written(&path, setup(SinkOptions::default()), &[channel("heat", Number::F64)], values).expect("written");
        let (vertices, _) = mesh(&path).expect("a mesh");
        let found: Vec<u64> = vertices.iter().map(|(_, values)| values[0].to_bits()).collect();
        assert_eq!(found, [0.0, f64::NAN, f64::INFINITY, 5e-324].map(f64::to_bits), "{name}");
    }
}

#[test]
fn formats_that_lose_something_are_refused() {
    let folder = testing::folder();
    let path = folder.path().join("mesh");
    let refused = |options| match written(&path, setup(options), &[], &[]) {
        Err(SinkError::Unfit { expected, found, .. }) => (expected, found),
        other => panic!("{other:?}"),
    };
    for (name, why) in [
        ("geojson", "GeoJSON, which rounds coordinates, and has no geometry for a TIN"),
        ("ESRI Shapefile", "ESRI Shapefile, which is several files"),
        ("Nothing", "Nothing, which is not known to"),
    ] {
        let expected = "a format of GDAL that gives back triangles as they are (GPKG, FlatGeobuf)";
        assert_eq!(refused(driver(name)), (expected.to_string(), why.to_string()));
    }
    for name in ["PGDump", "OpenFileGDB", "GeoJSONSeq", "KML", "LIBKML", "MapInfo File", "DXF", "CSV"] {
        assert!(refused(driver(name)).1.starts_with(&format!("{name}, which ")));
    }
    for frame in [
        CoordinateFrame { origin: (1.0, 0.0), ..CoordinateFrame::PLAIN },
        CoordinateFrame { z_scale: 2.0, ..CoordinateFrame::PLAIN },
        CoordinateFrame { single: true, ..CoordinateFrame::PLAIN },
    ] {
        let setup = Setup { header: Header { frame, ..utm() }, options: driver("FlatGeobuf"), ..Setup::default() };
        assert!(matches!(written(&path, setup, &[], &[]), Err(SinkError::Unfit { .. })));
    }
    let twice = [channel("heat", Number::F64), channel("Heat", Number::F64)];
    let written = written(&path, setup(SinkOptions::default()), &twice, &[&[0.0; 4], &[0.0; 4]]);
    assert!(matches!(written, Err(SinkError::Unfit { .. })));
    assert_eq!(folder.path().read_dir().expect("a folder").count(), 0);
}

#[test]
fn a_local_mesh_has_no_crs_but_the_header_knows_it() {
    let folder = testing::folder();
    let path = folder.path().join("mesh.gpkg");
    let frame = CoordinateFrame { origin: (500_000.0, 5_200_000.0), ..CoordinateFrame::PLAIN };
    let header = Header { frame, ..utm() };
    written(&path, Setup { header: header.clone(), ..Setup::default() }, &[], &[]).expect("written");
    let dataset = Dataset::open(&path).expect("a file");
    let crs = dataset.layer(0).expect("a layer").spatial_ref();
    assert!(crs.is_none_or(|crs| crs.auth_code().is_err()));
    assert_eq!(opened(&path).expect("a mesh").header(), &header);
}

#[test]
fn names_of_any_bytes_are_written_and_read() {
    use std::os::unix::ffi::OsStrExt;
    let folder = testing::folder();
    for name in [&b"relev\xe9.gpkg"[..], b"relev\xe9.fgb", b"a b'c\".gpkg"] {
        let path = folder.path().join(std::ffi::OsStr::from_bytes(name));
        written(&path, setup(SinkOptions::default()), &[], &[]).expect("written");
        assert_eq!(mesh(&path).expect("a mesh"), plain());
    }
}

#[test]
fn permissions_are_those_of_any_new_file() {
    use std::os::unix::fs::PermissionsExt;
    let folder = testing::folder();
    let (path, other) = (folder.path().join("mesh.gpkg"), folder.path().join("other"));
    std::fs::write(&other, "").expect("written");
    written(&path, setup(SinkOptions::default()), &[], &[]).expect("written");
    let mode = |path: &Path| path.metadata().expect("there").permissions().mode();
    assert_eq!(mode(&path), mode(&other));
}

#[test]
fn geometries_of_other_programs_are_read() {
    let folder = testing::folder();
    let (a, b) = ("((0 0 1,1 0 2,0 1 3,0 0 1))", "((1 0 2,1 1 4,0 1 3,1 0 2))");
    let expected = [[0.0, 0.0, 1.0], [1.0, 0.0, 2.0], [0.0, 1.0, 3.0], [1.0, 1.0, 4.0]];
    for geometries in [
        vec![format!("POLYGON Z {a}"), format!("POLYGON Z {b}")],
        vec![format!("TRIANGLE Z {a}"), format!("POLYGON Z {b}")],
        vec![format!("TIN Z ({a},{b})")],
        vec![format!("POLYHEDRALSURFACE Z ({a},{b})")],
        vec![format!("MULTIPOLYGON Z ({a},{b})")],
        vec![format!("GEOMETRYCOLLECTION Z (POLYGON Z {a},TIN Z ({b}))")],
    ] {
        let geometries: Vec<&str> = geometries.iter().map(String::as_str).collect();
        let (vertices, triangles) = mesh(&of_wkt(&folder, &geometries)).expect("a mesh");
        assert_eq!(triangles, [[0, 1, 2], [1, 3, 2]], "{geometries:?}");
        assert!(vertices.iter().zip(expected).all(|((place, _), expected)| *place == expected), "{geometries:?}");
    }
}

#[test]
fn what_is_no_mesh_is_refused_with_the_feature() {
    let folder = testing::folder();
    let good = "POLYGON Z ((0 0 1,1 0 2,0 1 3,0 0 1))";
    for (wkt, found) in [
        ("POLYGON Z ((0 0 1,1 0 2,1 1 3,0 1 4,0 0 1))", "a ring of 4 corners"),
        ("POLYGON ((0 0,1 0,0 1,0 0))", "a polygon without heights"),
        ("POINT Z (1 2 3)", "a point"),
        ("POLYGON Z EMPTY", "a polygon that is empty"),
        ("", "no geometry"),
    ] {
        let refused = refusal(&of_wkt(&folder, &[good, wkt]));
        assert_eq!(refused, format!("feature 2: expected triangles with heights, found {found}"));
    }
    let path = folder.path().join("table.csv");
    std::fs::write(&path, "a,b\n1,2\n").expect("written");
    assert_eq!(refusal(&path), "expected one layer with geometry, found none");
    std::fs::write(&path, "\u{1}").expect("written");
    assert!(refusal(&path.with_extension("none")).contains("No such file"));
    let path = path.with_extension("gpkg");
    std::fs::write(&path, "no database").expect("written");
    assert!(refusal(&path).starts_with("GDAL cannot open it: "));
}

fn update(path: &Path) -> Dataset {
    let open_flags = GdalOpenFlags::GDAL_OF_UPDATE | GdalOpenFlags::GDAL_OF_VECTOR;
    Dataset::open_ex(path, DatasetOptions { open_flags, ..DatasetOptions::default() }).expect("a file")
}

fn sql(path: &Path, statement: &str) {
    drop(update(path).execute_sql(statement, None, gdal::vector::sql::Dialect::DEFAULT).expect("done"));
}

fn package(folder: &tempfile::TempDir) -> PathBuf {
    let path = folder.path().join("mesh.gpkg");
    written(&path, setup(SinkOptions::default()), &[channel("red", Number::U8)], &[&[1.0; 4]]).expect("written");
    path
}

#[test]
fn layers_beside_the_mesh_are_refused_by_name() {
    let folder = testing::folder();
    let path = package(&folder);
    update(&path).create_layer(gdal::vector::LayerOptions { name: "roads", ..Default::default() }).expect("a layer");
    assert_eq!(refusal(&path), "expected one layer with geometry, found tin, roads");
}

#[test]
fn missing_rows_and_damaged_headers_are_noticed() {
    for (statement, expected) in [
        ("DELETE FROM tin WHERE fid = 1", "expected 2 triangles, as the file says, found 1: it is damaged"),
        (
            "UPDATE tin SET red_2 = 256 WHERE fid = 2",
            "feature 2: expected a whole number from 0 to 255 in the field red_2, found 256",
        ),
        (
            "UPDATE tin SET red_2 = NULL WHERE fid = 2",
            "feature 2: expected a whole number from 0 to 255 in the field red_2, found nothing",
        ),
        (
            "UPDATE gpkg_metadata SET metadata = replace(metadata, 'facts', 'lies')",
            "expected triangles, attributes and facts in JSON under \"terrabite\" in the metadata of the layer",
        ),
        (
            "UPDATE gpkg_metadata SET metadata = replace(metadata, '\"red', '\"green')",
            "expected attributes that are fields in the metadata of the layer, found \"green_1\"",
        ),
    ] {
        let folder = testing::folder();
        let path = package(&folder);
        sql(&path, statement);
        let refused = refusal(&path);
        assert!(refused.starts_with(expected), "{statement}: {refused}");
    }
}

#[test]
fn a_package_without_its_end_is_refused() {
    let folder = testing::folder();
    let path = package(&folder);
    let whole = std::fs::read(&path).expect("a file");
    for cut in [whole.len() - 1, whole.len() - 5000, whole.len() / 2, 200] {
        std::fs::write(&path, &whole[..cut]).expect("cut");
        assert_eq!(refusal(&path), format!("expected {} bytes, as bytes 16 to 31 say, found {cut}", whole.len()));
    }
}

#[test]
fn a_file_that_changes_between_passes_is_noticed() {
    for statement in ["DELETE FROM tin WHERE fid = 2", "INSERT INTO tin (geom) SELECT geom FROM tin WHERE fid = 1"] {
        let folder = testing::folder();
        let path = package(&folder);
        let mut reader = opened(&path).expect("a mesh");
        read(reader.as_mut()).expect("a mesh");
        sql(&path, statement);
        let error = read(reader.as_mut()).expect_err("noticed").to_string();
        assert!(error.contains("the file is being changed"), "{statement}: {error}");
    }
}

/// Writes triangles that share no vertex, and gives back the places of their corners.
fn there_and_back(path: &Path, options: SinkOptions, corners: &[[[f64; 3]; 3]]) -> Vec<[u64; 3]> {
    quiet_gdal();
    let places = corners.as_flattened();
    let triangles: Vec<[u64; 3]> = (0..corners.len() as u64).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    let staged = StagedFile::create(path, true, &[]).expect("staged");
    let loss = f64::INFINITY;
    let mut sink = (FORMAT.sink)(staged, Setup { options, loss, ..Setup::default() }).expect("a sink");
    let (vertices, count) = (places.len() as u64, corners.len() as u64);
    sink.begin(&Contents { vertices, triangles: count, ..Contents::default() }).expect("begun");
    sink.vertices(places, &[]).expect("written");
    sink.triangles(&triangles, corners).expect("written");
    sink.finish().expect("finished");
    let (vertices, triangles) = mesh(path).expect("a mesh");
    let place = |vertex: u64| vertices[vertex as usize].0.map(f64::to_bits);
    triangles.iter().flatten().map(|vertex| place(*vertex)).collect()
}

#[test]
fn more_triangles_than_are_written_at_a_time() {
    let corner = |t: u32, c: u32| [f64::from(3 * t + c), f64::from(t % 7), 0.5];
    let corners: Vec<[[f64; 3]; 3]> = (0..10_000).map(|t| [corner(t, 0), corner(t, 1), corner(t, 2)]).collect();
    let expected: Vec<[u64; 3]> = corners.as_flattened().iter().map(|c| c.map(f64::to_bits)).collect();
    for (name, options, features) in [
        ("mesh.gpkg", SinkOptions::default(), 10_000),
        ("mesh.gpkg", tin(), 3),
        ("mesh.fgb", SinkOptions::default(), 10_000),
        ("mesh.fgb", tin(), 3),
    ] {
        let folder = testing::folder();
        let path = folder.path().join(name);
        assert!(there_and_back(&path, options, &corners) == expected, "{name}");
        let dataset = Dataset::open(&path).expect("a file");
        assert_eq!(dataset.layer(0).expect("a layer").feature_count(), features, "{name}");
    }
}

fn number() -> impl Strategy<Value = f64> {
    prop_oneof![-1e7f64..1e7, select(vec![0.0, -0.0, 1e-300, -1e22, 0.1, f64::MAX, f64::MIN_POSITIVE])]
}

proptest! {
    #![proptest_config(testing::cases(16, 500))]

    #[test]
    fn any_triangle_comes_back_bit_for_bit(
        corners in vec([(); 3].map(|()| [number(), number(), number()]), 1..20), is_tin: bool, is_flat: bool,
    ) {
        let folder = testing::folder();
        let path = folder.path().join(if is_flat { "mesh.fgb" } else { "mesh.gpkg" });
        let options = if is_tin { tin() } else { SinkOptions::default() };
        let expected: Vec<[u64; 3]> = corners.as_flattened().iter().map(|c| c.map(f64::to_bits)).collect();
        prop_assert_eq!(there_and_back(&path, options, &corners), expected);
    }

    #[test]
    fn damage_to_flat_geobuf_is_no_panic(damage in vec((any::<Index>(), any::<u8>()), 1..6), is_tin: bool) {
        let folder = testing::folder();
        let path = folder.path().join("mesh.fgb");
        let options = if is_tin { tin() } else { SinkOptions::default() };
        written(&path, setup(options), &[], &[]).expect("written");
        let mut bytes = std::fs::read(&path).expect("a file");
        for (at, byte) in &damage {
            let at = at.index(bytes.len());
            bytes[at] = *byte;
        }
        std::fs::write(&path, bytes).expect("damaged");
        // Any outcome is right.
        let _ = mesh(&path);
    }
}
