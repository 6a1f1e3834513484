//! Meshes: made, kept in arrays of numpy, written, judged.

use std::path::PathBuf;

use numpy::ndarray::Array2;
use numpy::{Element, IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use terrabite::base::channels::Channel;
use terrabite::base::control::Control;
use terrabite::formats::{
    ArrayReader, Base, Compression, Format, Header, ReadError, SinkOptions, by_extension, by_name,
};
use terrabite::run::{ConvertRequest, Coordinates, InMemory, RunError, convert_mesh, simplify_in_memory, verify_mesh};

use crate::band::PyBand;
use crate::errors::{MeshError, taken};
use crate::options::{Options, VerifyOptions, within};
use crate::run::{Watch, run};

/// A mesh in arrays that numpy owns and nobody writes to, with what a file with it says of itself.
#[pyclass(name = "Mesh", module = "terrabite._terrabite", frozen)]
pub(crate) struct PyMesh {
    vertices: Py<PyArray2<f64>>,
    triangles: Py<PyArray2<u32>>,
    edges: Py<PyArray2<u32>>,
    soft_edges: Py<PyArray1<bool>>,
    attributes: Vec<(Channel, Py<PyArray1<f64>>)>,
    header: Header,
    report: String,
}

/// An array of rows of `columns` over numbers that it takes, read-only.
fn in_rows<T: Element>(py: Python<'_>, columns: usize, numbers: Vec<T>) -> PyResult<Py<PyArray2<T>>> {
    let rows = Array2::from_shape_vec((numbers.len() / columns, columns), numbers);
    let array = rows.map_err(|e| PyValueError::new_err(e.to_string()))?.into_pyarray(py);
    array.try_readwrite().map_err(|e| PyValueError::new_err(e.to_string()))?.make_nonwriteable();
    Ok(array.unbind())
}

/// An array over values that it takes, read-only.
fn in_a_row<T: Element>(py: Python<'_>, values: Vec<T>) -> PyResult<Py<PyArray1<T>>> {
    let array = values.into_pyarray(py);
    array.try_readwrite().map_err(|e| PyValueError::new_err(e.to_string()))?.make_nonwriteable();
    Ok(array.unbind())
}

impl PyMesh {
    fn new(py: Python<'_>, InMemory { arrays, header, report }: InMemory) -> PyResult<PyMesh> {
        let report = serde_json::to_string(&report).map_err(|e| PyValueError::new_err(e.to_string()))?;
        let kept = |(channel, values): (Channel, Vec<f64>)| Ok((channel, in_a_row(py, values)?));
        Ok(PyMesh {
            vertices: in_rows(py, 3, arrays.vertices)?,
            triangles: in_rows(py, 3, arrays.triangles)?,
            edges: in_rows(py, 2, arrays.edges)?,
            soft_edges: in_a_row(py, arrays.soft_edges)?,
            attributes: arrays.attributes.into_iter().map(kept).collect::<PyResult<_>>()?,
            header,
            report,
        })
    }

    /// Does something with the mesh open for reading, without the interpreter.
    fn read<T: Send>(
        &self,
        py: Python<'_>,
        watch: &Watch,
        work: impl FnOnce(&mut ArrayReader<'_>, &Control<'_>) -> Result<T, RunError> + Send,
    ) -> PyResult<T> {
        let failed = |error: numpy::AsSliceError| MeshError::new_err(error.to_string());
        let lent = |error: numpy::BorrowError| MeshError::new_err(error.to_string());
        let vertices = self.vertices.bind(py).try_readonly().map_err(lent)?;
        let triangles = self.triangles.bind(py).try_readonly().map_err(lent)?;
        let edges = self.edges.bind(py).try_readonly().map_err(lent)?;
        let soft_edges = self.soft_edges.bind(py).try_readonly().map_err(lent)?;
        let (edges, soft_edges) = (edges.as_slice().map_err(failed)?, soft_edges.as_slice().map_err(failed)?);
        let values = self.attributes.iter().map(|(_, values)| values.bind(py).try_readonly());
        let values: Vec<PyReadonlyArray1<'_, f64>> = values.collect::<Result<_, _>>().map_err(lent)?;
        let arrays = (vertices.as_slice().map_err(failed)?, triangles.as_slice().map_err(failed)?);
        let attributes = self.attributes.iter().zip(&values);
        let attributes = attributes.map(|((channel, _), values)| Ok((channel.clone(), values.as_slice()?)));
        let attributes = attributes.collect::<Result<Vec<_>, numpy::AsSliceError>>().map_err(failed)?;
        let header = self.header.clone();
        run(py, watch, move |control| {
            let mesh = ArrayReader::new("the mesh", header, arrays, attributes, control.cancel.clone());
            let mesh = mesh.and_then(|mesh| mesh.with_edges(edges, soft_edges));
            work(&mut mesh.map_err(|e| ReadError::Damaged(e.into()))?, control)
        })
    }
}

#[pymethods]
impl PyMesh {
    #[getter]
    fn vertices(&self, py: Python<'_>) -> Py<PyArray2<f64>> {
        self.vertices.clone_ref(py)
    }

    #[getter]
    fn triangles(&self, py: Python<'_>) -> Py<PyArray2<u32>> {
        self.triangles.clone_ref(py)
    }

    #[getter]
    fn edges(&self, py: Python<'_>) -> Py<PyArray2<u32>> {
        self.edges.clone_ref(py)
    }

    /// Whether each of these follows soft lines alone.
    #[getter]
    fn soft_edges(&self, py: Python<'_>) -> Py<PyArray1<bool>> {
        self.soft_edges.clone_ref(py)
    }

    /// Names and values.
    #[getter]
    fn attributes(&self, py: Python<'_>) -> Vec<(String, Py<PyArray1<f64>>)> {
        self.attributes.iter().map(|(channel, values)| (channel.name.clone(), values.clone_ref(py))).collect()
    }

    /// The report of the run, as JSON.
    #[getter]
    fn report(&self) -> &str {
        &self.report
    }

    /// Authority and code, or WKT.
    #[getter]
    fn crs(&self) -> Option<&str> {
        self.header.crs.definition.as_deref()
    }

    /// Writes a file. Gives the report as JSON.
    fn write(
        &self,
        py: Python<'_>,
        path: PathBuf,
        options: &Bound<'_, PyDict>,
        cancel: Option<Py<PyAny>>,
    ) -> PyResult<String> {
        let options: WriteOptions = taken(options)?;
        within("z_scale", Some(options.z_scale), |f| f.is_finite() && f > 0.0, "a finite number above 0")?;
        let (format, sink) = (options.format(&path)?, options.sink()?);
        let single = match options.precision.as_deref() {
            None | Some("double") => false,
            Some("float") => true,
            Some(found) => {
                let message = format!("precision: expected \"double\" or \"float\", found {found:?}");
                return Err(PyValueError::new_err(message));
            }
        };
        let request = ConvertRequest {
            format: Some(format),
            overwrite: options.overwrite,
            temp_dir: options.temp_dir,
            sink,
            coordinates: Coordinates { local: options.local, z_scale: options.z_scale, single },
            ..ConvertRequest::new("the mesh", path)
        };
        let watch = Watch { cancel, progress: None };
        let report = self.read(py, &watch, move |mesh, control| convert_mesh(mesh, &request, control))?;
        serde_json::to_string(&report).map_err(|e| PyValueError::new_err(e.to_string()))
    }
}

/// How a file is written, as the words of a call.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct WriteOptions {
    format: Option<String>,
    precision: Option<String>,
    local: bool,
    z_scale: f64,
    ascii: bool,
    base_height: Option<f64>,
    base_depth: Option<f64>,
    mesh_compression: Option<String>,
    overwrite: bool,
    temp_dir: Option<PathBuf>,
}

