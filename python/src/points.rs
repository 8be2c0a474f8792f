//! Light at points of the caller's.

use crate::args::{self, directions, points, same_count};
use crate::errors::OrRaise;
use crate::handles;
use crate::material::Material;
use crate::renderer::Renderer;
use crate::values;
use crate::work::run;
use cosine_lobes::brdf;
use cosine_lobes::lobe_core::{NO_OBJECT, Receiver};
use cosine_lobes::renderer::{self, LayerSet, PointLight};
use cosine_lobes::scene::{Cancel, ShadingPoints};
use glam::Vec3;
use numpy::{PyArray2, PyUntypedArray};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// The material of points: their own, or the number of one of the scene.
enum Reflects {
    Own(Box<brdf::Material>),
    Scene(u32),
}

/// The material that an argument means; a white diffuse one where it is none.
fn reflects(value: Option<&Bound<'_, PyAny>>, renderer: &renderer::Renderer, this: u64) -> PyResult<Reflects> {
    let Some(value) = value else { return Ok(Reflects::Own(Box::new(brdf::Material::lambert(Vec3::ONE)))) };
    if let Ok(material) = value.extract::<Material>() {
        return Ok(Reflects::Own(Box::new(material.material)));
    }
    let handle = handles::material(value, renderer, this)?;
    Ok(Reflects::Scene(renderer.materials().position(|(known, _)| known == handle).unwrap_or(usize::MAX) as u32))
}

/// The object of each point: none, one of all, or an array of numbers, of which -1 is none.
fn objects(
    value: Option<&Bound<'_, PyAny>>,
    count: usize,
    renderer: &renderer::Renderer,
    this: u64,
) -> PyResult<Vec<u32>> {
    let Some(value) = value else { return Ok(vec![NO_OBJECT; count]) };
    if value.cast::<PyUntypedArray>().is_ok() {
        let numbers = args::numbers_of("objects", value)?;
        same_count("objects", numbers.len(), count)?;
        return Ok(numbers.into_iter().map(|number| u32::try_from(number).unwrap_or(NO_OBJECT)).collect());
    }
    let handle = handles::object(value, renderer, this)?;
    let place = renderer.objects().position(|(known, _)| known == handle);
    Ok(vec![place.map_or(NO_OBJECT, |place| place as u32); count])
}

/// The arguments of points.
struct Points<'a, 'py> {
    points: &'a Bound<'py, PyAny>,
    normals: &'a Bound<'py, PyAny>,
    views: Option<&'a Bound<'py, PyAny>>,
    faces: Option<&'a Bound<'py, PyAny>>,
    material: Option<&'a Bound<'py, PyAny>>,
    objects: Option<&'a Bound<'py, PyAny>>,
}

impl Renderer {
    fn shade_points(&self, py: Python<'_>, given: &Points<'_, '_>, layers: LayerSet) -> PyResult<PointLight> {
        let positions = points("points", given.points)?;
        let count = positions.len();
        let normals = directions("normals", given.normals, count)?;
        let views = given.views.map(|views| directions("views", views, count)).transpose()?;
        let faces = given.faces.map(|faces| directions("faces", faces, count)).transpose()?;
        let mut held = self.hold(py)?;
        let renderer = &mut held.value.renderer;
        let reflects = reflects(given.material, renderer, self.number)?;
        let objects = objects(given.objects, count, renderer, self.number)?;
        let receiver = |i: usize| Receiver {
            position: positions[i],
            normal: normals[i],
            face: faces.as_ref().map_or(normals[i], |faces| faces[i]),
            view: views.as_ref().map_or(normals[i], |views| views[i]),
            object: objects[i],
        };
        let (number, own) = match reflects {
            Reflects::Own(material) => (0, Some([*material])),
            Reflects::Scene(number) => (number, None),
        };
        let points = ShadingPoints {
            receivers: (0..count).map(receiver).collect(),
            materials: vec![number; count],
            ..ShadingPoints::default()
        };
        let light = run(py, None, |cancel, _| {
            renderer.set_cancel(cancel.clone());
            let done = renderer.shade_points(points, own.as_ref().map(<[_; 1]>::as_slice), layers);
            renderer.set_cancel(Cancel::new());
            done
        });
        light?.or_raise()
    }
}

#[pymethods]
impl Renderer {
    /// The radiance that points of the caller's reflect toward `views` (their normals when left out), in their order: `(n, 3)`.
    ///
    /// `faces` are the normals of their triangles, where `normals` are smooth ones. `material` is a Material, or one of the scene; when
    /// left out white and diffuse, so that π times the result is the irradiance. `objects` says which object the points are on: one for
    /// all, or an array of numbers, -1 for none.
    #[pyo3(signature = (points, normals, views = None, *, faces = None, material = None, objects = None))]
    #[expect(clippy::too_many_arguments, reason = "each is a keyword")]
    fn shade<'py>(
        &self,
        py: Python<'py>,
        points: &Bound<'py, PyAny>,
        normals: &Bound<'py, PyAny>,
        views: Option<&Bound<'py, PyAny>>,
        faces: Option<&Bound<'py, PyAny>>,
        material: Option<&Bound<'py, PyAny>>,
        objects: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let given = Points { points, normals, views, faces, material, objects };
        values::rows(py, &self.shade_points(py, &given, LayerSet::NONE)?.radiance)
    }

    /// As `shade`, a dictionary: "beauty", "unshadowed", and "light0", "light1" …, the part of each light.
    #[pyo3(signature = (points, normals, views = None, *, faces = None, material = None, objects = None))]
    #[expect(clippy::too_many_arguments, reason = "each is a keyword")]
    fn shade_layers<'py>(
        &self,
        py: Python<'py>,
        points: &Bound<'py, PyAny>,
        normals: &Bound<'py, PyAny>,
        views: Option<&Bound<'py, PyAny>>,
        faces: Option<&Bound<'py, PyAny>>,
        material: Option<&Bound<'py, PyAny>>,
        objects: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let given = Points { points, normals, views, faces, material, objects };
        let set = LayerSet { unshadowed: true, lights: true, ..LayerSet::NONE };
        let light = self.shade_points(py, &given, set)?;
        let all = PyDict::new(py);
        all.set_item("beauty", values::rows(py, &light.radiance)?)?;
        all.set_item("unshadowed", values::rows(py, &light.unshadowed)?)?;
        for (number, part) in light.lights.iter().enumerate() {
            all.set_item(format!("light{number}"), values::rows(py, part)?)?;
        }
        Ok(all)
    }
}
