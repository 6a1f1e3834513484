//! The triangles of an STL file, one after the other.

use std::fs::File;
use std::io::{BufReader, ErrorKind, Read, Seek, SeekFrom};
use std::path::Path;

use super::StlError;
use super::text::TextTriangles;

/// Bytes of the one buffer that a pass reads through.
const BUFFER_BYTES: usize = 256 << 10;

/// Bytes before the first triangle of a binary file.
pub(super) const HEADER_BYTES: u64 = 84;

/// Bytes of a triangle.
pub(super) const TRIANGLE_BYTES: u64 = 50;

/// How triangles stand in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Text,
    /// So many.
    Surface(u64),
    /// So many, and after each its like on the floor.
    Solid(u64),
}

/// The triangles of a surface, one after the other.
#[derive(Debug)]
pub(super) enum Triangles<'a> {
    Text(Box<TextTriangles<'a>>),
    Binary {
        records: Records<'a>,
        is_solid: bool,
        /// How many are still to come.
        left: u64,
    },
}

impl<'a> Triangles<'a> {
    /// From the first one on.
    pub(super) fn new(path: &'a Path, mut file: &'a File, kind: Kind) -> Result<Triangles<'a>, StlError> {
        let binary = |left, is_solid| Ok(Triangles::Binary { records: Records::new(path, file)?, is_solid, left });
        match kind {
            Kind::Text => {
                let io = |source| StlError::Io { path: path.to_path_buf(), source };
                file.seek(SeekFrom::Start(0)).map_err(io)?;
                Ok(Triangles::Text(Box::new(TextTriangles::new(path, file))))
            }
            Kind::Surface(count) => binary(count, false),
            Kind::Solid(count) => binary(count, true),
        }
    }

    /// The corners of the next triangle; `None` after the last one, and where the file has become too short for it.
    pub(super) fn next(&mut self) -> Result<Option<[[f64; 3]; 3]>, StlError> {
        match self {
            Triangles::Text(text) => text.next(),
            Triangles::Binary { left: 0, .. } => Ok(None),
            Triangles::Binary { records, is_solid, left } => {
                *left -= 1;
                let triangle = records.next()?;
                if *is_solid {
                    records.next()?;
                }
                Ok(triangle.map(|corners| corners.map(|corner| corner.map(f64::from))))
            }
        }
    }
}

/// The triangles of a binary file, one after the other.
#[derive(Debug)]
pub(super) struct Records<'a> {
    path: &'a Path,
    reader: BufReader<&'a File>,
}

impl<'a> Records<'a> {
    /// From the first one on.
    pub(super) fn new(path: &'a Path, mut file: &'a File) -> Result<Records<'a>, StlError> {
        let io = |source| StlError::Io { path: path.to_path_buf(), source };
        file.seek(SeekFrom::Start(HEADER_BYTES)).map_err(io)?;
        Ok(Records { path, reader: BufReader::with_capacity(BUFFER_BYTES, file) })
    }

    /// The corners of the next one; `None` where the file ends.
    pub(super) fn next(&mut self) -> Result<Option<[[f32; 3]; 3]>, StlError> {
        let mut record = [0; TRIANGLE_BYTES as usize];
        match self.reader.read_exact(&mut record) {
            Ok(()) => {}
            Err(error) if error.kind() == ErrorKind::UnexpectedEof => return Ok(None),
            Err(source) => return Err(StlError::Io { path: self.path.to_path_buf(), source }),
        }
        let mut corners = [[0.0; 3]; 3];
        // The normal comes first.
        for (number, bytes) in corners.as_flattened_mut().iter_mut().zip(record[12..48].chunks_exact(4)) {
            *number = f32::from_le_bytes(bytes.try_into().expect("four bytes"));
        }
        Ok(Some(corners))
    }
}
