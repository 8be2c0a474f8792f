//! Balls and tubes in place of triangles.

use super::Triangle;
use super::picture::{shown, shown_across};
use crate::{Light, SphereLight, TubeLight};
use core::f64::consts::PI;
use glam::{DMat3, DVec3, Vec3};
use lobe_core::Sphere;

/// A tube with a shorter middle, in its radii, is a ball.
const SHORT: f64 = 0.05;

/// A ball, or a tube where its ends are not the same.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lamp {
    pub(super) ends: [DVec3; 2],
    pub(super) radius: f64,
}

impl Lamp {
    /// Whether a line meets it.
    pub(super) fn is_met(&self, from: DVec3, v: DVec3) -> bool {
        let across = |p: DVec3| p - v * v.dot(p);
        let (to, along) = (across(self.ends[0] - from), across(self.ends[1] - self.ends[0]));
        let square = along.length_squared();
        let t = if square > 0.0 { (-to.dot(along) / square).clamp(0.0, 1.0) } else { 0.0 };
        (to + along * t).length_squared() <= self.radius * self.radius
    }

    pub(super) fn light(&self, center: DVec3, scale: f64, radiance: Vec3) -> Light {
        let ends = self.ends.map(|p| (center + p * scale).as_vec3());
        let radius = (self.radius * scale) as f32;
        if ends[0] == ends[1] {
            SphereLight::new(Sphere { center: ends[0], radius }, radiance).into()
        } else {
            TubeLight { ends, radius, radiance }.into()
        }
    }

    /// A tube between two places, or a ball where they are next to each other.
    fn tube(middle: DVec3, axis: DVec3, length: f64, radius: f64) -> Self {
        Self { ends: [middle - axis * (0.5 * length), middle + axis * (0.5 * length)], radius }
    }
}

pub(super) fn area([a, b, c]: &Triangle) -> f64 {
    0.5 * (*b - *a).cross(*c - *a).length()
}

/// The middle of triangles' area, and the variances and covariances of its points: exact.
pub(super) fn moments<'a>(triangles: impl Iterator<Item = &'a Triangle> + Clone) -> (DVec3, DMat3) {
    let middles = |[a, b, c]: &Triangle| [0.5 * (*a + *b), 0.5 * (*b + *c), 0.5 * (*c + *a)];
    let (mut all, mut sum) = (0.0, DVec3::ZERO);
    for t in triangles.clone() {
        all += area(t);
        sum += middles(t).iter().sum::<DVec3>() * (area(t) / 3.0);
    }
    let middle = sum / all;
    let mut spread = DMat3::ZERO;
    for t in triangles {
        for p in middles(t) {
            let d = p - middle;
            spread += DMat3::from_cols(d * d.x, d * d.y, d * d.z) * (area(t) / (3.0 * all));
        }
    }
    (middle, spread)
}

/// The direction in which points are spread most: powers of the covariance keep it alone.
pub(super) fn longest(spread: DMat3) -> DVec3 {
    let mut power = spread;
    for _ in 0..12 {
        power = power * power;
        let trace = power.x_axis.x + power.y_axis.y + power.z_axis.z;
        if trace.is_nan() || trace <= 0.0 {
            return DVec3::Z;
        }
        power *= 1.0 / trace;
    }
    let columns = [power.x_axis, power.y_axis, power.z_axis];
    columns
        .into_iter()
        .max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()))
        .map_or(DVec3::Z, |a| a.normalize_or(DVec3::Z))
}

/// Radius of a ball around triangles.
pub(super) fn bounds<'a>(triangles: impl Iterator<Item = &'a Triangle>, middle: DVec3) -> f64 {
    triangles.flatten().map(|p| p.distance_squared(middle)).fold(0.0, f64::max).sqrt()
}

/// The tube that shows what triangles show along the axis in which they are longest, `πr²`, and across it, `2rh + πr²`.
pub(super) fn capsule(triangles: &[&Triangle]) -> Lamp {
    let (middle, spread) = moments(triangles.iter().copied());
    let (axis, bound) = (longest(spread), bounds(triangles.iter().copied(), middle));
    let along = shown(triangles, middle, bound, axis);
    let radius = (along / PI).sqrt();
    let length = (shown_across(triangles, middle, bound, axis) - along) / (2.0 * radius);
    if length > SHORT * radius {
        Lamp::tube(middle, axis, length, radius)
    } else {
        Lamp::tube(middle, axis, 0.0, radius)
    }
}

/// The tube as long as triangles that shows what they show across: of a piece of a ring, to which others are joined at both ends.
pub(super) fn share(triangles: &[&Triangle]) -> Lamp {
    let (middle, spread) = moments(triangles.iter().copied());
    let (axis, bound) = (longest(spread), bounds(triangles.iter().copied(), middle));
    let across = shown_across(triangles, middle, bound, axis);
    // Of points all along a length the variance is a twelfth of its square.
    let whole = (12.0 * axis.dot(spread * axis).max(0.0)).sqrt();
    let radius = 0.5 * across / whole;
    // Round ends show `πr²`.
    let length = whole - 0.5 * PI * radius;
    if length > SHORT * radius {
        Lamp::tube(middle, axis, length, radius)
    } else {
        Lamp::tube(middle, axis, 0.0, (across / PI).sqrt())
    }
}
