//! Shapes of lobes: each is a few constants that give a lobe for a normal and a view. Here are the trait, the diffuse shape and the mirrored one.

use glam::Vec3;
use lobe_core::Lobe;

/// A lobe as `P` constants. A lobe that reflects nothing has a flux of zero.
pub(crate) trait Shape<const P: usize>: bytemuck::Pod {
    /// To be inlined, and without branches: sixteen at a time are taken of it.
    fn lobe(&self, normal: Vec3, view: Vec3) -> Lobe;
}

/// A Lambert lobe: its flux.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(crate) struct Diffuse(pub(crate) Vec3);

impl Shape<3> for Diffuse {
    #[inline(always)]
    fn lobe(&self, normal: Vec3, _: Vec3) -> Lobe {
        Lobe::with_flux(normal, 1.0, self.0)
    }
}

/// A lobe about the mirrored view.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(crate) struct Mirror {
    pub(crate) flux: Vec3,
    pub(crate) exponent: f32,
    pub(crate) cosine: f32,
}

impl Shape<5> for Mirror {
    #[inline(always)]
    fn lobe(&self, normal: Vec3, view: Vec3) -> Lobe {
        Lobe {
            axis: mirrored_view(normal, view),
            exponent: self.exponent,
            flux: self.flux,
            has_cosine: self.cosine > 0.0,
        }
    }
}

/// `r = 2(n·ω_o)n − ω_o`.
#[inline(always)]
pub(crate) fn mirrored_view(normal: Vec3, view: Vec3) -> Vec3 {
    2.0 * normal.dot(view) * normal - view
}
