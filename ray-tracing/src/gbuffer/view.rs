//! Finding the visible points: tiles of an image, the hits of their rays, and the points there, written at their places.

use super::edges::Marks;
use super::{GBuffer, TILE};
use crate::World;
use crate::world::{Bundle, NOTHING, RayHits, RayPacket, Rays, SIDE, varied};
use brdf::Material;
use core::ops::Range;
use glam::{Vec2, Vec3};
use lobe_core::Receiver;
use rayon::prelude::*;
use scene::{Cancel, Surface, Terminator};

/// Tiles that a thread takes at once.
const TASK: usize = 8;

/// Some tiles of an image.
pub(super) struct View<'w> {
    world: &'w World<'w>,
    pub(super) rays: Rays,
    offsets: Vec<Vec2>,
    /// Columns and rows of tiles of the whole image.
    across: Range<u32>,
    down: Range<u32>,
    /// Pixels of the whole image that are requested.
    columns: Range<u32>,
    rows: Range<u32>,
    /// For each object whether its points have an appearance of their own, if any has.
    varied: Option<Vec<bool>>,
    has_smooth_terminators: bool,
    cancel: Option<&'w Cancel>,
    /// The pixels that are wanted; all without.
    marks: Option<Marks>,
}

/// Points of some tiles, where they belong.
struct Part<'a> {
    receivers: &'a mut [Receiver],
    materials: &'a mut [u32],
    pixels: &'a mut [u32],
    depths: &'a mut [f32],
    /// Empty where nothing emits.
    emission: &'a mut [Vec3],
}

/// Rays of a tile that have met something, eight at a time.
#[derive(Default)]
struct Met {
    hits: RayHits,
    pixels: [u32; SIDE],
    /// Their positions in the image.
    places: [Vec2; SIDE],
    count: usize,
}

impl GBuffer {
    /// Shoots `samples` rays (at least 1) through every pixel of a `width`×`height` image: one through its centre,
    /// several through a Hammersley set that is the same in all pixels.
    ///
    /// The rays of a tile go through the hierarchy together; closed surfaces have no cracks. Cost: 0.05 to 0.13 µs of a core
    /// a ray (`examples/points.rs`).
    ///
    /// # Panics
    /// When the image has more than 2³² pixels.
    #[must_use]
    pub fn new(world: &World<'_>, width: u32, height: u32, samples: u32) -> Self {
        Self::rows(world, width, height, samples, 0..height)
    }

    /// The same for some rows of the image only, as a picture of its own: large images in bands need little memory.
    ///
    /// # Panics
    /// As [`window`](Self::window).
    #[must_use]
    pub fn rows(world: &World<'_>, width: u32, height: u32, samples: u32, rows: Range<u32>) -> Self {
        Self::window(world, width, height, samples, 0..width, rows)
    }

    /// The same for a window of the image only, as a picture of its own: work that is split over processes.
    ///
    /// Every point has the same bits as in the whole image. Points come in the tiles of the whole image, cut at the
    /// window's edges.
    ///
    /// # Panics
    /// When the window has more than 2³² pixels or is not inside the image.
    #[must_use]
    pub fn window(
        world: &World<'_>,
        width: u32,
        height: u32,
        samples: u32,
        columns: Range<u32>,
        rows: Range<u32>,
    ) -> Self {
        Self::of(&View::new(world, [width, height], samples.max(1), columns, rows)).unwrap_or_default()
    }

    /// The same until the request to stop is made: none then. It is looked at for each tile of pixels.
    ///
    /// # Panics
    /// As [`window`](Self::window).
    #[must_use]
    pub fn window_until(
        world: &World<'_>,
        image: [u32; 2],
        samples: u32,
        columns: Range<u32>,
        rows: Range<u32>,
        cancel: &Cancel,
    ) -> Option<Self> {
        Self::of(&View::new(world, image, samples.max(1), columns, rows).until(cancel))
    }

    pub(super) fn of(view: &View<'_>) -> Option<Self> {
        let (width, height) = (view.columns.end - view.columns.start, view.rows.end - view.rows.start);
        let (found, ends) = view.trace();
        let mut all = Self { width, height, samples: view.offsets.len() as u32, ..Self::default() };
        if !view.is_cancelled() {
            view.describe(&found, &ends, &mut all);
        }
        if !view.is_cancelled() {
            all.sky = view.sky(&found);
        }
        (!view.is_cancelled()).then_some(all)
    }
}

