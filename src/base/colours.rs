//! Bands that hold colours: pictures, which are easily taken for heights.

use std::path::Path;

use super::RasterError;

/// What is known of all bands of a raster where it is to be found out whether one of them can hold heights.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Colours<'a> {
    /// The colour that each band is said to hold, in their order; `None` where it is none.
    pub of_bands: &'a [Option<&'static str>],
    /// Whether the band's samples are numbers of entries in a table of colours, other than a scale of greys.
    pub has_table: bool,
    /// Whether bands 1 to 3 hold bytes.
    pub bytes: bool,
}

impl Colours<'_> {
    /// Makes sure that a band, from 1, is no colour and no index of a table of colours.
    ///
    /// # Errors
    /// [`RasterError::Picture`] says what it is, and which bands might hold heights.
    pub fn expect_heights(&self, path: &Path, band: usize) -> Result<(), RasterError> {
        match self.of_bands.get(band - 1).copied().flatten() {
            Some(colour) => Err(self.picture(path, band, colour)),
            None => self.expect_no_table(path, band),
        }
    }

    /// Makes sure that the band's samples are no indices of a table of colours: those are no numbers of a channel either.
    ///
    /// # Errors
    /// [`RasterError::Picture`].
    pub fn expect_no_table(&self, path: &Path, band: usize) -> Result<(), RasterError> {
        if self.has_table { Err(self.picture(path, band, "the numbers of colours in a table")) } else { Ok(()) }
    }

    fn picture(&self, path: &Path, band: usize, found: &str) -> RasterError {
        let other = (1..).zip(self.of_bands).find(|&(number, colour)| number != band && colour.is_none());
        RasterError::Picture {
            path: path.to_path_buf(),
            band,
            found: found.to_string(),
            other: other.map(|(number, _)| number),
            encoded: self.of_bands.len() >= 3 && self.bytes,
        }
    }
}

/// The bands that have red, green and blue, from 1: the first that are said to have them, or bands 1 to 3 where one of the three
/// is not there. `colour_of` says what a band of `bands` is said to hold.
pub fn bands_of_colours(bands: usize, colour_of: impl Fn(usize) -> Option<&'static str>) -> [usize; 3] {
    let coloured = |name: &str| (1..=bands).find(|number| colour_of(*number) == Some(name));
    match [coloured("red"), coloured("green"), coloured("blue")] {
        [Some(red), Some(green), Some(blue)] => [red, green, blue],
        _ => [1, 2, 3],
    }
}

/// Whether a table of colours is one of greys, from dark to bright: with that, some formats say that samples are a measure of
/// something.
pub fn is_scale_of_greys(entries: &[[i16; 3]]) -> bool {
    let grey = entries.iter().all(|[red, green, blue]| red == green && green == blue);
    grey && entries.windows(2).all(|pair| pair[0][0] < pair[1][0])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_in_any_order() {
        let said = [Some("alpha"), Some("blue"), Some("green"), Some("red"), Some("red")];
        assert_eq!(bands_of_colours(5, |number| said[number - 1]), [4, 3, 2]);
        assert_eq!(bands_of_colours(3, |number| said[number - 1]), [1, 2, 3]);
    }

    #[test]
    fn a_scale_of_greys_rises() {
        assert!(is_scale_of_greys(&[[0; 3], [1; 3], [255; 3]]) && is_scale_of_greys(&[]));
        assert!(!is_scale_of_greys(&[[1; 3], [0; 3]]) && !is_scale_of_greys(&[[0, 0, 1]]));
    }

    #[test]
    fn a_colour_is_refused_and_the_first_other_band_named() {
        let bands = [Some("red"), Some("green"), None, None];
        let colours = |has_table| Colours { of_bands: &bands, has_table, bytes: true };
        let refused = |found: Result<(), RasterError>| match found {
            Err(RasterError::Picture { other, encoded, .. }) => (other, encoded),
            other => panic!("{other:?}"),
        };
        assert_eq!(refused(colours(false).expect_heights(Path::new("a"), 1)), (Some(3), true));
        assert!(colours(false).expect_heights(Path::new("a"), 3).is_ok());
        assert_eq!(refused(colours(true).expect_heights(Path::new("a"), 3)), (Some(4), true));
    }
}
