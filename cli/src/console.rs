//! Output to the user, and Ctrl-C.

use crate::failure::Failure;
use cosine_lobes::remove_unfinished;
use cosine_lobes::scene::Cancel;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::fmt::Display;
use std::io::{self, ErrorKind, Write};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{LazyLock, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Made by Ctrl-C while something is under way that can be put away in order.
pub(crate) static STOP: LazyLock<Cancel> = LazyLock::new(Cancel::new);

/// While true, Ctrl-C only makes [`STOP`]; the second one ends the program at once.
static GRACEFUL: AtomicBool = AtomicBool::new(false);

/// While true, Ctrl-C ends the program also when work has not stopped after [`PATIENCE`].
static HASTY: AtomicBool = AtomicBool::new(false);

/// Longer than pictures take to stop, but for steps that nothing cuts short.
const PATIENCE: Duration = Duration::from_millis(200);

/// True once Ctrl-C ends the program.
static ENDING: AtomicBool = AtomicBool::new(false);

/// The file that an interrupted program goes on from, if it keeps one.
static KEPT: Mutex<Option<PathBuf>> = Mutex::new(None);

/// From now on an interrupted program goes on from this file, or from none.
pub(crate) fn kept(path: Option<PathBuf>) {
    *KEPT.lock().unwrap_or_else(PoisonError::into_inner) = path;
}

/// The last line of a program that Ctrl-C has ended.
pub(crate) fn interrupted() -> String {
    match &*KEPT.lock().unwrap_or_else(PoisonError::into_inner) {
        None => "lobes: interrupted; nothing half-written".to_owned(),
        Some(path) => format!(
            "lobes: interrupted: the finished work is kept in {}; the same command goes on from there",
            path.display()
        ),
    }
}

/// Waits for the end of the program once Ctrl-C has begun it. Its files are removed meanwhile, and errors that follow from this
/// are not reported.
pub(crate) fn give_way() {
    while ENDING.load(Ordering::SeqCst) {
        std::thread::park();
    }
}

/// From now on a file that grows beyond what the system allows (`ulimit -f`) is an error of its writing and does not kill the program.
#[cfg(unix)]
fn survive_file_limits() -> Result<(), Failure> {
    let seen = std::sync::Arc::new(AtomicBool::new(false));
    let caught = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, seen);
    caught.map(|_| ()).map_err(|e| Failure::new(format_args!("cannot catch SIGXFSZ: {e}")))
}

/// Ends the program at once. A graphics driver may be at work: what its libraries do at an ordered exit takes away memory that its threads
/// still use.
fn end() -> ! {
    #[cfg(unix)]
    signal_hook::low_level::exit(130);
    #[cfg(not(unix))]
    std::process::exit(130)
}

