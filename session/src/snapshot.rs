use crate::Primitive;
use brdf::Material;
use glam::{DVec3, Mat4};
use lighting::Light;
use renderer::{LightHandle, MaterialHandle, ObjectHandle, Renderer, Settings};
use scene::{Bounds, Camera, Proxy, Shape, Strategy, Surface};

/// The scene that a picture shows, without its geometry: what a window lists, and what it draws handles on.
#[derive(Clone, Debug, Default)]
pub struct Snapshot {
    /// The camera.
    pub camera: Camera,
    /// Whether the animation moves it: edits of it are refused.
    pub is_camera_animated: bool,
    /// The [origin](scene::Animation::origin) of all coordinates, in those of the scene's file.
    pub origin: DVec3,
    /// Width and height of the whole picture.
    pub size: [u32; 2],
    /// The lights, in the order of the scene.
    pub lights: Vec<LightItem>,
    /// The objects, in the order of the scene.
    pub objects: Vec<ObjectItem>,
    /// The materials, in the order of the scene.
    pub materials: Vec<MaterialItem>,
    /// How it is drawn.
    pub settings: Settings,
    /// The device: `cpu`, or the name of a GPU.
    pub device: String,
    /// The moment of the animation, in seconds.
    pub time: f32,
    /// Seconds of the animation; 0 where nothing moves.
    pub duration: f32,
    /// Numbers of steps that can be taken back, and made again.
    pub steps: [usize; 2],
    /// Entries of the scene file that are there no more.
    #[cfg(feature = "files")]
    pub(crate) cuts: crate::saving::Cuts,
}

/// A light of a [`Snapshot`].
#[derive(Clone, Debug)]
pub struct LightItem {
    /// Its handle.
    pub handle: LightHandle,
    /// The light.
    pub light: Light,
    /// Whether the animation moves it: edits of it are refused.
    pub is_animated: bool,
}

/// An object of a [`Snapshot`].
#[derive(Clone, Debug)]
pub struct ObjectItem {
    /// Its handle.
    pub handle: ObjectHandle,
    /// Its name.
    pub name: String,
    /// The box around it.
    pub bounds: Bounds,
    /// Its number of triangles, or of exact spheres.
    pub parts: usize,
    /// Its material, as a place in [`Snapshot::materials`].
    pub material: usize,
    /// The sphere or the box that it was when it came, if it was one.
    pub primitive: Option<Primitive>,
    /// The strategy that it is given; none: the renderer's choice.
    pub strategy: Option<Strategy>,
    /// The strategy that its shadow takes.
    pub taken: Strategy,
    /// Whether the camera sees it.
    pub visible: bool,
    /// Whether nothing stands for it: a floor or a wall, which the view need not hold as a whole.
    pub is_backdrop: bool,
    /// The matrix of [`Renderer::set_transform`].
    pub transform: Mat4,
    /// Whether the animation moves it: edits of its transform are refused.
    pub is_animated: bool,
}

/// A material of a [`Snapshot`].
#[derive(Clone, Debug)]
pub struct MaterialItem {
    /// Its handle.
    pub handle: MaterialHandle,
    /// The material.
    pub material: Material,
    /// Textures and emission.
    pub surface: Surface,
}

impl Snapshot {
    /// The scene of a renderer; `bounds` are those of its objects.
    pub(crate) fn new(renderer: &Renderer, bounds: &[Bounds], steps: [usize; 2]) -> Self {
        let (scene, animation, plan) = (renderer.scene(), renderer.animation(), renderer.plan());
        let light = |(place, (handle, light)): (usize, (LightHandle, &Light))| LightItem {
            handle,
            light: light.clone(),
            is_animated: animation.moves_light(place),
        };
        let object = |(place, (handle, object)): (usize, (ObjectHandle, &scene::Object))| ObjectItem {
            handle,
            name: object.name.clone(),
            bounds: bounds.get(place).copied().unwrap_or(Bounds::EMPTY),
            parts: match &object.shape {
                Shape::Mesh(_) | Shape::Instances(_) => object.shape.triangle_count(),
                Shape::Spheres(spheres) => spheres.len(),
            },
            material: object.material,
            primitive: Primitive::of(object, renderer.transform(handle).unwrap_or(Mat4::IDENTITY)),
            strategy: object.strategy,
            taken: plan.of(place),
            visible: object.visible,
            is_backdrop: object.proxy == Proxy::None,
            transform: renderer.transform(handle).unwrap_or(Mat4::IDENTITY),
            is_animated: animation.moves_object(place),
        };
        let material = |(place, (handle, material)): (usize, (MaterialHandle, &Material))| MaterialItem {
            handle,
            material: material.clone(),
            surface: scene.surfaces.get(place).cloned().unwrap_or_default(),
        };
        Self {
            camera: scene.camera,
            is_camera_animated: animation.moves_camera(),
            origin: animation.origin(),
            size: [scene.width, scene.height],
            lights: renderer.lights().enumerate().map(light).collect(),
            objects: renderer.objects().enumerate().map(object).collect(),
            materials: renderer.materials().enumerate().map(material).collect(),
            settings: renderer.settings().clone(),
            device: renderer.backend().name(),
            time: renderer.time(),
            duration: animation.duration(),
            steps,
            #[cfg(feature = "files")]
            cuts: crate::saving::Cuts::default(),
        }
    }

    /// The box around all that is seen but floors and walls; around these where there is nothing else, and around the camera's target in
    /// an empty scene.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        let seen = || self.objects.iter().filter(|object| object.visible);
        let around = |all: &mut dyn Iterator<Item = &ObjectItem>| all.fold(Bounds::EMPTY, |b, o| b.union(o.bounds));
        let things = around(&mut seen().filter(|object| !object.is_backdrop));
        let all = if things.is_empty() { around(&mut seen()) } else { things };
        if all.is_empty() { Bounds::EMPTY.with_point(self.camera.target) } else { all }
    }

    /// A light by its handle.
    #[must_use]
    pub fn light(&self, handle: LightHandle) -> Option<&LightItem> {
        self.lights.iter().find(|item| item.handle == handle)
    }

    /// An object by its handle.
    #[must_use]
    pub fn object(&self, handle: ObjectHandle) -> Option<&ObjectItem> {
        self.objects.iter().find(|item| item.handle == handle)
    }
}
