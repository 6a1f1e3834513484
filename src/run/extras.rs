//! What is made beside a verdict, from the same sweep: a raster of the errors, what a report shows, and residuals of checkpoints.

use std::error::Error;
#[cfg(feature = "gdal")]
use std::path::{Path, PathBuf};

use super::RunError;
use super::checkpoints::{CheckpointReport, CheckpointSource, Finding};
use super::judge::VerifyRequest;
use super::scene::{Gatherer, Most, Scene};
use super::survey::{Survey, Surveyor};
use crate::base::{Band, GeoTransform};
#[cfg(feature = "gdal")]
use crate::raster::{Described, RowWriter, WriteError};
use crate::verify::{ObservedRows, Observer, RowObserver, Verdict};

/// What a mesh is asked for beside its verdict.
#[derive(Debug, Clone, Default)]
pub struct Extras {
    /// Where a raster of the errors is written: the height of the surface less that of the sample, for every sample, as a tiled
    /// GeoTIFF of single floats with the place and the CRS of the raster; NaN, its nodata value, where there is no surface or no
    /// height. A value is beyond the tolerance if and only if its sample is (where errors are not weighted).
    #[cfg(feature = "gdal")]
    pub error_raster: Option<PathBuf>,
    /// Whether that may replace a file.
    #[cfg(feature = "gdal")]
    pub overwrite: bool,
    /// Whether a [`Survey`] is made.
    pub survey: bool,
    /// How much of the mesh is in [`super::VerifyReport::scene`], for looking at it; `None` for nothing.
    pub scene: Option<Most>,
    /// Checkpoints that are held against the mesh.
    pub checkpoints: Option<CheckpointSource>,
}

/// What is being made.
#[derive(Default)]
pub(super) struct Making {
    #[cfg(feature = "gdal")]
    raster: Option<ErrorRaster>,
    surveyor: Option<Surveyor>,
    finding: Option<Finding>,
    scene: Option<(Gatherer, GeoTransform)>,
}

/// What was made.
pub(super) struct Made {
    pub(super) survey: Option<Survey>,
    pub(super) checkpoints: Option<CheckpointReport>,
    pub(super) scene: Option<Scene>,
}

impl Making {
    /// Begins, before any sample is read.
    pub(super) fn begin(request: &VerifyRequest, band: &Band) -> Result<Making, RunError> {
        #[cfg(feature = "gdal")]
        let raster = request.extras.error_raster.as_deref();
        Ok(Making {
            #[cfg(feature = "gdal")]
            raster: raster.map(|path| ErrorRaster::create(path, request, band)).transpose()?,
            finding: request.extras.checkpoints.as_ref().map(|source| Finding::begin(source, band)).transpose()?,
            surveyor: request.extras.survey.then(|| Surveyor::new(band, request.max_error)),
            scene: request.extras.scene.map(|most| {
                let last = |count: usize| (count - 1) as f64;
                let extent = [0.0, 0.0, last(band.width()), last(band.height())];
                (Gatherer::new(extent, most), band.geo_transform())
            }),
        })
    }

    /// The mesh is open, and has so many triangles.
    pub(super) fn expect(&mut self, triangles: u64) {
        self.scene.iter_mut().for_each(|(gatherer, _)| gatherer.expect(triangles));
    }

    /// Who is to be told of faces and rows; nobody, if nothing is made.
    pub(super) fn observer(&mut self) -> Option<&mut dyn Observer> {
        let is_watching = self.surveyor.is_some() || self.finding.is_some() || self.scene.is_some();
        #[cfg(feature = "gdal")]
        let is_watching = is_watching || self.raster.is_some();
        is_watching.then_some(self as &mut dyn Observer)
    }

    /// Ends what was made of the mesh that was judged so.
    pub(super) fn finish(self, verdict: &Verdict) -> Result<Made, RunError> {
        #[cfg(feature = "gdal")]
        self.raster.map_or(Ok(()), |raster| raster.writer.finish())?;
        let worst = verdict.worst.map_or(0.0, |worst| worst.error);
        let largest = verdict.weighted_worst.map_or(worst, |worst| worst.weighted_error);
        Ok(Made {
            survey: self.surveyor.map(|surveyor| surveyor.finish(worst, largest)),
            checkpoints: self.finding.map(Finding::finish),
            scene: self.scene.map(|(gatherer, map)| {
                gatherer.finish(verdict.triangles).placed(|[column, row, height]| {
                    let (x, y) = map.place(column, row);
                    [x, y, height]
                })
            }),
        })
    }
}

/// A place in quarters of cells and a height, in cells.
fn in_cells((column, row): (i64, i64), height: f64) -> [f64; 3] {
    let cells = |quarters: i64| quarters as f64 / 4.0;
    [cells(column), cells(row), height]
}

