use crate::primitive::reach;
use core::f32::consts::PI;
use glam::Vec3;
use lighting::{FlatLight, Light, SphereLight, SpotLight, SunLight};
use lobe_core::Sphere;
use scene::Bounds;

/// A kind of light that a window adds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NewLight {
    /// A sphere.
    Sphere,
    /// A square panel.
    Rectangle,
    /// A disc.
    Disc,
    /// A spot of 35°.
    Spot,
    /// A sun of 2°.
    Sun,
}

/// The size of a lamp, in radii of the scene.
const SIZE: f32 = 0.12;
/// From the middle of the scene to the lamp, in radii of the scene.
const ABOVE: Vec3 = Vec3::new(-0.5, 1.4, 0.6);
/// Degrees under which a sun is seen.
const SUN: f32 = 2.0;

impl NewLight {
    /// All kinds.
    pub const ALL: [Self; 5] = [Self::Sphere, Self::Rectangle, Self::Disc, Self::Spot, Self::Sun];

    /// Its name, the kind in scene files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Sphere => "sphere",
            Self::Rectangle => "rectangle",
            Self::Disc => "disc",
            Self::Spot => "spot",
            Self::Sun => "sun",
        }
    }

    /// A light above the middle of some bounds that shines there, so bright that a surface that faces it there has the given irradiance
    /// `E` (above 0), as a small lamp's:
    ///
    /// ```text
    /// L = E d² / A
    /// ```
    ///
    /// of the distance `d` and the area `A` of the lamp as it is seen from there.
    ///
    /// ```
    /// use lobe_core::Receiver;
    /// use shading::LightLobes;
    /// use scene::{Bounds, glam::Vec3};
    /// use session::NewLight;
    /// let around = Bounds::EMPTY.with_point(Vec3::NEG_ONE).with_point(Vec3::ONE);
    /// let light = NewLight::Disc.light(around, 2.0);
    /// let toward = light.bounds().center.normalize();
    /// let seen = light.seen_from(&Receiver::on_surface(Vec3::ZERO, toward, toward));
    /// assert!((seen.lobe().flux.x - 2.0).abs() < 0.02);
    /// ```
    #[must_use]
    pub fn light(self, around: Bounds, irradiance: f32) -> Light {
        let (middle, reach) = (if around.is_empty() { Vec3::ZERO } else { around.center() }, reach(around));
        let (center, size) = (middle + reach * ABOVE, SIZE * reach);
        let along = (middle - center).normalize_or(Vec3::NEG_Y);
        let power = Vec3::splat(irradiance) * center.distance_squared(middle);
        let sphere = Sphere { center, radius: size };
        let by_area = |area: f32| power / area;
        match self {
            Self::Sphere => SphereLight::new(sphere, by_area(PI * size * size)).into(),
            Self::Spot => {
                let light = SphereLight::with_intensity(Sphere { radius: 0.25 * size, ..sphere }, power);
                let cos = [25.0_f32, 35.0].map(|degrees| degrees.to_radians().cos());
                SpotLight { light, axis: along, cos, range: f32::INFINITY }.into()
            }
            Self::Sun => SunLight::new(-along, 0.5 * SUN, Vec3::splat(irradiance), sphere).into(),
            Self::Rectangle | Self::Disc => {
                let u = along.cross(Vec3::Y).normalize_or(Vec3::X) * size;
                let flat = match self {
                    Self::Disc => FlatLight::disc(center, along, size, by_area(PI * size * size)),
                    _ => FlatLight::rectangle(center, u, along.cross(u), by_area(4.0 * size * size)),
                };
                // Both have an area.
                flat.map_or_else(|_| SphereLight::new(sphere, by_area(PI * size * size)).into(), Light::from)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_core::Receiver;
    use shading::LightLobes;

    #[test]
    fn every_kind_lights_the_middle_alike() {
        let around = Bounds::EMPTY.with_point(Vec3::new(3.0, 0.0, -2.0)).with_point(Vec3::new(7.0, 3.0, 5.0));
        let toward = ABOVE.normalize();
        for kind in NewLight::ALL {
            let light = kind.light(around, 3.0);
            light.kind().validate().expect("a light");
            let seen = light.seen_from(&Receiver::on_surface(around.center(), toward, toward));
            let irradiance = seen.lobe().flux.x;
            assert!((irradiance - 3.0).abs() < 0.05, "{}: {irradiance}", kind.name());
        }
        assert!(NewLight::Sphere.light(Bounds::EMPTY, 1.0).bounds().radius > 0.0, "in an empty scene");
    }
}
