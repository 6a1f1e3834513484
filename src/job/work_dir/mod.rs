//! Work dirs: folders that keep a run's finished tiles, so that the same job can be continued after an interrupt, a
//! crash, a kill or a power cut.
//!
//! In comes a [`Job`] (what decides the bytes of the result); out goes a [`Spool`] whose chunks outlive the process. A
//! work dir belongs to one job and, while a run is on, to one process; shards of a run share it, as they only bring chunks:
//!
//! | name | what |
//! |---|---|
//! | `manifest.json` | the job: program version, parameters, raster; durable before anything else is made |
//! | `chunks/…` | of other jobs than meshes: files that they name themselves ([`WorkDir::parts`]) |
//! | `chunks/ROW/COLUMN.chunk` | finished tiles, checksummed, each renamed into place after it was synced |
//! | `chunks/PASS/ROW/COLUMN.chunk` | the same of each pass that follows the first, where there are some |
//! | `chunks/short-PASS/ROW/COLUMN.chunk` | the same of a run that is made again with short links |
//! | `chunks/at-TOLERANCE/…` | the same of the runs that a search for a tolerance makes |
//! | `trials.json` | what such a search has found out ([`crate::job::Store`]) |
//! | `plan.json` | the command, where the run is made in shards ([`crate::job::shards`]) |
//! | `short-links` | there once it is known that such a run has to be made again with short links |
//! | `logs` | what the processes of shards have said, where somebody keeps that; it goes with the rest |
//! | `staged` | where the partial output is, so that a killed run's is found and removed |
//! | `lock` | locked while a process works here; the system releases it however the process ends |
//!
//! Every file but the lock is written under a private name, synced and renamed ([`PrivateFile`]); other jobs than meshes may leave
//! theirs unsynced. A lock is on the file
//! itself, whatever its name, so it stays where it was made, and what it says is one word.
//!
//! [`PrivateFile`]: crate::base::private_file::PrivateFile
//!
//! **What identifies a raster** is [`crate::base::identity`]: its shape, type, geotransform, nodata and scaling, and a
//! checksum of some of its samples; never its path, so files may be moved. Beside it the manifest has the lengths and
//! times of its files ([`crate::base::Files`]). If all files are known and none of them differs, kept chunks are taken
//! as they are; otherwise (touched, copied, a VRT) the samples of every kept tile are loaded again and compared by
//! checksum with those its chunk was made from. An importance raster is identified and compared in the same way, its
//! weights together with the samples. So a touched raster costs one more reading and continues; a changed one
//! is refused, whichever sample changed.

mod error;
mod files;
#[cfg(any(test, feature = "fuzzing"))]
pub(crate) mod fuzzing;
mod layout;
mod lock;
mod look;
mod manifest;
mod staged_output;
mod trials;

pub use error::{Difference, WorkDirError};
pub use layout::PlannedCommand;
pub use look::Finished;

use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use crate::base::Files;
use crate::base::faults::{self, Point};
use crate::base::{durable, private_file};
use crate::job::Pass;
use crate::job::spool::{Spool, SpoolError};
use lock::Lock;
use manifest::Manifest;

