//! An OBJ file, pass by pass.

use std::path::Path;

use super::ObjError;
use super::line::{Kind, counts, kind};
use crate::base::channels::Channel;
use crate::base::control::CancelToken;
use crate::formats::text::{Head, Lines, Text};
use crate::formats::{FaceVisitor, Header, MeshReader, ReadError, TextError, VertexVisitor, lines};

/// An OBJ file with triangles, open for reading.
#[derive(Debug)]
pub struct ObjReader {
    text: Text,
    header: Header,
    vertices: u64,
    faces: u64,
}

impl ObjReader {
    /// Opens a file and reads it once, to count vertices and faces. `cancel` ends that and every pass.
    ///
    /// # Errors
    /// [`ObjError`] when the file cannot be read, has lines that belong to no mesh of triangles, or has not what its first
    /// line tells, where terrabite has written it.
    pub fn open(path: &Path, cancel: &CancelToken) -> Result<ObjReader, ObjError> {
        let text = Text::open(path, true, cancel)?;
        let mut mesh = ObjReader { text, header: Header::default(), vertices: 0, faces: 0 };
        let head = mesh.count()?;
        mesh.header = header_of(&head);
        Ok(mesh)
    }

    /// Counts, and returns the comments before anything else.
    fn count(&mut self) -> Result<Vec<String>, ObjError> {
        let (mut vertices, mut faces) = (0, 0);
        let (mut head, mut is_head) = (Head::default(), true);
        let last = self.text.for_each_line(|lines| {
            let line = lines.line();
            match kind(line) {
                Kind::Vertex => vertices += 1,
                Kind::Face => faces += 1,
                Kind::Unknown => {
                    return Err(self.text.line_error(lines, "a line of an OBJ mesh of triangles"));
                }
                Kind::Unused => is_head = false,
                Kind::Nothing if is_head && vertices + faces == 0 && !line.is_empty() => head.keep(line),
                Kind::Nothing => {}
            }
            head.look_for_end(lines);
            Ok(true)
        })?;
        match head.comments.first().and_then(|line| counts(line)) {
            None if vertices == 0 => return Err(ObjError::NoVertices { path: self.text.path().to_path_buf() }),
            None => {}
            Some((told, told_faces)) => {
                head.check_end(&self.text, last)?;
                let counts = [("vertices", told, vertices), ("triangles", told_faces, faces)];
                self.text.check_counts("first", counts)?;
                head.comments.remove(0);
            }
        }
        (self.vertices, self.faces) = (vertices, faces);
        Ok(head.comments)
    }

    fn read_vertices(&self, visit: &mut VertexVisitor<'_>) -> Result<(), TextError> {
        let (mut index, mut broken) = (0, false);
        self.text.for_each_line(|lines| {
            let line = lines.line();
            if kind(line) != Kind::Vertex {
                return Ok(true);
            }
            if index == self.vertices {
                return Err(self.text.changed("vertices", self.vertices, index + 1));
            }
            let vertex = vertex(line).ok_or_else(|| self.text.line_error(lines, "v and three numbers"))?;
            broken = visit(index, vertex, &[]).is_break();
            index += 1;
            Ok(!broken)
        })?;
        if !broken && index != self.vertices {
            return Err(self.text.changed("vertices", self.vertices, index));
        }
        Ok(())
    }

    fn read_faces(&self, visit: &mut FaceVisitor<'_>) -> Result<(), ObjError> {
        let (mut index, mut before, mut broken) = (0, 0, false);
        self.text.for_each_line(|lines| {
            match kind(lines.line()) {
                Kind::Vertex => before += 1,
                Kind::Face if index == self.faces => {
                    return Err(ObjError::from(self.text.changed("faces", self.faces, index + 1)));
                }
                Kind::Face => {
                    broken = visit(index, self.face(lines, before)?).is_break();
                    index += 1;
                }
                _ => {}
            }
            Ok(!broken)
        })?;
        if !broken && index != self.faces {
            return Err(self.text.changed("faces", self.faces, index).into());
        }
        Ok(())
    }

    /// The vertices of a face, from 0; `before` is how many come before it.
    fn face(&self, lines: &Lines<'_>, before: u64) -> Result<[u64; 3], ObjError> {
        let wrong = || ObjError::from(self.text.line_error(lines, "f and three numbers of vertices"));
        let text = std::str::from_utf8(lines.line()).map_err(|_| wrong())?;
        let mut face = [0; 3];
        let mut corners = 0;
        for word in text.split_ascii_whitespace().skip(1) {
            let number = corner(word).ok_or_else(wrong)?;
            let vertex = match number {
                1.. => u64::try_from(number - 1).ok(),
                _ => before.checked_sub(number.unsigned_abs()).filter(|_| number != 0),
            };
            let vertex = vertex.filter(|v| *v < self.vertices).ok_or_else(|| ObjError::VertexIndex {
                path: self.text.path().to_path_buf(),
                line: lines.number(),
                vertices: self.vertices,
                before,
                found: number,
            })?;
            if let Some(slot) = face.get_mut(corners) {
                *slot = vertex;
            }
            corners += 1;
        }
        match corners {
            3 => Ok(face),
            _ => Err(ObjError::NotATriangle {
                path: self.text.path().to_path_buf(),
                line: lines.number(),
                found: corners as u64,
            }),
        }
    }
}

/// x, y, z of a vertex; a weight or a colour after them are numbers, too.
fn vertex(line: &[u8]) -> Option<[f64; 3]> {
    let mut words = std::str::from_utf8(line).ok()?.split_ascii_whitespace().skip(1);
    let mut next = || words.next()?.parse::<f64>().ok();
    let vertex = [next()?, next()?, next()?];
    let mut further = 0;
    for word in words {
        word.parse::<f64>().ok()?;
        further += 1;
    }
    (further <= 4).then_some(vertex)
}

/// The number of a corner's vertex; those of its texture coordinates and its normal are numbers, too, or nothing.
fn corner(word: &str) -> Option<i64> {
    let mut parts = word.split('/');
    let number = parts.next()?.parse().ok()?;
    let mut further = 0;
    for part in parts {
        further += 1;
        if !part.is_empty() {
            part.parse::<i64>().ok()?;
        }
    }
    (further <= 2).then_some(number)
}

/// What the comments at the head say.
fn header_of(head: &[String]) -> Header {
    lines::header(head.iter().filter_map(|line| Some(line.trim().strip_prefix('#')?.trim())))
}

impl MeshReader for ObjReader {
    fn path(&self) -> &Path {
        self.text.path()
    }

    fn vertex_count(&self) -> u64 {
        self.vertices
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
        Ok(self.read_vertices(visit)?)
    }

    fn faces(&mut self, visit: &mut FaceVisitor<'_>) -> Result<(), ReadError> {
        Ok(self.read_faces(visit)?)
    }
}
