//! Several rays for the pixels that an outline crosses, one for the others.

use super::view::View;
use super::{GBuffer, TILE};
use crate::World;
use crate::world::SIDE;
use core::ops::Range;
use glam::Vec3;
use lobe_core::Receiver;
use rayon::prelude::*;
use scene::Cancel;

/// Two points are on one surface if the line between them rises by at most this sine above the planes of both.
const STEEPEST: f32 = 0.35;
/// The least cosine between the faces of two points on one surface: 26°.
const CREASE: f32 = 0.9;

/// Rows that a thread takes at once.
const BAND: u32 = 8 * TILE;

/// Which pixels of some tiles are meant: for each tile its rows, with a bit for each column.
pub(super) type Marks = Vec<[u8; SIDE]>;

/// How many camera rays a pixel has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PixelSamples {
    /// So many in every pixel.
    Uniform(u32),
    /// So many in the pixels that an outline or a crease crosses, and one in the others.
    Edges(u32),
}

impl PixelSamples {
    /// The most rays that a pixel has, at least 1.
    #[must_use]
    pub fn most(self) -> u32 {
        let (Self::Uniform(count) | Self::Edges(count)) = self;
        count.max(1)
    }

    /// Rays a pixel as an upper bound of the mean of usual pictures, in which outlines cross less than an eighth of the pixels.
    #[must_use]
    pub fn usual(self) -> u32 {
        match self {
            Self::Uniform(count) => count.max(1),
            Self::Edges(count) => 1 + count.div_ceil(8),
        }
    }
}

impl Default for PixelSamples {
    /// One ray a pixel.
    fn default() -> Self {
        Self::Uniform(1)
    }
}

impl From<u32> for PixelSamples {
    fn from(count: u32) -> Self {
        Self::Uniform(count)
    }
}

impl GBuffer {
    /// The same with rays of either kind.
    ///
    /// Of [`PixelSamples::Edges`] a pixel is crossed by an outline or a crease if it sees another object than one of the four pixels
    /// beside it, or a surface that does not continue there: faces that meet at more than 26°, or a step in depth. Rays of such a pixel
    /// that meet one surface share one point of it, which stands for all of them ([`rays`](Self::rays)): light is computed once a
    /// surface, outlines are as sharp as the rays are many. Thinner things than the distance of two pixels may be missed as with one
    /// ray. Every point has the same bits in all windows.
    ///
    /// # Cost
    /// The pixels that are crossed cost as many rays; all others one, and a comparison.
    ///
    /// # Panics
    /// As [`window`](Self::window).
    #[must_use]
    pub fn sampled(
        world: &World<'_>,
        image: [u32; 2],
        samples: PixelSamples,
        [columns, rows]: [Range<u32>; 2],
        cancel: &Cancel,
    ) -> Option<Self> {
        match samples {
            PixelSamples::Uniform(count) => Self::window_until(world, image, count, columns, rows, cancel),
            PixelSamples::Edges(count) => {
                let bands = rows.start / BAND..rows.end.div_ceil(BAND).max(rows.start / BAND);
                let bands: Option<Vec<Self>> = bands
                    .into_par_iter()
                    .map(|band| {
                        let rows = rows.start.max(band * BAND)..rows.end.min((band + 1) * BAND);
                        Edges { world, image, columns: columns.clone(), rows, cancel }.points(count.max(1))
                    })
                    .collect();
                Some(Self::stacked(bands?, world, columns.len() as u32, count.max(1)))
            }
        }
    }

    /// Pictures of the same width below each other.
    fn stacked(bands: Vec<Self>, world: &World<'_>, width: u32, samples: u32) -> Self {
        let materials = world.scene().materials.clone();
        let first = materials.len() as u32;
        let mut all = Self { width, samples, materials, ..Self::default() };
        all.reserve(bands.iter().map(Self::len).sum());
        for band in bands {
            let (points, pixels) = (all.len(), all.width * all.height);
            let own = all.materials.len() as u32 - first;
            let renumbered = |m: u32| if m < first { m } else { m + own };
            all.points.materials.extend(band.points.materials.into_iter().map(renumbered));
            all.points.receivers.extend(band.points.receivers);
            all.points.ends.extend(band.points.ends.into_iter().map(|end| points + end));
            all.materials.extend_from_slice(&band.materials[first as usize..]);
            all.pixels.extend(band.pixels.into_iter().map(|pixel| pixels + pixel));
            all.depths.extend(band.depths);
            all.rays.extend(band.rays);
            all.emission.extend(band.emission);
            all.sky.extend(band.sky);
            all.height += band.height;
        }
        all
    }
}

