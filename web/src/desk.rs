//! The scene that is open, and what is done with it.

use crate::files::Given;
use crate::gesture::Motion;
use crate::host;
use crate::request::Request;
use glam::{Vec2, Vec3};
use pictures::{Display, ToneMap};
use renderer::{LightHandle, ObjectHandle, PixelSamples, RenderError, Renderer, Settings, Window, exposure_of};
use scene::{Animation, Camera, Scene, Strategy};
use session::{Driver, Editor, Probe, Projection, Session, Task, framed, gloss, lamp, projected};
use shading::Accuracy;
use std::collections::HashMap;

/// Seconds in which a picture is to be there after an edit: browsers are slower, and coarser pictures show less of a shadow.
const BUDGET: f64 = 1.0 / 15.0;
/// Samples of the reference of one pixel.
const PROBE_SAMPLES: u32 = 4096;
/// Columns and rows of a picture, at most.
const LARGEST: u32 = 4096;

/// A light or an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Thing {
    Light(LightHandle),
    Object(ObjectHandle),
}

/// How far the exposure is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Meter {
    Nothing,
    /// From the first picture.
    Guess,
    /// By the renderer, or it is not needed.
    Done,
}

#[derive(Debug)]
pub(crate) struct Desk {
    pub(crate) editor: Editor,
    pub(crate) driver: Driver,
    pub(crate) display: Display,
    /// The exposure of the scene as it was opened.
    pub(crate) metered: f32,
    /// How it is known: the first picture comes before it is metered.
    meter: Meter,
    /// The size of the picture on the screen.
    pub(crate) view: Vec2,
    /// Rows over columns of the scene's own picture.
    aspect: f32,
    pub(crate) selected: Option<Thing>,
    pub(crate) motion: Option<Motion>,
    pub(crate) probed: Option<([u32; 2], Probe)>,
    /// How many were found.
    pub(crate) probes: u64,
    /// Lights that are switched off, as they were.
    off: HashMap<LightHandle, Vec3>,
    /// Whether it makes pictures, and not parts of another one's.
    leads: bool,
    /// Lines for the user since the last report.
    pub(crate) lines: Vec<String>,
}

impl Desk {
    /// Opens one of the files, or the built-in scene. An error is a line for the user.
    pub(crate) fn open(files: &Given, path: Option<&str>, columns: u32, leads: bool) -> Result<Self, String> {
        let (mut scene, animation, lines) = match path {
            None => (scene::builtin(), Animation::default(), Vec::new()),
            Some(path) => scene_files::load_from(files.all(), path, None).map_err(|error| error.to_string())?,
        };
        let aspect = scene.height as f32 / scene.width.max(1) as f32;
        [scene.width, scene.height] = size_of(columns, aspect);
        let mut desk = Self::of(scene, animation, leads).map_err(|error| error.to_string())?;
        (desk.aspect, desk.lines) = (aspect, lines);
        Ok(desk)
    }

    fn of(scene: Scene, animation: Animation, leads: bool) -> Result<Self, RenderError> {
        // As `lobes render` draws it.
        let settings = Settings { samples: PixelSamples::Edges(8), ..Settings::default() };
        let renderer = Renderer::with_backend(scene, animation, settings, host::backend()?)?;
        let (session, driver) = Session::driven(renderer);
        session.set_budget(BUDGET);
        let mut desk = Self {
            editor: Editor::new(session),
            driver,
            display: Display::default(),
            metered: 0.0,
            meter: if leads { Meter::Nothing } else { Meter::Done },
            view: Vec2::new(640.0, 360.0),
            aspect: 1.0,
            selected: None,
            motion: None,
            probed: None,
            probes: 0,
            off: HashMap::new(),
            leads,
            lines: Vec::new(),
        };
        // Leader and helpers begin with the same: edits are made of what is known.
        desk.driver.show_scene();
        desk.editor.follow();
        Ok(desk)
    }

