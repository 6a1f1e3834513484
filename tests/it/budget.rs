//! `--memory`, `--dry-run`, and disks that are too small.

use std::io::{ErrorKind, Write};
use std::process::Command;

use crate::util::{Dem, Folder, hills, is_long, shared_data, terrabite, terrabite_disturbed, terrabite_in_group};

/// As dense as meshes get: every sample is a vertex.
fn rough(column: usize, row: usize) -> f64 {
    ((column * column * 31 + row * row * 17 + column * row * 7) % 1009) as f64
}

/// Two tiles, and a little more across and down.
#[test]
fn the_peak_stays_within_the_budget() {
    let folder = Folder::new();
    let (plain, tile) = if is_long() { (Dem::new(1020, 520), "512") } else { (Dem::new(510, 260), "256") };
    let plain = plain.heights(rough);
    let rasters = [
        plain.clone().tiled(256).compressed().write(&folder, "tiled.tif"),
        plain.compressed().write(&folder, "strips.tif"),
    ];
    for dem in &rasters {
        for (quality, engine, least, least_long) in [
            ("none", "greedy-cuts", "82MiB", "94MiB"),
            ("none", "greedy-insertion", "82MiB", "94MiB"),
            ("fast", "greedy-insertion", "82MiB", "94MiB"),
        ] {
            let tin = folder.at("tin.ply");
            let memory = if is_long() { least_long } else { least };
            let run = ["simplify", dem, &tin, "--max-error", "0", "--overwrite", "--json", "--memory", memory];
            let report = terrabite(run.iter().chain(&["--quality", quality, "--engine", engine, "--tile", tile]));
            let report = report.succeeds().json();
            let (peak, budget) = (report["peak_memory_bytes"].as_u64(), report["memory"]["budget_bytes"].as_u64());
            assert!(peak <= budget, "{peak:?} of {budget:?} for {dem}, {quality}, {engine}");
            assert!(report["samples_per_triangle"].as_f64() < Some(0.6));
        }
    }
}

/// A quarter of the samples are holes of one sample each, and all others are vertices.
#[test]
fn the_peak_stays_within_the_budget_beside_holes() {
    let folder = Folder::new();
    let speckled = |c: usize, r: usize| if c % 2 == 1 && r % 2 == 1 { -32768.0 } else { rough(c, r) };
    let (side, tile, memory) = if is_long() { (1021, "512", "112MiB") } else { (511, "256", "92MiB") };
    let dem = Dem::new(side, side).heights(speckled).nodata(-32768.0).tiled(256).compressed().write(&folder, "dem.tif");
    let tin = folder.at("tin.ply");
    let run = ["simplify", &dem, &tin, "--max-error", "0", "--json", "--memory", memory, "--fill-holes", "1"];
    let report = terrabite(run.iter().chain(&["--quality", "fast", "--tile", tile])).succeeds().json();
    let (peak, budget) = (report["peak_memory_bytes"].as_u64(), report["memory"]["budget_bytes"].as_u64());
    assert!(peak <= budget, "{peak:?} of {budget:?}");
    assert_eq!(report["filled_voids"], (side / 2) * (side / 2));
}

#[test]
fn a_budget_that_is_too_small_names_the_smallest() {
    let folder = Folder::new();
    let smooth = |c: usize, r: usize| ((c / 40 + r / 30) % 40) as f64;
    let dem = Dem::new(600, 600).heights(smooth).write(&folder, "dem.tif");
    let run = |more: &[&str]| {
        let run = ["simplify", &dem, &folder.at("tin.ply"), "--max-error", "3", "--overwrite"];
        terrabite(run.iter().chain(more))
    };
    let refused = run(&["--memory", "10MiB"]).fails(3, &["at least", "MiB", "--memory"]);
    assert_eq!(folder.names(), ["dem.tif"]);
    let words: Vec<&str> = refused.err.split_whitespace().collect();
    let least = words[words.iter().position(|w| *w == "least").unwrap() + 1];
    run(&["--memory", &format!("{least}MiB")]).succeeds();
    let below = least.parse::<u64>().unwrap() - 1;
    let refused = run(&["--memory", &format!("{below}MiB")]).fails(3, &[" cells would fit"]);
    let words: Vec<&str> = refused.err.split_whitespace().collect();
    let cells = words[words.iter().position(|w| *w == "cells").unwrap() - 1];
    run(&["--memory", &format!("{below}MiB"), "--tile", cells]).succeeds();
}

