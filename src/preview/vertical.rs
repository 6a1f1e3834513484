//! The vertical scale of shading: true proportions, and an exaggeration that is given or chosen from the raster's slopes.

use super::PreviewError;
use super::view::View;
use crate::base::control::Control;
use crate::base::{Band, Metres, Window};
use crate::verify::HeightReader;

/// The vertical scale that a raster was shaded with.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct VerticalScale {
    /// What heights were multiplied by, beyond true proportions.
    pub factor: f64,
    /// Whether the factor was chosen from the raster's slopes. Otherwise the options gave it.
    pub chosen: bool,
    /// Whether the raster says how long a unit of x and y is. Otherwise it was taken for a unit of heights.
    pub to_scale: bool,
    /// How long a degree was taken to be, where x and y are longitude and latitude.
    pub degree: Option<Degree>,
}

/// How long a degree is.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Degree {
    /// The latitude, in degrees: that of the middle of the raster.
    pub latitude: f64,
    /// Metres in a degree of longitude.
    pub of_longitude: f64,
    /// Metres in a degree of latitude.
    pub of_latitude: f64,
}

/// The share of slopes that the chosen factor makes no steeper than [`STEEP`].
const MOST: f64 = 0.95;
/// 35°, as in mountains. The light is 45° high, so ground that falls away from it at 45° is black.
const STEEP: f64 = 0.7;

impl VerticalScale {
    /// The scale of a raster: with the factor, if one is given. Otherwise with the one that makes 19 of 20 slopes no steeper
    /// than 35°, to two digits; where proportions are known, with 1 at least, so that steep ground is shown as it is.
    ///
    /// Slopes are those over a pixel of the picture. See [`steepness`] for what is read.
    pub(super) fn of(
        band: &Band,
        factor: Option<f64>,
        view: &View,
        control: &Control,
    ) -> Result<VerticalScale, PreviewError> {
        let metres = band.reference().metres;
        let to_scale = metres.is_some();
        let chosen = factor.is_none();
        let factor = match factor {
            Some(given) => given,
            None => match steepness(band, view.cells_per_pixel(), MOST, control)? {
                Some(steep) if to_scale => two_digits(STEEP / steep).max(1.0),
                Some(steep) => two_digits(STEEP / steep),
                None => 1.0,
            },
        };
        Ok(VerticalScale { factor, chosen, to_scale, degree: metres.and_then(|metres| degree(band, metres)) })
    }
}

fn two_digits(factor: f64) -> f64 {
    format!("{factor:.1e}").parse().unwrap_or(factor)
}

fn degree(band: &Band, metres: Metres) -> Option<Degree> {
    let Metres::OnEllipsoid { radians, .. } = metres else { return None };
    let [_, bottom, _, top] = band.extent();
    let ((longitude, latitude), _) = band.in_metres();
    let degrees = radians.to_degrees();
    Some(Degree {
        latitude: (bottom + top) / 2.0 * degrees,
        of_longitude: longitude / degrees,
        of_latitude: latitude / degrees,
    })
}

/// The sides of a cell along a row and along a column, in the unit of heights.
pub(super) fn cell_size(band: &Band) -> (f64, f64) {
    let [_, xp, xl, _, yp, yl] = band.geo_transform().coefficients();
    let ((x, y), height) = band.in_metres();
    ((xp * x).hypot(yp * y) / height, (xl * x).hypot(yl * y) / height)
}

/// Patches of the raster that are looked at, each way.
const PATCHES: usize = 16;
/// Squares of a patch, each way.
const SQUARES: usize = 64;

/// The slope (height over distance, in true proportions) that this share of a raster's slopes does not exceed, over
/// squares of `cells` cells, at most 64. `None` if there is no slope above 0, or none at all.
///
/// At most 256 patches are read, evenly spread, each of 128² samples at most; a raster of up to 1024 cells each way is read
/// whole. Memory: 4 MiB.
pub(super) fn steepness(band: &Band, cells: usize, share: f64, control: &Control) -> Result<Option<f64>, PreviewError> {
    let cells = cells.clamp(1, SQUARES.min(band.width() - 1).min(band.height() - 1));
    let (width, height) = cell_size(band);
    let (width, height) = (width * cells as f64, height * cells as f64);
    let (across, down) = (patches(band.width() - cells), patches(band.height() - cells));
    let mut reader = HeightReader::new(band);
    let (mut heights, mut slopes) = (Vec::new(), Vec::<f32>::new());
    for &(row, rows) in &down {
        control.cancel.check()?;
        for &(column, columns) in &across {
            let window = Window { column, row, width: columns + cells, height: rows + cells };
            heights.resize(window.len(), 0.0);
            reader.read(window, &mut heights)?;
            for first in (0..rows).flat_map(|j| (0..columns).map(move |i| j * window.width + i)) {
                let (right, below) = (first + cells, first + cells * window.width);
                let corners = [first, right, below, below + cells].map(|i| heights[i]);
                let (rise_across, rise_down) = rises(corners);
                slopes.push((rise_across / width).hypot(rise_down / height) as f32);
            }
        }
    }
    slopes.retain(|slope| slope.is_finite());
    Ok(percentile(&mut slopes, share).filter(|slope| *slope > 0.0).map(f64::from))
}

/// Where patches begin, and how many squares each has, of so many squares in a row.
fn patches(squares: usize) -> Vec<(usize, usize)> {
    let count = squares.div_ceil(SQUARES).min(PATCHES);
    let patch = |i: usize| {
        let (from, to) = (i * squares / count, (i + 1) * squares / count);
        let size = (to - from).min(SQUARES);
        (from + (to - from - size) / 2, size)
    };
    (0..count).map(patch).collect()
}

