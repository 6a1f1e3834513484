//! `simplify --channels` and `--planar`: what a run does more than one of heights alone.

use serde::Serialize;

use crate::base::channels::{Channel, ChannelBands, Ranges};
use crate::base::control::Control;
use crate::base::{Band, channels_of, exact_double};
use crate::field::{Field, FieldError, FieldOptions, find_ranges};
use crate::formats::{OptionName, RunOption};
use crate::kernel::measure::{ErrorStats, WeightedStats};

/// The channels of a run: the bands, what they are called, and the ranges they are scaled by.
#[derive(Debug)]
pub(super) struct Extended {
    options: ChannelBands,
    ranges: Ranges,
    channels: Vec<Channel>,
}

impl Extended {
    /// Finds the ranges, which may read the whole raster.
    pub(super) fn find(band: &Band, options: &ChannelBands, control: &Control<'_>) -> Result<Extended, FieldError> {
        let channels = channels_of(&options.bands);
        Ok(Extended { options: options.clone(), ranges: find_ranges(band, options, control)?, channels })
    }

    pub(super) fn open(&self, band: &Band, options: &FieldOptions, control: &Control<'_>) -> Result<Field, FieldError> {
        Field::open_extended(band, options, &self.options, &self.ranges, control)
    }

    /// What of this decides the bytes of a tile, by name.
    pub(super) fn named(&self) -> Vec<(&'static str, String)> {
        let ranges = self.ranges.channels.iter().chain([&self.ranges.heights]);
        let ranges: Vec<String> =
            ranges.map(|r| format!("{} to {}", exact_double(r.min), exact_double(r.max))).collect();
        let bands = self.options.bands.iter().zip(&self.channels);
        let bands: Vec<String> = bands.map(|(band, c)| format!("{} {}", band.number(), c.name)).collect();
        vec![
            ("channels", bands.join(", ")),
            ("emphasis", exact_double(self.options.emphasis)),
            ("planar", self.options.planar.to_string()),
            ("ranges", ranges.join(", ")),
        ]
    }

    /// What the channels are called in files.
    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        self.channels.iter().map(|channel| channel.name.as_str())
    }

    /// What the file says of itself: what `verify` has to be told.
    pub(super) fn option(&self) -> RunOption {
        let ChannelBands { bands, emphasis, planar } = &self.options;
        let bands: Vec<String> = bands.iter().map(|band| band.number().to_string()).collect();
        let planar = if *planar { ", planar" } else { "" };
        RunOption::new(OptionName::Attributes, format!("{}, emphasis {emphasis}{planar}", bands.join(",")))
    }

    pub(super) fn report(&self, errors: &ErrorStats) -> ChannelReport {
        let WeightedStats { max, worst: (column, row) } = errors.extended.unwrap_or_default();
        ChannelReport {
            bands: self.options.bands.iter().map(Band::number).collect(),
            attributes: self.channels.clone(),
            emphasis: self.options.emphasis,
            planar: self.options.planar,
            ranges: self.ranges.clone(),
            max_weighted_error: max,
            column,
            row,
        }
    }
}

/// What `simplify` tells of the channels.
#[derive(Debug, Clone, Serialize)]
pub(super) struct ChannelReport {
    bands: Vec<usize>,
    attributes: Vec<Channel>,
    emphasis: f64,
    planar: bool,
    ranges: Ranges,
    max_weighted_error: f64,
    column: u64,
    row: u64,
}

impl ChannelReport {
    pub(super) fn lines(&self) -> [(&'static str, String); 2] {
        let ranges = self.attributes.iter().zip(&self.ranges.channels);
        let ranges: Vec<String> = ranges.map(|(c, r)| format!("{} {} to {}", c.name, r.min, r.max)).collect();
        let ChannelReport { max_weighted_error: max, column, row, .. } = self;
        [
            ("channels", format!("{}; emphasis {}, unit {}", ranges.join(", "), self.emphasis, self.ranges.unit)),
            ("weighted", format!("{max} at the most, at column {column}, row {row}")),
        ]
    }
}
