use crate::crossed::crossed;
use crate::worker::{Command, Worker};
use crate::{Driver, Edit, Picture, Probe, Truth};
use core::fmt;
use renderer::{LayerSet, RenderError, Renderer};
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
/// While one of several lights moves on the CPU, the picture without it is kept where that saves time, and a [sum](Picture::is_sum) is
/// seen: a room under a sky takes the time of the lamp that is dragged in it. The kept picture costs two of this light once, a quarter of a
/// second at most.
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
    listener: Mutex<Listener>,
}

/// Called after each news.
#[derive(Default)]
struct Listener(Option<Box<dyn Fn() + Send>>);

impl fmt::Debug for Listener {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Listener").field(&self.0.is_some()).finish()
    }
}

#[derive(Debug, Default)]
struct State {
    picture: Arc<Picture>,
    truth: Arc<Truth>,
    errors: Vec<RenderError>,
    running: Option<(Control, Cancel)>,
    is_over: bool,
    /// Commands that were sent.
    sent: u64,
    /// Changes that were made.
    edits: u64,
    /// How many were made when a picture failed.
    failed: Option<u64>,
    /// Whether the thread has ended, by a panic or with the session.
    has_ended: bool,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The token of the work that begins after so many commands were taken. A refinement ends at once where more are there: they came
    /// when nothing could be interrupted.
    pub(crate) fn begin(&self, control: Control, taken: u64) -> Cancel {
        let mut state = self.lock();
        let cancel = Cancel::new();
        if state.is_over || control == Control::Refining && state.sent > taken {
            cancel.cancel();
        }
        state.running = Some((control, cancel.clone()));
        cancel
    }

    pub(crate) fn is_over(&self) -> bool {
        self.lock().is_over
    }

    pub(crate) fn picture(&self) -> Arc<Picture> {
        Arc::clone(&self.lock().picture)
    }

    pub(crate) fn show(&self, picture: Picture) {
        self.lock().picture = Arc::new(picture);
        self.is_newer.notify_all();
        self.tell();
    }

    pub(crate) fn show_truth(&self, truth: Truth) {
        self.lock().truth = Arc::new(truth);
        self.tell();
    }

    /// Tells that there is something new.
    pub(crate) fn tell(&self) {
        if let Some(listener) = &self.listener.lock().unwrap_or_else(PoisonError::into_inner).0 {
            listener();
        }
    }

    /// Keeps an error; of a picture with the number of changes so far.
    pub(crate) fn fail(&self, error: RenderError, edits: Option<u64>) {
        let mut state = self.lock();
        state.errors.push(error);
        state.failed = edits.or(state.failed);
        drop(state);
        self.is_newer.notify_all();
        self.tell();
    }
}

/// Wakes those who wait for a picture once the thread has ended.
struct Ending(Arc<Shared>);

impl Drop for Ending {
    fn drop(&mut self) {
        self.0.lock().has_ended = true;
        self.0.is_newer.notify_all();
    }
}

impl Session {
    /// Starts with a renderer, and at once with its first picture.
    #[must_use]
    pub fn new(renderer: Renderer) -> Self {
        let (mut session, worker) = Self::apart(renderer);
        let ending = Ending(Arc::clone(&session.shared));
        session.worker = Some(thread::spawn(move || {
            let _ending = ending;
            worker.run();
        }));
        session
    }

    /// A session without a thread, for targets that have none: nothing is done until the [`Driver`] takes a step.
    #[must_use]
    pub fn driven(renderer: Renderer) -> (Self, Driver) {
        let (session, worker) = Self::apart(renderer);
        (session, Driver::new(worker))
    }

    fn apart(renderer: Renderer) -> (Self, Worker) {
        let (commands, received) = mpsc::channel();
        let shared = Arc::new(Shared::default());
        let worker = Worker::new(renderer, received, Arc::clone(&shared));
        (Self { commands, shared, worker: None }, worker)
    }

    /// Seconds in which the first picture after an edit is to be there: a thirtieth, unless set.
    pub fn set_budget(&self, seconds: f64) {
        self.send(Command::Budget(seconds));
    }

    /// Calls `listener`, on the session's thread, after each new picture, growth of the reference, error and answer. It must not wait for
    /// this session.
    pub fn set_listener(&self, listener: impl Fn() + Send + 'static) {
        self.shared.listener.lock().unwrap_or_else(PoisonError::into_inner).0 = Some(Box::new(listener));
    }

    /// The layers that pictures come with from now on. No step of the history: settings that are taken back keep these.
    pub fn set_layers(&self, layers: LayerSet) {
        self.send(Command::Layers(layers));
        self.interrupt();
    }

    /// Whether pictures of a GPU stay there from now on, as [`Picture::on_gpu`]: for a window that draws on the same device
    /// ([`Renderer::use_gpu`]). They come to the CPU only where [`Picture::pixels`] is called. Pictures of the CPU are as before.
    #[cfg(feature = "gpu")]
    pub fn set_on_gpu(&self, is_on_gpu: bool) {
        self.send(Command::OnGpu(is_on_gpu));
        self.interrupt();
    }

    /// Lets a reference of the picture grow while there is nothing else to do, up to so many samples of each light; 0: none.
    pub fn set_reference(&self, samples: u32) {
        self.send(Command::Reference(samples));
        self.interrupt();
    }

    /// The reference as far as it has come: one without pixels before the first samples, and an older one until edits are followed.
    #[must_use]
    pub fn reference(&self) -> Arc<Truth> {
        Arc::clone(&self.shared.lock().truth)
    }

    /// The number of changes so far, with which the picture that shows them all comes as [`Picture::edits`].
    #[must_use]
    pub fn edits(&self) -> u64 {
        self.shared.lock().edits
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
        self.shared.picture()
    }

    /// Waits for the whole picture with all changes so far; the newest one where an error keeps that from coming, or the thread has ended.
    #[must_use]
    pub fn finished(&self) -> Arc<Picture> {
        let mut state = self.shared.lock();
        let edits = state.edits;
        while state.picture.edits < edits || !state.picture.is_whole() {
            let is_failed = state.failed.is_some_and(|failed| failed >= edits);
            if is_failed || state.has_ended || self.worker.is_none() {
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

    /// The [exposure](Renderer::exposure) that shows the scene well.
    pub fn meter(&self) -> Receiver<f32> {
        self.ask(false, Renderer::exposure)
    }

    /// For each pixel of the whole picture, row by row, the number of surfaces that its rays meet where an outline or a crease crosses it:
    /// there more rays are taken. 0 where none was found.
    pub fn crossed(&self) -> Receiver<Vec<u32>> {
        self.ask(false, crossed)
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
        self.shared.lock().sent += 1;
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
