//! Tables of columns x, y, z that have no line for some samples.
//!
//! GDAL gives such samples a value that no line has: 0, or −32768. Where both are heights, or could not be stored, it marks
//! nothing, and they become heights of 0.

use std::fs::File;
use std::io::{self, BufRead, BufReader};
use std::path::Path;

/// How compressed files begin, which GDAL opens, too.
const GZIP: [u8; 2] = [0x1f, 0x8b];

/// Counts the lines of a table that begin with a number; `None` if it is compressed. Memory does not depend on the length of
/// lines.
///
/// # Errors
/// What the system says.
pub(super) fn lines(path: &Path) -> io::Result<Option<u64>> {
    let mut file = BufReader::with_capacity(1 << 18, File::open(path)?);
    let (mut count, mut seen) = (0, false);
    if file.fill_buf()?.starts_with(&GZIP) {
        return Ok(None);
    }
    loop {
        let bytes = file.fill_buf()?;
        if bytes.is_empty() {
            return Ok(Some(count));
        }
        for byte in bytes {
            match byte {
                b'\n' | b'\r' => seen = false,
                // What comes first decides; the rest of the line is passed over.
                _ if seen || byte.is_ascii_whitespace() => {}
                _ => {
                    seen = true;
                    count += u64::from(byte.is_ascii_digit() || matches!(byte, b'-' | b'+' | b'.'));
                }
            }
        }
        let used = bytes.len();
        file.consume(used);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_with_numbers_are_counted() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("dem.xyz");
        std::fs::write(&path, "x y z\r\n1 2 3\r\n\r\n  -1,2,3\n# 4\n.5;1;2\n\n7 8 9").expect("written");
        assert_eq!(lines(&path).expect("there"), Some(4));
        std::fs::write(&path, b"\x1f\x8b\x08\n1 2 3").expect("written");
        assert_eq!(lines(&path).expect("there"), None);
    }
}
