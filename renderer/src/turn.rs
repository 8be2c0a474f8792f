//! Work that a browser may do in later turns.

use crate::RenderError;
use core::pin::pin;
use core::task::{Context, Poll, Waker};

const LATER: &str = "a browser's GPU makes pictures in later turns: the asynchronous calls are for it";

/// The result of a future that waits for no later turn: all of this crate, but on a browser's GPU.
///
/// # Errors
/// [`RenderError::NotOnGpu`] there.
pub(crate) fn at_once<T>(future: impl Future<Output = T>) -> Result<T, RenderError> {
    match pin!(future).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(done) => Ok(done),
        Poll::Pending => Err(RenderError::NotOnGpu(LATER)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_later_turn_is_an_error() {
        assert_eq!(at_once(core::future::ready(7)).ok(), Some(7));
        assert!(matches!(at_once(core::future::pending::<()>()), Err(RenderError::NotOnGpu(_))));
    }
}
