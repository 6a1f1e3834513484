//! `terrabite simplify --work-dir`: what is stopped, at whatever moment, continues to the same bytes.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use crate::util::{
    Dem, Folder, Halted, Kind, Run, names_that_come_up, terrabite, terrabite_with_fault, terrabite_with_file_limit,
};

/// A job in a folder of its own: a raster that has to be decoded, 2 × 6 tiles, and their mesh.
struct Scene {
    folder: Folder,
    dem: String,
    expected: Vec<u8>,
}

/// Hills so wide that a run of a few tiles is soon done.
pub(crate) fn ground(column: usize, row: usize) -> f64 {
    let (x, y) = (column as f64, row as f64);
    (75.0 + 30.0 * (x / 14.0).sin() * (y / 18.0).cos() + 15.0 * ((x + y) / 7.0).sin()).round()
}

pub(crate) fn dem() -> Dem {
    Dem::new(200, 600).heights(ground).compressed().stripped(64)
}

impl Scene {
    fn new() -> Scene {
        Scene::of(dem())
    }

    fn of(dem: Dem) -> Scene {
        let folder = Folder::new();
        let dem = dem.write(&folder, "dem.tif");
        let tin = folder.at("expected.ply");
        terrabite(["simplify", &dem, &tin, "--max-error", "3", "--tile", "100"]).succeeds();
        let expected = fs::read(&tin).unwrap();
        fs::remove_file(tin).unwrap();
        Scene { folder, dem, expected }
    }

    /// The command; `options` may be others than usual.
    fn command(&self, options: &[&str]) -> Vec<String> {
        let mut command: Vec<String> =
            ["simplify", &self.dem, &self.tin(), "--json", "--access", "decode", "--work-dir", &self.work()]
                .iter()
                .map(|word| word.to_string())
                .collect();
        for (option, usual) in [("--max-error", "3"), ("--tile", "100")] {
            if !options.contains(&option) {
                command.extend([option.to_string(), usual.to_string()]);
            }
        }
        command.extend(options.iter().map(|word| word.to_string()));
        command
    }

    fn tin(&self) -> String {
        self.folder.at("tin.ply")
    }

    fn work(&self) -> String {
        self.folder.at("work")
    }

    fn run(&self, options: &[&str]) -> Run {
        terrabite(self.command(options))
    }

    #[track_caller]
    fn is_killed(&self, fault: &str) {
        let run = terrabite_with_fault(&format!("kill:{fault}"), self.command(&[]));
        assert_eq!(run.code, None, "{fault}: {run:#?}");
    }

    /// The command must succeed, with the expected bytes and nothing left; gives the number of tiles it found.
    #[track_caller]
    fn completes(&self) -> u64 {
        let run = self.run(&[]).succeeds();
        assert!(fs::read(self.tin()).unwrap() == self.expected, "other bytes: {run:#?}");
        assert_eq!(self.folder.names(), ["dem.tif", "tin.ply"]);
        fs::remove_file(self.tin()).unwrap();
        run.json()["tiles_found"].as_u64().unwrap()
    }

    fn chunks(&self) -> Vec<PathBuf> {
        let entries = |folder: &Path| -> Vec<PathBuf> {
            folder.read_dir().map_or(Vec::new(), |all| all.map(|e| e.unwrap().path()).collect())
        };
        let rows = entries(&self.folder.join("work/chunks"));
        let mut chunks: Vec<PathBuf> = rows.iter().flat_map(|row| entries(row)).collect();
        chunks.retain(|path| path.extension().is_some_and(|e| e == "chunk"));
        chunks.sort();
        chunks
    }

    /// Leaves a work dir with `tiles` finished tiles or some more.
    fn begin(&self, tiles: u32) {
        self.is_killed(&format!("chunk-renamed:{tiles}"));
        assert!(self.chunks().len() >= tiles as usize);
    }
}

const TILES: u64 = 12;

