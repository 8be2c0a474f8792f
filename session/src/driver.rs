use crate::worker::Worker;
use core::fmt;
use core::ops::{ControlFlow, Range};
use glam::Vec3;
use renderer::{Band, Event, Image, ImageStats, Layers, RenderError, Window};
use scene::Stopwatch;

/// Rows of a strip, the smallest part of a picture that is made at once: pixels are shaded in tiles of 8 × 8.
const STRIP: usize = 8;

/// The work of a [driven](crate::Session::driven) session, which its caller does step by step.
///
/// [`step`](Self::step) does one: it takes all edits so far and makes a coarse picture, some rows of the whole one, or a step of the
/// reference, so that none takes much longer than the session's [budget](crate::Session::set_budget); the first picture of a scene, which
/// builds hierarchies, does, and a step of the reference.
///
/// Several that were made of the same scene and were told the same edits can share a picture: one says which [`task`](Self::task) is next,
/// each [shades](Self::shade) its part of it, and the first one [takes](Self::finish) them all. The pixels are the same.
///
/// The [statistics](crate::Picture::stats) of a picture are those of the step that finished it.
///
/// ```
/// use renderer::{Renderer, Settings};
/// use session::Session;
/// let mut scene = scene::builtin();
/// (scene.width, scene.height) = (64, 36);
/// let renderer = Renderer::new(scene, scene::Animation::default(), Settings::default())?;
/// let (session, mut driver) = Session::driven(renderer);
/// while driver.step() {}
/// assert_eq!((session.picture().size, session.picture().divisor), ([64, 36], 1));
/// # Ok::<(), renderer::RenderError>(())
/// ```
pub struct Driver {
    worker: Worker,
    /// Whether a picture is to come.
    is_pending: bool,
    drawing: Option<Drawing>,
}

/// Rows of a picture that are made next.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Task {
    /// By how much the sides of the picture are shorter than those of the whole one.
    pub divisor: u32,
    /// Columns and rows of that picture.
    pub size: [usize; 2],
    /// The rows.
    pub rows: Range<usize>,
}

impl Task {
    /// The windows of one of `of` parts: strips of rows, dealt in turn.
    fn windows(&self, part: usize, of: usize) -> Vec<Window> {
        let [width, _] = self.size;
        let all = Window { image: self.size, columns: 0..width, rows: self.rows.clone() };
        all.parts([width, STRIP]).skip(part).step_by(of.max(1)).collect()
    }

    /// The number of pixels that a part of it has.
    #[must_use]
    pub fn pixels(&self, part: usize, of: usize) -> usize {
        self.windows(part, of).iter().map(Window::pixels).sum()
    }
}

/// A picture that is being made.
#[derive(Debug)]
struct Drawing {
    task: Task,
    radiance: Vec<Vec3>,
    layers: Layers,
    stats: ImageStats,
    /// Whether its points are found anew.
    is_new: usize,
    /// Seconds so far, without those between the steps.
    seconds: f64,
    watch: Stopwatch,
}

impl Drawing {
    fn new(size: [usize; 2], divisor: u32, is_new: usize) -> Self {
        let size = size.map(|side| side.div_ceil(divisor as usize));
        Self {
            task: Task { divisor, size, rows: 0..0 },
            radiance: vec![Vec3::ZERO; size[0] * size[1]],
            layers: Layers::default(),
            stats: ImageStats::default(),
            is_new,
            seconds: 0.0,
            watch: Stopwatch::start(),
        }
    }
}

impl fmt::Debug for Driver {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let task = self.drawing.as_ref().map(|drawing| &drawing.task);
        f.debug_struct("Driver").field("is_pending", &self.is_pending).field("task", &task).finish_non_exhaustive()
    }
}

impl Driver {
    pub(crate) const fn new(worker: Worker) -> Self {
        Self { worker, is_pending: true, drawing: None }
    }

    /// Does one step of the work; whether there is more to do.
    pub fn step(&mut self) -> bool {
        if let Some(task) = self.task(1) {
            let done = self.shade(&task, 0, 1);
            self.finish(vec![done]);
        } else if self.worker.wants_growth() {
            self.worker.grow();
        }
        self.is_pending || self.worker.wants_growth()
    }

    /// Takes all edits so far, and says what is to be made next by so many hands; none where the whole picture is there. The same again
    /// until it is [finished](Self::finish) or an edit makes it another one.
    pub fn task(&mut self, hands: usize) -> Option<Task> {
        self.follow();
        if !self.is_pending {
            return None;
        }
        let drawing = match self.drawing.take() {
            Some(drawing) => drawing,
            None => {
                let is_new = self.worker.has_new_points();
                let divisor = self.worker.divisor(is_new);
                Drawing::new(self.size(), divisor, is_new)
            }
        };
        let drawing = self.drawing.insert(drawing);
        let [_, height] = drawing.task.size;
        let start = drawing.task.rows.start;
        let end = match drawing.task.divisor {
            1 => start + rows_at_once(&self.worker, drawing, hands),
            _ => height,
        };
        drawing.task.rows = start..end.min(height);
        drawing.watch = Stopwatch::start();
        Some(drawing.task.clone())
    }

