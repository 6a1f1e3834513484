//! The page of a mesh that was read to be looked at: what the file says of itself, and the view.

use std::path::Path;

use super::html::{self, facts, list, section, text};
use super::view::{self, Drawn, SCRIPT};
use super::{PageError, hash, numbers, words};
use crate::base::{Metres, Reference};
use crate::formats::Header;
use crate::raster::metres_of;
use crate::run::report::{BinaryBytes, grouped};
use crate::run::scene::SceneReport;

pub(super) fn page(report: &SceneReport, mesh: &Path, temp_dir: Option<&Path>) -> Result<String, PageError> {
    let SceneReport { scene, header, format, vertices, bounds } = report;
    let reference = reference(header);
    let unit = words::unit_of(&reference);
    let name = mesh.file_name().map_or_else(|| mesh.display().to_string(), |name| name.to_string_lossy().into_owned());
    let mut rows = vec![("File", format!("<code>{}</code>", text(&mesh.display().to_string())))];
    if let Some((size, sha)) = hash::fingerprint(mesh) {
        rows.push(("Size", BinaryBytes(size).to_string()));
        rows.push(("SHA-256", format!("<code>{sha}</code>")));
    }
    rows.push(("Format", text(format.title)));
    rows.push(("Triangles", grouped(scene.of)));
    rows.push(("Vertices", grouped(*vertices)));
    if *vertices > 0 {
        let coordinate = |number: f64| numbers::coordinate(number, reference.geographic);
        let ([left, bottom, low], [right, top, high]) = (bounds.min, bounds.max);
        let [left, bottom, right, top] = [left, bottom, right, top].map(coordinate);
        rows.push(("Extent", format!("x {left} to {right}, y {bottom} to {top}")));
        rows.push(("Heights", format!("{}{unit} to {}{unit}", numbers::figure(low), numbers::figure(high))));
    }
    let said = |name, value: &Option<String>| value.as_ref().map(|value| (name, text(value)));
    rows.extend(said("CRS", &header.crs.name));
    rows.extend(said("Vertical datum", &header.heights.crs));
    rows.extend(said("Unit of heights", &header.heights.unit));
    rows.extend(said("Made from", &header.source));
    rows.extend(said("Made by", &header.made_by));
    rows.extend(
        header.tolerance.map(|tolerance| ("Tolerance that it names", format!("{}{unit}", numbers::figure(tolerance)))),
    );
    let points = ["Nothing is judged here, the tolerance that the file names least of all: <code>terrabite verify</code> does that."
        .to_string()];
    let scene = view::drawable(Some(scene));
    let script = scene.map(|_| SCRIPT);
    let mut page = html::begin(&name, script);
    page += &format!("<h1>{}</h1>\n", text(&name));
    if let Some(scene) = scene {
        let drawn = Drawn { scene, reference: &reference, unit: &unit, survey: None, is_mailed: false, temp_dir };
        view::add_view(&mut page, &drawn)?;
    }
    page += &section("The file", &facts(&rows));
    page += &section("What this does not say", &list(&points));
    html::end(&mut page, script);
    Ok(page)
}

/// What coordinates and heights are in, as far as the file says.
fn reference(header: &Header) -> Reference {
    let metres = header.crs.metres.or_else(|| metres_of(header.crs.definition.as_deref()?));
    Reference {
        crs: header.crs.name.clone().unwrap_or_else(|| "none".to_string()),
        georeferenced: true,
        geographic: matches!(metres, Some(Metres::OnEllipsoid { .. })),
        metres,
        vertical_crs: header.heights.crs.clone().unwrap_or_default(),
        height_unit: header.heights.unit.clone().unwrap_or_default(),
        ..Reference::none()
    }
}
