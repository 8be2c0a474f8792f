use crate::args;
use crate::camera::Camera;
use crate::errors::OrRaise;
use crate::handles::{self, LightHandle, MaterialHandle, ObjectHandle};
use crate::scene::Scene;
use crate::settings::Settings;
use crate::shared::{Held, Shared};
use crate::values;
use crate::work::run;
use cosine_lobes::Window;
use cosine_lobes::lobe_core::Receiver;
use cosine_lobes::renderer::{self, Image, ImageStats, LayerSet, Layers};
use cosine_lobes::scene::Cancel;
use glam::Vec3;
use numpy::{PyArray2, PyArray3, PyArrayMethods, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::exceptions::{PyMemoryError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyFrozenSet};
use serde_json::json;
use std::sync::atomic::{AtomicU64, Ordering};

/// Turns a scene into pictures, and keeps what the next picture can use. Edits are by handles, numbers or names; the next picture makes
/// again only what they have made stale.
///
/// Several threads may use it: one after the other, while other renderers work beside it.
#[pyclass(module = "cosine_lobes", frozen)]
pub(crate) struct Renderer {
    shared: Shared<Inner>,
    /// The number of this renderer, which its handles carry.
    pub(crate) number: u64,
}

pub(crate) struct Inner {
    pub(crate) renderer: renderer::Renderer,
    pub(crate) settings: Settings,
    stats: Option<ImageStats>,
}

static COUNT: AtomicU64 = AtomicU64::new(0);

/// The layers of `lobes render --layers`.
const LAYERS: LayerSet = LayerSet { objects: false, ..LayerSet::ALL };

type Progress<'a, 'py> = Option<&'a Bound<'py, PyAny>>;

impl Renderer {
    pub(crate) fn hold(&self, py: Python<'_>) -> PyResult<Held<'_, Inner>> {
        self.shared.hold(py)
    }
}

impl Inner {
    fn size(&self) -> [usize; 2] {
        [self.renderer.scene().width as usize, self.renderer.scene().height as usize]
    }

    /// A part of the picture: its left column, upper row, width and height; none for all of it.
    fn window(&self, part: Option<(usize, usize, usize, usize)>) -> PyResult<Window> {
        let [width, height] = self.size();
        let Some((x, y, across, down)) = part else { return Ok(Window::whole(width, height)) };
        let is_inside = |first: usize, count: usize, all: usize| count > 0 && first < all && count <= all - first;
        if !(is_inside(x, across, width) && is_inside(y, down, height)) {
            let fault = format!("window is {:?}: expected a part of {width} x {height} pixels", (x, y, across, down));
            return Err(PyValueError::new_err(fault));
        }
        Ok(Window { image: [width, height], columns: x..x + across, rows: y..y + down })
    }

    /// Renders into memory of three numbers a pixel.
    fn render_into(
        &mut self,
        py: Python<'_>,
        progress: Progress<'_, '_>,
        window: &Window,
        pixels: &mut [f32],
    ) -> PyResult<()> {
        let renderer = &mut self.renderer;
        let stats = run(py, progress, |cancel, reporter| {
            renderer.set_cancel(cancel.clone());
            let pixels: &mut [Vec3] = bytemuck::cast_slice_mut(pixels);
            let done = renderer.render_into(window, &mut |event| reporter.hear(event), pixels);
            renderer.set_cancel(Cancel::new());
            done
        });
        self.stats = Some(stats?.or_raise()?);
        Ok(())
    }

    /// Renders with some layers.
    fn render_layers(
        &mut self,
        py: Python<'_>,
        progress: Progress<'_, '_>,
        window: &Window,
        layers: LayerSet,
    ) -> PyResult<Image> {
        self.renderer.set_layers(layers).or_raise()?;
        let renderer = &mut self.renderer;
        let image = run(py, progress, |cancel, reporter| {
            renderer.set_cancel(cancel.clone());
            let done = renderer.render_window(window, &mut |event| reporter.hear(event));
            renderer.set_cancel(Cancel::new());
            done
        });
        self.renderer.set_layers(LayerSet::NONE).or_raise()?;
        let image = image?.or_raise()?;
        self.stats = Some(image.stats.clone());
        Ok(image)
    }
}

/// The layers of some names; those of the command where there are none.
fn layer_set(names: Option<Vec<String>>) -> PyResult<LayerSet> {
    let Some(names) = names else { return Ok(LAYERS) };
    let mut set = LayerSet::NONE;
    for name in names {
        let layer = match name.as_str() {
            "unshadowed" => &mut set.unshadowed,
            "lights" => &mut set.lights,
            "normal" => &mut set.normals,
            "depth" => &mut set.depths,
            "object" => &mut set.objects,
            "counts" => &mut set.counts,
            _ => {
                let known = "unshadowed, lights, normal, depth, object, counts";
                return Err(PyValueError::new_err(format!("layer \"{name}\": expected some of {known}")));
            }
        };
        *layer = true;
    }
    Ok(set)
}

/// The layers of a picture by the names that its OpenEXR file has.
fn named_layers<'py>(py: Python<'py>, image: Image, set: LayerSet) -> PyResult<Bound<'py, PyDict>> {
    let (size, all) = (image.size, PyDict::new(py));
    let Layers { unshadowed, lights, normals, depths, objects, lobes, products } = image.layers;
    all.set_item("beauty", values::layer(py, size, &image.radiance)?)?;
    if set.unshadowed {
        all.set_item("unshadowed", values::layer(py, size, &unshadowed)?)?;
    }
    for (number, light) in lights.iter().enumerate() {
        all.set_item(format!("light{number}"), values::layer(py, size, light)?)?;
    }
    if set.normals {
        all.set_item("normal", values::layer(py, size, &normals)?)?;
    }
    if set.depths {
        all.set_item("depth", values::plane(py, size, depths)?)?;
    }
    if set.objects {
        let numbers =
            objects.iter().map(|o| i64::from(*o)).map(|o| if o == i64::from(Layers::NO_OBJECT) { -1 } else { o });
        all.set_item("object", values::plane(py, size, numbers.collect())?)?;
    }
    if set.counts {
        all.set_item("lobes", values::plane(py, size, lobes)?)?;
        all.set_item("products", values::plane(py, size, products)?)?;
    }
    Ok(all)
}

