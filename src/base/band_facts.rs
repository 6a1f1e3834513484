//! A band of a raster that somebody else opens: what is told of it, and the band that comes of it by the rules of the house.

use std::path::PathBuf;
use std::sync::Arc;

use super::sample::zero_tag;
use super::{
    Band, Colours, CrsFacts, Cutline, Encoding, GeoTransform, Mark, Marks, Masks, Polygon, RasterError, Reference,
    SampleType, Scaling, TAG, ValidRange, Window, Windows, bands_of_colours,
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
    /// Which bands of the raster hold bytes.
    pub bytes: Vec<bool>,
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
    /// How heights are stored as colours, if they are: [`Windows::read`] then gives heights as doubles, of the bands that
    /// [`BandFacts::encoded_bands`] names.
    pub encoding: Option<Encoding>,
    /// Words for marks of missing samples, see [`Marks::of_words`].
    pub nodata: Vec<String>,
    /// The heights that are valid, if not all are.
    pub valid_range: Option<ValidRange>,
    /// The part of the raster that is meant, if not all of it.
    pub part: Option<BandPart>,
    /// Polygons outside of which samples have no height, as rings of places on the raster's own map.
    pub cutline: Vec<Vec<Vec<(f64, f64)>>>,
}

/// Part of a raster.
#[derive(Debug, Clone, PartialEq)]
pub enum BandPart {
    /// These samples.
    Window(Window),
    /// The smallest window that holds all samples between these places, x and y in the raster's own CRS: the corners of a
    /// box, or places of one whose sides are bent there.
    Between(Vec<(f64, f64)>),
}

impl BandFacts {
    /// The bands that have red, green and blue, from 1, where they stand for heights.
    ///
    /// # Errors
    /// [`RasterError::NotEncoded`] if there are no three bands of bytes.
    pub fn encoded_bands(&self, encoding: Encoding) -> Result<[usize; 3], RasterError> {
        let bands = bands_of_colours(self.colours.len(), |number| self.colours[number - 1]);
        if bands.iter().all(|number| self.bytes.get(number - 1) == Some(&true)) {
            return Ok(bands);
        }
        let (path, encoding, name) = (self.path.clone(), encoding.name(), self.sample_type.name());
        let found = match self.colours.len() {
            1 => format!("one band of {name}"),
            count => format!("{count} bands, band {} of {name}", self.number),
        };
        Err(RasterError::NotEncoded { path, encoding, found })
    }

    /// Makes sure that the band's samples are no indices of a table of colours, as those of an image must not be.
    ///
    /// # Errors
    /// [`RasterError::Picture`].
    pub fn expect_no_table(&self) -> Result<(), RasterError> {
        self.colours().expect_no_table(&self.path, self.number)
    }

