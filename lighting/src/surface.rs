//! Where the surface of a light is, for those who point at it.

use crate::{FlatLight, Light, TubeLight};
use glam::Vec3;
use lobe_core::Sphere;

impl Light {
    /// Distance of a point from the surface that emits; none for lights at infinity and those without a surface.
    ///
    /// ```
    /// use glam::Vec3;
    /// use lighting::{Light, SphereLight};
    /// use lobe_core::Sphere;
    /// let light: Light = SphereLight::new(Sphere { center: Vec3::Y, radius: 0.5 }, Vec3::ONE).into();
    /// assert_eq!(light.distance_to(Vec3::ZERO), Some(0.5));
    /// ```
    #[must_use]
    pub fn distance_to(&self, point: Vec3) -> Option<f32> {
        match self {
            Self::Sphere(light) => Some(to_sphere(&light.ball, point)),
            Self::Spot(spot) => Some(to_sphere(&spot.light.ball, point)),
            Self::Tube(tube) => Some(to_tube(tube, point)),
            Self::Flat(flat) => Some(to_flat(flat, point)),
            Self::Inside(inside) => inside.light.distance_to(point),
            _ => None,
        }
    }
}

fn to_sphere(sphere: &Sphere, point: Vec3) -> f32 {
    (point.distance(sphere.center) - sphere.radius).abs()
}

fn to_tube(tube: &TubeLight, point: Vec3) -> f32 {
    (to_segment(tube.ends, point) - tube.radius).abs()
}

fn to_segment([a, b]: [Vec3; 2], point: Vec3) -> f32 {
    let along = b - a;
    let t = (point - a).dot(along) / along.length_squared().max(f32::MIN_POSITIVE);
    point.distance(a + along * t.clamp(0.0, 1.0))
}

fn to_flat(flat: &FlatLight, point: Vec3) -> f32 {
    let (corners, normal) = (flat.corners(), flat.normal());
    if let (center, Some(radius)) = flat.as_disc() {
        let height = (point - center).dot(normal);
        let beside = ((point - center - normal * height).length() - radius).max(0.0);
        return height.hypot(beside);
    }
    let edges = || corners.iter().zip(corners.iter().cycle().skip(1)).map(|(a, b)| [*a, *b]);
    let is_above = edges().all(|[a, b]| normal.dot((b - a).cross(point - a)) >= 0.0);
    if is_above {
        return (point - corners[0]).dot(normal).abs();
    }
    edges().map(|edge| to_segment(edge, point)).fold(f32::INFINITY, f32::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SphereLight;
    use lobe_core::Random;

    /// Against the nearest of many points of the surface.
    #[test]
    fn distances_are_those_of_the_nearest_points() {
        let mut random = Random::new(3);
        let (center, u, v) = (Vec3::new(0.3, 1.0, -0.2), Vec3::new(0.8, 0.1, 0.0), Vec3::new(0.0, 0.2, 0.5));
        let quad: Light = FlatLight::rectangle(center, u, v, Vec3::ONE).expect("a rectangle").into();
        let normal = Vec3::new(0.2, 0.9, 0.1).normalize();
        let disc: Light = FlatLight::disc(center, normal, 0.7, Vec3::ONE).expect("a disc").into();
        let (x, y) = normal.any_orthonormal_pair();
        let ends = [center, center + u];
        let tube: Light = TubeLight { ends, radius: 0.25, radiance: Vec3::ONE }.into();
        let sphere: Light = SphereLight::new(Sphere { center, radius: 0.6 }, Vec3::ONE).into();
        let steps = || (0..=400).flat_map(|i| (0..=400).map(move |k| (i as f32 / 200.0 - 1.0, k as f32 / 200.0 - 1.0)));
        let quads: Vec<Vec3> = steps().map(|(s, t)| center + u * s + v * t).collect();
        let inside = |(s, t): &(f32, f32)| s * s + t * t <= 1.0;
        let discs: Vec<Vec3> = steps().filter(inside).map(|(s, t)| center + (x * s + y * t) * 0.7).collect();
        let axis = || (0..=20_000).map(|k| ends[0].lerp(ends[1], k as f32 / 20_000.0));
        let nearest = |points: &[Vec3], p: Vec3| points.iter().map(|q| q.distance(p)).fold(f32::INFINITY, f32::min);
        for _ in 0..60 {
            let p = center + Vec3::from_array(core::array::from_fn(|_| (random.uniform() * 4.0 - 2.0) as f32));
            let near = |light: &Light, want: f32| {
                let got = light.distance_to(p).expect("a surface");
                // Half a step of the samples.
                assert!((got - want).abs() <= 4e-3, "{}: {got} {want}", light.kind());
            };
            near(&quad, nearest(&quads, p));
            near(&disc, nearest(&discs, p));
            near(&tube, (axis().map(|q| q.distance(p)).fold(f32::INFINITY, f32::min) - 0.25).abs());
            near(&sphere, (p.distance(center) - 0.6).abs());
        }
    }
}
