//! An STL file, pass by pass.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use crc32fast::Hasher;

use super::closed::Closed;
use super::triangles::{HEADER_BYTES, Kind, Records, TRIANGLE_BYTES, Triangles};
use super::{MARK, StlError, text};
use crate::base::CoordinateFrame;
use crate::base::channels::Channel;
use crate::base::control::CancelToken;
use crate::base::external::Scratch;
use crate::formats::weld::{Welded, Welder};
use crate::formats::{FaceVisitor, Header, MeshReader, ReadError, ReadOptions, VertexVisitor};

/// Triangles between two looks at whether to stop; a power of two.
const PACE: u64 = 1 << 12;

/// What the text of a header takes that terrabite has written.
const TEXT_BYTES: usize = 40;

/// An STL file, open for reading.
#[derive(Debug)]
pub struct StlReader {
    path: PathBuf,
    file: File,
    header: Header,
    kind: Kind,
    bytes: u64,
    faces: u64,
    /// Of all corners.
    checksum: u32,
    welded: Welded,
    scratch: Scratch,
    cancel: CancelToken,
}

impl StlReader {
    /// Opens a file and reads it once, to find which corners are one vertex, and whether a solid is closed.
    ///
    /// # Errors
    /// [`ReadError`] when the file cannot be read, is damaged, or temporary files cannot be written.
    pub fn open(path: &Path, options: &ReadOptions) -> Result<StlReader, ReadError> {
        let file = File::open(path).map_err(|source| StlError::Io { path: path.to_path_buf(), source })?;
        let Form { kind, frame, bytes } = Form::of(path, &file)?;
        let cancel = options.cancel.clone();
        let scratch = Scratch::new(options.temp_dir.as_deref(), cancel.clone());
        let (mut faces, mut checksum) = (0, Hasher::new());
        let mut welder = Welder::new(&scratch);
        let mut triangles = Triangles::new(path, &file, kind)?;
        loop {
            pace(&cancel, faces)?;
            let Some(corners) = triangles.next()? else { break };
            hash(&mut checksum, corners);
            // Both zeros are one place.
            corners.iter().try_for_each(|corner| welder.push(corner.map(|v| v + 0.0)))?;
            faces += 1;
        }
        drop(triangles);
        let welded = welder.finish()?;
        let header = Header { frame, ..Header::default() };
        let (path, checksum) = (path.to_path_buf(), checksum.finalize());
        let mesh = StlReader { path, file, header, kind, bytes, faces, checksum, welded, scratch, cancel };
        match mesh.kind {
            Kind::Surface(count) | Kind::Solid(count) if count != faces => return Err(mesh.changed().into()),
            _ => mesh.check_solid()?,
        }
        Ok(mesh)
    }

    /// Makes sure that a solid is one.
    fn check_solid(&self) -> Result<(), ReadError> {
        let Kind::Solid(tops) = self.kind else { return Ok(()) };
        let mut closed = Closed::new(&self.path, tops, &self.scratch);
        let mut records = Records::new(&self.path, &self.file)?;
        let mut taken = 0;
        while let Some(corners) = records.next()? {
            pace(&self.cancel, taken)?;
            closed.take(corners)?;
            taken += 1;
        }
        closed.finish()
    }

    fn changed(&self) -> StlError {
        StlError::Changed { path: self.path.clone(), faces: self.faces }
    }

    /// Whatever a pass looks at, the file must be what it was.
    fn check_length(&self) -> Result<(), StlError> {
        let found = self.file.metadata().map_err(|source| StlError::Io { path: self.path.clone(), source })?.len();
        if found == self.bytes { Ok(()) } else { Err(self.changed()) }
    }

    fn read_vertices(&self, visit: &mut VertexVisitor<'_>) -> Result<(), ReadError> {
        self.check_length()?;
        let mut triangles = Triangles::new(&self.path, &self.file, self.kind)?;
        let mut numbers = self.welded.numbers(&self.scratch);
        let (mut faces, mut vertices, mut checksum) = (0, 0, Hasher::new());
        loop {
            pace(&self.cancel, faces)?;
            let Some(corners) = triangles.next()? else { break };
            hash(&mut checksum, corners);
            faces += 1;
            for corner in corners {
                let number = numbers.next().ok_or_else(|| self.changed())??;
                if number == vertices {
                    if visit(vertices, corner, &[]).is_break() {
                        return Ok(());
                    }
                    vertices += 1;
                }
            }
        }
        if (faces, checksum.finalize()) != (self.faces, self.checksum) {
            return Err(self.changed().into());
        }
        Ok(())
    }

    fn read_faces(&self, visit: &mut FaceVisitor<'_>) -> Result<(), ReadError> {
        self.check_length()?;
        let mut numbers = self.welded.numbers(&self.scratch);
        for index in 0..self.faces {
            pace(&self.cancel, index)?;
            let mut face = [0; 3];
            for corner in &mut face {
                *corner = numbers.next().expect("three for each face")?;
            }
            if visit(index, face).is_break() {
                break;
            }
        }
        Ok(())
    }
}

