//! What a terrain is to be like.

/// What the ground looks like. The height at a place depends on these numbers and the place alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TerrainOptions {
    /// Every seed is another world.
    pub seed: u64,
    /// Height of the highest mountains above the lowest plains, about, in metres.
    pub relief_m: f64,
    /// How much of the relief is in short waves: 0 is rolling, 1 is rugged.
    pub roughness: f64,
    /// Share of the area that is lake, each exactly flat.
    pub lakes: f64,
    /// Share of the area without heights.
    pub nodata_share: f64,
    /// Whether faults cut the ground, with vertical steps.
    pub cliffs: bool,
}

impl Default for TerrainOptions {
    fn default() -> Self {
        TerrainOptions { seed: 0, relief_m: 1500.0, roughness: 0.5, lakes: 0.0, nodata_share: 0.0, cliffs: false }
    }
}

/// A number that an option cannot take.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{option}: expected {expected}, found {found}")]
pub struct OptionError {
    /// The option, as the command line names it without dashes.
    pub option: &'static str,
    /// What it takes.
    pub expected: &'static str,
    /// What it was given.
    pub found: String,
}

impl OptionError {
    fn unless(ok: bool, option: &'static str, expected: &'static str, found: impl ToString) -> Result<(), OptionError> {
        if ok { Ok(()) } else { Err(OptionError { option, expected, found: found.to_string() }) }
    }
}

impl TerrainOptions {
    /// # Errors
    /// [`OptionError`] for the first number out of its range.
    pub fn check(&self) -> Result<(), OptionError> {
        let share = |f: f64| (0.0..=0.9).contains(&f);
        OptionError::unless(
            self.relief_m > 0.0 && self.relief_m <= 25_000.0,
            "relief",
            "metres above 0, up to 25000",
            self.relief_m,
        )?;
        OptionError::unless(
            (0.0..=1.0).contains(&self.roughness),
            "roughness",
            "a number from 0 to 1",
            self.roughness,
        )?;
        OptionError::unless(
            (0.0..=0.75).contains(&self.lakes),
            "lakes",
            "a share from 0 to 0.75: the rest is the rims between them",
            self.lakes,
        )?;
        OptionError::unless(share(self.nodata_share), "nodata-share", "a share from 0 to 0.9", self.nodata_share)
    }
}

/// How a sample is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum StoredAs {
    /// Whole metres, nodata −32768.
    Int16,
    /// Single precision, nodata −9999.
    #[default]
    Float32,
    /// Double precision, nodata −9999.
    Float64,
}

/// How the samples are laid out in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BlockLayout {
    /// Square tiles; their side in samples, a multiple of 16.
    Tiles(usize),
    /// Strips; their height in rows.
    Strips(usize),
}

/// How blocks are compressed. The predictor follows from the sample type.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[allow(missing_docs)]
pub enum Compression {
    None,
    #[default]
    Deflate,
    Lzw,
    Zstd,
}

/// A raster to be made: its ground and its file.
#[derive(Debug, Clone, PartialEq)]
pub struct SynthOptions {
    /// Samples across.
    pub width: usize,
    /// Samples down.
    pub height: usize,
    /// The ground.
    pub terrain: TerrainOptions,
    /// The sample type.
    pub stored_as: StoredAs,
    /// The blocks.
    pub layout: BlockLayout,
    /// The compression.
    pub compression: Compression,
    /// Distance of neighbouring samples on the map. It places the raster, and does not change the heights.
    pub cell_m: f64,
    /// Whether the file is big-endian.
    pub big_endian: bool,
    /// Whether an existing file is replaced.
    pub overwrite: bool,
}

impl Default for SynthOptions {
    fn default() -> Self {
        SynthOptions {
            width: 1024,
            height: 1024,
            terrain: TerrainOptions::default(),
            stored_as: StoredAs::default(),
            layout: BlockLayout::Tiles(256),
            compression: Compression::default(),
            cell_m: 10.0,
            big_endian: false,
            overwrite: false,
        }
    }
}

/// The longest side: what GDAL's 32-bit sizes hold.
const LONGEST: usize = i32::MAX as usize;

impl SynthOptions {
    /// # Errors
    /// [`OptionError`] for the first number out of its range.
    pub fn check(&self) -> Result<(), OptionError> {
        self.terrain.check()?;
        let side = |n: usize| (2..=LONGEST).contains(&n);
        OptionError::unless(
            side(self.width) && side(self.height),
            "size",
            "2 to 2147483647 samples each way",
            format!("{}x{}", self.width, self.height),
        )?;
        OptionError::unless(
            self.cell_m > 0.0 && self.cell_m <= 1e6,
            "cell",
            "metres above 0, up to 1000000",
            self.cell_m,
        )?;
        match self.layout {
            BlockLayout::Tiles(n) => OptionError::unless(
                n % 16 == 0 && (16..=4096).contains(&n),
                "block",
                "a multiple of 16 from 16 to 4096",
                n,
            ),
            BlockLayout::Strips(n) => OptionError::unless((1..=4096).contains(&n), "strip", "1 to 4096 rows", n),
        }
    }
}
