//! The integrals of lobes of microfacets with a grain over a light's cone: the chords of another ellipse.

use super::ellipse::{Moments, chords_of, moments};
use super::microfacets::Ellipse;
use super::pair::Pair;
use crate::PackedLobe;
use crate::grain::Grain;
use crate::microfacets::{alpha_sq, seen_from};
use glam::Vec3;

/// The numbers that all chords of microfacets with a grain share. Fourteen numbers, so that many of them lie in columns.
///
/// Slopes are stretched by another `α` along the grain than across it, `σ = (h_t/α_t, h_b/α_b)/h_z`, and the light is an ellipse still. Chords run
/// along its principal axis there. Lines stay lines: among slopes as they are a chord has `α` along it and across it, whose product is `α_t α_b`, and a
/// shear along it that grows with the chord's place.
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct Brushed {
    ellipse: Ellipse,
    along: f32,
    shear: f32,
}

impl Brushed {
    #[inline(always)]
    pub(super) fn new<const IS_CUT: bool>(pair: &Pair) -> Self {
        let n = pair.normal;
        let (vz, sin, forward) = seen_from(n, pair.axis);
        let aside = n.cross(forward);
        let grain = PackedLobe::grain(pair.cosine).unwrap_or(Grain::NONE);
        let (turn, fine) = (grain.turn(), alpha_sq(pair.exponent).sqrt());
        let rough = grain.alpha(fine);
        // Along and across the grain.
        let (cx, cy, cz) = (forward.dot(pair.light), aside.dot(pair.light), n.dot(pair.light));
        let (vx, vy) = (sin * turn.x, -sin * turn.y);
        let (lx, ly) = (cx * turn.x + cy * turn.y, cy * turn.x - cx * turn.y);
        let Moments { middle: [mx, my], second: [xx, yy, xy] } =
            moments([vx, vy, vz], [lx, ly, cz], pair.one_minus_cos);
        let second = [xx / (rough * rough), yy / (fine * fine), xy / (rough * fine)];
        let ([ex, ey], gap) = chords_of::<IS_CUT>(&Moments { middle: [mx / rough, my / fine], second });
        let (ax, ay) = (rough * ex, fine * ey);
        let along = (ax * ax + ay * ay).sqrt();
        let (ax, ay) = (ax / along, ay / along);
        let across = rough * fine / along;
        let shear = (fine * fine - rough * rough) * ex * ey / (along * along);
        let view = Vec3::new(vx * ax + vy * ay, vy * ax - vx * ay, vz);
        let light = Vec3::new(lx * ax + ly * ay, ly * ax - lx * ay, cz);
        let [x, y] = sheared([view.x, view.y], [along, shear, across]);
        let shared = (cx * cx + cy * cy, (vz * vz + x * x + y * y).sqrt());
        let ellipse = Ellipse::between::<IS_CUT>(view, light, pair.one_minus_cos, (across * across, gap), shared);
        Self { ellipse, along, shear }
    }

    #[inline(always)]
    pub(super) fn weight(&self) -> f32 {
        self.ellipse.weight()
    }

    #[inline(always)]
    pub(super) fn node<const IS_CUT: bool>(&self, cos: f32, weight: f32) -> [f32; 2] {
        self.ellipse.node_of::<IS_CUT, true>(cos, weight, [self.along, self.shear])
    }
}

/// A direction's parts along and across the chords, each times the roughness there: `Aᵀ` of what stretches slopes.
#[inline(always)]
pub(super) fn sheared([x, y]: [f32; 2], [along, shear, across]: [f32; 3]) -> [f32; 2] {
    [along * x, shear * along * x + across * y]
}

/// [`masking`](crate::microfacets::masking) by both parts of the light's direction, stretched.
#[inline(always)]
pub(super) fn masked(light: f32, view: f32, shadowing: f32, [x, y]: [f32; 2]) -> f32 {
    let light = if light > 0.0 { light } else { 0.0 };
    0.5 * light / (light * shadowing + view * (light * light + x * x + y * y).sqrt())
}
