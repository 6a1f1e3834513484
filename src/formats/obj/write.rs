//! OBJ's writer.

use std::io::Write;

use super::FORMAT;
use crate::base::decimal::Decimal;
use crate::base::staged::StagedFile;
use crate::formats::output::{Output, push_decimal};
use crate::formats::wording::{facts, placed};
use crate::formats::{Contents, Header, Sink, SinkError};

/// OBJ: `v x y z`, then `f a b c`, numbered from 1; the header's facts are comments.
///
/// Coordinates are the shortest decimals that are read again as the same doubles; in single precision as well, so that a
/// program that reads doubles and one that reads singles have the same numbers. Attributes of vertices are left out. Where
/// coordinates are those of a CRS it lies beside the mesh as `.prj`, in Esri's dialect; beside any other mesh there is no such
/// file, as it would be taken for its CRS.
///
/// The first comment tells how many vertices and triangles there are, and the last line is a comment that ends the mesh: so
/// readers that know notice when something is missing. Memory: one buffer of a megabyte.
#[derive(Debug)]
pub struct ObjSink {
    output: Output,
    header: Header,
    loss: f64,
}

impl ObjSink {
    /// Writes to `staged`. A height may be read again within `loss` of what it is.
    ///
    /// # Errors
    /// [`SinkError`] if the `.prj` cannot lie beside it.
    pub fn new(mut staged: StagedFile, header: Header, loss: f64) -> Result<ObjSink, SinkError> {
        let is_on_the_map = !header.frame.is_local();
        let prj = header.crs.esri_wkt.as_ref().filter(|_| is_on_the_map);
        staged.beside("prj", prj.map(|wkt| wkt.clone().into_bytes()))?;
        Ok(ObjSink { output: Output::new(staged), header, loss })
    }
}

impl Sink for ObjSink {
    fn begin(&mut self, contents: &Contents<'_>) -> Result<(), SinkError> {
        FORMAT.limits.check(FORMAT.title, self.output.path(), contents)?;
        let Contents { vertices, triangles, .. } = contents;
        let mut header = format!("# mesh of {vertices} vertices and {triangles} triangles\n");
        for line in facts(&self.header) {
            // A line that ends in a backslash would go on in the next.
            let end = if line.ends_with('\\') { " " } else { "" };
            header.push_str(&format!("# {line}{end}\n"));
        }
        self.output.buffer().extend_from_slice(header.as_bytes());
        Ok(())
    }

    fn vertices(&mut self, vertices: &[[f64; 3]], _: &[&[f64]]) -> Result<(), SinkError> {
        for vertex in vertices {
            let [x, y, z] = placed(&self.header.frame, self.loss, self.output.path(), *vertex)?;
            writeln!(self.output.buffer(), "v {} {} {}", Decimal(x), Decimal(y), Decimal(z)).expect("memory takes all");
            self.output.drain()?;
        }
        Ok(())
    }

    fn triangles(&mut self, triangles: &[[u64; 3]], _: &[[[f64; 3]; 3]]) -> Result<(), SinkError> {
        for triangle in triangles {
            self.output.buffer().push(b'f');
            for &vertex in triangle {
                self.output.buffer().push(b' ');
                push_decimal(self.output.buffer(), vertex + 1);
            }
            self.output.buffer().push(b'\n');
            self.output.drain()?;
        }
        Ok(())
    }

    fn finish(mut self: Box<Self>) -> Result<(), SinkError> {
        self.output.buffer().extend_from_slice(b"# end of mesh\n");
        self.output.commit()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::CoordinateFrame;
    use crate::formats::Crs;

    fn written(header: Header) -> (String, Option<String>) {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("tin.obj");
        let mut sink =
            ObjSink::new(StagedFile::create(&path, false, &[]).expect("staged"), header, 0.0).expect("a sink");
        let contents = Contents { vertices: 3, triangles: 1, ..Contents::default() };
        sink.begin(&contents).expect("begun");
        sink.vertices(&[[0.5, -0.5, 1.25], [1e-7, -0.0, 1e22], [0.1, 2.0, -7.0]], &[]).expect("written");
        sink.triangles(&[[0, 2, 1]], &[]).expect("written");
        Box::new(sink).finish().expect("finished");
        (std::fs::read_to_string(&path).expect("text"), std::fs::read_to_string(path.with_extension("prj")).ok())
    }

    #[test]
    fn a_mesh_byte_for_byte() {
        let header = Header { made_by: Some("terrabite 1".to_string()), tolerance: Some(0.5), ..Header::default() };
        let expected = "# mesh of 3 vertices and 1 triangles\n# made by terrabite 1\n# max_error 0.5\nv 0.5 -0.5 1.25\n\
                        v 1e-7 -0 1e22\nv 0.1 2 -7\nf 1 3 2\n# end of mesh\n";
        assert_eq!(written(header), (expected.to_string(), None));
    }

    #[test]
    fn only_map_coordinates_have_a_crs_beside_them() {
        let crs = Crs { esri_wkt: Some("PROJCS[…]".to_string()), ..Crs::default() };
        let header = Header { crs, ..Header::default() };
        assert_eq!(written(header.clone()).1.as_deref(), Some("PROJCS[…]"));
        let frame = CoordinateFrame { origin: (0.25, 0.0), ..CoordinateFrame::PLAIN };
        let (text, prj) = written(Header { frame, ..header });
        assert!(prj.is_none() && text.contains("# offset 0.25 0\nv 0.25 -0.5 1.25\n"), "{text}");
    }
}
