//! One lobe of any built-in model, whatever its shape.

use crate::lafortune_term::{IsotropicTerm, LafortuneTerm};
use crate::shape::{Diffuse, Mirror, Shape};
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
