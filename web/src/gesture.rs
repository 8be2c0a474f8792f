//! The pointer: what it takes hold of, and what its drags do.

use crate::desk::{Desk, Thing};
use glam::{Mat4, Vec2};
use lighting::Light;
use scene::Camera;
use session::{Drag, Dragged, Grip, Handles, lamp, orbited, panned, zoomed};

/// Radians that a drag over the height of the picture turns the camera by.
const TURN: f32 = 3.0;
/// Pixels within which a light's mark is hit.
const MARK: f32 = 13.0;
/// Marks of lights outside the picture stay so many pixels from its edge.
const EDGE: f32 = 18.0;

/// The effect of a drag, with what it began with.
#[derive(Debug)]
pub(crate) enum Motion {
    Orbit(Camera, Vec2),
    Pan(Camera, Vec2),
    Light(renderer::LightHandle, Box<Light>, Drag),
    Object(renderer::ObjectHandle, Mat4, Drag),
}

impl Desk {
    /// The handles of what is selected.
    pub(crate) fn handles(&self) -> Option<Handles> {
        match self.selected? {
            Thing::Light(handle) => {
                let item = self.editor.light(handle).filter(|item| !item.is_animated)?;
                let handles = Handles::new(self.projection(), lamp::center(&item.light)?);
                Some(handles.with_direction(lamp::direction(&item.light)).with_size(lamp::size(&item.light)))
            }
            Thing::Object(handle) => {
                let item = self.editor.object(handle).filter(|item| !item.is_animated && !item.is_backdrop)?;
                Some(Handles::new(self.projection(), item.bounds.center()))
            }
        }
    }

    /// Where the mark of a light is; of one outside the picture at its edge.
    pub(crate) fn mark(&self, light: &Light) -> Option<Vec2> {
        let place = self.projection().pixel(lamp::center(light)?)?;
        let edge = Vec2::splat(EDGE).min(0.5 * self.view);
        Some(place.clamp(edge, self.view - edge))
    }

    /// The light whose mark is under the pointer.
    fn marked(&self, pointer: Vec2) -> Option<Thing> {
        let lights = self.editor.scene().lights.iter();
        let near = lights.filter_map(|item| Some((item.handle, self.mark(&item.light)?.distance(pointer))));
        let nearest = near.min_by(|a, b| a.1.total_cmp(&b.1));
        nearest.filter(|(_, distance)| *distance <= MARK).map(|(handle, _)| Thing::Light(handle))
    }

    pub(crate) fn press(&mut self, from: Vec2, pans: bool) {
        let camera = self.editor.scene().camera;
        self.motion = Some(if pans { Motion::Pan(camera, from) } else { self.taken(from) });
    }

    /// The thing that a drag takes hold of; the camera where there is none.
    fn taken(&mut self, from: Vec2) -> Motion {
        let orbit = Motion::Orbit(self.editor.scene().camera, from);
        if let Some(handles) = self.handles()
            && let Some(grip) = handles.hit(from)
        {
            return self.held(handles.drag(grip, from)).unwrap_or(orbit);
        }
        // A light is dragged at once, without being chosen before.
        let Some(thing) = self.marked(from) else { return orbit };
        self.selected = Some(thing);
        let Some(handles) = self.handles() else { return orbit };
        // One whose mark is at the edge comes under the pointer.
        let middle = handles.middle().filter(|middle| middle.distance(from) > MARK);
        self.held(handles.drag(Grip::Middle, middle.unwrap_or(from))).unwrap_or(orbit)
    }

    fn held(&self, drag: Drag) -> Option<Motion> {
        match self.selected? {
            Thing::Light(handle) => {
                let item = self.editor.light(handle)?;
                Some(Motion::Light(handle, Box::new(item.light.clone()), drag))
            }
            Thing::Object(handle) => Some(Motion::Object(handle, self.editor.object(handle)?.transform, drag)),
        }
    }

    pub(crate) fn drag(&mut self, pointer: Vec2) {
        match &self.motion {
            Some(Motion::Orbit(before, from)) => {
                self.set_camera(orbited(*before, (pointer - from) * (TURN / self.view.y)));
            }
            Some(Motion::Pan(before, from)) => self.set_camera(panned(*before, self.view, pointer - from)),
            Some(Motion::Light(handle, before, drag)) => {
                if let Some(by) = drag.to(pointer) {
                    self.editor.set_light(*handle, lamp::dragged(before, by));
                }
            }
            Some(Motion::Object(handle, before, drag)) => {
                if let Some(Dragged::Shift(by)) = drag.to(pointer) {
                    self.editor.set_transform(*handle, Mat4::from_translation(by) * *before);
                }
            }
            None => {}
        }
    }

    pub(crate) fn release(&mut self) {
        if self.motion.take().is_some() {
            self.close_step();
        }
    }

    /// Selects a light, or takes a pixel apart and selects what it shows.
    pub(crate) fn click(&mut self, at: Vec2) {
        if let Some(thing) = self.marked(at) {
            self.selected = Some(thing);
            return;
        }
        self.selected = None;
        if at.cmplt(Vec2::ZERO).any() || at.cmpge(self.view).any() {
            self.probed = None;
            return;
        }
        let [width, height] = self.editor.scene().size;
        let place = at / self.view;
        let pixel = [(place.x * width as f32) as u32, (place.y * height as f32) as u32];
        self.look_into([pixel[0].min(width - 1), pixel[1].min(height - 1)]);
    }

    pub(crate) fn zoom(&mut self, by: f32) {
        let camera = zoomed(self.editor.scene().camera, by);
        self.set_camera(camera);
    }
}
