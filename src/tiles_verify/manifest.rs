//! The manifests: whether they are true, and say what clients need.

use std::collections::BTreeSet;
use std::path::Path;

use serde_json::Value;

use super::ellipsoid::Ellipsoid;
use super::findings::{Findings, Kind};
use crate::pyramid::{LAYER, Promise, PyramidError, TileKey};

/// What a tile is cut into at the most, each way.
const MAX_PARTS: u32 = 128;

/// The tiles that there are as files, found by looking.
pub(super) fn files(folder: &Path) -> Result<BTreeSet<TileKey>, PyramidError> {
    let failed = |path: &Path| {
        let path = path.to_path_buf();
        move |source| PyramidError::File { path, source }
    };
    let mut found = BTreeSet::new();
    let numbered = |path: &Path| -> Result<Vec<(u32, std::path::PathBuf)>, PyramidError> {
        let mut all = Vec::new();
        for entry in path.read_dir().map_err(failed(path))? {
            let path = entry.map_err(failed(path))?.path();
            let stem = path.file_stem().and_then(|s| s.to_str()).and_then(|s| s.parse().ok());
            all.extend(stem.map(|number| (number, path)));
        }
        Ok(all)
    };
    for (level, folder) in numbered(folder)?.into_iter().filter(|(_, path)| path.is_dir()) {
        for (x, folder) in numbered(&folder)?.into_iter().filter(|(_, path)| path.is_dir()) {
            for (y, path) in numbered(&folder)? {
                if path.extension().is_some_and(|e| e == "terrain") {
                    found.insert(TileKey { level, x, y });
                }
            }
        }
    }
    Ok(found)
}

/// Judges `layer.json` by what it must say.
pub(super) fn judge_layer(folder: &Path, found: &BTreeSet<TileKey>, levels: usize, findings: &mut Findings) {
    let path = folder.join(LAYER);
    let text = match std::fs::read_to_string(&path) {
        Ok(text) => text,
        Err(e) => return findings.add(Kind::Manifest, || format!("{}: {e}", path.display())),
    };
    let layer: Value = match serde_json::from_str(&text) {
        Ok(layer) => layer,
        Err(e) => return findings.add(Kind::Manifest, || format!("{}: {e}", path.display())),
    };
    let name = path.display();
    let mut expect = |what: &str, is_so: bool| {
        if !is_so {
            findings.add(Kind::Manifest, || {
                format!("{name}: expected {what}, found {}", layer[what.split(' ').next().unwrap_or_default()])
            });
        }
    };
    let strings = |value: &Value| -> Vec<String> {
        value.as_array().into_iter().flatten().filter_map(|v| v.as_str().map(str::to_string)).collect()
    };
    expect("format quantized-mesh-1.0", layer["format"] == "quantized-mesh-1.0");
    expect("scheme tms", layer["scheme"] == "tms");
    expect("projection EPSG:4326", layer["projection"] == "EPSG:4326");
    expect("version as text", layer["version"].as_str().is_some_and(|v| !v.is_empty()));
    let names_files = |t: &String| t.split('?').next() == Some("{z}/{x}/{y}.terrain");
    expect("tiles {z}/{x}/{y}.terrain", strings(&layer["tiles"]).first().is_some_and(names_files));
    expect("extensions with octvertexnormals", strings(&layer["extensions"]).contains(&"octvertexnormals".to_string()));
    expect("minzoom 0", layer["minzoom"] == 0);
    expect("maxzoom of the deepest level", layer["maxzoom"] == levels.saturating_sub(1));
    let deepest: Vec<&TileKey> = found.iter().filter(|k| k.level as usize + 1 == levels).collect();
    let side = 180.0 / 2f64.powi(levels as i32 - 1);
    let least = |of: fn(&TileKey) -> u32| deepest.iter().map(|k| of(k)).min().map_or(0.0, f64::from);
    let most = |of: fn(&TileKey) -> u32| deepest.iter().map(|k| of(k)).max().map_or(0.0, |last| f64::from(last) + 1.0);
    let bounds = [
        least(|k| k.x) * side - 180.0,
        least(|k| k.y) * side - 90.0,
        most(|k| k.x) * side - 180.0,
        most(|k| k.y) * side - 90.0,
    ];
    let said: Vec<f64> = layer["bounds"].as_array().into_iter().flatten().filter_map(Value::as_f64).collect();
    expect("bounds of the deepest tiles", said == bounds);
    let mut listed = BTreeSet::new();
    let mut is_sound = layer["available"].as_array().is_some_and(|a| a.len() == levels);
    for (level, ranges) in (0..).zip(layer["available"].as_array().into_iter().flatten()) {
        for range in ranges.as_array().into_iter().flatten() {
            let number = |name: &str| range[name].as_u64().and_then(|n| u32::try_from(n).ok());
            let (Some(x0), Some(x1)) = (number("startX"), number("endX")) else { return is_unsound(findings, &path) };
            let (Some(y0), Some(y1)) = (number("startY"), number("endY")) else { return is_unsound(findings, &path) };
            let size = (f64::from(x1) - f64::from(x0) + 1.0) * (f64::from(y1) - f64::from(y0) + 1.0);
            // Listed tiles that are not there are found below, without listing more than that.
            if size > found.len() as f64 {
                is_sound = false;
                continue;
            }
            for key in (x0..=x1).flat_map(|x| (y0..=y1).map(move |y| TileKey { level, x, y })) {
                is_sound &= listed.insert(key);
            }
        }
    }
    if !is_sound || listed != *found {
        let missing = listed.difference(found).next().or_else(|| found.difference(&listed).next());
        let case = missing.map_or(String::new(), |key| format!(", tile {key} among them"));
        findings
            .add(Kind::Manifest, || format!("{}: available tiles are not those that there are{case}", path.display()));
    }
}

