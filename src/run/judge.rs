//! Judging a mesh as a run: `verify` with everything opened, and its report.

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use serde::Serialize;

use super::checkpoints::CheckpointReport;
use super::extras::{Extras, Made, Making};
use super::inputs::{open, open_importance};
use super::lines::{UnusableLines, check_judged, path};
use super::look::look;
use super::report::SCHEMA;
use super::scene::Scene;
use super::survey::Survey;
use super::threads::start_threads;
use super::{Attributes, Input, LineInput, LineTypes, RunError, Warned};
use crate::base::Band;
use crate::base::control::Control;
use crate::base::warning::Warnings;
use crate::formats::{Format, MeshReader};
use crate::job::plan::all_cores;
use crate::verify::{self, GroundOptions, RequiredLines, Verdict, VerifyError, VerifyOptions};

/// A mesh that is to be judged, and what it was made from: everything that the command `verify` can be asked for.
#[derive(Debug, Clone)]
pub struct VerifyRequest {
    /// The heights.
    pub input: Input,
    /// The mesh.
    pub mesh: PathBuf,
    /// The format of the mesh; `None` goes by its extension, or else by its content.
    pub format: Option<&'static Format>,
    /// The distance allowed at every sample; where there is importance, distance × weight.
    pub max_error: f64,
    /// How far the surface may be beyond the heights of the samples around it, between samples, as a multiple of `max_error`
    /// from 1 on; see [`VerifyOptions::max_stray`]. `None`: that is not judged.
    pub max_stray: Option<f64>,
    /// Further bands that are to be attributes of the vertices, within the tolerance together with the heights.
    pub attributes: Option<Attributes>,
    /// Weights of errors, on the samples of the input.
    pub importance: Option<Input>,
    /// The largest void to be filled, in samples; 0 for none.
    pub fill_voids: u64,
    /// So many cells from missing samples the mesh may end short of the ground.
    pub trim: u32,
    /// Lines that edges of the mesh are to follow, one set of each kind at the most.
    pub lines: Vec<LineInput>,
    /// Threads to work with; `None` is as many as the machine has cores. The verdict does not depend on them.
    pub threads: Option<NonZeroUsize>,
    /// The folder of temporary files; `None` is the system's.
    pub temp_dir: Option<PathBuf>,
    /// What is made beside the verdict.
    pub extras: Extras,
}

/// What was found out about a mesh.
#[derive(Debug, Clone, Serialize)]
pub struct VerifyReport {
    /// See [`SCHEMA`].
    pub schema: u32,
    /// Whether the mesh keeps the promise.
    pub passed: bool,
    /// What is wrong, one sentence for each kind of fault.
    pub failures: Vec<String>,
    /// What the user should know of the inputs.
    pub warnings: Warnings,
    /// Samples with a height, but in no cell with two others.
    pub isolated_samples: u64,
    /// Samples of the ground that the mesh leaves uncovered where it may; 0 where it may not.
    pub trimmed_samples: u64,
    /// Where it was asked for ([`Extras::survey`]).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub survey: Option<Survey>,
    /// Where there are some ([`Extras::checkpoints`]).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub checkpoints: Option<CheckpointReport>,
    /// The mesh to be looked at, if that was asked for ([`Extras::scene`]).
    #[serde(skip)]
    pub scene: Option<Scene>,
    /// Everything else.
    #[serde(flatten)]
    pub verdict: Verdict,
}

impl VerifyRequest {
    /// A mesh that is to be within this distance of every sample.
    pub fn new(input: impl Into<Input>, mesh: impl Into<PathBuf>, max_error: f64) -> VerifyRequest {
        VerifyRequest {
            input: input.into(),
            mesh: mesh.into(),
            format: None,
            max_error,
            max_stray: None,
            attributes: None,
            importance: None,
            fill_voids: 0,
            trim: 0,
            lines: Vec::new(),
            threads: None,
            temp_dir: None,
            extras: Extras::default(),
        }
    }

    /// The files that it names to be read.
    pub fn inputs(&self) -> Vec<&Path> {
        let mut files = vec![self.input.path(), self.mesh.as_path()];
        files.extend(self.importance.as_ref().map(Input::path));
        files.extend(self.lines.iter().filter_map(LineInput::file));
        files.extend(self.extras.checkpoints.as_ref().map(|source| source.path.as_path()));
        #[cfg(feature = "gdal")]
        if let Input::Raster { view, .. } = &self.input {
            files.extend(view.cutline.as_ref().map(|cutline| cutline.path.as_path()));
        }
        files
    }
}

/// Judges a mesh, see [`verify_ground`](crate::verify::verify_ground). A mesh that is merely wrong is a report.
///
/// # Errors
/// [`RunError`]: the raster, the mesh or what else is read cannot be used, or the caller asked to stop.
pub fn verify(request: &VerifyRequest, control: &Control<'_>) -> Result<VerifyReport, RunError> {
    judge(request, None, control)
}

