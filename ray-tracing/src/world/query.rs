//! Queries for the primitives that a whole packet of rays may meet.

use super::World;
use super::primitive::{Corners, Named, SceneSphere};
use super::tree::Tree;
use glam::{Vec3, Vec3A};
use lobe_core::Cone;
use obvhs::aabb::Aabb;
use obvhs::ray::Ray;
use scene::rounding::BLUR;
use shading::Shaft;

/// One triangle or sphere of a [`World`]; valid for that world only.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Primitive {
    /// By its place in the hierarchy.
    Triangle(u32),
    /// By its place in the hierarchy.
    Sphere(u32),
}

/// All rays from a point into a cone, up to a light there.
#[derive(Clone, Copy, Debug)]
pub struct Region {
    origin: Vec3A,
    axis: Vec3A,
    sin: f32,
    cos: f32,
    /// No ray goes farther along the axis.
    far: f32,
    /// No ray goes below the plane with this normal through the origin.
    face: Option<Vec3A>,
}

impl Region {
    /// The rays to the near surface of the light that is seen as `cone`; `face` when all of them are above the surface
    /// that they leave.
    #[must_use]
    pub fn new(origin: Vec3, cone: &Cone, face: Option<Vec3>) -> Self {
        let (sin_sq, cos) = (cone.sin_sq(), cone.cos());
        // The tangents touch d cos²θ along the axis, and all of the near surface is nearer.
        let far = cone.distance * cos * cos;
        Self {
            origin: origin.into(),
            axis: cone.axis.into(),
            sin: sin_sq.sqrt(),
            cos,
            far,
            face: face.map(Vec3A::from),
        }
    }

    /// True when a plane parts the rays from a convex shape: `center` is a point of it relative to the origin, `support`
    /// its farthest extent along a direction, `blur` how far it may seem to rise above the face by rounding. May be false
    /// although none meets it.
    #[inline]
    fn misses(&self, center: Vec3A, blur: f32, support: impl Fn(Vec3A) -> f32) -> bool {
        support(self.axis) <= 0.0
            || -support(-self.axis) >= self.far
            || self.face.is_some_and(|n| support(n) <= blur)
            || self.tangent(center).is_some_and(|n| support(n) < 0.0)
    }

    /// Normal of the cone's tangent plane on the side of a point, turned to the cone; `None` on the axis.
    #[inline]
    fn tangent(&self, point: Vec3A) -> Option<Vec3A> {
        // Done twice, because for a point near the axis rounding leaves the first difference in any direction.
        let aside = point - self.axis * point.dot(self.axis);
        let aside = aside - self.axis * aside.dot(self.axis);
        let length = aside.length();
        (length > 1e-6 * point.length()).then(|| self.axis * self.sin - aside * (self.cos / length))
    }

    fn misses_box(&self, bounds: &Aabb) -> bool {
        let center = bounds.center() - self.origin;
        let half = 0.500_001 * bounds.diagonal();
        // No blur: something nearer may be in it.
        self.misses(center, 0.0, |n| n.dot(center) + n.abs().dot(half))
    }

    fn misses_sphere(&self, sphere: &SceneSphere) -> bool {
        let center = Vec3A::from(sphere.sphere.center) - self.origin;
        // All planes' normals have length 1.
        let blur = BLUR * (center.abs().element_sum() + sphere.sphere.radius);
        self.misses(center, blur, |n| n.dot(center) + sphere.sphere.radius)
    }

    /// Apart from rounding exact for a triangle before the light: two cones are parted by a plane that touches the one
    /// at an edge or corner, or the other.
    fn misses_triangle(&self, c: &Corners) -> bool {
        let a = c.v0 - self.origin;
        let (b, c) = (a + c.e1, a + c.e2);
        let support = |n: Vec3A| n.dot(a).max(n.dot(b)).max(n.dot(c));
        let blur = BLUR * a.abs().max(b.abs()).max(c.abs()).element_sum();
        if self.misses((a + b + c) * (1.0 / 3.0), blur, support) {
            return true;
        }
        let beside_edge = |p: Vec3A, q: Vec3A, r: Vec3A| {
            let n = p.cross(q);
            let toward = n.dot(self.axis) * -n.dot(r).signum();
            toward > self.sin * n.length()
        };
        let beside_corner = |p: Vec3A| self.tangent(p).is_some_and(|n| n.dot(a).max(n.dot(b)).max(n.dot(c)) <= 0.0);
        beside_edge(a, b, c)
            || beside_edge(b, c, a)
            || beside_edge(c, a, b)
            || beside_corner(a)
            || beside_corner(b)
            || beside_corner(c)
    }
}

