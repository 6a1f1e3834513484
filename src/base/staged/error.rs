//! Why an output file cannot be made.

use std::path::PathBuf;

/// Why an output file cannot be made. Every message names the file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OutputError {
    /// The path does not end in a file's name.
    #[error("{}: expected the path of a file, found no file name", path.display())]
    NoName {
        /// The output.
        path: PathBuf,
    },
    /// The folder of the output is missing, or no folder.
    #[error("{}: expected an existing folder {}: {source}", path.display(), folder.display())]
    NoFolder {
        /// The output.
        path: PathBuf,
        /// Its folder.
        folder: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// No file can be made in the folder of the output.
    #[error("{}: expected a folder that can be written to, found {}: {source}", path.display(), folder.display())]
    Folder {
        /// The output.
        path: PathBuf,
        /// Its folder.
        folder: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// There is a file already, and it may not be replaced.
    #[error("{}: the output exists already", path.display())]
    Exists {
        /// The output.
        path: PathBuf,
    },
    /// There is something that is no file: a folder, a device, a pipe.
    #[error("{}: expected a file or nothing at the output's path, found {found}", path.display())]
    NotAFile {
        /// The output.
        path: PathBuf,
        /// What is there.
        found: &'static str,
    },
    /// The output would replace one of the files that are read.
    #[error("{}: the output is the same file as the input {}; give it another name", path.display(), input.display())]
    IsInput {
        /// The output.
        path: PathBuf,
        /// The input.
        input: PathBuf,
    },
    /// The output would replace or remove a file that lies beside an input of the same name, and may belong to it.
    #[error(
        "{}: the output needs a file of its own under this name, and this one may belong to the input {}; give the output \
         another name, or move this file",
        path.display(), input.display()
    )]
    BesideInput {
        /// The file.
        path: PathBuf,
        /// The input.
        input: PathBuf,
    },
    /// The output has the extension of a file that belongs beside it.
    #[error("{}: expected another extension than .{extension}, which is that of a file beside the output", path.display())]
    Companion {
        /// The output.
        path: PathBuf,
        /// The extension.
        extension: String,
    },
    /// Whether there is something at the path cannot be told.
    #[error("{}: the output cannot be looked at: {source}", path.display())]
    Look {
        /// The output.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The bytes, or the final name, could not be written: a full disk, most often.
    #[error("{}: writing failed: {source}", path.display())]
    Write {
        /// The output.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
}
