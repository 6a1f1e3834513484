//! GLB's writer: plain files stream from front to back, compressed ones are put together at the end.

mod compressed;
mod document;
mod layout;
mod plain;
mod spool;

use crate::base::CoordinateFrame;
use crate::base::staged::StagedFile;
use crate::formats::output::Output;
use crate::formats::wording::Placer;
use crate::formats::{Contents, Header, Needs, Setup, Sink, SinkError};
use compressed::Compressed;
use plain::Plain;

/// GLB: one scene of one node, whose `translation` is the frame's origin, with one mesh; y up, so that x, y, z of the frame
/// stand as x, z, −y. The header's facts are in `asset.extras`.
///
/// Plain files have one primitive; vertices are interleaved, triangles number them in 16 bits where there are at most 65,535,
/// else in 32 bits. Memory: one buffer of a megabyte. With [`crate::formats::Compression`] there is a primitive for
/// every 65,535 vertices or fewer, in the order of triangles: those within one are in another order, and may begin with
/// another corner; vertices that primitives share stand in each, and those of no triangle are lost. Memory: one primitive
/// (some 20 MB); temporary files: all vertices and the compressed mesh.
///
/// A texture is part of the BIN chunk, and the material's base colour.
///
/// A mesh without triangles is a node without a mesh.
pub struct GlbSink(Kind);

enum Kind {
    Plain(Box<Plain>),
    Compressed(Box<Compressed>),
}

impl std::fmt::Debug for GlbSink {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("GlbSink").finish_non_exhaustive()
    }
}

impl GlbSink {
    /// Writes to `staged`, in single precision whatever the header's frame says.
    pub fn new(staged: StagedFile, setup: Setup) -> GlbSink {
        let frame = CoordinateFrame { single: true, ..setup.header.frame };
        let setup = Setup { header: Header { frame, ..setup.header }, ..setup };
        let placer = Placer::of(&setup);
        let Setup { header, options, texture, temp_dir, cancel, .. } = setup;
        let output = Output::new(staged);
        GlbSink(match options.compression {
            None => Kind::Plain(Box::new(Plain::new(output, header, placer, texture))),
            Some(compression) => Kind::Compressed(Box::new(Compressed::new(
                compression,
                output,
                header,
                placer,
                texture,
                temp_dir.as_deref(),
                cancel,
            ))),
        })
    }
}

impl Sink for GlbSink {
    fn needs(&self) -> Needs {
        Needs { bounds: matches!(self.0, Kind::Plain(_)), ..Needs::default() }
    }

    fn begin(&mut self, contents: &Contents<'_>) -> Result<(), SinkError> {
        match &mut self.0 {
            Kind::Plain(plain) => plain.begin(contents),
            Kind::Compressed(compressed) => compressed.begin(contents),
        }
    }

    fn vertices(&mut self, vertices: &[[f64; 3]], attributes: &[&[f64]]) -> Result<(), SinkError> {
        match &mut self.0 {
            Kind::Plain(plain) => plain.vertices(vertices, attributes),
            Kind::Compressed(compressed) => compressed.vertices(vertices, attributes),
        }
    }

    fn triangles(&mut self, triangles: &[[u64; 3]], _: &[[[f64; 3]; 3]]) -> Result<(), SinkError> {
        match &mut self.0 {
            Kind::Plain(plain) => plain.triangles(triangles),
            Kind::Compressed(compressed) => compressed.triangles(triangles),
        }
    }

    fn finish(self: Box<Self>) -> Result<(), SinkError> {
        match self.0 {
            Kind::Plain(plain) => plain.finish(),
            Kind::Compressed(compressed) => compressed.finish(),
        }
    }
}
