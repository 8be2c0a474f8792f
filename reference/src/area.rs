//! The surfaces of lights that are no spheres, in f64: the true shapes, sampled by area.

use crate::cone::concentric;
use core::f64::consts::{PI, TAU};
use glam::{DVec3, Vec3};
use lighting::{FlatLight, Light, SkyLight, TubeLight};
use lobe_core::{LightImage, LightLobes, Sphere};

/// Blockers count up to this fraction of the way to the light's surface, so that an object that shows the light does not hide it.
const BEFORE: f64 = 0.999_9;

/// A light's surface as a receiver sees it, relative to the receiver.
#[derive(Clone, Debug)]
pub(crate) struct Area<'l> {
    shape: Shape,
    shown: Option<Shown<'l>>,
}

/// The image of a flat light, from its middle along two half sides.
#[derive(Clone, Debug)]
struct Shown<'l> {
    image: &'l LightImage,
    middle: DVec3,
    sides: [DVec3; 2],
}

#[derive(Clone, Debug)]
enum Shape {
    /// A convex polygon: its corners, its unit normal toward the receiver, its area.
    Polygon {
        corners: Vec<DVec3>,
        normal: DVec3,
        area: f64,
    },
    Disc {
        center: DVec3,
        normal: DVec3,
        radius: f64,
    },
    /// A capsule: the middle of one end, the way to the other, the radius.
    Capsule {
        end: DVec3,
        along: DVec3,
        radius: f64,
    },
}

/// A direction in which the light is seen, how far a ray goes before blockers no longer count, and the density per steradian with which
/// directions are drawn there.
pub(crate) struct Seen {
    pub(crate) direction: DVec3,
    pub(crate) distance: f64,
    pub(crate) pdf: f64,
    /// The light's radiance there over its mean.
    pub(crate) shows: Vec3,
}

impl<'l> Area<'l> {
    /// The sphere around a light, and the light's shape if that is no sphere; `None` where the light faces away.
    pub(crate) fn of(light: &'l Light, position: Vec3) -> Option<(Sphere, Option<Self>)> {
        let plain = |shape| Some(Self { shape, shown: None });
        Some(match light {
            Light::Sphere(light) => (light.sphere, None),
            Light::Spot(light) => (light.light.sphere, None),
            Light::Sun(light) | Light::Sky(SkyLight::Sun(light)) => (light.sphere_from(position), None),
            Light::Enclosed(inside) => return Self::of(&inside.light, position),
            Light::Ambient(_) => (Sphere { center: position, radius: 1.0 }, None),
            Light::Tube(light) => (light.bounds(), plain(Shape::of_tube(light, position))),
            Light::Flat(light) => {
                let shape = Shape::of_flat(light, position)?;
                (light.bounds(), Some(Self { shape, shown: Shown::of_flat(light, position) }))
            }
            Light::Sky(sky @ SkyLight::Patch(patch)) => {
                let bounds = sky.bounds_from(&Sphere { center: position, radius: 0.0 });
                let middle = bounds.center.as_dvec3() - position.as_dvec3();
                // As far away as the sphere is.
                let distance = middle.length() / patch.center.as_dvec3().length();
                let sides = patch.sides.map(|side| side.as_dvec3() * distance);
                let [u, v] = sides;
                let corners = vec![middle - u - v, middle + u - v, middle + u + v, middle - u + v];
                let area = 4.0 * u.cross(v).length();
                let shape = Shape::Polygon { corners, normal: -patch.axis.as_dvec3(), area };
                let shown = patch.image.as_deref().map(|image| Shown { image, middle, sides });
                (bounds, Some(Self { shape, shown }))
            }
            // Without its shape a picture to compare with would be wrong.
            other => unreachable!("the reference has no shape for {other:?}"),
        })
    }

    /// A point drawn uniformly by area; `None` on the side away from the receiver.
    pub(crate) fn sample(&self, u: f64, v: f64) -> Option<Seen> {
        self.shape.sample(u, v).map(|seen| self.show(seen))
    }

    /// The point where a ray meets it.
    pub(crate) fn hit(&self, v: DVec3) -> Option<Seen> {
        self.shape.hit(v).map(|seen| self.show(seen))
    }

    fn show(&self, seen: Seen) -> Seen {
        let Some(Shown { image, middle, sides }) = &self.shown else { return seen };
        let p = seen.direction * (seen.distance / BEFORE) - *middle;
        let place = sides.map(|side| (p.dot(side) / side.length_squared()) as f32);
        Seen { shows: image.at(place.into(), 0.0), ..seen }
    }
}

impl<'l> Shown<'l> {
    fn of_flat(light: &'l FlatLight, position: Vec3) -> Option<Self> {
        let image = light.image()?;
        let [a, b, c, d] = *light.corners() else { return None };
        let [a, b, c, d] = [a, b, c, d].map(|p| p.as_dvec3() - position.as_dvec3());
        Some(Self { image, middle: 0.25 * (a + b + c + d), sides: [0.5 * (b - a), 0.5 * (d - a)] })
    }
}

