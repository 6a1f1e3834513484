//! Files that take their name when they are complete, under races and faults.

use std::fs;
use std::io::Write;
use std::path::Path;

use super::{OutputError, StagedFile};

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn appears_whole_at_the_commit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tin.ply");
    let mut staged = StagedFile::create(&path, false, &[]).unwrap();
    staged.file().write_all(b"ply").unwrap();
    let partial = names(folder.path());
    assert!(partial.len() == 1 && partial[0].starts_with(".tin.ply.") && partial[0].ends_with(".partial"));
    staged.commit().unwrap();
    assert_eq!(names(folder.path()), ["tin.ply"]);
    assert_eq!(fs::read(&path).unwrap(), b"ply");
}

#[test]
fn dropping_leaves_nothing_and_spares_the_old_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tin.ply");
    fs::write(&path, "old").unwrap();
    let mut staged = StagedFile::create(&path, true, &[]).unwrap();
    staged.file().write_all(b"new").unwrap();
    drop(staged);
    assert_eq!(names(folder.path()), ["tin.ply"]);
    assert_eq!(fs::read(&path).unwrap(), b"old");
}

#[test]
fn an_existing_file_needs_overwrite() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tin.ply");
    fs::write(&path, "old").unwrap();
    let refused = StagedFile::create(&path, false, &[]).unwrap_err();
    assert!(matches!(refused, OutputError::Exists { .. }) && refused.to_string().contains("exists already"));
    StagedFile::create(&path, true, &[]).unwrap().commit().unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"");
}

#[test]
fn a_file_that_comes_up_meanwhile_is_spared() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tin.ply");
    let staged = StagedFile::create(&path, false, &[]).unwrap();
    fs::write(&path, "other").unwrap();
    assert!(matches!(staged.commit(), Err(OutputError::Exists { .. })));
    assert_eq!(names(folder.path()), ["tin.ply"]);
    assert_eq!(fs::read(&path).unwrap(), b"other");
}

#[test]
fn a_writer_of_its_own_may_replace_the_partial_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("dem.tif");
    let staged = StagedFile::create(&path, false, &[]).unwrap();
    fs::remove_file(staged.partial_path()).unwrap();
    fs::write(staged.partial_path(), "II*").unwrap();
    staged.commit().unwrap();
    assert_eq!(names(folder.path()), ["dem.tif"]);
    assert_eq!(fs::read(&path).unwrap(), b"II*");
}

#[test]
fn folders_that_are_missing_or_files() {
    let folder = tempfile::tempdir().unwrap();
    let missing = StagedFile::create(&folder.path().join("none/tin.ply"), false, &[]).unwrap_err();
    assert!(matches!(missing, OutputError::NoFolder { .. }), "{missing}");
    fs::write(folder.path().join("file"), "").unwrap();
    let file = StagedFile::create(&folder.path().join("file/tin.ply"), false, &[]).unwrap_err();
    assert!(matches!(file, OutputError::NoFolder { .. }), "{file}");
    assert_eq!(names(folder.path()), ["file"]);
}

#[test]
fn what_is_no_file_is_never_replaced() {
    let folder = tempfile::tempdir().unwrap();
    for path in [folder.path(), Path::new("/dev/null")] {
        let refused = StagedFile::create(path, true, &[]).unwrap_err();
        assert!(matches!(refused, OutputError::NotAFile { .. }), "{refused}");
    }
    assert!(matches!(
        StagedFile::create(Path::new(".."), true, &[]),
        Err(OutputError::NotAFile { .. } | OutputError::NoName { .. })
    ));
}

#[cfg(unix)]
mod unix {
    use super::*;
    use std::os::unix::fs::{PermissionsExt, symlink};

