use crate::stamp::STAMP;
use crate::{ImageFileError, Output, Picture};
use png::{BitDepth, ColorType, Encoder, EncodingError, Writer};
use std::io::Write;

/// The sRGB transfer function (IEC 61966-2-1) of a linear value in [0, 1].
fn srgb(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// Eight-bit sRGB, three bytes a pixel, of the picture times `2^exposure`, clamped to [0, 1]; not a number is black.
#[must_use]
pub fn srgb_bytes(picture: &Picture, exposure: f32) -> Vec<u8> {
    picture.pixels().iter().flat_map(|p| p.to_array().map(|x| srgb_byte(x, exposure.exp2()))).collect()
}

fn srgb_byte(x: f32, gain: f32) -> u8 {
    (srgb((x * gain).clamp(0.0, 1.0)) * 255.0 + 0.5) as u8
}

/// Appends the bytes of pixels whose channels are apart.
pub(crate) fn srgb_row(r: &[f32], g: &[f32], b: &[f32], exposure: f32, out: &mut Vec<u8>) {
    let gain = exposure.exp2();
    for ((r, g), b) in r.iter().zip(g).zip(b) {
        out.extend([*r, *g, *b].map(|x| srgb_byte(x, gain)));
    }
}

/// The writer of an RGB file, its header written.
pub(crate) fn encoder<W: Write>(
    file: W,
    width: usize,
    height: usize,
    stamp: Option<String>,
) -> Result<Writer<W>, EncodingError> {
    let mut encoder = Encoder::new(file, width as u32, height as u32);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    if let Some(stamp) = stamp {
        encoder.add_text_chunk(STAMP.to_owned(), stamp)?;
    }
    encoder.write_header()
}

/// Writes RGB bytes, three a pixel, as a PNG file.
///
/// # Errors
/// When the disk refuses.
pub fn write_png(output: Output, width: usize, height: usize, rgb: &[u8]) -> Result<(), ImageFileError> {
    let (path, stamp) = (output.path().to_owned(), output.stamp().map(str::to_owned));
    let encode = |file: &mut dyn Write| -> Result<(), EncodingError> {
        // The same chunks as a picture that is written band by band.
        let mut writer = encoder(file, width, height, stamp)?;
        let mut rows = writer.stream_writer()?;
        rows.write_all(rgb)?;
        rows.finish()?;
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
