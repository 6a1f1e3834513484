//! The options that decide which samples a command sees, and what they are: shared by `simplify`, `verify`, `preview` and
//! `info`.

use clap::ValueEnum;

use super::clip::ClipArgs;
use super::combinations::Asked;
use super::cutline::CutlineArgs;
use super::values;
use crate::base::features::Feature;
use crate::base::{Encoding, ValidRange};
use crate::raster::View;

/// A view of the raster's heights, in words.
#[derive(Debug, clap::Args)]
pub(crate) struct InputArgs {
    /// The band, counted from 1 [default: 1, which must not be a colour then]
    #[arg(long, help_heading = "Input", hide_short_help = true, value_name = "N")]
    pub(super) band: Option<usize>,
    /// How heights are stored as red, green and blue
    #[arg(long, help_heading = "Input", hide_short_help = true, value_enum)]
    encoding: Option<EncodingArg>,
    /// A stored value that marks missing samples, in place of the raster's nodata tag: a number, inf, -inf, nan, or the word
    /// tag for the tag itself. May be given more than once; none means that no value does
    #[arg(long, help_heading = "Input", value_name = "VALUE", allow_hyphen_values = true)]
    nodata: Vec<String>,
    /// The heights that are valid, both ends included; samples beyond them count as missing
    #[arg(long, help_heading = "Input", hide_short_help = true, value_name = "MIN,MAX", value_parser = values::valid_range, allow_hyphen_values = true)]
    valid_range: Option<ValidRange>,
    /// An open option of the raster's format, such as GDAL's -oo takes it. May be given more than once
    #[arg(long = "oo", help_heading = "Input", hide_short_help = true, value_name = "NAME=VALUE", value_parser = values::open_option)]
    open_options: Vec<String>,
    #[command(flatten)]
    pub(super) clip: ClipArgs,
    #[command(flatten)]
    pub(super) cutline: CutlineArgs,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum EncodingArg {
    /// Mapbox's: (65536 R + 256 G + B - 100000) / 10 metres
    TerrainRgb,
    /// Mapzen's: (65536 R + 256 G + B) / 256 - 32768 metres
    Terrarium,
}

impl InputArgs {
    /// The view that the words stand for.
    pub(super) fn view(&self) -> View {
        View {
            band: self.band,
            open_options: self.open_options.clone(),
            encoding: self.encoding.map(|encoding| match encoding {
                EncodingArg::TerrainRgb => Encoding::TerrainRgb,
                EncodingArg::Terrarium => Encoding::Terrarium,
            }),
            part: self.clip.part(),
            nodata: self.nodata.clone(),
            valid_range: self.valid_range,
            cutline: self.cutline.source(),
            accept_pictures: false,
        }
    }

    /// Whether it says which samples are missing.
    pub(super) fn marks_samples(&self) -> bool {
        !self.nodata.is_empty() || self.valid_range.is_some()
    }

    /// What of this asks for features.
    pub(super) fn asked(&self) -> Asked {
        let mut asked = Asked::default();
        asked.add(Feature::Band, self.band.is_some());
        asked.add(Feature::Encoding, self.encoding.is_some());
        asked.add(Feature::NodataMarks, !self.nodata.is_empty());
        asked.add(Feature::ValidRange, self.valid_range.is_some());
        asked.add(Feature::Cutline, self.cutline.cutline.is_some());
        asked
    }
}
