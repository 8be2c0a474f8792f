use core::fmt::{self, Debug, Formatter};
use glam::Vec3;
use lobe_core::Sphere;
use shading::{DynScratch, Shaft};

/// Traces the rays that outlines leave open: whether a ray meets any triangle.
///
/// It must have the same triangles as the meshes.
pub trait AnyHit: Sync {
    /// Working memory, one a thread.
    type Scratch: Send + 'static;

    /// New working memory.
    fn scratch(&self) -> Self::Scratch;

    /// Called before a group of receivers and one light: all following rays are inside `shaft` until the next call. Returns `false`
    /// if no ray in the shaft meets a triangle.
    fn enter(&self, shaft: &Shaft, scratch: &mut Self::Scratch) -> bool {
        let _ = (shaft, scratch);
        true
    }

    /// The start of rays that leave a surface: just far enough off it that the surface does not hide itself.
    fn leave(&self, position: Vec3, face: Vec3) -> Vec3;

    /// Whether a triangle lies on the ray nearer than `distance`. `direction` has length 1.
    fn is_hit(&self, origin: Vec3, direction: Vec3, distance: f32, scratch: &mut Self::Scratch) -> bool;

    /// Calls `visit` for all triangles that may meet a sphere, with their corners in the order of the mesh.
    fn triangles_meeting(&self, sphere: Sphere, visit: &mut dyn FnMut([Vec3; 3]));

    /// Whether the triangles of an object are included.
    fn has(&self, object: u32) -> bool;
}

/// [`AnyHit`] in object-safe form: same operations, scratch erased. So the strategy is compiled once, not for each kind of rays.
pub(crate) trait DynAnyHit: Sync {
    fn scratch(&self) -> DynScratch;
    fn enter(&self, shaft: &Shaft, scratch: &mut DynScratch) -> bool;
    fn leave(&self, position: Vec3, face: Vec3) -> Vec3;
    fn is_hit(&self, origin: Vec3, direction: Vec3, distance: f32, scratch: &mut DynScratch) -> bool;
    fn triangles_meeting(&self, sphere: Sphere, visit: &mut dyn FnMut([Vec3; 3]));
    fn has(&self, object: u32) -> bool;
}

fn downcast<S: 'static>(scratch: &mut DynScratch) -> &mut S {
    scratch.downcast_mut().expect("scratch was made by other rays")
}

impl<H: AnyHit> DynAnyHit for H {
    fn scratch(&self) -> DynScratch {
        Box::new(AnyHit::scratch(self))
    }
    fn enter(&self, shaft: &Shaft, scratch: &mut DynScratch) -> bool {
        AnyHit::enter(self, shaft, downcast(scratch))
    }
    fn leave(&self, position: Vec3, face: Vec3) -> Vec3 {
        AnyHit::leave(self, position, face)
    }
    fn is_hit(&self, origin: Vec3, direction: Vec3, distance: f32, scratch: &mut DynScratch) -> bool {
        AnyHit::is_hit(self, origin, direction, distance, downcast(scratch))
    }
    fn triangles_meeting(&self, sphere: Sphere, visit: &mut dyn FnMut([Vec3; 3])) {
        AnyHit::triangles_meeting(self, sphere, visit);
    }
    fn has(&self, object: u32) -> bool {
        AnyHit::has(self, object)
    }
}

impl Debug for dyn DynAnyHit + '_ {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str("AnyHit")
    }
}
