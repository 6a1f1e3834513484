//! Maps of a survey: a hillshade, and over it where errors are large, how dense triangles are, and what is close to the tolerance.

use std::fmt::Write;

use super::html::{figure, text};
use super::image::{Colour, css, data_address};
use super::numbers;
use crate::preview::{Light, percentile};
use crate::run::survey::{MapGrid, Survey};

/// Pixels across a map.
const ACROSS: f64 = 600.0;
/// The slope that nineteen of twenty squares do not exceed in the hillshade: 35°.
const STEEP: f64 = 0.7;
/// Greys of a hillshade.
const GREYS: usize = 32;
const NOTHING: Colour = [0, 0, 0, 0];
const OVER: Colour = [215, 25, 28, 255];

/// Colours for values from a bound on, the last for what is above the tolerance.
type Steps = [(f64, Colour); 6];

const ERRORS: Steps = [
    (0.0, [255, 255, 204, 150]),
    (0.25, [199, 233, 180, 150]),
    (0.5, [127, 205, 187, 165]),
    (0.7, [65, 182, 196, 180]),
    (0.8, [44, 127, 184, 190]),
    (0.9, [37, 52, 148, 200]),
];

/// Against the mean density.
const DENSITIES: Steps = [
    (0.0, [247, 244, 249, 150]),
    (0.25, [212, 185, 218, 160]),
    (0.5, [201, 148, 199, 170]),
    (1.0, [223, 101, 176, 180]),
    (2.0, [206, 18, 86, 190]),
    (4.0, [103, 0, 31, 210]),
];

/// By the share of the samples of a square.
const CLOSE: [(f64, Colour); 4] =
    [(0.0, [254, 237, 160, 170]), (0.05, [254, 196, 79, 190]), (0.2, [236, 112, 20, 210]), (0.5, [153, 52, 4, 225])];

/// What maps are called, in their order.
pub(super) const TITLES: [&str; 3] = ["Largest error", "Density of triangles", "Close to the tolerance"];

/// The id of the image of what a map shows: a square of the map is a pixel.
pub(super) fn id(title: &str) -> String {
    title.to_lowercase().replace(' ', "-")
}

/// Adds all maps to a page. `worst` is the column and row of the largest error.
pub(super) fn add_maps(page: &mut String, survey: &Survey, tolerance: f64, worst: Option<(usize, usize)>, unit: &str) {
    let frame = Frame::of(survey);
    let mut hillshade = Some(hillshade(survey));
    page.push_str("<div class=\"maps\">\n");
    let mut add = |title: &str, overlay: &str, mark: Option<(usize, usize)>, caption: String| {
        let picture = frame.drawn(title, &survey.map, overlay, mark, hillshade.take());
        *page += &figure(title, &picture, &caption);
    };
    let (side, map) = (survey.map.side, &survey.map);
    let square = match (side, survey.raster.cell_metres) {
        (1, _) => "A square is a sample.".to_string(),
        (_, None) => format!("A square is {side} × {side} samples."),
        (_, Some((across, down))) => {
            let [across, down] = [across, down].map(|cell| numbers::figure(cell * side as f64));
            format!("A square is {side} × {side} samples, {across} × {down} m.")
        }
    };
    let ratio = |max: f32| if tolerance > 0.0 { f64::from(max) / tolerance } else { 0.0 };
    let above = spread(map);
    let errors = overlay(map, &colours(&ERRORS), |map, at| {
        let cell = &map.cells[at];
        let step = || step(&ERRORS, ratio(cell.max)) + 1;
        if above[at] {
            ERRORS.len() + 1
        } else if cell.measured > 0 {
            step()
        } else {
            0
        }
    });
    let bounds = |step: &(f64, Colour)| numbers::figure(step.0 * tolerance);
    let legend = legend(&ERRORS, bounds, unit, Some(&numbers::figure(tolerance)), "above the tolerance");
    let ring = if worst.is_some() { " The ring is around the largest of all." } else { "" };
    add(TITLES[0], &errors, worst, format!("The largest error in each square. {square}{ring}{legend}"));

    let (density, mean) = density(map);
    let bounds = |step: &(f64, Colour)| numbers::figure(step.0 * mean * 1000.0);
    let legend = self::legend(&DENSITIES, bounds, "", None, "");
    let mean = numbers::figure(mean * 1000.0);
    let caption = format!("Triangles in 1000 samples, by the middle of each; the mean is {mean}. {square}{legend}");
    add(TITLES[1], &density, None, caption);

    let close = overlay(map, &colours(&CLOSE), |map, at| {
        let cell = &map.cells[at];
        let share = f64::from(cell.near) / f64::from(cell.measured.max(1));
        if above[at] {
            CLOSE.len() + 1
        } else if cell.near > 0 {
            step(&CLOSE, share) + 1
        } else {
            0
        }
    });
    let bounds = |step: &(f64, Colour)| format!("{} %", step.0 * 100.0);
    let legend = self::legend(&CLOSE, bounds, "", None, "some above the tolerance");
    let bound = numbers::figure(0.9 * tolerance);
    let caption =
        format!("The share of samples with an error above 0.9 of the tolerance ({bound}{unit}). {square}{legend}");
    add(TITLES[2], &close, None, caption);
    page.push_str("</div>\n");
}

