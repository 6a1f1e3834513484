//! OBJ's writer.

use std::io::Write;
use std::path::Path;

use super::FORMAT;
use crate::base::Texture;
use crate::base::staged::StagedFile;
use crate::formats::output::{Output, push_decimal, push_place};
use crate::formats::wording::{Placer, facts};
use crate::formats::{Contents, Header, Setup, Sink, SinkError};

/// OBJ: `v x y z`, then `f a b c`, numbered from 1; the header's facts are comments.
///
/// Coordinates are the shortest decimals that are read again as the same doubles; in single precision as well, so that a
/// program that reads doubles and one that reads singles have the same numbers. Attributes of vertices are left out. Where
/// coordinates are those of a CRS it lies beside the mesh as `.prj`, in Esri's dialect; beside any other mesh there is no such
/// file, as it would be taken for its CRS.
///
/// The first comment tells how many vertices and triangles there are, and the last line is a comment that ends the mesh: so
/// readers that know notice when something is missing. Memory: three megabytes of buffers.
#[derive(Debug)]
pub struct ObjSink {
    output: Output,
    header: Header,
    placer: Placer,
    has_normals: bool,
    texture: Option<Texture>,
}

/// What the material is called.
const MATERIAL: &str = "texture";

impl ObjSink {
    /// Writes to `staged`, as the setup says.
    ///
    /// # Errors
    /// [`SinkError`] if the `.prj` cannot lie beside it.
    pub fn new(mut staged: StagedFile, setup: Setup) -> Result<ObjSink, SinkError> {
        let placer = Placer::of(&setup);
        let Setup { header, texture, .. } = setup;
        let is_on_the_map = !header.frame.is_local();
        let prj = header.crs.esri_wkt.as_ref().filter(|_| is_on_the_map);
        staged.beside("prj", prj.map(|wkt| wkt.clone().into_bytes()))?;
        if let Some(texture) = &texture {
            let image = staged.path().with_extension("jpg");
            let material = format!("newmtl {MATERIAL}\nKd 1 1 1\nmap_Kd {}\n", file_name(&image));
            staged.beside("mtl", Some(material.into_bytes()))?;
            staged.beside("jpg", Some(texture.jpeg.to_vec()))?;
        }
        Ok(ObjSink { output: Output::new(staged), header, placer, has_normals: false, texture })
    }
}

impl Sink for ObjSink {
    fn begin(&mut self, contents: &Contents<'_>) -> Result<(), SinkError> {
        self.header.complete(contents);
        FORMAT.limits.check(FORMAT.title, self.output.path(), contents)?;
        let Contents { vertices, triangles, has_normals, .. } = *contents;
        self.has_normals = has_normals;
        let mut header = format!("# mesh of {vertices} vertices and {triangles} triangles\n");
        for line in facts(&self.header) {
            // A line that ends in a backslash would go on in the next.
            let end = if line.ends_with('\\') { " " } else { "" };
            header.push_str(&format!("# {line}{end}\n"));
        }
        if self.texture.is_some() {
            let library = file_name(&self.output.path().with_extension("mtl"));
            header.push_str(&format!("mtllib {library}\nusemtl {MATERIAL}\n"));
        }
        self.output.buffer().extend_from_slice(header.as_bytes());
        Ok(())
    }

    fn vertices(&mut self, vertices: &[[f64; 3]], attributes: &[&[f64]]) -> Result<(), SinkError> {
        let normals = if self.has_normals { &attributes[attributes.len() - 3..] } else { &[] };
        let (placer, path, texture) = (self.placer, self.output.path().to_path_buf(), &self.texture);
        self.output.put_side_by_side(vertices, |text, i, vertex| {
            text.extend_from_slice(b"v ");
            push_place(text, placer.place(&path, *vertex)?);
            text.push(b'\n');
            if let Some(texture) = texture {
                // On the map, and counted from the bottom.
                let [u, v] = texture.at(vertex[0], vertex[1]).map(|share| share as f32);
                writeln!(text, "vt {u} {}", 1.0 - v).expect("memory takes all");
            }
            if let [nx, ny, nz] = normals {
                // As short as singles are.
                let [nx, ny, nz] = [nx[i], ny[i], nz[i]].map(|n| n as f32);
                writeln!(text, "vn {nx} {ny} {nz}").expect("memory takes all");
            }
            Ok(())
        })
    }

    fn triangles(&mut self, triangles: &[[u64; 3]], _: &[[[f64; 3]; 3]]) -> Result<(), SinkError> {
        // Each vertex has one of each, with its number.
        let further: &[&[u8]] = match (self.texture.is_some(), self.has_normals) {
            (false, false) => &[],
            (true, false) => &[b"/"],
            (false, true) => &[b"//"],
            (true, true) => &[b"/", b"/"],
        };
        self.output.put_side_by_side(triangles, |text, _, triangle| {
            text.push(b'f');
            for &vertex in triangle {
                text.push(b' ');
                push_decimal(text, vertex + 1);
                for slash in further {
                    text.extend_from_slice(slash);
                    push_decimal(text, vertex + 1);
                }
            }
            text.push(b'\n');
            Ok(())
        })
    }

    fn finish(mut self: Box<Self>) -> Result<(), SinkError> {
        self.output.buffer().extend_from_slice(b"# end of mesh\n");
        self.output.commit()
    }
}

/// What a file is called, without its folders.
fn file_name(path: &Path) -> String {
    path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
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
            ObjSink::new(StagedFile::create(&path, false, &[]).expect("staged"), Setup { header, ..Setup::default() })
                .expect("a sink");
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
    fn a_texture_lies_beside_it() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("tin.obj");
        let jpeg = std::sync::Arc::new(vec![1, 2, 3]);
        let texture = Some(Texture { jpeg, extent: [0.0, 10.0, 4.0, 30.0] });
        let staged = StagedFile::create(&path, false, &[]).expect("staged");
        let mut sink = ObjSink::new(staged, Setup { texture, ..Setup::default() }).expect("a sink");
        let normals = ["nx", "ny", "nz"].map(|name| crate::base::channels::Channel {
            name: name.to_string(),
            number: crate::base::channels::Number::F32,
        });
        let contents =
            Contents { vertices: 3, triangles: 1, attributes: &normals, has_normals: true, ..Contents::default() };
        sink.begin(&contents).expect("begun");
        let up = [[0.0; 3], [0.0; 3], [1.0; 3]];
        let vertices = [[0.0, 10.0, 5.0], [4.0, 10.0, 5.0], [1.0, 25.0, 5.0]];
        sink.vertices(&vertices, &[&up[0], &up[1], &up[2]]).expect("written");
        sink.triangles(&[[0, 1, 2]], &[]).expect("written");
        Box::new(sink).finish().expect("finished");
        let expected = "# mesh of 3 vertices and 1 triangles\nmtllib tin.mtl\nusemtl texture\nv 0 10 5\nvt 0 0\nvn 0 0 1\n\
                        v 4 10 5\nvt 1 0\nvn 0 0 1\nv 1 25 5\nvt 0.25 0.75\nvn 0 0 1\nf 1/1/1 2/2/2 3/3/3\n# end of mesh\n";
        assert_eq!(std::fs::read_to_string(&path).expect("text"), expected);
        let material = std::fs::read_to_string(path.with_extension("mtl")).expect("a material");
        assert_eq!(material, "newmtl texture\nKd 1 1 1\nmap_Kd tin.jpg\n");
        assert_eq!(std::fs::read(path.with_extension("jpg")).expect("an image"), [1, 2, 3]);
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
