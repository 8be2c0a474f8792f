use crate::{Bounds, Camera, Instances, Mesh, Strategy, Surface};
use brdf::Material;
use glam::{Mat4, Vec3};
use lighting::{Environment, Light};
use lobe_core::Sphere;
use std::borrow::Cow;
use std::path::PathBuf;
use std::sync::Arc;

/// The geometry of an object.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// Triangles.
    Mesh(Mesh),
    /// The triangles of one mesh at many places.
    Instances(Instances),
    /// Exact spheres.
    Spheres(Vec<Sphere>),
}

/// How an object blocks light in the `spheres` strategy.
#[derive(Clone, Debug, PartialEq)]
pub enum Proxy {
    /// No spheres: by this strategy it blocks nothing.
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
    /// How light ends on its smooth meshes.
    pub terminator: Terminator,
}

/// How light ends on a mesh whose normals are smooth and whose faces are not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Terminator {
    /// At the faces, which hide from themselves what is behind them: the truth of the triangles, in steps of a face.
    #[default]
    Exact,
    /// As on the rounded surface that the normals describe: points are raised onto it before they are lit, and the smooth normal bounds what
    /// they see. Shadows that the mesh casts stay those of its triangles.
    Smooth,
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

impl Default for Scene {
    /// Nothing, in 640 × 360 pixels before black.
    fn default() -> Self {
        Self {
            camera: Camera::default(),
            width: 640,
            height: 360,
            background: Vec3::ZERO,
            materials: Vec::new(),
            surfaces: Vec::new(),
            objects: Vec::new(),
            lights: Vec::new(),
            environment: None,
        }
    }
}

impl Shape {
    /// The smallest box that holds the shape.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        match self {
            Self::Mesh(mesh) => mesh.bounds(),
            Self::Instances(instances) => instances.bounds(),
            Self::Spheres(spheres) => spheres.iter().fold(Bounds::EMPTY, |b, &s| b.with_sphere(s)),
        }
    }
}

impl Shape {
    /// The triangles as one mesh in world space, if it has any.
    ///
    /// # Cost
    /// Nothing for a mesh; the memory of all copies for [instances](Instances::expanded).
    #[must_use]
    pub fn mesh(&self) -> Option<Cow<'_, Mesh>> {
        match self {
            Self::Mesh(mesh) => Some(Cow::Borrowed(mesh)),
            Self::Instances(instances) => Some(Cow::Owned(instances.expanded())),
            Self::Spheres(_) => None,
        }
    }

    /// Whether it consists of triangles.
    #[must_use]
    pub const fn has_triangles(&self) -> bool {
        matches!(self, Self::Mesh(_) | Self::Instances(_))
    }

    /// The number of triangles, all copies included.
    #[must_use]
    pub fn triangle_count(&self) -> usize {
        match self {
            Self::Mesh(mesh) => mesh.triangles.len(),
            Self::Instances(instances) => instances.triangle_count(),
            Self::Spheres(_) => 0,
        }
    }

    /// The mesh that textures and vertex colours come from: of instances the shared one, in its own coordinates.
    #[must_use]
    pub fn vertices(&self) -> Option<&Mesh> {
        match self {
            Self::Mesh(mesh) => Some(mesh),
            Self::Instances(instances) => Some(instances.mesh()),
            Self::Spheres(_) => None,
        }
    }

    /// The corners of a triangle in world space, by its number; `None` if there is no such triangle.
    #[must_use]
    pub fn corners(&self, triangle: usize) -> Option<[Vec3; 3]> {
        match self {
            Self::Mesh(mesh) => Some(mesh.triangles.get(triangle)?.map(|i| mesh.positions[i as usize])),
            Self::Instances(instances) => (triangle < instances.triangle_count()).then(|| instances.corners(triangle)),
            Self::Spheres(_) => None,
        }
    }
}

impl Object {
    /// Whether rays may meet it: it is seen, or blocks light unseen.
    #[must_use]
    pub fn is_met(&self) -> bool {
        self.visible || self.proxy != Proxy::None || self.shape.has_triangles() && self.strategy != Some(Strategy::None)
    }

    /// Whether its vertices have colours.
    #[must_use]
    pub fn has_vertex_colors(&self) -> bool {
        self.shape.vertices().is_some_and(|mesh| !mesh.colors.is_empty())
    }

    /// Exact spheres that cast exact shadows: the proxy is the shape.
    #[must_use]
    pub fn spheres(name: impl Into<String>, spheres: Vec<Sphere>, material: usize) -> Self {
        let proxy = Proxy::Spheres(spheres.clone());
        Self {
            name: name.into(),
            shape: Shape::Spheres(spheres),
            material,
            proxy,
            visible: true,
            strategy: None,
            terminator: Terminator::Exact,
        }
    }

    /// A mesh.
    #[must_use]
    pub fn mesh(name: impl Into<String>, mesh: Mesh, material: usize, proxy: Proxy) -> Self {
        Self {
            name: name.into(),
            shape: Shape::Mesh(mesh),
            material,
            proxy,
            visible: true,
            strategy: None,
            terminator: Terminator::Exact,
        }
    }
}

impl Scene {
    /// The smallest box that holds all objects (lights not included).
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        self.objects.iter().fold(Bounds::EMPTY, |b, o| b.union(o.shape.bounds()))
    }

    /// A sphere of an object as it casts shadows: one that [shows a light](Light::inside_of) is a little inside of it, so that it does not hide that light.
    #[must_use]
    pub fn casting(&self, sphere: &Sphere) -> Sphere {
        let inside = self.lights.iter().filter_map(|light| light.inside_of(sphere));
        inside.reduce(|a, b| if b.radius < a.radius { b } else { a }).unwrap_or(*sphere)
    }

    /// Lets lights that are farther away than the scene, or everywhere, hold all objects in the
    /// [sphere](Light::world) that they are made for, where objects have left it. Whether any light has changed.
    ///
    /// Cost: one look at each vertex, where there is such a light.
    pub fn fit_lights(&mut self) -> bool {
        if self.lights.iter().all(|light| light.world().is_none()) {
            return false;
        }
        let bounds = self.bounds();
        let around = bounds.sphere();
        let mut is_changed = false;
        for light in &mut self.lights {
            // To rounding: it may have been made for just these objects.
            let holds = |world: Sphere| bounds.farthest(world.center) <= world.radius * (1.0 + 1e-5);
            if !bounds.is_empty() && light.world().is_some_and(|world| !holds(world)) {
                light.set_world(around);
                is_changed = true;
            }
        }
        is_changed
    }

    /// Textures and emission of a material; `None` if it has neither.
    #[must_use]
    pub fn surface(&self, material: usize) -> Option<&Surface> {
        self.surfaces.get(material).filter(|surface| !surface.is_plain())
    }

    /// The number of triangles in all meshes.
    #[must_use]
    pub fn triangles(&self) -> usize {
        self.objects.iter().map(|o| o.shape.triangle_count()).sum()
    }

    /// The number of exact spheres in all objects.
    #[must_use]
    pub fn spheres(&self) -> usize {
        let of = |o: &Object| match &o.shape {
            Shape::Mesh(_) | Shape::Instances(_) => 0,
            Shape::Spheres(spheres) => spheres.len(),
        };
        self.objects.iter().map(of).sum()
    }
}
