//! The lock of a work dir: one process at a time.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, Write};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt};
use std::path::Path;

use super::{WorkDirError, failed};
use crate::base::durable;

pub(super) const NAME: &str = "lock";

/// A folder locked for this process, until this is dropped or the process ends.
#[derive(Debug)]
pub(super) struct Lock {
    _file: File,
    /// Whether the folder was made for the job, by this process or an earlier one; then it goes with the job. It stands
    /// in the lock file, as that is the first thing made in a folder.
    pub(super) made_folder: bool,
}

/// Locks `dir`, which this process has just made, or not.
pub(super) fn lock(dir: &Path, just_made: bool) -> Result<Lock, WorkDirError> {
    let path = dir.join(NAME);
    loop {
        let mut options = OpenOptions::new();
        options.write(true).create(true).truncate(false).mode(0o600).custom_flags(durable::NO_LINKS);
        let file = options.open(&path).map_err(failed(&path))?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Err(WorkDirError::InUse { dir: dir.to_path_buf() }),
            Err(TryLockError::Error(source)) => return Err(failed(&path)(source)),
        }
        // The one who had it may have removed the file between our opening and locking it: then this is no lock.
        let ours = file.metadata().map_err(failed(&path))?;
        if path.metadata().is_ok_and(|there| (there.dev(), there.ino()) == (ours.dev(), ours.ino())) {
            return Lock::of(file, just_made).map_err(failed(&path));
        }
    }
}

const MADE: &[u8] = b"with folder\n";

impl Lock {
    fn of(mut file: File, just_made: bool) -> io::Result<Lock> {
        if just_made {
            file.write_all(MADE)?;
            file.sync_all()?;
        }
        let made_folder = just_made || file.metadata()?.len() == MADE.len() as u64;
        Ok(Lock { _file: file, made_folder })
    }
}
