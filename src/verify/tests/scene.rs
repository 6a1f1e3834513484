//! Small rasters and meshes on disk.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use gdal::DriverManager;
use gdal::raster::{Buffer, GdalType};

use crate::base::Band;
use crate::base::GeoTransform;
use crate::base::control::Control;
use crate::verify::grid::orientation;
use crate::verify::{GroundOptions, Verdict, VerifyError, VerifyOptions, judge, open, verify};

/// North-up, as most rasters are.
pub(super) const NORTH_UP: [f64; 6] = [500_000.25, 30.0, 0.0, 5_200_000.5, 0.0, -30.0];
/// Rows run north: counter-clockwise is the other way round in (column, row).
pub(super) const SOUTH_UP: [f64; 6] = [-7.1, 0.1, 0.0, 46.3, 0.0, 0.1];
/// Turned.
pub(super) const TURNED: [f64; 6] = [1000.0, 0.3, 0.4, 2000.0, 0.4, -0.3];

/// A raster and a mesh that may be spoilt before they are compared.
#[derive(Debug, Clone)]
pub(super) struct Scene {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) transform: [f64; 6],
    pub(super) samples: Vec<f64>,
    pub(super) mesh: Mesh,
}

/// Vertices on the lattice, faces counter-clockwise on a north-up map.
#[derive(Debug, Clone, Default)]
pub(super) struct Mesh {
    pub(super) places: Vec<(i64, i64)>,
    pub(super) heights: Vec<f64>,
    pub(super) faces: Vec<[u64; 3]>,
}

impl Mesh {
    /// The rectangle as two triangles.
    pub(super) fn rectangle(width: usize, height: usize) -> Mesh {
        let (x, y) = (4 * (width as i64 - 1), 4 * (height as i64 - 1));
        Mesh { places: vec![(0, 0), (x, 0), (x, y), (0, y)], heights: vec![0.0; 4], faces: vec![[0, 2, 1], [0, 3, 2]] }
    }

    /// Splits the triangles that hold a point at it; the mesh stays whole.
    pub(super) fn insert(&mut self, place: (i64, i64), height: f64) {
        let turn = |places: &[(i64, i64)], a: u64, b: u64| -orientation(places[a as usize], places[b as usize], place);
        if self.places.contains(&place) {
            return;
        }
        let new = self.places.len() as u64;
        let mut faces = Vec::new();
        for &[a, b, c] in &self.faces {
            let turns = [(a, b), (b, c), (c, a)].map(|(p, q)| (p, q, turn(&self.places, p, q)));
            if turns.iter().any(|t| t.2 < 0) {
                faces.push([a, b, c]);
            } else {
                faces.extend(turns.iter().filter(|t| t.2 > 0).map(|&(p, q, _)| [p, q, new]));
            }
        }
        self.faces = faces;
        self.places.push(place);
        self.heights.push(height);
    }

    /// Every cell of a raster with four heights as two triangles, and half of every cell with three as one. The
    /// diagonals of the former fall or rise as they are told to. NaN is no height.
    pub(super) fn of_cells(width: usize, samples: &[f64], mut falls: impl FnMut() -> bool) -> Mesh {
        let mut mesh = Mesh::default();
        let mut vertices = std::collections::HashMap::new();
        let mut add = |corners: [(usize, usize); 3]| {
            let face = corners.map(|(column, row)| {
                *vertices.entry((column, row)).or_insert_with(|| {
                    mesh.places.push((4 * column as i64, 4 * row as i64));
                    mesh.heights.push(samples[row * width + column]);
                    mesh.places.len() as u64 - 1
                })
            });
            mesh.faces.push(face);
        };
        for (r, c) in (0..samples.len() / width - 1).flat_map(|r| (0..width - 1).map(move |c| (r, c))) {
            // Counter-clockwise on a north-up map.
            let ring = [(c, r), (c, r + 1), (c + 1, r + 1), (c + 1, r)];
            let valid: Vec<_> = ring.into_iter().filter(|&(c, r)| !samples[r * width + c].is_nan()).collect();
            match valid[..] {
                [p, q, s] => add([p, q, s]),
                [nw, sw, se, ne] if falls() => [[nw, sw, se], [nw, se, ne]].into_iter().for_each(&mut add),
                [nw, sw, se, ne] => [[nw, sw, ne], [sw, se, ne]].into_iter().for_each(&mut add),
                _ => {}
            }
        }
        mesh
    }

    /// An ascii PLY, whose shortest decimals are read back as the same doubles.
    pub(super) fn ply(&self, transform: [f64; 6], size: (usize, usize)) -> String {
        let transform = GeoTransform::new(transform, size.0, size.1).unwrap();
        let (vertices, faces) = (self.places.len(), self.faces.len());
        let mut out = format!(
            "ply\nformat ascii 1.0\nelement vertex {vertices}\nproperty double x\nproperty double y\nproperty double z\n\
             element face {faces}\nproperty list uchar uint vertex_indices\nend_header\n"
        );
        for (&(x, y), z) in self.places.iter().zip(&self.heights) {
            let (x, y) = transform.apply(x, y);
            writeln!(out, "{x} {y} {z}").unwrap();
        }
        for [a, b, c] in &self.faces {
            writeln!(out, "3 {a} {b} {c}").unwrap();
        }
        out
    }
}

