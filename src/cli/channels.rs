//! `--channels`, `--emphasis` and `--planar`: the options that `simplify` and `verify` share.

use std::path::Path;

use super::combinations::Asked;
use super::{Failure, values};
use crate::base::RasterError;
use crate::base::channels::ChannelBands;
use crate::base::control::CancelToken;
use crate::job::features::Feature;
use crate::raster::{Raster, View, ViewError};

/// Further bands beside the heights, as `simplify` and `verify` take them.
#[derive(Debug, clap::Args)]
pub(super) struct ChannelArgs {
    /// Bands to carry along as colours or other values of the vertices, such as 2,3,4, each counted in the error
    #[arg(long, value_name = "BANDS", value_parser = values::bands)]
    channels: Option<values::Bands>,
    /// What the channels count in the error, from 0 (only the heights do) to 1 (only the channels) [default: 0.5]
    #[arg(long, value_name = "W", value_parser = values::share, allow_hyphen_values = true)]
    emphasis: Option<f64>,
    /// The raster is an image without heights: flat, all bands are channels unless --channels says which
    #[arg(long)]
    planar: bool,
}

const DEFAULT_EMPHASIS: f64 = 0.5;

impl ChannelArgs {
    /// What of this asks for features. In an image --channels only chooses bands.
    pub(super) fn ask(&self, asked: &mut Asked) {
        asked.add(Feature::Image, self.planar);
        asked.add(Feature::Attributes, self.channels.is_some() && !self.planar);
        asked.add(Feature::AttributeWeight, self.emphasis.is_some());
    }

    /// Opens the raster by this view and finds out what the channels are, if any. A planar image is opened by its first
    /// channel.
    pub(super) fn open(
        &self,
        path: &Path,
        view: View,
        cancel: &CancelToken,
    ) -> Result<(Raster, Option<ChannelBands>), Failure> {
        let listed = self.channels.as_ref().map(|bands| bands.0.clone());
        if !self.planar {
            let Some(bands) = listed else { return Ok((view.open(path, cancel)?, None)) };
            // Who names channels knows which bands there are.
            let raster = View { accept_pictures: true, ..view }.open(path, cancel)?;
            let emphasis = self.emphasis.unwrap_or(DEFAULT_EMPHASIS);
            return with_bands(raster, &bands, emphasis, false);
        }
        let first = listed.as_ref().map_or(1, |bands| bands[0]);
        let raster = View { band: Some(first), ..view }.open(path, cancel).map_err(|error| match error {
            ViewError::Raster(error) => in_channels(error),
            other => other.into(),
        })?;
        if listed.is_none() {
            raster.expect_no_table().map_err(|error| {
                let bands = "name the bands with --channels if their numbers are values; ";
                Failure::new(error).hint(&format!("{bands}gdal_translate -expand rgb makes colours of them"))
            })?;
        }
        let bands = listed.unwrap_or_else(|| (1..=raster.band_count()).collect());
        with_bands(raster, &bands, 1.0, true)
    }
}

/// The raster with its channels, whose bands are opened at once.
fn with_bands(
    raster: Raster,
    bands: &[usize],
    emphasis: f64,
    planar: bool,
) -> Result<(Raster, Option<ChannelBands>), Failure> {
    let bands = raster.other_bands(bands).map_err(in_channels)?;
    Ok((raster, Some(ChannelBands { bands, emphasis, planar })))
}

/// Of an error in a band that --channels names.
fn in_channels(error: RasterError) -> Failure {
    match error {
        RasterError::NoSuchBand { .. } | RasterError::SampleType { .. } => {
            Failure::new(error).hint("choose bands with --channels")
        }
        _ => error.into(),
    }
}
