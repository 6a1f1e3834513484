//! `terrabite plan`, `run` and `merge`: whoever makes the tiles, in whatever order, the bytes are those of `simplify`.

use std::fs;
use std::path::PathBuf;
use std::process::Command;

use crate::resume::{dem, ground};
use crate::util::{Folder, Halted, Run, is_long, terrabite, terrabite_with_fault};

/// Options of the mesh: 12 tiles, four passes.
const OPTIONS: [&str; 4] = ["--max-error", "3", "--tile", "100"];
const PASSES: usize = 4;
/// Exit code: tiles wait for others.
const WAITING: i32 = 6;

/// A run that is laid out in a folder, and the mesh that `simplify` makes of it.
struct Scene {
    folder: Folder,
    dem: String,
    expected: Vec<u8>,
}

impl Scene {
    fn new(options: &[&str]) -> Scene {
        Scene::of(&[&OPTIONS, options].concat())
    }

    /// With no options but these.
    fn of(options: &[&str]) -> Scene {
        let folder = Folder::new();
        let dem = dem().write(&folder, "dem.tif");
        let tin = folder.at("tin.ply");
        terrabite([["simplify", &dem, &tin].as_slice(), options].concat()).succeeds();
        let expected = fs::read(&tin).unwrap();
        fs::remove_file(tin).unwrap();
        let scene = Scene { folder, dem, expected };
        scene.plan_as(options).succeeds();
        scene
    }

    fn plan(&self, options: &[&str]) -> Run {
        self.plan_as(&[&OPTIONS, options].concat())
    }

    fn plan_as(&self, options: &[&str]) -> Run {
        terrabite([["plan", &self.dem, &self.work()].as_slice(), options].concat())
    }

    fn work(&self) -> String {
        self.folder.at("work")
    }

    fn command(&self, shard: &str, options: &[&str]) -> Vec<String> {
        let work = self.work();
        let words = [["run", &work, "--shard", shard, "--json"].as_slice(), options].concat();
        words.into_iter().map(str::to_string).collect()
    }

    fn run(&self, shard: &str, options: &[&str]) -> Run {
        terrabite(self.command(shard, options))
    }

    fn merge(&self, options: &[&str]) -> Run {
        terrabite([["merge", &self.work(), &self.folder.at("tin.ply")].as_slice(), options].concat())
    }

    /// The mesh must be there, with the bytes of `simplify`, and nothing else.
    #[track_caller]
    fn merges(&self) {
        self.merge(&[]).succeeds();
        assert!(fs::read(self.folder.join("tin.ply")).unwrap() == self.expected, "other bytes");
        assert_eq!(self.folder.names(), ["dem.tif", "tin.ply"]);
    }

    fn chunk(&self, name: &str) -> PathBuf {
        self.folder.join("work/chunks").join(name)
    }
}

/// Tiles that were made, found and wait, over all passes.
fn tiles(run: &Run) -> [u64; 3] {
    let passes = run.json()["passes"].as_array().unwrap().clone();
    ["made", "found", "waiting"].map(|name| passes.iter().map(|pass| pass[name].as_u64().unwrap()).sum())
}

#[test]
fn any_number_of_shards_in_any_order_makes_the_same_bytes() {
    let numbers: &[usize] = if is_long() { &[1, 3, 64] } else { &[3, 16] };
    for &of in numbers {
        let scene = Scene::new(&[]);
        for pass in 1..=PASSES {
            let pass = pass.to_string();
            // Backwards, and the second half first.
            let numbers = (1..=of).rev();
            let (late, early): (Vec<usize>, Vec<usize>) = numbers.partition(|n| 2 * n <= of);
            for number in early.into_iter().chain(late) {
                scene.run(&format!("{number}/{of}"), &["--pass", &pass]).succeeds();
            }
        }
        scene.merges();
    }
}

#[test]
fn shards_do_what_they_can_and_say_when_they_wait() {
    let scene = Scene::new(&[]);
    let first = scene.run("1/2", &[]);
    assert_eq!(first.code, Some(WAITING), "{first:?}");
    let [made, found, waiting] = tiles(&first);
    assert!(made > 6 && found == 0 && waiting > 0, "{made} {found} {waiting}");
    let mut runs = vec![scene.run("2/2", &[])];
    while runs[runs.len() - 1].code != Some(0) || runs.len() % 2 == 1 {
        assert!(runs.len() < 12, "{runs:#?}");
        runs.push(scene.run(if runs.len() % 2 == 1 { "1/2" } else { "2/2" }, &[]));
    }
    let rest: u64 = runs.iter().map(|run| tiles(run)[0]).sum();
    assert_eq!(made + rest, 12 + 21 + 14 + 18, "each tile is made once");
    scene.merges();
}

