//! One depth image of the casters, seen from the light's centre.

use crate::layer::Layer;
use glam::DVec3;

/// One perspective image: a window of the plane at distance 1 in front of the light's centre, in square texels.
///
/// A point in front of the light is `L + z (u R + v U + F)`; texel `(i, j)` spans `u = left + (i…i+1) texel`. Depths are stored
/// as `q = z₀/z − 1`, which is affine in `(i, j)` on a plane and small for casters far from the light.
#[derive(Clone, Debug)]
pub(crate) struct Face {
    pub(crate) frame: Frame,
    pub(crate) left: f64,
    pub(crate) bottom: f64,
    /// Side of a texel at distance 1.
    pub(crate) texel: f64,
    pub(crate) width: usize,
    pub(crate) height: usize,
    /// The distance at which q is 0.
    pub(crate) z0: f64,
    pub(crate) layers: Vec<Layer>,
}

/// An orthonormal frame of the light. Its handedness, `right × up = −forward`, does not matter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Frame {
    pub(crate) right: DVec3,
    pub(crate) up: DVec3,
    pub(crate) forward: DVec3,
}

impl Frame {
    pub(crate) fn toward(forward: DVec3) -> Self {
        let (right, up) = forward.any_orthonormal_pair();
        Self { right, up, forward }
    }

    /// The six faces of a cube.
    pub(crate) fn cube() -> [Self; 6] {
        let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
        [(y, z, x), (y, z, -x), (z, x, y), (z, x, -y), (x, y, z), (x, y, -z)].map(|(right, up, forward)| Self {
            right,
            up,
            forward,
        })
    }

    pub(crate) fn local(&self, v: DVec3) -> DVec3 {
        DVec3::new(self.right.dot(v), self.up.dot(v), self.forward.dot(v))
    }
}

/// A function that is affine in texel coordinates and q: `f = d + a i + b j + c q`.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Affine {
    pub(crate) a: f64,
    pub(crate) b: f64,
    pub(crate) c: f64,
    pub(crate) d: f64,
}

impl Affine {
    pub(crate) fn minus(self, o: Self) -> Self {
        Self { a: self.a - o.a, b: self.b - o.b, c: self.c - o.c, d: self.d - o.d }
    }

    pub(crate) fn times(self, s: f64) -> Self {
        Self { a: self.a * s, b: self.b * s, c: self.c * s, d: self.d * s }
    }
}

impl Face {
    /// `(1 + q) m·(P − x)` for a caster's point P, where `to_light = L − x`. It is affine, since
    /// `(1 + q)(P − x) = z₀(u R + v U + F) + (1 + q)(L − x)`.
    pub(crate) fn along(&self, m: DVec3, to_light: DVec3) -> Affine {
        let (relative, k) = (self.relative(m), m.dot(to_light));
        Affine { c: k, d: relative.d + k, ..relative }
    }

    /// `(1 + q) m·(P − L)` for a caster's point P.
    pub(crate) fn relative(&self, m: DVec3) -> Affine {
        let (right, up) = (self.z0 * m.dot(self.frame.right), self.z0 * m.dot(self.frame.up));
        Affine {
            a: right * self.texel,
            b: up * self.texel,
            c: 0.0,
            d: self.z0 * m.dot(self.frame.forward) + right * self.left + up * self.bottom,
        }
    }

    /// `(1 + q)·k` for a constant k.
    pub(crate) fn constant(k: f64) -> Affine {
        Affine { c: k, d: k, ..Affine::default() }
    }

    /// `(1 + q)·k z` for a constant k: `k z₀`.
    pub(crate) fn per_distance(&self, k: f64) -> Affine {
        Affine { d: k * self.z0, ..Affine::default() }
    }
}
