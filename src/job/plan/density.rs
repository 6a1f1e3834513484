//! What a run will come to, found at a few of its tiles: for estimates of disks, before it begins.

use std::time::Instant;

use crate::base::Band;
use crate::base::control::Control;
use crate::base::features::FeatureSet;
use crate::base::tiling::{TileGrid, TileId, spread};
use crate::field::{Choice, Field, FieldOptions};
use crate::job::goal::{Curves, Floor, find_cut};
use crate::job::passes::{self, Job, Links, TileMaker, check_corners, error_needs, grid, lowest};
use crate::job::search::{self, Expectation};
use crate::job::spool::SpoolError;
use crate::job::{Error, Goal, Params};
use crate::kernel::triangulate::Progressive;

/// How many tiles each way are tried.
const TRIED: usize = 3;

/// What a run will come to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Expected {
    /// Samples of the raster for each triangle of the mesh.
    pub samples_per_triangle: f64,
    /// Bytes of temporary disk for what tiles tell of their insertions; 0 without a goal, or where a tolerance is looked for.
    pub survey_bytes: u64,
    /// The tolerance at which the first run will be made that looks for one; else none.
    pub tolerance: Option<f64>,
    /// Seconds of all threads together, as this machine took for the tiles that were made; none where none were.
    pub thread_seconds: Option<f64>,
}

/// How many times as long as the tiles of the first pass a run takes with those that follow.
const LATER_PASSES: f64 = 1.35;

/// How many runs a search makes, mostly.
const RUNS: f64 = 2.0;

impl Expected {
    /// What no run over a field exceeds: where every sample is a vertex.
    pub fn densest(samples_per_triangle: f64, samples: u64, params: &Params) -> Expected {
        let told = if params.goal.is_none() { 0 } else { told_of(samples) };
        Expected::of(samples_per_triangle, told)
    }

    fn of(samples_per_triangle: f64, told: u64) -> Expected {
        let survey_bytes = told.saturating_mul(Curves::BYTES);
        Expected { samples_per_triangle, survey_bytes, tolerance: None, thread_seconds: None }
    }
}

/// What tiles tell at the most: every sample once, and those on their common lines twice.
fn told_of(samples: u64) -> u64 {
    samples.saturating_add(samples / 16)
}

/// Finds out what a run over a raster will come to, by what ends it:
///
/// - a tolerance: up to nine tiles, spread evenly over the raster, are made; with points (which are left out there: they may
///   lie in bridged holes, and anywhere) two triangles more for each;
/// - a goal that a tolerance is looked for: that is begun, at a few tiles;
/// - a budget that insertion stops at: it is the answer, and nothing is read;
/// - a root mean square, alone or beside those: up to nine tiles tell of their insertions, and end together where the mean
///   over them is reached, as all tiles will. Where others are rougher, the truth lies elsewhere.
///
/// The windows are read through GDAL, those of the importance raster too, so nothing has to be decoded beforehand. Cost:
/// nine tiles.
///
/// # Errors
/// [`Error`], as for the whole run: a raster that cannot be read is told of early.
pub fn probe(
    band: &Band,
    importance: Option<&Band>,
    params: &Params,
    control: &Control<'_>,
) -> Result<Expected, Error> {
    let options =
        FieldOptions { temp_dir: params.temp_dir.clone(), choice: Choice::Windows, ..FieldOptions::default() };
    probe_field(&Field::open_with_importance(band, importance, &options, control)?, params, control)
}

/// Does what [`probe`] does, with a field that is open.
///
/// # Errors
/// As [`probe`].
pub fn probe_field(field: &Field, params: &Params, control: &Control<'_>) -> Result<Expected, Error> {
    params.check(field)?;
    let grid = grid(field.width(), field.height(), params)?;
    let samples = field.width() as f64 * field.height() as f64;
    let features = FeatureSet::of_field(field);
    if params.is_searched(features) {
        return searched(field, params, samples, control);
    }
    let goal = Goal { max_rms: params.goal.max_rms, ..Goal::default() };
    let few = Params { points: None, breaklines: None, goal, ..params.clone() };
    let max_stray = params.straying(params.features().and(features));
    let job = Job {
        field,
        params: &few,
        max_stray,
        links: Links::Fewest,
        grid,
        polishes_seams: false,
        control,
        end: None,
        chains: None,
    };
    let rates = match params.engine.progressive() {
        _ if params.goal.is_none() => Some(made(&job)?),
        Some(engine) if goal.max_rms.is_some() || !params.tolerance.is_open() => Some(surveyed(&job, engine)?),
        _ => None,
    };
    let points = 2.0 * params.points.as_ref().map_or(0, |p| p.len()) as f64;
    let share = params.breaklines.as_ref().and_then(|lines| lines.share_inside()).unwrap_or(1.0);
    let covered = samples * share;
    let wanted = rates.map_or(f64::INFINITY, |rates| rates.triangles * covered + points);
    let triangles = wanted.min(params.goal.most_triangles().map_or(f64::INFINITY, |most| most as f64));
    if params.goal.most_triangles().is_some() && !field.may_have_gaps() {
        check_corners(&Job { params, ..job })?;
    }
    let told = match rates {
        _ if params.goal.is_none() => 0,
        Some(rates) => most_told(&params.goal, grid).min((rates.told * samples) as u64),
        None => most_told(&params.goal, grid),
    };
    // Where the tiles that were tried have no ground, it is as if they had one triangle.
    let samples_per_triangle = samples / triangles.min(2.0 * samples).max(1.0);
    let later = if passes::polishes_seams(params.quality, max_stray) { LATER_PASSES } else { 1.0 };
    let seconds = rates.filter(|rates| rates.seconds > 0.0).map(|rates| rates.seconds * covered * later);
    Ok(Expected { thread_seconds: seconds, ..Expected::of(samples_per_triangle, told) })
}

