//! Tables of columns x, y, z: their order, and samples without a line.

use crate::util::{Folder, terrabite};

/// The lines of 30 × 20 samples, rows from north to south.
fn lines(separator: &str, height: impl Fn(usize, usize) -> f64) -> Vec<String> {
    let line = |i: usize| {
        let (c, r) = (i % 30, i / 30);
        [(500 + 10 * c).to_string(), (900 - 10 * r).to_string(), height(c, r).to_string()].join(separator)
    };
    (0..600).map(line).collect()
}

fn table(lines: &[String]) -> String {
    lines.join("\n") + "\n"
}

#[test]
fn lines_without_order_are_refused_with_the_way_to_sort_them() {
    let folder = Folder::new();
    let ordered = lines(" ", |c, r| (c + r) as f64);
    // Another order for every line: 7 has no factor in common with 600.
    let shuffled: Vec<String> = (0..600).map(|i| ordered[i * 7 % 600].clone()).collect();
    let dem = folder.with("dem.xyz", table(&shuffled));
    let words = ["dem.xyz", "Ungridded dataset", "sort -k2,2gr -k1,1g", "-t,", "header"];
    terrabite(["info", &dem]).fails(1, &words);
    let sorted = std::process::Command::new("sort").args(["-k2,2gr", "-k1,1g", &dem]).env("LC_ALL", "C").output();
    assert_eq!(String::from_utf8(sorted.unwrap().stdout).unwrap(), table(&ordered));
    terrabite(["info", &folder.with("dem.xyz", table(&ordered))]).succeeds();
}

#[test]
fn samples_without_a_line_are_told_where_nothing_marks_them() {
    let folder = Folder::new();
    let warnings = |name: &str, text: String| {
        let info = terrabite(["info", &folder.with(name, text), "--json"]).succeeds().json();
        info["warnings"].as_array().unwrap().clone()
    };
    let with_gaps = |lines: Vec<String>| {
        let kept: Vec<String> = lines.into_iter().enumerate().filter(|(i, _)| i % 7 != 3).map(|(_, l)| l).collect();
        assert_eq!(kept.len(), 600 - 86);
        table(&kept)
    };
    // Heights from 0 to 48 are bytes, and GDAL finds no value for gaps.
    let found = warnings("zero.xyz", with_gaps(lines(" ", |c, r| (c + r) as f64)));
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!((&found[0]["code"], &found[0]["count"]), (&"xyz_gaps".into(), &86.into()));
    let message = found[0]["message"].as_str().unwrap();
    assert!(message.starts_with("86 samples have no line in the table") && message.contains("--nodata"), "{message}");
    // Here it takes 0 or −32768, or there are no gaps.
    assert_eq!(warnings("one.xyz", with_gaps(lines(",", |c, r| (1 + c + r) as f64))), [] as [serde_json::Value; 0]);
    assert_eq!(warnings("low.xyz", with_gaps(lines(" ", |c, r| c as f64 - r as f64))), [] as [serde_json::Value; 0]);
    let whole = "x;y;z\n".to_string() + &table(&lines(";", |c, r| (c + r) as f64));
    assert_eq!(warnings("whole.xyz", whole), [] as [serde_json::Value; 0]);
}
