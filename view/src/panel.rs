//! The panel beside the picture.

use crate::darkroom::Figures;
use crate::desk::{Desk, Thing};
use crate::viewing::View;
use crate::{shot, trade};
use core::ops::RangeInclusive;
use cosine_lobes::ToneMap;
use cosine_lobes::glam::{Mat4, Quat, Vec3};
use cosine_lobes::lighting::Light;
use cosine_lobes::renderer::{Device, LightHandle, Method, PixelSamples, Settings};
use cosine_lobes::scene::Strategy;
use cosine_lobes::session::{LightItem, NewLight, ObjectItem, Primitive, gloss, lamp, projected};
use cosine_lobes::shading::Accuracy;
use eframe::egui::emath::Numeric;
use eframe::egui::{
    Button, CollapsingHeader, Color32, ComboBox, Grid, Response, RichText, ScrollArea, Slider, SliderClamping, Ui,
};

pub(crate) fn show(ui: &mut Ui, desk: &mut Desk, figures: Option<&Figures>, message: &mut Option<String>) {
    tools(ui, desk, message);
    ui.separator();
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        ui.spacing_mut().slider_width = 150.0;
        section(ui, "View", true, |ui| view(ui, desk, figures));
        section(ui, "Speed and accuracy", true, |ui| settings(ui, desk));
        section(ui, "Lights", true, |ui| lights(ui, desk));
        section(ui, "Objects", true, |ui| objects(ui, desk));
        section(ui, "Error against time", false, |ui| trade::show(ui, desk));
        section(ui, "Times", false, |ui| times(ui, desk));
    });
}

fn section(ui: &mut Ui, name: &str, is_open: bool, body: impl FnOnce(&mut Ui)) {
    CollapsingHeader::new(RichText::new(name).strong()).default_open(is_open).show(ui, body);
}

fn tools(ui: &mut Ui, desk: &mut Desk, message: &mut Option<String>) {
    ui.add_space(4.0);
    ui.horizontal(|ui| {
        let [undo, redo] = desk.editor.scene().steps;
        let mut button = |name: &str, keys: &str, is_on: bool| {
            ui.add_enabled(is_on, Button::new(name)).on_hover_text(keys.to_owned()).clicked()
        };
        if button("Undo", "Ctrl+Z", undo > 0) {
            desk.undo();
        }
        if button("Redo", "Ctrl+Shift+Z", redo > 0) {
            desk.redo();
        }
        if button("Save", "Ctrl+S: writes the changes into the scene file; its comments stay", desk.path.is_some()) {
            *message = Some(desk.save());
        }
        if button("Frame all", "F", true) {
            desk.frame_all();
        }
        if button("Screenshot", "F12", true) {
            *message = Some(shot::take(ui.ctx(), desk.path.as_deref()));
        }
    });
}

/// Lights that have a view of their own, at most.
pub(crate) const LIGHTS: usize = 16;

/// A slider that leaves its value as it is until it is moved: by itself it would round it, and bring it into its range.
fn slider<N: Numeric>(value: &mut N, range: RangeInclusive<N>) -> Slider<'_> {
    Slider::new(value, range).clamping(SliderClamping::Edits)
}

/// Closes the step once a slider rests.
fn rests(response: &Response, desk: &mut Desk) {
    if response.drag_stopped() || response.changed() && !response.dragged() {
        desk.close_step();
    }
}

