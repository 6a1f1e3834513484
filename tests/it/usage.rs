//! The command line itself: help, exit codes, closed pipes.

use std::process::{Command, Stdio};

use crate::util::{Dem, Folder, terrabite};

const NONE: [&str; 0] = [];

#[test]
fn without_arguments_it_tells_how_to_be_used() {
    terrabite(NONE).fails(2, &["Usage: terrabite", "Exit codes:"]);
}

#[test]
fn help_states_the_exit_codes_everywhere() {
    let help = terrabite(["--help"]).succeeds().out;
    assert!(help.contains("Exit codes:") && help.contains("closed pipe"), "{help}");
    let commands = help.split("Commands:").nth(1).unwrap().split("Options:").next().unwrap();
    let names = commands.lines().filter(|l| l.starts_with("  ")).filter_map(|l| l.split_whitespace().next());
    let names: Vec<&str> = names.filter(|n| n.chars().all(|c| c.is_ascii_lowercase())).collect();
    assert!(names.contains(&"info"), "{help}");
    for name in names {
        let help = terrabite([name, "--help"]).succeeds().out;
        assert!(help.contains("Exit codes:"), "{help}");
    }
}

#[test]
fn version() {
    assert_eq!(terrabite(["--version"]).succeeds().out, format!("terrabite {}\n", env!("CARGO_PKG_VERSION")));
}

#[test]
fn unknown_commands_and_options_are_usage_errors() {
    terrabite(["bite"]).fails(2, &["bite"]);
    terrabite(["info", "dem.tif", "--colour"]).fails(2, &["--colour"]);
    terrabite(["info"]).fails(2, &["RASTER"]);
    terrabite(["info", "dem.tif", "--band", "first"]).fails(2, &["first", "--band"]);
}

/// Both streams closed at the other end: no panic, and the exit code of the job.
#[test]
fn a_closed_pipe_is_no_failure() {
    let folder = Folder::new();
    let dem = Dem::new(20, 10).write(&folder, "dem.tif");
    for (arguments, code) in [(vec!["info", &dem], 0), (vec!["--help"], 0), (vec!["info", "none.tif"], 1)] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_terrabite"));
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        command.args(&arguments).stdout(writer.try_clone().unwrap()).stderr(writer).stdin(Stdio::null());
        assert_eq!(command.status().unwrap().code(), Some(code), "{arguments:?}");
    }
}
