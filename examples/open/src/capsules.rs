//! Blockers: capsules, segments with a radius, exact.

use cosine_lobes::glam::Vec3;
use cosine_lobes::lobe_core::wgsl::{GEOMETRY, Piece};
use cosine_lobes::lobe_core::{Cone, Sphere};
use cosine_lobes::renderer::CustomStrategy;
use cosine_lobes::scene::Scene;
use cosine_lobes::shading::gpu::{GpuBlockers, GpuBuffer};
use cosine_lobes::shading::{Coverage, VisibilityQuery};
use cosine_lobes::visibility_mask::wgsl::MASK;
use cosine_lobes::visibility_mask::{Blockers, DynBlockers, Mask};

/// All points nearer than `radius` to the segment between two ends.
#[derive(Clone, Copy, Debug)]
pub struct Capsule {
    pub ends: [Vec3; 2],
    pub radius: f32,
}

/// A set of capsules as a strategy.
#[derive(Clone, Debug, Default)]
pub struct Capsules(pub Vec<Capsule>);

impl Capsule {
    /// Whether it may hide a part of a light: the sphere around it meets the light's cone, and it begins before the light.
    fn meets(&self, x: Vec3, cone: &Cone) -> bool {
        let [a, b] = self.ends;
        let radius = 0.5 * a.distance(b) + self.radius;
        let around = Cone::of_sphere(x, Sphere { center: 0.5 * (a + b), radius });
        let along = (b - a) / a.distance_squared(b).max(f32::MIN_POSITIVE);
        let nearest = (a + (b - a) * (x - a).dot(along).clamp(0.0, 1.0)).distance(x) - self.radius;
        let reach = around.cos().clamp(-1.0, 1.0).acos() + cone.cos().acos();
        nearest < cone.distance && (around.one_minus_cos > 1.0 || around.axis.angle_between(cone.axis) <= reach + 1e-4)
    }
}

/// The part of the line of directions `(x, y, 1)` that a shape hides: from, to; empty where it hides nothing.
type Span = (f32, f32);

/// The interval where `a·x² + 2b·x + c ≤ 0`, in this order; NaN if there is none.
fn roots(a: f32, b: f32, c: f32) -> Span {
    let root = (b * b - a * c).sqrt();
    // Without cancellation.
    let q = -(b + root.copysign(b));
    (f32::min(q / a, c / q), f32::max(q / a, c / q))
}

/// A sphere: `(c·d)² ≥ (c² − r²)·d²`, before the receiver.
fn sphere(c: Vec3, radius: f32, y: f32) -> Span {
    let (power, along) = (c.length_squared() - radius * radius, c.y * y + c.z);
    if power <= 0.0 {
        return (f32::NEG_INFINITY, f32::INFINITY);
    }
    let a = power - c.x * c.x;
    let (from, to) = roots(a, -c.x * along, power * (y * y + 1.0) - along * along);
    match a > 0.0 {
        true if c.x * from + along > 0.0 => (from, to),
        // A hyperbola, of which one branch is before the receiver.
        false if c.x > 0.0 => (to, f32::INFINITY),
        false if c.x < 0.0 => (f32::NEG_INFINITY, from),
        _ => (f32::INFINITY, f32::NEG_INFINITY),
    }
}

/// A capsule from `p` to `q`: the hull of its two spheres and of where the tube between them ends.
fn capsule(p: Vec3, q: Vec3, radius: f32, y: f32) -> Span {
    let hull = |a: Span, b: Span| (a.0.min(b.0), a.1.max(b.1));
    let both = hull(sphere(p, radius, y), sphere(q, radius, y));
    let length = p.distance(q);
    if length <= 1e-6 * radius {
        return both;
    }
    let (u, r) = ((q - p) / length, radius * radius);
    let (g, w) = (u.cross(p), y * y + 1.0);
    let (g0, u0) = (g.y * y + g.z, u.y * y + u.z);
    let ends = roots(g.x * g.x - r * (1.0 - u.x * u.x), g.x * g0 + r * u.x * u0, g0 * g0 - r * (w - u0 * u0));
    // Whether a ray touches the tube between its ends.
    let touches = |x: f32| {
        let (d, du) = (Vec3::new(x, y, 1.0), u.x * x + u0);
        let t = (d.dot(p) - du * u.dot(p)) / (d.length_squared() - du * du);
        t > 0.0 && (0.0..=length).contains(&(t * du - u.dot(p)))
    };
    [ends.0, ends.1].into_iter().filter(|x| touches(*x)).fold(both, |all, x| hull(all, (x, x)))
}

impl Blockers for Capsules {
    /// Those that may hide something, as seen from the receiver.
    type Scratch = Vec<Capsule>;

    fn scratch(&self) -> Vec<Capsule> {
        Vec::new()
    }

    fn select(&self, query: &VisibilityQuery<'_>, near: &mut Vec<Capsule>) -> Coverage {
        near.clear();
        near.extend(self.0.iter().filter(|capsule| capsule.meets(query.at.position, query.cone)));
        if near.is_empty() { Coverage::Lit } else { Coverage::Partial }
    }

    fn splat(&self, query: &VisibilityQuery<'_>, near: &mut Vec<Capsule>, mask: &mut Mask) {
        for Capsule { ends, radius } in near {
            let [p, q] = ends.map(|end| mask.square().local(end - query.at.position));
            (0..mask.side()).for_each(|row| mask.block_area(row, |y| capsule(p, q, *radius, y)));
        }
    }
}

/// For renderers. Nothing is to be followed: the capsules are the objects.
impl CustomStrategy for Capsules {
    fn name(&self) -> &'static str {
        "capsules"
    }

    fn update(&mut self, _: &Scene, _: &[usize]) -> Result<(), String> {
        Ok(())
    }

    fn blockers(&self) -> &dyn DynBlockers {
        self
    }

    fn gpu_blockers(&self) -> Option<&dyn GpuBlockers> {
        Some(self)
    }
}

static CAPSULE: Piece = Piece::new("struct Capsule { a: vec3f, radius: f32, b: vec3f, pad: f32 }");
static COVERAGE: Piece = Piece::new(include_str!("capsules_coverage.wgsl")).needs(&[&CAPSULE, &GEOMETRY]);
static SPLAT: Piece = Piece::new(include_str!("capsules_splat.wgsl")).needs(&[&CAPSULE, &MASK]);

/// The same in WGSL.
impl GpuBlockers for Capsules {
    fn name(&self) -> &'static str {
        "capsules"
    }

    fn coverage(&self) -> &'static Piece {
        &COVERAGE
    }

    fn splat(&self) -> &'static Piece {
        &SPLAT
    }

    fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    fn buffers(&self) -> Vec<GpuBuffer<'_>> {
        let numbers = |c: &Capsule| [c.ends[0].extend(c.radius), c.ends[1].extend(0.0)].map(|v| v.to_array()).concat();
        let words: Vec<u32> = self.0.iter().flat_map(numbers).map(f32::to_bits).collect();
        vec![GpuBuffer::of("capsules_all", "Capsule", words)]
    }
}
