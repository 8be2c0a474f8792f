//! A light above a receiver's horizon: what tiles keep in columns, and what integrals over discs start from.

use crate::Cone;
use glam::Vec3;

/// A light above a receiver's horizon. Ten numbers, so that many of them lie in columns.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(crate) struct Seen {
    pub(crate) normal: Vec3,
    pub(crate) axis: Vec3,
    pub(crate) one_minus_cos: f32,
    /// Cosine of the angle β between its axis and the normal; sin θ and its square.
    pub(crate) cos_beta: f32,
    pub(crate) sin: f32,
    pub(crate) sin_sq: f32,
}

impl Seen {
    #[inline(always)]
    pub(crate) fn new(normal: Vec3, cone: &Cone) -> Self {
        // Inside the light: everything above the horizon.
        let inside = cone.one_minus_cos > 1.0;
        let axis = if inside { normal } else { cone.axis };
        let one_minus_cos = if inside { 1.0 } else { cone.one_minus_cos };
        let sin_sq = one_minus_cos * (2.0 - one_minus_cos);
        Self { normal, axis, one_minus_cos, cos_beta: normal.dot(axis), sin: sin_sq.sqrt(), sin_sq }
    }
}
