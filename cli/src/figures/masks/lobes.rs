//! Fig. 10: lobes of shadow nodes.

use super::super::canvas::{Draw, failed, heat};
use super::super::gallery::Page;
use super::super::studio::Studio;
use super::setting::{DIST, Panel, Seen, Setting, corners, three, words};
use crate::drawing::COLORS;
use crate::failure::Failure;
use cosine_lobes::lobe_core::Lobe;
use cosine_lobes::paper::Tables;
use glam::{Vec2, Vec3};
use plotters::coord::Shift;
use plotters::prelude::*;

/// V along a row of the unit square, and in a picture of it.
fn visibility(setting: &Setting, seen: &Seen, p: Vec2) -> f64 {
    let d = setting.direction(p);
    1.0 + f64::from(seen.lobes.iter().map(|l| l.eval(d).x).sum::<f32>())
}

/// Pixels a side of a panel in Fig. 10.
const PIXELS: i32 = 220;

struct Lobes<'a> {
    setting: &'a Setting,
    seen: &'a Seen,
}

impl Draw for Lobes<'_> {
    fn size(&self) -> (u32, u32) {
        (720, 290)
    }

    fn draw<B: DrawingBackend>(&self, root: &DrawingArea<B, Shift>) -> Result<(), String>
    where
        B::ErrorType: 'static,
    {
        let panel = |k: i32| Panel { left: 12 + 240 * k, top: 32, side: PIXELS };
        words(root, "shadow nodes and their spheres", (12, 8))?;
        words(root, "1 − V: lobes", (252, 8))?;
        words(root, "1 − V: the spheres themselves", (492, 8))?;
        for node in &self.seen.nodes {
            let [low, high] = corners(*node);
            root.draw(&panel(0).rectangle([low, high], RGBColor(110, 190, 120).filled())).map_err(failed)?;
            root.draw(&panel(0).rectangle([low, high], BLACK.stroke_width(1))).map_err(failed)?;
        }
        for node in &self.seen.nodes {
            let [low, high] = corners(*node);
            let radius = (0.5 * (high - low).length() * PIXELS as f32) as i32;
            let circle = Circle::new(panel(0).at(0.5 * (low + high)), radius, COLORS[1].stroke_width(1));
            root.draw(&circle).map_err(failed)?;
        }
        for (k, exact) in [(1, false), (2, true)] {
            for i in 0..PIXELS * PIXELS {
                let (x, y) = (i % PIXELS, i / PIXELS);
                let p = Vec2::new(x as f32 + 0.5, y as f32 + 0.5) / PIXELS as f32 - 0.5;
                let hidden = if exact {
                    f64::from(u8::from(self.setting.is_blocked(p)))
                } else {
                    1.0 - visibility(self.setting, self.seen, p)
                };
                let [r, g, b] = heat(hidden / 1.5);
                root.draw_pixel((panel(k).left + x, panel(k).top + PIXELS - 1 - y), &RGBColor(r, g, b))
                    .map_err(failed)?;
            }
        }
        for k in 0..3 {
            root.draw(&panel(k).disc()).map_err(failed)?;
            root.draw(&panel(k).frame()).map_err(failed)?;
        }
        for i in 0..160 {
            let [r, g, b] = heat(f64::from(i) / 159.0);
            let corners = [(252 + i, 264), (253 + i, 278)];
            root.draw(&Rectangle::new(corners, RGBColor(r, g, b).filled())).map_err(failed)?;
        }
        words(root, "0", (238, 263))?;
        words(root, "1.5", (418, 263))
    }
}

/// The depth of Fig. 10, small enough for its nodes to be seen.
const SHOWN: u32 = 4;

/// The visible fraction of a diffuse receiver's light, by method `paper` and by the spheres themselves.
fn shares(setting: &Setting, seen: &Seen, tables: &Tables) -> [f64; 2] {
    let lambert = Lobe::new(setting.at.normal, 1.0, Vec3::ONE);
    let product = tables.product(&lambert, &tables.light_lobe(&setting.cone, Vec3::ONE));
    let hidden: f32 = seen.lobes.iter().map(|c| tables.product(&product, c).flux.x).sum();
    const SIDE: usize = 400;
    let points = (0..SIDE * SIDE)
        .map(|i| Vec2::new((i % SIDE) as f32 + 0.5, (i / SIDE) as f32 + 0.5) / SIDE as f32 - 0.5)
        .filter(|p| p.length() < 0.5);
    let (mut open, mut all) = (0.0, 0.0);
    for p in points {
        // Solid angle and cosine of a piece of the square.
        let weight = f64::from(setting.direction(p).z).powi(4);
        all += weight;
        open += if setting.is_blocked(p) { 0.0 } else { weight };
    }
    [1.0 + f64::from(hidden / product.flux.x), open / all]
}

pub(in crate::figures) fn lobes(name: &str, studio: &mut Studio) -> Result<Page, Failure> {
    let tables = studio.tables()?;
    let setting = Setting::new(DIST, three());
    let seen = setting.seen(SHOWN, &tables)?;
    let mut rows = String::new();
    for depth in 3..=6 {
        let seen = setting.seen(depth, &tables)?;
        let [by_lobes, exact] = shares(&setting, &seen, &tables);
        rows += &format!("\n| {depth} | {} | {:.1} % | {:.1} % |", seen.nodes.len(), 100.0 * by_lobes, 100.0 * exact);
    }
    let image = Lobes { setting: &setting, seen: &seen }.picture(name)?;
    Ok(Page {
        title: "lobes of shadow nodes",
        images: vec![image],
        shows: format!(
            "The mask of Fig. 9 at depth {SHOWN}: each shadow node has a sphere around its square, and the sphere a cosine lobe. The weighted \
             sum of the lobes is the hidden part of the light; it has no edges, so single values are beside the truth where sums are not."
        ),
        paper: "One bounding sphere a shadow leaf, one lobe a sphere; no numbers (Fig. 10, §5.3).".into(),
        here: format!(
            "The fraction of its light that a diffuse receiver gets, by the depth of the quad-tree:\n\n| depth | lobes | method `paper` | exact |\n\
             |---|---|---|---|{rows}"
        ),
        differs: String::new(),
    })
}
