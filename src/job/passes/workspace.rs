//! What one thread needs for a tile, whatever the pass.

use super::Job;
use crate::base::handed_over::{DENSE_BYTES, clear};
use crate::base::{RasterError, Tile, Window};
use crate::field::{Field, LoadScratch};
use crate::job::spool::Chunk;
use crate::job::{Error, Params};
use crate::kernel::breaklines::TileChains;

/// The samples of a tile and its chunk; reused from tile to tile, but for dense ones.
#[derive(Default)]
pub(in crate::job) struct Workspace {
    pub(in crate::job) tile: Tile,
    loading: LoadScratch,
    /// Samples of the tile that are to be vertices, by rows, then by columns.
    pub(super) points: Vec<(usize, usize)>,
    /// The chains of breaklines in the tile.
    pub(super) chains: TileChains,
    pub(super) chunk: Chunk,
    pub(super) encoded: Vec<u8>,
}

impl Workspace {
    /// Loads the samples of a window, eases those beside lines with heights of their own, lifts the limit on straying beside lines, and takes
    /// the ground away that is outside of outlines.
    pub(super) fn load(&mut self, field: &Field, params: &Params, window: Window) -> Result<(), Error> {
        field.load_with(window, &mut self.tile, &mut self.loading)?;
        if let Some(lines) = &params.breaklines {
            let lines = lines.near(window)?;
            lines.ease(&mut self.tile, window, params.points.as_deref(), params.tolerance.kept());
            if params.straying(params.features()).is_finite() {
                lines.unbind(&mut self.tile, window);
            }
            lines.cut(&mut self.tile, window);
        }
        Ok(())
    }

    /// The tile is done: frees what a dense one has taken.
    pub(super) fn hand_over(&mut self) {
        self.chunk.hand_over();
        clear(&mut self.encoded, DENSE_BYTES);
    }

    /// Finds the points and the chains in a window.
    pub(super) fn find_features(&mut self, job: &Job<'_>, window: Window) -> Result<(), Error> {
        self.points.clear();
        if let Some(points) = &job.params.points {
            points.within(window, &mut self.points);
        }
        if let Some(chains) = &job.chains {
            chains.within(window, &mut self.chains)?;
        }
        Ok(())
    }

    /// The checksum of what is loaded and found: of the samples, and of the chains of breaklines.
    pub(super) fn checksum(&self) -> u32 {
        let samples = self.tile.checksum();
        if self.chains.vertices().is_empty() {
            return samples;
        }
        let mut hasher = crc32fast::Hasher::new_with_initial(samples);
        self.chains.hash(&mut hasher);
        hasher.finalize()
    }

    /// Loads the samples of a window, finds its features, and tells whether the chunk was made from the same. Gives both checksums.
    pub(super) fn compare(&mut self, job: &Job<'_>, window: Window) -> Result<[u32; 2], Error> {
        self.load(job.field, job.params, window)?;
        self.find_features(job, window)?;
        Ok([self.chunk.samples_checksum, self.checksum()])
    }

    /// Makes sure that the chunk was made from the samples that a window has now.
    pub(super) fn check_samples(&mut self, job: &Job<'_>, window: Window) -> Result<(), Error> {
        let [expected, found] = self.compare(job, window)?;
        if expected == found {
            return Ok(());
        }
        let Window { column, row, width, height } = window;
        let field = job.field;
        let samples = if field.importance().is_some() { "samples and weights" } else { "samples" };
        let what = format!("{width} × {height} {samples} at column {column}, row {row} with the checksum");
        let [expected, found] = [expected, found].map(|checksum| format!("{checksum:08x}"));
        Err(RasterError::Changed { path: field.name().to_path_buf(), what, expected, found }.into())
    }
}
