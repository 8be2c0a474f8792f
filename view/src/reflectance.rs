//! The hemisphere of a pixel that is taken apart: the lobes of its reflectance, and the lights on them.

use cosine_lobes::glam::{Vec2, Vec3};
use cosine_lobes::lobe_core::BrdfLobe;
use cosine_lobes::luminance;
use cosine_lobes::renderer::LightMask;
use cosine_lobes::session::{Hemisphere, HemispherePixel};
use eframe::egui::{
    Color32, ColorImage, ComboBox, Image, Painter, Pos2, Rect, RichText, Sense, Stroke, TextureHandle, TextureOptions,
    Ui, pos2, vec2,
};

/// The side of the disc, in points, and in pixels.
const SIDE: f32 = 170.0;
const PIXELS: usize = 340;
/// The width of the curves.
const WIDTH: f32 = 230.0;
/// Points of a curve.
const STEPS: usize = 361;
/// Lobes that are listed.
const MOST: usize = 12;
/// Colours of the curves of lobes.
const HUES: [Color32; 6] = [
    Color32::from_rgb(250, 190, 90),
    Color32::from_rgb(110, 190, 255),
    Color32::from_rgb(150, 230, 130),
    Color32::from_rgb(255, 130, 150),
    Color32::from_rgb(200, 160, 255),
    Color32::from_rgb(120, 225, 220),
];

/// The picture of the probe that is shown.
#[derive(Default)]
pub(crate) struct Reflectance {
    /// The number of the probe, and the lobe that is seen alone.
    shown: Option<(u64, Option<usize>)>,
    lobe: Option<usize>,
    picture: Option<TextureHandle>,
}

impl Reflectance {
    /// Draws the hemisphere of the probe of a number; `lights` are the masks that are drawn, with the hues of their lights.
    pub(crate) fn show(&mut self, ui: &mut Ui, probe: u64, all: &Hemisphere, lights: &[(&LightMask, Vec3)]) {
        if all.lobes().is_empty() {
            return;
        }
        self.lobe = self.lobe.filter(|lobe| *lobe < all.lobes().len());
        self.choose(ui, all);
        if self.shown != Some((probe, self.lobe)) {
            self.shown = Some((probe, self.lobe));
            let masks: Vec<&LightMask> = lights.iter().map(|(mask, _)| *mask).collect();
            let image = image(&all.picture(PIXELS, self.lobe, &masks), lights);
            self.picture = Some(ui.ctx().load_texture("hemisphere", image, TextureOptions::LINEAR));
        }
        ui.horizontal(|ui| {
            if let Some(picture) = &self.picture {
                let drawn = ui.add(Image::new((picture.id(), vec2(SIDE, SIDE))));
                draw_lights(ui.painter(), drawn.rect, all, lights);
                drawn.on_hover_text(
                    "the directions to light: the normal in the middle, the horizon at the rim, equal areas; bright where the \
                     surface reflects. Outlined: the lights, reddish where hidden. Ring: the eye. Cross: a mirror's reflection",
                );
            }
            self.curves(ui, all);
        });
    }

    fn choose(&mut self, ui: &mut Ui, all: &Hemisphere) {
        let name = |lobe: usize| format!("lobe {lobe}: {}", kind(&all.lobes()[lobe]));
        let shown = self.lobe.map_or_else(|| format!("all {} lobes", all.lobes().len()), name);
        ui.horizontal(|ui| {
            ComboBox::from_id_salt("lobe").selected_text(shown).width(190.0).show_ui(ui, |ui| {
                ui.selectable_value(&mut self.lobe, None, "all lobes");
                for lobe in 0..all.lobes().len().min(MOST) {
                    ui.selectable_value(&mut self.lobe, Some(lobe), name(lobe));
                }
            });
            ui.label(RichText::new("reflectance over the directions to light").weak());
        });
    }

