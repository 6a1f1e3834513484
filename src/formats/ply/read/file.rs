//! A PLY file, pass by pass.

use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use super::header::{Element, Header, Property, read_header};
use super::values::{ValueError, Values};
use super::{Encoding, PlyError, ScalarType};
use crate::base::control::CancelToken;
use crate::base::{LineEdge, LineType};

/// Bytes of the one buffer that a pass reads through.
const BUFFER_BYTES: usize = 256 << 10;

/// Records between two looks at whether to stop; a power of two.
const PACE: u64 = 1 << 14;

/// The comment of files in text that terrabite has written.
pub(super) const ENDED: &str = "every line is ended";

/// A PLY file with triangles, open for reading.
///
/// Memory use is constant: the header (at most 1 MiB), one buffer of 256 KiB and one record, because every pass hands
/// on what it reads and keeps nothing. A pass begins at the first byte after the header, so passes may be repeated.
///
/// ```no_run
/// # fn main() -> Result<(), terrabite::formats::ply::read::PlyError> {
/// use terrabite::formats::ply::read::{PlyError, PlyFile};
/// let mut mesh = PlyFile::open("tin.ply".as_ref())?;
/// let mut highest = f64::NEG_INFINITY;
/// mesh.for_each_vertex(|_, [_, _, z]| {
///     highest = highest.max(z);
///     Ok::<(), PlyError>(())
/// })?;
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct PlyFile {
    path: PathBuf,
    file: File,
    header: Header,
    vertices: usize,
    coordinates: [usize; 3],
    faces: usize,
    corners: usize,
    edges: Option<Edges>,
    cancel: CancelToken,
}

/// The element of edges, and which properties are their two vertices, and their type where they have one.
#[derive(Debug, Clone, Copy)]
struct Edges {
    element: usize,
    ends: [usize; 2],
    soft: Option<usize>,
}

impl PlyFile {
    /// Opens a file and reads its header. A file without any `face` element is no mesh; one with a count of 0 is.
    ///
    /// # Errors
    /// [`PlyError`] when the file cannot be read, the header is damaged, `vertex` has no `x`, `y`, `z`, `face` has no
    /// list `vertex_indices` (or `vertex_index`) of integers, or a count is more than the file's length allows.
    pub fn open(path: &Path) -> Result<PlyFile, PlyError> {
        let io = |source| PlyError::Io { path: path.to_path_buf(), source };
        let missing = |expected: &str| PlyError::Missing { path: path.to_path_buf(), expected: expected.to_string() };
        let file = File::open(path).map_err(io)?;
        let bytes = file.metadata().map_err(io)?.len();
        let header = read_header(path, &mut BufReader::new(&file))?;
        check_counts(path, &header, bytes)?;
        if header.encoding == Encoding::Ascii && header.comments.iter().any(|comment| comment == ENDED) {
            check_end(path, &file, bytes)?;
        }

        let find = |name: &str| header.elements.iter().position(|e| e.name == name);
        let vertices = find("vertex").ok_or_else(|| missing("element vertex"))?;
        let vertex = &header.elements[vertices];
        let mut coordinates = [0; 3];
        for (place, name) in coordinates.iter_mut().zip(["x", "y", "z"]) {
            let single = vertex.position(name).filter(|&p| vertex.properties[p].length.is_none());
            *place = single.ok_or_else(|| missing(&format!("property {name} of element vertex")))?;
        }
        let faces = find("face").ok_or_else(|| missing("element face"))?;
        let face = &header.elements[faces];
        let corners = face
            .position("vertex_indices")
            .or_else(|| face.position("vertex_index"))
            .filter(|&p| face.properties[p].length.is_some() && face.properties[p].value.is_integer())
            .ok_or_else(|| missing("an integer list vertex_indices (or vertex_index) of element face"))?;
        let edges = find("edge").and_then(|element| {
            let edge = &header.elements[element];
            let whole = |p: &usize| edge.properties[*p].length.is_none() && edge.properties[*p].value.is_integer();
            let end = |name| edge.position(name).filter(whole);
            Some(Edges { element, ends: [end("vertex1")?, end("vertex2")?], soft: end("soft") })
        });
        let (path, cancel) = (path.to_path_buf(), CancelToken::default());
        Ok(PlyFile { path, file, header, vertices, coordinates, faces, corners, edges, cancel })
    }

