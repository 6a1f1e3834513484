//! Reports as pages: one HTML file each, without a network, that is read in a browser and printed.
//!
//! In comes what a run tells in the end ([`VerifyReport`], [`Report`]); out goes a text. A page takes no figure from anywhere else,
//! but for the checksums of the files, which it reads once. Charts are SVG, maps are small pictures inside. The mesh is in it for a
//! view in three dimensions (`view`), which the only program on it draws. The report is in it as JSON, too.

mod charts;
mod checkpoints;
mod checks;
mod hash;
mod html;
mod image;
mod made;
mod maps;
mod numbers;
mod opened;
mod view;
mod words;

use std::io::Write;
use std::path::{Path, PathBuf};

use crate::base::decimal::Decimal;
use crate::base::staged::{OutputError, StagedFile};
use crate::base::warning::Warnings;
use crate::formats::SinkError;
use crate::run::report::{BinaryBytes, grouped};
use crate::run::scene::SceneReport;
use crate::run::survey::Survey;
use crate::run::{Report, VerifyReport};

use html::{facts, figure, list, section, text};
use numbers::percent;
use view::Drawn;
use words::unit_of;

/// What a page says of how it came to be.
#[derive(Debug, Clone)]
pub struct Origin {
    /// The words of the command.
    pub command: Vec<String>,
    /// When it was made, as people read it.
    pub made: String,
    /// The raster.
    pub raster: PathBuf,
    /// The mesh.
    pub mesh: PathBuf,
    /// The folder of temporary files; `None` is the system's.
    pub temp_dir: Option<PathBuf>,
}

/// Why a page cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum PageError {
    /// The mesh in it cannot be encoded.
    #[error(transparent)]
    Sink(#[from] SinkError),
    /// A file cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// Temporary files are of no use.
    #[error("the view of the page: temporary files: {0}")]
    Temporary(std::io::Error),
}

/// The page of a mesh that was judged. It has no maps, no shares and no slopes where the report has no survey, and no view where it has
/// no scene.
///
/// # Errors
/// [`PageError`]: the mesh cannot be put into it.
pub fn of_verdict(report: &VerifyReport, origin: &Origin) -> Result<String, PageError> {
    let verdict = &report.verdict;
    let reference = report.survey.as_ref().map(|survey| &survey.raster.reference);
    let unit = reference.map_or(String::new(), unit_of);
    let scene = view::drawable(report.scene.as_ref()).filter(|_| report.survey.is_some());
    let (title, script) = ("Quality of a terrain mesh", scene.map(|_| view::SCRIPT));
    let mut page = html::begin(title, script);
    page += &heading(title, report.passed, &words::verdict(report, &unit));
    if !report.passed {
        page += &list(&report.failures.iter().map(|failure| text(failure)).collect::<Vec<_>>());
    }
    page += &section("Files", &files(origin));
    if let Some(survey) = &report.survey {
        page += &section("Coordinates and heights", &coordinates(survey, verdict.height_range));
        page += &section("Vertical error", &errors(report, survey, &unit));
        let worst = verdict.weighted_worst.map(|worst| worst.sample).or(verdict.worst);
        let worst = worst.map(|worst| (worst.place.column as usize, worst.place.row as usize));
        html::long_section(&mut page, "Maps", |page| maps::add_maps(page, survey, verdict.tolerance, worst, &unit));
        page += &section("Error by slope", &slopes(survey, &unit));
        if let Some(scene) = scene {
            let reference = &survey.raster.reference;
            let temp_dir = origin.temp_dir.as_deref();
            let drawn = Drawn { scene, reference, unit: &unit, survey: Some(survey), is_mailed: true, temp_dir };
            view::add_view(&mut page, &drawn)?;
        }
    }
    let counts = Counts {
        raster: verdict.samples,
        ground: verdict.checked,
        missing: verdict.nodata,
        filled: (verdict.bridged, verdict.bridged_holes),
        trimmed: report.trimmed_samples,
        isolated: report.isolated_samples,
    };
    page += &section("Ground", &ground(&counts));
    page += &section("Surface", &checks::checks(verdict));
    page += &section("Triangles", &triangles(report));
    if let Some(found) = &report.checkpoints {
        page += &section("Checkpoints", &checkpoints::checkpoints(found, &unit));
    }
    page += &section("Warnings", &warnings(&report.warnings));
    let is_georeferenced = reference.is_none_or(|reference| reference.georeferenced);
    let points = words::not_promised(report.checkpoints.is_some(), verdict.stray.is_some(), is_georeferenced);
    page += &section("What this does not say", &list(&points));
    page += &json(report, origin);
    html::end(&mut page, script);
    Ok(page)
}

