//! Images that surfaces show.

use crate::texture::srgb_decoded;
use crate::texture_level::Texel;
use crate::{Encoding, Texture};
use glam::{UVec2, Vec3};
use image::{DynamicImage, ImageDecoder, ImageError, ImageReader, Limits};
use std::io::Cursor;

/// A file of so many bytes has no more pixels: flat images compress by a thousand.
const MOST_PIXELS_A_BYTE: u64 = 4096;
const MOST_PIXELS: u64 = 1 << 27;

/// Decodes PNG, JPEG, BMP or TGA (by `ending`, since that has no mark of its own). 16 bits a channel become 8, grey is all three
/// channels, a missing alpha is 1.
pub(crate) fn decode(name: &str, ending: &str, bytes: &[u8], encoding: Encoding) -> Result<Texture, String> {
    let (size, texels) = texels(name, ending, bytes)?;
    Ok(Texture::new(name, size, texels, encoding))
}

/// The same as rows of texels.
pub(crate) fn texels(name: &str, ending: &str, bytes: &[u8]) -> Result<([u32; 2], Vec<Texel>), String> {
    let most = Most { side: Texture::MAX_SIDE, pixels: 27, formats: "PNG, JPEG, BMP or TGA" };
    let image = read(name, ending, bytes, &most)?;
    let size = [image.width(), image.height()];
    let image = image.into_rgba8();
    let (texels, _) = image.as_raw().as_chunks::<4>();
    Ok((size, texels.to_vec()))
}

/// Decodes the same, Radiance HDR and OpenEXR to linear colours, the top row first: numbers as they are of the last two, sRGB of the
/// others.
pub(crate) fn decode_linear(name: &str, ending: &str, bytes: &[u8]) -> Result<(UVec2, Vec<Vec3>), String> {
    let most = Most { side: 16384, pixels: 25, formats: "HDR, EXR, PNG, JPEG, BMP or TGA" };
    let image = read(name, ending, bytes, &most)?;
    let size = UVec2::new(image.width(), image.height());
    let is_linear = matches!(image, DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_));
    let image = image.into_rgb32f();
    let color = |c: &[f32; 3]| if is_linear { Vec3::from_array(*c) } else { Vec3::from_array(c.map(srgb_decoded)) };
    let (texels, _) = image.as_raw().as_chunks::<3>();
    Ok((size, texels.iter().map(color).collect()))
}

/// Limits of an image that is read: pixels along a side, and two to this power in all.
struct Most {
    side: u32,
    pixels: u32,
    formats: &'static str,
}

fn read(name: &str, ending: &str, bytes: &[u8], most: &Most) -> Result<DynamicImage, String> {
    let fault = |e: ImageError| format!("image \"{name}\": {}", one_line(&e.to_string()));
    let mut reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|e| e.to_string())?;
    if reader.format().is_none() && ending.eq_ignore_ascii_case("tga") {
        reader.set_format(image::ImageFormat::Tga);
    }
    let is_float = matches!(reader.format(), Some(image::ImageFormat::Hdr | image::ImageFormat::OpenExr));
    if reader.format().is_none() || is_float && !most.formats.contains("HDR") {
        return Err(format!("image \"{name}\": unknown format: expected {}", most.formats));
    }
    let mut limits = Limits::default();
    limits.max_image_width = Some(most.side);
    limits.max_image_height = Some(most.side);
    limits.max_alloc = Some(8 * MOST_PIXELS);
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(fault)?;
    let (width, height) = decoder.dimensions();
    let pixels = u64::from(width) * u64::from(height);
    if pixels == 0 {
        return Err(format!("image \"{name}\": has no pixels"));
    }
    if width.max(height) > most.side || pixels > 1 << most.pixels {
        let Most { side, pixels, .. } = most;
        return Err(format!(
            "image \"{name}\": is {width}x{height}: at most {side} a side and 2^{pixels} in all are read"
        ));
    }
    if pixels > MOST_PIXELS_A_BYTE * (bytes.len() as u64 + 16) {
        return Err(format!("image \"{name}\": says it is {width}x{height}, which {} bytes cannot hold", bytes.len()));
    }
    DynamicImage::from_decoder(decoder).map_err(fault)
}

/// Decoders' messages may have several.
fn one_line(message: &str) -> String {
    message.split_whitespace().collect::<Vec<_>>().join(" ")
}
