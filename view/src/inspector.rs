//! Why a pixel is as bright as it is.

use crate::desk::Desk;
use cosine_lobes::glam::Vec3;
use cosine_lobes::luminance;
use eframe::egui::{Grid, RichText, Ui};

pub(crate) fn show(ui: &mut Ui, desk: &Desk) {
    let Some(([x, y], probe)) = &desk.probed else {
        ui.label(RichText::new("Click a place in the picture.").weak());
        return;
    };
    let scene = desk.editor.scene();
    let pick = &probe.pick;
    let object = scene.object(pick.object);
    let material = scene.materials.iter().find(|item| item.handle == pick.material);
    Grid::new("pixel").num_columns(2).show(ui, |ui| {
        let mut row = |name: &str, value: String| {
            ui.label(RichText::new(name).weak());
            ui.label(value);
            ui.end_row();
        };
        row("pixel", format!("{x}, {y}"));
        row("object", object.map_or_else(|| "–".to_owned(), |item| item.name.clone()));
        row("material", material.map_or_else(|| "–".to_owned(), |item| item.material.name().to_owned()));
        row("shadow by", object.map_or_else(|| "–".to_owned(), |item| item.taken.name().to_owned()));
        row("point", vector(pick.receiver.position));
        row("normal", vector(pick.receiver.normal));
        row("distance", format!("{:.3}", pick.distance));
        row("radiance", vector(probe.radiance));
        let [reference, error] = probe.reference;
        row("reference", format!("{} ± {:.4}", vector(reference), error.max_element()));
        row("difference", difference(probe.radiance, reference));
    });
    ui.add_space(6.0);
    Grid::new("lights").num_columns(4).striped(true).show(ui, |ui| {
        for name in ["light", "unshadowed", "visible", "adds"] {
            ui.label(RichText::new(name).weak());
        }
        ui.end_row();
        let mut parts: Vec<_> = probe.lights.iter().enumerate().collect();
        // Environments are hundreds: those that matter most come first.
        parts.sort_by(|a, b| luminance(b.1.unshadowed).total_cmp(&luminance(a.1.unshadowed)));
        for (number, part) in parts.iter().take(MOST) {
            let name = scene.light(part.light).map_or("", |item| item.light.name());
            ui.label(format!("{number} {name}"));
            ui.label(format!("{:.4}", luminance(part.unshadowed)));
            ui.label(format!("{:.1} %", 100.0 * luminance(part.visible)));
            ui.label(format!("{:.4}", luminance(part.radiance)));
            ui.end_row();
        }
    });
    if probe.lights.len() > MOST {
        ui.label(RichText::new(format!("and {} more", probe.lights.len() - MOST)).weak());
    }
}

/// Lights that are listed.
const MOST: usize = 8;

fn vector(v: Vec3) -> String {
    format!("{:.3}, {:.3}, {:.3}", v.x, v.y, v.z)
}

fn difference(radiance: Vec3, reference: Vec3) -> String {
    let (own, want) = (luminance(radiance), luminance(reference));
    if want > 0.0 { format!("{:+.2} %", 100.0 * (own / want - 1.0)) } else { format!("{:+.5}", own - want) }
}
