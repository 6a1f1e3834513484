//! Work dirs: who may open them, what is left in them, and what goes.

use std::fs;
use std::path::Path;

use tempfile::{TempDir, tempdir};

use super::{Difference, Job, WorkDir, WorkDirError};
use crate::base::private_file::PrivateFile;
use crate::base::{Files, exact_double};

fn job(tolerance: &str) -> Job {
    Job {
        parameters: vec![("max error", tolerance.to_string()), ("tile", "512".to_string())],
        raster: vec![("size", "7 × 9 samples".to_string())],
        importance: Vec::new(),
        files: Files::unknown(),
    }
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// Opens `folder`/work, and leaves something like a finished tile there.
fn begun(folder: &TempDir) -> WorkDir {
    let work = WorkDir::open(&folder.path().join("work"), &job("1")).unwrap();
    fs::create_dir_all(folder.path().join("work/chunks/0")).unwrap();
    work
}

#[test]
fn differences_are_named_one_by_one() {
    let folder = tempdir().unwrap();
    drop(begun(&folder));
    let mut other = job(&exact_double(2.5));
    other.parameters.pop();
    other.parameters.push(("nodata", String::new()));
    other.raster.push(("nodata", "-1".to_string()));
    let refused = WorkDir::open(&folder.path().join("work"), &other).unwrap_err();
    let expected = "the work dir belongs to another job: max error: 1 in the work dir, 2.5 now; nodata: not given in the work dir, none now; \
                    tile: 512 in the work dir, not given now; the raster's nodata: not given in the work dir, -1 now";
    assert!(refused.to_string().ends_with(expected), "{refused}");
    WorkDir::open(&folder.path().join("work"), &job("1")).unwrap();
}

/// Bits are told only where nothing else tells values apart.
#[test]
fn values_are_plain() {
    let nans = [0x7ff8_0000_0000_0000u64, 0x7ff8_0000_0000_0001].map(f64::from_bits);
    let [a, b] = nans.map(exact_double);
    let difference = |expected: &str, found: &str| {
        let [expected, found] = [expected, found].map(|value| Some(value.to_string()));
        Difference { what: "range".to_string(), expected, found }.to_string()
    };
    assert!(difference(&a, &b).contains("NaN (bits 7ff8000000000000) in the work dir"), "{}", difference(&a, &b));
    let [low, high] = [1.5, -2.0].map(exact_double);
    let range = format!("heights from {low} to {high}");
    assert_eq!(difference(&range, &high), "range: heights from 1.5 to -2 in the work dir, -2 now");
}

#[test]
fn a_job_that_makes_something_else_differs_in_that_alone() {
    let folder = tempdir().unwrap();
    drop(begun(&folder));
    let other = Job { parameters: vec![("result", "terrain tiles".to_string())], ..job("2") };
    let refused = WorkDir::open(&folder.path().join("work"), &other).unwrap_err();
    let expected = "the work dir belongs to another job: result: a mesh in the work dir, terrain tiles now";
    assert!(refused.to_string().ends_with(expected), "{refused}");
}

#[test]
fn an_importance_raster_is_part_of_the_job() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("work");
    let with = |checksum: &str| Job { importance: vec![("checksum", checksum.to_string())], ..job("1") };
    drop(begun(&folder));
    let refused = WorkDir::open(&path, &with("abc")).unwrap_err();
    assert!(
        refused.to_string().ends_with("another job: importance raster: not given in the work dir, given now"),
        "{refused}"
    );
    begun(&folder).finish().unwrap();
    let work = WorkDir::open(&path, &with("abc")).unwrap();
    fs::create_dir_all(path.join("chunks/0")).unwrap();
    drop(work);
    let refused = WorkDir::open(&path, &job("1")).unwrap_err();
    assert!(
        refused.to_string().ends_with("another job: importance raster: given in the work dir, not given now"),
        "{refused}"
    );
    let refused = WorkDir::open(&path, &with("xyz")).unwrap_err();
    assert!(
        refused.to_string().ends_with("the importance raster's checksum: abc in the work dir, xyz now"),
        "{refused}"
    );
    WorkDir::open(&path, &with("abc")).unwrap();
}

#[test]
fn one_at_a_time() {
    let folder = tempdir().unwrap();
    let work = begun(&folder);
    let second = WorkDir::open(work.path(), &job("1")).unwrap_err();
    assert!(matches!(second, WorkDirError::InUse { .. }), "{second}");
    let path = work.path().to_path_buf();
    drop(work);
    WorkDir::open(&path, &job("1")).unwrap();
}

#[test]
fn goes_when_it_is_done_and_when_nothing_was_begun() {
    let folder = tempdir().unwrap();
    drop(WorkDir::open(&folder.path().join("work"), &job("1")).unwrap());
    assert_eq!(names(folder.path()), [""; 0]);
    begun(&folder).finish().unwrap();
    assert_eq!(names(folder.path()), [""; 0]);
    // Made by a process that was killed: it is still the work dir's own folder.
    drop(begun(&folder));
    begun(&folder).finish().unwrap();
    assert_eq!(names(folder.path()), [""; 0]);
}

#[test]
fn other_peoples_folders_stay() {
    let folder = tempdir().unwrap();
    fs::create_dir(folder.path().join("work")).unwrap();
    begun(&folder).finish().unwrap();
    assert_eq!(names(folder.path()), ["work"]);
    fs::remove_dir(folder.path().join("work")).unwrap();
    let work = begun(&folder);
    fs::write(folder.path().join("work/notes.txt"), "mine").unwrap();
    work.finish().unwrap();
    assert_eq!(names(&folder.path().join("work")), ["notes.txt"]);
}

