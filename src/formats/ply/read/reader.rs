//! A PLY file as a mesh of any format.

use std::ops::ControlFlow;
use std::path::Path;

use super::file::ENDED;
use super::{PlyError, PlyFile, ScalarType};
use crate::base::channels::{Channel, Number};
use crate::base::control::CancelToken;
use crate::base::{CoordinateFrame, LineEdge};
use crate::formats::{EdgeVisitor, FaceVisitor, Header, MeshReader, ReadError, VertexVisitor, lines};

/// A [`PlyFile`] as a [`MeshReader`]. What terrabite writes in comments is its header; coordinates are single where x and y
/// are `float`.
#[derive(Debug)]
pub struct PlyReader {
    file: PlyFile,
    header: Header,
    attributes: Vec<Channel>,
}

impl PlyReader {
    /// Opens a file; `cancel` ends every pass over it.
    ///
    /// # Errors
    /// As [`PlyFile::open`].
    pub fn open(path: &Path, cancel: &CancelToken) -> Result<PlyReader, PlyError> {
        let file = PlyFile::open(path)?.until(cancel.clone());
        let comments = joined(file.comments());
        let found = lines::header(comments.iter().map(String::as_str).filter(|comment| *comment != ENDED));
        let single = file.coordinate_types()[..2].iter().all(|t| *t == ScalarType::F32);
        let header = Header { frame: CoordinateFrame { single, ..found.frame }, ..found };
        let attribute = |(name, kind): (&str, ScalarType)| Channel { name: name.to_string(), number: number(kind) };
        let attributes = file.attributes().map(attribute).collect();
        Ok(PlyReader { file, header, attributes })
    }
}

/// Bytes of a comment that may go on in the next.
const LONG: usize = 480;

/// Comments that are too long for a line go on in the next, which begins with a mark.
fn joined(comments: &[String]) -> Vec<String> {
    let mut joined: Vec<String> = Vec::new();
    let mut is_long = false;
    for comment in comments {
        match (joined.last_mut().filter(|_| is_long), comment.strip_prefix("+ ")) {
            (Some(before), Some(further)) => before.push_str(further),
            _ => joined.push(comment.clone()),
        }
        is_long = comment.len() >= LONG;
    }
    joined
}

/// The narrowest type that holds every value, 64-bit integers rounded.
fn number(kind: ScalarType) -> Number {
    match kind {
        ScalarType::U8 => Number::U8,
        ScalarType::I8 | ScalarType::I16 | ScalarType::U16 | ScalarType::F32 => Number::F32,
        ScalarType::I32 | ScalarType::U32 | ScalarType::I64 | ScalarType::U64 | ScalarType::F64 => Number::F64,
    }
}

/// Why a pass ends: the visitor has had enough, or the file is damaged.
enum End {
    Enough,
    Damaged(ReadError),
}

impl From<PlyError> for End {
    fn from(error: PlyError) -> End {
        End::Damaged(error.into())
    }
}

fn go_on(flow: ControlFlow<()>) -> Result<(), End> {
    if flow.is_continue() { Ok(()) } else { Err(End::Enough) }
}

fn ended(pass: Result<(), End>) -> Result<(), ReadError> {
    match pass {
        Ok(()) | Err(End::Enough) => Ok(()),
        Err(End::Damaged(error)) => Err(error),
    }
}

impl MeshReader for PlyReader {
    fn path(&self) -> &Path {
        self.file.path()
    }

    fn vertex_count(&self) -> u64 {
        self.file.vertex_count()
    }

    fn face_count(&self) -> u64 {
        self.file.face_count()
    }

    fn header(&self) -> &Header {
        &self.header
    }

    fn attributes(&self) -> &[Channel] {
        &self.attributes
    }

    fn vertices(&mut self, attributes: &[&str], visit: &mut VertexVisitor<'_>) -> Result<(), ReadError> {
        let reader: &dyn MeshReader = self;
        reader.must_have(attributes)?;
        let pass = |index, vertex, values: &[f64]| go_on(visit(index, vertex, values));
        ended(self.file.for_each_vertex_with(attributes, pass))
    }

    fn faces(&mut self, visit: &mut FaceVisitor<'_>) -> Result<(), ReadError> {
        ended(self.file.for_each_face(|index, face| go_on(visit(index, face))))
    }

    fn edge_count(&self) -> u64 {
        self.file.edge_count()
    }

    fn edges_have_types(&self) -> bool {
        self.file.edges_have_types()
    }

    fn edges(&mut self, visit: &mut EdgeVisitor<'_>) -> Result<(), ReadError> {
        let (path, vertices) = (self.file.path().to_path_buf(), self.file.vertex_count());
        ended(self.file.for_each_edge(|index, edge| {
            let LineEdge { ends, line_type } = edge.map(|end| u64::try_from(end).ok().filter(|end| *end < vertices));
            match ends[0].zip(ends[1]) {
                Some((from, to)) => go_on(visit(index, LineEdge { ends: [from, to], line_type })),
                None => Err(End::Damaged(ReadError::EdgeEnd { path: path.clone(), edge: index, found: "number" })),
            }
        }))
    }
}
