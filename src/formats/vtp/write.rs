//! VTP's writer.

use bytemuck::cast;

use super::FORMAT;
use crate::base::channels::{Channel, Number};
use crate::base::staged::StagedFile;
use crate::formats::columns::{AT_A_TIME, Column, Columns};
use crate::formats::wording::{Placer, facts};
use crate::formats::{Contents, Header, Setup, Sink, SinkError};

/// VTK's XML for polygons, with arrays as bytes behind it (`appended`, `raw`, little-endian, not compressed): points, an array
/// for every attribute, normals as such, triangles. The header's facts are strings of the field data `terrabite`.
///
/// Memory: 8 MiB of buffers.
#[derive(Debug)]
pub struct VtpSink {
    output: Columns,
    header: Header,
    placer: Placer,
    columns: Option<Filled>,
    /// How many triangles have come.
    triangles: u64,
    /// Where the arrays end.
    end: u64,
}

/// The columns of the file.
#[derive(Debug)]
struct Filled {
    points: Column,
    attributes: Vec<(Column, Number)>,
    normals: Option<Column>,
    connectivity: Column,
    offsets: Column,
}

/// An array as the XML has it.
struct Array {
    section: &'static str,
    number: &'static str,
    name: String,
    components: u64,
    bytes: u64,
}

/// Bytes before an array, which say how many it has.
const LENGTH: u64 = 8;

/// What comes after the arrays. No line ends it: whatever is cut off is missed.
const END: &[u8] = b"\n  </AppendedData>\n</VTKFile>";

impl VtpSink {
    /// Writes to `staged`, as the setup says.
    pub fn new(staged: StagedFile, setup: Setup) -> VtpSink {
        let placer = Placer::of(&setup);
        let header = setup.header;
        VtpSink { output: Columns::new(staged), header, placer, columns: None, triangles: 0, end: 0 }
    }

    /// The arrays, in the order of the columns.
    fn arrays(&self, contents: &Contents<'_>, attributes: &[Channel]) -> Vec<Array> {
        let Contents { vertices, triangles, has_normals, .. } = *contents;
        let coordinate = if self.header.frame.single { Number::F32 } else { Number::F64 };
        let points = |section, name: &str, number, components| {
            let (number, bytes) = type_of(number);
            Array { section, number, name: name.to_string(), components, bytes: vertices * components * bytes }
        };
        let mut arrays = vec![points("Points", "Points", coordinate, 3)];
        arrays.extend(attributes.iter().map(|Channel { name, number }| points("PointData", name, *number, 1)));
        let normals = points("PointData", normals_name(attributes), Number::F32, 3);
        arrays.extend(has_normals.then_some(normals));
        let polys = |name: &str, count: u64| {
            let name = name.to_string();
            Array { section: "Polys", number: "Int64", name, components: 1, bytes: 8 * count }
        };
        arrays.extend([polys("connectivity", 3 * triangles), polys("offsets", triangles)]);
        arrays
    }

    /// The XML up to the first array.
    fn head(&self, contents: &Contents<'_>, arrays: &[Array], normals: Option<&str>) -> String {
        let Contents { vertices, triangles, .. } = contents;
        let mut head = String::from(
            "<?xml version=\"1.0\"?>\n\
             <VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n  <PolyData>\n",
        );
        head.push_str(&field_data(&facts(&self.header)));
        head.push_str(&format!(
            "    <Piece NumberOfPoints=\"{vertices}\" NumberOfVerts=\"0\" NumberOfLines=\"0\" NumberOfStrips=\"0\" \
             NumberOfPolys=\"{triangles}\">\n"
        ));
        let mut place = 0;
        let lines: Vec<(&str, String)> = arrays
            .iter()
            .map(|Array { section, number, name, components, bytes }| {
                let line = format!(
                    "        <DataArray type=\"{number}\" Name=\"{name}\" NumberOfComponents=\"{components}\" \
                     format=\"appended\" offset=\"{place}\"/>\n"
                );
                place += LENGTH + bytes;
                (*section, line)
            })
            .collect();
        for section in ["PointData", "Points", "Polys"] {
            let role = normals.filter(|_| section == "PointData").map(|name| format!(" Normals=\"{name}\""));
            head.push_str(&format!("      <{section}{}>\n", role.unwrap_or_default()));
            lines.iter().filter(|(of, _)| *of == section).for_each(|(_, line)| head.push_str(line));
            head.push_str(&format!("      </{section}>\n"));
        }
        head.push_str("    </Piece>\n  </PolyData>\n  <AppendedData encoding=\"raw\">\n   _");
        head
    }
}

/// A number type by VTK's name, and its bytes.
fn type_of(number: Number) -> (&'static str, u64) {
    match number {
        Number::U8 => ("UInt8", 1),
        Number::F32 => ("Float32", 4),
        Number::F64 => ("Float64", 8),
    }
}

