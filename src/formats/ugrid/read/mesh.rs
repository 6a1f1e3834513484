//! Where in a NetCDF file the mesh is: the variables of its nodes and faces.

use std::collections::HashSet;
use std::path::Path;

use super::UgridError;
use super::head::{Head, Said, Value, Variable};
use super::values::Type;
use crate::base::channels::{Channel, Number};
use crate::formats::{Crs, Header, lines};

/// The variables of a mesh.
#[derive(Debug, Clone)]
pub(super) struct Mesh {
    pub(super) nodes: u64,
    pub(super) faces: u64,
    /// x, y, height.
    pub(super) places: [Values; 3],
    /// What nodes have beside them, as many as [`Mesh::values`].
    pub(super) attributes: Vec<Channel>,
    pub(super) values: Vec<Values>,
    pub(super) corners: Corners,
    pub(super) header: Header,
}

/// Where the values of a variable stand, one for each node.
#[derive(Debug, Clone)]
pub(super) struct Values {
    pub(super) name: String,
    pub(super) begin: u64,
    pub(super) number: Type,
    pub(super) meaning: Meaning,
}

/// What the numbers of a variable stand for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Meaning {
    /// Themselves.
    Plain,
    /// Numbers from 0 to 255, in a wider type.
    Byte,
    /// Bytes with a sign that stand for bytes without one.
    Unsigned,
}

/// Where the corners of faces stand.
#[derive(Debug, Clone)]
pub(super) struct Corners {
    pub(super) begin: u64,
    pub(super) number: Type,
    /// The most that a face has.
    pub(super) most: usize,
    /// Whether the first corners of all faces come first, then the second ones, and so on.
    pub(super) corner_first: bool,
    /// The number of the first node.
    pub(super) start: i128,
    /// What stands in the place of a corner that is none.
    pub(super) none: i128,
}

/// The most corners that a face may have room for.
const CORNERS: u64 = 1024;

/// Finds the mesh in a file of this length.
pub(super) fn find(path: &Path, head: &Head, length: u64) -> Result<Mesh, UgridError> {
    Finder { path, head, length }.mesh()
}

struct Finder<'a> {
    path: &'a Path,
    head: &'a Head,
    length: u64,
}

