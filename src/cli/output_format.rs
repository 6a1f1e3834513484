//! Formats of output files: the extension of a name says which one is meant, or `--format` does.
//!
//! In come the name of an output and what `--format` says; out goes the format. A name that says nothing, or names a format
//! that is not written, is refused before any work: the file would not be what its name promises.

use std::path::Path;

use clap::builder::PossibleValuesParser;

use super::Failure;
use crate::formats::FORMATS;

/// A format that a command writes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Format {
    /// What `--format` calls it.
    pub(super) name: &'static str,
    /// What names of such files end in, in lower case and without the dot; the usual one first.
    pub(super) extensions: &'static [&'static str],
}

/// What `simplify` writes: the table of formats.
pub(super) const MESHES: &[Format] = &{
    let mut meshes = [Format { name: "", extensions: &[] }; FORMATS.len()];
    let mut i = 0;
    while i < FORMATS.len() {
        meshes[i] = Format { name: FORMATS[i].name, extensions: FORMATS[i].extensions };
        i += 1;
    }
    meshes
};

/// What `preview` writes.
pub(super) const PICTURES: &[Format] = &[Format { name: "png", extensions: &["png"] }];

/// What `synth` writes.
pub(super) const RASTERS: &[Format] = &[Format { name: "gtiff", extensions: &["tif", "tiff"] }];

/// The parser of a command's `--format`.
pub(super) fn names(formats: &[Format]) -> PossibleValuesParser {
    formats.iter().map(|format| format.name).collect::<Vec<_>>().into()
}

/// The format in which `output` is to be written: `asked` by `--format`, or as its extension says, in upper or lower case.
///
/// # Errors
/// Exit code 2: `-`, for outputs are put together in a folder before they take their name; and, where nothing is asked, a
/// name with another extension or with none. Folders are left to whoever stages the output.
pub(super) fn of<'a>(output: &Path, asked: Option<&str>, formats: &'a [Format]) -> Result<&'a Format, Failure> {
    let usual = formats[0].extensions[0];
    if output.as_os_str() == "-" {
        return Err(Failure::usage("-: expected the name of a file, found the sign for standard output")
            .hint(&format!("name a file, such as out.{usual}")));
    }
    if let Some(format) = asked.and_then(|name| formats.iter().find(|format| format.name == name)) {
        return Ok(format);
    }
    let extension = output.extension().filter(|e| !e.is_empty()).map(|e| e.to_string_lossy().to_ascii_lowercase());
    let is_its = |format: &&Format| extension.as_deref().is_some_and(|e| format.extensions.contains(&e));
    if let Some(format) = formats.iter().find(is_its) {
        return Ok(format);
    }
    if output.is_dir() {
        return Ok(&formats[0]);
    }
    Err(refused(output, formats))
}

fn refused(output: &Path, formats: &[Format]) -> Failure {
    let ends = listed(formats.iter().flat_map(|f| f.extensions).map(|e| format!(".{e}")).collect());
    let options = match formats {
        [only] => format!("--format {}", only.name),
        [usual, others @ ..] => {
            let others = listed(others.iter().map(|f| f.name.to_string()).collect());
            format!("--format {} (or {others})", usual.name)
        }
        [] => String::new(),
    };
    let name = output.display();
    match output.extension().filter(|e| !e.is_empty()) {
        Some(found) => {
            let found = found.display();
            Failure::usage(format!("{name}: expected a name that ends in {ends}, found the extension .{found}"))
                .hint(&format!("choose another name, or use {options} to write that format under this name"))
        }
        None => Failure::usage(format!("{name}: expected a name that ends in {ends}, found no extension"))
            .hint(&format!("add the extension, or use {options}")),
    }
}

/// Words with commas, and "or" before the last.
fn listed(mut words: Vec<String>) -> String {
    match words.pop() {
        Some(last) if !words.is_empty() => format!("{} or {last}", words.join(", ")),
        last => last.unwrap_or_default(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(output: &str, asked: Option<&str>) -> String {
        format!("{:?}", of(Path::new(output), asked, MESHES).expect_err("refused"))
    }

    #[test]
    fn the_extension_or_the_option_says_the_format() {
        for name in ["x.ply", "x.PLY", "a.b/x.Ply", "x.obj.ply"] {
            assert_eq!(of(Path::new(name), None, MESHES).map(|f| f.name), Ok("ply"), "{name}");
        }
        for name in ["x.obj", "x.OBJ", "x.ply.obj"] {
            assert_eq!(of(Path::new(name), None, MESHES).map(|f| f.name), Ok("obj"), "{name}");
        }
        for name in ["x.obj", "x", "x.", ".ply", "ply", "./-"] {
            assert_eq!(of(Path::new(name), Some("ply"), MESHES).map(|f| f.name), Ok("ply"), "{name}");
        }
        assert!(of(Path::new("x.TIFF"), None, RASTERS).is_ok() && of(Path::new("x.jpg"), None, PICTURES).is_err());
    }

    #[test]
    fn other_names_are_refused() {
        for name in ["x.wrl", "x.off", "x.ply.gz", "x.obj "] {
            let found = name.rsplit('.').next().unwrap();
            let said = message(name, None);
            assert!(
                said.contains(&format!("{name}: expected a name that ends in .ply, .obj, .glb"))
                    && said.contains(&format!("found the extension .{found}")),
                "{said}"
            );
            assert!(said.contains("use --format ply (or obj, glb") && said.contains("to write that format"), "{said}");
        }
        for name in ["x", "x.", ".ply", "ply", "./-"] {
            let said = message(name, None);
            assert!(said.contains("found no extension; add the extension, or use --format ply (or obj"), "{said}");
        }
    }

    #[test]
    fn standard_output_is_always_refused() {
        for asked in [None, Some("ply")] {
            assert!(message("-", asked).contains("standard output; name a file, such as out.ply"));
        }
    }
}
