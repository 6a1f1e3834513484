//! What a verdict, a promise and a CRS are in words.

use super::html::text;
use super::numbers::coordinate;
use crate::base::Reference;
use crate::base::decimal::Decimal;
use crate::run::VerifyReport;
use crate::run::report::grouped;

/// " m", or nothing where the unit of heights is not known: what stands after a number. A raster may say anything: no character of it
/// means something in HTML.
pub(super) fn unit_of(reference: &Reference) -> String {
    match reference.height_unit.as_str() {
        "" => String::new(),
        "metre" | "meter" | "metres" | "meters" | "m" => " m".to_string(),
        unit => format!(" {}", unit.replace(['<', '>', '&', '"', '\''], "")),
    }
}

/// A place on the map.
pub(super) fn place(x: f64, y: f64, column: u64, row: u64, reference: &Reference) -> String {
    let [x, y] = [x, y].map(|number| coordinate(number, reference.geographic));
    let (x, y) = if reference.geographic {
        (format!("longitude {x}"), format!("latitude {y}"))
    } else {
        (format!("x {x}"), format!("y {y}"))
    };
    format!("{x}, {y} (column {column}, row {row})")
}

/// What coordinates and heights are in, as rows of a table.
pub(super) fn reference_rows(reference: &Reference) -> Vec<(&'static str, String)> {
    let not_said = || "<span class=\"warn\">not said by the raster</span>".to_string();
    let said = |words: &str| if words.is_empty() { not_said() } else { text(words) };
    let crs = match reference.crs.as_str() {
        "none" => not_said(),
        crs => text(crs),
    };
    let place = if reference.georeferenced {
        String::new()
    } else {
        " (no geotransform: coordinates count pixels)".to_string()
    };
    vec![
        ("CRS", format!("{crs}{place}")),
        ("Unit of x and y", said(&reference.unit)),
        ("Vertical datum", said(&reference.vertical_crs)),
        ("Unit of heights", said(&reference.height_unit)),
    ]
}

/// The verdict in a sentence.
pub(super) fn verdict(report: &VerifyReport, unit: &str) -> String {
    let verdict = &report.verdict;
    let tolerance = format!("{}{unit}", Decimal(verdict.tolerance));
    let samples = grouped(verdict.checked);
    let what = if verdict.weighted { "error × weight" } else { "vertical distance" };
    if !report.passed {
        let kinds = report.failures.len();
        let kinds = if kinds == 1 { "one kind of fault".to_string() } else { format!("{kinds} kinds of faults") };
        return format!("The mesh does not keep what was asked for: {kinds}, listed below.");
    }
    let trimmed = match report.trimmed_samples {
        0 => String::new(),
        count => format!(" ({} samples near missing ones are left uncovered, as the options allow)", grouped(count)),
    };
    format!(
        "At every one of {samples} samples of the ground the mesh is within {tolerance} ({what}){trimmed}, and it covers \
         the ground once, without cracks or overlaps.{}{}",
        between(report, unit),
        report.verdict.lines.as_ref().map_or("", |_| " Its edges follow all breaklines.")
    )
}

/// What was asked for between samples, in a sentence; nothing where that was not judged.
fn between(report: &VerifyReport, unit: &str) -> String {
    report.verdict.stray.as_ref().map_or(String::new(), |stray| {
        let limit = Decimal(stray.limit);
        format!(
            " Between samples it is at most {limit}{unit} ({} × the tolerance) beyond the heights around.",
            stray.max_stray
        )
    })
}

/// What the page does not say, for a mesh that was judged.
pub(super) fn not_promised(has_checkpoints: bool, has_strays: bool, is_georeferenced: bool) -> Vec<String> {
    let mut points = vec![
        "The error is the vertical distance between the mesh and <em>this raster</em>. How well the raster itself agrees with the \
         ground is another question"
            .to_string()
            + if has_checkpoints {
                "; the checkpoints above answer it as far as they go."
            } else {
                ", which takes checkpoints (<code>--checkpoints</code>)."
            },
    ];
    points.push(match has_strays {
        true => "Between samples the surface is held to the limit on straying, and to nothing else.".to_string(),
        false => "Between samples nothing was judged: <code>--max-stray</code> does that.".to_string(),
    });
    points.push(
        "Horizontal accuracy is not judged: vertices lie at samples of the raster, or between them on quarters of its cells. How far \
         edges are from breaklines is judged where these are given."
            .to_string(),
    );
    if is_georeferenced {
        points.push(
            "CRS, vertical datum and units are what the raster says of itself. Nobody has checked that it is right."
                .to_string(),
        );
    }
    points.push(
        "The figures are those of the two files with the checksums above. A mesh that is converted, moved into another CRS or \
         simplified again is another mesh."
            .to_string(),
    );
    points
}

/// A unit as it stands behind the title of an axis: " (m)".
pub(super) fn in_brackets(unit: &str) -> String {
    if unit.is_empty() { String::new() } else { format!(" ({})", unit.trim()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_unit_is_no_markup() {
        let unit = |name: &str| unit_of(&Reference { height_unit: name.to_string(), ..Reference::none() });
        assert_eq!([unit(""), unit("metre"), unit("US survey foot")], ["", " m", " US survey foot"]);
        assert_eq!(unit("<b onclick='x'>&m"), " b onclick=xm");
        assert_eq!(in_brackets(&unit("metre")), " (m)");
    }
}
