//! Rasters whose first band is a colour: pictures, which are easily taken for heights.

use gdal::raster::ColorInterpretation as Colour;

use super::{Raster, RasterError};
use crate::base::{Colours, SampleType, is_scale_of_greys};

impl Raster {
    /// Makes sure that the band is no colour and no index of a table of colours.
    ///
    /// # Errors
    /// [`RasterError::Picture`] says what it is, and which bands might hold heights.
    pub fn expect_heights(&self) -> Result<(), RasterError> {
        if self.encoding().is_some() {
            return Ok(());
        }
        self.with_colours(|colours| colours.expect_heights(self.path(), self.band()))
    }

    /// Makes sure that the band's samples are no indices of a table of colours: those are no numbers of a channel either.
    ///
    /// # Errors
    /// [`RasterError::Picture`].
    pub fn expect_no_table(&self) -> Result<(), RasterError> {
        self.with_colours(|colours| colours.expect_no_table(self.path(), self.band()))
    }

    fn with_colours(&self, judge: impl FnOnce(Colours<'_>) -> Result<(), RasterError>) -> Result<(), RasterError> {
        let of_bands: Vec<_> = (1..=self.band_count()).map(|number| self.colour_of(number)).collect();
        let bytes = |n: usize| {
            let band = self.dataset.rasterband(n).ok();
            band.and_then(|b| super::open::sample_type(&b)) == Some(SampleType::U8)
        };
        judge(Colours { of_bands: &of_bands, has_table: self.has_colour_table(), bytes: (1..=3).all(bytes) })
    }

    /// The colour that a band is said to hold; `None` where it is none.
    pub(super) fn colour_of(&self, band: usize) -> Option<&'static str> {
        match self.dataset.rasterband(band).ok()?.color_interpretation() {
            Colour::RedBand => Some("red"),
            Colour::GreenBand => Some("green"),
            Colour::BlueBand => Some("blue"),
            Colour::AlphaBand => Some("alpha"),
            Colour::HueBand => Some("hue"),
            Colour::SaturationBand => Some("saturation"),
            Colour::LightnessBand => Some("lightness"),
            Colour::CyanBand => Some("cyan"),
            Colour::MagentaBand => Some("magenta"),
            Colour::YellowBand => Some("yellow"),
            Colour::BlackBand => Some("black"),
            Colour::YCbCrSpaceYBand => Some("luminance"),
            Colour::YCbCrSpaceCbBand | Colour::YCbCrSpaceCrBand => Some("chrominance"),
            _ => None,
        }
    }

    /// The colour that the band is said to hold: red, green, blue or alpha.
    pub fn colour(&self) -> Option<&'static str> {
        self.colour_of(self.band()).filter(|c| matches!(*c, "red" | "green" | "blue" | "alpha"))
    }

    /// Whether samples are numbers of entries in a table of colours, and so no heights ([`is_scale_of_greys`] is none).
    pub fn has_colour_table(&self) -> bool {
        let Ok(band) = self.rasterband() else { return false };
        let Some(table) = band.color_table() else { return false };
        let entries = (0..table.entry_count()).filter_map(|i| table.entry_as_rgb(i));
        !is_scale_of_greys(&entries.map(|e| [e.r, e.g, e.b]).collect::<Vec<_>>())
    }
}
