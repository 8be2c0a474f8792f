use crate::args::{color, direction, one_of, points, positive, vec3, within};
use crate::errors::OrRaise;
use crate::lamp::{Beam, Lamp};
use crate::values::vector;
use cosine_lobes::lighting::{self, AmbientLight, FlatLight, SphereLight, SpotLight, SunLight, TubeLight};
use cosine_lobes::lobe_core::{Sphere, scales_evenly};
use cosine_lobes::scene::Scene;
use cosine_lobes::session::lamp;
use glam::Vec3;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// A light. Immutable: `moved`, `shifted`, `aimed`, `resized` and `with_radiance` return another one.
///
/// Radiance is in W·m⁻²·sr⁻¹, flux in W, intensity in W·sr⁻¹, irradiance in W·m⁻², each for red, green and blue or one number for
/// grey.
#[pyclass(module = "cosine_lobes", frozen, eq, from_py_object)]
#[derive(Clone, PartialEq)]
pub(crate) struct Light(pub(crate) lighting::Light);

/// Of suns and ambient light before a renderer fits them to its objects.
const NOWHERE: Sphere = Sphere { center: Vec3::ZERO, radius: 1e-3 };

type Given<'a> = Option<Bound<'a, PyAny>>;

impl Light {
    fn checked(light: impl Into<lighting::Light>) -> PyResult<Self> {
        let light = light.into();
        light.kind().validate().map_err(|error| PyValueError::new_err(error.to_string()))?;
        Scene::check_light(0, &light).or_raise()?;
        Ok(Self(light))
    }

    fn sphere_of(center: &Bound<'_, PyAny>, radius: f64) -> PyResult<Sphere> {
        Ok(Sphere { center: vec3("center", center)?, radius: positive("radius", radius)? })
    }

    fn flat(
        light: Result<FlatLight, lighting::FlatLightError>,
        two_sided: bool,
        radiance: &Given<'_>,
        flux: &Given<'_>,
    ) -> PyResult<Self> {
        let light = light.or_raise()?;
        let light = if two_sided { light.on_both_sides() } else { light };
        let (unit, value) = one_of(&[("radiance", radiance), ("flux", flux)])?;
        let color = color(unit, value)?;
        Self::checked(if unit == "flux" { light.with_flux(color) } else { light.with_radiance(color) })
    }
}

#[pymethods]
impl Light {
    /// A sphere.
    #[staticmethod]
    #[pyo3(signature = (center, radius, *, radiance = None, flux = None))]
    fn sphere(center: &Bound<'_, PyAny>, radius: f64, radiance: Given<'_>, flux: Given<'_>) -> PyResult<Self> {
        let sphere = Self::sphere_of(center, radius)?;
        let (unit, value) = one_of(&[("radiance", &radiance), ("flux", &flux)])?;
        let color = color(unit, value)?;
        Self::checked(match unit {
            "flux" => SphereLight::with_flux(sphere, color),
            _ => SphereLight::new(sphere, color),
        })
    }

    /// A small sphere, by its intensity. With a `range` its light is less by the factor `1 - (distance/range)^4`, and ends there.
    #[staticmethod]
    #[pyo3(signature = (center, *, intensity, radius = 0.01, range = None))]
    fn point(
        center: &Bound<'_, PyAny>,
        intensity: &Bound<'_, PyAny>,
        radius: f64,
        range: Option<f64>,
    ) -> PyResult<Self> {
        let light = SphereLight::with_intensity(Self::sphere_of(center, radius)?, color("intensity", intensity)?);
        match range {
            None => Self::checked(light),
            Some(range) => Self::checked(SpotLight::everywhere(light, positive("range", range)?)),
        }
    }

