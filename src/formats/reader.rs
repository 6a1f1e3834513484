//! Readers: a mesh file of any format, pass by pass.

use std::ops::ControlFlow;
use std::path::Path;

use super::{Header, ReadError};
use crate::base::LineEdge;
use crate::base::channels::Channel;

/// Is handed a vertex: its index, x, y and z as the file has them, and the attributes that were asked for.
pub type VertexVisitor<'a> = dyn FnMut(u64, [f64; 3], &[f64]) -> ControlFlow<()> + 'a;

/// Is handed a face: its index and its three vertices.
pub type FaceVisitor<'a> = dyn FnMut(u64, [u64; 3]) -> ControlFlow<()> + 'a;

/// Is handed an edge that follows a line: its index, and its two vertices.
pub type EdgeVisitor<'a> = dyn FnMut(u64, LineEdge<u64>) -> ControlFlow<()> + 'a;

/// A mesh file, open for reading.
///
/// Memory use is constant, because a pass hands on what it reads and keeps nothing. Passes may be repeated, in any order. The
/// token that the file was opened with ends a pass within some thousand records, whatever they are.
pub trait MeshReader: Send {
    /// The path it was opened by.
    fn path(&self) -> &Path;

    /// How many vertices there are.
    fn vertex_count(&self) -> u64;

    /// How many faces there are.
    fn face_count(&self) -> u64;

    /// What the file says of itself; with [`Header::frame`] its coordinates become those of the map.
    fn header(&self) -> &Header;

    /// What vertices have beside x, y and z: names, and the narrowest number types that hold every value of the file's
    /// (64-bit integers are rounded to doubles).
    fn attributes(&self) -> &[Channel];

    /// Hands every vertex to `visit`, in order, until it breaks: coordinates may be anything a double can be. Attributes are
    /// named as [`MeshReader::attributes`] has them.
    ///
    /// # Errors
    /// [`ReadError`], [`ReadError::NoAttribute`] among them.
    fn vertices(&mut self, attributes: &[&str], visit: &mut VertexVisitor<'_>) -> Result<(), ReadError>;

    /// Hands every face to `visit`, in order, until it breaks: each vertex is below [`MeshReader::vertex_count`]; they may
    /// repeat.
    ///
    /// # Errors
    /// [`ReadError`], also for a face that is no triangle.
    fn faces(&mut self, visit: &mut FaceVisitor<'_>) -> Result<(), ReadError>;

    /// How many edges are marked as following lines.
    fn edge_count(&self) -> u64 {
        0
    }

    /// Whether their types are marked; otherwise all of them are hard.
    fn edges_have_types(&self) -> bool {
        false
    }

    /// Hands every such edge to `visit`, in order, until it breaks: each vertex is below [`MeshReader::vertex_count`]. Nobody makes
    /// sure that it is an edge of the mesh.
    ///
    /// # Errors
    /// [`ReadError`], [`ReadError::EdgeEnd`] among them.
    fn edges(&mut self, visit: &mut EdgeVisitor<'_>) -> Result<(), ReadError> {
        let _ = visit;
        Ok(())
    }
}

/// Passes whose visitors may fail.
impl dyn MeshReader + '_ {
    /// Makes sure that vertices have attributes of these names.
    ///
    /// # Errors
    /// [`ReadError::NoAttribute`] names the first that is not there.
    pub fn must_have(&self, attributes: &[&str]) -> Result<(), ReadError> {
        match attributes.iter().find(|name| !self.attributes().iter().any(|a| a.name == **name)) {
            None => Ok(()),
            Some(name) => Err(ReadError::NoAttribute { path: self.path().to_path_buf(), name: name.to_string() }),
        }
    }

    /// Hands every vertex to `visit`: its index and x, y, z. Stops at the first error, the visitor's own included.
    ///
    /// # Errors
    /// [`ReadError`], or what `visit` returns.
    pub fn for_each_vertex<E: From<ReadError>>(
        &mut self,
        mut visit: impl FnMut(u64, [f64; 3]) -> Result<(), E>,
    ) -> Result<(), E> {
        self.for_each_vertex_with(&[], |index, vertex, _| visit(index, vertex))
    }

    /// Hands every vertex to `visit`: its index, x, y, z, and the attributes of these names, in their order.
    ///
    /// # Errors
    /// [`ReadError`], or what `visit` returns.
    pub fn for_each_vertex_with<E: From<ReadError>>(
        &mut self,
        attributes: &[&str],
        mut visit: impl FnMut(u64, [f64; 3], &[f64]) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut failed = None;
        self.vertices(attributes, &mut |index, vertex, values| kept(&mut failed, visit(index, vertex, values)))?;
        failed.map_or(Ok(()), Err)
    }

    /// Hands every face to `visit`: its index and its three vertices. Stops at the first error, the visitor's own included.
    ///
    /// # Errors
    /// [`ReadError`], or what `visit` returns.
    pub fn for_each_face<E: From<ReadError>>(
        &mut self,
        mut visit: impl FnMut(u64, [u64; 3]) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut failed = None;
        self.faces(&mut |index, face| kept(&mut failed, visit(index, face)))?;
        failed.map_or(Ok(()), Err)
    }

    /// Hands every edge that follows a line to `visit`: its index and its two vertices. Stops at the first error, the visitor's own
    /// included.
    ///
    /// # Errors
    /// [`ReadError`], or what `visit` returns.
    pub fn for_each_edge<E: From<ReadError>>(
        &mut self,
        mut visit: impl FnMut(u64, LineEdge<u64>) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut failed = None;
        self.edges(&mut |index, edge| kept(&mut failed, visit(index, edge)))?;
        failed.map_or(Ok(()), Err)
    }
}

fn kept<E>(failed: &mut Option<E>, result: Result<(), E>) -> ControlFlow<()> {
    match result {
        Ok(()) => ControlFlow::Continue(()),
        Err(error) => {
            *failed = Some(error);
            ControlFlow::Break(())
        }
    }
}
