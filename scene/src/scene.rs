use crate::mesh::MAX_COORDINATE;
use crate::{Bounds, Camera, Mesh, SceneError, Strategy, Surface};
use brdf::Material;
use glam::{Mat4, Vec3};
use lighting::{Environment, Light};
use lobe_core::Sphere;
use std::path::PathBuf;
use std::sync::Arc;

/// The geometry of an object.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// Triangles.
    Mesh(Mesh),
    /// Exact spheres.
    Spheres(Vec<Sphere>),
}

/// How an object blocks light in the `spheres` strategy.
#[derive(Clone, Debug, PartialEq)]
pub enum Proxy {
    /// It blocks nothing (floors and walls that nothing is behind).
    None,
    /// So many inner spheres built from the mesh.
    Count(usize),
    /// A sphere set in a file, made for the mesh in its own coordinates.
    File {
        /// The file.
        path: PathBuf,
        /// From the mesh's own coordinates to the world at the first moment; its scale is the same along all axes.
        placement: Mat4,
    },
    /// These spheres, in world space.
    Spheres(Vec<Sphere>),
}

/// One thing in the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    /// Its name in messages and reports; several objects may have the same.
    pub name: String,
    /// Geometry in world space.
    pub shape: Shape,
    /// Index into [`Scene::materials`].
    pub material: usize,
    /// The spheres that block light for it.
    pub proxy: Proxy,
    /// Whether the camera sees it.
    pub visible: bool,
    /// How it blocks light; `None` for the renderer's own choice.
    pub strategy: Option<Strategy>,
}

/// Everything that a picture is made of.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// The camera.
    pub camera: Camera,
    /// Image width in pixels.
    pub width: u32,
    /// Image height in pixels.
    pub height: u32,
    /// Radiance where the camera sees nothing, not even an environment.
    pub background: Vec3,
    /// Materials; objects refer to them by index.
    pub materials: Vec<Material>,
    /// Textures and emission of the materials with the same numbers. Materials beyond the end have
    /// neither.
    pub surfaces: Vec<Surface>,
    /// Objects; a receiver's `object` number is an index into this.
    pub objects: Vec<Object>,
    /// Lights, those of the environment included; none gives a black picture.
    pub lights: Vec<Light>,
    /// The environment, seen where the camera sees nothing else.
    pub environment: Option<Arc<Environment>>,
}

/// The largest image edge accepted, in pixels.
pub(crate) const MAX_IMAGE: u32 = 16384;

impl Shape {
    /// The smallest box that holds the shape.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        match self {
            Self::Mesh(mesh) => mesh.bounds(),
            Self::Spheres(balls) => balls.iter().fold(Bounds::EMPTY, |b, &s| b.with_sphere(s)),
        }
    }
}

impl Object {
    /// Exact spheres that cast exact shadows: the proxy is the shape.
    #[must_use]
    pub fn spheres(name: impl Into<String>, balls: Vec<Sphere>, material: usize) -> Self {
        let proxy = Proxy::Spheres(balls.clone());
        Self { name: name.into(), shape: Shape::Spheres(balls), material, proxy, visible: true, strategy: None }
    }

    /// A mesh.
    #[must_use]
    pub fn mesh(name: impl Into<String>, mesh: Mesh, material: usize, proxy: Proxy) -> Self {
        Self { name: name.into(), shape: Shape::Mesh(mesh), material, proxy, visible: true, strategy: None }
    }
}

