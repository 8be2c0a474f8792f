use crate::special::ln_of;
use glam::{UVec2, Vec2, Vec3, Vec3A};
use xxhash_rust::xxh3::Xxh3;

/// Where a flat light is how bright: factors of its radiance, of mean one in each channel, and coarser and coarser copies of them.
///
/// Places are in [−1, 1]² from the light's middle along its two half sides ([`Outline::with_sides`](super::Outline::with_sides)). Between
/// the middles of texels values are linear; beyond the outermost ones they stay.
///
/// ```
/// use glam::{UVec2, Vec2, Vec3, Vec3A};
/// use lobe_core::LightImage;
/// let (image, mean) = LightImage::new(UVec2::new(2, 1), &[Vec3::splat(1.0), Vec3::splat(3.0)]).unwrap();
/// assert_eq!(mean, Vec3::splat(2.0));
/// assert_eq!(image.at(Vec2::new(-1.0, 0.0), 0.0), Vec3::splat(0.5));
/// assert_eq!(image.at(Vec2::ZERO, 0.0), Vec3::ONE);
/// ```
#[derive(Clone, PartialEq)]
pub struct LightImage {
    /// The finest first, the last of one texel.
    levels: Vec<Level>,
    vectors: Option<[Vec3; 3]>,
}

#[derive(Clone, PartialEq)]
struct Level {
    size: UVec2,
    texels: Vec<Vec3A>,
}

impl LightImage {
    /// The most texels along a side: larger pictures are made smaller.
    pub const MOST: u32 = 1024;

    /// Of so many texels across and upward, the lowest row first, and their mean, which belongs into the light's radiance. None where
    /// there are not that many, or where one is negative or not finite.
    ///
    /// Sides become powers of two, by area: the mean stays.
    #[must_use]
    pub fn new(size: UVec2, texels: &[Vec3]) -> Option<(Self, Vec3)> {
        let count = size.x as usize * size.y as usize;
        let is_valid = |t: &Vec3| t.is_finite() && t.min_element() >= 0.0;
        if count == 0 || texels.len() != count || !texels.iter().all(is_valid) {
            return None;
        }
        let finest = size.map(|n| n.next_power_of_two().min(Self::MOST));
        let mut levels = vec![Level { size, texels: texels.iter().map(|t| Vec3A::from(*t)).collect() }.resized(finest)];
        while let Some(last) = levels.last()
            && last.size != UVec2::ONE
        {
            let coarser = last.resized((last.size / 2).max(UVec2::ONE));
            levels.push(coarser);
        }
        let mean = levels.last()?.texels[0];
        let one = |t: Vec3A| Vec3A::select(mean.cmpgt(Vec3A::ZERO), t / mean, Vec3A::ONE);
        levels.iter_mut().flat_map(|level| &mut level.texels).for_each(|t| *t = one(*t));
        mean.is_finite().then_some((Self { levels, vectors: None }, mean.into()))
    }

    /// Texels along its longer side.
    #[must_use]
    pub fn texels(&self) -> u32 {
        self.levels[0].size.max_element()
    }

    /// The same image of a light that all receivers see in the same directions: with `∫ L v dv` of each channel over all of it, for a mean
    /// radiance of one.
    #[must_use]
    pub fn with_vectors(self, vectors: [Vec3; 3]) -> Self {
        Self { vectors: Some(vectors), ..self }
    }

    /// Its irradiance by channel on a surface that all of it is above, where that is known: `n·∫ L v dv`.
    #[must_use]
    pub fn irradiance(&self, normal: Vec3) -> Option<Vec3> {
        self.vectors.map(|vectors| Vec3::from_array(vectors.map(|v| v.dot(normal))))
    }

    /// Words of [`pack`](Self::pack).
    #[must_use]
    pub fn packed_words(&self) -> usize {
        11 + self.levels.iter().map(|level| 3 + 3 * level.texels.len()).sum::<usize>()
    }

