use crate::stamp::STAMP;
use crate::{ImageFileError, Output, PngDepth};
use png::{BitDepth, ColorType, Encoder, EncodingError, Writer};
use std::io::Write;

/// The writer of an RGB file, its header written.
pub(crate) fn encoder<W: Write>(
    file: W,
    width: usize,
    height: usize,
    depth: PngDepth,
    stamp: Option<String>,
) -> Result<Writer<W>, EncodingError> {
    let mut encoder = Encoder::new(file, width as u32, height as u32);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(match depth {
        PngDepth::Eight => BitDepth::Eight,
        PngDepth::Sixteen => BitDepth::Sixteen,
    });
    if let Some(stamp) = stamp {
        encoder.add_text_chunk(STAMP.to_owned(), stamp)?;
    }
    encoder.write_header()
}

/// A PNG file in memory, of RGB bytes, three a pixel.
///
/// # Errors
/// When there are not three bytes a pixel, or no pixels.
pub fn png_bytes(width: usize, height: usize, rgb: &[u8]) -> Result<Vec<u8>, EncodingError> {
    let mut out = Vec::new();
    let mut writer = encoder(&mut out, width, height, PngDepth::Eight, None)?;
    writer.write_image_data(rgb)?;
    writer.finish()?;
    Ok(out)
}

/// Writes RGB bytes, three a pixel, as a PNG file.
///
/// # Errors
/// When the disk refuses.
pub fn write_png(output: Output, width: usize, height: usize, rgb: &[u8]) -> Result<(), ImageFileError> {
    let (path, stamp) = (output.path().to_owned(), output.stamp().map(str::to_owned));
    let encode = |file: &mut dyn Write| -> Result<(), EncodingError> {
        // The same chunks as a picture that is written band by band.
        let mut writer = encoder(file, width, height, PngDepth::Eight, stamp)?;
        let mut rows = writer.stream_writer()?;
        rows.write_all(rgb)?;
        rows.finish()?;
        writer.finish()
    };
    output.finish(|file| encode(file).map_err(|e| ImageFileError::format(&path, e.to_string())))
}