impl WriteOptions {
    fn format(&self, path: &std::path::Path) -> PyResult<&'static Format> {
        let format = match &self.format {
            None => by_extension(path),
            Some(name) => by_name(&name.to_ascii_lowercase())
                .or_else(|| by_extension(std::path::Path::new(&format!("mesh.{name}")))),
        };
        let found = || self.format.clone().unwrap_or_else(|| path.display().to_string());
        let known = || terrabite::formats::FORMATS.iter().map(|format| format.name).collect::<Vec<_>>().join(", ");
        format.ok_or_else(|| {
            PyValueError::new_err(format!("expected a format of meshes ({}), found {}", known(), found()))
        })
    }

    fn sink(&self) -> PyResult<SinkOptions> {
        let base = match (self.base_height, self.base_depth) {
            (None, None) => None,
            (Some(height), None) if height.is_finite() => Some(Base::Height(height)),
            (None, Some(depth)) if depth.is_finite() && depth > 0.0 => Some(Base::Depth(depth)),
            (Some(_), Some(_)) => return Err(PyValueError::new_err("base_height and base_depth cannot be combined")),
            _ => return Err(PyValueError::new_err("expected a finite base_height, or a base_depth above 0")),
        };
        let compression = match self.mesh_compression.as_deref() {
            None => None,
            Some("meshopt") => Some(Compression::Meshopt),
            Some(found) => {
                return Err(PyValueError::new_err(format!("mesh_compression: expected \"meshopt\", found {found:?}")));
            }
        };
        Ok(SinkOptions { ascii: self.ascii, base, compression, ..SinkOptions::default() })
    }
}

/// Makes the mesh that is asked for.
#[pyfunction]
#[pyo3(signature = (band, options, cancel, progress))]
pub(crate) fn simplify(
    py: Python<'_>,
    band: &PyBand,
    options: &Bound<'_, PyDict>,
    cancel: Option<Py<PyAny>>,
    progress: Option<Py<PyAny>>,
) -> PyResult<PyMesh> {
    let options: Options<'_> = taken(options)?;
    let request = options.request(&band.band)?;
    let mesh = run(py, &Watch { cancel, progress }, move |control| simplify_in_memory(&request, control))?;
    PyMesh::new(py, mesh)
}

/// Judges a mesh, or a file with one. Gives the report as JSON.
#[pyfunction]
#[pyo3(signature = (band, mesh, options, cancel, progress))]
pub(crate) fn verify(
    py: Python<'_>,
    band: &PyBand,
    mesh: Judged<'_>,
    options: &Bound<'_, PyDict>,
    cancel: Option<Py<PyAny>>,
    progress: Option<Py<PyAny>>,
) -> PyResult<String> {
    let options: VerifyOptions<'_> = taken(options)?;
    let watch = Watch { cancel, progress };
    let report = match mesh {
        Judged::Mesh(mesh) => {
            let request = options.request(&band.band, PathBuf::from("the mesh"))?;
            mesh.get().read(py, &watch, move |mesh, control| verify_mesh(mesh, &request, control))?
        }
        Judged::File(path) => {
            let request = options.request(&band.band, path)?;
            run(py, &watch, move |control| terrabite::run::verify(&request, control))?
        }
    };
    serde_json::to_string(&report).map_err(|e| PyValueError::new_err(e.to_string()))
}

/// What is judged.
#[derive(FromPyObject)]
pub(crate) enum Judged<'py> {
    Mesh(Bound<'py, PyMesh>),
    File(PathBuf),
}
