//! Receivers that are shaded together, and a light as they see it, in columns.

use crate::lanes::{Columns, Kept, Lane, Level, WIDTH, map, row, set_row};
use crate::seen::Seen;
use crate::{Cone, FlatShape, Outline, Receiver, SeenLight, Sphere};
use glam::Vec3;

/// Position, normal and view of receivers, sixteen to a block.
///
/// The rows of the last block that are too many repeat the last receiver.
#[derive(Clone, Debug, Default)]
pub struct Tile {
    blocks: Vec<Kept<9>>,
    len: usize,
}

impl Tile {
    /// Takes other receivers.
    pub fn set(&mut self, receivers: &[Receiver]) {
        self.len = receivers.len();
        self.blocks.resize(self.len.div_ceil(WIDTH), Kept::default());
        let set = |block: &mut Kept<9>, receivers: &[Receiver; WIDTH]| {
            for (j, r) in receivers.iter().enumerate() {
                let (p, n, v) = (r.position, r.normal, r.view);
                set_row(&mut block.0, j, &[p.x, p.y, p.z, n.x, n.y, n.z, v.x, v.y, v.z]);
            }
        };
        let (full, rest) = receivers.as_chunks();
        self.blocks.iter_mut().zip(full).for_each(|(block, receivers)| set(block, receivers));
        if let (Some(block), [.., last]) = (self.blocks.get_mut(full.len()), rest) {
            set(block, &core::array::from_fn(|j| *rest.get(j).unwrap_or(last)));
        }
    }

    /// Number of receivers.
    #[must_use]
    pub fn len(&self) -> usize {
        self.len
    }

    /// True when there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Number of blocks.
    #[must_use]
    pub fn blocks(&self) -> usize {
        self.blocks.len()
    }

    /// Columns of a block: position, normal, view.
    ///
    /// # Panics
    /// When `block` is not below [`blocks`](Self::blocks).
    #[must_use]
    pub fn block(&self, block: usize) -> &Columns<9> {
        &self.blocks[block].0
    }

    /// A sphere around the receivers, and half the sides of a box around them with the same middle
    /// (as `Shaft::in_box` of the crate `shading` takes it).
    #[must_use]
    pub fn bounds(&self) -> (Sphere, Vec3) {
        let positions = || self.blocks.iter().map(|block| &block.0);
        let extreme = |c: usize, start: f32, better: fn(f32, f32) -> bool| {
            let mut best = [start; WIDTH];
            for block in positions() {
                for (best, x) in best.iter_mut().zip(&block[c]) {
                    *best = if better(*x, *best) { *x } else { *best };
                }
            }
            best.into_iter().fold(start, |a, b| if better(b, a) { b } else { a })
        };
        if self.is_empty() {
            return (Sphere::default(), Vec3::ZERO);
        }
        let low = Vec3::from_array([0, 1, 2].map(|c| extreme(c, f32::INFINITY, |a, b| a < b)));
        let high = Vec3::from_array([0, 1, 2].map(|c| extreme(c, f32::NEG_INFINITY, |a, b| a > b)));
        let center = 0.5 * (low + high);
        let mut square = [0.0; WIDTH];
        for [x, y, z, ..] in positions() {
            for (j, square) in square.iter_mut().enumerate() {
                let d = (Vec3::new(x[j], y[j], z[j]) - center).length_squared();
                *square = if d > *square { d } else { *square };
            }
        }
        let radius = square.into_iter().fold(0.0, f32::max).sqrt();
        let half_extent = (high - center).max(center - low);
        (Sphere { center, radius: radius * 1.000_01 }, half_extent * 1.000_01)
    }
}

/// A light as the receivers of a [`Tile`] see it.
#[derive(Clone, Debug, Default)]
pub struct TileLight {
    pub(crate) cones: Vec<Kept<5>>,
    pub(crate) seen: Vec<Kept<10>>,
    /// The same for all receivers, where `each` is empty.
    same: Vec3,
    each: Vec<Kept<3>>,
    /// Of lights with outlines, one a receiver; of others none.
    outlines: Vec<Option<Outline>>,
    /// A flat light, and the receivers that it is seen from: their outlines are made on demand.
    flat: Option<Flat>,
    at: Vec<Kept<9>>,
}

/// A flat light.
#[derive(Clone, Debug)]
pub(crate) struct Flat {
    pub(crate) shape: FlatShape,
    pub(crate) is_two_sided: bool,
}

/// The radiance of a light toward the receivers of a tile.
#[derive(Clone, Copy, Debug)]
pub enum TileRadiance<'a> {
    /// The same toward all.
    Same(Vec3),
    /// In columns, red, green and blue.
    Each(&'a [Kept<3>]),
}

impl TileLight {
    /// A sphere of the same radiance toward all: the cones are those of [`Cone::of_sphere`], bit for bit.
    pub fn sphere(&mut self, tile: &Tile, sphere: Sphere, radiance: Vec3) {
        let level = Level::new();
        self.same = radiance;
        self.each.clear();
        self.outlines.clear();
        self.flat = None;
        self.cones.resize(tile.blocks(), Kept::default());
        for (at, cones) in tile.blocks.iter().zip(&mut self.cones) {
            map(level, &ToCone(sphere), &at.0, &[], &mut cones.0);
        }
        self.see(level, tile);
    }