#[test]
fn the_partial_output_of_a_killed_run_is_removed() {
    let folder = tempdir().unwrap();
    let partial = folder.path().join(".tin.ply.abc.partial");
    let work = begun(&folder);
    work.staging(&partial).unwrap();
    fs::write(&partial, "half").unwrap();
    work.committing().unwrap();
    drop(work);
    let work = begun(&folder);
    assert_eq!(names(folder.path()), ["work"]);
    assert!(!work.has_committed(&folder.path().join("tin.ply")));
}

#[test]
fn nothing_else_is_removed_in_its_name() {
    let folder = tempdir().unwrap();
    let precious = folder.path().join("letters.txt");
    fs::write(&precious, "dear").unwrap();
    begun(&folder).staging(&precious).unwrap();
    drop(begun(&folder));
    assert!(precious.exists());
    // Nor a note that makes no sense.
    fs::write(folder.path().join("work/staged"), [0xff, 0x0a, 0xff]).unwrap();
    drop(begun(&folder));
    assert_eq!(names(folder.path()), ["letters.txt", "work"]);
}

#[test]
fn an_output_that_took_its_name_is_known() {
    let folder = tempdir().unwrap();
    let (partial, output) = (folder.path().join(".tin.ply.abc.partial"), folder.path().join("tin.ply"));
    let work = begun(&folder);
    work.staging(&partial).unwrap();
    fs::write(&partial, "whole").unwrap();
    fs::write(&output, "someone else's").unwrap();
    work.committing().unwrap();
    drop(work);
    assert!(!begun(&folder).has_committed(&output));
    // The partial is gone by now; the same again, and renamed.
    let work = begun(&folder);
    work.staging(&partial).unwrap();
    fs::write(&partial, "whole").unwrap();
    work.committing().unwrap();
    fs::rename(&partial, &output).unwrap();
    drop(work);
    let work = begun(&folder);
    assert!(work.has_committed(&output));
    assert!(!work.has_committed(&folder.path().join("other.ply")));
    // A new file that gets the number of the one that was removed is not.
    fs::remove_file(&output).unwrap();
    fs::write(&output, "whole").unwrap();
    assert!(!work.has_committed(&output));
}

/// A kill between writing a note and naming it leaves the note under its private name.
#[test]
fn what_a_killed_run_has_left_of_its_notes_goes() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("work");
    for note in ["manifest.json", "staged"] {
        let work = begun(&folder);
        std::mem::forget(PrivateFile::create(&path.join(note)).unwrap());
        drop(work);
        assert_eq!(names(&path).len(), 4, "{:?}", names(&path));
        let work = begun(&folder);
        assert_eq!(names(&path), ["chunks", "lock", "manifest.json"]);
        std::mem::forget(PrivateFile::create(&path.join(note)).unwrap());
        work.finish().unwrap();
        assert_eq!(names(folder.path()), [""; 0]);
        // In a folder that has nothing else, too.
        fs::create_dir(&path).unwrap();
        std::mem::forget(PrivateFile::create(&path.join(note)).unwrap());
        begun(&folder).finish().unwrap();
        assert_eq!(names(&path), [""; 0]);
        fs::remove_dir(&path).unwrap();
    }
}

/// In a folder that others may write to.
#[test]
fn links_that_others_put_there_are_not_written_through() {
    let folder = tempdir().unwrap();
    let (work, letters) = (folder.path().join("work"), folder.path().join("letters.txt"));
    for name in ["manifest.json.partial", "lock"] {
        fs::create_dir(&work).unwrap();
        fs::write(&letters, "dear").unwrap();
        std::os::unix::fs::symlink(&letters, work.join(name)).unwrap();
        let refused = WorkDir::open(&work, &job("1")).unwrap_err();
        assert!(
            refused.to_string().contains(&format!("work/{name}").replace("manifest.json.partial", "manifest.json")),
            "{refused}"
        );
        assert_eq!(fs::read(&letters).unwrap(), b"dear");
        fs::remove_dir_all(&work).unwrap();
    }
}

/// A process that was killed between two steps leaves its folder, empty: the next run knows it as the work dir's own.
#[test]
fn a_folder_that_was_made_and_not_noted_goes_when_it_is_done() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("work");
    crate::base::durable::create_marked_dir(&path).unwrap();
    begun(&folder).finish().unwrap();
    assert_eq!(names(folder.path()), [""; 0]);
    // Nor does the mark stay on one that is in use, or that holds other people's files in the end.
    let work = begun(&folder);
    assert!(!crate::base::durable::is_marked(&path));
    fs::write(path.join("notes.txt"), "mine").unwrap();
    work.finish().unwrap();
    assert!(path.exists() && !crate::base::durable::is_marked(&path));
}

/// The folder is to be deleted then, and with it the note of where the partial output is.
#[test]
fn the_partial_output_of_a_killed_run_is_removed_when_another_job_comes() {
    let folder = tempdir().unwrap();
    let partial = folder.path().join(".tin.ply.abc.partial");
    begun(&folder).staging(&partial).unwrap();
    fs::write(&partial, "half").unwrap();
    let refused = WorkDir::open(&folder.path().join("work"), &job("2")).unwrap_err();
    assert!(matches!(refused, WorkDirError::OtherJob { .. }), "{refused}");
    assert_eq!(names(folder.path()), ["work"]);
}