    /// Shades one of `of` parts of a task after all edits so far: strips of eight rows, dealt in turn.
    ///
    /// # Errors
    /// Those of [`Renderer::render`](renderer::Renderer::render).
    pub fn shade(&mut self, task: &Task, part: usize, of: usize) -> Result<Image, RenderError> {
        self.follow();
        let (windows, mut image) = part_of(task, part, of);
        let (renderer, go_on) = (self.worker.renderer(), &mut |_: Event| ControlFlow::Continue(()));
        image.stats =
            renderer.render_reduced_parts(task.divisor, &windows, go_on, &mut |band| add(&mut image, band))?;
        Ok(image)
    }

    /// As [`shade`](Self::shade). On a browser's GPU the future is ready in a later turn; everywhere else at its first poll.
    ///
    /// # Errors
    /// Those of [`shade`](Self::shade).
    pub async fn shade_async(&mut self, task: &Task, part: usize, of: usize) -> Result<Image, RenderError> {
        self.follow();
        let (windows, mut image) = part_of(task, part, of);
        let (renderer, go_on) = (self.worker.renderer(), &mut |_: Event| ControlFlow::Continue(()));
        let mut sink = |band: &Band| add(&mut image, band);
        image.stats = renderer.render_reduced_parts_async(task.divisor, &windows, go_on, &mut sink).await?;
        Ok(image)
    }

    /// Takes all parts of the last [`task`](Self::task), in their order; layers come with pictures that one part makes. A failure ends the
    /// picture.
    ///
    /// # Panics
    /// If a part has not the pixels that it is to have.
    pub fn finish(&mut self, parts: Vec<Result<Image, RenderError>>) {
        let Some(mut drawing) = self.drawing.take() else { return };
        let of = parts.len();
        for (part, image) in parts.into_iter().enumerate() {
            let image = match image {
                Ok(image) => image,
                Err(error) => {
                    self.is_pending = false;
                    return self.worker.fail(error);
                }
            };
            let mut rest = image.radiance.as_slice();
            for window in drawing.task.windows(part, of) {
                let (strip, more) = rest.split_at(window.pixels());
                drawing.radiance[window.rows.start * window.image[0]..][..strip.len()].copy_from_slice(strip);
                rest = more;
            }
            assert!(rest.is_empty(), "the pixels of a part");
            if of == 1 {
                drawing.layers.append(&image.layers);
            }
            if part == 0 {
                drawing.stats = image.stats;
            }
        }
        drawing.seconds += drawing.watch.seconds();
        let Task { divisor, size, rows } = &mut drawing.task;
        rows.start = rows.end;
        if rows.start < size[1] {
            self.drawing = Some(drawing);
            return;
        }
        let (divisor, is_new) = (*divisor, drawing.is_new);
        let Drawing { task, radiance, layers, stats, seconds, .. } = drawing;
        self.worker.publish(Image { size: task.size, radiance, layers, stats }, divisor, is_new, seconds);
        match divisor {
            1 => self.is_pending = false,
            _ => self.drawing = Some(Drawing::new(self.size(), 1, is_new)),
        }
    }

    /// Makes the picture again, though nothing has changed: another device shades its parts from now on.
    pub fn redraw(&mut self) {
        self.follow();
        (self.is_pending, self.drawing) = (true, None);
    }

    /// Takes all edits so far, and shows the scene without pixels: for those that only shade parts.
    pub fn show_scene(&mut self) {
        self.follow();
        self.worker.publish(Image::default(), 0, 0, 0.0);
    }

    fn size(&mut self) -> [usize; 2] {
        let scene = self.worker.renderer().scene();
        [scene.width as usize, scene.height as usize]
    }

    /// Takes all edits so far, and answers all questions, without a picture.
    pub fn follow(&mut self) {
        if self.worker.take_all(None) == Some(true) {
            (self.is_pending, self.drawing) = (true, None);
        }
    }
}

/// The windows of a part, and an image without pixels for it.
fn part_of(task: &Task, part: usize, of: usize) -> (Vec<Window>, Image) {
    let windows = task.windows(part, of);
    let rows = windows.iter().map(|window| window.rows.len()).sum();
    (windows, Image { size: [task.size[0], rows], ..Image::default() })
}

/// Adds a band below an image.
fn add(image: &mut Image, band: &Band) -> ControlFlow<()> {
    image.radiance.extend_from_slice(&band.radiance);
    image.layers.append(&band.layers);
    ControlFlow::Continue(())
}

/// Rows that hands can make within the budget.
fn rows_at_once(worker: &Worker, drawing: &Drawing, hands: usize) -> usize {
    let least = STRIP * hands.max(1);
    let [_, height] = drawing.task.size;
    let second = match drawing.task.rows.start {
        0 => worker.seconds_of_whole(drawing.is_new).map(|seconds| seconds / height.max(1) as f64),
        done => Some(drawing.seconds / done as f64),
    };
    // Of a clock that stands still all rows.
    let rows = second.map_or(0.0, |seconds| worker.budget() / seconds);
    (rows.clamp(0.0, height as f64) as usize / least * least).max(least)
}
