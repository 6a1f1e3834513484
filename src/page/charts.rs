//! Charts as SVG.

use std::fmt::Write;

use super::html::text;
use super::numbers::{figure, percent};

/// The size of a chart, and what is left free for axes to the left and below, above and to the right.
const SIZE: (f64, f64) = (560.0, 220.0);
const LEFT: f64 = 58.0;
const BELOW: f64 = 38.0;
const ABOVE: f64 = 12.0;
const RIGHT: f64 = 14.0;

/// The part of a chart that is drawn on.
const WIDTH: f64 = SIZE.0 - LEFT - RIGHT;
const HEIGHT: f64 = SIZE.1 - BELOW - ABOVE;

/// A chart whose drawing is within this frame; `label` is read aloud.
fn chart(label: &str, x_title: &str, inside: &str) -> String {
    let (width, height) = SIZE;
    let (middle, bottom) = (LEFT + WIDTH / 2.0, height - 4.0);
    format!(
        "<svg viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{}\">\n{inside}\
         <path class=\"axis\" d=\"M{LEFT} {ABOVE}v{HEIGHT}h{WIDTH}\"/>\
         <text x=\"{middle}\" y=\"{bottom}\" text-anchor=\"middle\" class=\"soft\">{}</text></svg>\n",
        text(label),
        text(x_title)
    )
}

/// A mark on the axis below, with words.
fn tick(out: &mut String, x: f64, words: &str) {
    let (at, y) = (LEFT + x * WIDTH, ABOVE + HEIGHT);
    let _ = writeln!(
        out,
        "<path class=\"axis\" d=\"M{at:.1} {y}v4\"/><text x=\"{at:.1}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
        y + 15.0,
        text(words)
    );
}

/// A line across, with words at its left.
fn level(out: &mut String, y: f64, words: &str) {
    let at = ABOVE + HEIGHT * (1.0 - y);
    let _ = writeln!(
        out,
        "<path class=\"rule\" d=\"M{LEFT} {at:.1}h{WIDTH}\"/><text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
        LEFT - 5.0,
        at + 4.0,
        text(words)
    );
}

/// Bars next to each other: counts, and whether they are beyond what is allowed.
fn bars(out: &mut String, counts: impl ExactSizeIterator<Item = (u64, bool)>, largest: u64) {
    let width = WIDTH / counts.len() as f64;
    for (i, (count, is_over)) in counts.enumerate().filter(|(_, (count, _))| *count > 0) {
        let height = (count as f64 / largest as f64 * HEIGHT).max(0.75);
        let (x, y) = (LEFT + i as f64 * width, ABOVE + HEIGHT - height);
        let class = if is_over { "over" } else { "bar" };
        let _ = writeln!(
            out,
            "<rect class=\"{class}\" x=\"{:.2}\" y=\"{y:.2}\" width=\"{:.2}\" height=\"{height:.2}\"/>",
            x + 0.5,
            (width - 1.0).max(0.5)
        );
    }
}

/// Counts in bins as bars, with the share of the largest at the left.
fn histogram(label: &str, title: &str, counts: &[(u64, bool)], ticks: &[(f64, String)]) -> String {
    let (largest, all) = (counts.iter().map(|c| c.0).max().unwrap_or(0).max(1), counts.iter().map(|c| c.0).sum());
    let mut inside = String::new();
    for part in [0.5, 1.0] {
        level(&mut inside, part, &percent((largest as f64 * part).round() as u64, all));
    }
    bars(&mut inside, counts.iter().copied(), largest);
    ticks.iter().for_each(|(x, words)| tick(&mut inside, *x, words));
    chart(label, title, &inside)
}

/// Signed errors: below −ε, bins up to ε, above it.
pub(super) fn signed_errors(counts: &[u64], tolerance: f64, unit: &str) -> String {
    let last = counts.len() - 1;
    let bins: Vec<(u64, bool)> = counts.iter().enumerate().map(|(i, c)| (*c, i == 0 || i == last)).collect();
    let bin = 1.0 / counts.len() as f64;
    let at = |share: f64| bin + share * (1.0 - 2.0 * bin);
    let ticks = [-1.0, -0.5, 0.0, 0.5, 1.0].map(|e| (at((e + 1.0) / 2.0), figure(e * tolerance)));
    histogram("Histogram of signed errors", &format!("surface less raster{unit}"), &bins, &ticks)
}

