//! The command line itself: help, exit codes, closed pipes.

use std::process::{Command, Stdio};

use crate::util::{Dem, Folder, Kind, terrabite};

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
    let names: Vec<&str> = commands.lines().filter_map(|l| l.strip_prefix("  ")?.split(' ').next()).collect();
    assert!(names.contains(&"info") && names.contains(&"tiles-plan"), "{help}");
    // Every command is told in one line.
    assert!(names.iter().all(|name| !name.is_empty()), "{help}");
    for name in names {
        let help = terrabite([name, "--help"]).succeeds().out;
        assert!(help.contains("Exit codes:"), "{help}");
    }
}

#[test]
fn version() {
    let short = format!("terrabite {}\n", env!("CARGO_PKG_VERSION"));
    assert_eq!(terrabite(["-V"]).succeeds().out, short);
    let long = terrabite(["--version"]).succeeds().out;
    assert!(long.starts_with(&short), "{long}");
    for words in ["\nGDAL ", ", PROJ ", " raster drivers: ", ", GTiff, "] {
        assert!(long.contains(words), "{words} in {long}");
    }
}

#[test]
fn shells_and_manuals_are_told_of_every_command() {
    let help = terrabite(["--help"]).succeeds().out;
    for shell in ["bash", "zsh", "fish"] {
        let script = terrabite(["completions", shell]).succeeds().out;
        for word in ["simplify", "verify", "max-error", "checkpoints"] {
            assert!(help.contains("simplify") && script.contains(word), "{word} in that of {shell}");
        }
    }
    let folder = Folder::new();
    let script = folder.with("terrabite.bash", terrabite(["completions", "bash"]).succeeds().out);
    let checked = Command::new("bash").args(["-n", &script]).status().unwrap();
    assert!(checked.success());
    terrabite(["completions", "tcl"]).fails(2, &["tcl"]);

    assert!(terrabite(["man"]).succeeds().out.contains(".TH terrabite 1"));
    let page = terrabite(["man", "verify"]).succeeds().out;
    assert!(page.contains(".TH terrabite-verify 1") && page.contains("checkpoints"), "{page}");
    terrabite(["man", "bite"]).fails(2, &["bite", "simplify"]);
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

/// Options that do not go together are found before anything is opened: the files here are missing.
#[test]
fn all_conflicts_are_reported_at_once_with_exit_code_2() {
    let lines = |options: &[&str]| {
        let run = terrabite(["simplify", "none.tif", "tin.ply"].iter().chain(options)).fails(2, &["error: "]);
        run.err.lines().map(|line| line.strip_prefix("error: ").expect("an error").to_string()).collect::<Vec<_>>()
    };
    let many = [
        "--max-error",
        "1",
        "--attributes",
        "2",
        "--fill-holes",
        "9",
        "--importance",
        "w.tif",
        "--shape",
        "smallest-angle",
    ];
    let found = lines(&many);
    let expected = [
        ("--attributes cannot be combined with --fill-holes: ", "; remove --fill-holes"),
        ("--attributes cannot be combined with --importance: ", "; remove --importance"),
        ("--shape requires --swap data-dependent: ", "; use --swap data-dependent"),
    ];
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for (line, (begin, end)) in found.iter().zip(expected) {
        assert!(line.starts_with(begin) && line.ends_with(end), "{line}");
    }
    let scaled = lines(&["--max-error", "1", "--attributes", "2", "--quality", "none", "--z-scale", "0.3"]);
    assert!(scaled[0].starts_with("--attributes cannot be combined with --z-scale 0.3: "), "{scaled:?}");
    assert!(scaled[0].ends_with("; use --z-scale 1 or another power of two"), "{scaled:?}");
    for (command, options) in [
        ("verify", &["tin.ply", "--max-error", "1", "--importance", "w.tif", "--attributes", "2"][..]),
        ("info", &["--band", "2", "--encoding", "terrarium"]),
        ("preview", &["tin.ply", "out.png", "--band", "2", "--encoding", "terrarium"]),
    ] {
        terrabite([command, "none.tif"].iter().chain(options)).fails(2, &[" cannot be combined with ", "; remove --"]);
    }
}

/// What a message says is to be done once: it leads to no other one.
#[test]
fn no_way_out_leads_into_another_refusal() {
    let folder = Folder::new();
    let dem = Dem::new(20, 10).bands(2).write(&folder, "dem.tif");
    let run = |options: &[&str]| {
        let fixed = ["simplify", &dem, &folder.at("tin.ply"), "--max-error", "1", "--overwrite"];
        terrabite(fixed.iter().chain(options))
    };
    let message = "--attributes cannot be combined with --heights fitted: ";
    run(&["--attributes", "2", "--heights", "fitted"]).fails(2, &[message, "; remove --heights fitted\n"]);
    run(&["--attributes", "2"]).succeeds();
    run(&["--quality", "none", "--min-angle", "9"]).fails(2, &["--min-angle requires", "; use --quality balanced\n"]);
    run(&["--quality", "balanced", "--min-angle", "9"]).succeeds();
}

/// Whether single precision holds the heights is known once the raster is open: an infinite height is not come to.
#[test]
fn a_loss_that_is_certain_is_refused_before_samples_are_read() {
    let folder = Folder::new();
    let strange = |c: usize, _: usize| if c == 7 { f64::INFINITY } else { 5.0 };
    let dem = Dem::new(20, 10).kind(Kind::Float64).heights(strange).write(&folder, "dem.tif");
    let tin = folder.at("tin.ply");
    let run = |more: &[&str]| {
        let fixed = ["simplify", &dem, &tin, "--max-error", "1", "--attributes", "1"];
        terrabite(fixed.iter().chain(more))
    };
    run(&["--precision", "float"]).fails(2, &["--attributes cannot be combined with --precision float: "]);
    run(&[]).fails(1, &["inf", "column 7, row 0"]);
}
