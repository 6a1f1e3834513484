//! Reading VTP files of any origin, and refusing damaged ones.

use super::*;
use crate::base::channels::Number;
use crate::base::control::CancelToken;
use crate::formats::vtp::FORMAT;
use crate::formats::{MeshReader, ReadError};
use crate::testing::{Mesh, file, mesh_in, without_name};

/// Two triangles on four points, as text.
const SQUARE: &str = "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"0.1\" byte_order=\"LittleEndian\">\n\
    <PolyData><FieldData><DataArray type=\"Float64\" Name=\"TimeValue\" format=\"ascii\">1</DataArray></FieldData>\n\
    <Piece NumberOfPoints=\"4\" NumberOfVerts=\"0\" NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"2\">\n\
    <PointData Scalars=\"heat\"><DataArray type=\"Float32\" Name=\"heat\" format=\"ascii\">0.1 2 3 4</DataArray>\n\
    <DataArray type=\"UInt8\" Name=\"rgb\" NumberOfComponents=\"2\" format=\"ascii\">1 2 3 4 5 6 7 255</DataArray>\n\
    </PointData><CellData><DataArray type=\"Int32\" Name=\"id\" format=\"ascii\">1 2</DataArray></CellData>\n\
    <Points><DataArray type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\" format=\"ascii\" RangeMin=\"0\">\n\
    0 0 1.5  1 0 -2e3\n0 1 0.25 1 1 7 <InformationKey name=\"L2\"><Value>1</Value></InformationKey></DataArray></Points>\n\
    <Verts><DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\"></DataArray></Verts>\n\
    <Polys><DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">0 1 2 2 1 3</DataArray>\n\
    <DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">3 6</DataArray></Polys></Piece></PolyData></VTKFile>\n";

fn open(bytes: &[u8]) -> Result<(tempfile::NamedTempFile, VtpReader), String> {
    let file = file(bytes);
    let mesh = VtpReader::open(file.path(), &CancelToken::default());
    mesh.map_err(|error| without_name(file.path(), &error.to_string())).map(|mesh| (file, mesh))
}

fn read(bytes: &[u8]) -> Result<Mesh, String> {
    mesh_in(&FORMAT, bytes)
}

fn expected() -> Mesh {
    (vec![[0.0, 0.0, 1.5], [1.0, 0.0, -2e3], [0.0, 1.0, 0.25], [1.0, 1.0, 7.0]], vec![[0, 1, 2], [2, 1, 3]])
}

/// The same square with arrays as bytes: after their length, big-endian.
fn arrays() -> [Vec<u8>; 3] {
    let with_length = |bytes: Vec<u8>| [(bytes.len() as u32).to_be_bytes().to_vec(), bytes].concat();
    let points = expected().0.as_flattened().iter().flat_map(|v| v.to_be_bytes()).collect();
    let corners = [0i32, 1, 2, 2, 1, 3].iter().flat_map(|v| v.to_be_bytes()).collect();
    let offsets = [3u8, 6].to_vec();
    [points, corners, offsets].map(with_length)
}

fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for three in bytes.chunks(3) {
        let at = |i: usize| u32::from(three.get(i).copied().unwrap_or(0));
        let bits = at(0) << 16 | at(1) << 8 | at(2);
        for i in 0..4 {
            let digit = DIGITS[(bits >> (18 - 6 * i) & 63) as usize];
            text.push(if i > three.len() { '=' } else { digit.into() });
        }
    }
    text
}

fn binary(places: [String; 3], after: &[u8]) -> Vec<u8> {
    let [points, corners, offsets] = places;
    let xml = format!(
        "<VTKFile type='PolyData' byte_order='BigEndian' header_type='UInt32'><PolyData><Piece NumberOfPoints='4' \
         NumberOfPolys='2'><Points><DataArray type='Float64' Name='p' NumberOfComponents='3' {points}</DataArray></Points>\
         <Polys><DataArray type='Int32' Name='connectivity' {corners}</DataArray><DataArray type='UInt8' Name='offsets' \
         {offsets}</DataArray></Polys></Piece></PolyData>"
    );
    [xml.as_bytes(), after, b"</VTKFile>\n"].concat()
}

