//! A run that ends by itself: the window opens, shows one picture, is saved, and closes.

use crate::darkroom::{Print, Sheet};
use crate::desk::Desk;
use crate::shot;
use eframe::egui::{Context, ViewportCommand, vec2};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Longer than any machine takes.
const PATIENCE: Duration = Duration::from_secs(120);

/// Frames after which a window in the window has its size.
const FRAMES: u32 = 3;

#[derive(Clone, Debug)]
pub(crate) struct Outcome(Arc<Mutex<Option<Result<(), String>>>>);

impl Outcome {
    fn set(&self, outcome: Result<(), String>) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(outcome);
    }

    fn is_set(&self) -> bool {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).is_some()
    }

    pub(crate) fn result(&self) -> Result<(), String> {
        let outcome = self.0.lock().unwrap_or_else(PoisonError::into_inner).take();
        outcome.unwrap_or_else(|| Err("the window was closed before its picture was saved".to_owned()))
    }
}

pub(crate) struct Smoke {
    path: PathBuf,
    start: Instant,
    first: Option<Duration>,
    is_saving: bool,
    /// Whether a pixel is to be taken apart first.
    wants_pixel: bool,
    /// Frames that have shown it: its window is as large as it gets after some.
    looks: u32,
    /// The same of a shadow map.
    map_looks: u32,
    /// Whether the window's size changes at each frame, and frames so far.
    shakes: bool,
    frames: u32,
    outcome: Outcome,
}

impl Smoke {
    pub(crate) fn new(path: PathBuf, wants_pixel: bool, shakes: bool) -> Self {
        let outcome = Outcome(Arc::new(Mutex::new(None)));
        Self {
            path,
            start: Instant::now(),
            first: None,
            is_saving: false,
            wants_pixel,
            looks: 0,
            map_looks: 0,
            shakes,
            frames: 0,
            outcome,
        }
    }

    pub(crate) fn outcome(&self) -> Outcome {
        self.outcome.clone()
    }

    /// Called for each frame of the window.
    pub(crate) fn watch(
        &mut self,
        context: &Context,
        desk: Option<&Desk>,
        message: Option<&str>,
        print: Option<&Print>,
    ) {
        if desk.is_none()
            && let Some(line) = message
        {
            self.outcome.set(Err(line.to_owned()));
        }
        if self.start.elapsed() > PATIENCE {
            self.outcome.set(Err(format!("no picture within {} s", PATIENCE.as_secs())));
        }
        self.frames += 1;
        if self.shakes && !self.is_saving {
            let side = 1000.0 + (self.frames % 7) as f32 * 40.0;
            context.send_viewport_cmd(ViewportCommand::InnerSize(vec2(side, 0.6 * side)));
        }
        if print.is_some() && self.first.is_none() {
            self.first = Some(self.start.elapsed());
        }
        self.looks += u32::from(desk.is_some_and(|desk| desk.probed.is_some()));
        let has_spheres = |desk: &Desk| !desk.shows_spheres || desk.spheres.0 == desk.editor.picture().edits;
        let has_pixel = !self.wants_pixel || self.looks > FRAMES;
        let has_map = |desk: &Desk| !desk.maps.is_shown || desk.maps.is_of(desk.editor.picture().edits);
        // Not its coarse beginnings.
        let has_whole = |desk: &Desk| {
            desk.editor.is_finished() && print.is_some_and(|print| Arc::ptr_eq(&print.picture, desk.editor.picture()))
        };
        let is_there = |desk: &Desk| has_whole(desk) && has_pixel && has_spheres(desk) && has_map(desk);
        self.map_looks += u32::from(desk.is_some_and(|desk| desk.maps.is_shown && has_map(desk)));
        let is_ready = |desk: &Desk| is_there(desk) && (!desk.maps.is_shown || self.map_looks > FRAMES);
        if !self.is_saving && desk.is_some_and(is_ready) {
            self.is_saving = true;
            let (first, whole) = (self.first.unwrap_or_default().as_secs_f64(), self.start.elapsed().as_secs_f64());
            let device = desk.map(|desk| desk.editor.scene().device.clone()).unwrap_or_default();
            let copied = match print.map(|print| &print.image) {
                Some(Sheet::OnGpu(_)) => "not copied",
                _ => "copied",
            };
            println!("shaded by {device}, {copied}, {} frames", self.frames);
            println!("first picture after {first:.2} s, whole picture after {whole:.2} s");
            let outcome = self.outcome.clone();
            shot::save(context, self.path.clone(), move |saved| outcome.set(saved));
        }
        if self.outcome.is_set() {
            context.send_viewport_cmd(ViewportCommand::Close);
        }
        context.request_repaint();
    }
}
