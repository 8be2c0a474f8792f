//! One light as one receiver sees it.

use crate::{Cone, Lobe, Outline, cone_lobe};
use glam::Vec3;

/// One light as a receiver sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeenLight {
    /// Its cone.
    pub cone: Cone,
    /// Its radiance, W·m⁻²·sr⁻¹ per channel.
    pub radiance: Vec3,
    /// The bright part of the cone, where that is not all of it.
    pub outline: Option<Outline>,
}

impl SeenLight {
    /// A light that is bright in all of its cone.
    #[must_use]
    pub const fn of_cone(cone: Cone, radiance: Vec3) -> Self {
        Self { cone, radiance, outline: None }
    }

    /// A light with an outline, relative to the receiver; one with an empty cone toward `middle` where there is none.
    #[must_use]
    pub fn of_outline(outline: Option<Outline>, middle: Vec3, radiance: Vec3) -> Self {
        let distance = middle.length();
        // Twice, since one normalisation of a huge vector leaves f32.
        let axis = if middle.is_finite() { middle.normalize_or(Vec3::Z) } else { Vec3::Z };
        let distance = if distance > 0.0 { distance } else { f32::MIN_POSITIVE };
        let cone = outline.as_ref().map_or(Cone { axis, one_minus_cos: 0.0, distance }, Outline::cone);
        Self { cone, radiance, outline }
    }

    /// The cosine lobe with its flux and mean vector: of the outline, or of the whole cone.
    #[must_use]
    pub fn lobe(&self) -> Lobe {
        self.outline.as_ref().map_or_else(
            || {
                let lobe = cone_lobe(&self.cone);
                Lobe { flux: lobe.flux * self.radiance, ..lobe }
            },
            |outline| outline.lobe(self.radiance),
        )
    }

    /// The same light as far as a flat one is above the horizon of `normal`: with an empty cone where nothing of it is.
    #[must_use]
    pub fn above(&self, normal: Vec3) -> Self {
        let mut seen = *self;
        seen.keep_above(normal);
        seen
    }

    /// [`above`](Self::above) in place.
    pub(crate) fn keep_above(&mut self, normal: Vec3) {
        if Outline::keep_above(&mut self.outline, normal) && self.outline.is_none() {
            // The cone alone would be a light.
            self.cone.one_minus_cos = 0.0;
        }
    }
}
