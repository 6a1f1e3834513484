//! A look at a work dir from outside: what a run of a job would find finished there.

use std::fs::File;
use std::io::{ErrorKind, Read, Seek, SeekFrom};
use std::path::Path;

use super::manifest::Manifest;
use super::{CHUNKS, Job, WorkDirError, failed, must_be_empty, trials};
use crate::job::PassName;
use crate::job::passes::{Links, folder_of};

/// What a work dir has finished.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
pub struct Finished {
    /// Tiles of the first pass.
    pub tiles: u64,
    /// Tiles of the second pass, over the seams.
    pub seams: u64,
    /// Tiles of the last two passes, over crossings with seams.
    pub crossings: u64,
    /// Whole runs of a search for a tolerance.
    pub runs: u64,
    /// What all of them take on disk.
    pub bytes: u64,
}

impl Finished {
    /// Counts the tiles that are kept for `job` in `dir`, which may be missing. Nothing is locked, made, changed or
    /// removed, so another process may work there at the same time. A look at every chunk, at the end of it only: one that
    /// a run would find damaged counts.
    ///
    /// # Errors
    /// [`WorkDirError`], as [`super::WorkDir::open`] but for [`WorkDirError::InUse`]: it belongs to another job, or is some
    /// other folder.
    pub fn of(dir: &Path, job: &Job) -> Result<Finished, WorkDirError> {
        let path = Manifest::path(dir);
        let kept = match std::fs::read_to_string(&path) {
            Ok(text) => Manifest::parse(&path, &text)?,
            Err(e) if e.kind() == ErrorKind::NotFound && !dir.exists() => return Ok(Finished::default()),
            Err(e) if e.kind() == ErrorKind::NotFound => {
                must_be_empty(dir)?;
                return Ok(Finished::default());
            }
            Err(e) => return Err(failed(&path)(e)),
        };
        Manifest::new(job).must_continue(dir, &kept)?;
        let stamp = kept.stamp().to_le_bytes();
        let chunks = dir.join(CHUNKS);
        let of_pass = |pass: PassName| count(&chunks.join(folder_of(Links::Fewest, pass)), stamp);
        let all = PassName::ALL.map(of_pass);
        let [(tiles, _), (seams, _), (across, _), (down, _)] = all;
        let bytes = all.iter().map(|(_, bytes)| bytes).sum::<u64>() + trials::bytes(&chunks);
        Ok(Finished { tiles, seams, crossings: across + down, runs: trials::runs(dir), bytes })
    }
}

/// How many chunks with this stamp are in the rows in `dir`, and their bytes. What cannot be read is none: another process
/// may just have removed it.
fn count(dir: &Path, stamp: [u8; 4]) -> (u64, u64) {
    let entries = |dir: &Path| dir.read_dir().into_iter().flatten().flatten().map(|entry| entry.path());
    let is_number = |path: &Path| path.file_stem().and_then(|s| s.to_str()).is_some_and(|s| s.parse::<u64>().is_ok());
    let rows = entries(dir).filter(|row| is_number(row));
    let chunks = rows.flat_map(|row| entries(&row)).filter(|path| path.extension().is_some_and(|e| e == "chunk"));
    let bytes = chunks.filter(|chunk| is_number(chunk)).filter_map(|chunk| ends_with(&chunk, stamp));
    bytes.fold((0, 0), |(count, sum), bytes| (count + 1, sum + bytes))
}

/// The length of a file, if it ends with the stamp.
fn ends_with(path: &Path, stamp: [u8; 4]) -> Option<u64> {
    let mut file = File::open(path).ok()?;
    let mut end = [0; 4];
    file.seek(SeekFrom::End(-4)).ok()?;
    file.read_exact(&mut end).ok()?;
    (end == stamp).then(|| file.metadata().map_or(0, |m| m.len()))
}
