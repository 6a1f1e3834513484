//! `terrabite tiles --work-dir`, `tiles-plan`, `run` and `merge`: whatever is stopped, cut into shards or disturbed, the set has the same
//! bytes, or there is none.

use std::collections::BTreeMap;
use std::fs;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use crate::budget::SmallDisk;
use crate::util::{Dem, Folder, Halted, Kind, Run, hills, terrabite, terrabite_with_fault};

/// A job in a folder of its own, and its tiles.
struct Scene {
    folder: Folder,
    dem: String,
    expected: BTreeMap<PathBuf, Vec<u8>>,
}

fn ground(column: usize, row: usize) -> f64 {
    500.0 + 40.0 * hills(column, row)
}

/// Of more rows than are looked at to know it again.
fn dem() -> Dem {
    let place = [8.0, 0.004, 0.0, 46.5, 0.0, -0.004];
    Dem::new(20, 140).kind(Kind::Float32).heights(ground).geo_transform(place).epsg(4326)
}

/// All files of a set.
pub(crate) fn content(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut all = BTreeMap::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(next) = folders.pop() {
        for path in next.read_dir().unwrap().map(|entry| entry.unwrap().path()) {
            if path.is_dir() {
                folders.push(path);
            } else {
                all.insert(path.strip_prefix(folder).unwrap().to_path_buf(), fs::read(&path).unwrap());
            }
        }
    }
    all
}

impl Scene {
    fn new() -> Scene {
        let folder = Folder::new();
        let dem = dem().write(&folder, "dem.tif");
        terrabite(["tiles", &dem, &folder.at("out"), "--max-error", "500"]).succeeds();
        let expected = content(&folder.join("out"));
        fs::remove_dir_all(folder.join("out")).unwrap();
        assert!(expected.len() > 12, "{}", expected.len());
        Scene { folder, dem, expected }
    }

    fn out(&self) -> String {
        self.folder.at("out")
    }

    fn work(&self) -> String {
        self.folder.at("work")
    }

    fn command(&self, options: &[&str]) -> Vec<String> {
        let error: &[&str] = if options.contains(&"--max-error") { &[] } else { &["--max-error", "500"] };
        let words = ["tiles", &self.dem, &self.out(), "--json", "--work-dir", &self.work()];
        words.iter().chain(error).chain(options).map(|word| word.to_string()).collect()
    }

    fn run(&self, options: &[&str]) -> Run {
        terrabite(self.command(options))
    }

    #[track_caller]
    fn is_killed(&self, fault: &str) {
        let run = terrabite_with_fault(&format!("kill:{fault}"), self.command(&["--threads", "1"]));
        assert_eq!(run.code, None, "{fault}: {run:#?}");
    }

    /// The set has the expected bytes, and nothing else is left.
    #[track_caller]
    fn is_made(&self) {
        assert!(content(&self.folder.join("out")) == self.expected, "other bytes");
        assert_eq!(self.folder.names(), ["dem.tif", "out"]);
    }

    /// Gives the number of tiles that were there.
    #[track_caller]
    fn completes(&self) -> u64 {
        let run = self.run(&[]).succeeds();
        self.is_made();
        fs::remove_dir_all(self.out()).unwrap();
        run.json()["tiles_found"].as_u64().unwrap()
    }

    fn levels(&self) -> usize {
        fs::read_dir(self.out()).unwrap().filter(|entry| entry.as_ref().unwrap().path().is_dir()).count()
    }

    fn tiles(&self) -> u64 {
        self.expected.keys().filter(|path| path.extension().is_some_and(|e| e == "terrain")).count() as u64
    }
}

