//! Triangles and spheres, and where rays meet them.

use super::Update;
use glam::{DVec3, Vec3, Vec3A};
use lobe_core::Sphere;
use obvhs::Boundable;
use obvhs::aabb::Aabb;
use obvhs::ray::Ray;
use scene::rounding::{CLOSE, CLOSE_TO_SPHERE, EDGE};

#[derive(Clone, Copy)]
pub(crate) struct Corners {
    pub(super) v0: Vec3A,
    pub(super) e1: Vec3A,
    pub(super) e2: Vec3A,
    pub(super) object: u32,
    pub(super) index: u32,
    pub(super) visible: bool,
}

/// A triangle with an edge of so many times the distance to it is met in f64. Rounding moves the edges of others by less than
/// 0.004 of the distance.
pub(super) const GIANT: f32 = 4096.0;

/// As [`EDGE`] for giants, before they are met in f64: more than rounding, for all but grazing rays.
pub(super) const GIANT_EDGE: f32 = 1e-4;

/// As [`EDGE`], in f64.
const EXACT_EDGE: f64 = 1e-12;

impl Corners {
    /// Distance along the ray or infinity, both sides. A ray that starts on it does not meet it: obvhs enters no box that
    /// ends there, but others.
    #[cfg(test)]
    pub(super) fn intersect(&self, ray: &Ray) -> f32 {
        self.meet(ray, |t| t)
    }

    /// Distance along the ray or infinity (T. Möller, B. Trumbore, *Fast, Minimum Storage Ray-Triangle Intersection*,
    /// 1997), both sides. `exact` decides where rounding hides on which side of the plane the ray starts, and for triangles of
    /// [`GIANT`] times the distance: there rounding may be as large as other things are.
    #[inline]
    pub(super) fn meet(&self, ray: &Ray, exact: impl FnOnce(f32) -> f32) -> f32 {
        let p = ray.direction.cross(self.e2);
        let inverse = 1.0 / self.e1.dot(p);
        let s = ray.origin - self.v0;
        let u = s.dot(p) * inverse;
        let q = s.cross(self.e1);
        let v = ray.direction.dot(q) * inverse;
        // An inverse of ±∞ or NaN (ray in the plane) fails one of the comparisons.
        let within = |edge: f32| u >= -edge && v >= -edge && u + v <= 1.0 + edge;
        if within(GIANT_EDGE) {
            let mut t = self.e2.dot(q) * inverse;
            let (size1, size2) = (self.e1.length_squared(), self.e2.length_squared());
            let slant_sq = (size1 * inverse) * (size2 * inverse);
            let is_giant = is_giant(size1.max(size2), t);
            if !is_giant && !within(EDGE) {
                return f32::INFINITY;
            }
            if is_giant || t.abs() <= CLOSE * (s.length_squared() * slant_sq).sqrt() {
                t = exact(t);
            }
            if t > ray.tmin && t <= ray.tmax {
                return t;
            }
        }
        f32::INFINITY
    }
}

/// Whether the longest edge, squared, is more than [`GIANT`] times a distance.
#[inline]
pub(super) fn is_giant(size_sq: f32, t: f32) -> bool {
    size_sq > (GIANT * GIANT) * (t * t)
}

/// A triangle in f64.
#[derive(Clone, Copy, Debug)]
pub(super) struct Exact {
    corner: DVec3,
    e1: DVec3,
    e2: DVec3,
    /// Of any length.
    normal: DVec3,
}

impl Exact {
    pub(super) fn new([a, b, c]: [DVec3; 3]) -> Self {
        let (e1, e2) = (b - a, c - a);
        Self { corner: a, e1, e2, normal: e1.cross(e2) }
    }

    /// Distance along a ray to the plane; infinite where a giant's edges leave the ray outside.
    #[inline]
    pub(super) fn distance(&self, ray: &Ray) -> f32 {
        let (origin, direction) = (Vec3::from(ray.origin).as_dvec3(), Vec3::from(ray.direction).as_dvec3());
        let t = self.normal.dot(self.corner - origin) / self.normal.dot(direction);
        let size_sq = self.e1.length_squared().max(self.e2.length_squared()) as f32;
        if t > f64::from(ray.tmin) && is_giant(size_sq, t as f32) {
            return self.meet(origin, direction).map_or(f32::INFINITY, |t| t as f32);
        }
        t as f32
    }

    /// Distance along a ray, both sides, behind its start too.
    #[inline]
    pub(super) fn meet(&self, origin: DVec3, direction: DVec3) -> Option<f64> {
        let p = direction.cross(self.e2);
        let inverse = 1.0 / self.e1.dot(p);
        let s = origin - self.corner;
        let (u, v) = (s.dot(p) * inverse, direction.dot(s.cross(self.e1)) * inverse);
        let is_inside = u >= -EXACT_EDGE && v >= -EXACT_EDGE && u + v <= 1.0 + EXACT_EDGE;
        let t = self.normal.dot(self.corner - origin) / self.normal.dot(direction);
        (is_inside && t.is_finite()).then_some(t)
    }
}

