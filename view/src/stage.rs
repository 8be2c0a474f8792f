//! The picture, and all that the pointer does with it.

use crate::darkroom::{Print, Sheet};
use crate::desk::{Desk, Motion, Thing};
use crate::inspector::OUTLINE;
use crate::screen::Screen;
use cosine_lobes::glam::{Vec2, Vec3};
use cosine_lobes::lighting::Light;
use cosine_lobes::scene::Bounds;
use cosine_lobes::session::{Grip, Handles, ObjectItem, Probe, Projection, lamp, orbited, panned, zoomed};
use eframe::egui::{
    Align2, Color32, Context, CursorIcon, FontId, Painter, PointerButton, Pos2, Rect, Response, Sense, Shape, Stroke,
    TextureHandle, TextureId, TextureOptions, Ui, pos2, vec2,
};

/// Radians that a drag over the height of the picture turns the camera by.
const TURN: f32 = 3.0;
/// Pixels within which a light's mark is hit.
const MARK: f32 = 11.0;
/// Pixels within which the line between picture and reference is hit.
const LINE: f32 = 6.0;

/// Spheres that are drawn, at most.
const MOST: usize = 4096;

const AXES: [Color32; 3] =
    [Color32::from_rgb(240, 90, 80), Color32::from_rgb(120, 210, 90), Color32::from_rgb(90, 150, 255)];
const CHOSEN: Color32 = Color32::from_rgb(255, 210, 80);

/// The picture on the screen.
#[derive(Default)]
pub(crate) struct Stage {
    picture: Option<Plate>,
    reference: Option<TextureHandle>,
}

/// The texture of the picture.
enum Plate {
    /// It was uploaded.
    Uploaded(TextureHandle),
    /// It was made on the window's GPU.
    OnGpu(TextureId),
}

impl Plate {
    fn id(&self) -> TextureId {
        match self {
            Self::Uploaded(texture) => texture.id(),
            Self::OnGpu(id) => *id,
        }
    }
}

impl Stage {
    /// Takes a new print.
    pub(crate) fn take(&mut self, context: &Context, print: &Print, screen: Option<&mut Screen>) {
        // Pixels stay pixels: they are what is looked at.
        let options = TextureOptions::LINEAR;
        let put = |texture: &mut Option<TextureHandle>, image: &std::sync::Arc<_>, name: &str| match texture {
            Some(texture) => texture.set(std::sync::Arc::clone(image), options),
            None => *texture = Some(context.load_texture(name, std::sync::Arc::clone(image), options)),
        };
        match (&print.image, screen) {
            (Sheet::OnGpu(texture), Some(screen)) => self.picture = Some(Plate::OnGpu(screen.put(texture))),
            (Sheet::OnGpu(_), None) => {}
            (Sheet::Uploaded(image), _) => {
                let mut texture = match self.picture.take() {
                    Some(Plate::Uploaded(texture)) => Some(texture),
                    _ => None,
                };
                put(&mut texture, image, "picture");
                self.picture = texture.map(Plate::Uploaded);
            }
        }
        match &print.reference {
            Some(image) => put(&mut self.reference, image, "reference"),
            None => self.reference = None,
        }
    }

    pub(crate) fn show(&mut self, ui: &mut Ui, desk: &mut Desk) {
        let room = ui.available_rect_before_wrap();
        let rect = fitted(desk.editor.picture().scene.size, room);
        let response = ui.allocate_rect(room, Sense::click_and_drag());
        let painter = ui.painter_at(room);
        let Some(picture) = &self.picture else {
            painter.text(
                room.center(),
                Align2::CENTER_CENTER,
                "The first picture comes …",
                FontId::proportional(16.0),
                Color32::GRAY,
            );
            return;
        };
        let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
        painter.image(picture.id(), rect, whole, Color32::WHITE);
        if let Some(split) = desk.viewing.split {
            self.show_reference(&painter, rect, split);
        }
        let hands = Hands { projection: desk.projection(glam(rect.size())), rect, room: room.shrink(16.0) };
        hands.follow(ui, &response, desk);
        hands.draw(&painter, &response, desk);
    }

