use crate::texture_level::{FAR, Level, Stored, Texel, Wrap, near};
use glam::{Vec2, Vec4, Vec4Swizzles};
use std::sync::{Arc, LazyLock};

/// The meaning of an image's numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Encoding {
    /// Colours: IEC 61966-2-1. Alpha is linear.
    Srgb,
    /// Numbers: value/255.
    Linear,
}

impl Encoding {
    /// The linear value of a number in [0, 1].
    #[must_use]
    pub fn linear(self, x: f32) -> f32 {
        match self {
            Self::Srgb => srgb_decoded(x),
            Self::Linear => x,
        }
    }
}

/// An image for surfaces: 8 bits a channel, with a mip pyramid.
///
/// Texture coordinates have their origin at the upper left corner, v downward, as in glTF. Copies share the texels.
///
/// # Cost
/// 5.3 bytes a texel, 10.7 of colours, which are kept linear; a quarter of that where all texels are grey and opaque. A lookup:
/// docs/speed.md.
#[derive(Clone)]
pub struct Texture {
    name: Arc<str>,
    encoding: Encoding,
    levels: Arc<Levels>,
}

/// Numbers as they are; colours as linear values. One number a texel where all are grey and opaque.
enum Levels {
    Bytes(Vec<Level<[u8; 4]>>),
    Words(Vec<Level<[u16; 4]>>),
    GreyBytes(Vec<Level<u8>>),
    GreyWords(Vec<Level<u16>>),
}

/// An expression of the levels, of whichever kind they are.
macro_rules! with {
    ($levels:expr, $name:ident => $value:expr) => {
        match $levels {
            Levels::Bytes($name) => $value,
            Levels::Words($name) => $value,
            Levels::GreyBytes($name) => $value,
            Levels::GreyWords($name) => $value,
        }
    };
}

/// Texels row by row.
struct Rows<P> {
    size: [usize; 2],
    texels: Vec<P>,
}

/// A texel of a file.
trait Pixel: Copy {
    /// Adds so much of it to a sum of linear values.
    fn add_to(self, sum: &mut [f32; 4], weight: f32, table: &[f32; 256]);

    /// The texel of a sum.
    fn of(sum: [f32; 4], encoding: Encoding) -> Self;
}

impl Pixel for Texel {
    #[inline(always)]
    fn add_to(self, sum: &mut [f32; 4], weight: f32, table: &[f32; 256]) {
        let [r, g, b, a] = self;
        sum[0] += weight * table[r as usize];
        sum[1] += weight * table[g as usize];
        sum[2] += weight * table[b as usize];
        sum[3] += weight * DECODED.linear[a as usize];
    }

    fn of(sum: [f32; 4], encoding: Encoding) -> Self {
        let color = |x: f32| if encoding == Encoding::Srgb { DECODED.encoded(x) } else { byte(x) };
        [color(sum[0]), color(sum[1]), color(sum[2]), byte(sum[3])]
    }
}

impl Pixel for u8 {
    #[inline(always)]
    fn add_to(self, sum: &mut [f32; 4], weight: f32, table: &[f32; 256]) {
        sum[0] += weight * table[self as usize];
    }

    fn of(sum: [f32; 4], encoding: Encoding) -> Self {
        if encoding == Encoding::Srgb { DECODED.encoded(sum[0]) } else { byte(sum[0]) }
    }
}

fn byte(x: f32) -> u8 {
    (x * 255.0 + 0.5) as u8
}

/// A footprint has one tap, and one more for each of these that the ratio of its sides, squared, is above.
const TAPS_BEYOND: [f32; 7] = [1.0, 4.0, 9.0, 16.0, 25.0, 36.0, 49.0];