/// At every stage, each time after what the kill before has left.
#[test]
fn killed_again_and_again() {
    let scene = Scene::new();
    for fault in [
        "work-dir-made:1",
        "manifest-written:1",
        "decode-unit:1",
        // Of the grid's samples; then of tiles.
        "chunk-written:1",
        "chunk-written:5",
        "output-announced:1",
        "output-staged:1",
        "tile-begun:2",
        "chunk-renamed:2",
        "output-written:1",
        "output-renamed:1",
        "chunks-removed:1",
        "manifest-removed:1",
    ] {
        scene.is_killed(fault);
    }
    scene.is_killed("lock-removed:1");
    assert!(content(&scene.folder.join("out")) == scene.expected);
    assert_eq!(scene.folder.names(), ["dem.tif", "out", "work"]);
    fs::remove_dir_all(scene.out()).unwrap();
    assert_eq!(scene.completes(), 0);
    scene.is_killed("chunk-renamed:4");
    // One is torn, and one another's.
    let chunk = |name: &str| scene.folder.join(&format!("work/chunks/{name}.chunk"));
    let bytes = fs::read(chunk("0/0/0")).unwrap();
    fs::write(chunk("0/0/0"), &bytes[..bytes.len() - 9]).unwrap();
    fs::write(chunk("0/1/0"), bytes).unwrap();
    assert_eq!(scene.completes(), 2);
}

/// A set that has its name is known as the job's own, however little of the work dir is left. While it is known that it has the samples of the
/// raster, it is not made again.
#[test]
fn killed_when_the_set_is_there() {
    let scene = Scene::new();
    for (fault, is_kept) in [
        ("output-renamed:1", true),
        ("chunks-removed:1", true),
        ("manifest-removed:1", false),
        ("lock-removed:1", false),
    ] {
        scene.is_killed(fault);
        let made = |folder: &Folder| fs::metadata(folder.join("out")).unwrap().ino();
        let before = made(&scene.folder);
        let run = scene.run(&[]).succeeds();
        assert_eq!(made(&scene.folder) == before, is_kept, "{fault}");
        assert_eq!(run.json()["levels"].as_array().unwrap().len(), scene.levels(), "{fault}");
        scene.is_made();
        fs::remove_dir_all(scene.out()).unwrap();
    }
    // Others are not.
    scene.is_killed("chunks-removed:1");
    scene.run(&["--max-error", "1000"]).fails(1, &["another job", "--work-dir"]);
    fs::remove_dir_all(scene.out()).unwrap();
    assert_eq!(scene.completes(), 0);
}

/// An earlier set changes places with the new one, and is there until then.
#[test]
fn killed_while_an_earlier_set_is_replaced() {
    let scene = Scene::new();
    terrabite(["tiles", &scene.dem, &scene.out(), "--max-error", "2000"]).succeeds();
    let earlier = content(&scene.folder.join("out"));
    // It binds the work dir to nothing.
    scene.run(&[]).fails(1, &["an earlier set of tiles", "--overwrite"]);
    assert_eq!(scene.folder.names(), ["dem.tif", "out"]);
    // What was begun with --overwrite continues with it.
    let run = terrabite_with_fault("kill:chunk-renamed:2", scene.command(&["--overwrite", "--threads", "1"]));
    assert_eq!(run.code, None, "{run:#?}");
    scene.run(&[]).fails(1, &["--overwrite replaces it", "the same command with --overwrite continues"]);
    let replaces = scene.command(&["--overwrite"]);
    for (fault, is_there) in [("output-written:1", &earlier), ("output-renamed:1", &scene.expected)] {
        let run = terrabite_with_fault(&format!("kill:{fault}"), &replaces);
        assert_eq!(run.code, None, "{fault}: {run:#?}");
        assert!(content(&scene.folder.join("out")) == *is_there, "{fault}");
    }
    let run = terrabite(&replaces).succeeds();
    assert_eq!(run.json()["tiles_found"].as_u64(), Some(scene.tiles()));
    scene.is_made();
}

