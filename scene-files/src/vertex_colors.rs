//! Colours of vertices in text files, whose range is not stated.

use crate::unit::unit;
use glam::Vec3;
use scene::Encoding;

/// Makes sRGB colours linear ones in [0, 1]. Numbers above 1 are taken as bytes if they fit, else as 16 bits; fractions of which none is above 2 are a little
/// too bright. Returns a line about what was done.
pub(crate) fn decode(colors: &mut [Vec3]) -> Option<String> {
    let is_broken = |c: &Vec3| !(c.min_element() >= 0.0 && c.is_finite());
    let broken = colors.iter().filter(|c| is_broken(c)).count();
    // A broken colour tells nothing of the range.
    let numbers = || colors.iter().filter(|c| !is_broken(c)).flat_map(|c| c.to_array());
    let largest = numbers().fold(0.0, f32::max);
    let has_fractions = || numbers().any(|x| x.fract() != 0.0);
    let one = if largest <= 1.0 || largest <= 2.0 && has_fractions() {
        1.0
    } else if largest <= 255.0 {
        255.0
    } else {
        65535.0
    };
    colors.iter_mut().for_each(|c| *c = Vec3::from_array(c.to_array().map(|x| Encoding::Srgb.linear(unit(x / one)))));
    let above = (largest > 1.0).then(|| {
        if one == 1.0 { "those above 1 are cut".into() } else { format!("they are above 1: {one} is taken as 1") }
    });
    let below = (broken > 0).then(|| format!("{broken} with negative or broken numbers, which are taken as 0"));
    let all: Vec<String> = above.into_iter().chain(below).collect();
    (!all.is_empty()).then(|| format!("colours of vertices: {}", all.join("; ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_number_tells_the_range() {
        for (colors, want) in [
            ([0.5, 0.25, 0.75], None),
            ([127.5, 63.75, 191.25], Some("they are above 1: 255 is taken as 1")),
            ([32767.5, 16383.75, 49151.25], Some("they are above 1: 65535 is taken as 1")),
        ] {
            let mut alone = [Vec3::from_array(colors)];
            assert_eq!(decode(&mut alone), want.map(|text| format!("colours of vertices: {text}")));
            let mut all = [Vec3::from_array(colors), Vec3::new(f32::NAN, -3.0, 0.0)];
            let note = decode(&mut all).expect("a line");
            assert!(note.contains("1 with negative") && want.is_none_or(|text| note.contains(text)), "{note}");
            assert_eq!(all[1], Vec3::ZERO);
            assert!((all[0] - Vec3::new(0.21404, 0.05088, 0.52252)).length() < 1e-4, "{}", all[0]);
        }
    }

    #[test]
    fn fractions_a_little_above_one_are_cut() {
        let mut all = [Vec3::new(0.5, 1.02, 0.0), Vec3::new(f32::NAN, -3.0, 9.0)];
        let note = decode(&mut all).expect("a line");
        assert!(note.contains("above 1 are cut") && note.contains("1 with negative"), "{note}");
        assert!((all[0] - Vec3::new(0.21404, 1.0, 0.0)).length() < 1e-4);
        assert_eq!([all[1].x, all[1].y], [0.0; 2]);
        // Whole numbers are bytes, as dark as they are.
        let mut dark = [Vec3::new(2.0, 1.0, 0.0)];
        assert!(decode(&mut dark).is_some() && dark[0].max_element() < 0.01);
    }
}