fn view(ui: &mut Ui, desk: &mut Desk, figures: Option<&Figures>) {
    let lights = desk.editor.scene().lights.len();
    let list = ComboBox::from_id_salt("view").selected_text(desk.viewing.view.name()).width(220.0);
    let shown = list.show_ui(ui, |ui| {
        for view in View::ALL {
            ui.selectable_value(&mut desk.viewing.view, view, view.name());
        }
        for number in 0..lights.min(LIGHTS) {
            let view = View::Light(number);
            ui.selectable_value(&mut desk.viewing.view, view, view.name());
        }
    });
    shown.response.on_hover_text("V: the next one; Shift+V: the one before");
    let legend = desk.viewing.view.legend();
    if !legend.is_empty() {
        ui.label(RichText::new(legend).weak());
    }
    let mut is_split = desk.viewing.split.is_some();
    if ui.checkbox(&mut is_split, "reference beside it").on_hover_text("R; drag the line").changed() {
        desk.viewing.split = is_split.then_some(0.5);
    }
    let spheres = ui.checkbox(&mut desk.shows_spheres, "spheres that block");
    spheres.on_hover_text("those of all objects whose shadows are by spheres; yellow: the selected object's");
    let map = ui.checkbox(&mut desk.maps.is_shown, "shadow map");
    map.on_hover_text("the depths that the selected light's shadow map has, layer by layer");
    ui.horizontal(|ui| {
        let range = desk.metered - 8.0..=desk.metered + 8.0;
        ui.add(slider(&mut desk.viewing.display.exposure, range).step_by(0.1).text("exposure"));
        if ui.small_button("meter").clicked() {
            desk.meter();
        }
    });
    ui.horizontal(|ui| {
        ui.label("tone");
        let tones = [ToneMap::Linear, ToneMap::Soft, ToneMap::Neutral, ToneMap::Agx];
        for (tone, name) in tones.into_iter().zip(["linear", "soft", "neutral", "AgX"]) {
            ui.selectable_value(&mut desk.viewing.display.tone, tone, name);
        }
    });
    if desk.viewing.wants_reference() {
        show_figures(ui, desk, figures);
    }
}

/// With fewer samples the noise of the reference hides all else.
const ENOUGH: u32 = 64;

fn show_figures(ui: &mut Ui, desk: &Desk, figures: Option<&Figures>) {
    let Some(Figures { samples, all, shadows }) = figures else {
        let is_ready = desk.editor.is_finished();
        ui.label(RichText::new(if is_ready { "The reference comes …" } else { "The picture comes first …" }).weak());
        return;
    };
    if *samples < ENOUGH {
        let text = format!("The reference has {samples} samples; figures come from {ENOUGH} on.");
        ui.label(RichText::new(text).weak());
        return;
    }
    let percent = |value: f64| format!("{:.3} %", 100.0 * value);
    Grid::new("figures").num_columns(4).striped(true).show(ui, |ui| {
        for name in ["error", "mean", "p99", "largest"] {
            ui.label(RichText::new(name).weak());
        }
        ui.end_row();
        let regions =
            [("penumbra", shadows.penumbra), ("lit", shadows.lit), ("dark", shadows.dark), ("of itself", all.own)];
        for (name, region) in regions {
            ui.label(name).on_hover_text("as parts of the unshadowed luminance; the last row: of the pixel's own");
            ui.label(percent(region.mean));
            ui.label(percent(region.p99));
            ui.label(percent(region.max));
            ui.end_row();
        }
    });
    ui.label(RichText::new(format!("{samples} samples of the reference, whose noise is part of this")).weak());
}

fn settings(ui: &mut Ui, desk: &mut Desk) {
    let before = desk.editor.scene().settings.clone();
    let mut now = before.clone();
    let mut percent = 100.0 * now.accuracy.tolerance;
    let tolerance = slider(&mut percent, 0.05..=5.0).logarithmic(true).suffix(" %").text("tolerance");
    let response = ui.add(tolerance).on_hover_text("the error that shadows may have; more is faster");
    if response.changed() {
        now.accuracy = Accuracy::new(percent / 100.0);
    }
    method(ui, &mut now);
    strategy(ui, "shadows by", "all", &mut now.strategy, "as each object says");
    device(ui, desk, &mut now);
    let mut samples = now.samples.most();
    let rays = ui.add(slider(&mut samples, 1..=16).logarithmic(true).text("rays a pixel on outlines"));
    if rays.changed() {
        now.samples = PixelSamples::Edges(samples);
    }
    let is_changed = now.accuracy != before.accuracy
        || now.method != before.method
        || now.strategy != before.strategy
        || now.device != before.device
        || now.samples != before.samples;
    if is_changed {
        desk.editor.set_settings(now);
    }
    rests(&response, desk);
    rests(&rays, desk);
    size(ui, desk);
    projection(ui, desk);
}

fn method(ui: &mut Ui, now: &mut Settings) {
    let name = |method| match method {
        Method::Moments => "visible fractions (default)",
        Method::Lobes => "visibility as lobes",
        Method::Paper => "as the paper prints it",
        _ => "another",
    };
    ComboBox::from_label("method").selected_text(name(now.method)).width(180.0).show_ui(ui, |ui| {
        for method in [Method::Moments, Method::Lobes, Method::Paper] {
            ui.selectable_value(&mut now.method, method, name(method));
        }
    });
}