/// A run that has ended looks at the files of its set: at their names and lengths, not into them.
#[test]
fn a_finished_set_that_was_changed_is_no_success() {
    let scene = Scene::new();
    let out = scene.folder.join("out");
    let (some, other) = (out.join("0/0/0.terrain"), out.join("layer.json"));
    scene.run(&["--keep-work-dir"]).succeeds();
    let cut = |path: &Path| fs::File::options().write(true).open(path).unwrap().set_len(50).unwrap();
    cut(&some);
    let [length, cut_to] =
        [scene.expected[Path::new("0/0/0.terrain")].len(), 50].map(|bytes| format!("of {bytes} bytes"));
    scene.run(&[]).fails(1, &["0/0/0.terrain", &length, &cut_to, "--overwrite writes it anew"]);
    let run = scene.run(&["--overwrite", "--keep-work-dir"]).succeeds();
    assert_eq!(run.json()["tiles_found"].as_u64(), Some(scene.tiles()));
    for path in [&some, &other] {
        fs::remove_file(path).unwrap();
        let name = path.to_str().unwrap();
        scene.run(&[]).fails(1, &[name, "found none", "--overwrite writes it anew"]);
        // Whoever keeps the work dir has the set written anew.
        scene.run(&["--keep-work-dir"]).succeeds();
        assert!(content(&out) == scene.expected);
    }
    cut(&other);
    scene.run(&["--overwrite"]).succeeds();
    scene.is_made();
    fs::remove_dir_all(scene.out()).unwrap();
    // The same where the work dir is all but gone; its tiles have to be made again.
    scene.is_killed("chunks-removed:1");
    cut(&some);
    scene.run(&[]).fails(1, &["0/0/0.terrain", "--overwrite"]);
    scene.run(&["--overwrite"]).succeeds();
    scene.is_made();
}

#[test]
fn other_options_and_rasters_are_refused_and_named() {
    let scene = Scene::new();
    scene.is_killed("chunk-renamed:3");
    let refused = |options: &[&str], words: &[&str]| {
        scene.run(options).fails(1, words).fails(1, &[&scene.work(), "another job", "--work-dir", "delete"]);
        assert_eq!(scene.folder.names(), ["dem.tif", "work"]);
    };
    refused(&["--max-error", "600"], &["--max-error: 500 in the work dir, 600 now"]);
    refused(&["--gzip"], &["--gzip: not given in the work dir, given now"]);
    refused(&["--outside", "3"], &["--outside: 0 in the work dir, 3 now"]);
    refused(&["--nodata", "7"], &["--nodata, --valid-range: not given in the work dir, 7 now"]);
    refused(&["--nodata", "none"], &["--nodata, --valid-range: not given in the work dir, no nodata value now"]);
    refused(&["--vertical-crs", "EPSG:5773"], &["--vertical-crs: none in the work dir, EPSG:5773 now"]);
    refused(&["--window", "0,0,20,100"], &["--window, --bbox: not given in the work dir, 0,0,20,100 now"]);
    let inside = ["tiles", &scene.dem, &scene.out(), "--max-error", "500", "--work-dir", &scene.folder.at("out/work")];
    terrabite(inside).fails(1, &["expected an empty folder or nothing, found the work dir in it"]);
    terrabite(["simplify", &scene.dem, &scene.folder.at("tin.ply"), "--max-error", "500", "--work-dir", &scene.work()])
        .fails(1, &["another job", "result: terrain tiles in the work dir, a mesh now"]);
    let before = fs::read(&scene.dem).unwrap();
    dem().epsg(4258).write(&scene.folder, "dem.tif");
    refused(&[], &["the raster's CRS: EPSG:4326 (WGS 84)", "in the work dir, EPSG:4258 (ETRS89)"]);
    // The same samples in a file of another time; then one that is not among those that are looked at first.
    fs::write(&scene.dem, &before).unwrap();
    scene.is_killed("chunk-renamed:2");
    let changed = |c: usize, r: usize| ground(c, r) + if (c, r) == (9, 3) { 1.0 } else { 0.0 };
    dem().heights(changed).write(&scene.folder, "dem.tif");
    scene.run(&[]).fails(1, &["the raster has changed", "checksum of the grid's samples", &scene.work(), "delete"]);
    fs::write(&scene.dem, before).unwrap();
    assert_eq!(scene.completes(), 5);
}