impl<'w> View<'w> {
    pub(super) fn new(
        world: &'w World<'w>,
        [width, height]: [u32; 2],
        samples: u32,
        columns: Range<u32>,
        rows: Range<u32>,
    ) -> Self {
        let inside = |r: &Range<u32>, size: u32| r.start <= r.end && r.end <= size;
        assert!(inside(&columns, width) && inside(&rows, height), "window outside the image");
        let pixels = u64::from(columns.end - columns.start) * u64::from(rows.end - rows.start);
        assert!(pixels <= 1 << 32, "too many pixels");
        Self {
            world,
            rays: world.rays(width, height),
            offsets: sub_pixels(samples),
            across: columns.start / TILE..columns.end.div_ceil(TILE).max(columns.start / TILE),
            down: rows.start / TILE..rows.end.div_ceil(TILE).max(rows.start / TILE),
            columns,
            rows,
            varied: varied(world.scene()),
            has_smooth_terminators: world.scene().objects.iter().any(|object| object.terminator == Terminator::Smooth),
            cancel: None,
            marks: None,
        }
    }

    /// Some pixels of each tile only.
    pub(super) fn only(self, marks: Marks) -> Self {
        Self { marks: Some(marks), ..self }
    }

    /// Until the request to stop is made.
    pub(super) fn until(self, cancel: &'w Cancel) -> Self {
        Self { cancel: Some(cancel), ..self }
    }

    fn is_cancelled(&self) -> bool {
        self.cancel.is_some_and(Cancel::is_cancelled)
    }

    fn tile_rays(&self) -> usize {
        self.offsets.len() * (TILE * TILE) as usize
    }

    /// Column and row of a tile's first pixel, and which of its pixels are requested: a bit for each column of each row.
    fn tile(&self, number: usize) -> ([u32; 2], [u8; SIDE]) {
        let across = self.across.len();
        let left = (self.across.start + (number % across) as u32) * TILE;
        let top = (self.down.start + (number / across) as u32) * TILE;
        let part = |first: u32, all: &Range<u32>| {
            (all.start.max(first) - first) as usize..(all.end.clamp(first, first + TILE) - first) as usize
        };
        let columns = part(left, &self.columns).fold(0, |bits, column| bits | 1 << column);
        let rows = part(top, &self.rows);
        let marked = self.marks.as_ref().map_or([u8::MAX; SIDE], |marks| marks[number]);
        ([left, top], core::array::from_fn(|row| if rows.contains(&row) { columns & marked[row] } else { 0 }))
    }

    /// The hit of each ray, tile by tile and in each of them offset by offset; and the number of hits in this
    /// tile and all tiles before it.
    pub(super) fn trace(&self) -> (Vec<u32>, Vec<usize>) {
        let mut found = vec![0; self.across.len() * self.down.len() * self.tile_rays()];
        let mut ends: Vec<usize> = found
            .par_chunks_mut(self.tile_rays())
            .with_min_len(TASK)
            .enumerate()
            .map(|(tile, found)| self.trace_tile(tile, found))
            .collect();
        let mut end = 0;
        for count in &mut ends {
            end += *count;
            *count = end;
        }
        (found, ends)
    }

    fn trace_tile(&self, tile: usize, found: &mut [u32]) -> usize {
        if self.is_cancelled() {
            return 0;
        }
        let ([left, top], wanted) = self.tile(tile);
        if wanted == [0; SIDE] {
            found.fill(NOTHING);
            return 0;
        }
        let corner = Vec2::new(left as f32, top as f32);
        for (offset, found) in self.offsets.iter().zip(found.chunks_exact_mut((TILE * TILE) as usize)) {
            let mut packet = RayPacket::new(&self.rays, corner, *offset, &wanted);
            self.world.trace(&mut packet);
            found.copy_from_slice(packet.found().as_flattened());
        }
        found.iter().filter(|f| **f != NOTHING).count()
    }