fn strategy(ui: &mut Ui, label: &str, salt: &str, strategy: &mut Option<Strategy>, none: &str) {
    let name = strategy.map_or(none, |strategy| strategy.name());
    ui.horizontal(|ui| {
        ComboBox::from_id_salt(("strategy", salt)).selected_text(name).width(180.0).show_ui(ui, |ui| {
            ui.selectable_value(strategy, None, none);
            for one in Strategy::ALL {
                ui.selectable_value(strategy, Some(one), one.name());
            }
        });
        ui.label(label);
    });
}

fn device(ui: &mut Ui, desk: &Desk, now: &mut Settings) {
    let name = |device| if device == Device::Gpu { "GPU" } else { "CPU" };
    ui.horizontal(|ui| {
        ComboBox::from_id_salt("device").selected_text(name(now.device)).width(180.0).show_ui(ui, |ui| {
            for device in [Device::Cpu, Device::Gpu] {
                ui.selectable_value(&mut now.device, device, name(device));
            }
        });
        ui.label("device").on_hover_text(desk.editor.scene().device.clone());
    });
}

fn projection(ui: &mut Ui, desk: &mut Desk) {
    let camera = desk.editor.scene().camera;
    let now = camera.projection.name();
    ui.horizontal(|ui| {
        ComboBox::from_id_salt("projection").selected_text(now).width(180.0).show_ui(ui, |ui| {
            for name in ["perspective", "orthographic", "panoramic"] {
                if ui.selectable_label(name == now, name).clicked() {
                    desk.set_camera(projected(camera, name));
                    desk.close_step();
                }
            }
        });
        ui.label("camera");
    });
}

fn size(ui: &mut Ui, desk: &mut Desk) {
    let [width, height] = desk.editor.scene().size;
    let first = desk.first_size;
    ui.horizontal(|ui| {
        ComboBox::from_id_salt("size").selected_text(format!("{width} × {height}")).width(180.0).show_ui(ui, |ui| {
            for (parts, whole) in [(1, 4), (1, 2), (2, 3), (1, 1), (2, 1)] {
                let size = first.map(|side| (side * parts / whole).max(1));
                if ui.selectable_label(size == [width, height], format!("{} × {}", size[0], size[1])).clicked() {
                    desk.editor.set_size(size);
                    desk.close_step();
                }
            }
        });
        ui.label("pixels");
    });
}

fn lights(ui: &mut Ui, desk: &mut Desk) {
    let items: Vec<LightItem> = desk.editor.scene().lights.clone();
    if items.is_empty() {
        ui.label(RichText::new("There is no light: the picture is black.").weak());
    }
    let sky = items.iter().filter(|item| matches!(item.light, Light::Sky(_))).count();
    for (number, item) in items.iter().enumerate().filter(|(_, item)| !matches!(item.light, Light::Sky(_))) {
        ui.horizontal(|ui| {
            let mut is_on = item.light.full_radiance() != Vec3::ZERO;
            let can_switch = lamp::has_radiance(&item.light) && !item.is_animated;
            if ui
                .add_enabled(can_switch, eframe::egui::Checkbox::without_text(&mut is_on))
                .on_hover_text("on or off")
                .changed()
            {
                desk.switch(item.handle);
            }
            let thing = Thing::Light(item.handle);
            let moves = if item.is_animated { " (moves)" } else { "" };
            let name = format!("{number} {}{moves}", item.light.name());
            if ui.selectable_label(desk.selected == Some(thing), name).clicked() {
                desk.selected = Some(thing);
            }
        });
        if desk.selected == Some(Thing::Light(item.handle)) {
            ui.indent(("light", number), |ui| light(ui, desk, item.handle, &item.light, item.is_animated));
        }
    }
    if sky > 0 {
        ui.label(RichText::new(format!("an environment of {sky} lights")).weak());
    }
    ui.menu_button("Add a light", |ui| {
        for kind in NewLight::ALL {
            if ui.button(kind.name()).clicked() {
                desk.add_light(kind);
                ui.close();
            }
        }
    });
}

