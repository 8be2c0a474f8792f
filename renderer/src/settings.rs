use crate::error::{BETWEEN, LAYERS, LOBES};
use crate::{LayerSet, RenderError};
use render_cpu::PixelSamples;
use scene::Strategy;
use shading::Accuracy;
use std::path::PathBuf;
use visibility_shadowmap::MapOptions;

/// The most camera rays a pixel.
const MAX_SAMPLES: u32 = 1 << 16;

/// How visibility and reflectance are combined.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Method {
    /// The closed integral of each reflectance lobe over the light, times the lobe's *visible fraction*: the sum of the lobe over
    /// the mask. The fastest, and the closest to the reference.
    #[default]
    Moments,
    /// The same with visibility as a sum of lobes, cut from the mask's quad-tree, whose products with the reflectance lobe are
    /// integrated in closed form.
    Lobes,
    /// The paper as printed: least-squares lobes, tabulated products.
    Paper,
}

/// The device that computes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Device {
    /// All cores of the CPU.
    #[default]
    Cpu,
    /// The strongest graphics adapter, or else a software one. Needs the feature `gpu`.
    Gpu,
}

/// The settings of a [`Renderer`](crate::Renderer), beside the scene.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Strategy of all objects; `None`: each object's own in the scene, or else one by the kind of object.
    pub strategy: Option<Strategy>,
    /// How visibility and reflectance are combined.
    pub method: Method,
    /// The device that computes.
    pub device: Device,
    /// Requested error, and the depth of the masks.
    pub accuracy: Accuracy,
    /// Replaces `accuracy` by the best one whose frame takes at most so many milliseconds, measured before the first frame.
    pub time_budget: Option<f32>,
    /// Whether the tolerance is relative to each pixel's own radiance instead of the unshadowed radiance. Where little of a light is
    /// visible through an opening, as in a room behind a window, masks are always drawn again around that part; this does so in the dark
    /// ends of penumbrae as well. Up to 23 % slower.
    pub own_radiance: bool,
    /// Whether visible fractions are interpolated between the pixels of a tile, under eight lights and more that silhouettes hide, where no penumbra is
    /// narrower than the distance of these pixels. The tolerance is the picture's, over all lights together. On the CPU. Parts of a picture are those
    /// of the whole, to the bit, where their borders are multiples of 8 pixels.
    pub interpolate: bool,
    /// Contributions whose radiance is below this are dropped.
    pub threshold: f32,
    /// Camera rays a pixel.
    pub samples: PixelSamples,
    /// Texels a side of each light's shadow map; `None`: what the light's width takes.
    pub map_resolution: Option<u32>,
    /// The layers that pictures have.
    pub layers: LayerSet,
    /// Whether visible points are kept for a next picture that sees the same: about 60 bytes a camera ray, for up to two million
    /// rays. Of no use if only one picture is made, or the camera moves.
    pub keep_points: bool,
    /// How many times each picture is shaded, for timing.
    pub repeat: u32,
    /// Folder for results of earlier runs, sphere sets and the paper's table; `None`: nothing is read or written.
    pub cache: Option<PathBuf>,
}

impl Settings {
    /// Whether all numbers are in their ranges.
    ///
    /// # Errors
    /// [`RenderError::Setting`] that names the first number that is not.
    pub fn validate(&self) -> Result<(), RenderError> {
        let fault = |name, value: &dyn core::fmt::Display, expected| {
            Err(RenderError::Setting { name, value: value.to_string(), expected })
        };
        let Accuracy { tolerance, depth } = self.accuracy;
        if !(tolerance > 0.0 && tolerance <= 1.0) {
            return fault("tolerance", &tolerance, "a number above 0, 1 at most");
        }
        if !(1..=6).contains(&depth) {
            return fault("depth of masks", &depth, "1 to 6");
        }
        if let Some(budget) = self.time_budget.filter(|budget| !(*budget > 0.0 && budget.is_finite())) {
            return fault("time budget", &budget, "milliseconds above 0");
        }
        if !(self.threshold >= 0.0 && self.threshold.is_finite()) {
            return fault("threshold", &self.threshold, "a radiance of 0 or more");
        }
        let (PixelSamples::Uniform(rays) | PixelSamples::Edges(rays)) = self.samples;
        if !(1..=MAX_SAMPLES).contains(&rays) {
            return fault("camera rays a pixel", &rays, "1 to 65536");
        }
        if self.repeat == 0 {
            return fault("repetitions", &self.repeat, "1 or more");
        }
        let resolutions = MapOptions::MIN_RESOLUTION..=MapOptions::MAX_RESOLUTION;
        if let Some(resolution) = self.map_resolution.filter(|n| !resolutions.contains(n)) {
            return fault("resolution of shadow maps", &resolution, "16 to 8192 texels a side");
        }
        Ok(())
    }

    /// Checks that a device supports the settings.
    ///
    /// # Errors
    /// [`RenderError::NotOnGpu`]: only the CPU supports [`Method::Lobes`] and some [layers](LayerSet::is_of_cpu).
    pub fn check_device(&self, device: Device) -> Result<(), RenderError> {
        match device {
            Device::Gpu if self.layers.is_of_cpu() => Err(RenderError::NotOnGpu(LAYERS)),
            Device::Gpu if self.interpolate => Err(RenderError::NotOnGpu(BETWEEN)),
            Device::Gpu if self.method == Method::Lobes => Err(RenderError::NotOnGpu(LOBES)),
            _ => Ok(()),
        }
    }
}

impl Default for Settings {
    /// Default strategies, on the CPU, 0.5 % tolerance, one ray a pixel, no cache.
    fn default() -> Self {
        Self {
            strategy: None,
            method: Method::Moments,
            device: Device::Cpu,
            accuracy: Accuracy::default(),
            time_budget: None,
            own_radiance: false,
            interpolate: false,
            threshold: 0.0,
            samples: PixelSamples::Uniform(1),
            map_resolution: None,
            layers: LayerSet::NONE,
            keep_points: true,
            repeat: 1,
            cache: None,
        }
    }
}
