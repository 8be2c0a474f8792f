//! A value that one thread at a time works with.

use crate::errors::RenderError;
use crate::work;
use pyo3::prelude::*;
use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};
use std::thread::{self, ThreadId};
use std::time::Duration;

/// A value behind a lock that is waited for without the GIL. A thread that works with it and asks for it again, as a progress
/// callback may, gets an error instead of waiting for itself.
pub(crate) struct Shared<T> {
    value: Mutex<T>,
    worker: Mutex<Option<ThreadId>>,
}

/// The value, until it is dropped.
pub(crate) struct Held<'a, T> {
    pub(crate) value: MutexGuard<'a, T>,
    worker: &'a Mutex<Option<ThreadId>>,
}

/// Between two attempts to get the value: a wait ends by Ctrl-C as well.
const PAUSE: Duration = Duration::from_millis(2);

impl<T> Shared<T> {
    pub(crate) fn new(value: T) -> Self {
        Self { value: Mutex::new(value), worker: Mutex::new(None) }
    }

    /// Waits for the value.
    pub(crate) fn hold(&self, py: Python<'_>) -> PyResult<Held<'_, T>> {
        work::check_process()?;
        let me = thread::current().id();
        loop {
            match self.value.try_lock() {
                Ok(value) => {
                    *lock(&self.worker) = Some(me);
                    return Ok(Held { value, worker: &self.worker });
                }
                Err(TryLockError::Poisoned(_)) => {
                    return Err(RenderError::new_err("the renderer has failed before: make another one"));
                }
                Err(TryLockError::WouldBlock) if *lock(&self.worker) == Some(me) => {
                    return Err(RenderError::new_err("the renderer is at work: a callback of it cannot use it"));
                }
                Err(TryLockError::WouldBlock) => {
                    py.detach(|| thread::sleep(PAUSE));
                    py.check_signals()?;
                }
            }
        }
    }
}

impl<T> Drop for Held<'_, T> {
    fn drop(&mut self) {
        *lock(self.worker) = None;
    }
}

/// Locks a value that no panic leaves half changed.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
