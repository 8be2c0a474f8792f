use crate::history::History;
use crate::picture::Made;
use crate::rest::Rest;
use crate::session::{Control, Shared};
use crate::truth::Growth;
use crate::{Edit, Picture, Snapshot};
use core::ops::ControlFlow;
use renderer::{Event, Image, LayerSet, LightHandle, RenderError, Renderer, Settings, Stale};
#[cfg(feature = "gpu")]
use renderer::{GpuError, GpuImage};
use scene::{Bounds, Stopwatch};
use std::sync::Arc;
use std::sync::mpsc::Receiver;

/// A question to the renderer.
pub(crate) type Question = Box<dyn FnOnce(&mut Renderer) + Send>;

pub(crate) enum Command {
    /// With the moment at which it was made.
    Edit(Edit, Stopwatch),
    CloseStep,
    Undo(Stopwatch),
    Redo(Stopwatch),
    /// Whether it may change the scene.
    Query(Question, bool),
    Budget(f64),
    Layers(LayerSet),
    /// Whether pictures of a GPU stay there.
    #[cfg(feature = "gpu")]
    OnGpu(bool),
    /// Samples of the reference.
    Reference(u32),
    Quit,
}

impl Command {
    /// Whether it may change what there is to see.
    const fn is_change(&self) -> bool {
        matches!(self, Self::Edit(..) | Self::Undo(_) | Self::Redo(_) | Self::Query(_, true))
    }
}

/// The side of a session that works: its thread's, or its driver's.
pub(crate) struct Worker {
    renderer: Renderer,
    commands: Receiver<Command>,
    shared: Arc<Shared>,
    history: History,
    /// Commands that were taken.
    taken: u64,
    edits: u64,
    /// The first edit that no picture shows.
    waiting: Option<Stopwatch>,
    /// Seconds in which a picture is to be there after an edit.
    budget: f64,
    /// Seconds of the last whole picture: with visible points that were there, and with new ones.
    whole: [Option<f64>; 2],
    /// Boxes around the objects; none where they may have moved.
    bounds: Option<Vec<Bounds>>,
    /// The scene of the last picture, with the number of changes that it shows.
    snapshot: Option<(u64, Arc<Snapshot>)>,
    /// Samples that the reference is to have.
    samples: u32,
    /// Whether pictures of a GPU stay there.
    #[cfg(feature = "gpu")]
    is_on_gpu: bool,
    growth: Option<Growth>,
    /// Whether pictures without a light that moves are kept.
    keeps_rest: bool,
    /// The last one.
    rest: Option<Rest>,
    /// The light for which that is not worth it.
    declined: Option<LightHandle>,
    /// The last change that the reference shows differently.
    seen: u64,
}

/// The coarsest picture has a pixel for so many by so many.
const COARSEST: u32 = 16;
/// The one before it may take this multiple of the budget: it shows much more.
const LATE: f64 = 2.0;

impl Worker {
    pub(crate) fn new(renderer: Renderer, commands: Receiver<Command>, shared: Arc<Shared>) -> Self {
        Self {
            renderer,
            commands,
            shared,
            history: History::default(),
            taken: 0,
            edits: 0,
            waiting: None,
            budget: BUDGET,
            whole: [None; 2],
            bounds: None,
            snapshot: None,
            samples: 0,
            #[cfg(feature = "gpu")]
            is_on_gpu: false,
            growth: None,
            keeps_rest: false,
            rest: None,
            declined: None,
            seen: 0,
        }
    }

    pub(crate) fn run(mut self) {
        self.keeps_rest = true;
        let mut is_pending = true;
        loop {
            let first = match is_pending || self.wants_growth() {
                true => None,
                false => match self.commands.recv() {
                    Ok(command) => Some(command),
                    Err(_) => return,
                },
            };
            // From here on the first picture is not interrupted by edits: they would leave nothing to look at.
            let cancel = self.shared.begin(Control::First, self.taken);
            self.renderer.set_cancel(cancel);
            match self.take_all(first) {
                Some(is_new) => is_pending |= is_new,
                None => return,
            }
            if is_pending {
                is_pending = !self.refine();
            } else if self.wants_growth() {
                self.grow();
            }
            if self.shared.is_over() {
                return;
            }
        }
    }

