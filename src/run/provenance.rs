//! Where a mesh comes from: what identifies a job, and what its file says of itself.

use std::path::Path;

use super::attributes::Ranged;
use super::coordinates::Written;
use super::{HeightSource, Request};
#[cfg(feature = "gdal")]
use super::{Input, PointInput};
use crate::base::{Band, LineKind, said};
use crate::formats::{Crs, Header, Heights, OptionName, RunOption};
use crate::job::Params;

/// What decides the bytes of a tile and is not told by the rasters' identities, by name.
pub(super) fn named(
    request: &Request<'_>,
    params: &Params,
    band: &Band,
    attributes: Option<&Ranged<'_>>,
) -> Vec<(&'static str, String)> {
    let mut named = params.named();
    named.extend(said(band));
    named.extend((request.fill_voids > 0).then(|| ("fill holes", request.fill_voids.to_string())));
    named.extend(attributes.into_iter().flat_map(Ranged::named));
    named
}

/// What the output says of itself.
pub(super) fn header(request: &Request<'_>, band: &Band, written: &Written, attributes: Option<&Ranged<'_>>) -> Header {
    let reference = band.reference();
    let said = |text: &String| Some(text.clone()).filter(|text| !text.is_empty());
    Header {
        made_by: Some(format!("terrabite {}", env!("CARGO_PKG_VERSION"))),
        source: Some(name(band.path())),
        crs: Crs {
            definition: band.crs_definition().map(str::to_string),
            name: Some(reference.crs.clone()),
            esri_wkt: band.esri_wkt.clone(),
            unit: said(&reference.unit),
            metres: reference.metres,
        },
        heights: Heights { crs: said(&reference.vertical_crs), unit: said(&reference.height_unit) },
        frame: written.frame,
        window: band.window,
        tolerance: Some(request.params.tolerance.asked()).filter(|asked| asked.is_finite()),
        options: options(request, band, attributes),
        notes: Vec::new(),
    }
}

/// What else was asked for and decides the mesh, in a fixed order.
fn options(request: &Request<'_>, band: &Band, attributes: Option<&Ranged<'_>>) -> Vec<RunOption> {
    let goal = request.params.goal;
    let mut options = Vec::new();
    let mut say = |name, value: Option<String>| options.extend(value.map(|value| RunOption::new(name, value)));
    say(OptionName::MaxRms, goal.max_rms.map(|rms| rms.to_string()));
    say(OptionName::MaxPoints, goal.max_points.map(|most| most.to_string()));
    say(OptionName::MaxTriangles, goal.max_triangles.map(|most| most.to_string()));
    say(OptionName::Encoding, band.encoding.map(|encoding| encoding.name().to_string()));
    #[cfg(feature = "gdal")]
    if let Input::Raster { view, .. } = &request.input {
        view.open_options.iter().for_each(|option| say(OptionName::OpenOption, Some(option.clone())));
    }
    band.nodata_words().iter().for_each(|value| say(OptionName::Nodata, Some(value.clone())));
    say(OptionName::ValidRange, band.marks().valid.map(|valid| format!("{},{}", valid.min, valid.max)));
    say(OptionName::FillHoles, Some(request.fill_voids).filter(|most| *most > 0).map(|most| most.to_string()));
    #[cfg(feature = "gdal")]
    if let Input::Raster { view, .. } = &request.input
        && let Some(cutline) = &view.cutline
    {
        say(OptionName::Cutline, Some(name(&cutline.path)));
        say(OptionName::CutlineLayer, cutline.layer.clone());
    }
    say(OptionName::Trim, Some(request.params.trim).filter(|cells| *cells > 0).map(|cells| cells.to_string()));
    say(OptionName::Importance, request.importance.as_ref().map(|input| name(input.path())));
    #[cfg(feature = "gdal")]
    if let Some(PointInput::Layer(source)) = &request.points {
        say(OptionName::Points, Some(name(&source.path)));
    }
    for lines in &request.lines {
        let (file, layer) = match lines.kind {
            LineKind::Breaklines => (OptionName::Breaklines, OptionName::BreaklinesLayer),
            LineKind::Lakes => (OptionName::LakePolygons, OptionName::LakePolygonsLayer),
            LineKind::Footprints => (OptionName::Footprints, OptionName::FootprintsLayer),
            LineKind::Cutline => (OptionName::CutlineExact, OptionName::CutlineExactLayer),
        };
        say(file, lines.file().map(name));
        say(layer, lines.layer().map(str::to_string));
    }
    let shifted = request.lines.iter().find(|lines| !lines.kind.has_inside());
    say(OptionName::BreaklineShift, shifted.map(|lines| lines.shift.to_string()));
    let own = request.lines.iter().find(|lines| matches!(lines.heights, HeightSource::Own | HeightSource::Field(_)));
    say(OptionName::BreaklineZ, own.map(|lines| lines.heights.name()));
    let lakes = request.lines.iter().find(|lines| lines.kind == LineKind::Lakes);
    say(OptionName::LakeZ, lakes.map(|lines| lines.heights.name()));
    options.extend(attributes.map(Ranged::option));
    options
}

/// What a file is called, without its folders.
fn name(path: &Path) -> String {
    path.file_name().map_or(path, Path::new).display().to_string()
}