impl Finder<'_> {
    fn mesh(&self) -> Result<Mesh, UgridError> {
        let topology = self.topology()?;
        let node_coordinates = self.said(topology, "node_coordinates")?;
        let names = node_coordinates.split_whitespace().take(3);
        let coordinates = names.map(|name| self.variable(name)).collect::<Result<Vec<_>, _>>()?;
        let [first, second, further @ ..] = coordinates.as_slice() else {
            return Err(self.wrong(topology, "two node_coordinates", format!("{node_coordinates:?}")));
        };
        let (x, y) =
            if is_northing(&first.said) && !is_northing(&second.said) { (second, first) } else { (first, second) };
        let [node] = x.dimensions.as_slice() else {
            return Err(self.wrong(x, "one dimension", x.dimensions.len().to_string()));
        };
        let nodes = self.length_of(x, *node)?;
        let height = self.height(topology, *node, further)?;
        let places = [self.place(x, *node)?, self.place(y, *node)?, self.place(height, *node)?];
        let (faces, corners) = self.corners(topology)?;
        let used = [x.name.as_str(), &y.name, &height.name];
        let (mut attributes, mut names) = (Vec::new(), HashSet::new());
        let others = self.head.variables.iter().filter(|v| !used.contains(&v.name.as_str()));
        for variable in others.filter(|v| v.dimensions == [*node] && is_plain(v)) {
            let name = attribute_name(&topology.name, &variable.name);
            if names.insert(name) {
                let values = self.place(variable, *node)?;
                let number = match values.meaning {
                    Meaning::Plain => values.number.narrowest(),
                    Meaning::Byte | Meaning::Unsigned => Number::U8,
                };
                attributes.push((Channel { name: name.to_string(), number }, values));
            }
        }
        let (attributes, values) = attributes.into_iter().unzip();
        let header = self.header(&places, x);
        Ok(Mesh { nodes, faces, places, attributes, values, corners, header })
    }

    fn topology(&self) -> Result<&Variable, UgridError> {
        let is_mesh = |v: &&Variable| {
            v.said.text("cf_role") == Some("mesh_topology") && v.said.integer("topology_dimension").unwrap_or(2) == 2
        };
        let missing = "a variable with cf_role = \"mesh_topology\" and topology_dimension = 2, as UGRID has it";
        self.head.variables.iter().find(is_mesh).ok_or_else(|| self.missing(missing.to_string()))
    }

    /// The heights of nodes: a third coordinate, what is called an altitude, or what has the name that MDAL looks for.
    fn height<'a>(
        &'a self,
        topology: &Variable,
        node: usize,
        further: &[&'a Variable],
    ) -> Result<&'a Variable, UgridError> {
        let of_nodes = || self.head.variables.iter().filter(|v| v.dimensions == [node] && is_plain(v));
        let name = format!("{}_node_z", topology.name);
        let found = further
            .first()
            .copied()
            .or_else(|| of_nodes().find(|v| v.said.text("standard_name") == Some("altitude")))
            .or_else(|| of_nodes().find(|v| v.name == name))
            .ok_or_else(|| {
                self.missing(format!("heights of nodes: a variable with standard_name = \"altitude\", or named {name}"))
            })?;
        match found.said.text("positive") {
            Some("down") => Err(self.wrong(found, "heights (positive = \"up\")", "depths".to_string())),
            _ => Ok(found),
        }
    }

    /// A variable with one number for each node.
    fn place(&self, variable: &Variable, node: usize) -> Result<Values, UgridError> {
        if variable.dimensions != [node] {
            let names: Vec<&str> = variable.dimensions.iter().map(|&d| self.head.dimensions[d].name.as_str()).collect();
            return Err(self.wrong(variable, "the dimension of the nodes alone", format!("{names:?}")));
        }
        if !is_plain(variable) {
            return Err(self.wrong(variable, "plain numbers", format!("{}, or a scale or an offset", variable.number)));
        }
        let nodes = self.length_of(variable, node)?;
        self.must_have(variable, nodes)?;
        let meaning = match (variable.number, variable.said.text("original_type"), variable.said.text("_Unsigned")) {
            (Type::Float | Type::Short, Some("ubyte"), _) => Meaning::Byte,
            (Type::Byte, _, Some("true")) => Meaning::Unsigned,
            _ => Meaning::Plain,
        };
        Ok(Values { name: variable.name.clone(), begin: variable.begin, number: variable.number, meaning })
    }

    /// How many faces there are, and where their corners stand.
    fn corners(&self, topology: &Variable) -> Result<(u64, Corners), UgridError> {
        let variable = self.variable(self.said(topology, "face_node_connectivity")?)?;
        let [first, second] = variable.dimensions.as_slice() else {
            return Err(self.wrong(variable, "two dimensions", variable.dimensions.len().to_string()));
        };
        let dimension = topology.said.text("face_dimension").unwrap_or_default();
        let corner_first = self.head.dimensions[*second].name == dimension && first != second;
        let (face, corner) = if corner_first { (second, first) } else { (first, second) };
        let (faces, most) = (self.length_of(variable, *face)?, self.length_of(variable, *corner)?);
        if !variable.number.is_integer() {
            return Err(self.wrong(variable, "whole numbers", variable.number.to_string()));
        }
        if !(3..=CORNERS).contains(&most) {
            return Err(self.wrong(variable, "room for 3 corners, and for at most 1024", most.to_string()));
        }
        let values = faces.saturating_mul(most);
        self.must_have(variable, values)?;
        let none = variable.said.integer("_FillValue").unwrap_or(match variable.number {
            Type::Int64 => -9_223_372_036_854_775_806,
            _ => -2_147_483_647,
        });
        let corners = Corners {
            begin: variable.begin,
            number: variable.number,
            most: most as usize,
            corner_first,
            start: variable.said.integer("start_index").unwrap_or(0),
            none,
        };
        Ok((faces, corners))
    }

    fn header(&self, places: &[Values; 3], x: &Variable) -> Header {
        let facts = match self.head.said.value("terrabite") {
            Some(Value::Text(facts)) => facts.as_str(),
            _ => "",
        };
        let mut header = lines::header(facts.split('\n').map(str::trim).filter(|line| !line.is_empty()));
        header.frame.single = places.iter().all(|place| place.number == Type::Float);
        if facts.is_empty() {
            header.crs = self.crs(x);
        }
        header
    }

    /// The CRS, as other programs say it.
    fn crs(&self, x: &Variable) -> Crs {
        let grid_mapping = x.said.text("grid_mapping").or_else(|| {
            let of_others = self.head.variables.iter().filter(|v| v.dimensions == x.dimensions);
            of_others.filter_map(|v| v.said.text("grid_mapping")).next()
        });
        let names = ["projected_coordinate_system", "wgs84", "crs"].into_iter();
        let Some(variable) = grid_mapping.into_iter().chain(names).find_map(|name| self.head.variable(name)) else {
            return Crs::default();
        };
        let text = |name: &str| variable.said.text(name).map(str::trim).filter(|text| !text.is_empty());
        let epsg = variable.said.integer("epsg").filter(|code| *code > 0).map(|code| format!("EPSG:{code}"));
        let wkt = || text("crs_wkt").or_else(|| text("spatial_ref")).or_else(|| text("wkt")).map(str::to_string);
        Crs { definition: text("EPSG_code").map(str::to_string).or(epsg).or_else(wkt), ..Crs::default() }
    }

    /// The file must be long enough for these values.
    fn must_have(&self, variable: &Variable, values: u64) -> Result<(), UgridError> {
        let bytes = values.checked_mul(variable.number.bytes() as u64);
        let end = bytes.and_then(|bytes| bytes.checked_add(variable.begin)).unwrap_or(u64::MAX);
        if end <= self.length {
            return Ok(());
        }
        let what = format!("variable {:?}", variable.name);
        Err(UgridError::Truncated { path: self.path.to_path_buf(), what, expected: end, found: self.length })
    }

    fn length_of(&self, variable: &Variable, dimension: usize) -> Result<u64, UgridError> {
        match self.head.dimensions[dimension].length {
            0 => {
                let name = &self.head.dimensions[dimension].name;
                Err(self.wrong(variable, "dimensions with an end", format!("{name:?}, which is unlimited")))
            }
            length => Ok(length),
        }
    }

    fn said<'a>(&self, variable: &'a Variable, name: &str) -> Result<&'a str, UgridError> {
        let missing = || self.missing(format!("the attribute {name} of variable {:?}", variable.name));
        variable.said.text(name).map(str::trim).ok_or_else(missing)
    }

    fn variable(&self, name: &str) -> Result<&Variable, UgridError> {
        self.head.variable(name).ok_or_else(|| self.missing(format!("a variable {name:?}, which the mesh names")))
    }

    fn missing(&self, expected: String) -> UgridError {
        UgridError::Missing { path: self.path.to_path_buf(), expected }
    }

    fn wrong(&self, variable: &Variable, expected: &'static str, found: String) -> UgridError {
        UgridError::Variable { path: self.path.to_path_buf(), variable: variable.name.clone(), expected, found }
    }
}

/// Whether a coordinate is y: which comes first, UGRID leaves open.
fn is_northing(said: &Said) -> bool {
    matches!(said.text("standard_name"), Some("projection_y_coordinate" | "latitude"))
}

/// Whether the numbers of a variable are values as they stand.
fn is_plain(variable: &Variable) -> bool {
    let is_packed = ["scale_factor", "add_offset"].iter().any(|name| variable.said.value(name).is_some());
    variable.number != Type::Char && !is_packed
}

/// What an attribute is called: its variable's name, without that of the mesh.
fn attribute_name<'a>(mesh: &str, variable: &'a str) -> &'a str {
    let of_mesh = |name: &'a str| name.strip_prefix(mesh)?.strip_prefix('_');
    let name = variable.strip_prefix("attribute_").or_else(|| of_mesh(variable)).unwrap_or(variable);
    if ["", "x", "y", "z"].contains(&name) { variable } else { name }
}