/// Of each of one to eight taps.
const SHARES: [f32; 8] = [1.0, 1.0 / 2.0, 1.0 / 3.0, 1.0 / 4.0, 1.0 / 5.0, 1.0 / 6.0, 1.0 / 7.0, 1.0 / 8.0];

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
        if texels.iter().all(|[r, g, b, a]| r == g && g == b && *a == u8::MAX) {
            return Self::grey(name, size, texels.into_iter().map(|texel| texel[0]).collect(), encoding);
        }
        let rows = Rows::new(size, texels);
        let levels = match encoding {
            Encoding::Linear => Levels::Bytes(rows.pyramid(encoding, |texel| texel)),
            Encoding::Srgb => {
                let table = &DECODED.words;
                let word = |x: u8| table[x as usize];
                Levels::Words(rows.pyramid(encoding, |[r, g, b, a]| [word(r), word(g), word(b), 257 * u16::from(a)]))
            }
        };
        Self { name: name.into(), encoding, levels: levels.into() }
    }

    /// As [`Self::new`], of one grey number a texel, and opaque.
    ///
    /// # Panics
    /// As [`Self::new`].
    #[must_use]
    pub fn grey(name: &str, size: [u32; 2], texels: Vec<u8>, encoding: Encoding) -> Self {
        let rows = Rows::new(size, texels);
        let levels = match encoding {
            Encoding::Linear => Levels::GreyBytes(rows.pyramid(encoding, |texel| texel)),
            Encoding::Srgb => Levels::GreyWords(rows.pyramid(encoding, |texel| DECODED.words[texel as usize])),
        };
        Self { name: name.into(), encoding, levels: levels.into() }
    }

    /// The same image by another name.
    #[must_use]
    pub fn named(&self, name: &str) -> Self {
        Self { name: name.into(), ..self.clone() }
    }

    /// Its name in messages.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Width and height.
    #[must_use]
    pub fn size(&self) -> [usize; 2] {
        with!(&*self.levels, levels => levels[0].size)
    }

    /// The texels' alpha, row after row from the top.
    #[must_use]
    pub fn alphas(&self) -> Vec<u8> {
        with!(&*self.levels, levels => levels[0].texels().map(Stored::alpha).collect())
    }

    /// Bytes of all levels.
    #[must_use]
    pub fn bytes(&self) -> usize {
        with!(&*self.levels, levels => levels.iter().map(Level::bytes).sum())
    }

    /// The meaning of its numbers.
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
    /// footprint, bilinear, or if `is_pixelated` the mean of squares of one value over a box of the footprint's size.
    #[must_use]
    pub fn sample(&self, uv: Vec2, footprint: [Vec2; 2], wrap: [Wrap; 2], is_pixelated: bool) -> [f32; 4] {
        with!(&*self.levels, levels => mean(levels, uv, footprint, wrap, is_pixelated)).to_array()
    }
}

#[inline(always)]
fn mean<T: Stored>(levels: &[Level<T>], uv: Vec2, sides: [Vec2; 2], wrap: [Wrap; 2], is_pixelated: bool) -> Vec4 {
    let all = &levels[0];
    let uv = Vec4::new(uv.x, uv.y, uv.x, uv.y);
    let texels = Vec4::new(sides[0].x, sides[0].y, sides[1].x, sides[1].y) * all.extent;
    let squares = texels * texels;
    let squares = squares + squares.yxwz();
    let is_near = squares.cmple(Vec4::ONE) & uv.abs().cmplt(Vec4::splat(FAR));
    if is_near.all() && !is_pixelated {
        return all.bilinear(uv, wrap) * T::SCALE;
    }
    mean_from_far(levels, uv, sides, [squares.x, squares.z], wrap, is_pixelated)
}

/// Of any coordinates and footprints; these have squares of lengths in texels.
#[inline(never)]
fn mean_from_far<T: Stored>(
    levels: &[Level<T>],
    uv: Vec4,
    sides: [Vec2; 2],
    [a, b]: [f32; 2],
    wrap: [Wrap; 2],
    is_pixelated: bool,
) -> Vec4 {
    let all = &levels[0];
    if !uv.is_finite() {
        return all.nearest(Vec4::ZERO, wrap);
    }
    let uv = near(uv, wrap);
    let (major, long, short) = if a > b { (sides[0], a, b) } else { (sides[1], b, a) };
    if long <= 1.0 {
        let numbers =
            if is_pixelated { all.squares(uv, widths(sides, all.extent), wrap) } else { all.bilinear(uv, wrap) };
        return numbers * T::SCALE;
    }
    // Footprints that are not finite see all of the image.
    let long = if long < f32::MAX { long } else { f32::MAX };
    let ratio = long / short.max(1.0);
    let more = TAPS_BEYOND.iter().map(|square| usize::from(ratio > *square)).sum::<usize>();
    let share = SHARES[more];
    // Of a tap's length; its logarithm is taken as linear between powers of two, as levels are blended.
    let square = (long * (share * share)).max(1.0);
    let first = (((square.to_bits() >> 23) - 127) / 2).min(levels.len() as u32 - 1);
    let t = square.sqrt() * f32::from_bits((127 - first) << 23) - 1.0;
    let level = &levels[first as usize];
    // Nearly on a level its neighbour is not worth a look.
    let below = levels.get(first as usize + 1).filter(|_| t > 1.0 / 64.0);
    let along = major * if more > 0 { share } else { 0.0 };
    let along = Vec4::new(along.x, along.y, along.x, along.y);
    // A longer one sees means across the image, which are the same everywhere.
    let along = Vec4::select(along.abs().cmplt(Vec4::splat(FAR / 8.0)), along, Vec4::ZERO);
    let mut at = uv - along * (0.5 * f32::from(more as u8));
    let mut sum = Vec4::ZERO;
    for _ in 0..=more {
        sum += match below {
            Some(below) => level.trilinear(below, at, wrap, t),
            None => level.bilinear(at, wrap),
        };
        at += along;
    }
    sum * (T::SCALE * share)
}

