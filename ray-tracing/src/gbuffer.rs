#[cfg(test)]
mod tests;
mod view;

use self::view::View;
use crate::World;
use crate::world::SIDE;
use brdf::Material;
use core::ops::{Add, Mul, Range};
use glam::Vec3;
use scene::ShadingPoints;

/// Side of the pixel tiles in whose order points are listed.
pub const TILE: u32 = SIDE as u32;

/// What the camera sees: the visible points of every pixel.
///
/// Points come tile by tile ([`TILE`]² pixels, left to right, top to bottom), so that neighbours in the list are
/// neighbours in space. A camera ray that meets nothing leaves no point.
#[derive(Clone, Debug, Default)]
pub struct GBuffer {
    /// Image width in pixels.
    pub width: u32,
    /// Image height in pixels.
    pub height: u32,
    /// Camera rays a pixel.
    pub samples: u32,
    /// The visible points.
    pub points: ShadingPoints,
    /// For each point the number of its pixel, `row·width + column`.
    pub pixels: Vec<u32>,
    /// For each point the distance from the plane of the eye, along the view direction.
    pub depths: Vec<f32>,
    /// What the points' material numbers refer to: the scene's materials, then those of points whose surfaces have textures or vertex
    /// colours, one each. The Monte-Carlo reference takes them from here.
    pub materials: Vec<Material>,
    /// For each point the radiance that its surface emits toward the eye; empty where no surface does.
    pub emission: Vec<Vec3>,
    /// For each pixel what its rays that met nothing see of the scene's environment: their sum over all its rays. Empty where there is
    /// none.
    pub sky: Vec<Vec3>,
}

impl GBuffer {
    /// Shoots `samples` rays (at least 1) through every pixel of a `width`×`height` image: one through its centre,
    /// several through a Hammersley set that is the same in all pixels.
    ///
    /// The rays of a tile go through the hierarchy together; closed surfaces have no cracks. Cost: 0.05 to 0.13 µs of a core
    /// a ray (`examples/points.rs`).
    ///
    /// # Panics
    /// When the image has more than 2³² pixels.
    #[must_use]
    pub fn new(world: &World<'_>, width: u32, height: u32, samples: u32) -> Self {
        Self::rows(world, width, height, samples, 0..height)
    }

    /// The same for some rows of the image only, as a picture of its own: large images in bands need little memory.
    ///
    /// # Panics
    /// As [`window`](Self::window).
    #[must_use]
    pub fn rows(world: &World<'_>, width: u32, height: u32, samples: u32, rows: Range<u32>) -> Self {
        Self::window(world, width, height, samples, 0..width, rows)
    }

    /// The same for a window of the image only, as a picture of its own: work that is split over processes.
    ///
    /// Every point is to the bit what it is in the whole image. Points come in the tiles of the whole image, cut at the
    /// window's edges.
    ///
    /// # Panics
    /// When the window has more than 2³² pixels or is not inside the image.
    #[must_use]
    pub fn window(
        world: &World<'_>,
        width: u32,
        height: u32,
        samples: u32,
        columns: Range<u32>,
        rows: Range<u32>,
    ) -> Self {
        let inside = |r: &Range<u32>, size: u32| r.start <= r.end && r.end <= size;
        assert!(inside(&columns, width) && inside(&rows, height), "window outside the image");
        let (own_width, own_height) = (columns.end - columns.start, rows.end - rows.start);
        assert!(u64::from(own_width) * u64::from(own_height) <= 1 << 32, "too many pixels");
        let samples = samples.max(1);
        let view = View::new(world, [width, height], samples, columns, rows);
        let (found, ends) = view.trace();
        let mut all = Self { width: own_width, height: own_height, samples, ..Self::default() };
        view.describe(&found, &ends, &mut all);
        all.sky = view.sky(&found);
        all
    }

    /// Adds what the points' surfaces emit to their radiance.
    ///
    /// # Panics
    /// When there is not one value a point.
    pub fn add_emission(&self, radiance: &mut [Vec3]) {
        assert_eq!(radiance.len(), self.len(), "one value a point");
        radiance.iter_mut().zip(&self.emission).for_each(|(sum, own)| *sum += *own);
    }

    /// Number of points.
    #[must_use]
    pub fn len(&self) -> usize {
        self.pixels.len()
    }

    /// True when the camera sees nothing.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.pixels.is_empty()
    }

    /// The picture of the points' radiance ([`resolve`](Self::resolve)), with the scene's environment behind them or, where it has none,
    /// `background`.
    ///
    /// # Panics
    /// When there is not one value a point.
    #[must_use]
    pub fn picture(&self, radiance: &[Vec3], background: Vec3) -> Vec<Vec3> {
        if self.sky.is_empty() {
            return self.resolve(radiance, background);
        }
        let mut picture = self.resolve(radiance, Vec3::ZERO);
        picture.iter_mut().zip(&self.sky).for_each(|(pixel, sky)| *pixel += *sky);
        picture
    }

    /// The picture of one value a point: the mean over each pixel's rays (a box filter), `background` where a ray met
    /// nothing.
    ///
    /// # Panics
    /// When there is not one value a point.
    #[must_use]
    pub fn resolve<T>(&self, values: &[T], background: T) -> Vec<T>
    where
        T: Copy + Default + Add<Output = T> + Mul<f32, Output = T>,
    {
        assert_eq!(values.len(), self.len(), "one value a point");
        let count = self.width as usize * self.height as usize;
        let (mut sums, mut hits) = (vec![T::default(); count], vec![0u32; count]);
        for (pixel, value) in self.pixels.iter().zip(values) {
            sums[*pixel as usize] = sums[*pixel as usize] + *value;
            hits[*pixel as usize] += 1;
        }
        let share = 1.0 / self.samples.max(1) as f32;
        let mean = |(sum, hits): (T, u32)| {
            if hits == self.samples { sum * share } else { (sum + background * ((self.samples - hits) as f32)) * share }
        };
        sums.into_iter().zip(hits).map(mean).collect()
    }
}