/// What the array of normals is called: as VTK itself does, if no attribute is called so.
fn normals_name(attributes: &[Channel]) -> &'static str {
    if attributes.iter().any(|channel| channel.name == "Normals") { "UnitNormals" } else { "Normals" }
}

/// Strings as VTK has them in text: the numbers of their bytes, a 0 after each string. A byte of 0 within one is `\0`, and a
/// backslash is two.
fn field_data(lines: &[String]) -> String {
    let mut text = format!(
        "    <FieldData>\n      <Array type=\"String\" Name=\"terrabite\" NumberOfTuples=\"{}\" format=\"ascii\">\n",
        lines.len()
    );
    for line in lines {
        let escaped = line.replace('\\', "\\\\").replace('\0', "\\0");
        escaped.bytes().for_each(|byte| text.push_str(&format!("{byte} ")));
        text.push_str("0\n");
    }
    text.push_str("      </Array>\n    </FieldData>\n");
    text
}

impl Sink for VtpSink {
    fn begin(&mut self, contents: &Contents<'_>) -> Result<(), SinkError> {
        self.header.complete(contents);
        FORMAT.limits.check(FORMAT.title, self.output.path(), contents)?;
        let scalars = contents.attributes.len() - if contents.has_normals { 3 } else { 0 };
        let attributes = &contents.attributes[..scalars];
        let arrays = self.arrays(contents, attributes);
        let normals = contents.has_normals.then(|| normals_name(attributes));
        let head = self.head(contents, &arrays, normals);
        let mut place = head.len() as u64;
        let mut places = Vec::new();
        for array in &arrays {
            places.push((place + LENGTH, array.bytes));
            place += LENGTH + array.bytes;
        }
        let columns = self.output.lay_out(head.as_bytes(), &places)?;
        for ((place, bytes), _) in places.iter().zip(&arrays) {
            self.output.write_at(place - LENGTH, &bytes.to_le_bytes())?;
        }
        self.end = place;
        let last = columns.len() - 1;
        self.columns = Some(Filled {
            points: columns[0],
            attributes: columns[1..].iter().copied().zip(attributes.iter().map(|channel| channel.number)).collect(),
            normals: contents.has_normals.then(|| columns[last - 2]),
            connectivity: columns[last - 1],
            offsets: columns[last],
        });
        Ok(())
    }

    fn vertices(&mut self, vertices: &[[f64; 3]], attributes: &[&[f64]]) -> Result<(), SinkError> {
        let Filled { points, attributes: columns, normals, .. } = self.columns.as_ref().expect("begun");
        let scalars = columns.len();
        assert_eq!(attributes.len(), scalars + if normals.is_some() { 3 } else { 0 }, "attributes");
        let mut places = Vec::with_capacity(AT_A_TIME);
        for vertices in vertices.chunks(AT_A_TIME) {
            places.clear();
            for vertex in vertices {
                places.push(self.placer.place(self.output.path(), *vertex)?);
            }
            let places = places.iter().copied();
            match self.header.frame.single {
                true => self.output.put_all(*points, places.map(singles))?,
                false => self.output.put_all(*points, places.map(doubles))?,
            }
        }
        for (&(column, number), values) in columns.iter().zip(attributes) {
            for values in values.chunks(AT_A_TIME) {
                let values = values.iter();
                match number {
                    Number::U8 => self.output.put_all(column, values.map(|value| [*value as u8]))?,
                    Number::F32 => self.output.put_all(column, values.map(|value| (*value as f32).to_le_bytes()))?,
                    Number::F64 => self.output.put_all(column, values.map(|value| value.to_le_bytes()))?,
                }
            }
        }
        if let (Some(column), [x, y, z]) = (normals, &attributes[scalars..]) {
            for ((&x, &y), &z) in x.iter().zip(*y).zip(*z) {
                self.output.put(*column, &singles([x, y, z]))?;
            }
        }
        Ok(())
    }

    fn triangles(&mut self, triangles: &[[u64; 3]], _: &[[[f64; 3]; 3]]) -> Result<(), SinkError> {
        let Filled { connectivity, offsets, .. } = self.columns.as_ref().expect("begun");
        for triangles in triangles.chunks(AT_A_TIME) {
            let corners = triangles.iter().map(|triangle| cast::<_, [u8; 24]>(triangle.map(u64::to_le_bytes)));
            self.output.put_all(*connectivity, corners)?;
            let before = self.triangles;
            let ends = (0..triangles.len()).map(|i| (3 * (before + i as u64 + 1)).to_le_bytes());
            self.output.put_all(*offsets, ends)?;
            self.triangles += triangles.len() as u64;
        }
        Ok(())
    }

    fn finish(mut self: Box<Self>) -> Result<(), SinkError> {
        self.output.write_at(self.end, END)?;
        self.output.commit()
    }
}

fn singles(values: [f64; 3]) -> [u8; 12] {
    cast(values.map(|value| (value as f32).to_le_bytes()))
}

