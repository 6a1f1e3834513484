//! A sink that is watched: what it is given is gathered, too.

use super::Gatherer;
use crate::formats::{Contents, Needs, Sink, SinkError};

/// Hands everything on, and triangles to a [`Gatherer`] as well. It asks for the corners of triangles, whether the sink does or not.
pub(in crate::run) struct Watched<'s> {
    sink: Box<dyn Sink + 's>,
    gatherer: &'s mut Gatherer,
    hands_corners_on: bool,
}

impl<'s> Watched<'s> {
    /// Watches a sink.
    pub(in crate::run) fn new(sink: Box<dyn Sink + 's>, gatherer: &'s mut Gatherer) -> Watched<'s> {
        let hands_corners_on = sink.needs().corners;
        Watched { sink, gatherer, hands_corners_on }
    }
}

impl Sink for Watched<'_> {
    fn needs(&self) -> Needs {
        Needs { corners: true, ..self.sink.needs() }
    }

    fn begin(&mut self, contents: &Contents<'_>) -> Result<(), SinkError> {
        self.gatherer.expect(contents.triangles);
        self.sink.begin(contents)
    }

    fn vertices(&mut self, vertices: &[[f64; 3]], attributes: &[&[f64]]) -> Result<(), SinkError> {
        vertices.iter().for_each(|vertex| self.gatherer.vertex(*vertex));
        self.sink.vertices(vertices, attributes)
    }

    fn triangles(&mut self, triangles: &[[u64; 3]], corners: &[[[f64; 3]; 3]]) -> Result<(), SinkError> {
        corners.iter().for_each(|corners| self.gatherer.triangle(*corners));
        self.sink.triangles(triangles, if self.hands_corners_on { corners } else { &[] })
    }

    fn finish(self: Box<Self>) -> Result<(), SinkError> {
        self.sink.finish()
    }
}