/// Triangles, and insertions told of, for each sample.
/// What the first run of a search will come to.
fn searched(field: &Field, params: &Params, samples: f64, control: &Control<'_>) -> Result<Expected, Error> {
    let few = Params { points: None, ..params.clone() };
    let Expectation { tolerance, figures, seconds, run_seconds } = search::foretell(field, &few, control)?;
    let most = params.goal.most_triangles().map_or(2.0 * samples, |most| most as f64);
    let triangles = figures.map_or(most, |figures| (figures.triangles as f64).min(most));
    let samples_per_triangle = samples / triangles.max(1.0);
    let thread_seconds = run_seconds.map(|run| seconds + RUNS * LATER_PASSES * run);
    Ok(Expected { tolerance: Some(tolerance), thread_seconds, ..Expected::of(samples_per_triangle, 0) })
}

#[derive(Debug, Clone, Copy, Default)]
struct Rates {
    triangles: f64,
    told: f64,
    /// Seconds of a thread.
    seconds: f64,
}

fn tried(grid: TileGrid) -> impl Iterator<Item = TileId> {
    spread(grid.rows(), TRIED)
        .flat_map(move |row| spread(grid.columns(), TRIED).map(move |column| TileId { column, row }))
}

/// Makes a few tiles.
fn made(job: &Job<'_>) -> Result<Rates, Error> {
    let mut maker = TileMaker::default();
    let (mut samples, mut triangles, start) = (0, 0, Instant::now());
    for id in tried(job.grid) {
        let probed = maker.probe(job, &job.grid.place_of(id), false)?;
        samples += probed.samples;
        triangles += probed.triangles;
    }
    let seconds = start.elapsed().as_secs_f64() / samples as f64;
    Ok(Rates { triangles: triangles.max(1) as f64 / samples as f64, told: 0.0, seconds })
}

/// Has a few tiles tell of their insertions, and finds where they end together.
fn surveyed(job: &Job<'_>, engine: &dyn Progressive) -> Result<Rates, Error> {
    let (lowest, goal) = (lowest(job), &job.params.goal);
    let floor = Floor::new(goal, lowest);
    let failed = |source| SpoolError::File { dir: job.params.temp_dir.clone(), source };
    let curves = Curves::new(&job.params.temp_dir, tried(job.grid).count()).map_err(failed)?;
    let mut maker = TileMaker::default();
    let (mut samples, mut counted, mut told, mut encoded) = (0, 0, 0, Vec::new());
    for (i, id) in tried(job.grid).enumerate() {
        job.control.cancel.check()?;
        let place = job.grid.place_of(id);
        counted += maker.tell(job, engine, &place, lowest, &floor)?;
        samples += place.window.len();
        told += maker.told.len();
        curves.tell(i, &maker.told, &mut encoded).map_err(failed)?;
    }
    let (cut, _) = find_cut(&curves, goal, counted, error_needs(job)).map_err(failed)??;
    let mut triangles = 0;
    curves
        .for_each(|t| {
            triangles += if t.key <= cut { t.cost.triangles } else { 0 };
            true
        })
        .map_err(failed)?;
    Ok(Rates { triangles: triangles.max(1) as f64 / samples as f64, told: told as f64 / samples as f64, seconds: 0.0 })
}

/// How many insertions tiles tell of at the most, about, before the [`Floor`] stops them: where tiles are alike, each goes as
/// far as those before it together need for the budget, the first as far as all of it.
fn most_told(goal: &Goal, grid: TileGrid) -> u64 {
    let triangles = goal.max_triangles.map(|most| most / 2 + 1);
    let Some(most) = goal.max_points.or(triangles) else { return u64::MAX };
    let threads = rayon::current_num_threads() as u64;
    let of_tile = |index: usize| {
        // Those that are worked on at the same time know nothing of each other.
        let before = (index as u64).saturating_sub(threads).max(1);
        // The floor rises by steps of 6 % in error.
        let share = most / before + most / before / 8 + 4;
        share.min(most).min(grid.place(index).window.len() as u64)
    };
    (0..grid.len()).map(of_tile).sum()
}
