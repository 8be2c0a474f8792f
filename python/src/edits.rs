//! Edits of a renderer's scene.

use crate::args::{color, matrices, matrix, type_name};
use crate::camera::Camera;
use crate::environment;
use crate::errors::OrRaise;
use crate::handles::{self, LightHandle, MaterialHandle, ObjectHandle};
use crate::light::Light;
use crate::material::Material;
use crate::mesh::{Arrays, Manner, instances, sphere_rows, strategy};
use crate::renderer::{Inner, Renderer};
use crate::settings::Settings;
use crate::values;
use cosine_lobes::renderer as lobes;
use cosine_lobes::scene::{Object, Proxy, Shape};
use cosine_lobes::session::Edit;
use glam::Vec3;
use numpy::{PyArray2, PyArray3};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::Arc;

impl Inner {
    fn light(&self, handle: lobes::LightHandle) -> PyResult<Light> {
        let found = self.renderer.lights().find(|(known, _)| *known == handle);
        let gone = || lobes::RenderError::from(lobes::EditError::NoLight(handle));
        Ok(Light(found.ok_or_else(gone).or_raise()?.1.clone()))
    }

    fn object(&self, handle: lobes::ObjectHandle) -> PyResult<&Object> {
        let found = self.renderer.objects().find(|(known, _)| *known == handle);
        let gone = || lobes::RenderError::from(lobes::EditError::NoObject(handle));
        Ok(found.ok_or_else(gone).or_raise()?.1)
    }

    fn material(&self, handle: lobes::MaterialHandle) -> PyResult<Material> {
        let place = self.renderer.materials().position(|(known, _)| known == handle);
        let gone = || lobes::RenderError::from(lobes::EditError::NoMaterial(handle));
        let (place, scene) = (place.ok_or_else(gone).or_raise()?, self.renderer.scene());
        let surface = scene.surfaces.get(place).cloned().unwrap_or_default();
        Ok(Material { material: scene.materials[place].clone(), surface })
    }

    /// The number of a material for a new object: of one of the scene, or of a new one.
    fn material_number(&mut self, value: Option<&Bound<'_, PyAny>>, this: u64) -> PyResult<usize> {
        let usual = || Material {
            material: cosine_lobes::brdf::Material::lambert(Vec3::splat(0.5)),
            surface: Default::default(),
        };
        let own = match value {
            None => usual(),
            Some(value) => match value.extract::<Material>() {
                Ok(own) => own,
                Err(_) => {
                    let handle = handles::material(value, &self.renderer, this)?;
                    self.material(handle)?;
                    let place = self.renderer.materials().position(|(known, _)| known == handle);
                    return Ok(place.unwrap_or(usize::MAX));
                }
            },
        };
        self.renderer.add_material(own.material, own.surface).or_raise()?;
        Ok(self.renderer.scene().materials.len() - 1)
    }
}

/// The pairs of a dictionary argument.
fn pairs<'py>(value: Option<&Bound<'py, PyDict>>) -> Vec<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
    value.map_or_else(Vec::new, |value| value.iter().collect())
}

fn of_type<'py, T>(name: &str, value: &Bound<'py, PyAny>, wanted: &str) -> PyResult<T>
where
    T: for<'a> FromPyObject<'a, 'py>,
{
    let wrong = || PyTypeError::new_err(format!("{name} is of type {}: expected a {wanted}", type_name(value)));
    value.extract::<T>().map_err(|_| wrong())
}

