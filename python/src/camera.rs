use crate::args::{vec3, within};
use crate::values::vector;
use cosine_lobes::scene;
use pyo3::prelude::*;

/// A pinhole camera; `fov` is the full vertical field of view in degrees.
#[pyclass(module = "cosine_lobes", frozen, eq, from_py_object)]
#[derive(Clone, Copy, PartialEq)]
pub(crate) struct Camera {
    pub(crate) camera: scene::Camera,
    /// As it was given: radians do not give it back to the bit.
    fov: f64,
}

impl Camera {
    pub(crate) fn of(camera: scene::Camera) -> Self {
        Self { camera, fov: f64::from(camera.vertical_fov.to_degrees()) }
    }
}

#[pymethods]
impl Camera {
    #[new]
    #[pyo3(signature = (eye, target, *, up = None, fov = 35.0))]
    fn new(
        eye: &Bound<'_, PyAny>,
        target: &Bound<'_, PyAny>,
        up: Option<&Bound<'_, PyAny>>,
        fov: f64,
    ) -> PyResult<Self> {
        use crate::errors::OrRaise;
        let camera = scene::Camera {
            eye: vec3("eye", eye)?,
            target: vec3("target", target)?,
            up: up.map_or(Ok(glam::Vec3::Y), |up| vec3("up", up))?,
            vertical_fov: within("fov", fov, 0.001, 179.9)?.to_radians(),
        };
        camera.validate().or_raise()?;
        Ok(Self { camera, fov })
    }

    #[getter]
    fn eye(&self) -> (f32, f32, f32) {
        vector(self.camera.eye)
    }

    #[getter]
    fn target(&self) -> (f32, f32, f32) {
        vector(self.camera.target)
    }

    #[getter]
    fn up(&self) -> (f32, f32, f32) {
        vector(self.camera.up)
    }

    #[getter]
    fn fov(&self) -> f64 {
        self.fov
    }

    fn __repr__(&self) -> String {
        let (eye, target, up) = (self.eye(), self.target(), self.up());
        format!("Camera({eye:?}, {target:?}, up={up:?}, fov={})", self.fov)
    }
}
