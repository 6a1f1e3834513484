//! A run before it begins: what is read is open, what goes wrong with the request is found, and memory and threads are planned.

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use super::attributes::Ranged;
use super::coordinates::{Written, fits_single, is_single};
use super::inputs::Inputs;
use super::lines::{UnusableLines, on_lattice, path};
use super::resume::Kept;
use super::threads::start_threads;
use super::{Request, RunError, Warned, provenance};
use crate::base::channels::{Channel, ChannelBands, Number};
use crate::base::control::Control;
use crate::base::external::Scratch;
use crate::base::features::Feature;
use crate::base::staged::StagedFile;
use crate::base::{Band, Texture, channels_of};
use crate::field::{may_have_holes, searched_range};
use crate::formats::{self, Attributes, Base, FORMATS, Format, SinkError, SinkOption};
use crate::job::lines::Lines;
use crate::job::plan::{Load, Plan, all_cores, default_budget};
use crate::job::work_dir::{self, WorkDir, WorkDirError};
use crate::job::{Error, Params, grid, rules};
use crate::kernel::breaklines::TwoHeights;

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
    /// When it was begun to be prepared.
    pub(super) started: Instant,
    pub(super) purpose: Purpose,
    pub(super) request: &'a Request<'a>,
    pub(super) format: &'static Format,
    pub(super) inputs: Inputs,
    pub(super) plan: Plan,
    /// The threads that the plan is for.
    pub(super) pool: rayon::ThreadPool,
    pub(super) written: Written,
    /// The image over the mesh.
    pub(super) texture: Option<Texture>,
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
pub(super) fn titles(option: SinkOption) -> String {
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
    let lowest = searched_range(band, control)?.min;
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
        let started = Instant::now();
        let format = format_of(&request.output, request.format)?;
        let further = request.further_options();
        check_options(&request.output, request.sink.asked().chain(further), format)?;
        let features = request.features();
        rules::check(features)?;
        let inputs = Inputs::open(request, purpose != Purpose::Plan, warned, &control.cancel)?;
        let Inputs { band, attributes, importance, points, .. } = &inputs;
        if is_single(request.coordinates, format) && (!fits_single(band) || request.has_fitted_heights()) {
            rules::check(features.with(Feature::RoundedToSingle))?;
        }
        check_attributes(request, format, attributes.as_ref())?;
        let scratch = Scratch::new(Some(&request.params.temp_dir), control.cancel.clone());
        let breaklines = on_lattice(&request.lines, &inputs.lines, band, scratch)?;
        let grid = grid(band.width(), band.height(), &request.params)?;
        let load = Load {
            band,
            importance: importance.as_ref(),
            channels: attributes.as_ref().map_or(&[], |a| &a.bands),
            grid,
            params: &request.params,
            points: points.as_ref().map_or(0, |p| p.set.len()),
            lines_bytes: breaklines.as_ref().map_or(0, |lines| lines.bytes(&grid)),
            holes: request.fill_voids > 0 && may_have_holes(band)
                || breaklines.as_ref().is_some_and(Lines::have_heights),
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
        let lines_range = breaklines.as_ref().and_then(Lines::height_range);
        let found = || Written::find(request, format, (band, importance.as_ref(), lines_range), is_flat, control);
        let written = pool.install(found)?;
        let params = Params {
            tolerance: written.tolerance,
            goal: written.goal,
            points: points.as_ref().map(|p| p.set.clone()),
            breaklines: breaklines.map(Arc::new),
            ..request.params.clone()
        };
        params.check_lines().map_err(|error: TwoHeights| {
            RunError::from(UnusableLines::TwoHeights { path: path(&request.lines, error.of[0].0, band), error })
        })?;
        if purpose.writes() {
            check_floor(request, band, control)?;
        }
        let texture = if purpose.writes() { texture(request, band)? } else { None };
        Ok(Run { started, purpose, request, format, inputs, plan, pool, written, texture, params, warned, control })
    }

    pub(super) fn band(&self) -> &Band {
        &self.inputs.band
    }

    /// Whether a tolerance is looked for.
    pub(super) fn is_searched(&self) -> bool {
        self.params.is_searched(self.request.features())
    }

    /// The attributes and their ranges, where there are some; finding the ranges may read the whole raster.
    pub(super) fn ranged(&self) -> Result<Option<Ranged<'_>>, Error> {
        let find = |bands| Ranged::find(self.band(), bands, self.control);
        Ok(self.inputs.attributes.as_ref().map(find).transpose()?)
    }

    pub(super) fn named(&self, ranged: Option<&Ranged<'_>>) -> Vec<(&'static str, String)> {
        provenance::named(self.request, &self.params, self.band(), ranged)
    }

    /// The work dir of the run, as `open` gives it.
    pub(super) fn kept(
        &self,
        open: impl FnOnce(&work_dir::Job) -> Result<WorkDir, WorkDirError>,
        ranged: Option<&Ranged<'_>>,
    ) -> Result<Kept, RunError> {
        let Inputs { importance, watches, .. } = &self.inputs;
        Kept::open(open, self.band(), importance.as_ref(), watches, self.named(ranged))
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
pub(super) fn first_look(request: &Request<'_>) -> Result<(), RunError> {
    let overwrite = request.overwrite || request.work_dir.is_some();
    Ok(StagedFile::check(&request.output, overwrite, &request.inputs())?)
}

#[cfg(feature = "gdal")]
fn bound_cache(bytes: u64) {
    crate::raster::bound_gdal_cache(bytes);
}

#[cfg(not(feature = "gdal"))]
fn bound_cache(_: u64) {}
