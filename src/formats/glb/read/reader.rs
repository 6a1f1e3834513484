//! A GLB file as a mesh of any format.

use std::path::Path;

use super::GlbError;
use super::columns::Columns;
use super::container::GlbFile;
use super::scene::{Part, Scene, scene};
use super::transform::Transform;
use crate::base::channels::Channel;
use crate::base::external::{Scratch, ScratchError};
use crate::formats::weld::{Welded, Welder};
use crate::formats::{FaceVisitor, Header, MeshReader, ReadError, ReadOptions, VertexVisitor};

/// Records between two looks at whether to stop; a power of two.
const PACE: u64 = 1 << 14;

/// A GLB file as a [`MeshReader`].
#[derive(Debug)]
pub struct GlbReader {
    file: GlbFile,
    scene: Scene,
    scratch: Scratch,
    /// Which vertex each one of the parts is; `None` where there is one part, whose vertices are those of the mesh.
    welded: Option<Welded>,
}

impl GlbReader {
    /// Opens a file.
    ///
    /// # Errors
    /// [`GlbError`] if it cannot be read, is damaged or has what is not read of glTF.
    pub fn open(path: &Path, options: &ReadOptions) -> Result<GlbReader, GlbError> {
        let (mut file, document) = GlbFile::open(path, &options.cancel)?;
        let scene = scene(&file, &document)?;
        let scratch = Scratch::new(options.temp_dir.as_deref(), options.cancel.clone());
        let is_shared = scene.parts.len() <= 1 && scene.parts.iter().all(|part| part.indices.is_some());
        let welded = if is_shared { None } else { Some(weld(&mut file, &scene.parts, &scratch)?) };
        Ok(GlbReader { file, scene, scratch, welded })
    }

    fn each_vertex(&mut self, attributes: &[&str], visit: &mut VertexVisitor<'_>) -> Result<(), GlbError> {
        let GlbReader { file, scene, scratch, welded } = self;
        file.begin()?;
        let find = |name: &&str| scene.attributes.iter().position(|a| a.name == **name);
        let asked: Vec<usize> = attributes.iter().filter_map(find).collect();
        let mut numbers = welded.as_ref().map(|welded| welded.numbers(scratch));
        let mut values = vec![0.0; asked.len()];
        let mut next = 0;
        for part in &scene.parts {
            let fields: Vec<_> = asked.iter().map(|field| &part.fields[*field]).collect();
            let columns = std::iter::once(&part.positions).chain(fields.iter().map(|field| &field.column));
            let mut columns = Columns::open(file, columns)?;
            for i in 0..part.vertices {
                pace(file, i)?;
                let number = match &mut numbers {
                    None => next,
                    Some(numbers) => numbers.next().ok_or_else(|| GlbError::Changed { path: file.path.clone() })??,
                };
                if number < next {
                    continue;
                }
                columns.load(file, i)?;
                for (place, (value, field)) in values.iter_mut().zip(&fields).enumerate() {
                    let found = columns.value(place + 1, i, field.component);
                    *value = if field.is_negated { -found } else { found };
                }
                if visit(number, position(&columns, i, &part.transform), &values).is_break() {
                    return Ok(());
                }
                next = number + 1;
            }
        }
        Ok(())
    }

    fn each_face(&mut self, visit: &mut FaceVisitor<'_>) -> Result<(), GlbError> {
        let GlbReader { file, scene, scratch, welded } = self;
        file.begin()?;
        let mut lookup = welded.as_ref().map(|welded| Lookup::new(welded, scratch, &scene.parts));
        let mut next = 0;
        for part in &scene.parts {
            let mut columns = Columns::open(file, &part.indices)?;
            let is_mirrored = part.transform.mirrors();
            for face in 0..part.faces {
                pace(file, face)?;
                let mut triangle = [3 * face, 3 * face + 1, 3 * face + 2];
                if part.indices.is_some() {
                    for corner in &mut triangle {
                        columns.load(file, *corner)?;
                        *corner = columns.value(0, *corner, 0) as u64;
                    }
                }
                if let Some(&found) = triangle.iter().find(|vertex| **vertex >= part.vertices) {
                    let (path, place) = (file.path.clone(), part.name());
                    return Err(GlbError::VertexIndex { path, place, face, vertices: part.vertices, found });
                }
                if let Some(lookup) = &mut lookup {
                    for vertex in &mut triangle {
                        *vertex = lookup.vertex(part.first + *vertex)?;
                    }
                }
                if is_mirrored {
                    triangle.swap(1, 2);
                }
                if visit(next, triangle).is_break() {
                    return Ok(());
                }
                next += 1;
            }
        }
        Ok(())
    }
}

