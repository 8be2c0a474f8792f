//! The grain of a metallic–roughness material (KHR_materials_anisotropy).

use crate::Packer;
use crate::visible_normals::VisibleNormals;
use crate::wgsl::MATERIAL;
use glam::Vec3;
use lobe_core::wgsl::{MICROFACETS_GRAIN, Piece};
use lobe_core::{Grain, Receiver, orthonormal_basis};

/// Rougher along a direction: `α_t = α + (1 − α) strength²` there, `α` across it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Anisotropy {
    pub(crate) strength: f32,
    /// The direction, of any length; one that follows from the normal without.
    pub(crate) tangent: Option<Vec3>,
}

impl Anisotropy {
    fn tangent(&self, normal: Vec3) -> Vec3 {
        self.tangent.unwrap_or_else(|| orthonormal_basis(normal).0)
    }

    pub(crate) fn grain(&self, at: &Receiver) -> Option<Grain> {
        (self.strength > 0.0).then(|| Grain::new(at.normal, at.view, self.tangent(at.normal), self.strength))
    }

    /// Strength, whether there is an own tangent, that tangent.
    pub(crate) fn pack(&self, out: &mut Packer) {
        out.push([self.strength]);
        out.push_word(u32::from(self.tangent.is_some()));
        out.push(self.tangent.unwrap_or(Vec3::ZERO).to_array());
    }

    /// The roughness of an isotropic surface with as large a peak.
    pub(crate) fn mean(&self, alpha: f32) -> f32 {
        let along = alpha + (1.0 - alpha) * self.strength * self.strength;
        (along * alpha).sqrt().sqrt()
    }

    pub(crate) fn visible(&self, at: &Receiver, alpha: f32) -> Option<VisibleNormals> {
        let grain = self.grain(at)?;
        let along = grain.direction(at.normal, at.view).normalize();
        let frame = [along, at.normal.cross(along), at.normal];
        Some(VisibleNormals::in_frame(frame, at.view, [grain.alpha(alpha), alpha]))
    }
}

/// The WGSL of a grain.
pub(crate) static WGSL: Piece = Piece::new(include_str!("brushed.wgsl")).needs(&[&MATERIAL, &MICROFACETS_GRAIN]);
