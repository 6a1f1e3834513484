//! Opening everything that a run reads.

use std::sync::Arc;

#[cfg(feature = "gdal")]
use super::Lines;
use super::request::{AttributeBands, Attributes, Input, PointInput, Request};
use super::{RunError, Warned};
use crate::base::channels::ChannelBands;
use crate::base::control::CancelToken;
use crate::base::{Band, LineSet, PointCounts, PointSet, Watch};
use crate::job::grid;
#[cfg(feature = "gdal")]
use crate::raster::{FileWatch, PointsError, Raster, View, ViewError, read_points};

/// What a run reads.
pub(super) struct Inputs {
    pub(super) band: Band,
    pub(super) attributes: Option<ChannelBands>,
    pub(super) importance: Option<Band>,
    pub(super) points: Option<Points>,
    /// Lines that become edges.
    pub(super) lines: Vec<LineSet>,
    /// They have begun before any sample of these was read.
    pub(super) watches: Arc<[Box<dyn Watch>]>,
}

/// The samples that become vertices.
pub(super) struct Points {
    pub(super) set: Arc<PointSet>,
    pub(super) layer: String,
    pub(super) counts: PointCounts,
}

impl Inputs {
    /// Opens the rasters. Nothing watches them where the run is only planned.
    pub(super) fn open(
        request: &Request<'_>,
        watches: bool,
        warned: &Warned<'_>,
        cancel: &CancelToken,
    ) -> Result<Inputs, RunError> {
        let mut begun: Vec<Box<dyn Watch>> = Vec::new();
        let opened = open(&request.input, request.attributes.as_ref(), cancel)?;
        warned.tell_all(opened.band.warnings());
        let importance = request.importance.as_ref().map(|input| open_importance(input, &opened)).transpose()?;
        if let Some(importance) = &importance {
            warned.tell_all(importance.band.warnings());
        }
        if watches {
            opened.watch(&mut begun)?;
            if let Some(importance) = &importance {
                importance.watch(&mut begun)?;
            }
            watch_layers(request, &mut begun);
        }
        // Before points are read, which may take long.
        grid(opened.band.width(), opened.band.height(), &request.params)?;
        let points = request.points.as_ref().map(|points| opened.points(points, cancel)).transpose()?;
        let lines = opened.lines(&request.lines, Some(&request.params.temp_dir), warned, cancel)?;
        let Opened { band, attributes, .. } = opened;
        let importance = importance.map(|opened| opened.band);
        Ok(Inputs { band, attributes, importance, points, lines, watches: begun.into() })
    }
}

/// A raster, and what is read of it.
pub(super) struct Opened {
    #[cfg(feature = "gdal")]
    pub(super) raster: Option<Raster>,
    pub(super) band: Band,
    pub(super) attributes: Option<ChannelBands>,
}

impl Opened {
    fn of_band(band: Band, attributes: Option<ChannelBands>) -> Opened {
        Opened {
            #[cfg(feature = "gdal")]
            raster: None,
            band,
            attributes,
        }
    }

    #[cfg(feature = "gdal")]
    fn watch(&self, begun: &mut Vec<Box<dyn Watch>>) -> Result<(), RunError> {
        if let Some(raster) = &self.raster {
            begun.push(Box::new(FileWatch::new(raster)?));
        }
        Ok(())
    }

    #[cfg(not(feature = "gdal"))]
    fn watch(&self, _: &mut Vec<Box<dyn Watch>>) -> Result<(), RunError> {
        Ok(())
    }
}

impl Opened {
    /// The samples that become vertices.
    fn points(&self, points: &PointInput, cancel: &CancelToken) -> Result<Points, RunError> {
        match points {
            #[cfg(feature = "gdal")]
            PointInput::Layer(source) => {
                let Some(raster) = &self.raster else {
                    return Err(PointsError::NoRaster { path: source.path.clone() }.into());
                };
                let found = read_points(raster, source, cancel)?;
                Ok(Points { set: found.set, layer: found.layer, counts: found.counts })
            }
            PointInput::Samples(set) => {
                let _ = cancel;
                let used = set.len() as u64;
                let counts = PointCounts { read: used, used, merged: 0, outside: 0 };
                Ok(Points { set: set.clone(), layer: String::new(), counts })
            }
            PointInput::Places(places) => {
                let (transform, size) = (self.band.geo_transform(), (self.band.width(), self.band.height()));
                let nearest = places.iter().filter_map(|place| transform.nearest_sample(*place, size));
                let samples: Vec<(usize, usize)> = nearest.collect();
                let (read, inside) = (places.len() as u64, samples.len() as u64);
                let set = Arc::new(PointSet::new(samples));
                let used = set.len() as u64;
                let counts = PointCounts { read, used, merged: inside - used, outside: read - inside };
                Ok(Points { set, layer: String::new(), counts })
            }
        }
    }
}