/// Where things are in a map.
struct Frame {
    width: f64,
    height: f64,
    /// Pixels of a sample across and down.
    sample: (f64, f64),
    /// Metres in a pixel, if they are known.
    metres: Option<f64>,
}

impl Frame {
    fn of(survey: &Survey) -> Frame {
        let (across, down) = survey.map.samples;
        let (cell_across, cell_down) = survey.raster.cell_metres.unwrap_or((1.0, 1.0));
        let ratio = (down as f64 * cell_down / (across as f64 * cell_across)).clamp(0.05, 20.0);
        let (width, height) = (ACROSS, ACROSS * ratio);
        let metres = survey.raster.cell_metres.map(|(cell, _)| cell * across as f64 / width);
        Frame { width, height, sample: (width / across as f64, height / down as f64), metres }
    }

    /// A map: the hillshade, given once and used again, and what lies over it.
    fn drawn(
        &self,
        label: &str,
        map: &MapGrid,
        overlay: &str,
        mark: Option<(usize, usize)>,
        hillshade: Option<String>,
    ) -> String {
        let Frame { width, height, .. } = *self;
        let squares = |samples: f64, count: usize| samples * (count * map.side) as f64;
        let size = (squares(self.sample.0, map.size.0), squares(self.sample.1, map.size.1));
        let image = |address: &str, more: &str| {
            format!(
                "<image{more} href=\"{address}\" width=\"{:.2}\" height=\"{:.2}\" preserveAspectRatio=\"none\"/>\n",
                size.0, size.1
            )
        };
        let below = match hillshade {
            Some(address) => image(&address, " id=\"hillshade\""),
            None => "<use href=\"#hillshade\"/>\n".to_string(),
        };
        let narrow = 40.0 * (1.3 * width / height).min(1.0);
        let mut out = format!(
            "<svg viewBox=\"0 0 {width} {height:.1}\" role=\"img\" aria-label=\"{}\" style=\"max-width:{narrow:.1}rem\">\n{below}{}",
            text(label),
            image(overlay, &format!(" id=\"{}\"", id(label)))
        );
        if let Some((column, row)) = mark {
            let (x, y) = ((column as f64 + 0.5) * self.sample.0, (row as f64 + 0.5) * self.sample.1);
            for class in ["mark", "mark in"] {
                let _ = writeln!(out, "<circle class=\"{class}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"13\"/>");
            }
        }
        out + &self.scale_bar() + "</svg>\n"
    }

    /// A length that is easy to think of, at most a fourth of the map.
    fn scale_bar(&self) -> String {
        let Some(metres) = self.metres else { return String::new() };
        let most = self.width / 4.0 * metres;
        let power = 10f64.powf(most.log10().floor());
        let length = [5.0, 2.0, 1.0].map(|n| n * power).into_iter().find(|length| *length <= most).unwrap_or(power);
        let words = if length >= 1000.0 { format!("{} km", length / 1000.0) } else { format!("{length} m") };
        let (pixels, y) = (length / metres, self.height - 10.0);
        let line = |class: &str| format!("<path class=\"{class}\" d=\"M10 {:.1}v5h{pixels:.1}v-5\"/>", y - 5.0);
        let halo = "stroke=\"#fff\" stroke-width=\"3\" paint-order=\"stroke\" style=\"fill:#000\"";
        format!("{}{}<text x=\"15\" y=\"{:.1}\" {halo}>{words}</text>\n", line("scale"), line("scale in"), y - 8.0)
    }
}

/// Which squares are drawn as above the tolerance: those that are, and some around each, so that a single one is seen.
fn spread(map: &MapGrid) -> Vec<bool> {
    let (across, down) = map.size;
    let reach = across.max(down) / 150;
    let mut out = vec![false; map.cells.len()];
    for at in (0..map.cells.len()).filter(|at| map.cells[*at].above > 0) {
        let (column, row) = (at % across, at / across);
        for row in row.saturating_sub(reach)..(row + reach + 1).min(down) {
            let (first, end) = (column.saturating_sub(reach), (column + reach + 1).min(across));
            out[row * across + first..row * across + end].fill(true);
        }
    }
    out
}

/// The step that a value belongs to.
fn step(steps: &[(f64, Colour)], value: f64) -> usize {
    steps.iter().rposition(|(from, _)| value >= *from).unwrap_or(0)
}

/// Nothing, the colours of the steps, and that of what is above the tolerance.
fn colours(steps: &[(f64, Colour)]) -> Vec<Colour> {
    std::iter::once(NOTHING).chain(steps.iter().map(|step| step.1)).chain([OVER]).collect()
}

fn overlay(map: &MapGrid, palette: &[Colour], colour: impl Fn(&MapGrid, usize) -> usize) -> String {
    let pixels: Vec<u8> = (0..map.cells.len()).map(|at| colour(map, at) as u8).collect();
    data_address(map.size, palette, &pixels)
}

