//! What GDAL says beside its answers: warnings are kept for the user, each once, and nothing is printed by GDAL itself.
//!
//! GDAL tells a handler for the whole process, from any thread, and does not say which file it is about. So whoever opens or
//! reads a file says so by a [`About`] as long as it does.

use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use gdal::errors::CplErrType;

use crate::base::warning::{Warning, WarningCode};

/// Different messages that are kept until they are taken.
const KEPT: usize = 200;

thread_local! {
    /// The files this thread is busy with, the latest last, and whether it reads samples of them.
    static BUSY_WITH: RefCell<Vec<(PathBuf, bool)>> = const { RefCell::new(Vec::new()) };
}

/// What GDAL has said since it was taken last.
static SAID: Mutex<Said> = Mutex::new(Said { warnings: Vec::new(), latest: None });

struct Said {
    warnings: Vec<Warning>,
    /// The file that was opened last: threads of GDAL's own tell of no file.
    latest: Option<PathBuf>,
}

/// Keeps GDAL from printing on standard error by itself: errors reach the user as [`RasterError`](super::RasterError)s, once.
pub fn quiet_gdal() {
    gdal::config::set_error_handler(|_, _, _| {});
}

/// The same, and GDAL's warnings are kept for [`take_gdal_warnings`].
pub fn keep_gdal_warnings() {
    gdal::config::set_error_handler(|class, _, message| {
        if class == CplErrType::Warning {
            keep(message);
        }
    });
}

/// GDAL's warnings since the last call, in the order in which they came first. A message that comes again at a later opening
/// of the same file is no news; one that comes again while samples are read is counted.
pub fn take_gdal_warnings() -> Vec<Warning> {
    std::mem::take(&mut said().warnings)
}

fn said() -> std::sync::MutexGuard<'static, Said> {
    SAID.lock().unwrap_or_else(PoisonError::into_inner)
}

fn keep(message: &str) {
    let busy = BUSY_WITH.try_with(|busy| busy.try_borrow().ok().and_then(|b| b.last().cloned())).ok().flatten();
    let mut said = said();
    let (file, reading) =
        busy.or_else(|| said.latest.clone().map(|f| (f, true))).unwrap_or_else(|| ("GDAL".into(), true));
    let message = sentence(message, &file);
    if let Some(known) = said.warnings.iter_mut().find(|w| w.file == file && w.message == message) {
        known.count = known.count.saturating_add(u64::from(reading));
    } else if said.warnings.len() < KEPT {
        said.warnings.push(Warning { code: WarningCode::Gdal, file, count: 1, message });
    }
}

/// A message in one line, without a full stop and without the name of the file, which stands before it.
fn sentence(message: &str, file: &Path) -> String {
    let line = message.split_whitespace().collect::<Vec<_>>().join(" ");
    let name = file.display().to_string();
    let rest = line.strip_prefix(&name).and_then(|rest| rest.strip_prefix([':', ',']));
    rest.unwrap_or(&line).trim().trim_end_matches('.').to_string()
}

/// As long as it lives, what GDAL says on this thread is about a file.
#[derive(Debug)]
pub(crate) struct About(());

impl About {
    /// A file that is opened.
    pub(crate) fn opening(file: &Path) -> About {
        said().latest = Some(file.to_path_buf());
        About::file(file, false)
    }

    /// A file whose contents are read.
    pub(crate) fn reading(file: &Path) -> About {
        About::file(file, true)
    }

    fn file(file: &Path, reading: bool) -> About {
        BUSY_WITH.with_borrow_mut(|busy| busy.push((file.to_path_buf(), reading)));
        About(())
    }
}

impl Drop for About {
    fn drop(&mut self) {
        BUSY_WITH.with_borrow_mut(Vec::pop);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_becomes_a_sentence() {
        let file = Path::new("a/dem.tif");
        assert_eq!(sentence("a/dem.tif: odd  tag\n  42.", file), "odd tag 42");
        assert_eq!(sentence("a/dem.tif is odd", file), "a/dem.tif is odd");
    }

    #[test]
    fn openings_are_told_once_and_readings_counted() {
        let file = Path::new("no file of any other test");
        for _ in 0..3 {
            let _about = About::opening(file);
            keep("opened oddly.");
            let _about = About::reading(file);
            keep("read oddly");
        }
        let mine = |w: &Warning| (w.file == file).then(|| (w.message.clone(), w.count));
        let found: Vec<_> = take_gdal_warnings().iter().filter_map(mine).collect();
        assert_eq!(found, [("opened oddly".to_string(), 1), ("read oddly".to_string(), 3)]);
    }
}