#[pymethods]
impl Renderer {
    /// Several edits at once: all of them, or none where one is refused. Keys are handles, numbers or names of objects.
    #[pyo3(signature = (*, lights = None, transforms = None, materials = None, object_materials = None, visible = None, visibility = None, camera = None, size = None, time = None))]
    #[expect(clippy::too_many_arguments, reason = "each is a keyword")]
    fn edit(
        &self,
        py: Python<'_>,
        lights: Option<&Bound<'_, PyDict>>,
        transforms: Option<&Bound<'_, PyDict>>,
        materials: Option<&Bound<'_, PyDict>>,
        object_materials: Option<&Bound<'_, PyDict>>,
        visible: Option<&Bound<'_, PyDict>>,
        visibility: Option<&Bound<'_, PyDict>>,
        camera: Option<Camera>,
        size: Option<(u32, u32)>,
        time: Option<f32>,
    ) -> PyResult<()> {
        let mut held = self.hold(py)?;
        let (renderer, this) = (&held.value.renderer, self.number);
        let mut all = Vec::new();
        if let Some(time) = time {
            if !(time >= 0.0 && time.is_finite()) {
                return Err(PyValueError::new_err(format!("time is {time}: expected seconds of at least 0")));
            }
            all.push(Edit::Seek(time));
        }
        for (key, light) in pairs(lights) {
            let light: Light = of_type("lights: a value", &light, "Light")?;
            all.push(Edit::Light(handles::light(&key, renderer, this)?, Box::new(light.0)));
        }
        for (key, transform) in pairs(transforms) {
            all.push(Edit::Transform(handles::object(&key, renderer, this)?, matrix("transform", &transform)?));
        }
        for (key, material) in pairs(materials) {
            let new: Material = of_type("materials: a value", &material, "Material")?;
            all.push(Edit::Material(handles::material(&key, renderer, this)?, new.material, Box::new(new.surface)));
        }
        for (key, material) in pairs(object_materials) {
            let material = handles::material(&material, renderer, this)?;
            all.push(Edit::MaterialOf(handles::object(&key, renderer, this)?, material));
        }
        for (key, is_visible) in pairs(visible) {
            all.push(Edit::Visible(handles::object(&key, renderer, this)?, is_visible.extract()?));
        }
        for (key, name) in pairs(visibility) {
            let name: Option<String> = name.extract()?;
            all.push(Edit::Strategy(handles::object(&key, renderer, this)?, strategy(name.as_deref())?));
        }
        all.extend(camera.map(|camera| Edit::Camera(camera.camera)));
        all.extend(size.map(|(width, height)| Edit::Size(width, height)));
        Edit::All(all).apply(&mut held.value.renderer).or_raise().map(drop)
    }

    /// The lights, those of the environment included.
    #[getter]
    fn lights(&self, py: Python<'_>) -> PyResult<Vec<LightHandle>> {
        let of = self.number;
        Ok(self.hold(py)?.value.renderer.lights().map(|(handle, _)| LightHandle { handle, of }).collect())
    }

    /// The objects.
    #[getter]
    fn objects(&self, py: Python<'_>) -> PyResult<Vec<ObjectHandle>> {
        let of = self.number;
        Ok(self.hold(py)?.value.renderer.objects().map(|(handle, _)| ObjectHandle { handle, of }).collect())
    }

    /// The materials.
    #[getter]
    fn materials(&self, py: Python<'_>) -> PyResult<Vec<MaterialHandle>> {
        let of = self.number;
        Ok(self.hold(py)?.value.renderer.materials().map(|(handle, _)| MaterialHandle { handle, of }).collect())
    }

    /// A light.
    fn light(&self, py: Python<'_>, light: &Bound<'_, PyAny>) -> PyResult<Light> {
        let held = self.hold(py)?;
        held.value.light(handles::light(light, &held.value.renderer, self.number)?)
    }

    /// Replaces a light. A light that moves rebuilds nothing.
    fn set_light(&self, py: Python<'_>, light: &Bound<'_, PyAny>, new: Light) -> PyResult<()> {
        let mut held = self.hold(py)?;
        let handle = handles::light(light, &held.value.renderer, self.number)?;
        held.value.renderer.set_light(handle, new.0).or_raise().map(drop)
    }

    /// Adds a light.
    fn add_light(&self, py: Python<'_>, light: Light) -> PyResult<LightHandle> {
        let handle = self.hold(py)?.value.renderer.add_light(light.0).or_raise()?;
        Ok(LightHandle { handle, of: self.number })
    }

    /// Removes a light, and returns it.
    fn remove_light(&self, py: Python<'_>, light: &Bound<'_, PyAny>) -> PyResult<Light> {
        let mut held = self.hold(py)?;
        let handle = handles::light(light, &held.value.renderer, self.number)?;
        held.value.renderer.remove_light(handle).or_raise().map(Light)
    }

    /// Replaces the environment, or takes it away.
    fn set_environment(&self, py: Python<'_>, environment: &Bound<'_, PyAny>) -> PyResult<()> {
        let environment = environment::optional(environment)?;
        let mut held = self.hold(py)?;
        let world = held.value.renderer.scene().bounds().world();
        let environment = environment.map(|environment| environment.around(world));
        held.value.renderer.set_environment(environment).or_raise().map(drop)
    }

    /// The name of an object.
    fn name(&self, py: Python<'_>, object: &Bound<'_, PyAny>) -> PyResult<String> {
        let held = self.hold(py)?;
        let handle = handles::object(object, &held.value.renderer, self.number)?;
        Ok(held.value.object(handle)?.name.clone())
    }

