//! A band of a raster that somebody else opens: what is told of it, and the band that comes of it by the rules of the house.

use std::path::PathBuf;
use std::sync::Arc;

use super::sample::zero_tag;
use super::{
    Band, Colours, CrsFacts, GeoTransform, Mark, Marks, Masks, RasterError, Reference, SampleType, Scaling, TAG,
    ValidRange, Window, Windows,
};

/// What a program says of a raster's band that it has opened by itself, in GDAL's terms. What is missing, what counts as
/// heights and what coordinates mean is decided here, as for a raster that this library opens.
#[derive(Debug, Clone)]
pub struct BandFacts {
    /// What messages call the raster.
    pub path: PathBuf,
    /// GDAL's name of the format; may be empty.
    pub driver: String,
    /// Samples across and down.
    pub size: (usize, usize),
    /// Which band it is, from 1.
    pub number: usize,
    /// The colour that each band of the raster is said to hold.
    pub colours: Vec<Option<&'static str>>,
    /// Whether its samples are numbers of colours in a table, other than a scale of greys.
    pub has_table: bool,
    /// Whether bands 1 to 3 hold bytes.
    pub bytes: bool,
    /// Samples across and down in a block.
    pub block: (usize, usize),
    /// The type of the stored samples.
    pub sample_type: SampleType,
    /// Scale and offset tags.
    pub scaling: Scaling,
    /// The nodata tag.
    pub tag: Option<Mark>,
    /// What says that samples are missing beside marks; its [`Windows::read_mask`] reads them.
    pub masks: Masks,
    /// GDAL's six coefficients; `None` where there is no geotransform.
    pub geo_transform: Option<[f64; 6]>,
    /// What else places the raster on the map, such as ground control points, in words.
    pub elsewhere: Option<String>,
    /// The CRS as WKT, or in any words where it is not known as such; empty where there is none.
    pub crs: String,
    /// The CRS in Esri's dialect of WKT.
    pub esri_wkt: Option<String>,
    /// The unit of heights, as the band says it; may be empty.
    pub unit: String,
    /// What the band is said to hold, in words; may be empty.
    pub description: String,
    /// What GDAL says that pixels are; may be empty.
    pub pixel_is: String,
}

/// How a band is to be looked at.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct BandView {
    /// Whether somebody has named the band, and so means it even if it holds a colour.
    pub is_named: bool,
    /// Words for marks of missing samples, see [`Marks::of_words`].
    pub nodata: Vec<String>,
    /// The heights that are valid, if not all are.
    pub valid_range: Option<ValidRange>,
    /// The part of the raster that is meant, if not all of it.
    pub part: Option<BandPart>,
}

/// Part of a raster.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BandPart {
    /// These samples.
    Window(Window),
    /// The samples in a box in the raster's own CRS: the least x and y, and the largest.
    Box([f64; 4]),
}

