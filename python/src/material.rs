use crate::args::{color, matrix3, positive, type_name, vec3, within};
use crate::errors::OrRaise;
use crate::principled::Principled;
use crate::values::vector;
use cosine_lobes::brdf::{
    self, HalfVector, HalfVectorLobe, Lafortune, LafortuneLobe, Lambert, MetallicRoughness, ModifiedPhong, Neumann,
    Phong,
};
use cosine_lobes::scene::{Scene, Surface};
use glam::Vec3;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::Arc;

/// How a surface reflects light, and what it emits. Immutable.
#[pyclass(module = "cosine_lobes", frozen, eq, from_py_object)]
#[derive(Clone, PartialEq)]
pub(crate) struct Material {
    pub(crate) material: brdf::Material,
    pub(crate) surface: Surface,
}

type Given<'a> = Option<Bound<'a, PyAny>>;

impl Material {
    fn checked(material: impl Into<brdf::Material>, emission: &Given<'_>) -> PyResult<Self> {
        let material = material.into();
        material.validate().or_raise()?;
        let surface = Surface { emission: color_or_black("emission", emission)?, ..Surface::default() };
        Scene::check_material(0, &material, &surface).or_raise()?;
        Ok(Self { material, surface })
    }
}

fn color_or_black(name: &str, value: &Given<'_>) -> PyResult<Vec3> {
    value.as_ref().map_or(Ok(Vec3::ZERO), |value| color(name, value))
}

#[pymethods]
impl Material {
    /// Ideally diffuse.
    #[staticmethod]
    #[pyo3(signature = (albedo, *, emission = None))]
    fn lambert(albedo: &Bound<'_, PyAny>, emission: Given<'_>) -> PyResult<Self> {
        Self::checked(Lambert { albedo: color("albedo", albedo)? }, &emission)
    }

    /// The paper's Phong model, without cosine on the specular term.
    #[staticmethod]
    #[pyo3(signature = (*, kd = None, ks = None, exponent, emission = None))]
    fn phong(kd: Given<'_>, ks: Given<'_>, exponent: f32, emission: Given<'_>) -> PyResult<Self> {
        let (kd, ks) = (color_or_black("kd", &kd)?, color_or_black("ks", &ks)?);
        Self::checked(Phong { kd, ks, exponent }, &emission)
    }

    /// Normalised Phong.
    #[staticmethod]
    #[pyo3(signature = (*, kd = None, ks = None, exponent, emission = None))]
    fn modified_phong(kd: Given<'_>, ks: Given<'_>, exponent: f32, emission: Given<'_>) -> PyResult<Self> {
        let (kd, ks) = (color_or_black("kd", &kd)?, color_or_black("ks", &ks)?);
        Self::checked(ModifiedPhong { kd, ks, exponent }, &emission)
    }

    /// Neumann et al.'s metals.
    #[staticmethod]
    #[pyo3(signature = (*, kd = None, ks = None, exponent, emission = None))]
    fn neumann(kd: Given<'_>, ks: Given<'_>, exponent: f32, emission: Given<'_>) -> PyResult<Self> {
        let (kd, ks) = (color_or_black("kd", &kd)?, color_or_black("ks", &ks)?);
        Self::checked(Neumann { kd, ks, exponent }, &emission)
    }

    /// Lafortune: a list of lobes, each a dictionary with `exponent`, `scale` and `c` (three numbers) or `matrix` (3 × 3).
    #[staticmethod]
    #[pyo3(signature = (lobes, *, diffuse = None, emission = None))]
    fn lafortune(lobes: Vec<Bound<'_, PyDict>>, diffuse: Given<'_>, emission: Given<'_>) -> PyResult<Self> {
        let lobes = lobes.iter().map(lafortune_lobe).collect::<PyResult<_>>()?;
        Self::checked(Lafortune { diffuse: color_or_black("diffuse", &diffuse)?, lobes }, &emission)
    }

    /// Lobes about the half vector: a list of dictionaries with `roughness`, `f0` and, where it is not 1, `f90`.
    #[staticmethod]
    #[pyo3(signature = (lobes, *, diffuse = None, emission = None))]
    fn half_vector(lobes: Vec<Bound<'_, PyDict>>, diffuse: Given<'_>, emission: Given<'_>) -> PyResult<Self> {
        let lobes = lobes.iter().map(half_vector_lobe).collect::<PyResult<_>>()?;
        Self::checked(HalfVector { diffuse: color_or_black("diffuse", &diffuse)?, lobes }, &emission)
    }

    /// glTF's metallic–roughness model. Its coat is that of a refractive index, or reflects `f0` at normal incidence. A clear coat of a weight
    /// lies over all.
    #[staticmethod]
    #[pyo3(signature = (base, *, metallic = 1.0, roughness = 1.0, ior = None, f0 = None, clearcoat = 0.0, clearcoat_roughness = 0.0, emission = None))]
    #[expect(clippy::too_many_arguments, reason = "each is a keyword")]
    fn metallic_roughness(
        base: &Bound<'_, PyAny>,
        metallic: f32,
        roughness: f32,
        ior: Option<f64>,
        f0: Given<'_>,
        clearcoat: f32,
        clearcoat_roughness: f32,
        emission: Given<'_>,
    ) -> PyResult<Self> {
        let metal = MetallicRoughness::new(color("base", base)?, metallic, roughness).or_raise()?;
        let metal = metal.with_clearcoat(clearcoat, clearcoat_roughness).or_raise()?;
        let f0 = match (ior, f0) {
            (None, None) => return Self::checked(metal, &emission),
            (Some(_), Some(_)) => return Err(PyTypeError::new_err("expected one of ior, f0")),
            (Some(ior), None) => {
                let ior = within("ior", ior, 1.0, 1e6)?;
                Vec3::splat(((ior - 1.0) / (ior + 1.0)).powi(2))
            }
            (None, Some(f0)) => color("f0", &f0)?,
        };
        Self::checked(metal.with_coat(f0, 1.0).or_raise()?, &emission)
    }

