//! netCDF files for tests.

use super::Folder;

/// The coordinates of the columns or rows of a [`Cube`].
#[derive(Clone)]
pub(crate) struct Axis {
    name: &'static str,
    units: &'static str,
    standard_name: &'static str,
    values: Vec<f64>,
}

impl Axis {
    pub(crate) fn new(name: &'static str, values: impl IntoIterator<Item = f64>) -> Axis {
        let (units, standard_name) = match name {
            "lat" => ("degrees_north", "latitude"),
            "lon" => ("degrees_east", "longitude"),
            "y" => ("m", "projection_y_coordinate"),
            "x" => ("m", "projection_x_coordinate"),
            _ => ("", ""),
        };
        Axis { name, units, standard_name, values: values.into_iter().collect() }
    }
}

/// A classic netCDF file of one variable `z` in single precision, written byte by byte: GDAL writes even axes only.
#[derive(Clone)]
pub(crate) struct Cube {
    rows: Axis,
    columns: Axis,
    /// Whether axes are in single precision.
    single: bool,
    /// What dimensions are called, where not as their axes.
    dimensions: Option<(&'static str, &'static str)>,
    grid_mapping: bool,
    /// What the file says of itself: `productSpecification`.
    product: Option<&'static str>,
}

const CHAR: i32 = 2;
const INT: i32 = 4;
const FLOAT: i32 = 5;
const DOUBLE: i32 = 6;

struct Variable {
    name: &'static str,
    dimensions: Vec<i32>,
    attributes: Vec<(&'static str, String)>,
    kind: i32,
    data: Vec<u8>,
}

impl Cube {
    pub(crate) fn new(rows: Axis, columns: Axis) -> Cube {
        Cube { rows, columns, single: false, dimensions: None, grid_mapping: false, product: None }
    }

    pub(crate) fn single(self) -> Cube {
        Cube { single: true, ..self }
    }

    /// Dimensions of other names than the axes, which the variable's attribute `coordinates` names.
    pub(crate) fn dimensions(self, rows: &'static str, columns: &'static str) -> Cube {
        Cube { dimensions: Some((rows, columns)), ..self }
    }

    pub(crate) fn grid_mapping(self) -> Cube {
        Cube { grid_mapping: true, ..self }
    }

    pub(crate) fn product(self, product: &'static str) -> Cube {
        Cube { product: Some(product), ..self }
    }

    /// Writes it with the heights at rows and columns of the file.
    pub(crate) fn write(&self, folder: &Folder, name: &str, height: impl Fn(usize, usize) -> f64) -> String {
        let (rows, columns) = (self.rows.values.len(), self.columns.values.len());
        let heights = (0..rows * columns).flat_map(|i| (height(i / columns, i % columns) as f32).to_be_bytes());
        let mut attributes = Vec::new();
        if self.dimensions.is_some() {
            attributes.push(("coordinates", format!("{} {}", self.rows.name, self.columns.name)));
        }
        if self.grid_mapping {
            attributes.push(("grid_mapping", "crs".to_string()));
        }
        let z = Variable { name: "z", dimensions: vec![0, 1], attributes, kind: FLOAT, data: heights.collect() };
        let mut variables = vec![self.axis(&self.rows, 0), self.axis(&self.columns, 1), z];
        if self.grid_mapping {
            let attributes = vec![("grid_mapping_name", "latitude_longitude".to_string())];
            let data = vec![0; 4];
            variables.push(Variable { name: "crs", dimensions: Vec::new(), attributes, kind: INT, data });
        }
        let names = self.dimensions.unwrap_or((self.rows.name, self.columns.name));
        folder.with(name, file(&[(names.0, rows), (names.1, columns)], self.product, &variables))
    }

    fn axis(&self, axis: &Axis, dimension: i32) -> Variable {
        let data = match self.single {
            true => axis.values.iter().flat_map(|v| (*v as f32).to_be_bytes()).collect(),
            false => axis.values.iter().flat_map(|v| v.to_be_bytes()).collect(),
        };
        let attributes = vec![("units", axis.units), ("standard_name", axis.standard_name)];
        let attributes = attributes.into_iter().filter(|(_, text)| !text.is_empty());
        Variable {
            name: axis.name,
            dimensions: vec![dimension],
            attributes: attributes.map(|(name, text)| (name, text.to_string())).collect(),
            kind: if self.single { FLOAT } else { DOUBLE },
            data,
        }
    }
}

/// The file: magic number, dimensions, attributes of its own, variables, data. All numbers are big-endian.
fn file(dimensions: &[(&str, usize)], product: Option<&str>, variables: &[Variable]) -> Vec<u8> {
    let header = |begins: &[i32]| {
        let mut bytes = b"CDF\x01\0\0\0\0".to_vec();
        list(&mut bytes, 0x0a, dimensions.len());
        for (name, length) in dimensions {
            text(&mut bytes, name);
            number(&mut bytes, *length as i32);
        }
        let product = product.map(|product| ("productSpecification", product.to_string()));
        let own = [Some(("Conventions", "CF-1.8".to_string())), product];
        attributes(&mut bytes, &own.into_iter().flatten().collect::<Vec<_>>());
        list(&mut bytes, 0x0b, variables.len());
        for (variable, begin) in variables.iter().zip(begins) {
            text(&mut bytes, variable.name);
            number(&mut bytes, variable.dimensions.len() as i32);
            variable.dimensions.iter().for_each(|d| number(&mut bytes, *d));
            attributes(&mut bytes, &variable.attributes);
            number(&mut bytes, variable.kind);
            number(&mut bytes, variable.data.len().next_multiple_of(4) as i32);
            number(&mut bytes, *begin);
        }
        bytes
    };
    let mut at = header(&vec![0; variables.len()]).len();
    let mut begins = Vec::new();
    for variable in variables {
        begins.push(at as i32);
        at += variable.data.len().next_multiple_of(4);
    }
    let mut bytes = header(&begins);
    for variable in variables {
        bytes.extend_from_slice(&variable.data);
        bytes.resize(bytes.len().next_multiple_of(4), 0);
    }
    bytes
}

fn number(bytes: &mut Vec<u8>, number: i32) {
    bytes.extend_from_slice(&number.to_be_bytes());
}

fn attributes(bytes: &mut Vec<u8>, attributes: &[(&str, String)]) {
    list(bytes, if attributes.is_empty() { 0 } else { 0x0c }, attributes.len());
    for (name, value) in attributes {
        text(bytes, name);
        number(bytes, CHAR);
        text(bytes, value);
    }
}

fn list(bytes: &mut Vec<u8>, tag: i32, count: usize) {
    number(bytes, tag);
    number(bytes, count as i32);
}

fn text(bytes: &mut Vec<u8>, text: &str) {
    number(bytes, text.len() as i32);
    bytes.extend_from_slice(text.as_bytes());
    bytes.resize(bytes.len().next_multiple_of(4), 0);
}