    fn colours(&self) -> Colours<'_> {
        let bytes = self.bytes.len() >= 3 && self.bytes[..3].iter().all(|bytes| *bytes);
        Colours { of_bands: &self.colours, has_table: self.has_table, bytes }
    }

    /// The same with heights that stand for colours: no nodata tag, scale or offset applies.
    fn encoded(self, encoding: Encoding) -> Result<BandFacts, RasterError> {
        let [red, ..] = self.encoded_bands(encoding)?;
        Ok(BandFacts { number: red, sample_type: SampleType::F64, scaling: Scaling::NONE, tag: None, ..self })
    }

    /// The band, whose stored values `windows` reads.
    ///
    /// # Errors
    /// [`RasterError`]: for what can be no heights or cannot be placed, a word that is no mark, a part that is none.
    pub fn band(self, view: &BandView, windows: Arc<dyn Windows>) -> Result<Band, RasterError> {
        let facts = match view.encoding {
            Some(encoding) => self.encoded(encoding)?,
            None => self,
        };
        let band = facts.placed(view, windows)?;
        band.with_polygons(&view.cutline)
    }

    /// The band without its cutline.
    fn placed(self, view: &BandView, windows: Arc<dyn Windows>) -> Result<Band, RasterError> {
        let Scaling { scale, offset } = self.scaling;
        if !self.scaling.is_usable() {
            return Err(RasterError::Scaling { path: self.path, scale, offset });
        }
        if !view.is_named && view.encoding.is_none() {
            self.colours().expect_heights(&self.path, self.number)?;
        }
        let BandFacts { path, size: (width, height), sample_type, scaling, tag, .. } = self;
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
            encoding: view.encoding,
            view: view.encoding.iter().map(|encoding| ("encoding", encoding.name().to_string())).collect(),
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
        let band = match &view.part {
            None => band,
            Some(BandPart::Window(window)) => band.clip(*window)?,
            Some(BandPart::Between(places)) => {
                let window = band.window_between(places, &crs.name)?;
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

    /// The same, in which samples outside of these polygons have no height; none is left out where there is no polygon.
    fn with_polygons(self, polygons: &[Vec<Vec<(f64, f64)>>]) -> Result<Band, RasterError> {
        if polygons.is_empty() {
            return Ok(self);
        }
        let transform = self.geo_transform();
        let place = |&(x, y): &(f64, f64)| {
            let (column, row) = transform.sample_coordinates(x, y);
            let found = (column.is_finite() && row.is_finite()).then_some((column, row));
            found.ok_or_else(|| RasterError::CutlinePlace { path: self.path.clone(), x, y })
        };
        let mut placed = Vec::with_capacity(polygons.len());
        for rings in polygons {
            let mut polygon = Polygon::default();
            for ring in rings {
                polygon.add_ring(&ring.iter().map(place).collect::<Result<Vec<_>, _>>()?);
            }
            placed.push(polygon);
        }
        Ok(self.with_cutline(Cutline::new(placed)))
    }

    /// The samples between places in the CRS of the band.
    fn window_between(&self, places: &[(f64, f64)], crs: &str) -> Result<Window, RasterError> {
        let places: Vec<_> = places.iter().map(|&(x, y)| self.geo_transform().sample_coordinates(x, y)).collect();
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
            bytes: vec![true, true],
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
        let part = Some(BandPart::Between(vec![(121.0, 144.0), (155.0, 176.0)]));
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
    fn samples_outside_of_polygons_have_no_height() {
        let ring = vec![(100.0, 200.0), (130.0, 200.0), (130.0, 170.0), (100.0, 170.0)];
        let of = |ring: Vec<(f64, f64)>| band(facts(), BandView { cutline: vec![vec![ring]], ..BandView::default() });
        let cut = of(ring.clone()).expect("a band");
        let mut mask = Vec::new();
        cut.cutline().expect("a cutline").mask(Window { column: 0, row: 0, width: 9, height: 8 }, &mut mask);
        assert_eq!(mask.iter().filter(|inside| **inside).count(), 9);
        assert!(matches!(of(vec![(f64::NAN, 0.0)]), Err(RasterError::CutlinePlace { .. })));
    }

    #[test]
    fn colours_that_stand_for_heights() {
        let colours = vec![Some("blue"), Some("green"), Some("red"), Some("alpha")];
        let picture = |bytes| BandFacts {
            colours: colours.clone(),
            bytes,
            scaling: Scaling { scale: 2.0, offset: 1.0 },
            ..facts()
        };
        let view = || BandView { encoding: Some(Encoding::Terrarium), ..BandView::default() };
        let found = band(picture(vec![true; 4]), view()).expect("a band");
        assert_eq!((found.number(), found.sample_type(), found.scaling()), (3, SampleType::F64, Scaling::NONE));
        assert!(found.tag().is_none() && found.marks().is_empty() && found.encoding.is_some());
        assert_eq!(picture(vec![true; 4]).encoded_bands(Encoding::Terrarium).ok(), Some([3, 2, 1]));
        let refused = band(picture(vec![true, true, false, true]), view());
        assert!(matches!(refused, Err(RasterError::NotEncoded { .. })));
        assert!(matches!(band(facts(), view()), Err(RasterError::NotEncoded { .. })));
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
