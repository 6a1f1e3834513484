//! Whether a FlatGeobuf file has its end.

use std::fs::File;
use std::io::{BufReader, ErrorKind, Read, Seek, SeekFrom};
use std::path::Path;

/// Bytes before the size of the header.
const MARK: u64 = 8;

/// Whether a file without an index has so many features, each of the size that stands before it, and nothing else. GDAL does not
/// tell when the last of them did not fit on the disk.
pub(super) fn is_whole(path: &Path, features: u64) -> std::io::Result<bool> {
    let file = File::open(path)?;
    let length = file.metadata()?.len();
    let mut reader = BufReader::with_capacity(1 << 20, file);
    reader.seek(SeekFrom::Start(MARK))?;
    for _ in 0..=features {
        let mut size = [0; 4];
        match reader.read_exact(&mut size) {
            Err(e) if e.kind() == ErrorKind::UnexpectedEof => return Ok(false),
            read => read?,
        }
        reader.seek_relative(i64::from(u32::from_le_bytes(size)))?;
    }
    Ok(reader.stream_position()? == length)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_whole_with_all_features_and_nothing_else() {
        let file = tempfile::NamedTempFile::new().expect("a file");
        let mut bytes = b"fgb\x03fgb\x01".to_vec();
        for size in [7u32, 5, 0, 9] {
            bytes.extend(size.to_le_bytes());
            bytes.extend(vec![1; size as usize]);
        }
        let is_whole = |bytes: &[u8], features| {
            std::fs::write(file.path(), bytes).expect("written");
            is_whole(file.path(), features).expect("read")
        };
        assert!(is_whole(&bytes, 3));
        assert!(!is_whole(&bytes, 2) && !is_whole(&bytes, 4));
        assert!((0..bytes.len()).all(|cut| !is_whole(&bytes[..cut], 3)));
    }
}
