//! A run, from its request to the report.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use super::attributes::Ranged;
use super::inputs::Points;
use super::look::look;
use super::prepare::{Purpose, Run, first_look, titles};
use super::report::{Needs, Report, Seconds, Sources, WorkDirState};
use super::resume::{Kept, finished};
use super::scene::{Gatherer, Watched};
use super::{Coordinates, IN_MEMORY, InMemory, Request, RunError, Warned, provenance};
use crate::base::control::Control;
use crate::base::staged::StagedFile;
use crate::base::warning::{Warning, WarningCode};
use crate::field::{Access, Choice, Field, FieldError, FieldOptions, HoleOptions};
use crate::formats::{ArraySink, Arrays, Attributes, FORMATS, Header, Setup, Sink, SinkOption};
use crate::job::normals::NormalSource;
use crate::job::plan::{DENSEST, DiskUse, Estimate, Expected, check_disk, estimate, probe, probe_field};
use crate::job::work_dir::WorkDir;
use crate::job::{Error, Pass, grid, passes, triangulate, triangulate_into};
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
    // Normals are attributes there.
    let further = request.further_options().filter(|option| *option != SinkOption::Normals);
    if let Some(option) = request.sink.asked().chain(further).next() {
        let path = request.input.path().to_path_buf();
        return Err(RunError::FormatOption { path, format: IN_MEMORY, option, formats: titles(option) });
    }
    let request = Request {
        format: Some(format),
        output: PathBuf::from(IN_MEMORY),
        coordinates: Coordinates::default(),
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

impl Run<'_> {
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
                let windows = FieldOptions { temp_dir, choice: Choice::Windows, ..FieldOptions::default() };
                let field = ranged.open(self.band(), &windows, self.control)?;
                probe_field(&field, &self.params, self.control)?
            }
        };
        let goal = &self.params.goal;
        let is_budget = goal.most_triangles().is_some() && goal.max_rms.is_none() && self.params.tolerance.is_open();
        let by_budget = is_budget && expected.tolerance.is_none();
        let found_by = if by_budget { "by the budget" } else { "at a few tiles" };
        Ok(Needs::new(found_by, &expected, self.estimate(expected), self.plan))
    }

    fn estimate(&self, expected: Expected) -> Estimate {
        let band = self.band();
        // No run of a search is far beyond the budget.
        let most = self
            .params
            .goal
            .most_triangles()
            .filter(|_| self.is_searched())
            .map_or(f64::INFINITY, |most| 2.0 * most as f64);
        let density = expected.samples_per_triangle.max(band.samples() as f64 / most);
        let heights = estimate(band, self.inputs.importance.as_ref(), density, self.format);
        let once = match &self.inputs.attributes {
            None => heights,
            Some(a) => heights.with_channels(&a.bands, a.planar, self.format),
        };
        // A tile too long is told of later.
        let (tiles, passes) = grid(band.width(), band.height(), &self.params)
            .map_or((1, 1), |grid| (grid.len() as u64, self.params.passes(grid)));
        let (kept, of_best) = if self.request.work_dir.is_some() { (passes, passes) } else { (passes.min(2), 1) };
        // A search keeps its best run beside the one that is being made.
        let kept = if self.is_searched() { kept + of_best } else { kept };
        Estimate { survey_bytes: expected.survey_bytes, ..once.with_tiles(tiles, kept) }
    }

    /// The run to its end, on its own threads.
    fn report(&self) -> Result<Report, RunError> {
        let report = self.pool.install(|| self.run())?;
        warn_of_shortfall(&report, self.request, self.warned);
        Ok(Report { warnings: self.warned.take(), ..report })
    }

    fn run(&self) -> Result<Report, RunError> {
        if self.inputs.attributes.is_some() {
            // Finding the ranges may take long, so an output that cannot be written is found first.
            first_look(self.request)?;
        }
        let ranged = self.ranged()?;
        self.with_work_dir(ranged.as_ref(), |kept| self.make(ranged.as_ref(), kept))
    }

    /// Does something with the work dir, if there is one. What becomes of finished tiles depends on the outcome.
    fn with_work_dir<T>(
        &self,
        ranged: Option<&Ranged<'_>>,
        work: impl FnOnce(Option<&Kept>) -> Result<T, Error>,
    ) -> Result<T, RunError> {
        let open = |dir: &PathBuf| self.kept(|job| WorkDir::open(dir, job), ranged);
        let kept = self.request.work_dir.as_ref().map(open).transpose()?;
        match (work(kept.as_ref()), kept) {
            (Ok(made), None) => Ok(made),
            (Ok(made), Some(kept)) => {
                if !self.request.keep_work_dir {
                    kept.finish(self.warned);
                }
                Ok(made)
            }
            (Err(error), None) => Err(error.into()),
            (Err(error), Some(kept)) => Err(kept.explain(error)),
        }
    }

    /// Makes the output, from the tiles in the work dir and those still to be made.
    fn make(&self, ranged: Option<&Ranged<'_>>, kept: Option<&Kept>) -> Result<Report, Error> {
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
        let Some(most) = request.scene else { return self.make_into(sink, Some(&partial), ranged, kept) };
        let mut gatherer = Gatherer::new(self.band().extent(), most);
        let watched = Box::new(Watched::new(sink, &mut gatherer));
        let report = self.make_into(watched, Some(&partial), ranged, kept)?;
        let scene = gatherer.finish(report.triangles);
        Ok(Report { scene: Some(scene), ..report })
    }

    /// Makes the mesh in arrays. Gives what a file with it would say of itself.
    fn fill(&self, arrays: &mut Arrays) -> Result<(Report, Header), RunError> {
        let ranged = self.ranged()?;
        let report = self.with_work_dir(ranged.as_ref(), |kept| {
            self.check_disks(None, kept)?;
            let sink = Box::new(ArraySink::new(&self.request.output, arrays));
            self.make_into(sink, None, ranged.as_ref(), kept)
        })?;
        let header = provenance::header(self.request, self.band(), &self.written, ranged.as_ref());
        let header = Header { tolerance: report.tolerance, ..header };
        Ok((Report { output: String::new(), format: IN_MEMORY, ..report }, header))
    }

    /// Makes the mesh and hands it to a sink, whose unfinished file is called `partial`, if it has one.
    fn make_into(
        &self,
        sink: Box<dyn Sink + '_>,
        partial: Option<&Path>,
        ranged: Option<&Ranged<'_>>,
        kept: Option<&Kept>,
    ) -> Result<Report, Error> {
        let (request, params) = (self.request, &self.params);
        let field = match self.needs_samples(kept) {
            true => self.field(ranged, partial.unwrap_or(Path::new("")))?,
            false => self.field_of_no_use(ranged)?,
        };
        let opened = Instant::now();
        let mesh = match kept {
            Some(kept) if self.purpose == Purpose::Merge => kept.merge(&field, params, self.control)?,
            Some(kept) => triangulate_into(kept, &field, params, self.control)?,
            None => triangulate(&field, params, self.control)?,
        };
        let unchanged = || self.inputs.watches.iter().try_for_each(|watch| watch.check());
        unchanged()?;
        let triangulated = Instant::now();
        let frame = self.written.frame;
        let normals = request.normals.map(|normals| NormalSource { normals, field: &field, frame });
        let summary = mesh.write_if(sink, normals, self.control, &|| {
            unchanged()?;
            kept.filter(|_| partial.is_some()).map_or(Ok(()), Kept::committing)
        })?;
        self.look(&summary.errors);
        let seconds = Seconds {
            total: self.started.elapsed().as_secs_f64(),
            open: (opened - self.started).as_secs_f64(),
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

    /// Whether any sample is read once everything is open: chunks that are there already have to be compared with them only where
    /// nothing else proves that the raster is the same; but a search tries a few tiles.
    fn needs_samples(&self, kept: Option<&Kept>) -> bool {
        let is_proved = kept.is_some_and(|kept| kept.dir().has_same_samples());
        let is_free = self.request.normals.is_none() && self.params.breaklines.is_none() && !self.is_searched();
        self.purpose != Purpose::Merge || !is_free || !is_proved
    }

    /// The samples where nobody reads them: nothing is decoded, and no void is looked for.
    fn field_of_no_use(&self, ranged: Option<&Ranged<'_>>) -> Result<Field, Error> {
        let temp_dir = self.params.temp_dir.clone();
        self.opened(ranged, &FieldOptions { temp_dir, choice: Choice::Windows, ..FieldOptions::default() })
    }

    fn opened(&self, ranged: Option<&Ranged<'_>>, options: &FieldOptions) -> Result<Field, Error> {
        let (band, importance) = (self.band(), self.inputs.importance.as_ref());
        Ok(match ranged {
            None => Field::open_with_importance(band, importance, options, self.control)?,
            Some(ranged) => ranged.open(band, options, self.control)?,
        })
    }

    /// The samples, readable, with voids filled.
    pub(super) fn field(&self, ranged: Option<&Ranged<'_>>, partial: &Path) -> Result<Field, Error> {
        let (request, temp_dir) = (self.request, &self.params.temp_dir);
        let maps_files = request.guard.is_some();
        // A share of the tiles needs a part of the samples; where it needs more, they come one after the other.
        let in_parts = self.purpose == Purpose::Share;
        let options = FieldOptions { temp_dir: temp_dir.clone(), choice: request.access, maps_files, in_parts };
        let field = self.opened(ranged, &options)?.watched(Arc::clone(&self.inputs.watches));
        let in_place = |f: &&Field| *f.access() == Access::InPlace;
        // Attributes are bands of the same file.
        let mapped = [field.each().find(in_place).map(|_| &field), field.importance().filter(in_place)];
        let mapped: Vec<PathBuf> = mapped.into_iter().flatten().map(|f| f.name().to_path_buf()).collect();
        if let Some(guard) = request.guard.filter(|_| !mapped.is_empty()) {
            guard(&mapped, partial)
                .map_err(|source| FieldError::Map { path: self.band().path().to_path_buf(), source })?;
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
        if self.purpose == Purpose::Merge {
            // All tiles are there, and how large the mesh is they say: the output's disk tells if it is too small.
            return Ok(());
        }
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
