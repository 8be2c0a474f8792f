use glam::{Vec2, Vec4};
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

/// Texels in blocks of 4 × 4, one line of the processor's cache each, row by row of blocks.
struct Level {
    size: [usize; 2],
    /// Blocks from one row of them to the next: odd, so that rows do not share places of the cache.
    stride: usize,
    texels: Vec<Texel>,
}

/// Texels row by row.
struct Rows {
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
        let mut rows = Rows { size, texels };
        let mut levels = vec![rows.blocks()];
        while let Some(next) = rows.half(encoding) {
            levels.push(next.blocks());
            rows = next;
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
    pub(crate) fn texels(&self) -> impl Iterator<Item = Texel> {
        let level = &self.levels[0];
        let [width, height] = level.size;
        (0..height).flat_map(move |y| (0..width).map(move |x| level.texels[level.place(x, y)]))
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
        let tables = self.encoding.tables();
        if !uv.is_finite() {
            return decode(tables, self.levels[0].texels[0]).to_array();
        }
        let size = Vec2::new(self.size()[0] as f32, self.size()[1] as f32);
        let (a, b) = ((footprint[0] * size).length_squared(), (footprint[1] * size).length_squared());
        let (major, long, short) = if a > b { (footprint[0], a, b) } else { (footprint[1], b, a) };
        // Footprints that are not finite see all of the image.
        let long = if long.is_finite() { long.sqrt() } else { f32::MAX };
        if long <= 1.0 {
            let level = &self.levels[0];
            let near = if is_pixelated { level.nearest(uv, wrap, tables) } else { level.bilinear(uv, wrap, tables) };
            return near.to_array();
        }
        let taps = (long / short.sqrt().max(1.0)).clamp(1.0, MOST_TAPS);
        let count = taps as u32 + u32::from(taps > (taps as u32) as f32);
        let place = log2((long / count as f32).max(1.0)).min((self.levels.len() - 1) as f32);
        let first = place as usize;
        let t = place - first as f32;
        let level = &self.levels[first];
        // Nearly on a level its neighbour is not worth a look.
        let next = self.levels.get(first + 1).filter(|_| t > 1.0 / 64.0);
        let along = if count > 1 && major.is_finite() { major / count as f32 } else { Vec2::ZERO };
        let mut at = uv - along * (0.5 * (count - 1) as f32);
        let mut sum = Vec4::ZERO;
        for _ in 0..count {
            let mut value = level.bilinear(at, wrap, tables);
            if let Some(next) = next {
                value += (next.bilinear(at, wrap, tables) - value) * t;
            }
            sum += value;
            at += along;
        }
        (sum / count as f32).to_array()
    }
}

/// The values of bytes: of colours, and of alpha.
type Tables = [&'static [f32; 256]; 2];

impl Encoding {
    fn tables(self) -> Tables {
        let decoded: &'static Decoded = &DECODED;
        match self {
            Self::Srgb => [&decoded.srgb, &decoded.linear],
            Self::Linear => [&decoded.linear; 2],
        }
    }
}

#[inline(always)]
fn decode([color, alpha]: Tables, [r, g, b, a]: Texel) -> Vec4 {
    Vec4::new(color[r as usize], color[g as usize], color[b as usize], alpha[a as usize])
}

/// Logarithm of a number from 1 on, exact at powers of two and up to 0.09 less between: levels are blended by it.
#[inline(always)]
fn log2(x: f32) -> f32 {
    (x.to_bits() as f32) / (1 << 23) as f32 - 127.0
}

/// `x.floor()`, without the call that it is on older processors.
#[inline(always)]
fn floor(x: f32) -> f32 {
    if x.abs() >= 8_388_608.0 {
        return x;
    }
    let whole = x as i32 as f32;
    if whole > x { whole - 1.0 } else { whole }
}

impl PartialEq for Texture {
    fn eq(&self, other: &Self) -> bool {
        self.is_same(other)
            || self.encoding == other.encoding && self.size() == other.size() && self.texels().eq(other.texels())
    }
}

impl core::fmt::Debug for Texture {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let [width, height] = self.size();
        // Checkpoints compare scenes by this text.
        let sum = self
            .texels()
            .fold(0u64, |sum, t| sum.wrapping_mul(0x0100_0000_01b3).wrapping_add(u32::from_le_bytes(t).into()));
        write!(f, "Texture({:?}, {width}x{height}, {:?}, {sum:x})", self.name, self.encoding)
    }
}

/// A coordinate within [0, 1].
#[inline(always)]
fn fold(u: f32, wrap: Wrap) -> f32 {
    match wrap {
        Wrap::Repeat => u - floor(u),
        Wrap::Mirror => {
            let t = u - 2.0 * floor(0.5 * u);
            if t > 1.0 { 2.0 - t } else { t }
        }
        Wrap::Clamp => u.clamp(0.0, 1.0),
    }
}

/// The texels before and after a folded coordinate, and the second one's weight.
#[inline(always)]
fn neighbours(u: f32, n: usize, wrap: Wrap) -> (usize, usize, f32) {
    let at = u * n as f32 - 0.5;
    let last = n - 1;
    if at < 0.0 {
        return (if wrap == Wrap::Repeat { last } else { 0 }, 0, at + 1.0);
    }
    // Through i32, which takes one instruction.
    let first = (at as i32 as usize).min(last);
    let t = at - first as i32 as f32;
    let next = match (first == last, wrap) {
        (false, _) => first + 1,
        (true, Wrap::Repeat) => 0,
        (true, _) => last,
    };
    (first, next, t)
}

impl Level {
    fn nearest(&self, uv: Vec2, wrap: [Wrap; 2], tables: Tables) -> Vec4 {
        let nearest = |u: f32, wrap, n: usize| ((fold(u, wrap) * n as f32) as usize).min(n - 1);
        let (x, y) = (nearest(uv.x, wrap[0], self.size[0]), nearest(uv.y, wrap[1], self.size[1]));
        decode(tables, self.texels[self.place(x, y)])
    }

