use crate::args::{vec3, within};
use crate::values::vector;
use cosine_lobes::scene;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use scene::Projection;

/// A camera. `projection` is "perspective", with the full vertical field of view `fov` in degrees, "orthographic", with the `height` of the
/// picture in units of the scene, or "panoramic": all directions by longitude and latitude.
#[pyclass(module = "cosine_lobes", frozen, eq, from_py_object)]
#[derive(Clone, Copy, PartialEq)]
pub(crate) struct Camera {
    pub(crate) camera: scene::Camera,
    /// The field of view or the height, as it was given: single precision does not give it back to the bit.
    number: f64,
}

impl Camera {
    pub(crate) fn of(camera: scene::Camera) -> Self {
        let number = match camera.projection {
            Projection::Perspective { vertical_fov } => f64::from(vertical_fov.to_degrees()),
            Projection::Orthographic { height } => f64::from(height),
            Projection::Panoramic => 0.0,
        };
        Self { camera, number }
    }
}

#[pymethods]
impl Camera {
    #[new]
    #[pyo3(signature = (eye, target, *, up = None, fov = None, projection = "perspective", height = None))]
    fn new(
        eye: &Bound<'_, PyAny>,
        target: &Bound<'_, PyAny>,
        up: Option<&Bound<'_, PyAny>>,
        fov: Option<f64>,
        projection: &str,
        height: Option<f64>,
    ) -> PyResult<Self> {
        use crate::errors::OrRaise;
        let (projection, number) = projection_of(projection, fov, height)?;
        let camera = scene::Camera {
            eye: vec3("eye", eye)?,
            target: vec3("target", target)?,
            up: up.map_or(Ok(glam::Vec3::Y), |up| vec3("up", up))?,
            projection,
        };
        camera.validate().or_raise()?;
        Ok(Self { camera, number })
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
    fn projection(&self) -> &'static str {
        self.camera.projection.name()
    }

    #[getter]
    fn fov(&self) -> Option<f64> {
        matches!(self.camera.projection, Projection::Perspective { .. }).then_some(self.number)
    }

    #[getter]
    fn height(&self) -> Option<f64> {
        matches!(self.camera.projection, Projection::Orthographic { .. }).then_some(self.number)
    }

    fn __repr__(&self) -> String {
        let (eye, target, up) = (self.eye(), self.target(), self.up());
        let number = match self.camera.projection {
            Projection::Perspective { .. } => format!("fov={}", self.number),
            Projection::Orthographic { .. } => format!("projection='orthographic', height={}", self.number),
            Projection::Panoramic => "projection='panoramic'".to_owned(),
        };
        format!("Camera({eye:?}, {target:?}, up={up:?}, {number})")
    }
}

/// The projection of that name, and its number.
fn projection_of(name: &str, fov: Option<f64>, height: Option<f64>) -> PyResult<(Projection, f64)> {
    let refused = |message: String| Err(PyValueError::new_err(message));
    match name {
        "perspective" if height.is_some() => {
            refused("height is of orthographic cameras: perspective ones have fov".to_owned())
        }
        "perspective" => {
            let degrees = fov.unwrap_or(35.0);
            Ok((Projection::perspective(within("fov", degrees, 0.001, 179.9)?.to_radians()), degrees))
        }
        _ if fov.is_some() => refused(format!("fov is of perspective cameras: this one is {name}")),
        "orthographic" => match height {
            None => refused("an orthographic camera needs height".to_owned()),
            Some(units) => Ok((Projection::Orthographic { height: within("height", units, 1e-9, 1e9)? }, units)),
        },
        "panoramic" if height.is_some() => {
            refused("height is of orthographic cameras: this one is panoramic".to_owned())
        }
        "panoramic" => Ok((Projection::Panoramic, 0.0)),
        other => refused(format!("projection is '{other}': expected 'perspective', 'orthographic' or 'panoramic'")),
    }
}
