//! Rasters as GDAL gives and takes them: with OGR's formats and the writer of `synth`, the only place that names GDAL.
//!
//! In comes a path and a [`View`]; out goes a [`Raster`], which says what GDAL knows of it, and of that a
//! [`crate::base::Band`], which is what engines and `verify` read; and the samples nearest to the points of a vector layer
//! ([`read_points`]), and those inside its polygons ([`read_cutline`]). Numbers of samples come back as a raster of floats
//! ([`RowWriter`]). Nothing here knows of tiles or meshes.

mod about;
mod axes;
mod axis;
mod bounding_box;
mod cache;
mod companions;
mod crs;
mod cube;
mod cutline;
mod drape;
mod drivers;
mod encoding;
mod gdal_error;
mod gdal_messages;
mod gdal_name;
mod geodesy;
mod grid;
mod handles;
mod line_fields;
mod lines;
mod marks;
mod mask;
mod open;
mod picture;
mod plain;
mod points;
mod read;
mod reference;
mod remote;
mod sample_type;
mod shapes;
mod view;
mod watch;
mod write;
mod xyz;

pub use crate::base::RasterError;
pub use about::Libraries;
pub use bounding_box::BoundingBox;
pub use cache::{bound_gdal_cache, own_gdal_cache};
pub(crate) use crs::bring_into;
pub use cutline::{CutlineSource, read_cutline};
pub use drape::{DrapeError, drape};
pub(crate) use gdal_error::reason;
pub(crate) use gdal_messages::About;
pub use gdal_messages::{keep_gdal_warnings, quiet_gdal, take_gdal_warnings};
pub(crate) use gdal_name::GdalName;
pub use geodesy::{Geodesy, GeodesyError, Ways};
pub use line_fields::Said;
pub use lines::{LineAsk, LineMemory, LineSource, read_lines, read_outlines};
pub use open::{Opening, Raster};
pub use points::{PointSource, Points, PointsError, read_points};
pub(crate) use reference::metres_of;
pub use shapes::ShapesError;
pub use view::{Part, View, ViewError};
pub use watch::FileWatch;
pub use write::{Described, RowWriter, WriteError};
