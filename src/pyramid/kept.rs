//! What a work dir keeps of tiles: the samples of the grid, what was found out of them, and finished tiles.
//!
//! | name | what |
//! |---|---|
//! | `chunks/grid.samples` | the samples of the finest grid, a [`Store`] |
//! | `chunks/own.samples` | the raster's own samples, where they count, an [`OwnStore`] |
//! | `chunks/grid.json` | what else was found out of the raster ([`Facts`]); it is there only once the samples are |
//! | `chunks/LEVEL/X/Y.chunk` | a tile: its report as a line of JSON, the bytes of its file, a checksum of both and of its address, and the job's stamp |
//! | `chunks/LEVEL/loosened` | this level has the error that clients expect: no tile could be made within less |
//! | `chunks/LEVEL/parts-N` | tiles of this level have at least so many parts each way: one could not be made from fewer; `loosened-parts-N` where it is loosened |
//!
//! Tiles are not synced one by one: what a power cut has torn is found by its checksum, and made again.

use std::fs::{self, File};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use super::TilesRequest;
use super::error::PyramidError;
use super::grid::{Grid, Level, MAX_PARTS, TileKey};
use super::ground::Facts;
use super::own::OwnStore;
use super::report::{LevelReport, TilesReport};
use super::samples::Samples;
use super::store::Store;
use super::write::must_have;
use crate::base::control::Control;
use crate::base::faults::{self, Point};
use crate::base::private_file::{PrivateFile, remove_leftovers};
use crate::base::{RasterError, durable};
use crate::field::FieldError;
use crate::job::work_dir::{Job, PlannedCommand, WorkDir, WorkDirError};

/// A tile as it is kept.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct KeptTile {
    pub(super) report: LevelReport,
    /// The bytes of its file.
    pub(super) content: Vec<u8>,
}

/// The work dir of a run.
pub(super) struct Kept {
    dir: WorkDir,
    parts: PathBuf,
    stamp: [u8; 4],
    /// Files that are not as they were when it was made.
    changed: Vec<String>,
}

impl Kept {
    /// That of a job, for this process alone.
    pub(super) fn open(dir: &Path, job: &Job) -> Result<Kept, PyramidError> {
        let dir = WorkDir::open(dir, job)?;
        let changed = dir.files().differences(&job.files);
        let kept = Kept::of(dir, changed)?;
        [kept.samples(), kept.own_samples(), kept.facts()]
            .iter()
            .try_for_each(|path| remove_leftovers(path).map_err(failed(path)))?;
        Ok(kept)
    }

    /// That of a run that has been laid out, for this process alone.
    pub(super) fn open_laid_out(dir: &Path) -> Result<Kept, PyramidError> {
        Kept::of(WorkDir::open_laid_out(dir)?, Vec::new())
    }

    /// The same, together with others.
    pub(super) fn join_laid_out(dir: &Path) -> Result<Kept, PyramidError> {
        Kept::of(WorkDir::join_laid_out(dir)?, Vec::new())
    }

    fn of(dir: WorkDir, changed: Vec<String>) -> Result<Kept, PyramidError> {
        let (parts, stamp) = (dir.parts()?, dir.stamp().to_le_bytes());
        Ok(Kept { dir, parts, stamp, changed })
    }

    pub(super) fn dir(&self) -> &WorkDir {
        &self.dir
    }

    fn samples(&self) -> PathBuf {
        self.parts.join("grid.samples")
    }

    fn own_samples(&self) -> PathBuf {
        self.parts.join("own.samples")
    }

    /// Whether there are samples that another run of the job goes on from.
    pub(super) fn has_samples(&self) -> bool {
        self.samples().exists()
    }

    fn facts(&self) -> PathBuf {
        self.parts.join("grid.json")
    }

    /// Has other processes follow a command.
    pub(super) fn lay_out(&self, words: Vec<String>) -> Result<(), PyramidError> {
        let write = || self.dir.lay_out(&PlannedCommand::new(words, std::env::current_dir()?, 1));
        write().map_err(failed(self.dir.path()))
    }

    /// What was found out of the raster, where that is kept for this job.
    pub(super) fn read_facts(&self) -> Result<Option<Facts>, PyramidError> {
        let path = self.facts();
        match fs::read(&path) {
            Err(e) if e.kind() == ErrorKind::NotFound => Ok(None),
            // What cannot be read has to be found out again.
            other => {
                Ok(serde_json::from_slice(&other.map_err(failed(&path))?).ok().filter(|f: &Facts| f.is_of(self.stamp)))
            }
        }
    }

