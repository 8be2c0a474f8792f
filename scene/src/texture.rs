use glam::Vec2;
use std::sync::{Arc, LazyLock};

/// How the numbers of an image are meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// Colours: IEC 61966-2-1. Alpha is linear.
    Srgb,
    /// Numbers: value/255.
    Linear,
}

/// What lies outside [0, 1]².
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// The image again.
    #[default]
    Repeat,
    /// The image mirrored.
    Mirror,
    /// Its edge.
    Clamp,
}

/// An image as surfaces show it: 8 bits a channel, with the pyramid of its means, each half as large as the one before.
///
/// Texture coordinates have their origin at the upper left corner, v downward, as in glTF. Copies share the texels.
///
/// # Cost
/// 5.3 bytes a texel. A lookup: docs/materials.md.
#[derive(Clone)]
pub struct Texture {
    name: Arc<str>,
    encoding: Encoding,
    levels: Arc<[Level]>,
}

/// Red, green, blue, alpha.
pub(crate) type Texel = [u8; 4];

struct Level {
    size: [usize; 2],
    texels: Vec<Texel>,
}

/// The most taps of a lookup along a footprint that is longer than wide.
const MOST_TAPS: f32 = 8.0;

impl Texture {
    /// The largest width and height.
    pub const MAX_SIDE: u32 = 16384;

    /// From rows of texels, the upper one first. The name is for messages.
    ///
    /// # Panics
    /// When there are not width × height texels, or none.
    ///
    /// ```
    /// use scene::{Encoding, Texture, Wrap};
    /// let half = Texture::new("half", [2, 1], vec![[0, 0, 0, 255], [255; 4]], Encoding::Linear);
    /// // Seen from far: the mean.
    /// let far = half.sample(glam::Vec2::ZERO, [glam::Vec2::X, glam::Vec2::Y], [Wrap::Repeat; 2], false);
    /// assert!((far[0] - 0.5).abs() < 0.01);
    /// ```
    #[must_use]
    pub fn new(name: &str, size: [u32; 2], texels: Vec<Texel>, encoding: Encoding) -> Self {
        let size = size.map(|n| n as usize);
        assert!(!texels.is_empty() && texels.len() == size[0] * size[1], "width times height texels");
        let mut levels = vec![Level { size, texels }];
        while let Some(next) = levels[levels.len() - 1].half(encoding) {
            levels.push(next);
        }
        Self { name: name.into(), encoding, levels: levels.into() }
    }

    /// What messages call it.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Width and height.
    #[must_use]
    pub fn size(&self) -> [usize; 2] {
        self.levels[0].size
    }

    /// The texels, row after row from the top.
    pub(crate) fn texels(&self) -> &[Texel] {
        &self.levels[0].texels
    }

