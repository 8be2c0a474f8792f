//! OpenEXR pictures whose colours are not in channels R, G and B: one grey channel, or the colours of one layer.

use exr::error::Error;
use exr::meta::MetaData;
use exr::meta::header::Header;
use exr::prelude::{ReadChannels, ReadLayers, ReadSpecificChannel, Vec2, read};
use glam::{UVec2, Vec3};
use std::io::Cursor;

/// The first bytes of the format.
const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];
/// The most channels that a message names.
const MOST_NAMED: usize = 12;
const EXPECTED: &str = "expected R, G and B, one channel of grey, or one layer with R, G and B";

/// The channels that are a picture, in the first part that has them.
#[derive(Clone, Debug, PartialEq)]
enum Channels {
    Grey(String),
    Colors([String; 3]),
}

/// A picture that is not read yet.
pub(crate) struct ExrChannels<'b> {
    bytes: &'b [u8],
    channels: Channels,
    /// Where the display window begins, and its size.
    window: (Vec2<i32>, Vec2<usize>),
    /// Where the part's own pixels begin.
    first: Vec2<i32>,
}

impl<'b> ExrChannels<'b> {
    /// `None` for files of other formats and for those with bare channels R, G and B, which any decoder reads.
    ///
    /// # Errors
    /// Why the file is no picture, in one line.
    pub(crate) fn find(bytes: &'b [u8]) -> Result<Option<Self>, String> {
        let Some(meta) = read_meta(bytes)? else { return Ok(None) };
        let flat: Vec<&Header> = meta.headers.iter().filter(|header| !header.deep).collect();
        let names: Vec<Vec<String>> = flat.iter().map(|header| names(header)).collect();
        if flat.is_empty() {
            return Err(format!("its pixels are deep: {EXPECTED}"));
        }
        let Some((part, channels)) = choose(&names)? else { return Ok(None) };
        if flat[part].channels.list.iter().any(|channel| channel.sampling != Vec2(1, 1)) {
            return Err(subsampled());
        }
        let window = flat[part].shared_attributes.display_window;
        let first = flat[part].own_attributes.layer_position;
        Ok(Some(Self { bytes, channels, window: (window.position, window.size), first }))
    }

    pub(crate) fn size(&self) -> UVec2 {
        UVec2::new(self.window.1.width() as u32, self.window.1.height() as u32)
    }

    /// The colours in the display window, black where the file has none.
    pub(crate) fn read(&self) -> Result<Vec<Vec3>, String> {
        let (from, size) = self.window;
        let shift = self.first - from;
        let put = move |pixels: &mut Vec<Vec3>, at: Vec2<usize>, color: Vec3| {
            let at = at.to_i32() + shift;
            let inside = |at: i32, size: usize| usize::try_from(at).ok().filter(|at| *at < size);
            if let (Some(x), Some(y)) = (inside(at.x(), size.width()), inside(at.y(), size.height())) {
                pixels[y * size.width() + x] = color;
            }
        };
        let black = vec![Vec3::ZERO; size.area()];
        let (flat, bytes) =
            (read().no_deep_data().largest_resolution_level().specific_channels(), Cursor::new(self.bytes));
        let read = match &self.channels {
            Channels::Grey(name) => flat
                .required(name.as_str())
                .collect_pixels(
                    |_, _| black.clone(),
                    move |pixels, at, (grey,): (f32,)| put(pixels, at, Vec3::splat(grey)),
                )
                .first_valid_layer()
                .all_attributes()
                .from_buffered(bytes)
                .map(|image| image.layer_data.channel_data.pixels),
            Channels::Colors([r, g, b]) => flat
                .required(r.as_str())
                .required(g.as_str())
                .required(b.as_str())
                .collect_pixels(
                    |_, _| black.clone(),
                    move |pixels, at, color: (f32, f32, f32)| put(pixels, at, Vec3::from(color)),
                )
                .first_valid_layer()
                .all_attributes()
                .from_buffered(bytes)
                .map(|image| image.layer_data.channel_data.pixels),
        };
        read.map_err(|e| format!("not a readable OpenEXR file: {e}"))
    }
}

/// The headers of a file; `None` for other formats.
///
/// # Errors
/// Why they cannot be read, in one line.
pub(crate) fn read_meta(bytes: &[u8]) -> Result<Option<MetaData>, String> {
    if !bytes.starts_with(&MAGIC) {
        return Ok(None);
    }
    let fault = |e| match e {
        Error::NotSupported(_) => subsampled(),
        e => format!("not a readable OpenEXR file: {e}"),
    };
    MetaData::read_from_buffered(Cursor::new(bytes), false).map(Some).map_err(fault)
}

fn subsampled() -> String {
    format!(
        "its channels differ in resolution, as luminance and chroma do, or are of a kind that is not read: {EXPECTED}"
    )
}

fn names(header: &Header) -> Vec<String> {
    header.channels.list.iter().map(|channel| channel.name.to_string()).collect()
}