    /// Keeps what was found out of the raster.
    pub(super) fn write_facts(&self, facts: &Facts) -> Result<(), PyramidError> {
        let path = self.facts();
        let facts = facts.clone().of_job(self.stamp);
        let write = || {
            PrivateFile::create(&path)?.commit(&serde_json::to_vec(&facts)?, || {})?;
            durable::sync_dir(&self.parts)
        };
        write().map_err(failed(&path))
    }

    /// The heights that are kept; `None` where there are none of this size.
    pub(super) fn open_samples(
        &self,
        size: (usize, usize),
        blocks: (&[u64], &[u32]),
    ) -> Result<Option<Store>, PyramidError> {
        let path = self.samples();
        match File::open(&path) {
            Err(e) if e.kind() == ErrorKind::NotFound => Ok(None),
            other => Store::open(size, (other.map_err(failed(&path))?, &self.parts), blocks),
        }
    }

    /// Has the samples of a raster made in the work dir, and gives their checksum, too. Where the raster may have changed since
    /// others were made there, `expected` is the checksum of those, which they must have.
    pub(super) fn bring_samples(
        &self,
        raster: &Path,
        expected: Option<u32>,
        make: impl FnOnce((File, &Path)) -> Result<Samples, PyramidError>,
    ) -> Result<(Samples, u32), PyramidError> {
        let path = self.samples();
        let file = PrivateFile::create(&path).map_err(failed(&path))?;
        let clone = file.file().try_clone().map_err(failed(&path))?;
        let samples = make((clone, &self.parts)).map_err(on_disk(&path))?;
        let found = checksum(file.file(), &samples.store.runs()).map_err(failed(&path))?;
        must_be_same(raster, "checksum of the grid's samples", expected, found)?;
        file.commit_written(|| faults::reach(Point::ChunkWritten)).map_err(failed(&path))?;
        durable::sync_dir(&self.parts).map_err(failed(&self.parts))?;
        Ok((samples, found))
    }

    /// The raster's own samples that are kept; `None` where there are none, or not all.
    pub(super) fn open_own(&self, grid: Grid) -> Result<Option<OwnStore>, PyramidError> {
        let path = self.own_samples();
        match File::open(&path) {
            Err(e) if e.kind() == ErrorKind::NotFound => Ok(None),
            other => OwnStore::open(grid, (other.map_err(failed(&path))?, &self.parts)),
        }
    }

    /// Has the raster's own samples brought to the work dir, as [`Kept::bring_samples`] does those of the grid.
    pub(super) fn bring_own(
        &self,
        raster: &Path,
        expected: Option<u32>,
        make: impl FnOnce((File, &Path)) -> Result<OwnStore, PyramidError>,
    ) -> Result<(OwnStore, u32), PyramidError> {
        let path = self.own_samples();
        let file = PrivateFile::create(&path).map_err(failed(&path))?;
        let clone = file.file().try_clone().map_err(failed(&path))?;
        let own = make((clone, &self.parts)).map_err(on_disk(&path))?;
        let found = checksum(file.file(), &[]).map_err(failed(&path))?;
        must_be_same(raster, "checksum of the raster's own samples", expected, found)?;
        file.commit_written(|| faults::reach(Point::ChunkWritten)).map_err(failed(&path))?;
        durable::sync_dir(&self.parts).map_err(failed(&self.parts))?;
        Ok((own, found))
    }

    fn tile(&self, tile: TileKey) -> PathBuf {
        self.parts.join(format!("{tile}.chunk"))
    }

    /// A tile that was made as its level is. One that is torn, another's or of another job is none.
    pub(super) fn find(&self, tile: TileKey, level: &Level) -> Result<Option<KeptTile>, PyramidError> {
        let path = self.tile(tile);
        match fs::read(&path) {
            Err(e) if e.kind() == ErrorKind::NotFound => Ok(None),
            other => {
                let found = decode(tile, &other.map_err(failed(&path))?, self.stamp);
                let is_so =
                    |r: &LevelReport| (r.level, r.parts, r.max_error) == (level.level, level.parts, level.max_error);
                Ok(found.filter(|found| is_so(&found.report)))
            }
        }
    }

