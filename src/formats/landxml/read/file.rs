//! A LandXML file, pass by pass.

use std::fs::File;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use super::LandXmlError;
use super::walk::{Item, Walk, Wanted};
use crate::base::LineType;
use crate::base::channels::Channel;
use crate::base::control::CancelToken;
use crate::base::external::Scratch;
use crate::formats::ends::Ends;
use crate::formats::weld::{Welded, Welder};
use crate::formats::{EdgeVisitor, FaceVisitor, Header, MeshReader, ReadError, ReadOptions, VertexVisitor, lines};

/// Bytes of what a file says of itself that are kept.
const FACTS_LIMIT: usize = 1 << 20;

/// Names of surfaces that are told.
const NAMES_TOLD: usize = 8;

/// A LandXML file with one TIN, open for reading.
#[derive(Debug)]
pub struct LandXmlReader {
    path: PathBuf,
    file: File,
    header: Header,
    points: u64,
    faces: u64,
    /// Breaklines, and the edges that they are in a file of terrabite's; others need not be edges.
    lines: u64,
    edges: u64,
    /// Whether one of them is soft.
    has_soft: bool,
    ids: Ids,
    scratch: Scratch,
    cancel: CancelToken,
}

/// Which points faces mean.
#[derive(Debug)]
enum Ids {
    /// Those of points are one after the other, from this on.
    From(u64),
    /// The points' numbers: first those of all points, then those of all corners of faces.
    Sorted(Welded),
}

/// What is found while a file is opened.
#[derive(Debug, Default)]
struct Found {
    points: u64,
    faces: u64,
    lines: u64,
    has_soft: bool,
    first_id: u64,
    is_consecutive: bool,
    /// Surfaces: the first names, and how many with a definition there are.
    names: Vec<String>,
    definitions: u64,
    /// What terrabite says.
    facts: Vec<String>,
    facts_bytes: usize,
    vertices_told: Option<u64>,
    triangles_told: Option<u64>,
    edges_told: Option<u64>,
    /// What others say.
    others: Header,
}

impl LandXmlReader {
    /// Opens a file and reads it once, to count points and faces and to find what it says of itself; where ids have gaps, twice
    /// more.
    ///
    /// # Errors
    /// [`ReadError`] when the file cannot be read, is damaged, has another number of surfaces than one, or temporary files
    /// cannot be written.
    pub fn open(path: &Path, options: &ReadOptions) -> Result<LandXmlReader, ReadError> {
        let file = File::open(path).map_err(|source| LandXmlError::Io { path: path.to_path_buf(), source })?;
        let cancel = options.cancel.clone();
        let mut found = Found { is_consecutive: true, ..Found::default() };
        let mut walk = Walk::new(path, &file, Wanted::All, &cancel)?;
        while let Some(item) = walk.next()? {
            found.take(path, item)?;
        }
        drop(walk);
        found.check(path)?;
        let (header, ids) = (found.header(), Ids::From(found.first_id));
        let scratch = Scratch::new(options.temp_dir.as_deref(), cancel.clone());
        let Found { points, faces, lines, has_soft, is_consecutive, edges_told, .. } = found;
        let (path, edges) = (path.to_path_buf(), edges_told.unwrap_or(0));
        let mut mesh =
            LandXmlReader { path, file, header, points, faces, lines, edges, has_soft, ids, scratch, cancel };
        if !is_consecutive {
            mesh.ids = Ids::Sorted(mesh.sorted()?);
        }
        Ok(mesh)
    }

    /// Finds which points corners mean, by sorting: an id is the place of a point and of all corners that name it.
    fn sorted(&self) -> Result<Welded, ReadError> {
        let mut welder = Welder::new(&self.scratch);
        let place = |id: u64| [f64::from_bits(id), 0.0, 0.0];
        self.for_each(Wanted::Points, |item| {
            if let Item::Point(id, _) = item {
                welder.push(place(id))?;
            }
            Ok(ControlFlow::Continue(()))
        })?;
        self.for_each(Wanted::Faces, |item| {
            if let Item::Face(ids) = item {
                ids.into_iter().try_for_each(|id| welder.push(place(id)))?;
            }
            Ok(ControlFlow::Continue(()))
        })?;
        let welded = welder.finish()?;
        // A point's number is that of its place, unless one before it has its id.
        for (point, number) in (0..self.points).zip(welded.numbers(&self.scratch)) {
            let other = number?;
            if other != point {
                return Err(LandXmlError::RepeatedId { path: self.path.clone(), point, other }.into());
            }
        }
        Ok(welded)
    }