/// A window of an image.
struct Edges<'w> {
    world: &'w World<'w>,
    image: [u32; 2],
    columns: Range<u32>,
    rows: Range<u32>,
    cancel: &'w Cancel,
}

impl Edges<'_> {
    fn points(&self, count: u32) -> Option<GBuffer> {
        // With the pixels beside the window, so that its edges are those of the whole image.
        let beside = |range: &Range<u32>, size: u32| range.start.saturating_sub(1)..(range.end + 1).min(size);
        let around = [beside(&self.columns, self.image[0]), beside(&self.rows, self.image[1])];
        let [columns, rows] = around.clone();
        let centers = GBuffer::window_until(self.world, self.image, 1, columns, rows, self.cancel)?;
        let marks = self.marks(&centers, &around);
        let view = View::new(self.world, self.image, count, self.columns.clone(), self.rows.clone());
        let fine = GBuffer::of(&view.only(marks.clone()).until(self.cancel))?;
        Some(self.joined(&centers, &around, &fine, &marks, count))
    }

    /// The tile of a pixel of the window among its tiles, and its place there.
    fn place(&self, x: u32, y: u32) -> (usize, u32, u32) {
        let across = self.columns.end.div_ceil(TILE).max(self.columns.start / TILE) - self.columns.start / TILE;
        let (column, row) = (x / TILE - self.columns.start / TILE, y / TILE - self.rows.start / TILE);
        ((row * across + column) as usize, y % TILE, x % TILE)
    }

    fn tiles(&self) -> usize {
        let count = |range: &Range<u32>| range.end.div_ceil(TILE).max(range.start / TILE) - range.start / TILE;
        count(&self.columns) as usize * count(&self.rows) as usize
    }

    /// The pixels that an outline crosses, by the points at the centres of pixels.
    fn marks(&self, centers: &GBuffer, [columns, rows]: &[Range<u32>; 2]) -> Marks {
        let width = columns.len();
        let mut seen: Vec<Option<&Receiver>> = vec![None; width * rows.len()];
        centers.pixels.iter().zip(&centers.points.receivers).for_each(|(pixel, at)| seen[*pixel as usize] = Some(at));
        let mut marks = vec![[0; SIDE]; self.tiles()];
        let is_inside = |x: u32, y: u32| self.columns.contains(&x) && self.rows.contains(&y);
        let mut mark = |x: u32, y: u32| {
            if is_inside(x, y) {
                let (tile, row, column) = self.place(x, y);
                marks[tile][row as usize] |= 1 << column;
            }
        };
        for (y, line) in rows.clone().zip(0..) {
            for (x, k) in columns.clone().zip(0..) {
                let here = line * width + k;
                let right = (k + 1 < width).then_some((here + 1, x + 1, y));
                let below = (line + 1 < rows.len()).then_some((here + width, x, y + 1));
                for (there, other_x, other_y) in right.into_iter().chain(below) {
                    if !is_one_surface(seen[here], seen[there]) {
                        mark(x, y);
                        mark(other_x, other_y);
                    }
                }
            }
        }
        marks
    }

    /// The points of both, tile by tile, in the window's numbers of pixels.
    fn joined(
        &self,
        centers: &GBuffer,
        [columns, rows]: &[Range<u32>; 2],
        fine: &GBuffer,
        marks: &Marks,
        count: u32,
    ) -> GBuffer {
        let width = self.columns.len() as u32;
        let (around, first) = (columns.len() as u32, self.world.scene().materials.len() as u32);
        let mut all = GBuffer { width, height: self.rows.len() as u32, samples: count, ..GBuffer::default() };
        all.materials.clone_from(&centers.materials);
        all.materials.extend_from_slice(&fine.materials[first as usize..]);
        let own = centers.materials.len() as u32 - first;
        all.reserve(centers.len() + fine.len() / 2);
        let mut groups = fine.pixels.chunk_by(|a, b| a == b);
        let (mut group, mut done) = (groups.next(), 0);
        let mut waiting = group.map(|pixels| self.place_of(pixels[0], width));
        let mut merged = Merged::default();
        for (k, pixel) in centers.pixels.iter().enumerate() {
            let (x, y) = (columns.start + pixel % around, rows.start + pixel / around);
            if !self.columns.contains(&x) || !self.rows.contains(&y) {
                continue;
            }
            let at = self.place(x, y);
            while let (Some(pixels), Some(before)) = (group, waiting)
                && before <= at
            {
                all.end_tiles(before.0);
                merged.push_pixel(fine, done..done + pixels.len(), [first, own], &mut all);
                done += pixels.len();
                group = groups.next();
                waiting = group.map(|pixels| self.place_of(pixels[0], width));
            }
            all.end_tiles(at.0);
            if marks[at.0][at.1 as usize] & 1 << at.2 == 0 {
                let number = (y - self.rows.start) * width + x - self.columns.start;
                all.push(centers, k, [number, count], centers.points.materials[k]);
            }
        }
        for pixels in group.into_iter().chain(groups) {
            all.end_tiles(self.place_of(pixels[0], width).0);
            merged.push_pixel(fine, done..done + pixels.len(), [first, own], &mut all);
            done += pixels.len();
        }
        all.end_tiles(self.tiles());
        self.join_sky(centers, around, fine, marks, &mut all);
        all
    }

    fn place_of(&self, pixel: u32, width: u32) -> (usize, u32, u32) {
        self.place(self.columns.start + pixel % width, self.rows.start + pixel / width)
    }

    fn join_sky(&self, centers: &GBuffer, around: u32, fine: &GBuffer, marks: &Marks, all: &mut GBuffer) {
        all.sky.clone_from(&fine.sky);
        let [left, top] = [&self.columns, &self.rows].map(|range| u32::from(range.start > 0));
        for (number, sky) in (0..).zip(&mut all.sky) {
            let (tile, row, column) = self.place_of(number, all.width);
            if marks[tile][row as usize] & 1 << column == 0 {
                let (x, y) = (number % all.width + left, number / all.width + top);
                *sky = centers.sky[(y * around + x) as usize];
            }
        }
    }
}