/// Rays may start this far from the receivers, as a fraction of the radius of a sphere around them; their ends are rounded by the same.
const SLACK: f32 = 1e-5;

/// A shaft's hull, as boxes are compared with it.
struct ShaftHull {
    shaft: Shaft,
    from: Vec3A,
    axis: Vec3A,
    low: Vec3A,
    high: Vec3A,
}

impl ShaftHull {
    fn new(shaft: &Shaft) -> Self {
        let (from, to) = (Vec3A::from(shaft.receivers.center), Vec3A::from(shaft.light.center));
        let wide_from = Vec3A::from(shaft.half_extent + SLACK * shaft.receivers.radius);
        let wide_to = Vec3A::splat(shaft.light.radius);
        let (low, high) = ((from - wide_from).min(to - wide_to), (from + wide_from).max(to + wide_to));
        Self { shaft: *shaft, from, axis: (to - from).normalize_or_zero(), low, high }
    }

    /// Whether a box is certainly outside.
    #[inline]
    fn misses(&self, bounds: &Aabb) -> bool {
        if (bounds.min.cmpgt(self.high) | bounds.max.cmplt(self.low)).any() {
            return true;
        }
        let (center, half) = (bounds.center() - self.from, 0.500_01 * bounds.diagonal());
        let across = center - self.axis * center.dot(self.axis);
        let length = across.length();
        if length.is_nan() || length <= 0.0 {
            return false;
        }
        let n = across / length;
        let near = n.dot(center) - n.abs().dot(half);
        near > (1.0 + SLACK) * self.shaft.reach(n.into()) + SLACK * self.shaft.receivers.radius
    }
}

impl<T> Tree<T> {
    /// Calls `found` for primitives whose boxes meet the shaft, until it says true. Returns whether it did.
    pub(crate) fn in_shaft(&self, shaft: &Shaft, found: &mut impl FnMut(u32, &T) -> bool) -> bool {
        let hull = ShaftHull::new(shaft);
        self.visit(&|b| hull.misses(b), found)
    }

    /// Calls `found` for primitives in boxes that are not `outside`, until it says true. Returns whether it did.
    pub(super) fn visit(&self, outside: &impl Fn(&Aabb) -> bool, found: &mut impl FnMut(u32, &T) -> bool) -> bool {
        let Some(bvh) = &self.bvh else { return false };
        // Seven siblings wait on each level; the hierarchy is never deeper than 32.
        let mut stack = [0u32; 7 * 32 + 1];
        let mut count = 1;
        while count > 0 {
            count -= 1;
            let node = &bvh.nodes[stack[count] as usize];
            for child in 0..8 {
                if node.is_child_empty(child) || outside(&self.unscaled(node.child_aabb(child))) {
                    continue;
                }
                if node.is_leaf(child) {
                    let (first, n) = node.child_primitives(child);
                    if (first..first + n).any(|i| found(i, &self.primitives[i as usize])) {
                        return true;
                    }
                } else {
                    stack[count] = node.child_node_index(child);
                    count += 1;
                }
            }
        }
        false
    }
}

