//! Ctrl-C and termination: the first asks the run to stop and clean up, the second ends the process at once. And mapped
//! files that are truncated while they are in use.

use std::ffi::CString;
use std::io;
use std::os::unix::ffi::OsStrExt;
use std::path::Path;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicI32, Ordering};

use signal_hook::consts::{SIGBUS, SIGINT, SIGKILL, SIGSTOP, SIGTERM};
use signal_hook::iterator::Signals;
use signal_hook::low_level::{emulate_default_handler, raise};

use super::Failure;
use crate::base::control::CancelToken;
use crate::base::faults::Action;

static SIGNAL: AtomicI32 = AtomicI32::new(0);
static TOKEN: OnceLock<CancelToken> = OnceLock::new();

/// The token that a signal cancels: one for the process, as signals are.
pub(crate) fn token() -> CancelToken {
    TOKEN.get_or_init(CancelToken::default).clone()
}

/// Starts listening. SIGHUP is left alone, so that `nohup` keeps its meaning.
pub(super) fn listen() -> Result<(), Failure> {
    let cannot = |e| Failure::new(format!("signals cannot be caught: {e}"));
    let mut signals = Signals::new([SIGINT, SIGTERM]).map_err(cannot)?;
    let token = token();
    let wait = move || {
        for signal in signals.forever() {
            if token.is_cancelled() {
                // Fails only for signals that cannot be raised; these two can.
                let _ = emulate_default_handler(signal);
            }
            SIGNAL.store(signal, Ordering::Relaxed);
            token.cancel();
        }
    };
    std::thread::Builder::new().name("signals".to_string()).spawn(wait).map_err(cannot)?;
    Ok(())
}

/// What tests ask for at a moment of their choice. The thread that comes to it goes no further.
pub(super) fn act(action: Action) {
    // A process may end and halt itself: this fails for signals that do not exist.
    let _ = raise(match action {
        Action::Kill => SIGKILL,
        Action::Stop => SIGSTOP,
    });
}

/// What a shell reports of a process that the signal ended: 128 + its number.
pub(super) fn exit_code() -> u8 {
    match SIGNAL.load(Ordering::Relaxed) {
        0 => 1,
        signal => 128 + signal as u8,
    }
}

/// From now on, a mapped file that loses bytes while they are being read ends this process with exit code 1 and
/// `message` on standard error instead of a bare SIGBUS; `partial`, the unfinished output, is removed first. May be called once per process.
///
/// # Errors
/// What the system says; a NUL byte in the path.
#[allow(unsafe_code)]
pub(super) fn exit_on_truncation(message: &str, partial: &Path) -> io::Result<()> {
    let message = format!("{message}\n").into_bytes();
    let partial = CString::new(partial.as_os_str().as_bytes())?;
    let end = move || {
        // Nobody is left to be told that this failed.
        let _ = rustix::io::write(rustix::stdio::stderr(), &message);
        let _ = rustix::fs::unlink(partial.as_c_str());
        signal_hook::low_level::exit(1);
    };
    // SAFETY: the action makes three system calls that are safe in a signal handler (write, unlink, _exit), allocates
    // nothing, takes no lock and does not return.
    unsafe { signal_hook::low_level::register(SIGBUS, end) }.map(|_| ())
}