#[test]
fn a_raster_that_changes_during_a_run_is_refused() {
    let scene = Scene::new();
    let touch = |seconds: u64| {
        let now = SystemTime::now() + Duration::from_secs(seconds);
        fs::File::options().append(true).open(&scene.dem).unwrap().set_modified(now).unwrap();
    };
    for (i, work_dir) in [true, false].into_iter().enumerate() {
        let mut command = scene.command(&["--threads", "1"]);
        if !work_dir {
            command.retain(|word| *word != "--work-dir" && *word != scene.work());
        }
        let halted = Halted::at("tile-begun", 3, &command);
        touch(10 * (i as u64 + 1));
        halted.go_on().fails(1, &[&scene.dem, "the raster has changed", "modified"]);
        assert!(!Path::new(&scene.out()).exists());
    }
    assert_eq!(scene.folder.names(), ["dem.tif", "work"]);
    // It was only touched: the samples are compared, and the tiles serve.
    assert_eq!(scene.completes(), scene.tiles());
}

#[test]
fn an_interrupted_run_says_how_to_continue() {
    let scene = Scene::new();
    let halted = Halted::at("chunk-renamed", 3, scene.command(&["--threads", "1"]));
    halted.signal("INT");
    halted.go_on().fails(130, &["stopped", &scene.work(), "the same command continues"]);
    assert_eq!(scene.folder.names(), ["dem.tif", "work"]);
    let run = scene.run(&["--keep-work-dir"]).succeeds();
    assert!(run.json()["tiles_found"].as_u64() >= Some(3), "{run:#?}");
    assert_eq!(scene.folder.names(), ["dem.tif", "out", "work"]);
    // Another run of the same is of files that are there.
    fs::remove_dir_all(scene.out()).unwrap();
    assert_eq!(scene.completes(), scene.tiles());
}

#[test]
fn a_full_disk_is_told_and_leaves_nothing() {
    let Some(disk) = SmallDisk::new(20 << 10) else { return };
    let scene = Scene::new();
    let (full, tiles) = (disk.0.at(""), ["tiles", &scene.dem, "--max-error", "500"].map(String::from));
    let run = |output: String, options: &[&str], words: &[&str]| {
        let words = [words, &["No space left"]].concat();
        terrabite(tiles.iter().map(String::as_str).chain([output.as_str()]).chain(options.iter().copied()))
            .fails(4, &words);
        assert_eq!(scene.folder.names(), ["dem.tif"]);
    };
    run(disk.0.at("out"), &[], &["free some space"]);
    assert_eq!(disk.0.names(), [""; 0]);
    run(scene.out(), &["--temp-dir", &full], &["--temp-dir"]);
    run(scene.out(), &["--work-dir", &disk.0.at("work")], &["free some space"]);
    // It is the disk of the work dir that is full, not the output's: what is there goes on elsewhere.
    run(disk.0.at("out"), &["--work-dir", &disk.0.at("work")], &["free some space"]);
}

/// In shards, whatever their number and order, and without the raster.
#[test]
fn shards_make_the_same_set() {
    let scene = Scene::new();
    let plan = ["tiles-plan", &scene.dem, &scene.work(), "--max-error", "500"].map(String::from);
    let elsewhere = scene.folder.at("elsewhere.tif");
    for (shards, order) in [(1, [1].to_vec()), (3, [3, 1, 2].to_vec()), (64, (1..=64).rev().collect())] {
        let laid_out = terrabite(&plan).succeeds();
        assert!(laid_out.out.contains(&format!("{} tiles of levels 0 to", scene.tiles())), "{laid_out:#?}");
        fs::rename(&scene.dem, &elsewhere).unwrap();
        let missing = terrabite(["merge", &scene.work(), &scene.out()]);
        missing.fails(6, &[&format!("found {} missing: 0/0/0, 0/1/0", scene.tiles()), "terrabite run WORK"]);
        let run = |shard: usize| {
            let shard = format!("{shard}/{shards}");
            terrabite(["run", &scene.work(), "--shard", &shard, "--json"]).succeeds().json()["made"].as_u64().unwrap()
        };
        let made: u64 = order.into_iter().map(run).sum();
        assert_eq!(made, scene.tiles());
        let again = terrabite(["run", &scene.work(), "--shard", "1/2", "--json", "--pass", "1"]).succeeds();
        assert_eq!(again.json()["made"], 0);
        terrabite(["merge", &scene.work(), &scene.out()]).succeeds();
        fs::rename(&elsewhere, &scene.dem).unwrap();
        scene.is_made();
        fs::remove_dir_all(scene.out()).unwrap();
    }
}

