//! 2DM's writer.

use super::FORMAT;
use crate::base::staged::StagedFile;
use crate::formats::output::{Output, push_decimal, push_place};
use crate::formats::wording::{Placer, facts};
use crate::formats::{Contents, Header, Setup, Sink, SinkError};

/// 2DM: `ND i x y z`, then `E3T i a b c 1`, both numbered from 1 without a gap; the header's facts are comments.
///
/// Coordinates are the shortest decimals that are read again as the same doubles. Attributes of vertices are left out; the last
/// number of an element is its material, which SMS wants.
///
/// The second line tells how many nodes and elements there are, and the last line is a comment that ends the mesh: so readers
/// that know notice when something is missing. Memory: three megabytes of buffers.
#[derive(Debug)]
pub struct Sms2dmSink {
    output: Output,
    header: Header,
    placer: Placer,
    nodes: u64,
    elements: u64,
}

impl Sms2dmSink {
    /// Writes to `staged`, as the setup says.
    pub fn new(staged: StagedFile, setup: Setup) -> Sms2dmSink {
        let placer = Placer::of(&setup);
        let header = setup.header;
        Sms2dmSink { output: Output::new(staged), header, placer, nodes: 0, elements: 0 }
    }
}

impl Sink for Sms2dmSink {
    fn begin(&mut self, contents: &Contents<'_>) -> Result<(), SinkError> {
        self.header.complete(contents);
        FORMAT.limits.check(FORMAT.title, self.output.path(), contents)?;
        let Contents { vertices, triangles, .. } = contents;
        let mut head = format!("MESH2D\n# mesh of {vertices} nodes and {triangles} elements\n");
        facts(&self.header).iter().for_each(|line| head.push_str(&format!("# {line}\n")));
        head.push_str("NUM_MATERIALS_PER_ELEM 1\n");
        self.output.buffer().extend_from_slice(head.as_bytes());
        Ok(())
    }

    fn vertices(&mut self, vertices: &[[f64; 3]], _: &[&[f64]]) -> Result<(), SinkError> {
        let (placer, path, before) = (self.placer, self.output.path().to_path_buf(), self.nodes);
        self.nodes += vertices.len() as u64;
        self.output.put_side_by_side(vertices, |text, i, vertex| {
            text.extend_from_slice(b"ND ");
            push_decimal(text, before + i as u64 + 1);
            text.push(b' ');
            push_place(text, placer.place(&path, *vertex)?);
            text.push(b'\n');
            Ok(())
        })
    }

    fn triangles(&mut self, triangles: &[[u64; 3]], _: &[[[f64; 3]; 3]]) -> Result<(), SinkError> {
        let before = self.elements;
        self.elements += triangles.len() as u64;
        self.output.put_side_by_side(triangles, |text, i, triangle| {
            text.extend_from_slice(b"E3T ");
            push_decimal(text, before + i as u64 + 1);
            for &vertex in triangle {
                text.push(b' ');
                push_decimal(text, vertex + 1);
            }
            text.extend_from_slice(b" 1\n");
            Ok(())
        })
    }

    fn finish(mut self: Box<Self>) -> Result<(), SinkError> {
        self.output.buffer().extend_from_slice(b"# end of mesh\n");
        self.output.commit()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mesh_byte_for_byte() {
        let folder = crate::testing::folder();
        let path = folder.path().join("tin.2dm");
        let header = Header { made_by: Some("terrabite 1".to_string()), tolerance: Some(0.5), ..Header::default() };
        let mut sink = Sms2dmSink::new(
            StagedFile::create(&path, false, &[]).expect("staged"),
            Setup { header, ..Setup::default() },
        );
        sink.begin(&Contents { vertices: 3, triangles: 2, ..Contents::default() }).expect("begun");
        sink.vertices(&[[0.5, -0.5, 1.25], [1e-7, -0.0, 1e22]], &[]).expect("written");
        sink.vertices(&[[0.1, 2.0, -7.0]], &[]).expect("written");
        sink.triangles(&[[0, 2, 1]], &[]).expect("written");
        sink.triangles(&[[2, 0, 1]], &[]).expect("written");
        Box::new(sink).finish().expect("finished");
        let expected = "MESH2D\n# mesh of 3 nodes and 2 elements\n# made by terrabite 1\n# max_error 0.5\n\
                        NUM_MATERIALS_PER_ELEM 1\nND 1 0.5 -0.5 1.25\nND 2 1e-7 -0 1e22\nND 3 0.1 2 -7\nE3T 1 1 3 2 1\n\
                        E3T 2 3 1 2 1\n# end of mesh\n";
        assert_eq!(std::fs::read_to_string(&path).expect("text"), expected);
    }
}
