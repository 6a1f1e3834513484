//! Names of outputs: a file is what its name says, or `--format` says what it is.

use crate::util::{Dem, Folder, terrabite, with_both};

/// Every command that writes a file, with the extension it writes and its `--format`.
fn commands(dem: &str, tin: &str) -> [(Vec<String>, &'static str, &'static str); 3] {
    let words = |words: &[&str]| words.iter().map(|word| word.to_string()).collect();
    [
        (words(&["simplify", dem, "OUT", "--max-error", "1"]), "ply", "ply"),
        (words(&["preview", dem, tin, "OUT"]), "png", "png"),
        (words(&["synth", "OUT", "--size", "32x32"]), "tif", "gtiff"),
    ]
}

fn with_output(command: &[String], output: &str, more: &[&str]) -> Vec<String> {
    let named = command.iter().map(|word| if word == "OUT" { output.to_string() } else { word.clone() });
    named.chain(more.iter().map(|word| word.to_string())).collect()
}

#[test]
fn unknown_extensions_are_refused_before_any_work() {
    let (folder, dem, tin) = with_both();
    let before = folder.names();
    for (command, _, format) in commands(&dem, &tin) {
        for (name, found) in [
            ("x.wrl", "found the extension .wrl"),
            ("x.off", "found the extension .off"),
            ("x.jpg", "found the extension .jpg"),
            ("x.asc", "found the extension .asc"),
            ("x.ply.gz", "found the extension .gz"),
            ("x", "found no extension"),
            (".ply", "found no extension"),
        ] {
            let output = folder.at(name);
            let run = terrabite(with_output(&command, &output, &[]));
            run.fails(2, &[&format!("{output}: expected a name that ends in ."), found, &format!("--format {format}")]);
        }
        // Nothing is opened: there is no such raster.
        let nothing: Vec<String> =
            command.iter().map(|word| if *word == dem { "none.tif".to_string() } else { word.clone() }).collect();
        terrabite(with_output(&nothing, "x.wrl", &[])).fails(2, &["x.wrl"]);
    }
    assert_eq!(folder.names(), before);
}

#[test]
fn upper_case_is_the_same_and_an_option_takes_any_name() {
    let (folder, dem, tin) = with_both();
    for (command, extension, format) in commands(&dem, &tin) {
        let [plain, upper, other, none] =
            [format!("y.{extension}"), format!("x.{}", extension.to_uppercase()), "x.dat".into(), "x".into()];
        let bytes = |name: &str, more: &[&str]| {
            terrabite(with_output(&command, &folder.at(name), more)).succeeds();
            let bytes = std::fs::read(folder.join(name)).unwrap();
            std::fs::remove_file(folder.join(name)).unwrap();
            bytes
        };
        let expected = bytes(&plain, &[]);
        assert!(bytes(&upper, &[]) == expected);
        assert!(bytes(&other, &["--format", format]) == expected);
        assert!(bytes(&none, &["--format", format]) == expected);
        terrabite(with_output(&command, &folder.at(&plain), &["--format", "off"])).fails(2, &["off", "--format"]);
    }
    assert_eq!(folder.names(), ["dem.tif", "tin.ply"]);
}

#[test]
fn standard_output_is_no_output() {
    let (_folder, dem, tin) = with_both();
    for (command, extension, format) in commands(&dem, &tin) {
        for more in [&[][..], &["--format", format]] {
            let run = terrabite(with_output(&command, "-", more));
            run.fails(2, &["standard output", &format!("name a file, such as out.{extension}")]);
        }
    }
}

#[test]
fn a_folder_is_called_a_folder() {
    let folder = Folder::new();
    let dem = Dem::new(20, 10).write(&folder, "dem.tif");
    terrabite(["simplify", &dem, &folder.at("."), "--max-error", "1"]).fails(1, &["a folder"]);
}
