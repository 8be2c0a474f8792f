use crate::stamp::STAMP;
use crate::{ImageFileError, Output, Picture};
use png::{BitDepth, ColorType, Encoder, EncodingError};
use std::io::Write;

/// The sRGB transfer function (IEC 61966-2-1) of a linear value in [0, 1].
fn srgb(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// Eight-bit sRGB, three bytes a pixel, of the picture times `2^exposure`, clamped to [0, 1]; not a number is black.
#[must_use]
pub fn srgb_bytes(picture: &Picture, exposure: f32) -> Vec<u8> {
    let gain = exposure.exp2();
    let byte = |x: f32| (srgb((x * gain).clamp(0.0, 1.0)) * 255.0 + 0.5) as u8;
    picture.pixels().iter().flat_map(|p| p.to_array().map(byte)).collect()
}

/// Writes RGB bytes, three a pixel, as a PNG file.
///
/// # Errors
/// When the disk refuses.
pub fn write_png(output: Output, width: usize, height: usize, rgb: &[u8]) -> Result<(), ImageFileError> {
    let (path, stamp) = (output.path().to_owned(), output.stamp().map(str::to_owned));
    let encode = |file: &mut dyn Write| -> Result<(), EncodingError> {
        let mut encoder = Encoder::new(file, width as u32, height as u32);
        encoder.set_color(ColorType::Rgb);
        encoder.set_depth(BitDepth::Eight);
        if let Some(stamp) = stamp {
            encoder.add_text_chunk(STAMP.to_owned(), stamp)?;
        }
        let mut writer = encoder.write_header()?;
        writer.write_image_data(rgb)?;
        writer.finish()
    };
    output.finish(|file| encode(file).map_err(|e| ImageFileError::format(&path, e.to_string())))
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
}
