//! What the unit tests of all modules share.

pub(crate) mod heap;

use std::io::Write;
use std::path::{Path, PathBuf};

use gdal::DriverManager;
use gdal::raster::Buffer;
use gdal::spatial_ref::SpatialRef;
use proptest::prelude::ProptestConfig;
use tempfile::TempDir;

use crate::formats::{Format, MeshReader, ReadError, ReadOptions};
use crate::fuzzing::temp_dir;
use crate::job::Params;

/// Set to 1 by `make test-long`.
const LONG: &str = "TERRABITE_LONG_TESTS";

/// A property is tried `usual` times by `make test` and `long` times by `make test-long`.
pub(crate) fn cases(usual: u32, long: u32) -> ProptestConfig {
    assert!(usual <= long, "{usual} cases are more than {long}");
    ProptestConfig::with_cases(if is_long() { long } else { usual })
}

/// Whether `make test-long` runs.
pub(crate) fn is_long() -> bool {
    std::env::var_os(LONG).is_some_and(|value| value == "1")
}

/// A folder for small files, in memory where there is such a place: a finished mesh is synced, and for a disk that takes
/// longer than all else a small mesh needs.
pub(crate) fn folder() -> TempDir {
    tempfile::tempdir_in(temp_dir()).expect("a folder")
}

/// The same parameters, with temporary files in memory.
pub(crate) fn in_memory(params: &Params) -> Params {
    Params { temp_dir: temp_dir(), ..params.clone() }
}

/// Writes a raster of singles; without a CRS, if that is empty.
pub(crate) fn raster(
    folder: &Path,
    name: &str,
    size: (usize, usize),
    transform: [f64; 6],
    crs: &str,
    at: &dyn Fn(usize, usize) -> f32,
) -> PathBuf {
    let path = folder.join(name);
    let driver = DriverManager::get_driver_by_name("GTiff").expect("GeoTIFF");
    let mut dataset = driver.create_with_band_type::<f32, _>(&path, size.0, size.1, 1).expect("a raster");
    dataset.set_geo_transform(&transform).expect("placed");
    if !crs.is_empty() {
        dataset.set_spatial_ref(&SpatialRef::from_definition(crs).expect("a CRS")).expect("placed");
    }
    let samples = (0..size.0 * size.1).map(|i| at(i % size.0, i / size.0)).collect();
    let mut band = dataset.rasterband(1).expect("a band");
    band.write((0, 0), size, &mut Buffer::new(size, samples)).expect("written");
    path
}

#[test]
fn the_long_tests_are_asked_for_by_name() {
    assert_eq!(cases(3, 40).cases, if is_long() { 40 } else { 3 });
}

/// A band of a raster, from 1.
///
/// # Panics
/// If it cannot be opened.
pub(crate) fn band(path: &Path, number: usize) -> crate::base::Band {
    crate::raster::Raster::open(path, number).and_then(|raster| raster.to_band()).expect("a raster")
}

/// Vertices and faces.
pub(crate) type Mesh = (Vec<[f64; 3]>, Vec<[u64; 3]>);

/// All that a reader has, faces first: passes may come in any order.
pub(crate) fn mesh(reader: &mut dyn MeshReader) -> Result<Mesh, ReadError> {
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    reader.for_each_face(|_, face| {
        faces.push(face);
        Ok::<(), ReadError>(())
    })?;
    reader.for_each_vertex(|_, vertex| {
        vertices.push(vertex);
        Ok::<(), ReadError>(())
    })?;
    Ok((vertices, faces))
}

/// A file with these bytes.
pub(crate) fn file(bytes: &[u8]) -> tempfile::NamedTempFile {
    let mut file = tempfile::NamedTempFile::new_in(temp_dir()).expect("a file");
    file.write_all(bytes).expect("written");
    file
}

/// The mesh in these bytes, or what is wrong: a message must begin with the name of the file, which is left out.
pub(crate) fn mesh_in(format: &Format, bytes: &[u8]) -> Result<Mesh, String> {
    let file = file(bytes);
    let read = (format.reader)(file.path(), &ReadOptions::default()).and_then(|mut reader| mesh(reader.as_mut()));
    read.map_err(|error| without_name(file.path(), &error.to_string()))
}

/// A message without the name of the file, with which it must begin.
pub(crate) fn without_name(path: &Path, said: &str) -> String {
    said.strip_prefix(&format!("{}: ", path.display())).unwrap_or_else(|| panic!("{said}")).to_string()
}
