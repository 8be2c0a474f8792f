//! The closed forms against the f64 oracle, at ordinary arguments and at extreme ones.

mod cap;
mod extremes;
mod geometry;
mod product;
mod tile;

use crate::Receiver;
use glam::{DVec3, Vec3};

pub(crate) fn receiver(normal: DVec3) -> Receiver {
    Receiver::on_surface(Vec3::ZERO, normal.as_vec3(), normal.as_vec3())
}

const EXTREME: [f32; 12] = [0.0, 1e-30, 1e-6, 0.5, 0.999_999, 1.0, 7.999, 400.0, 1e5, 1e7, 1e20, f32::INFINITY];

/// All that this machine can run, from the plainest on.
pub(crate) fn levels() -> Vec<fearless_simd::Level> {
    use fearless_simd::{Level, Simd};
    let best = Level::new();
    let mut all = vec![Level::baseline(), best];
    #[cfg(target_arch = "x86_64")]
    {
        all.extend(best.as_sse4_2().map(Simd::level));
        all.extend(best.as_avx2().map(Simd::level));
    }
    all
}
