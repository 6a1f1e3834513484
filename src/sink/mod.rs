//! Sinks: the finished mesh as a file.
//!
//! A [`Sink`] is told the counts, then every vertex in map coordinates, then every triangle, and is then asked to
//! finish; dropped before that, at whatever point, it leaves nothing under the final name.

mod error;
mod ply;

pub use error::SinkError;
pub use ply::PlySink;

/// Takes one mesh, in order: [`Sink::begin`] once, [`Sink::vertices`] and then [`Sink::triangles`] until the counts are
/// reached, [`Sink::finish`] once. After an error, or to abort, it is dropped.
pub trait Sink {
    /// How many vertices and triangles will come.
    ///
    /// # Errors
    /// [`SinkError::TooLarge`] if the format cannot number so many.
    fn begin(&mut self, vertices: u64, triangles: u64) -> Result<(), SinkError>;

    /// The next vertices: x, y on the map, height.
    ///
    /// # Errors
    /// [`SinkError`] if they cannot be written.
    fn vertices(&mut self, vertices: &[[f64; 3]]) -> Result<(), SinkError>;

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