#[derive(Clone, Copy)]
pub(crate) struct SceneSphere {
    pub(super) sphere: Sphere,
    pub(super) object: u32,
    pub(super) index: u32,
    pub(super) visible: bool,
    /// As it [casts shadows](scene::Scene::casting).
    pub(super) casting: Sphere,
}

impl SceneSphere {
    /// [`meet`](Self::meet) for a ray of shadow.
    #[inline]
    pub(super) fn meet_casting(&self, ray: &Ray) -> f32 {
        Self { sphere: self.casting, ..*self }.meet(ray)
    }

    #[inline]
    pub(super) fn intersect(&self, ray: &Ray) -> f32 {
        let to = Vec3A::from(self.sphere.center) - ray.origin;
        let along = to.dot(ray.direction);
        // The distance of the centre from the ray first: |to|² − along² would cancel.
        let across = (to - ray.direction * along).length_squared();
        let half_sq = self.sphere.radius * self.sphere.radius - across;
        if half_sq < 0.0 {
            return f32::INFINITY;
        }
        let half = half_sq.sqrt();
        for t in [along - half, along + half] {
            if t > ray.tmin && t <= ray.tmax {
                return t;
            }
        }
        f32::INFINITY
    }

    /// The same in f64 where the ray starts so near to the surface that rounding would decide on which side.
    #[inline]
    pub(super) fn meet(&self, ray: &Ray) -> f32 {
        let off = (Vec3A::from(self.sphere.center) - ray.origin).length_squared() - self.sphere.radius.powi(2);
        if off.abs() > CLOSE_TO_SPHERE * self.sphere.radius.powi(2) {
            return self.intersect(ray);
        }
        let to = self.sphere.center.as_dvec3() - Vec3::from(ray.origin).as_dvec3();
        let (direction, radius) = (Vec3::from(ray.direction).as_dvec3(), f64::from(self.sphere.radius));
        let along = to.dot(direction);
        // Its sign is that of the nearer distance where the sphere is ahead.
        let off = to.length_squared() - radius * radius;
        let half_sq = along * along - off * direction.length_squared();
        if half_sq < 0.0 {
            return f32::INFINITY;
        }
        let far = (along.abs() + half_sq.sqrt()).copysign(along);
        let ends = [off / far, far];
        let met = ends.into_iter().filter(|t| *t > f64::from(ray.tmin) && *t <= f64::from(ray.tmax));
        met.fold(f64::INFINITY, f64::min) as f32
    }

    /// The point on the sphere nearest to that on a ray, and the normal there on the ray's side: in f64, then rounded.
    pub(super) fn surface(&self, origin: Vec3, direction: Vec3, t: f32) -> (Vec3, Vec3) {
        let center = self.sphere.center.as_dvec3();
        let near = origin.as_dvec3() + direction.as_dvec3() * f64::from(t);
        let outward = (near - center).normalize_or(DVec3::Z);
        let position = center + outward * f64::from(self.sphere.radius);
        let normal = if outward.dot(direction.as_dvec3()) > 0.0 { -outward } else { outward };
        (position.as_vec3(), normal.as_vec3().normalize())
    }
}

impl Boundable for Corners {
    fn aabb(&self) -> Aabb {
        let (b, c) = (self.v0 + self.e1, self.v0 + self.e2);
        Aabb::new(self.v0.min(b).min(c), self.v0.max(b).max(c))
    }
}

impl Boundable for SceneSphere {
    fn aabb(&self) -> Aabb {
        let (c, r) = (Vec3A::from(self.sphere.center), Vec3A::splat(self.sphere.radius));
        Aabb::new(c - r, c + r)
    }
}

/// Identifies a primitive by its object and number.
pub(crate) trait Named {
    /// Object and number: equal for one primitive at two moments.
    fn name(&self) -> (u32, u32);

    /// How much changes where it becomes another one of the same name.
    fn update_to(&self, other: &Self) -> Update;
}

/// The update of a primitive that has moved, or only its marks.
const fn update_of(is_moved: bool, is_marked: bool) -> Update {
    match (is_moved, is_marked) {
        (true, _) => Update::Refitted,
        (false, true) => Update::Marked,
        (false, false) => Update::Kept,
    }
}

impl Named for Corners {
    fn name(&self) -> (u32, u32) {
        (self.object, self.index)
    }

    fn update_to(&self, other: &Self) -> Update {
        let is_moved = (self.v0, self.e1, self.e2) != (other.v0, other.e1, other.e2);
        update_of(is_moved, self.visible != other.visible)
    }
}

impl Named for SceneSphere {
    fn name(&self) -> (u32, u32) {
        (self.object, self.index)
    }

    fn update_to(&self, other: &Self) -> Update {
        update_of(self.sphere != other.sphere, (self.visible, self.casting) != (other.visible, other.casting))
    }
}