    /// Writes the points.
    pub(super) fn describe(&self, found: &[u32], ends: &[usize], out: &mut GBuffer) {
        let count = ends.last().copied().unwrap_or(0);
        let none = Receiver::on_surface(Vec3::ZERO, Vec3::Z, Vec3::Z).on_object(0);
        out.points.receivers.resize(count, none);
        out.points.materials.resize(count, 0);
        out.pixels.resize(count, 0);
        out.points.ends = ends.to_vec();
        out.depths.resize(count, 0.0);
        let scene = self.world.scene();
        out.materials.clone_from(&scene.materials);
        if scene.surfaces.iter().any(Surface::emits) {
            out.emission.resize(count, Vec3::ZERO);
        }
        let mut rest = Part {
            receivers: &mut out.points.receivers,
            materials: &mut out.points.materials,
            pixels: &mut out.pixels,
            depths: &mut out.depths,
            emission: &mut out.emission,
        };
        let mut parts = Vec::with_capacity(ends.len().div_ceil(TASK));
        let mut done = 0;
        for ends in ends.chunks(TASK) {
            let end = ends[ends.len() - 1];
            let (part, after) = rest.split(end - done);
            (rest, done) = (after, end);
            parts.push(part);
        }
        let tasks = found.par_chunks(self.tile_rays() * TASK).zip(parts).enumerate();
        let own: Vec<_> = tasks.map(|(task, (found, part))| self.describe_tiles(task * TASK, found, part)).collect();
        if self.varied.is_none() {
            return;
        }
        // Each part has numbered its own from the same one on.
        let (first, mut done) = (scene.materials.len() as u32, 0);
        for (ends, own) in ends.chunks(TASK).zip(own) {
            let (end, before) = (ends[ends.len() - 1], out.materials.len() as u32 - first);
            for number in &mut out.points.materials[done..end] {
                *number += if *number >= first { before } else { 0 };
            }
            done = end;
            out.materials.extend(own);
        }
    }

    /// The environment's radiance along the rays that met nothing, pixel by pixel.
    pub(super) fn sky(&self, found: &[u32]) -> Vec<Vec3> {
        let environment = self.world.scene().environment.as_ref();
        let Some(map) = environment.and_then(|environment| environment.behind()) else { return Vec::new() };
        let share = 1.0 / self.offsets.len() as f32;
        let width = self.columns.len();
        let mut sky = vec![Vec3::ZERO; width * self.rows.len()];
        sky.par_chunks_mut(width.max(1)).zip(self.rows.clone()).for_each(|(pixels, y)| {
            if self.is_cancelled() {
                return;
            }
            for (pixel, x) in pixels.iter_mut().zip(self.columns.clone()) {
                let (column, row) = (x / TILE - self.across.start, y / TILE - self.down.start);
                let tile = row as usize * self.across.len() + column as usize;
                if self.marks.as_ref().is_some_and(|marks| marks[tile][(y % TILE) as usize] & 1 << (x % TILE) == 0) {
                    continue;
                }
                let found = &found[tile * self.tile_rays()..][..self.tile_rays()];
                for (o, offset) in self.offsets.iter().enumerate() {
                    let number = (o * SIDE + (y % TILE) as usize) * SIDE + (x % TILE) as usize;
                    if found[number] == NOTHING {
                        let direction = self.rays.direction(x as f32 + offset.x, y as f32 + offset.y);
                        *pixel += map.radiance(direction) * share;
                    }
                }
            }
        });
        sky
    }

    /// Writes the points of some tiles; gives the materials that they have of their own.
    fn describe_tiles(&self, first: usize, found: &[u32], mut out: Part<'_>) -> Vec<Material> {
        let (mut met, mut own) = (Met::default(), Vec::new());
        for (tile, found) in found.chunks_exact(self.tile_rays()).enumerate() {
            if self.is_cancelled() {
                break;
            }
            let ([left, top], wanted) = self.tile(first + tile);
            let width = self.columns.end - self.columns.start;
            for (row, bits) in wanted.into_iter().enumerate() {
                for column in (0..SIDE).filter(|column| bits & 1 << column != 0) {
                    let (x, y) = (left + column as u32, top + row as u32);
                    for (o, offset) in self.offsets.iter().enumerate() {
                        let number = found[(o * SIDE + row) * SIDE + column];
                        if number == NOTHING {
                            continue;
                        }
                        let (place, l) = (Vec2::new(x as f32 + offset.x, y as f32 + offset.y), met.count);
                        let (o, d) = (self.rays.start(place.x, place.y), self.rays.direction(place.x, place.y));
                        met.hits.found[l] = number;
                        for k in 0..3 {
                            (met.hits.starts[k][l], met.hits.directions[k][l]) = (o[k], d[k]);
                        }
                        met.places[l] = place;
                        met.pixels[l] = (y - self.rows.start) * width + (x - self.columns.start);
                        met.count += 1;
                        if met.count == SIDE {
                            out = self.write(&mut met, &mut own, out);
                        }
                    }
                }
            }
            if met.count > 0 {
                met.hits.found[met.count..].fill(NOTHING);
                out = self.write(&mut met, &mut own, out);
            }
        }
        own
    }