/// From now on Ctrl-C and SIGTERM remove unfinished files and end the program with code 130.
pub(crate) fn catch_interrupts() -> Result<(), Failure> {
    #[cfg(unix)]
    survive_file_limits()?;
    ctrlc::set_handler(|| {
        if GRACEFUL.load(Ordering::SeqCst) && !STOP.is_cancelled() {
            STOP.cancel();
            if !HASTY.load(Ordering::SeqCst) {
                return;
            }
            std::thread::sleep(PATIENCE);
            if !GRACEFUL.load(Ordering::SeqCst) {
                return;
            }
        }
        ENDING.store(true, Ordering::SeqCst);
        remove_unfinished();
        note(interrupted());
        end();
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

/// The same for work that writes nothing worth waiting for: it may be ended on its way.
pub(crate) fn cancellable<T>(work: impl FnOnce() -> Result<T, Failure>) -> Result<T, Failure> {
    HASTY.store(true, Ordering::SeqCst);
    stoppable(work).map_err(|failure| match STOP.is_cancelled() {
        true => Failure::interrupted(""),
        false => failure,
    })
}

/// The first error on standard output.
static UNSAID: Mutex<Option<io::Error>> = Mutex::new(None);

fn heard(result: io::Result<()>) {
    if let Err(error) = result {
        UNSAID.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
    }
}

/// Prints a line of the result. [`all_said`] reports whether it arrived.
pub(crate) fn say(text: impl Display) {
    heard(writeln!(io::stdout(), "{text}"));
}

/// Whether standard output took all lines. A reader that has gone away, as `head` does, is no error.
pub(crate) fn all_said() -> Result<(), Failure> {
    heard(io::stdout().flush());
    match UNSAID.lock().unwrap_or_else(PoisonError::into_inner).take() {
        Some(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::new(format_args!("standard output: {error}")))
        }
        _ => Ok(()),
    }
}

/// A number of things, in words.
pub(crate) fn counted(number: usize, thing: &str) -> String {
    format!("{number} {thing}{}", if number == 1 { "" } else { "s" })
}

/// A text of a file as the console shows it: on one line, and without commands to the terminal.
pub(crate) fn plain(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

/// Names in quotation marks without adjacent repetitions; of more than four the first three and the number of the rest.
pub(crate) fn listed(names: &[impl AsRef<str>]) -> String {
    let mut shown: Vec<String> = names.iter().map(|name| plain(name.as_ref())).collect();
    shown.dedup();
    if shown.len() > 4 {
        shown.truncate(3);
    }
    let quoted = format!("\"{}\"", shown.join("\", \""));
    match names.len() - shown.len() {
        0 => quoted,
        more => format!("{quoted} and {more} more"),
    }
}

/// Prints a line that is not part of the result.
pub(crate) fn note(text: impl Display) {
    let _ = writeln!(std::io::stderr(), "{text}");
}

/// A progress bar; invisible when `quiet` or without a terminal.
pub(crate) fn progress(what: &str, length: u64, quiet: bool) -> ProgressBar {
    let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
    let bar = ProgressBar::with_draw_target(Some(length), target);
    if let Ok(style) = ProgressStyle::with_template("{msg:12} [{bar:40}] {percent:>3} % {eta:>6} left") {
        bar.set_style(style.progress_chars("=> "));
    }
    bar.set_message(what.to_owned());
    bar
}

/// From one line of a fit to the next, where no bar is seen.
const LINES: Duration = Duration::from_secs(5);

/// A fit of seconds: a bar at a terminal, else a line every few seconds and one at its end, so that a log shows the slow fits.
pub(crate) struct Fit {
    what: String,
    bar: ProgressBar,
    quiet: bool,
    start: Instant,
    told: Instant,
}

impl Fit {
    pub(crate) fn new(what: &str, quiet: bool) -> Self {
        let now = Instant::now();
        Self { what: what.to_owned(), bar: progress("spheres", 1000, quiet), quiet, start: now, told: now }
    }

    /// The finished fraction, in [0, 1].
    pub(crate) fn report(&mut self, done: f32) {
        self.bar.set_position((done * 1000.0) as u64);
        if self.bar.is_hidden() && !self.quiet && self.told.elapsed() >= LINES {
            self.told = Instant::now();
            let (what, percent) = (&self.what, 100.0 * done);
            let left = self.start.elapsed().as_secs_f32() * (1.0 - done) / done.max(1e-3);
            note(format_args!("lobes: {what}: {percent:.0} % fitted, about {left:.0} s left"));
        }
    }

    pub(crate) fn end(self) {
        let unseen = self.bar.is_hidden() && !self.quiet;
        self.bar.finish_and_clear();
        if unseen {
            note(format_args!("lobes: {} fitted in {:.1} s", self.what, self.start.elapsed().as_secs_f64()));
        }
    }
}

/// Uses `count` threads from now on.
pub(crate) fn set_threads(count: Option<u32>) -> Result<(), Failure> {
    match count {
        None => Ok(()),
        Some(n) => rayon::ThreadPoolBuilder::new().num_threads(n as usize).build_global().map_err(Failure::from),
    }
}

#[cfg(test)]
mod tests {
    use super::listed;

    #[test]
    fn names_are_listed_once() {
        assert_eq!(listed(&["a", "b", "c", "d"]), "\"a\", \"b\", \"c\", \"d\"");
        assert_eq!(listed(&["a", "b", "c", "d", "e"]), "\"a\", \"b\", \"c\" and 2 more");
        assert_eq!(listed(&["a", "a", "a"]), "\"a\" and 2 more");
        assert_eq!(listed(&["a\nb\u{1b}[31mc"]), "\"a b [31mc\"");
    }
}
