//! Rasters as GDAL gives them: the one module that names GDAL for reading.
//!
//! In comes a path and a band number; out go sizes, types, georeferencing and windows of samples, either as they are
//! stored ([`Raster::read_native`]) or as heights ([`Raster::read_heights`], [`Raster::read_valid_heights`]); and the samples
//! nearest to the points of a vector layer ([`read_points`]), and those inside its polygons ([`read_cutline`]). Nothing here
//! knows of tiles or meshes.

mod axes;
mod axis;
mod bounding_box;
mod channels;
mod companions;
mod crs;
mod cube;
mod cutline;
mod drivers;
mod encoding;
mod error;
mod files;
mod gdal_error;
mod gdal_messages;
mod gdal_name;
mod grid;
mod identity;
mod look;
mod marks;
mod mask;
mod open;
mod picture;
mod plain;
mod points;
mod read;
mod reference;
mod sample_type;
mod validity;
mod view;
mod xyz;

pub use bounding_box::BoundingBox;
pub use channels::channels;
pub use cutline::{Cutline, CutlineError, CutlineSource, read_cutline};
pub use encoding::Encoding;
pub use error::RasterError;
pub use files::{Files, Watch};
pub(crate) use gdal_error::reason;
pub(crate) use gdal_messages::About;
pub use gdal_messages::{keep_gdal_warnings, quiet_gdal, take_gdal_warnings};
pub(crate) use gdal_name::GdalName;
pub use identity::{exact, exact_marks, identity};
pub use look::{Found, Look, LookError, NEAR_VOID, look};
pub use marks::{Mark, Marks, NEARNESS, NO_MARK, TAG, ValidRange};
pub use open::{Opening, Raster, bound_gdal_cache};
pub use plain::{PlainLayout, plain_layout};
pub use points::{PointCounts, PointSet, PointSource, Points, PointsError, read_points};
pub use reference::Reference;
pub(crate) use sample_type::with_sample_type;
pub use sample_type::{SampleType, Scaling};
pub use view::{Part, View, ViewError};
