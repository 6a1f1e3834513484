//! A GLB that is compressed by meshoptimizer's codecs, without loss.

use std::path::Path;

use rustc_hash::FxHashMap;

use super::super::FORMAT;
use super::document::{Buffers, Part, Stretch, document, front, too_long};
use super::layout::Layout;
use super::spool::Spool;
use crate::base::Texture;
use crate::base::control::CancelToken;
use crate::base::external::Scratch;
use crate::formats::output::Output;
use crate::formats::wording::Placer;
use crate::formats::{Compression, Contents, Header, SinkError};

/// The most vertices of a primitive: they are numbered in 16 bits, and the largest number restarts a primitive.
const VERTICES: usize = u16::MAX as usize;

/// The most triangles of a primitive; usual ones have twice as many as vertices.
const TRIANGLES: usize = 4 * VERTICES;

/// Vertices that the quick order takes a cache to hold.
const CACHE: u32 = 16;

/// Vertices whose records, in the mesh's order, are read at once.
const WINDOW: u64 = 1024;

/// Vertices wait in a temporary file until triangles name them; what is compressed waits in another until its length is
/// known.
pub(super) struct Compressed {
    compression: Compression,
    output: Output,
    header: Header,
    placer: Placer,
    texture: Option<Texture>,
    scratch: Scratch,
    layout: Layout,
    records: Spool,
    chunk: Chunk,
    bin: Spool,
    /// Bytes of what is compressed.
    unpacked: u64,
    parts: Vec<Part>,
}

/// The triangles of the next primitive.
#[derive(Default)]
struct Chunk {
    /// Numbers in the primitive, by those in the mesh.
    numbers: FxHashMap<u64, u32>,
    /// The other way round.
    vertices: Vec<u64>,
    corners: Vec<u32>,
}

impl Compressed {
    pub(super) fn new(
        compression: Compression,
        output: Output,
        header: Header,
        placer: Placer,
        texture: Option<Texture>,
        temp_dir: Option<&Path>,
        cancel: CancelToken,
    ) -> Compressed {
        Compressed {
            compression,
            output,
            header,
            placer,
            texture,
            scratch: Scratch::new(temp_dir, cancel),
            layout: Layout::default(),
            records: Spool::default(),
            chunk: Chunk::default(),
            bin: Spool::default(),
            unpacked: 0,
            parts: Vec::new(),
        }
    }

    pub(super) fn begin(&mut self, contents: &Contents<'_>) -> Result<(), SinkError> {
        self.header.complete(contents);
        FORMAT.limits.check(FORMAT.title, self.output.path(), contents)?;
        self.layout = Layout::new(self.output.path(), contents, self.texture.is_some())?;
        Ok(())
    }

    pub(super) fn vertices(&mut self, vertices: &[[f64; 3]], attributes: &[&[f64]]) -> Result<(), SinkError> {
        for (i, vertex) in vertices.iter().enumerate() {
            let place = self.placer.place(self.output.path(), *vertex)?;
            let at = self.texture.as_ref().map_or([0.0; 2], |texture| texture.at(vertex[0], vertex[1]));
            self.layout.append(self.records.buffer(), place, at, attributes, i);
            self.records.drain(&self.scratch)?;
        }
        Ok(())
    }

    pub(super) fn triangles(&mut self, triangles: &[[u64; 3]]) -> Result<(), SinkError> {
        for triangle in triangles {
            if self.chunk.vertices.len() + 3 > VERTICES || self.chunk.corners.len() == 3 * TRIANGLES {
                self.end_chunk()?;
            }
            self.chunk.push(triangle);
        }
        Ok(())
    }

    /// Makes a primitive of the triangles that have come.
    fn end_chunk(&mut self) -> Result<(), SinkError> {
        let chunk = std::mem::take(&mut self.chunk);
        if chunk.corners.is_empty() {
            return Ok(());
        }
        let (vertices, corners) = chunk.in_cache_order(self.compression);
        let records = self.records_of(&vertices)?;
        let stride = self.layout.stride as u64;
        let (min, max) = extent(&records, self.layout.stride);
        if !min.iter().chain(&max).all(|v| v.is_finite()) {
            return Err(SinkError::Unfit {
                path: self.output.path().to_path_buf(),
                expected: "coordinates that are finite in single precision".to_string(),
                found: format!("vertices between {min:?} and {max:?} (y up)"),
            });
        }
        let failed = |e: meshopt::Error| SinkError::Library {
            path: self.output.path().to_path_buf(),
            message: format!("meshoptimizer: {e}"),
        };
        let packed_vertices = encoded(&records, self.layout.stride).map_err(failed)?;
        let packed_corners = meshopt::encode_index_buffer(&corners, vertices.len()).map_err(failed)?;
        let vertices = self.stretch(vertices.len() as u64, stride, &packed_vertices)?;
        let corners = self.stretch(corners.len() as u64, 2, &packed_corners)?;
        self.parts.push(Part { vertices, corners, corner_bytes: 2, min, max });
        Ok(())
    }

