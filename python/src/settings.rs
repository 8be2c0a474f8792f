use crate::errors::OrRaise;
use crate::mesh::strategy;
use cosine_lobes::render_cpu::PixelSamples;
use cosine_lobes::renderer::{self, Device, LayerSet, Method};
use cosine_lobes::shading::Accuracy;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;

/// Camera rays of a pixel that an outline crosses, where `samples` is none.
const EDGE_SAMPLES: u32 = 8;

/// How a renderer makes its pictures; the defaults are those of `lobes render`. Immutable, comparable, can be pickled.
#[pyclass(module = "cosine_lobes", frozen, eq)]
#[derive(Clone, PartialEq)]
pub(crate) struct Settings {
    #[pyo3(get)]
    tolerance: f64,
    #[pyo3(get)]
    depth: Option<u32>,
    #[pyo3(get)]
    visibility: Option<String>,
    #[pyo3(get)]
    method: String,
    #[pyo3(get)]
    device: String,
    #[pyo3(get)]
    samples: Option<u32>,
    #[pyo3(get)]
    time_budget: Option<f64>,
    #[pyo3(get)]
    own_radiance: bool,
    #[pyo3(get)]
    interpolate: bool,
    #[pyo3(get)]
    threshold: f64,
    #[pyo3(get)]
    map_resolution: Option<u32>,
    #[pyo3(get)]
    keep_points: bool,
    #[pyo3(get)]
    cache: Option<PathBuf>,
}

/// The folder of kept sphere sets and tables, the command's: `cosine-lobes` in the user's cache folder.
pub(crate) fn cache_folder() -> Option<PathBuf> {
    Some(dirs::cache_dir()?.join("cosine-lobes"))
}

/// The value that a name stands for.
pub(crate) fn named<T: Copy>(what: &str, name: &str, all: &[(&str, T)]) -> PyResult<T> {
    let found = all.iter().find(|(known, _)| *known == name).map(|(_, value)| *value);
    found.ok_or_else(|| {
        let names: Vec<&str> = all.iter().map(|(name, _)| *name).collect();
        PyValueError::new_err(format!("{what} is \"{name}\": expected one of {}", names.join(", ")))
    })
}

impl Settings {
    /// The settings of a renderer.
    pub(crate) fn settings(&self) -> PyResult<renderer::Settings> {
        let methods = [("moments", Method::Moments), ("lobes", Method::Lobes), ("paper", Method::Paper)];
        let devices = [("cpu", Device::Cpu), ("gpu", Device::Gpu)];
        let requested = Accuracy::new(self.tolerance as f32);
        let settings = renderer::Settings {
            strategy: strategy(self.visibility.as_deref().filter(|name| *name != "scene"))?,
            method: named("method", &self.method, &methods)?,
            device: named("device", &self.device, &devices)?,
            accuracy: self.depth.map_or(requested, |depth| requested.with_depth(depth)),
            time_budget: self.time_budget.map(|milliseconds| milliseconds as f32),
            own_radiance: self.own_radiance,
            interpolate: self.interpolate,
            threshold: self.threshold as f32,
            samples: self.samples.map_or(PixelSamples::Edges(EDGE_SAMPLES), PixelSamples::Uniform),
            map_resolution: self.map_resolution,
            layers: LayerSet::NONE,
            keep_points: self.keep_points,
            repeat: 1,
            cache: self.cache.clone(),
        };
        settings.validate().or_raise()?;
        settings.check_device(settings.device).or_raise()?;
        Ok(settings)
    }

    /// The given settings, or the default ones, with changes by keyword.
    pub(crate) fn changed(
        py: Python<'_>,
        settings: Option<&Bound<'_, Self>>,
        changes: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let all = settings.map_or_else(|| Ok(PyDict::new(py)), |settings| settings.get().fields(py))?;
        if let Some(changes) = changes {
            all.update(changes.as_mapping())?;
        }
        let made = py.get_type::<Self>().call((), Some(&all))?;
        Ok(made.cast::<Self>()?.get().clone())
    }

    fn fields<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let all = PyDict::new(py);
        all.set_item("tolerance", self.tolerance)?;
        all.set_item("depth", self.depth)?;
        all.set_item("visibility", &self.visibility)?;
        all.set_item("method", &self.method)?;
        all.set_item("device", &self.device)?;
        all.set_item("samples", self.samples)?;
        all.set_item("time_budget", self.time_budget)?;
        all.set_item("own_radiance", self.own_radiance)?;
        all.set_item("interpolate", self.interpolate)?;
        all.set_item("threshold", self.threshold)?;
        all.set_item("map_resolution", self.map_resolution)?;
        all.set_item("keep_points", self.keep_points)?;
        match &self.cache {
            Some(folder) => all.set_item("cache", folder)?,
            None => all.set_item("cache", false)?,
        }
        Ok(all)
    }
}

#[pymethods]
impl Settings {
    #[new]
    #[pyo3(signature = (*, tolerance = 0.005, depth = None, visibility = None, method = "moments", device = "cpu", samples = None, time_budget = None, own_radiance = false, interpolate = false, threshold = 0.0, map_resolution = None, keep_points = true, cache = None))]
    #[expect(clippy::too_many_arguments, reason = "each is a keyword")]
    fn new(
        tolerance: f64,
        depth: Option<u32>,
        visibility: Option<String>,
        method: &str,
        device: &str,
        samples: Option<u32>,
        time_budget: Option<f64>,
        own_radiance: bool,
        interpolate: bool,
        threshold: f64,
        map_resolution: Option<u32>,
        keep_points: bool,
        cache: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let cache = match cache {
            None => cache_folder(),
            Some(cache) => match cache.extract::<bool>() {
                Ok(is_kept) => cache_folder().filter(|_| is_kept),
                Err(_) => Some(cache.extract()?),
            },
        };
        let (method, device) = (method.to_owned(), device.to_owned());
        let settings = Self {
            tolerance,
            depth,
            visibility,
            method,
            device,
            samples,
            time_budget,
            own_radiance,
            interpolate,
            threshold,
            map_resolution,
            keep_points,
            cache,
        };
        settings.settings()?;
        Ok(settings)
    }

    /// The same settings with some changed.
    #[pyo3(signature = (**changes))]
    fn replace(slf: &Bound<'_, Self>, changes: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        Self::changed(slf.py(), Some(slf), changes)
    }

    /// All of them as a dictionary, the arguments of the constructor.
    fn asdict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.fields(py)
    }

    /// For pickles.
    fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> PyResult<((), Bound<'py, PyDict>)> {
        Ok(((), self.fields(py)?))
    }

    fn __repr__(slf: &Bound<'_, Self>) -> PyResult<String> {
        let fields = slf.get().fields(slf.py())?;
        let all: Vec<String> =
            fields.iter().map(|(key, value)| Ok(format!("{key}={}", value.repr()?))).collect::<PyResult<_>>()?;
        Ok(format!("Settings({})", all.join(", ")))
    }
}