/// In texels, the sides of a box along the axes with the variance of a parallelogram of these sides: at most 1, and never 0.
fn widths([a, b]: [Vec2; 2], extent: Vec4) -> Vec2 {
    ((a * a + b * b).map(f32::sqrt) * extent.xy()).min(Vec2::ONE).max(Vec2::splat(1e-6))
}

impl PartialEq for Texture {
    fn eq(&self, other: &Self) -> bool {
        self.is_same(other)
            || self.size() == other.size()
                && match (&*self.levels, &*other.levels) {
                    (Levels::Bytes(a), Levels::Bytes(b)) => a[0].texels().eq(b[0].texels()),
                    (Levels::Words(a), Levels::Words(b)) => a[0].texels().eq(b[0].texels()),
                    (Levels::GreyBytes(a), Levels::GreyBytes(b)) => a[0].texels().eq(b[0].texels()),
                    (Levels::GreyWords(a), Levels::GreyWords(b)) => a[0].texels().eq(b[0].texels()),
                    _ => false,
                }
    }
}

impl core::fmt::Debug for Texture {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let [width, height] = self.size();
        // Checkpoints compare scenes by this text.
        let add = |sum: u64, bits: u64| sum.wrapping_mul(0x0100_0000_01b3).wrapping_add(bits);
        let sum = with!(&*self.levels, levels => levels[0].texels().map(Stored::bits).fold(0, add));
        write!(f, "Texture({:?}, {width}x{height}, {:?}, {sum:x})", self.name, self.encoding)
    }
}

impl<P: Pixel> Rows<P> {
    fn new(size: [u32; 2], texels: Vec<P>) -> Self {
        let size = size.map(|n| n as usize);
        assert!(!texels.is_empty() && texels.len() == size[0] * size[1], "width times height texels");
        Self { size, texels }
    }

    fn pyramid<T: Stored>(self, encoding: Encoding, store: impl Fn(P) -> T) -> Vec<Level<T>> {
        let mut rows = self;
        let mut levels = vec![Level::new(rows.size, &rows.texels, &store)];
        while let Some(next) = rows.half(encoding) {
            levels.push(Level::new(next.size, &next.texels, &store));
            rows = next;
        }
        levels
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
                        line[left + dx].add_to(&mut sum, row * column, table);
                    }
                }
                texels.push(P::of(sum, encoding));
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
    // A texel beyond the last one appears only by rounding and has no weight.
    let weights = core::array::from_fn(|k| if first + k < of { weight(k) } else { 0.0 });
    (first, weights)
}

struct Decoded {
    srgb: [f32; 256],
    linear: [f32; 256],
    words: [u16; 256],
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
        words: core::array::from_fn(|i| (srgb_decoded(i as f32 / 255.0) * 65535.0 + 0.5) as u16),
        encoded: (0..=steps).map(|i| (encode(f64::from(i) / f64::from(steps)) * 255.0 + 0.5) as u8).collect(),
    }
});

/// Linear value of an sRGB one in [0, 1].
fn srgb_decoded(x: f32) -> f32 {
    let x = f64::from(x);
    (if x <= 0.040_45 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }) as f32
}
