use fearless_simd::{Simd, f32x8};

/// The lanes' numbers.
pub(crate) const NUMBERS: [f32; 8] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];

/// The sum of eight lanes, in an order that is the same everywhere.
#[inline(always)]
pub(crate) fn sum<S: Simd>(lanes: f32x8<S>) -> f32 {
    let [a, b, c, d, e, f, g, h]: [f32; 8] = lanes.into();
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}
