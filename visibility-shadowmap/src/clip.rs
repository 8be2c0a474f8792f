//! Convex polygons of few corners, clipped by planes.

use core::ops::{Add, Mul, Sub};

/// The vector type of a polygon's corners.
pub(crate) trait Point:
    Copy + Default + Add<Output = Self> + Sub<Output = Self> + Mul<Self::Scalar, Output = Self>
{
    /// The type of its components.
    type Scalar: Copy + PartialOrd + Default + Sub<Output = Self::Scalar> + core::ops::Div<Output = Self::Scalar>;
}

impl Point for glam::DVec3 {
    type Scalar = f64;
}

impl Point for glam::Vec3 {
    type Scalar = f32;
}

/// The most corners: a triangle gains at most one corner from each of five planes, a folded quadrilateral two from one.
pub(crate) const MOST: usize = 10;

/// A convex polygon.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Polygon<P> {
    corners: [P; MOST],
    count: usize,
}

impl<P: Point> Polygon<P> {
    pub(crate) fn new(corners: &[P]) -> Self {
        let mut all = [P::default(); MOST];
        all[..corners.len()].copy_from_slice(corners);
        Self { corners: all, count: corners.len() }
    }

    pub(crate) fn corners(&self) -> &[P] {
        &self.corners[..self.count]
    }

    /// The part where `side ≥ 0`, an affine function.
    pub(crate) fn clip(&self, side: impl Fn(P) -> P::Scalar) -> Self {
        let zero = P::Scalar::default();
        let corners = self.corners();
        let mut out = Self { corners: [P::default(); MOST], count: 0 };
        for (k, &p) in corners.iter().enumerate() {
            let next = corners[(k + 1) % corners.len()];
            let (here, there) = (side(p), side(next));
            if here >= zero {
                out.push(p);
            }
            if (here >= zero) != (there >= zero) {
                // Computed from the inner end, so that both neighbours of an edge find the same point.
                let (p, next, here, there) = if here >= zero { (p, next, here, there) } else { (next, p, there, here) };
                out.push(p + (next - p) * (here / (here - there)));
            }
        }
        out
    }

    fn push(&mut self, p: P) {
        if self.count < MOST {
            self.corners[self.count] = p;
            self.count += 1;
        }
    }
}
