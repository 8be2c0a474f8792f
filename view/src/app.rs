use crate::args::Args;
use crate::darkroom::{Darkroom, Order, Print};
use crate::desk::Desk;
use crate::inspector::Inspector;
use crate::map_window::MapWindow;
use crate::opening::{Devices, Opened, Opening, name_of};
use crate::screen::{self, Screen};
use crate::smoke::Smoke;
use crate::stage::Stage;
use crate::{animation, panel, shot, status};
use cosine_lobes::renderer::Device;
use eframe::CreationContext;
use eframe::egui::{
    self, CentralPanel, Context, Frame, Key, KeyboardShortcut, Modifiers, Panel, Ui, ViewportBuilder, ViewportCommand,
};
use std::path::PathBuf;

/// Opens the window, and stays until it is closed. An error is a line for the user.
pub(crate) fn run(args: Args) -> Result<(), String> {
    let viewport = ViewportBuilder::default()
        .with_title("lobes")
        .with_app_id("lobes-view")
        .with_inner_size([1320.0, 780.0])
        .with_drag_and_drop(true);
    let wgpu_options = screen::configuration();
    let options = eframe::NativeOptions { viewport, wgpu_options, ..eframe::NativeOptions::default() };
    let smoke = args.smoke.map(|path| Smoke::new(path, args.pixel.is_some(), args.shake));
    let failed = smoke.as_ref().map(Smoke::outcome);
    let (pixel, shows_spheres, shows_map) = (args.pixel, args.spheres, args.shadow_map);
    let (first, takes_software) = (if args.gpu { Device::Gpu } else { Device::Cpu }, args.one_device);
    let start = move |creation: &CreationContext<'_>| {
        let state = creation.wgpu_render_state.as_ref();
        let screen = state.map_or(Ok(None), |state| Screen::new(state, &creation.egui_ctx, takes_software));
        let mut app = App::new(&creation.egui_ctx, args.file, (screen, first), smoke);
        (app.pixel, app.shows_spheres, app.shows_map) = (pixel, shows_spheres, shows_map);
        app
    };
    eframe::run_native("lobes", options, Box::new(move |creation| Ok(Box::new(start(creation)))))
        .map_err(|error| format!("no window: {error}"))?;
    failed.map_or(Ok(()), |outcome| outcome.result())
}

pub(crate) struct App {
    desk: Option<Desk>,
    opening: Option<Opening>,
    /// A line for the user.
    message: Option<String>,
    /// The window's GPU, where pictures are shown without a copy.
    screen: Option<Screen>,
    devices: Devices,
    darkroom: Darkroom,
    print: Option<Print>,
    stage: Stage,
    inspector: Inspector,
    map_window: MapWindow,
    title: String,
    smoke: Option<Smoke>,
    /// The pixel that is taken apart once a scene is open.
    pixel: Option<[u32; 2]>,
    /// Whether the first scene shows the spheres that block.
    shows_spheres: bool,
    /// Whether the first scene shows a shadow map.
    shows_map: bool,
}

impl App {
    fn new(
        context: &Context,
        file: Option<PathBuf>,
        (screen, first): (Result<Option<Screen>, String>, Device),
        smoke: Option<Smoke>,
    ) -> Self {
        context.set_theme(egui::Theme::Dark);
        let message = screen.as_ref().err().cloned();
        let screen = screen.ok().flatten();
        let devices = Devices { gpu: screen.as_ref().map(|screen| screen.gpu().clone()), first };
        Self {
            desk: None,
            opening: Some(Opening::new(file, context, devices.clone())),
            message,
            darkroom: Darkroom::new(context, screen.as_ref().map(Screen::enlarger)),
            screen,
            devices,
            print: None,
            stage: Stage::default(),
            inspector: Inspector::default(),
            map_window: MapWindow::default(),
            title: String::new(),
            smoke,
            pixel: None,
            shows_spheres: false,
            shows_map: false,
        }
    }

    /// Takes what other threads have done.
    fn follow(&mut self, context: &Context) {
        if let Some(opened) = self.opening.as_ref().and_then(Opening::take) {
            self.opening = None;
            match opened {
                Ok(opened) => self.show(opened, context),
                Err(line) => self.message = Some(line),
            }
        }
        if let Some(desk) = &mut self.desk {
            if let Some(line) = desk.follow(context) {
                self.message = Some(line);
            }
            let editor = &desk.editor;
            if !editor.picture().is_empty() {
                let truth = editor.session().reference();
                let crossed = desk.crossed().cloned();
                self.darkroom.order(Order { picture: editor.picture().clone(), truth, crossed, viewing: desk.viewing });
            }
        }
        if let Some(print) = self.darkroom.take() {
            self.stage.take(context, &print, self.screen.as_mut());
            self.print = Some(print);
        }
    }

    fn show(&mut self, opened: Opened, context: &Context) {
        self.message = opened.warning.clone().or_else(|| self.message.take());
        let mut desk = Desk::new(opened);
        desk.shows_spheres = core::mem::take(&mut self.shows_spheres);
        desk.maps.is_shown = core::mem::take(&mut self.shows_map);
        if let Some(pixel) = self.pixel.take() {
            desk.look_into(pixel);
        }
        self.title = format!("{} – lobes", desk.title());
        context.send_viewport_cmd(ViewportCommand::Title(self.title.clone()));
        self.desk = Some(desk);
        self.print = None;
        self.stage = Stage::default();
        self.inspector = Inspector::default();
        self.map_window = MapWindow::default();
    }