/// Does what [`verify()`] does with a mesh that is open, such as one in arrays; the request's own is not looked at.
///
/// # Errors
/// As [`verify()`].
pub fn verify_mesh(
    mesh: &mut dyn MeshReader,
    request: &VerifyRequest,
    control: &Control<'_>,
) -> Result<VerifyReport, RunError> {
    judge(request, Some(mesh), control)
}

fn judge(
    request: &VerifyRequest,
    mesh: Option<&mut dyn MeshReader>,
    control: &Control<'_>,
) -> Result<VerifyReport, RunError> {
    let warned = Warned::new(control);
    let opened = open(&request.input, request.attributes.as_ref(), &control.cancel)?;
    let importance = request.importance.as_ref().map(|input| open_importance(input, &opened)).transpose()?;
    let untyped = |input: &LineInput| input.clone().of_types(&LineTypes::default());
    let lines: Vec<LineInput> = request.lines.iter().map(untyped).collect();
    let sets = opened.lines(&lines, request.temp_dir.as_deref(), &warned, &control.cancel)?;
    let (band, attributes) = (opened.band, opened.attributes);
    let importance = importance.map(|opened| opened.band);
    warned.tell_all(band.warnings());
    importance.iter().for_each(|importance| warned.tell_all(importance.warnings()));
    let VerifyRequest { max_error, max_stray, ref temp_dir, .. } = *request;
    let size = (band.width(), band.height());
    let judged = |(kind, error)| match error {
        VerifyError::Scratch(_) | VerifyError::Cancelled(_) => RunError::from(error),
        error => UnusableLines::Judged { path: path(&request.lines, kind, &band), kind, error: Box::new(error) }.into(),
    };
    let pool = start_threads(request.threads.map_or_else(all_cores, usize::from))?;
    let on_lattice = || RequiredLines::new(&sets, size, max_error, temp_dir.as_deref(), &control.cancel);
    let lines = (!sets.is_empty()).then(|| pool.install(on_lattice)).transpose().map_err(judged)?;
    lines.as_ref().map_or(Ok(()), |lines| check_judged(&request.lines, &sets, &band, lines))?;
    drop(sets);
    let options = VerifyOptions {
        max_error,
        max_stray,
        importance: importance.as_ref(),
        lines: lines.as_ref(),
        temp_dir: temp_dir.clone(),
    };
    let ground = GroundOptions { fill_holes: request.fill_voids, trim: request.trim };
    let further = attributes.iter().flat_map(|a| &a.bands).chain(&importance);
    bound_gdal_cache(cache_bytes(further.chain([&band])));
    let mut making = Making::begin(request, &band)?;
    let verdict = pool.install(|| {
        let mut opened = None;
        let mesh = match mesh {
            Some(mesh) => mesh,
            None => opened.insert(verify::open(&band, &request.mesh, &options, control)?).as_mut(),
        };
        making.expect(mesh.face_count());
        let channels = attributes.as_ref();
        let verdict = verify::verify_observed(&band, mesh, &options, ground, channels, making.observer(), control)?;
        let judge_lines = |lines| verify::verify_lines(&band, mesh, max_error, lines, &control.cancel);
        let lines = lines.as_ref().map(judge_lines).transpose()?;
        Ok::<Verdict, RunError>(Verdict { lines, ..verdict })
    })?;
    drop(pool);
    let Made { survey, checkpoints, scene } = making.finish(&verdict)?;
    let is_flat = attributes.as_ref().is_some_and(|a| a.planar);
    if verdict.nodata + verdict.bridged > 0 && !is_flat {
        let look = look(&band, control).map_err(RunError::of_look)?;
        warned.tell_all(&look.warnings(&band));
    }
    let (passed, failures) = (verdict.passes(), verdict.failures());
    Ok(VerifyReport {
        schema: SCHEMA,
        passed,
        failures,
        warnings: warned.take(),
        isolated_samples: verdict.without_ground.count,
        trimmed_samples: verdict.trim.map_or(0, |trim| trim.trimmed),
        survey,
        checkpoints,
        scene,
        verdict,
    })
}

/// What GDAL's cache is to hold: a row of blocks of each of these bands and the others of its raster, because rows pass a few at
/// a time, fewer than blocks have; and an eighth more for others. No less and no more than these limits.
fn cache_bytes<'b>(bands: impl Iterator<Item = &'b Band>) -> u64 {
    const LIMITS: (u64, u64) = (8 << 20, 64 << 20);
    let rows = bands.map(|band| {
        let (across, down) = band.block_size();
        let samples = (band.width().next_multiple_of(across) as u64).saturating_mul(down as u64);
        samples.saturating_mul((band.sample_type().bytes() * band.bands + usize::from(band.has_mask())) as u64)
    });
    let row = rows.fold(0u64, u64::saturating_add);
    row.saturating_add(row / 8).clamp(LIMITS.0, LIMITS.1)
}

#[cfg(feature = "gdal")]
fn bound_gdal_cache(bytes: u64) {
    crate::raster::bound_gdal_cache(bytes);
}

#[cfg(not(feature = "gdal"))]
fn bound_gdal_cache(_: u64) {}