/// What a work dir belongs to.
#[derive(Debug, Clone)]
pub struct Job {
    /// The parameters that decide the bytes of a chunk, by name.
    pub parameters: Vec<(&'static str, String)>,
    /// [`crate::base::identity`].
    pub raster: Vec<(&'static str, String)>,
    /// [`crate::base::identity`] of the importance raster; empty where there is none.
    pub importance: Vec<(&'static str, String)>,
    /// The files of the raster and of the importance raster, looked at before their identity was read.
    pub files: Files,
}

/// A work dir in use. Dropped, it is unlocked and kept, unless there is no finished tile in it and no run laid out.
#[derive(Debug)]
pub struct WorkDir {
    dir: PathBuf,
    manifest: Manifest,
    same_samples: bool,
    /// Of the process that has the work dir for itself; a shard has none, and neither removes anything nor ends the work.
    lock: Option<Lock>,
}

/// The work dir of an earlier run.
#[derive(Debug)]
pub struct Earlier {
    dir: PathBuf,
    stamp: u32,
}

impl Earlier {
    /// The chunks of a pass.
    ///
    /// # Errors
    /// [`SpoolError::Kept`].
    pub fn spool(&self, pass: &Pass) -> Result<Spool, SpoolError> {
        let grid = pass.grid();
        Spool::kept(&self.dir.join(CHUNKS).join(pass.folder()), grid.columns(), grid.len(), self.stamp, true)
    }
}

const CHUNKS: &str = "chunks";
const LOGS: &str = "logs";

impl WorkDir {
    /// Opens the work dir of `job`, or makes one: `dir` is missing (its parent is there), or empty, or has been made by
    /// an earlier run of the same job. The partial output of a killed run is removed.
    ///
    /// # Errors
    /// [`WorkDirError`]: another process works in it, it belongs to another job, it is some other folder.
    pub fn open(dir: &Path, job: &Job) -> Result<WorkDir, WorkDirError> {
        // Outlives a change of the current folder.
        let dir = std::path::absolute(dir).unwrap_or_else(|_| dir.to_path_buf());
        let made = make(&dir)?;
        let path = Manifest::path(&dir);
        if !path.exists() {
            // Before anything is made in a folder that may be anyone's.
            must_be_empty(&dir)?;
        }
        let lock = lock::lock(&dir, made)?;
        if made {
            // The lock file says so from here on.
            durable::mark(&dir, false).map_err(failed(&dir))?;
        }
        remove_leftovers(&dir).map_err(failed(&dir))?;
        // Whoever noted it is dead. Also where the job is another one: the work dir is deleted then, note and all.
        staged_output::remove_partial(&dir).map_err(failed(&dir))?;
        let wanted = Manifest::new(job);
        let kept = match std::fs::read_to_string(&path) {
            Ok(text) => Some(Manifest::parse(&path, &text)?),
            Err(e) if e.kind() == ErrorKind::NotFound => None,
            Err(e) => return Err(failed(&path)(e)),
        };
        let (manifest, same_samples) = match kept {
            Some(kept) => continued(&dir, job, &wanted, kept)?,
            None => {
                must_be_empty(&dir)?;
                // Of which samples it tells is not known any more.
                durable::remove_if_there(&dir.join(files::REPORT)).map_err(failed(&dir))?;
                wanted.write(&dir).map_err(failed(&path))?;
                (wanted, true)
            }
        };
        Ok(WorkDir { dir, manifest, same_samples, lock: Some(lock) })
    }

    /// Joins the work dir of `job`, in which a run has been laid out. Any number of processes may, on any number of machines:
    /// nothing is locked.
    ///
    /// # Errors
    /// [`WorkDirError`]: no run is laid out in it, or it belongs to another job.
    pub fn join(dir: &Path, job: &Job) -> Result<WorkDir, WorkDirError> {
        let dir = std::path::absolute(dir).unwrap_or_else(|_| dir.to_path_buf());
        let path = Manifest::path(&dir);
        let kept = match std::fs::read_to_string(&path) {
            Ok(text) => Manifest::parse(&path, &text)?,
            Err(e) if e.kind() == ErrorKind::NotFound => return Err(WorkDirError::NotPlanned { dir }),
            Err(e) => return Err(failed(&path)(e)),
        };
        let (manifest, same_samples) = continued(&dir, job, &Manifest::new(job), kept)?;
        Ok(WorkDir { dir, manifest, same_samples, lock: None })
    }

    /// The chunks of an earlier run of the same job on another state of its raster, to be read. Nothing is locked
    /// there; nameless temporary files are made.
    ///
    /// # Errors
    /// [`WorkDirError`]: no work dir, or one of a run with other parameters, or of a raster of another size or kind.
    pub fn earlier(&self, dir: &Path) -> Result<Earlier, WorkDirError> {
        let path = Manifest::path(dir);
        let text = match std::fs::read_to_string(&path) {
            Err(e) if e.kind() == ErrorKind::NotFound => {
                return Err(WorkDirError::NoEarlier { dir: dir.to_path_buf() });
            }
            other => other.map_err(failed(&path))?,
        };
        let old = Manifest::parse(&path, &text)?;
        self.manifest.must_be_of_another_state(dir, &old)?;
        Ok(Earlier { dir: dir.to_path_buf(), stamp: old.stamp() })
    }

    /// Lays the run out for shards: they follow this command.
    ///
    /// # Errors
    /// What the system says.
    pub fn lay_out(&self, command: &PlannedCommand) -> io::Result<()> {
        command.write(&self.dir)
    }

    /// Notes that passes with short links have to be made.
    ///
    /// # Errors
    /// What the system says.
    pub fn note_again(&self) -> io::Result<()> {
        layout::note_again(&self.dir)
    }

    /// Notes at which tolerance shards make the tiles of a search's run from now on.
    ///
    /// # Errors
    /// What the system says.
    pub fn note_trial_of_shards(&self, tolerance: f64) -> io::Result<()> {
        layout::note_trial(&self.dir, tolerance)
    }

    /// The tolerance that shards make the tiles of a search's run at, where one is noted.
    ///
    /// # Errors
    /// [`WorkDirError::Io`].
    pub fn trial_of_shards(&self) -> Result<Option<f64>, WorkDirError> {
        layout::trial(&self.dir).map_err(failed(&self.dir))
    }

    /// Whether passes with short links have to be made.
    pub fn is_again(&self) -> bool {
        layout::is_again(&self.dir)
    }

    /// The folder, as an absolute path.
    pub fn path(&self) -> &Path {
        &self.dir
    }

    /// The spool that takes over the chunks of a pass that are there.
    ///
    /// # Errors
    /// [`SpoolError::Kept`].
    pub fn spool(&self, pass: &Pass) -> Result<Spool, SpoolError> {
        self.spool_in(&self.dir.join(CHUNKS), pass)
    }

    /// The same in a folder for chunks, which may be that for all or one in it.
    fn spool_in(&self, folder: &Path, pass: &Pass) -> Result<Spool, SpoolError> {
        let chunks = self.dir.join(CHUNKS);
        for dir in [chunks.as_path(), folder] {
            match durable::create_private_dir(dir) {
                Err(source) if source.kind() != ErrorKind::AlreadyExists => {
                    return Err(SpoolError::Kept { path: dir.to_path_buf(), source });
                }
                _ => {}
            }
        }
        let (dir, grid) = (folder.join(pass.folder()), pass.grid());
        Spool::kept(&dir, grid.columns(), grid.len(), self.manifest.stamp(), !self.same_samples)
    }

    /// Notes where the output is about to be staged.
    ///
    /// # Errors
    /// What the system says.
    pub fn staging(&self, partial: &Path) -> io::Result<()> {
        staged_output::note_partial(&self.dir, partial)
    }

    /// Notes that the staged output is about to take its name, so that [`WorkDir::has_committed`] knows it.
    ///
    /// # Errors
    /// What the system says.
    pub fn committing(&self) -> io::Result<()> {
        staged_output::note_commit(&self.dir)
    }

    /// Whether the file at `output` is one that an earlier run of this job completed just before it was killed: it may
    /// be replaced, by the same bytes.
    pub fn has_committed(&self, output: &Path) -> bool {
        staged_output::has_committed(&self.dir, output)
    }

    /// Whether it is known without a look at any sample that the rasters have those of when it was made.
    pub fn has_same_samples(&self) -> bool {
        self.same_samples
    }

    /// The files of the rasters, as they were when the work dir was made.
    pub fn files(&self) -> &Files {
        &self.manifest.files
    }

    /// Whether there may be finished tiles in it.
    pub fn has_chunks(&self) -> bool {
        self.dir.join(CHUNKS).read_dir().is_ok_and(|mut rows| rows.next().is_some())
    }

    /// What the finished tiles in it take on disk; a look at every one.
    pub fn chunk_bytes(&self) -> u64 {
        chunk_bytes(&self.dir.join(CHUNKS))
    }

    /// The job is done: removes what the work dir keeps, and the folder if it was made for this and holds nothing else.
    ///
    /// # Errors
    /// [`WorkDirError::Io`]; the output is not concerned.
    ///
    /// # Panics
    /// If it was joined: that is not for a shard to say.
    pub fn finish(mut self) -> Result<(), WorkDirError> {
        let lock = self.lock.take().expect("a work dir of one process");
        let chunks = self.dir.join(CHUNKS);
        match std::fs::remove_dir_all(&chunks) {
            Err(e) if e.kind() != ErrorKind::NotFound => return Err(failed(&chunks)(e)),
            _ => faults::reach(Point::ChunksRemoved),
        }
        let logs = self.dir.join(LOGS);
        match std::fs::remove_dir_all(&logs) {
            Err(e) if e.kind() != ErrorKind::NotFound => return Err(failed(&logs)(e)),
            _ => {}
        }
        self.remove_notes(&lock).map_err(failed(&self.dir))
    }

    /// Removes everything but chunks. Whoever comes before the lock goes is refused. Where the output is is known to the last: it is there, and
    /// a run that is killed here has to be done with by the next.
    fn remove_notes(&self, lock: &Lock) -> io::Result<()> {
        let [manifest, others @ .., staged] = notes(&self.dir);
        durable::remove_if_there(&manifest)?;
        faults::reach(Point::ManifestRemoved);
        others.iter().try_for_each(|note| durable::remove_if_there(note))?;
        remove_leftovers(&self.dir)?;
        if lock.made_folder {
            durable::mark(&self.dir, true)?;
        }
        durable::remove_if_there(&self.dir.join(lock::NAME))?;
        faults::reach(Point::LockRemoved);
        durable::remove_if_there(&staged)?;
        if !lock.made_folder {
            return Ok(());
        }
        match std::fs::remove_dir(&self.dir) {
            // It holds something else by now.
            Err(e) if e.kind() == ErrorKind::DirectoryNotEmpty => durable::mark(&self.dir, false),
            Err(e) if e.kind() == ErrorKind::NotFound => Ok(()),
            other => other,
        }
    }
}

/// A run that failed before its first tile leaves nothing that would bind the folder to a job that was never begun.
impl Drop for WorkDir {
    fn drop(&mut self) {
        let Some(lock) = self.lock.take() else { return };
        if self.dir.join(layout::COMMAND).exists() {
            return;
        }
        let removed = std::fs::remove_dir(self.dir.join(CHUNKS));
        if removed.is_ok() || removed.is_err_and(|e| e.kind() == ErrorKind::NotFound) {
            // Nobody is left to be told; what stays is taken up by the next run.
            let _ = self.remove_notes(&lock);
        }
    }
}

/// What the finished tiles in a folder take; what a killed run has left of a tile, nothing.
fn chunk_bytes(dir: &Path) -> u64 {
    let bytes = |entry: std::fs::DirEntry| match entry.metadata() {
        Ok(found) if found.is_dir() => chunk_bytes(&entry.path()),
        Ok(found) if found.is_file() && entry.path().extension().is_some_and(|e| e == "chunk") => found.len(),
        _ => 0,
    };
    dir.read_dir().into_iter().flatten().flatten().map(bytes).sum()
}

/// Makes the folder; false if it is there, unless it was made by a process that was killed before it came to note so.
fn make(dir: &Path) -> Result<bool, WorkDirError> {
    match durable::create_marked_dir(dir) {
        Err(e) if e.kind() == ErrorKind::AlreadyExists => Ok(durable::is_marked(dir)),
        Err(e) => Err(failed(dir)(e)),
        Ok(()) => {
            faults::reach(Point::WorkDirMade);
            let parent = dir.parent().unwrap_or(dir);
            durable::sync_dir(parent).map_err(failed(parent))?;
            Ok(true)
        }
    }
}

/// The files in a work dir that are written more than once, or that a kill may leave unfinished.
fn notes(dir: &Path) -> [PathBuf; 7] {
    let names = [layout::COMMAND, layout::AGAIN, layout::TRIAL, trials::TRIALS, files::REPORT, staged_output::NAME];
    let [command, again, trial, trials, report, staged] = names.map(|name| dir.join(name));
    [Manifest::path(dir), command, again, trial, trials, report, staged]
}

/// What was kept for a job that continues it, and whether the samples are known to be the same.
fn continued(dir: &Path, job: &Job, wanted: &Manifest, kept: Manifest) -> Result<(Manifest, bool), WorkDirError> {
    wanted.must_continue(dir, &kept)?;
    let same_samples = kept.files.same_samples(&job.files);
    Ok((kept, same_samples))
}

/// Removes what killed runs have left of them; nobody else is at work here.
fn remove_leftovers(dir: &Path) -> io::Result<()> {
    notes(dir).iter().try_for_each(|note| private_file::remove_leftovers(note))
}

/// Nothing may be there but what a run leaves that was killed before it had a manifest, or after it had removed it.
fn must_be_empty(dir: &Path) -> Result<(), WorkDirError> {
    let noted = notes(dir);
    for entry in dir.read_dir().map_err(failed(dir))? {
        let path = entry.map_err(failed(dir))?.path();
        let is_left = |note| private_file::is_leftover(path.file_name().unwrap_or_default(), note);
        let ours = path == dir.join(lock::NAME) || noted[1..].contains(&path) || noted.iter().any(|note| is_left(note));
        if !ours {
            return Err(WorkDirError::NotEmpty { dir: dir.to_path_buf(), found: path });
        }
    }
    Ok(())
}

fn failed(path: &Path) -> impl Fn(io::Error) -> WorkDirError + '_ {
    |source| WorkDirError::Io { path: path.to_path_buf(), source }
}

#[cfg(test)]
mod tests;
