//! The tests' own means: what they share is made once.

use std::fs::{self, OpenOptions};
use std::io::Write;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use crate::util::{Folder, Run, made_once};

/// The folder in which a child of this program is to ask for what is shared.
const CHILD: &str = "TERRABITE_TEST_SHARED";

/// Asks for a folder whose making takes a while, and notes each making in `log`.
fn ask(parent: &Path, content: &str) -> PathBuf {
    let make = |folder: &Path| {
        fs::create_dir(folder).expect("nothing is there, and nobody else makes it");
        let mut log = OpenOptions::new().create(true).append(true).open(parent.join("log")).unwrap();
        writeln!(log, "{content}").unwrap();
        std::thread::sleep(Duration::from_millis(200));
        fs::write(folder.join("whole"), "").unwrap();
    };
    let folder = made_once(parent, "thing", content, |folder| folder.join("whole").exists(), make);
    assert!(folder.join("whole").exists(), "it was given away before it was whole");
    folder
}

#[test]
fn what_tests_share_is_made_once_by_threads_and_processes() {
    if let Some(parent) = std::env::var_os(CHILD) {
        ask(Path::new(&parent), "first");
        return;
    }
    let folder = Folder::new();
    let log = || fs::read_to_string(folder.join("log")).unwrap();
    std::thread::scope(|scope| {
        for _ in 0..3 {
            scope.spawn(|| ask(folder.path(), "first"));
            scope.spawn(|| {
                let own_name = "shared::what_tests_share_is_made_once_by_threads_and_processes";
                let mut child = Command::new(std::env::current_exe().unwrap());
                let run = Run::of(child.args(["--exact", own_name]).env(CHILD, folder.path())).succeeds();
                assert!(run.out.contains("1 passed"), "{run:#?}");
            });
        }
    });
    assert_eq!(log(), "first\n");
    // Other content takes its place, and is made once, too.
    ask(folder.path(), "second");
    ask(folder.path(), "second");
    assert_eq!(log(), "first\nsecond\n");
    // What is no longer usable is made anew.
    fs::remove_file(folder.join("thing/whole")).unwrap();
    ask(folder.path(), "second");
    assert_eq!(log(), "first\nsecond\nsecond\n");
}

/// Neither does the lock stay, nor does anybody take the half for the whole.
#[test]
fn what_could_not_be_made_is_made_by_the_next() {
    let folder = Folder::new();
    let fails = |path: &Path| {
        fs::create_dir(path).unwrap();
        panic!("no network");
    };
    let failed = catch_unwind(AssertUnwindSafe(|| made_once(folder.path(), "thing", "first", |_| true, fails)));
    assert!(failed.is_err() && folder.join("thing").exists());
    ask(folder.path(), "first");
    assert_eq!(fs::read_to_string(folder.join("log")).unwrap(), "first\n");
}
