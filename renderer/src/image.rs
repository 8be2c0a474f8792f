use crate::bands::{Bands, seconds};
use crate::event::tell;
use crate::{Event, FrameClocks, Listener, RenderError, Shader, Work};
use core::ops::ControlFlow;
use glam::Vec3;
use lobe_core::Accuracy;
use render_cpu::ShadeRequest;
use scene::{Frame, ShadeStats, ShadingPoints};

/// A picture, or a window of one, row by row from the top, and how it was made.
#[derive(Clone, Debug, Default)]
pub struct Image {
    /// Columns and rows.
    pub size: [usize; 2],
    /// Linear radiance toward the eye, W·m⁻²·sr⁻¹ per channel.
    pub radiance: Vec<Vec3>,
    /// What it is made of, where the settings ask for it.
    pub layers: Option<Layers>,
    /// How it was made.
    pub stats: ImageStats,
}

/// The parts of a picture, pixel by pixel.
#[derive(Clone, Debug, Default)]
pub struct Layers {
    /// Radiance without blockers.
    pub unshadowed: Vec<Vec3>,
    /// The part of each light.
    pub lights: Vec<Vec<Vec3>>,
    /// Unit shading normals, the mean of a pixel's rays.
    pub normals: Vec<Vec3>,
    /// Distance from the plane of the eye, infinite where nothing is seen.
    pub depths: Vec<f32>,
    /// Visibility lobes made.
    pub lobes: Vec<f32>,
    /// Lobe integrals evaluated.
    pub products: Vec<f32>,
}

/// How a picture was made.
#[derive(Clone, Debug, Default)]
pub struct ImageStats {
    /// Requested error and depth of masks.
    pub accuracy: Accuracy,
    /// Visible points.
    pub points: usize,
    /// Of each repetition of the shading.
    pub shading: Vec<ShadeStats>,
    /// Seconds of the frame outside shading.
    pub clocks: FrameClocks,
    /// Seconds of compiling kernels.
    pub kernels: f64,
    /// Blocker spheres.
    pub spheres: usize,
    /// Triangles.
    pub triangles: usize,
    /// Resolution of each light's shadow map.
    pub map_resolutions: Vec<u32>,
    /// Bytes of all of them.
    pub map_bytes: usize,
}

/// Rows of a picture that are done.
#[derive(Clone, Debug, Default)]
pub struct Band {
    /// Which rows of the picture.
    pub rows: core::ops::Range<usize>,
    /// As [`Image::radiance`].
    pub radiance: Vec<Vec3>,
    /// As [`Image::layers`].
    pub layers: Option<Layers>,
}

/// Takes bands as they are done, from the top, and may have had enough.
pub type Sink<'a> = dyn FnMut(Band) -> ControlFlow<()> + 'a;

impl Layers {
    /// Appends the rows that follow.
    pub(crate) fn append(&mut self, next: Self) {
        self.unshadowed.extend(next.unshadowed);
        self.lights.resize(next.lights.len(), Vec::new());
        self.lights.iter_mut().zip(next.lights).for_each(|(all, next)| all.extend(next));
        self.normals.extend(next.normals);
        self.depths.extend(next.depths);
        self.lobes.extend(next.lobes);
        self.products.extend(next.products);
    }
}

/// Shades a picture band by band; the work that a strategy is chosen for.
pub(crate) struct Shading<'a, 'w, 'l, 's> {
    pub(crate) frame: &'a Frame<'a>,
    pub(crate) bands: &'a mut Bands<'w>,
    pub(crate) repeat: u32,
    pub(crate) layers: bool,
    pub(crate) listener: &'a mut Listener<'l>,
    pub(crate) sink: &'a mut Sink<'s>,
}

impl Work for Shading<'_, '_, '_, '_> {
    type Output = ImageStats;

    fn with<S: Shader>(self, shader: &mut S) -> Result<ImageStats, RenderError> {
        let Self { frame, bands, repeat, layers, listener, sink } = self;
        let background = bands.world.scene().background;
        let window = bands.window.clone();
        let mut done = ImageStats { shading: vec![ShadeStats::default(); repeat as usize], ..ImageStats::default() };
        let fail = |error: S::Error| -> RenderError { error.into() };
        // Compiles what there is to compile.
        seconds(&mut done.kernels, || shader.shade(&ShadingPoints::default(), frame, &mut [])).map_err(fail)?;
        let of = window.rows.len() as u32;
        for rows in bands.ranges(window.rows.start as u32..window.rows.end as u32) {
            tell(listener, Event::Rows { done: rows.start - window.rows.start as u32, of })?;
            let g = bands.points(&window, rows.clone())?;
            let frame = &Frame { materials: &g.materials, ..*frame };
            let mut radiance = vec![Vec3::ZERO; g.len()];
            let mut all = layers.then(Layers::default);
            let request =
                ShadeRequest { unshadowed: layers, lights: layers, counts: layers, cancel: Some(bands.cancel) };
            for (repetition, total) in done.shading.iter_mut().enumerate() {
                let shaded = shader.shade_with(&g.points, frame, &mut radiance, &request);
                if let Err(RenderError::Cancelled) = shaded {
                    // What was found is right, and is likely to be needed again.
                    bands.keep(&window, rows, g);
                    return Err(RenderError::Cancelled);
                }
                let (stats, mut points) = shaded?;
                *total += stats;
                if let (Some(all), 0) = (&mut all, repetition) {
                    g.add_emission(&mut points.unshadowed);
                    let count = frame.lights.len();
                    all.unshadowed = g.picture(&points.unshadowed, background);
                    let light = |l: usize| {
                        let part: Vec<Vec3> = points.lights.iter().skip(l).step_by(count).copied().collect();
                        g.resolve(&part, Vec3::ZERO)
                    };
                    all.lights = (0..count).map(light).collect();
                    let numbers = |n: &[u32]| n.iter().map(|n| *n as f32).collect::<Vec<f32>>();
                    all.lobes = g.resolve(&numbers(&points.lobes), 0.0);
                    all.products = g.resolve(&numbers(&points.integrals), 0.0);
                }
            }
            g.add_emission(&mut radiance);
            if let Some(all) = &mut all {
                let normals: Vec<Vec3> = g.points.receivers.iter().map(|r| r.normal).collect();
                all.normals = g.resolve(&normals, Vec3::ZERO);
                all.depths = g.resolve(&g.depths, f32::INFINITY);
            }
            done.points += g.len();
            let radiance = g.picture(&radiance, background);
            bands.keep(&window, rows.clone(), g);
            let rows = rows.start as usize..rows.end as usize;
            if sink(Band { rows, radiance, layers: all }).is_break() {
                break;
            }
        }
        Ok(done)
    }
}