/// A button that removes the selected thing.
fn remove(ui: &mut Ui, desk: &mut Desk, hint: &str) {
    if ui.button("Remove").on_hover_text(format!("Shift+Delete; {hint}")).clicked() {
        desk.remove();
    }
}

fn light(ui: &mut Ui, desk: &mut Desk, handle: LightHandle, before: &Light, is_animated: bool) {
    if is_animated {
        ui.label(RichText::new("The animation moves it: it cannot be changed here.").weak());
        return;
    }
    if let Some(mut size) = lamp::size(before) {
        let (range, name) = match before {
            Light::Sun(_) => (0.001..=0.8, "half-angle"),
            _ => (1e-3 * desk.extent..=desk.extent, "size"),
        };
        let slider = slider(&mut size, range).logarithmic(true).text(name);
        let response = ui.add(slider).on_hover_text("its power stays the same");
        if response.changed() {
            desk.editor.set_light(handle, lamp::resized(before, size));
        }
        rests(&response, desk);
    }
    let radiance = before.full_radiance();
    let mut most = radiance.max_element();
    if most > 0.0 && lamp::has_radiance(before) {
        let slider = slider(&mut most, 1e-2..=1e5).logarithmic(true).text("radiance");
        let response = ui.add(slider);
        if response.changed() {
            desk.editor.set_light(handle, lamp::with_radiance(before, radiance * (most / radiance.max_element())));
        }
        rests(&response, desk);
        let mut hue = (radiance / radiance.max_element()).to_array();
        ui.horizontal(|ui| {
            let response = ui.color_edit_button_rgb(&mut hue);
            ui.label("colour");
            if response.changed() {
                let color = Vec3::from_array(hue).max(Vec3::splat(1e-3));
                desk.editor.set_light(
                    handle,
                    lamp::with_radiance(before, color * (radiance.max_element() / color.max_element())),
                );
            }
        });
    }
    if let Some(direction) = lamp::direction(before) {
        aim(ui, desk, handle, before, direction);
    }
    remove(ui, desk, "a light of an object that shines comes back with the file: remove the object");
}

/// Sliders for the direction in which a light shines.
fn aim(ui: &mut Ui, desk: &mut Desk, handle: LightHandle, before: &Light, direction: Vec3) {
    let mut lift = direction.y.clamp(-1.0, 1.0).asin().to_degrees();
    let mut turn = direction.x.atan2(direction.z).to_degrees();
    let around = ui.add(slider(&mut turn, -180.0..=180.0).suffix("°").fixed_decimals(0).text("around"));
    let upward = ui.add(slider(&mut lift, -89.0..=89.0).suffix("°").fixed_decimals(0).text("upward"));
    if around.changed() || upward.changed() {
        let (lift, turn) = (lift.to_radians(), turn.to_radians());
        let toward = Vec3::new(lift.cos() * turn.sin(), lift.sin(), lift.cos() * turn.cos());
        desk.editor.set_light(handle, lamp::aimed(before, toward));
    }
    rests(&around, desk);
    rests(&upward, desk);
}

fn objects(ui: &mut Ui, desk: &mut Desk) {
    let items: Vec<ObjectItem> = desk.editor.scene().objects.clone();
    let mut list = |ui: &mut Ui| {
        for item in &items {
            ui.horizontal(|ui| {
                let mut is_shown = item.visible || item.taken != Strategy::None;
                let name = if item.name.is_empty() { "–" } else { &item.name };
                if ui.checkbox(&mut is_shown, "").on_hover_text("shown, and blocks light").changed() {
                    desk.show(item.handle, is_shown);
                }
                let thing = Thing::Object(item.handle);
                if ui.selectable_label(desk.selected == Some(thing), name).clicked() {
                    desk.selected = Some(thing);
                }
            });
            if desk.selected == Some(Thing::Object(item.handle)) {
                ui.indent(("object", item.handle), |ui| object(ui, desk, item));
            }
        }
    };
    match items.len() > 12 {
        true => drop(ScrollArea::vertical().id_salt("objects").max_height(260.0).show(ui, list)),
        false => list(ui),
    }
    ui.menu_button("Add an object", |ui| {
        let around = desk.editor.scene().bounds();
        for primitive in [Primitive::sphere_on(around), Primitive::box_on(around)] {
            if ui.button(primitive.to_string()).clicked() {
                desk.add_object(primitive);
                ui.close();
            }
        }
    });
}

