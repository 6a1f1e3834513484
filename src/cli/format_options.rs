//! `--format` of meshes, and the options that some formats have.

use clap::ValueEnum;

use super::values;
use crate::formats::{Base, Compression, OgrGeometry, SinkOptions};

/// How the mesh is written.
#[derive(Debug, Clone, Default, clap::Args)]
#[command(next_help_heading = "Format")]
pub(super) struct FormatArgs {
    /// The format of the mesh, whatever OUTPUT is called [default: what its extension says]. OGR:DRIVER is a vector format of
    /// GDAL's, such as OGR:GPKG
    #[arg(long, hide_short_help = true, value_name = "FORMAT", value_parser = values::mesh_format)]
    pub(super) format: Option<MeshFormat>,
    /// PLY as text
    #[arg(long, hide_short_help = true)]
    ascii: bool,
    /// STL: a solid with walls and a floor at this height, in the units of the heights
    #[arg(long, hide_short_help = true, value_name = "Z", conflicts_with = "base_depth", value_parser = values::number, allow_hyphen_values = true)]
    base_height: Option<f64>,
    /// STL: a solid with walls and a floor this far below the lowest vertex, in the units of the heights
    #[arg(long, hide_short_help = true, value_name = "D", value_parser = values::factor, allow_hyphen_values = true)]
    base_depth: Option<f64>,
    /// GLB: compressed without loss by meshoptimizer (EXT_meshopt_compression), for viewers that know it
    #[arg(long, hide_short_help = true, value_enum)]
    mesh_compression: Option<CompressionArg>,
    /// OGR: a polygon for each triangle, or TINs
    #[arg(long, hide_short_help = true, value_enum)]
    ogr_geometry: Option<OgrGeometryArg>,
}

/// A format of meshes, as `--format` names it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct MeshFormat {
    /// Its row in the table.
    pub(super) name: &'static str,
    /// The format of GDAL's, of OGR.
    pub(super) driver: Option<&'static str>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum CompressionArg {
    Meshopt,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum OgrGeometryArg {
    /// POLYGON Z, a feature for each triangle: every program reads it
    Polygon,
    /// TIN Z
    Tin,
}

impl FormatArgs {
    /// What `--format` names.
    pub(super) fn name(&self) -> Option<&'static str> {
        self.format.map(|format| format.name)
    }

    /// The options of the format.
    pub(super) fn sink(&self) -> SinkOptions {
        let height = self.base_height.map(Base::Height);
        SinkOptions {
            ascii: self.ascii,
            base: height.or(self.base_depth.map(Base::Depth)),
            compression: self.mesh_compression.map(|CompressionArg::Meshopt| Compression::Meshopt),
            ogr_driver: self.format.and_then(|format| format.driver),
            ogr_geometry: self.ogr_geometry.map(|geometry| match geometry {
                OgrGeometryArg::Polygon => OgrGeometry::Polygon,
                OgrGeometryArg::Tin => OgrGeometry::Tin,
            }),
        }
    }
}