    /// Writes the next few points and forgets them; returns the rest of the output.
    fn write<'o>(&self, met: &mut Met, own: &mut Vec<Material>, out: Part<'o>) -> Part<'o> {
        let count = core::mem::take(&mut met.count);
        let (now, rest) = out.split(count);
        let are_parallel = self.rays.bundle == Bundle::Parallel;
        self.world.surfaces(self.rays.level, are_parallel, &met.hits, now.receivers);
        now.pixels.copy_from_slice(&met.pixels[..count]);
        let objects = &self.world.scene().objects;
        for ((at, material), depth) in now.receivers.iter().zip(&mut *now.materials).zip(now.depths) {
            *material = objects[at.object as usize].material as u32;
            *depth = self.rays.depth(at.position);
        }
        // Before normal maps turn them.
        let smooth = self.has_smooth_terminators.then(|| -> [Vec3; SIDE] {
            core::array::from_fn(|l| now.receivers.get(l).map_or(Vec3::Z, |at| at.normal))
        });
        if let Some(varied) = &self.varied {
            for l in 0..count {
                let at = &mut now.receivers[l];
                if !varied[at.object as usize] {
                    continue;
                }
                let appearance = self.world.appearance(met.hits.found[l], self.sides(met.places[l], at), at);
                if let Some(material) = appearance.material {
                    now.materials[l] = (self.world.scene().materials.len() + own.len()) as u32;
                    own.push(material);
                }
                if let Some(emission) = now.emission.get_mut(l) {
                    *emission = appearance.emission;
                }
            }
        }
        if let Some(smooth) = smooth {
            for (l, at) in now.receivers.iter_mut().enumerate() {
                if objects[at.object as usize].terminator == Terminator::Smooth {
                    self.world.raise(met.hits.found[l], smooth[l], at);
                }
            }
        }
        rest
    }

    /// The two sides, at a point, of its ray's part of the pixel, or of all of it where rays may share a point.
    fn sides(&self, place: Vec2, at: &Receiver) -> [Vec3; 2] {
        let side = if self.marks.is_some() { 1.0 } else { 1.0 / (self.offsets.len() as f32).sqrt() };
        [self.rays.side(place.x + side, place.y, at), self.rays.side(place.x, place.y + side, at)]
    }
}

impl<'a> Part<'a> {
    fn split(self, count: usize) -> (Self, Self) {
        let (receivers, receivers_after) = self.receivers.split_at_mut(count);
        let (materials, materials_after) = self.materials.split_at_mut(count);
        let (pixels, pixels_after) = self.pixels.split_at_mut(count);
        let (depths, depths_after) = self.depths.split_at_mut(count);
        let (emission, emission_after) = self.emission.split_at_mut(count.min(self.emission.len()));
        (
            Self { receivers, materials, pixels, depths, emission },
            Self {
                receivers: receivers_after,
                materials: materials_after,
                pixels: pixels_after,
                depths: depths_after,
                emission: emission_after,
            },
        )
    }
}

/// The positions of a pixel's `n` rays: Hammersley points, moved so that their mean is the centre.
pub(super) fn sub_pixels(n: u32) -> Vec<Vec2> {
    let radical_inverse = |i: u32| f64::from(i.reverse_bits()) / 4_294_967_296.0;
    let shift = 0.5 - (0..n).map(radical_inverse).sum::<f64>() / f64::from(n);
    let x = |i: u32| (f64::from(i) + 0.5) / f64::from(n);
    (0..n).map(|i| Vec2::new(x(i) as f32, (radical_inverse(i) + shift) as f32)).collect()
}
