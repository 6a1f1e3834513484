//! A raster before tiles are made from it: opened, watched, and known by all that decides tiles.

use std::collections::BTreeMap;
use std::fs::File;
use std::path::Path;
use std::sync::Arc;

use super::error::PyramidError;
use super::grid::Grid;
use super::samples::Samples;
use super::source::{Scratch, Source};
use super::{Body, TilesRequest, store};
use crate::base::control::Control;
use crate::base::{Files, Watch, exact_double, identity, said};
use crate::field::{Field, FieldOptions};
use crate::job::work_dir::Job;
use crate::raster::{FileWatch, Libraries, Raster};

/// Counts the ways in which tiles have been made of the same request: borders of two ways do not meet, so no set has tiles of both.
const WAY: u32 = 4;

/// A raster on the finest grid.
pub(super) struct Prepared {
    pub(super) raster: Raster,
    pub(super) source: Source,
    pub(super) body: Body,
    pub(super) vertical: String,
    /// They have begun before any sample was read.
    pub(super) watches: Arc<[Box<dyn Watch>]>,
}

/// Opens a raster, and finds out how it lies on its ellipsoid.
pub(super) fn open(request: &TilesRequest, control: &Control<'_>) -> Result<Prepared, PyramidError> {
    let path = &request.input;
    let mut watches: Vec<Box<dyn Watch>> = Vec::new();
    if let Some(cutline) = &request.view.cutline {
        watches.push(Box::new(FileWatch::layer(&cutline.path)));
    }
    let raster = request.view.open(path, &control.cancel)?;
    watches.push(Box::new(FileWatch::new(&raster)?));
    raster.warnings().iter().for_each(|warning| control.progress.warn(warning));
    let geodesy = raster.geodesy(request.vertical_crs.as_deref());
    let geodesy = geodesy.map_err(|source| PyramidError::Geodesy { path: path.clone(), source })?;
    let body = Body { semi_major: geodesy.radii.0, semi_minor: geodesy.radii.1 };
    let vertical = geodesy.vertical.clone();
    // What has to be decoded is decoded when it is brought to the grid, on the threads that memory is there for.
    let options = FieldOptions { temp_dir: request.temp_dir(), in_parts: true, ..FieldOptions::default() };
    let watches: Arc<[Box<dyn Watch>]> = watches.into();
    let band = raster.to_band()?;
    let field = Field::open(&band, &options, control)?.watched(Arc::clone(&watches));
    Ok(Prepared { raster, source: Source::new(field, geodesy, request.void_as.is_marked()), body, vertical, watches })
}

/// Brings all samples to the finest grid, into a temporary file.
pub(super) fn resample(
    prepared: &Prepared,
    grid: Grid,
    request: &TilesRequest,
    control: &Control<'_>,
) -> Result<Samples, PyramidError> {
    let folder = request.temp_dir();
    bring(prepared, grid, request.outside, (store::temporary(&folder)?, &folder), control)
}

/// The same into a file, which is in a folder.
pub(super) fn bring(
    prepared: &Prepared,
    grid: Grid,
    outside: f64,
    file: (File, &Path),
    control: &Control<'_>,
) -> Result<Samples, PyramidError> {
    let source = &prepared.source;
    let area = source.area(grid)?;
    let fill = |scratch: &mut Scratch, first: (i64, i64), heights: &mut [f64]| {
        source.fill(grid, area, scratch, first, heights)
    };
    let made = Samples::make(grid, area, outside, file, || source.scratch(), fill, control);
    // It is the reason of whatever is wrong with the samples.
    source.field.check_files()?;
    made
}

impl Prepared {
    /// Makes sure that what is read is what it was at the beginning.
    pub(super) fn must_be_unchanged(&self) -> Result<(), PyramidError> {
        Ok(self.watches.iter().try_for_each(|watch| watch.check())?)
    }

    /// How the raster is looked at, as options have it, by name.
    pub(super) fn view(&self) -> Result<BTreeMap<String, String>, PyramidError> {
        let band = self.raster.to_band()?;
        let number = [("band", band.number().to_string())];
        let all = number.into_iter().chain(band.view.iter().cloned()).chain(said(&band));
        Ok(all.map(|(name, value)| (name.to_string(), value)).collect())
    }

    /// What decides every byte of a tile.
    pub(super) fn job(&self, request: &TilesRequest) -> Result<Job, PyramidError> {
        // A new field is either one that decides bytes or one that does not.
        let TilesRequest {
            input: _,
            view: _,
            output: _,
            max_error,
            max_level,
            error_factor,
            grid_factor,
            vertical_crs: _,
            outside,
            void_as,
            fine_heights,
            max_stray,
            own_samples,
            gzip,
            overwrite: _,
            work_dir: _,
            keep_work_dir: _,
            memory: _,
            threads: _,
            temp_dir: _,
        } = request;
        let band = self.raster.to_band()?;
        let or = |value: Option<String>, none: &str| value.unwrap_or_else(|| none.to_string());
        let vertical = Some(self.vertical.clone()).filter(|vertical| !vertical.is_empty());
        let mut parameters = vec![
            ("result", "terrain tiles".to_string()),
            ("way of making them", WAY.to_string()),
            ("max error", exact_double(*max_error)),
            ("max level", or(max_level.map(|level| level.to_string()), "by the rule")),
            ("error factor", exact_double(*error_factor)),
            ("grid factor", grid_factor.to_string()),
            ("vertical CRS", or(vertical, "none")),
            ("outside", exact_double(*outside)),
            ("voids", void_as.to_string()),
            ("fine heights", fine_heights.to_string()),
            ("max stray", exact_double(*max_stray)),
            ("own samples", own_samples.to_string()),
            ("gzip", gzip.to_string()),
            // It decides places by the last bit.
            ("PROJ", Libraries::here().proj),
        ];
        parameters.extend(said(&band));
        let definition = band.crs_definition().unwrap_or_default();
        let mut raster = identity(&band)?;
        raster.push((
            "CRS",
            format!("{} (checksum {:08x})", self.raster.crs_name(), crc32fast::hash(definition.as_bytes())),
        ));
        raster.push(("unit of heights", band.reference().height_unit.clone()));
        let files = self.watches.iter().map(|watch| watch.files()).fold(Files::none(), Files::and);
        Ok(Job { parameters, raster, importance: Vec::new(), files })
    }
}
