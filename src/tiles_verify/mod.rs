//! Judges a set of terrain tiles against the raster that it was made from.
//!
//! In come the raster and the folder; out comes a [`Verdict`]. `decode` reads files, `ellipsoid` has formulas of its own, `tile`
//! judges a tile by itself, `holes` where it has none of the ground, `strays` how far its edges are off between samples, `normals` those of its
//! vertices, `borders` where tiles meet, `manifest` what stands beside them, `own` how far tiles are from samples of the raster itself, by rows
//! (`own_rows`) where those lie in some. `facet` is a triangle, `facets` all of a tile, `scan` finds how far they are from heights in rows and columns, `known`
//! is what threads know together. It shares with
//! [`crate::pyramid`] which samples the finest grid has and what their heights are, the addresses of tiles, and the form of
//! `terrabite.json`; nothing of how meshes are made, written or measured.
//!
//! **Why that is a proof.** Triangles of a tile have positive area, no side of an edge has two, edges with one are on the border,
//! and areas add up to the square: so they tile it. The normal at every sample is intersected with all triangles near it, or the sample is so far inside
//! one that its normal meets it, as `facet` proves; the
//! largest distance counts, with a bound of rounding added: a coordinate is off by less than 4·10⁻⁹ m, so a height by less
//! than 2·10⁻⁸ m times the secant of the slope. What surely is not farther than another sample of its level, and within the error, is not looked at more
//! closely, so what is reported is the largest of all. A sample that no triangle is found for fails, so the search
//! for triangles near it need not be trusted. Every sample of the grid is in a tile of the finest level, which is counted.
//!
//! **Memory.** The borders of all tiles, 24 bytes a vertex; a tile and a window of samples per thread. `size` reckons beforehand.

mod borders;
mod decode;
mod ellipsoid;
mod facet;
mod facets;
mod findings;
#[cfg(test)]
mod hole_tests;
mod holes;
mod known;
mod manifest;
#[cfg(test)]
mod normal_tests;
mod normals;
mod own;
mod own_rows;
#[cfg(test)]
mod own_tests;
mod scan;
mod size;
#[cfg(test)]
mod stray_tests;
mod strays;
#[cfg(test)]
mod tests;
mod tile;

use std::collections::{BTreeMap, BTreeSet};
use std::io::Read;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use serde::Serialize;

pub use borders::Gap;
pub use own::OwnSamples;
pub use strays::Strays;

use self::borders::{Borders, Sides};
use self::decode::Decoded;
use self::ellipsoid::Ellipsoid;
use self::findings::{Findings, Kind};
use self::known::Known;
use self::own::OwnTask;
use self::scan::Limits;
use self::strays::Held;
use self::tile::{Distance, Tile};
use crate::base::control::{Control, Stage};
use crate::job::plan::Fitted;
use crate::pyramid::{
    Basis, Grid, PROMISE, Patch, Promise, PyramidError, SampleBlock, Samples, TileKey, TilesRequest, with_basis,
};
use crate::raster::View;

/// What is judged.
#[derive(Debug, Clone)]
pub struct TilesVerifyRequest {
    /// The raster.
    pub input: PathBuf,
    /// How it is looked at: as it was when the tiles were made.
    pub view: View,
    /// The folder of tiles.
    pub tiles: PathBuf,
    /// The most memory to use; `None` is [`crate::job::default_budget`].
    pub memory: Option<u64>,
    /// Threads, fewer if the memory is for fewer; `None`: as many as there are cores.
    pub threads: Option<NonZeroUsize>,
    /// The folder of temporary files; `None` is the system's.
    pub temp_dir: Option<PathBuf>,
}

/// What was found of a level.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LevelVerdict {
    /// The level.
    pub level: u32,
    /// What it promises, in metres.
    pub max_error: f64,
    /// Tiles.
    pub tiles: u64,
    /// Triangles.
    pub triangles: u64,
    /// Samples that were compared; those on borders count for every tile.
    pub samples: u64,
    /// The largest distance from a sample.
    pub largest_error: f64,
    /// How far edges stray between samples.
    pub strays: Strays,
    /// What was found at the raster's own samples. It is a fault only where the set promises to be within the error there.
    pub own_samples: OwnSamples,
}

