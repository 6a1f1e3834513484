//! Reading LandXML files of any origin, and refusing damaged ones.

use super::*;
use crate::formats::landxml::FORMAT;
use crate::formats::{MeshReader, ReadError, ReadOptions};
use crate::testing::{Mesh, file, mesh_in};

fn opened(path: &std::path::Path) -> Result<LandXmlReader, ReadError> {
    LandXmlReader::open(path, &ReadOptions::default())
}

/// The mesh in these bytes, or what is wrong.
fn read(bytes: impl AsRef<[u8]>) -> Result<Mesh, String> {
    mesh_in(&FORMAT, bytes.as_ref())
}

/// Vertices are x, y, z: easting, northing, elevation.
fn square() -> Mesh {
    let vertices = vec![[0.0, 10.0, 1.5], [1.0, 10.0, -2e3], [0.0, 11.0, 7.0], [1.0, 11.0, 0.25]];
    (vertices, vec![[0, 1, 2], [1, 3, 2]])
}

const SIMPLE: &str = "<LandXML><Surfaces><Surface name=\"a\"><Definition surfType=\"TIN\"><Pnts><P id=\"1\">10 0 1.5</P>\
                      <P id=\"2\">10 1 -2000</P><P id=\"3\">11 0 7</P><P id=\"4\">11 1 0.25</P></Pnts><Faces><F>1 2 3</F>\
                      <F>2 4 3</F></Faces></Definition></Surface></Surfaces></LandXML>";

#[test]
fn what_other_programs_write() {
    let rich = "\u{feff}<?xml version=\"1.0\" encoding=\"UTF-8\"?>\r\n<!DOCTYPE LandXML [<!ENTITY a \"b\">]>\r\n<!-- <Surface/> -->\r\n\
                <l:LandXML xmlns:l='http://www.landxml.org/schema/LandXML-1.2' version='1.2' date=\"2026-11-28\" time=\"00:00:00\">\r\n\
                <l:Units><l:Metric linearUnit=\"meter\"/></l:Units>\r\n<l:CoordinateSystem epsgCode=\"32633\" name=\"n\" desc=\"UTM &lt;33N&gt;\"/>\
                <l:Project name='&quot;x&quot;'/><l:Application name=\"Civil 3D\" version=\"2026\"><l:Author/></l:Application>\
                <l:CgPoints><l:CgPoint name=\"1\">1 2 3</l:CgPoint></l:CgPoints>\
                <l:Surfaces>text<l:Surface name=\"points\"><l:SourceData><l:DataPoints/></l:SourceData></l:Surface><l:Surface \
                name=\"EG\" desc=\"&unknown;\"><l:SourceData><l:Pnts><l:P id='1'>1 2 3</l:P></l:Pnts>&a;</l:SourceData>\
                <l:Definition surfType=\"TIN\" area2DSurf=\"1\"><l:Pnts>\r\n\t<l:P id=\" 1 \">\r\n 10\t0.0  1.5 </l:P>\
                <l:P id='2' code=\"x\">10&#32;1<!-- no --> -2E3</l:P>\n<l:P id=\"3\"><![CDATA[11 0]]> 7.</l:P><l:P id=\"4\">11 1 .25</l:P></l:Pnts>\
                <l:Faces><l:F n=\"0 2 0\">1 2 3</l:F><l:F i=\"1\">1 2 4</l:F><l:F i=\"0\"> 2\n4 3\n</l:F></l:Faces>\
                <l:Faces/></l:Definition></l:Surface></l:Surfaces></l:LandXML>\r\n<!-- end -->\n";
    assert_eq!(read(rich), Ok(square()));
    let file = file(rich.as_bytes());
    let reader = opened(file.path()).unwrap();
    let header = reader.header();
    assert_eq!(header.crs.definition.as_deref(), Some("EPSG:32633"));
    assert_eq!(header.crs.name.as_deref(), Some("UTM <33N>"));
    assert_eq!(header.made_by.as_deref(), Some("Civil 3D 2026"));
    assert!(!header.frame.is_local() && !header.frame.single && header.notes.is_empty());
    assert_eq!(read(SIMPLE), Ok(square()));
}

#[test]
fn other_encodings() {
    let declared = |name: &str| format!("<?xml version=\"1.0\" encoding=\"{name}\"?>{SIMPLE}").into_bytes();
    let latin = |mut text: Vec<u8>| {
        let at = text.windows(3).position(|w| w == b"\"a\"").unwrap() + 1;
        text[at] = 0xe4;
        text
    };
    assert_eq!(read(latin(declared("ISO-8859-1"))), Ok(square()));
    assert!(read(latin(declared("UTF-8"))).unwrap_err().contains("expected XML, found an error"));
    let wide: Vec<u8> = format!("\u{feff}{SIMPLE}").encode_utf16().flat_map(u16::to_le_bytes).collect();
    assert!(read(wide).is_err());
}