impl BandFacts {
    /// The band, whose stored values `windows` reads.
    ///
    /// # Errors
    /// [`RasterError`]: for what can be no heights or cannot be placed, a word that is no mark, a part that is none.
    pub fn band(self, view: &BandView, windows: Arc<dyn Windows>) -> Result<Band, RasterError> {
        let BandFacts { path, size: (width, height), sample_type, scaling, tag, .. } = self;
        if !scaling.is_usable() {
            return Err(RasterError::Scaling { path, scale: scaling.scale, offset: scaling.offset });
        }
        if !view.is_named {
            let colours = Colours { of_bands: &self.colours, has_table: self.has_table, bytes: self.bytes };
            colours.expect_heights(&path, self.number)?;
        }
        if let (None, Some(found)) = (self.geo_transform, self.elsewhere) {
            return Err(RasterError::NotAffine { path, found });
        }
        let place = |coefficients| {
            let placed = GeoTransform::new(coefficients, width, height);
            placed.map_err(|reason| RasterError::GeoTransform { path: path.clone(), coefficients, reason })
        };
        let geo_transform = self.geo_transform.map(place).transpose()?;
        let marks = Marks::of_words(&view.nodata, tag, sample_type).map_err(|found| {
            let (path, found, sample_type) = (path.clone(), found.to_string(), sample_type.name());
            RasterError::NodataValue { path, found, sample_type }
        })?;
        let counted = tag.filter(|_| view.nodata.is_empty() || view.nodata.iter().any(|word| word == TAG));
        let crs = CrsFacts::of_text(&self.crs);
        let colour = self.colours.get(self.number - 1).copied().flatten();
        let band = Band::new(path, (width, height), sample_type, windows)?;
        let band = Band {
            number: self.number,
            bands: self.colours.len(),
            block: self.block,
            scaling,
            marks: Marks { valid: view.valid_range, ..marks },
            marks_are_said: !view.nodata.is_empty() || view.valid_range.is_some(),
            nodata_words: view.nodata.clone(),
            tag,
            zero_tag: zero_tag(&self.driver, counted),
            has_mask: self.masks.are_some(),
            geo_transform,
            crs: crs.definition.clone(),
            title: if self.description.is_empty() { colour.unwrap_or_default() } else { &self.description }.to_string(),
            description: self.description,
            esri_wkt: self.esri_wkt,
            warnings: counted.and_then(|tag| tag.unreachable(sample_type, &band.path)).into_iter().collect(),
            colour: colour.filter(|colour| matches!(*colour, "red" | "green" | "blue" | "alpha")),
            ..band
        };
        let band = match view.part {
            None => band,
            Some(BandPart::Window(window)) => band.clip(window)?,
            Some(BandPart::Box(sides)) => {
                let window = band.window_of(sides, &crs.name)?;
                band.clip(window)?
            }
        };
        let [_, _, largest_x, _] = band.extent();
        let reference = Reference::of_crs(&crs, &self.unit, geo_transform.is_some(), largest_x, &self.pixel_is);
        Ok(Band { reference, ..band })
    }
}

/// Reads a part of what another reads.
struct Part {
    whole: Arc<dyn Windows>,
    first: (usize, usize),
}

impl Part {
    fn in_whole(&self, window: Window) -> Window {
        Window { column: self.first.0 + window.column, row: self.first.1 + window.row, ..window }
    }
}

impl Windows for Part {
    fn read(&self, window: Window, out: &mut [u8]) -> Result<(), RasterError> {
        self.whole.read(self.in_whole(window), out)
    }

    fn read_mask(&self, window: Window, out: &mut [u8]) -> Result<(), RasterError> {
        self.whole.read_mask(self.in_whole(window), out)
    }

    fn release(&self) {
        self.whole.release();
    }
}

impl Band {
    /// Part of the band: as large as the window, columns and rows counted from its first sample. Map coordinates of samples
    /// stay what they were, bit for bit.
    ///
    /// # Errors
    /// [`RasterError::Window`] if it reaches out of the band or has less than 2 samples across or down.
    pub fn clip(self, window: Window) -> Result<Band, RasterError> {
        let (width, height) = self.size;
        if !window.is_usable_in(self.size) {
            return Err(RasterError::Window { path: self.path, window, width, height });
        }
        let Window { column, row, .. } = window;
        if (window.width, window.height) == self.size {
            return Ok(self);
        }
        let first = (self.first.0 + column, self.first.1 + row);
        let window = Window { column: first.0, row: first.1, ..window };
        let mut view = self.view;
        view.retain(|(what, _)| *what != "window");
        // A window that happens to have the samples of another is not the same place.
        view.push(("window", window.to_string()));
        Ok(Band {
            size: (window.width, window.height),
            geo_transform: self.geo_transform.map(|transform| transform.of_window(column, row)),
            cutline: self.cutline.map(|cutline| Arc::new(cutline.of_window(column, row))),
            first,
            window: Some(window),
            view,
            windows: Arc::new(Part { whole: self.windows, first: (column, row) }),
            ..self
        })
    }

