//! Sinks: the finished mesh as a file.
//!
//! A [`Sink`] is told what comes ([`Contents`]), then every vertex in map coordinates, then every triangle, and is then
//! asked to finish; dropped before that, at whatever point, it leaves nothing under the final name.

use super::SinkError;
use crate::base::channels::Channel;

/// What a mesh consists of.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Contents<'a> {
    /// How many vertices.
    pub vertices: u64,
    /// How many triangles.
    pub triangles: u64,
    /// What every vertex has beside its place and its height.
    pub attributes: &'a [Channel],
}

/// Takes one mesh, in order: [`Sink::begin`] once, [`Sink::vertices`] and then [`Sink::triangles`] until the counts are
/// reached, [`Sink::finish`] once. After an error, or to abort, it is dropped.
pub trait Sink {
    /// What will come.
    ///
    /// # Errors
    /// [`SinkError::TooLarge`] if the format cannot number so many.
    fn begin(&mut self, contents: &Contents<'_>) -> Result<(), SinkError>;

    /// The next vertices: x, y on the map, height; and their values of every attribute, in the order of
    /// [`Contents::attributes`], each as many as there are vertices. A value is one that its number type holds exactly.
    ///
    /// # Errors
    /// [`SinkError`] if they cannot be written.
    fn vertices(&mut self, vertices: &[[f64; 3]], attributes: &[&[f64]]) -> Result<(), SinkError>;

    /// The next triangles: numbers of vertices, counter-clockwise seen from above on the map.
    ///
    /// # Errors
    /// [`SinkError`] if they cannot be written.
    fn triangles(&mut self, triangles: &[[u64; 3]]) -> Result<(), SinkError>;

    /// Everything has come: makes the file complete and gives it its name.
    ///
    /// # Errors
    /// [`SinkError`]; nothing is left then.
    fn finish(self: Box<Self>) -> Result<(), SinkError>;
}
