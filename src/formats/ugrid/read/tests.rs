//! Reading UGRID files of any origin, and refusing damaged ones.

use super::*;
use crate::base::channels::Number;
use crate::base::control::CancelToken;
use crate::formats::ugrid::FORMAT;
use crate::formats::{MeshReader, ReadError};
use crate::testing::{Mesh, file, mesh_in, without_name};

/// A NetCDF file as other programs write them.
#[derive(Clone)]
struct File {
    version: u8,
    dimensions: Vec<(&'static str, u64)>,
    variables: Vec<Variable>,
}

#[derive(Clone)]
struct Variable {
    name: &'static str,
    dimensions: Vec<u64>,
    said: Vec<(&'static str, Said)>,
    number: u32,
    values: Vec<u8>,
}

#[derive(Clone)]
enum Said {
    Text(&'static str),
    Int(i32),
}

use Said::{Int, Text};

impl File {
    fn bytes(&self) -> Vec<u8> {
        let count = |count: u64| match self.version {
            5 => count.to_be_bytes().to_vec(),
            _ => (count as u32).to_be_bytes().to_vec(),
        };
        let word = |word: u32| word.to_be_bytes().to_vec();
        let padded = |bytes: &[u8]| [bytes, &vec![0; bytes.len().next_multiple_of(4) - bytes.len()]].concat();
        let text = |text: &str| [count(text.len() as u64), padded(text.as_bytes())].concat();
        let place = |place: u64| if self.version == 1 { word(place as u32) } else { place.to_be_bytes().to_vec() };
        let head = |begins: &[u64]| {
            let mut bytes = [b"CDF".to_vec(), vec![self.version], count(0), word(10)].concat();
            bytes.extend(count(self.dimensions.len() as u64));
            self.dimensions.iter().for_each(|(name, length)| bytes.extend([text(name), count(*length)].concat()));
            bytes.extend([word(0), count(0), word(11), count(self.variables.len() as u64)].concat());
            for (variable, begin) in self.variables.iter().zip(begins) {
                bytes.extend([text(variable.name), count(variable.dimensions.len() as u64)].concat());
                variable.dimensions.iter().for_each(|d| bytes.extend(count(*d)));
                bytes.extend([word(12), count(variable.said.len() as u64)].concat());
                for (name, value) in &variable.said {
                    bytes.extend(text(name));
                    match value {
                        Text(value) => bytes.extend([word(2), text(value)].concat()),
                        Int(value) => bytes.extend([word(4), count(1), word(*value as u32)].concat()),
                    }
                }
                bytes.extend([word(variable.number), count(variable.values.len() as u64), place(*begin)].concat());
            }
            bytes
        };
        let mut begins = Vec::new();
        let mut next = head(&vec![0; self.variables.len()]).len() as u64;
        for variable in &self.variables {
            begins.push(next);
            next += padded(&variable.values).len() as u64;
        }
        let values = self.variables.iter().flat_map(|v| padded(&v.values));
        head(&begins).into_iter().chain(values).collect()
    }