    /// The same file, whose passes end with [`PlyError::Cancelled`] once `cancel` is cancelled.
    pub fn until(self, cancel: CancelToken) -> PlyFile {
        PlyFile { cancel, ..self }
    }

    /// The path it was opened by.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// How many vertices there are; never more than the file's length has room for.
    pub fn vertex_count(&self) -> u64 {
        self.header.elements[self.vertices].count
    }

    /// How many faces there are; never more than the file's length has room for.
    pub fn face_count(&self) -> u64 {
        self.header.elements[self.faces].count
    }

    /// How many edges there are (`edge` with `vertex1` and `vertex2`); never more than the file's length has room for.
    pub fn edge_count(&self) -> u64 {
        self.edges.map_or(0, |edges| self.header.elements[edges.element].count)
    }

    /// Whether edges have a property `soft`.
    pub fn edges_have_types(&self) -> bool {
        self.edges.is_some_and(|edges| edges.soft.is_some())
    }

    /// The header's comments in order, without the keyword and the blanks around them.
    pub fn comments(&self) -> &[String] {
        &self.header.comments
    }

    /// How the values are written.
    pub fn encoding(&self) -> Encoding {
        self.header.encoding
    }

    /// The types x, y and z are written in.
    pub fn coordinate_types(&self) -> [ScalarType; 3] {
        self.coordinates.map(|p| self.header.elements[self.vertices].properties[p].value)
    }

    /// What vertices have beside x, y and z: names and types of single values, in the file's order. Lists are left out.
    pub fn attributes(&self) -> impl Iterator<Item = (&str, ScalarType)> {
        let properties = self.header.elements[self.vertices].properties.iter().enumerate();
        let further = properties.filter(|(place, p)| p.length.is_none() && !self.coordinates.contains(place));
        further.map(|(_, p)| (p.name.as_str(), p.value))
    }

    /// Makes sure that vertices have attributes of these names.
    ///
    /// # Errors
    /// [`PlyError::Missing`] names the first that is not there.
    pub fn must_have(&self, attributes: &[&str]) -> Result<(), PlyError> {
        match attributes.iter().find(|name| !self.attributes().any(|(n, _)| n == **name)) {
            None => Ok(()),
            Some(name) => Err(PlyError::Missing {
                path: self.path.clone(),
                expected: format!("property {name} of element vertex"),
            }),
        }
    }

    /// Hands every vertex to `visit`: its index and x, y, z, which may be anything a double can be. Stops at the first
    /// error, the visitor's own included.
    ///
    /// # Errors
    /// [`PlyError`], or what `visit` returns.
    pub fn for_each_vertex<E: From<PlyError>>(
        &mut self,
        mut visit: impl FnMut(u64, [f64; 3]) -> Result<(), E>,
    ) -> Result<(), E> {
        self.for_each_vertex_with(&[], |index, vertex, _| visit(index, vertex))
    }