/// The page of a mesh that was made.
///
/// # Errors
/// [`PageError`]: the mesh cannot be put into it.
pub fn of_run(report: &Report, origin: &Origin) -> Result<String, PageError> {
    made::page(report, origin)
}

/// The page of a mesh that was read to be looked at.
///
/// # Errors
/// [`PageError`]: the mesh cannot be put into it.
pub fn of_mesh(report: &SceneReport, mesh: &Path, temp_dir: Option<&Path>) -> Result<String, PageError> {
    opened::page(report, mesh, temp_dir)
}

/// Writes a page to a file, whole or not at all. `inputs` are files that it may not replace.
///
/// # Errors
/// [`OutputError`].
pub fn write(page: &str, path: &Path, overwrite: bool, inputs: &[&Path]) -> Result<(), OutputError> {
    let mut staged = StagedFile::create(path, overwrite, inputs)?;
    let written = staged.file().write_all(page.as_bytes());
    written.map_err(|source| staged.write_error(source))?;
    staged.commit()
}

fn heading(title: &str, passed: bool, sentence: &str) -> String {
    let (class, word) = if passed { ("pass", "PASS") } else { ("fail", "FAIL") };
    format!("<h1>{title}</h1>\n<p class=\"verdict {class}\"><b>{word}</b>{}</p>\n", text(sentence))
}

fn files(origin: &Origin) -> String {
    let file = |path: &Path| {
        let name = text(&path.display().to_string());
        match hash::fingerprint(path) {
            Some((size, sha)) => {
                format!("<code>{name}</code><br><small>{}, SHA-256 <code>{sha}</code></small>", BinaryBytes(size))
            }
            None => {
                format!("<code>{name}</code><br><small>no single file of this machine, so without a checksum</small>")
            }
        }
    };
    facts(&[
        ("Raster", file(&origin.raster)),
        ("Mesh", file(&origin.mesh)),
        ("Command", format!("<code>{}</code>", text(&origin.command.join(" ")))),
        ("Program", format!("terrabite {}", env!("CARGO_PKG_VERSION"))),
        ("Made", text(&origin.made)),
    ])
}

fn coordinates(survey: &Survey, range: Option<[f64; 2]>) -> String {
    let raster = &survey.raster;
    let mut rows = words::reference_rows(&raster.reference);
    rows.push(("Samples", format!("{} × {}", grouped(raster.width as u64), grouped(raster.height as u64))));
    if let Some((across, down)) = raster.cell_metres {
        rows.push(("Cell", format!("{} × {} m, in the middle", numbers::figure(across), numbers::figure(down))));
    }
    let [left, bottom, right, top] =
        raster.extent.map(|number| numbers::coordinate(number, raster.reference.geographic));
    rows.push(("Extent of the samples", format!("x {left} to {right}, y {bottom} to {top}")));
    if let Some([low, high]) = range {
        let unit = unit_of(&raster.reference);
        rows.push(("Heights", format!("{}{unit} to {}{unit}", Decimal(low), Decimal(high))));
    }
    facts(&rows)
}

