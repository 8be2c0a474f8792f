//! What is said to the user, and what the user says by Ctrl-C.

use crate::failure::Failure;
use cosine_lobes::remove_unfinished;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::fmt::Display;
use std::io::Write;
use std::sync::atomic::{AtomicBool, Ordering};

/// Set by Ctrl-C while something is under way that can be put away in order.
pub(crate) static STOP: AtomicBool = AtomicBool::new(false);

/// While true, Ctrl-C only sets [`STOP`]; the second one ends the program at once.
static GRACEFUL: AtomicBool = AtomicBool::new(false);

/// From now on Ctrl-C and SIGTERM remove unfinished files and end the program with code 130.
pub(crate) fn catch_interrupts() -> Result<(), Failure> {
    ctrlc::set_handler(|| {
        if GRACEFUL.load(Ordering::SeqCst) && !STOP.swap(true, Ordering::SeqCst) {
            return;
        }
        remove_unfinished();
        std::process::exit(130);
    })
    .map_err(|e| Failure::new(format_args!("cannot catch Ctrl-C: {e}")))
}

/// Runs `work`, which is to end early and in order when [`STOP`] becomes true.
pub(crate) fn stoppable<T>(work: impl FnOnce() -> T) -> T {
    GRACEFUL.store(true, Ordering::SeqCst);
    let result = work();
    GRACEFUL.store(false, Ordering::SeqCst);
    result
}

/// Prints a line of the result. A reader that has gone away is no error.
pub(crate) fn say(text: impl Display) {
    let _ = writeln!(std::io::stdout(), "{text}");
}

/// Prints a line that is not part of the result.
pub(crate) fn note(text: impl Display) {
    let _ = writeln!(std::io::stderr(), "{text}");
}

/// A progress bar; invisible when `quiet` or when nobody is at the terminal.
pub(crate) fn progress(what: &str, length: u64, quiet: bool) -> ProgressBar {
    let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
    let bar = ProgressBar::with_draw_target(Some(length), target);
    if let Ok(style) = ProgressStyle::with_template("{msg:12} [{bar:40}] {percent:>3} % {eta:>6} left") {
        bar.set_style(style.progress_chars("=> "));
    }
    bar.set_message(what.to_owned());
    bar
}

/// Uses `count` threads from now on.
pub(crate) fn set_threads(count: Option<u32>) -> Result<(), Failure> {
    match count {
        None => Ok(()),
        Some(n) => rayon::ThreadPoolBuilder::new().num_threads(n as usize).build_global().map_err(Failure::from),
    }
}