    /// Hands every vertex to `visit`: its index, x, y, z, and the attributes of these names, in their order.
    ///
    /// # Errors
    /// [`PlyError`], [`PlyError::Missing`] among them, or what `visit` returns.
    pub fn for_each_vertex_with<E: From<PlyError>>(
        &mut self,
        attributes: &[&str],
        mut visit: impl FnMut(u64, [f64; 3], &[f64]) -> Result<(), E>,
    ) -> Result<(), E> {
        self.must_have(attributes)?;
        let mut values = self.seek_to(self.vertices)?;
        let element = &self.header.elements[self.vertices];
        // Places in `vertex`: the coordinates, then the attributes.
        let mut roles = vec![None; element.properties.len()];
        let asked = attributes.iter().filter_map(|name| element.position(name));
        self.coordinates.iter().copied().chain(asked).enumerate().for_each(|(role, p)| roles[p] = Some(role));
        let mut vertex = vec![0.0; 3 + attributes.len()];
        for index in 0..element.count {
            self.pace(index)?;
            for (property, role) in element.properties.iter().zip(&roles) {
                match role {
                    None => self.skip(&mut values, element, index, property)?,
                    Some(role) => {
                        let read = values.real(property.value);
                        vertex[*role] = read.map_err(|e| self.value_error(e, element, index, property))?;
                    }
                }
            }
            visit(index, [vertex[0], vertex[1], vertex[2]], &vertex[3..])?;
        }
        Ok(())
    }

    /// Hands every face to `visit`: its index and its three vertices, each below [`PlyFile::vertex_count`], in the
    /// file's order; they may repeat. Stops at the first error, the visitor's own included.
    ///
    /// # Errors
    /// [`PlyError`], also for a face that is no triangle, or what `visit` returns.
    pub fn for_each_face<E: From<PlyError>>(
        &mut self,
        mut visit: impl FnMut(u64, [u64; 3]) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut values = self.seek_to(self.faces)?;
        let element = &self.header.elements[self.faces];
        for index in 0..element.count {
            self.pace(index)?;
            let mut face = [0; 3];
            for (place, property) in element.properties.iter().enumerate() {
                if place == self.corners {
                    face = self.triangle(&mut values, element, index, property)?;
                } else {
                    self.skip(&mut values, element, index, property)?;
                }
            }
            visit(index, face)?;
        }
        Ok(())
    }

    /// Hands every edge to `visit`: its index, and its two vertices as numbers of any size; it is soft where it has a property `soft`
    /// other than 0. Stops at the first error, the visitor's own included.
    ///
    /// # Errors
    /// [`PlyError`], or what `visit` returns.
    pub fn for_each_edge<E: From<PlyError>>(
        &mut self,
        mut visit: impl FnMut(u64, LineEdge<i128>) -> Result<(), E>,
    ) -> Result<(), E> {
        let Some(Edges { element, ends, soft }) = self.edges else { return Ok(()) };
        let mut values = self.seek_to(element)?;
        let element = &self.header.elements[element];
        for index in 0..element.count {
            self.pace(index)?;
            let mut numbers = [0; 3];
            for (place, property) in element.properties.iter().enumerate() {
                match ends.into_iter().map(Some).chain([soft]).position(|role| role == Some(place)) {
                    None => self.skip(&mut values, element, index, property)?,
                    Some(role) => {
                        let read = values.integer(property.value);
                        numbers[role] = read.map_err(|e| self.value_error(e, element, index, property))?;
                    }
                }
            }
            let [from, to, soft] = numbers;
            let line_type = if soft == 0 { LineType::Hard } else { LineType::Soft };
            visit(index, LineEdge { ends: [from, to], line_type })?;
        }
        Ok(())
    }

    fn pace(&self, index: u64) -> Result<(), PlyError> {
        if index.is_multiple_of(PACE) { Ok(self.cancel.check()?) } else { Ok(()) }
    }

    fn triangle(
        &self,
        values: &mut Values<BufReader<&File>>,
        element: &Element,
        index: u64,
        property: &Property,
    ) -> Result<[u64; 3], PlyError> {
        let found = self.list_length(values, element, index, property)?;
        if found != 3 {
            return Err(PlyError::NotATriangle { path: self.path.clone(), face: index, found });
        }
        let vertices = self.vertex_count();
        let mut face = [0; 3];
        for corner in &mut face {
            let found = values.integer(property.value).map_err(|e| self.value_error(e, element, index, property))?;
            *corner = u64::try_from(found).ok().filter(|&v| v < vertices).ok_or_else(|| PlyError::VertexIndex {
                path: self.path.clone(),
                face: index,
                vertices,
                found,
            })?;
        }
        Ok(face)
    }