fn errors(report: &VerifyReport, survey: &Survey, unit: &str) -> String {
    let verdict = &report.verdict;
    let number = |number: f64| format!("{}{}", numbers::figure(number), text(unit));
    let mut rows = vec![("Tolerance", format!("{}{}", Decimal(verdict.tolerance), text(unit)))];
    if let Some(worst) = &verdict.worst {
        let place = worst.place;
        let at = words::place(place.x, place.y, place.column, place.row, &survey.raster.reference);
        let heights =
            format!("raster {}, mesh {}", numbers::figure(worst.raster_height), numbers::figure(worst.surface_height));
        let class = if verdict.above_tolerance.count > 0 { "bad" } else { "good" };
        let error = format!("<span class=\"{class}\">{}{}</span>", Decimal(worst.error), text(unit));
        rows.push(("Largest error", format!("{error}<br><small>at {}: {heights}</small>", text(&at))));
    }
    if let Some(worst) = &verdict.weighted_worst {
        rows.push(("Largest error × weight", Decimal(worst.weighted_error).to_string()));
    }
    rows.push(("Root of the mean square", number(verdict.rms_error)));
    rows.push(("Mean, mesh less raster", number(survey.mean_error)));
    let measured = survey.measured;
    let share = |count: u64| format!("{} samples, {}", grouped(count), percent(count, measured));
    rows.push(("Above the tolerance", share(verdict.above_tolerance.count)));
    rows.push(("Above 0.9 of it", share(survey.above_nine_tenths)));
    let shares = [
        ("50 %", survey.p50),
        ("90 %", survey.p90),
        ("95 %", survey.p95),
        ("99 %", survey.p99),
        ("100 %", survey.p100),
    ];
    let shares: Vec<Vec<String>> = shares.iter().map(|(name, at)| vec![name.to_string(), number(*at)]).collect();
    let weighted = if verdict.weighted { " Here the distance counts times the weight of the sample." } else { "" };
    let (brackets, tolerance) = (words::in_brackets(unit), verdict.tolerance);
    let histogram = figure(
        "Signed errors",
        &charts::signed_errors(&survey.signed_errors, tolerance, &brackets),
        "Above 0 the mesh is higher than the raster. The first and the last bar hold what is beyond the tolerance.",
    );
    let curve = figure(
        "Cumulative curve",
        &charts::cumulative(&survey.cumulative, tolerance, true, &brackets),
        &format!(
            "The share of the samples whose distance is at most so large. The dots are at 50, 90, 95 and 99 %.{weighted}"
        ),
    );
    let shares = html::table(&["of the samples", "at most"], &[false, true], &shares);
    format!(
        "<div class=\"grid\"><div>{}</div><div>{shares}</div></div>\n<div class=\"grid\">{histogram}{curve}</div>\n",
        facts(&rows)
    )
}

fn slopes(survey: &Survey, unit: &str) -> String {
    let all: u64 = survey.slopes.iter().map(|class| class.samples).sum();
    let ends = survey.slopes.iter().skip(1).map(|class| Some(class.from_degrees)).chain([None]);
    let rows: Vec<Vec<String>> = survey
        .slopes
        .iter()
        .zip(ends)
        .map(|(class, end)| {
            let name = match end {
                Some(end) => format!("{}° to {end}°", class.from_degrees),
                None => format!("{}° and steeper", class.from_degrees),
            };
            let samples = [grouped(class.samples), percent(class.samples, all)];
            let figures = [class.rms, class.max].map(|number| format!("{}{}", numbers::figure(number), text(unit)));
            [name].into_iter().chain(samples).chain(figures).chain([grouped(class.above_tolerance)]).collect()
        })
        .collect();
    let titles = ["slope of the ground", "samples", "share", "RMS error", "largest", "above the tolerance"];
    let table = html::table(&titles, &[false, true, true, true, true, true], &rows);
    let scale = match survey.raster.cell_metres {
        Some(_) => "The slope is that of the raster, from the samples beside and above each.",
        None => {
            "The slope is that of the raster, from the samples beside and above each. The raster does not say how long a unit of x and \
             y is: it was taken for a unit of heights."
        }
    };
    format!("<p>{scale}</p>\n{table}")
}

