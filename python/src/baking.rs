//! Baking files, as `lobes bake` does.

use crate::args;
use crate::errors::OrRaise;
use crate::load::Choices;
use crate::settings::{cache_folder, named};
use crate::values;
use crate::work::{run, warn};
use ::bake::{BakeError, BakeSettings, Baked, Baker, Form, Stage};
use core::ops::ControlFlow;
use cosine_lobes::Output;
use cosine_lobes::renderer::Settings;
use cosine_lobes::shading::Accuracy;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::{Path, PathBuf};

/// The file that a path means, however it is spelled.
fn identity(path: &Path) -> PathBuf {
    std::fs::canonicalize(path).unwrap_or_else(|_| path.to_owned())
}

/// Opens the file that is baked to.
fn create(input: &Path, output: &Path) -> PyResult<Output> {
    let fault = |text: &str| Err(PyValueError::new_err(format!("{}: {text}", output.display())));
    if !output.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("glb")) {
        return fault("the name must end in .glb");
    }
    if identity(input) == identity(output) {
        return fault("both read and written");
    }
    Output::create(output).or_raise()
}

/// Bakes the light of a moment; the files of its maps.
#[expect(clippy::type_complexity, reason = "files by the ends of their names")]
fn light(
    py: Python<'_>,
    baker: &mut Baker,
    time: f32,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<(Baked, Vec<(String, Vec<u8>)>)> {
    let end = baker.renderer().animation().duration();
    if !(0.0..=end).contains(&time) {
        return Err(PyValueError::new_err(format!("time is {time}: expected seconds from 0 to {end}")));
    }
    let made = run(py, progress, |cancel, reporter| {
        baker.set_cancel(cancel.clone());
        baker.seek(time)?;
        let baked = baker.bake(&mut |stage, done| {
            reporter.progress(if stage == Stage::Light { "light" } else { "coordinates" }, done);
            ControlFlow::Continue(())
        })?;
        let maps = baked.map_files()?;
        Ok::<_, BakeError>((baked, maps))
    });
    let (baked, maps) = made?.or_raise()?;
    if baked.subdivision.is_some_and(|made| made.is_cut) {
        let count = baked.vertices;
        warn(py, &format!("subdivision ended at {count} vertices before light was near enough everywhere"))?;
    }
    Ok((baked, maps))
}

/// Bakes the light of a file into a glTF file, as `lobes bake` does, and returns its report: the same files to the byte, and what `--json`
/// prints of them. `form` is "emission", "lightmap" or "vertex-colors"; the others are the options of the command, and those of
/// `Scene.load`. Nothing is kept of a bake that is stopped.
#[pyfunction]
#[pyo3(signature = (path, output, *, form = "emission", page = 1024, density = None, padding = 2, samples = 2, unwrap = false, both_sides = false, per_light = false, subdivide = None, vertices = 1_000_000, tolerance = 0.005, time = 0.0, clip = None, normals = "file", crease = 180.0, terminator = "exact", emission = "lights", studio = None, progress = None))]
#[expect(clippy::too_many_arguments, reason = "each is a keyword")]
pub(crate) fn bake<'py>(
    py: Python<'py>,
    path: PathBuf,
    output: PathBuf,
    form: &str,
    page: u32,
    density: Option<f32>,
    padding: u32,
    samples: u32,
    unwrap: bool,
    both_sides: bool,
    per_light: bool,
    subdivide: Option<f32>,
    vertices: u32,
    tolerance: f64,
    time: f32,
    clip: Option<String>,
    normals: &str,
    crease: f64,
    terminator: &str,
    emission: &str,
    studio: Option<&str>,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let forms = [("emission", Form::Emission), ("lightmap", Form::Lightmap), ("vertex-colors", Form::VertexColors)];
    let form = named("form", form, &forms)?;
    let options = Choices { clip, normals, crease, terminator, emission, studio }.options()?;
    let settings = BakeSettings {
        form,
        page,
        density,
        padding,
        samples,
        per_light,
        unwrap,
        both_sides,
        subdivide,
        most_vertices: vertices,
    };
    let accuracy = Accuracy::new(args::within("tolerance", tolerance, 1e-6, 0.1)?);
    let render = Settings { accuracy, cache: cache_folder(), keep_points: false, ..Settings::default() };
    let file = create(&path, &output)?;
    let mut baker = run(py, None, |_, _| Baker::open(&path, &options, settings, render))?.or_raise()?;
    baker.notes().iter().try_for_each(|line| warn(py, line))?;
    let (baked, maps) = light(py, &mut baker, time, progress)?;
    let files = py.detach(|| baked.write(file, &output, &maps)).or_raise()?;
    values::fields(py, Ok(baked.report(&files)))
}