    /// A small sphere that shines into a cone: fully within `inner` degrees of the axis, not at all beyond `angle`. Its `range` is as a
    /// point's.
    #[staticmethod]
    #[pyo3(signature = (center, direction, *, intensity, angle, inner = 0.0, radius = 0.01, range = None))]
    fn spot(
        center: &Bound<'_, PyAny>,
        direction: &Bound<'_, PyAny>,
        intensity: &Bound<'_, PyAny>,
        angle: f64,
        inner: f64,
        radius: f64,
        range: Option<f64>,
    ) -> PyResult<Self> {
        let range = range.map_or(Ok(f32::INFINITY), |range| positive("range", range))?;
        let light = SphereLight::with_intensity(Self::sphere_of(center, radius)?, color("intensity", intensity)?);
        let outer = within("angle", angle, 1e-3, 90.0)?;
        let inner = within("inner", inner, 0.0, angle)?;
        let axis = crate::args::direction("direction", direction)?;
        let cos = [inner, outer].map(|degrees| degrees.to_radians().cos());
        Self::checked(SpotLight { light, axis, cos, range })
    }

    /// A lamp as programs for modelling have it, by its intensity: a sphere, or with `facing` a disc that turns to each receiver, as
    /// Blender's lamps with a soft falloff. With a `direction` it shines into a cone of `angle` degrees from it, whose edge takes up the
    /// part `blend` of the cone (from 0, hard, to 1).
    #[staticmethod]
    #[pyo3(signature = (center, *, intensity, radius = 0.01, facing = false, direction = None, angle = 90.0, blend = 0.0))]
    fn lamp(
        center: &Bound<'_, PyAny>,
        intensity: &Bound<'_, PyAny>,
        radius: f64,
        facing: bool,
        direction: Given<'_>,
        angle: f64,
        blend: f64,
    ) -> PyResult<Self> {
        let light = SphereLight::with_intensity(Self::sphere_of(center, radius)?, color("intensity", intensity)?);
        let angle = within("angle", angle, 0.1, 90.0)?.to_radians();
        let blend = within("blend", blend, 0.0, 1.0)?;
        let axis = direction.map(|axis| crate::args::direction("direction", &axis)).transpose()?;
        let beam = axis.map(|axis| Beam { axis, cos: angle.cos(), blend });
        Self::checked(Lamp { light, facing, beam }.light())
    }

    /// A rectangle, `center` ± `u` ± `v`, that shines toward `u` × `v`.
    #[staticmethod]
    #[pyo3(signature = (center, u, v, *, radiance = None, flux = None, two_sided = false))]
    fn rectangle(
        center: &Bound<'_, PyAny>,
        u: &Bound<'_, PyAny>,
        v: &Bound<'_, PyAny>,
        radiance: Given<'_>,
        flux: Given<'_>,
        two_sided: bool,
    ) -> PyResult<Self> {
        let light = FlatLight::rectangle(vec3("center", center)?, vec3("u", u)?, vec3("v", v)?, Vec3::ONE);
        Self::flat(light, two_sided, &radiance, &flux)
    }

    /// A disc that shines toward its normal.
    #[staticmethod]
    #[pyo3(signature = (center, normal, radius, *, radiance = None, flux = None, two_sided = false))]
    fn disc(
        center: &Bound<'_, PyAny>,
        normal: &Bound<'_, PyAny>,
        radius: f64,
        radiance: Given<'_>,
        flux: Given<'_>,
        two_sided: bool,
    ) -> PyResult<Self> {
        let (center, normal) = (vec3("center", center)?, direction("normal", normal)?);
        let light = FlatLight::disc(center, normal, positive("radius", radius)?, Vec3::ONE);
        Self::flat(light, two_sided, &radiance, &flux)
    }

    /// A convex polygon that shines to the side from which its corners are seen counter-clockwise.
    #[staticmethod]
    #[pyo3(signature = (corners, *, radiance = None, flux = None, two_sided = false))]
    fn polygon(corners: &Bound<'_, PyAny>, radiance: Given<'_>, flux: Given<'_>, two_sided: bool) -> PyResult<Self> {
        Self::flat(FlatLight::polygon(&points("corners", corners)?, Vec3::ONE), two_sided, &radiance, &flux)
    }

    /// A tube with round ends.
    #[staticmethod]
    #[pyo3(signature = (start, end, radius, *, radiance = None, flux = None))]
    fn tube(
        start: &Bound<'_, PyAny>,
        end: &Bound<'_, PyAny>,
        radius: f64,
        radiance: Given<'_>,
        flux: Given<'_>,
    ) -> PyResult<Self> {
        let ends = [vec3("start", start)?, vec3("end", end)?];
        let (unit, value) = one_of(&[("radiance", &radiance), ("flux", &flux)])?;
        let color = color(unit, value)?;
        let tube = TubeLight { ends, radius: positive("radius", radius)?, radiance: color };
        Self::checked(if unit == "flux" { tube.with_flux(color) } else { tube })
    }

