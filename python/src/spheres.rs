use crate::args::{matrix, points, triangles};
use crate::errors::{LobesError, OrRaise};
use crate::mesh::sphere_rows;
use crate::values;
use crate::work::run;
use core::ops::ControlFlow;
use cosine_lobes::sphere_sets::{self, BuildOptions};
use glam::Vec3;
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;

/// Spheres that cast the shadow of a mesh.
#[pyclass(module = "cosine_lobes", frozen)]
pub(crate) struct SphereSet {
    pub(crate) set: sphere_sets::SphereSet,
}

#[pymethods]
impl SphereSet {
    /// Fits spheres to a mesh: at most `count` (64), or as few as have the silhouette error `tolerance`. `draft` is several times faster,
    /// with about three times the error; `bounding` holds every point of the surface.
    #[staticmethod]
    #[pyo3(signature = (positions, triangles, *, count = None, tolerance = None, draft = false, bounding = false, seed = 0, progress = None))]
    #[expect(clippy::too_many_arguments, reason = "each is a keyword")]
    fn fit(
        py: Python<'_>,
        positions: &Bound<'_, PyAny>,
        triangles: &Bound<'_, PyAny>,
        count: Option<usize>,
        tolerance: Option<f32>,
        draft: bool,
        bounding: bool,
        seed: u64,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let (positions, triangles) = mesh(positions, triangles)?;
        if tolerance.is_some() && (draft || bounding) {
            return Err(PyValueError::new_err("tolerance goes neither with draft nor with bounding"));
        }
        let count = count.unwrap_or(if tolerance.is_some() { 1024 } else { 64 });
        let options = if draft { BuildOptions::draft(count) } else { BuildOptions::new(count) };
        let options = BuildOptions { seed, bounding, ..options };
        let set = run(py, progress, |cancel, reporter| {
            let mut report = |done: f32| {
                reporter.progress("spheres", done);
                if cancel.is_cancelled() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            };
            match tolerance {
                Some(tolerance) => {
                    sphere_sets::SphereSet::build_to_tolerance(&positions, &triangles, tolerance, &options, &mut report)
                }
                None => sphere_sets::SphereSet::build_with_progress(&positions, &triangles, &options, &mut report),
            }
        });
        Ok(Self { set: set?.or_raise()? })
    }

    /// Measures spheres of the caller's, rows of x, y, z and radius, against a mesh.
    #[staticmethod]
    fn measure(
        py: Python<'_>,
        positions: &Bound<'_, PyAny>,
        triangles: &Bound<'_, PyAny>,
        spheres: &Bound<'_, PyAny>,
    ) -> PyResult<Self> {
        let (positions, triangles) = mesh(positions, triangles)?;
        let spheres = sphere_rows("spheres", spheres)?;
        let set = run(py, None, |_, _| sphere_sets::SphereSet::measure(&positions, &triangles, &spheres));
        Ok(Self { set: set?.or_raise()? })
    }

    /// Reads a file of `lobes spheres`.
    #[staticmethod]
    fn load(path: PathBuf) -> PyResult<Self> {
        let fault = |error: &dyn core::fmt::Display| LobesError::new_err(format!("{}: {error}", path.display()));
        let text = std::fs::read_to_string(&path).map_err(|error| fault(&format_args!("cannot read: {error}")))?;
        Ok(Self { set: sphere_sets::SphereSet::from_json(&text).map_err(|error| fault(&error))? })
    }

    /// Writes the file that `lobes spheres` would write.
    fn save(&self, path: PathBuf) -> PyResult<()> {
        let fault = |error| LobesError::new_err(format!("{}: cannot write: {error}", path.display()));
        std::fs::write(&path, self.set.to_json()).map_err(fault)
    }

    /// The set as it is once its mesh is placed by a matrix: a rotation, one scale and a translation.
    fn placed(&self, matrix: &Bound<'_, PyAny>) -> PyResult<Self> {
        Ok(Self { set: self.set.placed(&self::matrix("matrix", matrix)?) })
    }

    /// Rows of x, y, z and radius.
    #[getter]
    fn spheres<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let numbers = self.set.spheres.iter().flat_map(|sphere| {
            let [x, y, z] = sphere.center.to_array();
            [x, y, z, sphere.radius]
        });
        let rows = Array2::from_shape_vec((self.set.spheres.len(), 4), numbers.collect());
        Ok(rows.map_err(|error| PyValueError::new_err(error.to_string()))?.into_pyarray(py))
    }

    /// How well the spheres stand for the mesh: "silhouette_error" and others, as fractions.
    #[getter]
    fn quality<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        values::fields(py, serde_json::to_value(self.set.quality))
    }

    fn __len__(&self) -> usize {
        self.set.spheres.len()
    }

    fn __repr__(&self) -> String {
        let error = 100.0 * self.set.quality.silhouette_error;
        format!("<SphereSet of {} spheres, silhouette error {error:.1} %>", self.set.spheres.len())
    }
}

fn mesh(positions: &Bound<'_, PyAny>, triangles: &Bound<'_, PyAny>) -> PyResult<(Vec<Vec3>, Vec<[u32; 3]>)> {
    let positions = points("positions", positions)?;
    let triangles = self::triangles("triangles", triangles, positions.len())?;
    Ok((positions, triangles))
}