/// Triangles by area, against their mean, in blocks of squares that hold about eight; and the mean, in a sample.
fn density(map: &MapGrid) -> (String, f64) {
    let (faces, measured) = map.cells.iter().fold((0u64, 0u64), |(faces, measured), cell| {
        (faces + u64::from(cell.faces), measured + u64::from(cell.measured))
    });
    let mean = faces as f64 / measured.max(1) as f64;
    let of_square = mean * (map.side * map.side) as f64;
    let block = if of_square > 0.0 { (8.0 / of_square).sqrt().ceil().clamp(1.0, 64.0) as usize } else { 1 };
    let across = map.size.0.div_ceil(block);
    let mut sums = vec![(0u64, 0u64); across * map.size.1.div_ceil(block)];
    let block_of = |at: usize| at / map.size.0 / block * across + at % map.size.0 / block;
    for (at, cell) in map.cells.iter().enumerate() {
        let (faces, measured) = &mut sums[block_of(at)];
        (*faces, *measured) = (*faces + u64::from(cell.faces), *measured + u64::from(cell.measured));
    }
    let picture = overlay(map, &colours(&DENSITIES), |map, at| {
        let (faces, measured) = sums[block_of(at)];
        let density = faces as f64 / measured.max(1) as f64;
        if map.cells[at].measured > 0 { step(&DENSITIES, density / mean) + 1 } else { 0 }
    });
    (picture, mean)
}

/// The colours and where each begins and ends; the last one has no end unless one is given. `over` are the words for what is above
/// the tolerance, if that has a colour.
fn legend(
    steps: &[(f64, Colour)],
    bound: impl Fn(&(f64, Colour)) -> String,
    unit: &str,
    end: Option<&str>,
    over: &str,
) -> String {
    let entry = |colour: Colour, words: String| {
        format!("<span><i style=\"background:{}\"></i>{}</span>\n", css(colour), text(&words))
    };
    let ends = steps.iter().skip(1).map(|step| Some(bound(step))).chain([end.map(str::to_string)]);
    let entries = steps.iter().zip(ends).map(|(step, end)| match end {
        Some(end) => entry(step.1, format!("{} to {end}{unit}", bound(step))),
        None => entry(step.1, format!("{}{unit} and more", bound(step))),
    });
    let entries: String = entries.collect();
    let over = if over.is_empty() { String::new() } else { entry(OVER, over.to_string()) };
    format!("<div class=\"legend\">{entries}{over}</div>")
}

/// The raster in grey, lit from the upper left; nothing where there is no height.
fn hillshade(survey: &Survey) -> String {
    let map = &survey.map;
    let height = |at: usize| map.cells[at].height;
    let at = |column: usize, row: usize| height(row * map.size.0 + column);
    let rise = |before: f64, here: f64, after: f64| match (before.is_nan(), after.is_nan()) {
        (false, false) => (after - before) / 2.0,
        (false, true) => here - before,
        (true, false) => after - here,
        (true, true) => 0.0,
    };
    let beside = |there: bool, value: &dyn Fn() -> f64| if there { value() } else { f64::NAN };
    let rises = |index: usize| {
        let (column, row, here) = (index % map.size.0, index / map.size.0, height(index));
        let left = beside(column > 0, &|| at(column - 1, row));
        let right = beside(column + 1 < map.size.0, &|| at(column + 1, row));
        let above = beside(row > 0, &|| at(column, row - 1));
        let below = beside(row + 1 < map.size.1, &|| at(column, row + 1));
        (rise(left, here, right), rise(above, here, below))
    };
    let metres = crate::base::metres_in(&survey.raster.reference.height_unit).unwrap_or(1.0);
    let (across, down) = survey.raster.cell_metres.map_or((1.0, 1.0), |(a, d)| (a / metres, d / metres));
    let square = (across * map.side as f64, down * map.side as f64);
    let there = (0..map.cells.len()).filter(|at| !height(*at).is_nan());
    let mut slopes: Vec<f32> = Vec::with_capacity(map.cells.len());
    slopes.extend(there.map(|at| {
        let (across, down) = rises(at);
        let (across, down) = (across / square.0, down / square.1);
        (across * across + down * down).sqrt() as f32
    }));
    let steep = percentile(&mut slopes, 0.95).filter(|steep| *steep > 0.0).map_or(STEEP, f64::from);
    let factor = if survey.raster.cell_metres.is_some() { (STEEP / steep).max(1.0) } else { STEEP / steep };
    let light = Light::new(square, factor);
    let grey = |at: usize| match height(at).is_nan() {
        true => GREYS as u8,
        false => {
            let (across, down) = rises(at);
            (light.shade(across, down) * (GREYS - 1) as f32).round() as u8
        }
    };
    let pixels: Vec<u8> = (0..map.cells.len()).map(grey).collect();
    let greys = (0..GREYS).map(|grey| {
        let light = (40 + grey * 215 / (GREYS - 1)) as u8;
        [light, light, light, 255]
    });
    let palette: Vec<Colour> = greys.chain([NOTHING]).collect();
    data_address(map.size, &palette, &pixels)
}
