use super::peak::Peak;
use crate::special::{atan2, cosine_power_arc, exp, ln_of, sin_of_octant};
use core::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// `∫ cos^e₁ψ cos^e₂(ψ−α) dψ` by quadrature, for lobes so broad that one's horizon cuts the other off.
///
/// Gauss–Legendre, clustered at both ends, where a power below 1 has an infinite slope, over the peak's surroundings.
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(crate) struct Arc {
    e1: f32,
    e2: f32,
    /// First node's end of the arc as ψ, and the arc's length.
    low: f32,
    length: f32,
    /// From the horizons to the ends of the arc.
    from_first: f32,
    from_second: f32,
    /// The product's integral across the plane, `B(e₁+e₂)`.
    across: f32,
}

impl Arc {
    /// Nodes of the rule on [0, 1]: `(x, 1 − x, weight)`.
    pub(crate) const NODES: [(f32, f32, f32); 2 * HALF.len()] = nodes();

    #[inline(always)]
    pub(crate) fn new(peak: &Peak, e1: f32, e2: f32) -> Self {
        let larger = |x: f32, than: f32| if x > than { x } else { than };
        let smaller = |x: f32, than: f32| if x < than { x } else { than };
        let alpha = atan2(peak.sin, peak.cos);
        let start = alpha - FRAC_PI_2;
        let top = smaller(larger(atan2(peak.tan[0], 1.0), start), FRAC_PI_2);
        // The logarithm's curvature is at least e₁+e₂ everywhere: 5 widths away it has fallen by 12.
        let window = 5.0 / larger(e1 + e2, 1e-6).sqrt();
        let low = larger(start, top - window);
        let high = smaller(FRAC_PI_2, top + window);
        let (from_first, from_second) = (FRAC_PI_2 - high, low - start);
        let across = cosine_power_arc(e1 + e2 + 1.0);
        Self { e1, e2, low, length: larger(high - low, 0.0), from_first, from_second, across }
    }

    /// ψ and the weighted integrand of a node.
    #[inline(always)]
    pub(crate) fn node(&self, (near, far, weight): (f32, f32, f32)) -> (f32, f32) {
        let (before, behind) = (self.length * near, self.length * far);
        let log = self.e1 * ln_cos(self.from_first + behind) + self.e2 * ln_cos(self.from_second + before);
        (self.low + before, self.length * weight * exp(log))
    }

    /// The integral over the sphere.
    #[inline(always)]
    pub(super) fn integral(&self) -> f32 {
        Self::NODES.into_iter().fold(0.0, |sum, node| sum + self.node(node).1) * self.across
    }
}

/// `ln sin d` of a distance `d` from the horizon, in [0, π]: near the horizon as near the axis without cancellation.
#[inline(always)]
fn ln_cos(d: f32) -> f32 {
    let x = if d < PI - d { d } else { PI - d };
    let near = x < FRAC_PI_4;
    let s = sin_of_octant(if near { x } else { FRAC_PI_2 - x });
    let square = s * s;
    0.5 * if near { ln_of(square, square - 1.0) } else { ln_of(1.0 - square, -square) }
}

const fn nodes() -> [(f32, f32, f32); 2 * HALF.len()] {
    let mut all = [(0.0, 0.0, 0.0); 2 * HALF.len()];
    let mut k = 0;
    while k < HALF.len() {
        let (x, weight) = HALF[k];
        let far = (1.0 - x) as f32;
        all[k] = (x as f32, far, weight as f32);
        all[all.len() - 1 - k] = (far, x as f32, weight as f32);
        k += 1;
    }
    all
}

/// The half below ½: the 20-point Gauss–Legendre rule under `x²(3 − 2x)`.
const HALF: [(f64, f64); 10] = [
    (3.533_100_16e-5, 0.000_180_925_605),
    (0.000_961_825_21, 0.002_154_660_74),
    (0.005_608_086_62, 0.007_888_609_75),
    (0.018_371_463_7, 0.018_480_110_8),
    (0.044_179_899_2, 0.033_865_417_3),
    (0.087_290_890_1, 0.052_782_934_3),
    (0.150_181_917, 0.072_989_900_1),
    (0.232_768_03, 0.091_688_625_7),
    (0.332_115_358, 0.106_074_704),
    (0.442_717_15, 0.113_894_112),
];