    /// Does all that is requested so far, after `first`; whether there is something new to see. None where the session is over.
    pub(crate) fn take_all(&mut self, first: Option<Command>) -> Option<bool> {
        let mut is_new = false;
        let mut next = first.or_else(|| self.commands.try_recv().ok());
        while let Some(command) = next {
            if matches!(command, Command::Quit) {
                return None;
            }
            is_new |= self.take(command);
            next = self.commands.try_recv().ok();
        }
        Some(is_new)
    }

    /// Does what is requested; whether there is something new to see.
    fn take(&mut self, command: Command) -> bool {
        self.taken += 1;
        let shown = self.edits;
        let light = match &command {
            Command::Edit(Edit::Light(light, _), _) if self.keeps_rest => Some(*light),
            _ => None,
        };
        if let Some(light) = light {
            self.keep_rest(light);
        }
        self.edits += u64::from(command.is_change());
        if command.is_change()
            && !matches!(&command, Command::Edit(Edit::Settings(settings), _) if self.has_same_rays(settings))
        {
            self.seen = self.edits;
        }
        let (done, since) = self.follow(command);
        if self.renderer.stale().has(Stale::HIERARCHY) {
            self.bounds = None;
        }
        if light.is_none() && self.edits > shown {
            self.declined = None;
        }
        // Nothing else has changed.
        if let Some(rest) = self.rest.as_mut().filter(|rest| done.is_ok() && light == Some(rest.light)) {
            rest.edits += u64::from(rest.edits == shown);
        }
        match done {
            // A picture follows all the same: who counts changes waits for it.
            Err(error) => {
                self.shared.fail(error, None);
                true
            }
            Ok(is_new) => {
                if is_new && self.waiting.is_none() {
                    self.waiting = since;
                }
                is_new || self.edits > shown
            }
        }
    }

    /// Does what is requested: whether there is something new to see, and when a change was made.
    fn follow(&mut self, command: Command) -> (Result<bool, RenderError>, Option<Stopwatch>) {
        match command {
            Command::Edit(edit, since) => (self.history.apply(edit, &mut self.renderer).map(|()| true), Some(since)),
            Command::Undo(since) => (self.history.undo(&mut self.renderer), Some(since)),
            Command::Redo(since) => (self.history.redo(&mut self.renderer), Some(since)),
            Command::CloseStep => {
                self.history.close();
                (Ok(false), None)
            }
            Command::Budget(seconds) => {
                self.budget = seconds;
                (Ok(false), None)
            }
            Command::Layers(layers) => (self.set_layers(layers), None),
            #[cfg(feature = "gpu")]
            Command::OnGpu(is_on_gpu) => {
                let is_new = core::mem::replace(&mut self.is_on_gpu, is_on_gpu) != is_on_gpu;
                (Ok(is_new && self.renderer.backend().gpu().is_some()), None)
            }
            Command::Reference(samples) => {
                self.samples = samples;
                (Ok(false), None)
            }
            Command::Query(question, is_edit) => {
                question(&mut self.renderer);
                if is_edit {
                    self.history.clear();
                    self.bounds = None;
                }
                self.shared.tell();
                (Ok(is_edit), None)
            }
            Command::Quit => (Ok(false), None),
        }
    }

    /// Keeps the picture without a light that is about to change, if that is worth it.
    fn keep_rest(&mut self, light: LightHandle) {
        if self.rest.as_ref().is_some_and(|rest| rest.light == light && rest.edits == self.edits) {
            return;
        }
        self.rest = None;
        let whole = self.shared.picture();
        if self.declined != Some(light)
            && whole.is_whole()
            && whole.edits == self.edits
            && self.renderer.settings().layers == LayerSet::NONE
        {
            let watch = Stopwatch::start();
            // Without it, or where that fails, pictures are made as ever.
            let rest = Rest::new(&mut self.renderer, light, &whole, self.budget, || watch.seconds());
            self.rest = rest.ok().flatten();
            self.declined = if self.rest.is_none() { Some(light) } else { None };
        }
    }

