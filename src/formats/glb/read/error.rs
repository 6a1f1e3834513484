//! What is wrong with a GLB file.

use std::path::PathBuf;

use crate::base::control::Cancelled;
use crate::base::external::ScratchError;
use crate::formats::ReadError;

/// Why a GLB file cannot be used. Every message names the file; bytes, faces and the parts of the document are counted from
/// 0.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GlbError {
    /// The file cannot be opened or read.
    #[error("{}: {source}", path.display())]
    Io {
        /// The mesh.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The header of the file or of a chunk does not say what it should.
    #[error("{}: byte {offset}: expected {expected}, found {found}", path.display())]
    Container {
        /// The mesh.
        path: PathBuf,
        /// Where it says so.
        offset: u64,
        /// What would have been right.
        expected: String,
        /// What it says.
        found: String,
    },
    /// The file ends too early.
    #[error("{}: expected {expected} bytes, found the end of the file after {found}", path.display())]
    Truncated {
        /// The mesh.
        path: PathBuf,
        /// How many it should have.
        expected: u64,
        /// How many it has.
        found: u64,
    },
    /// The JSON chunk is no JSON, or not of the shape of glTF.
    #[error("{}: JSON chunk (from byte {offset} on): {source}", path.display())]
    Json {
        /// The mesh.
        path: PathBuf,
        /// Where the chunk begins.
        offset: u64,
        /// What is wrong with it, and where in the chunk.
        source: serde_json::Error,
    },
    /// A part of the document does not say what it should.
    #[error("{}: {place}: expected {expected}, found {found}", path.display())]
    Document {
        /// The mesh.
        path: PathBuf,
        /// Which part, such as `accessor 3`.
        place: String,
        /// What would have been right.
        expected: String,
        /// What it says.
        found: String,
    },
    /// The mesh cannot be understood without an extension that is not read.
    #[error("{}: {place}: expected a mesh without the extension {name}, which is not read, found it in use", path.display())]
    Extension {
        /// The mesh.
        path: PathBuf,
        /// Where it is used.
        place: String,
        /// Its name.
        name: String,
    },
    /// Compressed data is damaged.
    #[error("{}: bufferView {view} (compressed, from byte {offset} on): expected {expected}, found other data", path.display())]
    Packed {
        /// The mesh.
        path: PathBuf,
        /// Which view.
        view: usize,
        /// Where its compressed data begins.
        offset: u64,
        /// What it should decompress to.
        expected: String,
    },
    /// A face names a vertex that is not there.
    #[error("{}: {place}, face {face}: expected vertices 0 to below {vertices}, found {found}", path.display())]
    VertexIndex {
        /// The mesh.
        path: PathBuf,
        /// Which primitive.
        place: String,
        /// The face in it.
        face: u64,
        /// How many vertices it has.
        vertices: u64,
        /// The index as it is.
        found: u64,
    },
    /// It is another file than it was when it was opened.
    #[error("{}: expected the file as it was when it was opened, found that it has been changed", path.display())]
    Changed {
        /// The mesh.
        path: PathBuf,
    },
    /// Temporary files.
    #[error(transparent)]
    Scratch(ScratchError),
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl From<ScratchError> for GlbError {
    fn from(error: ScratchError) -> GlbError {
        match error {
            ScratchError::Cancelled(stopped) => GlbError::Cancelled(stopped),
            file => GlbError::Scratch(file),
        }
    }
}

impl From<GlbError> for ReadError {
    fn from(error: GlbError) -> ReadError {
        match error {
            GlbError::Cancelled(stopped) => ReadError::Cancelled(stopped),
            GlbError::Scratch(error) => ReadError::Scratch(error),
            GlbError::Io { path, source } => ReadError::Io { path, source },
            damaged => ReadError::Damaged(Box::new(damaged)),
        }
    }
}
