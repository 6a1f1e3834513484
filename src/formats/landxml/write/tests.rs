//! LandXML, line by line.

use super::*;
use crate::base::CoordinateFrame;
use crate::formats::{Crs, Heights};

fn written(header: Header) -> String {
    let folder = crate::testing::folder();
    let path = folder.path().join("tin.xml");
    let mut sink =
        LandXmlSink::new(StagedFile::create(&path, false, &[]).expect("staged"), Setup { header, ..Setup::default() });
    sink.begin(&Contents { vertices: 3, triangles: 1, ..Contents::default() }).expect("begun");
    sink.vertices(&[[0.5, -0.5, 1.25], [1e-7, -0.0, 1e22]], &[]).expect("written");
    sink.vertices(&[[0.1, 2.0, -7.0]], &[]).expect("written");
    sink.triangles(&[[0, 2, 1]], &[]).expect("written");
    Box::new(sink).finish().expect("finished");
    std::fs::read_to_string(&path).expect("text")
}

/// Edges that go on from each other are one line; without any the file is as it would be.
#[test]
fn edges_are_breaklines_of_the_source_data() {
    let folder = crate::testing::folder();
    let with = |edges: &[LineEdge<[f64; 3]>]| {
        let path = folder.path().join("tin.xml");
        let staged = StagedFile::create(&path, true, &[]).expect("staged");
        let mut sink = LandXmlSink::new(staged, Setup::default());
        let contents = Contents { vertices: 3, triangles: 1, edges: edges.len() as u64, ..Contents::default() };
        sink.begin(&contents).expect("begun");
        sink.lines(edges).expect("written");
        sink.vertices(&[[0.5, -0.5, 1.25], [3.0, 4.0, 5.0], [6.0, 7.0, 8.0]], &[]).expect("written");
        sink.triangles(&[[0, 2, 1]], &[]).expect("written");
        Box::new(sink).finish().expect("finished");
        std::fs::read_to_string(&path).expect("text")
    };
    let [a, b, c] = [[0.5, -0.5, 1.25], [3.0, 4.0, 5.0], [6.0, 7.0, 8.0]];
    let source = "<SourceData>\n<Breaklines>\n\
        <Breakline brkType=\"standard\"><PntList3D>-0.5 0.5 1.25 4 3 5</PntList3D></Breakline>\n\
        <Breakline brkType=\"standard\"><PntList3D>7 6 8 4 3 5 -0.5 0.5 1.25</PntList3D></Breakline>\n\
        <Breakline brkType=\"standard\" desc=\"soft\"><PntList3D>-0.5 0.5 1.25 7 6 8</PntList3D></Breakline>\n\
        </Breaklines>\n</SourceData>\n<Definition surfType=\"TIN\">";
    let hard = |from, to| LineEdge { ends: [from, to], line_type: LineType::Hard };
    let soft = LineEdge { ends: [a, c], line_type: LineType::Soft };
    let (marked, plain) = (with(&[hard(a, b), hard(c, b), hard(b, a), soft]), with(&[]));
    assert!(marked.contains(source), "{marked}");
    assert!(marked.contains("<Property label=\"edges\" value=\"4\"/>\n"));
    let without = marked.replace(source, "<Definition surfType=\"TIN\">");
    assert_eq!(without.replace("<Property label=\"edges\" value=\"4\"/>\n", ""), plain);
}

fn named(definition: &str, unit: &str) -> Header {
    let text = |text: &str| Some(text.to_string());
    let crs =
        Crs { definition: text(definition), name: text("WGS 84 / UTM \"33N\""), unit: text(unit), ..Crs::default() };
    Header { made_by: text("terrabite 0.1.0"), source: text("a&b.tif"), crs, ..Header::default() }
}

