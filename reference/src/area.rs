//! Points on the surfaces of lights that are no spheres, drawn by area.

use crate::cone::concentric;
use core::f64::consts::{PI, TAU};
use glam::{DVec3, Vec3};
use lighting::{Area, AreaPoint, AreaShape, ShownImage};

/// Blockers count up to this fraction of the way to the light's surface, so that an object that shows the light does not hide it.
const BEFORE: f64 = 0.999_9;

/// A direction in which the light is seen, how far a ray goes before blockers no longer count, and the density per steradian with which
/// directions are drawn there.
pub(crate) struct Seen {
    pub(crate) direction: DVec3,
    pub(crate) distance: f64,
    pub(crate) pdf: f64,
    /// The light's radiance there over its mean.
    pub(crate) shows: Vec3,
}

/// A point drawn uniformly by area; `None` on the side away from the receiver.
pub(crate) fn sample(area: &Area<'_>, u: f64, v: f64) -> Option<Seen> {
    point(&area.shape, u, v).and_then(seen).map(|seen| show(area, seen))
}

/// The point where a ray meets a surface; `None` on the side away from the receiver.
pub(crate) fn hit(area: &Area<'_>, v: DVec3) -> Option<Seen> {
    met(&area.shape, v).and_then(seen).map(|seen| show(area, seen))
}

fn show(area: &Area<'_>, seen: Seen) -> Seen {
    let Some(ShownImage { image, middle, sides }) = &area.shown else { return seen };
    let p = seen.direction * (seen.distance / BEFORE) - *middle;
    let place = sides.map(|side| (p.dot(side) / side.length_squared()) as f32);
    Seen { shows: image.at(place.into(), 0.0), ..seen }
}

/// A point for two numbers in [0, 1).
fn point(shape: &AreaShape, u: f64, v: f64) -> Option<AreaPoint> {
    match shape {
        AreaShape::Sphere => None,
        AreaShape::Custom(surface) => surface.sample(u, v),
        AreaShape::Polygon { corners, normal, area } => {
            let first = corners[0];
            let mut left = u * area;
            let fans = corners[1..].windows(2);
            let last = corners.len() - 3;
            for (k, pair) in fans.enumerate() {
                let (p, q) = (pair[0] - first, pair[1] - first);
                let part = 0.5 * p.cross(q).length();
                if left <= part || k == last {
                    let s = (left / part).clamp(0.0, 1.0).sqrt();
                    return on(first + (p * (1.0 - v) + q * v) * s, *normal, *area);
                }
                left -= part;
            }
            None
        }
        AreaShape::Disc { center, normal, radius } => {
            let (a, b) = normal.any_orthonormal_pair();
            let (r, phi) = concentric(u, v);
            let (sin, cos) = phi.sin_cos();
            on(*center + (a * cos + b * sin) * (r * radius), *normal, PI * radius * radius)
        }
        AreaShape::Capsule { end, along, radius } => {
            let length = along.length();
            let axis = *along / length;
            let (a, b) = axis.any_orthonormal_pair();
            // By height: the mantle and, as Archimedes knew, both halves of a sphere have the same area for each length.
            let height = u * (length + 2.0 * radius) - radius;
            let (sin, cos) = (TAU * v).sin_cos();
            let aside = a * cos + b * sin;
            let beyond = if height < 0.0 { height } else { (height - length).max(0.0) };
            let z = (beyond / radius).clamp(-1.0, 1.0);
            let normal = axis * z + aside * (1.0 - z * z).sqrt();
            let middle = *end + axis * height.clamp(0.0, length);
            on(middle + normal * *radius, normal, TAU * radius * (length + 2.0 * radius))
        }
    }
}

