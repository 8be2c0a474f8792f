//! Pages as images: PNG with a scale, and OpenEXR of half floats.

use crate::BakeError;
use crate::page::State;
use exr::prelude::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, WritableImage, f16};
use glam::Vec3;
use pictures::{png_bytes, srgb, srgb_to_linear};
use std::io::Cursor;

/// The largest half float.
const HALF: f32 = 65504.0;

/// A page of one thing that is baked.
#[derive(Clone, Debug, PartialEq)]
pub struct Map {
    /// The end of its file's name, such as `lightmap0` or `lightmap0.light2`.
    pub name: String,
    /// Whether it is of one light, or one sky, and not of all.
    pub is_single: bool,
    /// Width and height in texels.
    pub size: [u32; 2],
    /// One value a texel, row by row from the top: irradiance in W·m⁻² per channel, or radiance in W·m⁻²·sr⁻¹.
    pub values: Vec<Vec3>,
    /// The value that is white in a PNG file.
    pub white: f32,
}

/// How an image stores numbers from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Curve {
    Linear,
    Srgb,
}

impl Map {
    /// A map whose white is the largest value of all channels, or 1 where all is black.
    pub(crate) fn whole(name: String, size: [u32; 2], values: Vec<Vec3>) -> Self {
        let most = values.iter().map(|v| v.max_element()).fold(0.0, f32::max);
        Self { name, is_single: false, size, values, white: if most > 0.0 { most } else { 1.0 } }
    }

    /// A map whose white cuts one of a thousand texels of surfaces, if the largest value is more than half as large again: eight bits of
    /// linear light would have few steps for all others beside a small lamp on a wall.
    pub(crate) fn cut(self, states: &[State]) -> Self {
        let on_surface = self.values.iter().zip(states).filter(|(_, state)| **state == State::Surface);
        let mut each: Vec<f32> = on_surface.map(|(value, _)| value.max_element()).collect();
        each.sort_unstable_by(f32::total_cmp);
        let place = (each.len() * 999).div_ceil(1000).saturating_sub(1);
        let most = each.get(place).copied().filter(|most| *most > 0.0);
        let white = most.filter(|most| 1.5 * most < self.white).unwrap_or(self.white);
        Self { white, ..self }
    }

    /// The number of texels of which a PNG file cuts a channel.
    #[must_use]
    pub fn cut_texels(&self) -> usize {
        self.values.iter().filter(|value| value.max_element() > self.white).count()
    }

    /// A PNG file of 8 bits a channel, of values over [`white`](Self::white).
    pub(crate) fn png(&self, curve: Curve) -> Result<Vec<u8>, BakeError> {
        let scale = 1.0 / self.white;
        let width = self.size[0] as usize;
        let byte = |place: usize, channel: usize| {
            let x = (self.values[place][channel] * scale).clamp(0.0, 1.0);
            dithered(x, curve, threshold(place % width, place / width))
        };
        let bytes: Vec<u8> = (0..3 * self.values.len()).map(|k| byte(k / 3, k % 3)).collect();
        png_bytes(width, self.size[1] as usize, &bytes).map_err(|e| BakeError::Image(format!("{}: {e}", self.name)))
    }

    /// The linear PNG file of a light map: texel times [`white`](Self::white) is the value, unless that is larger.
    ///
    /// # Errors
    /// [`BakeError::Image`].
    pub fn linear_png(&self) -> Result<Vec<u8>, BakeError> {
        self.png(Curve::Linear)
    }

    /// An OpenEXR file of half floats with the channels R, G and B; values above 65504 are stored as that.
    ///
    /// # Errors
    /// [`BakeError::Image`].
    pub fn exr(&self) -> Result<Vec<u8>, BakeError> {
        let channel = |name: &'static str, k: usize| {
            let half = |v: &Vec3| f16::from_f32(v[k].min(HALF));
            AnyChannel::new(name, FlatSamples::F16(self.values.iter().map(half).collect()))
        };
        let channels = AnyChannels::sort([channel("B", 2), channel("G", 1), channel("R", 0)].into_iter().collect());
        let size = self.size.map(|k| k as usize);
        let layer = Layer::new((size[0], size[1]), LayerAttributes::default(), Encoding::SMALL_LOSSLESS, channels);
        let mut out = Cursor::new(Vec::new());
        let written = Image::from_layer(layer).write().to_buffered(&mut out);
        written.map_err(|e| BakeError::Image(format!("{}: {e}", self.name)))?;
        Ok(out.into_inner())
    }
}

