//! A 2DM file, pass by pass.

use std::fs::File;
use std::io::{Seek, SeekFrom};
use std::path::{Path, PathBuf};

use super::Sms2dmError;
use super::line::{Kind, LINE_LIMIT, LineError, Lines, counts, kind, word};
use crate::base::channels::Channel;
use crate::base::control::CancelToken;
use crate::formats::{FaceVisitor, Header, MeshReader, ReadError, VertexVisitor, lines};

/// Lines between two looks at whether to stop; a power of two.
const PACE: u64 = 1 << 13;

/// Bytes of comments at the head of a file that are kept.
const HEAD_LIMIT: usize = 1 << 20;

/// The last line of what terrabite writes.
const END: &str = "# end of mesh";

/// A 2DM file with triangles, open for reading.
#[derive(Debug)]
pub struct Sms2dmReader {
    path: PathBuf,
    file: File,
    header: Header,
    /// The number of the first node; those after it have the numbers after it.
    first: u64,
    nodes: u64,
    elements: u64,
    cancel: CancelToken,
}

impl Sms2dmReader {
    /// Opens a file and reads it once, to count nodes and elements. `cancel` ends that and every pass.
    ///
    /// # Errors
    /// [`Sms2dmError`] when the file cannot be read, does not begin with `MESH2D`, has nodes that are not numbered one after the
    /// other or elements other than triangles, or has not what its second line tells, where terrabite has written it.
    pub fn open(path: &Path, cancel: &CancelToken) -> Result<Sms2dmReader, Sms2dmError> {
        let file = File::open(path).map_err(|source| Sms2dmError::Io { path: path.to_path_buf(), source })?;
        let (header, cancel) = (Header::default(), cancel.clone());
        let mut mesh = Sms2dmReader { path: path.to_path_buf(), file, header, first: 1, nodes: 0, elements: 0, cancel };
        let head = mesh.count()?;
        mesh.header = lines::header(head.iter().filter_map(|line| Some(line.trim().strip_prefix('#')?.trim())));
        Ok(mesh)
    }

