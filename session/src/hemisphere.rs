use glam::{Vec2, Vec3};
use lobe_core::{BrdfLobe, Receiver, orthonormal_basis};
use renderer::{LightMask, MaskSample};

/// The reflectance of a point over the hemisphere of directions toward light, to be drawn on a disc: the normal in the middle, the horizon at
/// the rim, and the eye to the right of the middle.
///
/// The disc has equal areas (Lambert's azimuthal projection): a direction at the angle `θ` from the normal lies at the radius
///
/// ```text
/// r = √2 sin(θ/2)
/// ```
///
/// and an area `a` of the unit disc has the solid angle `2a`. So the light that a lobe gets of a lamp is the sum of the lobe over the
/// lamp's visible part as it is drawn, times twice its area and the lamp's radiance.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Hemisphere {
    /// World directions of the disc's right and up, and the normal.
    frame: [Vec3; 3],
    /// The direction toward the eye.
    view: Vec3,
    lobes: Vec<BrdfLobe>,
}

/// A part of the hemisphere that a picture of it shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HemispherePixel {
    /// Outside the disc.
    Outside,
    /// Reflectance times the cosine, 1/sr, where there is no light.
    Dark(Vec3),
    /// The same where a light, by its number among the masks, is seen.
    Lit(usize, Vec3),
    /// The same where a blocker hides it.
    Blocked(usize, Vec3),
}

impl Hemisphere {
    /// The hemisphere of a receiver, with its [lobes of reflectance](renderer::Renderer::reflectance).
    #[must_use]
    pub fn new(at: &Receiver, lobes: Vec<BrdfLobe>) -> Self {
        let normal = at.normal;
        let aside = at.view - normal * at.view.dot(normal);
        // Straight from above any direction will do.
        let right = if aside.length_squared() > 1e-8 { aside.normalize() } else { orthonormal_basis(normal).0 };
        Self { frame: [right, normal.cross(right), normal], view: at.view, lobes }
    }

    /// The lobes, in the order of the material.
    #[must_use]
    pub fn lobes(&self) -> &[BrdfLobe] {
        &self.lobes
    }

    /// Where a direction lies on the unit disc; none below the horizon.
    #[must_use]
    pub fn place(&self, direction: Vec3) -> Option<Vec2> {
        let [right, up, normal] = self.frame;
        let cos = direction.dot(normal);
        // √2 sin(θ/2)/sin θ = 1/√(1 + cos θ)
        (cos >= 0.0).then(|| Vec2::new(direction.dot(right), direction.dot(up)) / (1.0 + cos).sqrt())
    }

    /// The unit direction at a place of the unit disc; none outside it.
    #[must_use]
    pub fn direction(&self, place: Vec2) -> Option<Vec3> {
        let square = place.length_squared();
        let [right, up, normal] = self.frame;
        (square <= 1.0).then(|| {
            let aside = place * (2.0 - square).sqrt();
            aside.x * right + aside.y * up + (1.0 - square) * normal
        })
    }

    /// Where the eye lies on the disc, and the direction of a mirror's reflection.
    #[must_use]
    pub fn eye_and_mirror(&self) -> [Option<Vec2>; 2] {
        let normal = self.frame[2];
        let mirror = 2.0 * self.view.dot(normal) * normal - self.view;
        [self.view, mirror].map(|direction| self.place(direction))
    }

    /// Reflectance times the cosine toward a direction, 1/sr: of one lobe, or of all together.
    #[must_use]
    pub fn value(&self, lobe: Option<usize>, direction: Vec3) -> Vec3 {
        let normal = self.frame[2];
        match lobe {
            Some(number) => self.lobes.get(number).map_or(Vec3::ZERO, |lobe| lobe.eval_at(normal, direction)),
            None => BrdfLobe::sum_at(&self.lobes, normal, direction),
        }
    }

    /// The values along the plane of the normal and the eye: `count` angles from the horizon behind the eye (−π/2) to that before it
    /// (π/2), where the mirror's reflection is at a negative one; for a curve in polar coordinates.
    #[must_use]
    pub fn section(&self, lobe: Option<usize>, count: usize) -> Vec<(f32, Vec3)> {
        let [right, _, normal] = self.frame;
        let angle = |k: usize| (k as f32 / count.saturating_sub(1).max(1) as f32 - 0.5) * core::f32::consts::PI;
        let at = |angle: f32| (angle, self.value(lobe, (angle.sin() * right + angle.cos() * normal).normalize()));
        (0..count).map(angle).map(at).collect()
    }

    /// The disc as `side` × `side` pixels, row by row from the top, with the lights whose masks the point sees.
    #[must_use]
    pub fn picture(&self, side: usize, lobe: Option<usize>, masks: &[&LightMask]) -> Vec<HemispherePixel> {
        let pixel = |i: usize| {
            let [column, row] = [i % side, i / side].map(|n| (2.0 * n as f32 + 1.0) / side as f32 - 1.0);
            let Some(direction) = self.direction(Vec2::new(column, -row)) else { return HemispherePixel::Outside };
            let value = self.value(lobe, direction);
            let sampled = masks.iter().map(|mask| mask.sample(direction)).enumerate();
            match sampled.into_iter().find(|(_, sample)| *sample != MaskSample::Outside) {
                Some((light, MaskSample::Lit)) => HemispherePixel::Lit(light, value),
                Some((light, _)) => HemispherePixel::Blocked(light, value),
                None => HemispherePixel::Dark(value),
            }
        };
        (0..side * side).map(pixel).collect()
    }

    /// The outline of a light on the disc.
    #[must_use]
    pub fn outline(&self, mask: &LightMask) -> Vec<Vec2> {
        // Rounding may leave a point of the horizon below it.
        let above = |direction: Vec3| direction + self.frame[2] * (-direction.dot(self.frame[2])).max(0.0);
        mask.outline().into_iter().filter_map(|direction| self.place(above(direction).normalize())).collect()
    }
}