#[test]
fn killed_and_doubled_shards_make_the_same_bytes() {
    let scene = Scene::new(&[]);
    for (fault, shard, pass) in [
        ("kill:tile-begun:1", "1/2", "1"),
        ("kill:chunk-written:2", "1/2", "1"),
        ("kill:chunk-renamed:3", "2/2", "1"),
        ("kill:chunk-written:1", "2/2", "1"),
    ] {
        let run = terrabite_with_fault(fault, scene.command(shard, &["--pass", pass]));
        assert_eq!(run.code, None, "{fault}: {run:?}");
    }
    // Two processes at one shard: the first stands still with a chunk that is about to get its name.
    let slow = Halted::at("chunk-written", 1, scene.command("1/1", &["--pass", "1"]));
    scene.run("1/1", &["--pass", "1"]).succeeds();
    slow.go_on().succeeds();
    for pass in ["2", "3", "4"] {
        let killed = terrabite_with_fault("kill:chunk-renamed:2", scene.command("1/1", &["--pass", pass]));
        assert_eq!(killed.code, None, "{killed:?}");
        scene.run("1/1", &["--pass", pass]).succeeds();
    }
    scene.merges();
}

#[test]
fn what_is_missing_is_listed_and_made_again() {
    let scene = Scene::new(&[]);
    scene.merge(&[]).fails(WAITING, &["tiles of pass 4", "missing: column 0 row 0", "terrabite run", "--pass 4"]);
    scene.run("1/1", &[]).succeeds();
    fs::remove_file(scene.chunk("down/1/0.chunk")).unwrap();
    let torn = fs::read(scene.chunk("down/2/1.chunk")).unwrap();
    fs::write(scene.chunk("down/2/1.chunk"), &torn[..torn.len() / 2]).unwrap();
    fs::remove_file(scene.chunk("1/1.chunk")).unwrap();
    scene.merge(&[]).fails(WAITING, &["found 2 missing: column 0 row 1, column 1 row 2;"]);
    assert!(!scene.folder.join("tin.ply").exists());
    let again = scene.run("1/1", &[]).succeeds();
    assert_eq!(tiles(&again)[0], 3);
    scene.merges();
}

#[test]
fn the_plan_is_what_counts() {
    let scene = Scene::new(&["--quality", "none", "--local"]);
    scene.run("1/1", &[]).succeeds();
    let glb = scene.folder.at("tin.glb");
    terrabite(["merge", &scene.work(), &glb]).fails(2, &["laid out for, PLY", "found GLB", "--format glb"]);
    terrabite(["merge", &scene.work(), &scene.folder.at("tin")])
        .fails(2, &["a name of the format", "name the output .ply"]);
    // The same run goes on; another one is refused, and so is what only one process can find out.
    scene.plan(&["--quality", "none", "--local"]).succeeds();
    scene.plan(&["--quality", "none"]).succeeds();
    scene.plan(&["--quality", "fast", "--local"]).fails(1, &["another job", "--quality", "another WORK"]);
    scene
        .plan(&["--quality", "none", "--max-triangles", "100"])
        .fails(2, &["a budget of triangles", "made in shards", "--max-error"]);
    scene.plan(&["--quality", "none", "--local"]).succeeds();
    scene.run("1/1", &["--pass", "5"]).fails(2, &["expected a pass from 1 to 1", "--pass"]);
    for shard in ["0/3", "4/3", "1/0", "x", "1"] {
        scene.run(shard, &[]).fails(2, &["expected a part such as 3/64"]);
    }
    // Whoever merges reads no samples, so nothing is decoded, even if that is asked for.
    let merged = scene.merge(&["--keep-work-dir", "--json", "--access", "decode"]).succeeds();
    assert_eq!(merged.json()["access"]["how"], "windows");
    assert_eq!(scene.folder.names(), ["dem.tif", "tin.ply", "work"]);
    fs::remove_file(scene.folder.join("tin.ply")).unwrap();
    scene.folder.with("tin.ply", "mine");
    scene.merge(&[]).fails(1, &["--overwrite"]);
    scene.merge(&["--overwrite"]).succeeds();
    assert!(fs::read(scene.folder.join("tin.ply")).unwrap() == scene.expected);
    assert_eq!(scene.folder.names(), ["dem.tif", "tin.ply"]);
}