#[test]
fn a_dry_run_says_what_is_left_and_leaves_the_work_dir_alone() {
    let scene = Scene::new();
    let work_dir = |options: &[&str]| {
        let run = scene.run(&[&["--dry-run"], options].concat()).succeeds();
        let report = run.json()["work_dir"].clone();
        let finished = |name: &str| report["finished"][name].as_u64().unwrap();
        let all = |name: &str| report[name].as_u64().unwrap();
        let later = ["seams", "crossings"].map(|name| [finished(name), all(name)]);
        ([finished("tiles"), all("tiles")], later, finished("bytes"))
    };
    assert_eq!(work_dir(&[]), ([0, TILES], [[0, 21], [0, 32]], 0));
    assert_eq!(work_dir(&["--quality", "none"]), ([0, TILES], [[0, 0], [0, 0]], 0));
    assert_eq!(scene.folder.names(), ["dem.tif"]);
    scene.begin(4);
    let (kept, before) = (scene.chunks(), names_and_times(&scene.folder.join("work")));
    let bytes: u64 = kept.iter().map(|chunk| chunk.metadata().unwrap().len()).sum();
    assert_eq!(work_dir(&[]), ([kept.len() as u64, TILES], [[0, 21], [0, 32]], bytes));
    assert_eq!(names_and_times(&scene.folder.join("work")), before);
    // As the run itself would be.
    scene
        .run(&["--max-error", "2", "--dry-run"])
        .fails(1, &["another job", "--max-error: 3 in the work dir, 2 now", "--work-dir"]);
    // While another process works there it can be looked at, too.
    let run = Halted::at("chunk-renamed", 34, scene.command(&[]));
    let ([tiles, _], [[seams, _], [crossings, _]], _) = work_dir(&[]);
    assert!(tiles == TILES && seams == 21 && crossings >= 1, "{tiles}, {seams} and {crossings}");
    run.go_on().succeeds();
    assert!(fs::read(scene.tin()).unwrap() == scene.expected);
    let other = scene.folder.with("other.txt", "not ours");
    let folder = scene.folder.at("");
    let command = ["simplify", &scene.dem, &scene.tin(), "--max-error", "3", "--dry-run", "--work-dir", &folder];
    terrabite(command).fails(1, &["expected a new folder, an empty one or a work dir"]);
    assert!(Path::new(&other).exists());
}

/// Everything in a folder, and when it was changed.
fn names_and_times(folder: &Path) -> Vec<(PathBuf, SystemTime)> {
    let mut all = vec![(folder.to_path_buf(), folder.metadata().unwrap().modified().unwrap())];
    if folder.is_dir() {
        all.extend(folder.read_dir().unwrap().flat_map(|entry| names_and_times(&entry.unwrap().path())));
    }
    all.sort();
    all
}

#[test]
fn killed_at_any_moment_it_continues_to_the_same_bytes() {
    let scene = Scene::new();
    for fault in [
        "work-dir-made:1",
        "manifest-written:1",
        "output-announced:1",
        "output-probed:1",
        "output-staged:1",
        "decode-unit:1",
        "tile-begun:1",
        "tile-begun:6",
        "tile-begun:12",
        "chunk-written:1",
        "chunk-written:5",
        "chunk-written:12",
        "chunk-renamed:1",
        "chunk-renamed:4",
        "chunk-renamed:7",
        "chunk-renamed:12",
        // The second pass, over the shifted grid.
        "tile-begun:13",
        "chunk-written:14",
        "chunk-renamed:20",
        "chunk-renamed:33",
        // Those over crossings: first a grid of 3 × 6 tiles, then of 2 × 7.
        "tile-begun:34",
        "chunk-written:40",
        "chunk-renamed:51",
        "tile-begun:52",
        "chunk-renamed:65",
        "vertices:1",
        "vertices:6",
        "vertices:12",
        "triangles:1",
        "triangles:7",
        "triangles:12",
        "output-written:1",
        "output-renamed:1",
        "chunks-removed:1",
        "manifest-removed:1",
    ] {
        scene.is_killed(fault);
        let kept = scene.chunks().len() as u64;
        let renamed = ["output-renamed", "chunks", "manifest-removed"].iter().any(|stage| fault.starts_with(stage));
        assert_eq!(Path::new(&scene.tin()).exists(), renamed, "{fault}");
        assert_eq!(scene.completes(), kept, "{fault}");
        let written = ["vertices", "triangles", "output-written"].iter().any(|stage| fault.starts_with(stage));
        assert!(!written || kept == TILES, "{fault}: {kept} tiles");
    }
}

