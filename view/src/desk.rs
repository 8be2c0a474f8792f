//! The scene that is open, and what is done with it.

use crate::map_window::MapView;
use crate::opening::{Opened, name_of};
use crate::viewing::{View, Viewing};
use cosine_lobes::Display;
use cosine_lobes::glam::{Mat4, Vec2, Vec3};
use cosine_lobes::lighting::Light;
use cosine_lobes::renderer::{LightHandle, ObjectHandle, RenderError, Renderer, Settings};
use cosine_lobes::scene::{Animation, BlockerSet, Camera, Scene, Strategy};
use cosine_lobes::session::{
    Drag, Dragged, Editor, LightItem, NewLight, Primitive, Probe, Projection, Snapshot, Trade, framed, lamp, save,
};
use eframe::egui::Context;
use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::Receiver;

/// Samples of the reference, at most.
const SAMPLES: u32 = 4096;
/// Samples of the reference of one pixel.
const PROBE_SAMPLES: u32 = 4096;

/// The shadow map that is shown.
#[derive(Debug, Default)]
pub(crate) struct Maps {
    pub(crate) is_shown: bool,
    /// None where the light has none.
    pub(crate) view: Option<MapView>,
    /// How many were taken so far.
    pub(crate) count: u64,
    /// The number of its light.
    pub(crate) number: usize,
    /// The number of changes that it shows, and its light.
    of: Option<(u64, LightHandle)>,
    /// That of a later picture or of another light, on its way from the session.
    coming: Option<Coming>,
}

/// The number of changes and the light of a shadow map, and where it arrives.
type Coming = ((u64, LightHandle), Receiver<Option<MapView>>);

impl Maps {
    /// Whether the map of a picture with this number of changes is there.
    pub(crate) fn is_of(&self, edits: u64) -> bool {
        self.of.is_some_and(|(of, _)| of == edits)
    }
}

/// A light or an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Thing {
    Light(LightHandle),
    Object(ObjectHandle),
}

/// The effect of a drag of the pointer.
#[derive(Debug)]
pub(crate) enum Motion {
    /// The camera as it was, and where the pointer began.
    Orbit(Camera, Vec2),
    Pan(Camera, Vec2),
    /// A light by a handle: as it was.
    Light(LightHandle, Box<Light>, Drag),
    /// An object by a handle: where it was.
    Object(ObjectHandle, Mat4, Drag),
    Split,
}

#[derive(Debug)]
pub(crate) struct Desk {
    pub(crate) editor: Editor,
    pub(crate) path: Option<PathBuf>,
    /// Of the scene as it was opened.
    pub(crate) metered: f32,
    /// The scene as its file has it.
    saved: Option<Snapshot>,
    /// The size of its picture.
    pub(crate) first_size: [u32; 2],
    /// Half the diagonal of its box, floors and walls left out.
    pub(crate) extent: f32,
    pub(crate) viewing: Viewing,
    pub(crate) selected: Option<Thing>,
    pub(crate) motion: Option<Motion>,
    /// The pixel that is looked into, and what was found.
    pub(crate) probed: Option<([u32; 2], Probe)>,
    /// How many were found.
    pub(crate) probes: u64,
    asked: Option<([u32; 2], Receiver<Answer>)>,
    /// Lights that are switched off, as they were.
    off: HashMap<LightHandle, Vec3>,
    /// All things as they were before one was added that is to be selected.
    known: Option<Vec<Thing>>,
    /// Whether the spheres that block light are drawn.
    pub(crate) shows_spheres: bool,
    /// These spheres, and the number of changes that they show.
    pub(crate) spheres: (u64, BlockerSet),
    /// Those of a later picture, on their way from the session.
    coming: Option<(u64, Receiver<BlockerSet>)>,
    pub(crate) maps: Maps,
    /// The pixels in which an outline was found, and the number of changes that they show.
    crossed: Option<(u64, Arc<Vec<u32>>)>,
    /// Those of a later picture, on their way from the session.
    crossing: Option<(u64, Receiver<Vec<u32>>)>,
    /// The strategies of objects that are hidden.
    hidden: HashMap<ObjectHandle, Option<Strategy>>,
    pub(crate) is_playing: bool,
    /// Whether the wheel turns.
    pub(crate) is_zooming: bool,
    /// The layers and samples that were requested of the session.
    requested: Option<(View, u32)>,
    metering: Option<Receiver<f32>>,
    /// Error against time, once it was requested.
    pub(crate) trade: Option<Trade>,
    pub(crate) is_measuring: bool,
    /// The scene that is to be measured, on its way from the session.
    sent: Option<Receiver<Measured>>,
}

/// A pixel taken apart; none where it shows no surface.
type Answer = Result<Option<Probe>, RenderError>;