    /// Appends it as kernels read it: how many copies, whether there are vectors, and these; of each copy its size and where its
    /// texels begin; all texels.
    pub fn pack(&self, out: &mut Vec<u32>) {
        let vectors = self.vectors.unwrap_or_default();
        out.extend([self.levels.len() as u32, u32::from(self.vectors.is_some())]);
        out.extend(vectors.iter().flat_map(|v| v.to_array()).map(f32::to_bits));
        let mut start = 11 + 3 * self.levels.len();
        for Level { size, texels } in &self.levels {
            out.extend([size.x, size.y, start as u32]);
            start += 3 * texels.len();
        }
        out.extend(self.levels.iter().flat_map(|level| &level.texels).flat_map(|t| t.to_array()).map(f32::to_bits));
    }

    /// Texels of the finest copy.
    #[must_use]
    pub fn size(&self) -> UVec2 {
        self.levels[0].size
    }

    /// Its factor about a place; of copy `level`, 0 is the finest, between two of them by both.
    #[must_use]
    pub fn at(&self, place: Vec2, level: f32) -> Vec3 {
        let level = level.clamp(0.0, (self.levels.len() - 1) as f32);
        let (fine, part) = (level as usize, level.fract());
        let here = self.levels[fine].at(place);
        if part > 0.0 { here.lerp(self.levels[fine + 1].at(place), part).into() } else { here.into() }
    }

    /// A texel of a copy, and the three to the right of it and above: it has an even place.
    #[inline(always)]
    pub(super) fn four(&self, level: u32, UVec2 { x, y }: UVec2) -> [Vec3A; 4] {
        let Level { size, texels } = &self.levels[level as usize];
        let row = |y: u32| &texels[(y * size.x + x) as usize..][..2];
        let [low, high] = [row(y), row(y + 1)];
        [low[0], low[1], high[0], high[1]]
    }

    /// A texel of a copy.
    #[inline(always)]
    pub(super) fn texel(&self, level: u32, UVec2 { x, y }: UVec2) -> Vec3A {
        let Level { size, texels } = &self.levels[level as usize];
        texels[(y * size.x + x) as usize]
    }

    /// The texels of a copy, or of the coarsest, in the row of a place's y.
    #[must_use]
    #[inline]
    pub fn row(&self, level: usize, y: f32) -> &[Vec3A] {
        let Level { size, texels } = &self.levels[level.min(self.levels.len() - 1)];
        let width = size.x as usize;
        &texels[index(y, size.y) * width..][..width]
    }

    /// Which texel of its row a place's x is in.
    #[must_use]
    #[inline]
    pub fn column(&self, level: usize, x: f32) -> usize {
        index(x, self.levels[level.min(self.levels.len() - 1)].size.x)
    }

    /// The copy whose texels are as large as an area in places.
    #[must_use]
    #[inline]
    pub fn level(&self, area: f32) -> f32 {
        let texels = area * (0.25 * (self.size().x * self.size().y) as f32);
        let texels = if texels > 1.0 { texels } else { 1.0 };
        (0.5 * core::f32::consts::LOG2_E) * ln_of(texels, texels - 1.0)
    }
}

/// Its size and a hash of what it shows.
impl core::fmt::Debug for LightImage {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(
            f,
            "LightImage {{ {}, {:016x} }}",
            self.size(),
            fingerprint(self.levels[0].texels.iter().map(|t| (*t).into()))
        )
    }
}

/// A hash of radiances (XXH3): the same for the same bits.
#[must_use]
pub fn fingerprint(texels: impl Iterator<Item = Vec3>) -> u64 {
    let mut hash = Xxh3::new();
    texels.for_each(|texel| hash.update(bytemuck::bytes_of(&texel)));
    hash.digest()
}

/// Places this part of a texel before the next one are in that: middles of a mask's cells lie on borders, and rounding shall not choose.
pub(super) const BORDER: f32 = 1e-3;

/// Which of so many parts of [−1, 1] a number is in.
#[inline]
fn index(place: f32, count: u32) -> usize {
    let part = 0.5 * (place + 1.0) * count as f32 + BORDER;
    (part as usize).min(count as usize - 1)
}

