//! Images that surfaces show.

use crate::{Encoding, Texture};
use image::{DynamicImage, ImageDecoder, ImageError, ImageReader, Limits};
use std::io::Cursor;

/// A file of so many bytes has no more pixels: flat images compress by a thousand.
const MOST_PIXELS_A_BYTE: u64 = 4096;
const MOST_PIXELS: u64 = 1 << 27;

/// Decodes PNG, JPEG, BMP or TGA (by `ending`, since that has no mark of its own). 16 bits a channel become 8, grey is all three
/// channels, a missing alpha is 1.
pub(crate) fn decode(name: &str, ending: &str, bytes: &[u8], encoding: Encoding) -> Result<Texture, String> {
    let fault = |e: ImageError| format!("image \"{name}\": {}", one_line(&e.to_string()));
    let mut reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|e| e.to_string())?;
    if reader.format().is_none() && ending.eq_ignore_ascii_case("tga") {
        reader.set_format(image::ImageFormat::Tga);
    }
    if reader.format().is_none() {
        return Err(format!("image \"{name}\": unknown format: expected PNG, JPEG, BMP or TGA"));
    }
    let mut limits = Limits::default();
    limits.max_image_width = Some(Texture::MAX_SIDE);
    limits.max_image_height = Some(Texture::MAX_SIDE);
    limits.max_alloc = Some(8 * MOST_PIXELS);
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(fault)?;
    let (width, height) = decoder.dimensions();
    let pixels = u64::from(width) * u64::from(height);
    if pixels == 0 {
        return Err(format!("image \"{name}\": has no pixels"));
    }
    if width.max(height) > Texture::MAX_SIDE || pixels > MOST_PIXELS {
        let most = Texture::MAX_SIDE;
        return Err(format!("image \"{name}\": is {width}x{height}: at most {most} a side and 2^27 in all are read"));
    }
    if pixels > MOST_PIXELS_A_BYTE * (bytes.len() as u64 + 16) {
        return Err(format!("image \"{name}\": says it is {width}x{height}, which {} bytes cannot hold", bytes.len()));
    }
    let image = DynamicImage::from_decoder(decoder).map_err(fault)?.into_rgba8();
    let (texels, _) = image.as_raw().as_chunks::<4>();
    Ok(Texture::new(name, [width, height], texels.to_vec(), encoding))
}

/// Decoders' messages may have several.
fn one_line(message: &str) -> String {
    message.split_whitespace().collect::<Vec<_>>().join(" ")
}
