//! From a raster and a mesh to a picture.

use std::path::Path;

use super::deviation::Deviation;
use super::edges::Edges;
use super::gouraud::{COLOURS, Gouraud};
use super::legend::{captioned, with_scale};
use super::mesh::for_each_triangle;
use super::relief::{Light, Shading, shaded_samples};
use super::samples::Samples;
use super::vertical::{VerticalScale, cell_size};
use super::view::View;
use super::{Mode, PreviewError, PreviewOptions};
use crate::base::Band;
use crate::base::Window;
use crate::base::control::Control;
use crate::base::staged::StagedFile;
use crate::base::warning::Warning;
use crate::formats::{self, MeshReader, ReadOptions};

use super::canvas::Canvas;

/// What was drawn.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct PreviewReport {
    /// Pixels across, legend included.
    pub width: usize,
    /// Pixels down, legend included.
    pub height: usize,
    /// Triangles that touch the window.
    pub triangles: u64,
    /// The largest error among the samples looked at, in [`Mode::Error`].
    pub largest_error: Option<f64>,
    /// The vertical scale of the shading; `None` in modes without, and for images.
    pub vertical_scale: Option<VerticalScale>,
    /// What a user should know of the raster.
    pub warnings: Vec<Warning>,
}

/// Draws a mesh above its raster and writes a PNG.
///
/// The mesh is read twice from end to end. It needs a temporary file of 32 bytes per vertex, and memory for the
/// picture and, where samples are shown, for 4096² samples at most. Where the vertical scale is chosen, up to 4 million samples
/// are read for it.
///
/// # Errors
/// [`PreviewError`], also for [`Mode::Colour`] if the mesh has no colours; then nothing new is left at `out` or beside
/// it.
pub fn preview(
    raster: &Path,
    mesh: &Path,
    out: &Path,
    options: &PreviewOptions,
    control: &Control,
) -> Result<PreviewReport, PreviewError> {
    check(options)?;
    let cutline = options.view.cutline.as_ref();
    let others = cutline
        .map(|c| c.path.as_path())
        .into_iter()
        .chain(options.importance.as_ref().map(|(path, _)| path.as_path()));
    let inputs: Vec<&Path> = [raster, mesh].into_iter().chain(others).collect();
    // Found before the work; the file itself is made after it, so that a killed run leaves nothing.
    StagedFile::check(out, options.overwrite, &inputs)?;
    let raster = options.view.open(raster, &control.cancel)?;
    let warnings = raster.warnings().to_vec();
    let band = raster.to_band()?;
    let importance = match &options.importance {
        Some((path, view)) => Some(raster.open_on_its_grid(path, view)?.to_band()?),
        None => None,
    };
    band.holds_rows(band.width())?;
    let window = Window { column: 0, row: 0, width: band.width(), height: band.height() };
    let view = View::fit(window, options.size);
    let is_shaded = options.mode.is_shaded() && !options.image;
    let vertical_scale =
        is_shaded.then(|| VerticalScale::of(&band, options.exaggeration, &view, control)).transpose()?;
    let mut job = Job {
        light: Light::new(cell_size(&band), vertical_scale.map_or(1.0, |scale| scale.factor)),
        view,
        mesh: formats::open(mesh, None, &ReadOptions { cancel: control.cancel.clone(), temp_dir: None })?,
        band,
        importance,
        options,
        control,
    };
    let (canvas, triangles, largest_error) = match options.mode {
        Mode::Hillshade => job.shaded(false)?,
        Mode::Wireframe => job.shaded(true)?,
        Mode::Error => job.errors()?,
        Mode::SideBySide => job.side_by_side()?,
        Mode::Colour => job.coloured()?,
    };
    control.cancel.check()?;
    canvas.save(StagedFile::create(out, options.overwrite, &inputs)?)?;
    Ok(PreviewReport { width: canvas.width, height: canvas.height, triangles, largest_error, vertical_scale, warnings })
}

