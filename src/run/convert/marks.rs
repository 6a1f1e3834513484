//! Edges that follow lines, from one mesh to another.

use super::BATCH;
use crate::base::LineEdge;
use crate::base::external::{Scratch, StoreWriter};
use crate::formats::{MeshReader, Sink};
use crate::run::RunError;

/// Hands on edges as numbers of vertices.
pub(super) fn write_numbers(sink: &mut dyn Sink, reader: &mut dyn MeshReader) -> Result<(), RunError> {
    let mut edges = Vec::new();
    reader.for_each_edge(|_, edge| {
        edges.push(edge);
        if edges.len() == BATCH {
            sink.edges(&edges)?;
            edges.clear();
        }
        Ok::<(), RunError>(())
    })?;
    Ok(sink.edges(&edges)?)
}

/// Hands on edges as the places of their ends, which `place` makes of what the mesh has.
pub(super) fn write_places(
    sink: &mut dyn Sink,
    reader: &mut dyn MeshReader,
    scratch: &Scratch,
    place: impl Fn([f64; 3]) -> [f64; 3],
) -> Result<(), RunError> {
    let mut vertices = StoreWriter::<3>::new(scratch)?;
    reader.for_each_vertex(|_, vertex| Ok::<(), RunError>(vertices.push(place(vertex).map(f64::to_bits))?))?;
    let mut vertices = vertices.finish()?;
    let mut edges = Vec::new();
    reader.for_each_edge(|_, edge| {
        let mut ends = [[0.0; 3]; 2];
        for (end, vertex) in ends.iter_mut().zip(edge.ends) {
            *end = vertices.get(vertex)?.map(f64::from_bits);
        }
        edges.push(LineEdge { ends, line_type: edge.line_type });
        if edges.len() == BATCH {
            sink.lines(&edges)?;
            edges.clear();
        }
        Ok::<(), RunError>(())
    })?;
    Ok(sink.lines(&edges)?)
}
