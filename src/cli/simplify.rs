//! `simplify`: its options, and a run from them to the report.

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

use clap::ValueEnum;

use super::channels::ChannelArgs;
use super::combinations::Asked;
use super::goal::GoalArgs;
use super::importance::ImportanceArgs;
use super::input::InputArgs;
use super::progress::Bars;
use super::simplify_channels::Extended;
use super::simplify_engine::EngineArgs;
use super::simplify_kept::{Kept, finished};
use super::simplify_map::{MapArgs, MapReport, Written};
use super::simplify_polish::PolishArgs;
use super::simplify_report::{Needs, Report, Seconds, WorkDirReport};
use super::warnings::Shown;
use super::{Failure, output_format, print, signals, values, warnings};
use crate::base::RasterError;
use crate::base::channels::ChannelBands;
use crate::base::control::Control;
use crate::base::staged::{OutputError, StagedFile};
use crate::base::warning::{Warning, WarningCode};
use crate::base::{Band, Watch};
use crate::field::{Access, Choice, Field, FieldError, FieldOptions, HoleOptions, may_have_holes};
use crate::formats::PlySink;
use crate::formats::ply::read::Frame;
use crate::job::features::{Feature, FeatureSet};
use crate::job::plan::{DENSEST, Estimate, estimate};
use crate::job::rules::{default_engine, default_quality};
use crate::job::{
    DEFAULT_TILE, DiskUse, EngineChoice, Error, Expected, Goal, Load, Params, Plan, Quality, VertexHeights, check_disk,
    default_budget, grid, probe, probe_field, triangulate, triangulate_into,
};
use crate::kernel::measure::ErrorStats;
use crate::kernel::triangulate::Feasibility;
use crate::raster::{FileWatch, PointSource, Points, PointsError, Raster, bound_gdal_cache, read_points};
use crate::run::look::look;

