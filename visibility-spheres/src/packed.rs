use crate::SphereBlockers;
use bytemuck::{Pod, Zeroable};
use lobe_core::NO_OBJECT;

/// How many neighbours of [`SphereBlockers::pack`] share a bound on the GPU.
pub const SPHERE_BLOCK: usize = 32;

/// Words of a tile's list: how many spheres, flags, their indices, ascending.
pub const LIST_WORDS: usize = LIST_ROOM + 2;

/// Spheres that a tile's list may have.
pub(crate) const LIST_ROOM: usize = 512;

/// A blocker as kernels read it: `BlockerSphere` of `packed.wgsl`, 48 bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct BlockerSphere {
    /// Centre.
    pub center: [f32; 3],
    /// Radius.
    pub radius: f32,
    /// The sphere that receivers of its own object see from inside it ([`SelfShadow`](lobe_core::SelfShadow)): from the centre
    /// to that sphere's.
    pub own_offset: [f32; 3],
    /// Radius of that sphere.
    pub own_radius: f32,
    /// Number of the object that it stands for.
    pub object: u32,
    /// For receivers of that object: how far away a ray must leave it to be blocked (τ).
    pub own_distance: f32,
    /// Of the objects that have a sphere, the one at this sphere's place in ascending order; [`NO_OBJECT`] behind the last.
    pub caster: u32,
    /// Nothing.
    pub pad: u32,
}

impl SphereBlockers {
    /// Replaces `out` by the spheres that can block, as kernels read them: neighbours in space are neighbours in the list, so
    /// that each [`SPHERE_BLOCK`] of them have a small bound.
    ///
    /// The order is that of the hierarchy: after [`update`](Self::update) the same as before unless that says that it made a
    /// new one. Spheres that block nothing (radius zero or less, anything infinite or NaN) are left out. O(n).
    pub fn pack(&self, out: &mut Vec<BlockerSphere>) {
        out.clear();
        let casters = self.casters().iter().copied().chain(core::iter::repeat(NO_OBJECT));
        out.extend(self.order().iter().zip(casters).map(|(index, caster)| {
            let index = *index as usize;
            let (own, own_distance) = self.own(index);
            let sphere = self.spheres()[index];
            BlockerSphere {
                center: sphere.center.to_array(),
                radius: sphere.radius,
                own_offset: own.center.to_array(),
                own_radius: own.radius,
                object: self.objects()[index],
                own_distance,
                caster,
                pad: 0,
            }
        }));
    }
}
