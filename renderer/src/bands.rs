use crate::kept_points::{Found, KeptPoints};
use crate::{RenderError, Settings};
use brdf::Material;
use core::ops::Range;
use pictures::Window;
use render_cpu::{GBuffer, PixelSamples, TILE, World};
use scene::{Cancel, ShadingPoints, Stopwatch};
use visibility_shadowmap::ReceiverBounds;

/// The most camera rays of a band: bounds the memory of large pictures.
pub const BAND_RAYS: u64 = 1 << 19;

/// Runs `work` and adds its time to a clock in seconds.
pub fn seconds<T>(clock: &mut f64, work: impl FnOnce() -> T) -> T {
    let watch = Stopwatch::start();
    let result = work();
    *clock += watch.seconds();
    result
}

/// Camera rays of the strips on which a time budget is measured.
const TRIAL_RAYS: u64 = 1 << 15;

/// The visible points of parts of the picture.
#[derive(Debug)]
pub(crate) struct Bands<'w> {
    pub(crate) world: &'w World<'w>,
    samples: PixelSamples,
    /// The parts, in their order.
    pub(crate) parts: &'w [Window],
    /// Points that an earlier picture has kept, or that were found before shading.
    kept: &'w mut KeptPoints,
    /// Whether points are kept for the next picture.
    keeps: bool,
    pub(crate) cancel: &'w Cancel,
    /// Seconds spent on finding visible points.
    pub(crate) seconds: f64,
}

impl<'w> Bands<'w> {
    pub(crate) fn new(
        world: &'w World<'w>,
        settings: &Settings,
        parts: &'w [Window],
        kept: &'w mut KeptPoints,
        cancel: &'w Cancel,
    ) -> Self {
        let (samples, keeps) = (settings.samples, settings.keep_points);
        Self { world, samples, parts, kept, keeps, cancel, seconds: 0.0 }
    }

    /// Cuts a window into bands of rows with at most [`BAND_RAYS`] camera rays; the borders of bands are borders of tiles.
    fn cut(&self, window: &Window) -> impl Iterator<Item = Window> + use<> {
        let width = window.columns.len();
        let rows = BAND_RAYS / (width as u64 * u64::from(self.samples.usual())).max(1);
        let rows = (rows as u32 / TILE * TILE).max(TILE);
        window.parts([window.image[0].max(1), rows as usize])
    }

    /// The bands of all parts.
    pub(crate) fn windows(&self) -> Vec<Window> {
        self.parts.iter().flat_map(|part| self.cut(part)).collect()
    }

    pub(crate) fn points(&mut self, window: &Window) -> Result<Found, RenderError> {
        let (world, samples) = (self.world, self.samples);
        if let Some(kept) = self.kept.take(window, samples) {
            return Ok(kept);
        }
        let range = |side: &Range<usize>| side.start as u32..side.end as u32;
        let part = [range(&window.columns), range(&window.rows)];
        let (image, cancel) = (window.image.map(|side| side as u32), self.cancel);
        let find = || GBuffer::sampled(world, image, samples, part, cancel);
        let mut found = seconds(&mut self.seconds, find).ok_or(RenderError::Cancelled)?;
        found.find_squares();
        self.kept.found += 1;
        Ok(Found::new(found))
    }

    /// Keeps the points of a band for the next picture that needs them.
    pub(crate) fn keep(&mut self, window: &Window, points: Found) {
        if self.keeps {
            self.kept.put(window, self.samples, points);
        }
    }

    /// The box around all visible points of the picture, including those outside the parts, so that parts equal the whole picture.
    /// `None` if the camera sees nothing. Kept until something moves. Free if the whole picture is shaded and its points are few
    /// enough to be kept; else all points are found twice.
    pub(crate) fn bounds(&mut self) -> Result<Option<ReceiverBounds>, RenderError> {
        if let Some(known) = self.kept.bounds {
            return Ok(known);
        }
        let mut all: Option<ReceiverBounds> = None;
        let scene = self.world.scene();
        let picture = Window::whole(scene.width as usize, scene.height as usize);
        let keep = self.parts.len() == 1 && self.parts[0] == picture;
        for window in self.cut(&picture) {
            let g = self.points(&window)?;
            if let Some(b) = ReceiverBounds::of(g.points.points.receivers.iter().map(|r| r.position)) {
                all = Some(all.map_or(b, |a| ReceiverBounds { min: a.min.min(b.min), max: a.max.max(b.max) }));
            }
            if keep {
                self.kept.put(&window, self.samples, g);
            }
        }
        self.kept.bounds = Some(all);
        Ok(all)
    }

    /// The points of strips spread over the picture, their materials, and the picture's number of rows over that of the strips.
    pub(crate) fn strips(&self) -> (ShadingPoints, Vec<Material>, f64) {
        let scene = self.world.scene();
        let (width, height) = (scene.width, scene.height);
        let all = height.div_ceil(TILE);
        let rays = u64::from(width) * u64::from(TILE) * u64::from(self.samples.usual());
        let count = (TRIAL_RAYS / rays).clamp(1, u64::from(all)) as u32;
        let (mut points, mut materials, mut taken) = (ShadingPoints::default(), scene.materials.clone(), 0);
        let first = materials.len() as u32;
        for i in 0..count {
            let top = (u64::from(2 * i + 1) * u64::from(all) / (2 * u64::from(count))) as u32 * TILE;
            let rows = top..(top + TILE).min(height);
            taken += rows.len();
            let Some(g) = GBuffer::sampled(self.world, [width, height], self.samples, [0..width, rows], self.cancel)
            else {
                break;
            };
            let first_point = points.receivers.len();
            points.ends.extend(g.points.ends.iter().map(|end| first_point + end));
            points.receivers.extend(g.points.receivers);
            // These materials follow those of earlier strips.
            let before = materials.len() as u32 - first;
            points.materials.extend(g.points.materials.iter().map(|m| if *m < first { *m } else { *m + before }));
            materials.extend(g.materials.into_iter().skip(first as usize));
        }
        (points, materials, f64::from(height) / taken.max(1) as f64)
    }
}
