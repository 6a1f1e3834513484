//! A mesh in arrays: a sink that fills them, and a reader over them. Not a format of files: what is in memory keeps all that
//! there is, as doubles.

use std::path::{Path, PathBuf};

use super::reader::{EdgeVisitor, FaceVisitor, VertexVisitor};
use super::{Contents, Header, Marks, MeshReader, Needs, ReadError, Sink, SinkError};
use crate::base::channels::Channel;
use crate::base::control::CancelToken;
use crate::base::{LineEdge, LineType};

/// A mesh in memory. Memory: 24 bytes a vertex, 8 for each of its attributes, 12 a triangle, 9 an edge of a line.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Arrays {
    /// x, y on the map and height, vertex by vertex.
    pub vertices: Vec<f64>,
    /// Three numbers of vertices for each triangle, counter-clockwise seen from above on the map.
    pub triangles: Vec<u32>,
    /// What vertices have beside that, and the values, as many as vertices.
    pub attributes: Vec<(Channel, Vec<f64>)>,
    /// Two numbers of vertices for each edge that follows a line.
    pub edges: Vec<u32>,
    /// Whether each of these follows soft lines alone.
    pub soft_edges: Vec<bool>,
}

/// Fills [`Arrays`].
#[derive(Debug)]
pub struct ArraySink<'a> {
    name: PathBuf,
    into: &'a mut Arrays,
}

impl<'a> ArraySink<'a> {
    /// Begins with what is there taken away. `name` is what messages call it.
    pub fn new(name: impl Into<PathBuf>, into: &'a mut Arrays) -> ArraySink<'a> {
        *into = Arrays::default();
        ArraySink { name: name.into(), into }
    }
}

/// The most vertices: more cannot be told apart by 32 bits.
const MOST: u64 = 1 << 32;

impl Sink for ArraySink<'_> {
    fn needs(&self) -> Needs {
        Needs { edges: Marks::Numbers, ..Needs::default() }
    }

    fn begin(&mut self, contents: &Contents<'_>) -> Result<(), SinkError> {
        let (vertices, triangles) = (contents.vertices, contents.triangles);
        if vertices > MOST {
            let (path, format) = (self.name.clone(), "an array of 32-bit numbers");
            return Err(SinkError::TooLarge { path, format, what: "vertices", limit: MOST, found: vertices });
        }
        self.into.vertices.reserve_exact(3 * vertices as usize);
        self.into.triangles.reserve_exact(3 * triangles as usize);
        self.into.edges.reserve_exact(2 * contents.edges as usize);
        self.into.soft_edges.reserve_exact(contents.edges as usize);
        let named = |channel: &Channel| (channel.clone(), Vec::with_capacity(vertices as usize));
        self.into.attributes = contents.attributes.iter().map(named).collect();
        Ok(())
    }

    fn vertices(&mut self, vertices: &[[f64; 3]], attributes: &[&[f64]]) -> Result<(), SinkError> {
        self.into.vertices.extend_from_slice(vertices.as_flattened());
        self.into.attributes.iter_mut().zip(attributes).for_each(|((_, all), values)| all.extend_from_slice(values));
        Ok(())
    }

    fn triangles(&mut self, triangles: &[[u64; 3]], _corners: &[[[f64; 3]; 3]]) -> Result<(), SinkError> {
        self.into.triangles.extend(triangles.as_flattened().iter().map(|&vertex| vertex as u32));
        Ok(())
    }

    fn edges(&mut self, edges: &[LineEdge<u64>]) -> Result<(), SinkError> {
        self.into.edges.extend(edges.iter().flat_map(|edge| edge.ends).map(|vertex| vertex as u32));
        self.into.soft_edges.extend(edges.iter().map(|edge| edge.line_type == LineType::Soft));
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<(), SinkError> {
        Ok(())
    }
}

/// Reads a mesh in arrays that somebody else holds, laid out as those of [`Arrays`].
#[derive(Debug)]
pub struct ArrayReader<'a> {
    name: PathBuf,
    header: Header,
    vertices: &'a [[f64; 3]],
    triangles: &'a [[u32; 3]],
    channels: Vec<Channel>,
    values: Vec<&'a [f64]>,
    edges: &'a [[u32; 2]],
    soft_edges: &'a [bool],
    cancel: CancelToken,
}

/// Records between two looks at the token.
const AT_A_TIME: usize = 1 << 12;