/// Whether the surface at one point goes on at another. Nothing is one surface with nothing.
fn is_one_surface(a: Option<&Receiver>, b: Option<&Receiver>) -> bool {
    let (Some(a), Some(b)) = (a, b) else { return a.is_none() && b.is_none() };
    let between = b.position - a.position;
    let rise = a.face.dot(between).abs().max(b.face.dot(between).abs());
    a.object == b.object && a.face.dot(b.face) >= CREASE && rise <= STEEPEST * between.length()
}

/// The surfaces that the rays of a pixel meet: for each the points on it.
#[derive(Default)]
struct Merged {
    surfaces: Vec<Vec<usize>>,
}

impl Merged {
    /// Adds for each surface that a pixel's rays meet the point that is nearest to the middle of those on it.
    fn push_pixel(&mut self, fine: &GBuffer, points: Range<usize>, [first, own]: [u32; 2], all: &mut GBuffer) {
        let at = |k: usize| &fine.points.receivers[k];
        self.surfaces.clear();
        for k in points {
            let same = |surface: &&mut Vec<usize>| is_one_surface(Some(at(surface[0])), Some(at(k)));
            match self.surfaces.iter_mut().find(same) {
                Some(surface) => surface.push(k),
                None => self.surfaces.push(vec![k]),
            }
        }
        for surface in &self.surfaces {
            let middle = surface.iter().map(|k| at(*k).position).sum::<Vec3>() / surface.len() as f32;
            let away = |k: &usize| at(*k).position.distance_squared(middle);
            let nearest = surface.iter().copied().min_by(|a, b| away(a).total_cmp(&away(b))).unwrap_or(surface[0]);
            let material = fine.points.materials[nearest];
            let material = if material < first { material } else { material + own };
            all.push(fine, nearest, [fine.pixels[nearest], surface.len() as u32], material);
        }
    }
}

impl GBuffer {
    fn reserve(&mut self, count: usize) {
        self.points.receivers.reserve(count);
        self.points.materials.reserve(count);
        self.pixels.reserve(count);
        self.depths.reserve(count);
        self.rays.reserve(count);
    }

    /// Ends the tiles before one.
    fn end_tiles(&mut self, tile: usize) {
        self.points.ends.resize(tile.max(self.points.ends.len()), self.pixels.len());
    }

    /// Adds a point of another list as that of some rays of a pixel.
    fn push(&mut self, from: &Self, k: usize, [pixel, rays]: [u32; 2], material: u32) {
        self.points.receivers.push(from.points.receivers[k]);
        self.points.materials.push(material);
        self.pixels.push(pixel);
        self.depths.push(from.depths[k]);
        self.rays.push(rays);
        self.emission.extend(from.emission.get(k));
    }
}
