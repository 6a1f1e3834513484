//! A VTP file, pass by pass.

use std::collections::HashSet;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use super::VtpError;
use super::document::{self, Array, Document};
use super::numbers::{Encoding, Numbers, Type, Value, ValueError};
use super::tags::Stretch;
use crate::base::channels::Channel;
use crate::base::control::CancelToken;
use crate::formats::{FaceVisitor, Header, MeshReader, ReadError, VertexVisitor, lines};

/// Records between two looks at whether to stop; a power of two.
const PACE: u64 = 1 << 13;

/// The most components of an array that become attributes.
const COMPONENTS: u64 = 64;

/// A VTP file with triangles, open for reading.
///
/// Memory use is constant: what the XML says but for arrays, then 64 KiB for each array that is read.
#[derive(Debug)]
pub struct VtpReader {
    path: PathBuf,
    file: File,
    length: u64,
    header: Header,
    points: u64,
    polys: u64,
    coordinates: Array,
    connectivity: Array,
    offsets: Array,
    attributes: Vec<Channel>,
    /// Of each attribute its array, and which of the array's components it is.
    sources: Vec<(Array, u64)>,
    of_lengths: Type,
    is_big: bool,
    cancel: CancelToken,
}

impl VtpReader {
    /// Opens a file and reads its XML. `cancel` ends every pass.
    ///
    /// # Errors
    /// [`VtpError`] when the file cannot be read, is cut off, has no points or other cells than polygons, or arrays of other
    /// lengths than it says.
    pub fn open(path: &Path, cancel: &CancelToken) -> Result<VtpReader, VtpError> {
        let io = |source| VtpError::Io { path: path.to_path_buf(), source };
        let file = File::open(path).map_err(io)?;
        let length = file.metadata().map_err(io)?.len();
        if !ends(&file, length).map_err(io)? {
            return Err(VtpError::CutOff { path: path.to_path_buf(), length });
        }
        let document = document::read(path, &file, length)?;
        let mesh = VtpReader::of(path, file, length, document, cancel)?;
        mesh.check_lengths()?;
        Ok(mesh)
    }

    fn of(
        path: &Path,
        file: File,
        length: u64,
        document: Document,
        cancel: &CancelToken,
    ) -> Result<VtpReader, VtpError> {
        let Document { is_big, length: of_lengths, points, polys, coordinates, connectivity, offsets, .. } = document;
        let missing = |expected: &str| VtpError::Missing { path: path.to_path_buf(), expected: expected.to_string() };
        if points == 0 {
            return Err(missing("points"));
        }
        let coordinates = coordinates.ok_or_else(|| missing("the array of points"))?;
        let connectivity = connectivity.ok_or_else(|| missing("the array connectivity of polygons"))?;
        let offsets = offsets.ok_or_else(|| missing("the array offsets of polygons"))?;
        let wrong = |array: &Array, expected: &str, found: String| {
            let (array, expected) = (array.name.clone(), expected.to_string());
            Err(VtpError::Array { path: path.to_path_buf(), array, expected, found })
        };
        if coordinates.components != 3 {
            return wrong(&coordinates, "3 components", coordinates.components.to_string());
        }
        for array in [&connectivity, &offsets] {
            if !array.number.is_integer() || array.components != 1 {
                return wrong(
                    array,
                    "integers of one component",
                    format!("{:?} of {}", array.number, array.components),
                );
            }
        }
        let (attributes, sources) = attributes(document.attributes, document.normals.as_deref());
        let facts = document.facts.unwrap_or_default();
        let mut header = lines::header(facts.iter().map(|line| line.trim()));
        header.frame.single = coordinates.number == Type::Float32;
        let path = path.to_path_buf();
        let cancel = cancel.clone();
        Ok(VtpReader {
            path,
            file,
            length,
            header,
            points,
            polys,
            coordinates,
            connectivity,
            offsets,
            attributes,
            sources,
            of_lengths,
            is_big,
            cancel,
        })
    }