impl<'a> ArrayReader<'a> {
    /// `name` is what messages call the mesh, `header` what it says of itself. `cancel` ends every pass.
    ///
    /// # Errors
    /// A sentence if arrays have another length than their contents need, or a triangle names a vertex that is not there.
    pub fn new(
        name: impl Into<PathBuf>,
        header: Header,
        (vertices, triangles): (&'a [f64], &'a [u32]),
        attributes: Vec<(Channel, &'a [f64])>,
        cancel: CancelToken,
    ) -> Result<ArrayReader<'a>, String> {
        let (vertices, rest) = vertices.as_chunks::<3>();
        let (triangles, more) = triangles.as_chunks::<3>();
        if !rest.is_empty() || !more.is_empty() {
            return Err("expected three coordinates for each vertex and three vertices for each triangle".to_string());
        }
        if let Some(beyond) = triangles.as_flattened().iter().find(|&&vertex| vertex as usize >= vertices.len()) {
            return Err(format!("expected vertices below {}, found vertex {beyond} in a triangle", vertices.len()));
        }
        if let Some((channel, values)) = attributes.iter().find(|(_, values)| values.len() != vertices.len()) {
            let (name, found) = (&channel.name, values.len());
            return Err(format!("expected {} values of {name}, as many as vertices, found {found}", vertices.len()));
        }
        let (channels, values) = attributes.into_iter().unzip();
        Ok(ArrayReader {
            name: name.into(),
            header,
            vertices,
            triangles,
            channels,
            values,
            edges: &[],
            soft_edges: &[],
            cancel,
        })
    }

    /// The same mesh with edges that follow lines, two numbers of vertices for each, and whether each is soft.
    ///
    /// # Errors
    /// A sentence if there is an odd one, or one that is no vertex's, or not a type for each.
    pub fn with_edges(self, edges: &'a [u32], soft_edges: &'a [bool]) -> Result<ArrayReader<'a>, String> {
        let (edges, rest) = edges.as_chunks::<2>();
        if !rest.is_empty() || soft_edges.len() != edges.len() {
            return Err("expected two vertices and a type for each edge".to_string());
        }
        match edges.as_flattened().iter().find(|&&vertex| vertex as usize >= self.vertices.len()) {
            None => Ok(ArrayReader { edges, soft_edges, ..self }),
            Some(beyond) => {
                let vertices = self.vertices.len();
                Err(format!("expected vertices below {vertices}, found vertex {beyond} in an edge"))
            }
        }
    }
}