fn appended(encoding: &str, arrays: &[Vec<u8>; 3]) -> Vec<u8> {
    let [a, b, _] = arrays.each_ref().map(Vec::len);
    let places = [0, a, a + b].map(|offset| format!("format='appended' offset='{offset}'>"));
    let open = format!("<AppendedData encoding='{encoding}'>\n _");
    binary(places, &[open.as_bytes(), &arrays.concat(), b"</AppendedData>"].concat())
}

#[test]
fn every_way_to_write_arrays_is_read() {
    assert_eq!(read(SQUARE.as_bytes()), Ok(expected()));
    let inline = arrays().map(|array| format!("format='binary'>\n {}\n", base64(&array)));
    assert_eq!(read(&binary(inline, b"")), Ok(expected()));
    assert_eq!(read(&appended("raw", &arrays())), Ok(expected()));
    assert_eq!(read(&appended("base64", &arrays().map(|array| base64(&array).into_bytes()))), Ok(expected()));
}

#[test]
fn arrays_of_points_are_attributes() {
    let found = |text: &str| {
        let (_file, mesh) = open(text.as_bytes()).expect("opens");
        mesh.attributes().iter().map(|a| (a.name.clone(), a.number)).collect::<Vec<_>>()
    };
    let named = |names: &[(&str, Number)]| names.iter().map(|(name, n)| (name.to_string(), *n)).collect::<Vec<_>>();
    assert_eq!(found(SQUARE), named(&[("heat", Number::F32), ("rgb_0", Number::U8), ("rgb_1", Number::U8)]));
    let (_file, mut mesh) = open(SQUARE.as_bytes()).expect("opens");
    let mesh: &mut dyn MeshReader = &mut mesh;
    let mut values = Vec::new();
    mesh.for_each_vertex_with(&["rgb_1", "heat"], |_, _, found| {
        values.push(found.to_vec());
        Ok::<(), ReadError>(())
    })
    .expect("read");
    assert_eq!(values, [[2.0, f64::from(0.1f32)], [4.0, 2.0], [6.0, 3.0], [255.0, 4.0]]);
    let normals = SQUARE.replace("Scalars=\"heat\"", "Normals=\"n\"").replace(
        "<CellData>",
        "<PointData Normals=\"n\"><DataArray type=\"Float64\" Name=\"n\" NumberOfComponents=\"3\" format=\"ascii\">\
         0 0 1 0 0 1 0 0 1 0 0 1</DataArray></PointData><CellData>",
    );
    assert_eq!(found(&normals)[3..], named(&[("nx", Number::F64), ("ny", Number::F64), ("nz", Number::F64)]));
}

/// As VTK writes them again: all on one line, bytes with a sign.
#[test]
fn strings_are_facts() {
    let strings = "<FieldData><Array type=\"String\" Name=\"terrabite\" NumberOfTuples=\"2\" format=\"ascii\">\n 99 114 115 \
                   58 -61 -87 92 92 92 48 33 0 109 97 120 95 101 114 114 111 114 32 50 0\n</Array>";
    let (_file, mesh) = open(SQUARE.replace("<FieldData>", strings).as_bytes()).expect("opens");
    assert_eq!(mesh.header().crs.definition.as_deref(), Some("é\\\0!"));
    assert_eq!(mesh.header().tolerance, Some(2.0));
    for wrong in ["256 ", "x "] {
        let error = open(SQUARE.replace("<FieldData>", &strings.replace("-61 ", wrong)).as_bytes()).expect_err("wrong");
        assert!(error.contains("expected the numbers of bytes, found"), "{error}");
    }
}

