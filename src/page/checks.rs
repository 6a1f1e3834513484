//! What was checked of a mesh, and what was found.

use std::fmt::Display;

use super::html::{table, text};
use crate::run::report::grouped;
use crate::verify::{Finding, Verdict};

/// Every check as a line: what is counted, how many there are, and where the first is.
pub(super) fn checks(verdict: &Verdict) -> String {
    let mut rows = vec![
        row("Samples above the tolerance", &verdict.above_tolerance),
        row("Samples of the ground in no triangle", &verdict.uncovered),
        row("Samples in several triangles", &verdict.overlapped),
        row("Missing samples under a triangle", &verdict.touched_nodata),
        row(
            "Edges open inside the ground, or off its boundary (cracks, T-junctions, seams that do not meet)",
            &verdict.unmatched_edges,
        ),
        row("Edges of more than two triangles", &verdict.overused_edges),
        row("Edges that fold the surface over", &verdict.same_direction_edges),
        row("Parts of the ground's boundary that the mesh does not follow", &verdict.boundary_gaps),
        row("Parts of it that several edges follow", &verdict.boundary_doubled),
        row("Triangles that turn clockwise", &verdict.clockwise),
        row("Triangles without an area", &verdict.degenerate),
        row("Triangles with a corner nowhere near the raster", &verdict.unplaced),
        row("Vertices at the place of another", &verdict.duplicate_vertices),
        row("Vertices in no triangle", &verdict.unused_vertices),
        row("Vertices off the raster's grid of quarter cells", &verdict.off_lattice),
        row("Vertices outside of the raster", &verdict.outside),
        row("Vertices without a finite height", &verdict.heights_not_finite),
    ];
    if let Some(stray) = &verdict.stray {
        rows.push(row("Places between samples beyond the limit on straying", &stray.beyond));
    }
    if let Some(extended) = &verdict.extended {
        rows.push(row("Samples above the tolerance in heights and attributes together", &extended.above_tolerance));
    }
    if let Some(lines) = &verdict.lines {
        let what = format!(
            "Stretches of breaklines that no edges follow, of {} ({} segments, {} of them off the ground)",
            grouped(lines.stretches),
            grouped(lines.segments),
            grouped(lines.off_ground)
        );
        rows.push(row(&what, &lines.broken));
    }
    if let Some(trim) = &verdict.trim {
        rows.extend([
            row("Ground left bare farther from missing samples than the trim allows", &trim.bare_core),
            row("Triangles beyond the ground", &trim.beyond_ground),
            row("Edges of the trimmed rim that cross or lie on each other", &trim.crossed_edges),
            row("Edges of the rim with several triangles upon each other", &trim.overlapping_edges),
            row("Bare ground that is enclosed by triangles", &trim.enclosed),
        ]);
    }
    let (found, least) =
        (verdict.double_area, verdict.trim.map_or(verdict.expected_double_area, |t| t.core_double_area));
    let area = if (least..=verdict.expected_double_area).contains(&found) { "equal" } else { "different" };
    let class = if area == "equal" { "good" } else { "bad" };
    let area = format!("<span class=\"{class}\">{area}</span>");
    let words =
        format!("twice, in squared quarter cells: {found} of the mesh, {} of the ground", verdict.expected_double_area);
    rows.push(vec!["Area of the mesh against that of the ground".to_string(), area, words]);
    table(&["checked", "found", "first place"], &[false, true, false], &rows)
}

fn row<P: Display>(what: &str, finding: &Finding<P>) -> Vec<String> {
    let class = if finding.count == 0 { "good" } else { "bad" };
    let place = finding.first.as_ref().map_or(String::new(), |first| text(&first.to_string()));
    vec![text(what), format!("<span class=\"{class}\">{}</span>", grouped(finding.count)), place]
}
