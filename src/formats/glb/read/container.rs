//! The file: its header, its two chunks, and bytes out of them.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;

use super::GlbError;
use super::document::Document;
use super::packed::Packing;
use crate::base::control::CancelToken;

/// The most bytes of a JSON chunk; terrabite writes no longer ones.
const JSON_BYTES: u64 = 16 << 20;

/// Decompressed views are kept as long as they take no more bytes than this, but for the latest.
const KEPT_BYTES: usize = 64 << 20;

/// A GLB file, open for reading.
#[derive(Debug)]
pub(super) struct GlbFile {
    pub(super) path: PathBuf,
    pub(super) cancel: CancelToken,
    file: File,
    bytes: u64,
    modified: Option<SystemTime>,
    /// Where the content of the BIN chunk begins, and how long it is.
    pub(super) bin: Option<(u64, u64)>,
    /// Views that have been decompressed, the latest at the end.
    kept: Vec<(usize, Arc<Vec<u8>>)>,
}

impl GlbFile {
    /// Opens a file and reads its headers and its JSON chunk.
    pub(super) fn open(path: &Path, cancel: &CancelToken) -> Result<(GlbFile, Document), GlbError> {
        let io = |source| GlbError::Io { path: path.to_path_buf(), source };
        cancel.check()?;
        let file = File::open(path).map_err(io)?;
        let metadata = file.metadata().map_err(io)?;
        let (bytes, modified) = (metadata.len(), metadata.modified().ok());
        let (path, cancel) = (path.to_path_buf(), cancel.clone());
        let mut glb = GlbFile { path, cancel, file, bytes, modified, bin: None, kept: Vec::new() };
        let [magic, version, length] = glb.words(0)?;
        if magic.to_le_bytes() != *b"glTF" {
            return Err(glb.unfit(0, "glTF, the mark of a GLB", format!("{:?}", text(magic))));
        }
        if version != 2 {
            return Err(glb.unfit(4, "version 2", version));
        }
        let length = u64::from(length);
        if length > bytes {
            return Err(GlbError::Truncated { path: glb.path, expected: length, found: bytes });
        }
        // What comes after the length that the file says is not part of it.
        glb.bytes = length;
        let [json_bytes, kind] = glb.words(12)?;
        if kind.to_le_bytes() != *b"JSON" {
            return Err(glb.unfit(16, "JSON, the first chunk", format!("{:?}", text(kind))));
        }
        let end = glb.chunk(12, json_bytes)?;
        if u64::from(json_bytes) > JSON_BYTES {
            return Err(glb.unfit(12, format!("a JSON chunk of at most {JSON_BYTES} bytes"), json_bytes));
        }
        let mut json = vec![0; json_bytes as usize];
        glb.read(20, &mut json)?;
        if end < length {
            let [bin_bytes, kind] = glb.words(end)?;
            glb.chunk(end, bin_bytes)?;
            glb.bin = (kind.to_le_bytes() == *b"BIN\0").then_some((end + 8, u64::from(bin_bytes)));
        }
        glb.bytes = bytes;
        let document = serde_json::from_slice(&json);
        let document = document.map_err(|source| GlbError::Json { path: glb.path.clone(), offset: 20, source })?;
        Ok((glb, document))
    }

    /// Begins a pass.
    ///
    /// # Errors
    /// [`GlbError::Changed`] if the file is another than at opening.
    pub(super) fn begin(&self) -> Result<(), GlbError> {
        self.cancel.check()?;
        let metadata = self.file.metadata().map_err(|source| GlbError::Io { path: self.path.clone(), source })?;
        match (metadata.len(), metadata.modified().ok()) == (self.bytes, self.modified) {
            true => Ok(()),
            false => Err(GlbError::Changed { path: self.path.clone() }),
        }
    }

    /// Fills `bytes` with those of the file from `offset` on.
    pub(super) fn read(&self, offset: u64, bytes: &mut [u8]) -> Result<(), GlbError> {
        self.cancel.check()?;
        let expected = offset + bytes.len() as u64;
        if expected > self.bytes {
            return Err(GlbError::Truncated { path: self.path.clone(), expected, found: self.bytes });
        }
        let mut file = &self.file;
        let read = file.seek(SeekFrom::Start(offset)).and_then(|_| file.read_exact(bytes));
        read.map_err(|source| GlbError::Io { path: self.path.clone(), source })
    }

    /// The content of a compressed view.
    pub(super) fn unpacked(&mut self, view: usize, packing: &Packing) -> Result<Arc<Vec<u8>>, GlbError> {
        if let Some((_, content)) = self.kept.iter().find(|(kept, _)| *kept == view) {
            return Ok(content.clone());
        }
        let bytes = |kept: &[(usize, Arc<Vec<u8>>)]| kept.iter().map(|(_, content)| content.len()).sum::<usize>();
        while !self.kept.is_empty() && bytes(&self.kept) + packing.unpacked_bytes() > KEPT_BYTES {
            self.kept.remove(0);
        }
        let mut packed = vec![0; packing.length as usize];
        self.read(packing.start, &mut packed)?;
        let content = packing.unpack(&packed).ok_or_else(|| GlbError::Packed {
            path: self.path.clone(),
            view,
            offset: packing.start,
            expected: packing.content(),
        })?;
        let content = Arc::new(content);
        self.kept.push((view, content.clone()));
        Ok(content)
    }

    fn words<const N: usize>(&self, offset: u64) -> Result<[u32; N], GlbError> {
        let mut bytes = vec![0; 4 * N];
        self.read(offset, &mut bytes)?;
        Ok(std::array::from_fn(|i| {
            u32::from_le_bytes([bytes[4 * i], bytes[4 * i + 1], bytes[4 * i + 2], bytes[4 * i + 3]])
        }))
    }

    /// Where a chunk ends that begins at `offset` and says how many bytes it has.
    fn chunk(&self, offset: u64, bytes: u32) -> Result<u64, GlbError> {
        let end = offset + 8 + u64::from(bytes);
        match end <= self.bytes {
            true => Ok(end),
            false => {
                let room = self.bytes - offset - 8;
                Err(self.unfit(offset, format!("a chunk of at most {room} bytes, as the file has room for"), bytes))
            }
        }
    }

    fn unfit(&self, offset: u64, expected: impl ToString, found: impl ToString) -> GlbError {
        let (expected, found) = (expected.to_string(), found.to_string());
        GlbError::Container { path: self.path.clone(), offset, expected, found }
    }
}

fn text(word: u32) -> String {
    String::from_utf8_lossy(&word.to_le_bytes()).into_owned()
}
