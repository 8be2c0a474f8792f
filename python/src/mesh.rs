//! Objects from arrays.

use crate::args::{directions, matrices, points, rows, same_count, triangles, type_name, within};
use crate::spheres::SphereSet;
use crate::work::warn;
use cosine_lobes::lobe_core::Sphere;
use cosine_lobes::scene::{Instances, Mesh, Object, Proxy, Shape, Strategy, Terminator};
use glam::{Mat4, Vec2, Vec3};
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray2, PyUntypedArray};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use std::sync::Arc;

/// Spheres that are fitted to a mesh where none are given.
const SPHERES: usize = 64;

/// The arrays of a mesh.
pub(crate) struct Arrays<'a, 'py> {
    pub(crate) positions: &'a Bound<'py, PyAny>,
    pub(crate) triangles: &'a Bound<'py, PyAny>,
    pub(crate) normals: Option<&'a Bound<'py, PyAny>>,
    pub(crate) uvs: Option<&'a Bound<'py, PyAny>>,
    pub(crate) colors: Option<&'a Bound<'py, PyAny>>,
    pub(crate) smooth: bool,
}

/// Everything else of an object.
pub(crate) struct Manner<'a, 'py> {
    pub(crate) name: Option<String>,
    pub(crate) visible: bool,
    pub(crate) visibility: Option<&'a str>,
    pub(crate) spheres: Option<&'a Bound<'py, PyAny>>,
    pub(crate) terminator: Option<&'a str>,
    pub(crate) places: Option<&'a Bound<'py, PyAny>>,
}

/// A mesh at places: stored once.
pub(crate) fn instances(mesh: Arc<Mesh>, places: Vec<Mat4>) -> PyResult<Shape> {
    Instances::new(mesh, places)
        .map(Shape::Instances)
        .map_err(|fault| PyValueError::new_err(format!("places: {fault}")))
}

impl Arrays<'_, '_> {
    /// The mesh. Triangles without an area are left out, with a warning.
    pub(crate) fn mesh(&self, py: Python<'_>) -> PyResult<Mesh> {
        let positions = points("positions", self.positions)?;
        let count = positions.len();
        let mut mesh = Mesh {
            triangles: triangles("triangles", self.triangles, count)?,
            normals: match self.normals {
                Some(_) if self.smooth => {
                    return Err(PyValueError::new_err("normals are given: smooth has no say"));
                }
                Some(normals) => directions("normals", normals, count)?,
                None => Vec::new(),
            },
            positions,
            ..Mesh::default()
        };
        if let Some(uvs) = self.uvs {
            let uvs = rows::<2>("uvs", uvs)?;
            same_count("uvs", uvs.len(), count)?;
            mesh.uv_sets.push(uvs.into_iter().map(Vec2::from_array).collect());
        }
        if let Some(colors) = self.colors {
            mesh.colors = points("colors", colors)?;
            same_count("colors", mesh.colors.len(), count)?;
        }
        tell_far(py, &mesh)?;
        match mesh.remove_degenerate() {
            0 => {}
            n => warn(py, &format!("{n} triangles without an area are left out"))?,
        }
        if self.smooth {
            mesh.smooth_normals();
        }
        Ok(mesh)
    }
}

/// Warns of a mesh so far from the origin that single precision moves its corners by more than a part of 4096 of its size.
fn tell_far(py: Python<'_>, mesh: &Mesh) -> PyResult<()> {
    const PARTS: f32 = 4096.0;
    let bounds = mesh.bounds();
    let (size, far) = (bounds.radius(), bounds.center().abs().max_element());
    let step = far * f32::EPSILON;
    if !(step.is_finite() && PARTS * step > size) {
        return Ok(());
    }
    let message = format!(
        "positions are {far:.3e} from the origin: single precision rounds them by {step:.1e}, and the mesh is {size:.1e} wide; move the scene to the origin"
    );
    warn(py, &message)
}

impl Manner<'_, '_> {
    /// A mesh as an object, at its own place or at all that are given.
    pub(crate) fn mesh(self, mesh: Mesh, material: usize, number: usize) -> PyResult<Object> {
        let (shape, proxy) = match (self.places, self.spheres) {
            (Some(_), Some(_)) => return Err(PyValueError::new_err("places are given: no spheres stand for the mesh")),
            (Some(places), None) => (instances(Arc::new(mesh), matrices("places", places)?)?, Proxy::None),
            (None, spheres) => (Shape::Mesh(mesh), spheres.map_or(Ok(Proxy::Count(SPHERES)), proxy)?),
        };
        let (name, visible, strategy) = (self.name(number), self.visible, strategy(self.visibility)?);
        let terminator = self.terminator.map_or(Ok(Terminator::Exact), crate::load::terminator)?;
        Ok(Object { shape, visible, strategy, terminator, ..Object::mesh(name, Mesh::default(), material, proxy) })
    }

