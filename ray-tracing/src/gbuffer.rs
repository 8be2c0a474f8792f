//! The visible points of a picture, and pictures of values at them.

mod edges;
#[cfg(test)]
mod tests;
mod view;

pub use edges::PixelSamples;

use crate::world::SIDE;
use brdf::Material;
use core::ops::{Add, Mul};
use glam::Vec3;
use scene::ShadingPoints;

/// Side of the pixel tiles in whose order points are listed.
pub const TILE: u32 = SIDE as u32;

/// The visible points of every pixel.
///
/// Points come tile by tile ([`TILE`]² pixels, left to right, top to bottom), so that neighbours in the list are
/// neighbours in space, and the points of a pixel side by side. A camera ray that meets nothing leaves no point.
#[derive(Clone, Debug, Default)]
pub struct GBuffer {
    /// Image width in pixels.
    pub width: u32,
    /// Image height in pixels.
    pub height: u32,
    /// Camera rays a pixel; where only some pixels have several, those of one of them.
    pub samples: u32,
    /// The visible points.
    pub points: ShadingPoints,
    /// For each point the number of its pixel, `row·width + column`.
    pub pixels: Vec<u32>,
    /// For each point the number of its pixel's rays that it stands for, of [`samples`](Self::samples) in all; empty where each point
    /// is of one ray.
    pub rays: Vec<u32>,
    /// For each point the distance from the plane of the eye, along the view direction; of a panoramic camera that from the eye.
    pub depths: Vec<f32>,
    /// The materials that points refer to by number: the scene's materials, then one for each point whose surface has textures or vertex
    /// colours. The Monte-Carlo reference takes them from here.
    pub materials: Vec<Material>,
    /// For each point the radiance that its surface emits toward the eye; empty where no surface does.
    pub emission: Vec<Vec3>,
    /// For each pixel the radiance of the environment, summed over its rays that met nothing. Empty without an
    /// environment.
    pub sky: Vec<Vec3>,
}

impl GBuffer {
    /// Adds the emission of the points' surfaces to their radiance.
    ///
    /// # Panics
    /// When there is not one value a point.
    pub fn add_emission(&self, radiance: &mut [Vec3]) {
        assert_eq!(radiance.len(), self.len(), "one value a point");
        radiance.iter_mut().zip(&self.emission).for_each(|(sum, own)| *sum += *own);
    }

    /// Finds the [square tiles](ShadingPoints::squares) among its points: those with one point in each of [`TILE`]² pixels.
    pub fn find_squares(&mut self) {
        const SIDE: usize = TILE as usize;
        let (pixels, width) = (&self.pixels, self.width);
        let ends = &self.points.ends;
        let is_square = |first: &usize| {
            let corner = pixels[*first];
            let is_in_place =
                |(k, pixel): (usize, &u32)| *pixel == corner + (k / SIDE) as u32 * width + (k % SIDE) as u32;
            pixels[*first..].iter().take(SIDE * SIDE).enumerate().all(is_in_place)
        };
        let firsts = core::iter::once(0).chain(ends.iter().copied()).zip(ends);
        let firsts = firsts.filter(|(first, end)| *first + SIDE * SIDE == **end).map(|(first, _)| first);
        self.points.squares = firsts.filter(is_square).collect();
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
        let mut picture = vec![Vec3::ZERO; self.width as usize * self.height as usize];
        self.picture_into(radiance, background, &mut picture);
        picture
    }

    /// The same in memory of the caller's.
    ///
    /// # Panics
    /// When there is not one value a point, or one pixel of the picture.
    pub fn picture_into(&self, radiance: &[Vec3], background: Vec3, picture: &mut [Vec3]) {
        if self.sky.is_empty() {
            return self.resolve_into(radiance, background, picture);
        }
        self.resolve_into(radiance, Vec3::ZERO, picture);
        picture.iter_mut().zip(&self.sky).for_each(|(pixel, sky)| *pixel += *sky);
    }

    /// The picture of one value a point: the mean over each pixel's rays (a box filter of one pixel), `background` where a ray met
    /// nothing.
    ///
    /// # Panics
    /// When there is not one value a point.
    #[must_use]
    pub fn resolve<T>(&self, values: &[T], background: T) -> Vec<T>
    where
        T: Copy + Default + Add<Output = T> + Mul<f32, Output = T>,
    {
        let mut picture = vec![T::default(); self.width as usize * self.height as usize];
        self.resolve_into(values, background, &mut picture);
        picture
    }

    /// Standard errors of pixels from those of their points. Points are independent: a pixel's variance is the sum of theirs times the
    /// squares of their parts of its rays. Errors of any size, whose squares may be no f32.
    ///
    /// # Panics
    /// When there is not one value a point.
    #[must_use]
    pub fn resolve_errors(&self, errors: &[Vec3]) -> Vec<Vec3> {
        let largest = errors.iter().map(|e| e.max_element()).fold(0.0, f32::max);
        let unit = if largest > 0.0 { largest } else { 1.0 };
        let mut variances: Vec<Vec3> = errors.iter().map(|e| (*e / unit) * (*e / unit)).collect();
        variances.iter_mut().zip(&self.rays).for_each(|(variance, rays)| *variance *= *rays as f32);
        let part = 1.0 / self.samples as f32;
        self.resolve(&variances, Vec3::ZERO).iter().map(|v| (*v * part).map(f32::sqrt) * unit).collect()
    }

    /// The same in memory of the caller's.
    ///
    /// # Panics
    /// When there is not one value a point, or one pixel of the picture.
    pub fn resolve_into<T>(&self, values: &[T], background: T, picture: &mut [T])
    where
        T: Copy + Default + Add<Output = T> + Mul<f32, Output = T>,
    {
        assert_eq!(values.len(), self.len(), "one value a point");
        assert_eq!(picture.len(), self.width as usize * self.height as usize, "one value a pixel");
        let share = 1.0 / self.samples.max(1) as f32;
        let mean = |sum: T, missed: u32| {
            if missed == 0 { sum * share } else { (sum + background * (missed as f32)) * share }
        };
        picture.fill(mean(T::default(), self.samples));
        let mut first = 0;
        for pixels in self.pixels.chunk_by(|a, b| a == b) {
            let points = first..first + pixels.len();
            let values = &values[points.clone()];
            picture[pixels[0] as usize] = match self.rays.get(points) {
                Some(rays) if !self.rays.is_empty() => {
                    let sum = values.iter().zip(rays).fold(T::default(), |sum, (value, n)| sum + *value * (*n as f32));
                    mean(sum, self.samples - rays.iter().sum::<u32>())
                }
                _ => {
                    let sum = values.iter().fold(T::default(), |sum, value| sum + *value);
                    mean(sum, self.samples - pixels.len() as u32)
                }
            };
            first += pixels.len();
        }
    }
}
