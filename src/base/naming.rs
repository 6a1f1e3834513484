//! What the bands of a raster are called as channels of a mesh.

use super::{Band, SampleType};
use crate::base::channels::{Channel, Number, sanitised};

/// Colours, in the order in which bands are taken for them where nothing says which is which.
const COLOURS: [&str; 4] = ["red", "green", "blue", "alpha"];

/// Names and number types of bands as channels, in their order.
///
/// If the raster says that red, green and blue are among them, these bands (and alpha) are called so; three or four
/// bands of bytes are taken for red, green, blue and alpha also if nothing says so. Others are called what their
/// description says, as far as it is a word that no other channel has, else `band_N`. Bytes of a colour are written as
/// bytes, other samples in single precision if it holds them, else in double precision.
pub fn channels_of(bands: &[Band]) -> Vec<Channel> {
    let bytes = |r: &Band| r.sample_type() == SampleType::U8 && r.scaling().is_none();
    let said: Vec<Option<&str>> = bands.iter().map(Band::colour).collect();
    let rgb = COLOURS[..3].iter().all(|c| said.contains(&Some(c)));
    let plain = !rgb && matches!(bands.len(), 3 | 4) && bands.iter().all(bytes);
    let mut channels: Vec<Channel> = Vec::new();
    for (i, band) in bands.iter().enumerate() {
        let free = |name: &String| channels.iter().all(|c| c.name != *name);
        let colour = if plain { Some(COLOURS[i]) } else { said[i].filter(|_| rgb) };
        let colour = colour.map(str::to_string).filter(free);
        let is_colour = colour.is_some();
        let described = || sanitised(band.description()).filter(|n| free(n) && !COLOURS.contains(&n.as_str()));
        let name = colour.or_else(described).unwrap_or_else(|| format!("band_{}", band.number()));
        // Only another band's description, or the same band once more, can have taken it.
        let name = if free(&name) { name } else { format!("{name}_channel_{}", i + 1) };
        let number = match band.sample_type() {
            SampleType::U8 if is_colour && band.scaling().is_none() => Number::U8,
            t if t.fits_f32() && band.scaling().is_none() => Number::F32,
            _ => Number::F64,
        };
        channels.push(Channel { name, number });
    }
    channels
}
