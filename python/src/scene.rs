use crate::args::{color, type_name};
use crate::camera::Camera;
use crate::environment::{self, Environment};
use crate::errors::OrRaise;
use crate::light::Light;
use crate::load::Choices;
use crate::material::Material;
use crate::mesh::{Arrays, Manner, sphere_rows};
use crate::values::vector;
use crate::work::warn;
use cosine_lobes::scene::{self, Animation};
use cosine_lobes::{brdf, lighting};
use glam::Vec3;
use pyo3::exceptions::{PyIndexError, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyMapping};
use std::path::PathBuf;

/// Everything that a picture is made of: objects, materials, lights, a camera; from files or from arrays.
#[pyclass(module = "cosine_lobes")]
pub(crate) struct Scene {
    pub(crate) scene: scene::Scene,
    pub(crate) animation: Animation,
    warnings: Vec<String>,
    /// The material of objects that state none.
    usual: Option<usize>,
}

/// The size of a picture of a scene that states none, that of scene files.
const SIZE: (u32, u32) = (960, 540);
/// The reflectance of an object that states no material.
const GREY: f32 = 0.5;

impl Scene {
    fn of(scene: scene::Scene, animation: Animation, warnings: Vec<String>) -> Self {
        Self { scene, animation, warnings, usual: None }
    }

    /// The number of a material: one of the scene's, or a new one.
    fn material_number(&mut self, material: Option<&Bound<'_, PyAny>>) -> PyResult<usize> {
        let Some(material) = material else {
            return Ok(match self.usual {
                Some(number) => number,
                None => {
                    let number = self.push(brdf::Material::lambert(Vec3::splat(GREY)), scene::Surface::default());
                    *self.usual.insert(number)
                }
            });
        };
        if let Ok(material) = material.extract::<Material>() {
            return Ok(self.push(material.material, material.surface));
        }
        let count = self.scene.materials.len();
        match material.extract::<usize>() {
            Ok(number) if number < count => Ok(number),
            Ok(number) => {
                Err(PyIndexError::new_err(format!("material {number} is not in the scene: there are {count}")))
            }
            Err(_) => {
                let kind = type_name(material);
                Err(PyTypeError::new_err(format!("material is of type {kind}: expected a Material or a number")))
            }
        }
    }

    fn push(&mut self, material: brdf::Material, surface: scene::Surface) -> usize {
        let number = self.scene.materials.len();
        self.scene.materials.push(material);
        if !surface.is_plain() {
            self.scene.surfaces.resize(number, scene::Surface::default());
            self.scene.surfaces.push(surface);
        }
        number
    }

    /// Adds an object that the scene accepts; its number.
    fn add(&mut self, object: scene::Object) -> PyResult<usize> {
        self.scene.check_object(&object).or_raise()?;
        self.scene.objects.push(object);
        Ok(self.scene.objects.len() - 1)
    }

    /// Adds one of `from_arrays`.
    fn add_item(slf: &Bound<'_, Self>, item: &Bound<'_, PyAny>) -> PyResult<()> {
        let wrong = || {
            let kind = type_name(item);
            PyTypeError::new_err(format!(
                "meshes: one is of type {kind}: expected dictionaries of arguments of add_mesh"
            ))
        };
        let arguments = PyDict::new(slf.py());
        arguments.update(item.cast::<PyMapping>().map_err(|_| wrong())?)?;
        slf.call_method("add_mesh", (), Some(&arguments)).map(drop)
    }
}

#[pymethods]
impl Scene {
    /// An empty scene.
    #[new]
    #[pyo3(signature = (*, size = None, camera = None, background = None))]
    fn new(size: Option<(u32, u32)>, camera: Option<Camera>, background: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        let mut scene = Self::of(scene::Scene::default(), Animation::default(), Vec::new());
        scene.set_size(size.unwrap_or(SIZE))?;
        if let Some(camera) = camera {
            scene.scene.camera = camera.camera;
        }
        if let Some(background) = background {
            scene.set_background(background)?;
        }
        Ok(scene)
    }