/// How much a square rises across and down: its corners are the upper left and right, the lower left and right.
pub(super) fn rises([a, b, c, d]: [f64; 4]) -> (f64, f64) {
    (0.5 * ((b - a) + (d - c)), 0.5 * ((c - a) + (d - b)))
}

/// The least of the values that `share` of them do not exceed; `None` of none. Reorders them.
pub(crate) fn percentile(values: &mut [f32], share: f64) -> Option<f32> {
    let rank = (share * values.len() as f64).ceil().max(1.0) as usize;
    (rank <= values.len()).then(|| *values.select_nth_unstable_by(rank - 1, f32::total_cmp).1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::{GeoTransform, Reference};

    const SIZE: (usize, usize) = (300, 200);

    /// Where x and y are metres, or nobody knows what they are.
    fn band(height: impl Fn(usize, usize) -> f64, metres: Option<Metres>, coefficients: [f64; 6]) -> Band {
        let heights = (0..SIZE.1).flat_map(|row| (0..SIZE.0).map(move |column| (column, row)));
        let heights = heights.map(|(column, row)| height(column, row)).collect();
        let transform = GeoTransform::new(coefficients, SIZE.0, SIZE.1).expect("a transform");
        Band::of_doubles("dem", SIZE, heights)
            .expect("a band")
            .with_reference(Reference { metres, ..Reference::none() }, None)
            .with_geo_transform(transform)
    }

    fn scale(band: &Band, factor: Option<f64>) -> VerticalScale {
        let window = Window { column: 0, row: 0, width: band.width(), height: band.height() };
        VerticalScale::of(band, factor, &View::fit(window, (1024, 1024)), &Control::default()).expect("a scale")
    }

    const METRES: Option<Metres> = Some(Metres::PerUnit(1.0));
    const CELLS: [f64; 6] = [500_000.0, 10.0, 0.0, 5_200_000.0, 0.0, -10.0];

    #[test]
    fn gentle_ground_is_exaggerated_and_steep_ground_is_not() {
        // Rises over cells of 10 m.
        for (rise, known, unknown) in [(0.5, 14.0, 14.0), (2.4, 2.9, 2.9), (10.0, 1.0, 0.7), (35.0, 1.0, 0.2)] {
            let ramp = |column, _| rise * column as f64;
            assert_eq!(scale(&band(ramp, METRES, CELLS), None).factor, known, "{rise} m");
            let found = scale(&band(ramp, None, CELLS), None);
            let expected = VerticalScale { factor: unknown, chosen: true, to_scale: false, degree: None };
            assert_eq!(found, expected, "{rise} m");
        }
        for height in [7.0, f64::NAN] {
            assert_eq!(scale(&band(|_, _| height, METRES, CELLS), None).factor, 1.0, "{height} everywhere");
        }
        let given = VerticalScale { factor: 3.0, chosen: false, to_scale: true, degree: None };
        assert_eq!(scale(&band(|column, _| column as f64, METRES, CELLS), Some(3.0)), given);
    }

    #[test]
    fn nineteen_of_twenty_slopes_count() {
        // The slope of the first columns is 2, of the others 0.1, and there are gaps, which count for nothing.
        let with_steep = |columns: usize| {
            let height = move |column: usize, row: usize| {
                let high = 20.0 * column.min(columns) as f64 + column.saturating_sub(columns) as f64;
                if row.is_multiple_of(9) { f64::NAN } else { high }
            };
            scale(&band(height, METRES, CELLS), None).factor
        };
        assert_eq!((with_steep(14), with_steep(15)), (7.0, 1.0), "of 299 columns of cells");
    }

    #[test]
    fn a_degree_is_as_long_as_it_is_there() {
        let moon = Metres::OnEllipsoid { semi_major: 1_737_400.0, semi_minor: 1_737_400.0, radians: 1f64.to_radians() };
        // From 59° to 61° south, and 0.01 of the way across.
        let degrees = [10.0, 0.01, 0.0, -59.0, 0.0, -0.01];
        let found = scale(&band(|column, _| 15.1616 * column as f64, Some(moon), degrees), None);
        let degree = found.degree.expect("a degree");
        assert!((degree.latitude + 60.0).abs() < 1e-9, "{degree:?}");
        assert!((degree.of_longitude - 15_161.7).abs() < 0.1 && (degree.of_latitude - 30_323.35).abs() < 0.1);
        assert_eq!(found.factor, 7.0, "a slope of 0.1");
        let down = band(|_, row| 30.3233 * row as f64, Some(moon), degrees);
        assert_eq!(scale(&down, None).factor, 7.0, "a slope of 0.1");
    }

    #[test]
    fn patches_are_spread_over_any_raster() {
        for squares in [1, 63, 64, 65, 500, 1023, 1024, 1025, 40_000] {
            let found = patches(squares);
            assert!(found.windows(2).all(|pair| pair[0].0 + pair[0].1 <= pair[1].0), "{squares}: {found:?}");
            assert!(found.last().is_some_and(|&(from, size)| from + size <= squares), "{squares}: {found:?}");
            assert!(found.iter().all(|&(_, size)| size <= SQUARES));
            let all: usize = found.iter().map(|patch| patch.1).sum();
            assert_eq!(all, squares.min(PATCHES * SQUARES));
        }
    }

    #[test]
    fn slopes_are_those_over_a_pixel() {
        // Steps of a cell that lead nowhere.
        let rough = band(|column, _| 10.0 * (column % 2) as f64, METRES, CELLS);
        let steep = |cells| steepness(&rough, cells, MOST, &Control::default()).expect("slopes");
        assert_eq!((steep(1), steep(2)), (Some(1.0), None));
    }
}