/// A scene as settings draw it.
type Measured = (Scene, Animation, Settings);

impl Desk {
    pub(crate) fn new(opened: Opened) -> Self {
        let display = Display { exposure: opened.exposure, ..Display::default() };
        let viewing = Viewing { view: View::Picture, display, split: None };
        Self {
            editor: Editor::new(opened.session),
            path: opened.path,
            metered: opened.exposure,
            saved: None,
            first_size: [0; 2],
            extent: 1.0,
            viewing,
            selected: None,
            motion: None,
            probed: None,
            probes: 0,
            asked: None,
            off: HashMap::new(),
            known: None,
            shows_spheres: false,
            spheres: (u64::MAX, BlockerSet::default()),
            coming: None,
            maps: Maps::default(),
            crossed: None,
            crossing: None,
            hidden: HashMap::new(),
            is_playing: false,
            is_zooming: false,
            requested: None,
            metering: None,
            trade: None,
            is_measuring: false,
            sent: None,
        }
    }

    pub(crate) fn title(&self) -> String {
        self.path.as_deref().map_or_else(|| "built-in scene".to_owned(), name_of)
    }

    /// Takes what the session has done. An error is a line for the user.
    pub(crate) fn follow(&mut self, context: &Context) -> Option<String> {
        self.editor.follow();
        self.select_new();
        self.follow_spheres();
        self.follow_map();
        self.follow_crossed();
        self.begin_to_measure(context);
        if self.first_size == [0; 2] && !self.editor.picture().is_empty() {
            self.first_size = self.editor.scene().size;
            self.saved = Some(self.editor.scene().clone());
            self.extent = self.editor.scene().bounds().radius().max(1e-6);
        }
        let samples = if self.viewing.wants_reference() { SAMPLES } else { 0 };
        if self.requested != Some((self.viewing.view, samples)) {
            self.requested = Some((self.viewing.view, samples));
            self.editor.session().set_layers(self.viewing.view.layers());
            self.editor.session().set_reference(samples);
        }
        if let Some(exposure) = self.metering.as_ref().and_then(|metered| metered.try_recv().ok()) {
            (self.viewing.display.exposure, self.metered, self.metering) = (exposure, exposure, None);
        }
        let mut error = self.editor.take_errors().pop().map(|error| error.to_string());
        if let Some(Err(fault)) = self.trade.as_ref().and_then(Trade::end).inspect(|_| self.is_measuring = false) {
            error = Some(fault.to_string());
        }
        if let Some((pixel, received)) = &self.asked
            && let Ok(answer) = received.try_recv()
        {
            match answer {
                Ok(Some(probe)) => {
                    if self.selected.is_none() {
                        self.selected = Some(probe.pick.light.map_or(Thing::Object(probe.pick.object), Thing::Light));
                    }
                    self.probed = Some((*pixel, probe));
                    self.probes += 1;
                }
                Ok(None) => self.probed = None,
                Err(fault) => error = Some(fault.to_string()),
            }
            self.asked = None;
        }
        error
    }

    /// Takes a pixel apart, and selects what it shows.
    pub(crate) fn look_into(&mut self, pixel: [u32; 2]) {
        self.selected = None;
        self.ask(pixel);
    }

    /// Takes the same pixel apart again: the scene has changed.
    pub(crate) fn look_again(&mut self) {
        if let Some((pixel, _)) = self.probed {
            self.ask(pixel);
        }
    }

    fn ask(&mut self, pixel: [u32; 2]) {
        let [x, y] = pixel;
        self.asked = Some((pixel, self.editor.session().probe(x, y, PROBE_SAMPLES)));
    }

    /// Begins to measure error against time.
    pub(crate) fn measure(&mut self, context: &Context) {
        let copy =
            |renderer: &Renderer| (renderer.scene().clone(), renderer.animation().clone(), renderer.settings().clone());
        self.sent = Some(self.editor.session().query(copy));
        (self.trade, self.is_measuring) = (None, true);
        context.request_repaint();
    }

    /// Hands the scene on to be measured, once it is there.
    fn begin_to_measure(&mut self, context: &Context) {
        let Some((scene, animation, settings)) = self.sent.as_ref().and_then(|sent| sent.try_recv().ok()) else {
            return;
        };
        self.sent = None;
        let waker = context.clone();
        self.trade = Some(Trade::new(scene, animation, settings, move || waker.request_repaint()));
    }

    /// Meters the exposure anew.
    pub(crate) fn meter(&mut self) {
        self.metering = Some(self.editor.session().meter());
    }

    /// Ends a drag, or the move of a slider.
    pub(crate) fn close_step(&mut self) {
        self.editor.close_step();
        self.look_again();
    }