fn check(options: &PreviewOptions) -> Result<(), PreviewError> {
    let unless = |ok: bool, option, expected, found: String| {
        if ok { Ok(()) } else { Err(PreviewError::Option { option, expected, found }) }
    };
    let (width, height) = options.size;
    let side = 16..=16_384;
    let found = format!("{width}x{height}");
    unless(side.contains(&width) && side.contains(&height), "size", "16 to 16384 pixels each way", found)?;
    let tolerance = options.max_error.unwrap_or(0.0);
    unless(tolerance >= 0.0 && tolerance.is_finite(), "max-error", "a number from 0 on", tolerance.to_string())?;
    let factor = options.exaggeration.unwrap_or(1.0);
    unless(factor > 0.0 && factor.is_finite(), "vertical-exaggeration", "a number above 0", factor.to_string())
}

struct Job<'a> {
    band: Band,
    importance: Option<Band>,
    mesh: Box<dyn MeshReader>,
    view: View,
    light: Light,
    options: &'a PreviewOptions,
    control: &'a Control<'a>,
}

/// A picture, the triangles in it, the largest error.
type Drawn = (Canvas, u64, Option<f64>);

impl Job<'_> {
    fn samples(&self) -> Result<Samples, PreviewError> {
        let samples = Samples::read(&self.band, self.importance.as_ref(), &self.view, self.control)?;
        Ok(if self.options.image { samples.levelled() } else { samples })
    }

    fn shaded(&mut self, with_edges: bool) -> Result<Drawn, PreviewError> {
        let mut shading = Shading::new(self.view);
        let mut edges = if with_edges { Edges::new(self.view) } else { None };
        let transform = self.band.geo_transform();
        let triangles =
            for_each_triangle(self.mesh.as_mut(), &[], &transform, self.view.window, self.control, |triangle| {
                shading.draw(triangle, &self.light);
                edges.iter_mut().for_each(|e| e.draw(triangle));
            })?;
        let mut canvas = shading.finish();
        if let Some(edges) = edges {
            edges.finish(triangles, &mut canvas);
        }
        Ok((canvas, triangles, None))
    }

    fn coloured(&mut self) -> Result<Drawn, PreviewError> {
        let mut gouraud = Gouraud::new(self.view);
        let (transform, window) = (self.band.geo_transform(), self.view.window);
        let triangles =
            for_each_triangle(self.mesh.as_mut(), &COLOURS, &transform, window, self.control, |triangle| {
                gouraud.draw(triangle);
            })?;
        Ok((gouraud.finish(), triangles, None))
    }

    fn errors(&mut self) -> Result<Drawn, PreviewError> {
        let samples = self.samples()?;
        let mut deviation = Deviation::new(self.view, samples);
        let transform = self.band.geo_transform();
        let triangles =
            for_each_triangle(self.mesh.as_mut(), &[], &transform, self.view.window, self.control, |triangle| {
                deviation.draw(triangle);
            })?;
        let tolerance = self.options.max_error;
        let summary = deviation.summary(tolerance);
        let end = [tolerance.unwrap_or(0.0), summary.largest].into_iter().find(|e| *e > 1e-9).unwrap_or(1.0);
        let picture = deviation.finish(end, tolerance);
        let page = with_scale(picture, &summary, end, tolerance, self.view.stride);
        Ok((page, triangles, Some(summary.largest)))
    }

    fn side_by_side(&mut self) -> Result<Drawn, PreviewError> {
        const GAP: usize = 6;
        let samples = self.samples()?;
        let left = shaded_samples(&samples, self.view, &self.light);
        let (right, triangles, _) = self.shaded(true)?;
        let mut both = Canvas::filled(2 * left.width + GAP, left.height, [250, 250, 248]);
        both.paste(&left, 0, 0);
        both.paste(&right, left.width + GAP, 0);
        let Window { width, height, .. } = self.view.window;
        let caption = format!("left: {width} x {height} samples    right: {triangles} triangles");
        Ok((captioned(both, &[caption]), triangles, None))
    }
}