/// The part and the channels that are the picture; `None` for bare channels R, G and B.
fn choose(parts: &[Vec<String>]) -> Result<Option<(usize, Channels)>, String> {
    let of_layer = |names: &[String], layer: &str| {
        let channels = ["R", "G", "B"].map(|letter| format!("{layer}{letter}"));
        channels.iter().all(|channel| names.contains(channel)).then_some(channels)
    };
    if parts.iter().any(|names| of_layer(names, "").is_some()) {
        return Ok(None);
    }
    // Of alpha and of depth, by the format's names.
    let is_no_light = |name: &str| ["A", "Z", "ZBack"].contains(&name.rsplit('.').next().unwrap_or(name));
    let colors = |names: &'_ [String]| names.iter().filter(|name| !is_no_light(name)).cloned().collect::<Vec<_>>();
    if let [names] = parts
        && let [grey] = &colors(names)[..]
    {
        return Ok(Some((0, Channels::Grey(grey.clone()))));
    }
    let mut layers = Vec::new();
    for (part, names) in parts.iter().enumerate() {
        for layer in names.iter().filter_map(|name| name.strip_suffix('R')) {
            layers.extend(of_layer(names, layer).map(|channels| (part, Channels::Colors(channels))));
        }
    }
    if let [_] = layers[..] {
        return Ok(layers.pop());
    }
    let all: Vec<&String> = parts.iter().flatten().collect();
    let more = if all.len() > MOST_NAMED { format!(" and {} more", all.len() - MOST_NAMED) } else { String::new() };
    let named = all.iter().take(MOST_NAMED).map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(", ");
    Err(format!("has the channels {named}{more}: {EXPECTED}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use exr::prelude::{AnyChannel, AnyChannels, FlatSamples, Image, WritableImage};

    /// A file of 2 × 1 pixels; each channel has its number, from 1, in the left pixel, and ten times that in the other one.
    fn file(channels: &[&str]) -> Vec<u8> {
        let samples = |k: usize| FlatSamples::F32(vec![k as f32 + 1.0, 10.0 * (k as f32 + 1.0)]);
        let channels = channels.iter().enumerate().map(|(k, name)| AnyChannel::new(*name, samples(k)));
        let mut bytes = Cursor::new(Vec::new());
        let image = Image::from_channels((2, 1), AnyChannels::sort(channels.collect()));
        image.write().to_buffered(&mut bytes).expect("a file in memory");
        bytes.into_inner()
    }

    #[test]
    fn grey_channels_and_single_layers_are_pictures() {
        let read = |channels: &[&str]| {
            let bytes = file(channels);
            let found = ExrChannels::find(&bytes).expect("a picture").expect("no bare colours");
            assert_eq!(found.size(), UVec2::new(2, 1));
            found.read().expect("pixels")
        };
        for grey in [&["Y"][..], &["G"], &["Y", "A"], &["Y", "Z", "ZBack"], &["sky.Y"]] {
            assert_eq!(read(grey), [Vec3::ONE, Vec3::splat(10.0)], "{grey:?}");
        }
        let layer = ["beauty.R", "beauty.G", "beauty.B", "beauty.A", "depth.Z"];
        assert_eq!(read(&layer), [Vec3::new(1.0, 2.0, 3.0), Vec3::new(10.0, 20.0, 30.0)]);
        assert!(ExrChannels::find(&file(&["R", "G", "B", "Z"])).is_ok_and(|found| found.is_none()));
        assert!(ExrChannels::find(b"\x89PNG").is_ok_and(|found| found.is_none()));
    }

    #[test]
    fn others_are_refused_by_the_names_of_their_channels() {
        let told = |channels: &[&str]| ExrChannels::find(&file(channels)).map(|_| ()).expect_err("no picture");
        assert!(told(&["Y", "RY", "BY"]).starts_with("has the channels \"BY\", \"RY\", \"Y\": expected R, G and B"));
        assert!(told(&["Z"]).starts_with("has the channels \"Z\": ") && told(&["main.A"]).contains("main.A"));
        let two = ["a.R", "a.G", "a.B", "b.R", "b.G", "b.B"];
        assert!(told(&two).contains("\"a.R\", \"b.B\"") && !told(&two).contains('\n'), "{}", told(&two));
        let many: Vec<String> = (0..20).map(|k| format!("c{k:02}")).collect();
        assert!(told(&many.iter().map(String::as_str).collect::<Vec<_>>()).contains("\"c11\" and 8 more: expected"));
    }

    /// Headers whose channels have less resolution, as programs write luminance and chroma.
    #[test]
    fn channels_of_less_resolution_are_told() {
        let told = |channels: &[&str]| {
            let mut bytes = file(channels);
            let name = [channels[0].as_bytes(), b"\0"].concat();
            let at = bytes.windows(name.len()).position(|part| part == name).expect("a channel") + name.len();
            // Behind the type and four more bytes the samplings along x and y.
            bytes[at + 8] = 2;
            ExrChannels::find(&bytes).map(|_| ()).expect_err("subsampled")
        };
        assert!(told(&["GREY"]).starts_with("its channels differ in resolution"), "{}", told(&["GREY"]));
        assert!(told(&["BY", "RY", "Y"]).contains("expected R, G and B, one channel of grey"));
    }
}
