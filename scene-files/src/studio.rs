//! The lights of models that bring none.

use glam::Vec3;
use lighting::{AmbientLight, Light, SphereLight};
use lobe_core::Sphere;
use scene::Bounds;
use shading::LightLobes;

/// How a model without lights is lit.
///
/// Half-angles are those under which lights are seen from the middle of the model's bounding box, five of its radii away.
///
/// ```no_run
/// use scene_files::{LoadOptions, Studio};
/// let (scene, _, _) = scene_files::load_with("duck.glb", &LoadOptions::new().with_studio(Studio::Key))?;
/// assert_eq!(scene.lights.len(), 1);
/// # Ok::<(), scene::SceneError>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Studio {
    /// A warm key light of 6°, a cool fill of 5° beside the camera, and ambient light, which metals mirror: with an irradiance of 1.06 π
    /// where all of it arrives.
    #[default]
    Soft,
    /// One white light of 6°, with an irradiance of π in the middle of the model.
    Key,
}

impl Studio {
    pub(crate) fn lights(self, bounds: &Bounds) -> Vec<Light> {
        if self == Self::Key {
            return vec![sphere(bounds, KEY, 6.0, Vec3::ONE)];
        }
        let world = Sphere { center: bounds.center(), radius: 100.0 * bounds.radius() };
        vec![
            sphere(bounds, KEY, 6.0, Vec3::new(0.74, 0.72, 0.68)),
            sphere(bounds, FILL, 5.0, Vec3::new(0.18, 0.195, 0.21)),
            AmbientLight { radiance: Vec3::new(0.14, 0.145, 0.15), world }.into(),
        ]
    }
}

/// Lights that look from everywhere less bright than this part of a disc as large as the model, of radiance 1, are no lighting of it.
const FAINT: f32 = 1e-3;

/// Lights of a radiance below this make up for a missing fill light, as the colours of some models do; they are no lamps.
const GLOW: f32 = 0.1;

/// Whether lights in a model are too faint to be all its lighting.
pub(crate) fn is_faint(lights: &[Light], bounds: &Bounds) -> bool {
    let size = bounds.radius() * bounds.radius();
    let area = |light: &Light| light.roundness().unwrap_or(1.0) * light.bounds().radius.powi(2) / size;
    let lamps = lights.iter().map(|light| (area(light), light.full_radiance().max_element()));
    lamps.filter(|(_, radiance)| *radiance >= GLOW).map(|(area, radiance)| area * radiance).sum::<f32>() < FAINT
}

/// The directions of the key light and of the fill, which stands above the camera, so that few of its shadows are seen.
const KEY: Vec3 = Vec3::new(-0.5, 0.9, 0.55);
const FILL: Vec3 = Vec3::new(0.75, 0.7, 0.9);

/// A sphere of light five radii from the middle, by its half-angle and its irradiance there over π.
fn sphere(bounds: &Bounds, toward: Vec3, degrees: f32, irradiance: Vec3) -> Light {
    let (distance, sin) = (5.0 * bounds.radius(), degrees.to_radians().sin());
    let sphere = Sphere { center: bounds.center() + distance * toward.normalize(), radius: distance * sin };
    SphereLight::new(sphere, irradiance / (sin * sin)).into()
}
