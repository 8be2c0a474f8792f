//! Lights as things to take hold of: where they are, how large, which way they shine, and the same with one of these changed.

use crate::Dragged;
use glam::{Mat4, Quat, Vec3};
use lighting::{EnclosedLight, Light, SphereLight, SpotLight, SunLight, TubeLight};
use lobe_core::Sphere;
use shading::LightLobes;

/// A sun is seen under half this angle at most, in radians.
const WIDEST_SUN: f32 = 1.0;

/// The middle of a light; none of lights that are nowhere: suns, skies, ambient light.
#[must_use]
pub fn center(light: &Light) -> Option<Vec3> {
    let is_nowhere = light.world().is_some() || matches!(light, Light::Sun(_) | Light::Sky(_) | Light::Ambient(_));
    let center = light.bounds().center;
    (!is_nowhere && center.is_finite()).then_some(center)
}

/// The unit direction in which a light shines; none of those that shine to all sides.
#[must_use]
pub fn direction(light: &Light) -> Option<Vec3> {
    match light {
        Light::Flat(flat) => Some(flat.normal()),
        Light::Spot(spot) => Some(spot.axis),
        Light::Sun(sun) => Some(-sun.toward),
        Light::Enclosed(inside) => direction(&inside.light),
        _ => None,
    }
}

/// How large a light is: its radius, or that of a circle around it; of a sun half the angle under which it is seen, in radians.
/// None of lights without a size.
#[must_use]
pub fn size(light: &Light) -> Option<f32> {
    match light {
        Light::Sphere(light) => Some(light.sphere.radius),
        Light::Spot(spot) => Some(spot.light.sphere.radius),
        Light::Flat(flat) => Some(flat.bounds().radius),
        Light::Tube(tube) => Some(tube.radius),
        Light::Sun(sun) => Some(sun.sin.clamp(0.0, 1.0).asin()),
        _ => None,
    }
}

/// The light at another [`size`], above 0, with the same power: its radiance falls as its area grows. The same where it has no size.
///
/// A tube keeps its length.
///
/// ```
/// use glam::Vec3;
/// use lighting::{Light, SphereLight};
/// use lobe_core::Sphere;
/// let light: Light = SphereLight::new(Sphere { center: Vec3::Y, radius: 0.5 }, Vec3::ONE).into();
/// let large = session::lamp::resized(&light, 1.0);
/// assert_eq!((large.sphere().map(|s| s.radius), large.full_radiance()), (Some(1.0), Vec3::splat(0.25)));
/// ```
#[must_use]
pub fn resized(light: &Light, to: f32) -> Light {
    let Some(from) = size(light).filter(|from| *from > 0.0 && to > 0.0 && to.is_finite()) else { return light.clone() };
    let factor = to / from;
    let sphere = |light: SphereLight| {
        let sphere = Sphere { radius: to, ..light.sphere };
        SphereLight { sphere, radiance: light.radiance / (factor * factor) }
    };
    match light {
        Light::Sphere(light) => sphere(*light).into(),
        Light::Spot(spot) => SpotLight { light: sphere(spot.light), ..*spot }.into(),
        Light::Flat(flat) => {
            let radiance = flat.radiance / (factor * factor);
            flat.clone().scaled(factor).with_radiance(radiance).into()
        }
        Light::Tube(tube) => {
            let wide = TubeLight { radius: to, ..*tube };
            TubeLight { radiance: tube.radiance * (tube.area() / wide.area()), ..wide }.into()
        }
        Light::Sun(sun) => {
            let sin = to.min(WIDEST_SUN).sin();
            SunLight { sin, radiance: sun.radiance * (sun.sin / sin).powi(2), ..*sun }.into()
        }
        _ => light.clone(),
    }
}

/// The light with another radiance; the same where it has none of its own.
#[must_use]
pub fn with_radiance(light: &Light, radiance: Vec3) -> Light {
    match light {
        Light::Sphere(light) => SphereLight { radiance, ..*light }.into(),
        Light::Spot(spot) => SpotLight { light: SphereLight { radiance, ..spot.light }, ..*spot }.into(),
        Light::Flat(flat) => flat.clone().with_radiance(radiance).into(),
        Light::Tube(tube) => TubeLight { radiance, ..*tube }.into(),
        Light::Sun(sun) => SunLight { radiance, ..*sun }.into(),
        Light::Ambient(ambient) => lighting::AmbientLight { radiance, ..*ambient }.into(),
        Light::Enclosed(inside) => {
            let light = Box::new(with_radiance(&inside.light, radiance));
            EnclosedLight { light, ..*inside }.into()
        }
        _ => light.clone(),
    }
}