/// Checks the array of a picture that is rendered into.
fn writable<'py>(out: &Bound<'py, PyAny>, [width, height]: [usize; 2]) -> PyResult<Bound<'py, PyArray3<f32>>> {
    let Ok(array) = out.cast::<PyUntypedArray>() else {
        let kind = args::type_name(out);
        return Err(PyTypeError::new_err(format!("out is of type {kind}: expected a numpy array of float32")));
    };
    if out.cast::<PyArray3<f32>>().is_err() && array.ndim() == 3 {
        let dtype = array.dtype();
        return Err(PyTypeError::new_err(format!("out has dtype {dtype}: expected float32")));
    }
    if array.shape() != [height, width, 3] {
        let shape = args::shape_of(array);
        return Err(PyValueError::new_err(format!("out has shape {shape}: expected ({height}, {width}, 3)")));
    }
    if !array.is_c_contiguous() {
        let strides = array.strides();
        return Err(PyValueError::new_err(format!(
            "out has strides {strides:?}: expected rows in order, without gaps"
        )));
    }
    Ok(out.cast::<PyArray3<f32>>()?.clone())
}

#[pymethods]
impl Renderer {
    /// A renderer of a scene, which it copies. Changes of the settings may be given by keyword.
    #[new]
    #[pyo3(signature = (scene, settings = None, **changes))]
    fn new(
        py: Python<'_>,
        scene: PyRef<'_, Scene>,
        settings: Option<&Bound<'_, Settings>>,
        changes: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let settings = Settings::changed(py, settings, changes)?;
        let (own, animation, chosen) = (scene.scene.clone(), scene.animation.clone(), settings.settings()?);
        let renderer = py.detach(|| renderer::Renderer::new(own, animation, chosen)).or_raise()?;
        let number = COUNT.fetch_add(1, Ordering::Relaxed);
        Ok(Self { shared: Shared::new(Inner { renderer, settings, stats: None }), number })
    }

