//! Numbers kept in [0, 1].

/// Within [0, 1]; 0 for NaN.
pub(crate) fn unit(x: f32) -> f32 {
    if x > 0.0 { x.min(1.0) } else { 0.0 }
}
