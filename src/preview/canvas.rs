//! A picture, and writing it as PNG.

use std::io::Write;

use super::PreviewError;
use crate::base::staged::StagedFile;

/// An opaque picture in RGB, rows from the top.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Canvas {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) pixels: Vec<[u8; 3]>,
}

impl Canvas {
    pub(super) fn filled(width: usize, height: usize, colour: [u8; 3]) -> Canvas {
        Canvas { width, height, pixels: vec![colour; width * height] }
    }

    pub(super) fn from_fn(width: usize, height: usize, colour: impl Fn(usize, usize) -> [u8; 3]) -> Canvas {
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| colour(x, y)).collect();
        Canvas { width, height, pixels }
    }

    /// Lays `colour` over a pixel, `cover` from 0 (nothing) to 1; outside the picture it does nothing.
    pub(super) fn blend(&mut self, x: usize, y: usize, colour: [u8; 3], cover: f32) {
        if x >= self.width || y >= self.height {
            return;
        }
        for (below, above) in self.pixels[y * self.width + x].iter_mut().zip(colour) {
            *below = (f32::from(*below) + (f32::from(above) - f32::from(*below)) * cover).round() as u8;
        }
    }

    /// Copies `other` in with its upper left corner at (x, y).
    ///
    /// # Panics
    /// If it does not fit.
    pub(super) fn paste(&mut self, other: &Canvas, x: usize, y: usize) {
        for (j, row) in other.pixels.chunks_exact(other.width).enumerate() {
            let start = (y + j) * self.width + x;
            self.pixels[start..start + other.width].copy_from_slice(row);
        }
    }

    /// Writes a PNG and gives it its name.
    pub(super) fn save(&self, mut staged: StagedFile) -> Result<(), PreviewError> {
        let written = self.encode(&mut std::io::BufWriter::new(staged.file()));
        written.map_err(|e| match e {
            png::EncodingError::IoError(source) => staged.write_error(source),
            other => staged.write_error(std::io::Error::other(other)),
        })?;
        Ok(staged.commit()?)
    }

    fn encode(&self, out: &mut impl Write) -> Result<(), png::EncodingError> {
        let mut encoder = png::Encoder::new(&mut *out, self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(self.pixels.as_flattened())?;
        writer.finish()?;
        Ok(out.flush()?)
    }
}
