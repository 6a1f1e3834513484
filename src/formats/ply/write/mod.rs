//! PLY's writer.

mod comment;

use bytemuck::cast;

use super::FORMAT;
use crate::base::channels::{Channel, Number};
use crate::base::decimal::Decimal;
use crate::base::staged::StagedFile;
use crate::base::{LineEdge, LineType};
use crate::formats::output::{Output, push_decimal, push_place};
use crate::formats::wording::{Placer, frame_lines, one_line, run_lines};
use crate::formats::{Contents, Header, Marks, Needs, Setup, Sink, SinkError};
use comment::pieces;

/// PLY, binary little-endian or text: vertices as x, y, z (`double`, or `float`, as the header's frame says) and a number for
/// every attribute (`uchar`, `float` or `double`), faces as lists of three 32-bit numbers; edges that follow lines, if there are
/// some, as pairs of such numbers in an element `edge`, and a third one, `soft`, where their types are marked: 1 for soft ones, else 0.
/// The header's facts are comments.
///
/// In text, numbers are the shortest decimals that are read again as the same doubles, in single precision as well; a comment
/// says that the last line is ended, so that readers that know notice when a digit is missing.
///
/// No line of the header is longer than 500 bytes, which is more than some readers take: comments go on in the next, which
/// begins with `+`. A CRS that is longer is not where QGIS looks for one; where it is that of the coordinates, it lies beside
/// the mesh as `.prj`, in Esri's dialect.
///
/// Vertices are shared, so the mesh is indexed. Memory: one buffer of a megabyte; for text some two more.
#[derive(Debug)]
pub struct PlySink {
    output: Output,
    header: Header,
    placer: Placer,
    is_text: bool,
    numbers: Vec<Number>,
    edges_have_types: bool,
}

/// Bytes of one triangle in the file.
const TRIANGLE_BYTES: usize = 13;

/// The comment of files in text.
const ENDED: &str = "every line is ended";

impl PlySink {
    /// Writes to `staged`, in binary and every height so that it is read again exactly. There is never a `.prj`.
    pub fn new(staged: StagedFile, header: Header) -> PlySink {
        PlySink::of(staged, Setup { header, ..Setup::default() })
    }

    /// Writes to `staged` as it is asked for.
    ///
    /// # Errors
    /// [`SinkError`] if the `.prj` cannot lie beside it, where there is one.
    pub fn with_setup(mut staged: StagedFile, setup: Setup) -> Result<PlySink, SinkError> {
        let header = &setup.header;
        if let Some(wkt) = header.crs.esri_wkt.as_ref().filter(|_| !header.frame.is_local() && is_long(header)) {
            staged.beside("prj", Some(wkt.clone().into_bytes()))?;
        }
        Ok(PlySink::of(staged, setup))
    }

    fn of(staged: StagedFile, setup: Setup) -> PlySink {
        let placer = Placer::of(&setup);
        let Setup { header, options, .. } = setup;
        PlySink {
            output: Output::new(staged),
            header,
            placer,
            is_text: options.ascii,
            numbers: Vec::new(),
            edges_have_types: false,
        }
    }
}

/// The key by which QGIS finds a CRS: no blank after the colon, which would belong to the CRS.
const CRS: &str = "crs:";

/// Whether the CRS has a definition that is no single comment.
fn is_long(header: &Header) -> bool {
    header.crs.definition.as_ref().is_some_and(|definition| pieces(&format!("{CRS}{definition}")).count() > 1)
}

