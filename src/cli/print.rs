//! Standard output and standard error. `println!` and `eprintln!` panic when nobody listens; these do not.

use std::io::{ErrorKind, Write};

use super::{Failure, warnings};
use crate::base::warning::Warnings;
use crate::run::report::Line;

/// Prints a report on standard output. Whoever closed the pipe has read enough: that is no failure.
pub(crate) fn report(text: &str) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.write_all(b"\n")).and_then(|()| out.flush()) {
        Err(e) if e.kind() != ErrorKind::BrokenPipe => Err(Failure::new(format!("standard output: {e}"))),
        _ => Ok(()),
    }
}

/// Prints a report as JSON on standard output, indented as people read it.
pub(crate) fn json(value: &impl serde::Serialize) -> Result<(), Failure> {
    report(&serde_json::to_string_pretty(value).map_err(Failure::new)?)
}

/// Prints what came of a command: as JSON, or as warnings and lines, unless it is to be quiet.
pub(crate) fn told(
    value: &impl serde::Serialize,
    warned: &Warnings,
    lines: impl FnOnce() -> Vec<Line>,
    is_json: bool,
    is_quiet: bool,
) -> Result<(), Failure> {
    if is_json {
        return json(value);
    }
    if is_quiet {
        return Ok(());
    }
    warnings::print(warned);
    report(&aligned(&lines()))
}

/// Prints a message on standard error; where that is closed there is nobody to tell.
pub(crate) fn error(message: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{message}");
}

/// A report as lines of a name and a value, the values aligned.
pub(crate) fn aligned(lines: &[(&str, String)]) -> String {
    let width = lines.iter().map(|(name, _)| name.len()).max().unwrap_or(0);
    let lines: Vec<String> = lines.iter().map(|(name, value)| format!("{name:width$}  {value}")).collect();
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    #[test]
    fn values_stand_in_one_column() {
        let lines = [("size", "2 × 3".to_string()), ("type", "Int16".to_string()), ("nodata", "none".to_string())];
        assert_eq!(super::aligned(&lines), "size    2 × 3\ntype    Int16\nnodata  none");
    }
}
