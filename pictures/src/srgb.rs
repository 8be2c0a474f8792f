//! Linear values to the bytes that screens show.

use crate::Picture;
use rayon::prelude::*;

/// The sRGB transfer function (IEC 61966-2-1) of a linear value in [0, 1].
#[must_use]
pub fn srgb(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// The linear value of an sRGB value in [0, 1]: the inverse of [`srgb`].
#[must_use]
pub fn srgb_to_linear(srgb: f32) -> f32 {
    if srgb <= 0.040_45 { srgb / 12.92 } else { ((srgb + 0.055) / 1.055).powf(2.4) }
}

/// Pixels that a thread takes at once.
const TASK: usize = 1 << 12;

/// Eight-bit sRGB, three bytes a pixel, of the picture times `2^exposure`, clamped to [0, 1] and rounded; not a number is black. For
/// figures and differences; [`Display`](crate::Display) shows pictures better. All cores work: about 40 ns a pixel and core.
///
/// ```
/// use glam::Vec3;
/// use pictures::{Picture, srgb_bytes};
/// let picture = Picture::new(2, 1, vec![Vec3::ONE, Vec3::splat(0.5)]);
/// assert_eq!(srgb_bytes(&picture, 0.0), [255, 255, 255, 188, 188, 188]);
/// ```
#[must_use]
pub fn srgb_bytes(picture: &Picture, exposure: f32) -> Vec<u8> {
    let gain = exposure.exp2();
    let mut bytes = vec![0; 3 * picture.pixels().len()];
    picture.pixels().par_chunks(TASK).zip(bytes.par_chunks_mut(3 * TASK)).for_each(|(pixels, bytes)| {
        for (pixel, bytes) in pixels.iter().zip(bytes.chunks_exact_mut(3)) {
            bytes.copy_from_slice(&pixel.to_array().map(|x| srgb_byte(x, gain)));
        }
    });
    bytes
}

fn srgb_byte(x: f32, gain: f32) -> u8 {
    (srgb((x * gain).clamp(0.0, 1.0)) * 255.0 + 0.5) as u8
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    /// Known pairs of the standard: linear 0.214 is 0.5 in sRGB, 0.0031308 is 0.04045.
    #[test]
    fn transfer_function() {
        assert!((srgb(0.214_041) - 0.5).abs() < 1e-5);
        assert!((srgb(0.003_130_8) - 0.040_45).abs() < 1e-5);
        let picture = Picture::new(2, 1, vec![Vec3::new(0.5, 1.0, 9.0), Vec3::new(-1.0, f32::NAN, 0.0)]);
        assert_eq!(srgb_bytes(&picture, 1.0), [255, 255, 255, 0, 0, 0]);
        assert_eq!(srgb_bytes(&picture, 0.0)[0], 188);
    }

    /// As one value after the other, over the ends of tasks.
    #[test]
    fn bytes_are_the_same_on_all_cores() {
        let pixel = |i: usize| Vec3::new(i as f32 / 5e3 - 0.1, (i % 257) as f32 / 256.0, 1.0 / (i + 1) as f32);
        let pixels: Vec<Vec3> = (0..2 * TASK + 77).map(pixel).collect();
        let exposure = 0.7_f32;
        let want: Vec<u8> = pixels.iter().flat_map(|p| p.to_array().map(|x| srgb_byte(x, exposure.exp2()))).collect();
        assert_eq!(srgb_bytes(&Picture::new(pixels.len(), 1, pixels), exposure), want);
    }
}