    #[inline(always)]
    const fn place(&self, x: usize, y: usize) -> usize {
        16 * (y / 4 * self.stride + x / 4) + 4 * (y % 4) + x % 4
    }

    #[inline(always)]
    fn bilinear(&self, uv: Vec2, wrap: [Wrap; 2], tables: Tables) -> Vec4 {
        let (x0, x1, s) = neighbours(fold(uv.x, wrap[0]), self.size[0], wrap[0]);
        let (y0, y1, t) = neighbours(fold(uv.y, wrap[1]), self.size[1], wrap[1]);
        let texel = |x: usize, y: usize| decode(tables, self.texels[self.place(x, y)]);
        let [a, b, c, d] = [texel(x0, y0), texel(x1, y0), texel(x0, y1), texel(x1, y1)];
        let (upper, lower) = (a + (b - a) * s, c + (d - c) * s);
        upper + (lower - upper) * t
    }
}

impl Rows {
    fn blocks(&self) -> Level {
        let [width, height] = self.size;
        let stride = width.div_ceil(4) | 1;
        let mut level = Level { size: self.size, stride, texels: vec![[0; 4]; 16 * stride * height.div_ceil(4)] };
        for (y, row) in self.texels.chunks_exact(width).enumerate() {
            for (x, four) in row.chunks(4).enumerate() {
                let place = level.place(4 * x, y);
                level.texels[place..place + four.len()].copy_from_slice(four);
            }
        }
        level
    }

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

/// Within [0, 1]; 0 for NaN.
pub(crate) fn unit(x: f32) -> f32 {
    if x > 0.0 { x.min(1.0) } else { 0.0 }
}

/// Linear value of an sRGB one in [0, 1].
pub(crate) fn srgb_decoded(x: f32) -> f32 {
    let x = f64::from(x);
    (if x <= 0.040_45 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }) as f32
}