/// Nothing but an empty folder is left then, and it is known as the work dir's own.
#[test]
fn killed_before_its_folder_is_removed() {
    let scene = Scene::new();
    scene.is_killed("lock-removed:1");
    assert!(fs::read(scene.tin()).unwrap() == scene.expected);
    assert_eq!(
        (scene.folder.names(), scene.chunks().len()),
        (["dem.tif", "tin.ply", "work"].map(String::from).to_vec(), 0)
    );
    fs::remove_file(scene.tin()).unwrap();
    assert_eq!(scene.completes(), 0);
}

/// A raster of three times what is decoded at once, smooth so that the rest is soon done.
#[test]
fn killed_while_decoding() {
    let smooth = |c: usize, r: usize| ((c / 40 + r / 30) % 40) as f64;
    let scene = Scene::of(Dem::new(1000, 1500).kind(Kind::Float64).compressed().heights(smooth));
    for unit in 1..=3 {
        scene.is_killed(&format!("decode-unit:{unit}"));
        assert_eq!(scene.completes(), 0, "unit {unit}");
    }
}

#[test]
fn killed_again_and_again() {
    let scene = Scene::new();
    for fault in ["chunk-renamed:3", "chunk-written:2", "decode-unit:1", "chunk-renamed:1", "triangles:3", "vertices:2"]
    {
        let before = scene.chunks().len();
        scene.is_killed(fault);
        assert!(scene.chunks().len() >= before, "{fault}");
    }
    assert_eq!(scene.completes(), TILES);
}

/// Killed when the output had its name, it is made once more, and killed again: it is still the run's own output.
#[test]
fn killed_again_after_the_output_has_its_name() {
    let scene = Scene::new();
    for faults in [
        ["output-renamed:1", "vertices:3"],
        ["output-renamed:1", "output-written:1"],
        ["output-renamed:1", "output-renamed:1"],
    ] {
        faults.iter().for_each(|fault| scene.is_killed(fault));
        assert_eq!(scene.completes(), TILES, "{faults:?}");
    }
    // Another's output of that name is not.
    scene.is_killed("output-renamed:1");
    scene.is_killed("vertices:3");
    scene.folder.with("other.ply", "mine");
    fs::rename(scene.folder.join("other.ply"), scene.tin()).unwrap();
    scene.run(&[]).fails(1, &["exists already", "--overwrite"]);
    fs::remove_file(scene.tin()).unwrap();
    assert_eq!(scene.completes(), TILES);
}

#[test]
fn torn_and_foreign_chunks_are_made_again() {
    let scene = Scene::new();
    scene.is_killed("vertices:1");
    let chunks = scene.chunks();
    assert_eq!(chunks.len() as u64, TILES);
    let bytes = fs::read(&chunks[0]).unwrap();
    fs::write(&chunks[0], &bytes[..bytes.len() / 2]).unwrap();
    fs::write(&chunks[1], "").unwrap();
    let mut bytes = fs::read(&chunks[2]).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&chunks[2], bytes).unwrap();
    // Another tile's chunk; then one of another job.
    fs::copy(&chunks[5], &chunks[4]).unwrap();
    let other = Scene { folder: Folder::new(), dem: scene.dem.clone(), expected: Vec::new() };
    let run = terrabite_with_fault("kill:vertices:1", other.command(&["--max-error", "4"]));
    assert_eq!(run.code, None, "{run:#?}");
    fs::copy(&other.chunks()[7], &chunks[7]).unwrap();
    assert_eq!(scene.completes(), TILES - 5);
}

