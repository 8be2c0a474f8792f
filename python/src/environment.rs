use crate::args::{color, direction, picture, type_name};
use crate::errors::OrRaise;
use crate::work::warn;
use cosine_lobes::lighting::{self, EnvironmentMap};
use cosine_lobes::lobe_core::Sphere;
use glam::{UVec2, Vec3};
use numpy::PyUntypedArray;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::sync::Arc;

/// The most patches along each side of the environment's cube.
const MOST_PATCHES: u32 = 16;

/// Light from all around that objects hide: one radiance, or an image in latitude and longitude of `(height, width, 3)`, the top row first;
/// `ambient` is more radiance from everywhere, which is not seen behind the objects. At least one of them.
#[pyclass(module = "cosine_lobes", frozen)]
pub(crate) struct Environment {
    picture: Option<EnvironmentMap>,
    ambient: Vec3,
    patches: u32,
}

impl Environment {
    /// The environment around a scene.
    pub(crate) fn around(&self, world: Sphere) -> Arc<lighting::Environment> {
        Arc::new(lighting::Environment::with_ambient(self.picture.clone(), self.ambient, self.patches, world))
    }
}

#[pymethods]
impl Environment {
    #[new]
    #[pyo3(signature = (radiance = None, *, strength = None, up = None, turn = 0.0, patches = 2, ambient = None))]
    fn new(
        radiance: Option<&Bound<'_, PyAny>>,
        strength: Option<&Bound<'_, PyAny>>,
        up: Option<&Bound<'_, PyAny>>,
        turn: f64,
        patches: u32,
        ambient: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        if radiance.is_none() && ambient.is_none() {
            return Err(PyValueError::new_err("an environment without light: expected radiance or ambient"));
        }
        let map = radiance.map(map).transpose()?;
        let ambient = ambient.map_or(Ok(Vec3::ZERO), |ambient| color("ambient", ambient))?;
        if !turn.is_finite() {
            return Err(PyValueError::new_err(format!("turn is {turn}: expected degrees")));
        }
        if !(1..=MOST_PATCHES).contains(&patches) {
            return Err(PyValueError::new_err(format!("patches is {patches}: expected 1 to {MOST_PATCHES}")));
        }
        let strength = strength.map(|strength| color("strength", strength)).transpose()?;
        let up = up.map_or(Ok(Vec3::Y), |up| direction("up", up))?;
        let placed = |map: EnvironmentMap| map.scaled(strength.unwrap_or(Vec3::ONE)).turned(up, turn as f32);
        Ok(Self { picture: map.map(placed), ambient, patches })
    }

    fn __repr__(&self) -> String {
        let size = self.picture.as_ref().map(EnvironmentMap::size);
        let picture = size.map_or("no picture".to_owned(), |size| format!("{} x {} texels", size.x, size.y));
        match self.ambient {
            Vec3::ZERO => format!("<Environment of {picture}>"),
            ambient => format!("<Environment of {picture}, ambient {ambient}>"),
        }
    }
}

fn map(radiance: &Bound<'_, PyAny>) -> PyResult<EnvironmentMap> {
    let is_image = radiance.cast::<PyUntypedArray>().is_ok_and(|array| {
        use numpy::PyUntypedArrayMethods;
        array.ndim() != 1
    });
    if is_image {
        let (width, height, texels) = picture("radiance", radiance)?;
        tell_clamped(radiance.py(), &texels)?;
        EnvironmentMap::new(UVec2::new(width as u32, height as u32), texels).or_raise()
    } else {
        Ok(EnvironmentMap::uniform(color("radiance", radiance)?))
    }
}

/// Warns of pixels that are no radiance, which the map clamps.
fn tell_clamped(py: Python<'_>, texels: &[Vec3]) -> PyResult<()> {
    let tell = |is_one: fn(Vec3) -> bool, why: &str| match texels.iter().filter(|texel| is_one(**texel)).count() {
        0 => Ok(()),
        1 => warn(py, &format!("radiance: 1 pixel is {why}")),
        count => warn(py, &format!("radiance: {count} pixels are {why}")),
    };
    tell(|texel| texel.min_element() < 0.0, "negative: taken as black")?;
    tell(|texel| texel.max_element() > EnvironmentMap::BRIGHTEST, "brighter than 1e12: taken as that")
}

/// An environment, or none.
pub(crate) fn optional<'py>(value: &Bound<'py, PyAny>) -> PyResult<Option<PyRef<'py, Environment>>> {
    if value.is_none() {
        return Ok(None);
    }
    value.extract::<PyRef<'py, Environment>>().map(Some).map_err(|_| {
        let kind = type_name(value);
        pyo3::exceptions::PyTypeError::new_err(format!("environment is of type {kind}: expected an Environment"))
    })
}
