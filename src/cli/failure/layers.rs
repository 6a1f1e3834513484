//! What mends layers of points, lines and polygons that cannot be used.

use super::Failure;
use crate::raster::{PointsError, ShapesError};

impl From<PointsError> for Failure {
    fn from(error: PointsError) -> Failure {
        let failure = Failure::new(&error);
        match error {
            PointsError::Cancelled(stopped) => stopped.into(),
            PointsError::NoSuchLayer { wanted: Some(_), .. } => failure.hint("choose one with --points-layer"),
            PointsError::Feature { .. } => {
                failure.hint("ogr2ogr -where \"OGR_GEOMETRY='POINT'\" keeps the points of a layer")
            }
            PointsError::Open { .. } => failure.hint("choose another file with --points"),
            PointsError::Crs { .. } => failure.hint("transform the layer with ogr2ogr -t_srs"),
            PointsError::AllOutside { .. } => failure
                .hint("if the coordinates are in another CRS than the layer says, ogr2ogr -a_srs sets the right one"),
            _ => failure,
        }
    }
}

/// Why the layer of an option cannot be used.
pub(in crate::cli) fn of_shapes(error: ShapesError, option: &str) -> Failure {
    let failure = Failure::new(&error);
    match error {
        ShapesError::Cancelled(stopped) => stopped.into(),
        ShapesError::Scratch(ref scratch) => super::of_scratch(scratch, &error),
        ShapesError::Open { .. } => failure.hint(&format!("choose another file with {option}")),
        ShapesError::NoSuchLayer { .. } => failure.hint(&format!("choose one with {option}-layer")),
        ShapesError::Layer { ref found, .. } if found.contains("CURVE") || found == "CIRCULARSTRING" => {
            failure.hint("ogr2ogr -nlt CONVERT_TO_LINEAR makes straight pieces of curves")
        }
        ShapesError::Layer { ref found, .. } if found == "GEOMETRYCOLLECTION" => {
            failure.hint("ogr2ogr -explodecollections takes collections apart")
        }
        ShapesError::Layer { .. } => failure.hint(&format!("choose another layer with {option}-layer")),
        ShapesError::Crs { .. } => {
            failure.hint(&format!("give {option} a layer in the raster's CRS, transformed with ogr2ogr -t_srs"))
        }
        _ => failure,
    }
}
