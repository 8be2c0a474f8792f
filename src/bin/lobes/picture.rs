//! A picture, shaded in bands.

use crate::args::RenderArgs;
use crate::device::Shader;
use crate::failure::Failure;
use crate::strategy::Work;
use cosine_lobes::render_cpu::{GBuffer, TILE, World};
use cosine_lobes::scene::{Frame, ShadeStats, ShadingPoints};
use cosine_lobes::visibility_shadowmap::Bounds;
use cosine_lobes::{ExrLayer, ExrPart, PictureStream, Window};
use glam::Vec3;
use std::ops::Range;
use std::time::Instant;

/// Camera rays in flight: bounds the memory of large pictures.
pub(crate) const BAND_RAYS: u64 = 1 << 19;

/// Runs `work` and adds what it takes to a clock in seconds.
pub(crate) fn seconds<T>(clock: &mut f64, work: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let result = work();
    *clock += start.elapsed().as_secs_f64();
    result
}

/// Camera rays that a time budget is measured with.
const TRIAL_RAYS: u64 = 1 << 15;

/// The visible points of a window of the picture, band by band of rows.
pub(crate) struct Bands<'w> {
    world: &'w World<'w>,
    samples: u32,
    window: Window,
    rows: u32,
    /// The picture's only band, where it has been looked at before it is shaded.
    kept: Option<GBuffer>,
    /// Seconds of finding visible points.
    pub(crate) seconds: f64,
}

impl<'w> Bands<'w> {
    pub(crate) fn new(world: &'w World<'w>, samples: u32, window: Window) -> Self {
        let rows = BAND_RAYS / (window.size()[0] as u64 * u64::from(samples)).max(1);
        let rows = (rows as u32 / TILE * TILE).max(TILE);
        Self { world, samples, window, rows, kept: None, seconds: 0.0 }
    }

    /// Bands of these rows, whose borders are those of tiles.
    fn ranges(&self, rows: Range<u32>) -> impl Iterator<Item = Range<u32>> + use<> {
        let step = self.rows;
        let cut = move |k: u32| (k * step).max(rows.start)..((k + 1) * step).min(rows.end);
        (rows.start / step..rows.end.div_ceil(step)).map(cut)
    }

    fn points(&mut self, window: &Window, rows: Range<u32>) -> GBuffer {
        let (world, samples) = (self.world, self.samples);
        let scene = world.scene();
        let columns = window.columns.start as u32..window.columns.end as u32;
        match self.kept.take() {
            Some(g) => g,
            None => {
                seconds(&mut self.seconds, || GBuffer::window(world, scene.width, scene.height, samples, columns, rows))
            }
        }
    }

    /// The box of all visible points of the picture, those outside the window too: its parts are to be as the whole.
    /// `None` when the camera sees nothing. Costs nothing where one band is the whole picture, since its points are kept; else all
    /// points are found twice.
    pub(crate) fn bounds(&mut self) -> Option<Bounds> {
        let mut all: Option<Bounds> = None;
        let [width, height] = self.window.image;
        let picture = Window::whole(width, height);
        let ranges: Vec<_> = self.ranges(0..height as u32).collect();
        let keep = ranges.len() == 1 && self.window.is_whole();
        for rows in ranges {
            let g = self.points(&picture, rows);
            if let Some(b) = Bounds::of(g.points.receivers.iter().map(|r| r.position)) {
                all = Some(all.map_or(b, |a| Bounds { min: a.min.min(b.min), max: a.max.max(b.max) }));
            }
            self.kept = keep.then_some(g);
        }
        all
    }

    /// The points of strips spread over the picture, and how many times their rows the picture has.
    pub(crate) fn strips(&self) -> (ShadingPoints, f64) {
        let scene = self.world.scene();
        let (width, height) = (scene.width, scene.height);
        let all = height.div_ceil(TILE);
        let rays = u64::from(width) * u64::from(TILE) * u64::from(self.samples);
        let count = (TRIAL_RAYS / rays).clamp(1, u64::from(all)) as u32;
        let (mut points, mut taken) = (ShadingPoints::default(), 0);
        for i in 0..count {
            let top = (u64::from(2 * i + 1) * u64::from(all) / (2 * u64::from(count))) as u32 * TILE;
            let rows = top..(top + TILE).min(height);
            taken += rows.len();
            let g = GBuffer::rows(self.world, width, height, self.samples, rows);
            points.receivers.extend(g.points.receivers);
            points.materials.extend(g.points.materials);
        }
        (points, f64::from(height) / taken.max(1) as f64)
    }
}

/// What shading a picture came to.
#[derive(Default)]
pub(crate) struct Shaded {
    pub(crate) points: usize,
    /// Seconds of compiling kernels.
    pub(crate) kernels: f64,
    /// One entry a repetition.
    pub(crate) stats: Vec<ShadeStats>,
}