/// What was found of a set of tiles.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Verdict {
    /// The version of this report.
    pub schema: u32,
    /// Whether the set keeps its promise.
    pub passed: bool,
    /// What is wrong, one sentence for each kind of fault.
    pub failures: Vec<String>,
    /// In what the raster is looked at otherwise than when the tiles were made, which may be the reason.
    pub other_view: Vec<String>,
    /// The levels.
    pub levels: Vec<LevelVerdict>,
    /// The largest gap between tiles of any two levels that meet.
    pub gaps: Vec<Gap>,
    /// How judging them fitted into its budget of memory.
    pub memory: Fitted,
}

impl std::fmt::Display for Verdict {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        writeln!(
            f,
            "level  tiles  triangles    allowed    largest   strays  at own samples  above  gap to the level above"
        )?;
        for l in &self.levels {
            let gap = self.gaps.iter().find(|g| g.finer == l.level && g.coarser + 1 == l.level);
            let gap = gap.map_or(String::new(), |g| format!("{:.3} of {:.3}", g.largest, g.allowed));
            let (allowed, largest) = (l.max_error, l.largest_error);
            let (own, above) = (l.own_samples.largest_error, 100.0 * l.own_samples.share_above);
            write!(f, "{:>5} {:>6} {:>10} {allowed:>10.3} {largest:>10.3} ", l.level, l.tiles, l.triangles)?;
            write!(f, "{:>8.3} ", l.strays.largest)?;
            writeln!(f, "{own:>15.3} {above:>4.2} %  {gap}")?;
        }
        for failure in &self.failures {
            writeln!(f, "failed: {failure}")?;
        }
        for difference in &self.other_view {
            writeln!(f, "note: the tiles were made from another view of the raster: {difference}")?;
        }
        write!(f, "{}", if self.passed { "passed" } else { "NOT passed" })
    }
}

/// Judges a set of tiles. One that is merely wrong is a verdict.
///
/// # Errors
/// [`PyramidError`]: the raster cannot be read, the folder holds no set, or the caller asked to stop.
pub fn tiles_verify(request: &TilesVerifyRequest, control: &Control<'_>) -> Result<Verdict, PyramidError> {
    let promise = promise(&request.tiles)?;
    let grid = Grid { exponent: promise.grid_exponent };
    let asked = TilesRequest {
        view: request.view.clone(),
        vertical_crs: promise.vertical_crs_given.clone(),
        outside: promise.outside,
        void_as: promise.void_as,
        memory: request.memory,
        threads: request.threads,
        temp_dir: request.temp_dir.clone(),
        ..TilesRequest::new(&request.input, &request.tiles, promise.max_error)
    };
    let found = manifest::files(&request.tiles)?;
    let judging = size::judging(&request.tiles, &found, promise.gzip);
    with_basis(&asked, grid, judging, control, |basis| judge(request, &promise, &found, basis, control))
}

fn promise(folder: &Path) -> Result<Promise, PyramidError> {
    let path = folder.join(PROMISE);
    let wrong = |found: String| PyramidError::NotTiles { path: path.clone(), found };
    let text = std::fs::read_to_string(&path).map_err(|e| wrong(e.to_string()))?;
    let promise: Promise = serde_json::from_str(&text).map_err(|e| wrong(e.to_string()))?;
    let sound = promise.schema == 1 && (7..=26).contains(&promise.grid_exponent) && !promise.levels.is_empty();
    let deepest = promise.grid_exponent as usize - 3;
    if !sound || promise.levels.len() > deepest + 1 {
        return Err(wrong("numbers out of range".to_string()));
    }
    Ok(promise)
}

/// What was found of one tile.
struct Judged {
    key: TileKey,
    findings: Findings,
    distance: Distance,
    strays: Strays,
    /// Whether its triangles tile its square.
    is_tiling: bool,
    triangles: u64,
    step: f64,
    /// How far corners that the raster gives no height are from the height that is promised there.
    beside: f64,
    sides: Option<Sides>,
}

