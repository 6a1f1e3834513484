//! Temporary files, in pieces.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use super::ScratchError;
use crate::base::control::CancelToken;

/// Where temporary files are made. They have no name, so nobody else opens them and nothing is left behind by a crash.
///
/// Every transfer looks out for cancellation: a run that is sorting notices as soon as one that is reading.
#[derive(Debug, Clone)]
pub(crate) struct Scratch {
    dir: PathBuf,
    cancel: CancelToken,
}

impl Scratch {
    pub(crate) fn new(dir: Option<&Path>, cancel: CancelToken) -> Scratch {
        Scratch { dir: dir.map_or_else(std::env::temp_dir, Path::to_path_buf), cancel }
    }

    pub(crate) fn file(&self) -> Result<File, ScratchError> {
        tempfile::tempfile_in(&self.dir).map_err(|e| self.error(e))
    }

    pub(crate) fn error(&self, source: std::io::Error) -> ScratchError {
        ScratchError::File { dir: self.dir.clone(), source }
    }

    /// Writes records at the file's cursor.
    pub(crate) fn write<const N: usize>(&self, mut file: &File, records: &[[u64; N]]) -> Result<(), ScratchError> {
        self.cancel.check()?;
        file.write_all(bytemuck::cast_slice(records.as_flattened())).map_err(|e| self.error(e))
    }

    /// Writes records at the cursor of a file, which is made if there is none.
    pub(crate) fn append<const N: usize>(
        &self,
        file: &mut Option<File>,
        records: &[[u64; N]],
    ) -> Result<(), ScratchError> {
        if file.is_none() {
            *file = Some(self.file()?);
        }
        self.write(file.as_ref().expect("made above"), records)
    }

    /// Reads records from number `first` on.
    pub(crate) fn read<const N: usize>(
        &self,
        mut file: &File,
        first: u64,
        records: &mut [[u64; N]],
    ) -> Result<(), ScratchError> {
        self.cancel.check()?;
        let place = SeekFrom::Start(first * size_of::<[u64; N]>() as u64);
        let bytes = bytemuck::cast_slice_mut(records.as_flattened_mut());
        file.seek(place).and_then(|_| file.read_exact(bytes)).map_err(|e| self.error(e))
    }
}

/// First in, first out, in bounded memory: what does not fit into one buffer waits in a file.
///
/// Memory use is constant: [`Queue::BUFFER`] records while it is filled, as many again while it is emptied.
#[derive(Debug)]
pub(crate) struct Queue<'s, const N: usize> {
    scratch: &'s Scratch,
    file: Option<File>,
    filed: u64,
    latest: Vec<[u64; N]>,
}

impl<'s, const N: usize> Queue<'s, N> {
    /// Records of a piece.
    pub(crate) const BUFFER: usize = 16 << 10;

    pub(crate) fn new(scratch: &'s Scratch) -> Self {
        Queue::reusing(scratch, Vec::new())
    }

    /// One whose buffer has been used before.
    pub(crate) fn reusing(scratch: &'s Scratch, mut latest: Vec<[u64; N]>) -> Self {
        latest.clear();
        Queue { scratch, file: None, filed: 0, latest }
    }

    pub(crate) fn push(&mut self, record: [u64; N]) -> Result<(), ScratchError> {
        if self.latest.len() == Self::BUFFER {
            self.scratch.append(&mut self.file, &self.latest)?;
            self.filed += self.latest.len() as u64;
            self.latest.clear();
        }
        self.latest.push(record);
        Ok(())
    }

    /// The records in the order they came.
    pub(crate) fn into_records(self) -> impl Iterator<Item = Result<[u64; N], ScratchError>> {
        self.into_pieces().flat_map(|piece| {
            let (records, error) = match piece {
                Ok(records) => (records, None),
                Err(error) => (Vec::new(), Some(Err(error))),
            };
            records.into_iter().map(Ok).chain(error)
        })
    }

    /// The records in the order they came, in pieces of [`Queue::BUFFER`] records; the last may have fewer, but has some.
    pub(crate) fn into_pieces(self) -> impl Iterator<Item = Result<Vec<[u64; N]>, ScratchError>> {
        let Queue { scratch, file, filed, latest } = self;
        let from_file = (0..filed).step_by(Self::BUFFER).map(move |first| {
            let mut piece = vec![[0; N]; Self::BUFFER];
            scratch.read(file.as_ref().expect("records were filed"), first, &mut piece).map(|()| piece)
        });
        from_file.chain((!latest.is_empty()).then_some(Ok(latest)))
    }
}
