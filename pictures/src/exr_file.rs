//! Pictures in OpenEXR files: whole ones written by layers, and one layer read by its name.

use crate::exr_open::open;
use crate::{ExrLayer, ExrPart, ImageFileError, Output, Picture, Window};
use exr::prelude::{ReadChannels, ReadLayers, Vec2, read};
use glam::Vec3;
use std::path::Path;

/// The layer whose channels carry no prefix, so that every viewer shows it.
const MAIN: &str = "beauty";

/// Writes layers as one OpenEXR part of 32-bit floats in scan lines, ZIP-compressed; the same bytes for the same
/// values.
///
/// # Errors
/// When the disk refuses.
///
/// # Panics
/// When a channel has not `width`·`height` values.
pub fn write_exr(output: Output, width: usize, height: usize, layers: &[ExrLayer]) -> Result<(), ImageFileError> {
    ExrPart::of_layers(Window::whole(width, height), layers).write(output)
}

/// Reads the picture of an OpenEXR file: its bare R, G, B channels, or those of the layer `beauty`.
///
/// # Errors
/// When the file cannot be read, is damaged, or has no such channels.
pub fn read_exr(path: &Path) -> Result<Picture, ImageFileError> {
    read_exr_layer(path, MAIN)?.ok_or_else(|| {
        ImageFileError::format(path, "no R, G, B channels found, neither bare nor in a layer named beauty")
    })
}

/// Reads a layer of R, G, B channels, half, float or integer, by its name: a prefix of the channels' names or the name
/// of a part of the file. `None` when the file has no such layer. `beauty` also finds bare channels; further channels
/// such as alpha are ignored.
///
/// # Errors
/// When the file cannot be read or is damaged.
pub fn read_exr_layer(path: &Path, name: &str) -> Result<Option<Picture>, ImageFileError> {
    let damaged = |e: exr::error::Error| match e {
        exr::error::Error::Io(e) if e.kind() != std::io::ErrorKind::UnexpectedEof => ImageFileError::io(path, e),
        e => ImageFileError::format(path, format!("not a readable OpenEXR file: {e}")),
    };
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .non_parallel()
        .from_buffered(open(path)?)
        .map_err(damaged)?;

    // A part of that name first; then prefixed channels; then, for the main picture, bare ones of any part.
    let named = |part: &str| (part.eq_ignore_ascii_case(name), String::new());
    for layer in &image.layer_data {
        let part = layer.attributes.layer_name.as_ref().map(ToString::to_string).unwrap_or_default();
        let mut prefixes = vec![(true, format!("{name}."))];
        prefixes.insert(0, named(&part));
        prefixes.push((name == MAIN, String::new()));
        for (_, prefix) in prefixes.iter().filter(|(applies, _)| *applies) {
            let find = |letter: &str| {
                layer.channel_data.list.iter().find(|c| c.name.to_string() == format!("{prefix}{letter}"))
            };
            let (Some(r), Some(g), Some(b)) = (find("R"), find("G"), find("B")) else { continue };
            let (width, height) = (layer.size.width(), layer.size.height());
            if [r, g, b].iter().any(|c| c.sampling != Vec2(1, 1) || c.sample_data.len() != width * height) {
                return Err(ImageFileError::format(path, "subsampled channels are not supported"));
            }
            let values = r.sample_data.values_as_f32().zip(g.sample_data.values_as_f32());
            let pixels = values.zip(b.sample_data.values_as_f32()).map(|((r, g), b)| Vec3::new(r, g, b));
            return Ok(Some(Picture::new(width, height, pixels.collect())));
        }
    }
    Ok(None)
}

#[cfg(test)]
mod tests {
    use super::*;
    use exr::prelude::{
        AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, WritableImage, f16,
    };
    use std::path::PathBuf;

    fn ramp(scale: f32) -> Vec<Vec3> {
        (0..6).map(|i| Vec3::new(i as f32, 0.1, -3.0) * scale).collect()
    }

