//! What coordinates and heights mean.

use super::Metres;

/// What a raster's coordinates and heights mean, as far as it says.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Reference {
    /// The CRS in one line; "none" where there is none.
    pub crs: String,
    /// Whether there is a geotransform; without one coordinates count pixels.
    pub georeferenced: bool,
    /// Whether x and y are longitude and latitude.
    pub geographic: bool,
    /// Whether longitudes go beyond 180° (0 to 360, most often). They are kept as they are.
    pub longitudes_beyond_180: bool,
    /// The unit of x and y; empty where it is not said.
    pub unit: String,
    /// How long it is; `None` where that is not known. Not part of reports.
    #[serde(skip)]
    pub metres: Option<Metres>,
    /// The vertical CRS; empty where there is none.
    pub vertical_crs: String,
    /// The unit of heights, as the band or else the vertical CRS says; empty where neither does.
    pub height_unit: String,
    /// What GDAL says that pixels are: "Area" or "Point"; empty where it is not said. In either case samples stand at the
    /// centres of pixels: for the latter GDAL moves the geotransform by half a pixel.
    pub pixel_is: String,
}

impl Reference {
    /// Coordinates that count pixels, and mean nothing.
    pub fn none() -> Reference {
        Reference {
            crs: "none".to_string(),
            georeferenced: false,
            geographic: false,
            longitudes_beyond_180: false,
            unit: String::new(),
            metres: None,
            vertical_crs: String::new(),
            height_unit: String::new(),
            pixel_is: String::new(),
        }
    }
}
