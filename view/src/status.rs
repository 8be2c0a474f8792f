//! The line at the bottom: what is going on, and what went wrong.

use crate::desk::Desk;
use crate::opening::Opening;
use eframe::egui::{Color32, Label, RichText, Ui};

const HINT: &str =
    "drag: turn · right drag: move · wheel: zoom · F: all · click: look into a pixel · drag a lamp: see its shadow";

pub(crate) fn show(ui: &mut Ui, desk: Option<&Desk>, opening: Option<&Opening>, message: &mut Option<String>) {
    ui.horizontal(|ui| {
        if let Some(opening) = opening.filter(|_| desk.is_some()) {
            ui.spinner();
            ui.label(format!("Opening {} …", opening.name()));
        } else if let Some(desk) = desk {
            ui.label(state(desk));
        }
        ui.separator();
        match message {
            Some(line) => {
                if ui.small_button("×").clicked() {
                    *message = None;
                    return;
                }
                let text = RichText::new(line.as_str()).color(Color32::from_rgb(255, 170, 110));
                ui.add(Label::new(text).truncate()).on_hover_text(line.as_str());
            }
            None => {
                ui.add(Label::new(RichText::new(HINT).weak()).truncate());
            }
        }
    });
}

fn state(desk: &Desk) -> String {
    let picture = desk.editor.picture();
    let [width, height] = picture.size;
    let milliseconds = 1e3 * picture.seconds;
    if picture.is_empty() {
        return "the first picture …".to_owned();
    }
    let fineness = match picture.divisor {
        1 => String::new(),
        divisor => format!(" (1/{divisor})"),
    };
    let waiting = if desk.editor.is_finished() { "" } else { " …" };
    format!("{width} × {height}{fineness} in {milliseconds:.0} ms{waiting}")
}