fn judge(
    request: &TilesVerifyRequest,
    promise: &Promise,
    found: &BTreeSet<TileKey>,
    basis: Basis,
    control: &Control<'_>,
) -> Result<Verdict, PyramidError> {
    let Basis { samples, coarsest, body, vertical_crs, view, memory } = basis;
    let grid = samples.grid;
    let ellipsoid = Ellipsoid { a: body.semi_major, b: body.semi_minor };
    let mut findings = Findings::default();
    if (promise.semi_major, promise.semi_minor) != (body.semi_major, body.semi_minor) {
        findings.add(Kind::Manifest, || "the tiles are on another ellipsoid than the raster".to_string());
    }
    if promise.vertical_crs != vertical_crs {
        let found = &promise.vertical_crs;
        findings.add(Kind::Manifest, || format!("expected the vertical CRS \"{vertical_crs}\", found \"{found}\""));
    }
    manifest::judge_layer(&request.tiles, found, promise.levels.len(), &mut findings);
    manifest::judge_promise(promise, &ellipsoid, coarsest.exponent, &mut findings);
    judge_files(found, promise.levels.len() as u32, &mut findings);

    let is_judged = |key: &TileKey| (key.level as usize) < promise.levels.len() && is_on_the_globe(key);
    let keys: Vec<TileKey> = found.iter().copied().filter(is_judged).collect();
    control.progress.begin(Stage::Compare, keys.len() as u64, keys.len() as u64);
    let task = TileTask {
        folder: &request.tiles,
        promise,
        ellipsoid: &ellipsoid,
        samples: &samples,
        known: promise.levels.iter().map(|_| LevelKnown::default()).collect(),
    };
    let one = |block: &mut SampleBlock, &key: &TileKey| {
        control.cancel.check()?;
        let judged = task.judge(key, block)?;
        control.progress.step(Stage::Compare, 1);
        Ok(judged)
    };
    // One after the other they are near each other, and have blocks of samples in common.
    let mut in_order = keys.clone();
    in_order.sort_by_cached_key(|key| (key.level, along_curve(key)));
    let judged: Result<Vec<Judged>, PyramidError> = in_order.par_iter().map_init(SampleBlock::default, one).collect();
    control.progress.end(Stage::Compare);
    let mut judged = judged?;
    judged.sort_by_key(|tile| tile.key);
    let tiling = judged.iter().filter(|tile| tile.is_tiling).map(|tile| tile.key).collect();
    let level = |level: &crate::pyramid::Level| LevelVerdict {
        level: level.level,
        max_error: level.max_error,
        tiles: 0,
        triangles: 0,
        samples: 0,
        largest_error: 0.0,
        strays: Strays::default(),
        own_samples: OwnSamples::default(),
    };
    let mut levels: Vec<LevelVerdict> = promise.levels.iter().map(level).collect();
    let (mut steps, mut beside) = (vec![0.0f64; levels.len()], vec![0.0f64; levels.len()]);
    let mut sides = BTreeMap::new();
    let mut owned = vec![0u64; levels.len()];
    for tile in judged {
        findings.merge(tile.findings);
        let number = tile.key.level as usize;
        let level = &mut levels[number];
        level.tiles += 1;
        level.triangles += tile.triangles;
        level.samples += tile.distance.samples;
        level.largest_error = level.largest_error.max(tile.distance.largest);
        level.strays = level.strays.with(tile.strays);
        owned[number] += tile.distance.owned;
        steps[number] = steps[number].max(tile.step);
        beside[number] = beside[number].max(tile.beside);
        sides.extend(tile.sides.map(|s| (tile.key, s)));
    }
    for (level, (off, step)) in beside.iter().zip(&steps).enumerate().filter(|(_, (off, step))| **off > 0.5 * **step) {
        findings.add(Kind::Manifest, || {
            format!(
                "corners of tiles of level {level} are {off} m from the height outside, steps of heights are {step} m"
            )
        });
    }
    let expected = count(&samples)?;
    for (level, owned) in owned.iter().enumerate().filter(|(_, owned)| **owned != expected) {
        findings.add(Kind::Files, || format!("tiles of level {level} have {owned} of the raster's {expected} samples"));
    }
    let own_samples = promise.own_samples;
    let borders =
        Borders { grid, ellipsoid: &ellipsoid, samples: &samples, levels: &promise.levels, sides, steps, own_samples };
    borders.judge_levels(&mut findings);
    let gaps = borders.judge_gaps(&mut findings)?;
    let own = OwnTask {
        request,
        promise,
        ellipsoid: &ellipsoid,
        grid_samples: &samples,
        tiles: &keys.into_iter().collect(),
        tiling: &tiling,
        known: promise.levels.iter().map(|_| Known::default()).collect(),
    };
    levels.iter_mut().zip(own.judge(control)?).for_each(|(level, own)| level.own_samples = own);
    for level in levels.iter().filter(|level| promise.own_samples && level.own_samples.above > 0) {
        let OwnSamples { samples, largest_error, above, .. } = level.own_samples;
        findings.add(Kind::OwnSamples, || {
            let (level, allowed) = (level.level, level.max_error);
            format!(
                "level {level}: {above} of {samples} samples of the raster itself are farther than {allowed} m from the \
                 surface, as far as {largest_error} m"
            )
        });
    }
    let (failures, other_view) = (findings.sentences(), differences(&promise.view, &view));
    Ok(Verdict { schema: 1, passed: failures.is_empty(), failures, other_view, levels, gaps, memory })
}