#[test]
fn ids_with_gaps_and_in_any_order() {
    let with = |ids: [&str; 4], faces: &str| {
        let mut text = SIMPLE.to_string();
        for (i, id) in ids.iter().enumerate() {
            text = text.replace(&format!("<P id=\"{}\">", i + 1), &format!("<P  id=\"{id}\">"));
        }
        let start = text.find("<F>").unwrap();
        let end = text.find("</Faces>").unwrap();
        read(format!("{}{faces}{}", &text[..start], &text[end..]))
    };
    assert_eq!(with(["5", "6", "7", "8"], "<F>5 6 7</F><F>6 8 7</F>"), Ok(square()));
    assert_eq!(with(["0", "1", "2", "3"], "<F>0 1 2</F><F>1 3 2</F>"), Ok(square()));
    let huge = "18446744073709551615";
    assert_eq!(with(["9", "2", huge, "3"], &format!("<F>9 2 {huge}</F><F>2 3 {huge}</F>")), Ok(square()));
    assert_eq!(
        with(["1", "2", "4", "2"], "").unwrap_err(),
        "point 3: expected an id of its own, found that of point 1"
    );
    assert_eq!(
        with(["1", "2", "4", "5"], "<F>1 2 4</F><F>1 4 3</F>").unwrap_err(),
        "face 1: expected ids of points, found 3"
    );
    assert_eq!(with(["5", "6", "7", "8"], "<F>4 6 7</F>").unwrap_err(), "face 0: expected ids of points, found 4");
    assert_eq!(with(["5", "6", "7", "8"], "<F>5 6 9</F>").unwrap_err(), "face 0: expected ids of points, found 9");
    // Faces may stand before points.
    let start = SIMPLE.find("<Pnts>").unwrap();
    let faces = SIMPLE.find("<Faces>").unwrap();
    let end = SIMPLE.find("</Definition>").unwrap();
    let text = format!("{}{}{}{}", &SIMPLE[..start], &SIMPLE[faces..end], &SIMPLE[start..faces], &SIMPLE[end..]);
    assert_eq!(read(&text), Ok(square()));
    assert_eq!(read(text.replace("\"4\"", "\"9\"").replace("2 4 3", "2 9 3")), Ok(square()));
}

#[test]
fn errors_name_the_place() {
    for (from, to, said) in [
        ("10 1 -2000", "10 1", "byte 110: expected northing, easting and elevation, found \"10 1\""),
        ("10 1 -2000", "10 1 -2000 5", "expected northing, easting and elevation, found \"10 1 -2000 5\""),
        ("10 1 -2000", "10,5 1 2", "expected northing, easting and elevation, found \"10,5 1 2\""),
        ("10 1 -2000", "10 1 <a/>", "expected three numbers in P or F, and no elements, found \"a\""),
        ("10 1 -2000", "10 1 &a;", "expected northing, easting and elevation, found \"10 1 &\""),
        ("<P id=\"2\">", "<P>", "expected P with an id, a whole number, found \"\""),
        ("id=\"2\"", "id=\"b2\"", "expected P with an id, a whole number, found \"b2\""),
        ("id=\"2\"", "id=\"2", "expected XML, found an error"),
        ("<P id=\"2\">10 1 -2000</P>", "<P id=\"2\"/>", "expected northing, easting and elevation, found \"\""),
        ("<F>1 2 3", "<F>1 2 3 4", "expected the ids of a triangle's three points, found \"1 2 3 4\""),
        ("<F>1 2 3", "<F>1 2 -3", "expected the ids of a triangle's three points"),
        ("<F>1 2 3", "<F>1 2 5", "face 0: expected ids of points, found 5"),
        ("</Faces>", "</Fces>", "expected XML, found an error"),
        ("</LandXML>", "", "expected </LandXML>, found the end of the file"),
        ("</LandXML>", "</LandXML>more", "expected one element LandXML, and no text beside it, found \"more\""),
        ("</LandXML>", "</LandXML><a/>", "expected one element LandXML, found \"a\""),
        ("LandXML", "LandGML", "byte 9: expected one element LandXML, found \"LandGML\""),
        ("\"TIN\"", "\"grid\"", "expected one surface of type TIN, found one of type \"grid\""),
        ("Definition", "Watersheds", "expected one surface of type TIN, found none with a definition"),
    ] {
        let error = read(SIMPLE.replace(from, to)).unwrap_err();
        assert!(error.contains(said), "{to}: {error}");
    }
    let start = SIMPLE.find("<Surface ").unwrap();
    let end = SIMPLE.find("</Surfaces>").unwrap();
    let again = SIMPLE[start..end].replace("\"a\"", "\"b &amp; c\"");
    let two = format!("{}{again}{}", &SIMPLE[..end], &SIMPLE[end..]);
    assert_eq!(read(two).unwrap_err(), "expected one surface of type TIN, found 2: a, b & c");
    assert_eq!(read("").unwrap_err(), "expected </LandXML>, found the end of the file");
}

