//! The written mesh in readers that others wrote: Python's trimesh and meshio, pinned, in an environment of their own.

use std::path::{Path, PathBuf};
use std::process::Command;

use terrabite::base::channels::{Channel, Number};
use terrabite::base::staged::StagedFile;
use terrabite::formats::{Contents, Header, PlySink, Sink};

use crate::util::{Dem, Folder, Run, made_once, terrabite};

const PACKAGES: [&str; 3] = ["meshio==5.3.5", "numpy==2.3.5", "trimesh==5.2.0"];

/// Set where the package index cannot be reached.
const SKIP: &str = "TERRABITE_SKIP_READERS";

#[test]
fn trimesh_and_meshio_read_what_was_written() {
    if std::env::var_os(SKIP).is_some_and(|v| v == "1") {
        eprintln!("skipped: {SKIP}=1");
        return;
    }
    let python = python();
    let folder = Folder::new();
    let tin = folder.at("tin.ply");
    for (name, dem, tile) in [
        ("map.tif", Dem::new(120, 90).on_the_map(), "32"),
        ("plain.tif", Dem::new(120, 90), "0"),
        ("south-up.tif", Dem::new(60, 45).geo_transform([500.0, 2.0, 0.0, 100.0, 0.0, 2.0]), "16"),
    ] {
        let dem = dem.write(&folder, name);
        let run = ["simplify", &dem, &tin, "--max-error", "2", "--tile", tile, "--overwrite", "--json"];
        let report = terrabite(run).succeeds().json();
        let (vertices, triangles) = (report["vertices"].to_string(), report["triangles"].to_string());
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/it/readers.py");
        Run::of(Command::new(&python).arg(script).args([&tin, &vertices, &triangles])).succeeds();
    }
}

/// Two triangles whose vertices have the colours (10·i, 0, 255) and a heat of 0.5·i.
#[test]
fn trimesh_and_meshio_read_colours_and_other_attributes() {
    if std::env::var_os(SKIP).is_some_and(|v| v == "1") {
        eprintln!("skipped: {SKIP}=1");
        return;
    }
    let folder = Folder::new();
    let tin = folder.join("tin.ply");
    let channel = |name: &str, number| Channel { name: name.to_string(), number };
    let mut attributes = ["red", "green", "blue"].map(|name| channel(name, Number::U8)).to_vec();
    attributes.push(channel("heat", Number::F32));
    let mut sink = PlySink::new(StagedFile::create(&tin, false, &[]).unwrap(), Header::default());
    sink.begin(&Contents { vertices: 4, triangles: 2, attributes: &attributes, ..Contents::default() }).unwrap();
    let places = [[0.5, -0.5, 1.0], [0.5, -9.5, 2.0], [9.5, -9.5, 3.0], [9.5, -0.5, 4.0]];
    let red: Vec<f64> = (0..4).map(|i| 10.0 * f64::from(i)).collect();
    let heat: Vec<f64> = (0..4).map(|i| 0.5 * f64::from(i)).collect();
    sink.vertices(&places, &[&red, &[0.0; 4], &[255.0; 4], &heat]).unwrap();
    sink.triangles(&[[0, 1, 2], [0, 2, 3]], &[]).unwrap();
    Box::new(sink).finish().unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/it/readers.py");
    let arguments = [&folder.at("tin.ply"), "4", "2", "colours"];
    Run::of(Command::new(python()).arg(script).args(arguments)).succeeds();
}

/// The interpreter of a virtual environment with [`PACKAGES`], made under the target folder at the first run.
fn python() -> PathBuf {
    let parent = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let python = |environment: &Path| environment.join("bin/python");
    let usable = |environment: &Path| python(environment).exists();
    python(&made_once(parent, "readers", &PACKAGES.join("\n"), usable, |environment| {
        let made = Run::of(Command::new(system_python()).args(["-m", "venv"]).arg(environment));
        assert_eq!(made.code, Some(0), "python3 -m venv failed, `make setup` installs it: {made:#?}");
        let pip = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--only-binary=:all:"];
        let installed = Run::of(Command::new(python(environment)).args(pip).args(PACKAGES));
        assert_eq!(installed.code, Some(0), "PyPI cannot be reached? {SKIP}=1 skips this test: {installed:#?}");
    }))
}

/// The first Python that can make environments for [`PACKAGES`]. The one of the path may be another than the system's,
/// without `venv` or too old; `scripts/setup.sh` looks at the same two.
fn system_python() -> &'static str {
    let suits = "import ensurepip, sys, venv; sys.exit(sys.version_info < (3, 11))";
    let can = |python: &&str| Command::new(python).args(["-c", suits]).output().is_ok_and(|o| o.status.success());
    let candidates = ["python3", "/usr/bin/python3"];
    candidates.into_iter().find(can).unwrap_or_else(|| panic!("no Python 3.11 with venv: `make setup` installs it"))
}
