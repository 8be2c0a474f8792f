use crate::worker::{Command, Worker};
use crate::{Edit, Picture, Probe};
use renderer::{RenderError, Renderer};
use scene::{Cancel, Stopwatch};
use std::sync::mpsc::{self, Receiver, Sender};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};

/// A renderer on a thread of its own. No call waits for a picture but [`finished`](Self::finished).
///
/// # Pictures
/// The first picture after an edit comes within the [budget](Self::set_budget): in fewer pixels where the whole one takes longer. Edits do not
/// interrupt it, so that something is seen while they go on. The whole picture follows; an edit stops it within 5 ms.
///
/// # Cost
/// A thread; pictures are shared, not copied. A dropped session stops its work.
#[derive(Debug)]
pub struct Session {
    commands: Sender<Command>,
    shared: Arc<Shared>,
    worker: Option<JoinHandle<()>>,
}

/// Whether edits may interrupt the work that runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Control {
    /// The first picture after an edit: nothing may.
    First,
    /// Its refinement.
    Refining,
}

/// The state that both threads have.
#[derive(Debug, Default)]
pub(crate) struct Shared {
    state: Mutex<State>,
    is_newer: Condvar,
}

#[derive(Debug, Default)]
struct State {
    picture: Arc<Picture>,
    errors: Vec<RenderError>,
    running: Option<(Control, Cancel)>,
    is_over: bool,
    /// Changes that were made.
    edits: u64,
    /// How many were made when a picture failed.
    failed: Option<u64>,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The token of the work that begins.
    pub(crate) fn begin(&self, control: Control) -> Cancel {
        let mut state = self.lock();
        let cancel = Cancel::new();
        if state.is_over {
            cancel.cancel();
        }
        state.running = Some((control, cancel.clone()));
        cancel
    }

    pub(crate) fn is_over(&self) -> bool {
        self.lock().is_over
    }

    pub(crate) fn show(&self, picture: Picture) {
        self.lock().picture = Arc::new(picture);
        self.is_newer.notify_all();
    }

    /// Keeps an error; of a picture with the number of changes so far.
    pub(crate) fn fail(&self, error: RenderError, edits: Option<u64>) {
        let mut state = self.lock();
        state.errors.push(error);
        state.failed = edits.or(state.failed);
        drop(state);
        self.is_newer.notify_all();
    }
}

impl Session {
    /// Starts with a renderer, and at once with its first picture.
    #[must_use]
    pub fn new(renderer: Renderer) -> Self {
        let (commands, received) = mpsc::channel();
        let shared = Arc::new(Shared::default());
        let worker = Worker::new(renderer, received, Arc::clone(&shared));
        let worker = Some(thread::spawn(move || worker.run()));
        Self { commands, shared, worker }
    }

    /// Seconds in which the first picture after an edit is to be there: a thirtieth, unless set.
    pub fn set_budget(&self, seconds: f64) {
        self.send(Command::Budget(seconds));
    }

    /// Makes a change. A refused one is among the [errors](Self::take_errors), and changes nothing.
    pub fn edit(&self, edit: Edit) {
        self.change_by(Command::Edit(edit, Stopwatch::start()));
    }

    /// Ends a step of the history: a drag is over. Edits of the same thing that follow each other are one step until then.
    pub fn close_step(&self) {
        self.send(Command::CloseStep);
    }

    /// Takes the latest step back.
    pub fn undo(&self) {
        self.change_by(Command::Undo(Stopwatch::start()));
    }

    /// Makes the step again that was taken back last.
    pub fn redo(&self) {
        self.change_by(Command::Redo(Stopwatch::start()));
    }

    /// The newest picture; one without pixels before the first.
    #[must_use]
    pub fn picture(&self) -> Arc<Picture> {
        Arc::clone(&self.shared.lock().picture)
    }

    /// Waits for the whole picture with all changes so far; the newest one where an error keeps that from coming.
    #[must_use]
    pub fn finished(&self) -> Arc<Picture> {
        let mut state = self.shared.lock();
        let edits = state.edits;
        while state.picture.edits < edits || state.picture.divisor != 1 {
            let is_failed = state.failed.is_some_and(|failed| failed >= edits);
            if is_failed || self.worker.as_ref().is_none_or(JoinHandle::is_finished) {
                break;
            }
            state = self.shared.is_newer.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        Arc::clone(&state.picture)
    }

    /// The errors since the last call: edits that were refused, pictures that could not be made.
    pub fn take_errors(&self) -> Vec<RenderError> {
        core::mem::take(&mut self.shared.lock().errors)
    }

    /// Asks the renderer something, between two pictures: the answer arrives where it is waited for.
    pub fn query<R: Send + 'static>(&self, question: impl FnOnce(&Renderer) -> R + Send + 'static) -> Receiver<R> {
        self.ask(false, |renderer| question(renderer))
    }

    /// Changes the renderer in any way; a picture follows. The history is forgotten, since handles may be others.
    pub fn change<R: Send + 'static>(&self, change: impl FnOnce(&mut Renderer) -> R + Send + 'static) -> Receiver<R> {
        self.ask(true, change)
    }

    /// Takes a pixel apart, beside a reference of so many samples; `None` where it shows no surface.
    pub fn probe(&self, x: u32, y: u32, samples: u32) -> Receiver<Result<Option<Probe>, RenderError>> {
        self.ask(false, move |renderer| Probe::new(renderer, x, y, samples))
    }

    fn ask<R: Send + 'static>(
        &self,
        is_edit: bool,
        question: impl FnOnce(&mut Renderer) -> R + Send + 'static,
    ) -> Receiver<R> {
        let (answer, received) = mpsc::channel();
        // Who no longer waits needs no answer.
        let question = move |renderer: &mut Renderer| drop(answer.send(question(renderer)));
        match is_edit {
            true => self.change_by(Command::Query(Box::new(question), true)),
            false => {
                self.send(Command::Query(Box::new(question), false));
                self.interrupt();
            }
        }
        received
    }

    fn change_by(&self, command: Command) {
        self.shared.lock().edits += 1;
        self.send(command);
        self.interrupt();
    }

    fn send(&self, command: Command) {
        // The thread ends with the session alone.
        let _ = self.commands.send(command);
    }

    /// Stops the refinement that runs: the command is there already.
    fn interrupt(&self) {
        if let Some((Control::Refining, cancel)) = &self.shared.lock().running {
            cancel.cancel();
        }
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        {
            let mut state = self.shared.lock();
            state.is_over = true;
            if let Some((_, cancel)) = &state.running {
                cancel.cancel();
            }
        }
        self.send(Command::Quit);
        if let Some(worker) = self.worker.take() {
            let _ = worker.join();
        }
    }
}
