//! Images on materials, from arrays.

use crate::args::refuse;
use crate::errors::OrRaise;
use crate::material::Material;
use cosine_lobes::scene::{Channel, Encoding, Scene, Texture, TextureMap};
use glam::Vec3;
use numpy::{PyArray2, PyArray3, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

type Given<'a, 'py> = Option<&'a Bound<'py, PyAny>>;

/// An image of texels, the upper row first.
fn map(name: &str, [width, height]: [usize; 2], texels: Vec<[u8; 4]>, encoding: Encoding) -> PyResult<TextureMap> {
    let sides = 1..=Texture::MAX_SIDE as usize;
    if !(sides.contains(&width) && sides.contains(&height)) {
        let fault = format!("{name} has {width} x {height} texels: expected 1 to {} a side", Texture::MAX_SIDE);
        return Err(PyValueError::new_err(fault));
    }
    Ok(TextureMap::new(Texture::new(name, [width as u32, height as u32], texels, encoding)))
}

/// An image of three bytes a texel.
fn colors(name: &str, value: &Bound<'_, PyAny>, encoding: Encoding) -> PyResult<TextureMap> {
    let wanted = || refuse(name, value, "(height, width, 3)", "uint8");
    let array = value.cast::<PyArray3<u8>>().map_err(|_| wanted())?;
    let &[height, width, 3] = array.shape() else { return Err(wanted()) };
    let array = array.try_readonly()?;
    let texels = array.as_array().rows().into_iter().map(|t| [t[0], t[1], t[2], u8::MAX]).collect();
    map(name, [width, height], texels, encoding)
}

/// An image of one byte a texel.
fn numbers(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Channel> {
    let array = value.cast::<PyArray2<u8>>().map_err(|_| refuse(name, value, "(height, width)", "uint8"))?;
    let (height, width) = (array.shape()[0], array.shape()[1]);
    let texels = array.try_readonly()?.as_array().iter().map(|t| [*t, *t, *t, u8::MAX]).collect();
    Ok(Channel { map: map(name, [width, height], texels, Encoding::Linear)?, index: 0 })
}

/// An image of alpha, one byte a texel.
pub(crate) fn alpha(name: &str, value: &Bound<'_, PyAny>) -> PyResult<TextureMap> {
    let array = value.cast::<PyArray2<u8>>().map_err(|_| refuse(name, value, "(height, width)", "uint8"))?;
    let (height, width) = (array.shape()[0], array.shape()[1]);
    let texels = array.try_readonly()?.as_array().iter().map(|t| [u8::MAX, u8::MAX, u8::MAX, *t]).collect();
    map(name, [width, height], texels, Encoding::Linear)
}

#[pymethods]
impl Material {
    /// The material with images, which its own values multiply: arrays of uint8, the upper row first. `color`, `specular` and `emission` are
    /// sRGB, `(height, width, 3)`; `normal` is a normal map of that shape; `roughness` and `metallic` are `(height, width)`. They lie by the
    /// `uvs` of meshes, v downward, and repeat. `normal_scale` multiplies x and y of the normal map.
    #[pyo3(signature = (*, color = None, specular = None, emission = None, normal = None, roughness = None, metallic = None, normal_scale = 1.0))]
    #[expect(clippy::too_many_arguments, reason = "each is a keyword")]
    fn with_images(
        &self,
        color: Given<'_, '_>,
        specular: Given<'_, '_>,
        emission: Given<'_, '_>,
        normal: Given<'_, '_>,
        roughness: Given<'_, '_>,
        metallic: Given<'_, '_>,
        normal_scale: f64,
    ) -> PyResult<Self> {
        let mut new = self.clone();
        let surface = &mut new.surface;
        if let Some(image) = color {
            surface.color = Some(colors("color", image, Encoding::Srgb)?);
        }
        if let Some(image) = specular {
            surface.specular = Some(colors("specular", image, Encoding::Srgb)?);
        }
        if let Some(image) = emission {
            surface.emission_map = Some(colors("emission", image, Encoding::Srgb)?);
            // As in files, the image alone is the radiance.
            if surface.emission == Vec3::ZERO {
                surface.emission = Vec3::ONE;
            }
        }
        if let Some(image) = normal {
            let scale = crate::args::within("normal_scale", normal_scale, 0.0, 1e3)?;
            surface.normal = Some((colors("normal", image, Encoding::Linear)?, scale));
        }
        if let Some(image) = roughness {
            surface.roughness = Some(numbers("roughness", image)?);
        }
        if let Some(image) = metallic {
            surface.metallic = Some(numbers("metallic", image)?);
        }
        Scene::check_material(0, &new.material, &new.surface).or_raise()?;
        Ok(new)
    }
}