    /// The matrix by which an object was moved from the place at which it was added.
    fn transform<'py>(&self, py: Python<'py>, object: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let held = self.hold(py)?;
        let handle = handles::object(object, &held.value.renderer, self.number)?;
        held.value.object(handle)?;
        values::matrix(py, &held.value.renderer.transform(handle).unwrap_or_default())
    }

    /// Moves an object from the place at which it was added.
    fn set_transform(&self, py: Python<'_>, object: &Bound<'_, PyAny>, matrix: &Bound<'_, PyAny>) -> PyResult<()> {
        let matrix = crate::args::matrix("matrix", matrix)?;
        let mut held = self.hold(py)?;
        let handle = handles::object(object, &held.value.renderer, self.number)?;
        held.value.renderer.set_transform(handle, matrix).or_raise().map(drop)
    }

    /// Adds a mesh; the arguments are those of `Scene.add_mesh`.
    #[pyo3(signature = (positions, triangles, *, normals = None, uvs = None, colors = None, smooth = false, material = None, name = None, visible = true, visibility = None, spheres = None, terminator = None, places = None))]
    #[expect(clippy::too_many_arguments, reason = "each is a keyword")]
    fn add_mesh(
        &self,
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
    ) -> PyResult<ObjectHandle> {
        let mesh = Arrays { positions, triangles, normals, uvs, colors, smooth }.mesh(py)?;
        let mut held = self.hold(py)?;
        let number = held.value.renderer.scene().objects.len();
        let object = Manner { name, visible, visibility, spheres, terminator, places }.mesh(mesh, 0, number)?;
        self.add(&mut held.value, object, material)
    }

    /// Adds exact spheres, rows of x, y, z and radius, as one object.
    #[pyo3(signature = (spheres, *, material = None, name = None, visible = true, visibility = None))]
    fn add_spheres(
        &self,
        py: Python<'_>,
        spheres: &Bound<'_, PyAny>,
        material: Option<&Bound<'_, PyAny>>,
        name: Option<String>,
        visible: bool,
        visibility: Option<&str>,
    ) -> PyResult<ObjectHandle> {
        let spheres = sphere_rows("spheres", spheres)?;
        let mut held = self.hold(py)?;
        let number = held.value.renderer.scene().objects.len();
        let object = Manner { name, visible, visibility, spheres: None, terminator: None, places: None }
            .spheres(spheres, 0, number)?;
        self.add(&mut held.value, object, material)
    }

    /// Gives an object another mesh, in world space.
    #[pyo3(signature = (object, positions, triangles, *, normals = None, uvs = None, colors = None, smooth = false))]
    #[expect(clippy::too_many_arguments, reason = "each is a keyword")]
    fn set_mesh(
        &self,
        py: Python<'_>,
        object: &Bound<'_, PyAny>,
        positions: &Bound<'_, PyAny>,
        triangles: &Bound<'_, PyAny>,
        normals: Option<&Bound<'_, PyAny>>,
        uvs: Option<&Bound<'_, PyAny>>,
        colors: Option<&Bound<'_, PyAny>>,
        smooth: bool,
    ) -> PyResult<()> {
        let mesh = Arrays { positions, triangles, normals, uvs, colors, smooth }.mesh(py)?;
        let mut held = self.hold(py)?;
        let handle = handles::object(object, &held.value.renderer, self.number)?;
        let proxy = match &held.value.object(handle)?.proxy {
            Proxy::Count(count) => Proxy::Count(*count),
            _ => Proxy::Count(64),
        };
        held.value.renderer.set_shape(handle, Shape::Mesh(mesh), proxy).or_raise().map(drop)
    }

    /// Lets the mesh of an object that was added with `places` stand at others. Nothing that was prepared of the mesh is made again.
    fn set_places(&self, py: Python<'_>, object: &Bound<'_, PyAny>, places: &Bound<'_, PyAny>) -> PyResult<()> {
        let places = matrices("places", places)?;
        let mut held = self.hold(py)?;
        let handle = handles::object(object, &held.value.renderer, self.number)?;
        let object = held.value.object(handle)?;
        let Shape::Instances(all) = &object.shape else {
            return Err(PyValueError::new_err(format!("{} was not added with places", object.name)));
        };
        let shape = instances(Arc::clone(all.mesh()), places)?;
        held.value.renderer.set_shape(handle, shape, Proxy::None).or_raise().map(drop)
    }

    /// The matrices of the places where an object's mesh stands, an array `(n, 4, 4)`; none for an object that was added without places.
    fn places<'py>(&self, py: Python<'py>, object: &Bound<'_, PyAny>) -> PyResult<Option<Bound<'py, PyArray3<f32>>>> {
        let held = self.hold(py)?;
        let handle = handles::object(object, &held.value.renderer, self.number)?;
        let Shape::Instances(all) = &held.value.object(handle)?.shape else { return Ok(None) };
        values::matrices(py, all.places()).map(Some)
    }

    /// Removes an object.
    fn remove_object(&self, py: Python<'_>, object: &Bound<'_, PyAny>) -> PyResult<()> {
        let mut held = self.hold(py)?;
        let handle = handles::object(object, &held.value.renderer, self.number)?;
        held.value.renderer.remove_object(handle).or_raise().map(drop)
    }

    /// Shows an object to the camera, or hides it.
    fn set_visible(&self, py: Python<'_>, object: &Bound<'_, PyAny>, visible: bool) -> PyResult<()> {
        let mut held = self.hold(py)?;
        let handle = handles::object(object, &held.value.renderer, self.number)?;
        held.value.renderer.set_visible(handle, visible).or_raise().map(drop)
    }

    /// Sets how an object blocks light; none for the usual way.
    fn set_visibility(&self, py: Python<'_>, object: &Bound<'_, PyAny>, visibility: Option<&str>) -> PyResult<()> {
        let strategy = strategy(visibility)?;
        let mut held = self.hold(py)?;
        let handle = handles::object(object, &held.value.renderer, self.number)?;
        held.value.renderer.set_object_strategy(handle, strategy).or_raise().map(drop)
    }

    /// A material.
    fn material(&self, py: Python<'_>, material: &Bound<'_, PyAny>) -> PyResult<Material> {
        let held = self.hold(py)?;
        held.value.material(handles::material(material, &held.value.renderer, self.number)?)
    }

    /// Replaces a material.
    fn set_material(&self, py: Python<'_>, material: &Bound<'_, PyAny>, new: Material) -> PyResult<()> {
        let mut held = self.hold(py)?;
        let handle = handles::material(material, &held.value.renderer, self.number)?;
        held.value.renderer.set_material(handle, new.material, new.surface).or_raise().map(drop)
    }

    /// Adds a material.
    fn add_material(&self, py: Python<'_>, material: Material) -> PyResult<MaterialHandle> {
        let handle = self.hold(py)?.value.renderer.add_material(material.material, material.surface).or_raise()?;
        Ok(MaterialHandle { handle, of: self.number })
    }

    /// The material of an object.
    fn object_material(&self, py: Python<'_>, object: &Bound<'_, PyAny>) -> PyResult<MaterialHandle> {
        let held = self.hold(py)?;
        let object = held.value.object(handles::object(object, &held.value.renderer, self.number)?)?;
        let handle = held.value.renderer.materials().nth(object.material).map(|(handle, _)| handle);
        let wrong = || PyValueError::new_err("the object has no material");
        Ok(MaterialHandle { handle: handle.ok_or_else(wrong)?, of: self.number })
    }

    /// Gives an object another material.
    fn set_object_material(
        &self,
        py: Python<'_>,
        object: &Bound<'_, PyAny>,
        material: &Bound<'_, PyAny>,
    ) -> PyResult<()> {
        let mut held = self.hold(py)?;
        let material = handles::material(material, &held.value.renderer, self.number)?;
        let object = handles::object(object, &held.value.renderer, self.number)?;
        held.value.renderer.set_object_material(object, material).or_raise().map(drop)
    }

    /// Replaces the camera.
    fn set_camera(&self, py: Python<'_>, camera: Camera) -> PyResult<()> {
        self.hold(py)?.value.renderer.set_camera(camera.camera).or_raise().map(drop)
    }

    /// Sets width and height of pictures.
    fn set_size(&self, py: Python<'_>, width: u32, height: u32) -> PyResult<()> {
        self.hold(py)?.value.renderer.set_size(width, height).or_raise().map(drop)
    }

    /// Sets the radiance where the camera sees nothing.
    fn set_background(&self, py: Python<'_>, background: &Bound<'_, PyAny>) -> PyResult<()> {
        let background = color("background", background)?;
        self.hold(py)?.value.renderer.set_background(background).or_raise().map(drop)
    }

    /// Changes settings.
    #[pyo3(signature = (settings = None, **changes))]
    fn set_settings(
        &self,
        py: Python<'_>,
        settings: Option<&Bound<'_, Settings>>,
        changes: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<()> {
        let mut held = self.hold(py)?;
        let before = match settings {
            Some(settings) => settings.clone(),
            None => Bound::new(py, held.value.settings.clone())?,
        };
        let new = Settings::changed(py, Some(&before), changes)?;
        held.value.renderer.set_settings(new.settings()?).or_raise()?;
        held.value.settings = new;
        Ok(())
    }
}

impl Renderer {
    /// Adds an object with its material, which is taken back where the object is refused.
    fn add(&self, inner: &mut Inner, object: Object, material: Option<&Bound<'_, PyAny>>) -> PyResult<ObjectHandle> {
        let before = inner.renderer.materials().count();
        let material = inner.material_number(material, self.number)?;
        let added = inner.renderer.add_object(Object { material, ..object });
        let unused = inner.renderer.materials().nth(before).map(|(handle, _)| handle);
        if let Some(handle) = unused.filter(|_| added.is_err()) {
            inner.renderer.remove_material(handle).or_raise()?;
        }
        Ok(ObjectHandle { handle: added.or_raise()?, of: self.number })
    }
}
