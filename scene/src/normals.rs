//! Measures that smooth normals are made with.

use glam::{DVec3, Vec3};

/// Whether a normal has a direction.
#[must_use]
#[inline]
pub fn is_usable(normal: &Vec3) -> bool {
    normal.is_finite() && normal.length() > 1e-20
}

/// The angle of a triangle at its corner `k`, in radians, of its corners' positions.
#[must_use]
#[inline]
pub fn angle_at(k: usize, corners: &[DVec3; 3]) -> f64 {
    let (to_next, to_last) = (corners[(k + 1) % 3] - corners[k], corners[(k + 2) % 3] - corners[k]);
    to_next.cross(to_last).length().atan2(to_next.dot(to_last))
}
