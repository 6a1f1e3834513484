//! What stands before the surface: units, CRS, project, application.

use super::text::{attribute, comment};
use crate::formats::Header;
use crate::formats::wording::one_line;

const ROOT: &str = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<LandXML xmlns=\"http://www.landxml.org/schema/LandXML-1.2\" \
                    xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" \
                    xsi:schemaLocation=\"http://www.landxml.org/schema/LandXML-1.2 \
                    http://www.landxml.org/schema/LandXML-1.2/LandXML-1.2.xsd\" version=\"1.2\" date=\"2000-01-01\" \
                    time=\"00:00:00\" readOnly=\"false\" language=\"English\">\n";

/// Everything before what the surface has.
pub(super) fn head(header: &Header) -> String {
    let mut head = ROOT.to_string();
    head.push_str(&units(header));
    head.push_str(&coordinate_system(header));
    let name = header.source.as_deref().unwrap_or("terrabite");
    head.push_str(&format!("<Project{}/>\n", named("name", name)));
    head.push_str(&application(header.made_by.as_deref()));
    let desc = "terrain, northing easting elevation";
    let surface = format!("<Surfaces>\n<Surface{}{}>\n", named("name", name), named("desc", desc));
    head.push_str(&surface);
    head
}

/// An attribute, with a blank before it.
fn named(name: &str, value: &str) -> String {
    format!(" {name}=\"{}\"", attribute(&one_line(value)))
}

/// A unit of length that LandXML has a word for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Length {
    Metre,
    Foot,
    UsSurveyFoot,
}

/// The unit of this name, as GDAL and rasters have it.
fn length(name: &str) -> Option<Length> {
    match name.to_ascii_lowercase().as_str() {
        "metre" | "meter" | "metres" | "meters" | "m" => Some(Length::Metre),
        "foot" | "feet" | "ft" | "international foot" => Some(Length::Foot),
        "us survey foot" | "us survey feet" | "foot_us" | "us-ft" | "ftus" => Some(Length::UsSurveyFoot),
        _ => None,
    }
}

/// Units of x and y are metres where LandXML has no word for them; a comment says so.
fn units(header: &Header) -> String {
    let is_scaled = header.frame.xy_scale != (1.0, 1.0);
    let known = header.crs.unit.as_deref().filter(|_| !is_scaled);
    let unit = known.map_or(Some(Length::Metre), length);
    let elevation = header.heights.unit.as_deref().and_then(length).filter(|_| header.frame.z_scale == 1.0);
    let elevation = match elevation {
        None => "",
        Some(Length::Metre) => " elevationUnit=\"meter\"",
        Some(Length::Foot | Length::UsSurveyFoot) => " elevationUnit=\"feet\"",
    };
    let imperial = |name| {
        format!(
            "<Imperial areaUnit=\"squareFoot\" linearUnit=\"{name}\" volumeUnit=\"cubicYard\" \
             temperatureUnit=\"fahrenheit\" pressureUnit=\"inchHG\"{elevation}/>"
        )
    };
    let units = match unit {
        Some(Length::Foot) => imperial("foot"),
        Some(Length::UsSurveyFoot) => imperial("USSurveyFoot"),
        Some(Length::Metre) | None => format!(
            "<Metric areaUnit=\"squareMeter\" linearUnit=\"meter\" volumeUnit=\"cubicMeter\" temperatureUnit=\"celsius\" \
             pressureUnit=\"milliBars\"{elevation}/>"
        ),
    };
    let note = match (unit, known) {
        (None, Some(name)) => comment(&one_line(&format!("x and y are in {name}, which LandXML has no word for"))),
        _ => String::new(),
    };
    format!("{note}<Units>{units}</Units>\n")
}

/// The CRS, where coordinates are those of the map.
fn coordinate_system(header: &Header) -> String {
    let crs = &header.crs;
    let Some(definition) = crs.definition.as_deref().filter(|_| !header.frame.is_local()) else {
        return String::new();
    };
    let name = crs.name.as_deref().map(|name| named("desc", name)).unwrap_or_default();
    let code =
        definition.strip_prefix("EPSG:").filter(|code| !code.is_empty() && code.bytes().all(|b| b.is_ascii_digit()));
    let definition = match code {
        Some(code) => named("epsgCode", code),
        None if definition.contains('[') => named("ogcWktCode", definition),
        // The code of another authority, for which there is no word.
        None => String::new(),
    };
    let vertical = header.heights.crs.as_deref().map(|name| named("verticalDatum", name)).unwrap_or_default();
    format!("<CoordinateSystem{name}{definition}{vertical}/>\n")
}

/// The program and its version, which is the last word.
fn application(made_by: Option<&str>) -> String {
    let program = made_by.unwrap_or("terrabite");
    let (name, version) = program.rsplit_once(' ').map_or((program, None), |(name, version)| (name, Some(version)));
    let version = version.map(|version| named("version", version)).unwrap_or_default();
    format!("<Application{}{version}/>\n", named("name", name))
}
