//! A name in UTF-8 for any path, as GDAL needs one.

use std::io;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

/// A name by which GDAL finds a file: its interface takes UTF-8 only.
///
/// Of a path that is no UTF-8, it is one through a private temporary folder with a link in it: to the file's folder, so
/// that files beside it are found, too; or, if its own name is no UTF-8, to the file, under a name with the same ending.
/// The folder goes when this is dropped, so it is kept as long as GDAL has the file open.
#[derive(Debug)]
pub(crate) struct GdalName {
    path: PathBuf,
    _links: Option<TempDir>,
}

impl GdalName {
    /// # Errors
    /// What the system says, if there is no place for the links.
    pub(crate) fn of(path: &Path) -> io::Result<GdalName> {
        if path.to_str().is_some() {
            return Ok(GdalName { path: path.to_path_buf(), _links: None });
        }
        let links = tempfile::tempdir()?;
        // A link's target is looked for from where the link is.
        let absolute = std::path::absolute(path)?;
        let (folder, name) = (absolute.parent().unwrap_or(Path::new("/")), absolute.file_name().unwrap_or_default());
        let (target, link) = match name.to_str() {
            Some(_) => (folder, PathBuf::from("folder")),
            None => (absolute.as_path(), Path::new("file").with_extension(extension(&absolute))),
        };
        let link = links.path().join(link);
        std::os::unix::fs::symlink(target, &link)?;
        let path = name.to_str().map_or(link.clone(), |name| link.join(name));
        Ok(GdalName { path, _links: Some(links) })
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }
}

fn extension(path: &Path) -> &str {
    path.extension().and_then(|e| e.to_str()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;

    #[test]
    fn files_are_found_by_names_in_utf_8() {
        let folder = tempfile::tempdir().expect("a folder");
        let odd = folder.path().join(OsStr::from_bytes(b"d\xe9p\xf4t"));
        std::fs::create_dir(&odd).expect("a folder");
        for name in [&b"dem.tif"[..], b"relev\xe9.tif", b"relev\xe9", b"a b\xff.tar.gz"] {
            let path = odd.join(OsStr::from_bytes(name));
            std::fs::write(&path, name).expect("written");
            let found = GdalName::of(&path).expect("a name");
            assert!(found.path().to_str().is_some());
            assert_eq!(std::fs::read(found.path()).expect("there"), name);
            assert_eq!(found.path().extension(), path.extension());
            let links = found.path().to_path_buf();
            drop(found);
            assert!(!links.exists() && path.exists());
        }
        let plain = folder.path().join("dem.tif");
        assert_eq!(GdalName::of(&plain).expect("a name").path(), plain);
    }
}