    fn skip(
        &self,
        values: &mut Values<BufReader<&File>>,
        element: &Element,
        index: u64,
        property: &Property,
    ) -> Result<(), PlyError> {
        let count = if property.length.is_some() { self.list_length(values, element, index, property)? } else { 1 };
        let mut skipped = (0..count).map(|_| values.skip(property.value));
        skipped.try_for_each(|s| s).map_err(|e| self.value_error(e, element, index, property))
    }

    fn list_length(
        &self,
        values: &mut Values<BufReader<&File>>,
        element: &Element,
        index: u64,
        property: &Property,
    ) -> Result<u64, PlyError> {
        let length = property.length.expect("a list property");
        let found = values.integer(length).map_err(|e| self.value_error(e, element, index, property))?;
        u64::try_from(found).map_err(|_| PlyError::ListLength {
            path: self.path.clone(),
            element: element.name.clone(),
            index,
            property: property.name.clone(),
            found,
        })
    }

    /// A reader at the first value of an element: records of one length are jumped over, others are read.
    fn seek_to(&self, target: usize) -> Result<Values<BufReader<&File>>, PlyError> {
        let io = |source| PlyError::Io { path: self.path.clone(), source };
        let before = &self.header.elements[..target];
        let encoding = self.header.encoding;
        let jumped = match encoding {
            Encoding::Ascii => 0,
            _ => before.iter().take_while(|e| e.stride().is_some()).count(),
        };
        let jump: u64 = before[..jumped].iter().map(|e| e.count * e.stride().expect("no list") as u64).sum();
        let mut file = &self.file;
        file.seek(SeekFrom::Start(self.header.length + jump)).map_err(io)?;
        let mut values = Values::new(BufReader::with_capacity(BUFFER_BYTES, file), encoding);
        for element in before[jumped..].iter().filter(|e| !e.properties.is_empty()) {
            for index in 0..element.count {
                self.pace(index)?;
                for property in &element.properties {
                    self.skip(&mut values, element, index, property)?;
                }
            }
        }
        Ok(values)
    }

    fn value_error(&self, error: ValueError, element: &Element, index: u64, property: &Property) -> PlyError {
        let (path, name) = (self.path.clone(), element.name.clone());
        match error {
            ValueError::Io(source) => PlyError::Io { path, source },
            ValueError::End => PlyError::Truncated { path, element: name, count: element.count, index },
            ValueError::NotANumber(found) => PlyError::Number {
                path,
                element: name,
                index,
                property: property.name.clone(),
                expected: property.value,
                found,
            },
        }
    }
}

/// Without the end of its last line a file may have lost digits.
fn check_end(path: &Path, mut file: &File, bytes: u64) -> Result<(), PlyError> {
    let mut last = [0];
    let read = file.seek(SeekFrom::Start(bytes.saturating_sub(1))).and_then(|_| file.read_exact(&mut last));
    read.map_err(|source| PlyError::Io { path: path.to_path_buf(), source })?;
    if last == *b"\n" { Ok(()) } else { Err(PlyError::Unended { path: path.to_path_buf() }) }
}

/// Holds each count against what the rest of the file has room for: a lie is found before anybody counts on it.
/// Holds each count against what the rest of the file has room for: a lie is found before anybody counts on it.
fn check_counts(path: &Path, header: &Header, bytes: u64) -> Result<(), PlyError> {
    // The last value of an ascii file needs no blank after it.
    let mut left = bytes.saturating_sub(header.length) + u64::from(header.encoding == Encoding::Ascii);
    for element in &header.elements {
        let least = element.least_bytes(header.encoding) as u64;
        if least == 0 {
            continue;
        }
        if element.count > left / least {
            return Err(PlyError::Count {
                path: path.to_path_buf(),
                element: element.name.clone(),
                count: element.count,
                at_most: left / least,
            });
        }
        left -= element.count * least;
    }
    Ok(())
}
