//! Coordinates relative to a point nearby, for geometry far from the origin of its file.
//!
//! At 1e6 from the origin single precision has steps of 0.06. So the numbers of a file are read in double precision, and a
//! point near the scene is subtracted before they are rounded.

use glam::{DVec3, Vec3};

/// Geometry is taken relative to a point nearby if it is farther from the origin than this many times its size.
const FAR: f64 = 32.0;

/// A point near `center` for a thing of that size, or the origin where that is near enough. Of few binary digits, so that the
/// differences of most numbers to it are exact.
pub(crate) fn near(center: DVec3, size: f64) -> DVec3 {
    if !(center.is_finite() && size > 0.0 && size.is_finite()) || center.abs().max_element() <= FAR * size {
        return DVec3::ZERO;
    }
    let unit = size.log2().ceil().exp2();
    (center / unit).round() * unit
}

/// The difference of a position to an origin; for the origin zero the position in single precision as it is.
pub(crate) fn relative(position: DVec3, origin: DVec3) -> Vec3 {
    (position - origin).as_vec3()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_far_has_an_origin_of_its_own() {
        assert_eq!(near(DVec3::new(30.0, -5.0, 2.0), 1.0), DVec3::ZERO);
        assert_eq!(near(DVec3::new(1e6, 3.0, -2e5), 5.0), DVec3::new(1e6, 0.0, -2e5));
        for size in [0.0, f64::NAN, f64::INFINITY, -1.0] {
            assert_eq!(near(DVec3::splat(1e6), size), DVec3::ZERO);
        }
        assert_eq!(near(DVec3::NAN, 1.0), DVec3::ZERO);
        let tiny = near(DVec3::splat(1.0), 1e-30);
        assert!(tiny.is_finite() && tiny.distance(DVec3::ONE) < 1e-15);
    }
}
