//! One result that a callback passes on.

use core::future::poll_fn;
use core::task::{Poll, Waker};
use core::time::Duration;
use std::sync::{Arc, Condvar, Mutex, PoisonError};

/// How long another thread that waits for the same device may take to pass on a result.
const PASSING: Duration = Duration::from_secs(10);

/// A place for one result: a callback sends it, a future receives it. Clones are the same place.
#[derive(Debug)]
pub(crate) struct Mail<T> {
    place: Arc<(Mutex<Letter<T>>, Condvar)>,
}

#[derive(Debug)]
struct Letter<T> {
    result: Option<T>,
    waker: Option<Waker>,
}

impl<T> Clone for Mail<T> {
    fn clone(&self) -> Self {
        Self { place: Arc::clone(&self.place) }
    }
}

impl<T> Default for Mail<T> {
    fn default() -> Self {
        Self { place: Arc::new((Mutex::new(Letter { result: None, waker: None }), Condvar::new())) }
    }
}

impl<T> Mail<T> {
    pub(crate) fn send(&self, result: T) {
        let (letter, came) = &*self.place;
        let mut letter = letter.lock().unwrap_or_else(PoisonError::into_inner);
        letter.result = Some(result);
        came.notify_all();
        if let Some(waker) = letter.waker.take() {
            waker.wake();
        }
    }

    /// Whether the result has come and is not received.
    pub(crate) fn is_there(&self) -> bool {
        self.place.0.lock().unwrap_or_else(PoisonError::into_inner).result.is_some()
    }

    /// The result. Natively the device has been polled to its end: the thread waits for another one that has taken the callback, and
    /// gets nothing if that takes too long. In a browser the future is ready once the callback has run.
    pub(crate) async fn received(&self) -> Option<T> {
        let (letter, came) = &*self.place;
        if !cfg!(target_arch = "wasm32") {
            let letter = letter.lock().unwrap_or_else(PoisonError::into_inner);
            let waited = came.wait_timeout_while(letter, PASSING, |letter| letter.result.is_none());
            return waited.unwrap_or_else(PoisonError::into_inner).0.result.take();
        }
        poll_fn(|context| {
            let mut letter = letter.lock().unwrap_or_else(PoisonError::into_inner);
            match letter.result.take() {
                Some(result) => Poll::Ready(Some(result)),
                None => {
                    letter.waker = Some(context.waker().clone());
                    Poll::Pending
                }
            }
        })
        .await
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_result_arrives_from_another_thread() {
        let mail = Mail::default();
        let sender = mail.clone();
        std::thread::spawn(move || {
            std::thread::sleep(Duration::from_millis(20));
            sender.send(7);
        });
        assert_eq!(pollster::block_on(mail.received()), Some(7));
    }
}