#[test]
fn neither_memory_nor_threads_nor_access_change_a_byte() {
    let folder = Folder::new();
    let hilly = |c: usize, r: usize| ((c * c) % 97 + (r * r) % 89) as f64 + (c + r) as f64;
    let (plain, tile) = if is_long() { (Dem::new(700, 500), "96") } else { (Dem::new(300, 220), "40") };
    let plain = plain.heights(hilly).on_the_map();
    for (name, dem) in [("tiled.tif", plain.clone().tiled(64)), ("strips.tif", plain)] {
        let dem = dem.write(&folder, name);
        let bytes = |options: &[&str]| {
            let tin = folder.at("tin.ply");
            let run = ["simplify", &dem, &tin, "--max-error", "9", "--tile", tile, "--overwrite", "--quiet"];
            terrabite(run.iter().chain(options)).succeeds();
            std::fs::read(&tin).unwrap()
        };
        let expected = bytes(&["--threads", "1", "--memory", "128MiB"]);
        for options in [
            ["--threads", "2", "--memory", "2GiB"],
            ["--threads", "7", "--memory", "300MiB"],
            ["--threads", "2", "--access", "in-place"],
            ["--threads", "7", "--access", "windows"],
            ["--threads", "2", "--access", "decode"],
        ] {
            assert!(bytes(&options) == expected, "{options:?}");
        }
    }
}

#[test]
fn a_dry_run_tells_and_writes_nothing() {
    let folder = Folder::new();
    let dem = Dem::new(350, 250).compressed().write(&folder, "dem.tif");
    let run = ["simplify", &dem, &folder.at("tin.ply"), "--max-error", "3", "--tile", "128", "--dry-run"];
    let needs = terrabite(run.iter().chain(&["--json"])).succeeds().json();
    assert!(needs["estimate"]["spool_bytes"].as_u64() > Some(0));
    assert!(needs["memory"]["needed_bytes"].as_u64() <= needs["memory"]["budget_bytes"].as_u64());
    assert!(terrabite(run).succeeds().out.contains("samples per triangle"));
    assert_eq!(folder.names(), ["dem.tif"]);
}

/// The estimate from a few tiles, against the truth.
#[test]
fn the_estimate_is_near() {
    let Some(dem) = shared_data("moon_tycho_4096.tif") else { return };
    let folder = Folder::new();
    let window = if is_long() { "0,0,4096,4096" } else { "1024,1024,2048,2048" };
    let run = ["simplify", dem.to_str().unwrap(), &folder.at("tin.ply"), "--max-error", "200", "--json"];
    let run = run.into_iter().chain(["--window", window]);
    let needs = terrabite(run.clone().chain(["--dry-run"])).succeeds().json();
    terrabite(run).succeeds();
    let size = std::fs::metadata(folder.join("tin.ply")).unwrap().len() as f64;
    let told = needs["estimate"]["output_bytes"].as_f64().unwrap();
    assert!((0.5..2.0).contains(&(told / size)), "{told} told, {size} written");
}

/// A small file system of its own, where this process may mount one.
pub(crate) struct SmallDisk(pub(crate) Folder);

impl SmallDisk {
    pub(crate) fn new(bytes: u32) -> Option<SmallDisk> {
        let folder = Folder::new();
        let size = format!("size={bytes}");
        let mount = Command::new("mount").args(["-t", "tmpfs", "-o", &size, "tmpfs", &folder.at("")]).output();
        if mount.is_ok_and(|m| m.status.success()) {
            return Some(SmallDisk(folder));
        }
        eprintln!("skipped: no file system can be mounted here");
        None
    }
}

impl Drop for SmallDisk {
    fn drop(&mut self) {
        let _ = Command::new("umount").args(["--lazy", &self.0.at("")]).output();
    }
}

#[test]
fn a_disk_that_cannot_hold_the_run_is_told_of_before_it() {
    let Some(disk) = SmallDisk::new(1 << 20) else { return };
    let folder = Folder::new();
    let dem = Dem::new(600, 500).heights(rough).compressed().write(&folder, "dem.tif");
    let (inside, outside) = (disk.0.at(""), folder.at(""));
    let run = |output: &str, temp: &str| {
        let run = terrabite(["simplify", &dem, output, "--max-error", "0", "--temp-dir", temp]);
        run.fails(4, &["free", "--temp-dir"]);
        assert_eq!(folder.names(), ["dem.tif"]);
        assert_eq!(disk.0.names(), [""; 0]);
    };
    run(&folder.at("tin.ply"), &inside);
    run(&disk.0.at("tin.ply"), &outside);
}

