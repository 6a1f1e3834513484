//! Sinks: the finished mesh as a file.
//!
//! A [`Sink`] is told what comes ([`Contents`]), then every vertex in map coordinates, then every triangle, and is then
//! asked to finish; dropped before that, at whatever point, it leaves nothing under the final name.

use super::SinkError;
use crate::base::LineEdge;
use crate::base::channels::Channel;

/// What a mesh consists of.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Contents<'a> {
    /// How many vertices.
    pub vertices: u64,
    /// How many triangles.
    pub triangles: u64,
    /// What every vertex has beside its place and its height.
    pub attributes: &'a [Channel],
    /// Whether the last three attributes are `nx`, `ny` and `nz`, the unit normal in the coordinates of the file, upwards.
    pub has_normals: bool,
    /// The tolerance, where it was not known when the sink was made: it takes the place of the header's.
    pub tolerance: Option<f64>,
    /// Between what the vertices lie; `None` unless asked for ([`Needs::bounds`]), or where there are none.
    pub bounds: Option<Bounds>,
    /// How many edges of the mesh follow lines; 0 unless asked for ([`Needs::edges`]).
    pub edges: u64,
    /// Whether the types of these are marked: some of them follow soft lines alone.
    pub edges_have_types: bool,
}

/// The least and the largest x, y on the map and height of vertices.
///
/// What a [`crate::base::CoordinateFrame`] writes grows with what it is given, so what it makes of the bounds are the bounds
/// of what it makes of the vertices, bit for bit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// The least.
    pub min: [f64; 3],
    /// The largest.
    pub max: [f64; 3],
}

impl Bounds {
    /// Of no vertex.
    pub const EMPTY: Bounds = Bounds { min: [f64::INFINITY; 3], max: [f64::NEG_INFINITY; 3] };

    /// With one vertex more.
    pub fn with(self, vertex: [f64; 3]) -> Bounds {
        let at = |i: usize| (self.min[i].min(vertex[i]), self.max[i].max(vertex[i]));
        let [(x0, x1), (y0, y1), (z0, z1)] = [at(0), at(1), at(2)];
        Bounds { min: [x0, y0, z0], max: [x1, y1, z1] }
    }
}

/// What a sink asks for beyond counts, vertices and numbers. Each costs the caller something.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Needs {
    /// [`Contents::bounds`]: a pass over all vertices before [`Sink::begin`].
    pub bounds: bool,
    /// The corners of triangles in [`Sink::triangles`]: the vertices that tiles share are kept at hand, two rows of tiles at
    /// a time.
    pub corners: bool,
    /// How edges that follow lines are marked, where the format has a place for that.
    pub edges: Marks,
}

/// How a format marks edges of the mesh that follow lines.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Marks {
    /// Not at all.
    #[default]
    None,
    /// By the numbers of vertices: [`Sink::edges`].
    Numbers,
    /// By places: [`Sink::lines`].
    Places,
}

/// Takes one mesh, in order: [`Sink::begin`] once, [`Sink::lines`] if asked for, [`Sink::vertices`], [`Sink::triangles`] and, if asked
/// for, [`Sink::edges`] until the counts are reached, [`Sink::finish`] once. After an error, or to abort, it is dropped.
pub trait Sink {
    /// What it asks for; asked before anything else.
    fn needs(&self) -> Needs {
        Needs::default()
    }

    /// What will come.
    ///
    /// # Errors
    /// [`SinkError::TooLarge`] if there is more than the format can number.
    fn begin(&mut self, contents: &Contents<'_>) -> Result<(), SinkError>;

    /// The next vertices: x, y on the map, height; and their values of every attribute, in the order of
    /// [`Contents::attributes`], each as many as there are vertices. A value is one that its number type holds exactly.
    ///
    /// # Errors
    /// [`SinkError`] if they cannot be written.
    fn vertices(&mut self, vertices: &[[f64; 3]], attributes: &[&[f64]]) -> Result<(), SinkError>;

    /// The next triangles: numbers of vertices, counter-clockwise seen from above on the map; and the vertices themselves,
    /// as many as there are triangles where they are asked for ([`Needs::corners`]), else none.
    ///
    /// # Errors
    /// [`SinkError`] if they cannot be written.
    fn triangles(&mut self, triangles: &[[u64; 3]], corners: &[[[f64; 3]; 3]]) -> Result<(), SinkError>;

    /// The next edges that follow lines, as numbers of vertices ([`Marks::Numbers`]). Those of a line come one after the other, and
    /// each begins where the one before it ended.
    ///
    /// # Errors
    /// [`SinkError`] if they cannot be written.
    fn edges(&mut self, edges: &[LineEdge<u64>]) -> Result<(), SinkError> {
        let _ = edges;
        Ok(())
    }

    /// The same edges in the same order, as the vertices themselves ([`Marks::Places`]).
    ///
    /// # Errors
    /// [`SinkError`] if they cannot be written.
    fn lines(&mut self, edges: &[LineEdge<[f64; 3]>]) -> Result<(), SinkError> {
        let _ = edges;
        Ok(())
    }

    /// Everything has come: makes the file complete and gives it its name.
    ///
    /// # Errors
    /// [`SinkError`]; nothing is left then.
    fn finish(self: Box<Self>) -> Result<(), SinkError>;
}
