//! Edges that follow breaklines, as formats mark them, and as `convert` hands them on.

use std::collections::HashSet;
use std::path::Path;

use serde_json::Value;
use terrabite::formats::{ReadError, ReadOptions, open};

use crate::breaklines::{LINES, Scene};
use crate::util::terrabite;

/// The places of both ends of an edge.
type Edge = [[u64; 3]; 2];

/// Marked edges of a mesh, each of which must be a side of a triangle.
fn edges(path: &str) -> Vec<Edge> {
    let mut mesh = open(Path::new(path), None, &ReadOptions::default()).unwrap();
    let (mut vertices, mut sides, mut edges) = (Vec::new(), HashSet::new(), Vec::new());
    mesh.for_each_vertex(|_, place| {
        vertices.push(place.map(f64::to_bits));
        Ok::<(), ReadError>(())
    })
    .unwrap();
    mesh.for_each_face(|_, [a, b, c]| {
        sides.extend([[a, b], [b, a], [b, c], [c, b], [c, a], [a, c]]);
        Ok::<(), ReadError>(())
    })
    .unwrap();
    mesh.for_each_edge(|_, edge| {
        assert!(sides.contains(&edge), "{path}: {edge:?}");
        edges.push(edge.map(|vertex| vertices[vertex as usize]));
        Ok::<(), ReadError>(())
    })
    .unwrap();
    edges
}

#[test]
fn edges_are_marked_where_formats_have_a_place_and_go_on_with_convert() {
    let scene = Scene::new();
    let lines = scene.layer("roads.geojson", &LINES);
    let at = |name: &str| scene.folder.at(name);
    let simplify = |name: &str, options: &[&str]| {
        let tin = at(name);
        let command =
            ["simplify", &scene.dem, &tin, "--max-error", "3", "--tile", "16", "--json", "--breaklines", &lines];
        let report = terrabite(command.iter().chain(options)).succeeds().json();
        (edges(&tin), report["breaklines"]["chains"]["edges"].as_u64().unwrap())
    };
    let (expected, told) = simplify("tin.ply", &[]);
    assert!(expected.len() as u64 == told && told > 10, "{} of {told}", expected.len());
    for (name, options) in [("text.ply", &["--ascii"][..]), ("tin.xml", &[]), ("tin.gpkg", &[])] {
        assert_eq!(simplify(name, options).0, expected, "{name}");
    }
    for name in ["tin.fgb", "tin.obj", "tin.glb"] {
        assert!(simplify(name, &[]).0.is_empty(), "{name}");
    }
    let header = String::from_utf8_lossy(&std::fs::read(at("tin.ply")).unwrap()).to_string();
    assert!(
        header.contains(&format!("\nelement edge {told}\nproperty uint vertex1\nproperty uint vertex2\nend_header"))
    );
    let convert = |from: &str, to: &str| -> Value {
        terrabite(["convert", &at(from), &at(to), "--json", "--overwrite"]).succeeds().json()
    };
    for (from, to) in [
        ("tin.ply", "1.xml"),
        ("1.xml", "2.gpkg"),
        ("2.gpkg", "3.ply"),
        ("3.ply", "4.gpkg"),
        ("4.gpkg", "5.xml"),
        ("5.xml", "6.ply"),
    ] {
        assert_eq!(convert(from, to)["edges"], told, "{to}");
        assert_eq!(edges(&at(to)), expected, "{to}");
        terrabite(["verify", &scene.dem, &at(to), "--max-error", "3", "--breaklines", &lines]).succeeds();
    }
    for to in ["tin.fgb", "tin.vtp"] {
        let report = convert("tin.ply", to);
        let codes: Vec<&str> =
            report["warnings"].as_array().unwrap().iter().map(|w| w["code"].as_str().unwrap()).collect();
        assert!(report["edges"] == 0 && codes.contains(&"edges_lost"), "{to}: {codes:?}");
        assert!(edges(&at(to)).is_empty());
    }
    // Less an origin, in single precision.
    let (local, _) = simplify("local.xml", &["--local", "--precision", "float"]);
    assert!(local.len() > 10 && local[0] != expected[0]);
}

/// What others have written, or damaged.
#[test]
fn ends_that_are_no_vertices_are_refused_where_edges_are_read() {
    let scene = Scene::new();
    let lines = scene.layer("roads.geojson", &LINES);
    let [ply, xml, out] = ["tin.ply", "tin.xml", "out.ply"].map(|name| scene.folder.at(name));
    let simplify = |tin: &str, options: &[&str]| {
        let command = ["simplify", &scene.dem, tin, "--max-error", "3", "--breaklines", &lines];
        terrabite(command.iter().chain(options)).succeeds();
        std::fs::read_to_string(tin).unwrap()
    };
    let text = simplify(&ply, &["--ascii"]);
    let last = text.trim_end().rsplit('\n').next().unwrap();
    std::fs::write(&ply, text.replace(&format!("\n{last}\n"), "\n7 999999\n")).unwrap();
    terrabite(["convert", &ply, &out]).fails(1, &["tin.ply: edge ", "expected two vertices, found another number"]);
    terrabite(["verify", &scene.dem, &ply, "--max-error", "3", "--breaklines", &lines]).succeeds();
    let text = simplify(&xml, &[]);
    let moved = text.replacen("<PntList3D>", "<PntList3D>7", 1);
    std::fs::write(&xml, moved).unwrap();
    terrabite(["convert", &xml, &out]).fails(1, &["tin.xml: edge 0: expected two vertices, found another place"]);
    let fewer = text.replacen("<Property label=\"edges\" value=\"", "<Property label=\"edges\" value=\"1", 1);
    std::fs::write(&xml, fewer).unwrap();
    terrabite(["convert", &xml, &out]).fails(1, &["tin.xml: expected 1", "edges, as the property of this name says"]);
    // Breaklines of others need not be edges.
    let others = text.replace("<Property label=\"edges\"", "<Property label=\"lines\"");
    std::fs::write(&xml, others.replacen("<PntList3D>", "<PntList3D>a b", 1)).unwrap();
    terrabite(["convert", &xml, &out]).succeeds();
    assert!(edges(&out).is_empty());
}