    #[test]
    fn the_input_is_known_under_every_name() {
        let folder = tempfile::tempdir().unwrap();
        let input = folder.path().join("dem.tif");
        fs::write(&input, "dem").unwrap();
        let (link, hard) = (folder.path().join("link"), folder.path().join("hard"));
        symlink(&input, &link).unwrap();
        fs::hard_link(&input, &hard).unwrap();
        for output in [&input, &link, &hard, &folder.path().join("../").join(folder.path()).join("./dem.tif")] {
            let refused = StagedFile::create(output, true, &[&input]).unwrap_err();
            assert!(matches!(refused, OutputError::IsInput { .. }), "{refused}");
        }
        let names_of_gdal = Path::new("/vsizip/dem.zip/dem.tif");
        assert!(StagedFile::create(&folder.path().join("tin.ply"), false, &[names_of_gdal]).is_ok());
    }

    #[test]
    fn private_until_complete_then_as_any_new_file() {
        let folder = tempfile::tempdir().unwrap();
        let mode = |p: &Path| fs::metadata(p).unwrap().permissions().mode() & 0o777;
        fs::write(folder.path().join("ordinary"), "").unwrap();
        let path = folder.path().join("tin.ply");
        let staged = StagedFile::create(&path, false, &[]).unwrap();
        assert_eq!(mode(staged.partial_path()), 0o600);
        staged.commit().unwrap();
        assert_eq!(mode(&path), mode(&folder.path().join("ordinary")));
        fs::set_permissions(&path, PermissionsExt::from_mode(0o640)).unwrap();
        StagedFile::create(&path, true, &[]).unwrap().commit().unwrap();
        assert_eq!(mode(&path), 0o640);
    }

    #[test]
    fn a_link_stays_a_link() {
        let folder = tempfile::tempdir().unwrap();
        let elsewhere = tempfile::tempdir().unwrap();
        let target = elsewhere.path().join("tin.ply");
        fs::write(&target, "old").unwrap();
        let link = folder.path().join("tin.ply");
        symlink(&target, &link).unwrap();
        let mut staged = StagedFile::create(&link, true, &[]).unwrap();
        staged.file().write_all(b"new").unwrap();
        staged.commit().unwrap();
        assert!(link.is_symlink());
        assert_eq!(fs::read(&target).unwrap(), b"new");
    }
}

/// Every name that comes up in the folder, by the kernel's account.
#[cfg(target_os = "linux")]
mod names_that_come_up {
    use super::*;
    use rustix::fs::inotify::{self, CreateFlags, WatchFlags};
    use std::cell::RefCell;
    use std::mem::MaybeUninit;

    /// What is made or moved into `folder` while `run` runs, each name once.
    fn while_running(folder: &Path, run: impl FnOnce()) -> Vec<String> {
        let watch = inotify::init(CreateFlags::NONBLOCK).unwrap();
        inotify::add_watch(&watch, folder, WatchFlags::CREATE | WatchFlags::MOVED_TO).unwrap();
        run();
        let mut buffer = [MaybeUninit::uninit(); 4096];
        let mut events = inotify::Reader::new(&watch, &mut buffer);
        let mut names: Vec<String> = Vec::new();
        while let Ok(event) = events.next() {
            let name = event.file_name().unwrap().to_string_lossy().into_owned();
            if !names.contains(&name) {
                names.push(name);
            }
        }
        names
    }

    #[test]
    fn none_but_the_announced_one_and_the_final_one() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("tin.ply");
        let announced = RefCell::new(Vec::new());
        let announce = |partial: &Path| {
            assert!(!partial.exists(), "it is announced before it is made");
            announced.borrow_mut().push(partial.file_name().unwrap().to_string_lossy().into_owned());
            Ok(())
        };
        let names = while_running(folder.path(), || {
            StagedFile::create_announced(&path, false, &[], &announce).unwrap().commit().unwrap();
        });
        let mut expected = announced.borrow().clone();
        expected.push("tin.ply".to_string());
        assert_eq!(names, expected);
    }

    #[test]
    fn a_check_makes_none() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("tin.ply");
        assert_eq!(while_running(folder.path(), || StagedFile::check(&path, false, &[]).unwrap()), [""; 0]);
        fs::write(&path, "old").unwrap();
        assert!(matches!(StagedFile::check(&path, false, &[]), Err(OutputError::Exists { .. })));
        let nowhere = folder.path().join("none/tin.ply");
        assert!(matches!(StagedFile::check(&nowhere, false, &[]), Err(OutputError::NoFolder { .. })));
    }
}

