//! References that are kept on disk while they are sampled.

use crate::console::{self, STOP, note};
use crate::failure::Failure;
use cosine_lobes::reference::{CheckpointError, Reference};
use cosine_lobes::{ImageFileError, Output};
use std::fs::File;
use std::io::BufReader;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Interval of checkpoints, if writing one takes a twentieth of the time at most.
const EVERY: Duration = Duration::from_secs(4);
const SHARE: u32 = 20;

/// Resumes from the checkpoint and returns true, if it belongs to this job. A damaged one, or one of another picture, gives a
/// note and is replaced later.
///
/// # Errors
/// When a checkpoint exists and cannot be read.
pub(crate) fn resume(reference: &mut Reference<'_>, path: &Path, quiet: bool) -> Result<bool, Failure> {
    let Ok(file) = File::open(path) else { return Ok(false) };
    let fault = match reference.restore(BufReader::new(file)) {
        Ok(()) => return Ok(true),
        Err(CheckpointError::Io(error)) => return Err(Failure::new(format_args!("{}: {error}", path.display()))),
        Err(CheckpointError::OtherJob) => "belongs to another picture and will be replaced".to_owned(),
        Err(error) => format!("{error}; made anew"),
    };
    if !quiet {
        note(format_args!("lobes: warning: {}: {fault}", path.display()));
    }
    Ok(false)
}

pub(crate) fn save(reference: &Reference<'_>, path: &Path) -> Result<(), Failure> {
    let output = Output::create(path)?;
    let failed = |source| ImageFileError::Io { path: path.to_owned(), source };
    Ok(output.finish(|file| reference.save(file).map_err(failed))?)
}

/// Samples to the end, with checkpoints on the way; returns early when Ctrl-C comes.
pub(crate) fn advance(
    reference: &mut Reference<'_>,
    samples: u32,
    path: &Path,
    what: &'static str,
    quiet: bool,
) -> Result<(), Failure> {
    let bar = console::progress(what, reference.work(samples), quiet);
    let mut every = EVERY;
    while reference.samples() < samples && !STOP.is_cancelled() {
        let (start, pause) = (Instant::now(), AtomicBool::new(false));
        reference.advance(samples, &pause, &|done| {
            bar.inc(done);
            if start.elapsed() > every || STOP.is_cancelled() {
                pause.store(true, Ordering::Relaxed);
            }
        });
        if reference.samples() < samples && !STOP.is_cancelled() {
            let start = Instant::now();
            save(reference, path)?;
            every = EVERY.max(SHARE * start.elapsed());
        }
    }
    bar.finish_and_clear();
    Ok(())
}