/// In what two views differ, by the names of options. Nothing is known of tiles that say nothing.
fn differences(made: &BTreeMap<String, String>, found: &BTreeMap<String, String>) -> Vec<String> {
    if made.is_empty() {
        return Vec::new();
    }
    let names: BTreeSet<&String> = made.keys().chain(found.keys()).collect();
    let said = |view: &BTreeMap<String, String>, name| view.get(name).map_or("none", String::as_str).to_string();
    let differing = names.into_iter().filter(|&name| made.get(name) != found.get(name));
    differing.map(|name| format!("{name}: expected {}, found {}", said(made, name), said(found, name))).collect()
}

/// The place of a tile on a curve through all of its level: bits of its column and row in turns.
fn along_curve(key: &TileKey) -> u64 {
    let bit_of = |number: u32, bit: u32| u64::from((number >> bit) & 1);
    (0..32).fold(0, |at, bit| at | (bit_of(key.x, bit) << (2 * bit)) | (bit_of(key.y, bit) << (2 * bit + 1)))
}

/// Whether a level has such a column and row.
fn is_on_the_globe(key: &TileKey) -> bool {
    u64::from(key.x) < 2u64 << key.level && u64::from(key.y) < 1u64 << key.level
}

/// Every tile has its parent, both roots are there, and no level is deeper than promised.
fn judge_files(found: &BTreeSet<TileKey>, levels: u32, findings: &mut Findings) {
    for root in (0..2).map(|x| TileKey { level: 0, x, y: 0 }).filter(|root| !found.contains(root)) {
        findings.add(Kind::Files, || format!("tile {root} is missing"));
    }
    for key in found {
        if key.level >= levels {
            findings.add(Kind::Files, || format!("tile {key} is of a level that nothing is promised of"));
        } else if !is_on_the_globe(key) {
            findings.add(Kind::Files, || format!("tile {key} is beyond the columns and rows of its level"));
        } else if key.level > 0 && !found.contains(&key.parent()) {
            findings.add(Kind::Files, || format!("tile {key} has no tile above it"));
        }
    }
}

/// What tiles are judged by.
struct TileTask<'a> {
    folder: &'a Path,
    promise: &'a Promise,
    ellipsoid: &'a Ellipsoid,
    samples: &'a Samples,
    known: Vec<LevelKnown>,
}

/// The largest that was found of a level so far.
#[derive(Default)]
struct LevelKnown {
    error: Known,
    strays: strays::KnownStrays,
}