#[test]
fn other_parameters_are_refused_and_named() {
    let scene = Scene::new();
    scene.begin(3);
    let refused = |options: &[&str], words: &[&str]| {
        let kept = scene.chunks();
        scene.run(options).fails(1, words).fails(1, &[&scene.work(), "another job", "--work-dir", "delete"]);
        // The dead run's partial output goes: the work dir, which knows of it, may be deleted now.
        assert_eq!((scene.chunks(), scene.folder.names()), (kept, ["dem.tif", "work"].map(String::from).to_vec()));
    };
    refused(&["--max-error", "3.5"], &["--max-error: 3 in the work dir, 3.5 now"]);
    refused(&["--tile", "64"], &["--tile: 100 in the work dir, 64 now"]);
    refused(&["--feasibility", "strong"], &["--feasibility: weak in the work dir, strong now"]);
    refused(
        &["--max-error", "2", "--tile", "64"],
        &["--max-error: 3 in the work dir, 2 now; --tile: 100 in the work dir, 64 now"],
    );
    // What does not decide the bytes may differ.
    scene.run(&["--threads", "1"]).succeeds();
    assert!(fs::read(scene.tin()).unwrap() == scene.expected);
}

#[test]
fn other_rasters_are_refused_and_named() {
    let scene = Scene::new();
    scene.begin(3);
    for (other, word) in [
        (dem().heights(|c, r| ((c * r) % 91) as f64), "the raster's checksum of some samples: "),
        (Dem::new(200, 601).heights(ground).compressed().stripped(64), "the raster's size: 200 × 600"),
        (dem().on_the_map(), "the raster's geotransform: 0, "),
        (dem().nodata(-5.0), "the raster's nodata: no nodata value in the work dir, -5 now"),
        (dem().scaling(2.0, 7.0), "the raster's offset: 0 in the work dir, "),
        (dem().kind(Kind::Int32), "the raster's sample type: Int16 in the work dir, Int32 now"),
        (dem().bands(2), ""),
    ] {
        let elsewhere = Folder::new();
        let path = other.write(&elsewhere, "dem.tif");
        let mut command = scene.command(&[]);
        command[1] = path;
        if word.is_empty() {
            command.extend(["--band".to_string(), "2".to_string()]);
            terrabite(&command).fails(1, &["another job", "--band: 1 in the work dir, 2 now"]);
        } else {
            terrabite(&command).fails(1, &["another job", word]);
        }
    }
    assert!(scene.completes() >= 3);
}

#[test]
fn another_version_is_refused() {
    let scene = Scene::new();
    scene.begin(3);
    let path = scene.folder.join("work/manifest.json");
    let manifest = fs::read_to_string(&path).unwrap();
    let program = format!("terrabite {}", env!("CARGO_PKG_VERSION"));
    for (is, was, words) in [
        (program.as_str(), "terrabite 0.0.9", ["program: terrabite 0.0.9 in the work dir, terrabite", &program]),
        ("\"format\": 1", "\"format\": 7", ["work dir format: 7 in the work dir, 1 now", "--work-dir"]),
        ("}", "", ["manifest", "--work-dir"]),
    ] {
        assert!(manifest.contains(is));
        fs::write(&path, manifest.replace(is, was)).unwrap();
        scene.run(&[]).fails(1, &words);
    }
    fs::write(&path, manifest).unwrap();
    assert!(scene.completes() >= 3);
}

#[test]
fn moved_and_touched_files_continue() {
    let scene = Scene::new();
    scene.begin(4);
    // The bytes name the source, so a moved file keeps its name.
    fs::create_dir(scene.folder.join("elsewhere")).unwrap();
    let elsewhere = scene.folder.at("elsewhere/dem.tif");
    fs::rename(&scene.dem, &elsewhere).unwrap();
    let mut command = scene.command(&[]);
    command[1].clone_from(&elsewhere);
    let run = terrabite_with_fault("kill:vertices:1", &command);
    assert_eq!(run.code, None, "{run:#?}");
    fs::rename(&elsewhere, &scene.dem).unwrap();
    fs::remove_dir(scene.folder.join("elsewhere")).unwrap();
    let touched = SystemTime::now() - Duration::from_secs(1000);
    fs::File::options().append(true).open(&scene.dem).unwrap().set_modified(touched).unwrap();
    assert_eq!(scene.completes(), TILES);
}

