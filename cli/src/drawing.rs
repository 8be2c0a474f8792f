//! Colours and fonts for plots and sheets of pictures.

use crate::failure::Failure;
use cosine_lobes::Picture;
use glam::Vec3;
use plotters::style::{FontStyle, RGBColor, register_font};

/// One colour a curve; people who see no red or green can tell them apart as well (M. Okabe, K. Ito).
pub(crate) const COLORS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(120, 120, 120),
];

/// Makes text drawable without fonts of the system.
pub(crate) fn font() -> Result<(), Failure> {
    register_font("sans-serif", FontStyle::Normal, epaint_default_fonts::UBUNTU_LIGHT)
        .map_err(|_| Failure::new("the built-in font cannot be read"))
}

/// The picture with `factor`² pixels averaged to one.
pub(crate) fn smaller(picture: &Picture, factor: usize) -> Picture {
    let (width, height) = (picture.width() / factor, picture.height() / factor);
    let at = |i: usize| {
        let (x, y) = (i % width * factor, i / width * factor);
        let block = (0..factor * factor).map(|k| picture.pixels()[(y + k / factor) * picture.width() + x + k % factor]);
        block.sum::<Vec3>() / (factor * factor) as f32
    };
    Picture::new(width, height, (0..width * height).map(at).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_are_averaged() {
        let picture = Picture::new(5, 2, (0..10).map(|i| Vec3::splat(i as f32)).collect());
        assert_eq!(smaller(&picture, 2).pixels(), [Vec3::splat(3.0), Vec3::splat(5.0)]);
    }
}