/// Distances in equal bins from 0 to the tolerance.
pub(super) fn distances(counts: &[u64], tolerance: f64, unit: &str) -> String {
    let bins: Vec<(u64, bool)> = counts.iter().map(|count| (*count, false)).collect();
    let ticks = [0.0, 0.25, 0.5, 0.75, 1.0].map(|share| (share, figure(share * tolerance)));
    histogram("Histogram of errors", &format!("distance{unit}"), &bins, &ticks)
}

/// Smallest angles of triangles by whole degrees.
pub(super) fn angles(counts: &[u64]) -> String {
    let bins: Vec<(u64, bool)> = counts.iter().map(|count| (*count, false)).collect();
    let ticks: Vec<(f64, String)> = (0..=6).map(|tens| (f64::from(tens) / 6.0, format!("{}°", 10 * tens))).collect();
    histogram("Histogram of smallest angles", "smallest angle of a triangle", &bins, &ticks)
}

/// The distances that 1 %, 2 % and so on of the samples do not exceed, on an axis for distances of about `scale`, and a line there if it
/// is the tolerance. Where samples are far beyond it, the curve leaves to the right.
pub(super) fn cumulative(distances: &[f64], scale: f64, is_tolerance: bool, unit: &str) -> String {
    let largest = distances.last().copied().unwrap_or(0.0);
    let end = largest.min(2.0 * scale).max(scale);
    let end = if end > 0.0 { end * 1.02 } else { largest.max(1.0) };
    let mut inside = String::new();
    for percent in [0, 50, 90, 100] {
        level(&mut inside, f64::from(percent) / 100.0, &format!("{percent} %"));
    }
    let place = |share: f64, distance: f64| (LEFT + (distance / end).min(1.0) * WIDTH, ABOVE + HEIGHT * (1.0 - share));
    let mut path = format!("M{LEFT} {}", ABOVE + HEIGHT);
    for (i, distance) in distances.iter().enumerate() {
        let (x, y) = place((i + 1) as f64 / distances.len() as f64, *distance);
        let _ = write!(path, "L{x:.1} {y:.1}");
        if *distance > end {
            break;
        }
    }
    if is_tolerance {
        let limit = place(0.0, scale).0;
        let _ = writeln!(inside, "<path class=\"limit\" d=\"M{limit:.1} {ABOVE}v{HEIGHT}\"/>");
    }
    let _ = writeln!(inside, "<path class=\"curve\" d=\"{path}\"/>");
    for percent in [50, 90, 95, 99] {
        if let Some(distance) = distances.get(percent - 1).filter(|distance| **distance <= end) {
            let (x, y) = place(percent as f64 / 100.0, *distance);
            let _ = writeln!(inside, "<circle class=\"bar\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3\"/>");
        }
    }
    let step = if scale > 0.0 { scale } else { end };
    let ticks = [0.0, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0].map(|t| t * step).into_iter().filter(|t| *t <= end);
    ticks.for_each(|t| tick(&mut inside, t / end, &figure(t)));
    let dashed = if is_tolerance { "; dashed: the tolerance" } else { "" };
    chart("Cumulative curve of errors", &format!("distance{unit}{dashed}"), &inside)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bars_of(svg: &str, class: &str) -> usize {
        svg.matches(&format!("<rect class=\"{class}\"")).count()
    }

    #[test]
    fn a_bar_for_every_bin_that_has_something() {
        let svg = signed_errors(&[1, 0, 5, 9, 0, 2], 2.0, " (m)");
        assert_eq!((bars_of(&svg, "bar"), bars_of(&svg, "over")), (2, 2));
        for words in [">-2<", ">-1<", ">0<", ">1<", ">2<", ">52.94 %<"] {
            assert!(svg.contains(words), "{words} in {svg}");
        }
        assert_eq!(bars_of(&distances(&[0; 8], 0.0, ""), "bar"), 0);
    }

    #[test]
    fn a_curve_ends_at_the_top_or_leaves_to_the_right() {
        let within: Vec<f64> = (1..=100).map(|i| f64::from(i) / 100.0).collect();
        let svg = cumulative(&within, 1.0, true, "");
        assert!(svg.contains(&format!("{ABOVE:.1}\"/>")) && svg.matches("<circle").count() == 4, "{svg}");
        let beyond: Vec<f64> = (1..=100).map(|i| if i > 92 { 1e6 } else { 0.5 }).collect();
        let svg = cumulative(&beyond, 1.0, false, "");
        assert_eq!(svg.matches("<circle").count(), 2, "95 and 99 % are off the chart");
        assert!(!svg.contains("NaN") && !svg.contains("tolerance"));
        assert!(!cumulative(&[0.0; 100], 0.0, true, "").contains("NaN"));
    }
}
