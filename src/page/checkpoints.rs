//! Checkpoints on a page.

use super::html::{list, table, text};
use super::numbers::figure;
use crate::base::decimal::Decimal;
use crate::run::checkpoints::{CheckpointReport, Cover, Residuals};
use crate::run::report::grouped;

/// The chapter's text: residuals, accuracy by the standard, the worst.
pub(super) fn checkpoints(report: &CheckpointReport, unit: &str) -> String {
    let off = match report.off_mesh {
        0 => "all of them on the mesh".to_string(),
        count => {
            format!("<span class=\"warn\">{} of them not on the mesh, and not counted below</span>", grouped(count))
        }
    };
    let crs = report.crs.as_ref().map_or("the raster's CRS".to_string(), |crs| text(crs));
    let mut out = format!(
        "<p>{} checkpoints from <code>{}</code> in {crs}, {off}. A residual is the height of the mesh less that of the checkpoint, in \
         the unit of the raster's heights; heights of the table are taken to refer to the raster's vertical datum.</p>\n",
        grouped(report.read),
        text(&report.file)
    );
    let kinds = [("all", report.all), ("not vegetated (N)", report.non_vegetated), ("vegetated (V)", report.vegetated)];
    let rows: Vec<Vec<String>> =
        kinds.iter().filter_map(|(name, residuals)| Some(figures(name, residuals.as_ref()?))).collect();
    let titles = ["checkpoints", "n", "mean", "median", "RMSE", "std. dev.", "95 % |r|", "max |r|"];
    out += &table(&titles, &[false, true, true, true, true, true, true, true], &rows);
    out += &accuracy(report, unit);
    let rows: Vec<Vec<String>> = report
        .worst
        .iter()
        .map(|worst| {
            let cover = match worst.cover {
                None => "",
                Some(Cover::NonVegetated) => "N",
                Some(Cover::Vegetated) => "V",
            };
            // As they stand in the table.
            let [x, y] = [worst.x, worst.y].map(|number| Decimal(number).to_string());
            let heights = [worst.z, worst.surface, worst.residual].map(figure);
            let [z, surface, residual] = heights;
            vec![text(&worst.id), x, y, z, surface, residual, cover.to_string()]
        })
        .collect();
    let titles = ["worst", "x", "y", "z", "mesh", "residual", "cover"];
    out + &table(&titles, &[false, true, true, true, true, true, false], &rows)
}

fn figures(name: &str, residuals: &Residuals) -> Vec<String> {
    let Residuals { count, mean, median, rmse, standard_deviation, p95, max } = *residuals;
    let numbers = [mean, median, rmse, standard_deviation, p95, max].map(figure);
    [name.to_string(), grouped(count)].into_iter().chain(numbers).collect()
}

/// NVA and VVA, and how far to trust them.
fn accuracy(report: &CheckpointReport, unit: &str) -> String {
    let mut points = Vec::new();
    if let Some(nva) = report.nva {
        points.push(format!(
            "<b>NVA {}{unit}</b>: non-vegetated vertical accuracy at 95 % confidence, 1.96 × RMSE (ASPRS 2014; it supposes errors \
             with a normal distribution)",
            figure(nva)
        ));
    }
    if let Some(vva) = report.vva {
        points.push(format!(
            "<b>VVA {}{unit}</b>: vegetated vertical accuracy, the 95th percentile of absolute residuals (ASPRS 2014)",
            figure(vva)
        ));
    }
    if points.is_empty() {
        return "<p>The table does not say what covers the ground (a column <code>cover</code> with N or V), so there is neither NVA \
                nor VVA.</p>\n"
            .to_string();
    }
    points.push(
        "The edition of 2023 states the RMSE itself, together with that of the checkpoints' own survey".to_string(),
    );
    if let Some(few) = report.non_vegetated.map(|residuals| residuals.count).filter(|count| *count < 30) {
        points.push(format!(
            "<span class=\"warn\">{few} checkpoints that are not vegetated are few: the standard asks for 20 at least, since 2023 for \
             30</span>"
        ));
    }
    list(&points)
}