impl Shape {
    fn of_flat(light: &FlatLight, position: Vec3) -> Option<Self> {
        let position = position.as_dvec3();
        let (center, disc) = light.as_disc();
        let center = center.as_dvec3() - position;
        let normal = light.normal().as_dvec3().normalize();
        let height = -normal.dot(center);
        if height == 0.0 || height < 0.0 && !light.two_sided {
            return None;
        }
        let normal = normal * height.signum();
        if let Some(radius) = disc {
            return Some(Self::Disc { center, normal, radius: f64::from(radius) });
        }
        let corners: Vec<DVec3> = light.corners().iter().map(|p| p.as_dvec3() - position).collect();
        let first = corners[0];
        let twice: DVec3 = corners[1..].windows(2).map(|p| (p[0] - first).cross(p[1] - first)).sum();
        Some(Self::Polygon { area: 0.5 * twice.length(), corners, normal })
    }

    fn of_tube(light: &TubeLight, position: Vec3) -> Self {
        let [a, b] = light.ends.map(|p| p.as_dvec3() - position.as_dvec3());
        Self::Capsule { end: a, along: b - a, radius: f64::from(light.radius) }
    }

    fn sample(&self, u: f64, v: f64) -> Option<Seen> {
        match self {
            Self::Polygon { corners, normal, area } => {
                let first = corners[0];
                let mut left = u * area;
                let fans = corners[1..].windows(2);
                let last = corners.len() - 3;
                for (k, pair) in fans.enumerate() {
                    let (p, q) = (pair[0] - first, pair[1] - first);
                    let part = 0.5 * p.cross(q).length();
                    if left <= part || k == last {
                        let s = (left / part).clamp(0.0, 1.0).sqrt();
                        return seen(first + (p * (1.0 - v) + q * v) * s, *normal, *area);
                    }
                    left -= part;
                }
                None
            }
            Self::Disc { center, normal, radius } => {
                let (a, b) = normal.any_orthonormal_pair();
                let (r, phi) = concentric(u, v);
                let (sin, cos) = phi.sin_cos();
                seen(*center + (a * cos + b * sin) * (r * radius), *normal, PI * radius * radius)
            }
            Self::Capsule { end, along, radius } => {
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
                seen(middle + normal * *radius, normal, TAU * radius * (length + 2.0 * radius))
            }
        }
    }

    fn hit(&self, v: DVec3) -> Option<Seen> {
        match self {
            Self::Polygon { corners, normal, area } => {
                let p = v * (normal.dot(corners[0]) / normal.dot(v));
                let inside = |i: usize| {
                    let (a, b) = (corners[i], corners[(i + 1) % corners.len()]);
                    (b - a).cross(p - a).dot(*normal)
                };
                let (low, high) = (0..corners.len())
                    .map(inside)
                    .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
                (v.dot(*normal) < 0.0 && (low >= 0.0 || high <= 0.0)).then(|| seen(p, *normal, *area)).flatten()
            }
            Self::Disc { center, normal, radius } => {
                let p = v * (normal.dot(*center) / normal.dot(v));
                let hits = v.dot(*normal) < 0.0 && p.distance_squared(*center) <= radius * radius;
                hits.then(|| seen(p, *normal, PI * radius * radius)).flatten()
            }
            Self::Capsule { end, along, radius } => {
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
                        return seen(p, aside(p - *end) / *radius, area);
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
                    .and_then(|(t, center)| seen(v * t, (v * t - center) / *radius, area))
            }
        }
    }
}

/// A point of a surface.
fn seen(p: DVec3, normal: DVec3, area: f64) -> Option<Seen> {
    let distance = p.length();
    let direction = p / distance;
    let cos = -direction.dot(normal);
    (cos > 0.0 && distance > 0.0).then(|| Seen {
        direction,
        distance: distance * BEFORE,
        pdf: distance * distance / (area * cos),
        shows: Vec3::ONE,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn areas() -> [Shape; 3] {
        let position = Vec3::new(0.3, -0.2, 0.1);
        let flat = FlatLight::rectangle(Vec3::new(0.0, 0.2, 2.0), Vec3::X, Vec3::new(0.0, 0.5, 0.2), Vec3::ONE);
        let disc = FlatLight::disc(Vec3::new(0.5, 0.2, 2.0), Vec3::new(0.2, 0.1, -1.0), 0.7, Vec3::ONE);
        let tube =
            TubeLight { ends: [Vec3::new(-1.0, 0.0, 2.0), Vec3::new(1.0, 0.4, 2.5)], radius: 0.3, radiance: Vec3::ONE };
        let flat = flat.expect("a rectangle").on_both_sides();
        [
            Shape::of_flat(&flat, position).expect("lit"),
            Shape::of_flat(&disc.expect("a disc"), position).expect("lit"),
            Shape::of_tube(&tube, position),
        ]
    }

    /// A sampled direction meets the light where it was sampled, and the solid angle is that of random directions.
    #[test]
    fn samples_are_what_rays_meet() {
        for area in areas() {
            let (n, mut solid) = (200, 0.0);
            for k in 0..n * n {
                let at = |i: usize| (i as f64 + 0.5) / n as f64;
                let Some(seen) = area.sample(at(k % n), at(k / n)) else { continue };
                solid += 1.0 / seen.pdf;
                let hit = area.hit(seen.direction).expect("a hit");
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
                    area.hit(DVec3::new(s * phi.cos(), s * phi.sin(), z)).is_some()
                })
                .count();
            let want = 2.0 * TAU * hits as f64 / f64::from(m * m);
            assert!((solid / want - 1.0).abs() < 5e-3, "{solid} {want}");
        }
    }
}