fn is_unsound(findings: &mut Findings, path: &Path) {
    findings.add(Kind::Manifest, || format!("{}: a range of available tiles is incomplete", path.display()));
}

/// Judges whether the promise is one that clients can use: every level within what they take for granted, and within twice the
/// next finer one, unless triangles sag too far for that, or no tiles could be made.
pub(super) fn judge_promise(promise: &Promise, ellipsoid: &Ellipsoid, coarsest: u32, findings: &mut Findings) {
    if promise.grid_exponent < coarsest {
        let found = promise.grid_exponent;
        findings.add(Kind::Manifest, || {
            format!("the grid of 2^{found} cells is coarser than the raster, which asks for 2^{coarsest}")
        });
    }
    let version = promise.generator.strip_prefix("terrabite ").filter(|version| !version.is_empty());
    if version.is_none() {
        let found = &promise.generator;
        findings
            .add(Kind::Manifest, || format!("expected the generator \"terrabite\" and its version, found \"{found}\""));
    }
    let mut below = 0.5 * promise.max_error;
    for (i, level) in promise.levels.iter().enumerate().rev() {
        let client = ellipsoid.client_error(i as u32);
        let is_finest = i + 1 == promise.levels.len();
        let least = if is_finest { 0.0 } else { 4.0 * ellipsoid.sag(i as u32, promise.grid_exponent) };
        let loosest = promise.error_factor * client;
        let expected = (2.0 * below).max(least).min(loosest);
        below = expected;
        let is_near = |found: f64, expected: f64| (found - expected).abs() <= 1e-9 * expected;
        let is_loosened = !is_finest && is_near(level.max_error, loosest);
        if level.level as usize != i || !(is_near(level.max_error, expected) || is_loosened) {
            let found = level.max_error;
            findings.add(Kind::Manifest, || format!("level {i} promises {found} m, where the rule gives {expected} m"));
        }
        // Two cells in a part at the least.
        let most = MAX_PARTS.min(1 << promise.grid_exponent.saturating_sub(i as u32 + 1).min(31));
        if !level.parts.is_power_of_two() || level.parts > most {
            let found = level.parts;
            findings.add(Kind::Manifest, || {
                format!("level {i} has tiles of {found} × {found} parts, expected a power of two, at most {most}")
            });
        }
        if !is_near(level.client_error, client) {
            let found = level.client_error;
            findings.add(Kind::Manifest, || format!("level {i} has a client error of {found} m, expected {client} m"));
        }
    }
}