    /// Hands on what a pass is for until `visit` breaks.
    fn for_each(
        &self,
        wanted: Wanted,
        mut visit: impl FnMut(Item) -> Result<ControlFlow<()>, ReadError>,
    ) -> Result<(), ReadError> {
        let mut walk = Walk::new(&self.path, &self.file, wanted, &self.cancel)?;
        let (what, expected) = match wanted {
            Wanted::Points => ("points", self.points),
            Wanted::Lines => ("breaklines", self.lines),
            Wanted::Faces | Wanted::All => ("faces", self.faces),
        };
        let changed = |found| LandXmlError::Changed { path: self.path.clone(), what, expected, found };
        let mut found = 0;
        while let Some(item) = walk.next()? {
            let is_wanted = match item {
                Item::Point(..) => wanted == Wanted::Points,
                Item::Face(_) => wanted == Wanted::Faces,
                Item::Line(..) => wanted == Wanted::Lines,
                _ => false,
            };
            if !is_wanted {
                continue;
            }
            found += 1;
            if found > expected {
                return Err(changed(found).into());
            }
            if visit(item)?.is_break() {
                return Ok(());
            }
        }
        if found == expected { Ok(()) } else { Err(changed(found).into()) }
    }

    fn read_vertices(&self, visit: &mut VertexVisitor<'_>) -> Result<(), ReadError> {
        let mut index = 0;
        self.for_each(Wanted::Points, |item| {
            let Item::Point(_, place) = item else { return Ok(ControlFlow::Continue(())) };
            index += 1;
            Ok(visit(index - 1, place, &[]))
        })
    }

    fn read_faces(&self, visit: &mut FaceVisitor<'_>) -> Result<(), ReadError> {
        let mut numbers = match &self.ids {
            Ids::From(_) => None,
            Ids::Sorted(welded) => Some(welded.numbers_from(self.points, &self.scratch)),
        };
        let mut index = 0;
        self.for_each(Wanted::Faces, |item| {
            let Item::Face(ids) = item else { return Ok(ControlFlow::Continue(())) };
            let mut face = [0; 3];
            for (vertex, id) in face.iter_mut().zip(ids) {
                let number = match (&self.ids, &mut numbers) {
                    (Ids::From(first), _) => id.checked_sub(*first),
                    (Ids::Sorted(_), numbers) => numbers.as_mut().and_then(Iterator::next).transpose()?,
                };
                *vertex = number.filter(|number| *number < self.points).ok_or_else(|| LandXmlError::PointId {
                    path: self.path.clone(),
                    face: index,
                    found: id,
                })?;
            }
            index += 1;
            Ok(visit(index - 1, face))
        })
    }
}

impl Found {
    fn take(&mut self, path: &Path, item: Item) -> Result<(), LandXmlError> {
        match item {
            Item::Point(id, _) => {
                if self.points == 0 {
                    self.first_id = id;
                }
                self.is_consecutive &= id.checked_sub(self.first_id) == Some(self.points);
                self.points += 1;
            }
            Item::Face(_) => self.faces += 1,
            Item::Line(_, line_type) => {
                self.lines += 1;
                self.has_soft |= line_type == LineType::Soft;
            }
            Item::Surface(name) if self.names.len() < NAMES_TOLD => self.names.push(name.chars().take(80).collect()),
            Item::Surface(_) => {}
            Item::Definition(kind) if kind.is_empty() || kind.eq_ignore_ascii_case("TIN") => self.definitions += 1,
            Item::Definition(kind) => {
                let found = format!("one of type {:?}", kind.chars().take(80).collect::<String>());
                return Err(LandXmlError::Surfaces { path: path.to_path_buf(), found });
            }
            Item::Property(label, value) => self.take_property(&label, &value),
            Item::Crs(code, name) => {
                self.others.crs.definition = code.map(|code| format!("EPSG:{code}"));
                self.others.crs.name = name;
            }
            Item::Program(words) => self.others.made_by = Some(words),
        }
        Ok(())
    }