    pub(crate) fn undo(&mut self) {
        self.editor.undo();
        self.look_again();
    }

    pub(crate) fn redo(&mut self) {
        self.editor.redo();
        self.look_again();
    }

    /// The camera, where nothing else moves it. From now on it is the user's.
    pub(crate) fn set_camera(&mut self, camera: Camera) {
        if self.editor.scene().is_camera_animated {
            self.editor.release_camera();
        }
        self.editor.set_camera(camera);
    }

    /// Seconds of the animation that pass between two pictures, at least: as many as the last one took.
    pub(crate) fn pace(&self) -> f32 {
        (self.editor.picture().latency as f32).clamp(0.0, 0.5)
    }

    /// Writes the changes into the scene file; a line for the user.
    pub(crate) fn save(&mut self) -> String {
        let Some(path) = self.path.clone() else {
            return "not saved: the built-in scene has no file".to_owned();
        };
        if path.extension().is_none_or(|ending| !ending.eq_ignore_ascii_case("toml")) {
            return format!(
                "not saved: {} is a model; a scene file (.toml) that names it can be saved",
                name_of(&path)
            );
        }
        if !self.editor.is_finished() {
            return "not saved yet: the picture with all changes comes first".to_owned();
        }
        let Some(before) = &self.saved else { return "not saved: there is no picture yet".to_owned() };
        let now = self.editor.scene().clone();
        match save(&path, before, &now) {
            Ok(saved) => {
                self.saved = Some(saved);
                format!("saved to {}", path.display())
            }
            Err(error) => error.to_string(),
        }
    }

    /// Looks at the whole scene, from where the camera looks.
    pub(crate) fn frame_all(&mut self) {
        self.editor.close_step();
        let scene = self.editor.scene();
        let size = Vec2::new(scene.size[0] as f32, scene.size[1] as f32);
        self.set_camera(framed(scene.camera, scene.bounds(), size));
        self.close_step();
    }

    /// Drags a handle further.
    pub(crate) fn drag_to(&mut self, pointer: Vec2) {
        match &self.motion {
            Some(Motion::Light(handle, before, drag)) => {
                let Some(dragged) = drag.to(pointer) else { return };
                self.editor.set_light(*handle, lamp::dragged(before, dragged));
            }
            Some(Motion::Object(handle, before, drag)) => {
                if let Some(Dragged::Shift(by)) = drag.to(pointer) {
                    let transform = Mat4::from_translation(by) * *before;
                    self.editor.set_transform(*handle, transform);
                }
            }
            _ => {}
        }
    }

    /// Switches a light off or on.
    pub(crate) fn switch(&mut self, handle: LightHandle) {
        let Some(light) = self.editor.light(handle).map(|item| item.light.clone()) else { return };
        let radiance = light.full_radiance();
        let new = match radiance == Vec3::ZERO {
            true => self.off.remove(&handle).unwrap_or(Vec3::ONE),
            false => {
                self.off.insert(handle, radiance);
                Vec3::ZERO
            }
        };
        self.editor.set_light(handle, lamp::with_radiance(&light, new));
        self.close_step();
    }

    /// Shows an object, or hides it: it is neither seen nor does it block light then.
    pub(crate) fn show(&mut self, handle: ObjectHandle, visible: bool) {
        let Some(before) = self.editor.object(handle).map(|item| item.strategy) else { return };
        let strategy = match visible {
            true => self.hidden.remove(&handle).unwrap_or(before.filter(|strategy| *strategy != Strategy::None)),
            false => {
                self.hidden.insert(handle, before);
                Some(Strategy::None)
            }
        };
        self.editor.show(handle, visible, strategy);
        self.close_step();
    }

    /// Switches the selected light off, or hides the selected object.
    pub(crate) fn delete(&mut self) {
        match self.selected.take() {
            Some(Thing::Light(handle)) => self.switch(handle),
            Some(Thing::Object(handle)) => self.show(handle, false),
            None => {}
        }
    }

    /// Removes the selected light or object; one step.
    pub(crate) fn remove(&mut self) {
        match self.selected.take() {
            Some(Thing::Light(handle)) => self.editor.remove_light(handle),
            Some(Thing::Object(handle)) => self.editor.remove_object(handle),
            None => return,
        }
        self.probed = None;
    }

    /// Adds a light above the scene, so bright that a white surface under it is as bright as white is at this exposure.
    pub(crate) fn add_light(&mut self, kind: NewLight) {
        let irradiance = std::f32::consts::PI * (-self.metered).exp2();
        self.editor.add_light(kind.light(self.editor.scene().bounds(), irradiance));
        self.known = Some(self.handles());
        self.look_again();
    }