impl TileTask<'_> {
    fn judge(&self, key: TileKey, block: &mut SampleBlock) -> Result<Judged, PyramidError> {
        let TileTask { promise, samples, .. } = *self;
        let mut findings = Findings::default();
        let (distance, strays) = (Distance::default(), Strays::default());
        let decoded = match read(&self.folder.join(format!("{key}.terrain")), promise.gzip) {
            Ok(decoded) => decoded,
            Err(reason) => {
                findings.add(Kind::Format, || format!("tile {key}: {reason}"));
                let (triangles, step, beside) = (0, 0.0, 0.0);
                let is_tiling = false;
                return Ok(Judged { key, findings, distance, strays, is_tiling, triangles, step, beside, sides: None });
            }
        };
        let tile = Tile::new(key, samples.grid, self.ellipsoid, &decoded, promise.void_as);
        let is_tiling = tile.judge_shape(&mut findings);
        if tile.has_holes {
            tile.judge_holes(samples, block, &mut findings)?;
        }
        tile.judge_normals(samples, promise.own_samples, block, &mut findings)?;
        if promise.fine_heights {
            tile.judge_range(&mut findings);
        }
        let (level, known) = (&promise.levels[key.level as usize], &self.known[key.level as usize]);
        let limits = Limits { known: known.error.so_far(), allowed: level.max_error };
        let distance = tile.distance(samples, block, (limits, is_tiling), &mut findings)?;
        known.error.raise(distance.largest);
        let limit = promise.max_stray.map_or(f64::INFINITY, |factor| factor * level.max_error);
        let held = Held { limit, parts: level.parts, known: &known.strays };
        let strays = tile.strays(samples, block, held, &mut findings)?;
        let (triangles, step) = (decoded.triangles.len() as u64, borders::step(&tile));
        let beside = tile.beside(samples, promise.void_as, block)?;
        let sides = Some(Sides::of(&decoded));
        Ok(Judged { key, findings, distance, strays, is_tiling, triangles, step, beside, sides })
    }
}

/// Reads a tile, compressed or not, as all of a set are: a server says one thing of all of them.
fn read(path: &Path, gzip: bool) -> Result<Decoded, String> {
    let mut bytes = std::fs::read(path).map_err(|e| e.to_string())?;
    match (gzip, bytes.starts_with(&[0x1f, 0x8b])) {
        (true, false) => return Err("expected gzip, as terrabite.json says, found a plain file".to_string()),
        (false, true) => return Err("expected a plain file, as terrabite.json says, found gzip".to_string()),
        _ => {}
    }
    if gzip {
        /// More than any tile of 65,536 vertices has.
        const MOST: u64 = 8 << 20;
        let mut plain = Vec::new();
        let mut decoder = flate2::bufread::GzDecoder::new(bytes.as_slice()).take(MOST);
        decoder.read_to_end(&mut plain).map_err(|e| e.to_string())?;
        let left = decoder.into_inner().into_inner().len();
        if left > 0 {
            return Err(format!("expected the end after what is compressed, found {left} bytes more"));
        }
        bytes = plain;
    }
    decode::decode(&bytes)
}

/// Samples that are counted together, across and down.
const SIDE: usize = 256;

/// How many samples the raster has on the grid.
fn count(samples: &Samples) -> Result<u64, PyramidError> {
    let area = samples.area;
    let rows = |block: &mut SampleBlock, top: usize| {
        let height = (area.height - top).min(SIDE);
        let mut count = 0;
        for left in (0..area.width).step_by(SIDE) {
            let (column, row) = (area.column + left as i64, area.row + top as i64);
            let patch = Patch { column, row, width: (area.width - left).min(SIDE), height, step: 1 };
            samples.read(patch, block)?;
            count += block.inside.iter().filter(|inside| **inside).count() as u64;
        }
        Ok(count)
    };
    let tops: Vec<usize> = (0..area.height).step_by(SIDE).collect();
    let counts: Result<Vec<u64>, PyramidError> =
        tops.par_iter().map_init(SampleBlock::default, |block, &top| rows(block, top)).collect();
    Ok(counts?.into_iter().sum())
}
