//! One level of a texture's pyramid: how memory holds its texels, how its edges wrap, and lookups in it.

use glam::{BVec4A, Vec2, Vec4};

/// The values outside [0, 1]².
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

/// Red, green, blue, alpha.
pub(crate) type Texel = [u8; 4];

/// A texel as memory holds it.
pub(crate) trait Stored: Copy + Default + PartialEq {
    /// Its numbers times this are its values.
    const SCALE: f32;

    fn numbers(self) -> Vec4;

    /// All of it.
    fn bits(self) -> u64;

    fn alpha(self) -> u8;
}

impl Stored for [u8; 4] {
    const SCALE: f32 = 1.0 / 255.0;

    #[inline(always)]
    fn numbers(self) -> Vec4 {
        Vec4::from_array(self.map(f32::from))
    }

    fn bits(self) -> u64 {
        u32::from_le_bytes(self).into()
    }

    fn alpha(self) -> u8 {
        self[3]
    }
}

/// Fine enough for linear values: the darkest colour of sRGB that is not black is 20.
impl Stored for [u16; 4] {
    const SCALE: f32 = 1.0 / 65535.0;

    #[inline(always)]
    fn numbers(self) -> Vec4 {
        Vec4::from_array(self.map(f32::from))
    }

    fn bits(self) -> u64 {
        self.into_iter().fold(0, |bits, x| bits << 16 | u64::from(x))
    }

    fn alpha(self) -> u8 {
        (self[3] / 257) as u8
    }
}

/// Grey without alpha.
impl Stored for u8 {
    const SCALE: f32 = 1.0 / 255.0;

    #[inline(always)]
    fn numbers(self) -> Vec4 {
        let grey = f32::from(self);
        Vec4::new(grey, grey, grey, 255.0)
    }

    fn bits(self) -> u64 {
        [self, self, self, Self::MAX].bits()
    }

    fn alpha(self) -> u8 {
        Self::MAX
    }
}

impl Stored for u16 {
    const SCALE: f32 = 1.0 / 65535.0;

    #[inline(always)]
    fn numbers(self) -> Vec4 {
        let grey = f32::from(self);
        Vec4::new(grey, grey, grey, 65535.0)
    }

    fn bits(self) -> u64 {
        [self, self, self, Self::MAX].bits()
    }

    fn alpha(self) -> u8 {
        u8::MAX
    }
}

/// Texels in blocks of 4 × 4, one or two lines of the processor's cache each, row by row of blocks.
pub(crate) struct Level<T> {
    pub(crate) size: [usize; 2],
    /// Width, height, width, height.
    pub(crate) extent: Vec4,
    /// One less each, where both are powers of two.
    masks: Option<[u32; 2]>,
    /// Texels in a row of blocks, less 16. The number of blocks is odd, so that rows do not fall on the same cache sets.
    pitch: usize,
    texels: Vec<T>,
}

impl<T: Stored> Level<T> {
    /// From rows of texels.
    pub(crate) fn new<P: Copy>(size: [usize; 2], rows: &[P], store: impl Fn(P) -> T) -> Self {
        let [width, height] = size;
        let blocks = width.div_ceil(4) | 1;
        let (w, h) = (width as f32, height as f32);
        let texels = vec![T::default(); 16 * blocks * height.div_ceil(4)];
        let masks = (width.is_power_of_two() && height.is_power_of_two()).then(|| size.map(|n| n as u32 - 1));
        let mut level = Self { size, extent: Vec4::new(w, h, w, h), masks, pitch: 16 * (blocks - 1), texels };
        for (y, row) in rows.chunks_exact(width).enumerate() {
            for (x, four) in row.chunks(4).enumerate() {
                let place = level.column(4 * x) + level.row(y);
                let to = &mut level.texels[place..place + four.len()];
                to.iter_mut().zip(four).for_each(|(to, from)| *to = store(*from));
            }
        }
        level
    }

    /// The texels, row after row from the top.
    pub(crate) fn texels(&self) -> impl Iterator<Item = T> {
        let [width, height] = self.size;
        (0..height).flat_map(move |y| (0..width).map(move |x| self.texels[self.column(x) + self.row(y)]))
    }

    pub(crate) fn bytes(&self) -> usize {
        size_of::<T>() * self.texels.len()
    }

    // A texel's place is the sum of its column's and its row's.
    #[inline(always)]
    const fn column(&self, x: usize) -> usize {
        x + 3 * (x & !3)
    }

    #[inline(always)]
    const fn row(&self, y: usize) -> usize {
        4 * y + (y >> 2) * self.pitch
    }

    /// The value of a texel.
    pub(crate) fn nearest(&self, uv: Vec4, wrap: [Wrap; 2]) -> Vec4 {
        let at = folded(uv, wrap) * self.extent;
        let nearest = |at: f32, n: usize| (if at < 0.0 { at + n as f32 } else { at } as usize).min(n - 1);
        let (x, y) = (nearest(at.x, self.size[0]), nearest(at.y, self.size[1]));
        self.texels[self.column(x) + self.row(y)].numbers() * T::SCALE
    }

    /// The numbers between four texels.
    #[inline(always)]
    pub(crate) fn bilinear(&self, uv: Vec4, wrap: [Wrap; 2]) -> Vec4 {
        let masks = self.masks.map(|[x, y]| [x, y, x, y]);
        let ([x, y, ..], t) = neighbours(uv, self.extent, masks, wrap);
        self.blend(x, y, t.x, t.y)
    }

