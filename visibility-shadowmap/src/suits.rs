//! Tests whether a map shows the blockers of a light.

use crate::ShadowMap;
use crate::fit::{Fit, corners};
use glam::{DVec3, Vec3};
use lobe_core::Sphere;

/// Surfaces nearer to the light's centre than this many of its radii are not shown: other parts of the light see around them, and
/// every receiver has the whole map in front of its light (3.9 s for a picture that takes 0.8 s with rays).
const TOUCHING: f64 = 1.25;
/// Largest fraction of the area whose planes may cut the light. For a sphere the fraction is the sine of the light's half-angle.
const EDGE_ON: f64 = 0.4;

impl ShadowMap {
    /// Whether a map from the light's centre shows these triangles to all receivers of the light. It does not
    /// - if they touch the light, or nearly: its other parts then see around their outlines;
    /// - if the planes of most of their area cut the light: the light's centre sees such walls edge-on, in a few texels or none,
    ///   while half of the light sees their whole front.
    ///
    /// Use other blockers for them. Triangles with numbers that are not finite, or with vertices that do not exist, are reported by
    /// [`build`](Self::build).
    ///
    /// ```
    /// use glam::Vec3;
    /// use lobe_core::Sphere;
    /// use visibility_shadowmap::ShadowMap;
    /// let wall = [Vec3::ZERO, Vec3::Y, Vec3::new(0.0, 1.0, 1.0), Vec3::Z];
    /// let light = |x| Sphere { center: Vec3::new(x, 5.0, 0.5), radius: 1.0 };
    /// let shows = |x| ShadowMap::shows(&wall, &[[0, 1, 2], [0, 2, 3]], light(x));
    /// assert!(shows(3.0) && !shows(0.5));
    /// ```
    #[must_use]
    pub fn shows(positions: &[Vec3], triangles: &[[u32; 3]], light: Sphere) -> bool {
        let (center, radius) = (light.center.as_dvec3(), f64::from(light.radius));
        let (mut edge_on, mut all) = (0.0, 0.0);
        for triangle in triangles {
            let corner = |v: u32| positions.get(v as usize).map(|p| p.as_dvec3() - center);
            let [Some(a), Some(b), Some(c)] = triangle.map(corner) else { continue };
            let normal = (b - a).cross(c - a);
            let area = normal.length();
            if !(area > 0.0 && area.is_finite()) {
                continue;
            }
            all += area;
            let off = normal.dot(a).abs() / area;
            if off < radius {
                edge_on += area;
            }
            if off < TOUCHING * radius && distance([a, b, c], normal) < TOUCHING * radius {
                return false;
            }
        }
        edge_on <= EDGE_ON * all
    }

    /// Whether the map has texels of these triangles, if it was built from them: some triangle may be between one of its receivers
    /// and the light. Floors below all receivers, and walls around them, have no texels.
    ///
    /// A surface with texels is shadowed mostly by itself, from a few texels away: see
    /// [`ShadowMapBlockers::leaving`](crate::ShadowMapBlockers::leaving).
    ///
    /// ```
    /// use glam::Vec3;
    /// use lobe_core::Sphere;
    /// use visibility_shadowmap::{MapOptions, ReceiverBounds, ShadowMap};
    /// let square = |y| [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, z)| Vec3::new(x, y, z));
    /// let (table, floor, triangles) = (square(1.0), square(0.0), [[0, 1, 2], [0, 2, 3]]);
    /// let light = Sphere { center: Vec3::new(0.0, 5.0, 0.0), radius: 0.5 };
    /// let receivers = Some(ReceiverBounds { min: Vec3::new(-3.0, 0.0, -3.0), max: Vec3::new(3.0, 2.0, 3.0) });
    /// let map = ShadowMap::build(&table, &triangles, light, &MapOptions { receivers, ..MapOptions::default() })?;
    /// assert!(map.draws(&table, &triangles) && !map.draws(&floor, &triangles));
    /// # Ok::<(), visibility_shadowmap::MapError>(())
    /// ```
    #[must_use]
    pub fn draws(&self, positions: &[Vec3], triangles: &[[u32; 3]]) -> bool {
        let light = self.light();
        let center = light.center.as_dvec3();
        let receivers = self.receivers.map(|bounds| corners(&bounds, center));
        let far = positions.iter().chain([&light.center]).map(|p| p.abs().max_element()).fold(0.0, f32::max);
        let (radius, far) = (f64::from(light.radius), f64::from(far));
        let fit = Fit { radius, resolution: self.resolution(), receivers: receivers.as_ref(), far };
        let corner = |v: u32| positions.get(v as usize).map(|p| p.as_dvec3() - center);
        triangles.iter().any(|t| match t.map(corner) {
            [Some(a), Some(b), Some(c)] => fit.needs(&[a, b, c], far),
            _ => false,
        })
    }
}

/// The distance of a triangle from the origin.
fn distance(corners: [DVec3; 3], normal: DVec3) -> f64 {
    let next = |k: usize| corners[(k + 1) % 3];
    // The plane is nearest if the origin projects into the triangle, else an edge.
    if (0..3).all(|k| normal.dot((next(k) - corners[k]).cross(-corners[k])) >= 0.0) {
        return normal.dot(corners[0]).abs() / normal.length();
    }
    let to_edge = |k: usize| {
        let (from, along) = (corners[k], next(k) - corners[k]);
        let t = (-from.dot(along) / along.length_squared()).clamp(0.0, 1.0);
        (from + along * t).length()
    };
    (0..3).map(to_edge).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_core::oracle::Random;

    #[test]
    fn distance_is_that_of_the_nearest_point() {
        let mut random = Random::new(5);
        for _ in 0..300 {
            let corners = [0, 1, 2].map(|_| random.axis() * random.between(0.2, 2.0) + DVec3::X);
            let [a, b, c] = corners;
            let normal = (b - a).cross(c - a);
            let mut nearest = f64::INFINITY;
            for i in 0..=200 {
                for j in 0..=200 - i {
                    let (u, v) = (f64::from(i) / 200.0, f64::from(j) / 200.0);
                    nearest = nearest.min((a + (b - a) * u + (c - a) * v).length());
                }
            }
            let found = distance(corners, normal);
            assert!(found <= nearest + 1e-12 && nearest < found + 0.03, "{found} {nearest}");
        }
    }

    #[test]
    fn broken_triangles_are_left_out() {
        let light = Sphere { center: Vec3::new(0.0, 5.0, 0.0), radius: 1.0 };
        assert!(ShadowMap::shows(&[Vec3::ZERO; 3], &[[0, 1, 2], [0, 1, 9]], light));
        assert!(ShadowMap::shows(&[Vec3::NAN, Vec3::X, Vec3::Y], &[[0, 1, 2]], light));
    }
}