    /// Loads a scene file (.toml) or a model (.glb, .gltf, .obj, .ply), as the command does: a model gets a floor, a light and, where it
    /// has none, a camera.
    ///
    /// `normals` of models are those of the "file", of each "face", or "smooth" ones across edges of at most `crease` degrees. `terminator`,
    /// "exact" or "smooth", is where light ends on smooth meshes. Objects that emit have an `emission` that "lights" the others, or is "seen" alone. The
    /// `studio` lights a model without lights, "soft" (as without a choice) or by its "key" alone; chosen, also one in which objects emit.
    #[staticmethod]
    #[pyo3(signature = (path, *, clip = None, size = None, normals = "file", crease = 180.0, terminator = "exact", emission = "lights", studio = None))]
    #[expect(clippy::too_many_arguments, reason = "each is a keyword")]
    fn load(
        py: Python<'_>,
        path: PathBuf,
        clip: Option<String>,
        size: Option<(u32, u32)>,
        normals: &str,
        crease: f64,
        terminator: &str,
        emission: &str,
        studio: Option<&str>,
    ) -> PyResult<Self> {
        let options = Choices { clip, normals, crease, terminator, emission, studio }.options()?;
        let read = || scene::load_with(&path, &options);
        let (scene, animation, warnings) = py.detach(read).or_raise()?;
        warnings.iter().try_for_each(|text| warn(py, text))?;
        let mut scene = Self::of(scene, animation, warnings);
        if let Some(size) = size {
            scene.set_size(size)?;
        }
        Ok(scene)
    }

    /// The scene that needs no file.
    #[staticmethod]
    #[pyo3(signature = (*, size = None))]
    fn builtin(size: Option<(u32, u32)>) -> PyResult<Self> {
        let mut scene = Self::of(scene::builtin(), Animation::default(), Vec::new());
        if let Some(size) = size {
            scene.set_size(size)?;
        }
        Ok(scene)
    }

    /// A scene of arrays: `meshes` are dictionaries of the arguments of `add_mesh`.
    #[staticmethod]
    #[pyo3(signature = (meshes, *, lights, camera, size = None, background = None, environment = None))]
    fn from_arrays<'py>(
        py: Python<'py>,
        meshes: Vec<Bound<'py, PyAny>>,
        lights: Vec<Light>,
        camera: Camera,
        size: Option<(u32, u32)>,
        background: Option<&Bound<'py, PyAny>>,
        environment: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, Self>> {
        let scene = Bound::new(py, Self::new(size, Some(camera), background)?)?;
        meshes.iter().try_for_each(|mesh| Self::add_item(&scene, mesh))?;
        {
            let mut scene = scene.borrow_mut();
            for light in lights {
                scene.add_light(light)?;
            }
            if let Some(environment) = environment {
                scene.set_environment(environment)?;
            }
        }
        Ok(scene)
    }

