//! What came of making tiles, as data and as lines.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::Level;
use crate::job::plan::{Fitted, mebibytes};

/// What came of one level, or of one tile of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LevelReport {
    /// The level.
    pub level: u32,
    /// What its surface is within, in metres.
    pub max_error: f64,
    /// The client's error.
    pub client_error: f64,
    /// Parts of a tile, each way.
    pub parts: u32,
    /// Tiles.
    pub tiles: u64,
    /// Triangles of all of them.
    pub triangles: u64,
    /// Vertices of all of them.
    pub vertices: u64,
    /// Samples that were measured; those on the border of tiles count for each of them.
    pub samples: u64,
    /// The largest error at a sample of the finest grid, and of the raster itself where those count, as decoded; the bound of rounding
    /// is in it.
    pub largest_error: f64,
    /// Bytes of tiles, before they are compressed.
    pub bytes: u64,
    /// Bytes of the files.
    pub bytes_in_files: u64,
    /// How long it took.
    pub seconds: f64,
}

impl LevelReport {
    pub(super) fn new(level: &Level) -> LevelReport {
        LevelReport {
            level: level.level,
            max_error: level.max_error,
            client_error: level.client_error,
            parts: level.parts,
            tiles: 0,
            triangles: 0,
            vertices: 0,
            samples: 0,
            largest_error: 0.0,
            bytes: 0,
            bytes_in_files: 0,
            seconds: 0.0,
        }
    }

    pub(super) fn add(&mut self, other: &LevelReport) {
        self.tiles += other.tiles;
        self.triangles += other.triangles;
        self.vertices += other.vertices;
        self.samples += other.samples;
        self.largest_error = self.largest_error.max(other.largest_error);
        self.bytes += other.bytes;
        self.bytes_in_files += other.bytes_in_files;
    }
}

/// What came of making tiles.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TilesReport {
    /// The version of this report.
    pub schema: u32,
    /// The folder.
    pub output: PathBuf,
    /// The CRS of the raster.
    pub crs: String,
    /// The vertical CRS that heights were brought from; empty where they were taken as ellipsoidal.
    pub vertical_crs: String,
    /// The finest grid has 2 to the power of this cells from pole to pole.
    pub grid_exponent: u32,
    /// Samples of the grid in the rectangle around the raster.
    pub grid_samples: u64,
    /// Whether errors hold at the raster's own samples, too.
    pub own_samples: bool,
    /// How it fitted into its budget of memory.
    pub memory: Fitted,
    /// The most that the process has held, where the system says so.
    pub peak_memory_bytes: Option<u64>,
    /// Bytes of temporary files.
    pub temporary_bytes: u64,
    /// Tiles that were in the work dir.
    pub tiles_found: u64,
    /// The levels, from 0 on.
    pub levels: Vec<LevelReport>,
    /// Seconds until all samples were on the grid.
    pub seconds_resampling: f64,
    /// Seconds in all.
    pub seconds: f64,
}

impl std::fmt::Display for TilesReport {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (tiles, bytes) = self.levels.iter().fold((0, 0), |(t, b), l| (t + l.tiles, b + l.bytes_in_files));
        let finest = self.levels.last().map_or(0, |l| l.level);
        let heights = match self.vertical_crs.as_str() {
            "" => "taken as ellipsoidal, as no vertical CRS is known".to_string(),
            vertical => format!("brought from {vertical} to ellipsoidal"),
        };
        writeln!(f, "tiles    {tiles} of levels 0 to {finest}, {bytes} bytes, in {}", self.output.display())?;
        if self.tiles_found > 0 {
            writeln!(f, "found    {} of these tiles in the work dir", self.tiles_found)?;
        }
        writeln!(f, "heights  {heights}")?;
        let own = if self.own_samples { " and of the raster's own samples" } else { "" };
        let exponent = self.grid_exponent;
        writeln!(f, "grid     180° ÷ 2^{exponent}; errors are those of the resampled surface{own}, in metres")?;
        writeln!(f, "level  tiles  triangles    allowed    largest")?;
        for l in &self.levels {
            let (allowed, largest) = (l.max_error, l.largest_error);
            writeln!(f, "{:>5} {:>6} {:>10} {allowed:>10.3} {largest:>10.3}", l.level, l.tiles, l.triangles)?;
        }
        let (peak, budget) = (self.peak_memory_bytes.map(mebibytes), mebibytes(self.memory.budget_bytes));
        let (peak, threads) = (peak.unwrap_or("unknown".to_string()), self.memory.threads);
        writeln!(f, "memory   {peak} at its peak, of {budget} allowed; {threads} threads")?;
        write!(f, "time     {:.1} s, of which {:.1} s for the grid", self.seconds, self.seconds_resampling)
    }
}