/// What `with` has beside an output of these bytes, which may be overwritten or not; and what is in the folder then.
fn beside(
    old: Option<&str>,
    with: Option<&str>,
    overwrite: bool,
) -> (Result<(), OutputError>, Vec<String>, Option<String>) {
    let folder = tempfile::tempdir().unwrap();
    let (path, prj) = (folder.path().join("tin.obj"), folder.path().join("tin.prj"));
    if let Some(old) = old {
        fs::write(&prj, old).unwrap();
    }
    let mut staged = StagedFile::create(&path, overwrite, &[]).unwrap();
    let placed = staged.beside("prj", with.map(|text| text.as_bytes().to_vec()));
    assert_eq!(fs::read_to_string(&prj).ok().as_deref(), old, "nothing happens before the commit");
    let done = placed.and_then(|()| staged.commit());
    (done, names(folder.path()), fs::read_to_string(&prj).ok())
}

#[test]
fn a_file_beside_the_output_comes_and_goes_with_it() {
    let both = ["tin.obj", "tin.prj"];
    for (old, with, overwrite, left, text) in [
        (None, Some("new"), false, &both[..], Some("new")),
        (Some("new"), Some("new"), false, &both[..], Some("new")),
        (Some("old"), Some("new"), true, &both[..], Some("new")),
        (Some("old"), None, true, &both[..1], None),
        (None, None, false, &both[..1], None),
    ] {
        let (done, names, found) = beside(old, with, overwrite);
        done.unwrap();
        assert_eq!((names, found.as_deref()), (left.iter().map(|n| n.to_string()).collect(), text), "{old:?} {with:?}");
    }
    for with in [Some("new"), None] {
        let (done, names, found) = beside(Some("old"), with, false);
        assert!(matches!(done, Err(OutputError::Exists { path }) if path.ends_with("tin.prj")));
        assert_eq!((names, found.as_deref()), (vec!["tin.prj".to_string()], Some("old")));
    }
}

#[test]
fn a_commit_that_fails_leaves_what_was_beside_the_output() {
    for old in [None, Some("old")] {
        for with in [Some("new"), None] {
            let folder = tempfile::tempdir().unwrap();
            let (path, prj) = (folder.path().join("tin.obj"), folder.path().join("tin.prj"));
            if let Some(old) = old {
                fs::write(&prj, old).unwrap();
            }
            let mut staged = StagedFile::create(&path, true, &[]).unwrap();
            staged.beside("prj", with.map(|text| text.as_bytes().to_vec())).unwrap();
            // A folder is in the way by now.
            fs::create_dir(&path).unwrap();
            assert!(matches!(staged.commit(), Err(OutputError::Write { .. })));
            assert_eq!(fs::read_to_string(&prj).ok().as_deref(), old, "{with:?}");
            assert!(!names(folder.path()).iter().any(|name| name.ends_with(".partial")));
        }
    }
}

#[test]
fn what_lies_beside_an_input_stays() {
    let folder = tempfile::tempdir().unwrap();
    let (dem, prj) = (folder.path().join("dem.asc"), folder.path().join("dem.prj"));
    fs::write(&dem, "samples").unwrap();
    fs::write(&prj, "old").unwrap();
    for name in ["dem.obj", "dem"] {
        let mut staged = StagedFile::create(&folder.path().join(name), true, &[&dem]).unwrap();
        assert!(matches!(staged.beside("prj", None), Err(OutputError::BesideInput { .. })));
    }
    let mut staged = StagedFile::create(&folder.path().join("dem.obj"), true, &[&dem, &prj]).unwrap();
    assert!(matches!(staged.beside("prj", None), Err(OutputError::IsInput { .. })));
    let mut staged = StagedFile::create(&prj, true, &[]).unwrap();
    assert!(matches!(staged.beside("prj", None), Err(OutputError::Companion { .. })));
}
