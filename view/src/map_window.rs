//! The shadow map of a light: its layers as images of distances, in a small window.

use crate::desk::Desk;
use crate::false_color;
use cosine_lobes::visibility_shadowmap::{MapImage, ShadowMap};
use eframe::egui::{
    ColorImage, Context, Image, RichText, ScrollArea, TextureHandle, TextureOptions, Ui, Window, pos2, vec2,
};

/// The longer side of an image, in points and pixels.
const SIDE: usize = 220;

/// A shadow map as the window shows it.
#[derive(Debug)]
pub(crate) struct MapView {
    images: Vec<MapImage>,
    resolution: u32,
    bytes: usize,
    /// The nearest and the farthest surface.
    ends: [f32; 2],
}

impl MapView {
    pub(crate) fn new(map: &ShadowMap) -> Self {
        let images = map.images(SIDE);
        let all = || images.iter().flat_map(|image| &image.distances).copied().filter(|d| d.is_finite());
        let ends = [all().fold(f32::INFINITY, f32::min), all().fold(0.0, f32::max)];
        Self { resolution: map.resolution(), bytes: map.bytes(), ends, images }
    }
}

/// The textures of the map that is shown.
#[derive(Default)]
pub(crate) struct MapWindow {
    /// The number of the map that they show.
    shown: u64,
    textures: Vec<TextureHandle>,
}

impl MapWindow {
    pub(crate) fn show(&mut self, context: &Context, desk: &mut Desk) {
        if !desk.maps.is_shown {
            return;
        }
        if self.shown != desk.maps.count {
            self.shown = desk.maps.count;
            let images = desk.maps.view.iter().flat_map(|view| view.images.iter().map(|image| (image, view.ends)));
            let load = |(image, ends): (&MapImage, [f32; 2])| {
                let colors = false_color::distances(&image.distances, ends);
                let picture = ColorImage::from_rgb(image.size, colors.as_flattened());
                context.load_texture("shadow map", picture, TextureOptions::NEAREST)
            };
            self.textures = images.map(load).collect();
        }
        let mut is_open = true;
        let room = context.content_rect().height() - 90.0;
        let body = |ui: &mut Ui| match &desk.maps.view {
            Some(view) => self.layers(ui, desk.maps.number, view),
            None => {
                ui.label("No object hides this light by a shadow map: the strategy shadow-map draws one, where all lights are spheres.");
            }
        };
        let window = Window::new("Shadow map").open(&mut is_open).default_pos(pos2(34.0, 60.0)).resizable(false);
        window.show(context, |ui| ScrollArea::vertical().max_height(room).show(ui, body));
        desk.maps.is_shown = is_open;
    }

    fn layers(&self, ui: &mut Ui, number: usize, view: &MapView) {
        let MapView { images, resolution, bytes, ends: [near, far] } = view;
        let size = format!("{resolution} texels a side, {:.1} MB", *bytes as f64 / 1e6);
        ui.label(format!("light {number}: {} layers, {size}", images.len()));
        ui.label(format!("yellow: nearest, {near:.3}; black: farthest, {far:.3}; grey: no surface"));
        let scale = "distances from the light's centre along the direction of the image, in units of the scene";
        ui.label(RichText::new(scale).weak());
        for (face, images) in
            images.iter().zip(&self.textures).collect::<Vec<_>>().chunk_by(|a, b| a.0.face == b.0.face).enumerate()
        {
            ui.horizontal(|ui| {
                for (image, texture) in images {
                    ui.vertical(|ui| {
                        let scale = SIDE as f32 / image.size[0].max(image.size[1]).max(1) as f32;
                        ui.add(Image::new((texture.id(), scale * vec2(image.size[0] as f32, image.size[1] as f32))));
                        ui.label(format!("face {face}, layer {}", image.layer));
                    });
                }
            });
        }
    }
}
