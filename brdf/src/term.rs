//! What a material's lobe is made of: constants, and a function of normal and view.

use crate::lafortune_term::{IsotropicTerm, LafortuneTerm};
use crate::phong::mirrored_view;
use glam::Vec3;
use lobe_core::{Lobe, Receiver};

/// One lobe of a material, for any receiver.
#[derive(Clone, Copy)]
pub(crate) enum Term<'a> {
    Diffuse(Diffuse),
    Mirror(Mirror),
    Lafortune(&'a LafortuneTerm),
    Isotropic(&'a IsotropicTerm),
}

impl Term<'_> {
    /// The lobe at a receiver; none where it reflects nothing.
    pub(crate) fn lobe(&self, at: &Receiver) -> Option<Lobe> {
        let lobe = match self {
            Self::Diffuse(shape) => shape.lobe(at.normal, at.view),
            Self::Mirror(shape) => shape.lobe(at.normal, at.view),
            Self::Lafortune(shape) => shape.lobe(at.normal, at.view),
            Self::Isotropic(shape) => shape.lobe(at.normal, at.view),
        };
        (lobe.flux != Vec3::ZERO).then_some(lobe)
    }
}

/// A lobe as `P` constants. What reflects nothing has a flux of zero.
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
        Lobe { axis: mirrored_view(normal, view), exponent: self.exponent, flux: self.flux, factor: self.cosine }
    }
}
