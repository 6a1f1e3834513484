//! What the variables of a UGRID file are called, and what they say of themselves.

use super::netcdf::{Said, Type, Value, Variable};
use crate::base::CoordinateFrame;
use crate::base::channels::{Channel, Number};
use crate::formats::Header;
use crate::formats::wording::{facts, one_line};

/// The variable that has the CRS, under the name by which MDAL (QGIS) finds it.
const REFERENCE: &str = "projected_coordinate_system";

/// Dimensions, by number.
const NODES: usize = 0;
const FACES: usize = 1;
const CORNERS: usize = 2;

/// What the file says of itself.
pub(super) fn file(header: &Header) -> Said {
    let mut said = vec![("Conventions", text("CF-1.8 UGRID-1.0"))];
    let title = header.source.as_ref().map_or("TIN".to_string(), |source| format!("TIN of {}", one_line(source)));
    said.push(("title", text(title)));
    said.extend(header.made_by.iter().map(|program| ("source", text(one_line(program)))));
    said.push(("terrabite", text(facts(header).join("\n"))));
    said
}

/// The variable that says what of the file is a mesh.
pub(super) fn topology(number: Type) -> Variable {
    let said = vec![
        ("cf_role", text("mesh_topology")),
        ("long_name", text("triangulated surface")),
        ("topology_dimension", Value::Int(2)),
        ("node_coordinates", text("mesh2d_node_x mesh2d_node_y")),
        ("face_node_connectivity", text("mesh2d_face_nodes")),
        ("face_dimension", text("mesh2d_nFaces")),
    ];
    Variable { name: "mesh2d".to_string(), number, dimensions: Vec::new(), said }
}

/// The CRS of coordinates on the map. Where they are less an origin or scaled, programs would draw the mesh in the wrong
/// place, so then they are not to find one.
pub(super) fn reference(header: &Header, number: Type) -> Option<Variable> {
    let definition = header.crs.definition.as_ref().filter(|_| !header.frame.is_local())?;
    let mut said = Vec::new();
    if is_geographic(header) {
        said.push(("grid_mapping_name", text("latitude_longitude")));
    }
    said.extend(header.crs.name.iter().map(|name| ("long_name", text(one_line(name)))));
    let code = definition.strip_prefix("EPSG:").and_then(|code| code.parse().ok());
    said.extend(code.map(|code| ("epsg", Value::Int(code))));
    if definition.contains(['[', '(']) {
        // CF's name for it, and MDAL's.
        said.extend(["crs_wkt", "wkt"].map(|name| (name, text(one_line(definition)))));
    } else {
        said.push(("EPSG_code", text(one_line(definition))));
    }
    Some(Variable { name: REFERENCE.to_string(), number, dimensions: Vec::new(), said })
}

/// x, y and height. uxarray 2026.10.0 takes an x without a unit and a standard name for degrees, so both are always there.
pub(super) fn places(header: &Header, number: Type) -> [Variable; 3] {
    let is_geographic = is_geographic(header) && !header.frame.is_local();
    let is_scaled = header.frame.xy_scale != CoordinateFrame::PLAIN.xy_scale;
    let unit = if is_scaled { "m".to_string() } else { unit(header.crs.unit.as_deref()) };
    let [x, y] = match is_geographic {
        true => [("longitude", "degrees_east".to_string()), ("latitude", "degrees_north".to_string())],
        false => [("projection_x_coordinate", unit.clone()), ("projection_y_coordinate", unit)],
    };
    let place = |axis: &str, (name, unit): (&'static str, String)| {
        let said = vec![
            ("standard_name", text(name)),
            ("long_name", text(format!("{axis} of nodes"))),
            ("units", text(unit)),
            ("mesh", text("mesh2d")),
            ("location", text("node")),
        ];
        Variable { name: format!("mesh2d_node_{axis}"), number, dimensions: vec![NODES], said }
    };
    let mut height = place("z", ("altitude", self::unit(header.heights.unit.as_deref())));
    let is_plain = header.frame.z_scale == CoordinateFrame::PLAIN.z_scale;
    let meaning = if is_plain { "height of nodes" } else { "height of nodes, scaled" };
    height.said[1].1 = text(meaning);
    height.said.push(("positive", text("up")));
    height.said.extend(mapping(header));
    [place("x", x), place("y", y), height]
}

/// An attribute of vertices.
pub(super) fn attribute(header: &Header, Channel { name, number: asked }: &Channel, number: Type) -> Variable {
    let mut said = vec![("long_name", text(name)), ("mesh", text("mesh2d")), ("location", text("node"))];
    if *asked == Number::U8 {
        said.push(("original_type", text("ubyte")));
    }
    said.extend(mapping(header));
    said.push(("coordinates", text("mesh2d_node_x mesh2d_node_y")));
    // The mesh has names of its own.
    let is_taken = ["mesh2d", "attribute_", REFERENCE, "Three"].iter().any(|taken| name.starts_with(taken));
    let name = if is_taken { format!("attribute_{name}") } else { name.clone() };
    Variable { name, number, dimensions: vec![NODES], said }
}

/// The corners of faces.
pub(super) fn faces(number: Type) -> Variable {
    let said = vec![
        ("cf_role", text("face_node_connectivity")),
        ("long_name", text("nodes of faces, counter-clockwise from above")),
        ("start_index", Value::Int(0)),
    ];
    Variable { name: "mesh2d_face_nodes".to_string(), number, dimensions: vec![FACES, CORNERS], said }
}

fn mapping(header: &Header) -> Option<(&'static str, Value)> {
    let has_reference = reference(header, Type::Int).is_some();
    has_reference.then(|| ("grid_mapping", text(REFERENCE)))
}

fn is_geographic(header: &Header) -> bool {
    header.crs.unit.as_deref().is_some_and(|unit| unit.to_ascii_lowercase().starts_with("degree"))
}

/// A unit as UDUNITS, which NetCDF goes by, has it; metres where none is known.
fn unit(name: Option<&str>) -> String {
    let name = one_line(name.unwrap_or("m"));
    match name.trim().to_ascii_lowercase().as_str() {
        "" | "m" | "metre" | "meter" | "metres" | "meters" => "m".to_string(),
        "ft" | "foot" | "feet" | "international foot" => "foot".to_string(),
        "us survey foot" | "foot_us" | "us-ft" | "ftus" => "US_survey_foot".to_string(),
        _ => name.trim().replace(' ', "_"),
    }
}

fn text(text: impl Into<String>) -> Value {
    Value::Text(text.into())
}