    /// The next rows to shade.
    pub(crate) fn task(&mut self, hands: usize) -> Option<Task> {
        let task = self.driver.task(hands);
        if task.is_none() && self.meter == Meter::Guess {
            let metered = self.editor.session().meter();
            self.driver.follow();
            self.expose(metered.try_recv().unwrap_or(self.metered), Meter::Done);
        }
        task
    }

    /// Takes what the session has done; whether there is a new picture.
    pub(crate) fn follow(&mut self) -> bool {
        let is_new = self.editor.follow();
        self.lines.extend(self.editor.take_errors().iter().map(ToString::to_string));
        if is_new && self.meter == Meter::Nothing && !self.editor.picture().radiance.is_empty() {
            let stops = exposure_of(self.editor.picture().radiance.iter().copied());
            self.expose(stops, Meter::Guess);
        }
        is_new
    }

    /// Shows pictures at an exposure, and the user's own steps from it.
    fn expose(&mut self, stops: f32, meter: Meter) {
        self.display.exposure += stops - self.metered;
        (self.metered, self.meter) = (stops, meter);
    }

    /// The picture as a screen shows it, four bytes a pixel.
    pub(crate) fn pixels(&self, out: &mut Vec<u8>) {
        let picture = self.editor.picture();
        let [width, height] = picture.size;
        let rgb = self.display.bytes(&picture.radiance, &Window::whole(width, height));
        out.extend(rgb.as_chunks::<3>().0.iter().flat_map(|[r, g, b]| [*r, *g, *b, 255]));
    }

    /// Does what is requested. An error is a line for the user.
    pub(crate) fn follow_request(&mut self, request: Request) -> Result<(), String> {
        match request {
            Request::Open { .. } => {}
            Request::View { size } => self.view = Vec2::from_array(size).max(Vec2::ONE),
            Request::Press { at, pans } => self.press(at.into(), pans),
            Request::Drag { at } => self.drag(at.into()),
            Request::Release => self.release(),
            Request::Click { at } => self.click(at.into()),
            Request::Zoom { by } => self.zoom(by),
            Request::Frame => self.frame(),
            Request::Select { light } => {
                let handle = light.and_then(|number| self.editor.scene().lights.get(number)).map(|item| item.handle);
                self.selected = handle.map(Thing::Light);
            }
            Request::Light { number, size, radiance, color, on } => {
                self.change_light(number, size, (radiance, color.map(Vec3::from_array)), on);
            }
            Request::Material { gloss, color } => self.change_material(gloss, color.map(Vec3::from_array)),
            Request::Strategy { name } => {
                if let Some(Thing::Object(handle)) = self.selected {
                    self.editor.set_strategy(handle, named(name.as_deref())?);
                    self.close_step();
                }
            }
            Request::Strategies { name } => {
                let strategy = named(name.as_deref())?;
                self.change_settings(|settings| settings.strategy = strategy);
                self.close_step();
            }
            Request::Projection { name } => {
                self.set_camera(projected(self.editor.scene().camera, &name));
                self.close_step();
            }
            Request::Tolerance { value } => {
                self.change_settings(|settings| settings.accuracy = Accuracy::new(value));
            }
            Request::Columns { count } => self.editor.set_size(size_of(count, self.aspect)),
            Request::Look { exposure, tone } => {
                self.display = Display { exposure, tone: tone_named(&tone)?, ..self.display };
            }
            Request::Seek { time } => self.editor.seek(time),
            Request::Rest => self.close_step(),
            Request::Undo => {
                self.editor.undo();
                self.look_again();
            }
            Request::Redo => {
                self.editor.redo();
                self.look_again();
            }
        }
        Ok(())
    }

    fn change_settings(&mut self, change: impl FnOnce(&mut Settings)) {
        let mut settings = self.editor.scene().settings.clone();
        change(&mut settings);
        self.editor.set_settings(settings);
    }