    /// Every array must have as many bytes as its values take, and the file as many as its arrays.
    fn check_lengths(&self) -> Result<(), VtpError> {
        let corners = self.polys.saturating_mul(3);
        let of_points = |array: &Array| self.points.saturating_mul(array.components);
        let counts = [(&self.coordinates, of_points(&self.coordinates)), (&self.connectivity, corners)];
        let further = self.sources.iter().filter(|(_, component)| *component == 0);
        let counts = counts.into_iter().chain([(&self.offsets, self.polys)]);
        for (array, count) in counts.chain(further.map(|(array, _)| (array, of_points(array)))) {
            self.check_length(array, count)?;
        }
        Ok(())
    }

    fn check_length(&self, array: &Array, count: u64) -> Result<(), VtpError> {
        let mut numbers = self.numbers(array);
        let found = numbers.length(self.of_lengths).map_err(|error| self.value_error(array, 0, error))?;
        let wanted = i128::from(count) * array.number.bytes() as i128;
        let wrong = |expected: String, found: String| {
            Err(VtpError::Array { path: self.path.clone(), array: array.name.clone(), expected, found })
        };
        match found {
            None => return Ok(()),
            // One of polygons with more corners is longer.
            Some(found) if found < wanted => {
                return wrong(format!("{wanted} bytes, for {count} numbers"), format!("{found}"));
            }
            Some(_) => {}
        }
        let end = i128::from(array.begin) + self.of_lengths.bytes() as i128 + wanted;
        if array.encoding == Encoding::Raw && end > i128::from(self.length) {
            return wrong(
                format!("{wanted} bytes, up to byte {end}"),
                format!("the end of the file at byte {}", self.length),
            );
        }
        Ok(())
    }

    fn numbers(&self, array: &Array) -> Numbers<'_> {
        let bytes = Stretch::new(&self.file, array.begin, array.end);
        Numbers::new(bytes, array.encoding, array.number, self.is_big)
    }

    /// The values of an array, from the first on.
    fn values<'a>(&'a self, array: &'a Array) -> Result<Values<'a>, VtpError> {
        let mut values = Values { mesh: self, array, numbers: self.numbers(array), index: 0 };
        let length = values.numbers.length(self.of_lengths);
        length.map_err(|error| self.value_error(array, 0, error))?;
        Ok(values)
    }

    fn value_error(&self, array: &Array, index: u64, error: ValueError) -> VtpError {
        let (path, name, expected) = (self.path.clone(), array.name.clone(), "a number of the array's type");
        match error {
            ValueError::Io(source) => VtpError::Io { path, source },
            ValueError::Ended => {
                VtpError::Value { path, array: name, index, expected, found: "the end of the array".to_string() }
            }
            ValueError::Wrong(found) => VtpError::Value { path, array: name, index, expected, found },
        }
    }

    /// Makes sure that the file is as long as it was.
    fn begin_pass(&self) -> Result<(), VtpError> {
        let io = |source| VtpError::Io { path: self.path.clone(), source };
        let found = self.file.metadata().map_err(io)?.len();
        if found == self.length {
            return Ok(());
        }
        Err(VtpError::Changed { path: self.path.clone(), expected: self.length, found })
    }

    fn pace(&self, index: u64) -> Result<(), VtpError> {
        if index.is_multiple_of(PACE) { Ok(self.cancel.check()?) } else { Ok(()) }
    }

    fn read_vertices(&self, attributes: &[&str], visit: &mut VertexVisitor<'_>) -> Result<(), VtpError> {
        self.begin_pass()?;
        let mut coordinates = self.values(&self.coordinates)?;
        let asked = attributes.iter().filter_map(|name| self.attributes.iter().position(|a| a.name == *name));
        let asked: Vec<&(Array, u64)> = asked.map(|place| &self.sources[place]).collect();
        let mut columns = asked.iter().map(|(array, _)| self.values(array)).collect::<Result<Vec<_>, _>>()?;
        let mut found = vec![0.0; asked.len()];
        for index in 0..self.points {
            self.pace(index)?;
            let place = [coordinates.real()?, coordinates.real()?, coordinates.real()?];
            for ((values, (array, wanted)), value) in columns.iter_mut().zip(&asked).zip(&mut found) {
                for component in 0..array.components {
                    let read = values.real()?;
                    if component == *wanted {
                        *value = read;
                    }
                }
            }
            if visit(index, place, &found).is_break() {
                return Ok(());
            }
        }
        Ok(())
    }

    fn read_faces(&self, visit: &mut FaceVisitor<'_>) -> Result<(), VtpError> {
        self.begin_pass()?;
        let mut connectivity = self.values(&self.connectivity)?;
        let mut offsets = self.values(&self.offsets)?;
        for index in 0..self.polys {
            self.pace(index)?;
            let found = offsets.integer()? - 3 * i128::from(index);
            if found != 3 {
                return Err(VtpError::NotATriangle { path: self.path.clone(), face: index, found });
            }
            let mut face = [0; 3];
            for vertex in &mut face {
                let (points, found) = (self.points, connectivity.integer()?);
                *vertex = u64::try_from(found).ok().filter(|v| *v < points).ok_or_else(|| VtpError::VertexIndex {
                    path: self.path.clone(),
                    face: index,
                    points,
                    found,
                })?;
            }
            if visit(index, face).is_break() {
                return Ok(());
            }
        }
        Ok(())
    }
}

