//! Images that surfaces show.

use crate::budget::Budget;
use crate::exr_channels::ExrChannels;
use crate::exr_colors::ExrColors;
use crate::hdr_header::HdrHeader;
use crate::height::Texel;
use glam::{UVec2, Vec3};
use image::{ColorType, DynamicImage, ImageDecoder, ImageError, ImageReader, Limits};
use scene::{Encoding, Texture};
use std::io::Cursor;

/// A file of so many bytes has no more pixels: flat images compress by a thousand.
const MOST_PIXELS_A_BYTE: u64 = 4096;
const MOST_PIXELS: u64 = 1 << 27;

/// Decodes PNG, JPEG, BMP or TGA (by `ending`, since that has no mark of its own); equal files once. 16 bits a channel become 8, grey is
/// all three channels, a missing alpha is 1.
pub(crate) fn decode(
    name: &str,
    ending: &str,
    bytes: &[u8],
    encoding: Encoding,
    budget: &Budget,
) -> Result<Texture, String> {
    let depth = if encoding == Encoding::Srgb { 2 } else { 1 };
    budget.texture(name, bytes, encoding, || {
        let image = read(name, ending, bytes, &Most { depth, ..MATERIAL }, budget)?;
        let size = [image.width(), image.height()];
        if matches!(image, DynamicImage::ImageLuma8(_) | DynamicImage::ImageLuma16(_)) {
            return Ok(Texture::grey(name, size, image.into_luma8().into_raw(), encoding));
        }
        Ok(Texture::new(name, size, colors(image), encoding))
    })
}

/// The same as rows of texels, from which a texture of numbers is made.
pub(crate) fn texels(
    name: &str,
    ending: &str,
    bytes: &[u8],
    budget: &Budget,
) -> Result<([u32; 2], Vec<Texel>), String> {
    let image = read(name, ending, bytes, &Most { meanwhile: 10, ..MATERIAL }, budget)?;
    Ok(([image.width(), image.height()], colors(image)))
}

fn colors(image: DynamicImage) -> Vec<Texel> {
    let image = image.into_rgba8();
    let (texels, _) = image.as_raw().as_chunks::<4>();
    texels.to_vec()
}

/// Decodes the same, Radiance HDR and OpenEXR to linear colours, the top row first: numbers of HDR as they are, those of EXR in the
/// colours that their header names, sRGB of the others. Appends a note for each word of a header that means something and is not read.
pub(crate) fn decode_linear(
    name: &str,
    ending: &str,
    bytes: &[u8],
    notes: &mut Vec<String>,
    budget: &Budget,
) -> Result<(UVec2, Vec<Vec3>), String> {
    let colors = ExrColors::read(bytes).map_err(|e| format!("image \"{name}\": {}", one_line(&e)))?;
    let (size, mut texels) = decode_numbers(name, ending, bytes, notes, budget)?;
    if let Some(colors) = colors {
        notes.extend(colors.convert(&mut texels).map(|note| format!("image \"{name}\": {note}")));
    }
    Ok((size, texels))
}

fn decode_numbers(
    name: &str,
    ending: &str,
    bytes: &[u8],
    notes: &mut Vec<String>,
    budget: &Budget,
) -> Result<(UVec2, Vec<Vec3>), String> {
    let formats = "HDR, EXR, PNG, JPEG, BMP or TGA";
    let most = Most { side: 16384, pixels: 25, formats, depth: 0, meanwhile: 12 };
    let fault = |e: String| format!("image \"{name}\": {}", one_line(&e));
    if let Some(picture) = ExrChannels::find(bytes).map_err(fault)? {
        let size = picture.size();
        most.check(name, size.to_array(), bytes.len())?;
        budget.take(0, u64::from(size.element_product()) * most.meanwhile, &described(name, size.to_array()))?;
        return Ok((size, picture.read().map_err(fault)?));
    }
    let radiance = HdrHeader::read(bytes).transpose().map_err(|e| format!("image \"{name}\": {e}"))?;
    let image = read(name, ending, radiance.as_ref().map_or(bytes, |(_, plain)| plain), &most, budget)?;
    let size = UVec2::new(image.width(), image.height());
    let is_linear = matches!(image, DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_));
    let image = image.into_rgb32f();
    let color = |c: &[f32; 3]| {
        if is_linear { Vec3::from_array(*c) } else { Vec3::from_array(c.map(|x| Encoding::Srgb.linear(x))) }
    };
    let (texels, _) = image.as_raw().as_chunks::<3>();
    let colors: Vec<Vec3> = texels.iter().map(color).collect();
    Ok(match radiance {
        Some((header, _)) => {
            let (size, colors, note) = header.radiance(colors);
            notes.extend(header.notes.iter().chain(&note).map(|note| format!("image \"{name}\": {note}")));
            (size, colors)
        }
        None => (size, colors),
    })
}

/// Limits of an image that is read: pixels along a side, and two to this power in all.
struct Most {
    side: u32,
    pixels: u32,
    formats: &'static str,
    /// Bytes of a channel of its texture; 0 where none stays.
    depth: u64,
    /// Bytes a pixel that are needed meanwhile.
    meanwhile: u64,
}

impl Most {
    /// Refuses images without pixels, larger ones, and those with more pixels than the number of bytes can hold.
    fn check(&self, name: &str, [width, height]: [u32; 2], bytes: usize) -> Result<(), String> {
        let pixels = u64::from(width) * u64::from(height);
        if pixels == 0 {
            return Err(format!("image \"{name}\": has no pixels"));
        }
        if width.max(height) > self.side || pixels > 1 << self.pixels {
            let Self { side, pixels, .. } = self;
            return Err(format!(
                "image \"{name}\": is {width}x{height}: at most {side} a side and 2^{pixels} in all are read"
            ));
        }
        if pixels > MOST_PIXELS_A_BYTE * (bytes as u64 + 16) {
            return Err(format!("image \"{name}\": says it is {width}x{height}, which {bytes} bytes cannot hold"));
        }
        Ok(())
    }
}

/// An image in messages about memory.
fn described(name: &str, [width, height]: [u32; 2]) -> String {
    format!("image \"{name}\" of {width} x {height}")
}

/// Images of surfaces.
const MATERIAL: Most =
    Most { side: Texture::MAX_SIDE, pixels: 27, formats: "PNG, JPEG, BMP or TGA", depth: 1, meanwhile: 4 };

fn read(name: &str, ending: &str, bytes: &[u8], most: &Most, budget: &Budget) -> Result<DynamicImage, String> {
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
    most.check(name, [width, height], bytes.len())?;
    let pixels = u64::from(width) * u64::from(height);
    let is_grey =
        matches!(decoder.color_type(), ColorType::L8 | ColorType::L16) && most.meanwhile == MATERIAL.meanwhile;
    let (channels, meanwhile) = if is_grey { (1, 1) } else { (4, most.meanwhile) };
    // A pyramid has a third more than its largest level.
    let kept = pixels * channels * most.depth * 4 / 3;
    budget.take(kept, pixels * meanwhile, &described(name, [width, height]))?;
    DynamicImage::from_decoder(decoder).map_err(fault)
}

/// Decoders' messages may have several.
fn one_line(message: &str) -> String {
    message.split_whitespace().collect::<Vec<_>>().join(" ")
}