    fn change_light(
        &mut self,
        number: usize,
        size: Option<f32>,
        (radiance, color): (Option<f32>, Option<Vec3>),
        on: Option<bool>,
    ) {
        let Some(item) = self.editor.scene().lights.get(number).filter(|item| !item.is_animated) else { return };
        let (handle, mut light) = (item.handle, item.light.clone());
        let before = light.full_radiance();
        if let Some(size) = size {
            light = lamp::resized(&light, size);
        }
        if let Some(radiance) = radiance.filter(|_| before.max_element() > 0.0) {
            light = lamp::with_radiance(&light, before * (radiance / before.max_element()));
        }
        if let Some(color) = color.map(|color| color.max(Vec3::splat(1e-3))) {
            light = lamp::with_radiance(&light, color * (before.max_element() / color.max_element()));
        }
        match on {
            Some(true) if before == Vec3::ZERO => {
                light = lamp::with_radiance(&light, self.off.remove(&handle).unwrap_or(Vec3::ONE));
            }
            Some(false) if before != Vec3::ZERO => {
                self.off.insert(handle, before);
                light = lamp::with_radiance(&light, Vec3::ZERO);
            }
            _ => {}
        }
        self.editor.set_light(handle, light);
    }

    fn change_material(&mut self, number: Option<f32>, color: Option<Vec3>) {
        let Some(Thing::Object(handle)) = self.selected else { return };
        let place = self.editor.object(handle).map(|item| item.material);
        let Some(item) = place.and_then(|place| self.editor.scene().materials.get(place)) else { return };
        let (handle, mut material) = (item.handle, item.material.clone());
        if let Some(number) = number {
            material = gloss::with(&material, number);
        }
        if let Some(color) = color {
            material = gloss::with_color(&material, color);
        }
        self.editor.set_material(handle, material);
    }

    /// The camera, where nothing else moves it. From now on it is the user's.
    pub(crate) fn set_camera(&mut self, camera: Camera) {
        if self.editor.scene().is_camera_animated {
            self.editor.release_camera();
        }
        self.editor.set_camera(camera);
    }

    fn frame(&mut self) {
        let scene = self.editor.scene();
        let camera = framed(scene.camera, scene.bounds(), self.view);
        self.set_camera(camera);
        self.close_step();
    }

    /// Ends a drag, or the move of a slider.
    pub(crate) fn close_step(&mut self) {
        self.editor.close_step();
        self.look_again();
    }

    /// Takes the same pixel apart again: the scene has changed.
    fn look_again(&mut self) {
        if let Some((pixel, _)) = self.probed {
            self.look_into(pixel);
        }
    }

    /// Takes a pixel apart, and selects what it shows where nothing is selected.
    pub(crate) fn look_into(&mut self, pixel: [u32; 2]) {
        // A helper needs no more than the selection.
        let samples = if self.leads { PROBE_SAMPLES } else { 1 };
        let answer = self.editor.session().probe(pixel[0], pixel[1], samples);
        self.driver.follow();
        self.probed = None;
        match answer.try_recv() {
            Ok(Ok(Some(probe))) => {
                if self.selected.is_none() {
                    self.selected = Some(probe.pick.light.map_or(Thing::Object(probe.pick.object), Thing::Light));
                }
                self.probed = Some((pixel, probe));
            }
            Ok(Err(error)) => self.lines.push(error.to_string()),
            _ => {}
        }
        self.probes += 1;
    }

    /// The camera with all changes so far, on the screen.
    pub(crate) fn projection(&self) -> Projection {
        Projection::new(self.editor.scene().camera, self.view)
    }
}

fn size_of(columns: u32, aspect: f32) -> [u32; 2] {
    let columns = columns.clamp(1, LARGEST);
    [columns, ((columns as f32 * aspect).round() as u32).clamp(1, LARGEST)]
}

fn named(name: Option<&str>) -> Result<Option<Strategy>, String> {
    let find = |name| Strategy::named(name).ok_or_else(|| format!("no strategy is called \"{name}\""));
    name.map(find).transpose()
}

pub(crate) fn tone_named(name: &str) -> Result<ToneMap, String> {
    let all =
        [("linear", ToneMap::Linear), ("soft", ToneMap::Soft), ("neutral", ToneMap::Neutral), ("agx", ToneMap::Agx)];
    let found = all.into_iter().find(|(known, _)| *known == name);
    found.map(|(_, tone)| tone).ok_or_else(|| format!("no tone map is called \"{name}\""))
}
