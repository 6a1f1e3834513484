//! Ctrl-C and termination: the first asks the run to stop and clean up, the second ends the process at once.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicI32, Ordering};

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::iterator::Signals;
use signal_hook::low_level::emulate_default_handler;

use super::Failure;
use crate::base::control::CancelToken;

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

/// What a shell reports of a process that the signal ended: 128 + its number.
pub(super) fn exit_code() -> u8 {
    match SIGNAL.load(Ordering::Relaxed) {
        0 => 1,
        signal => 128 + signal as u8,
    }
}
