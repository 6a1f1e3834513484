//! Small files that belong to an output and lie beside it: there with it or not at all.

use std::fs::Permissions;
use std::io::Write;
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use super::{OutputError, StagedFile, checks, persist_new};
use crate::base::durable;

/// A file that is to be there, or not, once the output is.
#[derive(Debug)]
pub(super) struct Companion {
    path: PathBuf,
    content: Option<Vec<u8>>,
    /// What is there, and may be replaced.
    old: Option<Old>,
}

/// A file that was there before.
#[derive(Debug)]
struct Old {
    content: Vec<u8>,
    permissions: Permissions,
}

impl Companion {
    /// `None` where all is as it is to be.
    pub(super) fn of(
        output: &StagedFile,
        extension: &str,
        content: Option<Vec<u8>>,
    ) -> Result<Option<Companion>, OutputError> {
        let path = output.path.with_extension(extension);
        if path == output.path {
            return Err(OutputError::Companion { path, extension: extension.to_string() });
        }
        let Some(existing) = checks::existing(&path)? else {
            return Ok(content.is_some().then_some(Companion { path, content, old: None }));
        };
        if let Some(content) = &content
            && existing.len() == content.len() as u64
            && std::fs::read(&path).is_ok_and(|old| old == *content)
        {
            return Ok(None);
        }
        if !output.overwrite {
            return Err(OutputError::Exists { path });
        }
        let inputs: Vec<&Path> = output.inputs.iter().map(PathBuf::as_path).collect();
        checks::is_no_input(&path, &existing, &inputs)?;
        for input in inputs {
            // What lies beside an input belongs to it.
            let beside = input.with_extension(extension);
            checks::is_no_input(&path, &existing, &[&beside])
                .map_err(|_| OutputError::BesideInput { path: path.clone(), input: input.to_path_buf() })?;
        }
        let old = std::fs::read(&path).map_err(|source| OutputError::Look { path: path.clone(), source })?;
        let old = Some(Old { content: old, permissions: existing.permissions() });
        // What a link leads to is replaced, or the link removed.
        let path = if content.is_some() { checks::target(&path, true) } else { path };
        Ok(Some(Companion { path, content, old }))
    }

    /// Puts the file where it belongs, on the disk when this returns.
    pub(super) fn place(self, permissions: &Permissions) -> Result<Placed, OutputError> {
        let Companion { path, content, old } = self;
        let failed = |source| OutputError::Write { path: path.clone(), source };
        match content {
            Some(content) => {
                let permissions = old.as_ref().map_or(permissions, |old| &old.permissions);
                let partial = written(&path, &content, permissions).map_err(failed)?;
                match &old {
                    Some(_) => partial.into_temp_path().persist(&path).map_err(|e| failed(e.error))?,
                    None => persist_new(partial.into_temp_path(), &path)?,
                }
            }
            None => durable::remove_if_there(&path).map_err(failed)?,
        }
        Ok(Placed { path, old, stays: false })
    }
}

/// A file beside an output that has no name yet: dropped, it is as it was before.
pub(super) struct Placed {
    path: PathBuf,
    old: Option<Old>,
    stays: bool,
}

impl Placed {
    /// The output has its name.
    pub(super) fn keep(mut self) {
        self.stays = true;
    }
}

impl Drop for Placed {
    fn drop(&mut self) {
        if self.stays {
            return;
        }
        // Whoever drops it has an error to tell already.
        let _ = match &self.old {
            None => durable::remove_if_there(&self.path),
            Some(old) => written(&self.path, &old.content, &old.permissions)
                .and_then(|partial| partial.into_temp_path().persist(&self.path).map_err(|e| e.error)),
        };
    }
}

fn written(path: &Path, content: &[u8], permissions: &Permissions) -> std::io::Result<NamedTempFile> {
    let mut prefix = std::ffi::OsString::from(".");
    prefix.push(path.file_name().unwrap_or_default());
    prefix.push(".");
    let folder = checks::parent(path);
    let mut partial = tempfile::Builder::new().prefix(&prefix).suffix(".partial").tempfile_in(folder)?;
    partial.write_all(content)?;
    partial.as_file().set_permissions(permissions.clone())?;
    partial.as_file().sync_all()?;
    Ok(partial)
}
