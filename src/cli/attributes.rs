//! `--attributes`, `--attribute-weight` and `--image`: the options that `simplify` and `verify` share.

use super::combinations::Asked;
use super::values;
use crate::base::features::Feature;
use crate::run::{AttributeBands, Attributes};

/// Further bands beside the heights.
#[derive(Debug, clap::Args)]
pub(super) struct AttributeArgs {
    /// Bands to carry along as colours or other values of the vertices, such as 2,3,4, each counted in the error
    #[arg(long, help_heading = "Input", alias = "channels", value_name = "BANDS", value_parser = values::bands)]
    attributes: Option<values::Bands>,
    /// What the attributes count in the error, from 0 (only the heights do) to 1 (only the attributes) [default: 0.5]
    #[arg(long, help_heading = "Input", hide_short_help = true, alias = "emphasis", value_name = "W", value_parser = values::share, allow_hyphen_values = true)]
    attribute_weight: Option<f64>,
    /// The raster is an image without heights: flat, all bands are attributes unless --attributes says which
    #[arg(long, help_heading = "Input", hide_short_help = true, alias = "planar")]
    image: bool,
}

const DEFAULT_WEIGHT: f64 = 0.5;

impl AttributeArgs {
    /// What of this asks for features. In an image --attributes only chooses bands.
    pub(super) fn ask(&self, asked: &mut Asked) {
        asked.add(Feature::Image, self.image);
        asked.add(Feature::Attributes, self.attributes.is_some() && !self.image);
        asked.add(Feature::AttributeWeight, self.attribute_weight.is_some());
    }

    /// What is asked for.
    pub(super) fn attributes(&self) -> Option<Attributes> {
        let listed = self.attributes.as_ref().map(|bands| bands.0.clone());
        let bands = match (listed, self.image) {
            (Some(numbers), _) => AttributeBands::Numbers(numbers),
            (None, true) => AttributeBands::All,
            (None, false) => return None,
        };
        Some(Attributes { bands, weight: self.attribute_weight.unwrap_or(DEFAULT_WEIGHT), image: self.image })
    }
}
