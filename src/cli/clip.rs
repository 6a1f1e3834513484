//! `--window` and `--bbox`: the options that `simplify`, `verify`, `info` and `preview` share.

use super::values;
use crate::raster::{BoundingBox, Raster, RasterError, Window};

/// Which part of the raster is meant.
#[derive(Debug, clap::Args)]
pub(crate) struct ClipArgs {
    /// Only these samples of the raster; columns and rows are then counted from the first of them
    #[arg(long, value_name = "XOFF,YOFF,XSIZE,YSIZE", value_parser = values::window, conflicts_with = "bbox")]
    window: Option<Window>,
    /// Only samples inside this box, its sides included: the smallest window that holds all of them. In another CRS the
    /// box's sides may be bent; 65 × 65 places of it are transformed
    #[arg(long, value_name = "XMIN,YMIN,XMAX,YMAX", value_parser = values::bounding_box, allow_hyphen_values = true)]
    bbox: Option<BoundingBox>,
    /// The CRS of --bbox, in any form GDAL takes, such as EPSG:4326; x is longitude there [default: the raster's]
    #[arg(long, value_name = "CRS", requires = "bbox")]
    bbox_crs: Option<String>,
}

impl ClipArgs {
    /// The box, where there is one, with its CRS.
    pub(super) fn bounding_box(&self) -> Option<BoundingBox> {
        self.bbox.clone().map(|bounds| BoundingBox { crs: self.bbox_crs.clone(), ..bounds })
    }

    /// The window as it was given.
    pub(super) fn window(&self) -> Option<Window> {
        self.window
    }

    /// The part of the raster that is meant.
    pub(super) fn clip(&self, raster: Raster) -> Result<Raster, RasterError> {
        match (self.window, self.bounding_box()) {
            (Some(window), _) => raster.clip(window),
            (None, Some(bounds)) => {
                let window = raster.window_of(&bounds)?;
                raster.clip(window)
            }
            (None, None) => Ok(raster),
        }
    }
}
