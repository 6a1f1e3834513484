//! PLY's writer.

use super::FORMAT;
use crate::base::channels::{Channel, Number};
use crate::base::staged::StagedFile;
use crate::formats::output::Output;
use crate::formats::wording::{Placer, frame_lines, one_line, run_lines};
use crate::formats::{Contents, Header, Setup, Sink, SinkError};

/// Binary little-endian PLY: vertices as x, y, z (`double`, or `float`, as the header's frame says) and a number for every
/// attribute (`uchar`, `float` or `double`), faces as lists of three 32-bit numbers. The header's facts are comments.
///
/// Vertices are shared, so the mesh is indexed. Memory: one buffer of a megabyte.
#[derive(Debug)]
pub struct PlySink {
    output: Output,
    header: Header,
    placer: Placer,
    numbers: Vec<Number>,
}

/// Bytes of one triangle in the file.
const TRIANGLE_BYTES: u64 = 13;

impl PlySink {
    /// Writes to `staged`, and every height so that it is read again exactly.
    pub fn new(staged: StagedFile, header: Header) -> PlySink {
        PlySink::with_setup(staged, Setup { header, ..Setup::default() })
    }

    /// Writes to `staged`, as the setup says.
    pub fn with_setup(staged: StagedFile, setup: Setup) -> PlySink {
        let placer = Placer::of(&setup);
        PlySink { output: Output::new(staged), header: setup.header, placer, numbers: Vec::new() }
    }
}

/// What the file says of itself. Nothing here depends on the machine or the time.
fn comments(header: &Header) -> Vec<String> {
    let Header { made_by, source, crs, frame, .. } = header;
    let mut lines = Vec::new();
    lines.extend(made_by.iter().map(|program| format!("made by {program}")));
    lines.extend(source.iter().map(|name| format!("source {name}")));
    // In the form in which QGIS reads it: no blank after the colon, which would belong to the CRS. Where an origin is taken
    // off, QGIS would draw the mesh in the wrong place, so then it is not to find one.
    let key = if frame.is_local() { "map crs " } else { "crs:" };
    lines.extend(crs.definition.iter().map(|crs| format!("{key}{crs}")));
    lines.extend(crs.name.iter().map(|name| format!("crs name {name}")));
    lines.extend(run_lines(header));
    lines.extend(frame_lines(frame));
    lines.iter().map(|line| one_line(line)).collect()
}

impl Sink for PlySink {
    fn begin(&mut self, contents: &Contents<'_>) -> Result<(), SinkError> {
        let Contents { vertices, triangles, attributes, .. } = *contents;
        FORMAT.limits.check(FORMAT.title, self.output.path(), contents)?;
        let mut header = String::from("ply\nformat binary_little_endian 1.0\n");
        for comment in comments(&self.header) {
            header.push_str(&format!("comment {comment}\n"));
        }
        let number = if self.header.frame.single { "float" } else { "double" };
        header.push_str(&format!("element vertex {vertices}\n"));
        ["x", "y", "z"].iter().for_each(|name| header.push_str(&format!("property {number} {name}\n")));
        for Channel { name, number } in attributes {
            let number = match number {
                Number::U8 => "uchar",
                Number::F32 => "float",
                Number::F64 => "double",
            };
            header.push_str(&format!("property {number} {name}\n"));
        }
        header.push_str(&format!("element face {triangles}\nproperty list uchar uint vertex_indices\nend_header\n"));
        self.numbers = attributes.iter().map(|a| a.number).collect();
        self.output.buffer().extend_from_slice(header.as_bytes());
        Ok(())
    }