/// Turn a raster into a mesh that is within a tolerance of every sample
#[derive(Debug, clap::Args)]
pub(crate) struct SimplifyArgs {
    /// The raster: a file, or any name GDAL opens
    #[arg(value_name = "INPUT")]
    pub(super) input: PathBuf,
    /// The mesh: a binary PLY file in map coordinates
    #[arg(value_name = "OUTPUT")]
    pub(super) output: PathBuf,
    /// The format of the mesh, whatever OUTPUT is called [default: what its extension says]
    #[arg(long, value_parser = output_format::names(output_format::MESHES))]
    format: Option<String>,
    #[command(flatten)]
    pub(super) goal: GoalArgs,
    /// Test triangles at the samples under them (weak), or also where their edges cross the grid (strong)
    #[arg(long, value_enum, default_value_t = FeasibilityArg::Weak)]
    feasibility: FeasibilityArg,
    /// How much work goes into fewer triangles [default: balanced; none under --max-points, --max-triangles, --max-rms]
    #[arg(long, value_enum)]
    quality: Option<QualityArg>,
    /// What heights vertices have where polishing has moved them: those of samples, or fitted to the samples around
    #[arg(long, value_enum, default_value_t = HeightsArg::Sampled)]
    heights: HeightsArg,
    /// Polishing makes no triangle with a smaller angle, seen from above, unless it takes the place of a sharper one; 0 sets
    /// no floor
    #[arg(long, value_name = "DEGREES", default_value_t = 0.0, hide_default_value = true, value_parser = values::angle,
        allow_hyphen_values = true)]
    min_angle: f64,
    /// The side of the tiles worked on one at a time; 0 makes one of the whole raster
    #[arg(long, value_name = "CELLS", default_value_t = DEFAULT_TILE)]
    tile: usize,
    /// Simplify the rim of voids: ground within CELLS columns and rows of a missing sample may be removed. Removed samples are
    /// counted, and not covered; `verify` needs the same option
    #[arg(long, value_name = "CELLS", default_value_t = 0, hide_default_value = true, value_parser = values::trim,
        allow_hyphen_values = true)]
    trim: u32,
    #[command(flatten)]
    pub(super) input_args: InputArgs,
    /// Bridge holes of at most so many samples without a height: the mesh goes on over them, bound by no tolerance there. A
    /// hole is a group of such samples, diagonal neighbours included, with none in the first or last row or column; 0 bridges
    /// none
    #[arg(long, value_name = "SAMPLES", value_parser = values::count, default_value_t = 0)]
    fill_holes: u64,
    #[command(flatten)]
    channels: ChannelArgs,
    #[command(flatten)]
    pub(super) importance: ImportanceArgs,
    /// A layer of points, in any format OGR reads: the samples nearest to them become vertices of the mesh.
    #[arg(long, value_name = "FILE")]
    pub(super) points: Option<PathBuf>,
    /// The layer of --points [default: the first]
    #[arg(long, value_name = "NAME", requires = "points")]
    points_layer: Option<String>,
    /// The folder of temporary files [default: the system's]
    #[arg(long, value_name = "DIR")]
    temp_dir: Option<PathBuf>,
    /// Keep finished tiles in this folder: after an interrupt, a crash or a power cut the same command continues there. With
    /// --dry-run: print how many tiles are left to be made
    #[arg(long, value_name = "DIR")]
    work_dir: Option<PathBuf>,
    /// How samples are read: from the mapped file, in windows through GDAL, or decoded into a temporary file first
    #[arg(long, value_enum, default_value_t = AccessArg::Auto)]
    access: AccessArg,
    /// The most memory to use, such as 256MiB [default: a quarter of the machine's, at most 2 GiB]
    #[arg(long, value_name = "BYTES", value_parser = values::bytes)]
    memory: Option<u64>,
    /// Print what the run would need, from a few tiles, and stop
    #[arg(long)]
    dry_run: bool,
    /// Threads to work with, fewer if the memory is for fewer [default: as many as the machine has cores]
    #[arg(long, value_name = "N", value_parser = values::threads)]
    threads: Option<NonZeroUsize>,
    /// Replace an existing output
    #[arg(long)]
    pub(super) overwrite: bool,
    /// Print nothing but errors
    #[arg(long, short, conflicts_with = "json")]
    pub(super) quiet: bool,
    /// Print the report as JSON
    #[arg(long)]
    json: bool,
    // The last: their headings would be those of what follows.
    #[command(flatten)]
    engine: EngineArgs,
    #[command(flatten)]
    map: MapArgs,
    #[command(flatten)]
    polish: PolishArgs,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum AccessArg {
    /// What suits the raster
    Auto,
    /// The raster's own file, mapped
    InPlace,
    /// Windows, read through GDAL when they are wanted
    Windows,
    /// A temporary file, decoded beforehand
    Decode,
}

