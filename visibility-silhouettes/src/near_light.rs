//! Triangles near lights, and those of them that cut a light or are cut by its plane.

use crate::clip::{Behind, LightSphere, is_around, sides_of};
use crate::hidden::Hidden;
use glam::{DVec3, Vec2, Vec3};
use lobe_core::{Capsule, Sphere, distance_of_segments, orthonormal_basis};
use shading::{LightExtent, Shaft};

pub(crate) type Triangle = [Vec3; 3];

/// Triangles that are nearer to a tube's middle line than this many radii touch it, so that its surface ends what they hide; before others its plane does.
const TOUCHING: f32 = 1.25;
/// Lights whose triangles are kept: those of later ones take their places.
const LIGHTS: usize = 1024;
/// Triangles as far beside the light as this part of its radius count as near: outlines reach a little beyond it.
const BESIDE: f32 = 0.1;
/// The same across a flat light, where its plane ends for each receiver a little nearer.
const ABOVE: f32 = 0.01;
/// Triangles as near to the plane as this part of the light's radius count as cut: the plane is a little different for each receiver.
const MARGIN: f64 = 1e-3;

/// The triangles near the lights of a frame.
#[derive(Clone, Debug, Default)]
pub(crate) struct NearLights {
    lights: Vec<Option<NearLight>>,
    current: usize,
}

/// The triangles near one light.
#[derive(Clone, Debug)]
pub(crate) struct NearLight {
    light: Sphere,
    extent: LightExtent,
    around: AroundLight,
    /// In the order of their distances from the line along the light through its middle.
    pub(crate) triangles: Vec<Triangle>,
    beside: Vec<f32>,
    /// Whether triangles reach into the light's sphere, and those that its surface cuts.
    pub(crate) is_clipped: bool,
    pub(crate) cutting: Vec<Triangle>,
    /// The plane of the last query of a flat light, how many triangles a tube may have hidden there, and those of the others that it may cut.
    plane: Option<(Vec3, f64, usize)>,
    /// See [`is_touched`](Self::is_touched).
    is_touched: Option<bool>,
    cut: Vec<Triangle>,
}

impl NearLights {
    /// Makes the light of a shaft the current one. `visit` calls its argument for all triangles that may meet a sphere, which is done once for each
    /// light.
    pub(crate) fn enter(
        &mut self,
        shaft: &Shaft,
        mut visit: impl FnMut(Sphere, &mut dyn FnMut(Triangle)),
    ) -> &NearLight {
        self.current = shaft.id.0 as usize % LIGHTS;
        if self.lights.len() <= self.current {
            self.lights.resize_with(self.current + 1, || None);
        }
        let place = &mut self.lights[self.current];
        // Another light, or one that has moved.
        place.take_if(|near| near.light != shaft.light || near.extent != shaft.extent);
        place.get_or_insert_with(|| NearLight::new(shaft, &mut visit))
    }

    /// The triangles of the light that was entered last.
    pub(crate) fn current(&mut self) -> Option<&mut NearLight> {
        self.lights.get_mut(self.current)?.as_mut()
    }
}

/// Whether a triangle may reach as near to the plane through a point as `margin`.
#[must_use]
pub fn meets_plane(corners: &[Vec3; 3], normal: Vec3, point: Vec3, margin: f64) -> bool {
    meets_slab(corners, normal, normal.as_dvec3().dot(point.as_dvec3()), margin)
}

/// The same for the plane at an offset from the origin along its normal.
fn meets_slab(corners: &Triangle, normal: Vec3, offset: f64, margin: f64) -> bool {
    let heights = corners.map(|p| normal.as_dvec3().dot(p.as_dvec3()) - offset);
    heights.iter().any(|height| *height >= -margin) && heights.iter().any(|height| *height <= margin)
}

/// The space about a light in which its plane may cut triangles.
#[derive(Clone, Copy, Debug)]
pub struct AroundLight {
    light: Sphere,
    /// Three directions along and across the light, and how far it reaches along each, with what lies beside it.
    sides: [(Vec3, f32); 3],
}

impl AroundLight {
    /// Of a light that both of these bound.
    #[must_use]
    pub fn new(light: Sphere, extent: &LightExtent) -> Self {
        let [u, v] = extent.sides;
        let long = if u.length_squared() < v.length_squared() { v } else { u }.normalize_or(Vec3::X);
        let normal = u.cross(v).normalize_or(orthonormal_basis(long).0);
        let reach = |n: Vec3, more: f32| (n, light.radius.min(extent.support(n)) + more * light.radius);
        Self { light, sides: [reach(long, BESIDE), reach(normal.cross(long), BESIDE), reach(normal, ABOVE)] }
    }

