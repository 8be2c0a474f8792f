//! Depth images for people.

use crate::ShadowMap;
use crate::layer::EMPTY;

/// A layer of a [`ShadowMap`] as an image of distances.
#[derive(Clone, Debug, PartialEq)]
pub struct MapImage {
    /// The number of its face: 0 of a single perspective, up to 5 of a cube.
    pub face: usize,
    /// The number of its layer in the face. Surfaces that face the light and surfaces that face away have their own.
    pub layer: usize,
    /// Columns and rows.
    pub size: [usize; 2],
    /// The distance of the surface from the light's centre, along the direction of the face, in world units, row by row from the top;
    /// infinite where there is none.
    pub distances: Vec<f32>,
}

impl ShadowMap {
    /// All layers, with at most `most` pixels a side: a pixel has the nearest surface of its texels.
    ///
    /// `distance = z₀/(1 + q)` for a texel's depth `q` and the face's reference distance `z₀`.
    ///
    /// # Cost
    /// One pass over all texels, a nanosecond each.
    ///
    /// # Panics
    /// When `most` is 0.
    #[must_use]
    pub fn images(&self, most: usize) -> Vec<MapImage> {
        assert!(most > 0, "an image has pixels");
        let of_face = |(face, of): (usize, &crate::face::Face)| {
            // Texels of a pixel, along each side.
            let step = of.width.max(of.height).div_ceil(most).max(1);
            let size = [of.width.div_ceil(step), of.height.div_ceil(step)];
            let image = |(layer, texels): (usize, &crate::layer::Layer)| {
                // The largest q is the nearest surface.
                let mut nearest = vec![EMPTY; size[0] * size[1]];
                for (row, texels) in texels.q().chunks_exact(of.width).enumerate() {
                    // Row 0 of a layer is at the bottom.
                    let line = (size[1] - 1 - row / step) * size[0];
                    for (column, q) in texels.iter().enumerate() {
                        let pixel = &mut nearest[line + column / step];
                        *pixel = pixel.max(*q);
                    }
                }
                let distance = |q: f32| if q == EMPTY { f32::INFINITY } else { (of.z0 / (1.0 + f64::from(q))) as f32 };
                MapImage { face, layer, size, distances: nearest.into_iter().map(distance).collect() }
            };
            of.layers.iter().enumerate().map(image).collect::<Vec<_>>()
        };
        self.faces.iter().enumerate().flat_map(of_face).collect()
    }
}

#[cfg(test)]
mod tests {
    use crate::{MapOptions, ShadowMap};
    use glam::Vec3;
    use lobe_core::Sphere;

    /// A slanted triangle under a light: its plane's distances, of the nearest texel where pixels are larger than texels.
    #[test]
    fn images_have_the_distances_of_surfaces() {
        let positions = [Vec3::new(-1.0, -2.0, -1.0), Vec3::new(1.0, -2.0, -1.0), Vec3::new(0.0, -3.0, 1.5)];
        let light = Sphere { center: Vec3::ZERO, radius: 0.1 };
        let options = MapOptions { resolution: 64, ..MapOptions::default() };
        let map = ShadowMap::build(&positions, &[[0, 1, 2]], light, &options).expect("a map");
        let fine = map.images(1024);
        assert_eq!(fine.len(), map.layers());
        let [image] = &fine[..] else { panic!("one layer") };
        assert_eq!((image.face, image.layer, image.distances.len()), (0, 0, image.size[0] * image.size[1]));
        let seen = |distances: &[f32]| -> Vec<f32> { distances.iter().copied().filter(|d| d.is_finite()).collect() };
        let ends = |distances: &[f32]| {
            let all = seen(distances);
            (all.iter().copied().fold(f32::INFINITY, f32::min), all.iter().copied().fold(0.0, f32::max))
        };
        let (near, far) = ends(&image.distances);
        assert!(seen(&image.distances).len() > 200 && seen(&image.distances).len() < image.distances.len());
        // Along the face's direction, which points to the triangle: no nearer than its plane, no farther than its corners.
        assert!(near > 1.5 && far < 3.6 && far - near > 0.3, "{near} to {far}");
        let coarse = map.images(16);
        assert!(coarse[0].size.iter().all(|side| (1..=16).contains(side)));
        assert_eq!(ends(&coarse[0].distances).0, near);
    }
}
