//! `--importance`: the options that `simplify` and `verify` share.

use std::path::PathBuf;

use super::combinations::Asked;
use super::values;
use crate::base::features::Feature;
use crate::raster::View;
use crate::run::Input;

/// Where the weights of errors come from.
#[derive(Debug, clap::Args)]
pub(crate) struct ImportanceArgs {
    /// A raster of weights on the same grid: distance × weight is within --max-error at every sample; 0 lets it go free
    #[arg(long, help_heading = "Input", hide_short_help = true, value_name = "RASTER")]
    pub(super) importance: Option<PathBuf>,
    /// The band of the weights, counted from 1
    #[arg(
        long,
        help_heading = "Input",
        hide_short_help = true,
        value_name = "N",
        default_value_t = 1,
        requires = "importance"
    )]
    importance_band: usize,
    /// An open option of the importance raster's format. May be given more than once
    #[arg(long = "importance-oo", help_heading = "Input", hide_short_help = true, value_name = "NAME=VALUE", value_parser = values::open_option, requires = "importance")]
    importance_options: Vec<String>,
}

impl ImportanceArgs {
    /// What of this asks for features.
    pub(super) fn ask(&self, asked: &mut Asked) {
        asked.add(Feature::Importance, self.importance.is_some());
    }

    /// The raster, if there is one, and how it is looked at.
    pub(super) fn source(&self) -> Option<(PathBuf, View)> {
        let path = self.importance.clone()?;
        let open_options = self.importance_options.clone();
        Some((path, View { open_options, ..View::of_band(self.importance_band) }))
    }

    /// The same for a run.
    pub(super) fn input(&self) -> Option<Input> {
        self.source().map(|(path, view)| Input::Raster { path, view })
    }
}