impl Level {
    #[inline(always)]
    fn at(&self, place: Vec2) -> Vec3A {
        let last = (self.size - 1).as_vec2();
        let p = (0.5 * (place + 1.0) * self.size.as_vec2() - 0.5).clamp(Vec2::ZERO, last);
        let low = p.as_uvec2();
        let part = p - low.as_vec2();
        let width = self.size.x as usize;
        let row = |y: u32| {
            let texels = &self.texels[y as usize * width..][..width];
            let x = low.x as usize;
            texels[x].lerp(texels[(x + 1).min(width - 1)], part.x)
        };
        row(low.y).lerp(row((low.y + 1).min(self.size.y - 1)), part.y)
    }

    /// By the area that old texels have of new ones.
    fn resized(&self, size: UVec2) -> Self {
        let across = shares(self.size.x, size.x);
        let upward = shares(self.size.y, size.y);
        let mut texels = Vec::with_capacity((size.x * size.y) as usize);
        for rows in &upward {
            for columns in &across {
                let mut sum = Vec3A::ZERO;
                for (y, by_row) in rows {
                    for (x, by_column) in columns {
                        sum += self.texels[(y * self.size.x + x) as usize] * (by_row * by_column);
                    }
                }
                texels.push(sum);
            }
        }
        Self { size, texels }
    }
}

/// Which of `from` equal parts of a length each of `to` parts covers, and the part of its own length that each has.
fn shares(from: u32, to: u32) -> Vec<Vec<(u32, f32)>> {
    let ratio = f64::from(from) / f64::from(to);
    (0..to)
        .map(|k| {
            let (low, high) = (f64::from(k) * ratio, f64::from(k + 1) * ratio);
            let last = (high.ceil() as u32).clamp(low as u32 + 1, from);
            let part = |i: u32| (high.min(f64::from(i + 1)) - low.max(f64::from(i))).max(0.0) / ratio;
            (low as u32..last).map(|i| (i, part(i) as f32)).collect()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::oracle::Random;

    /// Any size: the mean is kept, by texels and by what lies between them.
    #[test]
    fn the_mean_is_one() {
        let mut random = Random::new(3);
        for size in [UVec2::new(1, 1), UVec2::new(5, 3), UVec2::new(7, 64), UVec2::new(300, 2)] {
            let texels: Vec<Vec3> =
                (0..size.x * size.y).map(|_| Vec3::new(random.uniform() as f32, 0.0, 2.0)).collect();
            let (image, mean) = LightImage::new(size, &texels).expect("an image");
            let want = texels.iter().sum::<Vec3>() / texels.len() as f32;
            assert!((mean - want).abs().max_element() < 1e-5, "{size}: {mean} {want}");
            for level in 0..image.levels.len() {
                let n = 512;
                let at = |k: i32| (2 * k + 1) as f32 / n as f32 - 1.0;
                let sum: Vec3 = (0..n * n).map(|k| image.at(Vec2::new(at(k % n), at(k / n)), level as f32)).sum();
                let got = sum / (n * n) as f32;
                assert!((got - Vec3::ONE).abs().max_element() < 2e-3, "{size}, level {level}: {got}");
            }
        }
    }

    #[test]
    fn what_is_no_image_is_refused() {
        assert!(LightImage::new(UVec2::new(2, 2), &[Vec3::ONE; 3]).is_none());
        assert!(LightImage::new(UVec2::new(0, 2), &[]).is_none());
        for bad in [f32::NAN, f32::INFINITY, -1.0] {
            assert!(LightImage::new(UVec2::ONE, &[Vec3::splat(bad)]).is_none());
        }
        let black = LightImage::new(UVec2::ONE, &[Vec3::ZERO]).expect("an image");
        assert_eq!((black.1, black.0.at(Vec2::ZERO, 0.0)), (Vec3::ZERO, Vec3::ONE));
    }
}