fn pace(cancel: &CancelToken, index: u64) -> Result<(), StlError> {
    if index.is_multiple_of(PACE) { Ok(cancel.check()?) } else { Ok(()) }
}

fn hash(checksum: &mut Hasher, corners: [[f64; 3]; 3]) {
    checksum.update(bytemuck::cast_slice(corners.as_flattened()));
}

/// What stands before the triangles.
struct Form {
    kind: Kind,
    frame: CoordinateFrame,
    /// The length of the file.
    bytes: u64,
}

impl Form {
    fn of(path: &Path, mut file: &File) -> Result<Form, StlError> {
        let io = |source| StlError::Io { path: path.to_path_buf(), source };
        let found = file.metadata().map_err(io)?.len();
        let mut header = Vec::new();
        file.seek(SeekFrom::Start(0)).map_err(io)?;
        file.take(HEADER_BYTES).read_to_end(&mut header).map_err(io)?;
        let text = Form { kind: Kind::Text, frame: CoordinateFrame::PLAIN, bytes: found };
        let Ok(header) = <[u8; HEADER_BYTES as usize]>::try_from(header.as_slice()) else {
            let is_text = text::is_text(&header);
            return if is_text { Ok(text) } else { Err(StlError::TooShort { path: path.to_path_buf(), found }) };
        };
        let count = u32::from_le_bytes([header[80], header[81], header[82], header[83]]);
        let expected = HEADER_BYTES + TRIANGLE_BYTES * u64::from(count);
        if found != expected {
            let path = path.to_path_buf();
            let is_text = text::is_text(&header);
            return if is_text { Ok(text) } else { Err(StlError::Length { path, expected, count, found }) };
        }
        let count = u64::from(count);
        if !header.starts_with(MARK) {
            let frame = CoordinateFrame { single: true, ..CoordinateFrame::PLAIN };
            return Ok(Form { kind: Kind::Surface(count), frame, bytes: found });
        }
        let kind = kind(path, &header[..TEXT_BYTES], count)?;
        Ok(Form { kind, frame: frame(path, &header[TEXT_BYTES..80])?, bytes: found })
    }
}

/// What the text of a header of terrabite's says of a file with this many triangles.
fn kind(path: &Path, text: &[u8], count: u64) -> Result<Kind, StlError> {
    let words = String::from_utf8_lossy(text).trim_end().to_string();
    let wrong = |expected| StlError::Header { path: path.to_path_buf(), offset: 0, expected, found: words.clone() };
    if words == "terrabite STL; 5 f64: offset x y, scales" {
        return Ok(Kind::Surface(count));
    }
    let tops = words.strip_prefix("terrabite STL, ").and_then(|rest| rest.strip_suffix(" on base; 5 f64"));
    let tops: u64 = tops.and_then(|tops| tops.parse().ok()).ok_or_else(|| wrong("a header of terrabite's"))?;
    let is_possible = tops <= count / 2 && count.is_multiple_of(2) && (tops > 0 || count == 0);
    if is_possible { Ok(Kind::Solid(tops)) } else { Err(wrong("a solid of at most as many triangles as there are")) }
}

/// The frame of a file of terrabite's: five doubles.
fn frame(path: &Path, bytes: &[u8]) -> Result<CoordinateFrame, StlError> {
    let mut numbers = [0.0; 5];
    for (i, (number, bytes)) in numbers.iter_mut().zip(bytes.chunks_exact(8)).enumerate() {
        *number = f64::from_le_bytes(bytes.try_into().expect("eight bytes"));
        let (is_right, expected) = match i {
            0 | 1 => (number.is_finite(), "an offset, which is finite"),
            _ => (number.is_finite() && *number > 0.0, "a scale, which is above 0"),
        };
        if !is_right {
            let (path, offset) = (path.to_path_buf(), (TEXT_BYTES + 8 * i) as u64);
            return Err(StlError::Header { path, offset, expected, found: number.to_string() });
        }
    }
    let [x, y, x_scale, y_scale, z_scale] = numbers;
    Ok(CoordinateFrame { origin: (x, y), xy_scale: (x_scale, y_scale), z_scale, single: true })
}

impl MeshReader for StlReader {
    fn path(&self) -> &Path {
        &self.path
    }

    fn vertex_count(&self) -> u64 {
        self.welded.vertices()
    }

    fn face_count(&self) -> u64 {
        self.faces
    }

    fn header(&self) -> &Header {
        &self.header
    }

    fn attributes(&self) -> &[Channel] {
        &[]
    }

    fn vertices(&mut self, attributes: &[&str], visit: &mut VertexVisitor<'_>) -> Result<(), ReadError> {
        let reader: &dyn MeshReader = self;
        reader.must_have(attributes)?;
        self.read_vertices(visit)
    }

    fn faces(&mut self, visit: &mut FaceVisitor<'_>) -> Result<(), ReadError> {
        self.read_faces(visit)
    }
}