/// One sample that is not among those the checksum in the manifest is of.
#[test]
fn a_raster_changed_between_runs_is_refused() {
    let scene = Scene::new();
    scene.is_killed("vertices:1");
    let before = fs::read(&scene.dem).unwrap();
    let changed = |c: usize, r: usize| ground(c, r) + if (c, r) == (120, 301) { 9.0 } else { 0.0 };
    let old = fs::metadata(&scene.dem).unwrap().modified().unwrap();
    dem().heights(changed).write(&scene.folder, "dem.tif");
    scene.run(&[]).fails(1, &["the raster has changed", "column 100, row 300", "checksum", "delete"]);
    assert_eq!(scene.folder.names(), ["dem.tif", "work"]);
    // The old raster again: what was kept serves.
    fs::write(&scene.dem, before).unwrap();
    fs::File::options().append(true).open(&scene.dem).unwrap().set_modified(old).unwrap();
    assert_eq!(scene.completes(), TILES);
}

#[test]
fn a_raster_changed_during_a_run_is_refused() {
    let scene = Scene::new();
    for (point, count) in [("tile-begun", 5), ("triangles", 12)] {
        for work_dir in [true, false] {
            let mut command = scene.command(&[]);
            if !work_dir {
                command.retain(|word| *word != "--work-dir" && *word != scene.work());
            }
            let halted = Halted::at(point, count, &command);
            let now = SystemTime::now() + Duration::from_secs(count.into());
            fs::File::options().append(true).open(&scene.dem).unwrap().set_modified(now).unwrap();
            halted.go_on().fails(1, &[&scene.dem, "the raster has changed", "modified"]);
            assert!(!Path::new(&scene.tin()).exists());
        }
    }
    // It was only touched.
    assert_eq!(scene.completes(), TILES);
}

/// A VRT does not change when its source does: there the samples tell.
#[test]
fn sources_behind_a_vrt_are_watched_too() {
    let mut scene = Scene::new();
    let source = std::mem::replace(&mut scene.dem, scene.folder.at("dem.vrt"));
    let vrt = "<VRTDataset rasterXSize='200' rasterYSize='600'><VRTRasterBand dataType='Int16' band='1'><SimpleSource>\
               <SourceFilename relativeToVRT='1'>dem.tif</SourceFilename><SourceBand>1</SourceBand></SimpleSource>\
               </VRTRasterBand></VRTDataset>";
    scene.folder.with("dem.vrt", vrt);
    scene.is_killed("vertices:1");
    let equal = fs::read(&source).unwrap();
    // Between runs: one sample that no checksum but its tile's is of.
    let one = |c: usize, r: usize| ground(c, r) + if (c, r) == (120, 301) { 9.0 } else { 0.0 };
    dem().heights(one).write(&scene.folder, "dem.tif");
    scene.run(&[]).fails(1, &["dem.vrt", "the raster has changed", "column 100, row 300"]);
    fs::write(&source, equal).unwrap();
    // During a run: rows.
    let halted = Halted::at("triangles", 2, scene.command(&[]));
    dem().heights(|c, r| ground(c, r) + 1.0).write(&scene.folder, "dem.tif");
    halted.go_on().fails(1, &["dem.vrt", "the raster has changed", "expected file dem.tif"]);
    assert!(!Path::new(&scene.tin()).exists());
}

#[test]
fn a_second_process_is_refused_while_the_first_runs() {
    let scene = Scene::new();
    let halted = Halted::at("tile-begun", 3, scene.command(&[]));
    let mut command = scene.command(&[]);
    command[2] = scene.folder.at("second.ply");
    terrabite(&command).fails(1, &[&scene.work(), "another process", "--work-dir"]);
    let run = halted.go_on().succeeds();
    assert_eq!(run.json()["tiles_found"], 0);
    assert!(fs::read(scene.tin()).unwrap() == scene.expected);
    assert_eq!(scene.folder.names(), ["dem.tif", "tin.ply"]);
}

#[test]
fn an_interrupted_run_says_how_to_continue() {
    let scene = Scene::new();
    // In either pass, with work enough left that the signal comes before the end.
    for (signal, code, point, count) in [("INT", 130, "chunk-renamed", 2), ("TERM", 143, "tile-begun", 15)] {
        let halted = Halted::at(point, count, scene.command(&["--threads", "1"]));
        halted.signal(signal);
        halted.go_on().fails(code, &["stopped", &scene.work(), "the same command continues"]);
        assert_eq!(scene.folder.names(), ["dem.tif", "work"]);
        assert!(scene.chunks().len() >= 2);
    }
    assert_eq!(scene.completes(), TILES);
}