    /// A sphere around it.
    #[must_use]
    pub fn sphere(&self) -> Sphere {
        Sphere { radius: self.light.radius * (1.0 + BESIDE), ..self.light }
    }

    /// A point seen along the line along the light through its middle.
    fn across(&self, p: Vec3) -> Vec2 {
        let [_, (u, _), (v, _)] = self.sides;
        let p = p - self.light.center;
        Vec2::new(u.dot(p), v.dot(p))
    }

    /// How far a triangle is from that line.
    fn beside(&self, corners: &Triangle) -> f32 {
        let [a, b, c] = corners.map(|p| self.across(p));
        let sides = [(a, b), (b, c), (c, a)];
        // Where the line goes through the triangle, it is to one side of all three sides.
        let turns = sides.map(|(p, q)| p.perp_dot(q));
        if turns.iter().all(|turn| *turn >= 0.0) || turns.iter().all(|turn| *turn <= 0.0) {
            return 0.0;
        }
        let to_side = |(p, q): (Vec2, Vec2)| {
            let along = q - p;
            let t = (-p.dot(along) / along.length_squared().max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
            (p + along * t).length()
        };
        sides.map(to_side).into_iter().fold(f32::INFINITY, f32::min)
    }

    /// Whether a triangle that meets the sphere may reach into it.
    #[must_use]
    pub fn may_have(&self, corners: &[Vec3; 3]) -> bool {
        self.sides.iter().all(|(n, reach)| meets_plane(corners, *n, self.light.center, f64::from(*reach)))
    }
}

impl NearLight {
    fn new(shaft: &Shaft, visit: &mut impl FnMut(Sphere, &mut dyn FnMut(Triangle))) -> Self {
        let Shaft { light, extent, .. } = *shaft;
        let (mut near, mut cutting, mut is_clipped) = (Vec::new(), Vec::new(), false);
        let around = AroundLight::new(light, &extent);
        if !extent.is_beyond_all {
            visit(around.sphere(), &mut |corners| {
                if around.may_have(&corners) {
                    near.push((around.beside(&corners), corners));
                }
            });
            visit(light, &mut |corners| {
                is_clipped = true;
                if LightSphere::may_clip(light, corners) {
                    cutting.push(corners);
                }
            });
            near.sort_by(|(a, _), (b, _)| a.total_cmp(b));
        }
        let (beside, triangles) = near.into_iter().unzip();
        Self {
            light,
            extent,
            around,
            triangles,
            beside,
            is_clipped,
            cutting,
            plane: None,
            is_touched: None,
            cut: Vec::new(),
        }
    }

    /// Whether no triangle is near the light.
    pub(crate) fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    /// Whether a triangle is nearer to a tube's middle line than this many radii, seen from a point. It is found once for each light.
    pub(crate) fn is_touched(&mut self, tube: &Capsule, origin: Vec3) -> bool {
        *self.is_touched.get_or_insert_with(|| {
            let ends = tube.ends.map(|end| (origin + end).as_dvec3());
            let near = f64::from(TOUCHING * tube.radius);
            self.triangles.iter().any(|corners| is_near(corners, ends, near))
        })
    }