    /// The samples inside a box in the CRS of the band.
    fn window_of(&self, [left, bottom, right, top]: [f64; 4], crs: &str) -> Result<Window, RasterError> {
        let corners = [(left, bottom), (left, top), (right, bottom), (right, top)];
        let places = corners.map(|(x, y)| self.geo_transform().sample_coordinates(x, y));
        Window::between(&places, self.size).map_err(|(columns, rows)| {
            let (path, extent, crs) = (self.path.clone(), self.extent(), crs.to_string());
            RasterError::EmptyBox { path, columns, rows, extent, crs }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of bytes that count rows and columns.
    struct Counting;

    impl Windows for Counting {
        fn read(&self, window: Window, out: &mut [u8]) -> Result<(), RasterError> {
            for (i, value) in out.iter_mut().enumerate() {
                *value = (10 * (window.row + i / window.width) + window.column + i % window.width) as u8;
            }
            Ok(())
        }
    }

    fn facts() -> BandFacts {
        BandFacts {
            path: "counted".into(),
            driver: "Zarr".to_string(),
            size: (9, 8),
            number: 1,
            colours: vec![None, Some("alpha")],
            has_table: false,
            bytes: false,
            block: (9, 1),
            sample_type: SampleType::U8,
            scaling: Scaling::NONE,
            tag: Some(Mark::Real(0.0)),
            masks: Masks { file: false, alpha: Some(2) },
            geo_transform: Some([100.0, 10.0, 0.0, 200.0, 0.0, -10.0]),
            elsewhere: None,
            crs: "EPSG:32633".to_string(),
            esri_wkt: None,
            unit: "m".to_string(),
            description: String::new(),
            pixel_is: "Area".to_string(),
        }
    }

    fn band(facts: BandFacts, view: BandView) -> Result<Band, RasterError> {
        facts.band(&view, Arc::new(Counting))
    }

    #[test]
    fn a_box_is_a_window_with_the_places_of_the_whole() {
        let part = Some(BandPart::Box([121.0, 144.0, 155.0, 176.0]));
        let band = band(facts(), BandView { part, ..BandView::default() }).expect("a band");
        let window = Window { column: 2, row: 2, width: 4, height: 4 };
        assert_eq!((band.window, band.size), (Some(window), (4, 4)));
        assert_eq!(band.geo_transform().apply(0, 0), (125.0, 175.0));
        let mut first = [0; 2];
        band.read(Window { column: 1, row: 1, width: 2, height: 1 }, &mut first).expect("samples");
        assert_eq!(first, [33, 34]);
        assert!(band.has_mask() && band.reference().georeferenced && band.zero_tag.is_some());
    }

    #[test]
    fn words_of_the_user_count_in_place_of_the_tag() {
        let view =
            |words: &[&str]| BandView { nodata: words.iter().map(|w| w.to_string()).collect(), ..BandView::default() };
        let marks = |words: &[&str]| band(facts(), view(words)).map(|band| (band.marks().values.len(), band.zero_tag));
        assert!(matches!(marks(&[]), Ok((1, Some(_)))));
        assert!(matches!(marks(&["none"]), Ok((0, None))));
        assert!(matches!(marks(&["7", "tag"]), Ok((2, Some(_)))));
        assert!(matches!(marks(&["300"]), Err(RasterError::NodataValue { .. })));
    }

    #[test]
    fn what_can_be_no_heights_is_refused() {
        let of = |facts, view: BandView| band(facts, view).map(|_| ());
        let view = BandView::default;
        assert!(matches!(of(BandFacts { has_table: true, ..facts() }, view()), Err(RasterError::Picture { .. })));
        assert!(of(BandFacts { has_table: true, ..facts() }, BandView { is_named: true, ..view() }).is_ok());
        let unscaled = Scaling { scale: 0.0, offset: 0.0 };
        assert!(matches!(of(BandFacts { scaling: unscaled, ..facts() }, view()), Err(RasterError::Scaling { .. })));
        let elsewhere = BandFacts { geo_transform: None, elsewhere: Some("4 points".to_string()), ..facts() };
        assert!(matches!(of(elsewhere, view()), Err(RasterError::NotAffine { .. })));
        let window = Window { column: 8, row: 0, width: 2, height: 2 };
        let part = Some(BandPart::Window(window));
        assert!(matches!(of(facts(), BandView { part, ..view() }), Err(RasterError::Window { .. })));
    }
}
