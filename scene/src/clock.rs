//! The clock that times of pictures are read from.

use std::sync::OnceLock;

static CLOCK: OnceLock<fn() -> f64> = OnceLock::new();

/// Lets all times be read from a clock of the caller's, which gives seconds since any moment and may be read on any thread: for
/// targets without a clock of their own, and for tests. Whether it was taken: the first one is, and stays.
///
/// Without it times are the system's; on `wasm32-unknown-unknown`, which has no clock, all are 0.
pub fn set_clock(clock: fn() -> f64) -> bool {
    CLOCK.set(clock).is_ok()
}

/// Measures seconds from when it was made.
///
/// ```
/// let watch = scene::Stopwatch::start();
/// assert!(watch.seconds() >= 0.0);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Stopwatch {
    start: f64,
}

impl Stopwatch {
    /// Starts now.
    #[must_use]
    pub fn start() -> Self {
        Self { start: now() }
    }

    /// Seconds since.
    #[must_use]
    pub fn seconds(&self) -> f64 {
        now() - self.start
    }

    /// Seconds since, and starts again.
    pub fn lap(&mut self) -> f64 {
        let now = now();
        now - core::mem::replace(&mut self.start, now)
    }
}

fn now() -> f64 {
    CLOCK.get().map_or_else(system, |clock| clock())
}

#[cfg(not(all(target_family = "wasm", target_os = "unknown")))]
fn system() -> f64 {
    use std::sync::LazyLock;
    use std::time::Instant;
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    START.elapsed().as_secs_f64()
}

/// There is no clock to ask: it would panic.
#[cfg(all(target_family = "wasm", target_os = "unknown"))]
fn system() -> f64 {
    0.0
}
