//! What a format is: one row of the table in [`super::FORMATS`].

use std::path::Path;

use super::{Contents, Header, MeshReader, ReadError, Sink, SinkError};
use crate::base::control::CancelToken;
use crate::base::staged::StagedFile;

/// A format of meshes: what it is called, what it keeps, how it is written and read.
#[derive(Debug, Clone, Copy)]
pub struct Format {
    /// What `--format` calls it.
    pub name: &'static str,
    /// What people call it.
    pub title: &'static str,
    /// What names of such files end in, in lower case and without the dot; the usual one first.
    pub extensions: &'static [&'static str],
    /// The precisions in which it keeps coordinates exactly; the first is the usual one.
    pub precisions: &'static [Precision],
    /// How much it can number.
    pub limits: Limits,
    /// Which attributes of vertices it keeps.
    pub attributes: Attributes,
    /// What its files take, for estimates.
    pub bytes: Bytes,
    /// Opens a sink that writes to a staged file. A height may be read again within `loss` of what it is
    /// ([`crate::base::CoordinateFrame::height`]); one that would lose more ends the writing.
    pub sink: OpenSink,
    /// Opens a file for reading. The token ends every pass.
    pub reader: OpenReader,
    /// What the first bytes of a file say; at most [`BEGINNING`], fewer only where the file ends.
    pub recognise: fn(beginning: &[u8]) -> Recognised,
}

/// Opens a sink: where to write, what to say, how much a height may lose.
pub type OpenSink = fn(staged: StagedFile, header: Header, loss: f64) -> Result<Box<dyn Sink>, SinkError>;

/// Opens a file for reading.
pub type OpenReader = fn(path: &Path, cancel: &CancelToken) -> Result<Box<dyn MeshReader>, ReadError>;

/// Bytes of a file by which its format is recognised.
pub const BEGINNING: usize = 4096;

/// A number type of coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Precision {
    Double,
    Single,
}

/// The most of what a format can number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Vertices.
    pub vertices: u64,
    /// Triangles.
    pub triangles: u64,
}

/// Which attributes of vertices a format keeps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Attributes {
    /// None: they are left out.
    None,
    /// Any, under their names, in their number types.
    All,
}

/// What files of a format take on disk, for estimates before a run: the most that is usual.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bytes {
    /// A vertex.
    pub vertex: f64,
    /// A triangle.
    pub triangle: f64,
    /// An attribute of a vertex.
    pub attribute: f64,
}

impl Bytes {
    /// A triangle with the half of a vertex that there is to it.
    pub fn per_triangle(&self) -> f64 {
        self.triangle + self.vertex / 2.0
    }
}

/// Whether the beginning of a file is that of a format.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Recognised {
    /// It bears the format's mark.
    Surely,
    /// It could be.
    Perhaps,
    /// It is something else.
    No,
}

impl Limits {
    /// Holds what is to come against the limits.
    ///
    /// # Errors
    /// [`SinkError::TooLarge`].
    pub(super) fn check(&self, format: &'static str, path: &Path, contents: &Contents<'_>) -> Result<(), SinkError> {
        let counts =
            [("vertices", contents.vertices, self.vertices), ("triangles", contents.triangles, self.triangles)];
        match counts.into_iter().find(|(_, found, limit)| found > limit) {
            None => Ok(()),
            Some((what, found, limit)) => {
                Err(SinkError::TooLarge { path: path.to_path_buf(), format, what, limit, found })
            }
        }
    }
}
