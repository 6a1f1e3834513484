//! A run, from its request to the report.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use super::attributes::Ranged;
use super::coordinates::{Written, fits_single, is_single};
use super::inputs::{Inputs, Points};
use super::look::look;
use super::report::{Needs, Report, Seconds, Sources, WorkDirState};
use super::resume::{Kept, finished};
use super::threads::start_threads;
use super::{Coordinates, IN_MEMORY, InMemory, Request, RunError, Warned, provenance};
use crate::base::channels::{Channel, ChannelBands, Number};
use crate::base::control::Control;
use crate::base::features::Feature;
use crate::base::staged::StagedFile;
use crate::base::warning::{Warning, WarningCode};
use crate::base::{Band, Texture, channels_of};
use crate::field::{Access, Choice, Field, FieldError, FieldOptions, HoleOptions, height_range, may_have_holes};
use crate::formats::{
    self, ArraySink, Arrays, Attributes, Base, FORMATS, Format, Header, Setup, Sink, SinkError, SinkOption,
};
use crate::job::normals::NormalSource;
use crate::job::plan::{
    DENSEST, DiskUse, Estimate, Expected, Load, Plan, check_disk, default_budget, estimate, probe, probe_field,
};
use crate::job::{Error, Params, Pass, VertexHeights, grid, passes, rules, triangulate, triangulate_into};
use crate::kernel::measure::ErrorStats;

/// Does [`super::simplify`].
pub(super) fn simplify(request: &Request<'_>, control: &Control<'_>) -> Result<Report, RunError> {
    let warned = Warned::new(control);
    let run = Run::prepare(request, Purpose::Make, &warned, control)?;
    run.report()
}

/// Does [`super::merge`].
pub(super) fn merge(request: &Request<'_>, control: &Control<'_>) -> Result<Report, RunError> {
    let warned = Warned::new(control);
    let run = Run::prepare(request, Purpose::Merge, &warned, control)?;
    run.report()
}

fn warn_of_shortfall(report: &Report, request: &Request<'_>, warned: &Warned<'_>) {
    if report.fell_short() {
        let message = "the mesh is complete, but the budget ended it before the quality asked for".to_string();
        warned.tell(Warning { code: WarningCode::FellShort, file: request.output.clone(), count: 1, message });
    }
}

/// Does [`super::simplify_in_memory`].
pub(super) fn simplify_in_memory(request: &Request<'_>, control: &Control<'_>) -> Result<InMemory, RunError> {
    let warned = Warned::new(control);
    // What is in memory keeps what the first format keeps: doubles, and all attributes.
    let format = FORMATS[0];
    if let Some(option) = request.sink.asked().chain(request.further_options()).next() {
        let path = request.input.path().to_path_buf();
        return Err(RunError::FormatOption { path, format: IN_MEMORY, option, formats: titles(option) });
    }
    let request = Request {
        format: Some(format),
        output: PathBuf::from(IN_MEMORY),
        coordinates: Coordinates::default(),
        work_dir: None,
        ..request.clone()
    };
    let run = Run::prepare(&request, Purpose::Make, &warned, control)?;
    let mut arrays = Arrays::default();
    let (report, header) = run.pool.install(|| run.fill(&mut arrays))?;
    warn_of_shortfall(&report, &request, &warned);
    Ok(InMemory { arrays, header, report: Report { warnings: warned.take(), ..report } })
}

/// Does [`super::plan`].
pub(super) fn plan(request: &Request<'_>, control: &Control<'_>) -> Result<Needs, RunError> {
    let warned = Warned::new(control);
    let run = Run::prepare(request, Purpose::Plan, &warned, control)?;
    let needs = run.pool.install(|| run.plan_only())?;
    Ok(Needs { warnings: warned.take(), ..needs })
}

/// What a run is prepared for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Purpose {
    /// To be made, output and all.
    Make,
    /// To be told what it needs.
    Plan,
    /// To be made in part: tiles, no output.
    Share,
    /// To be put together from tiles that are there.
    Merge,
}

impl Purpose {
    /// Whether there is an output.
    fn writes(self) -> bool {
        matches!(self, Purpose::Make | Purpose::Merge)
    }
}

/// A run, as asked for and as planned.
pub(super) struct Run<'a> {
    purpose: Purpose,
    pub(super) request: &'a Request<'a>,
    format: &'static Format,
    pub(super) inputs: Inputs,
    plan: Plan,
    /// The threads that the plan is for.
    pub(super) pool: rayon::ThreadPool,
    written: Written,
    /// The image over the mesh.
    texture: Option<Texture>,
    /// What decides the mesh: what was asked for, less what writing loses, and the points.
    pub(super) params: Params,
    pub(super) warned: &'a Warned<'a>,
    pub(super) control: &'a Control<'a>,
}