    /// Adds an object on the bottom of the scene: of the selected object's material, or the first one that does not shine.
    pub(crate) fn add_object(&mut self, primitive: Primitive) {
        let scene = self.editor.scene();
        let dark = |number: &usize| scene.materials.get(*number).is_some_and(|item| !item.surface.emits());
        let chosen = match self.selected {
            Some(Thing::Object(handle)) => scene.object(handle).map(|item| item.material),
            _ => None,
        };
        let material = chosen.filter(dark).or_else(|| (0..scene.materials.len()).find(dark));
        let name = (1..).map(|number| format!("new {primitive} {number}"));
        let is_free = |name: &String| scene.objects.iter().all(|item| item.name != *name);
        if let (Some(material), Some(name)) = (material, name.into_iter().find(is_free)) {
            self.editor.add_object(primitive.object(name, material));
            self.known = Some(self.handles());
            self.look_again();
        }
    }

    fn handles(&self) -> Vec<Thing> {
        let scene = self.editor.scene();
        let lights = scene.lights.iter().map(|item| Thing::Light(item.handle));
        lights.chain(scene.objects.iter().map(|item| Thing::Object(item.handle))).collect()
    }

    /// Requests the spheres of a whole picture, which that would interrupt before, and takes them.
    fn follow_spheres(&mut self) {
        let edits = self.editor.picture().edits;
        if let Some((edits, set)) = self.coming.as_ref().and_then(|(edits, set)| Some((*edits, set.try_recv().ok()?))) {
            self.spheres = (edits, set);
            self.coming = None;
        }
        if self.shows_spheres && self.coming.is_none() && self.editor.is_finished() && self.spheres.0 != edits {
            let set = self.editor.session().query(|renderer| renderer.blocker_spheres().clone());
            self.coming = Some((edits, set));
        }
    }

    /// Requests the shadow map of the selected light, or of the last one that was, or of the first, and takes it.
    fn follow_map(&mut self) {
        let edits = self.editor.picture().edits;
        let taken = self.maps.coming.as_ref().and_then(|(of, coming)| Some((*of, coming.try_recv().ok()?)));
        if let Some((of, view)) = taken {
            self.maps.of = Some(of);
            self.maps.view = view;
            self.maps.count += 1;
            self.maps.coming = None;
        }
        if !self.maps.is_shown || self.maps.coming.is_some() || !self.editor.is_finished() {
            return;
        }
        let lights = &self.editor.scene().lights;
        let selected = |item: &&LightItem| self.selected == Some(Thing::Light(item.handle));
        let last = |item: &&LightItem| self.maps.of.is_some_and(|(_, light)| light == item.handle);
        let chosen = lights.iter().find(selected).or_else(|| lights.iter().find(last)).or(lights.first());
        let Some(light) = chosen.map(|item| item.handle) else { return };
        if self.maps.of != Some((edits, light)) {
            self.maps.number = lights.iter().position(|item| item.handle == light).unwrap_or(0);
            let ask = move |renderer: &Renderer| renderer.shadow_map(light).map(MapView::new);
            self.maps.coming = Some(((edits, light), self.editor.session().query(ask)));
        }
    }

    /// Requests the pixels in which outlines are found, where they are looked at, and takes them.
    fn follow_crossed(&mut self) {
        let edits = self.editor.picture().edits;
        if let Some((of, found)) = self.crossing.as_ref().and_then(|(of, found)| Some((*of, found.try_recv().ok()?))) {
            self.crossed = Some((of, Arc::new(found)));
            self.crossing = None;
        }
        let is_there = self.crossed.as_ref().is_some_and(|(of, _)| *of == edits);
        if self.viewing.view == View::Edges && !is_there && self.crossing.is_none() && self.editor.is_finished() {
            self.crossing = Some((edits, self.editor.session().crossed()));
        }
    }

    /// The pixels in which outlines were found, once they are those of the picture that is seen.
    pub(crate) fn crossed(&self) -> Option<&Arc<Vec<u32>>> {
        let is_own = |of: u64| self.viewing.view == View::Edges && of == self.editor.picture().edits;
        self.crossed.as_ref().filter(|(of, _)| is_own(*of)).map(|(_, found)| found)
    }

    /// Selects what was added, once it is there.
    fn select_new(&mut self) {
        let Some(known) = &self.known else { return };
        if let Some(new) = self.handles().into_iter().find(|thing| !known.contains(thing)) {
            self.selected = Some(new);
            self.known = None;
        } else if !self.editor.is_waiting() {
            // It was refused.
            self.known = None;
        }
    }

    /// The camera of the picture that is seen, on a screen of some size.
    pub(crate) fn projection(&self, size: Vec2) -> Projection {
        Projection::new(self.editor.picture().scene.camera, size)
    }
}
