//! A receiver, a light and blockers, and the unit square in a drawing.

use super::super::canvas::failed;
use crate::failure::Failure;
use cosine_lobes::lobe_core::{Cone, Lobe, Receiver, Sphere, VisibilitySum};
use cosine_lobes::paper::{PaperVisibility, ShadowNode, Tables};
use cosine_lobes::shading::{Accuracy, Coverage, LightCoverage, LightId, LightVisibility, Visibility, VisibilityQuery};
use cosine_lobes::visibility_spheres::SphereBlockers;
use glam::{Vec2, Vec3};
use plotters::coord::Shift;
use plotters::prelude::*;

/// The receiver is at the origin, the light this far above it.
pub(super) const LIGHT: f32 = 8.0;
/// The paper's `dist` of the unit square in Fig. 8 to 10: the light's half-angle is 14°.
pub(super) const DIST: f32 = 2.0;

/// A receiver, its light and the blockers between.
pub(super) struct Setting {
    pub(super) at: Receiver,
    pub(super) cone: Cone,
    pub(super) light: Sphere,
    pub(super) spheres: Vec<Sphere>,
}

/// A sphere by its place and radius on the unit square, and its height.
pub(super) fn sphere(u: f32, v: f32, radius: f32, height: f32) -> Sphere {
    let scale = height / DIST;
    Sphere { center: Vec3::new(u * scale, v * scale, height), radius: radius * scale }
}

impl Setting {
    pub(super) fn new(dist: f32, spheres: Vec<Sphere>) -> Self {
        let at = Receiver::on_surface(Vec3::ZERO, Vec3::Z, Vec3::Z);
        let tan = 0.5 / dist;
        let light = Sphere { center: Vec3::Z * LIGHT, radius: LIGHT * tan / (1.0 + tan * tan).sqrt() };
        Self { cone: Cone::of_sphere(at.position, light), at, light, spheres }
    }

    /// The shadow nodes and lobes that it gets from a quad-tree of that depth.
    pub(super) fn seen(&self, depth: u32, tables: &Tables) -> Result<Seen, Failure> {
        let accuracy = Accuracy { tolerance: 0.005, depth };
        let blockers = SphereBlockers::new(&self.spheres, &vec![0; self.spheres.len()], &[0.0]);
        let strategy = PaperVisibility::new(blockers, tables);
        let (mut scratch, mut sum) = (strategy.scratch(), VisibilitySum::default());
        let lambert = Lobe::new(self.at.normal, 1.0, Vec3::ONE);
        let mut visit = LightVisibility::alone(&strategy, LightId(0), accuracy, &mut scratch);
        if let LightCoverage::Partial(seen) = visit.coverage(&self.at, &self.cone, None) {
            visit.lobes(&seen, &lambert, 1.0, &mut sum);
        }
        Ok(Seen { nodes: scratch.nodes().to_vec(), lobes: sum.lobes.lobes().iter().collect() })
    }

    /// Whether a sphere changes the visibility.
    pub(super) fn is_kept(&self, sphere: Sphere, tables: &Tables) -> bool {
        let strategy = PaperVisibility::new(SphereBlockers::new(&[sphere], &[0], &[0.0]), tables);
        let accuracy = Accuracy { tolerance: 0.005, depth: 6 };
        let query = VisibilityQuery::new(&self.at, LightId(0), &self.cone, accuracy);
        strategy.coverage(&query, &mut strategy.scratch()) != Coverage::Lit
    }

    /// The direction through a point of the unit square.
    pub(super) fn direction(&self, p: Vec2) -> Vec3 {
        let tan = self.cone.tan();
        Vec3::new(2.0 * p.x * tan, 2.0 * p.y * tan, 1.0).normalize()
    }

    /// Whether a sphere blocks that direction before the light.
    pub(super) fn is_blocked(&self, p: Vec2) -> bool {
        let d = self.direction(p);
        self.spheres.iter().any(|b| {
            let along = b.center.dot(d);
            along > 0.0 && b.center.length() < self.light.center.length() && (b.center - along * d).length() < b.radius
        })
    }

    /// The outline of a sphere's shadow on the unit square.
    pub(super) fn outline(&self, sphere: &Sphere) -> Vec<Vec2> {
        let cone = Cone::of_sphere(Vec3::ZERO, *sphere);
        let (right, up) = cone.axis.any_orthonormal_pair();
        let tan = self.cone.tan();
        (0..=64)
            .map(|i| {
                let (s, c) = (core::f32::consts::TAU * i as f32 / 64.0).sin_cos();
                let d = cone.axis + cone.tan() * (right * c + up * s);
                Vec2::new(d.x, d.y) / (2.0 * tan * d.z)
            })
            .collect()
    }
}

/// Shadow nodes and their lobes, weights included.
pub(super) struct Seen {
    pub(super) nodes: Vec<ShadowNode>,
    pub(super) lobes: Vec<Lobe>,
}

/// Lower left and upper right corner of a node on the unit square.
pub(super) fn corners(node: ShadowNode) -> [Vec2; 2] {
    let side = 1.0 / (1_u32 << node.level) as f32;
    let low = Vec2::new(node.x as f32, node.y as f32) * side - 0.5;
    [low, low + side]
}

/// The unit square in a drawing.
#[derive(Clone, Copy)]
pub(super) struct Panel {
    pub(super) left: i32,
    pub(super) top: i32,
    pub(super) side: i32,
}

impl Panel {
    pub(super) fn at(&self, p: Vec2) -> (i32, i32) {
        let place = |t: f32| ((t + 0.5) * self.side as f32).round() as i32;
        (self.left + place(p.x), self.top + self.side - place(p.y))
    }

    pub(super) fn path(&self, points: &[Vec2]) -> Vec<(i32, i32)> {
        points.iter().map(|p| self.at(p.clamp(Vec2::splat(-0.5), Vec2::splat(0.5)))).collect()
    }

    pub(super) fn rectangle(&self, [low, high]: [Vec2; 2], style: ShapeStyle) -> Rectangle<(i32, i32)> {
        Rectangle::new([self.at(low), self.at(high)], style)
    }

    pub(super) fn frame(&self) -> Rectangle<(i32, i32)> {
        self.rectangle([Vec2::splat(-0.5), Vec2::splat(0.5)], BLACK.stroke_width(1))
    }

    pub(super) fn disc(&self) -> Circle<(i32, i32), i32> {
        Circle::new(self.at(Vec2::ZERO), self.side / 2, RGBColor(200, 150, 0).stroke_width(2))
    }
}

pub(super) const GREY: RGBColor = RGBColor(130, 130, 130);

pub(super) fn words<B: DrawingBackend>(root: &DrawingArea<B, Shift>, text: &str, at: (i32, i32)) -> Result<(), String> {
    root.draw(&Text::new(text.to_owned(), at, ("sans-serif", 15).into_font())).map_err(|e| failed(e.to_string()))
}

/// The three spheres of Fig. 9 and 10.
pub(super) fn three() -> Vec<Sphere> {
    vec![sphere(-0.26, -0.24, 0.33, 3.0), sphere(0.24, 0.02, 0.34, 4.0), sphere(0.10, 0.33, 0.12, 5.0)]
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use cosine_lobes::paper::{CapTable, ProductTable, Resolution};

    /// Quick to build; nodes do not depend on products.
    pub(in crate::figures::masks) fn coarse() -> Tables {
        let products = ProductTable::build_with(Resolution { angles: 9, per_interval: 3 });
        Tables { products, caps: CapTable::build() }
    }
}