    fn open(&mut self, path: PathBuf, context: &Context) {
        self.message = None;
        self.opening = Some(Opening::new(Some(path), context, self.devices.clone()));
    }

    /// Files that were dropped, and keys.
    fn listen(&mut self, context: &Context) {
        let dropped = context.input(|input| input.raw.dropped_files.first().map(|file| file.path().to_owned()));
        if let Some(path) = dropped {
            self.open(path, context);
        }
        let Some(desk) = &mut self.desk else { return };
        if context.egui_wants_keyboard_input() {
            return;
        }
        let pressed =
            |modifiers, key| context.input_mut(|i| i.consume_shortcut(&KeyboardShortcut::new(modifiers, key)));
        let redo = Modifiers::COMMAND | Modifiers::SHIFT;
        // A slow frame has more than one.
        let count = |modifiers, key| context.input_mut(|i| i.count_and_consume_key(modifiers, key));
        (0..count(redo, Key::Z) + count(Modifiers::COMMAND, Key::Y)).for_each(|_| desk.redo());
        (0..count(Modifiers::COMMAND, Key::Z)).for_each(|_| desk.undo());
        if pressed(Modifiers::COMMAND, Key::S) {
            self.message = Some(desk.save());
        }
        if pressed(Modifiers::NONE, Key::F) {
            desk.frame_all();
        }
        for (modifiers, is_back) in [(Modifiers::SHIFT, true), (Modifiers::NONE, false)] {
            if pressed(modifiers, Key::V) {
                let lights = desk.editor.scene().lights.len().min(panel::LIGHTS);
                desk.viewing.view = desk.viewing.view.beside(lights, is_back);
            }
        }
        if pressed(Modifiers::SHIFT, Key::Delete) {
            desk.remove();
        } else if pressed(Modifiers::NONE, Key::Delete) {
            desk.delete();
        }
        if pressed(Modifiers::NONE, Key::Escape) {
            (desk.selected, desk.probed) = (None, None);
        }
        if pressed(Modifiers::NONE, Key::R) {
            desk.viewing.split = if desk.viewing.split.is_some() { None } else { Some(0.5) };
        }
        if pressed(Modifiers::NONE, Key::Space) {
            desk.is_playing = !desk.is_playing && desk.editor.scene().duration > 0.0;
        }
        if pressed(Modifiers::NONE, Key::F12) {
            self.message = Some(shot::take(context, desk.path.as_deref()));
        }
    }

    fn hint_of_drop(context: &Context, ui: &Ui) {
        let hovered = context.input(|input| !input.raw.hovered_files.is_empty());
        if hovered {
            let (rect, painter) = (ui.max_rect(), ui.painter());
            painter.rect_filled(rect, 0.0, egui::Color32::from_black_alpha(160));
            let font = egui::FontId::proportional(24.0);
            painter.text(rect.center(), egui::Align2::CENTER_CENTER, "Drop to open", font, egui::Color32::WHITE);
        }
    }
}

impl eframe::App for App {
    fn ui(&mut self, ui: &mut Ui, frame: &mut eframe::Frame) {
        let context = ui.ctx().clone();
        if let Some(screen) = &self.screen {
            screen.retry_size(frame);
        }
        self.follow(&context);
        self.listen(&context);
        Panel::bottom("status").show(ui, |ui| {
            status::show(ui, self.desk.as_ref(), self.opening.as_ref(), &mut self.message);
        });
        if let Some(desk) = self.desk.as_mut().filter(|desk| desk.editor.scene().duration > 0.0) {
            Panel::bottom("animation").show(ui, |ui| animation::show(ui, desk));
        }
        if let Some(desk) = &mut self.desk {
            let figures = self.print.as_ref().and_then(|print| print.figures);
            let panel = Panel::right("panel").default_size(330.0).min_size(260.0);
            panel.show(ui, |ui| panel::show(ui, desk, figures.as_ref(), &mut self.message));
        }
        let frame = Frame::new().fill(egui::Color32::from_gray(24));
        CentralPanel::default().frame(frame).show(ui, |ui| {
            match &mut self.desk {
                Some(desk) => self.stage.show(ui, desk),
                None => Self::wait(ui, self.opening.as_ref()),
            }
            Self::hint_of_drop(&context, ui);
        });
        if let Some(desk) = &mut self.desk {
            self.inspector.show(&context, desk);
            self.map_window.show(&context, desk);
            // Whatever was dragged, a field of colour as well: it is a step.
            if context.input(|input| input.pointer.any_released()) {
                desk.editor.close_step();
            }
        }
        if let Some(smoke) = &mut self.smoke {
            smoke.watch(&context, self.desk.as_ref(), self.message.as_deref(), self.print.as_ref());
        }
    }
}

impl App {
    fn wait(ui: &mut Ui, opening: Option<&Opening>) {
        ui.centered_and_justified(|ui| match opening {
            Some(opening) => ui.label(format!("Opening {} …", opening.name())),
            None => ui.label("Drop a scene (.toml) or a model (.gltf, .glb, .obj, .ply) here"),
        });
    }
}

/// A name beside a scene's file, or in the present folder.
pub(crate) fn beside(path: Option<&std::path::Path>, ending: &str) -> PathBuf {
    let stem = path.map_or_else(|| PathBuf::from("lobes"), |path| path.with_extension(""));
    (1..)
        .map(|number| stem.with_file_name(format!("{}-{number}.{ending}", name_of(&stem))))
        .find(|path| !path.exists())
        .unwrap_or_else(|| stem.with_extension(ending))
}
