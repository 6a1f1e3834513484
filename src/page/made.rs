//! The page of a mesh that was made: from the run's own measurement.

use super::html::{self, facts, figure, list, section, text};
use super::view::{self, Drawn};
use super::words::unit_of;
use super::{Counts, Origin, PageError, angles, charts, files, ground, heading, json, numbers, warnings, words};
use crate::base::decimal::Decimal;
use crate::job::rules;
use crate::run::Report;
use crate::run::report::{BinaryBytes, grouped};

pub(super) fn page(report: &Report, origin: &Origin) -> Result<String, PageError> {
    let reference = &report.map.reference;
    let unit = unit_of(reference);
    let title = "A terrain mesh and how it was made";
    let scene = view::drawable(report.scene.as_ref());
    let script = scene.map(|_| view::SCRIPT);
    let mut page = html::begin(title, script);
    page += &heading(title, !report.fell_short(), &verdict(report, &unit));
    page += "<p>These figures are what the program that made the mesh measured at every sample before it wrote the file. They are no \
             certificate: <code>terrabite verify --report</code> reads the written file with other code, and adds maps, error by slope \
             and a check of every edge.</p>\n";
    page += &section("Files", &files(origin));
    let mut rows = words::reference_rows(reference);
    if let Some([left, top, width, height]) = report.window {
        rows.push(("Window", format!("{width} × {height} samples from column {left}, row {top}")));
    }
    if let Some([low, high]) = report.height_range {
        rows.push(("Heights", format!("{}{unit} to {}{unit}", Decimal(low), Decimal(high))));
    }
    page += &section("Coordinates and heights", &facts(&rows));
    page += &section("Vertical error", &errors(report, &unit));
    if let Some(scene) = scene {
        let temp_dir = origin.temp_dir.as_deref();
        let drawn = Drawn { scene, reference, unit: &unit, survey: None, is_mailed: true, temp_dir };
        view::add_view(&mut page, &drawn)?;
    }
    let counts = Counts {
        raster: report.raster_samples,
        ground: report.samples,
        missing: report.missing_samples,
        filled: (report.filled_samples, report.filled_voids),
        trimmed: report.trimmed_samples,
        isolated: report.isolated_samples,
    };
    page += &section("Ground", &ground(&counts));
    page += &section("Triangles", &triangles(report, &unit));
    let lines: Vec<(&str, String)> = report.lines().into_iter().map(|(name, value)| (name, text(&value))).collect();
    page += &section("The run", &facts(&lines));
    page += &section("Warnings", &warnings(&report.warnings));
    page += &section("What this does not say", &list(&not_promised(report)));
    page += &json(report, origin);
    html::end(&mut page, script);
    Ok(page)
}

fn verdict(report: &Report, unit: &str) -> String {
    let samples = grouped(report.samples);
    let figure = |number: f64| format!("{}{unit}", Decimal(number));
    if let Some(goal) = report.goal.as_ref().filter(|goal| goal.fell_short()) {
        let tolerance = goal.max_error.map(|most| format!("the tolerance of {}", figure(most)));
        let rms = goal.goal.max_rms.map(|rms| format!("the root mean square of {}", figure(rms)));
        let asked = rules::list(tolerance.into_iter().chain(rms));
        let largest = figure(report.error.max);
        return format!("A budget ended the run before it reached {asked}. The largest error is {largest}.");
    }
    match (report.tolerance, &report.goal) {
        (Some(tolerance), _) if report.importance.is_some() => {
            format!("At every one of {samples} samples of the ground error × weight is at most {}.", figure(tolerance))
        }
        (Some(tolerance), _) => {
            format!(
                "At every one of {samples} samples of the ground the mesh is within {} of the raster.",
                figure(tolerance)
            )
        }
        (None, _) => {
            format!(
                "No tolerance was asked for. The largest error of {samples} samples is {}.",
                figure(report.error.max)
            )
        }
    }
}

fn errors(report: &Report, unit: &str) -> String {
    let error = &report.error;
    let number = |number: f64| format!("{}{}", numbers::figure(number), text(unit));
    let mut rows = Vec::new();
    if let Some(tolerance) = report.tolerance {
        rows.push(("Tolerance", format!("{}{}", Decimal(tolerance), text(unit))));
    }
    let at = words::place(error.x, error.y, error.column, error.row, &report.map.reference);
    rows.push(("Largest error", format!("{}{}<br><small>at {}</small>", Decimal(error.max), text(unit), text(&at))));
    rows.push(("Root of the mean square", number(error.rms)));
    let shares =
        [("50 %", error.p50), ("90 %", error.p90), ("95 %", error.p95), ("99 %", error.p99), ("100 %", error.max)];
    let shares: Vec<Vec<String>> = shares.iter().map(|(name, at)| vec![name.to_string(), number(*at)]).collect();
    let shares = html::table(&["of the samples", "at most"], &[false, true], &shares);
    let brackets = words::in_brackets(unit);
    let counts = &error.histogram;
    let (all, mut seen) = (counts.iter().sum::<u64>().max(1), 0u64);
    let bin = error.histogram_end / counts.len() as f64;
    // The share of the samples at the end of each bin, turned round: the distance at each per cent.
    let mut cumulative = Vec::with_capacity(100);
    for (i, count) in counts.iter().enumerate() {
        seen += count;
        while cumulative.len() < 100 && seen * 100 >= (cumulative.len() as u64 + 1) * all {
            cumulative.push(((i + 1) as f64 * bin).min(error.max));
        }
    }
    let coarse: Vec<u64> = counts.chunks(8).map(|bins| bins.iter().sum()).collect();
    let histogram = figure(
        "Errors",
        &charts::distances(&coarse, error.histogram_end, &brackets),
        "Samples by their vertical distance from the mesh.",
    );
    let curve = figure(
        "Cumulative curve",
        &charts::cumulative(&cumulative, error.histogram_end, report.tolerance.is_some(), &brackets),
        "The share of the samples whose distance is at most so large. The dots are at 50, 90, 95 and 99 %.",
    );
    format!(
        "<div class=\"grid\"><div>{}</div><div>{shares}</div></div>\n<div class=\"grid\">{histogram}{curve}</div>\n",
        facts(&rows)
    )
}

fn triangles(report: &Report, unit: &str) -> String {
    let mut rows = vec![
        ("Triangles", grouped(report.triangles)),
        ("Vertices", grouped(report.vertices)),
        ("Samples for each triangle", numbers::figure(report.samples_per_triangle)),
    ];
    if let Some(shape) = &report.shape {
        let beyond = format!("{:.2} % of the edges stray farther than the tolerance", 100.0 * shape.edges_beyond);
        rows.push((
            "Between samples",
            format!("{beyond}, the farthest {}{}", numbers::figure(shape.overshoot_max), text(unit)),
        ));
    }
    rows.push(("Temporary files", BinaryBytes(report.temporary_bytes).to_string()));
    let angles = report.shape.as_ref().map_or(String::new(), |shape| angles(&shape.smallest_angles));
    format!("<div class=\"grid\"><div>{}</div>{angles}</div>\n", facts(&rows))
}

fn not_promised(report: &Report) -> Vec<String> {
    let is_georeferenced = report.map.reference.georeferenced;
    let mut points = words::not_promised(false, report.max_stray.is_some(), is_georeferenced);
    points.insert(
        0,
        "There are no maps and no errors by slope on this page: they come with <code>verify --report</code>."
            .to_string(),
    );
    points
}
