//! Why a pixel is as bright as it is: a small window beside it.

use crate::desk::Desk;
use crate::reflectance::Reflectance;
use cosine_lobes::glam::{Vec2, Vec3};
use cosine_lobes::luminance;
use cosine_lobes::renderer::{LightMask, MaskSample};
use cosine_lobes::session::{LightPart, Probe, Snapshot};
use eframe::egui::{
    Color32, ColorImage, Context, Grid, Image, RichText, ScrollArea, Stroke, TextureHandle, TextureOptions, Ui, Window,
    pos2, vec2,
};

/// Lights that are listed.
const MOST: usize = 8;
/// Masks that are drawn.
const MASKS: usize = 4;
/// The longer side of a mask, in points.
const SIDE: f32 = 130.0;

/// Outlines of blockers, here and before the picture.
pub(crate) const OUTLINE: Color32 = Color32::from_rgb(255, 90, 200);

/// The masks of the probe that is shown.
#[derive(Default)]
pub(crate) struct Inspector {
    probe: u64,
    masks: Vec<TextureHandle>,
    reflectance: Reflectance,
}

impl Inspector {
    pub(crate) fn show(&mut self, context: &Context, desk: &mut Desk) {
        let Some((pixel, probe)) = &desk.probed else { return };
        let scene = desk.editor.scene();
        let parts = by_weight(probe);
        if self.probe != desk.probes {
            self.probe = desk.probes;
            let draw = |(mask, hue): &(&LightMask, Vec3)| {
                context.load_texture("mask", picture(mask, *hue), TextureOptions::NEAREST)
            };
            self.masks = lights_of(scene, &parts).iter().map(draw).collect();
        }
        let drawn = lights_of(scene, &parts);
        let mut is_open = true;
        // Many lights make it longer than the screen.
        let room = context.content_rect().height() - 90.0;
        let mut body = |ui: &mut Ui| {
            surface(ui, scene, *pixel, probe);
            ui.separator();
            lights(ui, scene, &parts);
            ui.separator();
            ui.label(
                RichText::new("the lights as this point sees them; dark: hidden; lines: outlines of blockers").weak(),
            );
            ui.horizontal(|ui| {
                for ((number, part), texture) in parts.iter().zip(&self.masks) {
                    let Some(mask) = &part.mask else { continue };
                    ui.vertical(|ui| {
                        let sides = mask.sides / mask.sides.max_element().max(f32::MIN_POSITIVE);
                        let size = vec2(SIDE * sides.x.max(0.05), SIDE * sides.y.max(0.05));
                        let drawn = ui.add(Image::new((texture.id(), size)));
                        let on = |place: Vec2| drawn.rect.min + vec2(place.x * size.x, place.y * size.y);
                        for outline in &part.outlines {
                            ui.painter().line_segment(outline.places.map(on), Stroke::new(1.0, OUTLINE));
                        }
                        ui.label(format!("{number}: {:.1} % lit", 100.0 * mask.lit()));
                    });
                }
            });
            ui.separator();
            self.reflectance.show(ui, desk.probes, &probe.hemisphere, &drawn);
        };
        let window = Window::new("Pixel").open(&mut is_open).default_pos(pos2(34.0, 34.0)).resizable(false);
        window
            .show(context, |ui| ScrollArea::vertical().max_height(room).min_scrolled_height(room).show(ui, &mut body));
        if !is_open {
            desk.probed = None;
        }
    }
}

/// The masks that are drawn, with the hues of their lights as a screen shows them.
fn lights_of<'p>(scene: &Snapshot, parts: &[(usize, &'p LightPart)]) -> Vec<(&'p LightMask, Vec3)> {
    let one = |(number, part): &(usize, &'p LightPart)| {
        let radiance = scene.lights.get(*number).map_or(Vec3::ONE, |item| item.light.full_radiance());
        let hue = radiance / radiance.max_element().max(f32::MIN_POSITIVE);
        Some((part.mask.as_ref()?, hue.powf(1.0 / 2.2)))
    };
    parts.iter().take(MASKS).map_while(one).collect()
}

/// The lights and their numbers, those first that matter most: an environment has hundreds.
fn by_weight(probe: &Probe) -> Vec<(usize, &LightPart)> {
    let mut parts: Vec<_> = probe.lights.iter().enumerate().collect();
    if parts.len() > MASKS {
        parts.sort_by(|a, b| luminance(b.1.unshadowed).total_cmp(&luminance(a.1.unshadowed)));
    }
    parts
}

fn surface(ui: &mut Ui, scene: &Snapshot, [x, y]: [u32; 2], probe: &Probe) {
    let pick = &probe.pick;
    let object = scene.object(pick.object);
    let material = scene.materials.iter().find(|item| item.handle == pick.material);
    Grid::new("pixel").num_columns(2).show(ui, |ui| {
        let mut row = |name: &str, value: String| {
            ui.label(RichText::new(name).weak());
            ui.label(value);
            ui.end_row();
        };
        let none = || "–".to_owned();
        row("pixel", format!("{x}, {y}"));
        row("object", object.map_or_else(none, |item| item.name.clone()));
        row("material", material.map_or_else(none, |item| item.material.name().to_owned()));
        row("point", vector(pick.receiver.position));
        row("normal", vector(pick.receiver.normal));
        row("distance", format!("{:.3}", pick.distance));
        row("radiance", vector(probe.radiance));
        let [reference, error] = probe.reference;
        row("reference", format!("{} ± {:.4}", vector(reference), error.max_element()));
        row("difference", difference(probe.radiance, reference));
    });
}

fn lights(ui: &mut Ui, scene: &Snapshot, parts: &[(usize, &LightPart)]) {
    Grid::new("lights").num_columns(4).striped(true).spacing([14.0, 3.0]).show(ui, |ui| {
        let heads = [
            ("light", "its number and kind"),
            ("unshadowed", "luminance that it would add if nothing blocked it"),
            ("visible", "the fraction of it that a white diffuse surface sees here"),
            ("adds", "luminance that it adds to the pixel"),
        ];
        for (name, hint) in heads {
            ui.label(RichText::new(name).weak()).on_hover_text(hint);
        }
        ui.end_row();
        for (number, part) in parts.iter().take(MOST) {
            let name = scene.light(part.light).map_or("", |item| item.light.name());
            ui.label(format!("{number} {name}"));
            ui.label(format!("{:.4}", luminance(part.unshadowed)));
            ui.label(format!("{:.1} %", 100.0 * luminance(part.visible)));
            ui.label(format!("{:.4}", luminance(part.radiance)));
            ui.end_row();
        }
    });
    if parts.len() > MOST {
        ui.label(RichText::new(format!("and {} more", parts.len() - MOST)).weak());
    }
}

fn picture(mask: &LightMask, hue: Vec3) -> ColorImage {
    let [r, g, b] = (255.0 * hue).to_array().map(|c| c as u8);
    let color = |sample: &MaskSample| match sample {
        MaskSample::Outside => [38, 38, 42],
        MaskSample::Lit => [r, g, b],
        MaskSample::Blocked => [4, 6, 14],
    };
    let rgb: Vec<u8> = mask.samples.iter().flat_map(color).collect();
    ColorImage::from_rgb(mask.size, &rgb)
}

fn vector(v: Vec3) -> String {
    format!("{:.3}, {:.3}, {:.3}", v.x, v.y, v.z)
}

fn difference(radiance: Vec3, reference: Vec3) -> String {
    let (own, want) = (luminance(radiance), luminance(reference));
    if want > 0.0 { format!("{:+.2} %", 100.0 * (own / want - 1.0)) } else { format!("{:+.5}", own - want) }
}