/// Opens the heights and the bands beside them.
pub(super) fn open(input: &Input, attributes: Option<&Attributes>, cancel: &CancelToken) -> Result<Opened, RunError> {
    match input {
        #[cfg(feature = "gdal")]
        Input::Raster { path, view } => {
            let raster = match attributes {
                None => view.open(path, cancel)?,
                Some(attributes) => open_beside(path, view, attributes, cancel)?,
            };
            // What marks samples of an image marks those of all its bands.
            let marks = if attributes.is_some_and(|a| a.image) { view.nodata.as_slice() } else { &[] };
            let attributes = attributes.map(|attributes| channels(attributes, Some(&raster), marks)).transpose()?;
            let band = raster.to_band()?;
            Ok(Opened { raster: Some(raster), band, attributes })
        }
        Input::Band(band) => {
            let _ = cancel;
            #[cfg(feature = "gdal")]
            let attributes = attributes.map(|attributes| channels(attributes, None, &[])).transpose()?;
            #[cfg(not(feature = "gdal"))]
            let attributes = attributes.map(channels);
            Ok(Opened::of_band(band.clone(), attributes))
        }
    }
}

/// Opens a raster of whose bands some are attributes. Whoever names bands knows which there are; an image is opened by its
/// first attribute.
#[cfg(feature = "gdal")]
fn open_beside(
    path: &std::path::Path,
    view: &View,
    attributes: &Attributes,
    cancel: &CancelToken,
) -> Result<Raster, RunError> {
    if !attributes.image {
        return Ok(View { accept_pictures: true, ..view.clone() }.open(path, cancel)?);
    }
    let first = match &attributes.bands {
        AttributeBands::Numbers(numbers) => numbers.first().copied().unwrap_or(1),
        AttributeBands::All | AttributeBands::Bands(_) => 1,
    };
    let raster = View { band: Some(first), ..view.clone() }.open(path, cancel).map_err(|error| match error {
        ViewError::Raster(error) => RunError::Attribute(error),
        other => other.into(),
    })?;
    if matches!(attributes.bands, AttributeBands::All) {
        raster.expect_no_table().map_err(RunError::ColourTable)?;
    }
    Ok(raster)
}

/// The bands that are attributes, opened, so that those are found at once that cannot be used.
#[cfg(feature = "gdal")]
fn channels(attributes: &Attributes, raster: Option<&Raster>, nodata: &[String]) -> Result<ChannelBands, RunError> {
    let of = |numbers: &[usize]| match raster {
        Some(raster) => raster.other_bands(numbers, nodata).map_err(RunError::Attribute),
        // A band by itself has no others.
        None => Err(RunError::Attribute(crate::base::RasterError::NoSuchBand {
            path: "the input".into(),
            band: numbers.first().copied().unwrap_or(1),
            count: 1,
        })),
    };
    let bands = match &attributes.bands {
        AttributeBands::All => of(&(1..=raster.map_or(0, Raster::band_count)).collect::<Vec<_>>())?,
        AttributeBands::Numbers(numbers) => of(numbers)?,
        AttributeBands::Bands(bands) => bands.clone(),
    };
    let weight = if attributes.image { 1.0 } else { attributes.weight };
    Ok(ChannelBands { bands, emphasis: weight, planar: attributes.image })
}

#[cfg(not(feature = "gdal"))]
fn channels(attributes: &Attributes) -> ChannelBands {
    let AttributeBands::Bands(bands) = &attributes.bands;
    let weight = if attributes.image { 1.0 } else { attributes.weight };
    ChannelBands { bands: bands.clone(), emphasis: weight, planar: attributes.image }
}

/// Opens the weights, and makes sure that they lie on the samples of the heights.
pub(super) fn open_importance(input: &Input, heights: &Opened) -> Result<Opened, RunError> {
    let opened = match input {
        #[cfg(feature = "gdal")]
        Input::Raster { path, view } => {
            let number = view.band.unwrap_or(1);
            let raster = Raster::open_with(path, number, &view.open_options).map_err(RunError::Importance)?;
            let raster = match &heights.raster {
                Some(heights) => heights.clip_alike(raster)?,
                None => raster,
            };
            let band = raster.to_band()?;
            Opened { raster: Some(raster), band, attributes: None }
        }
        Input::Band(band) => Opened::of_band(band.clone(), None),
    };
    heights.band.same_grid(&opened.band)?;
    Ok(opened)
}

#[cfg(feature = "gdal")]
fn watch_layers(request: &Request<'_>, begun: &mut Vec<Box<dyn Watch>>) {
    if let Input::Raster { view, .. } = &request.input
        && let Some(cutline) = &view.cutline
    {
        begun.push(Box::new(FileWatch::layer(&cutline.path)));
    }
    if let Some(PointInput::Layer(source)) = &request.points {
        begun.push(Box::new(FileWatch::layer(&source.path)));
    }
    for input in &request.lines {
        if let Lines::Layer(source) = &input.from {
            begun.push(Box::new(FileWatch::layer(&source.path)));
        }
    }
}

#[cfg(not(feature = "gdal"))]
fn watch_layers(_: &Request<'_>, _: &mut Vec<Box<dyn Watch>>) {}