#[test]
fn a_disk_that_fills_up_during_the_run() {
    const SIZE: u32 = 400 << 20;
    let Some(disk) = SmallDisk::new(SIZE) else { return };
    let folder = Folder::new();
    let dem = Dem::new(1500, 1500).heights(rough).write(&folder, "dem.tif");
    let run = ["simplify", &dem, &disk.0.at("tin.ply"), "--max-error", "0", "--temp-dir", &disk.0.at("")];
    // Until nothing more goes in: the run is writing, too, so nobody can tell beforehand how much that is.
    let fill = || {
        let mut file = std::fs::File::create(disk.0.join("full")).unwrap();
        let chunk = vec![0u8; 1 << 20];
        let error = (0..SIZE >> 19).find_map(|_| file.write_all(&chunk).err()).expect("a disk has an end");
        error.kind() == ErrorKind::StorageFull
    };
    terrabite_disturbed(run, fill).fails(4, &["No space left"]);
    assert_eq!(disk.0.names(), ["full"]);
}

/// A control group of its own with a limit on memory, where one can be made.
struct Group(std::path::PathBuf);

impl Group {
    fn new(bytes: u64) -> Option<Group> {
        for (root, limit) in [
            ("/sys/fs/cgroup/memory", "memory.limit_in_bytes"),
            ("/sys/fs/cgroup", "memory.max"),
            ("/sys/fs/cgroup/unified", "memory.max"),
        ] {
            // A name that no other test, checkout or container has.
            let Ok(folder) = tempfile::Builder::new().prefix("terrabite-test-").tempdir_in(root) else { continue };
            let group = Group(folder.keep());
            if group.0.join(limit).exists() && std::fs::write(group.0.join(limit), bytes.to_string()).is_ok() {
                return Some(group);
            }
        }
        eprintln!("skipped: no control group with a memory limit can be made here");
        None
    }
}

impl Drop for Group {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir(&self.0);
    }
}

/// What a control group counts besides the process: the page cache of the raster, the temporary files and the output,
/// which the kernel takes back when it needs the room.
const PAGE_CACHE: u64 = 24 << 20;

/// Tiles in two rows and columns, and a little more.
#[test]
fn a_control_group_of_the_budget_is_enough() {
    let (size, tile, budget) = if is_long() { ((1500, 1300), "512", 176) } else { ((520, 518), "256", 104) };
    let Some(group) = Group::new((budget << 20) + PAGE_CACHE) else { return };
    let folder = Folder::new();
    let hilly = |c: usize, r: usize| ((c * c) % 97 + (r * r) % 89) as f64 + (c + r) as f64;
    let plain = Dem::new(size.0, size.1).heights(hilly);
    // The same memory for ways of reading takes less time on gentle ground.
    let gentle = if is_long() { plain.clone() } else { Dem::new(size.0, size.1).heights(hills) };
    for (name, dem) in [
        ("mapped.tif", plain.clone()),
        ("decoded.tif", gentle.clone().compressed()),
        ("windows.tif", gentle.compressed().tiled(256)),
    ] {
        let dem = dem.write(&folder, name);
        let tin = folder.at("tin.ply");
        let run = ["simplify", &dem, &tin, "--max-error", "30", "--tile", tile, "--overwrite", "--json"];
        let with = |more: &[&str], mib: u64| {
            let memory = format!("{mib}MiB");
            terrabite_in_group(&group.0, run.iter().chain(more).chain(&["--memory", &memory])).succeeds().json()
        };
        let report = with(&[], budget);
        assert!(report["peak_memory_bytes"].as_u64() <= Some(budget << 20), "{report:#}");
        let needs = with(&["--dry-run"], budget - 4);
        assert_eq!(needs["memory"]["budget_bytes"].as_u64(), Some((budget - 4) << 20));
        // Left to itself it asks what the group has.
        let quarter = (budget + (PAGE_CACHE >> 20)) / 4;
        terrabite_in_group(&group.0, run).fails(3, &[&format!("found {quarter} MiB")]);
    }
}
