//! Long work: without the GIL, on a thread of its own, while the calling thread hears Ctrl-C and reports progress.

use crate::errors::{LobesWarning, RenderError};
use core::ops::ControlFlow;
use cosine_lobes::renderer::Event;
use cosine_lobes::scene::Cancel;
use cosine_lobes::visibility_shadowmap::MapFineness;
use pyo3::prelude::*;
use std::sync::OnceLock;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::Duration;

/// Between two looks for signals.
const PAUSE: Duration = Duration::from_millis(5);

/// News from the work.
enum News {
    /// A stage, and the part of it that is done, in [0, 1].
    Progress(&'static str, f32),
    Warning(String),
}

/// The way back to the calling thread.
#[derive(Clone)]
pub(crate) struct Reporter(Sender<News>);

impl Reporter {
    pub(crate) fn progress(&self, stage: &'static str, done: f32) {
        // Fails where the caller has an error already, and listens no more.
        let _ = self.0.send(News::Progress(stage, done));
    }

    /// Passes on the event of a renderer.
    pub(crate) fn hear(&self, event: Event<'_>) -> ControlFlow<()> {
        let warn = |text: String| drop(self.0.send(News::Warning(text)));
        match event {
            Event::Fitting { done, .. } => self.progress("spheres", done),
            Event::Fitted { .. } => self.progress("spheres", 1.0),
            Event::Tables { done } => self.progress("tables", done),
            Event::Pixels { done, of } => self.progress("shading", done as f32 / of.max(1) as f32),
            Event::Damaged { path } => warn(format!("{}: damaged; made anew", path.display())),
            Event::PoorFit { object, error } => warn(format!(
                "object \"{object}\": its spheres miss {:.0} % of its silhouette: silhouettes are exact, or more spheres",
                100.0 * error
            )),
            Event::Map { light, advice } if advice.fineness != MapFineness::Fine => {
                warn(format!("light {light}: {advice}"));
            }
            Event::MapsReduced(reduced) => {
                warn(format!("there is room for shadow maps of {}² texels only", reduced.drawn));
            }
            Event::Chosen { accuracy, milliseconds, is_within: false } => warn(format!(
                "time budget: no setting is faster than tolerance {} %, about {milliseconds:.1} ms a frame",
                100.0 * accuracy.tolerance
            )),
            _ => {}
        }
        ControlFlow::Continue(())
    }
}

/// The process that has worked first.
static PROCESS: OnceLock<u32> = OnceLock::new();

/// Refuses to wait for threads that a fork has left behind.
pub(crate) fn check_process() -> PyResult<()> {
    let this = std::process::id();
    if PROCESS.get().is_none_or(|first| *first == this) {
        return Ok(());
    }
    let fault =
        "this process was forked from one that has rendered, and its threads were not: start processes by \"spawn\"";
    Err(RenderError::new_err(fault))
}

/// Does something with neither the GIL nor the calling thread, which meanwhile raises what signals raise (Ctrl-C), calls
/// `progress(stage, done)` and issues warnings. An exception of any of these stops the work, and is raised once it has stopped.
pub(crate) fn run<T: Send>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Cancel, &Reporter) -> T + Send,
) -> PyResult<T> {
    PROCESS.get_or_init(std::process::id);
    check_process()?;
    let cancel = Cancel::new();
    let (sender, receiver) = channel();
    thread::scope(|scope| {
        let stop = &cancel;
        let worker = scope.spawn(move || work(stop, &Reporter(sender)));
        let heard = listen(py, receiver, progress);
        if heard.is_err() {
            cancel.cancel();
        }
        let result = py.detach(|| worker.join());
        heard?;
        result.map_or_else(|panic| std::panic::resume_unwind(panic), Ok)
    })
}

/// Listens until the work is done, or an exception is raised.
fn listen(py: Python<'_>, mut news: Receiver<News>, progress: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
    loop {
        let next;
        (news, next) = py.detach(move || {
            let next = news.recv_timeout(PAUSE);
            (news, next)
        });
        match next {
            Ok(News::Progress(stage, done)) => {
                if let Some(progress) = progress {
                    progress.call1((stage, done))?;
                }
                py.check_signals()?;
            }
            Ok(News::Warning(text)) => warn(py, &text)?,
            Err(RecvTimeoutError::Timeout) => py.check_signals()?,
            Err(RecvTimeoutError::Disconnected) => return Ok(()),
        }
    }
}

/// Issues a warning to the caller's line.
pub(crate) fn warn(py: Python<'_>, text: &str) -> PyResult<()> {
    let text = std::ffi::CString::new(text.replace('\0', " "))?;
    PyErr::warn(py, &py.get_type::<LobesWarning>(), &text, 1)
}
