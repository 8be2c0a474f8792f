use crate::RenderError;
use crate::kept_points::KeptPoints;
use brdf::Material;
use core::ops::Range;
use pictures::Window;
use render_cpu::{GBuffer, TILE, World};
use scene::{Cancel, ShadingPoints};
use std::time::Instant;
use visibility_shadowmap::ReceiverBounds;

/// Camera rays in flight: bounds the memory of large pictures.
pub const BAND_RAYS: u64 = 1 << 19;

/// Runs `work` and adds what it takes to a clock in seconds.
pub fn seconds<T>(clock: &mut f64, work: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let result = work();
    *clock += start.elapsed().as_secs_f64();
    result
}

/// Camera rays that a time budget is measured with.
const TRIAL_RAYS: u64 = 1 << 15;

/// The visible points of a window of the picture, band by band of rows.
#[derive(Debug)]
pub(crate) struct Bands<'w> {
    pub(crate) world: &'w World<'w>,
    samples: u32,
    pub(crate) window: Window,
    rows: u32,
    /// Points of the picture before, or found before they are shaded.
    kept: &'w mut KeptPoints,
    pub(crate) cancel: &'w Cancel,
    /// Seconds of finding visible points.
    pub(crate) seconds: f64,
}

impl<'w> Bands<'w> {
    pub(crate) fn new(
        world: &'w World<'w>,
        samples: u32,
        window: Window,
        kept: &'w mut KeptPoints,
        cancel: &'w Cancel,
    ) -> Self {
        let rows = BAND_RAYS / (window.size()[0] as u64 * u64::from(samples)).max(1);
        let rows = (rows as u32 / TILE * TILE).max(TILE);
        Self { world, samples, window, rows, kept, cancel, seconds: 0.0 }
    }

    /// Bands of these rows, whose borders are those of tiles.
    pub(crate) fn ranges(&self, rows: Range<u32>) -> impl Iterator<Item = Range<u32>> + use<> {
        let step = self.rows;
        let cut = move |k: u32| (k * step).max(rows.start)..((k + 1) * step).min(rows.end);
        (rows.start / step..rows.end.div_ceil(step)).map(cut)
    }

    pub(crate) fn points(&mut self, window: &Window, rows: Range<u32>) -> Result<GBuffer, RenderError> {
        let (world, samples) = (self.world, self.samples);
        let scene = world.scene();
        let columns = window.columns.start as u32..window.columns.end as u32;
        if let Some(kept) = self.kept.take(window, samples, &rows) {
            return Ok(kept);
        }
        let (image, cancel) = ([scene.width, scene.height], self.cancel);
        let find = || GBuffer::window_until(world, image, samples, columns, rows, cancel);
        let found = seconds(&mut self.seconds, find).ok_or(RenderError::Cancelled)?;
        self.kept.found += 1;
        Ok(found)
    }

    /// Keeps the points of a band for the next time that they are needed.
    pub(crate) fn keep(&mut self, window: &Window, rows: Range<u32>, points: GBuffer) {
        self.kept.put(window, self.samples, rows, points);
    }

    /// The box of all visible points of the picture, those outside the window too: its parts are to be as the whole.
    /// `None` when the camera sees nothing. Costs nothing where the points of the whole picture are few enough to be kept; else all
    /// points are found twice.
    pub(crate) fn bounds(&mut self) -> Result<Option<ReceiverBounds>, RenderError> {
        let mut all: Option<ReceiverBounds> = None;
        let [width, height] = self.window.image;
        let picture = Window::whole(width, height);
        let ranges: Vec<_> = self.ranges(0..height as u32).collect();
        let keep = self.window.is_whole();
        for rows in ranges {
            let g = self.points(&picture, rows.clone())?;
            if let Some(b) = ReceiverBounds::of(g.points.receivers.iter().map(|r| r.position)) {
                all = Some(all.map_or(b, |a| ReceiverBounds { min: a.min.min(b.min), max: a.max.max(b.max) }));
            }
            if keep {
                self.keep(&picture, rows, g);
            }
        }
        Ok(all)
    }

    /// The points of strips spread over the picture, their materials, and how many times their rows the picture has.
    pub(crate) fn strips(&self) -> (ShadingPoints, Vec<Material>, f64) {
        let scene = self.world.scene();
        let (width, height) = (scene.width, scene.height);
        let all = height.div_ceil(TILE);
        let rays = u64::from(width) * u64::from(TILE) * u64::from(self.samples);
        let count = (TRIAL_RAYS / rays).clamp(1, u64::from(all)) as u32;
        let (mut points, mut materials, mut taken) = (ShadingPoints::default(), scene.materials.clone(), 0);
        let first = materials.len() as u32;
        for i in 0..count {
            let top = (u64::from(2 * i + 1) * u64::from(all) / (2 * u64::from(count))) as u32 * TILE;
            let rows = top..(top + TILE).min(height);
            taken += rows.len();
            let g = GBuffer::rows(self.world, width, height, self.samples, rows);
            points.receivers.extend(g.points.receivers);
            // Behind those of the strips before.
            let before = materials.len() as u32 - first;
            points.materials.extend(g.points.materials.iter().map(|m| if *m < first { *m } else { *m + before }));
            materials.extend(g.materials.into_iter().skip(first as usize));
        }
        (points, materials, f64::from(height) / taken.max(1) as f64)
    }
}
