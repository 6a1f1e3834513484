//! Small pictures of few colours, inside a page.

use std::fmt::Write;

/// Colours with an opacity.
pub(super) type Colour = [u8; 4];

/// A PNG of colours of a table, as an address that holds it. One byte a pixel, row by row from the top.
pub(super) fn data_address((width, height): (usize, usize), palette: &[Colour], pixels: &[u8]) -> String {
    let mut bytes = Vec::new();
    let colours: Vec<u8> = palette.iter().flat_map(|[r, g, b, _]| [*r, *g, *b]).collect();
    let opacities: Vec<u8> = palette.iter().map(|colour| colour[3]).collect();
    let mut encoder = png::Encoder::new(&mut bytes, width as u32, height as u32);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_palette(colours);
    encoder.set_trns(opacities);
    encoder.set_compression(png::Compression::Fast);
    let written = encoder.write_header().and_then(|mut writer| {
        writer.write_image_data(pixels)?;
        writer.finish()
    });
    written.expect("memory takes all, and a picture has as many pixels as it should");
    let mut address = String::from("data:image/png;base64,");
    address.reserve(bytes.len().div_ceil(3) * 4);
    add_base64(&mut address, &bytes);
    address
}

/// Bytes as text (RFC 4648).
pub(super) fn base64(bytes: &[u8]) -> String {
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    add_base64(&mut text, bytes);
    text
}

/// Adds bytes to a text in the same way.
pub(super) fn add_base64(text: &mut String, bytes: &[u8]) {
    const GROUPS: usize = 1024;
    let mut digits = Vec::with_capacity(4 * GROUPS);
    for bytes in bytes.chunks(3 * GROUPS) {
        digits.clear();
        add_digits(&mut digits, bytes);
        text.push_str(std::str::from_utf8(&digits).expect("digits"));
    }
}

/// Adds the digits of some bytes, filled up where they end within a group.
fn add_digits(text: &mut Vec<u8>, bytes: &[u8]) {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let digits = |[a, b, c]: [u8; 3]| {
        let bits = u32::from_be_bytes([0, a, b, c]);
        [18, 12, 6, 0].map(|shift| DIGITS[(bits >> shift) as usize & 63])
    };
    let (groups, rest) = bytes.as_chunks::<3>();
    groups.iter().for_each(|group| text.extend_from_slice(&digits(*group)));
    if !rest.is_empty() {
        let mut group = [0; 3];
        group[..rest.len()].copy_from_slice(rest);
        text.extend_from_slice(&digits(group)[..=rest.len()]);
        text.resize(text.len().next_multiple_of(4), b'=');
    }
}

/// A colour as CSS has it.
pub(super) fn css([r, g, b, _]: Colour) -> String {
    let mut text = String::from("#");
    for part in [r, g, b] {
        let _ = write!(text, "{part:02x}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_as_in_the_rfc() {
        for (bytes, text) in [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foob", "Zm9vYg=="),
            ("fooba", "Zm9vYmE="),
            ("foobar", "Zm9vYmFy"),
        ] {
            assert_eq!(base64(bytes.as_bytes()), text);
        }
        let long = base64(&[0xff; 5000]);
        assert_eq!((long.len(), long.matches('/').count(), &long[6664..]), (6668, 6666, "//8="));
    }
}
