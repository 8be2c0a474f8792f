//! Picture files, and the comparison of pictures.

use crate::args::picture;
use crate::errors::OrRaise;
use crate::values;
use cosine_lobes::{
    Comparison, Display, ExrLayer, ExrPart, FlipMap, ImageFileError, Output, Picture, PictureStream, PngDepth,
    ShadowErrors, ToneMap, Window, write_exr as write_layers,
};
use numpy::ndarray::Array3;
use numpy::{IntoPyArray, PyArray3};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;

fn read(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Picture> {
    let (width, height, pixels) = picture(name, value)?;
    if pixels.is_empty() {
        return Err(PyValueError::new_err(format!("{name} has shape ({height}, {width}, 3): expected pixels")));
    }
    Ok(Picture::new(width, height, pixels))
}

/// How far a picture is from a reference, as `lobes compare --json` reports it: differences of linear radiance. With the picture
/// without shadows also the errors in penumbra, in light and in shadow.
#[pyfunction]
#[pyo3(signature = (test, reference, *, unshadowed = None, exposure = 0.0))]
pub(crate) fn compare<'py>(
    py: Python<'py>,
    test: &Bound<'py, PyAny>,
    reference: &Bound<'py, PyAny>,
    unshadowed: Option<&Bound<'py, PyAny>>,
    exposure: f32,
) -> PyResult<Bound<'py, PyDict>> {
    if !exposure.is_finite() {
        return Err(PyValueError::new_err(format!("exposure is {exposure}: expected stops")));
    }
    let (test, reference) = (read("test", test)?, read("reference", reference)?);
    let unshadowed = unshadowed.map(|value| read("unshadowed", value)).transpose()?;
    let (comparison, shadows, flip) = py.detach(|| {
        let shadows = unshadowed.map(|layer| ShadowErrors::of(&test, &reference, &layer)).transpose();
        (Comparison::of(&test, &reference), shadows, FlipMap::of(&test, &reference, exposure))
    });
    let comparison = comparison.or_raise()?;
    let (shadows, flip) = (
        shadows.map_err(|error| PyValueError::new_err(error.to_string()))?,
        flip.map_err(|error| PyValueError::new_err(error.to_string()))?,
    );
    let all = values::fields(py, serde_json::to_value(comparison))?;
    all.set_item("flip", flip.mean())?;
    if let Some(shadows) = shadows {
        all.update(values::fields(py, serde_json::to_value(shadows))?.as_mapping())?;
    }
    Ok(all)
}

/// The picture of an OpenEXR file, its channels R, G and B; with `layer` those of a layer.
#[pyfunction]
#[pyo3(signature = (path, *, layer = None))]
pub(crate) fn read_exr<'py>(
    py: Python<'py>,
    path: PathBuf,
    layer: Option<&str>,
) -> PyResult<Bound<'py, PyArray3<f32>>> {
    let read = || match layer {
        None => cosine_lobes::read_exr(&path).map(Some),
        Some(layer) => cosine_lobes::read_exr_layer(&path, layer),
    };
    let missing = || {
        let (path, layer) = (path.display(), layer.unwrap_or_default());
        PyValueError::new_err(format!("{path}: there is no layer \"{layer}\""))
    };
    let picture = py.detach(read).or_raise()?.ok_or_else(missing)?;
    values::layer(py, [picture.width(), picture.height()], picture.pixels())
}

/// Writes a picture as OpenEXR: linear radiance, 32-bit float.
#[pyfunction]
pub(crate) fn write_exr(py: Python<'_>, path: PathBuf, image: &Bound<'_, PyAny>) -> PyResult<()> {
    let picture = read("image", image)?;
    py.detach(|| {
        let layers = [ExrLayer::color("beauty", picture.pixels())];
        write_layers(Output::create(path)?, picture.width(), picture.height(), &layers)
    })
    .or_raise()
}

/// The tone map of a name, as of the command's `--tone`.
fn tone_map(name: &str) -> PyResult<ToneMap> {
    match name {
        "linear" => Ok(ToneMap::Linear),
        "soft" => Ok(ToneMap::Soft),
        "neutral" => Ok(ToneMap::Neutral),
        "agx" => Ok(ToneMap::Agx),
        _ => Err(PyValueError::new_err(format!("tone is {name:?}: expected linear, soft, neutral or agx"))),
    }
}

/// The picture as eight-bit sRGB, at a brightness of 2^`exposure`, through a tone map, dithered: what PNG files of the command hold.
#[pyfunction]
#[pyo3(signature = (image, *, exposure = 0.0, tone = "soft"))]
pub(crate) fn exposed<'py>(
    py: Python<'py>,
    image: &Bound<'py, PyAny>,
    exposure: f32,
    tone: &str,
) -> PyResult<Bound<'py, PyArray3<u8>>> {
    let picture = read("image", image)?;
    let display = Display { exposure, tone: tone_map(tone)?, depth: PngDepth::Eight };
    let window = Window::whole(picture.width(), picture.height());
    let bytes = py.detach(|| display.bytes(picture.pixels(), &window));
    let shape = (picture.height(), picture.width(), 3);
    let array = Array3::from_shape_vec(shape, bytes).map_err(|error| PyValueError::new_err(error.to_string()))?;
    Ok(array.into_pyarray(py))
}

/// Writes a picture as PNG of 8 or 16 bits, at a brightness of 2^`exposure`, through a tone map.
#[pyfunction]
#[pyo3(signature = (path, image, *, exposure = 0.0, tone = "soft", bits = 8))]
pub(crate) fn write_png(
    py: Python<'_>,
    path: PathBuf,
    image: &Bound<'_, PyAny>,
    exposure: f32,
    tone: &str,
    bits: u32,
) -> PyResult<()> {
    let picture = read("image", image)?;
    let depth = match bits {
        8 => PngDepth::Eight,
        16 => PngDepth::Sixteen,
        _ => return Err(PyValueError::new_err(format!("bits is {bits}: expected 8 or 16"))),
    };
    let display = Display { exposure, tone: tone_map(tone)?, depth };
    let window = Window::whole(picture.width(), picture.height());
    let write = || -> Result<(), ImageFileError> {
        let mut stream = PictureStream::new(window.clone());
        stream.add_png(Output::create(path)?, display)?;
        // The stream reports the reason when it is finished.
        let _ = stream.send(ExrPart::of_layers(window, &[ExrLayer::color("beauty", picture.pixels())]));
        stream.finish()
    };
    py.detach(write).or_raise()
}
