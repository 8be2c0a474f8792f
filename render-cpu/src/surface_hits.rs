use glam::Vec3;
use lobe_core::Sphere;
use ray_tracing::{TriangleList, World};
use shading::{LightId, Shaft};
use visibility_silhouettes::AnyHit;

/// So many triangles in a group's shaft are tested one by one; more are left to the hierarchy.
const LISTED: usize = 48;

/// Any-hit rays against the triangles of some objects of a [`World`]: what the `silhouettes` strategy asks once a mask.
#[derive(Debug)]
pub struct SurfaceHits<'w> {
    world: &'w World<'w>,
    /// For each object whether its triangles count.
    objects: Vec<bool>,
}

impl<'w> SurfaceHits<'w> {
    /// The triangles of the objects that `blocks` says yes to by their number.
    #[must_use]
    pub fn new(world: &'w World<'w>, blocks: impl Fn(u32) -> bool) -> Self {
        Self { world, objects: (0..world.scene().objects.len() as u32).map(blocks).collect() }
    }
}

/// Working memory of [`SurfaceHits`].
#[derive(Clone, Debug, Default)]
pub struct HitScratch {
    /// Triangles in the current shaft, where they are few.
    listed: TriangleList,
    is_listed: bool,
    /// The triangle that hid the light from the last receiver: it mostly hides it from the next one.
    last: Option<u32>,
}

impl AnyHit for SurfaceHits<'_> {
    type Scratch = HitScratch;

    fn scratch(&self) -> HitScratch {
        HitScratch::default()
    }

    fn enter(&self, shaft: &Shaft, scratch: &mut HitScratch) -> bool {
        scratch.last = None;
        scratch.is_listed = self.world.list_triangles(shaft, |o| self.has(o), LISTED, &mut scratch.listed);
        !(scratch.is_listed && scratch.listed.is_empty())
    }

    fn leave(&self, position: Vec3, face: Vec3) -> Vec3 {
        self.world.leave(position, face)
    }

    fn is_hit(&self, origin: Vec3, direction: Vec3, distance: f32, scratch: &mut HitScratch) -> bool {
        if scratch.is_listed {
            return self.world.meets_one(origin, direction, distance, &mut scratch.listed);
        }
        self.world.first_met(origin, direction, distance, |o| self.has(o), &mut scratch.last)
    }

    fn triangles_meeting(&self, sphere: Sphere, visit: &mut dyn FnMut([Vec3; 3])) {
        let mut found = Vec::new();
        let whole = Shaft::new(sphere, sphere, LightId(0));
        self.world.triangles_in(&whole, |o| self.has(o), usize::MAX, &mut found);
        for corners in self.world.names(&found).filter_map(|name| self.world.corners(name)) {
            let [a, b, c] = corners.map(|p| p.as_dvec3() - sphere.center.as_dvec3());
            // Not where the sphere is on one side of the plane.
            if (b - a).cross(c - a).normalize_or_zero().dot(a).abs() <= 1.000_1 * f64::from(sphere.radius) {
                visit(corners);
            }
        }
    }

    fn has(&self, object: u32) -> bool {
        self.objects.get(object as usize).is_some_and(|has| *has)
    }
}
