//! The bar of the animation: play, and any moment.

use crate::desk::Desk;
use eframe::egui::{Slider, SliderClamping, Ui};

pub(crate) fn show(ui: &mut Ui, desk: &mut Desk) {
    let (duration, mut time) = (desk.editor.scene().duration, desk.editor.scene().time);
    // The next moment follows once the one before it is seen: no faster than pictures come.
    if desk.is_playing {
        if !desk.editor.is_waiting() {
            let step = ui.input(|input| input.unstable_dt).clamp(0.0, 0.1).max(desk.pace());
            desk.editor.seek((time + step) % duration.max(1e-3));
        }
        ui.ctx().request_repaint();
    }
    ui.horizontal(|ui| {
        let name = if desk.is_playing { "Pause" } else { "Play" };
        if ui.button(name).on_hover_text("Space").clicked() {
            desk.is_playing = !desk.is_playing;
        }
        ui.spacing_mut().slider_width = (ui.available_width() - 90.0).max(80.0);
        let slider =
            Slider::new(&mut time, 0.0..=duration).suffix(" s").fixed_decimals(2).clamping(SliderClamping::Edits);
        let response = ui.add(slider);
        if response.changed() {
            desk.is_playing = false;
            desk.editor.seek(time);
        }
        if response.drag_stopped() {
            desk.close_step();
        }
    });
}
