//! Letters.

use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

use super::canvas::Canvas;

/// Pixels down one line.
pub(super) const LINE: usize = RasterHeight::Size16.val();

/// Pixels across a text.
pub(super) fn width(text: &str) -> usize {
    text.chars().count() * get_raster_width(FontWeight::Regular, RasterHeight::Size16)
}

/// Draws a text with its upper left corner at (x, y). Characters beyond Latin-1 become question marks.
pub(super) fn draw(canvas: &mut Canvas, x: usize, y: usize, text: &str, colour: [u8; 3]) {
    let glyph = |c| get_raster(c, FontWeight::Regular, RasterHeight::Size16);
    let mut left = x;
    for glyph in text.chars().filter_map(|c| glyph(c).or_else(|| glyph('?'))) {
        for (j, row) in glyph.rows().enumerate() {
            for (i, &cover) in row.iter().enumerate() {
                canvas.blend(left + i, y + j, colour, f32::from(cover) / 255.0);
            }
        }
        left += glyph.width();
    }
}
