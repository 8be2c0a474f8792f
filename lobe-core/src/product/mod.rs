//! The integral of the product of two lobes.

mod arc;
mod normalized;
mod peak;

pub use self::normalized::is_lambert;
#[cfg(test)]
pub(crate) use self::normalized::normalized_product;
pub(crate) use self::normalized::normalized_total;

use self::arc::Arc;
use self::peak::Peak;

use crate::lanes::{Block, Columns, Lane, WIDTH, map, row};
use crate::special::gamma_ratios;
use core::f32::consts::PI;
use fearless_simd::{Level, dispatch};
use glam::Vec3;

/// `P(e₁, e₂, α) = ∫ max(a₁·v, 0)^e₁ max(a₂·v, 0)^e₂ dv`, the integral over the sphere of the product of two lobes of
/// scale 1.
///
/// `P = B(e₁+e₂)·J`, where the integral across the plane of the two axes is exact,
/// `B(n) = √π Γ(n/2+1)/Γ(n/2+3/2)`, and `J = ∫ cos^e₁ψ cos^e₂(ψ−α) dψ` in the plane is taken at its peak: with `t` the
/// angle of the peak from `a₁` (the axis of Eq. 19 in closed form),
/// `J ≈ cos^e₁t cos^e₂(α−t) A(n) exp(5h₃²/24n³ − (h₄−2n)/8n²)`, `n = e₁/cos²t + e₂/cos²(α−t)`,
/// `A(n) = √π Γ((n+1)/2)/Γ(n/2+1)`, h₃ and h₄ the third and fourth derivatives of the integrand's logarithm. Where an
/// exponent is below 8 and that expansion is not good (the horizon of the broad lobe cuts the integrand off, or both are
/// broad) `J` is a 20-node quadrature clustered at both ends.
///
/// # Domain
/// Exponents in [0, 1e6] (up to 1e18 they work as well), unit axes; the angle comes from `|a₁−a₂|`, which keeps its
/// digits where `a₁·a₂` has none left.
///
/// # Accuracy
/// Relative error ≤ 0.15 % wherever `P` exceeds 1e-4 of the coaxial `2π/(e₁+e₂+1)`, against quadrature in f64; absolute
/// error below 1e-6 of the coaxial value elsewhere.
///
/// # Cost
/// About 180 instructions; ten times that where the quadrature is needed. Many at once: [`products_of_angle`].
///
/// ```
/// use glam::Vec3;
/// let p = lobe_core::product_integral(3.0, 5.0, Vec3::Z, Vec3::Z);
/// assert!((p - core::f32::consts::TAU / 9.0).abs() < 1e-5);
/// ```
#[must_use]
pub fn product_integral(e1: f32, e2: f32, a1: Vec3, a2: Vec3) -> f32 {
    product_of_angle(e1, e2, 0.5 * (a1 - a2).length_squared())
}

/// [`product_integral`] by `1 − cos α` instead of the axes.
#[must_use]
pub fn product_of_angle(e1: f32, e2: f32, one_minus_cos: f32) -> f32 {
    let value = high(e1, e2, one_minus_cos);
    if value >= 0.0 { value } else { low(e1, e2, one_minus_cos) }
}

/// [`product_of_angle`] of many pairs, bit for bit what the single call gives.
///
/// # Cost
/// Sixteen pairs side by side: 6 ns a pair; 50 ns where the quadrature is needed.
///
/// # Panics
/// When the slices differ in length.
pub fn products_of_angle(e1: &[f32], e2: &[f32], one_minus_cos: &[f32], out: &mut [f32]) {
    products_at(Level::new(), e1, e2, one_minus_cos, out);
}

pub(crate) fn products_at(level: Level, e1: &[f32], e2: &[f32], one_minus_cos: &[f32], out: &mut [f32]) {
    let n = out.len();
    assert!(e1.len() == n && e2.len() == n && one_minus_cos.len() == n, "one product for each pair");
    let mut waiting = Block::<3>::new();
    for start in (0..n).step_by(WIDTH) {
        let count = WIDTH.min(n - start);
        let mut columns = [[0.0; WIDTH]; 3];
        for (column, from) in columns.iter_mut().zip([e1, e2, one_minus_cos]) {
            column[..count].copy_from_slice(&from[start..start + count]);
        }
        let mut values = [[0.0; WIDTH]];
        map(level, &High, &columns, &[], &mut values);
        let [values] = values;
        out[start..start + count].copy_from_slice(&values[..count]);
        if values.iter().fold(f32::MAX, |least, value| least.min(*value)) >= 0.0 {
            continue;
        }
        for j in (0..count).filter(|&j| values[j] < 0.0) {
            out[start + j] = 0.0;
            if waiting.push(&row(&columns, j), start + j) {
                let values = low_block(level, &waiting.columns);
                waiting.flush(&values, out);
            }
        }
    }
    if waiting.len > 0 {
        let values = low_block(level, &waiting.columns);
        waiting.flush(&values, out);
    }
}

struct High;
impl Lane<3, 0, 1> for High {
    #[inline(always)]
    fn value(&self, [e1, e2, one_minus_cos]: [f32; 3], []: [f32; 0]) -> [f32; 1] {
        [high(e1, e2, one_minus_cos)]
    }
}

/// [`low`] of every row, node by node.
fn low_block(level: Level, columns: &Columns<3>) -> [f32; WIDTH] {
    let mut arcs = [[0.0; WIDTH]; 7];
    map(level, &ToArc, columns, &[], &mut arcs);
    dispatch!(level, _simd => {
        let mut sums = [0.0; WIDTH];
        for node in Arc::NODES {
            for (j, sum) in sums.iter_mut().enumerate() {
                let arc: Arc = bytemuck::cast(row(&arcs, j));
                *sum += arc.node(node).1;
            }
        }
        for (j, sum) in sums.iter_mut().enumerate() {
            *sum *= arcs[6][j];
        }
        sums
    })
}

struct ToArc;
impl Lane<3, 0, 7> for ToArc {
    #[inline(always)]
    fn value(&self, [e1, e2, one_minus_cos]: [f32; 3], []: [f32; 0]) -> [f32; 7] {
        bytemuck::cast(Arc::new(&Peak::new(e1, e2, one_minus_cos), e1, e2))
    }
}

/// By the saddle point; negative where that is not good enough.
#[inline(always)]
fn high(e1: f32, e2: f32, one_minus_cos: f32) -> f32 {
    let saddle = Peak::new(e1, e2, one_minus_cos).saddle(e1, e2);
    // Two pairs of Γ functions: π·Γ ratio across the plane·Γ ratio in it.
    let value = saddle.value * (PI * gamma_ratios(0.5 * (e1 + e2 + 1.0), 0.5 * saddle.n));
    if saddle.trusted { value } else { -1.0 }
}

/// By quadrature in the plane.
#[inline(always)]
fn low(e1: f32, e2: f32, one_minus_cos: f32) -> f32 {
    Arc::new(&Peak::new(e1, e2, one_minus_cos), e1, e2).integral()
}