    /// Blender's Principled, of which it has the base and the clear coat: `ior` is the base's refractive index (1 for none), `tint` colours what it
    /// reflects at normal incidence, and with `scatters` light that scatters between the facets more than once counts. A clear coat of the weight `coat` lies over
    /// all. On the CPU alone.
    #[staticmethod]
    #[pyo3(signature = (base, *, metallic = 0.0, roughness = 0.5, ior = 1.5, tint = None, scatters = true, coat = 0.0, coat_roughness = 0.03, coat_ior = 1.5, coat_tint = None, emission = None))]
    #[expect(clippy::too_many_arguments, reason = "each is a keyword")]
    fn principled(
        base: &Bound<'_, PyAny>,
        metallic: f64,
        roughness: f64,
        ior: f64,
        tint: Given<'_>,
        scatters: bool,
        coat: f64,
        coat_roughness: f64,
        coat_ior: f64,
        coat_tint: Given<'_>,
        emission: Given<'_>,
    ) -> PyResult<Self> {
        let fractions = |name: &str, color: Vec3| {
            let wrong = || PyValueError::new_err(format!("{name} is {color}: expected 0 to 1"));
            if color.max_element() <= 1.0 { Ok(color) } else { Err(wrong()) }
        };
        let base = fractions("base", color("base", base)?)?;
        let tinted =
            |name: &str, tint: Given<'_>| fractions(name, tint.map_or(Ok(Vec3::ONE), |tint| color(name, &tint))?);
        let (tint, coat_tint) = (tinted("tint", tint)?, tinted("coat_tint", coat_tint)?);
        let numbers = [within("metallic", metallic, 0.0, 1.0)?, within("roughness", roughness, 0.0, 1.0)?];
        let ior = within("ior", ior, 1.0, 1e3)?;
        let coat = [within("coat", coat, 0.0, 1.0)?, within("coat_roughness", coat_roughness, 0.0, 1.0)?];
        let coat_ior = within("coat_ior", coat_ior, 1.0, 1e3)?;
        let model = Principled::new(base, numbers, f64::from(ior), tint, scatters).with_coat(coat, coat_ior, coat_tint);
        Self::checked(brdf::Material::Custom(Arc::new(model)), &emission)
    }

    /// The name of its model.
    #[getter]
    fn model(&self) -> &'static str {
        self.material.name()
    }

    /// Radiance of its own, which the camera sees.
    #[getter]
    fn emission(&self) -> (f32, f32, f32) {
        vector(self.surface.emission)
    }

    fn __repr__(&self) -> String {
        format!("<Material {}>", self.model())
    }
}

/// A key of a lobe.
fn key<'py>(lobe: &Bound<'py, PyDict>, name: &str) -> PyResult<Bound<'py, PyAny>> {
    lobe.get_item(name)?.ok_or_else(|| PyTypeError::new_err(format!("a lobe has no \"{name}\": {}", lobe)))
}

fn number(lobe: &Bound<'_, PyDict>, name: &str) -> PyResult<f64> {
    let value = key(lobe, name)?;
    let wrong = || PyTypeError::new_err(format!("{name} is of type {}: expected a number", type_name(&value)));
    value.extract().map_err(|_| wrong())
}

/// Refuses keys that mean nothing.
fn only(lobe: &Bound<'_, PyDict>, names: &[&str]) -> PyResult<()> {
    for name in lobe.keys() {
        let known = name.extract::<String>().is_ok_and(|name| names.contains(&name.as_str()));
        if !known {
            return Err(PyTypeError::new_err(format!("a lobe has {}: expected {}", name.repr()?, names.join(", "))));
        }
    }
    Ok(())
}

fn lafortune_lobe(lobe: &Bound<'_, PyDict>) -> PyResult<LafortuneLobe> {
    only(lobe, &["exponent", "scale", "c", "matrix"])?;
    let (exponent, scale) = (positive("exponent", number(lobe, "exponent")?)?, color("scale", &key(lobe, "scale")?)?);
    let lobe = match lobe.get_item("matrix")? {
        Some(matrix) => LafortuneLobe::new(matrix3("matrix", &matrix)?, exponent, scale),
        None => LafortuneLobe::diagonal(vec3("c", &key(lobe, "c")?)?, exponent, scale),
    };
    lobe.validate().or_raise()?;
    Ok(lobe)
}

fn half_vector_lobe(lobe: &Bound<'_, PyDict>) -> PyResult<HalfVectorLobe> {
    only(lobe, &["roughness", "f0", "f90"])?;
    let roughness = within("roughness", number(lobe, "roughness")?, 0.0, 1.0)?;
    let f90 = lobe.get_item("f90")?.map_or(Ok(Vec3::ONE), |value| color("f90", &value))?;
    Ok(HalfVectorLobe::new(roughness, color("f0", &key(lobe, "f0")?)?, f90))
}
