//! Which format a file is in: by what it bears, by what it is called, by what it looks like.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use super::{BEGINNING, FORMATS, Format, MeshReader, ReadError, ReadOptions, Recognised};

/// The format of this name, as `--format` takes it.
pub fn by_name(name: &str) -> Option<&'static Format> {
    FORMATS.iter().copied().find(|format| format.name == name)
}

/// The format whose files are called so, in upper or lower case.
pub fn by_extension(path: &Path) -> Option<&'static Format> {
    let extension = path.extension()?.to_str()?.to_ascii_lowercase();
    FORMATS.iter().copied().find(|format| format.extensions.contains(&extension.as_str()))
}

/// Opens a mesh: in `format` where one is given; else in the format whose mark the file bears, whatever it is called; else
/// in that of its extension; else in one that its first bytes could be of.
///
/// # Errors
/// [`ReadError`] if the file cannot be read, is of no known format, or is damaged where opening looks at it.
pub fn open(path: &Path, format: Option<&Format>, options: &ReadOptions) -> Result<Box<dyn MeshReader>, ReadError> {
    must_be_a_file(path)?;
    if let Some(format) = format {
        return (format.reader)(path, options);
    }
    (recognised(path)?.reader)(path, options)
}

/// The format of a mesh: that whose mark the file bears, whatever it is called; else that of its extension; else one that its
/// first bytes could be of.
///
/// # Errors
/// [`ReadError`] if the file cannot be read, or is of no known format.
pub fn recognised(path: &Path) -> Result<&'static Format, ReadError> {
    must_be_a_file(path)?;
    let io = |source| ReadError::Io { path: path.to_path_buf(), source };
    let mut beginning = Vec::new();
    File::open(path).and_then(|f| f.take(BEGINNING as u64).read_to_end(&mut beginning)).map_err(io)?;
    let of = |wanted| FORMATS.iter().copied().find(|f| (f.recognise)(&beginning) == wanted);
    of(Recognised::Surely).or_else(|| by_extension(path)).or_else(|| of(Recognised::Perhaps)).ok_or_else(|| {
        ReadError::Unrecognised {
            path: path.to_path_buf(),
            expected: FORMATS.iter().map(|f| f.title).collect::<Vec<_>>().join(", "),
        }
    })
}

/// Opening a pipe would wait for whoever writes to it. What cannot be looked at is left to whoever opens it.
fn must_be_a_file(path: &Path) -> Result<(), ReadError> {
    let found = match path.metadata() {
        Ok(metadata) if metadata.is_dir() => "a folder",
        Ok(metadata) if !metadata.is_file() => "a device or a pipe",
        _ => return Ok(()),
    };
    Err(ReadError::NotAFile { path: path.to_path_buf(), found })
}