    fn write(path: &Path) {
        let layers = [
            ExrLayer::color("beauty", &ramp(1.0)),
            ExrLayer::color("unshadowed", &ramp(2.0)),
            ExrLayer::scalar("depth", 'Z', vec![1.0; 6]),
        ];
        write_exr(Output::create(path).unwrap(), 3, 2, &layers).unwrap();
    }

    #[test]
    fn layers_come_back_and_bytes_repeat() {
        let folder = tempfile::tempdir().unwrap();
        let (a, b) = (folder.path().join("a.exr"), folder.path().join("b.exr"));
        write(&a);
        write(&b);
        assert_eq!(std::fs::read(&a).unwrap(), std::fs::read(&b).unwrap());
        assert_eq!(read_exr(&a).unwrap(), Picture::new(3, 2, ramp(1.0)));
        assert_eq!(read_exr_layer(&a, "unshadowed").unwrap(), Some(Picture::new(3, 2, ramp(2.0))));
        assert_eq!(read_exr_layer(&a, "light0").unwrap(), None);
    }

    /// A header may claim any size: no memory is reserved that the file's own size does not justify.
    #[test]
    fn huge_sizes_in_small_files_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        write(&path);
        let mut bytes = std::fs::read(&path).unwrap();
        // The data window and the display window: two pairs of corners of 32 bits.
        for name in [&b"dataWindow\0box2i\0"[..], b"displayWindow\0box2i\0"] {
            let at = bytes.windows(name.len()).position(|part| part == name).unwrap() + name.len() + 4;
            for corner in [8, 12] {
                bytes[at + corner..at + corner + 4].copy_from_slice(&1_000_000_i32.to_le_bytes());
            }
        }
        std::fs::write(&path, bytes).unwrap();
        for error in [read_exr(&path).unwrap_err(), ExrPart::read(&path).unwrap_err()] {
            assert!(error.to_string().contains("MB of pixels in a file of"), "{error}");
        }
    }

    /// Half floats with alpha, and unsigned integers in a part named "beauty" that is not the first.
    #[test]
    fn other_sample_types_and_parts() {
        let folder = tempfile::tempdir().unwrap();
        let path = |n: &str| -> PathBuf { folder.path().join(n) };
        let half = |v: f32| FlatSamples::F16(vec![f16::from_f32(v); 2]);
        let channels = ["A", "B", "G", "R"].map(|n| AnyChannel::new(n, half(if n == "R" { 0.5 } else { 1.0 })));
        let image = Image::from_channels((2, 1), AnyChannels::sort(channels.into_iter().collect()));
        image.write().to_file(path("half.exr")).unwrap();
        let expected = Picture::new(2, 1, vec![Vec3::new(0.5, 1.0, 1.0); 2]);
        assert_eq!(read_exr(&path("half.exr")).unwrap(), expected);

        let part = |name: &str, letters: [&'static str; 3]| {
            let channels = letters.map(|n| AnyChannel::new(n, FlatSamples::U32(vec![7; 2])));
            Layer::new(
                (2, 1),
                LayerAttributes::named(name),
                Encoding::UNCOMPRESSED,
                AnyChannels::sort(channels.into_iter().collect()),
            )
        };
        let layers = vec![part("other", ["X", "Y", "Z"]), part("beauty", ["R", "G", "B"])];
        let size = exr::prelude::IntegerBounds::from_dimensions((2, 1));
        Image::from_layers(exr::prelude::ImageAttributes::new(size), layers).write().to_file(path("int.exr")).unwrap();
        assert_eq!(read_exr(&path("int.exr")).unwrap(), Picture::new(2, 1, vec![Vec3::splat(7.0); 2]));
    }

    #[test]
    fn damaged_files_are_errors() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        write(&path);
        let bytes = std::fs::read(&path).unwrap();
        for end in 0..bytes.len() {
            std::fs::write(&path, &bytes[..end]).unwrap();
            assert!(read_exr(&path).is_err(), "cut after {end} bytes");
        }
        std::fs::write(&path, b"no picture at all").unwrap();
        assert!(read_exr(&path).unwrap_err().to_string().contains("a.exr"));
        assert!(read_exr(folder.path()).is_err());
        assert!(read_exr(&folder.path().join("missing.exr")).is_err());
    }
}
