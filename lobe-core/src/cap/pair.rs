use crate::PackedLobe;
use crate::seen::Seen;
use glam::Vec3;

/// A lobe and a light at a receiver: what the slab and the chord form start from. Twelve numbers, so that many of them
/// lie in columns.
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct Pair {
    pub(super) axis: Vec3,
    pub(super) exponent: f32,
    /// The lobe's kind: 1 where the receiver's cosine multiplies it, else 0. Microfacets do not read it.
    pub(super) cosine: f32,
    pub(super) normal: Vec3,
    /// Axis of the cone.
    pub(super) light: Vec3,
    pub(super) one_minus_cos: f32,
}

impl Pair {
    /// `1 − cos δ` of the angle δ between the two axes, from their chord.
    #[inline(always)]
    pub(super) fn one_minus_cos_delta(&self) -> f32 {
        let d = self.axis - self.light;
        0.5 * d.dot(d)
    }

    /// The unit vector at a right angle to the lobe's axis, toward the light; zero where the two axes are one.
    ///
    /// From their difference, made orthogonal: axes that are 1e-4 apart have no length to 1e-7 to tell a direction by.
    #[inline(always)]
    pub(super) fn aside(&self) -> Vec3 {
        let d = self.light - self.axis;
        let aside = d - self.axis * self.axis.dot(d);
        let square = aside.dot(aside);
        aside * if square > 1e-30 { 1.0 / square.sqrt() } else { 0.0 }
    }
}

impl Seen {
    #[inline(always)]
    pub(super) fn pair(&self, lobe: &PackedLobe) -> Pair {
        Pair {
            axis: lobe.axis,
            exponent: lobe.exponent,
            cosine: lobe.kind,
            normal: self.normal,
            light: self.axis,
            one_minus_cos: self.one_minus_cos,
        }
    }
}