impl Observer for Making {
    fn vertex(&mut self, place: (i64, i64), height: f64) {
        self.scene.iter_mut().for_each(|(gatherer, _)| gatherer.vertex(in_cells(place, height)));
    }

    fn face(&mut self, corners: [(i64, i64); 3], heights: [f64; 3]) {
        self.surveyor.iter_mut().for_each(|surveyor| surveyor.face(corners, heights));
        self.finding.iter_mut().for_each(|finding| finding.face(corners, heights));
        if let Some((gatherer, _)) = &mut self.scene {
            gatherer.triangle(std::array::from_fn(|corner| in_cells(corners[corner], heights[corner])));
        }
    }

    fn row_observer(&self) -> Option<&dyn RowObserver> {
        self.surveyor.as_ref().and_then(Surveyor::row_observer)
    }

    fn needs_errors(&self) -> bool {
        #[cfg(feature = "gdal")]
        let is_written = self.raster.is_some();
        #[cfg(not(feature = "gdal"))]
        let is_written = false;
        is_written
    }

    fn rows(&mut self, rows: &ObservedRows<'_>) -> Result<(), Box<dyn Error + Send + Sync>> {
        #[cfg(feature = "gdal")]
        if let Some(raster) = &mut self.raster {
            raster.take(rows)?;
        }
        self.surveyor.as_mut().map_or(Ok(()), |surveyor| surveyor.rows(rows))
    }
}

/// A raster of errors that is being written.
#[cfg(feature = "gdal")]
struct ErrorRaster {
    writer: RowWriter,
    tolerance: f64,
}

#[cfg(feature = "gdal")]
impl ErrorRaster {
    fn create(path: &Path, request: &VerifyRequest, band: &Band) -> Result<ErrorRaster, WriteError> {
        let unit = &band.reference().height_unit;
        let unit = if unit.is_empty() { "the raster's unit of heights" } else { unit.as_str() };
        let what = format!("height of the mesh less that of the raster, in {unit}");
        let image = format!("{what}: {} less {}", request.mesh.display(), request.input.path().display());
        let described = Described { band: &what, image: &image };
        let writer = RowWriter::create(path, request.extras.overwrite, &request.inputs(), band, described)?;
        Ok(ErrorRaster { writer, tolerance: request.max_error })
    }

    fn take(&mut self, rows: &ObservedRows<'_>) -> Result<(), WriteError> {
        let tolerance = self.tolerance;
        let single = |at: usize, error: f32| match rows.weights {
            None => agreeing(error, rows.is_above(at), tolerance),
            Some(_) => error,
        };
        let singles: Vec<f32> = rows.errors.iter().enumerate().map(|(at, error)| single(at, *error)).collect();
        self.writer.write(&singles)
    }
}

/// Of the single float that is nearest to an error, the one nearest to it that is beyond the tolerance if the error is, else within.
#[cfg(feature = "gdal")]
fn agreeing(single: f32, is_above: bool, tolerance: f64) -> f32 {
    match f64::from(single.abs()) > tolerance {
        false if is_above => single.signum() * least_above(tolerance),
        true if !is_above => single.signum() * largest_within(tolerance),
        _ => single,
    }
}

/// The largest single float that is at most this.
#[cfg(feature = "gdal")]
fn largest_within(tolerance: f64) -> f32 {
    let single = tolerance as f32;
    if f64::from(single) > tolerance { single.next_down() } else { single }
}

/// The least single float above this.
#[cfg(feature = "gdal")]
fn least_above(tolerance: f64) -> f32 {
    largest_within(tolerance).next_up()
}

#[cfg(all(test, feature = "gdal"))]
mod tests {
    use super::*;

    #[test]
    fn single_floats_are_beyond_the_tolerance_as_their_samples_are() {
        for tolerance in [0.0f64, 0.1, 0.3, 5.0, 1e-40, 1e300] {
            for error in [0.0, tolerance, tolerance.next_up(), tolerance.next_down(), tolerance * 1.5, tolerance / 3.0]
            {
                for error in [error, -error] {
                    let above = error.abs() > tolerance;
                    let found = agreeing(error as f32, above, tolerance);
                    assert_eq!(f64::from(found.abs()) > tolerance, above, "{error} at {tolerance}: {found}");
                    let apart = (f64::from(found) - error).abs();
                    assert!(apart <= error.abs() * 2f64.powi(-23) + 2e-45 || found.is_infinite() || error.abs() > 1e38);
                }
            }
        }
        assert!(agreeing(f32::NAN, false, 1.0).is_nan());
    }
}
