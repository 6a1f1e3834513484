//! What a file is recognised by.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use sha2::{Digest, Sha256};

/// The size of a file and its SHA-256, in hexadecimal; `None` where a name is no file of this machine, or it cannot be read.
///
/// Memory: 128 KiB, which stays in the cache.
pub(super) fn fingerprint(path: &Path) -> Option<(u64, String)> {
    if !path.is_file() {
        return None;
    }
    let (mut file, mut hasher, mut size) = (File::open(path).ok()?, Sha256::new(), 0);
    let mut buffer = vec![0; 128 << 10];
    loop {
        let read = file.read(&mut buffer).ok()?;
        if read == 0 {
            break;
        }
        hasher.update(&buffer[..read]);
        size += read as u64;
    }
    Some((size, hasher.finalize().iter().map(|byte| format!("{byte:02x}")).collect()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_abc_as_the_standard_has_it() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("abc");
        std::fs::write(&path, "abc").unwrap();
        let expected = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(fingerprint(&path), Some((3, expected.to_string())));
        assert_eq!(fingerprint(dir.path()), None);
    }
}
