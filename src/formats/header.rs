//! What a mesh file says of itself beside its vertices and triangles, as data: each format words it for itself.

use super::Contents;
use crate::base::{CoordinateFrame, Metres, Window};

/// What a mesh was made from, where it lies on the map, how its coordinates are written, and what was asked for.
///
/// A writer says of it what its format has words for; a reader gives back what it finds, and leaves the rest empty. Nothing
/// in it depends on the machine or the time. Texts are one line each: writers put a blank in the place of line breaks.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Header {
    /// The program and its version, such as `terrabite 0.1.0`.
    pub made_by: Option<String>,
    /// The raster's file name, without its folders.
    pub source: Option<String>,
    /// The CRS of map coordinates.
    pub crs: Crs,
    /// What heights mean.
    pub heights: Heights,
    /// How map coordinates and heights stand in the file.
    pub frame: CoordinateFrame,
    /// The part of the raster that was simplified, where it is not the whole.
    pub window: Option<Window>,
    /// The tolerance that was asked for, or that was found for a goal, in the unit of the heights; `None` where there is none, but
    /// a budget that insertion stopped at for instance. (Insertion that a budget stops before a tolerance that is asked for does not
    /// keep it.)
    pub tolerance: Option<f64>,
    /// What else was asked for and decides the mesh, in a fixed order.
    pub options: Vec<RunOption>,
    /// Further lines.
    pub notes: Vec<String>,
}

impl Header {
    /// Adds what is known only when the mesh is there.
    pub(super) fn complete(&mut self, contents: &Contents<'_>) {
        self.tolerance = contents.tolerance.or(self.tolerance);
    }
}

/// A coordinate reference system, as far as it is known.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Crs {
    /// Its authority's code (`EPSG:32633`), else WKT; `None` where there is no CRS.
    pub definition: Option<String>,
    /// Its name in one line; "none" where the raster has no CRS.
    pub name: Option<String>,
    /// It in Esri's dialect of WKT, for files beside a mesh. No header of a mesh has it.
    pub esri_wkt: Option<String>,
    /// The unit of x and y, such as `metre`. No format of today has it.
    pub unit: Option<String>,
    /// How long the unit of x and y is, for formats in metres. No header of a mesh has it.
    pub metres: Option<Metres>,
}

/// What heights mean, as far as it is known.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Heights {
    /// The vertical CRS.
    pub crs: Option<String>,
    /// The unit, as the raster says it.
    pub unit: Option<String>,
}

/// An option of the run with its value in words.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RunOption {
    /// Which one.
    pub name: OptionName,
    /// Its value; numbers as the shortest decimals.
    pub value: String,
}

/// The options that decide a mesh; [`OptionName::words`] are their names in files, which do not change.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[allow(missing_docs)]
pub enum OptionName {
    MaxRms,
    MaxPoints,
    MaxTriangles,
    Encoding,
    OpenOption,
    Nodata,
    ValidRange,
    FillHoles,
    Cutline,
    CutlineLayer,
    CutlineExact,
    CutlineExactLayer,
    Trim,
    Importance,
    Points,
    Breaklines,
    BreaklinesLayer,
    LakePolygons,
    LakePolygonsLayer,
    LakeZ,
    Footprints,
    FootprintsLayer,
    BreaklineShift,
    BreaklineZ,
    Attributes,
}

impl OptionName {
    /// All of them. One whose words begin another's comes after it, so that the first that fits a line is the right one.
    pub const ALL: [OptionName; 25] = [
        OptionName::MaxRms,
        OptionName::MaxPoints,
        OptionName::MaxTriangles,
        OptionName::Encoding,
        OptionName::OpenOption,
        OptionName::Nodata,
        OptionName::ValidRange,
        OptionName::FillHoles,
        OptionName::CutlineExactLayer,
        OptionName::CutlineExact,
        OptionName::CutlineLayer,
        OptionName::Cutline,
        OptionName::Trim,
        OptionName::Importance,
        OptionName::Points,
        OptionName::BreaklinesLayer,
        OptionName::Breaklines,
        OptionName::LakePolygonsLayer,
        OptionName::LakePolygons,
        OptionName::LakeZ,
        OptionName::FootprintsLayer,
        OptionName::Footprints,
        OptionName::BreaklineShift,
        OptionName::BreaklineZ,
        OptionName::Attributes,
    ];

    /// Its name in files.
    pub const fn words(self) -> &'static str {
        match self {
            OptionName::MaxRms => "max_rms",
            OptionName::MaxPoints => "max_points",
            OptionName::MaxTriangles => "max_triangles",
            OptionName::Encoding => "encoding",
            OptionName::OpenOption => "open option",
            OptionName::Nodata => "nodata",
            OptionName::ValidRange => "valid range",
            OptionName::FillHoles => "fill holes",
            OptionName::Cutline => "cutline",
            OptionName::CutlineLayer => "cutline layer",
            OptionName::CutlineExact => "cutline exact",
            OptionName::CutlineExactLayer => "cutline exact layer",
            OptionName::Trim => "trim",
            OptionName::Importance => "importance",
            OptionName::Points => "points",
            OptionName::Breaklines => "breaklines",
            OptionName::BreaklinesLayer => "breaklines layer",
            OptionName::LakePolygons => "lake polygons",
            OptionName::LakePolygonsLayer => "lake polygons layer",
            OptionName::LakeZ => "lake z",
            OptionName::Footprints => "footprints",
            OptionName::FootprintsLayer => "footprints layer",
            OptionName::BreaklineShift => "breakline shift",
            OptionName::BreaklineZ => "breakline z",
            OptionName::Attributes => "channels",
        }
    }
}

impl RunOption {
    /// An option with its value.
    pub fn new(name: OptionName, value: impl ToString) -> RunOption {
        RunOption { name, value: value.to_string() }
    }
}