fn doubles(values: [f64; 3]) -> [u8; 24] {
    cast(values.map(f64::to_le_bytes))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::CoordinateFrame;
    use crate::formats::{ReadError, ReadOptions};

    const VERTICES: [[f64; 3]; 3] = [[0.5, -0.5, 1.25], [2.5, -0.5, -7.0], [0.5, -4.5, 1e-3]];

    fn written(
        header: Header,
        attributes: &[Channel],
        values: &[&[f64]],
        has_normals: bool,
    ) -> (tempfile::TempDir, Vec<u8>) {
        let folder = crate::testing::folder();
        let path = folder.path().join("tin.vtp");
        let mut sink = VtpSink::new(
            StagedFile::create(&path, false, &[]).expect("staged"),
            Setup { header, loss: f64::INFINITY, ..Setup::default() },
        );
        let contents = Contents { vertices: 3, triangles: 1, attributes, has_normals, ..Contents::default() };
        sink.begin(&contents).expect("begun");
        sink.vertices(&VERTICES, values).expect("written");
        sink.triangles(&[[0, 2, 1]], &[]).expect("written");
        Box::new(sink).finish().expect("finished");
        let bytes = std::fs::read(path).expect("a file");
        (folder, bytes)
    }

    #[test]
    fn a_mesh_byte_for_byte() {
        let mut expected = b"<?xml version=\"1.0\"?>\n\
            <VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n  <PolyData>\n    \
            <FieldData>\n      <Array type=\"String\" Name=\"terrabite\" NumberOfTuples=\"1\" format=\"ascii\">\n\
            97 92 92 92 48 0\n      </Array>\n    </FieldData>\n    <Piece NumberOfPoints=\"3\" NumberOfVerts=\"0\" \
            NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"1\">\n      <PointData>\n        <DataArray \
            type=\"UInt8\" Name=\"red\" NumberOfComponents=\"1\" format=\"appended\" offset=\"80\"/>\n      </PointData>\n      \
            <Points>\n        <DataArray type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\" format=\"appended\" \
            offset=\"0\"/>\n      </Points>\n      <Polys>\n        <DataArray type=\"Int64\" Name=\"connectivity\" \
            NumberOfComponents=\"1\" format=\"appended\" offset=\"91\"/>\n        <DataArray type=\"Int64\" Name=\"offsets\" \
            NumberOfComponents=\"1\" format=\"appended\" offset=\"123\"/>\n      </Polys>\n    </Piece>\n  </PolyData>\n  \
            <AppendedData encoding=\"raw\">\n   _"
            .to_vec();
        expected.extend(72u64.to_le_bytes());
        VERTICES.iter().flatten().for_each(|v| expected.extend(v.to_le_bytes()));
        expected.extend([3, 0, 0, 0, 0, 0, 0, 0, 1, 2, 255]);
        [24u64, 0, 2, 1, 8, 3].iter().for_each(|v| expected.extend(v.to_le_bytes()));
        expected.extend(END);
        let header = Header { notes: vec!["a\\\0".to_string()], ..Header::default() };
        let red = Channel { name: "red".to_string(), number: Number::U8 };
        let (_folder, found) = written(header, &[red], &[&[1.0, 2.0, 255.0]], false);
        assert_eq!(String::from_utf8_lossy(&found), String::from_utf8_lossy(&expected));
        assert_eq!(found, expected);
    }

    #[test]
    fn normals_are_normals() {
        let channel = |name: &str, number| Channel { name: name.to_string(), number };
        let attributes = [
            channel("Normals", Number::F64),
            channel("nx", Number::F32),
            channel("ny", Number::F32),
            channel("nz", Number::F32),
        ];
        let values: [&[f64]; 4] = [&[0.1, 0.2, 0.3], &[0.0, 0.5, 0.0], &[0.0, 0.25, 1.0], &[1.0, 0.125, 0.0]];
        let frame = CoordinateFrame { single: true, ..CoordinateFrame::PLAIN };
        let (folder, bytes) = written(Header { frame, ..Header::default() }, &attributes, &values, true);
        let head = String::from_utf8_lossy(&bytes).into_owned();
        assert!(head.contains("<PointData Normals=\"UnitNormals\">") && head.contains("Name=\"Normals\""), "{head}");
        let mut mesh =
            crate::formats::open(&folder.path().join("tin.vtp"), None, &ReadOptions::default()).expect("a mesh");
        assert_eq!(mesh.attributes(), attributes);
        mesh.for_each_vertex_with(&["nz", "Normals", "nx", "ny"], |i, place, found| {
            let i = i as usize;
            assert_eq!(place, VERTICES[i].map(|v| f64::from(v as f32)));
            assert_eq!(found, [values[3][i], values[0][i], values[1][i], values[2][i]]);
            Ok::<(), ReadError>(())
        })
        .expect("vertices");
    }
}
