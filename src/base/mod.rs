//! The vocabulary of everything above: tiles of samples, places, meshes, exact arithmetic, control, warnings, files that
//! are written whole. Nothing here imports another folder of the house.

mod band;
mod band_facts;
pub mod channels;
mod colours;
pub mod control;
mod coordinate_frame;
mod cutline;
pub mod decimal;
pub mod durable;
pub mod exact;
pub mod external;
pub mod faults;
pub mod features;
mod files;
mod georef;
pub(crate) mod handed_over;
mod identity;
pub mod lattice;
mod line_type;
mod memory;
pub mod mesh;
mod naming;
pub(crate) mod plainly;
mod points;
mod polylines;
pub mod private_file;
mod raster_error;
mod raster_rim;
mod sample;
mod sample_cut;
pub mod staged;
mod texture;
mod tile;
pub mod tiling;
pub mod tolerance;
mod validity;
pub mod warning;
mod window;

pub use band::{Band, PlainLayout, Windows};
pub use band_facts::{BandFacts, BandPart, BandView};
pub use colours::{Colours, bands_of_colours, is_scale_of_greys};
pub use coordinate_frame::CoordinateFrame;
pub use cutline::{Cutline, Polygon};
pub use files::{FileState, Files, Watch};
pub use georef::{CrsFacts, GeoTransform, Metres, Reference, metres_in};
pub use identity::{SOME_SAMPLES, exact_double, identity, said, without_bits};
pub use line_type::{LineEdge, LineType};
pub use naming::channels_of;
#[cfg(feature = "gdal")]
pub(crate) use points::key;
pub use points::{PointCounts, PointSet};
#[cfg(feature = "gdal")]
pub(crate) use polylines::LineWriter;
pub use polylines::{LineKind, LineSet, Polylines};
pub use raster_error::RasterError;
#[cfg(feature = "gdal")]
pub(crate) use raster_error::SILENT;
pub use raster_rim::RasterRim;
#[cfg(feature = "gdal")]
pub(crate) use sample::zero_tag;
pub use sample::{
    Encoding, Mark, Marks, MaskFlags, Masks, NEARNESS, NO_MARK, SampleType, Scaling, TAG, ValidRange, mask_by_alpha,
};
pub(crate) use sample::{stored, with_sample_type};
pub use sample_cut::SampleCut;
pub use texture::Texture;
pub use tile::{EasedSample, Heights, Tile};
pub(crate) use tile::{PADDING, padded};
pub use tolerance::Tolerance;
pub use validity::{Cell, NEAR_VOID, Validity};
pub use window::Window;
