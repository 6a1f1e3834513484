//! `--memory` of `tiles`, `tiles-verify`, `tiles-plan`, `run` and `merge`: a budget is kept or refused, and decides no byte.

use crate::tiles_resume::content;
use crate::util::{Dem, Folder, Kind, Run, hills, terrabite};

const TOO_SMALL: [&str; 3] = ["expected a memory budget of at least", "found 64 MiB", "choose a larger --memory"];

/// The smallest budget, as the refusal of a smaller one names it.
#[track_caller]
fn smallest(refused: Run) -> String {
    let refused = refused.fails(3, &TOO_SMALL);
    let (_, after) = refused.err.split_once("at least ").expect("a budget");
    let (mebibytes, _) = after.split_once(" MiB").expect("mebibytes");
    format!("{mebibytes}MiB")
}

#[test]
fn a_budget_is_kept_or_refused() {
    let folder = Folder::new();
    let heights = |column, row| 500.0 + 40.0 * hills(column, row);
    let place = [8.0, 0.002, 0.0, 46.5, 0.0, -0.002];
    let dem = Dem::new(150, 100).kind(Kind::Float32).heights(heights).geo_transform(place).epsg(4326);
    let dem = dem.write(&folder, "dem.tif");
    let (free, tight, work) = (folder.at("free"), folder.at("tight"), folder.at("work"));
    let made = |out: &str, options: &[&str]| {
        let words = ["tiles", &dem, out, "--max-error", "100", "--own-samples", "--threads", "4", "--json"];
        terrabite(words.iter().chain(options))
    };
    let least = smallest(made(&tight, &["--memory", "64MiB"]));
    let free_report = made(&free, &["--memory", "1GiB"]).succeeds().json();
    assert_eq!(free_report["memory"]["threads"], 4, "{free_report}");
    let report = made(&tight, &["--memory", &least]).succeeds().json();
    assert_eq!(report["memory"]["threads"], 1, "{report}");
    for memory in [&free_report, &report] {
        let needed = memory["memory"]["needed_bytes"].as_u64();
        assert!(needed <= memory["memory"]["budget_bytes"].as_u64(), "{memory}");
        assert!(memory["peak_memory_bytes"].as_u64().is_none_or(|peak| Some(peak) <= needed), "{memory}");
    }
    let expected = content(&folder.join("free"));
    assert_eq!(content(&folder.join("tight")), expected);

    let least = smallest(terrabite(["tiles-verify", &dem, &tight, "--memory", "64MiB"]));
    let verdict = terrabite(["tiles-verify", &dem, &tight, "--json", "--memory", &least]).succeeds().json();
    assert_eq!(verdict["memory"]["threads"], 1, "{verdict}");

    let plan = ["tiles-plan", &dem, &work, "--max-error", "100", "--own-samples", "--memory"];
    let least = smallest(terrabite(plan.iter().chain(&["64MiB"])));
    terrabite(plan.iter().chain(&[least.as_str()])).succeeds();
    let least = smallest(terrabite(["run", &work, "--memory", "64MiB"]));
    terrabite(["run", &work, "--memory", &least]).succeeds();
    let out = folder.at("out");
    terrabite(["merge", &work, &out, "--memory", "32MiB"]).fails(3, &["found 32 MiB", "--memory"]);
    terrabite(["merge", &work, &out]).succeeds();
    assert_eq!(content(&folder.join("out")), expected);
}