fn object(ui: &mut Ui, desk: &mut Desk, item: &ObjectItem) {
    let handle = item.handle;
    let mut chosen = item.strategy;
    let own = format!("by itself: {}", item.taken.name());
    strategy(ui, "shadow", "object", &mut chosen, &own);
    if chosen != item.strategy {
        desk.editor.set_strategy(handle, chosen);
        desk.close_step();
    }
    material(ui, desk, item);
    match item.is_animated {
        true => drop(ui.label(RichText::new("The animation moves it.").weak())),
        false => {
            place(ui, desk, item);
            remove(ui, desk, "with the lights that its material stands for");
        }
    }
}

fn material(ui: &mut Ui, desk: &mut Desk, item: &ObjectItem) {
    let Some(before) = desk.editor.scene().materials.get(item.material).cloned() else { return };
    let (handle, material) = (before.handle, &before.material);
    ui.label(RichText::new(format!("material {} ({})", item.material, material.name())).weak());
    if let Some(color) = gloss::color(material) {
        let mut rgb = color.to_array();
        ui.horizontal(|ui| {
            if ui.color_edit_button_rgb(&mut rgb).changed() {
                desk.editor.set_material(handle, gloss::with_color(material, Vec3::from_array(rgb)));
            }
            ui.label("colour");
        });
    }
    let (mut number, range, is_logarithmic, name) = match gloss::of(material) {
        Some(gloss::Gloss::Exponent(exponent)) => (exponent, 1.0..=10_000.0, true, "exponent"),
        Some(gloss::Gloss::Roughness(roughness)) => (roughness, 0.02..=1.0, false, "roughness"),
        None => return,
    };
    let response = ui.add(slider(&mut number, range).logarithmic(is_logarithmic).text(name));
    if response.changed() {
        desk.editor.set_material(handle, gloss::with(material, number));
    }
    rests(&response, desk);
}

/// Turns an object about the vertical through its middle, and scales it about that.
fn place(ui: &mut Ui, desk: &mut Desk, item: &ObjectItem) {
    let middle = item.bounds.center();
    let about = |m: Mat4| Mat4::from_translation(middle) * m * Mat4::from_translation(-middle) * item.transform;
    ui.horizontal(|ui| {
        for (name, degrees) in [("turn left", 15.0_f32), ("turn right", -15.0)] {
            if ui.button(name).clicked() {
                desk.editor
                    .set_transform(item.handle, about(Mat4::from_quat(Quat::from_rotation_y(degrees.to_radians()))));
                desk.close_step();
            }
        }
        for (name, factor) in [("larger", 1.1_f32), ("smaller", 1.0 / 1.1)] {
            if ui.button(name).clicked() {
                desk.editor.set_transform(item.handle, about(Mat4::from_scale(Vec3::splat(factor))));
                desk.close_step();
            }
        }
    });
}

fn times(ui: &mut Ui, desk: &Desk) {
    let picture = desk.editor.picture();
    let clocks = &picture.stats.clocks;
    let shading = picture.stats.shading.first().map_or(0.0, |stats| stats.seconds);
    let rows = [
        ("visible points", clocks.gbuffer),
        ("shading", shading),
        ("hierarchy", clocks.hierarchy),
        ("silhouettes", clocks.silhouettes),
        ("spheres", clocks.spheres),
        ("shadow maps", clocks.maps),
        ("pose", clocks.pose),
        ("kernels", picture.stats.kernels),
    ];
    let all = picture.seconds.max(1e-9);
    Grid::new("times").num_columns(2).show(ui, |ui| {
        for (name, seconds) in rows.into_iter().filter(|(_, seconds)| *seconds > 1e-5) {
            ui.label(name);
            let bar = eframe::egui::ProgressBar::new((seconds / all) as f32).text(format!("{:.2} ms", 1e3 * seconds));
            ui.add(bar.desired_width(170.0).fill(Color32::from_rgb(70, 90, 130)));
            ui.end_row();
        }
        ui.label(RichText::new("picture").strong());
        ui.label(format!("{:.2} ms", 1e3 * picture.seconds));
        ui.end_row();
        ui.label("event to picture");
        ui.label(format!("{:.2} ms", 1e3 * picture.latency));
        ui.end_row();
    });
}
