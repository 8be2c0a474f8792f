//! Handles of a renderer's items, and the other ways to name one.

use crate::args::type_name;
use crate::errors::EditError;
use cosine_lobes::renderer;
use pyo3::exceptions::{PyIndexError, PyKeyError, PyTypeError};
use pyo3::prelude::*;

macro_rules! handles {
    ($($(#[$doc:meta])* $name:ident, $kind:literal;)*) => {
        $(
            $(#[$doc])*
            #[pyclass(module = "cosine_lobes", frozen, eq, hash, from_py_object)]
            #[derive(Clone, Copy, PartialEq, Eq, Hash)]
            pub(crate) struct $name {
                pub(crate) handle: renderer::$name,
                /// The renderer that it is of.
                pub(crate) of: u64,
            }

            #[pymethods]
            impl $name {
                fn __repr__(&self) -> String {
                    format!("<{} of a renderer: {:?}>", $kind, self.handle)
                }
            }
        )*
    };
}

handles! {
    /// A light of a renderer; valid until the light is removed.
    LightHandle, "light";
    /// An object of a renderer; valid until the object is removed.
    ObjectHandle, "object";
    /// A material of a renderer; valid until the material is removed.
    MaterialHandle, "material";
}

/// A handle, or the number of an item in its list; negative ones count from the end.
fn numbered<H>(kind: &str, key: &Bound<'_, PyAny>, all: impl DoubleEndedIterator<Item = H> + Clone) -> PyResult<H> {
    let Ok(number) = key.extract::<i64>() else {
        let given = type_name(key);
        return Err(PyTypeError::new_err(format!("{kind} is of type {given}: expected a handle or a number")));
    };
    let count = all.clone().count() as i64;
    let place = if number < 0 { number + count } else { number };
    let found = usize::try_from(place).ok().and_then(|place| all.clone().nth(place));
    found.ok_or_else(|| PyIndexError::new_err(format!("{kind} {number} is not in the scene: there are {count}")))
}

fn of_this(kind: &str, of: u64, this: u64) -> PyResult<()> {
    if of == this { Ok(()) } else { Err(EditError::new_err(format!("the {kind} is one of another renderer"))) }
}

/// The light that a key means.
pub(crate) fn light(
    key: &Bound<'_, PyAny>,
    renderer: &renderer::Renderer,
    this: u64,
) -> PyResult<renderer::LightHandle> {
    if let Ok(light) = key.extract::<LightHandle>() {
        of_this("light", light.of, this)?;
        return Ok(light.handle);
    }
    numbered("light", key, renderer.lights().map(|(handle, _)| handle).collect::<Vec<_>>().into_iter())
}

/// The material that a key means.
pub(crate) fn material(
    key: &Bound<'_, PyAny>,
    renderer: &renderer::Renderer,
    this: u64,
) -> PyResult<renderer::MaterialHandle> {
    if let Ok(material) = key.extract::<MaterialHandle>() {
        of_this("material", material.of, this)?;
        return Ok(material.handle);
    }
    numbered("material", key, renderer.materials().map(|(handle, _)| handle).collect::<Vec<_>>().into_iter())
}

/// The object that a key means: a handle, a number, or a name that one object alone has.
pub(crate) fn object(
    key: &Bound<'_, PyAny>,
    renderer: &renderer::Renderer,
    this: u64,
) -> PyResult<renderer::ObjectHandle> {
    if let Ok(object) = key.extract::<ObjectHandle>() {
        of_this("object", object.of, this)?;
        return Ok(object.handle);
    }
    if let Ok(name) = key.extract::<String>() {
        let mut found = renderer.objects().filter(|(_, object)| object.name == name).map(|(handle, _)| handle);
        return match (found.next(), found.next()) {
            (Some(handle), None) => Ok(handle),
            (None, _) => Err(PyKeyError::new_err(format!("no object is named \"{name}\""))),
            _ => Err(PyKeyError::new_err(format!(
                "several objects are named \"{name}\": their handles are in `objects`"
            ))),
        };
    }
    numbered("object", key, renderer.objects().map(|(handle, _)| handle).collect::<Vec<_>>().into_iter())
}
