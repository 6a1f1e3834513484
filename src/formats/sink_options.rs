//! Options of writing that some formats have.

use std::fmt;

/// What some formats can be asked for. [`super::Format::options`] says which takes which; all else is refused.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SinkOptions {
    /// Text where binary is usual.
    pub ascii: bool,
    /// A solid: walls along the rim, and a floor.
    pub base: Option<Base>,
    /// How meshes are compressed.
    pub compression: Option<Compression>,
    /// The format of GDAL that OGR is to write, by its short name; `None` goes by the extension.
    pub ogr_driver: Option<&'static str>,
    /// How OGR has a triangle.
    pub ogr_geometry: Option<OgrGeometry>,
}

/// Where the floor of a solid is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Base {
    /// At this height.
    Height(f64),
    /// So far below the lowest vertex; above 0.
    Depth(f64),
}

/// How a mesh is compressed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Compression {
    /// By meshoptimizer's codecs (`EXT_meshopt_compression`), without loss.
    Meshopt,
    /// The same in less time, in a few more bytes.
    QuickMeshopt,
}

/// How OGR has a triangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OgrGeometry {
    /// A polygon with heights, a feature for each triangle.
    Polygon,
    /// A TIN with heights.
    Tin,
}

/// One of [`SinkOptions`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum SinkOption {
    Ascii,
    Base,
    Compression,
    OgrDriver,
    OgrGeometry,
    Normals,
    Texture,
}

impl SinkOptions {
    /// Those that are asked for.
    pub fn asked(&self) -> impl Iterator<Item = SinkOption> + use<> {
        let all = [
            (SinkOption::Ascii, self.ascii),
            (SinkOption::Base, self.base.is_some()),
            (SinkOption::Compression, self.compression.is_some()),
            (SinkOption::OgrDriver, self.ogr_driver.is_some()),
            (SinkOption::OgrGeometry, self.ogr_geometry.is_some()),
        ];
        all.into_iter().filter(|(_, is_asked)| *is_asked).map(|(option, _)| option)
    }
}

impl fmt::Display for SinkOption {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            SinkOption::Ascii => "text instead of binary",
            SinkOption::Base => "a floor with walls",
            SinkOption::Compression => "compression",
            SinkOption::OgrDriver => "a format of GDAL",
            SinkOption::OgrGeometry => "a kind of geometry",
            SinkOption::Normals => "normals",
            SinkOption::Texture => "an image over the mesh",
        })
    }
}
