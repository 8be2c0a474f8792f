//! Error against time of this scene, measured beside the session; a click on a point, or a drag along them, takes its tolerance.

use crate::desk::Desk;
use cosine_lobes::renderer::Settings;
use cosine_lobes::session::{Trade, TradePoint};
use cosine_lobes::shading::Accuracy;
use eframe::egui::{Align2, Color32, FontId, Pos2, Rect, RichText, Sense, Stroke, Ui, pos2, vec2};

const POINT: Color32 = Color32::from_rgb(120, 170, 255);
const CHOSEN: Color32 = Color32::from_rgb(255, 210, 80);
const WEAK: Color32 = Color32::from_gray(130);

pub(crate) fn show(ui: &mut Ui, desk: &mut Desk) {
    ui.horizontal(|ui| {
        let name = if desk.trade.is_some() { "Measure again" } else { "Measure" };
        if ui.button(name).on_hover_text("small pictures of this scene against a reference; takes both cores").clicked()
        {
            desk.measure(ui.ctx());
        }
        if desk.is_measuring {
            ui.spinner();
        }
    });
    let points = desk.trade.as_ref().map(Trade::points).unwrap_or_default();
    if points.len() < 2 {
        ui.label(
            RichText::new("How much time does which accuracy take here? Drag the point of today along the others.")
                .weak(),
        );
        return;
    }
    let tolerance = desk.editor.scene().settings.accuracy.tolerance;
    let (chosen, rests) = plot(ui, &points, tolerance);
    if let Some(tolerance) = chosen.filter(|chosen| *chosen != tolerance) {
        let settings = Settings { accuracy: Accuracy::new(tolerance), ..desk.editor.scene().settings.clone() };
        desk.editor.set_settings(settings);
    }
    if rests {
        desk.close_step();
    }
}

/// Draws the points; the tolerance of the one that is clicked or dragged to, and whether the pointer rests then.
fn plot(ui: &mut Ui, points: &[TradePoint], tolerance: f32) -> (Option<f32>, bool) {
    let (response, painter) = ui.allocate_painter(vec2(ui.available_width(), 190.0), Sense::click_and_drag());
    let rect = Rect::from_min_max(response.rect.min + vec2(44.0, 8.0), response.rect.max - vec2(10.0, 34.0));
    let (times, errors) = (range(points, |p| p.seconds), range(points, |p| p.error));
    let part = |value: f64, [low, high]: [f64; 2]| ((value.ln() - low.ln()) / (high.ln() - low.ln())) as f32;
    let place = |point: &TradePoint| -> Pos2 {
        let (x, y) = (part(point.seconds, times), part(point.error, errors));
        pos2(rect.left() + x * rect.width(), rect.bottom() - y * rect.height())
    };
    painter.rect_stroke(rect, 2.0, Stroke::new(1.0, Color32::from_gray(70)), eframe::egui::StrokeKind::Inside);
    let text = |at: Pos2, anchor, text: String| painter.text(at, anchor, text, FontId::proportional(11.0), WEAK);
    for (value, anchor, x) in [(times[0], Align2::LEFT_TOP, rect.left()), (times[1], Align2::RIGHT_TOP, rect.right())] {
        text(pos2(x, rect.bottom() + 3.0), anchor, format!("{:.1} ms", 1e3 * value));
    }
    for (value, y) in [(errors[0], rect.bottom()), (errors[1], rect.top())] {
        text(pos2(rect.left() - 4.0, y), Align2::RIGHT_CENTER, format!("{:.2} %", 100.0 * value));
    }
    text(
        pos2(rect.center().x, rect.bottom() + 18.0),
        Align2::CENTER_TOP,
        "time of shading, to the right; mean error in penumbra, upward".to_owned(),
    );
    for pair in points.windows(2) {
        painter.line_segment([place(&pair[0]), place(&pair[1])], Stroke::new(1.0, POINT.gamma_multiply(0.5)));
    }
    for point in points {
        painter.circle_filled(place(point), 3.5, POINT);
    }
    if let Some(today) = nearest(points, |point| f64::from((point.tolerance / tolerance).ln().abs())) {
        painter.circle(place(today), 5.5, CHOSEN, Stroke::new(1.0, Color32::BLACK));
    }
    let rests = response.clicked() || response.drag_stopped();
    let pointer = response.interact_pointer_pos().or(response.hover_pos());
    let near = |pointer: Pos2| nearest(points, |point| f64::from(place(point).distance(pointer)));
    let Some(near) = pointer.and_then(near) else { return (None, rests) };
    painter.circle_stroke(place(near), 8.0, Stroke::new(1.0, Color32::WHITE));
    let line =
        format!("tolerance {} %: {:.1} ms, {:.3} %", 100.0 * near.tolerance, 1e3 * near.seconds, 100.0 * near.error);
    painter.text(
        rect.right_top() + vec2(-5.0, 5.0),
        Align2::RIGHT_TOP,
        line,
        FontId::proportional(11.0),
        Color32::WHITE,
    );
    ((response.clicked() || response.dragged()).then_some(near.tolerance), rests)
}

/// The least and the largest of a positive number of the points, apart.
fn range(points: &[TradePoint], of: impl Fn(&TradePoint) -> f64) -> [f64; 2] {
    let values = points.iter().map(of).map(|value| value.max(1e-9));
    let (low, high) = values.fold((f64::INFINITY, 0.0_f64), |(low, high), value| (low.min(value), high.max(value)));
    [low / 1.15, high * 1.15]
}

fn nearest(points: &[TradePoint], distance: impl Fn(&TradePoint) -> f64) -> Option<&TradePoint> {
    points.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)))
}
