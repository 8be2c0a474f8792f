//! Fig. 8: blockers on the unit square.

use super::super::canvas::{Draw, failed};
use super::super::gallery::Page;
use super::super::studio::Studio;
use super::setting::{DIST, LIGHT, Panel, Setting, sphere, words};
use crate::drawing::COLORS;
use crate::failure::Failure;
use cosine_lobes::lobe_core::Sphere;
use glam::Vec3;
use plotters::coord::Shift;
use plotters::prelude::*;

/// Three spheres that count, and three that do not: beside the light's cone, behind the light, behind the receiver.
fn around() -> Vec<Sphere> {
    vec![
        sphere(-0.22, 0.12, 0.20, 3.0),
        sphere(0.30, 0.05, 0.26, 5.0),
        sphere(0.05, -0.42, 0.16, 2.2),
        sphere(1.05, 0.0, 0.22, 4.0),
        sphere(-0.25, 0.0, 0.18, 11.5),
        Sphere { center: Vec3::new(-0.8, 0.0, -1.0), radius: 0.6 },
    ]
}

struct Splat<'a> {
    setting: &'a Setting,
    kept: &'a [bool],
    nodes: usize,
}

impl Splat<'_> {
    /// From the side, in the plane y = 0.
    fn side<B: DrawingBackend>(&self, root: &DrawingArea<B, Shift>, left: i32, only_kept: bool) -> Result<(), String>
    where
        B::ErrorType: 'static,
    {
        const SCALE: f32 = 23.0;
        let place = |x: f32, z: f32| (left + 110 + (SCALE * x) as i32, 322 - (SCALE * z) as i32);
        let Setting { cone, light, spheres, .. } = self.setting;
        let tan = cone.tan();
        let line = |from: (i32, i32), to: (i32, i32), style: ShapeStyle| {
            root.draw(&PathElement::new(vec![from, to], style)).map_err(failed)
        };
        let radius = |r: f32| (SCALE * r) as i32;
        root.draw(&Circle::new(place(0.0, LIGHT), radius(light.radius), RGBColor(255, 225, 120).filled()))
            .map_err(failed)?;
        for side in [-1.0, 1.0] {
            line(place(0.0, 0.0), place(side * tan * 12.3, 12.3), RGBColor(200, 150, 0).stroke_width(1))?;
        }
        for (sphere, kept) in spheres.iter().zip(self.kept) {
            let color = if *kept { COLORS[0] } else { RGBColor(190, 190, 190) };
            let at = place(sphere.center.x, sphere.center.z);
            if *kept || !only_kept {
                root.draw(&Circle::new(at, radius(sphere.radius), color.mix(0.75).filled())).map_err(failed)?;
            }
        }
        // The unit square, seen from its edge.
        line(place(-0.5, DIST), place(0.5, DIST), RED.stroke_width(3))?;
        line(place(-4.5, 0.0), place(4.5, 0.0), BLACK.stroke_width(2))?;
        root.draw(&Circle::new(place(0.0, 0.0), 4, BLACK.filled())).map_err(failed)?;
        words(root, "x", (place(0.0, 0.0).0 - 4, 330))?;
        words(root, "light", (place(0.0, LIGHT).0 - 14, place(0.0, LIGHT).1 - 8))?;
        words(root, "dist", (place(0.7, 0.5 * DIST).0, place(0.7, 0.5 * DIST).1 - 14))?;
        Ok(())
    }
}

impl Draw for Splat<'_> {
    fn size(&self) -> (u32, u32) {
        (760, 385)
    }

    fn draw<B: DrawingBackend>(&self, root: &DrawingArea<B, Shift>) -> Result<(), String>
    where
        B::ErrorType: 'static,
    {
        words(root, "(a) light, cone, unit square (red)", (10, 8))?;
        self.side(root, 0, false)?;
        words(root, "(b) what is left after clipping", (255, 8))?;
        self.side(root, 245, true)?;
        words(root, "(c) splatted onto the square", (510, 8))?;
        let panel = Panel { left: 510, top: 60, side: 230 };
        for (sphere, _) in self.setting.spheres.iter().zip(self.kept).filter(|(_, kept)| **kept) {
            let path = panel.path(&self.setting.outline(sphere));
            root.draw(&Polygon::new(path.clone(), COLORS[0].mix(0.45))).map_err(failed)?;
            root.draw(&PathElement::new(path, COLORS[0].stroke_width(1))).map_err(failed)?;
        }
        root.draw(&panel.disc()).map_err(failed)?;
        root.draw(&panel.frame()).map_err(failed)?;
        words(root, &format!("{} shadow nodes at depth 5", self.nodes), (panel.left, 304))
    }
}

pub(in crate::figures) fn square(name: &str, studio: &mut Studio) -> Result<Page, Failure> {
    let tables = studio.tables()?;
    let setting = Setting::new(DIST, around());
    let kept: Vec<bool> = setting.spheres.iter().map(|b| setting.is_kept(*b, &tables)).collect();
    let nodes = setting.seen(5, &tables)?.nodes.len();
    let left = kept.iter().filter(|k| **k).count();
    let images = Splat { setting: &setting, kept: &kept, nodes }.images(name)?;
    Ok(Page {
        title: "blockers on the unit square",
        images,
        shows: "A receiver x sees a spherical light as a cone. A unit square faces the cone at dist = 1/(2 tan α). Spheres that cannot \
                hide any of the light are clipped; the others are splatted onto the square."
            .into(),
        paper: "The figure has the same three steps and no numbers (Fig. 8, §5.3).".into(),
        here: format!(
            "The light's half-angle is {:.1}°, so dist is {DIST}. Of {} spheres {left} are left: one is beside the cone, one behind the light, one \
             below the receiver.",
            setting.cone.tan().atan().to_degrees(),
            kept.len()
        ),
        differs: String::new(),
    })
}

#[cfg(test)]
mod tests {
    use super::super::setting::tests::coarse;
    use super::*;

    #[test]
    fn what_cannot_block_is_clipped() {
        let (setting, tables) = (Setting::new(DIST, around()), coarse());
        let kept: Vec<bool> = setting.spheres.iter().map(|b| setting.is_kept(*b, &tables)).collect();
        assert_eq!(kept, [true, true, true, false, false, false]);
    }
}