    /// Counts, and returns the comments before nodes and elements.
    fn count(&mut self) -> Result<Vec<String>, Sms2dmError> {
        let (mut first, mut nodes, mut elements) = (1, 0, 0);
        let (mut head, mut head_bytes) = (Vec::new(), 0);
        let (mut has_begun, mut has_end) = (false, false);
        let last = self.for_each_line(|lines| {
            let line = lines.line();
            has_end = line == END.as_bytes() && lines.ended();
            match kind(line) {
                Kind::Nothing => {}
                Kind::Comment => {
                    if nodes + elements == 0 && head_bytes + line.len() <= HEAD_LIMIT {
                        head_bytes += line.len();
                        head.push(String::from_utf8_lossy(line).into_owned());
                    }
                }
                Kind::First => has_begun = true,
                _ if !has_begun => return Err(self.line_error(lines, "MESH2D")),
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
                    let (path, line) = (self.path.clone(), lines.number());
                    let found = String::from_utf8_lossy(word(lines.line())).chars().take(20).collect();
                    return Err(Sms2dmError::NotATriangle { path, line, found });
                }
                Kind::Unused => {}
            }
            Ok(true)
        })?;
        match head.first().and_then(|line| counts(line)) {
            None if nodes == 0 => return Err(Sms2dmError::NoVertices { path: self.path.clone() }),
            None => {}
            Some(_) if !has_end => {
                return Err(Sms2dmError::Truncated { path: self.path.clone(), expected: END, line: last });
            }
            Some((told, told_elements)) => {
                let counts = [("nodes", told, nodes), ("elements", told_elements, elements)];
                if let Some((what, expected, found)) = counts.into_iter().find(|(_, told, found)| told != found) {
                    return Err(Sms2dmError::Count { path: self.path.clone(), what, expected, found });
                }
                head.remove(0);
            }
        }
        (self.first, self.nodes, self.elements) = (first, nodes, elements);
        Ok(head)
    }

    /// Hands every line to `visit` until it returns false; returns the number of the last one.
    fn for_each_line(
        &self,
        mut visit: impl FnMut(&Lines<'_>) -> Result<bool, Sms2dmError>,
    ) -> Result<u64, Sms2dmError> {
        let io = |source| Sms2dmError::Io { path: self.path.clone(), source };
        let mut file = &self.file;
        file.seek(SeekFrom::Start(0)).map_err(io)?;
        let mut lines = Lines::new(file);
        loop {
            if lines.number().is_multiple_of(PACE) {
                self.cancel.check()?;
            }
            match lines.advance() {
                Ok(true) if visit(&lines)? => {}
                Ok(_) => return Ok(lines.number()),
                Err(LineError::Io(source)) => return Err(io(source)),
                Err(LineError::TooLong) => {
                    let (path, line) = (self.path.clone(), lines.number());
                    return Err(Sms2dmError::LineTooLong { path, line, limit: LINE_LIMIT });
                }
            }
        }
    }

    fn line_error(&self, lines: &Lines<'_>, expected: &'static str) -> Sms2dmError {
        let line = lines.line();
        let found = String::from_utf8_lossy(&line[..line.len().min(400)]).trim().chars().take(80).collect();
        Sms2dmError::Line { path: self.path.clone(), line: lines.number(), expected, found }
    }

    fn changed(&self, what: &'static str, expected: u64, found: u64) -> Sms2dmError {
        Sms2dmError::Changed { path: self.path.clone(), what, expected, found }
    }

    /// The number of a node, so small that there may be as many after it as a file has.
    fn number_of(&self, lines: &Lines<'_>) -> Result<u64, Sms2dmError> {
        let number = words(lines.line()).and_then(|mut words| words.next()?.parse().ok());
        number.filter(|n| *n < 1 << 62).ok_or_else(|| self.line_error(lines, NODE))
    }

    fn check_number(&self, lines: &Lines<'_>, expected: u64, found: u64) -> Result<(), Sms2dmError> {
        if expected == found {
            return Ok(());
        }
        Err(Sms2dmError::NodeNumber { path: self.path.clone(), line: lines.number(), expected, found })
    }

    fn read_vertices(&self, visit: &mut VertexVisitor<'_>) -> Result<(), Sms2dmError> {
        let (mut index, mut broken) = (0, false);
        self.for_each_line(|lines| {
            if kind(lines.line()) != Kind::Node {
                return Ok(true);
            }
            if index == self.nodes {
                return Err(self.changed("nodes", self.nodes, index + 1));
            }
            self.check_number(lines, self.first + index, self.number_of(lines)?)?;
            let vertex = vertex(lines.line()).ok_or_else(|| self.line_error(lines, NODE))?;
            broken = visit(index, vertex, &[]).is_break();
            index += 1;
            Ok(!broken)
        })?;
        if !broken && index != self.nodes {
            return Err(self.changed("nodes", self.nodes, index));
        }
        Ok(())
    }

    fn read_faces(&self, visit: &mut FaceVisitor<'_>) -> Result<(), Sms2dmError> {
        let (mut index, mut broken) = (0, false);
        self.for_each_line(|lines| {
            if kind(lines.line()) != Kind::Triangle {
                return Ok(true);
            }
            if index == self.elements {
                return Err(self.changed("elements", self.elements, index + 1));
            }
            broken = visit(index, self.face(lines)?).is_break();
            index += 1;
            Ok(!broken)
        })?;
        if !broken && index != self.elements {
            return Err(self.changed("elements", self.elements, index));
        }
        Ok(())
    }

    /// The vertices of an element, from 0. Materials after them mean nothing here.
    fn face(&self, lines: &Lines<'_>) -> Result<[u64; 3], Sms2dmError> {
        let numbers = corners(lines.line()).ok_or_else(|| self.line_error(lines, TRIANGLE))?;
        let mut face = [0; 3];
        for (vertex, found) in face.iter_mut().zip(numbers) {
            let index = found.checked_sub(self.first).filter(|index| *index < self.nodes);
            *vertex = index.ok_or_else(|| Sms2dmError::VertexIndex {
                path: self.path.clone(),
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
        &self.path
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
