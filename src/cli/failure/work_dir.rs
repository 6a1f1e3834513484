//! What mends a work dir that cannot be used, and what becomes of what one keeps. In what its job differs from this one is told in
//! the words of options.

use std::path::Path;

use super::Failure;
use crate::job::work_dir::{Difference, WorkDirError};
use crate::run::Fate;

impl From<WorkDirError> for Failure {
    fn from(error: WorkDirError) -> Failure {
        let failure = Failure::new(&error);
        let other_job = "restore what differs, choose another --work-dir, or delete this one";
        match error {
            WorkDirError::OtherJob { .. } => in_options(error).hint(other_job),
            WorkDirError::Manifest { .. } => failure.hint(other_job),
            WorkDirError::NoEarlier { .. } => failure.hint("choose another --update"),
            WorkDirError::NotPlanned { .. } => failure.hint("terrabite plan lays one out, or tiles-plan"),
            WorkDirError::OtherProgram { .. } => {
                failure.hint("use that version, or lay the run out in another folder with this one")
            }
            WorkDirError::InUse { .. } => failure.hint("wait for it, or choose another --work-dir"),
            _ => failure.hint("choose another --work-dir"),
        }
    }
}

/// What is to be done with finished tiles. `with`: what the same command needs in addition to continue.
pub(in crate::cli) fn kept(dir: &Path, fate: &Fate, with: &str) -> String {
    let (dir, way_out) = (dir.display(), "delete that folder, or restore the input");
    match fate {
        Fate::Damaged => format!("terrabite run {dir} --pass 1, and the passes after it, make it again"),
        Fate::Incomplete { pass: Some(pass) } => {
            format!("terrabite run {dir} --pass {pass} makes them, once the passes before are there")
        }
        Fate::Incomplete { pass: None } => {
            format!("make all passes of {dir} (terrabite run), then merge again: a search takes about two rounds")
        }
        Fate::Continue => format!("finished tiles are kept in {dir}: the same command{with} continues"),
        Fate::Outdated(files) if files.is_empty() => {
            format!("the finished tiles in {dir} were made from the old one: {way_out}")
        }
        Fate::Outdated(files) => {
            format!("the finished tiles in {dir} were made before {} changed: {way_out}", files.join(", "))
        }
    }
}

/// A parameter of a job: what it is called in a work dir, the options that choose it, and the value that stands for none.
const OPTIONS: [(&str, &str, &str); 37] = [
    ("max error", "--max-error", NONE),
    ("feasibility", "--feasibility", NONE),
    ("tile", "--tile", NONE),
    ("engine", "--engine and its options", NONE),
    ("quality", "--quality", NONE),
    ("heights", "--heights", "sampled"),
    ("polishing", "--polish-… options", NONE),
    ("smallest angle", "--min-angle", "0"),
    ("max stray", "--max-stray", "inf"),
    ("edges in polishing", "--polish-edges", "weak"),
    ("trim", "--trim", "0 cells"),
    ("max points", "--max-points", NONE),
    ("max triangles", "--max-triangles", NONE),
    ("max RMS error", "--max-rms", NONE),
    ("points", "--points", NONE),
    ("breaklines", "--breaklines, --footprints, --lake-polygons", NONE),
    ("nodata", "--nodata, --valid-range", NONE),
    ("cutline", "--cutline", NONE),
    ("fill holes", "--fill-holes", "0"),
    ("channels", "--attributes", NONE),
    ("emphasis", "--attribute-weight", NONE),
    ("planar", "--image", NONE),
    ("importance raster", "--importance", NONE),
    ("max level", "--max-level", NONE),
    ("error factor", "--error-factor", NONE),
    ("grid factor", "--grid-factor", NONE),
    ("vertical CRS", "--vertical-crs", NONE),
    ("outside", "--outside", NONE),
    ("voids", "--void-as", NONE),
    ("fine heights", "--fine-heights", NONE),
    ("own samples", "--own-samples", NONE),
    ("gzip", "--gzip", NONE),
    ("the raster's band", "--band", NONE),
    ("the raster's encoding", "--encoding", NONE),
    ("the raster's open options", "--oo", NONE),
    ("the raster's window", "--window, --bbox", NONE),
    ("the importance raster's band", "--importance-band", NONE),
];

/// What is said of an option that is not given.
const NONE: &str = "not given";

/// A work dir of another job: each parameter by its option, with plain values.
fn in_options(error: WorkDirError) -> Failure {
    match error {
        WorkDirError::OtherJob { dir, differences } => {
            let differences = differences.into_iter().map(in_option).collect();
            Failure::new(WorkDirError::OtherJob { dir, differences })
        }
        error => Failure::new(error),
    }
}

fn in_option(difference: Difference) -> Difference {
    let [expected, found] = difference.plain();
    let named = OPTIONS.iter().find(|(what, ..)| *what == difference.what);
    let (option, none) = named.map_or((difference.what.as_str(), NONE), |(_, option, none)| (*option, *none));
    let in_words = |value: Option<String>| match (value.as_deref(), difference.what.as_str()) {
        (Some(""), "nodata") | (Some("none"), "the raster's nodata") => "no nodata value".to_string(),
        (Some("true"), _) => "given".to_string(),
        // Of a tolerance, and of a level.
        (Some("false" | "open" | "by the rule"), _) => NONE.to_string(),
        (Some(value), _) => value.to_string(),
        (None, _) => none.to_string(),
    };
    Difference { what: option.to_string(), expected: Some(in_words(expected)), found: Some(in_words(found)) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::exact_double;

    fn message(what: &str, expected: Option<&str>, found: Option<&str>) -> String {
        let [expected, found] = [expected, found].map(|value| value.map(str::to_string));
        let differences = vec![Difference { what: what.to_string(), expected, found }];
        let message = in_options(WorkDirError::OtherJob { dir: "W".into(), differences }).message;
        message.strip_prefix("W: the work dir belongs to another job: ").expect("the same sentence").to_string()
    }

    #[test]
    fn parameters_are_named_by_their_options() {
        let [five, six] = [5.0, 6.0].map(exact_double);
        assert_eq!(message("max error", Some(&five), Some(&six)), "--max-error: 5 in the work dir, 6 now");
        assert_eq!(message("max error", Some("open"), Some(&six)), "--max-error: not given in the work dir, 6 now");
        assert_eq!(message("max stray", Some("1.5"), None), "--max-stray: 1.5 in the work dir, inf now");
        assert_eq!(message("gzip", Some("false"), Some("true")), "--gzip: not given in the work dir, given now");
        let nodata = "--nodata, --valid-range: no nodata value in the work dir, not given now";
        assert_eq!(message("nodata", Some(""), None), nodata);
        let tag = "the raster's nodata: no nodata value in the work dir, -9999 now";
        assert_eq!(message("the raster's nodata", Some("none"), Some("-9999")), tag);
        // What no option decides keeps its name.
        assert_eq!(message("PROJ", Some("9.1.1"), Some("9.2.0")), "PROJ: 9.1.1 in the work dir, 9.2.0 now");
    }

    /// Options that are named are there, and no parameter is named twice.
    #[test]
    fn the_table_is_sound() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/options.md");
        let page = std::fs::read_to_string(folder).expect("the page of options");
        for (i, (what, options, _)) in OPTIONS.iter().enumerate() {
            assert!(OPTIONS[..i].iter().all(|(other, ..)| other != what), "{what} twice");
            let named = options.split([' ', ',']).filter(|word| word.starts_with("--") && !word.ends_with('…'));
            assert!(named.clone().all(|option| page.contains(&format!("`{option}"))), "{options}");
        }
    }
}