    /// Keeps a tile.
    pub(super) fn put(&self, tile: TileKey, kept: &KeptTile) -> Result<(), PyramidError> {
        let path = self.tile(tile);
        let write = || {
            let bytes = encode(tile, kept, self.stamp)?;
            let file = match PrivateFile::create(&path) {
                Err(e) if e.kind() == ErrorKind::NotFound => {
                    fs::create_dir_all(path.parent().unwrap_or(&self.parts))?;
                    PrivateFile::create(&path)
                }
                other => other,
            };
            file?.commit_unsynced(&bytes, || faults::reach(Point::ChunkWritten))
        };
        write().map_err(failed(&path))?;
        faults::reach(Point::ChunkRenamed);
        Ok(())
    }

    /// What is found out about a level with the error that clients expect does not hold for less, nor the other way round.
    fn parts_of_level(&self, level: u32, parts: u32, is_loosened: bool) -> PathBuf {
        let of = if is_loosened { "loosened-" } else { "" };
        self.parts.join(format!("{level}/{of}parts-{parts}"))
    }

    /// How many parts tiles of a level have at least; 0 if nothing is known.
    pub(super) fn parts_needed(&self, level: u32, is_loosened: bool) -> u32 {
        let all = (1..).map(|i| 1u32 << i).take_while(|&parts| parts <= MAX_PARTS);
        all.filter(|&parts| self.parts_of_level(level, parts, is_loosened).exists()).last().unwrap_or(0)
    }

    fn loosened(&self, level: u32) -> PathBuf {
        self.parts.join(format!("{level}/loosened"))
    }

    /// Whether a level has the error that clients expect, as no less can be kept.
    pub(super) fn is_loosened(&self, level: u32) -> bool {
        self.loosened(level).exists()
    }

    /// Notes that.
    pub(super) fn note_loosened(&self, level: u32) -> Result<(), PyramidError> {
        self.note(&self.loosened(level))
    }

    /// Notes that a tile of a level cannot be made from fewer parts.
    pub(super) fn note_parts(&self, level: u32, parts: u32, is_loosened: bool) -> Result<(), PyramidError> {
        self.note(&self.parts_of_level(level, parts, is_loosened))
    }

    fn note(&self, path: &Path) -> Result<(), PyramidError> {
        let write = || {
            fs::create_dir_all(path.parent().unwrap_or(&self.parts))?;
            PrivateFile::create(path)?.commit(b"", || {})
        };
        write().map_err(failed(path))
    }

    /// Keeps what is to be told of a set that is about to take its name, and the [list](super::write::StagedSet::list) of its files.
    pub(super) fn keep_report(&self, report: &TilesReport, list: &str) -> Result<(), PyramidError> {
        let mut bytes = serde_json::to_vec(report).map_err(|e| failed(self.dir.path())(e.into()))?;
        bytes.push(b'\n');
        bytes.extend_from_slice(list.as_bytes());
        self.dir.keep_report(&bytes).map_err(failed(self.dir.path()))
    }

    /// What was kept so by a run that was killed afterwards, or that has kept its work dir: its set is there, and made from the same
    /// samples. `None` where the set is to be written anew: for whoever keeps the work dir, or overwrites a set that is not as it was
    /// written.
    ///
    /// # Errors
    /// [`PyramidError::Altered`]: a file of the set is missing, or of another length.
    pub(super) fn report_of(&self, request: &TilesRequest) -> Result<Option<TilesReport>, PyramidError> {
        let Some(bytes) = self.dir.report_of(&request.output).filter(|_| !request.keep_work_dir) else {
            return Ok(None);
        };
        let text = String::from_utf8_lossy(&bytes);
        let Some((report, list)) = text.split_once('\n') else { return Ok(None) };
        match must_have(&request.output, list) {
            Err(PyramidError::Altered { .. }) if request.overwrite => Ok(None),
            other => other.map(|()| serde_json::from_str(report).ok()),
        }
    }

    /// The job is done: it goes.
    pub(super) fn finish(self, control: &Control<'_>) {
        if let Some(warning) = self.dir.finish_or_warn() {
            control.progress.warn(&warning);
        }
    }

    /// A run that did not get through, and what becomes of what it has finished.
    pub(super) fn explain(self, error: PyramidError) -> PyramidError {
        let is_change = matches!(
            &error,
            PyramidError::Raster(e) | PyramidError::Field(FieldError::Raster(e)) if e.is_change()
        );
        if error.is_final() || !self.dir.has_chunks() {
            return error;
        }
        let outdated = is_change.then_some(self.changed);
        PyramidError::Kept { error: Box::new(error), dir: self.dir.path().to_path_buf(), outdated }
    }
}

