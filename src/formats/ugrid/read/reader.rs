//! A UGRID file, pass by pass.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use super::UgridError;
use super::head;
use super::mesh::{self, Corners, Meaning, Mesh, Values};
use crate::base::channels::Channel;
use crate::base::control::CancelToken;
use crate::formats::{FaceVisitor, Header, MeshReader, ReadError, VertexVisitor};

/// Nodes or faces that are read at a time; after them, whether to stop is looked at.
const BLOCK: u64 = 8 << 10;

/// A UGRID file with triangles, open for reading.
///
/// Memory use is constant: the head, then 128 KiB for each variable that is read.
#[derive(Debug)]
pub struct UgridReader {
    path: PathBuf,
    file: File,
    length: u64,
    mesh: Mesh,
    cancel: CancelToken,
}

impl UgridReader {
    /// Opens a file and reads its head. `cancel` ends every pass.
    ///
    /// # Errors
    /// [`UgridError`] when the file cannot be read, is no classic NetCDF file, has no mesh of faces with heights, or is shorter
    /// than its head says.
    pub fn open(path: &Path, cancel: &CancelToken) -> Result<UgridReader, UgridError> {
        let io = |source| UgridError::Io { path: path.to_path_buf(), source };
        let file = File::open(path).map_err(io)?;
        let length = file.metadata().map_err(io)?.len();
        let head = head::read(path, &file, length)?;
        let mesh = mesh::find(path, &head, length)?;
        Ok(UgridReader { path: path.to_path_buf(), file, length, mesh, cancel: cancel.clone() })
    }

    /// Makes sure that the file is as long as it was.
    fn begin_pass(&self) -> Result<(), UgridError> {
        let io = |source| UgridError::Io { path: self.path.clone(), source };
        let found = self.file.metadata().map_err(io)?.len();
        if found == self.length {
            return Ok(());
        }
        Err(UgridError::Changed { path: self.path.clone(), expected: self.length, found })
    }

    /// Fills `bytes` from a place in the file.
    fn read_at(&self, place: u64, bytes: &mut [u8]) -> Result<(), UgridError> {
        let mut file = &self.file;
        let read = file.seek(SeekFrom::Start(place)).and_then(|_| file.read_exact(bytes));
        read.map_err(|source| UgridError::Io { path: self.path.clone(), source })
    }

    /// The values of the nodes from `first` on, as many as `values` has room for.
    fn values(
        &self,
        Values { name, begin, number, meaning }: &Values,
        first: u64,
        bytes: &mut Vec<u8>,
        values: &mut [f64],
    ) -> Result<(), UgridError> {
        let size = number.bytes();
        bytes.resize(values.len() * size, 0);
        self.read_at(begin + first * size as u64, bytes)?;
        for (value, bytes) in values.iter_mut().zip(bytes.chunks_exact(size)) {
            *value = match meaning {
                Meaning::Unsigned => bytes[0].into(),
                Meaning::Plain | Meaning::Byte => number.real(bytes),
            };
        }
        let is_byte = |value: f64| value == f64::from(value as u8);
        match values.iter().position(|value| *meaning == Meaning::Byte && !is_byte(*value)) {
            None => Ok(()),
            Some(i) => {
                let (index, found) = (first + i as u64, values[i]);
                Err(UgridError::Byte { path: self.path.clone(), variable: name.clone(), index, found })
            }
        }
    }

    fn read_vertices(&self, attributes: &[&str], visit: &mut VertexVisitor<'_>) -> Result<(), UgridError> {
        self.begin_pass()?;
        let Mesh { nodes, places, .. } = &self.mesh;
        let asked = attributes.iter().filter_map(|name| self.mesh.attributes.iter().position(|a| a.name == *name));
        let columns: Vec<&Values> = places.iter().chain(asked.map(|place| &self.mesh.values[place])).collect();
        let mut bytes = Vec::new();
        let mut blocks = vec![vec![0.0; BLOCK.min(*nodes) as usize]; columns.len()];
        let mut row = vec![0.0; columns.len()];
        for first in (0..*nodes).step_by(BLOCK as usize) {
            self.cancel.check()?;
            let count = BLOCK.min(nodes - first) as usize;
            for (values, block) in columns.iter().zip(&mut blocks) {
                self.values(values, first, &mut bytes, &mut block[..count])?;
            }
            for i in 0..count {
                row.iter_mut().zip(&blocks).for_each(|(value, block)| *value = block[i]);
                if visit(first + i as u64, [row[0], row[1], row[2]], &row[3..]).is_break() {
                    return Ok(());
                }
            }
        }
        Ok(())
    }

    fn read_faces(&self, visit: &mut FaceVisitor<'_>) -> Result<(), UgridError> {
        self.begin_pass()?;
        let (faces, corners) = (self.mesh.faces, &self.mesh.corners);
        let size = corners.number.bytes();
        let at_a_time = (3 * BLOCK / corners.most as u64).max(1);
        let mut bytes = Vec::new();
        let mut face = vec![0; corners.most];
        for first in (0..faces).step_by(at_a_time as usize) {
            self.cancel.check()?;
            let count = at_a_time.min(faces - first) as usize;
            bytes.resize(count * corners.most * size, 0);
            if corners.corner_first {
                for (corner, bytes) in (0..).zip(bytes.chunks_exact_mut(count * size)) {
                    self.read_at(corners.begin + (corner * faces + first) * size as u64, bytes)?;
                }
            } else {
                self.read_at(corners.begin + first * (corners.most * size) as u64, &mut bytes)?;
            }
            for i in 0..count {
                for (corner, vertex) in face.iter_mut().enumerate() {
                    let place = if corners.corner_first { corner * count + i } else { i * corners.most + corner };
                    *vertex = corners.number.integer(&bytes[place * size..][..size]);
                }
                let index = first + i as u64;
                if visit(index, self.triangle(corners, index, &face)?).is_break() {
                    return Ok(());
                }
            }
        }
        Ok(())
    }

    /// The vertices of a face, from 0.
    fn triangle(&self, corners: &Corners, face: u64, vertices: &[i128]) -> Result<[u64; 3], UgridError> {
        let found = vertices.iter().position(|v| *v == corners.none).unwrap_or(vertices.len());
        if found != 3 {
            return Err(UgridError::NotATriangle { path: self.path.clone(), face, found });
        }
        let end = corners.start.saturating_add(self.mesh.nodes.into());
        let mut triangle = [0; 3];
        for (vertex, &found) in triangle.iter_mut().zip(vertices) {
            if found < corners.start || found >= end {
                let start = corners.start;
                return Err(UgridError::VertexIndex { path: self.path.clone(), face, start, end, found });
            }
            *vertex = (found - corners.start) as u64;
        }
        Ok(triangle)
    }
}

impl MeshReader for UgridReader {
    fn path(&self) -> &Path {
        &self.path
    }

    fn vertex_count(&self) -> u64 {
        self.mesh.nodes
    }

    fn face_count(&self) -> u64 {
        self.mesh.faces
    }

    fn header(&self) -> &Header {
        &self.mesh.header
    }

    fn attributes(&self) -> &[Channel] {
        &self.mesh.attributes
    }

    fn vertices(&mut self, attributes: &[&str], visit: &mut VertexVisitor<'_>) -> Result<(), ReadError> {
        let reader: &dyn MeshReader = self;
        reader.must_have(attributes)?;
        Ok(self.read_vertices(attributes, visit)?)
    }

    fn faces(&mut self, visit: &mut FaceVisitor<'_>) -> Result<(), ReadError> {
        Ok(self.read_faces(visit)?)
    }
}
