//! A 2DM file, pass by pass.

use std::path::Path;

use super::Sms2dmError;
use super::line::{Kind, counts, kind, word};
use crate::base::channels::Channel;
use crate::base::control::CancelToken;
use crate::formats::text::{Head, Lines, Text};
use crate::formats::{FaceVisitor, Header, MeshReader, ReadError, TextError, VertexVisitor, lines};

/// A 2DM file with triangles, open for reading.
#[derive(Debug)]
pub struct Sms2dmReader {
    text: Text,
    header: Header,
    /// The number of the first node; those after it have the numbers after it.
    first: u64,
    nodes: u64,
    elements: u64,
}

impl Sms2dmReader {
    /// Opens a file and reads it once, to count nodes and elements. `cancel` ends that and every pass.
    ///
    /// # Errors
    /// [`Sms2dmError`] when the file cannot be read, does not begin with `MESH2D`, has nodes that are not numbered one after the
    /// other or elements other than triangles, or has not what its second line tells, where terrabite has written it.
    pub fn open(path: &Path, cancel: &CancelToken) -> Result<Sms2dmReader, Sms2dmError> {
        let text = Text::open(path, false, cancel)?;
        let mut mesh = Sms2dmReader { text, header: Header::default(), first: 1, nodes: 0, elements: 0 };
        let head = mesh.count()?;
        mesh.header = lines::header(head.iter().filter_map(|line| Some(line.trim().strip_prefix('#')?.trim())));
        Ok(mesh)
    }

    /// Counts, and returns the comments before nodes and elements.
    fn count(&mut self) -> Result<Vec<String>, Sms2dmError> {
        let (mut first, mut nodes, mut elements) = (1, 0, 0);
        let (mut head, mut has_begun) = (Head::default(), false);
        let last = self.text.for_each_line(|lines| {
            head.look_for_end(lines);
            match kind(lines.line()) {
                Kind::Nothing => {}
                Kind::Comment if nodes + elements == 0 => head.keep(lines.line()),
                Kind::Comment => {}
                Kind::First => has_begun = true,
                _ if !has_begun => return Err(self.text.line_error(lines, "MESH2D").into()),
                Kind::Node => {
                    let number = self.number_of(lines)?;
                    if nodes == 0 {
                        first = number;
                    }
                    self.check_number(lines, first + nodes, number)?;
                    nodes += 1;
                }
                Kind::Triangle => elements += 1,
                Kind::OtherElement => {
                    let (path, line) = (self.text.path().to_path_buf(), lines.number());
                    let found = String::from_utf8_lossy(word(lines.line())).chars().take(20).collect();
                    return Err(Sms2dmError::NotATriangle { path, line, found });
                }
                Kind::Unused => {}
            }
            Ok(true)
        })?;
        match head.comments.first().and_then(|line| counts(line)) {
            None if nodes == 0 => return Err(Sms2dmError::NoVertices { path: self.text.path().to_path_buf() }),
            None => {}
            Some((told, told_elements)) => {
                head.check_end(&self.text, last)?;
                self.text.check_counts("second", [("nodes", told, nodes), ("elements", told_elements, elements)])?;
                head.comments.remove(0);
            }
        }
        (self.first, self.nodes, self.elements) = (first, nodes, elements);
        Ok(head.comments)
    }

    /// The number of a node, so small that there may be as many after it as a file has.
    fn number_of(&self, lines: &Lines<'_>) -> Result<u64, TextError> {
        let number = words(lines.line()).and_then(|mut words| words.next()?.parse().ok());
        number.filter(|n| *n < 1 << 62).ok_or_else(|| self.text.line_error(lines, NODE))
    }

    fn check_number(&self, lines: &Lines<'_>, expected: u64, found: u64) -> Result<(), Sms2dmError> {
        if expected == found {
            return Ok(());
        }
        Err(Sms2dmError::NodeNumber { path: self.text.path().to_path_buf(), line: lines.number(), expected, found })
    }

    fn read_vertices(&self, visit: &mut VertexVisitor<'_>) -> Result<(), Sms2dmError> {
        let (mut index, mut broken) = (0, false);
        self.text.for_each_line(|lines| {
            if kind(lines.line()) != Kind::Node {
                return Ok::<bool, Sms2dmError>(true);
            }
            if index == self.nodes {
                return Err(self.text.changed("nodes", self.nodes, index + 1).into());
            }
            self.check_number(lines, self.first + index, self.number_of(lines)?)?;
            let vertex = vertex(lines.line()).ok_or_else(|| self.text.line_error(lines, NODE))?;
            broken = visit(index, vertex, &[]).is_break();
            index += 1;
            Ok(!broken)
        })?;
        if !broken && index != self.nodes {
            return Err(self.text.changed("nodes", self.nodes, index).into());
        }
        Ok(())
    }

    fn read_faces(&self, visit: &mut FaceVisitor<'_>) -> Result<(), Sms2dmError> {
        let (mut index, mut broken) = (0, false);
        self.text.for_each_line(|lines| {
            if kind(lines.line()) != Kind::Triangle {
                return Ok::<bool, Sms2dmError>(true);
            }
            if index == self.elements {
                return Err(self.text.changed("elements", self.elements, index + 1).into());
            }
            broken = visit(index, self.face(lines)?).is_break();
            index += 1;
            Ok(!broken)
        })?;
        if !broken && index != self.elements {
            return Err(self.text.changed("elements", self.elements, index).into());
        }
        Ok(())
    }

    /// The vertices of an element, from 0. Materials after them mean nothing here.
    fn face(&self, lines: &Lines<'_>) -> Result<[u64; 3], Sms2dmError> {
        let numbers = corners(lines.line()).ok_or_else(|| self.text.line_error(lines, TRIANGLE))?;
        let mut face = [0; 3];
        for (vertex, found) in face.iter_mut().zip(numbers) {
            let index = found.checked_sub(self.first).filter(|index| *index < self.nodes);
            *vertex = index.ok_or_else(|| Sms2dmError::VertexIndex {
                path: self.text.path().to_path_buf(),
                line: lines.number(),
                first: self.first,
                last: self.first + self.nodes.saturating_sub(1),
                found,
            })?;
        }
        Ok(face)
    }
}

/// What lines of nodes and of triangles are.
const NODE: &str = "ND, the number of a node and three coordinates";
const TRIANGLE: &str = "E3T, the number of an element and three numbers of nodes";

/// The words after the first.
fn words(line: &[u8]) -> Option<impl Iterator<Item = &str>> {
    Some(std::str::from_utf8(line).ok()?.split_ascii_whitespace().skip(1))
}

/// x, y, z of a node, after its number.
fn vertex(line: &[u8]) -> Option<[f64; 3]> {
    let mut words = words(line)?.skip(1);
    let mut next = || words.next()?.parse().ok();
    let vertex = [next()?, next()?, next()?];
    words.next().is_none().then_some(vertex)
}

/// The nodes of a triangle, after its number; what comes after them are numbers, too.
fn corners(line: &[u8]) -> Option<[u64; 3]> {
    let mut words = words(line)?;
    words.next()?.parse::<u64>().ok()?;
    let mut next = || words.next()?.parse().ok();
    let corners = [next()?, next()?, next()?];
    for word in words {
        word.parse::<f64>().ok()?;
    }
    Some(corners)
}

impl MeshReader for Sms2dmReader {
    fn path(&self) -> &Path {
        self.text.path()
    }

    fn vertex_count(&self) -> u64 {
        self.nodes
    }

    fn face_count(&self) -> u64 {
        self.elements
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