impl Scene {
    /// Samples and vertices at 0, with a few vertices inside and on the rim. 9 × 7 samples.
    pub(super) fn flat() -> Scene {
        let (width, height) = (9, 7);
        let mut mesh = Mesh::rectangle(width, height);
        for place in [(12, 8), (16, 0), (20, 18), (32, 11), (7, 13), (16, 12)] {
            mesh.insert(place, 0.0);
        }
        Scene { width, height, transform: NORTH_UP, samples: vec![0.0; width * height], mesh }
    }

    /// With the weights of errors.
    pub(super) fn judge_weighted(&self, max_error: f64, weights: &[f64]) -> Result<Verdict, VerifyError> {
        let dir = tempfile::tempdir().unwrap();
        let path = write_raster(&dir, (self.width, self.height), weights, |_| {});
        let importance = crate::testing::band(&path, 1);
        self.judge_with(&self.mesh_ply(), max_error, Some(&importance))
    }

    pub(super) fn judge(&self, max_error: f64) -> Result<Verdict, VerifyError> {
        self.judge_ply(&self.mesh_ply(), max_error)
    }

    pub(super) fn mesh_ply(&self) -> String {
        let mut mesh = self.mesh.clone();
        if self.transform[1] * self.transform[5] - self.transform[2] * self.transform[4] > 0.0 {
            mesh.faces.iter_mut().for_each(|f| f.swap(1, 2));
        }
        mesh.ply(self.transform, (self.width, self.height))
    }

    /// The mesh as it is on disk, spoilt by whoever needs a finer tool than the lattice.
    pub(super) fn judge_ply(&self, ply: &str, max_error: f64) -> Result<Verdict, VerifyError> {
        self.judge_with(ply, max_error, None)
    }

    pub(super) fn judge_with(
        &self,
        ply: &str,
        max_error: f64,
        importance: Option<&Band>,
    ) -> Result<Verdict, VerifyError> {
        self.compare(ply, |raster, mesh, temp_dir| {
            let options =
                VerifyOptions { lines: None, max_error, max_stray: None, importance, temp_dir: Some(temp_dir) };
            verify(raster, mesh, &options, &Control::default())
        })
    }

    /// With a limit on straying, on any ground, with weights where there are some.
    pub(super) fn judge_stray(
        &self,
        (max_error, max_stray): (f64, f64),
        ground: GroundOptions,
        weights: Option<&[f64]>,
    ) -> Verdict {
        let other = tempfile::tempdir().unwrap();
        let size = (self.width, self.height);
        let weights = weights.map(|w| crate::testing::band(&write_raster(&other, size, w, |_| {}), 1));
        let judged = self.compare(&self.mesh_ply(), |raster, mesh, temp_dir| {
            let (importance, temp_dir) = (weights.as_ref(), Some(temp_dir));
            let options = VerifyOptions { lines: None, max_error, max_stray: Some(max_stray), importance, temp_dir };
            judge_file(raster, mesh, &options, ground, None)
        });
        judged.unwrap()
    }

    /// The same, the raster passing by so many rows at a time.
    pub(super) fn judge_in_bands(&self, max_error: f64, rows: usize) -> Result<Verdict, VerifyError> {
        self.judge_ground(max_error, GroundOptions::default(), rows)
    }

    /// The same, on another ground.
    pub(super) fn judge_ground(
        &self,
        max_error: f64,
        ground: GroundOptions,
        rows: usize,
    ) -> Result<Verdict, VerifyError> {
        self.compare(&self.mesh_ply(), |raster, mesh, temp_dir| {
            let options =
                VerifyOptions { lines: None, max_error, max_stray: None, importance: None, temp_dir: Some(temp_dir) };
            judge_file(raster, mesh, &options, ground, Some(rows))
        })
    }

    pub(super) fn compare(
        &self,
        ply: &str,
        judge: impl FnOnce(&Band, &Path, PathBuf) -> Result<Verdict, VerifyError>,
    ) -> Result<Verdict, VerifyError> {
        let dir = tempfile::tempdir().unwrap();
        let mesh = dir.path().join("mesh.ply");
        std::fs::write(&mesh, ply).unwrap();
        let raster = write_raster(&dir, (self.width, self.height), &self.samples, |d| {
            d.set_geo_transform(&self.transform).unwrap();
        });
        let raster = crate::testing::band(&raster, 1);
        judge(&raster, &mesh, dir.path().to_path_buf())
    }
}

/// A GeoTIFF of one band.
pub(super) fn write_raster<T: GdalType + Copy>(
    dir: &tempfile::TempDir,
    (width, height): (usize, usize),
    samples: &[T],
    adorn: impl FnOnce(&mut gdal::Dataset),
) -> PathBuf {
    let path = dir.path().join("raster.tif");
    let driver = DriverManager::get_driver_by_name("GTiff").unwrap();
    let mut dataset = driver.create_with_band_type::<T, _>(&path, width, height, 1).unwrap();
    adorn(&mut dataset);
    let mut buffer = Buffer::new((width, height), samples.to_vec());
    dataset.rasterband(1).unwrap().write((0, 0), (width, height), &mut buffer).unwrap();
    dataset.close().unwrap();
    path
}

/// Judges a file. `rows` is how many rows of the raster are read at a time; `None` leaves that to the verifier.
pub(super) fn judge_file(
    raster: &Band,
    mesh: &Path,
    options: &VerifyOptions<'_>,
    ground: GroundOptions,
    rows: Option<usize>,
) -> Result<Verdict, VerifyError> {
    let control = Control::default();
    let mut mesh = open(raster, mesh, options, &control)?;
    judge(raster, mesh.as_mut(), options, ground, None, (rows, None), &control)
}