    /// A flat light of the same radiance on one side, or on both.
    pub fn flat(&mut self, tile: &Tile, shape: &FlatShape, is_two_sided: bool, radiance: Vec3) {
        self.same = radiance;
        self.each.clear();
        self.outlines.clear();
        self.cones.clear();
        self.flat = Some(Flat { shape: shape.clone(), is_two_sided });
        self.at.clone_from(&tile.blocks);
    }

    fn see(&mut self, level: Level, tile: &Tile) {
        self.seen.resize(tile.blocks(), Kept::default());
        for ((at, cones), seen) in tile.blocks.iter().zip(&self.cones).zip(&mut self.seen) {
            map(level, &ToSeen, &at.0, &cones.0, &mut seen.0);
        }
    }

    /// The light as each receiver sees it.
    ///
    /// # Panics
    /// When there are not as many as receivers of the tile.
    pub fn one_by_one(&mut self, tile: &Tile, seen: impl IntoIterator<Item = SeenLight>) {
        self.outlines.clear();
        self.flat = None;
        let mut is_flat = false;
        self.cones.resize(tile.blocks(), Kept::default());
        self.each.resize(tile.blocks(), Kept::default());
        let mut count = 0;
        for (i, mut seen) in seen.into_iter().enumerate() {
            is_flat |= seen.outline.is_some();
            let [.., x, y, z, _, _, _] = row(&tile.blocks[i / WIDTH].0, i % WIDTH);
            seen.keep_above(Vec3::new(x, y, z));
            let SeenLight { cone, radiance, outline } = seen;
            self.outlines.push(outline);
            let last = if i + 1 == tile.len() { WIDTH } else { i % WIDTH + 1 };
            // The rows that are too many repeat the last one, as the tile's do.
            for j in i % WIDTH..last {
                set_row(&mut self.cones[i / WIDTH].0, j, &bytemuck::cast(cone));
                set_row(&mut self.each[i / WIDTH].0, j, &radiance.to_array());
            }
            count = i + 1;
        }
        assert_eq!(count, tile.len(), "one cone a receiver");
        if !is_flat {
            self.outlines.clear();
        }
        self.see(Level::new(), tile);
    }

    /// The light's radiance toward receiver `i`.
    ///
    /// # Panics
    /// When the tile has no such receiver's block.
    #[must_use]
    pub fn radiance(&self, i: usize) -> Vec3 {
        match self.radiances() {
            TileRadiance::Same(radiance) => radiance,
            TileRadiance::Each(each) => Vec3::from_array(row(&each[i / WIDTH].0, i % WIDTH)),
        }
    }

    /// All that receiver `i` sees of the light.
    ///
    /// # Panics
    /// When the tile has no such receiver.
    #[must_use]
    pub fn seen_by(&self, i: usize) -> SeenLight {
        let radiance = self.radiance(i);
        let Some(flat) = &self.flat else {
            let cone = bytemuck::cast(row(&self.cones[i / WIDTH].0, i % WIDTH));
            return SeenLight { cone, radiance, outline: self.outlines.get(i).copied().flatten() };
        };
        let [x, y, z, u, v, w, ..] = row(&self.at[i / WIDTH].0, i % WIDTH);
        let mut seen = flat.shape.seen_from(Vec3::new(x, y, z), flat.is_two_sided, radiance);
        seen.keep_above(Vec3::new(u, v, w));
        seen
    }

    /// A flat light, and blocks of the receivers that it is seen from.
    pub(crate) fn as_flat(&self) -> Option<(&Flat, &[Kept<9>])> {
        Some((self.flat.as_ref()?, &self.at))
    }

    /// The bright parts of the receivers' cones above their horizons, of a flat light: none where it faces away. Empty of others.
    pub(crate) fn outlines(&self) -> &[Option<Outline>] {
        &self.outlines
    }

    /// Its radiance toward all receivers.
    #[must_use]
    pub fn radiances(&self) -> TileRadiance<'_> {
        if self.each.is_empty() { TileRadiance::Same(self.same) } else { TileRadiance::Each(&self.each) }
    }

    /// The cone that receiver `i` sees.
    ///
    /// # Panics
    /// When the tile has no such receiver's block.
    #[must_use]
    pub fn cone(&self, i: usize) -> Cone {
        self.seen_by(i).cone
    }
}

struct ToCone(Sphere);
impl Lane<9, 0, 5> for ToCone {
    #[inline(always)]
    fn value(&self, [x, y, z, ..]: [f32; 9], []: [f32; 0]) -> [f32; 5] {
        bytemuck::cast(Cone::of_sphere(Vec3::new(x, y, z), self.0))
    }
}

struct ToSeen;
impl Lane<9, 5, 10> for ToSeen {
    #[inline(always)]
    fn value(&self, [_, _, _, x, y, z, ..]: [f32; 9], cone: [f32; 5]) -> [f32; 10] {
        bytemuck::cast(Seen::new(Vec3::new(x, y, z), &bytemuck::cast(cone)))
    }
}