    fn show_reference(&self, painter: &Painter, rect: Rect, split: f32) {
        let x = rect.left() + split * rect.width();
        if let Some(reference) = &self.reference {
            let left = Rect::from_min_max(rect.min, pos2(x, rect.bottom()));
            painter.image(reference.id(), left, Rect::from_min_max(pos2(0.0, 0.0), pos2(split, 1.0)), Color32::WHITE);
        }
        painter.vline(x, rect.y_range(), Stroke::new(2.0, CHOSEN));
        painter.circle_filled(pos2(x, rect.center().y), 6.0, CHOSEN);
        let text = if self.reference.is_some() { "reference" } else { "reference …" };
        label(painter, pos2(x - 8.0, rect.top() + 8.0), Align2::RIGHT_TOP, text);
        label(painter, pos2(x + 8.0, rect.top() + 8.0), Align2::LEFT_TOP, "lobes");
    }
}

fn label(painter: &Painter, at: Pos2, anchor: Align2, text: &str) {
    let galley = painter.layout_no_wrap(text.to_owned(), FontId::proportional(13.0), Color32::WHITE);
    let place = anchor.anchor_size(at, galley.size());
    painter.rect_filled(place.expand(3.0), 3.0, Color32::from_black_alpha(150));
    painter.galley(place.min, galley, Color32::WHITE);
}

fn glam(v: eframe::egui::Vec2) -> Vec2 {
    Vec2::new(v.x, v.y)
}

/// The largest place for a picture of this size.
fn fitted(size: [u32; 2], room: Rect) -> Rect {
    let size = vec2(size[0].max(1) as f32, size[1].max(1) as f32);
    let scale = (room.width() / size.x).min(room.height() / size.y);
    Rect::from_center_size(room.center(), size * scale)
}

/// The pointer and the handles before the picture.
struct Hands {
    projection: Projection,
    rect: Rect,
    /// The marks of lights stay in here.
    room: Rect,
}

impl Hands {
    /// A place on the screen as the projection has it.
    fn local(&self, pos: Pos2) -> Vec2 {
        glam(pos - self.rect.min)
    }

    fn screen(&self, pixel: Vec2) -> Pos2 {
        self.rect.min + vec2(pixel.x, pixel.y)
    }

    fn handles(&self, desk: &Desk) -> Option<Handles> {
        match desk.selected? {
            Thing::Light(handle) => {
                let item = desk.editor.light(handle).filter(|item| !item.is_animated)?;
                let center = lamp::center(&item.light)?;
                let handles = Handles::new(self.projection, center).with_direction(lamp::direction(&item.light));
                Some(handles.with_size(lamp::size(&item.light)))
            }
            Thing::Object(handle) => {
                // Who looks into a pixel of the floor does not mean to move it.
                let can_move = |item: &&ObjectItem| !item.is_animated && item.visible && !item.is_backdrop;
                let item = desk.editor.object(handle).filter(can_move)?;
                Some(Handles::new(self.projection, item.bounds.center()))
            }
        }
    }

    /// Where the mark of a light is; of one outside the room at its edge.
    fn place_of(&self, light: &Light) -> Option<Pos2> {
        Some(self.room.clamp(self.screen(self.projection.pixel(lamp::center(light)?)?)))
    }

    /// The light whose mark is under the pointer.
    fn mark(&self, desk: &Desk, pointer: Vec2) -> Option<Thing> {
        let lights = desk.editor.scene().lights.iter();
        let near = lights.filter_map(|item| {
            let place = self.local(self.place_of(&item.light)?);
            Some((Thing::Light(item.handle), place.distance(pointer)))
        });
        let nearest = near.min_by(|a, b| a.1.total_cmp(&b.1));
        nearest.filter(|(_, distance)| *distance <= MARK).map(|(thing, _)| thing)
    }

    fn is_on_line(&self, desk: &Desk, pointer: Vec2) -> bool {
        desk.viewing.split.is_some_and(|split| (pointer.x - split * self.rect.width()).abs() <= LINE)
    }

    fn follow(&self, ui: &Ui, response: &Response, desk: &mut Desk) {
        self.begin(ui, response, desk);
        self.go_on(ui, response, desk);
        if response.drag_stopped() {
            match desk.motion.take() {
                Some(Motion::Split) | None => {}
                Some(_) => desk.close_step(),
            }
        }
        if response.clicked()
            && let Some(pointer) = response.interact_pointer_pos()
        {
            self.click(desk, self.local(pointer), pointer);
        }
        if response.hovered() {
            self.zoom(ui, desk);
        }
    }

