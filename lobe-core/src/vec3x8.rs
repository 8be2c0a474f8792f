//! Eight vectors side by side.

use core::ops::{Add, Mul, Sub};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8, mask32x8};
use glam::Vec3;

/// Lanes.
pub const LANES: usize = 8;

/// Eight [`Vec3`]s: operations in the same order as theirs.
#[derive(Clone, Copy)]
pub struct Vec3x8<S: Simd> {
    pub x: f32x8<S>,
    pub y: f32x8<S>,
    pub z: f32x8<S>,
}

impl<S: Simd> Vec3x8<S> {
    #[inline(always)]
    pub fn new(x: f32x8<S>, y: f32x8<S>, z: f32x8<S>) -> Self {
        Self { x, y, z }
    }

    #[inline(always)]
    pub fn splat(simd: S, v: Vec3) -> Self {
        Self { x: f32x8::splat(simd, v.x), y: f32x8::splat(simd, v.y), z: f32x8::splat(simd, v.z) }
    }

    #[inline(always)]
    pub fn dot(self, with: Self) -> f32x8<S> {
        self.x * with.x + self.y * with.y + self.z * with.z
    }

    #[inline(always)]
    pub fn cross(self, with: Self) -> Self {
        Self {
            x: self.y * with.z - self.z * with.y,
            y: self.z * with.x - self.x * with.z,
            z: self.x * with.y - self.y * with.x,
        }
    }

    #[inline(always)]
    pub fn dot_one(self, with: Vec3) -> f32x8<S> {
        self.x * with.x + self.y * with.y + self.z * with.z
    }

    #[inline(always)]
    pub fn length_squared(self) -> f32x8<S> {
        self.dot(self)
    }

    #[inline(always)]
    pub fn minus(self, v: Vec3) -> Self {
        Self { x: self.x - v.x, y: self.y - v.y, z: self.z - v.z }
    }

    #[inline(always)]
    pub fn plus(self, v: Vec3) -> Self {
        Self { x: self.x + v.x, y: self.y + v.y, z: self.z + v.z }
    }

    #[inline(always)]
    pub fn abs(self) -> Self {
        Self { x: self.x.abs(), y: self.y.abs(), z: self.z.abs() }
    }

    /// `axis × self`.
    #[inline(always)]
    pub fn turned_about(self, axis: Vec3) -> Self {
        Self {
            x: self.z * axis.y - self.y * axis.z,
            y: self.x * axis.z - self.z * axis.x,
            z: self.y * axis.x - self.x * axis.y,
        }
    }

    /// Where a mask holds, the other.
    #[inline(always)]
    pub fn or(self, mask: mask32x8<S>, other: Self) -> Self {
        Self { x: mask.select(other.x, self.x), y: mask.select(other.y, self.y), z: mask.select(other.z, self.z) }
    }

    /// One of them.
    #[inline(always)]
    pub fn get(self, lane: usize) -> Vec3 {
        Vec3::new(self.x[lane], self.y[lane], self.z[lane])
    }
}

impl<S: Simd> Add for Vec3x8<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, v: Self) -> Self {
        Self { x: self.x + v.x, y: self.y + v.y, z: self.z + v.z }
    }
}

impl<S: Simd> Sub for Vec3x8<S> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, v: Self) -> Self {
        Self { x: self.x - v.x, y: self.y - v.y, z: self.z - v.z }
    }
}

impl<S: Simd> Mul<f32x8<S>> for Vec3x8<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, v: f32x8<S>) -> Self {
        Self { x: self.x * v, y: self.y * v, z: self.z * v }
    }
}