/// How many samples of a raster are what.
struct Counts {
    raster: u64,
    ground: u64,
    missing: u64,
    /// Samples of filled voids, and voids.
    filled: (u64, u64),
    trimmed: u64,
    isolated: u64,
}

fn ground(counts: &Counts) -> String {
    let samples = |count: u64| format!("{} ({})", grouped(count), percent(count, counts.raster));
    let (filled, voids) = counts.filled;
    facts(&[
        ("Samples of the raster", grouped(counts.raster)),
        ("On the ground, with a height", samples(counts.ground)),
        ("Missing: nodata, masked, outside of a cutline", samples(counts.missing)),
        ("In filled voids", format!("{} in {} voids", samples(filled), grouped(voids))),
        ("On the trimmed rim, left uncovered", samples(counts.trimmed)),
        ("Isolated, in no cell with three heights", samples(counts.isolated)),
    ])
}

fn triangles(report: &VerifyReport) -> String {
    let verdict = &report.verdict;
    let per_triangle = verdict.checked as f64 / verdict.triangles.max(1) as f64;
    let mut rows = vec![
        ("Triangles", grouped(verdict.triangles)),
        ("Vertices", grouped(verdict.vertices)),
        ("Samples for each triangle", numbers::figure(per_triangle)),
    ];
    match &verdict.stray {
        None => rows.push(("Between samples", "not judged".to_string())),
        Some(stray) => {
            let farthest = stray.worst.map_or("nowhere beyond the heights around".to_string(), |worst| {
                let at =
                    worst.tolerances.map_or(String::new(), |t| format!(", {} × the tolerance", numbers::figure(t)));
                format!(
                    "at most {} beyond the heights around{at}, at x {}, y {}",
                    numbers::figure(worst.stray),
                    worst.x,
                    worst.y
                )
            });
            rows.push(("Between samples", format!("{farthest}; allowed are {} × the tolerance", stray.max_stray)));
        }
    }
    let angles = report.survey.as_ref().map_or(String::new(), |survey| angles(&survey.smallest_angles));
    format!("<div class=\"grid\"><div>{}</div>{angles}</div>\n", facts(&rows))
}

fn angles(counts: &[u64]) -> String {
    figure(
        "Smallest angles",
        &charts::angles(counts),
        "Triangles by their smallest angle, seen from above with square cells. 60° is an equilateral triangle.",
    )
}

fn warnings(warnings: &Warnings) -> String {
    let said: Vec<String> = warnings
        .iter()
        .map(|warning| {
            let times = if warning.count > 1 { format!(" ({} times)", grouped(warning.count)) } else { String::new() };
            format!("<code>{}</code>: {}{times}", text(&warning.file.display().to_string()), text(&warning.message))
        })
        .collect();
    if said.is_empty() { "<p>None.</p>\n".to_string() } else { list(&said) }
}

/// The report as JSON: to be seen, and for programs.
fn json(report: &impl serde::Serialize, origin: &Origin) -> String {
    #[derive(serde::Serialize)]
    struct Embedded<'a, R> {
        command: &'a [String],
        version: &'static str,
        #[serde(flatten)]
        report: &'a R,
    }
    let embedded = Embedded { command: &origin.command, version: env!("CARGO_PKG_VERSION"), report };
    let json = serde_json::to_string_pretty(&embedded).expect("a report has names of text and numbers");
    let shown = format!(
        "<details class=\"screen\"><summary>The report as JSON</summary>\n<pre>{}</pre></details>\n",
        text(&json)
    );
    let place = "<p class=\"soft\">The same figures, as JSON, are in this file, in the element with the id <code>report</code>.</p>\n";
    section("For programs", &format!("{place}{shown}")) + &html::embedded_json("report", &json)
}
