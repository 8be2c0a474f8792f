//! Triangles of a mesh: their area, their middle, how they are spread, and the sphere around them.

use glam::{DMat3, DVec3};

pub(super) type Triangle = [DVec3; 3];

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

/// Radius of a sphere around triangles.
pub(super) fn bounds<'a>(triangles: impl Iterator<Item = &'a Triangle>, middle: DVec3) -> f64 {
    triangles.flatten().map(|p| p.distance_squared(middle)).fold(0.0, f64::max).sqrt()
}