    fn begin(&self, ui: &Ui, response: &Response, desk: &mut Desk) {
        if !response.drag_started() {
            return;
        }
        desk.editor.close_step();
        let Some(from) = ui.input(|input| input.pointer.press_origin()).map(|pos| self.local(pos)) else { return };
        let camera = desk.editor.scene().camera;
        let is_first = response.drag_started_by(PointerButton::Primary);
        if !is_first || ui.input(|input| input.modifiers.shift) {
            desk.motion = Some(Motion::Pan(camera, from));
            return;
        }
        let grip = self.handles(desk).and_then(|handles| Some((handles, handles.hit(from)?)));
        desk.motion = Some(match (grip, desk.selected) {
            _ if self.is_on_line(desk, from) => Motion::Split,
            (Some((handles, grip)), Some(thing)) => self.take(desk, thing, handles, (grip, from)),
            _ => match self.mark(desk, from) {
                // A light is dragged at once, without being chosen before.
                Some(thing) => {
                    desk.selected = Some(thing);
                    match self.handles(desk) {
                        // One whose mark is at the edge comes under the pointer.
                        Some(handles) => {
                            let middle = handles.middle().filter(|middle| middle.distance(from) > MARK);
                            self.take(desk, thing, handles, (Grip::Middle, middle.unwrap_or(from)))
                        }
                        None => Motion::Orbit(camera, from),
                    }
                }
                None => Motion::Orbit(camera, from),
            },
        });
    }

    fn take(&self, desk: &Desk, thing: Thing, handles: Handles, (grip, from): (Grip, Vec2)) -> Motion {
        let drag = handles.drag(grip, from);
        let before = match thing {
            Thing::Light(handle) => {
                desk.editor.light(handle).map(|item| Motion::Light(handle, Box::new(item.light.clone()), drag))
            }
            Thing::Object(handle) => {
                desk.editor.object(handle).map(|item| Motion::Object(handle, item.transform, drag))
            }
        };
        before.unwrap_or(Motion::Orbit(*self.projection.camera(), from))
    }

    /// Also in the frame that the button is released in: a slow frame holds the last moves as well, which are not a drag to egui.
    fn go_on(&self, ui: &Ui, response: &Response, desk: &mut Desk) {
        let Some(pointer) = response.interact_pointer_pos() else { return };
        if ui.input(|input| input.pointer.delta()) == eframe::egui::Vec2::ZERO {
            return;
        }
        match &desk.motion {
            Some(Motion::Orbit(before, from)) => {
                let camera = orbited(*before, (self.local(pointer) - *from) * (TURN / self.rect.height()));
                desk.set_camera(camera);
            }
            Some(Motion::Pan(before, from)) => {
                let camera = panned(*before, glam(self.rect.size()), self.local(pointer) - *from);
                desk.set_camera(camera);
            }
            Some(Motion::Split) => {
                let split = (pointer.x - self.rect.left()) / self.rect.width();
                desk.viewing.split = Some(split.clamp(0.02, 0.98));
            }
            Some(Motion::Light(..) | Motion::Object(..)) => desk.drag_to(self.local(pointer)),
            None => {}
        }
    }

    fn click(&self, desk: &mut Desk, local: Vec2, pointer: Pos2) {
        if let Some(thing) = self.mark(desk, local) {
            desk.selected = Some(thing);
            return;
        }
        if !self.rect.contains(pointer) {
            (desk.selected, desk.probed) = (None, None);
            return;
        }
        let size = desk.editor.scene().size;
        let place = local / glam(self.rect.size());
        let pixel = [place.x * size[0] as f32, place.y * size[1] as f32];
        let last = size.map(|side| side.saturating_sub(1));
        desk.look_into([(pixel[0] as u32).min(last[0]), (pixel[1] as u32).min(last[1])]);
    }

