//! Colours of vertices in text files, whose range is not stated.

use crate::unit::unit;
use glam::Vec3;
use scene::Encoding;

/// Makes sRGB colours linear ones in [0, 1]. Numbers above 1 are taken as bytes if they fit, else as 16 bits: returns the number that
/// stands for 1 then.
pub(crate) fn decode(colors: &mut [Vec3]) -> Option<f32> {
    let largest = colors.iter().filter(|c| c.is_finite()).map(|c| c.max_element()).fold(0.0, f32::max);
    let one = if largest <= 1.0 {
        1.0
    } else if largest <= 255.0 {
        255.0
    } else {
        65535.0
    };
    colors.iter_mut().for_each(|c| *c = Vec3::from_array(c.to_array().map(|x| Encoding::Srgb.linear(unit(x / one)))));
    (one != 1.0).then_some(one)
}

/// The line about such a range.
pub(crate) fn note(one: f32) -> String {
    format!("colours of vertices are above 1: {one} is taken as 1")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_number_tells_the_range() {
        for (colors, one) in [
            ([0.5, 0.25, 0.75], None),
            ([127.5, 63.75, 191.25], Some(255.0)),
            ([32767.5, 16383.75, 49151.25], Some(65535.0)),
        ] {
            let mut all = [Vec3::from_array(colors), Vec3::new(f32::NAN, -3.0, 0.0)];
            assert_eq!(decode(&mut all), one);
            assert!((all[0] - Vec3::new(0.21404, 0.05088, 0.52252)).length() < 1e-4, "{}", all[0]);
            assert_eq!(all[1], Vec3::ZERO);
        }
    }
}