/// The format of an output: the one that is asked for, else that of its extension.
pub(super) fn format_of(output: &Path, asked: Option<&'static Format>) -> Result<&'static Format, RunError> {
    if let Some(format) = asked {
        return Ok(format);
    }
    formats::by_extension(output).ok_or_else(|| RunError::Format {
        path: output.to_path_buf(),
        known: FORMATS.iter().flat_map(|f| f.extensions).map(|e| format!(".{e}")).collect::<Vec<_>>().join(", "),
        found: output.extension().map_or("none".to_string(), |e| format!(".{}", e.display())),
    })
}

/// Refuses options that the format does not take.
pub(super) fn check_options(
    output: &Path,
    mut asked: impl Iterator<Item = SinkOption>,
    format: &'static Format,
) -> Result<(), RunError> {
    let Some(option) = asked.find(|option| !format.options.contains(option)) else { return Ok(()) };
    let (path, formats) = (output.to_path_buf(), titles(option));
    Err(RunError::FormatOption { path, format: format.title, option, formats })
}

/// The formats that take an option.
fn titles(option: SinkOption) -> String {
    FORMATS.iter().filter(|f| f.options.contains(&option)).map(|f| f.title).collect::<Vec<_>>().join(", ")
}

/// Refuses attributes in double precision for a format that has none.
fn check_attributes(
    request: &Request<'_>,
    format: &'static Format,
    attributes: Option<&ChannelBands>,
) -> Result<(), RunError> {
    let channels = attributes.map_or(Vec::new(), |attributes| channels_of(&attributes.bands));
    match channels.into_iter().find(|c| format.attributes == Attributes::Single && c.number == Number::F64) {
        None => Ok(()),
        Some(Channel { name, .. }) => {
            let path = request.output.clone();
            Err(SinkError::DoubleAttribute { path, format: format.title, name }.into())
        }
    }
}

/// Refuses a floor that is not below all heights.
fn check_floor(request: &Request<'_>, band: &Band, control: &Control<'_>) -> Result<(), RunError> {
    let Some(Base::Height(floor)) = request.sink.base else { return Ok(()) };
    let lowest = height_range(band, control)?.min;
    if floor < lowest {
        return Ok(());
    }
    let path = request.output.clone();
    let expected = format!("a floor below the lowest height, which is {lowest}");
    Err(SinkError::Unfit { path, expected, found: format!("one at {floor}") }.into())
}

impl<'a> Run<'a> {
    /// Opens what is read and decides what is done. Nothing watches the inputs, and no output need be writable, where the run
    /// is only planned.
    pub(super) fn prepare(
        request: &'a Request<'a>,
        purpose: Purpose,
        warned: &'a Warned<'a>,
        control: &'a Control<'a>,
    ) -> Result<Run<'a>, RunError> {
        let format = format_of(&request.output, request.format)?;
        let further = request.further_options();
        check_options(&request.output, request.sink.asked().chain(further), format)?;
        let features = request.features();
        rules::check(features)?;
        let inputs = Inputs::open(request, purpose != Purpose::Plan, warned, &control.cancel)?;
        let Inputs { band, attributes, importance, points, .. } = &inputs;
        if is_single(request.coordinates, format)
            && (!fits_single(band) || request.params.heights == VertexHeights::Fitted)
        {
            rules::check(features.with(Feature::RoundedToSingle))?;
        }
        check_attributes(request, format, attributes.as_ref())?;
        let load = Load {
            band,
            importance: importance.as_ref(),
            channels: attributes.as_ref().map_or(&[], |a| &a.bands),
            grid: grid(band.width(), band.height(), &request.params)?,
            params: &request.params,
            points: points.as_ref().map_or(0, |p| p.set.len()),
            holes: request.fill_voids > 0 && may_have_holes(band),
            solid: request.sink.base.is_some(),
            normals: request.normals.is_some(),
        };
        let wanted = request.threads.map_or_else(all_cores, usize::from);
        let plan = Plan::new(request.memory.unwrap_or_else(default_budget), &load, wanted)?;
        bound_cache(plan.cache_bytes);
        let coordinates = &request.coordinates;
        let is_plain = !coordinates.local && !is_single(*coordinates, format) && coordinates.z_scale == 1.0;
        if purpose.writes() && !is_plain {
            // Finding out what is lost may take long, so an output that cannot be written is found first.
            first_look(request)?;
        }
        let is_flat = attributes.as_ref().is_some_and(|a| a.planar);
        let pool = start_threads(plan.threads)?;
        let written = pool.install(|| Written::find(request, format, band, importance.as_ref(), is_flat, control))?;
        let params = Params {
            tolerance: written.tolerance,
            goal: written.goal,
            points: points.as_ref().map(|p| p.set.clone()),
            ..request.params.clone()
        };
        if purpose.writes() {
            check_floor(request, band, control)?;
        }
        let texture = if purpose.writes() { texture(request, band)? } else { None };
        Ok(Run { purpose, request, format, inputs, plan, pool, written, texture, params, warned, control })
    }

    pub(super) fn band(&self) -> &Band {
        &self.inputs.band
    }

    /// The attributes and their ranges, where there are some; finding the ranges may read the whole raster.
    pub(super) fn ranged(&self) -> Result<Option<Ranged<'_>>, Error> {
        let find = |bands| Ranged::find(self.band(), bands, self.control);
        Ok(self.inputs.attributes.as_ref().map(find).transpose()?)
    }

    pub(super) fn named(&self, ranged: Option<&Ranged<'_>>) -> Vec<(&'static str, String)> {
        provenance::named(self.request, &self.params, self.band(), ranged)
    }

    /// What the run will need, and what its work dir has of it.
    fn plan_only(&self) -> Result<Needs, RunError> {
        let ranged = self.ranged()?;
        let needs = self.needs(ranged.as_ref())?;
        let Some(dir) = &self.request.work_dir else { return Ok(needs) };
        let named = self.named(ranged.as_ref());
        let finished = finished(dir, self.band(), self.inputs.importance.as_ref(), named)?;
        let passes = passes(self.band().width(), self.band().height(), &self.params)?;
        let count = |pass: Option<&Pass>| pass.map_or(0, |pass| pass.grid().len() as u64);
        let (tiles, seams, crossings) = (count(passes.first()), count(passes.get(1)), passes.iter().skip(2));
        let crossings = crossings.map(|pass| count(Some(pass))).sum();
        Ok(Needs { work_dir: Some(WorkDirState { tiles, seams, crossings, finished }), ..needs })
    }

    /// What the run will need, from a few tiles or from its budget.
    pub(super) fn needs(&self, ranged: Option<&Ranged<'_>>) -> Result<Needs, Error> {
        let expected = match ranged {
            None => probe(self.band(), self.inputs.importance.as_ref(), &self.params, self.control)?,
            Some(ranged) => {
                let temp_dir = self.params.temp_dir.clone();
                let windows = FieldOptions { temp_dir, choice: Choice::Windows, maps_files: false };
                let field = ranged.open(self.band(), &windows, self.control)?;
                probe_field(&field, &self.params, self.control)?
            }
        };
        let goal = &self.params.goal;
        let by_budget = goal.most_triangles().is_some() && goal.max_rms.is_none() && self.params.tolerance.is_open();
        let found_by = if by_budget { "by the budget" } else { "at a few tiles" };
        Ok(Needs::new(found_by, self.estimate(expected), self.plan))
    }

    fn estimate(&self, expected: Expected) -> Estimate {
        let (band, density) = (self.band(), expected.samples_per_triangle);
        let heights = estimate(band, self.inputs.importance.as_ref(), density, self.format);
        let once = match &self.inputs.attributes {
            None => heights,
            Some(a) => heights.with_channels(&a.bands, a.planar, self.format),
        };
        // A tile too long is told of later.
        let (tiles, passes) = grid(band.width(), band.height(), &self.params)
            .map_or((1, 1), |grid| (grid.len() as u64, self.params.passes(grid)));
        let kept = if self.request.work_dir.is_some() { passes } else { passes.min(2) };
        Estimate { survey_bytes: expected.survey_bytes, ..once.with_tiles(tiles, kept) }
    }

    /// The run to its end, on its own threads.
    fn report(&self) -> Result<Report, RunError> {
        let report = self.pool.install(|| self.run())?;
        warn_of_shortfall(&report, self.request, self.warned);
        Ok(Report { warnings: self.warned.take(), ..report })
    }

    fn run(&self) -> Result<Report, RunError> {
        let start = Instant::now();
        if self.inputs.attributes.is_some() {
            // Finding the ranges may take long, so an output that cannot be written is found first.
            first_look(self.request)?;
        }
        let ranged = self.ranged()?;
        let Inputs { importance, watches, .. } = &self.inputs;
        let open = |dir: &PathBuf| {
            let named = self.named(ranged.as_ref());
            Kept::open(dir, self.band(), importance.as_ref(), watches, named)
        };
        let kept = self.request.work_dir.as_ref().map(open).transpose()?;
        match (self.make(start, ranged.as_ref(), kept.as_ref()), kept) {
            (Ok(report), None) => Ok(report),
            (Ok(report), Some(kept)) => {
                if !self.request.keep_work_dir {
                    kept.finish(self.warned);
                }
                Ok(report)
            }
            (Err(error), None) => Err(error.into()),
            (Err(error), Some(kept)) => Err(kept.explain(error)),
        }
    }

    /// Makes the output, from the tiles in the work dir and those still to be made.
    fn make(&self, start: Instant, ranged: Option<&Ranged<'_>>, kept: Option<&Kept>) -> Result<Report, Error> {
        let (request, params) = (self.request, &self.params);
        let staged = match kept {
            Some(kept) => kept.stage(request)?,
            None => StagedFile::create(&request.output, request.overwrite, &request.inputs())?,
        };
        let partial = staged.partial_path().to_path_buf();
        self.check_disks(Some(partial.parent().unwrap_or(Path::new("."))), kept)?;
        // A file that cannot lie beside the output is found before the long run, as the output itself is.
        let header = provenance::header(request, self.band(), &self.written, ranged);
        let sink = (self.format.sink)(
            staged,
            Setup {
                header,
                loss: self.written.loss,
                as_is: false,
                options: request.sink,
                texture: self.texture.clone(),
                temp_dir: Some(params.temp_dir.clone()),
                cancel: self.control.cancel.clone(),
            },
        )?;
        self.warn_of_attributes(ranged);
        self.make_into(sink, &partial, start, ranged, kept)
    }

    /// Makes the mesh in arrays. Gives what a file with it would say of itself.
    fn fill(&self, arrays: &mut Arrays) -> Result<(Report, Header), RunError> {
        let start = Instant::now();
        let ranged = self.ranged()?;
        self.check_disks(None, None)?;
        let sink = Box::new(ArraySink::new(&self.request.output, arrays));
        let report = self.make_into(sink, Path::new(""), start, ranged.as_ref(), None)?;
        let header = provenance::header(self.request, self.band(), &self.written, ranged.as_ref());
        Ok((Report { output: String::new(), format: IN_MEMORY, ..report }, header))
    }

    /// Makes the mesh and hands it to a sink, whose unfinished file is called `partial`.
    fn make_into(
        &self,
        sink: Box<dyn Sink + '_>,
        partial: &Path,
        start: Instant,
        ranged: Option<&Ranged<'_>>,
        kept: Option<&Kept>,
    ) -> Result<Report, Error> {
        let (request, params) = (self.request, &self.params);
        let field = self.field(ranged, partial)?;
        let opened = Instant::now();
        let mesh = match kept {
            Some(kept) if self.purpose == Purpose::Merge => kept.merge(&field, params, self.control)?,
            Some(kept) => triangulate_into(&|pass| kept.spool(pass), &field, params, self.control)?,
            None => triangulate(&field, params, self.control)?,
        };
        let unchanged = || self.inputs.watches.iter().try_for_each(|watch| watch.check());
        unchanged()?;
        let triangulated = Instant::now();
        let frame = self.written.frame;
        let normals = request.normals.map(|normals| NormalSource { normals, field: &field, frame });
        let summary = mesh.write_if(sink, normals, self.control, &|| {
            unchanged()?;
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
        let sources = Sources {
            request,
            format: self.format,
            band: self.band(),
            points: self.inputs.points.as_ref().map(|Points { layer, counts, .. }| (layer.as_str(), *counts)),
            ranged,
            written: &self.written,
            continues: kept.is_some(),
        };
        Ok(Report::new(&sources, &field, params, self.plan, &summary, seconds, &mesh))
    }

    /// The samples, readable, with voids filled.
    pub(super) fn field(&self, ranged: Option<&Ranged<'_>>, partial: &Path) -> Result<Field, Error> {
        let (request, temp_dir) = (self.request, &self.params.temp_dir);
        let maps_files = request.guard.is_some();
        let options = FieldOptions { temp_dir: temp_dir.clone(), choice: request.access, maps_files };
        let (band, importance) = (self.band(), self.inputs.importance.as_ref());
        let field = match ranged {
            None => Field::open_with_importance(band, importance, &options, self.control)?,
            Some(ranged) => ranged.open(band, &options, self.control)?,
        };
        let field = field.watched(Arc::clone(&self.inputs.watches));
        let in_place = |f: &&Field| *f.access() == Access::InPlace;
        // Attributes are bands of the same file.
        let mapped = [field.each().find(in_place).map(|_| &field), field.importance().filter(in_place)];
        let mapped: Vec<PathBuf> = mapped.into_iter().flatten().map(|f| f.name().to_path_buf()).collect();
        if let Some(guard) = request.guard.filter(|_| !mapped.is_empty()) {
            guard(&mapped, partial).map_err(|source| FieldError::Map { path: band.path().to_path_buf(), source })?;
        }
        if request.fill_voids == 0 {
            return Ok(field);
        }
        // This reads samples, perhaps of a mapped file.
        let voids = HoleOptions {
            most: request.fill_voids,
            // Lists that grow leave about as much behind.
            memory_bytes: self.plan.before_tiles_bytes / 2,
            temp_dir: temp_dir.clone(),
        };
        Ok(field.with_holes_bridged(&voids, self.control)?)
    }

    /// Looks at the raster once more where the tiles' heights hint at something worth a warning. The output is there
    /// whatever comes of this.
    fn look(&self, errors: &ErrorStats) {
        let has_voids = errors.nodata + errors.bridged > 0;
        let has_zero_tag = self.band().zero_tag.is_some();
        let hints = errors.heights.is_some_and(|heights| heights.is_suspicious());
        let is_flat = self.inputs.attributes.as_ref().is_some_and(|a| a.planar);
        if has_voids
            && !is_flat
            && (hints || has_zero_tag)
            && let Ok(look) = look(self.band(), self.control)
        {
            self.warned.tell_all(&look.warnings(self.band()));
        }
    }

    /// Tells of attributes that the output's format does not keep.
    fn warn_of_attributes(&self, ranged: Option<&Ranged<'_>>) {
        let Some(ranged) = ranged.filter(|_| self.format.attributes == Attributes::None) else { return };
        let names = ranged.names();
        let message = format!(
            "{} keeps no attributes of vertices: {} are bounded by the error, but not in the file",
            self.format.title,
            names.join(", ")
        );
        let (file, count) = (self.request.output.clone(), names.len() as u64);
        self.warned.tell(Warning { code: WarningCode::AttributesLost, file, count, message });
    }

    /// Refuses what the disks cannot hold: `output_folder` is that of the output, if it is a file. A few tiles are only tried
    /// where the densest mesh would not fit.
    fn check_disks(&self, output_folder: Option<&Path>, kept: Option<&Kept>) -> Result<(), Error> {
        let temp_dir = self.params.temp_dir.as_path();
        let (tiles, there) = kept.map_or((temp_dir, 0), |kept| (kept.path(), kept.chunk_bytes()));
        let check = |estimate: Estimate| {
            let uses = [
                DiskUse { what: "decoded samples", folder: temp_dir, bytes: estimate.field_bytes },
                DiskUse { what: "what tiles tell under a goal", folder: temp_dir, bytes: estimate.survey_bytes },
                DiskUse { what: "finished tiles", folder: tiles, bytes: estimate.spool_bytes.saturating_sub(there) },
            ];
            let output =
                output_folder.map(|folder| DiskUse { what: "the output", folder, bytes: estimate.output_bytes });
            check_disk(&uses.into_iter().chain(output).collect::<Vec<_>>())
        };
        if check(self.estimate(Expected::densest(DENSEST, self.band().samples(), &self.params))).is_ok() {
            return Ok(());
        }
        let ranged = self.ranged()?;
        Ok(check(self.needs(ranged.as_ref())?.estimate)?)
    }
}

/// The image that is to lie over the mesh, cut to the raster.
#[cfg(feature = "gdal")]
fn texture(request: &Request<'_>, band: &Band) -> Result<Option<Texture>, RunError> {
    let Some(texture) = &request.texture else { return Ok(None) };
    Ok(Some(crate::raster::drape(&texture.path, band.extent(), band.crs_definition(), texture.size)?))
}

#[cfg(not(feature = "gdal"))]
fn texture(_: &Request<'_>, _: &Band) -> Result<Option<Texture>, RunError> {
    Ok(None)
}

/// Finds an output that cannot be written. A work dir may have one of its own there.
fn first_look(request: &Request<'_>) -> Result<(), RunError> {
    let overwrite = request.overwrite || request.work_dir.is_some();
    Ok(StagedFile::check(&request.output, overwrite, &request.inputs())?)
}

pub(super) fn all_cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

#[cfg(feature = "gdal")]
fn bound_cache(bytes: u64) {
    crate::raster::bound_gdal_cache(bytes);
}

#[cfg(not(feature = "gdal"))]
fn bound_cache(_: u64) {}
