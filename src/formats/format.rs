//! What a format is: one row of the table in [`super::FORMATS`].

use std::path::{Path, PathBuf};

use super::{Contents, Header, MeshReader, ReadError, Sink, SinkError, SinkOption, SinkOptions};
use crate::base::Texture;
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
    /// The precisions in which it keeps coordinates exactly; the first is the usual one. Where there is no other than single,
    /// coordinates are always less an origin.
    pub precisions: &'static [Precision],
    /// What x, y and z are in.
    pub unit: Unit,
    /// Whether triangles name vertices that they share. Where each brings its own, readers join those at one place; a vertex
    /// of no triangle is lost, and vertices are numbered anew, in the order in which triangles name them first.
    pub vertices: Vertices,
    /// What of a [`Header`] it keeps.
    pub header: HeaderKept,
    /// How much it can number.
    pub limits: Limits,
    /// Which attributes of vertices it keeps.
    pub attributes: Attributes,
    /// Which options of writing it takes.
    pub options: &'static [SinkOption],
    /// What its files take, for estimates.
    pub bytes: Bytes,
    /// Opens a sink that writes to a staged file.
    pub sink: OpenSink,
    /// Opens a file for reading.
    pub reader: OpenReader,
    /// What the first bytes of a file say; at most [`BEGINNING`], fewer only where the file ends.
    pub recognise: fn(beginning: &[u8]) -> Recognised,
}

/// Opens a sink: where to write, and how.
pub type OpenSink = fn(staged: StagedFile, setup: Setup) -> Result<Box<dyn Sink>, SinkError>;

/// Opens a file for reading.
pub type OpenReader = fn(path: &Path, options: &ReadOptions) -> Result<Box<dyn MeshReader>, ReadError>;

/// What a sink is told when it is opened.
#[derive(Debug, Clone, Default)]
pub struct Setup {
    /// What the file is to say of itself; its frame is how coordinates are to be written.
    pub header: Header,
    /// How far a height may be from what is read again ([`crate::base::CoordinateFrame::height`]); one that would lose more
    /// ends the writing.
    pub loss: f64,
    /// Vertices come as they are to stand in the file, and not on the map: nothing is done to them, and nothing is lost.
    pub as_is: bool,
    /// Options of the format: none but those that it takes ([`Format::options`]).
    pub options: SinkOptions,
    /// An image over the mesh, where the format takes one.
    pub texture: Option<Texture>,
    /// The folder of temporary files; `None` is the system's.
    pub temp_dir: Option<PathBuf>,
    /// Ends work that takes longer than a batch, such as sorting.
    pub cancel: CancelToken,
}

/// What a reader is told when it is opened.
#[derive(Debug, Clone, Default)]
pub struct ReadOptions {
    /// Ends opening and every pass.
    pub cancel: CancelToken,
    /// The folder of temporary files; `None` is the system's.
    pub temp_dir: Option<PathBuf>,
}

/// What the coordinates of a format are in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    /// The units of the CRS and of the heights.
    OfCrs,
    /// Metres: degrees and feet are scaled ([`crate::base::CoordinateFrame::xy_scale`]).
    Metre,
}

/// How triangles have their vertices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Vertices {
    Shared,
    OfEachTriangle,
}

/// What of a [`Header`] a format keeps. All keep the frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HeaderKept {
    /// All of it.
    All,
    /// All but what heights mean.
    AllButHeights,
    /// Nothing but the frame.
    Frame,
}

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
    /// Those that fit into single precision, under their names; others are refused.
    Single,
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