    /// Bytes of all levels.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.levels.iter().map(|level| size_of::<Texel>() * level.texels.len()).sum()
    }

    /// How its numbers are meant.
    #[must_use]
    pub const fn encoding(&self) -> Encoding {
        self.encoding
    }

    /// Whether both are one image in memory.
    #[must_use]
    pub fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.levels, &other.levels)
    }

    /// The mean over a footprint: a parallelogram of these two sides about `uv`. Linear red, green and blue, and alpha, in [0, 1]; the
    /// upper left texel where `uv` is not finite.
    ///
    /// Trilinear in the pyramid, by up to eight taps along a footprint longer than wide; where texels are larger than the
    /// footprint, bilinear, or the nearest one if `is_pixelated`.
    #[must_use]
    pub fn sample(&self, uv: Vec2, footprint: [Vec2; 2], wrap: [Wrap; 2], is_pixelated: bool) -> [f32; 4] {
        if !uv.is_finite() {
            return self.decode(self.levels[0].texels[0]);
        }
        let size = Vec2::new(self.size()[0] as f32, self.size()[1] as f32);
        let [a, b] = footprint.map(|side| (side * size).length_squared());
        let (major, long, short) = if a > b { (footprint[0], a, b) } else { (footprint[1], b, a) };
        // Footprints that are not finite see all of the image.
        let long = if long.is_finite() { long.sqrt() } else { f32::MAX };
        if long <= 1.0 {
            let level = &self.levels[0];
            return if is_pixelated { self.nearest(level, uv, wrap) } else { self.bilinear(level, uv, wrap) };
        }
        let taps = (long / short.sqrt().max(1.0)).clamp(1.0, MOST_TAPS).ceil();
        let level = (long / taps).max(1.0).log2().min((self.levels.len() - 1) as f32);
        let (first, t) = (level as usize, level.fract());
        let mut sum = [0.0; 4];
        let mut add = |value: [f32; 4], weight: f32| sum.iter_mut().zip(value).for_each(|(s, v)| *s += weight * v);
        for k in 0..taps as u32 {
            let place = (k as f32 + 0.5) / taps - 0.5;
            let uv = if taps > 1.0 && major.is_finite() { uv + major * place } else { uv };
            add(self.bilinear(&self.levels[first], uv, wrap), (1.0 - t) / taps);
            if t > 0.0 {
                add(self.bilinear(&self.levels[first + 1], uv, wrap), t / taps);
            }
        }
        sum
    }

    fn decode(&self, [r, g, b, a]: Texel) -> [f32; 4] {
        let table = match self.encoding {
            Encoding::Srgb => &DECODED.srgb,
            Encoding::Linear => &DECODED.linear,
        };
        [table[r as usize], table[g as usize], table[b as usize], DECODED.linear[a as usize]]
    }

    fn nearest(&self, level: &Level, uv: Vec2, wrap: [Wrap; 2]) -> [f32; 4] {
        let [x, y] = [0, 1].map(|k| {
            let n = level.size[k];
            ((fold(uv[k], wrap[k]) * n as f32) as usize).min(n - 1)
        });
        self.decode(level.texels[y * level.size[0] + x])
    }

    fn bilinear(&self, level: &Level, uv: Vec2, wrap: [Wrap; 2]) -> [f32; 4] {
        let [(x0, x1, s), (y0, y1, t)] = [0, 1].map(|k| neighbours(fold(uv[k], wrap[k]), level.size[k], wrap[k]));
        let texel = |x: usize, y: usize| self.decode(level.texels[y * level.size[0] + x]);
        let [a, b, c, d] = [texel(x0, y0), texel(x1, y0), texel(x0, y1), texel(x1, y1)];
        core::array::from_fn(|k| {
            let (upper, lower) = (a[k] + (b[k] - a[k]) * s, c[k] + (d[k] - c[k]) * s);
            upper + (lower - upper) * t
        })
    }
}

impl PartialEq for Texture {
    fn eq(&self, other: &Self) -> bool {
        self.is_same(other)
            || self.encoding == other.encoding
                && self.size() == other.size()
                && self.levels[0].texels == other.levels[0].texels
    }
}

impl core::fmt::Debug for Texture {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let [width, height] = self.size();
        // Checkpoints compare scenes by this text.
        let sum = self.levels[0]
            .texels
            .iter()
            .fold(0u64, |sum, t| sum.wrapping_mul(0x0100_0000_01b3).wrapping_add(u32::from_le_bytes(*t).into()));
        write!(f, "Texture({:?}, {width}x{height}, {:?}, {sum:x})", self.name, self.encoding)
    }
}

/// A coordinate within [0, 1].
fn fold(u: f32, wrap: Wrap) -> f32 {
    match wrap {
        Wrap::Repeat => u - u.floor(),
        Wrap::Mirror => {
            let t = u - 2.0 * (0.5 * u).floor();
            if t > 1.0 { 2.0 - t } else { t }
        }
        Wrap::Clamp => u.clamp(0.0, 1.0),
    }
}