impl MeshReader for ArrayReader<'_> {
    fn path(&self) -> &Path {
        &self.name
    }

    fn vertex_count(&self) -> u64 {
        self.vertices.len() as u64
    }

    fn face_count(&self) -> u64 {
        self.triangles.len() as u64
    }

    fn header(&self) -> &Header {
        &self.header
    }

    fn attributes(&self) -> &[Channel] {
        &self.channels
    }

    fn vertices(&mut self, attributes: &[&str], visit: &mut VertexVisitor<'_>) -> Result<(), ReadError> {
        (self as &mut dyn MeshReader).must_have(attributes)?;
        let of = |name: &&str| self.channels.iter().position(|channel| channel.name == *name);
        let wanted: Vec<&[f64]> = attributes.iter().filter_map(of).map(|at| self.values[at]).collect();
        let mut values = vec![0.0; wanted.len()];
        for (index, vertex) in self.vertices.iter().enumerate() {
            if index % AT_A_TIME == 0 {
                self.cancel.check()?;
            }
            values.iter_mut().zip(&wanted).for_each(|(value, all)| *value = all[index]);
            if visit(index as u64, *vertex, &values).is_break() {
                break;
            }
        }
        Ok(())
    }

    fn faces(&mut self, visit: &mut FaceVisitor<'_>) -> Result<(), ReadError> {
        for (index, triangle) in self.triangles.iter().enumerate() {
            if index % AT_A_TIME == 0 {
                self.cancel.check()?;
            }
            if visit(index as u64, triangle.map(u64::from)).is_break() {
                break;
            }
        }
        Ok(())
    }

    fn edge_count(&self) -> u64 {
        self.edges.len() as u64
    }

    fn edges_have_types(&self) -> bool {
        self.soft_edges.contains(&true)
    }

    fn edges(&mut self, visit: &mut EdgeVisitor<'_>) -> Result<(), ReadError> {
        for (index, (edge, is_soft)) in self.edges.iter().zip(self.soft_edges).enumerate() {
            if index % AT_A_TIME == 0 {
                self.cancel.check()?;
            }
            let line_type = if *is_soft { LineType::Soft } else { LineType::Hard };
            if visit(index as u64, LineEdge { ends: edge.map(u64::from), line_type }).is_break() {
                break;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::channels::Number;

    fn channel(name: &str) -> Channel {
        Channel { name: name.to_string(), number: Number::F32 }
    }

    #[test]
    fn what_is_written_is_read() {
        let mut arrays = Arrays::default();
        let mut sink = Box::new(ArraySink::new("arrays", &mut arrays));
        let attributes = [channel("slope")];
        let contents = Contents { vertices: 3, triangles: 1, attributes: &attributes, ..Contents::default() };
        sink.begin(&contents).expect("room");
        sink.vertices(&[[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]], &[&[7.0, 8.0]]).expect("vertices");
        sink.vertices(&[[6.0, 7.0, 8.0]], &[&[9.0]]).expect("vertices");
        sink.triangles(&[[2, 0, 1]], &[]).expect("triangles");
        sink.edges(&[LineEdge { ends: [2, 1], line_type: LineType::Soft }]).expect("edges");
        sink.finish().expect("a mesh");
        let values = arrays.attributes.iter().map(|(channel, values)| (channel.clone(), values.as_slice())).collect();
        let slices = (arrays.vertices.as_slice(), arrays.triangles.as_slice());
        let cancel = CancelToken::default();
        let reader = ArrayReader::new("arrays", Header::default(), slices, values, cancel.clone()).expect("a mesh");
        assert!(reader.edges.is_empty());
        let mut reader = reader.with_edges(&arrays.edges, &arrays.soft_edges).expect("edges");
        assert_eq!((reader.edges, reader.edges_have_types()), (&[[2, 1]][..], true));
        let reader: &mut dyn MeshReader = &mut reader;
        let mut read = Vec::new();
        let visit = |_, [_, _, z]: [f64; 3], values: &[f64]| -> Result<(), ReadError> {
            read.push((z, values[0]));
            Ok(())
        };
        reader.for_each_vertex_with(&["slope"], visit).expect("vertices");
        assert_eq!(read, [(2.0, 7.0), (5.0, 8.0), (8.0, 9.0)]);
        let mut faces = Vec::new();
        let visit = |_, face| -> Result<(), ReadError> {
            faces.push(face);
            Ok(())
        };
        reader.for_each_face(visit).expect("faces");
        assert_eq!(faces, [[2, 0, 1]]);
        let missing = reader.for_each_vertex_with(&["depth"], |_, _, _| Ok::<(), ReadError>(()));
        assert!(matches!(missing, Err(ReadError::NoAttribute { .. })));
        cancel.cancel();
        assert!(matches!(reader.faces(&mut |_, _| panic!("stopped before")), Err(ReadError::Cancelled(_))));
    }

    #[test]
    fn arrays_that_do_not_fit_are_refused() {
        let refused = |vertices: &[f64], triangles: &[u32], values: &[f64]| {
            let attributes = vec![(channel("slope"), values)];
            let found =
                ArrayReader::new("a", Header::default(), (vertices, triangles), attributes, CancelToken::default());
            found.err().unwrap_or_default()
        };
        assert!(refused(&[0.0; 4], &[], &[0.0]).contains("three coordinates"));
        assert!(refused(&[0.0; 3], &[0, 0, 1], &[0.0]).contains("found vertex 1"));
        assert!(refused(&[0.0; 3], &[0, 0, 0], &[]).contains("slope"));
        assert_eq!(refused(&[0.0; 3], &[0, 0, 0], &[0.0]), "");
        let edges = |edges: &[u32], soft: &[bool]| {
            let mesh = ArrayReader::new("a", Header::default(), (&[0.0; 6], &[]), Vec::new(), CancelToken::default());
            mesh.expect("two vertices").with_edges(edges, soft).err().unwrap_or_default()
        };
        assert!(edges(&[0, 1, 1], &[false]).contains("two vertices and a type for each edge"));
        assert!(edges(&[0, 1], &[]).contains("two vertices and a type for each edge"));
        assert!(edges(&[0, 1, 1, 2], &[false; 2]).contains("found vertex 2 in an edge"));
        assert_eq!(edges(&[0, 1, 1, 0], &[false, true]), "");
    }
}
