//! Flat lights that are far larger than their distance: the part of them that a receiver has before it.

use super::Outline;
use glam::{DVec2, Vec3};

/// A receiver sees a light as far as this many times its distance from the light's plane, along each of two axes. The rest is within 0.06° of
/// that plane: it adds 1e-6 of the irradiance of a receiver that faces the plane, and 1e-3 of one at right angles to it.
pub(super) const FAR: f32 = 1e3;

/// Straight lines that stand for the rim of a disc, on either side of its point next to the receiver.
const RIM: i32 = 4;

/// A shape in a plane, in the world.
pub(super) enum Place<'a> {
    Polygon(&'a [Vec3]),
    Disc(Vec3, f64),
}

/// The part of a shape within [`FAR`] heights of the foot of a receiver's perpendicular on its plane, in f64: single precision loses the height
/// beside such lengths. `axis` is the plane's unit normal away from the receiver. None where nothing is there.
pub(super) fn near_part(place: &Place<'_>, from: Vec3, axis: Vec3) -> Option<Outline> {
    let from = from.as_dvec3();
    let normal = axis.as_dvec3().normalize();
    let (u, v) = normal.any_orthonormal_pair();
    let to = |p: Vec3| p.as_dvec3() - from;
    let height = match place {
        Place::Polygon(corners) => corners.iter().map(|p| normal.dot(to(*p))).sum::<f64>() / corners.len() as f64,
        Place::Disc(center, _) => normal.dot(to(*center)),
    };
    let flat = |p: Vec3| DVec2::new(u.dot(to(p)), v.dot(to(p)));
    let reach = f64::from(FAR) * height;
    let mut part: Vec<DVec2> =
        [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| DVec2::new(x, y) * reach).into();
    match place {
        Place::Polygon(corners) => {
            let corners: Vec<DVec2> = corners.iter().map(|p| flat(*p)).collect();
            let next = || corners.iter().cycle().skip(1);
            let turn = corners.iter().zip(next()).map(|(p, q)| p.perp_dot(*q)).sum::<f64>().signum();
            for (p, q) in corners.iter().zip(next()) {
                part = cut(&part, *p, (*q - *p).perp() * turn);
            }
        }
        Place::Disc(center, radius) => {
            let center = flat(*center);
            let nearest = (-center).normalize_or(DVec2::X);
            for k in -RIM..=RIM {
                // The rim runs through the part within this angle.
                let outward = nearest.rotate(DVec2::from_angle(1.5 * f64::from(k) / f64::from(RIM) * reach / radius));
                part = cut(&part, center + outward * *radius, -outward);
            }
        }
    }
    while part.len() > Outline::MOST {
        part.remove(least(&part));
    }
    let corners: Vec<Vec3> = part.iter().map(|p| (u * p.x + v * p.y + normal * height).as_vec3()).collect();
    Outline::new(&corners, axis)
}

/// The part of a convex polygon on the side of a line through `at` to which `inward` points.
fn cut(polygon: &[DVec2], at: DVec2, inward: DVec2) -> Vec<DVec2> {
    let height = |p: DVec2| inward.dot(p - at);
    let mut out = Vec::with_capacity(polygon.len() + 1);
    for (i, p) in polygon.iter().enumerate() {
        let q = polygon[(i + 1) % polygon.len()];
        let (h, g) = (height(*p), height(q));
        if h >= 0.0 {
            out.push(*p);
        }
        if (h >= 0.0) != (g >= 0.0) {
            out.push(*p + (q - *p) * (h / (h - g)));
        }
    }
    out
}

/// The corner without which a polygon loses least.
fn least(polygon: &[DVec2]) -> usize {
    let count = polygon.len();
    let area = |i: usize| {
        let (p, q, r) = (polygon[(i + count - 1) % count], polygon[i], polygon[(i + 1) % count]);
        (q - p).perp_dot(r - p).abs()
    };
    (0..count).min_by(|i, k| area(*i).total_cmp(&area(*k))).unwrap_or(0)
}
