//! A run with attributes: what it does more than one of heights alone.

use crate::base::channels::{Channel, ChannelBands, Ranges};
use crate::base::control::Control;
use crate::base::{Band, channels_of, exact_double};
use crate::field::{Field, FieldError, FieldOptions, find_ranges};
use crate::formats::{OptionName, RunOption};

/// The attributes of a run: the bands, what they are called, and the ranges they are scaled by.
#[derive(Debug)]
pub(super) struct Ranged<'a> {
    pub(super) bands: &'a ChannelBands,
    pub(super) ranges: Ranges,
    pub(super) channels: Vec<Channel>,
}

impl<'a> Ranged<'a> {
    /// Finds the ranges, which may read the whole raster.
    pub(super) fn find(band: &Band, bands: &'a ChannelBands, control: &Control<'_>) -> Result<Ranged<'a>, FieldError> {
        let channels = channels_of(&bands.bands);
        Ok(Ranged { bands, ranges: find_ranges(band, bands, control)?, channels })
    }

    pub(super) fn open(&self, band: &Band, options: &FieldOptions, control: &Control<'_>) -> Result<Field, FieldError> {
        Field::open_extended(band, options, self.bands, &self.ranges, control)
    }

    /// What the attributes are called.
    pub(super) fn names(&self) -> Vec<&str> {
        self.channels.iter().map(|channel| channel.name.as_str()).collect()
    }

    /// What of this decides the bytes of a tile, by name.
    pub(super) fn named(&self) -> Vec<(&'static str, String)> {
        let ranges = self.ranges.channels.iter().chain([&self.ranges.heights]);
        let ranges: Vec<String> =
            ranges.map(|r| format!("{} to {}", exact_double(r.min), exact_double(r.max))).collect();
        let bands = self.bands.bands.iter().zip(&self.channels);
        let bands: Vec<String> = bands.map(|(band, c)| format!("{} {}", band.number(), c.name)).collect();
        vec![
            ("channels", bands.join(", ")),
            ("emphasis", exact_double(self.bands.emphasis)),
            ("planar", self.bands.planar.to_string()),
            ("ranges", ranges.join(", ")),
        ]
    }

    /// What the file says of itself: what `verify` has to be told.
    pub(super) fn option(&self) -> RunOption {
        let ChannelBands { bands, emphasis, planar } = self.bands;
        let bands: Vec<String> = bands.iter().map(|band| band.number().to_string()).collect();
        let planar = if *planar { ", planar" } else { "" };
        RunOption::new(OptionName::Attributes, format!("{}, emphasis {emphasis}{planar}", bands.join(",")))
    }
}