    /// Shows the kept picture with the light that moves; none where another one is to be made.
    fn show_sum(&mut self) -> Option<Shown> {
        let is_own = |rest: &Rest| rest.edits == self.edits && self.renderer.settings().layers == LayerSet::NONE;
        let rest = self.rest.take_if(|rest| is_own(rest))?;
        let watch = Stopwatch::start();
        let part = self.renderer.render_light(rest.divisor, rest.light, &mut |_: Event<'_>| ControlFlow::Continue(()));
        let shown = match part {
            Ok(mut part) => {
                rest.with(&mut part.radiance);
                self.put(part.into(), rest.divisor, true, watch.seconds());
                Some(Shown::Yes)
            }
            Err(RenderError::Cancelled) => Some(Shown::Interrupted),
            // Another picture may be possible, or says why not.
            Err(_) => return None,
        };
        self.rest = Some(rest);
        shown
    }

    /// Pictures from the coarsest that is needed to the whole one; whether that is there now.
    fn refine(&mut self) -> bool {
        let is_new = self.has_new_points();
        let sum = if is_new == 0 { self.show_sum() } else { None };
        let divisor = if sum.is_some() { 1 } else { self.divisor(is_new) };
        if sum.is_some() || divisor > 1 {
            match sum.unwrap_or_else(|| self.show(divisor, is_new)) {
                Shown::Yes => {}
                Shown::Failed => return true,
                Shown::Interrupted => return false,
            }
            let cancel = self.shared.begin(Control::Refining, self.taken);
            self.renderer.set_cancel(cancel);
        }
        self.show(1, is_new) != Shown::Interrupted
    }

    /// Whether the next picture finds its visible points anew: the place of its time in `whole`.
    pub(crate) fn has_new_points(&self) -> usize {
        usize::from(self.renderer.stale().has(Stale::POINTS))
    }

    /// The divisor of the first picture.
    pub(crate) fn divisor(&self, is_new: usize) -> u32 {
        match self.seconds_of_whole(is_new) {
            Some(seconds) => divisor_for(seconds, self.budget),
            None => COARSEST / 4,
        }
    }

    /// Seconds of the last whole picture, if possible of one alike.
    pub(crate) fn seconds_of_whole(&self, is_new: usize) -> Option<f64> {
        self.whole[is_new].or(self.whole[1 - is_new])
    }

    pub(crate) const fn budget(&self) -> f64 {
        self.budget
    }

    pub(crate) const fn renderer(&mut self) -> &mut Renderer {
        &mut self.renderer
    }

    /// Makes a picture and shows it.
    fn show(&mut self, divisor: u32, is_new: usize) -> Shown {
        let watch = Stopwatch::start();
        let made = match self.make(divisor) {
            Ok(made) => made,
            Err(RenderError::Cancelled) => return Shown::Interrupted,
            Err(error) => {
                self.fail(error);
                return Shown::Failed;
            }
        };
        self.publish(made, divisor, is_new, watch.seconds());
        Shown::Yes
    }

    /// Makes a picture, where it is to stay.
    fn make(&mut self, divisor: u32) -> Result<Made, RenderError> {
        let go_on = &mut |_: Event<'_>| ControlFlow::Continue(());
        #[cfg(feature = "gpu")]
        if self.is_on_gpu && self.renderer.backend().gpu().is_some() {
            match self.renderer.render_on_gpu(divisor, go_on) {
                // Too many points for a buffer: they are shaded in parts.
                Err(RenderError::Gpu(GpuError::Limits { .. })) => {}
                made => {
                    let GpuImage { picture, layers, stats } = made?;
                    let size = picture.size().map(|side| side as usize);
                    let image = Image { size, radiance: Vec::new(), layers, stats };
                    return Ok(Made { image, on_gpu: Some(Arc::new(picture)) });
                }
            }
        }
        self.renderer.render_reduced(divisor, go_on).map(Made::from)
    }

    /// Says why there is no picture.
    pub(crate) fn fail(&self, error: RenderError) {
        self.shared.fail(error, Some(self.edits));
    }

    /// Shows a picture that took so many seconds.
    pub(crate) fn publish(&mut self, made: impl Into<Made>, divisor: u32, is_new: usize, seconds: f64) {
        if divisor == 1 {
            self.whole[is_new] = Some(seconds);
        }
        self.put(made.into(), divisor, false, seconds);
    }

    /// Puts a picture where it is seen.
    fn put(&mut self, made: Made, divisor: u32, is_sum: bool, seconds: f64) {
        let latency = self.waiting.take().map_or(0.0, |since| since.seconds());
        let Image { size, radiance, layers, stats } = made.image;
        let (edits, seen, upkeep, scene) = (self.edits, self.seen, self.renderer.upkeep(), self.snapshot());
        self.shared.show(Picture {
            size,
            radiance,
            #[cfg(feature = "gpu")]
            on_gpu: made.on_gpu,
            layers,
            divisor,
            is_sum,
            edits,
            seen,
            latency,
            seconds,
            stats,
            upkeep,
            scene,
        });
    }

    /// The scene as it is now.
    fn snapshot(&mut self) -> Arc<Snapshot> {
        if let Some((_, known)) = self.snapshot.as_ref().filter(|(edits, _)| *edits == self.edits) {
            return Arc::clone(known);
        }
        let renderer = &self.renderer;
        let measure = || renderer.scene().objects.iter().map(|object| object.shape.bounds()).collect();
        let bounds = self.bounds.get_or_insert_with(measure);
        let snapshot = Arc::new(Snapshot::new(renderer, bounds, self.history.steps()));
        self.snapshot = Some((self.edits, Arc::clone(&snapshot)));
        snapshot
    }

    fn set_layers(&mut self, layers: LayerSet) -> Result<bool, RenderError> {
        let settings = self.renderer.settings();
        if settings.layers == layers {
            return Ok(false);
        }
        self.renderer.set_settings(Settings { layers, ..settings.clone() })?;
        self.snapshot = None;
        Ok(true)
    }

    /// Whether other settings leave the reference as it is.
    fn has_same_rays(&self, settings: &Settings) -> bool {
        settings.samples == self.renderer.settings().samples
    }

    /// Whether the reference is to grow.
    pub(crate) fn wants_growth(&self) -> bool {
        let samples = self.growth.as_ref().filter(|growth| growth.edits() >= self.seen).map_or(0, Growth::samples);
        samples < self.samples
    }

    /// Lets the reference grow by a step, unless something interrupts it.
    pub(crate) fn grow(&mut self) {
        let cancel = self.shared.begin(Control::Refining, self.taken);
        if self.growth.as_ref().is_none_or(|growth| growth.edits() < self.seen) {
            self.growth = Some(Growth::new(&mut self.renderer, self.edits));
        }
        let growth = self.growth.as_mut();
        if let Some(truth) = growth.and_then(|growth| growth.advance(&mut self.renderer, &cancel)) {
            self.shared.show_truth(truth);
        }
    }
}

/// Whether a picture is there.
#[derive(PartialEq, Eq)]
enum Shown {
    Yes,
    Interrupted,
    Failed,
}

/// Thirty pictures a second.
const BUDGET: f64 = 1.0 / 30.0;

/// The smallest divisor whose picture takes so long at most, or twice as long before the coarsest one.
fn divisor_for(seconds: f64, budget: f64) -> u32 {
    let mut divisor = 1;
    let allowed = |divisor: u32| if 2 * divisor == COARSEST { LATE * budget } else { budget };
    while divisor < COARSEST && seconds / f64::from(divisor * divisor) > allowed(divisor) {
        divisor *= 2;
    }
    divisor
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coarse_pictures_keep_within_the_budget() {
        let divisors = [0.01, 0.033, 0.05, 0.2, 2.0, 4.2, 9.0].map(|seconds| divisor_for(seconds, BUDGET));
        assert_eq!(divisors, [1, 1, 2, 4, 8, 8, COARSEST]);
    }
}
