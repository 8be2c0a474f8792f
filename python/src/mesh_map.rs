//! Light on the texture coordinates of a mesh.

use crate::errors::OrRaise;
use crate::handles;
use crate::mesh::Arrays;
use crate::renderer::Renderer;
use crate::values;
use crate::work::run;
use bake::MeshMap;
use core::ops::ControlFlow;
use cosine_lobes::scene::Cancel;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

#[pymethods]
impl Renderer {
    /// The irradiance of a mesh on its texture coordinates: a map of `size` texels, width and height, as a dictionary. "irradiance" is
    /// `(height, width, 3)`, "covered" says which texels lie on the mesh, "overlaps" how many of them do more than once, and "beyond" how
    /// many triangles leave the map. With `per_light` also "light0", "light1" … and "sky".
    ///
    /// Positions are in world space, `uvs` are in [0, 1], v downward, and triangles are lit on the side from which they go round against the
    /// clock. A texel is the mean over `samples`² cells of the part of it that lies on the mesh; `padding` rings of texels repeat the edge.
    /// Both sides of a seam show the same light. `object` is the object of the scene that the mesh is, if any.
    #[pyo3(signature = (positions, triangles, uvs, size, *, normals = None, samples = 2, padding = 2, per_light = false, object = None, progress = None))]
    #[expect(clippy::too_many_arguments, reason = "each is a keyword")]
    fn bake<'py>(
        &self,
        py: Python<'py>,
        positions: &Bound<'py, PyAny>,
        triangles: &Bound<'py, PyAny>,
        uvs: &Bound<'py, PyAny>,
        size: (u32, u32),
        normals: Option<&Bound<'py, PyAny>>,
        samples: u32,
        padding: u32,
        per_light: bool,
        object: Option<&Bound<'py, PyAny>>,
        progress: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let mesh = Arrays { positions, triangles, normals, uvs: Some(uvs), colors: None, smooth: false }.mesh(py)?;
        if mesh.triangles.is_empty() {
            return Err(PyValueError::new_err("triangles: none has an area"));
        }
        let mut held = self.hold(py)?;
        let renderer = &mut held.value.renderer;
        let handle = object.map(|object| handles::object(object, renderer, self.number)).transpose()?;
        let object = handle.and_then(|handle| renderer.objects().position(|(known, _)| known == handle));
        let map = MeshMap { mesh, size: size.into(), samples, padding, per_light, object };
        let baked = run(py, progress, |cancel, reporter| {
            renderer.set_cancel(cancel.clone());
            let done = map.bake(renderer, &mut |_, done| {
                reporter.progress("light", done);
                ControlFlow::Continue(())
            });
            renderer.set_cancel(Cancel::new());
            done
        });
        let baked = baked?.or_raise()?;
        let size = map.size.map(|side| side as usize);
        let all = PyDict::new(py);
        all.set_item("irradiance", values::layer(py, size, &baked.light)?)?;
        for (name, light) in &baked.single {
            all.set_item(name, values::layer(py, size, light)?)?;
        }
        all.set_item("covered", values::plane(py, size, baked.covered)?)?;
        all.set_item("overlaps", baked.overlaps)?;
        all.set_item("beyond", baked.beyond)?;
        Ok(all)
    }
}