    /// Renders the picture: linear radiance, `(height, width, 3)`, the top row first. With `out` into that array.
    ///
    /// `window` is a part of the picture to render alone: left column, upper row, width, height. `progress(stage, done)` is called from this
    /// thread; what it raises stops the work, as Ctrl-C does.
    #[pyo3(signature = (*, progress = None, out = None, window = None))]
    fn render<'py>(
        &self,
        py: Python<'py>,
        progress: Option<&Bound<'py, PyAny>>,
        out: Option<&Bound<'py, PyAny>>,
        window: Option<(usize, usize, usize, usize)>,
    ) -> PyResult<Bound<'py, PyArray3<f32>>> {
        let mut held = self.hold(py)?;
        let window = held.value.window(window)?;
        let [width, height] = window.size();
        if let Some(out) = out {
            let array = writable(out, [width, height])?;
            let refused = |error: numpy::BorrowError| PyValueError::new_err(format!("out: {error}"));
            let mut memory = array.try_readwrite().map_err(refused)?;
            let wrong = |_| PyValueError::new_err("out: expected rows in order, without gaps");
            held.value.render_into(py, progress, &window, memory.as_slice_mut().map_err(wrong)?)?;
            drop(memory);
            return Ok(array);
        }
        let mut pixels = Vec::new();
        let count = 3 * width * height;
        pixels.try_reserve_exact(count).map_err(|error| PyMemoryError::new_err(error.to_string()))?;
        pixels.resize(count, 0.0);
        held.value.render_into(py, progress, &window, &mut pixels)?;
        values::image(py, [width, height], pixels)
    }

    /// Renders the picture with its layers, by the names that they have in files of `lobes render --layers`. `names` are some of
    /// "unshadowed", "lights", "normal", "depth", "object" and "counts"; when left out all but "object". `window` as of [`render`](Self::render).
    #[pyo3(signature = (names = None, *, progress = None, window = None))]
    fn layers<'py>(
        &self,
        py: Python<'py>,
        names: Option<Vec<String>>,
        progress: Option<&Bound<'py, PyAny>>,
        window: Option<(usize, usize, usize, usize)>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let set = layer_set(names)?;
        let mut held = self.hold(py)?;
        let window = held.value.window(window)?;
        let image = held.value.render_layers(py, progress, &window, set)?;
        named_layers(py, image, set)
    }

    /// The picture without shadows.
    #[pyo3(signature = (*, progress = None))]
    fn unshadowed<'py>(
        &self,
        py: Python<'py>,
        progress: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyArray3<f32>>> {
        let set = LayerSet { unshadowed: true, ..LayerSet::NONE };
        let mut held = self.hold(py)?;
        let window = held.value.window(None)?;
        let image = held.value.render_layers(py, progress, &window, set)?;
        values::layer(py, image.size, &image.layers.unshadowed)
    }

    /// The fraction of each pixel that shows a surface, `(height, width)`: the rest shows the background.
    #[pyo3(signature = (*, window = None))]
    fn coverage<'py>(
        &self,
        py: Python<'py>,
        window: Option<(usize, usize, usize, usize)>,
    ) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let mut held = self.hold(py)?;
        let window = held.value.window(window)?;
        let renderer = &mut held.value.renderer;
        let found = run(py, None, |cancel, _| {
            renderer.set_cancel(cancel.clone());
            let found = renderer.coverage(&window);
            renderer.set_cancel(Cancel::new());
            found
        });
        values::plane(py, window.size(), found?.or_raise()?)
    }

    /// The exposure, in stops, that PNG files of the command have.
    fn exposure(&self, py: Python<'_>) -> PyResult<f32> {
        let mut held = self.hold(py)?;
        let renderer = &mut held.value.renderer;
        run(py, None, |_, _| renderer.exposure())
    }

    /// The surface at the centre of a pixel; none where the camera sees nothing.
    fn pick(&self, py: Python<'_>, x: u32, y: u32) -> PyResult<Option<Pick>> {
        let mut held = self.hold(py)?;
        let renderer = &mut held.value.renderer;
        let picked = run(py, None, |_, _| renderer.pick(x, y))?;
        let of = self.number;
        Ok(picked.map(|pick| Pick {
            name: held.value.renderer.objects().find(|(o, _)| *o == pick.object).map(|(_, o)| o.name.clone()),
            object: ObjectHandle { handle: pick.object, of },
            light: pick.light.map(|handle| LightHandle { handle, of }),
            material: MaterialHandle { handle: pick.material, of },
            position: pick.receiver.position.into(),
            normal: pick.receiver.normal.into(),
            view: pick.receiver.view.into(),
            distance: pick.distance,
        }))
    }

    /// The visible fraction of a light for a white diffuse surface at a point, for red, green and blue.
    fn visible_fraction(
        &self,
        py: Python<'_>,
        point: &Bound<'_, PyAny>,
        normal: &Bound<'_, PyAny>,
        light: &Bound<'_, PyAny>,
    ) -> PyResult<(f32, f32, f32)> {
        let (position, normal) = (args::vec3("point", point)?, args::direction("normal", normal)?);
        let mut held = self.hold(py)?;
        let light = handles::light(light, &held.value.renderer, self.number)?;
        let (at, renderer) = (Receiver::on_surface(position, normal, normal), &mut held.value.renderer);
        let fraction = run(py, None, |cancel, _| {
            renderer.set_cancel(cancel.clone());
            let done = renderer.visible_fraction(&at, light);
            renderer.set_cancel(Cancel::new());
            done
        });
        Ok(fraction?.or_raise()?.into())
    }

    /// Moves the animation to a time in seconds.
    fn seek(&self, py: Python<'_>, time: f32) -> PyResult<()> {
        if !(time >= 0.0 && time.is_finite()) {
            return Err(PyValueError::new_err(format!("time is {time}: expected seconds of at least 0")));
        }
        let mut held = self.hold(py)?;
        let renderer = &mut held.value.renderer;
        run(py, None, |_, _| renderer.seek(time))
    }

    /// The present time of the animation, in seconds.
    #[getter]
    fn time(&self, py: Python<'_>) -> PyResult<f32> {
        Ok(self.hold(py)?.value.renderer.time())
    }

    /// The settings.
    #[getter]
    fn settings(&self, py: Python<'_>) -> PyResult<Settings> {
        Ok(self.hold(py)?.value.settings.clone())
    }

    /// Width and height of pictures.
    #[getter]
    fn size(&self, py: Python<'_>) -> PyResult<(usize, usize)> {
        Ok(self.hold(py)?.value.size().into())
    }

    /// The camera at the present time.
    #[getter]
    fn camera(&self, py: Python<'_>) -> PyResult<Camera> {
        Ok(Camera::of(self.hold(py)?.value.renderer.scene().camera))
    }

    /// How often the data that is kept between pictures was built or updated so far.
    #[getter]
    fn upkeep<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let upkeep = self.hold(py)?.value.renderer.upkeep();
        values::fields(
            py,
            Ok(json!({
                "hierarchy_builds": upkeep.hierarchy_builds,
                "hierarchy_refits": upkeep.hierarchy_refits,
                "silhouette_builds": upkeep.silhouette_builds,
                "silhouette_refits": upkeep.silhouette_refits,
                "sphere_sets": upkeep.sphere_sets,
                "sphere_updates": upkeep.sphere_updates,
                "point_bands": upkeep.point_bands,
                "maps": upkeep.maps,
                "sky_tables": upkeep.sky_tables,
                "ray_worlds": upkeep.ray_worlds,
            })),
        )
    }

    /// The kinds of results that edits have made stale since the last picture.
    #[getter]
    fn stale<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyFrozenSet>> {
        let stale = self.hold(py)?.value.renderer.stale();
        PyFrozenSet::new(py, stale.names())
    }

    /// Times and counts of the last picture; none before it.
    #[getter]
    fn stats<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let held = self.hold(py)?;
        let Some(stats) = &held.value.stats else { return Ok(None) };
        let shading: f64 = stats.shading.iter().map(|shading| shading.seconds).sum();
        let clocks = &stats.clocks;
        let all = json!({
            "tolerance": stats.accuracy.tolerance,
            "depth": stats.accuracy.depth,
            "points": stats.points,
            "triangles": stats.triangles,
            "spheres": stats.spheres,
            "map_resolutions": stats.map_resolutions,
            "seconds": {
                "pose": clocks.pose,
                "hierarchy": clocks.hierarchy,
                "silhouettes": clocks.silhouettes,
                "spheres": clocks.spheres,
                "maps": clocks.maps,
                "visible_points": clocks.gbuffer,
                "shading": shading,
            },
        });
        values::fields(py, Ok(all)).map(Some)
    }
}

/// The surface that a pixel shows.
#[pyclass(module = "cosine_lobes", frozen, get_all)]
pub(crate) struct Pick {
    object: ObjectHandle,
    name: Option<String>,
    light: Option<LightHandle>,
    material: MaterialHandle,
    position: (f32, f32, f32),
    normal: (f32, f32, f32),
    view: (f32, f32, f32),
    distance: f32,
}