    fn zoom(&self, ui: &Ui, desk: &mut Desk) {
        let (scroll, pinch) = ui.input(|input| (input.smooth_scroll_delta().y, input.zoom_delta()));
        if scroll == 0.0 && pinch == 1.0 {
            // The wheel rests: what it did so far is a step.
            if core::mem::take(&mut desk.is_zooming) {
                desk.close_step();
            }
            return;
        }
        desk.is_zooming = true;
        // The frame in which it rests comes too.
        ui.ctx().request_repaint();
        let factor = (-0.002 * scroll).exp() / pinch;
        let camera = zoomed(desk.editor.scene().camera, factor);
        desk.set_camera(camera);
    }

    fn draw(&self, painter: &Painter, response: &Response, desk: &Desk) {
        for item in &desk.editor.scene().lights {
            let is_chosen = desk.selected == Some(Thing::Light(item.handle));
            self.draw_light(painter, &item.light, is_chosen);
        }
        if let Some(Thing::Object(handle)) = desk.selected
            && let Some(item) = desk.editor.object(handle).filter(|item| !item.is_backdrop)
        {
            self.draw_box(painter, item.bounds);
        }
        if desk.shows_spheres {
            self.draw_spheres(painter, desk);
        }
        let pointer = response.hover_pos().map(|pos| self.local(pos));
        let handles = self.handles(desk);
        let hovered = match &desk.motion {
            Some(Motion::Light(_, _, drag) | Motion::Object(_, _, drag)) => Some(drag.grip()),
            Some(_) => None,
            None => handles.zip(pointer).and_then(|(handles, pointer)| handles.hit(pointer)),
        };
        if let Some(handles) = handles {
            self.draw_handles(painter, &handles, hovered);
        }
        if let Some((pixel, probe)) = &desk.probed {
            self.draw_outlines(painter, probe);
            self.draw_pixel(painter, *pixel, desk.editor.picture().scene.size);
        }
        let is_on_line = pointer.is_some_and(|pointer| self.is_on_line(desk, pointer));
        let is_on_mark = pointer.is_some_and(|pointer| self.mark(desk, pointer).is_some());
        let cursor = match &desk.motion {
            Some(Motion::Pan(..)) => CursorIcon::Move,
            Some(Motion::Orbit(..)) => CursorIcon::Grabbing,
            Some(Motion::Split) => CursorIcon::ResizeHorizontal,
            None if is_on_line => CursorIcon::ResizeHorizontal,
            _ if hovered.is_some() || is_on_mark => CursorIcon::Grab,
            _ => CursorIcon::Crosshair,
        };
        if response.hovered() || response.dragged() {
            painter.ctx().set_cursor_icon(cursor);
        }
    }

    /// A small lamp: a disc of the light's colour with rays.
    fn draw_light(&self, painter: &Painter, light: &Light, is_chosen: bool) {
        let Some(at) = self.place_of(light) else { return };
        let radiance = light.full_radiance();
        let hue = radiance / radiance.max_element().max(f32::MIN_POSITIVE);
        let [r, g, b] = (255.0 * hue.powf(1.0 / 2.2)).to_array().map(|c| c as u8);
        let fill = if radiance == Vec3::ZERO { Color32::from_gray(60) } else { Color32::from_rgb(r, g, b) };
        let edge = if is_chosen { CHOSEN } else { Color32::from_black_alpha(220) };
        for k in 0..8 {
            let turn =
                vec2((k as f32 * std::f32::consts::FRAC_PI_4).cos(), (k as f32 * std::f32::consts::FRAC_PI_4).sin());
            painter.line_segment([at + 7.0 * turn, at + 11.0 * turn], Stroke::new(3.0, Color32::from_black_alpha(160)));
            painter.line_segment([at + 7.5 * turn, at + 10.5 * turn], Stroke::new(1.5, fill));
        }
        painter.circle(at, 5.5, fill, Stroke::new(1.5, edge));
    }