impl World<'_> {
    /// Lists the primitives of the objects `of` whose boxes meet the shaft, in `out`. False, and an unfinished list, when
    /// there are more than `limit`.
    pub fn in_shaft(&self, shaft: &Shaft, of: impl Fn(u32) -> bool, limit: usize, out: &mut Vec<Primitive>) -> bool {
        self.triangles_in(shaft, &of, limit, out)
            && !self.hierarchy.spheres.in_shaft(shaft, &mut |i, b| {
                if of(b.object) {
                    out.push(Primitive::Sphere(i));
                }
                out.len() > limit
            })
    }

    /// The same with triangles only.
    pub fn triangles_in(
        &self,
        shaft: &Shaft,
        of: impl Fn(u32) -> bool,
        limit: usize,
        out: &mut Vec<Primitive>,
    ) -> bool {
        out.clear();
        self.each_triangle_in(shaft, of, limit, |i, _| out.push(Primitive::Triangle(i)))
    }

    /// Calls `found` with the triangles of the objects `of` whose boxes meet the shaft. False, and not with all of them, when
    /// there are more than `limit`.
    pub(super) fn each_triangle_in(
        &self,
        shaft: &Shaft,
        of: impl Fn(u32) -> bool,
        limit: usize,
        mut found: impl FnMut(u32, &Corners),
    ) -> bool {
        let mut count = 0;
        let mut each = |i: u32, c: &Corners| {
            if of(c.object) {
                found(i, c);
                count += 1;
            }
            count > limit
        };
        if self.hierarchy.triangles.in_shaft(shaft, &mut each) {
            return false;
        }
        if self.hierarchy.instances.is_empty() {
            return true;
        }
        let (hull, own) = (ShaftHull::new(shaft), self.hierarchy.triangles.primitives.len() as u32);
        !self.hierarchy.instances.visit(&|b| hull.misses(b), &mut |i, c| each(own + i, c))
    }

    /// Object and number of primitives.
    pub fn names(&self, primitives: &[Primitive]) -> impl Iterator<Item = (u32, u32)> {
        primitives.iter().map(|p| match p {
            Primitive::Triangle(i) => self.triangle_name(*i),
            Primitive::Sphere(i) => self.hierarchy.spheres.primitives[*i as usize].name(),
        })
    }

    /// Whether any triangle of the objects `of` lies on a ray of unit direction nearer than `distance`. The one in `last` is
    /// tried first, and the one that is met stays there.
    pub fn first_met(
        &self,
        origin: Vec3,
        direction: Vec3,
        distance: f32,
        of: impl Fn(u32) -> bool,
        last: &mut Option<u32>,
    ) -> bool {
        let ray = Ray::new(origin.into(), direction.into(), 0.0, distance);
        if last.is_some_and(|i| self.is_met(&self.triangle(i), &ray)) {
            return true;
        }
        let meet = |c: &Corners, r: &Ray| {
            if of(c.object) { c.meet(r, |_| self.exact_distance(c, &ray)) } else { f32::INFINITY }
        };
        let own = self.hierarchy.triangles.primitives.len() as u32;
        *last = self.hierarchy.triangles.any_number(ray, meet);
        *last = last.or_else(|| self.hierarchy.instances.any(&ray, meet).map(|i| own + i));
        last.is_some()
    }

    fn is_met(&self, corners: &Corners, ray: &Ray) -> bool {
        corners.meet(ray, |_| self.exact_distance(corners, ray)).is_finite()
    }

    /// False when no ray of the region meets one of the primitives; may be true although none does.
    #[must_use]
    pub fn meets_any(&self, region: &Region, primitives: &[Primitive]) -> bool {
        primitives.iter().any(|p| match p {
            Primitive::Triangle(i) => !region.misses_triangle(&self.triangle(*i)),
            Primitive::Sphere(i) => !region.misses_sphere(&self.hierarchy.spheres.primitives[*i as usize]),
        })
    }

    /// The same for all primitives of the objects `of`.
    #[must_use]
    pub fn meets(&self, region: &Region, of: impl Fn(u32) -> bool) -> bool {
        let outside = |b: &Aabb| region.misses_box(b);
        self.hierarchy.triangles.visit(&outside, &mut |_, c| of(c.object) && !region.misses_triangle(c))
            || self.hierarchy.instances.visit(&outside, &mut |_, c| of(c.object) && !region.misses_triangle(c))
            || self.hierarchy.spheres.visit(&outside, &mut |_, b| of(b.object) && !region.misses_sphere(b))
    }
}
