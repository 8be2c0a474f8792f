use crate::{Camera, Mesh};
use brdf::Material;
use glam::Vec3;
use lighting::SphereLight;
use lobe_core::Sphere;
use std::path::PathBuf;

/// What an object looks like.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// Triangles.
    Mesh(Mesh),
    /// Exact balls.
    Spheres(Vec<Sphere>),
}

/// How an object blocks light in the `spheres` strategy.
#[derive(Clone, Debug, PartialEq)]
pub enum Proxy {
    /// It blocks nothing (floors and walls that nothing is behind).
    None,
    /// Inner spheres built from the mesh.
    Count(usize),
    /// A sphere set in a file.
    File(PathBuf),
    /// These spheres, in world space.
    Spheres(Vec<Sphere>),
}

/// One thing in the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    /// Its name in messages.
    pub name: String,
    /// Geometry in world space.
    pub shape: Shape,
    /// Index into [`Scene::materials`].
    pub material: usize,
    /// What it blocks light with.
    pub proxy: Proxy,
    /// Whether the camera sees it.
    pub visible: bool,
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
    /// Radiance where the camera sees nothing.
    pub background: Vec3,
    /// Materials; objects refer to them by index.
    pub materials: Vec<Material>,
    /// Objects; a receiver's `object` number is an index into this.
    pub objects: Vec<Object>,
    /// Lights.
    pub lights: Vec<SphereLight>,
}