#[test]
fn damage_is_named() {
    for (from, to, said) in [
        ("VTKFile", "VTKfile", "expected </VTKFile> at the end"),
        ("<VTKFile", "<Other/><VTKFile", "byte 22: expected <VTKFile>, found <Other>"),
        ("PolyData\"", "UnstructuredGrid\"", "byte 22: expected type=\"PolyData\", found UnstructuredGrid"),
        ("LittleEndian\"", "LittleEndian\" header_type=\"Int8\"", "expected header_type UInt32 or UInt64, found Int8"),
        ("NumberOfPolys=\"2\"", "NumberOfPolys=\"-2\"", "expected counts of points and cells, found -2"),
        ("NumberOfStrips=\"0\"", "NumberOfStrips=\"1\"", "expected no triangle strips, found 1"),
        ("</Piece>", "</Piece><Piece NumberOfPoints=\"1\"/>", "expected one piece with points, found another"),
        ("NumberOfPoints=\"4\"", "NumberOfPoints=\"0\"", "expected points, found none"),
        (
            "NumberOfPoints=\"4\"",
            "NumberOfPoints=\"5\"",
            "array \"Points\", value 12: expected a number of the array's type, found the end",
        ),
        ("-2e3", "x", "array \"Points\", value 5: expected a number of the array's type, found \"x\""),
        ("\"connectivity\"", "\"none\"", "expected the array connectivity of polygons, found none"),
        ("2 1 3<", "2 1 4<", "face 1: expected points 0 to below 4, found 4"),
        ("2 1 3<", "2 1 -1<", "face 1: expected points 0 to below 4, found -1"),
        ("2 1 3<", "2 1 1.5<", "array \"connectivity\", value 5: expected a number of the array's type, found \"1.5\""),
        (">3 6<", ">3 7<", "face 1: expected a triangle, found 4 corners"),
        (
            ">3 6<",
            ">3<",
            "array \"offsets\", value 1: expected a number of the array's type, found the end of the array",
        ),
        ("NumberOfComponents=\"3\"", "NumberOfComponents=\"2\"", "array \"Points\": expected 3 components, found 2"),
        ("\"ascii\" Range", "\"zip\" Range", "expected format ascii, binary or appended, found zip"),
        ("\"ascii\" Range", "\"appended\" Range", "expected an offset, found none"),
        ("\"ascii\" Range", "\"appended\" offset=\"0\" Range", "expected <AppendedData>, found none"),
        ("</Polys>", "</Polys", "expected a tag of XML, found none"),
    ] {
        let error = read(SQUARE.replacen(from, to, if from == "VTKFile" { 9 } else { 1 }).as_bytes()).expect_err(said);
        assert!(error.contains(said), "{to}: {error}");
    }
    let compressed = |bytes: Vec<u8>| {
        let text = String::from_utf8_lossy(&bytes).replace("<VTKFile ", "<VTKFile compressor='vtkZLibDataCompressor' ");
        read(text.as_bytes())
    };
    assert_eq!(compressed(SQUARE.into()), Ok(expected()));
    let error =
        compressed(binary(arrays().map(|array| format!("format='binary'>{}", base64(&array))), b"")).unwrap_err();
    assert!(error.starts_with("expected arrays that are not compressed, found vtkZLibDataCompressor;"), "{error}");
    let whole = appended("raw", &arrays());
    // The line's end at the end says nothing.
    for cut in 0..whole.len() - 1 {
        assert!(open(&whole[..cut]).is_err(), "cut at {cut}");
    }
    let mut short = arrays();
    short[1][3] = 20;
    assert_eq!(
        read(&appended("raw", &short)).unwrap_err(),
        "array \"connectivity\": expected 24 bytes, for 6 numbers, found 20"
    );
    short[1][3] = 24;
    let text = String::from_utf8_lossy(&appended("raw", &short)).into_owned();
    assert!(
        read(text.replace("offset='0'", "offset='9999'").as_bytes())
            .unwrap_err()
            .contains("expected a place before byte")
    );
    let many = text.replace("NumberOfPolys='2'", "NumberOfPolys='18446744073709551615'");
    assert!(read(many.as_bytes()).unwrap_err().contains("for 18446744073709551615 numbers"));
    let mut lie = arrays();
    lie[2] = vec![0x7f; 6];
    assert!(read(&appended("raw", &lie)).unwrap_err().starts_with("face 0: expected a triangle, found 127 corners"));
}

#[test]
fn a_file_that_changes_between_passes_is_an_error() {
    let (file, mut mesh) = open(SQUARE.as_bytes()).expect("opens");
    std::fs::write(file.path(), &SQUARE[..SQUARE.len() - 1]).expect("written");
    let mesh: &mut dyn MeshReader = &mut mesh;
    let error = mesh.for_each_vertex(|_, _| Ok::<(), ReadError>(())).expect_err("shorter").to_string();
    assert!(error.contains("as when it was opened") && error.ends_with("the file is being changed"), "{error}");
    std::fs::write(file.path(), SQUARE).expect("written");
    assert!(mesh.for_each_face(|_, _| Ok::<(), ReadError>(())).is_ok());
}