    fn take_property(&mut self, label: &str, value: &str) {
        match label {
            "vertices" => self.vertices_told = value.parse().ok(),
            "triangles" => self.triangles_told = value.parse().ok(),
            "edges" => self.edges_told = value.parse().ok(),
            "fact" if self.facts_bytes + value.len() <= FACTS_LIMIT => {
                self.facts_bytes += value.len();
                self.facts.push(unescaped(value));
            }
            _ => {}
        }
    }

    /// Holds counts against what the file says, and makes sure that it has one surface.
    fn check(&self, path: &Path) -> Result<(), LandXmlError> {
        let path = path.to_path_buf();
        if self.definitions != 1 {
            let found = match self.definitions {
                0 => "none with a definition".to_string(),
                count => format!("{count}: {}", self.names.join(", ")),
            };
            return Err(LandXmlError::Surfaces { path, found });
        }
        let counts = [("vertices", self.vertices_told, self.points), ("triangles", self.triangles_told, self.faces)];
        match counts.into_iter().find(|(_, told, found)| told.is_some_and(|told| told != *found)) {
            Some((what, Some(expected), found)) => Err(LandXmlError::Count { path, what, expected, found }),
            _ => Ok(()),
        }
    }

    /// What terrabite says of a mesh, or what others do.
    fn header(&self) -> Header {
        if self.vertices_told.is_none() && self.facts.is_empty() {
            return self.others.clone();
        }
        lines::header(self.facts.iter().map(|line| line.trim_end()))
    }
}

/// A fact as it was: `\\` is a backslash, `\u0000` the character of this number.
fn unescaped(fact: &str) -> String {
    let mut text = String::with_capacity(fact.len());
    let mut rest = fact;
    while let Some((before, escape)) = rest.split_once('\\') {
        text.push_str(before);
        let number = escape.strip_prefix('u').and_then(|digits| digits.get(..4));
        let character = number.and_then(|digits| char::from_u32(u32::from_str_radix(digits, 16).ok()?));
        let length = match character {
            Some(c) => {
                text.push(c);
                5
            }
            None => {
                text.push('\\');
                usize::from(escape.starts_with('\\'))
            }
        };
        rest = &escape[length..];
    }
    text + rest
}

impl MeshReader for LandXmlReader {
    fn path(&self) -> &Path {
        &self.path
    }

    fn vertex_count(&self) -> u64 {
        self.points
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

    fn edge_count(&self) -> u64 {
        self.edges
    }

    fn edges_have_types(&self) -> bool {
        self.edges > 0 && self.has_soft
    }

    fn edges(&mut self, visit: &mut EdgeVisitor<'_>) -> Result<(), ReadError> {
        if self.edges == 0 {
            return Ok(());
        }
        let (path, expected) = (&self.path, self.edges);
        let (mut ends, mut found) = (Ends::new(&self.scratch), 0);
        self.for_each(Wanted::Lines, |item| {
            if let Item::Line(points, line_type) = item {
                found += points.len().saturating_sub(1) as u64;
                ends.line(&points, line_type)?;
            }
            Ok(ControlFlow::Continue(()))
        })?;
        if found != expected {
            return Err(LandXmlError::Count { path: path.clone(), what: "edges", expected, found }.into());
        }
        let mut vertices = 0;
        self.for_each(Wanted::Points, |item| {
            if let Item::Point(_, place) = item {
                ends.vertex(vertices, place)?;
                vertices += 1;
            }
            Ok(ControlFlow::Continue(()))
        })?;
        ends.visit(path, visit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn facts_come_back() {
        for (fact, expected) in [
            ("a\\\\b", "a\\b"),
            ("\\u0000\\u001b.", "\u{0}\u{1b}."),
            ("\\\\u0041", "\\u0041"),
            ("\\u00", "\\u00"),
            ("\\ud800é", "\\ud800é"),
            ("\\", "\\"),
            ("\\uééé", "\\uééé"),
            ("a\\q", "a\\q"),
        ] {
            assert_eq!(unescaped(fact), expected, "{fact}");
        }
    }
}
