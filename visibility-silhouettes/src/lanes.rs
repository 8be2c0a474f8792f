//! Eight vectors at once. Functions and no closures: a closure is not told to stay inside the code that has the wide
//! instructions.

use fearless_simd::{Simd, f32x8, mask32x8, prelude::*};
use glam::Vec3;

/// Lanes.
pub(crate) const LANES: usize = 8;

/// x, y and z of eight vectors.
#[derive(Clone, Copy)]
pub(crate) struct Lanes3<S: Simd> {
    pub(crate) x: f32x8<S>,
    pub(crate) y: f32x8<S>,
    pub(crate) z: f32x8<S>,
}

impl<S: Simd> Lanes3<S> {
    #[inline(always)]
    pub(crate) fn new(x: f32x8<S>, y: f32x8<S>, z: f32x8<S>) -> Self {
        Self { x, y, z }
    }

    #[inline(always)]
    pub(crate) fn minus(self, v: Vec3) -> Self {
        Self { x: self.x - v.x, y: self.y - v.y, z: self.z - v.z }
    }

    #[inline(always)]
    pub(crate) fn plus(self, v: Vec3) -> Self {
        Self { x: self.x + v.x, y: self.y + v.y, z: self.z + v.z }
    }

    #[inline(always)]
    pub(crate) fn minus_each(self, v: Self) -> Self {
        Self { x: self.x - v.x, y: self.y - v.y, z: self.z - v.z }
    }

    #[inline(always)]
    pub(crate) fn plus_each(self, v: Self) -> Self {
        Self { x: self.x + v.x, y: self.y + v.y, z: self.z + v.z }
    }

    #[inline(always)]
    pub(crate) fn abs(self) -> Self {
        Self { x: self.x.abs(), y: self.y.abs(), z: self.z.abs() }
    }

    #[inline(always)]
    pub(crate) fn dot(self, v: Vec3) -> f32x8<S> {
        self.x * v.x + self.y * v.y + self.z * v.z
    }

    #[inline(always)]
    pub(crate) fn dot_each(self, v: Self) -> f32x8<S> {
        self.x * v.x + self.y * v.y + self.z * v.z
    }

    #[inline(always)]
    pub(crate) fn cross_each(self, v: Self) -> Self {
        Self { x: self.y * v.z - self.z * v.y, y: self.z * v.x - self.x * v.z, z: self.x * v.y - self.y * v.x }
    }

    /// `axis × self`.
    #[inline(always)]
    pub(crate) fn turned_about(self, axis: Vec3) -> Self {
        Self {
            x: self.z * axis.y - self.y * axis.z,
            y: self.x * axis.z - self.z * axis.x,
            z: self.y * axis.x - self.x * axis.y,
        }
    }

    /// Where a mask holds, the other.
    #[inline(always)]
    pub(crate) fn or(self, mask: mask32x8<S>, other: Self) -> Self {
        Self { x: mask.select(other.x, self.x), y: mask.select(other.y, self.y), z: mask.select(other.z, self.z) }
    }
}

/// Writes the first numbers of eight rows of four as columns.
#[inline(always)]
pub(crate) fn columns<S: Simd>(simd: S, rows: &[[f32; 4]; LANES], out: &mut [[f32; LANES]]) {
    for (half, four) in rows.as_chunks::<4>().0.iter().enumerate() {
        let mut flat = [0.0; 16];
        flat.copy_from_slice(four.as_flattened());
        let columns = simd.load_four_interleaved_f32x4(&flat);
        for (column, out) in columns.into_iter().zip(out.iter_mut()) {
            column.store_slice(&mut out[4 * half..4 * half + 4]);
        }
    }
}
