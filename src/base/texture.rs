//! Images that lie over a mesh.

use std::sync::Arc;

/// An image over a rectangle of the map, as a JPEG file. Cloning shares it.
#[derive(Debug, Clone, PartialEq)]
pub struct Texture {
    /// The file.
    pub jpeg: Arc<Vec<u8>>,
    /// The least x and y on the map and the largest: where the outer edges of the image lie, its first row at the largest y.
    pub extent: [f64; 4],
}

impl Texture {
    /// Where a place on the map lies in the image: from 0 at the left to 1 at the right, and from 0 at the top to 1 at the
    /// bottom.
    pub fn at(&self, x: f64, y: f64) -> [f64; 2] {
        let [left, bottom, right, top] = self.extent;
        [(x - left) / (right - left), (top - y) / (top - bottom)]
    }
}