impl Scene {
    /// The smallest box that holds all objects (lights not included).
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        self.objects.iter().fold(Bounds::EMPTY, |b, o| b.union(o.shape.bounds()))
    }

    /// Textures and emission of a material; `None` if it has neither.
    #[must_use]
    pub fn surface(&self, material: usize) -> Option<&Surface> {
        self.surfaces.get(material).filter(|surface| !surface.is_plain())
    }

    /// The number of triangles in all meshes.
    #[must_use]
    pub fn triangles(&self) -> usize {
        let of = |o: &Object| match &o.shape {
            Shape::Mesh(mesh) => mesh.triangles.len(),
            Shape::Spheres(_) => 0,
        };
        self.objects.iter().map(of).sum()
    }

    /// The number of exact spheres in all objects.
    #[must_use]
    pub fn spheres(&self) -> usize {
        let of = |o: &Object| match &o.shape {
            Shape::Mesh(_) => 0,
            Shape::Spheres(balls) => balls.len(),
        };
        self.objects.iter().map(of).sum()
    }

    /// Checks everything that a renderer relies on: camera, image size, materials, meshes, spheres, proxies, lights, and
    /// that there is an object. [`load`](crate::load) has done so.
    ///
    /// A scene without lights is allowed: its picture is black.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] that names the first fault.
    pub fn validate(&self) -> Result<(), SceneError> {
        let fault = |what: String, e: &dyn std::fmt::Display| SceneError::invalid(format!("{what}: {e}"));
        self.camera.validate()?;
        if !(1..=MAX_IMAGE).contains(&self.width) || !(1..=MAX_IMAGE).contains(&self.height) {
            let (w, h) = (self.width, self.height);
            return Err(SceneError::invalid(format!("image is {w}x{h}: both must lie in 1…{MAX_IMAGE}")));
        }
        if !(self.background.is_finite() && self.background.min_element() >= 0.0) {
            let b = self.background;
            return Err(SceneError::invalid(format!("background is {b}: expected finite values ≥ 0")));
        }
        for (i, material) in self.materials.iter().enumerate() {
            material.validate().map_err(|e| fault(format!("material {i}"), &e))?;
        }
        for (i, surface) in self.surfaces.iter().enumerate() {
            let emission = surface.emission;
            if !(emission.is_finite() && emission.min_element() >= 0.0) {
                return Err(SceneError::invalid(format!("material {i} emits {emission}: expected finite values ≥ 0")));
            }
        }
        if self.objects.is_empty() {
            return Err(SceneError::invalid("scene has no objects"));
        }
        for object in &self.objects {
            let name = || format!("object \"{}\"", object.name);
            if object.material >= self.materials.len() {
                let (m, n) = (object.material, self.materials.len());
                return Err(SceneError::invalid(format!("{} has material {m} of {n}", name())));
            }
            match &object.shape {
                Shape::Mesh(mesh) => mesh.validate().map_err(|e| fault(name(), &e))?,
                Shape::Spheres(balls) if balls.is_empty() => {
                    return Err(SceneError::invalid(format!("{} has no spheres", name())));
                }
                Shape::Spheres(balls) => {
                    check_balls(balls).map_err(|e| fault(name(), &e))?;
                    if object.visible {
                        balls.iter().try_for_each(|b| self.check_seen(b)).map_err(|e| fault(name(), &e))?;
                    }
                }
            }
            if let Proxy::Spheres(balls) = &object.proxy {
                check_balls(balls).map_err(|e| fault(format!("proxy of {}", name()), &e))?;
            }
        }
        for (i, light) in self.lights.iter().enumerate() {
            if let Some(ball) = light.ball() {
                check_balls(&[ball]).map_err(|e| fault(format!("light {i}"), &e))?;
            }
            let r = light.full_radiance();
            if !(r.is_finite() && r.min_element() >= 0.0) {
                return Err(SceneError::invalid(format!("light {i} has radiance {r}: expected finite values ≥ 0")));
            }
        }
        Ok(())
    }

    /// Points on a sphere have an error of up to 1e-7 of its radius: seen from too near they are noise.
    fn check_seen(&self, ball: &Sphere) -> Result<(), SceneError> {
        let radius = f64::from(ball.radius);
        let height = (ball.center.as_dvec3().distance(self.camera.eye.as_dvec3()) - radius).abs();
        if radius <= MAX_RADIUS_SEEN * height {
            return Ok(());
        }
        Err(SceneError::invalid(format!(
            "sphere of radius {radius:e} is seen from {height:.3e} away: expected at least {:.3e}, or a plane",
            radius / MAX_RADIUS_SEEN
        )))
    }
}

/// The largest radius over the eye's distance to its surface at which single precision shows a sphere well: speckles begin at 5e6.
const MAX_RADIUS_SEEN: f64 = 2e6;

pub(crate) fn check_balls(balls: &[Sphere]) -> Result<(), SceneError> {
    for ball in balls {
        if ball.center.is_nan() || ball.center.abs().max_element() > MAX_COORDINATE {
            let c = ball.center;
            return Err(SceneError::invalid(format!("sphere has centre {c}: coordinates must lie within ±1e9")));
        }
        if !(ball.radius > 0.0 && ball.radius <= MAX_COORDINATE) {
            let r = ball.radius;
            return Err(SceneError::invalid(format!("sphere has radius {r}: expected a positive number up to 1e9")));
        }
    }
    Ok(())
}