/// What `--layers` adds to the rows of a band.
#[derive(Default)]
struct Planes {
    unshadowed: Vec<Vec3>,
    lights: Vec<Vec<Vec3>>,
    normals: Vec<Vec3>,
    depths: Vec<f32>,
    lobes: Vec<f32>,
    products: Vec<f32>,
}

/// The names of a picture's channels, with those of `--layers` for so many lights where it is given.
pub(crate) fn channels(lights: Option<usize>) -> Vec<String> {
    let planes = lights.map(|count| Planes { lights: vec![Vec::new(); count], ..Planes::default() });
    let nowhere = Window { image: [0, 0], columns: 0..0, rows: 0..0 };
    part(nowhere, &[], planes.as_ref()).channels.into_iter().map(|(name, _)| name).collect()
}

fn part(window: Window, beauty: &[Vec3], planes: Option<&Planes>) -> ExrPart {
    let mut layers = vec![ExrLayer::color("beauty", beauty)];
    layers.extend(planes.into_iter().flat_map(Planes::layers));
    ExrPart::of_layers(window, &layers)
}

/// Shades a picture; the work that a strategy is chosen for.
pub(crate) struct Shading<'a, 'w> {
    pub(crate) args: &'a RenderArgs,
    pub(crate) frame: &'a Frame<'a>,
    pub(crate) bands: &'a mut Bands<'w>,
    /// Gets the rows.
    pub(crate) stream: &'a mut PictureStream,
    /// Told how many rows are done.
    pub(crate) progress: &'a dyn Fn(u32),
}

impl Work for Shading<'_, '_> {
    type Output = Shaded;

    fn with<S: Shader>(self, shader: &mut S) -> Result<Shaded, Failure> {
        let Self { args, frame, bands, stream, progress } = self;
        let scene = bands.world.scene();
        let window = bands.window.clone();
        let mut shaded = Shaded { stats: vec![ShadeStats::default(); args.repeat as usize], ..Shaded::default() };
        // Compiles what there is to compile.
        seconds(&mut shaded.kernels, || shader.shade(&ShadingPoints::default(), frame, &mut []))?;
        for rows in bands.ranges(window.rows.start as u32..window.rows.end as u32) {
            progress(rows.start - window.rows.start as u32);
            let g = bands.points(&window, rows.clone());
            let mut radiance = vec![Vec3::ZERO; g.len()];
            let mut planes = Planes::default();
            for (repetition, total) in shaded.stats.iter_mut().enumerate() {
                let stats = if args.layers {
                    let (stats, layers) = shader.shade_layers(&g.points, frame, &mut radiance)?;
                    if repetition == 0 {
                        let count = frame.lights.len();
                        planes.unshadowed = g.resolve(&layers.unshadowed, scene.background);
                        let light = |l: usize| {
                            let part: Vec<Vec3> = layers.lights.iter().skip(l).step_by(count).copied().collect();
                            g.resolve(&part, Vec3::ZERO)
                        };
                        planes.lights = (0..count).map(light).collect();
                        let numbers = |n: &[u32]| n.iter().map(|n| *n as f32).collect::<Vec<f32>>();
                        planes.lobes = g.resolve(&numbers(&layers.lobes), 0.0);
                        planes.products = g.resolve(&numbers(&layers.integrals), 0.0);
                    }
                    stats
                } else {
                    shader.shade(&g.points, frame, &mut radiance)?
                };
                *total += stats;
            }
            if args.layers {
                let normals: Vec<Vec3> = g.points.receivers.iter().map(|r| r.normal).collect();
                planes.normals = g.resolve(&normals, Vec3::ZERO);
                planes.depths = g.resolve(&g.depths, f32::INFINITY);
            }
            shaded.points += g.len();
            let beauty = g.resolve(&radiance, scene.background);
            let band = Window { rows: rows.start as usize..rows.end as usize, ..window.clone() };
            if !stream.send(part(band, &beauty, args.layers.then_some(&planes))) {
                // Why is told when the stream is finished.
                break;
            }
        }
        Ok(shaded)
    }
}

impl Planes {
    /// The layers that `--layers` asks for.
    fn layers(&self) -> Vec<ExrLayer> {
        let mut layers = vec![ExrLayer::color("unshadowed", &self.unshadowed)];
        layers.extend(self.lights.iter().enumerate().map(|(i, l)| ExrLayer::color(&format!("light{i}"), l)));
        layers.push(ExrLayer::vector("normal", &self.normals));
        layers.push(ExrLayer::scalar("depth", 'Z', self.depths.clone()));
        layers.push(ExrLayer::scalar("lobes", 'N', self.lobes.clone()));
        layers.push(ExrLayer::scalar("products", 'N', self.products.clone()));
        layers
    }
}