    /// A light at infinity that shines along `direction`, seen under `angle` degrees (0.53 for the sun).
    #[staticmethod]
    #[pyo3(signature = (direction, *, irradiance = None, radiance = None, angle = None))]
    fn sun(
        direction: &Bound<'_, PyAny>,
        irradiance: Given<'_>,
        radiance: Given<'_>,
        angle: Option<f64>,
    ) -> PyResult<Self> {
        let along = crate::args::direction("direction", direction)?;
        let half =
            angle.map_or(Ok(SunLight::HALF_ANGLE), |angle| within("angle", angle, 1e-3, 120.0).map(|a| 0.5 * a))?;
        let (unit, value) = one_of(&[("irradiance", &irradiance), ("radiance", &radiance)])?;
        let color = color(unit, value)?;
        let sun = SunLight::new(-along, half, color, NOWHERE);
        Self::checked(if unit == "radiance" { SunLight { radiance: color, ..sun } } else { sun })
    }

    /// The same radiance from everywhere, which nothing hides.
    #[staticmethod]
    fn ambient(radiance: &Bound<'_, PyAny>) -> PyResult<Self> {
        Self::checked(AmbientLight { radiance: color("radiance", radiance)?, world: NOWHERE })
    }

    /// Its kind: sphere, flat, tube, sun, spot, environment, ambient …
    #[getter]
    fn kind(&self) -> &'static str {
        self.0.name()
    }

    /// Its middle; none of suns, skies and ambient light.
    #[getter]
    fn center(&self) -> Option<(f32, f32, f32)> {
        lamp::center(&self.0).map(vector)
    }

    /// The unit direction in which it shines; none of those that shine to all sides.
    #[getter]
    fn direction(&self) -> Option<(f32, f32, f32)> {
        lamp::direction(&self.0).map(vector)
    }

    /// Its radius, or that of a circle around it; of a sun half its angle, in radians.
    #[getter]
    fn size(&self) -> Option<f32> {
        lamp::size(&self.0)
    }

    /// Its radiance, where it shines.
    #[getter]
    fn radiance(&self) -> (f32, f32, f32) {
        vector(self.0.full_radiance())
    }

    /// The light moved by a matrix: a rotation and a translation. `resized` changes its size.
    fn moved(&self, matrix: &Bound<'_, PyAny>) -> PyResult<Self> {
        let matrix = crate::args::matrix("matrix", matrix)?;
        if !(scales_evenly(&matrix, 1.0, 1e-4) && matrix.determinant() > 0.0) {
            return Err(PyValueError::new_err("matrix scales or mirrors: expected a rotation and a translation"));
        }
        Self::checked(self.0.moved(matrix))
    }

    /// The light shifted.
    fn shifted(&self, by: &Bound<'_, PyAny>) -> PyResult<Self> {
        Self::checked(lamp::shifted(&self.0, vec3("by", by)?))
    }

    /// The light turned about its middle, so that it shines in a direction; the same where it shines to all sides.
    fn aimed(&self, direction: &Bound<'_, PyAny>) -> PyResult<Self> {
        Self::checked(lamp::aimed(&self.0, crate::args::direction("direction", direction)?))
    }

    /// The light with another `size` and the same power.
    fn resized(&self, size: f64) -> PyResult<Self> {
        Self::checked(lamp::resized(&self.0, positive("size", size)?))
    }

    /// The light with another radiance.
    fn with_radiance(&self, radiance: &Bound<'_, PyAny>) -> PyResult<Self> {
        Self::checked(lamp::with_radiance(&self.0, color("radiance", radiance)?))
    }

    fn __repr__(&self) -> String {
        let radiance = self.radiance();
        match self.center() {
            Some(center) => format!("<Light {} at {center:?} of radiance {radiance:?}>", self.kind()),
            None => format!("<Light {} of radiance {radiance:?}>", self.kind()),
        }
    }
}