    fn vertices(&mut self, vertices: &[[f64; 3]], attributes: &[&[f64]]) -> Result<(), SinkError> {
        assert_eq!(attributes.len(), self.numbers.len(), "attributes");
        for (i, vertex) in vertices.iter().enumerate() {
            for value in self.placer.place(self.output.path(), *vertex)? {
                match self.header.frame.single {
                    true => self.output.buffer().extend_from_slice(&(value as f32).to_le_bytes()),
                    false => self.output.buffer().extend_from_slice(&value.to_le_bytes()),
                }
            }
            for (values, number) in attributes.iter().zip(&self.numbers) {
                match number {
                    Number::U8 => self.output.buffer().push(values[i] as u8),
                    Number::F32 => self.output.buffer().extend_from_slice(&(values[i] as f32).to_le_bytes()),
                    Number::F64 => self.output.buffer().extend_from_slice(&values[i].to_le_bytes()),
                }
            }
            self.output.drain()?;
        }
        Ok(())
    }

    fn triangles(&mut self, triangles: &[[u64; 3]], _: &[[[f64; 3]; 3]]) -> Result<(), SinkError> {
        for triangle in triangles {
            let mut face = [3u8; TRIANGLE_BYTES as usize];
            for (bytes, &index) in face[1..].chunks_exact_mut(4).zip(triangle) {
                bytes.copy_from_slice(&(index as u32).to_le_bytes());
            }
            self.output.buffer().extend_from_slice(&face);
            self.output.drain()?;
        }
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<(), SinkError> {
        self.output.commit()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::ReadOptions;

    const VERTICES: [[f64; 3]; 3] = [[0.5, -0.5, 1.25], [2.5, -0.5, -7.0], [0.5, -4.5, 1e-3]];

    fn written(attributes: &[Channel], values: &[&[f64]]) -> (tempfile::TempDir, Vec<u8>) {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("tin.ply");
        let header = Header { notes: vec!["by hand".to_string()], ..Header::default() };
        let mut sink = PlySink::new(StagedFile::create(&path, false, &[]).expect("staged"), header);
        sink.begin(&Contents { vertices: 3, triangles: 1, attributes, ..Contents::default() }).expect("begun");
        sink.vertices(&VERTICES, values).expect("written");
        sink.triangles(&[[0, 2, 1]], &[]).expect("written");
        Box::new(sink).finish().expect("finished");
        let bytes = std::fs::read(path).expect("a file");
        (folder, bytes)
    }

    /// Byte for byte what it has always been.
    #[test]
    fn a_mesh_without_attributes() {
        let mut expected = b"ply\nformat binary_little_endian 1.0\ncomment by hand\nelement vertex 3\nproperty double x\n\
            property double y\nproperty double z\nelement face 1\nproperty list uchar uint vertex_indices\nend_header\n"
            .to_vec();
        VERTICES.iter().flatten().for_each(|v| expected.extend(v.to_le_bytes()));
        expected.extend([3, 0, 0, 0, 0, 2, 0, 0, 0, 1, 0, 0, 0]);
        assert_eq!(written(&[], &[]).1, expected);
    }

    #[test]
    fn attributes_come_back_by_name_from_every_number_type() {
        let channel = |name: &str, number| Channel { name: name.to_string(), number };
        let attributes =
            [channel("red", Number::U8), channel("near_infrared", Number::F32), channel("band_7", Number::F64)];
        let values: [&[f64]; 3] = [&[0.0, 255.0, 7.0], &[0.5, -3.25, 1e10], &[0.1, -1e300, 3.0]];
        let (folder, bytes) = written(&attributes, &values);
        let header = String::from_utf8_lossy(&bytes[..bytes.len().min(400)]).into_owned();
        let lines =
            "property double z\nproperty uchar red\nproperty float near_infrared\nproperty double band_7\nelement face";
        assert!(header.contains(lines), "{header}");
        let path = folder.path().join("tin.ply");
        let mut mesh = crate::formats::open(&path, None, &ReadOptions::default()).expect("a mesh");
        mesh.for_each_vertex_with(&["band_7", "red", "near_infrared"], |index, place, found| {
            let i = index as usize;
            assert_eq!((place, found), (VERTICES[i], &[values[2][i], values[0][i], values[1][i]][..]));
            Ok::<(), crate::formats::ReadError>(())
        })
        .expect("vertices");
    }
}
