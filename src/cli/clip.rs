//! `--window` and `--bbox`: the options that `simplify`, `verify`, `info` and `preview` share.

use super::values;
use crate::base::Window;
use crate::raster::{BoundingBox, Part};

/// Which part of the raster is meant.
#[derive(Debug, clap::Args)]
pub(crate) struct ClipArgs {
    /// Only these samples of the raster; columns and rows are then counted from the first of them
    #[arg(long, help_heading = "Input", hide_short_help = true, value_name = "XOFF,YOFF,XSIZE,YSIZE", value_parser = values::window, conflicts_with = "bbox")]
    window: Option<Window>,
    /// Only samples inside this box, its sides included: the smallest window that holds all of them. In another CRS the
    /// box's sides may be bent; 65 × 65 places of it are transformed
    #[arg(long, help_heading = "Input", hide_short_help = true, value_name = "XMIN,YMIN,XMAX,YMAX", value_parser = values::bounding_box, allow_hyphen_values = true)]
    bbox: Option<BoundingBox>,
    /// The CRS of --bbox, in any form GDAL takes, such as EPSG:4326; x is longitude there [default: the raster's]
    #[arg(long, help_heading = "Input", hide_short_help = true, value_name = "CRS", requires = "bbox")]
    bbox_crs: Option<String>,
}

impl ClipArgs {
    /// The part of the raster that is meant.
    pub(super) fn part(&self) -> Part {
        match (self.window, &self.bbox) {
            (Some(window), _) => Part::Window(window),
            (None, Some(bounds)) => Part::Box(BoundingBox { crs: self.bbox_crs.clone(), ..bounds.clone() }),
            (None, None) => Part::Whole,
        }
    }
}