    /// Exact spheres as an object.
    pub(crate) fn spheres(self, spheres: Vec<Sphere>, material: usize, number: usize) -> PyResult<Object> {
        let (name, visible, strategy) = (self.name(number), self.visible, strategy(self.visibility)?);
        Ok(Object { visible, strategy, ..Object::spheres(name, spheres, material) })
    }

    fn name(&self, number: usize) -> String {
        self.name.clone().unwrap_or_else(|| format!("object {number}"))
    }
}

/// A strategy by its name; none for the usual one.
pub(crate) fn strategy(name: Option<&str>) -> PyResult<Option<Strategy>> {
    let Some(name) = name else { return Ok(None) };
    let known: Vec<&str> = Strategy::ALL.iter().map(|strategy| strategy.name()).collect();
    let wrong = || PyValueError::new_err(format!("visibility is \"{name}\": expected one of {}", known.join(", ")));
    Strategy::named(name).map(Some).ok_or_else(wrong)
}

/// Spheres of rows x, y, z, radius.
pub(crate) fn sphere_rows(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<Sphere>> {
    let spheres: Vec<Sphere> = rows::<4>(name, value)?
        .into_iter()
        .map(|[x, y, z, radius]| Sphere { center: Vec3::new(x, y, z), radius })
        .collect();
    for (i, sphere) in spheres.iter().enumerate() {
        sphere.validate().map_err(|fault| PyValueError::new_err(format!("{name}[{i}]: {fault}")))?;
    }
    Ok(spheres)
}

/// The spheres by which a mesh blocks: a number of those that are fitted to it, a set, or rows of an array.
fn proxy(value: &Bound<'_, PyAny>) -> PyResult<Proxy> {
    if let Ok(set) = value.cast::<SphereSet>() {
        return Ok(Proxy::Spheres(set.get().set.spheres.clone()));
    }
    if value.cast::<PyUntypedArray>().is_ok() {
        return Ok(Proxy::Spheres(sphere_rows("spheres", value)?));
    }
    match value.extract::<i64>() {
        Ok(0) => Ok(Proxy::None),
        Ok(count @ 1..=100_000) => Ok(Proxy::Count(count as usize)),
        Ok(count) => Err(PyValueError::new_err(format!("spheres is {count}: expected 0 to 100000"))),
        Err(_) => {
            let kind = type_name(value);
            let fault =
                format!("spheres is of type {kind}: expected a number, a SphereSet or an array of shape (n, 4)");
            Err(PyTypeError::new_err(fault))
        }
    }
}

/// The arrays of a mesh without the parts where an image of alpha (uint8, `(height, width)`, the upper row first) is below a limit:
/// positions, triangles, normals or none, uvs. Camera and shadows then see the same outline.
#[pyfunction]
#[pyo3(signature = (positions, triangles, uvs, alpha, *, limit = 0.5, normals = None))]
#[expect(clippy::type_complexity, reason = "four arrays")]
pub(crate) fn cut_out<'py>(
    py: Python<'py>,
    positions: &Bound<'py, PyAny>,
    triangles: &Bound<'py, PyAny>,
    uvs: &Bound<'py, PyAny>,
    alpha: &Bound<'py, PyAny>,
    limit: f64,
    normals: Option<&Bound<'py, PyAny>>,
) -> PyResult<(
    Bound<'py, PyArray2<f32>>,
    Bound<'py, PyArray2<u32>>,
    Option<Bound<'py, PyArray2<f32>>>,
    Bound<'py, PyArray2<f32>>,
)> {
    let limit = within("limit", limit, 1e-6, 1.0)?;
    let map = crate::images::alpha("alpha", alpha)?;
    let arrays = Arrays { positions, triangles, normals, uvs: Some(uvs), colors: None, smooth: false };
    let mut mesh = arrays.mesh(py)?;
    if !py.detach(|| mesh.cut_out(&map, limit)) {
        return Err(PyValueError::new_err("alpha is repeated too often to cut along its outline"));
    }
    let uvs: Vec<[f32; 2]> = mesh.uv_sets[0].iter().map(Vec2::to_array).collect();
    let rows = |all: &[Vec3]| array(py, &all.iter().map(Vec3::to_array).collect::<Vec<_>>());
    let normals = (!mesh.normals.is_empty()).then(|| rows(&mesh.normals)).transpose()?;
    Ok((rows(&mesh.positions)?, array(py, &mesh.triangles)?, normals, array(py, &uvs)?))
}

/// Rows as an array.
fn array<'py, T: numpy::Element + Copy, const N: usize>(
    py: Python<'py>,
    rows: &[[T; N]],
) -> PyResult<Bound<'py, PyArray2<T>>> {
    let shape = (rows.len(), N);
    let array =
        Array2::from_shape_vec(shape, rows.concat()).map_err(|error| PyValueError::new_err(error.to_string()))?;
    Ok(array.into_pyarray(py))
}
