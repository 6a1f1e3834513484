//! The threads of a run.

use super::RunError;

/// Starts this number of threads.
///
/// # Errors
/// [`RunError::Threads`] where the system has not that many.
pub(super) fn start_threads(threads: usize) -> Result<rayon::ThreadPool, RunError> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.map_err(|e| RunError::Threads { threads, reason: e.to_string() })
}