    /// The records of these vertices, one after the other.
    fn records_of(&mut self, vertices: &[u64]) -> Result<Vec<u8>, SinkError> {
        let stride = self.layout.stride;
        self.records.flush(&self.scratch)?;
        let mut order: Vec<(u64, usize)> = vertices.iter().copied().zip(0..).collect();
        order.sort_unstable();
        let (mut records, mut piece) = (vec![0; vertices.len() * stride], Vec::new());
        let mut rest = order.as_slice();
        while let Some(&(first, _)) = rest.first() {
            let (near, further) = rest.split_at(rest.partition_point(|(vertex, _)| vertex - first < WINDOW));
            let last = near[near.len() - 1].0;
            piece.resize((last - first + 1) as usize * stride, 0);
            self.records.read(&self.scratch, first * stride as u64, &mut piece)?;
            for &(vertex, place) in near {
                let at = (vertex - first) as usize * stride;
                records[place * stride..][..stride].copy_from_slice(&piece[at..at + stride]);
            }
            rest = further;
        }
        Ok(records)
    }

    /// Takes the bytes of compressed elements, and fills them up to a multiple of 4.
    fn stretch(&mut self, count: u64, bytes: u64, packed: &[u8]) -> Result<Stretch, SinkError> {
        let stretch = Stretch { count, offset: self.unpacked, packed: Some((self.bin.length(), packed.len() as u64)) };
        self.unpacked = (self.unpacked + count * bytes).next_multiple_of(4);
        self.bin.buffer().extend_from_slice(packed);
        let padding = [0; 4];
        let aligned = self.bin.length().next_multiple_of(4) - self.bin.length();
        self.bin.buffer().extend_from_slice(&padding[..aligned as usize]);
        self.bin.drain(&self.scratch)?;
        match self.bin.length() > u64::from(u32::MAX) {
            true => Err(too_long(self.output.path(), self.bin.length())),
            false => Ok(stretch),
        }
    }

    pub(super) fn finish(mut self) -> Result<(), SinkError> {
        self.end_chunk()?;
        let mut texture = None;
        if let Some(image) = self.texture.as_ref().filter(|_| !self.parts.is_empty()) {
            let (begin, length) = (self.bin.length(), image.jpeg.len());
            texture = Some((begin, length as u64));
            self.bin.buffer().extend_from_slice(&image.jpeg);
            let padding = [0; 4];
            self.bin.buffer().extend_from_slice(&padding[..length.next_multiple_of(4) - length]);
        }
        let bin = self.bin.length();
        let buffers = Buffers { bin, unpacked: Some(self.unpacked), texture };
        let json = document(&self.header, &self.layout, &self.parts, buffers);
        let front = front(self.output.path(), &json, bin)?;
        self.output.buffer().extend_from_slice(&front);
        self.bin.flush(&self.scratch)?;
        let mut piece = vec![0; 64 << 10];
        for offset in (0..bin).step_by(piece.len()) {
            let count = (bin - offset).min(piece.len() as u64) as usize;
            self.bin.read(&self.scratch, offset, &mut piece[..count])?;
            self.output.buffer().extend_from_slice(&piece[..count]);
            self.output.drain()?;
        }
        self.output.commit()
    }
}

impl Chunk {
    fn push(&mut self, triangle: &[u64; 3]) {
        for &vertex in triangle {
            let next = self.vertices.len() as u32;
            let number = *self.numbers.entry(vertex).or_insert(next);
            if number == next {
                self.vertices.push(vertex);
            }
            self.corners.push(number);
        }
    }

    /// The vertices in the order in which triangles name them first, and the corners of triangles, in an order in which those
    /// that share vertices are near to each other.
    fn in_cache_order(self, compression: Compression) -> (Vec<u64>, Vec<u32>) {
        let count = self.vertices.len();
        let mut corners = match compression {
            Compression::Meshopt => meshopt::optimize_vertex_cache(&self.corners, count),
            Compression::QuickMeshopt => meshopt::optimize_vertex_cache_fifo(&self.corners, count, CACHE),
        };
        let mut new = vec![u32::MAX; self.vertices.len()];
        let mut order = Vec::with_capacity(self.vertices.len());
        for corner in &mut corners {
            let number = &mut new[*corner as usize];
            if *number == u32::MAX {
                *number = order.len() as u32;
                order.push(self.vertices[*corner as usize]);
            }
            *corner = *number;
        }
        (order, corners)
    }
}

/// Between what the positions of records lie, which begin with them.
fn extent(records: &[u8], stride: usize) -> ([f32; 3], [f32; 3]) {
    let (mut min, mut max) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for record in records.chunks_exact(stride) {
        for (i, bytes) in record[..12].as_chunks::<4>().0.iter().enumerate() {
            let value = f32::from_le_bytes(*bytes);
            (min[i], max[i]) = (min[i].min(value), max[i].max(value));
        }
    }
    (min, max)
}

/// Records of `stride` bytes, a multiple of 4 and at most 252, in the version of the codec that the extension has.
fn encoded(records: &[u8], stride: usize) -> Result<Vec<u8>, meshopt::Error> {
    fn encode<const N: usize>(records: &[u8]) -> Result<Vec<u8>, meshopt::Error> {
        meshopt::encode_vertex_buffer_level(records.as_chunks::<N>().0, 2, Some(0))
    }
    macro_rules! of_stride {
        ($($bytes:literal)*) => {
            match stride {
                $($bytes => encode::<$bytes>(records),)*
                _ => unreachable!("records of {stride} bytes"),
            }
        };
    }
    of_stride!(12 16 20 24 28 32 36 40 44 48 52 56 60 64 68 72 76 80 84 88 92 96 100 104 108 112 116 120 124 128 132 136
        140 144 148 152 156 160 164 168 172 176 180 184 188 192 196 200 204 208 212 216 220 224 228 232 236 240 244 248 252)
}