/// What the file says of itself. Nothing here depends on the machine or the time.
fn comments(header: &Header) -> Vec<String> {
    let Header { made_by, source, crs, frame, .. } = header;
    let mut lines = Vec::new();
    lines.extend(made_by.iter().map(|program| format!("made by {program}")));
    lines.extend(source.iter().map(|name| format!("source {name}")));
    // Where an origin is taken off, QGIS would draw the mesh in the wrong place, so then it is not to find a CRS; nor half of
    // one.
    let key = if frame.is_local() || is_long(header) { "map crs " } else { CRS };
    lines.extend(crs.definition.iter().map(|crs| format!("{key}{crs}")));
    lines.extend(crs.name.iter().map(|name| format!("crs name {name}")));
    lines.extend(run_lines(header));
    lines.extend(frame_lines(frame));
    lines.iter().map(|line| one_line(line)).collect()
}

impl PlySink {
    fn vertices_in_text(&mut self, vertices: &[[f64; 3]], attributes: &[&[f64]]) -> Result<(), SinkError> {
        let (placer, path, numbers) = (self.placer, self.output.path().to_path_buf(), &self.numbers);
        self.output.put_side_by_side(vertices, |text, i, vertex| {
            push_place(text, placer.place(&path, *vertex)?);
            for (values, number) in attributes.iter().zip(numbers) {
                text.push(b' ');
                match number {
                    Number::U8 => push_decimal(text, values[i] as u64),
                    Number::F32 | Number::F64 => Decimal(values[i]).push_to(text),
                }
            }
            text.push(b'\n');
            Ok(())
        })
    }

    /// Vertices that have no attributes are records of one length.
    fn bare_vertices(&mut self, vertices: &[[f64; 3]]) -> Result<(), SinkError> {
        let (placer, path) = (self.placer, self.output.path().to_path_buf());
        let place = |vertex: &[f64; 3]| placer.place(&path, *vertex);
        match self.header.frame.single {
            true => {
                self.output.put_all(vertices, |v| Ok::<[u8; 12], _>(cast(place(v)?.map(|v| (v as f32).to_le_bytes()))))
            }
            false => self.output.put_all(vertices, |v| Ok::<[u8; 24], _>(cast(place(v)?.map(f64::to_le_bytes)))),
        }
    }
}

impl Sink for PlySink {
    fn needs(&self) -> Needs {
        Needs { edges: Marks::Numbers, ..Needs::default() }
    }