#[test]
fn what_is_too_much() {
    let deep = SIMPLE.replace("<Surfaces>", &format!("{}{}<Surfaces>", "<a>".repeat(300), "</a>".repeat(300)));
    assert!(read(deep).unwrap_err().contains("expected at most 256 nested elements, found more"));
    let long = SIMPLE.replace("10 1 -2000", &format!("10 1 {}2", " ".repeat(5000)));
    assert!(read(long).unwrap_err().contains("expected at most 4096 bytes of three numbers"));
    let name = SIMPLE.replace("<Surfaces>", &format!("<{}/><Surfaces>", "a".repeat(2000)));
    assert!(read(name).unwrap_err().contains("expected at most 1024 bytes of an element's name"));
    for endless in ["<!-- ", "<a b=\"", ""] {
        let endless = SIMPLE.replace("<Surfaces>", &format!("{endless}{}", "x".repeat(17 << 20)));
        let error = read(endless).unwrap_err();
        assert!(error.contains("expected at most 16777216 bytes of a tag or text, found more"), "{error}");
    }
}

#[test]
fn what_terrabite_has_written_must_be_whole() {
    let told = |vertices: u64, triangles: u64| {
        let facts = format!(
            "</Definition><Feature code=\"terrabite\"><Property label=\"vertices\" value=\"{vertices}\"/>\
             <Property label=\"triangles\" value=\"{triangles}\"/><Property label=\"fact\" value=\"note \\\\ \\u0000\"/></Feature>"
        );
        SIMPLE.replace("</Definition>", &facts)
    };
    assert_eq!(read(told(4, 2)), Ok(square()));
    assert_eq!(read(told(5, 2)).unwrap_err(), "expected 5 vertices, as the property of this name says, found 4");
    assert_eq!(read(told(4, 1)).unwrap_err(), "expected 1 triangles, as the property of this name says, found 2");
    let file = file(told(4, 2).as_bytes());
    assert_eq!(opened(file.path()).unwrap().header().notes, ["note \\ \u{0}"]);
}

#[test]
fn a_file_that_changes_between_passes_is_an_error() {
    let file = file(SIMPLE.as_bytes());
    let mut reader = opened(file.path()).unwrap();
    let reader: &mut dyn MeshReader = &mut reader;
    let mut pass = |text: &str| {
        std::fs::write(file.path(), text).unwrap();
        let vertices = reader.for_each_vertex(|_, _| Ok::<(), ReadError>(())).map_err(|e| e.to_string());
        let faces = reader.for_each_face(|_, _| Ok::<(), ReadError>(())).map_err(|e| e.to_string());
        [vertices, faces].map(|pass| pass.err().unwrap_or_default())
    };
    let [vertices, faces] = pass(&SIMPLE.replace("<P id=\"4\">11 1 0.25</P>", "").replace("<F>2 4 3</F>", ""));
    assert!(vertices.contains("expected 4 points, as when it was opened, found 3"), "{vertices}");
    assert!(faces.contains("expected 2 faces, as when it was opened, found 1"), "{faces}");
    let [vertices, faces] =
        pass(&SIMPLE.replace("</Pnts>", "<P id=\"5\">1 1 1</P></Pnts>").replace("</Faces>", "<F>1 2 3</F></Faces>"));
    assert!(vertices.contains("found 5") && faces.contains("found 3"), "{vertices} {faces}");
    let [vertices, faces] = pass(&SIMPLE[..200]);
    assert!(!vertices.is_empty() && !faces.is_empty());
    assert_eq!(pass(SIMPLE), ["", ""]);
    assert!(matches!(opened("no/such/file".as_ref()), Err(ReadError::Io { .. })));
}

#[test]
fn recognised() {
    for (beginning, expected) in [
        (SIMPLE.as_bytes(), Recognised::Surely),
        (b"\xef\xbb\xbf\n<?xml version='1.0'?><!-- x --><LandXML\n", Recognised::Surely),
        (b"<a:LandXML>", Recognised::Surely),
        (b"<?xml version='1.0'?><gml/>", Recognised::No),
        (b"ply\n<LandXML>", Recognised::No),
        (b"<LandXMLs>", Recognised::No),
        (b"", Recognised::No),
    ] {
        assert_eq!(recognise(beginning), expected);
    }
}
