//! Checks of everything that a renderer relies on, for a whole scene and for each item.

use crate::{Camera, Object, Projection, Proxy, Scene, SceneError, Shape, Surface};
use brdf::Material;
use glam::Vec3;
use lighting::Light;
use lobe_core::Sphere;
use std::fmt::Display;

/// The most triangles of a scene, which are numbered: instances are many in little memory.
const MOST_TRIANGLES: usize = 1 << 31;

fn fault(thing: &dyn Display, error: &dyn Display) -> SceneError {
    SceneError::invalid(format!("{thing}: {error}"))
}

fn check_triangles(count: usize) -> Result<(), SceneError> {
    if count <= MOST_TRIANGLES {
        return Ok(());
    }
    Err(SceneError::invalid(format!("the scene has {count} triangles: expected 2^31 at most")))
}

fn is_color(color: Vec3) -> bool {
    color.is_finite() && color.min_element() >= 0.0
}

impl Scene {
    /// The largest width and height of a picture, in pixels.
    pub const MAX_SIDE: u32 = 16384;

    /// Checks everything that a renderer relies on: camera, image size, materials, meshes, spheres, proxies, lights.
    /// Readers of files have done so.
    ///
    /// A scene without lights is allowed: its picture is black. So is one without objects: its picture is the background.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] that names the first fault.
    pub fn validate(&self) -> Result<(), SceneError> {
        self.camera.validate()?;
        Self::check_size(self.width, self.height)?;
        Self::check_background(self.background)?;
        for (i, material) in self.materials.iter().enumerate() {
            Self::check_material(i, material, self.surfaces.get(i).unwrap_or(&Surface::default()))?;
        }
        self.objects.iter().try_for_each(|object| self.check_object(object))?;
        check_triangles(self.triangles())?;
        self.lights.iter().enumerate().try_for_each(|(i, light)| Self::check_light(i, light))
    }

    /// Checks the size of a picture.
    ///
    /// # Errors
    /// [`SceneError::Invalid`].
    pub fn check_size(width: u32, height: u32) -> Result<(), SceneError> {
        if (1..=Self::MAX_SIDE).contains(&width) && (1..=Self::MAX_SIDE).contains(&height) {
            return Ok(());
        }
        Err(SceneError::invalid(format!("image is {width}x{height}: both must lie in 1…{}", Self::MAX_SIDE)))
    }

    /// Checks spheres: finite centres, and radii above 0.
    ///
    /// # Errors
    /// [`SceneError::Invalid`].
    pub fn check_spheres(spheres: &[Sphere]) -> Result<(), SceneError> {
        spheres.iter().try_for_each(Sphere::validate).map_err(SceneError::invalid)
    }

    /// Checks a background.
    ///
    /// # Errors
    /// [`SceneError::Invalid`].
    pub fn check_background(background: Vec3) -> Result<(), SceneError> {
        if is_color(background) {
            return Ok(());
        }
        Err(SceneError::invalid(format!("background is {background}: expected finite values ≥ 0")))
    }

    /// Checks a material of some number and what surfaces show beside it.
    ///
    /// # Errors
    /// [`SceneError::Invalid`].
    pub fn check_material(number: usize, material: &Material, surface: &Surface) -> Result<(), SceneError> {
        material.validate().map_err(|e| fault(&format_args!("material {number}"), &e))?;
        if surface.varies() && !material.takes_textures() {
            let name = material.name();
            return Err(SceneError::invalid(format!(
                "material {number} (`{name}`) has textures: the model takes none"
            )));
        }
        check_maps(number, surface)?;
        check_emission(number, surface)
    }

    /// Checks an object that is in this scene, or is to be: its shape and proxy, its material, how near this camera sees it.
    ///
    /// # Errors
    /// [`SceneError::Invalid`].
    pub fn check_object(&self, object: &Object) -> Result<(), SceneError> {
        let name = format!("object \"{}\"", object.name);
        if object.material >= self.materials.len() {
            let (m, n) = (object.material, self.materials.len());
            return Err(SceneError::invalid(format!("{name} has material {m} of {n}")));
        }
        match &object.shape {
            // Checked as they were made.
            Shape::Instances(_) => {}
            Shape::Mesh(mesh) => mesh.validate().map_err(|e| fault(&name, &e))?,
            Shape::Spheres(spheres) if spheres.is_empty() => {
                return Err(SceneError::invalid(format!("{name} has no spheres")));
            }
            Shape::Spheres(spheres) => {
                Self::check_spheres(spheres).map_err(|e| fault(&name, &e))?;
                Self::check_seen_object(&self.camera, object)?;
            }
        }
        match &object.proxy {
            Proxy::Spheres(spheres) => {
                Self::check_spheres(spheres).map_err(|e| fault(&format_args!("proxy of {name}"), &e))?;
            }
            Proxy::Count(0) => return Err(SceneError::invalid(format!("proxy of {name} has no spheres"))),
            _ => {}
        }
        Self::check_colors(object, &self.materials[object.material])
    }

    /// Checks that a material takes the colours of an object's vertices, if these have any.
    ///
    /// # Errors
    /// [`SceneError::Invalid`].
    pub fn check_colors(object: &Object, material: &Material) -> Result<(), SceneError> {
        if !object.has_vertex_colors() || material.takes_textures() {
            return Ok(());
        }
        let (name, model) = (&object.name, material.name());
        Err(SceneError::invalid(format!("object \"{name}\" has vertex colours: the model `{model}` takes none")))
    }