impl From<AccessArg> for Choice {
    fn from(argument: AccessArg) -> Choice {
        match argument {
            AccessArg::Auto => Choice::Auto,
            AccessArg::InPlace => Choice::InPlace,
            AccessArg::Windows => Choice::Windows,
            AccessArg::Decode => Choice::Decode,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum QualityArg {
    /// The engine alone, the fastest there is
    None,
    /// Removes vertices whose hole can be filled directly
    Fast,
    /// Removes more vertices, and repairs the triangles around them
    Balanced,
    /// The same, until it removes no more
    Best,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum HeightsArg {
    /// Vertices stand on samples and have their heights
    Sampled,
    /// Vertices stand where triangles fit best: the fewest triangles, larger errors on the whole, in hardly more time
    Fitted,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum FeasibilityArg {
    Weak,
    Strong,
}

impl From<FeasibilityArg> for Feasibility {
    fn from(argument: FeasibilityArg) -> Feasibility {
        match argument {
            FeasibilityArg::Weak => Feasibility::Weak,
            FeasibilityArg::Strong => Feasibility::Strong,
        }
    }
}

pub(crate) fn run(args: &SimplifyArgs) -> Result<ExitCode, Failure> {
    output_format::of(&args.output, args.format.as_deref(), output_format::MESHES)?;
    let mut asked = args.asked();
    asked.check()?;
    let params = args.params(asked.features());
    let bars = Bars::new(args.quiet);
    let control = bars.control();
    let (raster, channels) = args.channels.open(&args.input, args.input_args.view(), &control.cancel)?;
    args.map.ask_of(&raster, &mut asked);
    asked.check()?;
    warnings::collect(raster.warnings().iter().cloned());
    let importance = args.importance.open(&raster)?;
    warnings::collect(importance.iter().flat_map(Raster::warnings).cloned());
    let watches = args.watches(&raster, importance.as_ref())?;
    let band = raster.to_band()?;
    let importance = importance.as_ref().map(Raster::to_band).transpose()?;
    let grid = grid(raster.width(), raster.height(), &params)?;
    let points = args.read_points(&raster, &control)?;
    let wanted = args.threads.map_or_else(default_threads, NonZeroUsize::get);
    let budget = args.memory.unwrap_or_else(default_budget);
    let load = Load {
        band: &band,
        importance: importance.as_ref(),
        channels: channels.as_ref().map_or(&[], |c| &c.bands),
        grid,
        engine: params.engine,
        quality: params.quality,
        trim: params.trim,
        points: points.as_ref().map_or(0, |p| p.set.len()),
        holes: args.fill_holes > 0 && may_have_holes(&band),
    };
    let plan = Plan::new(budget, &load, wanted).map_err(Error::from)?;
    bound_gdal_cache(plan.cache_bytes);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(plan.threads).build().map_err(|e| {
        Failure::new(format!("{} threads cannot be started: {e}", plan.threads)).hint("choose fewer with --threads")
    })?;
    let flat = channels.as_ref().is_some_and(|c| c.planar);
    if !args.dry_run && !args.map.is_plain() {
        // Finding out what is lost may take long, so an output that cannot be written is found first.
        args.first_look()?;
    }
    // To the pool's threads and back: a raster serves one thread at a time.
    let heights = params.heights;
    let write = |raster: &Raster| args.map.written(raster, flat, &args.goal, heights, &control);
    let (raster, written) = pool.install(move || {
        let written = write(&raster);
        (raster, written)
    });
    let written = written?;
    let set = points.as_ref().map(|p| p.set.clone());
    let params = Params { tolerance: written.tolerance, goal: written.goal, points: set, ..params };
    let job =
        Job { written, args, raster, band, watches, channels, importance, params, points, plan, control: &control };
    if args.dry_run {
        let needs = pool.install(move || job.dry_run())?;
        let needs = Needs { warnings: warnings::take(), ..needs };
        drop(bars);
        if args.json {
            print::json(&needs)?;
        } else {
            if !args.quiet {
                needs.warnings.print();
            }
            print::report(&print::aligned(&needs.lines()))?;
        }
        return Ok(ExitCode::SUCCESS);
    }
    let report = pool.install(move || job.run())?;
    drop(bars);
    let fell_short = report.fell_short();
    if fell_short {
        let message = "the mesh is complete, but the budget ended it before the quality asked for".to_string();
        warnings::collect([Warning { code: WarningCode::FellShort, file: args.output.clone(), count: 1, message }]);
    }
    let report = report.warnings(warnings::take());
    if args.json {
        print::json(&report)?;
    } else if !args.quiet {
        report.print_warnings();
        print::report(&print::aligned(&report.lines()))?;
    }
    Ok(if fell_short { ExitCode::from(FELL_SHORT) } else { ExitCode::SUCCESS })
}

/// Exit code: a budget ended the refinement before the quality that was asked for was reached.
const FELL_SHORT: u8 = 5;

fn default_threads() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

impl SimplifyArgs {
    /// What the options ask for, and by which of them. What is not said is as the rule book has it.
    fn asked(&self) -> Asked {
        let mut asked = self.input_args.asked();
        self.goal.ask(&mut asked);
        self.channels.ask(&mut asked);
        self.importance.ask(&mut asked);
        asked.add(Feature::Points, self.points.is_some());
        asked.add(Feature::Trim, self.trim > 0);
        asked.add(Feature::FilledVoids, self.fill_holes > 0);
        asked.add(Feature::FittedHeights, self.heights == HeightsArg::Fitted);
        asked.add(Feature::MinAngle, self.min_angle > 0.0);
        asked.add(Feature::StrongFeasibility, self.feasibility == FeasibilityArg::Strong);
        self.polish.ask(&mut asked);
        self.engine.ask(&mut asked);
        self.map.ask(self.heights == HeightsArg::Fitted, &mut asked);
        let quality = self.quality(asked.features());
        if quality != Quality::None {
            asked.add_by(Feature::Polishing, format!("--quality {}", quality.name()));
        }
        let engine = self.engine.choice(|| default_engine(asked.features()));
        asked.add(Feature::GreedyCuts, matches!(engine, EngineChoice::GreedyCuts(_)));
        asked
    }

    /// The same once it is known that heights need all digits of doubles.
    #[cfg(test)]
    pub(super) fn asked_of_doubles(&self) -> Asked {
        let mut asked = self.asked();
        self.map.ask(true, &mut asked);
        asked
    }

    /// The quality that is asked for, or the usual one for these features.
    fn quality(&self, features: FeatureSet) -> Quality {
        match self.quality {
            Some(QualityArg::None) => Quality::None,
            Some(QualityArg::Fast) => Quality::Fast,
            Some(QualityArg::Balanced) => Quality::Balanced,
            Some(QualityArg::Best) => Quality::Best,
            None => default_quality(features),
        }
    }

    /// The parameters, where these features are asked for. They go together.
    fn params(&self, features: FeatureSet) -> Params {
        let quality = self.quality(features);
        let heights = match self.heights {
            HeightsArg::Sampled => VertexHeights::Sampled,
            HeightsArg::Fitted => VertexHeights::Fitted,
        };
        let mut params = Params {
            feasibility: self.feasibility.into(),
            tile: self.tile,
            trim: self.trim,
            engine: self.engine.choice(|| default_engine(features)),
            quality,
            heights,
            tuning: self.polish.tuning(quality, heights, self.min_angle),
            goal: self.goal.goal(),
            ..Params::new(self.goal.tolerance())
        };
        if let Some(dir) = &self.temp_dir {
            params.temp_dir.clone_from(dir);
        }
        params
    }

    /// The points, where there are some.
    fn read_points(&self, raster: &Raster, control: &Control<'_>) -> Result<Option<Points>, PointsError> {
        let Some(path) = &self.points else { return Ok(None) };
        let source = PointSource { path: path.clone(), layer: self.points_layer.clone() };
        read_points(raster, &source, &control.cancel).map(Some)
    }

    /// Watches everything that is read from here on: no sample, point or polygon has been read yet.
    fn watches(&self, raster: &Raster, importance: Option<&Raster>) -> Result<Arc<[Box<dyn Watch>]>, RasterError> {
        if self.dry_run {
            return Ok(Arc::default());
        }
        let boxed = |watch: FileWatch| Box::new(watch) as Box<dyn Watch>;
        let rasters = [Some(raster), importance].into_iter().flatten().map(|r| FileWatch::new(r).map(boxed));
        let layers = [self.input_args.cutline.cutline.as_ref(), self.points.as_ref()].into_iter().flatten();
        rasters.chain(layers.map(|path| Ok(boxed(FileWatch::layer(path))))).collect()
    }

    /// Finds an output that cannot be written. A work dir may have one of its own there.
    fn first_look(&self) -> Result<(), OutputError> {
        StagedFile::check(&self.output, self.overwrite || self.work_dir.is_some(), &self.inputs())
    }

    /// Files that are read: the output is none of them.
    pub(super) fn inputs(&self) -> Vec<&Path> {
        let (importance, cutline) = (self.importance.importance.as_ref(), self.input_args.cutline.cutline.as_ref());
        let all = [Some(&self.input), importance, cutline, self.points.as_ref()];
        all.into_iter().flatten().map(PathBuf::as_path).collect()
    }
}

/// A run, as asked for and as planned.
struct Job<'a> {
    written: Written,
    args: &'a SimplifyArgs,
    raster: Raster,
    band: Band,
    watches: Arc<[Box<dyn Watch>]>,
    channels: Option<ChannelBands>,
    importance: Option<Band>,
    params: Params,
    points: Option<Points>,
    plan: Plan,
    control: &'a Control<'a>,
}

impl Job<'_> {
    /// What the run will need, from a few tiles or from its budget.
    fn needs(&self) -> Result<Needs, Error> {
        let find = |options| Extended::find(&self.band, options, self.control);
        let extended = self.channels.as_ref().map(find).transpose()?;
        self.needs_of(extended.as_ref())
    }

    /// The same where it is known what channels there are.
    fn needs_of(&self, extended: Option<&Extended>) -> Result<Needs, Error> {
        let expected = match extended {
            None => probe(&self.band, self.importance.as_ref(), &self.params, self.control)?,
            Some(extended) => {
                let windows =
                    FieldOptions { temp_dir: self.params.temp_dir.clone(), choice: Choice::Windows, maps_files: false };
                let field = extended.open(&self.band, &windows, self.control)?;
                probe_field(&field, &self.params, self.control)?
            }
        };
        let Goal { max_rms, .. } = self.params.goal;
        let by_budget = self.params.goal.most_triangles().is_some();
        let found_by = match by_budget && max_rms.is_none() && self.params.tolerance.is_open() {
            true => "by the budget",
            false => "at a few tiles",
        };
        let (estimate, memory) = (self.estimate(expected), self.plan);
        Ok(Needs { found_by, estimate, memory, work_dir: None, warnings: Shown::default() })
    }

    /// What a run will need, and what its work dir has of it.
    fn dry_run(&self) -> Result<Needs, Failure> {
        let find = |options| Extended::find(&self.band, options, self.control).map_err(Error::from);
        let extended = self.channels.as_ref().map(find).transpose()?;
        let needs = self.needs_of(extended.as_ref())?;
        let Some(dir) = &self.args.work_dir else { return Ok(needs) };
        let named = self.named(extended.as_ref());
        let finished = finished(dir, &self.band, self.importance.as_ref(), named)?;
        let grid = grid(self.band.width(), self.band.height(), &self.params)?;
        let second = grid.shifted().filter(|_| self.params.passes(grid) == 2);
        let (tiles, seams) = (grid.len() as u64, second.map_or(0, |grid| grid.len() as u64));
        Ok(Needs { work_dir: Some(WorkDirReport { tiles, seams, finished }), ..needs })
    }

    /// What decides the bytes of a tile, by name.
    fn named(&self, extended: Option<&Extended>) -> Vec<(&'static str, String)> {
        let mut named = self.params.named();
        named.extend(self.args.input_args.named(&self.raster));
        named.extend(self.fill_holes().map(|most| ("fill holes", most.to_string())));
        named.extend(extended.into_iter().flat_map(Extended::named));
        named
    }

    fn estimate(&self, expected: Expected) -> Estimate {
        let heights = estimate(&self.band, self.importance.as_ref(), expected.samples_per_triangle);
        let once = match &self.channels {
            None => heights,
            Some(options) => heights.with_channels(&options.bands, options.planar),
        };
        // A tile too long is told of later.
        let (tiles, passes) = grid(self.raster.width(), self.raster.height(), &self.params)
            .map_or((1, 1), |grid| (grid.len() as u64, self.params.passes(grid)));
        Estimate { survey_bytes: expected.survey_bytes, ..once.with_tiles(tiles, passes) }
    }

    /// The channels and their ranges, where there are some. Finding the ranges may take long, so an output that cannot
    /// be written is found first.
    fn extended(&self) -> Result<Option<Extended>, Error> {
        let Some(options) = &self.channels else { return Ok(None) };
        self.args.first_look()?;
        Ok(Some(Extended::find(&self.band, options, self.control)?))
    }

    /// The most samples of a hole that is bridged, if any is.
    fn fill_holes(&self) -> Option<u64> {
        Some(self.args.fill_holes).filter(|most| *most > 0)
    }

    fn run(&self) -> Result<Report, Failure> {
        let start = Instant::now();
        let extended = self.extended()?;
        let open = |dir: &PathBuf| {
            let named = self.named(extended.as_ref());
            Kept::open(dir, &self.band, self.importance.as_ref(), &self.watches, named)
        };
        let kept = self.args.work_dir.as_ref().map(open).transpose()?;
        match (self.make(start, extended.as_ref(), kept.as_ref()), kept) {
            (Ok(report), None) => Ok(report),
            (Err(error), None) => Err(self.explain(matches!(error, Error::NoGround { .. }), error.into())),
            (Ok(report), Some(kept)) => {
                kept.finish();
                Ok(report)
            }
            (Err(error), Some(kept)) => Err(self.explain(matches!(error, Error::NoGround { .. }), kept.explain(error))),
        }
    }

    /// Where there is no ground, it may be the cutline's doing.
    fn explain(&self, no_ground: bool, failure: Failure) -> Failure {
        match &self.args.input_args.cutline.cutline {
            Some(file) if no_ground => failure.hint(&format!(
                "samples outside the polygons of --cutline {} have no heights: choose other polygons; ogrinfo shows where they lie",
                file.display()
            )),
            _ => failure,
        }
    }

    /// Makes the output, from the tiles in the work dir and those still to be made.
    fn make(&self, start: Instant, extended: Option<&Extended>, kept: Option<&Kept>) -> Result<Report, Error> {
        let args = self.args;
        let staged = match kept {
            Some(kept) => kept.stage(args)?,
            None => StagedFile::create(&args.output, args.overwrite, &args.inputs())?,
        };
        self.check_disks(&staged, kept)?;
        let options =
            FieldOptions { temp_dir: self.params.temp_dir.clone(), choice: args.access.into(), maps_files: true };
        let field = match extended {
            None => Field::open_with_importance(&self.band, self.importance.as_ref(), &options, self.control)?,
            Some(extended) => extended.open(&self.band, &options, self.control)?,
        }
        .watched(self.watches.clone());
        let holes = HoleOptions {
            most: args.fill_holes,
            // Lists that grow leave about as much behind.
            memory_bytes: self.plan.before_tiles_bytes / 2,
            temp_dir: self.params.temp_dir.clone(),
        };
        let in_place = |f: &&Field| *f.access() == Access::InPlace;
        // Channels are bands of the same file.
        let mapped = [field.each().find(in_place).map(|_| &field), field.importance().filter(in_place)];
        let mapped: Vec<String> = mapped.into_iter().flatten().map(|f| f.name().display().to_string()).collect();
        if !mapped.is_empty() {
            let message = format!("error: {}: the file was truncated while it was in use", mapped.join(" or "));
            signals::exit_on_truncation(&message, staged.partial_path())
                .map_err(|source| FieldError::Map { path: args.input.clone(), source })?;
        }
        // What follows reads samples, perhaps of a mapped file.
        let field = if args.fill_holes > 0 { field.with_holes_bridged(&holes, self.control)? } else { field };
        let opened = Instant::now();
        let mesh = match kept {
            Some(kept) => triangulate_into(&|pass| kept.spool(pass), &field, &self.params, self.control)?,
            None => triangulate(&field, &self.params, self.control)?,
        };
        self.watches.iter().try_for_each(|watch| watch.check())?;
        let triangulated = Instant::now();
        let mut comments = comments(&self.raster, args, self.written.frame);
        comments.extend(extended.map(Extended::comment));
        let sink = PlySink::new(staged, &comments).in_frame(self.written.frame, self.written.loss);
        let summary = mesh.write_if(Box::new(sink), self.control, &|| {
            self.watches.iter().try_for_each(|watch| watch.check())?;
            kept.map_or(Ok(()), Kept::committing)
        })?;
        self.look(&summary.errors);
        let seconds = Seconds {
            total: start.elapsed().as_secs_f64(),
            open: (opened - start).as_secs_f64(),
            tiles: (triangulated - opened).as_secs_f64(),
            write: triangulated.elapsed().as_secs_f64(),
            threads: mesh.times(),
        };
        let report = Report::new(&field, &self.params, self.plan, &args.output, &summary, seconds, &mesh);
        let report = match extended {
            Some(extended) => report.channels(extended.report(&summary.errors)),
            None => report,
        };
        let report = match self.fill_holes() {
            Some(_) => report.holes(field.holes()),
            None => report,
        };
        let report = match (&args.input_args.cutline.cutline, self.raster.cutline()) {
            (Some(file), Some(cutline)) => report.cutline(file, cutline),
            _ => report,
        };
        let report = match (&args.points, &self.points) {
            (Some(file), Some(points)) => report.points(file, points),
            _ => report,
        };
        let report = report.raster(&self.raster).map(MapReport::new(&self.raster, &self.written));
        Ok(if kept.is_some() { report.tiles_found(mesh.tiles_found()) } else { report })
    }

    /// Looks at the raster once more where the tiles' heights hint at something worth a warning. The output is there
    /// whatever comes of this.
    fn look(&self, errors: &ErrorStats) {
        let has_voids = errors.nodata + errors.bridged > 0;
        let has_zero_tag = self.raster.has_zero_tag();
        let hints = errors.heights.is_some_and(|heights| heights.is_suspicious());
        let is_flat = self.channels.as_ref().is_some_and(|c| c.planar);
        if has_voids
            && !is_flat
            && (hints || has_zero_tag)
            && let Ok(look) = look(&self.band, self.control)
        {
            warnings::collect(look.warnings(&self.band));
        }
    }

    /// Refuses what the disks cannot hold. A few tiles are only tried where the densest mesh would not fit.
    fn check_disks(&self, staged: &StagedFile, kept: Option<&Kept>) -> Result<(), Error> {
        let output_folder = staged.partial_path().parent().unwrap_or(Path::new("."));
        let temp_dir = self.params.temp_dir.as_path();
        let (tiles, there) = kept.map_or((temp_dir, 0), |kept| (kept.path(), kept.chunk_bytes()));
        let check = |estimate: Estimate| {
            check_disk(&[
                DiskUse { what: "decoded samples", folder: temp_dir, bytes: estimate.field_bytes },
                DiskUse { what: "what tiles tell under a goal", folder: temp_dir, bytes: estimate.survey_bytes },
                DiskUse { what: "finished tiles", folder: tiles, bytes: estimate.spool_bytes.saturating_sub(there) },
                DiskUse { what: "the output", folder: output_folder, bytes: estimate.output_bytes },
            ])
        };
        let samples = self.raster.width() as u64 * self.raster.height() as u64;
        if check(self.estimate(Expected::densest(DENSEST, samples, &self.params))).is_ok() {
            return Ok(());
        }
        Ok(check(self.needs()?.estimate)?)
    }
}

/// What the file says of itself. Nothing here depends on the machine or the time.
fn comments(raster: &Raster, args: &SimplifyArgs, frame: Frame) -> Vec<String> {
    let name = |path: &Path| path.file_name().map_or(path, Path::new).display().to_string();
    let mut comments =
        vec![format!("made by terrabite {}", env!("CARGO_PKG_VERSION")), format!("source {}", name(&args.input))];
    // In the form in which QGIS reads it: no blank after the colon, which would belong to the CRS. Where an origin is taken
    // off, QGIS would draw the mesh in the wrong place, so then it is not to find one.
    let key = if frame.origin == Frame::PLAIN.origin { "crs:" } else { "map crs " };
    comments.extend(raster.crs_definition().map(|crs| format!("{key}{crs}")));
    comments.push(format!("crs name {}", raster.crs_name()));
    comments.extend(raster.window().map(|window| format!("window {window}")));
    comments.extend(args.goal.comments());
    comments.extend(args.input_args.comments());
    comments.extend(Some(args.fill_holes).filter(|most| *most > 0).map(|most| format!("fill holes {most}")));
    comments.extend(args.input_args.cutline.comments());
    comments.extend((args.trim > 0).then(|| format!("trim {}", args.trim)));
    comments.extend(args.importance.file_name().map(|name| format!("importance {}", name.display())));
    comments.extend(args.points.iter().map(|points| format!("points {}", name(points))));
    comments
}
