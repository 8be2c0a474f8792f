//! Error scopes whose results come later.

use core::future::{Future, poll_fn};
use core::pin::Pin;
use core::task::{Context, Poll, Waker};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The three results of a piece of work: internal errors, memory, validation.
const KINDS: usize = 3;

/// The result of an error scope.
type Popped = Pin<Box<dyn Future<Output = Option<wgpu::Error>> + Send>>;

/// A piece of work, and the results that are still to come.
struct Scoped {
    what: &'static str,
    pops: Vec<Popped>,
    error: Option<wgpu::Error>,
}

impl Scoped {
    /// Whether all results are there. The first error stays.
    fn is_done(&mut self, context: &mut Context<'_>) -> bool {
        let error = &mut self.error;
        self.pops.retain_mut(|pop| match pop.as_mut().poll(context) {
            Poll::Ready(found) => {
                if error.is_none() {
                    *error = found;
                }
                false
            }
            Poll::Pending => true,
        });
        self.pops.is_empty()
    }
}

/// An error, and the work that it came from.
pub(crate) type Found = (&'static str, wgpu::Error);

/// The error scopes of a device that are not settled. Natively each is settled at once; a browser settles them in later turns.
#[derive(Clone, Default)]
pub(crate) struct Scopes {
    list: Arc<Mutex<Vec<Scoped>>>,
}

impl core::fmt::Debug for Scopes {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Scopes").field("unsettled", &self.list().len()).finish()
    }
}

impl Scopes {
    /// Runs `work` in scopes for all errors. An error that is known at once, or of earlier work, is returned.
    pub(crate) fn run<T>(
        &self,
        device: &wgpu::Device,
        what: &'static str,
        work: impl FnOnce() -> T,
    ) -> Result<T, Found> {
        use wgpu::ErrorFilter::{Internal, OutOfMemory, Validation};
        let [validation, memory, internal] =
            [Validation, OutOfMemory, Internal].map(|filter| device.push_error_scope(filter));
        let value = work();
        let mut pops: Vec<Popped> = Vec::with_capacity(KINDS);
        // Innermost first.
        pops.push(Box::pin(internal.pop()));
        pops.push(Box::pin(memory.pop()));
        pops.push(Box::pin(validation.pop()));
        let mut context = Context::from_waker(Waker::noop());
        let mut scoped = Scoped { what, pops, error: None };
        let is_done = scoped.is_done(&mut context);
        let mut list = self.list();
        if list.is_empty() && is_done {
            return scoped.error.map_or(Ok(value), |error| Err((what, error)));
        }
        list.push(scoped);
        take_error(&mut list, &mut context).map_or(Ok(value), Err)
    }

    /// Waits until all scopes are settled. Returns the first error of those that were not.
    pub(crate) async fn settle(&self) -> Result<(), Found> {
        poll_fn(|context| {
            let mut list = self.list();
            match take_error(&mut list, context) {
                Some(found) => Poll::Ready(Err(found)),
                None if list.is_empty() => Poll::Ready(Ok(())),
                None => Poll::Pending,
            }
        })
        .await
    }

    fn list(&self) -> MutexGuard<'_, Vec<Scoped>> {
        self.list.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Removes settled scopes from the front of the list. Returns the error of the first that has one; what came after it followed from
/// it, and is forgotten.
fn take_error(list: &mut Vec<Scoped>, context: &mut Context<'_>) -> Option<Found> {
    let mut found = None;
    let mut is_first = true;
    list.retain_mut(|scoped| {
        // All are polled, so that each wakes who waits.
        let is_settled = scoped.is_done(context) && is_first;
        is_first &= is_settled;
        if is_settled && found.is_none() {
            found = scoped.error.take().map(|error| (scoped.what, error));
        }
        !is_settled
    });
    if found.is_some() {
        list.clear();
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicBool, Ordering};

    /// A result that comes when it is let go.
    fn later(is_there: &Arc<AtomicBool>, error: Option<&'static str>) -> Popped {
        let is_there = Arc::clone(is_there);
        Box::pin(poll_fn(move |_| match is_there.load(Ordering::Relaxed) {
            true => {
                Poll::Ready(error.map(|text| wgpu::Error::Internal { source: text.into(), description: text.into() }))
            }
            false => Poll::Pending,
        }))
    }

    fn push(scopes: &Scopes, what: &'static str, pops: Vec<Popped>) {
        scopes.list().push(Scoped { what, pops, error: None });
    }

    #[test]
    fn errors_that_come_later_name_the_first_work_that_failed() {
        let (scopes, first, second) = (Scopes::default(), Arc::default(), Arc::default());
        push(&scopes, "a", vec![later(&first, None), later(&first, Some("broken")), later(&first, Some("again"))]);
        push(&scopes, "b", vec![later(&second, Some("follows"))]);
        let mut context = Context::from_waker(Waker::noop());
        let mut settle = Box::pin(scopes.settle());
        assert!(settle.as_mut().poll(&mut context).is_pending());
        // The second comes earlier, but is not the cause.
        second.store(true, Ordering::Relaxed);
        assert!(settle.as_mut().poll(&mut context).is_pending());
        first.store(true, Ordering::Relaxed);
        let Poll::Ready(Err((what, error))) = settle.as_mut().poll(&mut context) else { panic!("an error") };
        assert_eq!((what, error.to_string().contains("broken")), ("a", true));
        drop(settle);
        assert!(pollster::block_on(scopes.settle()).is_ok());
    }

    #[test]
    fn work_without_errors_leaves_nothing() {
        let (scopes, there) = (Scopes::default(), Arc::new(AtomicBool::new(true)));
        push(&scopes, "a", vec![later(&there, None), later(&there, None)]);
        assert!(pollster::block_on(scopes.settle()).is_ok());
        assert!(scopes.list().is_empty());
    }
}
