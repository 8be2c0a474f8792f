//! How many receivers of a single picture look at lights.

use lighting::Light;
use lobe_core::Sphere;
use render_cpu::Looks;
use scene::Scene;
use shading::LightLobes;

/// The half-angle of a light that counts once, in degrees.
const HALF_ANGLE: f64 = 5.0;

/// The looks of a picture: its pixels, times the width of each light over that of a sphere with a half-angle of 5°, seen from the middle of
/// the scene; many under a sky.
pub(crate) fn of_picture(scene: &Scene) -> Looks {
    let middle = scene.bounds().center();
    let width = |light: &Light| match light {
        Light::Sky(_) => f64::INFINITY,
        light => {
            let Sphere { center, radius } = light.bounds_from(&Sphere { center: middle, radius: 0.0 });
            let sin = radius / center.distance(middle).max(radius).max(f32::MIN_POSITIVE);
            f64::from(sin) / HALF_ANGLE.to_radians().sin()
        }
    };
    let pixels = f64::from(scene.width) * f64::from(scene.height);
    Looks::new(pixels * scene.lights.iter().map(width).sum::<f64>())
}
