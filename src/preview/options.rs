//! What is drawn, and how.

use std::path::PathBuf;

use crate::raster::View;

/// What is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Mode {
    /// The triangles, each shaded flat by its own slope.
    #[default]
    Hillshade,
    /// The shaded triangles and their edges.
    Wireframe,
    /// How far the surface is from the samples, in colours, with a legend.
    Error,
    /// The raster, shaded, to the left; the triangles and their edges to the right.
    SideBySide,
    /// The colours of the vertices, blended across the triangles; for meshes with red, green and blue.
    Colour,
}

impl Mode {
    /// Whether ground is shaded by its slope.
    pub(super) fn is_shaded(self) -> bool {
        !matches!(self, Mode::Error | Mode::Colour)
    }
}

/// What is drawn of it, and how.
#[derive(Debug, Clone, PartialEq)]
pub struct PreviewOptions {
    /// What is drawn.
    pub mode: Mode,
    /// Which samples are drawn, and what they are.
    pub view: View,
    /// Weights of errors, on the samples of the raster: [`Mode::Error`] draws error × weight.
    pub importance: Option<(PathBuf, View)>,
    /// The raster is an image without heights: they are 0.
    pub image: bool,
    /// The largest picture, in pixels across and down; the legend is added to it.
    pub size: (usize, usize),
    /// The tolerance: the end of the colour scale, beyond which samples are marked. `None` scales to the largest error.
    pub max_error: Option<f64>,
    /// Heights are multiplied by this for shading, beyond true proportions. `None` chooses from the raster's slopes:
    /// 19 of 20 are shaded no steeper than 35°, and at least as steep as they are where proportions are known.
    pub exaggeration: Option<f64>,
    /// Whether an existing picture is replaced.
    pub overwrite: bool,
}

impl Default for PreviewOptions {
    fn default() -> Self {
        PreviewOptions {
            mode: Mode::default(),
            view: View::default(),
            importance: None,
            image: false,
            size: (1024, 1024),
            max_error: None,
            exaggeration: None,
            overwrite: false,
        }
    }
}
