//! Memory for threads, used by one after the other.

use std::sync::{Mutex, PoisonError};

/// Memory that goes back to others when a run of groups is done.
pub(crate) struct Lent<'p, M> {
    pool: &'p Mutex<Vec<M>>,
    pub(crate) memory: Option<M>,
}

impl<'p, M> Lent<'p, M> {
    /// None, if none is free.
    pub(crate) fn new(pool: &'p Mutex<Vec<M>>) -> Self {
        Self { pool, memory: pool.lock().unwrap_or_else(PoisonError::into_inner).pop() }
    }
}

impl<M> Drop for Lent<'_, M> {
    fn drop(&mut self) {
        self.pool.lock().unwrap_or_else(PoisonError::into_inner).extend(self.memory.take());
    }
}