    /// Each lobe as a curve in the plane of the normal and the eye, the eye to the right; roots of the values.
    fn curves(&self, ui: &mut Ui, all: &Hemisphere) {
        let (response, painter) = ui.allocate_painter(vec2(WIDTH, SIDE), Sense::hover());
        let rect = response.rect;
        response.on_hover_text("each lobe in the plane of the normal and the eye (right), in roots; white: their sum");
        let (foot, reach) = (pos2(rect.center().x, rect.bottom() - 24.0), 0.5 * WIDTH - 4.0);
        let grid = Stroke::new(1.0, Color32::from_gray(60));
        painter.line_segment([foot - vec2(reach, 0.0), foot + vec2(reach, 0.0)], grid);
        painter.line_segment([foot, foot - vec2(0.0, reach)], grid);
        let sections = |lobe| all.section(lobe, STEPS);
        let sum = sections(None);
        let most = sum.iter().map(|(_, value)| luminance(*value)).fold(f64::MIN_POSITIVE, f64::max);
        let curve = |section: &[(f32, Vec3)], stroke: Stroke| {
            let at = |(angle, value): &(f32, Vec3)| {
                let radius = reach * (luminance(*value).max(0.0) / most).sqrt() as f32;
                foot + radius * vec2(angle.sin(), -angle.cos())
            };
            painter.line(section.iter().map(at).collect(), stroke);
        };
        for lobe in 0..all.lobes().len().min(MOST) {
            let width = if self.lobe == Some(lobe) { 2.5 } else { 1.2 };
            curve(&sections(Some(lobe)), Stroke::new(width, HUES[lobe % HUES.len()]));
        }
        curve(&sum, Stroke::new(1.0, Color32::from_white_alpha(150)));
    }
}

/// The kind of a lobe, and how sharp it is.
fn kind(lobe: &BrdfLobe) -> String {
    match lobe {
        BrdfLobe::Cosine(lobe) if lobe.exponent == 1.0 => "diffuse".to_owned(),
        BrdfLobe::Cosine(lobe) => format!("cosine, exponent {:.0}", lobe.exponent),
        BrdfLobe::Microfacets(facets) => format!("microfacets, α {:.3}", (2.0 / (facets.exponent + 2.0)).sqrt()),
    }
}

/// The disc in colours: roots of the luminance, in the hue of a light where one is seen, reddish where one is hidden.
fn image(pixels: &[HemispherePixel], lights: &[(&LightMask, Vec3)]) -> ColorImage {
    let value = |pixel: &HemispherePixel| match pixel {
        HemispherePixel::Outside => 0.0,
        HemispherePixel::Dark(value) | HemispherePixel::Lit(_, value) | HemispherePixel::Blocked(_, value) => {
            luminance(*value).max(0.0)
        }
    };
    let most = pixels.iter().map(value).fold(f64::MIN_POSITIVE, f64::max);
    let color = |pixel: &HemispherePixel| {
        let bright = (value(pixel) / most).sqrt() as f32;
        let color = match pixel {
            HemispherePixel::Outside => return [0; 4],
            HemispherePixel::Dark(_) => Vec3::new(0.07, 0.08, 0.11) + bright * Vec3::new(0.35, 0.4, 0.5),
            HemispherePixel::Lit(light, _) => {
                let hue = lights.get(*light).map_or(Vec3::ONE, |(_, hue)| *hue);
                hue * (0.45 + 0.55 * bright)
            }
            HemispherePixel::Blocked(..) => Vec3::new(0.16, 0.03, 0.03) + bright * Vec3::new(0.4, 0.12, 0.12),
        };
        let [r, g, b] = (255.0 * color).clamp(Vec3::ZERO, Vec3::splat(255.0)).to_array().map(|c| c as u8);
        [r, g, b, 255]
    };
    let bytes: Vec<u8> = pixels.iter().flat_map(color).collect();
    ColorImage::from_rgba_unmultiplied([PIXELS, PIXELS], &bytes)
}

/// Outlines of lights, the eye and the mirror's reflection on the disc.
fn draw_lights(painter: &Painter, rect: Rect, all: &Hemisphere, lights: &[(&LightMask, Vec3)]) {
    let screen = |place: Vec2| rect.center() + 0.5 * SIDE * vec2(place.x, -place.y);
    for (mask, hue) in lights {
        let [r, g, b] = (255.0 * *hue).to_array().map(|c| c as u8);
        let outline: Vec<Pos2> = all.outline(mask).into_iter().map(screen).collect();
        if let (Some(first), Some(last)) = (outline.first().copied(), outline.last().copied()) {
            let stroke = Stroke::new(1.2, Color32::from_rgb(r, g, b));
            painter.line_segment([last, first], stroke);
            painter.line(outline, stroke);
        }
    }
    let stroke = Stroke::new(1.2, Color32::WHITE);
    let [eye, mirror] = all.eye_and_mirror().map(|place| place.map(screen));
    if let Some(eye) = eye {
        painter.circle_stroke(eye, 3.5, stroke);
    }
    if let Some(mirror) = mirror {
        for turn in [vec2(3.5, 3.5), vec2(3.5, -3.5)] {
            painter.line_segment([mirror - turn, mirror + turn], stroke);
        }
    }
    painter.circle_stroke(rect.center(), 0.5 * SIDE, Stroke::new(1.0, Color32::from_gray(110)));
}
