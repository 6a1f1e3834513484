//! Edges that follow breaklines, as formats mark them, and as `convert` hands them on.

use std::collections::HashSet;
use std::path::Path;

use serde_json::{Value, json};
use terrabite::base::{LineEdge, LineType};
use terrabite::formats::{ReadError, ReadOptions, open};

use crate::breaklines::{LINES, Scene};
use crate::util::terrabite;

/// The places of both ends of an edge, and its type.
type Edge = LineEdge<[u64; 3]>;

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
        assert!(sides.contains(&edge.ends), "{path}: {edge:?}");
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

/// A soft line crosses a hard one and shares a stretch with another; verify does not ask of what type they are.
#[test]
fn types_of_lines_are_marked_and_change_no_verdict() {
    let scene = Scene::new();
    let at = |name: &str| scene.folder.at(name);
    let lines: [&[(f64, f64)]; 3] = [
        &[(1.3, 2.7), (16.0, 9.2), (38.9, 27.4)],
        &[(16.0, 9.2), (38.9, 27.4), (38.9, 29.0)],
        &[(3.0, 22.0), (30.0, 4.0)],
    ];
    let layer = |name: &str, types: [Value; 3]| {
        let feature = |(line, line_type): (&&[(f64, f64)], Value)| {
            let place =
                |&(c, r): &(f64, f64)| json!([500_000.0 + (c + 0.5) * 10.0, 5_200_000.0 - (r + 0.5) * 10.0, 40.0]);
            let geometry = json!({"type": "LineString", "coordinates": line.iter().map(place).collect::<Vec<_>>()});
            json!({"type": "Feature", "properties": {"kind": line_type}, "geometry": geometry})
        };
        let features: Vec<Value> = lines.iter().zip(types).map(feature).collect();
        let crs = json!({"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::32633"}});
        scene.folder.with(name, json!({"type": "FeatureCollection", "crs": crs, "features": features}).to_string())
    };
    let mixed = layer("mixed.geojson", [json!("hard"), json!("Soft_Line"), json!("soft")]);
    let by_field = ["--breakline-type", "field:kind"];
    let report = scene.simplify(&mixed, &by_field).succeeds().json();
    scene.verify(&mixed, &[]).succeeds();
    let expected = edges(&at("tin.ply"));
    let soft = expected.iter().filter(|edge| edge.line_type == LineType::Soft).count() as u64;
    let told = &report["breaklines"];
    assert_eq!((&told["types"], &told["soft_edges"], &told["lines"]), (&json!("field:kind"), &json!(soft), &json!(3)));
    assert!(soft > 3 && soft + 3 < expected.len() as u64, "{soft} of {}", expected.len());
    // The hard line is hard from end to end; the others are soft, but where they are it.
    for edge in &expected {
        let place = |axis: usize| edge.ends.map(|end| f64::from_bits(end[axis])).iter().sum::<f64>() / 2.0;
        let (c, r) = ((place(0) - 500_000.0) / 10.0 - 0.5, (5_200_000.0 - place(1)) / 10.0 - 0.5);
        let along = if c < 16.0 { 2.7 + (c - 1.3) / 14.7 * 6.5 } else { 9.2 + (c - 16.0) / 22.9 * 18.2 };
        let is_hard = (r - along).abs() < 0.6 && c < 38.8;
        assert_eq!(edge.line_type == LineType::Hard, is_hard, "{c}, {r}");
    }
    // In every format, after every conversion, in shards, and beside heights of the lines.
    for (name, options) in [("text.ply", &["--ascii"][..]), ("tin.xml", &[]), ("tin.gpkg", &[])] {
        let command = ["simplify", &scene.dem, &at(name), "--max-error", "3", "--tile", "16", "--breaklines", &mixed];
        terrabite(command.iter().chain(&by_field).chain(options)).succeeds();
        assert_eq!(edges(&at(name)), expected, "{name}");
    }
    for (from, to) in
        [("tin.ply", "1.xml"), ("1.xml", "2.gpkg"), ("2.gpkg", "3.ply"), ("3.ply", "4.gpkg"), ("4.gpkg", "5.ply")]
    {
        terrabite(["convert", &at(from), &at(to)]).succeeds();
        assert_eq!(edges(&at(to)), expected, "{to}");
    }
    scene.simplify(&mixed, &[&by_field[..], &["--breakline-z", "line"]].concat()).succeeds();
    scene.verify(&mixed, &["--breakline-z", "line"]).succeeds();
    assert!(edges(&at("tin.ply")).iter().any(|edge| edge.line_type == LineType::Soft));
    // All of one type: the same mesh, with other marks or none.
    let hard = {
        scene.simplify(&mixed, &[]).succeeds();
        scene.written()
    };
    let report = scene.simplify(&mixed, &["--breakline-type", "soft"]).succeeds().json();
    assert_eq!(report["breaklines"]["soft_edges"], report["breaklines"]["chains"]["edges"]);
    let header = String::from_utf8_lossy(&scene.written()[..1500]).into_owned();
    assert!(header.contains("property uint vertex2\nproperty uchar soft\n"), "{header}");
    let plain = edges(&at("tin.ply")).iter().map(|edge| edge.ends).collect::<Vec<_>>();
    std::fs::write(at("tin.ply"), &hard).unwrap();
    assert_eq!(edges(&at("tin.ply")).iter().map(|edge| edge.ends).collect::<Vec<_>>(), plain);
    assert!(!String::from_utf8_lossy(&hard[..1500]).contains("soft"));
    // What cannot be a type.
    let odd = layer("odd.geojson", [json!("hard"), json!("firm"), json!("soft")]);
    scene.simplify(&odd, &by_field).fails(
        1,
        &[
            "odd: expected the text hard or soft in field kind of feature 1, found the text \"firm\"",
            "--breakline-type",
        ],
    );
    scene.simplify(&mixed, &["--breakline-type", "firm"]).fails(2, &["expected hard, soft or field:NAME"]);
    terrabite(scene.command("simplify", &["--breakline-type", "soft"])).fails(2, &["--breaklines"]);
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