    /// The outlines of the spheres that block light, those of the selected object before the others.
    fn draw_spheres(&self, painter: &Painter, desk: &Desk) {
        let scene = desk.editor.scene();
        let chosen = scene.objects.iter().position(|item| desk.selected == Some(Thing::Object(item.handle)));
        let is_chosen = |object: u32| chosen == Some(object as usize);
        let set = &desk.spheres.1;
        let mut all: Vec<_> = set.spheres.iter().zip(&set.objects).collect();
        all.sort_by_key(|(_, object)| is_chosen(**object));
        for (sphere, object) in all.into_iter().rev().take(MOST).rev() {
            let outline = self.projection.sphere_outline(sphere.center, sphere.radius, 40);
            let color = if is_chosen(*object) { CHOSEN } else { Color32::from_rgb(90, 220, 230).gamma_multiply(0.5) };
            let places = outline.into_iter().map(|pixel| self.screen(pixel)).collect();
            painter.add(Shape::closed_line(places, Stroke::new(1.0, color)));
        }
    }

    fn draw_box(&self, painter: &Painter, bounds: Bounds) {
        if bounds.is_empty() {
            return;
        }
        let corner = |i: usize| {
            let pick = |k: usize| if i >> k & 1 == 0 { bounds.min[k] } else { bounds.max[k] };
            self.projection.pixel(Vec3::new(pick(0), pick(1), pick(2))).map(|pixel| self.screen(pixel))
        };
        for i in 0..8_usize {
            for k in [1, 2, 4].into_iter().filter(|k| i & k == 0) {
                if let (Some(a), Some(b)) = (corner(i), corner(i | k)) {
                    painter.line_segment([a, b], Stroke::new(1.0, CHOSEN.gamma_multiply(0.6)));
                }
            }
        }
    }

    fn draw_handles(&self, painter: &Painter, handles: &Handles, hovered: Option<Grip>) {
        let Some(middle) = handles.middle().map(|pixel| self.screen(pixel)) else { return };
        let width = |grip| if hovered == Some(grip) { 4.0 } else { 2.0 };
        if let Some(radius) = handles.circle() {
            painter.circle_stroke(middle, radius, Stroke::new(width(Grip::Size), CHOSEN.gamma_multiply(0.9)));
        }
        for (axis, tip) in handles.tips().into_iter().enumerate() {
            let Some(tip) = tip.map(|pixel| self.screen(pixel)) else { continue };
            let stroke = Stroke::new(width(Grip::Axis(axis)), AXES[axis]);
            let along = (tip - middle).normalized();
            painter.line_segment([middle + 0.25 * (tip - middle), tip - 8.0 * along], stroke);
            let beside = along.rot90();
            let head = vec![tip, tip - 11.0 * along + 4.5 * beside, tip - 11.0 * along - 4.5 * beside];
            painter.add(Shape::convex_polygon(head, AXES[axis], Stroke::NONE));
        }
        if let Some(aim) = handles.aim().map(|pixel| self.screen(pixel)) {
            painter.line_segment([middle, aim], Stroke::new(1.0, CHOSEN.gamma_multiply(0.7)));
            painter.circle(aim, width(Grip::Aim) + 3.0, CHOSEN, Stroke::new(1.0, Color32::BLACK));
        }
        painter.circle_stroke(middle, 8.0, Stroke::new(width(Grip::Middle), Color32::WHITE));
    }

    /// The edges that shadow the pixel which is looked into, as far as they are before its lights.
    fn draw_outlines(&self, painter: &Painter, probe: &Probe) {
        let lines = probe.lights.iter().flat_map(|part| &part.outlines).take(MOST);
        for outline in lines {
            if let [Some(a), Some(b)] = outline.ends.map(|end| self.projection.pixel(end)) {
                painter.line_segment([self.screen(a), self.screen(b)], Stroke::new(1.5, OUTLINE));
            }
        }
    }

    /// A cross with a gap, which leaves the pixel itself to be seen.
    fn draw_pixel(&self, painter: &Painter, pixel: [u32; 2], size: [u32; 2]) {
        let part = vec2((pixel[0] as f32 + 0.5) / size[0] as f32, (pixel[1] as f32 + 0.5) / size[1] as f32);
        let at = self.rect.min + part * self.rect.size();
        for (width, color) in [(3.0, Color32::from_black_alpha(180)), (1.0, Color32::WHITE)] {
            for turn in [vec2(1.0, 0.0), vec2(-1.0, 0.0), vec2(0.0, 1.0), vec2(0.0, -1.0)] {
                painter.line_segment([at + 4.0 * turn, at + 13.0 * turn], Stroke::new(width, color));
            }
        }
    }
}
