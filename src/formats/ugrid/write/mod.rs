//! UGRID's writer.

mod netcdf;
mod words;

use super::FORMAT;
use crate::base::channels::Number;
use crate::base::staged::StagedFile;
use crate::formats::columns::{AT_A_TIME, Column, Columns};
use crate::formats::wording::Placer;
use crate::formats::{Contents, Header, Setup, Sink, SinkError};
use netcdf::{File, Type, Variable, Version};

/// UGRID 1.0 in a classic NetCDF file: x, y and height of the nodes of a mesh `mesh2d`, a variable for every attribute, and the
/// faces as three numbers of nodes, from 0. The header's facts are lines of the file's attribute `terrabite`.
///
/// Files are of the kind CDF-2 (64-bit offset), which every NetCDF library reads, as long as every variable has less than 4
/// GiB; CDF-5 beyond. Attributes that are bytes are written as singles, and say what they were: MDAL (QGIS 3.22) refuses a
/// whole file for a variable of short or unsigned numbers.
///
/// Memory: 8 MiB of buffers.
#[derive(Debug)]
pub struct UgridSink {
    output: Columns,
    header: Header,
    placer: Placer,
    /// x, y and height.
    places: Vec<Column>,
    attributes: Vec<(Column, Type)>,
    faces: Option<(Column, Type)>,
}

impl UgridSink {
    /// Writes to `staged`, as the setup says.
    pub fn new(staged: StagedFile, setup: Setup) -> UgridSink {
        let placer = Placer::of(&setup);
        let header = setup.header;
        let output = Columns::new(staged);
        UgridSink { output, header, placer, places: Vec::new(), attributes: Vec::new(), faces: None }
    }

    /// A file for these contents, as CDF-2 if it can be.
    fn file(&self, contents: &Contents<'_>) -> File {
        let small = self.file_of(Version::Offset64, contents);
        if small.is_small() { small } else { self.file_of(Version::Data64, contents) }
    }

    fn file_of(&self, version: Version, contents: &Contents<'_>) -> File {
        let coordinate = if self.header.frame.single { Type::Float } else { Type::Double };
        let attribute = |number| match number {
            Number::U8 | Number::F32 => Type::Float,
            Number::F64 => Type::Double,
        };
        // Signed, as xugrid 0.15.3 cannot take others.
        let index = if contents.vertices > i32::MAX as u64 { Type::Int64 } else { Type::Int };
        let mut variables = vec![words::topology(Type::Int)];
        variables.extend(words::reference(&self.header, Type::Int));
        variables.extend(words::places(&self.header, coordinate));
        let numbers = contents.attributes.iter().map(|channel| (channel, attribute(channel.number)));
        variables.extend(numbers.map(|(channel, number)| words::attribute(&self.header, channel, number)));
        variables.push(words::faces(index));
        let dimensions = [("mesh2d_nNodes", contents.vertices), ("mesh2d_nFaces", contents.triangles), ("Three", 3)];
        let dimensions = dimensions.map(|(name, length)| (name.to_string(), length)).to_vec();
        File { version, dimensions, said: words::file(&self.header), variables }
    }
}

impl Sink for UgridSink {
    fn begin(&mut self, contents: &Contents<'_>) -> Result<(), SinkError> {
        self.header.complete(contents);
        FORMAT.limits.check(FORMAT.title, self.output.path(), contents)?;
        if contents.vertices == 0 || contents.triangles == 0 {
            // In NetCDF, a dimension of 0 is one that has no end.
            return Err(SinkError::Unfit {
                path: self.output.path().to_path_buf(),
                expected: "vertices and triangles".to_string(),
                found: format!("{} vertices and {} triangles", contents.vertices, contents.triangles),
            });
        }
        let file = self.file(contents);
        let (head, places) = file.head();
        let columns = self.output.lay_out(&head, &places)?;
        let mut all = columns.into_iter().zip(&file.variables);
        for (column, Variable { dimensions, number, .. }) in all.by_ref() {
            match dimensions.as_slice() {
                [] => self.output.put(column, &[0; 4])?,
                [_] if self.places.len() < 3 => self.places.push(column),
                [_] => self.attributes.push((column, *number)),
                _ => self.faces = Some((column, *number)),
            }
        }
        Ok(())
    }

    fn vertices(&mut self, vertices: &[[f64; 3]], attributes: &[&[f64]]) -> Result<(), SinkError> {
        assert_eq!(attributes.len(), self.attributes.len(), "attributes");
        let is_single = self.header.frame.single;
        let mut places = Vec::with_capacity(AT_A_TIME);
        for vertices in vertices.chunks(AT_A_TIME) {
            places.clear();
            for vertex in vertices {
                places.push(self.placer.place(self.output.path(), *vertex)?);
            }
            for (axis, &column) in self.places.iter().enumerate() {
                let values = places.iter().map(|place| place[axis]);
                match is_single {
                    true => self.output.put_all(column, values.map(|value| (value as f32).to_be_bytes()))?,
                    false => self.output.put_all(column, values.map(f64::to_be_bytes))?,
                }
            }
        }
        for (&(column, number), values) in self.attributes.iter().zip(attributes) {
            for values in values.chunks(AT_A_TIME) {
                match number {
                    Type::Float => self.output.put_all(column, values.iter().map(|v| (*v as f32).to_be_bytes()))?,
                    _ => self.output.put_all(column, values.iter().map(|v| v.to_be_bytes()))?,
                }
            }
        }
        Ok(())
    }

    fn triangles(&mut self, triangles: &[[u64; 3]], _: &[[[f64; 3]; 3]]) -> Result<(), SinkError> {
        let (column, number) = self.faces.expect("begun");
        for triangles in triangles.chunks(AT_A_TIME) {
            let corners = triangles.as_flattened().iter();
            match number {
                Type::Int64 => self.output.put_all(column, corners.map(|vertex| vertex.to_be_bytes()))?,
                _ => self.output.put_all(column, corners.map(|vertex| (*vertex as u32).to_be_bytes()))?,
            }
        }
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<(), SinkError> {
        self.output.commit()
    }
}

#[cfg(test)]
mod tests;
