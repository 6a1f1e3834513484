//! Workspaces that threads take turns with.

use std::sync::{Mutex, PoisonError};

/// Things that are costly to make and used by one thread at a time: there are never more than threads that use one at
/// once, and they are reused, last in first out, while their memory is warm. The lock is held to take one out and to
/// put it back, once per tile.
#[derive(Debug)]
pub(in crate::job) struct Pool<T> {
    idle: Mutex<Vec<T>>,
}

impl<T> Default for Pool<T> {
    fn default() -> Self {
        Pool { idle: Mutex::default() }
    }
}

impl<T: Default> Pool<T> {
    /// Lends one to `work`. It is put back only if `work` returns: after a panic it is dropped.
    pub(in crate::job) fn with<R>(&self, work: impl FnOnce(&mut T) -> R) -> R {
        let lock = || self.idle.lock().unwrap_or_else(PoisonError::into_inner);
        let taken = lock().pop();
        let mut lent = taken.unwrap_or_default();
        let result = work(&mut lent);
        lock().push(lent);
        result
    }
}
