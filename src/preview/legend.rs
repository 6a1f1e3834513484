//! Captions and the scale of colours.

use super::canvas::Canvas;
use super::colours::{EXCEEDED, NO_GROUND, UNCOVERED, scale};
use super::deviation::Summary;
use super::text;

const PAPER: [u8; 3] = [250, 250, 248];
const INK: [u8; 3] = [30, 30, 34];
const MARGIN: usize = 12;
const BAR: usize = 14;

/// The picture with lines of text below it.
pub(super) fn captioned(picture: Canvas, lines: &[String]) -> Canvas {
    let wide = lines.iter().map(|l| text::width(l)).max().unwrap_or(0) + 2 * MARGIN;
    let below = lines.len() * (text::LINE + 4) + 12;
    let mut page = Canvas::filled(picture.width.max(wide), picture.height + below, PAPER);
    page.paste(&picture, 0, 0);
    for (k, line) in lines.iter().enumerate() {
        text::draw(&mut page, MARGIN, picture.height + 8 + k * (text::LINE + 4), line, INK);
    }
    page
}

/// The error picture with its scale: a bar of colours from 0 to `end`, numbers below it, and what was found.
pub(super) fn with_scale(
    picture: Canvas,
    summary: &Summary,
    end: f64,
    tolerance: Option<f64>,
    stride: usize,
) -> Canvas {
    let lines = lines(summary, tolerance, stride);
    let wide = lines.iter().map(|l| text::width(l)).max().unwrap_or(0).max(360) + 2 * MARGIN;
    let wide = picture.width.max(wide);
    let below = MARGIN + BAR + 4 + text::LINE + 8 + (lines.len() + 1) * (text::LINE + 4) + MARGIN;
    let mut page = Canvas::filled(wide, picture.height + below, PAPER);
    let top = picture.height + MARGIN;
    page.paste(&picture, 0, 0);
    bar(&mut page, top, end);
    let first = top + BAR + 4 + text::LINE + 8;
    for (k, line) in lines.iter().enumerate() {
        text::draw(&mut page, MARGIN, first + k * (text::LINE + 4), line, INK);
    }
    let mut left = MARGIN;
    let marks = [(EXCEEDED, "beyond tolerance"), (UNCOVERED, "no surface"), (NO_GROUND, "no ground")];
    for (colour, label) in marks.into_iter().skip(usize::from(tolerance.is_none())) {
        let y = first + lines.len() * (text::LINE + 4);
        page.paste(&Canvas::filled(12, 12, colour), left, y + 2);
        text::draw(&mut page, left + 18, y, label, INK);
        left += 18 + text::width(label) + 16;
    }
    page
}

fn bar(page: &mut Canvas, top: usize, end: f64) {
    let wide = page.width - 2 * MARGIN;
    let colours = Canvas::from_fn(wide, BAR, |x, _| scale(x as f64 / (wide - 1) as f64));
    page.paste(&colours, MARGIN, top);
    for k in 0..=4 {
        let label = number(end * f64::from(k) / 4.0);
        let label = if k == 4 { format!("{label} m") } else { label };
        let x = MARGIN + (wide - 1) * k as usize / 4;
        let left = (x.saturating_sub(text::width(&label) / 2)).clamp(MARGIN, page.width - MARGIN - text::width(&label));
        for y in top + BAR..top + BAR + 3 {
            page.blend(x, y, INK, 1.0);
        }
        text::draw(page, left, top + BAR + 4, &label, INK);
    }
}

fn lines(summary: &Summary, tolerance: Option<f64>, stride: usize) -> Vec<String> {
    let Summary { valid, covered, largest, rms, beyond } = *summary;
    let mut first = format!("max error {} m, RMS {} m", number(largest), number(rms));
    if let Some(tolerance) = tolerance {
        first += &format!(", tolerance {} m", number(tolerance));
    }
    let mut second = format!("{valid} samples");
    if stride > 1 {
        second += &format!(" (every {stride}th each way)");
    }
    second += &format!(", {} without surface", valid - covered);
    if tolerance.is_some() {
        second += &format!(", {beyond} beyond tolerance");
    }
    vec![first, second]
}

/// Four significant digits.
pub(super) fn number(value: f64) -> String {
    match value.abs() {
        0.0 => "0".to_string(),
        v if !(1e-4..1e6).contains(&v) => format!("{value:.3e}"),
        v => {
            let before_point = v.log10().floor() as i32 + 1;
            let text = format!("{value:.*}", (4 - before_point).max(0) as usize);
            if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_string() } else { text }
        }
    }
}