    /// Adds a mesh; its number. Without normals its faces are flat, unless it is `smooth`. It blocks light by its silhouettes, or as
    /// `visibility` says. At `places`, matrices from the mesh's own coordinates to the world, it stands many times and is stored once.
    #[pyo3(signature = (positions, triangles, *, normals = None, uvs = None, colors = None, smooth = false, material = None, name = None, visible = true, visibility = None, spheres = None, terminator = None, places = None))]
    #[expect(clippy::too_many_arguments, reason = "each is a keyword")]
    fn add_mesh(
        &mut self,
        py: Python<'_>,
        positions: &Bound<'_, PyAny>,
        triangles: &Bound<'_, PyAny>,
        normals: Option<&Bound<'_, PyAny>>,
        uvs: Option<&Bound<'_, PyAny>>,
        colors: Option<&Bound<'_, PyAny>>,
        smooth: bool,
        material: Option<&Bound<'_, PyAny>>,
        name: Option<String>,
        visible: bool,
        visibility: Option<&str>,
        spheres: Option<&Bound<'_, PyAny>>,
        terminator: Option<&str>,
        places: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<usize> {
        let mesh = Arrays { positions, triangles, normals, uvs, colors, smooth }.mesh(py)?;
        let manner = Manner { name, visible, visibility, spheres, terminator, places };
        let object = manner.mesh(mesh, 0, self.scene.objects.len())?;
        let material = self.material_number(material)?;
        self.add(scene::Object { material, ..object })
    }

    /// Adds exact spheres, rows of x, y, z and radius; their number as one object.
    #[pyo3(signature = (spheres, *, material = None, name = None, visible = true, visibility = None))]
    fn add_spheres(
        &mut self,
        spheres: &Bound<'_, PyAny>,
        material: Option<&Bound<'_, PyAny>>,
        name: Option<String>,
        visible: bool,
        visibility: Option<&str>,
    ) -> PyResult<usize> {
        let manner = Manner { name, visible, visibility, spheres: None, terminator: None, places: None };
        let object = manner.spheres(sphere_rows("spheres", spheres)?, 0, self.scene.objects.len())?;
        let material = self.material_number(material)?;
        self.add(scene::Object { material, ..object })
    }

    /// Adds a material; its number, which objects may share.
    fn add_material(&mut self, material: Material) -> usize {
        self.push(material.material, material.surface)
    }

    /// Adds a light; its number.
    fn add_light(&mut self, light: Light) -> PyResult<usize> {
        let number = self.scene.lights.len();
        scene::Scene::check_light(number, &light.0).or_raise()?;
        self.scene.lights.push(light.0);
        Ok(number)
    }

    /// Replaces the environment, or takes it away.
    fn set_environment(&mut self, environment: &Bound<'_, PyAny>) -> PyResult<()> {
        let environment: Option<PyRef<'_, Environment>> = environment::optional(environment)?;
        let world = self.scene.bounds().world();
        self.scene.lights.retain(|light| !matches!(light, lighting::Light::Sky(_)));
        let environment = environment.map(|environment| environment.around(world));
        if let Some(environment) = &environment {
            self.scene.lights.extend_from_slice(environment.lights());
        }
        self.scene.environment = environment;
        Ok(())
    }

    /// Checks everything that a renderer relies on.
    fn validate(&self) -> PyResult<()> {
        self.scene.validate().or_raise()
    }

    #[getter]
    fn camera(&self) -> Camera {
        Camera::of(self.scene.camera)
    }

    #[setter]
    fn set_camera(&mut self, camera: Camera) -> PyResult<()> {
        self.scene.check_camera(&camera.camera).or_raise()?;
        self.scene.camera = camera.camera;
        Ok(())
    }

    /// Width and height of pictures.
    #[getter]
    fn size(&self) -> (u32, u32) {
        (self.scene.width, self.scene.height)
    }

    #[setter]
    fn set_size(&mut self, size: (u32, u32)) -> PyResult<()> {
        let (width, height) = size;
        scene::Scene::check_size(width, height).or_raise()?;
        (self.scene.width, self.scene.height) = (width, height);
        Ok(())
    }

    /// Radiance where the camera sees nothing.
    #[getter]
    fn background(&self) -> (f32, f32, f32) {
        vector(self.scene.background)
    }

    #[setter]
    fn set_background(&mut self, background: &Bound<'_, PyAny>) -> PyResult<()> {
        self.scene.background = color("background", background)?;
        Ok(())
    }

    /// The lights, those of the environment included.
    #[getter]
    fn lights(&self) -> Vec<Light> {
        self.scene.lights.iter().cloned().map(Light).collect()
    }

    /// The names of the objects, in their order.
    #[getter]
    fn objects(&self) -> Vec<String> {
        self.scene.objects.iter().map(|object| object.name.clone()).collect()
    }

    /// The materials, in their order.
    #[getter]
    fn materials(&self) -> Vec<Material> {
        let surface = |number: usize| self.scene.surfaces.get(number).cloned().unwrap_or_default();
        let numbered = self.scene.materials.iter().enumerate();
        numbered.map(|(number, material)| Material { material: material.clone(), surface: surface(number) }).collect()
    }

    /// The number of triangles.
    #[getter]
    fn triangles(&self) -> usize {
        self.scene.triangles()
    }

    /// Seconds of the animation; 0 if nothing moves.
    #[getter]
    fn duration(&self) -> f32 {
        self.animation.duration()
    }

    /// Frames a second of the animation.
    #[getter]
    fn fps(&self) -> f32 {
        self.animation.fps()
    }

    /// One line for each thing that was left out or replaced while loading.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.warnings.clone()
    }

    fn __repr__(&self) -> String {
        let scene = &self.scene;
        let (objects, lights) = (scene.objects.len(), scene.lights.len());
        format!(
            "<Scene of {objects} objects, {} triangles, {lights} lights, {} x {} pixels>",
            scene.triangles(),
            scene.width,
            scene.height
        )
    }
}
