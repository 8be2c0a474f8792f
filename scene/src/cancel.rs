use core::sync::atomic::{AtomicBool, Ordering};
use std::sync::Arc;

/// A request to stop work that runs on another thread. Clones are the same request; once made it stays.
///
/// Renderers look at it once for each tile of pixels and each light, which costs a load of one byte.
///
/// ```
/// use scene::Cancel;
/// let cancel = Cancel::new();
/// let other = cancel.clone();
/// std::thread::spawn(move || other.cancel()).join().unwrap();
/// assert!(cancel.is_cancelled());
/// ```
#[derive(Clone, Debug, Default)]
pub struct Cancel(Arc<AtomicBool>);

impl Cancel {
    /// A request that was not made yet.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Makes the request.
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether it was made.
    #[must_use]
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// The flag itself, true once the request was made, for work that looks at a flag.
    #[must_use]
    pub fn flag(&self) -> &AtomicBool {
        &self.0
    }
}
