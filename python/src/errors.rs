//! Errors of the library as exceptions.

use pyo3::conversion::FromPyObjectOwned;
use pyo3::exceptions::{PyException, PyTypeError, PyValueError};
use pyo3::prelude::*;
use terrabite::base::RasterError;
use terrabite::base::control::Cancelled as Stopped;
use terrabite::base::external::ScratchError;
use terrabite::field::FieldError;
use terrabite::formats::{ReadError, SinkError};
use terrabite::job::Error as JobError;
use terrabite::run::RunError;
use terrabite::verify::VerifyError;

pyo3::create_exception!(terrabite, Error, PyException, "What went wrong with data, files or the machine.");
pyo3::create_exception!(terrabite, RasterError_, Error, "The heights cannot be read, or cannot be meshed.");
pyo3::create_exception!(terrabite, MeshError, Error, "A mesh cannot be read, or is damaged.");
pyo3::create_exception!(terrabite, OutputError, Error, "The output cannot be written.");
pyo3::create_exception!(terrabite, ResourceError, Error, "The memory or the disks are too small.");
pyo3::create_exception!(terrabite, Cancelled, Error, "The cancel flag was set.");

/// Adds the exceptions to the module.
pub(crate) fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let py = module.py();
    module.add("Error", py.get_type::<Error>())?;
    let raster_error = py.get_type::<RasterError_>();
    // In Rust the name is that of the library's own error.
    raster_error.setattr("__name__", "RasterError")?;
    raster_error.setattr("__qualname__", "RasterError")?;
    module.add("RasterError", raster_error)?;
    module.add("MeshError", py.get_type::<MeshError>())?;
    module.add("OutputError", py.get_type::<OutputError>())?;
    module.add("ResourceError", py.get_type::<ResourceError>())?;
    module.add("Cancelled", py.get_type::<Cancelled>())
}

/// What was given by name, or an error that begins with the name of what cannot be used.
pub(crate) fn taken<'py, T: FromPyObjectOwned<'py>>(given: &Bound<'py, PyAny>) -> PyResult<T> {
    let py = given.py();
    given.extract().map_err(|error: T::Error| {
        let mut error: PyErr = error.into();
        let mut name = None;
        // A field may have fields.
        while let (Some(field), Some(cause)) = (field_of(&error.value(py).to_string()), error.cause(py)) {
            (name, error) = (Some(field), cause);
        }
        match name {
            Some(name) => {
                let message = format!("{name}: {}", error.value(py));
                // A negative number where none can be is an `OverflowError`.
                let is_type = error.is_instance_of::<PyTypeError>(py);
                if is_type { PyTypeError::new_err(message) } else { PyValueError::new_err(message) }
            }
            None => error,
        }
    })
}

/// The field that could not be extracted, if that is what an exception says.
fn field_of(said: &str) -> Option<String> {
    let field = said.strip_prefix("failed to extract field ")?;
    field.rsplit('.').next().map(str::to_string)
}

/// What kind of exception an error is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// An option, or options that do not go together.
    Value,
    Raster,
    Mesh,
    Output,
    Resource,
    Cancelled,
    Other,
}

/// The exception for an error of a run.
pub(crate) fn exception(error: &RunError) -> PyErr {
    let message = error.to_string();
    match of_run(error) {
        Kind::Value => PyValueError::new_err(message),
        Kind::Raster => RasterError_::new_err(message),
        Kind::Mesh => MeshError::new_err(message),
        Kind::Output => OutputError::new_err(message),
        Kind::Resource => ResourceError::new_err(message),
        Kind::Cancelled => Cancelled::new_err(message),
        Kind::Other => Error::new_err(message),
    }
}

/// The exception for a band that cannot be used.
pub(crate) fn of_band(error: &RasterError) -> PyErr {
    match error {
        RasterError::NodataValue { .. } | RasterError::Window { .. } | RasterError::EmptyBox { .. } => {
            PyValueError::new_err(error.to_string())
        }
        _ => RasterError_::new_err(error.to_string()),
    }
}

fn of_run(error: &RunError) -> Kind {
    match error {
        RunError::Incompatible(_) | RunError::Format { .. } | RunError::FormatOption { .. } | RunError::Loss { .. } => {
            Kind::Value
        }
        RunError::Attribute(_) | RunError::Importance(_) => Kind::Raster,
        RunError::Threads { .. } => Kind::Resource,
        RunError::Indistinct { .. } => Kind::Output,
        RunError::NotFinite { .. } => Kind::Mesh,
        RunError::Mesh(error) => of_mesh(error),
        RunError::Scratch(error) => of_scratch(error),
        RunError::Verify(error) => of_verdict(error),
        RunError::Job(error) => of_job(error),
        RunError::Kept { error, .. } => of_job(error),
        _ => Kind::Other,
    }
}

fn of_job(error: &JobError) -> Kind {
    match error {
        JobError::Raster(_) | JobError::NoGround { .. } | JobError::PointOffGround { .. } => Kind::Raster,
        JobError::Field(FieldError::Cancelled(Stopped)) | JobError::Cancelled(Stopped) => Kind::Cancelled,
        JobError::Field(FieldError::HolesTooLarge { .. } | FieldError::Temporary { .. }) => Kind::Resource,
        JobError::Field(_) => Kind::Raster,
        JobError::Sink(SinkError::Scratch(error)) => of_scratch(error),
        JobError::Sink(_) => Kind::Output,
        JobError::Output(_) => Kind::Output,
        JobError::Budget(_) | JobError::Disk(_) | JobError::Spool(_) => Kind::Resource,
        JobError::Tolerance(_)
        | JobError::Incompatible(_)
        | JobError::Trim(_)
        | JobError::Schedule(_)
        | JobError::MinAngle(_)
        | JobError::MaxStray(_)
        | JobError::NoStop { .. }
        | JobError::Goal(_)
        | JobError::Tile { .. } => Kind::Value,
        _ => Kind::Other,
    }
}

fn of_mesh(error: &ReadError) -> Kind {
    match error {
        ReadError::Cancelled(Stopped) => Kind::Cancelled,
        ReadError::Scratch(error) => of_scratch(error),
        _ => Kind::Mesh,
    }
}

fn of_scratch(error: &ScratchError) -> Kind {
    if matches!(error, ScratchError::Cancelled(Stopped)) { Kind::Cancelled } else { Kind::Resource }
}

fn of_verdict(error: &VerifyError) -> Kind {
    match error {
        VerifyError::Cancelled(Stopped) => Kind::Cancelled,
        VerifyError::Raster(_) | VerifyError::InfiniteSample { .. } => Kind::Raster,
        VerifyError::Mesh(error) => of_mesh(error),
        VerifyError::Scratch(error) => of_scratch(error),
        VerifyError::Tolerance { .. } | VerifyError::Incompatible(_) | VerifyError::Emphasis { .. } => Kind::Value,
        _ => Kind::Other,
    }
}