    /// Checks another camera for this scene.
    ///
    /// # Errors
    /// [`SceneError::Invalid`].
    pub fn check_camera(&self, camera: &Camera) -> Result<(), SceneError> {
        camera.validate()?;
        self.objects.iter().try_for_each(|object| Self::check_seen_object(camera, object))
    }

    fn check_seen_object(camera: &Camera, object: &Object) -> Result<(), SceneError> {
        match &object.shape {
            Shape::Spheres(spheres) if object.visible => spheres
                .iter()
                .try_for_each(|sphere| check_seen(camera, sphere))
                .map_err(|e| fault(&format_args!("object \"{}\"", object.name), &e)),
            _ => Ok(()),
        }
    }

    /// Checks a light of some number: where it is, how large, and how bright.
    ///
    /// # Errors
    /// [`SceneError::Invalid`].
    pub fn check_light(number: usize, light: &Light) -> Result<(), SceneError> {
        light.kind().validate().map_err(|e| fault(&format_args!("light {number}"), &e))?;
        let radiance = light.full_radiance();
        if is_color(radiance) {
            return Ok(());
        }
        Err(SceneError::invalid(format!("light {number} has radiance {radiance}: expected finite values ≥ 0")))
    }
}

fn check_maps(number: usize, surface: &Surface) -> Result<(), SceneError> {
    let fault = |what: &str, value: &dyn Display| {
        SceneError::invalid(format!("material {number}: {what} is {value}: expected finite numbers"))
    };
    if let Some((name, map)) = surface.maps().find(|(_, map)| !map.transform.is_finite()) {
        return Err(fault(&format!("the transform of its {name} texture"), &map.transform));
    }
    let scales =
        [&surface.normal, &surface.clearcoat_normal].map(|normal| normal.as_ref().map_or(1.0, |normal| normal.1));
    if let Some(scale) = scales.iter().find(|scale| !scale.is_finite()) {
        return Err(fault("the scale of a normal map", scale));
    }
    if surface.anisotropy_turn.is_finite() {
        Ok(())
    } else {
        Err(fault("the turn of its grain", &surface.anisotropy_turn))
    }
}

fn check_emission(number: usize, surface: &Surface) -> Result<(), SceneError> {
    let emission = surface.emission;
    if is_color(emission) {
        return Ok(());
    }
    Err(SceneError::invalid(format!("material {number} emits {emission}: expected finite values ≥ 0")))
}

/// Points of a sphere are off its surface by up to 1e-7 of its radius: seen from too near they are noise.
fn check_seen(camera: &Camera, sphere: &Sphere) -> Result<(), SceneError> {
    let radius = f64::from(sphere.radius);
    if let Projection::Orthographic { height } = camera.projection {
        return if radius <= MAX_RADIUS_SEEN * f64::from(height) {
            Ok(())
        } else {
            Err(SceneError::invalid(format!(
                "sphere of radius {radius:e} is seen in a picture {height:.3e} high: expected at least {:.3e}, or a plane",
                radius / MAX_RADIUS_SEEN
            )))
        };
    }
    let height = (sphere.center.as_dvec3().distance(camera.eye.as_dvec3()) - radius).abs();
    if radius <= MAX_RADIUS_SEEN * height {
        return Ok(());
    }
    Err(SceneError::invalid(format!(
        "sphere of radius {radius:e} is seen from {height:.3e} away: expected at least {:.3e}, or a plane",
        radius / MAX_RADIUS_SEEN
    )))
}

/// Radius over the eye's distance to its surface up to which single precision shows a sphere well: speckles begin at 5e6.
const MAX_RADIUS_SEEN: f64 = 2e6;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Encoding, Texture, TextureMap};
    use glam::{Affine2, Vec2};

    #[test]
    fn spheres_are_seen_in_pictures_that_are_not_too_small() {
        let sphere = Sphere { center: Vec3::ZERO, radius: 1000.0 };
        let camera = |height| Camera { projection: Projection::Orthographic { height }, ..Camera::default() };
        // How near the eye is does not matter.
        assert!(check_seen(&camera(1.0), &sphere).is_ok());
        let refused = check_seen(&camera(1e-4), &sphere).expect_err("too small").to_string();
        assert!(refused.contains("1.000e-4 high: expected at least 5.000e-4"), "{refused}");
    }

    #[test]
    fn maps_have_finite_places() {
        let texture = Texture::new("grey", [1, 1], vec![[128; 4]], Encoding::Linear);
        let map = |transform| TextureMap { transform, ..TextureMap::new(texture.clone()) };
        let lambert = Material::lambert(Vec3::ONE);
        let check = |surface| Scene::check_material(3, &lambert, &surface).map_err(|error| error.to_string());
        let colored = |transform| Surface { color: Some(map(transform)), ..Surface::default() };
        assert_eq!(check(colored(Affine2::IDENTITY)), Ok(()));
        let refused = check(colored(Affine2::from_scale(Vec2::new(f32::NAN, 1.0)))).expect_err("a scale of NaN");
        assert!(refused.starts_with("material 3: the transform of its color texture is "), "{refused}");
        let bumpy = Surface { normal: Some((map(Affine2::IDENTITY), f32::INFINITY)), ..Surface::default() };
        let refused = check(bumpy).expect_err("an infinite scale");
        assert_eq!(refused, "material 3: the scale of a normal map is inf: expected finite numbers");
    }

    #[test]
    fn triangles_can_be_numbered() {
        assert!(check_triangles(MOST_TRIANGLES).is_ok());
        let refused = check_triangles(MOST_TRIANGLES + 1).expect_err("too many").to_string();
        assert!(refused.contains("2147483649 triangles: expected 2^31"), "{refused}");
    }
}
