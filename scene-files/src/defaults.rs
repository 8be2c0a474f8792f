//! Defaults for everything that a scene file leaves out.

use brdf::{Lambert, Material};
use glam::Vec3;
use scene::{Bounds, Camera};

pub(crate) const DEFAULT_SPHERES: usize = 64;
pub(crate) const DEFAULT_FOV: f32 = 35.0;
pub(crate) const DEFAULT_SIZE: (u32, u32) = (960, 540);

pub(crate) fn default_material() -> Material {
    Lambert { albedo: Vec3::splat(0.5) }.into()
}

/// Looks at everything from the front, a little from the right and from above.
pub(crate) fn default_camera(bounds: Bounds, width: u32, height: u32) -> Camera {
    Camera::framing(bounds, Vec3::new(0.35, 0.5, 1.0), DEFAULT_FOV.to_radians(), width, height)
}