    fn variable(&mut self, name: &str) -> &mut Variable {
        self.variables.iter_mut().find(|v| v.name == name).expect("a variable")
    }
}

fn doubles(values: &[f64]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_be_bytes()).collect()
}

fn ints(values: &[i32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_be_bytes()).collect()
}

/// Two triangles on four nodes.
fn square() -> File {
    let of_nodes = |name, values: &[f64]| Variable {
        name,
        dimensions: vec![0],
        said: Vec::new(),
        number: 6,
        values: doubles(values),
    };
    let topology = vec![
        ("cf_role", Text("mesh_topology")),
        ("topology_dimension", Int(2)),
        ("node_coordinates", Text("nx ny")),
        ("face_node_connectivity", Text("fn")),
    ];
    let scalar = |name, said| Variable { name, dimensions: vec![], said, number: 4, values: vec![0; 4] };
    let faces = Variable {
        name: "fn",
        dimensions: vec![1, 2],
        said: vec![("start_index", Int(1))],
        number: 4,
        values: ints(&[1, 2, 3, 3, 2, 4]),
    };
    File {
        version: 1,
        dimensions: vec![("node", 4), ("face", 2), ("three", 3), ("time", 0)],
        variables: vec![
            scalar("m", topology),
            of_nodes("nx", &[0.0, 1.0, 0.0, 1.0]),
            of_nodes("ny", &[0.0, 0.0, 1.0, 1.0]),
            of_nodes("m_node_z", &[1.5, -2e3, 0.25, 7.0]),
            scalar("projected_coordinate_system", vec![("epsg", Int(32633))]),
            faces,
        ],
    }
}

fn open(bytes: &[u8]) -> Result<(tempfile::NamedTempFile, UgridReader), String> {
    let file = file(bytes);
    let mesh = UgridReader::open(file.path(), &CancelToken::default());
    mesh.map_err(|error| without_name(file.path(), &error.to_string())).map(|mesh| (file, mesh))
}

fn read(bytes: &[u8]) -> Result<Mesh, String> {
    mesh_in(&FORMAT, bytes)
}

fn expected() -> Mesh {
    (vec![[0.0, 0.0, 1.5], [1.0, 0.0, -2e3], [0.0, 1.0, 0.25], [1.0, 1.0, 7.0]], vec![[0, 1, 2], [2, 1, 3]])
}

/// The square, changed.
fn changed(change: impl FnOnce(&mut File)) -> Vec<u8> {
    let mut file = square();
    change(&mut file);
    file.bytes()
}

#[test]
fn every_kind_of_classic_file_is_read() {
    for version in [1, 2, 5] {
        assert_eq!(read(&changed(|file| file.version = version)), Ok(expected()), "CDF-{version}");
    }
    let (_file, mesh) = open(&square().bytes()).expect("opens");
    assert_eq!(mesh.header().crs.definition.as_deref(), Some("EPSG:32633"));
}

#[test]
fn meshes_are_read_as_other_programs_have_them() {
    type Change = fn(&mut File);
    let changes: &[(&str, Change)] = &[
        ("from 0", |f| {
            *f.variable("fn") =
                Variable { said: vec![], values: ints(&[0, 1, 2, 2, 1, 3]), ..f.variable("fn").clone() };
        }),
        ("64 bits without a sign", |f| {
            f.version = 5;
            let values = [1u64, 2, 3, 3, 2, 4].iter().flat_map(|v| v.to_be_bytes()).collect();
            *f.variable("fn") = Variable { number: 11, values, ..f.variable("fn").clone() };
        }),
        ("bytes", |f| {
            *f.variable("fn") = Variable { number: 1, values: vec![1, 2, 3, 3, 2, 4], ..f.variable("fn").clone() };
        }),
        ("corners first", |f| {
            f.variable("m").said.push(("face_dimension", Text("face")));
            let values = ints(&[1, 3, 2, 2, 3, 4]);
            *f.variable("fn") = Variable { dimensions: vec![2, 1], values, ..f.variable("fn").clone() };
        }),
        ("room for four corners", |f| {
            f.dimensions[2].1 = 4;
            f.variable("fn").said.push(("_FillValue", Int(-1)));
            f.variable("fn").values = ints(&[1, 2, 3, -1, 3, 2, 4, -1]);
        }),
        ("an altitude", |f| {
            *f.variable("m_node_z") = Variable {
                name: "h",
                said: vec![("standard_name", Text("altitude"))],
                ..f.variable("m_node_z").clone()
            };
        }),
        ("a third coordinate", |f| {
            f.variable("m").said[2].1 = Text("nx ny h");
            f.variable("m_node_z").name = "h";
        }),
        ("y first", |f| {
            f.variable("m").said[2].1 = Text("ny nx");
            f.variable("ny").said.push(("standard_name", Text("projection_y_coordinate")));
        }),
    ];
    for (what, change) in changes {
        assert_eq!(read(&changed(change)), Ok(expected()), "{what}");
    }
    // A record variable that is not of the mesh.
    let other = Variable { name: "t", dimensions: vec![3], said: vec![], number: 6, values: vec![] };
    assert_eq!(read(&changed(|f| f.variables.push(other))), Ok(expected()));
}

#[test]
fn variables_of_nodes_are_attributes() {
    let of_nodes = |name, number, said: &[(&'static str, Said)], values: &[u8]| Variable {
        name,
        dimensions: vec![0],
        said: said.to_vec(),
        number,
        values: values.to_vec(),
    };
    let file = changed(|f| {
        let short = [0, 1, 0, 255, 0, 7, 0, 0];
        f.variables.insert(5, of_nodes("m_red", 3, &[("original_type", Text("ubyte"))], &short));
        f.variables.insert(5, of_nodes("green", 3, &[], &[0xff, 0xff, 1, 0, 0, 0, 0, 0]));
        f.variables.insert(5, of_nodes("blue", 1, &[("_Unsigned", Text("true"))], &[0, 255, 7, 1]));
        f.variables.insert(5, of_nodes("packed", 1, &[("scale_factor", Int(2))], &[0; 4]));
        f.variables.insert(5, of_nodes("text", 2, &[], b"abcd"));
    });
    let (_file, mut mesh) = open(&file).expect("opens");
    let found: Vec<(&str, Number)> = mesh.attributes().iter().map(|a| (a.name.as_str(), a.number)).collect();
    assert_eq!(found, [("blue", Number::U8), ("green", Number::F32), ("red", Number::U8)]);
    let mesh: &mut dyn MeshReader = &mut mesh;
    let mut values = Vec::new();
    mesh.for_each_vertex_with(&["red", "blue", "green"], |_, _, found| {
        values.push(found.to_vec());
        Ok::<(), ReadError>(())
    })
    .expect("read");
    assert_eq!(values[..2], [[1.0, 0.0, -1.0], [255.0, 255.0, 256.0]]);
    let lie = changed(|f| f.variables.push(of_nodes("m_red", 3, &[("original_type", Text("ubyte"))], &[1; 8])));
    let (_file, mut mesh) = open(&lie).expect("opens");
    let error = mesh.vertices(&["red"], &mut |_, _, _| std::ops::ControlFlow::Continue(())).expect_err("a lie");
    assert!(
        error.to_string().contains("variable \"m_red\", value 0: expected a whole number from 0 to 255, found 257")
    );
}

#[test]
fn damage_is_named() {
    type Change = fn(&mut File);
    let changes: &[(Change, &str)] = &[
        (|f| f.variable("m").said[0].1 = Text("mesh"), "expected a variable with cf_role = \"mesh_topology\""),
        (|f| f.variable("m").said[1].1 = Int(1), "topology_dimension = 2"),
        (|f| f.variable("m").said[2].1 = Text("nx"), "variable \"m\": expected two node_coordinates, found \"nx\""),
        (|f| f.variable("m").said[2].1 = Text("nx no"), "expected a variable \"no\", which the mesh names, found none"),
        (
            |f| f.variable("m_node_z").name = "z",
            "expected heights of nodes: a variable with standard_name = \"altitude\"",
        ),
        (
            |f| f.variable("m_node_z").said.push(("positive", Text("down"))),
            "expected heights (positive = \"up\"), found depths",
        ),
        (|f| f.variable("ny").dimensions = vec![1], "variable \"ny\": expected the dimension of the nodes alone"),
        (|f| f.variable("nx").said.push(("scale_factor", Int(2))), "variable \"nx\": expected plain numbers"),
        (
            |f| f.variable("fn").dimensions = vec![3, 2],
            "expected dimensions with an end, found \"time\", which is unlimited",
        ),
        (|f| f.variable("fn").number = 5, "variable \"fn\": expected whole numbers, found float"),
        (|f| f.variable("fn").number = 12, "expected the code of a number type, 1 to 11, found 12"),
        (|f| f.variable("fn").dimensions = vec![1, 9], "expected the number of a dimension, found 9"),
        (|f| f.dimensions[2].1 = 2, "expected room for 3 corners, and for at most 1024, found 2"),
        (|f| f.variable("fn").values[3] = 0, "face 0: expected nodes 1 to below 5, found 0"),
        (|f| f.variable("fn").values[23] = 5, "face 1: expected nodes 1 to below 5, found 5"),
        (
            |f| {
                f.dimensions[2].1 = 4;
                f.variable("fn").values = ints(&[1, 2, 3, 4, 1, 2, 3, -2_147_483_647]);
            },
            "face 0: expected a triangle, found 4 corners",
        ),
        (|f| f.dimensions[0].1 = 2_000_000_000, "expected variable \"nx\" up to byte 16000000"),
        (
            |f| {
                f.version = 5;
                f.dimensions[1].1 = u64::MAX;
            },
            "expected variable \"fn\" up to byte 18446744073709551615, found the end of the file at byte",
        ),
    ];
    for (change, said) in changes {
        let error = read(&changed(change)).expect_err(said);
        assert!(error.contains(said), "{error}");
    }
    assert!(read(b"\x89HDF\r\n\x1a\n").unwrap_err().contains("nccopy -k cdf5"));
    assert!(read(b"CDF\x03").unwrap_err().starts_with("byte 0: expected CDF and 1, 2 or 5"));
    let whole = square().bytes();
    for cut in 0..whole.len() {
        assert!(open(&whole[..cut]).is_err(), "cut at {cut}");
    }
    // A name of 2 GiB.
    let mut name = whole.clone();
    name[16..20].copy_from_slice(&[0x7f; 4]);
    assert!(read(&name).unwrap_err().starts_with("expected the head of a NetCDF file up to byte 2139062163"));
}

#[test]
fn a_file_that_changes_between_passes_is_an_error() {
    let whole = square().bytes();
    let (file, mut mesh) = open(&whole).expect("opens");
    std::fs::write(file.path(), &whole[..whole.len() - 1]).expect("written");
    let mesh: &mut dyn MeshReader = &mut mesh;
    let error = mesh.for_each_vertex(|_, _| Ok::<(), ReadError>(())).expect_err("shorter").to_string();
    assert!(error.contains("as when it was opened") && error.ends_with("the file is being changed"), "{error}");
    assert!(mesh.for_each_face(|_, _| Ok::<(), ReadError>(())).is_err());
    std::fs::write(file.path(), &whole).expect("written");
    assert!(mesh.for_each_face(|_, _| Ok::<(), ReadError>(())).is_ok());
}
