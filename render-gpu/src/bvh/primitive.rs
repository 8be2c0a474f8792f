//! Triangles and spheres as the kernels read them, and the rays that they stop.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// `Primitive` of bvh.wgsl.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct GpuPrimitive {
    /// A triangle's corner or a sphere's centre.
    pub(crate) a: [f32; 3],
    /// Number of the object, and flags.
    pub(crate) object: u32,
    /// The next corner, or a sphere's radius.
    pub(crate) b: [f32; 3],
    pub(crate) material: u32,
    pub(crate) c: [f32; 3],
    /// Where its normals begin.
    pub(crate) corners: u32,
}

pub(crate) const SPHERE: u32 = 1 << 31;
pub(crate) const VISIBLE: u32 = 1 << 30;
pub(crate) const BLOCKS: u32 = 1 << 29;
pub(crate) const BLOCKS_ALIKE: u32 = 1 << 28;
/// No normals of its own.
pub(crate) const FLAT: u32 = u32::MAX;

/// On which receivers an object casts shadows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ShadowCasting {
    /// On none.
    None,
    /// On all.
    #[default]
    All,
    /// On receivers of objects that also cast `Alike`. Other blockers, such as shadow maps, hide the light from all other
    /// receivers.
    Alike,
}

/// The smallest box around a primitive.
pub(super) fn bounds(p: &GpuPrimitive) -> [Vec3; 2] {
    let a = Vec3::from(p.a);
    if p.object & SPHERE != 0 {
        return [a - p.b[0], a + p.b[0]];
    }
    let (b, c) = (Vec3::from(p.b), Vec3::from(p.c));
    [a.min(b).min(c), a.max(b).max(c)]
}