/// A search takes several runs. Whoever merges says at which tolerance, and the bytes are those of one process.
#[test]
fn a_budget_is_met_in_rounds() {
    // Single precision: what it loses is taken from every tolerance that is tried.
    let budget = ["--max-triangles", "1500", "--precision", "float", "--tile", "100"];
    let quality = ["--max-rms", "0.9", "--quality", "fast", "--tile", "100"];
    for options in [budget.as_slice(), &quality] {
        let scene = Scene::of(options);
        let runs = |merged: &Run| merged.json()["goal"]["search"]["runs"].as_u64().unwrap();
        let once =
            terrabite([["simplify", &scene.dem, &scene.folder.at("other.ply"), "--json"].as_slice(), options].concat());
        fs::remove_file(scene.folder.join("other.ply")).unwrap();
        let mut tolerances = Vec::new();
        let merged = loop {
            for shard in ["2/2", "1/2", "2/2"] {
                tolerances.push(scene.run(shard, &[]).json()["tolerance"].as_f64().unwrap());
            }
            let merged = scene.merge(&["--json"]);
            if merged.code != Some(WAITING) {
                break merged.succeeds();
            }
            merged.fails(WAITING, &["which the search tries next", "terrabite run", "merge again"]);
            // Laid out once more it goes on.
            scene.plan_as(options).succeeds();
        };
        tolerances.dedup();
        assert_eq!(runs(&merged), runs(&once));
        assert_eq!(tolerances.len() as u64, runs(&once), "{tolerances:?}");
        let is_budget = options == budget;
        assert!(tolerances.len() > 1 || !is_budget, "no second round");
        assert!(fs::read(scene.folder.join("tin.ply")).unwrap() == scene.expected, "other bytes");
        assert_eq!(scene.folder.names(), ["dem.tif", "tin.ply"]);
    }
}

#[test]
fn folders_without_a_plan_are_refused() {
    let folder = Folder::new();
    fs::create_dir(folder.join("other")).unwrap();
    for name in ["missing", "other"] {
        terrabite(["run", &folder.at(name)]).fails(1, &["in which a run is laid out", "terrabite plan"]);
        terrabite(["merge", &folder.at(name), &folder.at("tin.ply")]).fails(1, &["terrabite plan"]);
    }
    let scene = Scene::new(&[]);
    let plan = scene.folder.join("work/plan.json");
    let text = fs::read_to_string(&plan).unwrap();
    fs::write(&plan, text.replace(env!("CARGO_PKG_VERSION"), "0.0.1")).unwrap();
    scene.run("1/1", &[]).fails(1, &["found one by terrabite 0.0.1", "use that version"]);
    fs::write(&plan, "{}").unwrap();
    scene.run("1/1", &[]).fails(1, &["plan.json", "missing field"]);
}

/// Names of files are those of the folder that the plan was made in, and the raster may be elsewhere.
#[test]
fn a_plan_can_be_followed_from_anywhere() {
    let scene = Scene::new(&[]);
    fs::remove_dir_all(scene.folder.join("work")).unwrap();
    let program = env!("CARGO_BIN_EXE_terrabite");
    let mut plan = Command::new(program);
    plan.current_dir(scene.folder.path()).args(["plan", "dem.tif", "work"]).args(OPTIONS);
    Run::of(&mut plan).succeeds();
    scene.run("1/2", &["--pass", "1"]).succeeds();
    let moved = scene.folder.at("moved.tif");
    fs::rename(&scene.dem, &moved).unwrap();
    scene.run("2/2", &["--pass", "1"]).fails(1, &["dem.tif"]);
    scene.run("2/2", &["--pass", "1", "--raster", &moved]).succeeds();
    fs::rename(&moved, &scene.dem).unwrap();
    // Whoever has the whole machine may go on by itself.
    let tin = scene.folder.at("tin.ply");
    let run = terrabite(
        [["simplify", &scene.dem, &tin, "--json", "--work-dir", &scene.work()].as_slice(), &OPTIONS].concat(),
    );
    assert_eq!(run.succeeds().json()["tiles_found"], 12);
    assert!(fs::read(&tin).unwrap() == scene.expected);
    assert_eq!(scene.folder.names(), ["dem.tif", "tin.ply"]);
}