    /// The triangles that a tube may hide, and those of the others that the plane of a flat light may cut, seen from a point.
    pub(crate) fn cut(&mut self, plane: &Behind, origin: Vec3, tube: Option<&Hidden>) -> [&[Triangle]; 2] {
        let count = tube.map_or(0, |tube| {
            // The tube's middle line is the light's but for rounding, unless the light is one that a receiver made for itself.
            let off = tube
                .ends()
                .map(|end| self.around.across(origin + end.as_vec3()).length())
                .into_iter()
                .fold(0.0, f32::max);
            self.beside.partition_point(|beside| *beside < tube.reach() + off)
        });
        let (nearest, others) = self.triangles.split_at(count);
        let (axis, offset) = plane.placed(origin);
        let margin = MARGIN * f64::from(self.light.radius);
        let is_near = |known: f64| (known - offset).abs() < 0.5 * margin;
        if !self.plane.is_some_and(|(normal, known, many)| normal == axis && is_near(known) && many == count) {
            self.plane = Some((axis, offset, count));
            self.cut.clear();
            self.cut.extend(others.iter().filter(|corners| meets_slab(corners, axis, offset, margin)));
        }
        [nearest, &self.cut]
    }
}

/// Whether a triangle is nearer to a segment than a distance: at the triangle's sides, across from an end of the segment, or where that goes through it.
fn is_near(corners: &Triangle, [a, b]: [DVec3; 2], distance: f64) -> bool {
    let [p, q, r] = corners.map(|p| p.as_dvec3());
    let sides = sides_of([p, q, r]);
    if sides.iter().any(|side| distance_of_segments(*side, [a, b]).0 < distance) {
        return true;
    }
    let normal = (q - p).cross(r - p).normalize_or_zero();
    let [of_a, of_b] = [a, b].map(|end| normal.dot(end - p));
    let holds = |at: DVec3| is_around(sides, at, normal);
    let is_end_near = |end: DVec3, off: f64| off.abs() < distance && holds(end - normal * off);
    is_end_near(a, of_a) || is_end_near(b, of_b) || of_a * of_b < 0.0 && holds(a + (b - a) * (of_a / (of_a - of_b)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_core::FlatShape;
    use shading::LightId;

    /// As receivers move and lights alternate, no triangle that a plane cuts is missed; others are left out, and each light's are found once.
    #[test]
    fn triangles_that_a_plane_cuts_are_kept() {
        let around = |at: Vec3| -> Vec<Triangle> {
            (0..400_u16)
                .map(|k| {
                    let turn = Vec3::new(f32::from(k).sin(), (1.7 * f32::from(k)).sin(), (2.3 * f32::from(k)).cos());
                    [Vec3::ZERO, 0.2 * Vec3::X, 0.2 * turn].map(|p| at + turn + p)
                })
                .collect()
        };
        let lights = [Vec3::new(0.0, 3.0, 0.0), Vec3::new(50.0, 2.0, 1.0)].map(|center| {
            let normal = (center.normalize() - Vec3::Y * 2.0).normalize();
            let (u, v) = lobe_core::orthonormal_basis(normal);
            let corners = [u + v, v - u, -u - v, u - v].map(|p| center + p);
            let bounds = Sphere { center, radius: 1.5 };
            (FlatShape::polygon(&corners, normal, bounds, 1.0), around(center))
        });
        let (mut near, mut found, mut most, mut cut) = (NearLights::default(), 0, 0, 0);
        for k in 0..200_u16 {
            let number = k / 3 % 2;
            let (shape, triangles) = &lights[usize::from(number)];
            let origin = shape.bounds().center + Vec3::new(f32::from(k).sin() * 9.0, -2.0, f32::from(k).cos() * 9.0);
            let Some(outline) = shape.outline(origin) else { continue };
            let plane = Behind::new(&outline, outline.depth());
            let shaft = Shaft::new(Sphere::default(), shape.bounds(), LightId(u32::from(number)));
            near.enter(&shaft, |_, visit| {
                found += 1;
                triangles.iter().copied().for_each(visit);
            });
            let [nearest, listed] = near.current().expect("entered").cut(&plane, origin, None);
            assert!(nearest.is_empty());
            let listed = listed.to_vec();
            most = most.max(listed.len());
            for corners in triangles {
                if plane.clip(corners.map(|p| p - origin), || 1.0).is_some() {
                    cut += 1;
                    assert!(listed.contains(corners), "{k}");
                }
            }
        }
        // Near the light, and at its surface.
        assert!(found == 4 && cut > 1000 && most < 200, "{found} {cut} {most}");
    }

    /// Of the triangles near a long light only those beside it are kept, however it lies.
    #[test]
    fn triangles_far_from_a_long_light_are_left_out() {
        for k in 0..40_u16 {
            let along = Vec3::new(f32::from(k).sin(), (1.3 * f32::from(k)).cos(), 0.3).normalize();
            let (u, v) = lobe_core::orthonormal_basis(along);
            let light = Sphere { center: Vec3::new(1.0, 2.0, 3.0), radius: 2.0 };
            let extent = LightExtent { sides: [along * 1.9, Vec3::ZERO], margin: 0.05, is_beyond_all: false };
            let small = |p: Vec3| [Vec3::ZERO, 0.01 * u, 0.01 * v].map(|q| light.center + p + q);
            let all = [0.05 * u, -0.2 * v + 1.9 * along, 0.9 * u, -0.8 * v - along].map(small);
            let shaft = Shaft::new(Sphere::default(), light, LightId(3)).with_extent(Some(extent));
            let mut near = NearLights::default();
            let near = near.enter(&shaft, |_, visit| all.into_iter().for_each(visit));
            assert_eq!(near.triangles, all[..2], "{k}");
        }
    }
}