#[test]
fn a_mesh_line_by_line() {
    let text = written(named("EPSG:32633", "metre"));
    let lines: Vec<&str> = text.split('\n').collect();
    assert_eq!(lines[0], "<?xml version=\"1.0\" encoding=\"UTF-8\"?>");
    assert!(lines[1].starts_with("<LandXML xmlns=\"http://www.landxml.org/schema/LandXML-1.2\" xmlns:xsi="));
    assert!(
        lines[1].ends_with(
            " version=\"1.2\" date=\"2000-01-01\" time=\"00:00:00\" readOnly=\"false\" language=\"English\">"
        )
    );
    let expected = [
        "<Units><Metric areaUnit=\"squareMeter\" linearUnit=\"meter\" volumeUnit=\"cubicMeter\" temperatureUnit=\"celsius\" \
         pressureUnit=\"milliBars\"/></Units>",
        "<CoordinateSystem desc=\"WGS 84 / UTM &quot;33N&quot;\" epsgCode=\"32633\"/>",
        "<Project name=\"a&amp;b.tif\"/>",
        "<Application name=\"terrabite\" version=\"0.1.0\"/>",
        "<Surfaces>",
        "<Surface name=\"a&amp;b.tif\" desc=\"terrain, northing easting elevation\">",
        "<Definition surfType=\"TIN\">",
        "<Pnts>",
        "<P id=\"1\">-0.5 0.5 1.25</P>",
        "<P id=\"2\">-0 1e-7 1e22</P>",
        "<P id=\"3\">2 0.1 -7</P>",
        "</Pnts>",
        "<Faces>",
        "<F>1 3 2</F>",
        "</Faces>",
        "</Definition>",
        "<Feature code=\"terrabite\">",
        "<Property label=\"vertices\" value=\"3\"/>",
        "<Property label=\"triangles\" value=\"1\"/>",
        "<Property label=\"fact\" value=\"made by terrabite 0.1.0\"/>",
        "<Property label=\"fact\" value=\"source a&amp;b.tif\"/>",
        "<Property label=\"fact\" value=\"crs:EPSG:32633\"/>",
        "<Property label=\"fact\" value=\"crs name WGS 84 / UTM &quot;33N&quot;\"/>",
        "</Feature>",
        "</Surface>",
        "</Surfaces>",
        "</LandXML>",
    ];
    assert_eq!(lines[2..], expected);
}

#[test]
fn units_of_length() {
    let line = |unit: &str| written(named("EPSG:2227", unit)).split('\n').skip(2).take(2).collect::<Vec<_>>().join("|");
    for (unit, expected) in [
        ("metre", "<Units><Metric areaUnit=\"squareMeter\" linearUnit=\"meter\""),
        ("US survey foot", "<Units><Imperial areaUnit=\"squareFoot\" linearUnit=\"USSurveyFoot\""),
        ("foot", "<Units><Imperial areaUnit=\"squareFoot\" linearUnit=\"foot\""),
        ("degree", "<!-- x and y are in degree, which LandXML has no word for -->|<Units><Metric "),
        ("a--b\n->", "<!-- x and y are in a- -b ->, which LandXML has no word for -->|<Units><Metric "),
    ] {
        assert!(line(unit).starts_with(expected), "{}", line(unit));
    }
    let heights = Heights { unit: Some("ft".to_string()), ..Heights::default() };
    let header = Header { heights, ..named("EPSG:32633", "metre") };
    assert!(written(header.clone()).contains("milliBars\" elevationUnit=\"feet\"/>"));
    let frame = CoordinateFrame { z_scale: 0.5, ..CoordinateFrame::PLAIN };
    assert!(!written(Header { frame, ..header }).contains("elevationUnit"));
}

#[test]
fn only_map_coordinates_have_a_coordinate_system() {
    assert!(written(named("GEOGCS[\"x\"]", "degree")).contains(" ogcWktCode=\"GEOGCS[&quot;x&quot;]\"/>"));
    let frame = CoordinateFrame { origin: (0.25, 0.0), ..CoordinateFrame::PLAIN };
    let text = written(Header { frame, ..named("EPSG:32633", "metre") });
    assert!(!text.contains("CoordinateSystem") && text.contains("value=\"map crs EPSG:32633\""), "{text}");
    assert!(text.contains("value=\"offset 0.25 0\"") && text.contains("<P id=\"1\">-0.5 0.25 1.25</P>"), "{text}");
    assert!(!written(Header::default()).contains("CoordinateSystem"));
}
