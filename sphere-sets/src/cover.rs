use std::collections::BinaryHeap;

use glam::{UVec3, Vec4};

use crate::bits::round_up;
use crate::solid::Solid;

/// The distance that a sphere of the cover reaches through the surface, in units of D.
pub(crate) const PROTRUSION: f32 = 0.008;

/// Greedy cover: at most `count` spheres centred in solid voxels, each as deep as its centre plus [`PROTRUSION`], each
/// taking the most voxels that no earlier one took.
///
/// The volume that a sphere would add only shrinks as others are taken, so a heap of old values finds the best without
/// asking all (M. Minoux, *Accelerated greedy algorithms for maximizing submodular set functions*, 1978).
pub(crate) fn greedy_cover(solid: &Solid, count: usize) -> Vec<Vec4> {
    let mut open = Grid::new(solid.dims());
    for (at, _) in solid.voxels() {
        open.set(at);
    }
    for &p in solid.isolated() {
        open.set(solid.voxel_of(p));
    }
    // A vertex is less than √3/2 cells from the centre of its voxel.
    let tiny = solid.isolated().iter().map(|p| p.extend(0.9 * solid.cell()));
    let spheres: Vec<Vec4> = solid
        .voxels()
        .filter(|voxel| !solid.in_deeper_neighbour(*voxel))
        .map(|voxel| {
            let sphere = solid.sphere(voxel);
            sphere.truncate().extend((sphere.w + PROTRUSION).max(0.5 * solid.cell()))
        })
        .chain(tiny)
        .collect();
    let gain = |open: &Grid, sphere: Vec4| open.sum(solid.locate(sphere.truncate()).extend(sphere.w / solid.cell()));
    // To begin with, a bound: no more voxels than fit the sphere grown by half a voxel's diagonal.
    let bound =
        |sphere: &Vec4| (core::f32::consts::PI * 4.0 / 3.0 * (sphere.w / solid.cell() + 0.867).powi(3)) as u32 + 1;
    // Equal gains: the earlier voxel first.
    let mut heap: BinaryHeap<(u32, core::cmp::Reverse<usize>)> =
        spheres.iter().enumerate().map(|(i, sphere)| (bound(sphere), core::cmp::Reverse(i))).collect();
    let mut chosen = Vec::with_capacity(count.min(spheres.len()));
    while let Some((old, core::cmp::Reverse(i))) = heap.pop() {
        if chosen.len() == count || old == 0 {
            break;
        }
        let now = gain(&open, spheres[i]);
        if heap.peek().is_none_or(|(next, _)| now >= *next) {
            if now == 0 {
                break;
            }
            open.take(solid.locate(spheres[i].truncate()).extend(spheres[i].w / solid.cell()));
            chosen.push(spheres[i]);
        } else {
            heap.push((now, core::cmp::Reverse(i)));
        }
    }
    chosen
}

/// One bit a voxel.
struct Grid {
    dims: UVec3,
    words: usize,
    data: Vec<u64>,
}

impl Grid {
    fn new(dims: UVec3) -> Self {
        let words = dims.x.div_ceil(64) as usize;
        Self { dims, words, data: vec![0; words * (dims.y * dims.z) as usize] }
    }

    fn set(&mut self, at: UVec3) {
        let row = (at.z * self.dims.y + at.y) as usize * self.words;
        self.data[row + at.x as usize / 64] |= 1 << (at.x % 64);
    }

    /// Bits set in a sphere, in voxel coordinates.
    fn sum(&self, sphere: Vec4) -> u32 {
        let mut sum = 0;
        rows(self.dims, sphere, |row, start, end| {
            words(start, end, |word, mask| sum += (self.data[row * self.words + word] & mask).count_ones());
        });
        sum
    }

    /// Clears the bits in a sphere.
    fn take(&mut self, sphere: Vec4) {
        rows(self.dims, sphere, |row, start, end| {
            words(start, end, |word, mask| self.data[row * self.words + word] &= !mask);
        });
    }
}

/// Calls `span(row, start, end)` for each row of the voxels whose centres a sphere holds.
fn rows(dims: UVec3, sphere: Vec4, mut span: impl FnMut(usize, usize, usize)) {
    let range = |center: f32, half: f32, size: u32| {
        (round_up(center - half - 0.5) as u32).min(size)..(round_up(center + half - 0.5) as u32).min(size)
    };
    for z in range(sphere.z, sphere.w, dims.z) {
        let dz = z as f32 + 0.5 - sphere.z;
        let half = (sphere.w * sphere.w - dz * dz).max(0.0).sqrt();
        for y in range(sphere.y, half, dims.y) {
            let dy = y as f32 + 0.5 - sphere.y;
            let half = (sphere.w * sphere.w - dz * dz - dy * dy).max(0.0).sqrt();
            let x = range(sphere.x, half, dims.x);
            if x.start < x.end {
                span((z * dims.y + y) as usize, x.start as usize, x.end as usize);
            }
        }
    }
}

/// Calls `each(word, mask)` for the 64-bit words of the bits `start..end`, `start < end`.
fn words(start: usize, end: usize, mut each: impl FnMut(usize, u64)) {
    let (first, last) = (start / 64, (end - 1) / 64);
    for word in first..=last {
        let mut mask = !0_u64;
        if word == first {
            mask &= !0 << (start % 64);
        }
        if word == last {
            mask &= !0 >> (63 - (end - 1) % 64);
        }
        each(word, mask);
    }
}