/// The texels before and after a folded coordinate, and the second one's weight.
fn neighbours(u: f32, n: usize, wrap: Wrap) -> (usize, usize, f32) {
    let at = u * n as f32 - 0.5;
    let floor = at.floor();
    let t = at - floor;
    let last = n - 1;
    if floor < 0.0 {
        return (if wrap == Wrap::Repeat { last } else { 0 }, 0, t);
    }
    let first = (floor as usize).min(last);
    let next = match (first == last, wrap) {
        (false, _) => first + 1,
        (true, Wrap::Repeat) => 0,
        (true, _) => last,
    };
    (first, next, t)
}

impl Level {
    /// The level half as large, at least one texel a side; none after that of one texel.
    fn half(&self, encoding: Encoding) -> Option<Self> {
        if self.texels.len() == 1 {
            return None;
        }
        let size = self.size.map(|n| (n / 2).max(1));
        let columns: Vec<_> = (0..size[0]).map(|x| covered(x, size[0], self.size[0])).collect();
        let table = if encoding == Encoding::Srgb { &DECODED.srgb } else { &DECODED.linear };
        let mut texels = Vec::with_capacity(size[0] * size[1]);
        for y in 0..size[1] {
            let (top, rows) = covered(y, size[1], self.size[1]);
            for (left, weights) in &columns {
                let mut sum = [0.0_f32; 4];
                for (dy, row) in rows.iter().enumerate().filter(|(_, w)| **w > 0.0) {
                    let line = &self.texels[(top + dy) * self.size[0]..];
                    for (dx, column) in weights.iter().enumerate().filter(|(_, w)| **w > 0.0) {
                        let [r, g, b, a] = line[left + dx];
                        let weight = row * column;
                        sum[0] += weight * table[r as usize];
                        sum[1] += weight * table[g as usize];
                        sum[2] += weight * table[b as usize];
                        sum[3] += weight * DECODED.linear[a as usize];
                    }
                }
                let byte = |x: f32| (x * 255.0 + 0.5) as u8;
                let color = |x: f32| if encoding == Encoding::Srgb { DECODED.encoded(x) } else { byte(x) };
                texels.push([color(sum[0]), color(sum[1]), color(sum[2]), byte(sum[3])]);
            }
        }
        Some(Self { size, texels })
    }
}

/// Which texels a texel of the level below covers: the first, and the weights of three, of sum 1.
fn covered(at: usize, n: usize, of: usize) -> (usize, [f32; 3]) {
    let step = of as f64 / n as f64;
    let (begin, end) = (at as f64 * step, (at + 1) as f64 * step);
    let first = begin as usize;
    let weight = |k: usize| {
        let texel = (first + k) as f64;
        (((texel + 1.0).min(end) - texel.max(begin)).max(0.0) / step) as f32
    };
    // What rounding leaves of a texel beyond the last is none.
    let weights = core::array::from_fn(|k| if first + k < of { weight(k) } else { 0.0 });
    (first, weights)
}

struct Decoded {
    srgb: [f32; 256],
    linear: [f32; 256],
    encoded: Vec<u8>,
}

impl Decoded {
    /// The byte of a linear value; at most one off.
    fn encoded(&self, x: f32) -> u8 {
        self.encoded[((x * (self.encoded.len() - 1) as f32 + 0.5) as usize).min(self.encoded.len() - 1)]
    }
}

static DECODED: LazyLock<Decoded> = LazyLock::new(|| {
    let encode = |x: f64| if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
    let steps = 1 << 14;
    Decoded {
        srgb: core::array::from_fn(|i| srgb_decoded(i as f32 / 255.0)),
        linear: core::array::from_fn(|i| i as f32 / 255.0),
        encoded: (0..=steps).map(|i| (encode(f64::from(i) / f64::from(steps)) * 255.0 + 0.5) as u8).collect(),
    }
});

/// Linear value of an sRGB one in [0, 1].
pub(crate) fn srgb_decoded(x: f32) -> f32 {
    let x = f64::from(x);
    (if x <= 0.040_45 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }) as f32
}
