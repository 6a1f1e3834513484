//! The mesh, triangle by triangle in raster coordinates, in bounded memory.

use std::fs::File;
use std::io::{BufWriter, Read, Seek, SeekFrom, Write};

use super::PreviewError;
use crate::base::control::{Cancelled, Control};
use crate::base::{CoordinateFrame, GeoTransform, Window};
use crate::formats::MeshReader;

/// A corner: column and row of the raster (whole numbers at samples), height, and the colour, black if not asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Corner {
    pub(super) column: f64,
    pub(super) row: f64,
    pub(super) height: f64,
    pub(super) colour: [u8; 3],
}

/// A triangle, in the file's order.
pub(super) type Triangle = [Corner; 3];

/// Calls `visit` for every triangle whose bounds touch the window, in the file's order; `colours` names the attributes
/// that are its corners' colours, as red, green and blue from 0 to 255, or nothing.
///
/// Vertices go through a temporary file of 32 bytes each and come back by blocks, of which [`BLOCKS`] are kept: faces
/// near each other in the file mostly name vertices near each other.
pub(super) fn for_each_triangle(
    mesh: &mut dyn MeshReader,
    colours: &[&str],
    transform: &GeoTransform,
    window: Window,
    control: &Control,
    mut visit: impl FnMut(&Triangle),
) -> Result<u64, PreviewError> {
    let mut vertices = Vertices::spool(mesh, colours, transform, control)?;
    let path = mesh.path().to_path_buf();
    let io = |source| PreviewError::io(&path, "its vertices cannot be read back from the temporary file", source);
    let mut seen = 0;
    mesh.for_each_face(|index, corners| {
        check(control, index)?;
        let triangle = [
            vertices.get(corners[0]).map_err(io)?,
            vertices.get(corners[1]).map_err(io)?,
            vertices.get(corners[2]).map_err(io)?,
        ];
        if touches(&triangle, window) {
            seen += 1;
            visit(&triangle);
        }
        Ok::<(), PreviewError>(())
    })?;
    Ok(seen)
}

fn check(control: &Control, index: u64) -> Result<(), Cancelled> {
    if index.is_multiple_of(65536) { control.cancel.check() } else { Ok(()) }
}

fn touches(triangle: &Triangle, window: Window) -> bool {
    let (right, bottom) = (window.column + window.width - 1, window.row + window.height - 1);
    !(triangle.iter().all(|c| c.column < window.column as f64)
        || triangle.iter().all(|c| c.column > right as f64)
        || triangle.iter().all(|c| c.row < window.row as f64)
        || triangle.iter().all(|c| c.row > bottom as f64))
}

/// From map coordinates to column and row. Vertices written by terrabite lie on quarter cells, which are found
/// exactly; those of other meshes are where they are.
fn place(transform: &GeoTransform, frame: &CoordinateFrame, [x, y, height]: [f64; 3], colour: [u8; 3]) -> Corner {
    let height = frame.height(height);
    if let Some((lx, ly)) = frame.lattice(transform, (x, y)) {
        return Corner { column: lx as f64 / 4.0, row: ly as f64 / 4.0, height, colour };
    }
    let (x, y) = frame.on_the_map((x, y));
    let (column, row) = transform.sample_coordinates(x, y);
    Corner { column, row, height, colour }
}

/// Bytes of a corner in the temporary file.
const RECORD: usize = 32;
/// Corners in one block.
const PER_BLOCK: usize = 1024;
/// Blocks kept: 32 MiB.
const BLOCKS: usize = 1024;

struct Vertices {
    file: File,
    count: u64,
    /// Block `b` may only be kept in place `b % BLOCKS`.
    cache: Vec<Option<(u64, Vec<Corner>)>>,
}

impl Vertices {
    fn spool(
        mesh: &mut dyn MeshReader,
        colours: &[&str],
        transform: &GeoTransform,
        control: &Control,
    ) -> Result<Vertices, PreviewError> {
        let path = mesh.path().to_path_buf();
        let io = |source| PreviewError::io(&path, "its vertices cannot be put into a temporary file", source);
        let frame = mesh.header().frame;
        let mut out = BufWriter::with_capacity(1 << 18, tempfile::tempfile().map_err(io)?);
        mesh.for_each_vertex_with(colours, |index, xyz, attributes| {
            check(control, index)?;
            let mut colour = [0; 3];
            colour.iter_mut().zip(attributes).for_each(|(c, v)| *c = v.round().clamp(0.0, 255.0) as u8);
            let Corner { column, row, height, colour } = place(transform, &frame, xyz, colour);
            let mut record = [0; RECORD];
            record[24..27].copy_from_slice(&colour);
            for (bytes, value) in record.chunks_exact_mut(8).zip([column, row, height]) {
                bytes.copy_from_slice(&value.to_ne_bytes());
            }
            out.write_all(&record).map_err(io)
        })?;
        let file = out.into_inner().map_err(|e| io(e.into_error()))?;
        Ok(Vertices { file, count: mesh.vertex_count(), cache: vec![None; BLOCKS] })
    }

    fn get(&mut self, index: u64) -> std::io::Result<Corner> {
        let (block, within) = (index / PER_BLOCK as u64, (index % PER_BLOCK as u64) as usize);
        let slot = (block % BLOCKS as u64) as usize;
        if let Some((held, corners)) = &self.cache[slot]
            && *held == block
        {
            return Ok(corners[within]);
        }
        let corners = self.load(block)?;
        let corner = corners[within];
        self.cache[slot] = Some((block, corners));
        Ok(corner)
    }

    fn load(&mut self, block: u64) -> std::io::Result<Vec<Corner>> {
        let first = block * PER_BLOCK as u64;
        let count = (self.count - first).min(PER_BLOCK as u64) as usize;
        let mut bytes = vec![0; count * RECORD];
        self.file.seek(SeekFrom::Start(first * RECORD as u64))?;
        self.file.read_exact(&mut bytes)?;
        let value = |b: &[u8]| f64::from_ne_bytes(b.try_into().expect("eight bytes"));
        let corner = |r: &[u8]| Corner {
            column: value(&r[..8]),
            row: value(&r[8..16]),
            height: value(&r[16..24]),
            colour: [r[24], r[25], r[26]],
        };
        Ok(bytes.chunks_exact(RECORD).map(corner).collect())
    }
}
