//! A light among the slopes of half vectors: an ellipse, and the chords through it.

/// The square root, of negative numbers 0.
#[inline(always)]
pub(super) fn root_of(x: f32) -> f32 {
    if x > 0.0 { x.sqrt() } else { 0.0 }
}

/// The height of the half vector of view and light, kept from 0.
#[inline(always)]
pub(super) fn above_zero(height: f32) -> f32 {
    if height > 1e-3 { height } else { 1e-3 }
}

/// An ellipse by its middle and its second moment about that: xx, yy and xy.
pub(super) struct Moments {
    pub(super) middle: [f32; 2],
    pub(super) second: [f32; 3],
}

/// Those of the light's ellipse, in slopes. With `h = (σ, 1)` it is where `2(ω_o·h)(c·h) > (ω_o·c + cos θ) h²`, from the half vector of the light's
/// middle on. Where that is no ellipse, a point there.
#[inline(always)]
pub(super) fn moments([vx, vy, vz]: [f32; 3], [cx, cy, cz]: [f32; 3], omc: f32) -> Moments {
    let near = above_zero(vz + cz);
    let (sx, sy) = ((vx + cx) / near, (vy + cy) / near);
    let both = 1.0 + (vx * cx + vy * cy + vz * cz);
    // zᵀNz − 2(1 − cos θ) σ·z − at_middle < 0
    let at_middle = 2.0 * both * omc / (near * near);
    let k = both - omc;
    let (xx, yy, xy) = (k - 2.0 * vx * cx, k - 2.0 * vy * cy, -(vx * cy + vy * cx));
    let det = xx * yy - xy * xy;
    let inverse = if det > 1e-9 && xx + yy > 0.0 { 1.0 / det } else { 0.0 };
    let (zx, zy) = (omc * (yy * sx - xy * sy) * inverse, omc * (xx * sy - xy * sx) * inverse);
    let size = 0.25 * inverse * (at_middle + omc * (sx * zx + sy * zy));
    Moments { middle: [sx + zx, sy + zy], second: [size * yy, size * xx, -size * xy] }
}

/// The longer axis of a second moment, and by how much its eigenvalues differ.
#[inline(always)]
fn longer_axis([xx, yy, xy]: [f32; 3]) -> ([f32; 2], f32) {
    let (difference, twice) = (xx - yy, 2.0 * xy);
    let root = (difference * difference + twice * twice).sqrt();
    let double = if root > 1e-30 { difference / root } else { 1.0 };
    let (ex, ey) = (root_of(0.5 * (1.0 + double)), root_of(0.5 * (1.0 - double)));
    ([ex, if twice < 0.0 { -ey } else { ey }], root)
}

/// Steps of Newton's method to the point of an ellipse next to the origin.
pub(super) const STEPS: usize = 3;

/// The direction of chords, and how far the ellipse is from the origin: across the way to the ellipse's point next to that, or along the longer axis of the
/// second moment about the origin where this is inside. Of a light that the horizon cuts the ellipse is not all there, and how far it is counts as 0.
#[inline(always)]
pub(super) fn chords_of<const IS_CUT: bool>(ellipse: &Moments) -> ([f32; 2], f32) {
    let ([mx, my], [xx, yy, xy]) = (ellipse.middle, ellipse.second);
    let (along, _) = longer_axis([xx + mx * mx, yy + my * my, xy + mx * my]);
    // In its own axes: a²p²/(a² + λ)² + b²q²/(b² + λ)² = 1.
    let ([ex, ey], root) = longer_axis(ellipse.second);
    let semi_axis_sq = |twice: f32| if twice > 1e-30 { 2.0 * twice } else { 2e-30 };
    let (a_sq, b_sq) = (semi_axis_sq(xx + yy + root), semi_axis_sq(xx + yy - root));
    let (p, q) = (mx * ex + my * ey, my * ex - mx * ey);
    let (ap_sq, bq_sq) = (a_sq * (p * p), b_sq * (q * q));
    let larger = |x: f32, y: f32| if x > y { x } else { y };
    let mut lambda = larger(larger((ap_sq + bq_sq).sqrt() - a_sq, bq_sq.sqrt() - b_sq), 0.0);
    for _ in 0..STEPS {
        let (of_a, of_b) = (1.0 / (a_sq + lambda), 1.0 / (b_sq + lambda));
        let (x, y) = (ap_sq * (of_a * of_a), bq_sq * (of_b * of_b));
        let step = 0.5 * (x + y - 1.0) / (x * of_a + y * of_b);
        lambda += larger(step, 0.0);
    }
    let (x, y) = (p / (a_sq + lambda), q / (b_sq + lambda));
    let length = (x * x + y * y).sqrt();
    let is_outside = lambda > 0.0 && length > 0.0 && length < f32::INFINITY;
    let over = 1.0 / if is_outside { length } else { 1.0 };
    let toward = [(x * ex - y * ey) * over, (x * ey + y * ex) * over];
    if !is_outside {
        return (along, 0.0);
    }
    let across = [-toward[1], toward[0]];
    (across, if IS_CUT { 0.0 } else { lambda * length })
}