/// The point that a ray meets.
fn met(shape: &AreaShape, v: DVec3) -> Option<AreaPoint> {
    match shape {
        AreaShape::Sphere => None,
        AreaShape::Custom(surface) => surface.hit(v),
        AreaShape::Polygon { corners, normal, area } => {
            let p = v * (normal.dot(corners[0]) / normal.dot(v));
            let inside = |i: usize| {
                let (a, b) = (corners[i], corners[(i + 1) % corners.len()]);
                (b - a).cross(p - a).dot(*normal)
            };
            let (low, high) = (0..corners.len())
                .map(inside)
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
            (v.dot(*normal) < 0.0 && (low >= 0.0 || high <= 0.0)).then(|| on(p, *normal, *area)).flatten()
        }
        AreaShape::Disc { center, normal, radius } => {
            let p = v * (normal.dot(*center) / normal.dot(v));
            let hits = v.dot(*normal) < 0.0 && p.distance_squared(*center) <= radius * radius;
            hits.then(|| on(p, *normal, PI * radius * radius)).flatten()
        }
        AreaShape::Capsule { end, along, radius } => {
            let length = along.length();
            let axis = *along / length;
            let area = TAU * radius * (length + 2.0 * radius);
            let aside = |p: DVec3| p - axis * p.dot(axis);
            let (d, o) = (aside(v), aside(-*end));
            // |o + t d| = r.
            let (a, b, c) = (d.length_squared(), o.dot(d), o.length_squared() - radius * radius);
            let root = b * b - a * c;
            if root >= 0.0 && a > 0.0 {
                let t = (-b - root.sqrt()) / a;
                let height = (v * t - *end).dot(axis);
                if t > 0.0 && (0.0..=length).contains(&height) {
                    let p = v * t;
                    return on(p, aside(p - *end) / *radius, area);
                }
            }
            [*end, *end + *along]
                .into_iter()
                .filter_map(|center| {
                    let along = center.dot(v);
                    let half = radius * radius - (center - v * along).length_squared();
                    let t = along - half.max(0.0).sqrt();
                    (half >= 0.0 && t > 0.0).then_some((t, center))
                })
                .min_by(|a, b| a.0.total_cmp(&b.0))
                .and_then(|(t, center)| on(v * t, (v * t - center) / *radius, area))
        }
    }
}

/// A point of a surface of that area, drawn evenly.
fn on(position: DVec3, normal: DVec3, area: f64) -> Option<AreaPoint> {
    Some(AreaPoint { position, normal, area })
}

fn seen(point: AreaPoint) -> Option<Seen> {
    let distance = point.position.length();
    let direction = point.position / distance;
    let cos = -direction.dot(point.normal);
    (cos > 0.0 && distance > 0.0).then(|| Seen {
        direction,
        distance: distance * BEFORE,
        pdf: distance * distance / (point.area * cos),
        shows: Vec3::ONE,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use lighting::{FlatLight, Light, TubeLight};

    const POSITION: Vec3 = Vec3::new(0.3, -0.2, 0.1);

    fn lights() -> [Light; 3] {
        let flat = FlatLight::rectangle(Vec3::new(0.0, 0.2, 2.0), Vec3::X, Vec3::new(0.0, 0.5, 0.2), Vec3::ONE);
        let disc = FlatLight::disc(Vec3::new(0.5, 0.2, 2.0), Vec3::new(0.2, 0.1, -1.0), 0.7, Vec3::ONE);
        let tube =
            TubeLight { ends: [Vec3::new(-1.0, 0.0, 2.0), Vec3::new(1.0, 0.4, 2.5)], radius: 0.3, radiance: Vec3::ONE };
        [flat.expect("a rectangle").on_both_sides().into(), disc.expect("a disc").into(), tube.into()]
    }

    /// A sampled direction meets the light where it was sampled, and the solid angle is that of random directions.
    #[test]
    fn samples_are_what_rays_meet() {
        for light in lights() {
            let area = light.kind().area(POSITION).expect("lit");
            let (n, mut solid) = (200, 0.0);
            for k in 0..n * n {
                let at = |i: usize| (i as f64 + 0.5) / n as f64;
                let Some(seen) = sample(&area, at(k % n), at(k / n)) else { continue };
                solid += 1.0 / seen.pdf;
                let hit = hit(&area, seen.direction).expect("a hit");
                assert!(
                    (hit.distance - seen.distance).abs() < 1e-6 * seen.distance,
                    "{} {}",
                    hit.distance,
                    seen.distance
                );
                assert!((hit.pdf / seen.pdf - 1.0).abs() < 1e-3);
            }
            solid /= (n * n) as f64;
            let m = 1500;
            let hits = (0..m * m)
                .filter(|k| {
                    let (z, phi) = (
                        2.0 * ((k % m) as f64 + 0.5) / f64::from(m) - 1.0,
                        TAU * (f64::from(k / m) + 0.5) / f64::from(m),
                    );
                    let s = (1.0 - z * z).sqrt();
                    hit(&area, DVec3::new(s * phi.cos(), s * phi.sin(), z)).is_some()
                })
                .count();
            let want = 2.0 * TAU * hits as f64 / f64::from(m * m);
            assert!((solid / want - 1.0).abs() < 5e-3, "{solid} {want}");
        }
    }
}