/// One of the two bytes beside a value, chosen so that the mean of decoded bytes over all thresholds from 0 to 1 is the value.
fn dithered(x: f32, curve: Curve, threshold: f32) -> u8 {
    let decode = |byte: f32| match curve {
        Curve::Linear => byte / 255.0,
        Curve::Srgb => srgb_to_linear(byte / 255.0),
    };
    let encoded = match curve {
        Curve::Linear => x,
        Curve::Srgb => srgb(x),
    };
    let below = (encoded * 255.0).floor().clamp(0.0, 254.0);
    let (low, high) = (decode(below), decode(below + 1.0));
    let part = (x - low) / (high - low);
    (below + if part > threshold { 1.0 } else { 0.0 }) as u8
}

/// A threshold in (0, 1) by place (Bayer's matrix of 8 × 8): any block of texels has them evenly.
fn threshold(x: usize, y: usize) -> f32 {
    let bit = |k: usize| (((x ^ y) >> k & 1) << (5 - 2 * k)) | ((y >> k & 1) << (4 - 2 * k));
    ((bit(0) | bit(1) | bit(2)) as f32 + 0.5) / 64.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(values: Vec<Vec3>, size: [u32; 2]) -> Map {
        Map::whole("map".to_owned(), size, values)
    }

    /// Blocks of 8 × 8 texels of one value have that mean once decoded, by both curves.
    #[test]
    fn means_survive_eight_bits() {
        for value in [0.0003, 0.01, 0.2, 0.777, 1.0] {
            for curve in [Curve::Linear, Curve::Srgb] {
                let mut values = vec![Vec3::splat(3.0 * value); 64];
                values[0] = Vec3::splat(3.0);
                let map = map(values, [8, 8]);
                assert_eq!(map.white, 3.0);
                let png = map.png(curve).unwrap();
                let mut reader = png::Decoder::new(Cursor::new(png)).read_info().unwrap();
                let mut bytes = vec![0; 192];
                reader.next_frame(&mut bytes).unwrap();
                let decode = |byte: &u8| match curve {
                    Curve::Linear => f32::from(*byte) / 255.0,
                    Curve::Srgb => srgb_to_linear(f32::from(*byte) / 255.0),
                };
                let mean = bytes[3..].iter().map(decode).sum::<f32>() / 189.0;
                let step = match curve {
                    Curve::Linear => 1.0 / 255.0,
                    Curve::Srgb => (srgb_to_linear((srgb(value) + 1.0 / 255.0).min(1.0)) - value).max(1e-5),
                };
                assert!((mean - value).abs() <= step / 32.0 + 1e-6, "{value} {curve:?} {mean}");
                assert_eq!(bytes[0], 255);
            }
        }
    }

    #[test]
    fn one_of_a_thousand_is_cut() {
        let mut values = vec![Vec3::ONE; 4000];
        (0..4).for_each(|k| values[k] = Vec3::splat(9.0));
        let states = vec![State::Surface; 4000];
        let cut = |values: &[Vec3]| map(values.to_vec(), [40, 100]).cut(&states);
        assert_eq!((cut(&values).white, cut(&values).cut_texels()), (1.0, 4));
        values[5] = Vec3::splat(9.0);
        assert_eq!((cut(&values).white, cut(&values).cut_texels()), (9.0, 0));
        assert_eq!(map(vec![Vec3::ZERO], [1, 1]).cut(&states).white, 1.0);
    }

    #[test]
    fn exr_holds_halves() {
        let map = map(vec![Vec3::new(0.5, 1.0, 70000.0), Vec3::ZERO], [2, 1]);
        let bytes = map.exr().unwrap();
        assert_eq!(bytes, map.exr().unwrap());
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        std::fs::write(&path, &bytes).unwrap();
        let image = exr::prelude::read_first_flat_layer_from_file(&path).unwrap();
        let channel = |name: &str| {
            let list = &image.layer_data.channel_data.list;
            let found = list.iter().find(|c| c.name.eq(name)).unwrap();
            assert!(matches!(found.sample_data, FlatSamples::F16(_)));
            found.sample_data.values_as_f32().collect::<Vec<f32>>()
        };
        assert_eq!([channel("R"), channel("G"), channel("B")], [[0.5, 0.0], [1.0, 0.0], [HALF, 0.0]]);
    }
}