/// Whether [`with_radiance`] has a say.
#[must_use]
pub fn has_radiance(light: &Light) -> bool {
    !matches!(light, Light::Sky(_) | Light::Custom(_))
}

/// The light shifted.
#[must_use]
pub fn shifted(light: &Light, by: Vec3) -> Light {
    light.moved(Mat4::from_translation(by))
}

/// The light turned about its middle, so that it shines in a unit direction; the same where it shines to all sides.
#[must_use]
pub fn aimed(light: &Light, toward: Vec3) -> Light {
    let Some(before) = direction(light) else { return light.clone() };
    let turn = Mat4::from_quat(Quat::from_rotation_arc(before.normalize_or(Vec3::NEG_Y), toward.normalize_or(before)));
    let middle = center(light).unwrap_or(Vec3::ZERO);
    light.moved(Mat4::from_translation(middle) * turn * Mat4::from_translation(-middle))
}

/// The light as a drag of its [handles](crate::Handles) leaves it.
#[must_use]
pub fn dragged(light: &Light, by: Dragged) -> Light {
    match by {
        Dragged::Shift(by) => shifted(light, by),
        Dragged::Scale(by) => size(light).map_or_else(|| light.clone(), |size| resized(light, size * by)),
        Dragged::Toward(direction) => aimed(light, direction),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lighting::FlatLight;

    fn lights() -> Vec<Light> {
        let sphere =
            SphereLight::new(Sphere { center: Vec3::new(1.0, 3.0, 0.5), radius: 0.4 }, Vec3::new(3.0, 2.0, 1.0));
        let world = Sphere { center: Vec3::ZERO, radius: 5.0 };
        let radiance = sphere.radiance;
        let flat = FlatLight::rectangle(Vec3::Y * 3.0, Vec3::X, Vec3::Z * 0.4, radiance).unwrap();
        vec![
            sphere.into(),
            SpotLight { light: sphere, axis: Vec3::NEG_Y, cos: [0.9, 0.8], range: f32::INFINITY }.into(),
            flat.into(),
            FlatLight::disc(Vec3::Y * 3.0, Vec3::new(0.1, -1.0, 0.2), 0.7, radiance).unwrap().into(),
            TubeLight { ends: [Vec3::Y, Vec3::Y + Vec3::X], radius: 0.1, radiance }.into(),
            SunLight { toward: Vec3::new(0.6, 0.8, 0.0), sin: 0.01, radiance, world }.into(),
        ]
    }

    /// Power, up to a factor of the kind: radiance times the area, or times the solid angle.
    fn power(light: &Light) -> Vec3 {
        let area = match light {
            Light::Flat(flat) => flat.area(),
            Light::Tube(tube) => tube.area(),
            Light::Sun(sun) => sun.sin * sun.sin,
            other => size(other).unwrap().powi(2),
        };
        light.full_radiance() * area
    }

    #[test]
    fn a_resized_light_keeps_its_power_and_its_middle() {
        for light in lights() {
            let before = size(&light).unwrap();
            let after = resized(&light, 1.7 * before);
            assert!((size(&after).unwrap() / before - 1.7).abs() < 1e-4, "{light:?}");
            assert!((power(&after) / power(&light) - Vec3::ONE).length() < 1e-3, "{light:?}");
            assert_eq!(center(&after).is_some(), center(&light).is_some());
            if let (Some(a), Some(b)) = (center(&after), center(&light)) {
                assert!(a.distance(b) < 1e-5);
            }
            scene::Scene::check_light(0, &after).unwrap();
            for bad in [0.0, -1.0, f32::NAN, f32::INFINITY] {
                assert_eq!(resized(&light, bad), light);
            }
        }
    }

    #[test]
    fn an_aimed_light_shines_there() {
        let toward = Vec3::new(0.3, -0.5, 0.8).normalize();
        for light in lights() {
            let after = aimed(&light, toward);
            match direction(&light) {
                Some(_) => assert!(direction(&after).unwrap().distance(toward) < 1e-5, "{after:?}"),
                None => assert_eq!(after, light),
            }
            if let (Some(a), Some(b)) = (center(&after), center(&light)) {
                assert!(a.distance(b) < 1e-4, "{a} {b}");
            }
        }
    }

    #[test]
    fn a_shifted_light_is_elsewhere_with_the_same_radiance() {
        for light in lights() {
            let after = with_radiance(&shifted(&light, Vec3::X), Vec3::ONE);
            assert_eq!(after.full_radiance(), Vec3::ONE);
            if let Some(middle) = center(&light) {
                assert!(center(&after).unwrap().distance(middle + Vec3::X) < 1e-5);
            }
        }
    }
}