    /// The mean of numbers over a box with sides of a number of texels, at most 1 and not 0, where texels are squares of one value.
    pub(crate) fn squares(&self, uv: Vec4, widths: Vec2, wrap: [Wrap; 2]) -> Vec4 {
        let masks = self.masks.map(|[x, y]| [x, y, x, y]);
        let ([x, y, ..], t) = neighbours(uv, self.extent, masks, wrap);
        // Of two texels the second one's part of the box.
        let part = |t: f32, width: f32| ((t - 0.5) / width + 0.5).clamp(0.0, 1.0);
        self.blend(x, y, part(t.x, widths.x), part(t.y, widths.y))
    }

    /// The numbers between this level's and the next one's.
    #[inline(always)]
    pub(crate) fn trilinear(&self, below: &Self, uv: Vec4, wrap: [Wrap; 2], share: f32) -> Vec4 {
        let (a, b) = (self.extent, below.extent);
        let masks = self.masks.zip(below.masks).map(|([x, y], [z, w])| [x, y, z, w]);
        let ([x, y, z, w], t) = neighbours(uv, Vec4::new(a.x, a.y, b.x, b.y), masks, wrap);
        let a = self.blend(x, y, t.x, t.y);
        let b = below.blend(z, w, t.z, t.w);
        a + (b - a) * share
    }

    #[inline(always)]
    fn blend(&self, x: [u32; 2], y: [u32; 2], s: f32, t: f32) -> Vec4 {
        let [left, right] = x.map(|x| self.column(x as usize));
        let [upper, lower] = y.map(|y| self.row(y as usize));
        let texel = |place: usize| self.texels[place].numbers();
        let [a, b, c, d] = [texel(left + upper), texel(right + upper), texel(left + lower), texel(right + lower)];
        let (upper, lower) = (a + (b - a) * s, c + (d - c) * s);
        upper + (lower - upper) * t
    }
}

/// Lookups are at coordinates u, v, u, v below twice this: 2²² texels of the largest image.
pub(crate) const FAR: f32 = 128.0;

/// 1.5·2²³: numbers below 2²² are rounded to whole ones by adding and subtracting it; the sum's last bits are the whole number's.
const ROUND: Vec4 = Vec4::splat(12_582_912.0);

/// Lanes u and not v.
const IS_U: BVec4A = BVec4A::from_array([true, false, true, false]);

/// Each lane by the wrap of its axis.
#[inline(always)]
fn each(wrap: [Wrap; 2], of: impl Fn(Wrap) -> Vec4) -> Vec4 {
    let [u, v] = wrap.map(of);
    Vec4::select(IS_U, u, v)
}

/// Finite coordinates u, v, u, v below [`FAR`] that mean the same place.
pub(crate) fn near(uv: Vec4, wrap: [Wrap; 2]) -> Vec4 {
    if uv.abs().cmplt(Vec4::splat(FAR)).all() {
        return uv;
    }
    each(wrap, |wrap| if wrap == Wrap::Clamp { uv.clamp(Vec4::ZERO, Vec4::ONE) } else { uv % 2.0 })
}

#[inline(always)]
fn round(x: Vec4) -> Vec4 {
    (x + ROUND) - ROUND
}

/// Coordinates within the image or, where it is repeated, half an image before and after its edge.
#[inline(always)]
fn folded(uv: Vec4, wrap: [Wrap; 2]) -> Vec4 {
    each(wrap, |wrap| match wrap {
        Wrap::Repeat => uv - round(uv),
        Wrap::Mirror => (uv - 2.0 * round(0.5 * uv)).abs(),
        Wrap::Clamp => uv.clamp(Vec4::ZERO, Vec4::ONE),
    })
}

/// For each lane the texels before and after a place, and the second one's weight.
#[inline(always)]
fn neighbours(uv: Vec4, extent: Vec4, masks: Option<[u32; 4]>, wrap: [Wrap; 2]) -> ([[u32; 2]; 4], Vec4) {
    // At a texel's centre both may be meant: one has no weight.
    let before = |uv: Vec4| {
        let at = uv * extent - Vec4::ONE;
        (at + ROUND, at - round(at) + 0.5)
    };
    let bits = |n: Vec4| n.to_array().map(f32::to_bits);
    match (masks, wrap) {
        (Some(masks), [Wrap::Repeat, Wrap::Repeat]) => {
            let (n, t) = before(uv);
            let n = bits(n);
            (core::array::from_fn(|k| [n[k] & masks[k], (n[k] + 1) & masks[k]]), t)
        }
        _ => {
            let (n, t) = before(folded(uv, wrap));
            let inside = |n: Vec4| {
                let around = || n + Vec4::select(n.cmplt(Vec4::ZERO), extent, Vec4::ZERO);
                let n = each(wrap, |wrap| if wrap == Wrap::Repeat { around() } else { n });
                bits(n.clamp(Vec4::ZERO, extent - 1.0) + ROUND).map(|n| n & 0x3f_ffff)
            };
            let n = n - ROUND;
            let (first, next) = (inside(n), inside(n + 1.0));
            (core::array::from_fn(|k| [first[k], next[k]]), t)
        }
    }
}
