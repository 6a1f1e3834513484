//! `verify --checkpoints`: surveyed heights against the mesh.

use serde_json::Value;

use crate::util::{Dem, Folder, terrabite};

/// A plane that rises by 1 to the right and by 10 downwards, ten metres a cell, and its mesh.
fn plane(folder: &Folder) -> (String, String) {
    let dem = Dem::new(40, 30).on_the_map().heights(|column, row| (column + 10 * row) as f64).write(folder, "dem.tif");
    let tin = folder.at("tin.ply");
    terrabite(["simplify", &dem, &tin, "--max-error", "0"]).succeeds();
    (dem, tin)
}

/// The plane at a place on the map, as a line of a table that is `off` too low for the mesh.
fn line(x: f64, y: f64, off: f64, more: &str) -> String {
    let z = (x - 500_005.0) / 10.0 + 10.0 * (5_199_995.0 - y) / 10.0;
    format!("{x},{y},{}{more}\n", z - off)
}

fn judged(folder: &Folder, table: &str, more: &[&str]) -> Value {
    let (dem, tin) = (folder.at("dem.tif"), folder.at("tin.ply"));
    let csv = folder.with("gcp.csv", table);
    let run = ["verify", &dem, &tin, "--max-error", "0", "--json", "--checkpoints", &csv];
    terrabite(run.iter().chain(more)).succeeds().json()["checkpoints"].clone()
}

#[test]
fn residuals_are_mesh_less_checkpoint() {
    let folder = Folder::new();
    plane(&folder);
    let offs = [0.3, -0.1, 0.0, 0.2, -0.4];
    let mut table = "x,y,z,id,cover\n".to_string();
    for (i, off) in offs.iter().enumerate() {
        table += &line(500_050.0 + 37.1 * i as f64, 5_199_950.0 - 41.3 * i as f64, *off, &format!(",A{i},N"));
    }
    // On a sample, on the rim, on the corner; one step beyond it, far away.
    table += &line(500_105.0, 5_199_895.0, 1.0, ",on a sample,V");
    table += &line(500_005.0, 5_199_800.0, 2.0, ",on the rim,V");
    table += &line(500_005.0, 5_199_995.0, -3.0, ",corner,");
    table += &line(500_004.9, 5_199_800.0, 7.0, ",off,N");
    table += &line(9e9, -9e9, 7.0, ",far off,V");
    let found = judged(&folder, &table, &[]);
    let number = |path: &str| found.pointer(path).unwrap().as_f64().unwrap();
    let near = |path: &str, expected: f64| assert!((number(path) - expected).abs() < 1e-6, "{path}: {}", number(path));
    assert_eq!((number("/read"), number("/off_mesh"), number("/all/count")), (10.0, 2.0, 8.0));
    near("/non_vegetated/mean", 0.0);
    near("/non_vegetated/median", 0.0);
    near("/non_vegetated/rmse", 0.06f64.sqrt());
    near("/nva", 1.96 * 0.06f64.sqrt());
    near("/vegetated/mean", 1.5);
    // Ranks of 1 and 2: 1 + 0.95 · 1.
    near("/vva", 1.95);
    near("/all/max", 3.0);
    assert_eq!(found["worst"][0]["id"], "corner");
    assert_eq!(found["worst"].as_array().unwrap().len(), 8);
    near("/worst/0/residual", -3.0);
    near("/worst/1/residual", 2.0);
    near("/worst/1/surface", 19.5 * 10.0);
}

#[test]
fn places_in_another_crs_are_brought_into_the_rasters() {
    let folder = Folder::new();
    plane(&folder);
    // EPSG:4326 of x 500100, y 5199800 in UTM 33 N, by PROJ; x is longitude.
    let table = "X;Y;Z\n15.0013134;46.9508;1000\n";
    let transformed = std::process::Command::new("gdaltransform")
        .args(["-s_srs", "EPSG:32633", "-t_srs", "EPSG:4326", "-output_xy"])
        .stdin(std::process::Stdio::piped())
        .stdout(std::process::Stdio::piped())
        .spawn()
        .and_then(|mut child| {
            use std::io::Write;
            child.stdin.take().unwrap().write_all(b"500100 5199800\n")?;
            child.wait_with_output()
        })
        .unwrap();
    let place = String::from_utf8(transformed.stdout).unwrap();
    let (longitude, latitude) = place.trim().split_once(' ').unwrap();
    let table = table.replace("15.0013134", longitude).replace("46.9508", latitude);
    let found = judged(&folder, &table, &["--checkpoints-crs", "EPSG:4326"]);
    let surface = found["worst"][0]["surface"].as_f64().unwrap();
    assert!((surface - (9.5 + 195.0)).abs() < 1e-4, "{surface}");
    assert_eq!(judged(&folder, &table, &[])["off_mesh"], 1);
}

#[test]
fn tables_that_cannot_be_used_are_named() {
    let folder = Folder::new();
    let (dem, tin) = plane(&folder);
    let judge = |table: &str, more: &[&str]| {
        terrabite(["verify", &dem, &tin, "--max-error", "0", "--checkpoints", table].iter().chain(more))
    };
    judge(&folder.at("none.csv"), &[]).fails(1, &["none.csv", "--checkpoints"]);
    judge(&folder.with("a.csv", "a,b\n1,2\n"), &[]).fails(1, &["a.csv", "x, y and z", "a,b"]);
    judge(&folder.with("b.csv", "x,y,z\n1,2,high\n"), &[]).fails(1, &["b.csv, line 2", "a number for z", "high"]);
    let good = folder.with("c.csv", "x,y,z\n1,2,3\n");
    judge(&good, &["--checkpoints-crs", "EPSG:nothing"]).fails(1, &["c.csv", "--checkpoints-crs"]);
    let run = terrabite(["verify", &dem, &tin, "--max-error", "0", "--checkpoints-crs", "EPSG:4326"]);
    run.fails(2, &["--checkpoints"]);
}