#[test]
fn a_full_disk_leaves_it_resumable() {
    let scene = Scene::new();
    scene.begin(3);
    // Not even a chunk fits.
    let mut command = scene.command(&[]);
    command[1] = Dem::new(200, 600).heights(ground).write(&scene.folder, "plain.tif");
    terrabite_with_file_limit(4, &command).fails(1, &["File too large", "the same command continues"]);
    fs::remove_file(scene.folder.join("plain.tif")).unwrap();
    assert!(scene.completes() >= 3);
}

#[test]
fn folders_that_are_no_work_dirs() {
    let scene = Scene::new();
    let mut command = scene.command(&[]);
    let work = command.iter().position(|word| *word == scene.work()).unwrap();
    let precious = Folder::new();
    let file = precious.with("letters.txt", "dear");
    command[work] = precious.at("");
    terrabite(&command).fails(1, &["expected a new folder, an empty one or a work dir", &file]);
    assert_eq!(precious.names(), ["letters.txt"]);
    command[work] = file;
    terrabite(&command).fails(1, &["letters.txt", "--work-dir"]);
    command[work] = precious.at("none/work");
    terrabite(&command).fails(1, &["none/work", "--work-dir"]);
    assert_eq!(scene.folder.names(), ["dem.tif"]);
    // An empty one is taken, and left.
    let empty = Folder::new();
    command[work] = empty.at("");
    terrabite(&command).succeeds();
    assert_eq!(empty.names(), [""; 0]);
}

#[test]
fn a_run_that_fails_at_once_binds_the_folder_to_nothing() {
    let scene = Scene::new();
    scene.folder.with("tin.ply", "precious");
    scene.run(&["--max-error", "4"]).fails(1, &["--overwrite"]);
    assert_eq!(scene.folder.names(), ["dem.tif", "tin.ply"]);
    scene.run(&["--overwrite"]).succeeds();
    assert!(fs::read(scene.tin()).unwrap() == scene.expected);
    // What an earlier run has kept does not let a later one replace other people's files.
    fs::remove_file(scene.tin()).unwrap();
    scene.begin(2);
    scene.folder.with("tin.ply", "precious");
    scene.run(&[]).fails(1, &["--overwrite replaces it", "the same command with --overwrite continues"]);
    assert_eq!(fs::read(scene.tin()).unwrap(), b"precious");
}

#[test]
fn what_is_kept_is_private() {
    use std::os::unix::fs::PermissionsExt;
    let scene = Scene::new();
    scene.begin(2);
    let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode() & 0o777;
    for folder in ["work", "work/chunks"] {
        assert_eq!(mode(&scene.folder.join(folder)), 0o700);
    }
    let files = ["work/manifest.json", "work/lock", "work/staged"].map(|name| scene.folder.join(name));
    for file in files.iter().chain(&scene.chunks()) {
        assert_eq!(mode(file), 0o600, "{}", file.display());
    }
}

/// Whatever name a killed run leaves must be known: of temporary files beside the output there is one, and it is noted.
#[test]
fn no_temporary_name_comes_up_beside_the_noted_one() {
    let folder = Folder::new();
    let dem = Dem::new(60, 50).bands(2).write(&folder, "dem.tif");
    let work = Folder::new();
    for options in [&[][..], &["--z-scale", "0.3048"], &["--attributes", "2"], &["--local", "--overwrite"]] {
        let (tin, dir) = (folder.at("tin.ply"), work.at("work"));
        let command = ["simplify", &dem, &tin, "--max-error", "3", "--work-dir", &dir];
        let names = names_that_come_up(folder.path(), || {
            terrabite(command.iter().chain(options)).succeeds();
        });
        assert_eq!(names.len(), 2, "{options:?}: {names:?}");
        assert!(names[0].starts_with(".tin.ply.") && names[0].ends_with(".partial") && names[1] == "tin.ply");
        if !options.contains(&"--local") {
            fs::remove_file(tin).unwrap();
        }
    }
}
