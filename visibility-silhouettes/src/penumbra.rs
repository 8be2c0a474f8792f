//! How narrow the penumbrae of listed edges may be.

use crate::edge_list::{ENDS, EdgeList};
use fearless_simd::{Simd, f32x8, mask32x8, prelude::*};
use lobe_core::Sphere;
use lobe_core::vec3x8::Vec3x8;

/// Room around the space between the receivers and the light, for rounding.
const AROUND: f32 = 1.000_1;

/// The width of the narrowest penumbra that edges may cast on receivers in a sphere, `2R d/(D − d)` with the distance `d` of the nearest edge
/// between the receivers and the light: infinite if there is none.
#[inline(always)]
pub(crate) fn narrowest<S: Simd>(simd: S, edges: &EdgeList, part: Sphere, light: Sphere) -> f32 {
    let [zero, one, tiny] = [0.0, 1.0, f32::MIN_POSITIVE].map(|x| f32x8::splat(simd, x));
    let mut nearest = f32x8::splat(simd, f32::INFINITY);
    let to_light = light.center - part.center;
    let distance = to_light.length().max(f32::MIN_POSITIVE);
    let axis = to_light / distance;
    // A cone that touches both spheres contains all between them: its radius is (r + h sin φ)/cos φ at the height h. Or a cylinder, if the light is the
    // smaller one.
    let sin = ((light.radius - part.radius) / distance).clamp(0.0, 0.999);
    let secant = AROUND / (1.0 - sin * sin).sqrt();
    for first in (0..edges.len()).step_by(8) {
        let [a, b] = [
            edges.load3(simd, ENDS[0], first).minus(part.center),
            edges.load3(simd, ENDS[1], first).minus(part.center),
        ];
        let high = a.dot_one(axis).max(b.dot_one(axis));
        let radius = (high.max(zero) * sin + part.radius) * secant;
        // Vectors as long as the points are far from the axis.
        let aside = nearest_sq([a.turned_about(axis), b.turned_about(axis)], [zero, one, tiny]);
        let is_there = mask32x8::from_bitmask(simd, u64::from(edges.lanes(first)));
        let is_between = is_there & aside.simd_le(radius * radius) & high.simd_ge(zero - part.radius * secant);
        if is_between.any_true() {
            nearest = is_between.select(nearest.min(nearest_sq([a, b], [zero, one, tiny])), nearest);
        }
    }
    let nearest: [f32; 8] = nearest.into();
    let nearest = nearest.into_iter().fold(f32::INFINITY, f32::min).sqrt();
    if nearest == f32::INFINITY {
        return nearest;
    }
    let near = (nearest / AROUND - part.radius).max(0.0);
    let beyond = distance + part.radius - near;
    if beyond > 0.0 { 2.0 * light.radius * near / beyond } else { f32::INFINITY }
}

/// Squares of the distances of eight segments from the origin.
#[inline(always)]
fn nearest_sq<S: Simd>([a, b]: [Vec3x8<S>; 2], [zero, one, tiny]: [f32x8<S>; 3]) -> f32x8<S> {
    let edge = b - a;
    let t = (zero - a.dot(edge)) / edge.dot(edge).max(tiny);
    let near = a + edge * t.max(zero).min(one);
    near.dot(near)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::edge_list::COLUMNS;
    use fearless_simd::{Level, dispatch};
    use glam::Vec3;

    fn width(edges: &[[Vec3; 2]], part: Sphere, light: Sphere) -> f32 {
        let mut list = EdgeList::default();
        for [a, b] in edges {
            let mut numbers = [0.0; COLUMNS];
            numbers[..3].copy_from_slice(&a.to_array());
            numbers[3..6].copy_from_slice(&b.to_array());
            list.push(numbers);
        }
        dispatch!(Level::new(), simd => narrowest(simd, &list, part, light))
    }

    /// A light of radius 0.5 at a distance of 4 over receivers within 0.1: the formula for an edge before the light, whatever other edges are
    /// beside it, and none for edges beside the light, behind it or below the receivers.
    #[test]
    fn nearest_edges_between_count() {
        let part = Sphere { center: Vec3::new(1.0, 0.0, 2.0), radius: 0.1 };
        let light = Sphere { center: part.center + 4.0 * Vec3::Y, radius: 0.5 };
        let edge = |x: f32, y: f32| [Vec3::new(x - 3.0, y, 2.0), Vec3::new(x + 3.0, y, 2.0)];
        let across = |x: f32, y: f32| [Vec3::new(x, y, -3.0), Vec3::new(x, y, 7.0)];
        let formula = |d: f32| {
            let d = d / AROUND - 0.1;
            2.0 * 0.5 * d / (4.1 - d)
        };
        for d in [0.2_f32, 1.0, 3.0] {
            let found = width(&[edge(1.0, d), edge(1.0, 3.5), across(1.0, d + 0.3)], part, light);
            assert!((found - formula(d)).abs() < 1e-5, "{d}: {found} for {}", formula(d));
        }
        assert_eq!(width(&[edge(1.0, 0.05)], part, light), 0.0, "through the receivers");
        assert_eq!(width(&[], part, light), f32::INFINITY);
        let beside = [across(1.2, 0.2), across(1.7, 3.9), edge(1.0, -0.2), across(0.75, 0.3)];
        assert_eq!(width(&beside, part, light), f32::INFINITY);
        // Just inside of the cone.
        assert!(width(&[across(1.265, 1.7)], part, light).is_finite());
    }
}