/// The values of an array, one after the other.
struct Values<'a> {
    mesh: &'a VtpReader,
    array: &'a Array,
    numbers: Numbers<'a>,
    index: u64,
}

impl Values<'_> {
    #[inline]
    fn next(&mut self) -> Result<Value, VtpError> {
        match self.numbers.next() {
            Ok(value) => {
                self.index += 1;
                Ok(value)
            }
            Err(error) => Err(self.mesh.value_error(self.array, self.index, error)),
        }
    }

    #[inline]
    fn real(&mut self) -> Result<f64, VtpError> {
        Ok(self.next()?.real())
    }

    #[inline]
    fn integer(&mut self) -> Result<i128, VtpError> {
        match self.next()? {
            Value::Integer(value) => Ok(value),
            Value::Real(value) => Ok(value as i128),
        }
    }
}

/// Attributes of arrays: of one with several components each is one, numbered from 0; of normals `nx`, `ny` and `nz`.
fn attributes(arrays: Vec<Array>, normals: Option<&str>) -> (Vec<Channel>, Vec<(Array, u64)>) {
    let (mut found, mut names) = (Vec::new(), HashSet::new());
    for array in arrays.into_iter().filter(|array| (1..=COMPONENTS).contains(&array.components)) {
        let is_normals = array.components == 3 && normals == Some(array.name.as_str());
        let number = array.number.narrowest();
        for component in 0..array.components {
            let name = match (is_normals, array.components) {
                (true, _) => ["nx", "ny", "nz"][component as usize].to_string(),
                (false, 1) => array.name.clone(),
                (false, _) => format!("{}_{component}", array.name),
            };
            if !name.is_empty() && names.insert(name.clone()) {
                found.push((Channel { name, number }, (array.clone(), component)));
            }
        }
    }
    found.into_iter().unzip()
}

/// Whether the file ends as its XML does.
fn ends(mut file: &File, length: u64) -> std::io::Result<bool> {
    let mut end = Vec::new();
    file.seek(SeekFrom::Start(length.saturating_sub(256)))?;
    file.take(256).read_to_end(&mut end)?;
    file.seek(SeekFrom::Start(0))?;
    Ok(end.trim_ascii_end().ends_with(b"</VTKFile>"))
}

impl MeshReader for VtpReader {
    fn path(&self) -> &Path {
        &self.path
    }

    fn vertex_count(&self) -> u64 {
        self.points
    }

    fn face_count(&self) -> u64 {
        self.polys
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
        Ok(self.read_vertices(attributes, visit)?)
    }

    fn faces(&mut self, visit: &mut FaceVisitor<'_>) -> Result<(), ReadError> {
        Ok(self.read_faces(visit)?)
    }
}
