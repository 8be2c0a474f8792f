use crate::host;
use core::ops::ControlFlow;
use core::sync::atomic::{AtomicBool, Ordering};
use renderer::Event;

/// Reports to JavaScript, where it listens; it may stop the work.
#[derive(Debug)]
pub(crate) struct Progress {
    listens: bool,
    is_over: AtomicBool,
}

impl Progress {
    pub(crate) const fn new(listens: bool) -> Self {
        Self { listens, is_over: AtomicBool::new(false) }
    }

    /// Whether the work is stopped.
    pub(crate) const fn is_over(&self) -> &AtomicBool {
        &self.is_over
    }

    /// Reports the part of a stage that is done, in [0, 1]; nothing more once the work is stopped.
    pub(crate) fn report(&self, stage: &str, done: f64) -> ControlFlow<()> {
        let is_over = self.is_over.load(Ordering::Relaxed) || self.listens && !host::progress(stage, done);
        self.is_over.store(is_over, Ordering::Relaxed);
        if is_over { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// Reports an event of a renderer.
    pub(crate) fn hear(&self, event: Event<'_>) -> ControlFlow<()> {
        match event {
            Event::Fitting { done, .. } => self.report("spheres", f64::from(done)),
            Event::Fitted { .. } => self.report("spheres", 1.0),
            Event::Tables { done } => self.report("tables", f64::from(done)),
            Event::Pixels { done, of } => self.report("shading", done as f64 / of.max(1) as f64),
            _ => ControlFlow::Continue(()),
        }
    }
}
