//! A name with the right extension for a file that is staged under another.

use std::io;
use std::path::{Path, PathBuf};

use tempfile::{Builder, TempDir};

/// A link in a private temporary folder. Drivers look at extensions: under another name FlatGeobuf makes a folder, and
/// GeoPackage warns. SQLite finds the file behind the link, which lies where it is staged.
#[derive(Debug)]
pub(super) struct Link {
    path: PathBuf,
    _folder: TempDir,
}

impl Link {
    /// To a file that need not be there yet.
    pub(super) fn to(file: &Path, extension: &str, temp_dir: Option<&Path>) -> io::Result<Link> {
        let folder = match temp_dir {
            Some(folder) => Builder::new().tempdir_in(folder)?,
            None => Builder::new().tempdir()?,
        };
        let path = folder.path().join("mesh").with_extension(extension);
        std::os::unix::fs::symlink(std::path::absolute(file)?, &path)?;
        Ok(Link { path, _folder: folder })
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }
}