fn pace(file: &GlbFile, index: u64) -> Result<(), GlbError> {
    if index.is_multiple_of(PACE) { Ok(file.cancel.check()?) } else { Ok(()) }
}

/// A vertex of a part, from its first column: x, y, z.
fn position(columns: &Columns, i: u64, transform: &Transform) -> [f64; 3] {
    let found = std::array::from_fn(|component| columns.value(0, i, component));
    let [x, up, south] = if *transform == Transform::NONE { found } else { transform.apply(found) };
    [x, -south, up]
}

fn weld(file: &mut GlbFile, parts: &[Part], scratch: &Scratch) -> Result<Welded, GlbError> {
    let mut welder = Welder::new(scratch);
    for part in parts {
        let mut columns = Columns::open(file, [&part.positions])?;
        for i in 0..part.vertices {
            pace(file, i)?;
            columns.load(file, i)?;
            welder.push(position(&columns, i, &part.transform))?;
        }
    }
    Ok(welder.finish()?)
}

/// Elements whose vertices are looked up at once.
const PAGE: u64 = 8 << 10;

/// Pages that are kept.
const PAGES: u64 = 512;

/// The vertices of elements, wherever they are. Memory: 32 MiB.
struct Lookup<'a> {
    welded: &'a Welded,
    scratch: &'a Scratch,
    elements: u64,
    /// Each with its number, in the place that the number has modulo [`PAGES`].
    pages: Vec<Option<(u64, Vec<u64>)>>,
}

impl<'a> Lookup<'a> {
    fn new(welded: &'a Welded, scratch: &'a Scratch, parts: &[Part]) -> Lookup<'a> {
        let elements = parts.last().map_or(0, |part| part.first + part.vertices);
        Lookup { welded, scratch, elements, pages: vec![None; PAGES as usize] }
    }

    fn vertex(&mut self, element: u64) -> Result<u64, ScratchError> {
        let (page, place) = (element / PAGE, (element % PAGE) as usize);
        let slot = &mut self.pages[(page % PAGES) as usize];
        match slot {
            Some((number, vertices)) if *number == page => Ok(vertices[place]),
            _ => {
                let first = page * PAGE;
                let vertices = self.welded.some(self.scratch, first, PAGE.min(self.elements - first) as usize)?;
                let vertex = vertices[place];
                *slot = Some((page, vertices));
                Ok(vertex)
            }
        }
    }
}

impl MeshReader for GlbReader {
    fn path(&self) -> &Path {
        &self.file.path
    }

    fn vertex_count(&self) -> u64 {
        match &self.welded {
            Some(welded) => welded.vertices(),
            None => self.scene.parts.iter().map(|part| part.vertices).sum(),
        }
    }

    fn face_count(&self) -> u64 {
        self.scene.parts.iter().map(|part| part.faces).sum()
    }

    fn header(&self) -> &Header {
        &self.scene.header
    }

    fn attributes(&self) -> &[Channel] {
        &self.scene.attributes
    }

    fn vertices(&mut self, attributes: &[&str], visit: &mut VertexVisitor<'_>) -> Result<(), ReadError> {
        let reader: &dyn MeshReader = self;
        reader.must_have(attributes)?;
        Ok(self.each_vertex(attributes, visit)?)
    }

    fn faces(&mut self, visit: &mut FaceVisitor<'_>) -> Result<(), ReadError> {
        Ok(self.each_face(visit)?)
    }
}