#[test]
fn shards_of_tiles_are_no_shards_of_a_mesh() {
    let scene = Scene::new();
    let plan = ["tiles-plan", &scene.dem, &scene.work(), "--max-error", "500"];
    terrabite(["run", &scene.work()]).fails(1, &["terrabite plan"]);
    terrabite(plan).succeeds();
    let run = |options: &[&str], words: &[&str]| {
        terrabite(["run", &scene.work()].iter().chain(options)).fails(2, words);
    };
    run(&["--access", "windows"], &["--access", "terrain tiles", "remove"]);
    run(&["--raster", &scene.dem], &["--raster", "terrain tiles", "remove"]);
    run(&["--pass", "2"], &["expected pass 1", "--pass"]);
    // A level that cannot be made from fewer parts: all that others have made of it is made again.
    terrabite(["run", &scene.work()]).succeeds();
    fs::write(scene.folder.join("work/chunks/3/parts-32"), "").unwrap();
    terrabite(["merge", &scene.work(), &scene.out()]).fails(6, &["found 1 missing: 3/"]);
    let again = terrabite(["run", &scene.work(), "--json"]).succeeds();
    assert_eq!(again.json()["made"], 1);
    terrabite(["merge", &scene.work(), &scene.out()]).succeeds();
    let made = content(&scene.folder.join("out"));
    assert!(String::from_utf8_lossy(&made[Path::new("terrabite.json")]).contains("\"parts\": 32"));
    let differing: Vec<&PathBuf> =
        made.iter().filter(|(name, file)| scene.expected[*name] != **file).map(|f| f.0).collect();
    assert!(differing.len() == 2 && differing[0].starts_with("3"), "{differing:?}");
    terrabite(["tiles-verify", &scene.dem, &scene.out()]).succeeds();
}

/// What a disk has done to the samples of the grid is found by whoever reads them.
#[test]
fn damaged_samples_are_noticed() {
    let scene = Scene::new();
    terrabite(["tiles-plan", &scene.dem, &scene.work(), "--max-error", "500"]).succeeds();
    let samples = scene.folder.join("work/chunks/grid.samples");
    let mut bytes = fs::read(&samples).unwrap();
    let at = bytes.iter().position(|&byte| byte == 0x40).unwrap();
    bytes[at] ^= 1;
    fs::write(&samples, bytes).unwrap();
    let run = terrabite(["run", &scene.work()]);
    run.fails(1, &[&scene.work(), "samples of the grid as they were written", "begin anew"]);
}

#[test]
fn a_plan_that_fails_leaves_no_folder() {
    let scene = Scene::new();
    let plan = ["tiles-plan", &scene.dem, &scene.work(), "--max-error", "500", "--max-level", "15"];
    terrabite(plan).fails(1, &["expected a finest level", "--max-level"]);
    assert_eq!(scene.folder.names(), ["dem.tif"]);
}

#[test]
fn another_view_is_named_by_the_judge() {
    let scene = Scene::new();
    let window = ["--window", "0,0,12,100"];
    terrabite(["tiles", &scene.dem, &scene.out(), "--max-error", "500"].iter().chain(&window)).succeeds();
    let judge = ["tiles-verify", &scene.dem, &scene.out()];
    let judged = terrabite(judge);
    assert_eq!(judged.code, Some(1), "{judged:#?}");
    assert!(judged.out.contains("made from another view of the raster: window: expected"), "{judged:#?}");
    let judged = terrabite(judge.iter().chain(&window)).succeeds();
    assert!(!judged.out.contains("another view"), "{judged:#?}");
}
