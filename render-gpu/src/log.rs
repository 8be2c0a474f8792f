use core::time::Duration;
use scene::Stopwatch;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// A kernel that the driver has compiled.
#[derive(Clone, Debug, PartialEq)]
pub struct CompiledKernel {
    /// Its entry point and its variant, such as `penumbra (spheres, depth 5)`.
    pub name: String,
    /// The time it took; the longest one if it was compiled several times.
    pub time: Duration,
}

/// The kernels of a [`Gpu`](crate::Gpu): which are being compiled, and which have been. Clones share one log; none keeps the device
/// alive.
///
/// A driver may take seconds for a kernel without any message. While a call waits for it, another thread can read this log.
#[derive(Clone, Debug, Default)]
pub struct KernelLog {
    entries: Arc<Mutex<Entries>>,
}

#[derive(Debug, Default)]
struct Entries {
    next: u64,
    running: Vec<(u64, String, Stopwatch)>,
    done: Vec<CompiledKernel>,
}

impl KernelLog {
    /// The kernels that are being compiled, and since when.
    #[must_use]
    pub fn compiling(&self) -> Vec<CompiledKernel> {
        let running =
            |(_, name, since): &(u64, String, Stopwatch)| CompiledKernel { name: name.clone(), time: time(since) };
        self.entries().running.iter().map(running).collect()
    }

    /// The kernels that have been compiled, the slowest first, each name once.
    #[must_use]
    pub fn compiled(&self) -> Vec<CompiledKernel> {
        let mut done = self.entries().done.clone();
        done.sort_by_key(|kernel| core::cmp::Reverse(kernel.time));
        done
    }

    /// Runs `work`, which compiles a kernel, and records its time if it succeeds.
    pub(crate) fn compile<T, E>(&self, name: &str, work: impl FnOnce() -> Result<T, E>) -> Result<T, E> {
        let since = Stopwatch::start();
        let key = {
            let mut entries = self.entries();
            entries.next += 1;
            let key = entries.next;
            entries.running.push((key, name.to_owned(), since));
            key
        };
        let result = work();
        let mut entries = self.entries();
        entries.running.retain(|(running, ..)| *running != key);
        if result.is_ok() {
            let time = time(&since);
            match entries.done.iter_mut().find(|done| done.name == name) {
                Some(done) => done.time = done.time.max(time),
                None => entries.done.push(CompiledKernel { name: name.to_owned(), time }),
            }
        }
        result
    }

    /// The list stays valid even if a thread panicked while it held the lock.
    fn entries(&self) -> MutexGuard<'_, Entries> {
        self.entries.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The time since then; zero if the caller's clock has gone backward.
fn time(since: &Stopwatch) -> Duration {
    Duration::try_from_secs_f64(since.seconds()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_compiled_is_named_while_it_is_and_after() {
        let log = KernelLog::default();
        let other = log.clone();
        let names = |kernels: Vec<CompiledKernel>| kernels.into_iter().map(|kernel| kernel.name).collect::<Vec<_>>();
        for (name, millis) in [("a", 2), ("b", 20), ("a", 1)] {
            let compiled = log.compile(name, || {
                assert_eq!(names(other.compiling()), [name]);
                std::thread::sleep(Duration::from_millis(millis));
                assert!(other.compiling()[0].time >= Duration::from_millis(millis));
                Ok::<_, ()>(millis)
            });
            assert_eq!(compiled, Ok(millis));
        }
        assert_eq!(log.compile("refused", || Err::<(), _>(7)), Err(7));
        assert!(log.compiling().is_empty());
        assert_eq!(names(log.compiled()), ["b", "a"]);
        // The longer of two times.
        assert!(log.compiled()[1].time >= Duration::from_millis(2));
    }
}