#[test]
fn a_changed_raster_takes_over_what_no_change_concerns() {
    let scene = Scene::new(&[]);
    scene.run("1/1", &[]).succeeds();
    scene.merge(&["--keep-work-dir"]).succeeds();
    let old = scene.folder.at("old");
    fs::rename(scene.work(), &old).unwrap();
    fs::remove_file(scene.folder.join("tin.ply")).unwrap();
    // A hill in the third of six rows of tiles.
    let changed = |column, row| {
        ground(column, row) + if (90..110).contains(&column) && (230..250).contains(&row) { 40.0 } else { 0.0 }
    };
    let dem = dem().heights(changed).write(&scene.folder, "dem.tif");
    let tin = scene.folder.at("tin.ply");
    terrabite([["simplify", &dem, &tin].as_slice(), &OPTIONS].concat()).succeeds();
    let expected = fs::read(&tin).unwrap();
    assert!(expected != scene.expected);
    fs::remove_file(tin).unwrap();
    scene.plan(&["--quality", "fast", "--update", &old]).fails(1, &["another job", "--quality"]);
    let planned = scene.plan(&["--update", &old, "--json"]).succeeds();
    let count = |name: &str| planned.json()["taken_over"][name].as_u64().unwrap();
    let run = scene.run("1/1", &[]).succeeds();
    let [made, found, _] = tiles(&run);
    assert_eq!([count("taken"), count("tiles")], [found, made + found]);
    assert!(found >= 20 && made >= 20, "{made} {found}");
    fs::remove_dir_all(old).unwrap();
    Scene { expected, ..scene }.merges();
}

/// Chunks of the old raster and of the new one never become one mesh.
#[test]
fn a_raster_that_changes_between_passes_is_refused() {
    let scene = Scene::new(&[]);
    scene.run("1/1", &["--pass", "1"]).succeeds();
    let raised = |column, row| ground(column, row) + if (column, row) == (40, 250) { 9.0 } else { 0.0 };
    dem().heights(raised).write(&scene.folder, "dem.tif");
    for shard in ["1/1", "1/2", "2/2"] {
        scene.run(shard, &["--pass", "2"]).fails(1, &["dem.tif: the raster has changed", "checksum"]);
    }
    // As it was, at another time.
    dem().write(&scene.folder, "dem.tif");
    for pass in ["2", "3", "4"] {
        scene.run("1/1", &["--pass", pass]).succeeds();
    }
    scene.merges();
}

#[test]
fn where_the_rim_is_trimmed_chunks_of_the_first_pass_are_needed_to_the_end() {
    let folder = Folder::new();
    let with_void =
        |column, row| if (60..90).contains(&column) && (60..90).contains(&row) { -9999.0 } else { ground(column, row) };
    let dem = dem().heights(with_void).nodata(-9999.0).write(&folder, "dem.tif");
    let (work, tin) = (folder.at("work"), folder.at("tin.ply"));
    terrabite([["plan", &dem, &work, "--trim", "2"].as_slice(), &OPTIONS].concat()).succeeds();
    terrabite(["run", &work]).succeeds();
    fs::remove_file(folder.join("work/chunks/0/1.chunk")).unwrap();
    terrabite(["merge", &work, &tin]).fails(WAITING, &["tiles of pass 1", "missing: column 1 row 0;", "--pass 1"]);
    terrabite(["run", &work, "--pass", "1"]).succeeds();
    terrabite(["merge", &work, &tin]).succeeds();
    // A damaged one is found by whoever needs it, and the message says what makes it again.
    terrabite([["plan", &dem, &work].as_slice(), &OPTIONS].concat()).succeeds();
    terrabite(["run", &work, "--pass", "1"]).succeeds();
    fs::copy(folder.join("work/chunks/0/1.chunk"), folder.join("work/chunks/0/0.chunk")).unwrap();
    terrabite(["run", &work, "--pass", "2"]).fails(1, &["damaged", "--pass 1, and the passes after it, make it again"]);
    terrabite(["run", &work]).succeeds();
}