fn failed(path: &Path) -> impl Fn(std::io::Error) -> PyramidError {
    let path = path.to_path_buf();
    move |source| PyramidError::File { path: path.clone(), source }
}

/// What goes wrong with a file of a work dir is none of a temporary file.
fn on_disk(path: &Path) -> impl Fn(PyramidError) -> PyramidError {
    let path = path.to_path_buf();
    move |error| match error {
        PyramidError::Field(FieldError::Temporary { source, .. }) => PyramidError::File { path: path.clone(), source },
        other => other,
    }
}

/// Where the raster may have changed, its samples must be those that are kept.
fn must_be_same(raster: &Path, what: &str, expected: Option<u32>, found: u32) -> Result<(), PyramidError> {
    match expected.filter(|expected| *expected != found) {
        None => Ok(()),
        Some(expected) => {
            let (path, what) = (raster.to_path_buf(), what.to_string());
            let (expected, found) = (format!("{expected:08x}"), format!("{found:08x}"));
            Err(RasterError::Changed { path, what, expected, found }.into())
        }
    }
}

impl From<WorkDirError> for PyramidError {
    fn from(error: WorkDirError) -> PyramidError {
        PyramidError::WorkDir(error)
    }
}

/// A checksum of all bytes of a file that has just been written, and of which blocks are in it.
fn checksum(file: &File, runs: &[u64]) -> std::io::Result<u32> {
    use std::os::unix::fs::FileExt;
    let (mut hasher, mut buffer, mut at) = (crc32fast::Hasher::new(), vec![0; 4 << 20], 0);
    runs.iter().for_each(|run| hasher.update(&run.to_le_bytes()));
    loop {
        match file.read_at(&mut buffer, at)? {
            0 => return Ok(hasher.finalize()),
            read => {
                hasher.update(&buffer[..read]);
                at += read as u64;
            }
        }
    }
}

fn encode(tile: TileKey, kept: &KeptTile, stamp: [u8; 4]) -> std::io::Result<Vec<u8>> {
    let mut bytes = serde_json::to_vec(&kept.report)?;
    bytes.push(b'\n');
    bytes.extend_from_slice(&kept.content);
    bytes.extend(sum(tile, &bytes).to_le_bytes());
    bytes.extend(stamp);
    Ok(bytes)
}

/// `None` where it is not what [`encode`] made of this tile for this job.
fn decode(tile: TileKey, bytes: &[u8], stamp: [u8; 4]) -> Option<KeptTile> {
    let (bytes, found) = bytes.split_last_chunk::<4>()?;
    let (bytes, checksum) = bytes.split_last_chunk::<4>()?;
    if *found != stamp || u32::from_le_bytes(*checksum) != sum(tile, bytes) {
        return None;
    }
    let end = bytes.iter().position(|&b| b == b'\n')?;
    Some(KeptTile { report: serde_json::from_slice(&bytes[..end]).ok()?, content: bytes[end + 1..].to_vec() })
}

fn sum(tile: TileKey, bytes: &[u8]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    [tile.level, tile.x, tile.y].iter().for_each(|number| hasher.update(&number.to_le_bytes()));
    hasher.update(bytes);
    hasher.finalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tile_is_found_whole_or_not_at_all() {
        let level = Level { level: 3, max_error: 0.1, client_error: 0.3, parts: 2 };
        let report = LevelReport { largest_error: 0.1 + 0.2, triangles: 7, ..LevelReport::new(&level) };
        let kept = KeptTile { report, content: b"a tile\nof bytes".to_vec() };
        let (tile, stamp) = (TileKey { level: 3, x: 5, y: 1 }, *b"job1");
        let bytes = encode(tile, &kept, stamp).expect("plain data");
        assert_eq!(decode(tile, &bytes, stamp), Some(kept));
        assert_eq!(decode(TileKey { x: 6, ..tile }, &bytes, stamp), None);
        assert_eq!(decode(tile, &bytes, *b"job2"), None);
        for end in 0..bytes.len() {
            assert_eq!(decode(tile, &bytes[..end], stamp), None);
        }
        for at in 0..bytes.len() {
            let mut torn = bytes.clone();
            torn[at] ^= 4;
            assert_eq!(decode(tile, &torn, stamp), None);
        }
    }
}