    fn begin(&mut self, contents: &Contents<'_>) -> Result<(), SinkError> {
        self.header.complete(contents);
        let Contents { vertices, triangles, attributes, edges, edges_have_types, .. } = *contents;
        FORMAT.limits.check(FORMAT.title, self.output.path(), contents)?;
        let encoding = if self.is_text { "ascii" } else { "binary_little_endian" };
        let mut header = format!("ply\nformat {encoding} 1.0\n");
        let ended = self.is_text.then(|| ENDED.to_string());
        for comment in ended.into_iter().chain(comments(&self.header)) {
            for (i, piece) in pieces(&comment).enumerate() {
                let mark = if i == 0 { "" } else { "+ " };
                header.push_str(&format!("comment {mark}{piece}\n"));
            }
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
        header.push_str(&format!("element face {triangles}\nproperty list uchar uint vertex_indices\n"));
        if edges > 0 {
            header.push_str(&format!("element edge {edges}\nproperty uint vertex1\nproperty uint vertex2\n"));
            header.push_str(if edges_have_types { "property uchar soft\n" } else { "" });
        }
        header.push_str("end_header\n");
        self.numbers = attributes.iter().map(|a| a.number).collect();
        self.edges_have_types = edges_have_types;
        self.output.buffer().extend_from_slice(header.as_bytes());
        Ok(())
    }

    fn vertices(&mut self, vertices: &[[f64; 3]], attributes: &[&[f64]]) -> Result<(), SinkError> {
        assert_eq!(attributes.len(), self.numbers.len(), "attributes");
        if self.is_text {
            return self.vertices_in_text(vertices, attributes);
        }
        if attributes.is_empty() {
            return self.bare_vertices(vertices);
        }
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
        if self.is_text {
            return self.output.put_side_by_side(triangles, |text, _, [a, b, c]| {
                push_numbers(text, &[3, *a, *b, *c]);
                Ok(())
            });
        }
        self.output.put_all(triangles, |triangle| {
            let mut face = [3u8; TRIANGLE_BYTES];
            face[1..].copy_from_slice(triangle.map(|vertex| (vertex as u32).to_le_bytes()).as_flattened());
            Ok(face)
        })
    }

    fn edges(&mut self, edges: &[LineEdge<u64>]) -> Result<(), SinkError> {
        let have_types = self.edges_have_types;
        let soft = |edge: &LineEdge<u64>| u8::from(edge.line_type == LineType::Soft);
        if self.is_text {
            return self.output.put_side_by_side(edges, |text, _, edge| {
                let [from, to] = edge.ends;
                let numbers = [from, to, u64::from(soft(edge))];
                push_numbers(text, if have_types { &numbers } else { &numbers[..2] });
                Ok(())
            });
        }
        let ends = |edge: &LineEdge<u64>| -> [u8; 8] { cast(edge.ends.map(|vertex| (vertex as u32).to_le_bytes())) };
        if !have_types {
            return self.output.put_all(edges, |edge| Ok(ends(edge)));
        }
        self.output.put_all(edges, |edge| {
            let mut record = [soft(edge); 9];
            record[..8].copy_from_slice(&ends(edge));
            Ok(record)
        })
    }

    fn finish(self: Box<Self>) -> Result<(), SinkError> {
        self.output.commit()
    }
}

/// Whole numbers as a line.
fn push_numbers(text: &mut Vec<u8>, numbers: &[u64]) {
    for (i, &number) in numbers.iter().enumerate() {
        if i > 0 {
            text.push(b' ');
        }
        push_decimal(text, number);
    }
    text.push(b'\n');
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::CoordinateFrame;
    use crate::formats::{Crs, ReadOptions, SinkOptions};

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

    fn text() -> Setup {
        let options = SinkOptions { ascii: true, ..SinkOptions::default() };
        Setup { loss: 1e-6, options, ..Setup::default() }
    }

    fn of_setup(setup: Setup, attributes: &[Channel], values: &[&[f64]]) -> (tempfile::TempDir, Vec<u8>) {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("tin.ply");
        let staged = StagedFile::create(&path, false, &[]).expect("staged");
        let mut sink = PlySink::with_setup(staged, setup).expect("a sink");
        sink.begin(&Contents { vertices: 3, triangles: 1, attributes, ..Contents::default() }).expect("begun");
        sink.vertices(&VERTICES, values).expect("written");
        sink.triangles(&[[0, 2, 1]], &[]).expect("written");
        Box::new(sink).finish().expect("finished");
        let bytes = std::fs::read(path).expect("a file");
        (folder, bytes)
    }

    #[test]
    fn a_mesh_in_text() {
        let channel = |name: &str, number| Channel { name: name.to_string(), number };
        let attributes = [channel("red", Number::U8), channel("heat", Number::F32), channel("far", Number::F64)];
        let single = f64::from(0.1f32);
        let values: [&[f64]; 3] = [&[0.0, 255.0, 7.0], &[0.5, single, -0.0], &[0.1, -1e300, f64::NAN]];
        let (folder, bytes) = of_setup(text(), &attributes, &values);
        let expected = "ply\nformat ascii 1.0\ncomment every line is ended\nelement vertex 3\nproperty double x\n\
            property double y\nproperty double z\nproperty uchar red\nproperty float heat\nproperty double far\n\
            element face 1\nproperty list uchar uint vertex_indices\nend_header\n\
            0.5 -0.5 1.25 0 0.5 0.1\n2.5 -0.5 -7 255 0.10000000149011612 -1e300\n0.5 -4.5 0.001 7 -0 NaN\n3 0 2 1\n";
        assert_eq!(String::from_utf8_lossy(&bytes), expected);
        let path = folder.path().join("tin.ply");
        let mut mesh = crate::formats::open(&path, None, &ReadOptions::default()).expect("a mesh");
        assert_eq!((mesh.header(), mesh.attributes()), (&Header::default(), &attributes[..]));
        mesh.for_each_vertex_with(&["red", "heat", "far"], |index, place, found| {
            let i = index as usize;
            let bits = |values: &[f64]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
            assert_eq!((place, bits(found)), (VERTICES[i], bits(&values.map(|of_all| of_all[i]))));
            Ok::<(), crate::formats::ReadError>(())
        })
        .expect("vertices");
    }

    #[test]
    fn text_in_single_precision_has_the_same_numbers_for_all_readers() {
        let frame = CoordinateFrame { single: true, ..CoordinateFrame::PLAIN };
        let (folder, bytes) = of_setup(Setup { header: Header { frame, ..Header::default() }, ..text() }, &[], &[]);
        let file = String::from_utf8_lossy(&bytes).into_owned();
        assert!(file.contains("property float z\n") && file.contains("\n0.5 -4.5 0.0010000000474974513\n"), "{file}");
        let mesh = crate::formats::open(&folder.path().join("tin.ply"), None, &ReadOptions::default());
        assert!(mesh.expect("a mesh").header().frame.single);
    }

    #[test]
    fn text_that_is_cut_off_is_refused() {
        let (folder, whole) = of_setup(text(), &[], &[]);
        let path = folder.path().join("tin.ply");
        for cut in 0..whole.len() {
            std::fs::write(&path, &whole[..cut]).expect("cut");
            let faces = crate::formats::open(&path, None, &ReadOptions::default())
                .and_then(|mut mesh| mesh.for_each_face(|_, _| Ok::<(), crate::formats::ReadError>(())));
            assert!(faces.is_err(), "{cut} of {}", whole.len());
        }
    }

    #[test]
    fn no_line_of_a_header_is_too_long_for_any_reader() {
        let long = |words: &str| words.repeat(1600 / words.len());
        let (wkt, note) = (long("PROJCS[Größe] "), long("by hand "));
        let crs = Crs { definition: Some(wkt.clone()), esri_wkt: Some("PROJCS[…]".to_string()), ..Crs::default() };
        for origin in [(0.0, 0.0), (1.0, 0.0)] {
            let frame = CoordinateFrame { origin, ..CoordinateFrame::PLAIN };
            let header =
                Header { crs: crs.clone(), notes: vec![note.clone(), "+ 1".to_string()], frame, ..Header::default() };
            let (folder, bytes) = of_setup(Setup { header, ..Setup::default() }, &[], &[]);
            let end = bytes.windows(10).position(|w| w == b"end_header").expect("an end");
            assert!(bytes[..end].split(|b| *b == b'\n').all(|line| line.len() <= 500));
            let path = folder.path().join("tin.ply");
            let mesh = crate::formats::open(&path, None, &ReadOptions::default()).expect("a mesh");
            assert_eq!(mesh.header().crs.definition.as_deref(), Some(wkt.trim_end()));
            assert_eq!(mesh.header().notes[0], note.trim_end());
            // QGIS takes what begins so for a CRS, and there is only the half of one.
            assert!(!String::from_utf8_lossy(&bytes[..end]).contains("crs:"));
            let prj = std::fs::read_to_string(path.with_extension("prj")).ok();
            assert_eq!(prj.as_deref(), (origin == (0.0, 0.0)).then_some("PROJCS[…]"));
        }
        // What fits stands where QGIS looks for it, and nothing lies beside it.
        let crs = Crs { definition: Some("EPSG:32633".to_string()), ..crs };
        let (folder, bytes) =
            of_setup(Setup { header: Header { crs, ..Header::default() }, ..Setup::default() }, &[], &[]);
        assert!(String::from_utf8_lossy(&bytes).contains("\ncomment crs:EPSG:32633\n"));
        assert_eq!(folder.path().read_dir().expect("a folder").count(), 1);
    }
}
