use fearless_simd::{Simd, f32x8};

/// The sum of eight lanes, in an order that is the same everywhere.
#[inline(always)]
pub(crate) fn sum<S: Simd>(lanes: f32x8<S>) -> f32 {
    let [a, b, c, d, e, f, g, h]: [f32; 8] = lanes.into();
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}
