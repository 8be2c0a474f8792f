//! All the segments from some receivers to a light.

use glam::Vec3;
use lobe_core::{Sphere, orthonormal_basis};

/// Which light is meant: its place in the frame's list of lights.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct LightId(pub u32);

/// A parallelogram about the middle of a light, and how far the light reaches beyond it in any direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightExtent {
    /// Half its sides.
    pub sides: [Vec3; 2],
    /// The distance of a point of the light from it, at most.
    pub margin: f32,
    /// Whether all that blocks is nearer than the light for every receiver, as before a part of a sky.
    pub is_beyond_all: bool,
}

impl LightExtent {
    /// A sphere.
    #[must_use]
    pub const fn of_sphere(radius: f32) -> Self {
        Self { sides: [Vec3::ZERO; 2], margin: radius, is_beyond_all: false }
    }

    /// How far it is from its middle along a unit direction, at most.
    #[inline]
    #[must_use]
    pub fn support(&self, direction: Vec3) -> f32 {
        direction.dot(self.sides[0]).abs() + direction.dot(self.sides[1]).abs() + self.margin
    }
}

/// All the segments from some receivers to a light: what a tile of receivers asks its blockers for.
///
/// The receivers are in a sphere and in a box with the same middle: those of a tile on a floor that is seen at a low angle are in a
/// flat and narrow one. The light is in a sphere as well, and around a parallelogram with the same middle.
#[derive(Clone, Copy, Debug)]
pub struct Shaft {
    /// Bounds the receivers.
    pub receivers: Sphere,
    /// How far they are from the middle of the sphere along each axis, at most.
    pub half_extent: Vec3,
    /// Bounds the light; an infinite light has a far away centre.
    pub light: Sphere,
    /// Bounds it, too.
    pub extent: LightExtent,
    /// Which light.
    pub id: LightId,
}

impl Shaft {
    /// From receivers in a sphere to a light in a sphere.
    #[must_use]
    pub fn new(receivers: Sphere, light: Sphere, id: LightId) -> Self {
        let extent = LightExtent::of_sphere(light.radius);
        Self { receivers, half_extent: Vec3::splat(receivers.radius), light, extent, id }
    }

    /// From other receivers to the same light.
    #[must_use]
    pub fn from_receivers(&self, receivers: Sphere) -> Self {
        Self { receivers, half_extent: Vec3::splat(receivers.radius), ..*self }
    }

    /// The light has this extent as well, where it is known.
    #[must_use]
    pub fn with_extent(self, extent: Option<LightExtent>) -> Self {
        Self { extent: extent.unwrap_or(self.extent), ..self }
    }

    /// The receivers are in this box as well.
    ///
    /// ```
    /// use glam::Vec3;
    /// use lobe_core::Sphere;
    /// use shading::{LightId, Shaft};
    /// let (receivers, light) = (Sphere { center: Vec3::ZERO, radius: 2.0 }, Sphere { center: Vec3::Y * 9.0, radius: 1.0 });
    /// let shaft = Shaft::new(receivers, light, LightId(0)).in_box(Vec3::new(2.0, 0.0, 0.5));
    /// assert_eq!([Vec3::X, Vec3::Y, Vec3::NEG_Z].map(|n| shaft.support(n)), [2.0, 0.0, 0.5]);
    /// ```
    #[must_use]
    pub fn in_box(self, half_extent: Vec3) -> Self {
        Self { half_extent, ..self }
    }

    /// How far the receivers are from their middle along a unit direction, at most.
    #[inline]
    #[must_use]
    pub fn support(&self, direction: Vec3) -> f32 {
        self.receivers.radius.min(self.half_extent.dot(direction.abs()))
    }

    /// How far the light is from its middle along a unit direction, at most.
    #[inline]
    #[must_use]
    pub fn light_support(&self, direction: Vec3) -> f32 {
        self.light.radius.min(self.extent.support(direction))
    }

    /// How far along a unit direction all segments stay from the middle of the receivers, apart from rounding.
    #[inline]
    #[must_use]
    pub fn reach(&self, direction: Vec3) -> f32 {
        let to = self.light.center - self.receivers.center;
        self.support(direction).max(direction.dot(to) + self.light_support(direction))
    }

    /// Unit vectors that make a right-handed basis with the way to the light, turned as a long light is.
    fn across(&self, axis: Vec3) -> (Vec3, Vec3) {
        let [u, v] = self.extent.sides;
        let long = if u.length_squared() < v.length_squared() { v } else { u };
        let aside = long - axis * axis.dot(long);
        if aside.length_squared() <= 1e-6 * long.length_squared() {
            return orthonormal_basis(axis);
        }
        let right = aside.normalize();
        let right = (right - axis * right.dot(axis)).normalize();
        (right, axis.cross(right))
    }

    /// Outward unit normals of ten planes around all segments, [`reach`](Self::reach) from the middle of the receivers: eight around the way
    /// to the light, one behind each end.
    #[must_use]
    pub fn normals(&self) -> [Vec3; 10] {
        use core::f32::consts::FRAC_1_SQRT_2 as DIAGONAL;
        let to = self.light.center - self.receivers.center;
        let length = to.length();
        let axis = if length > 0.0 { to / length } else { Vec3::Z };
        let (u, v) = self.across(axis);
        let side = |x: f32, y: f32| {
            let beside = u * x + v * y;
            // Touches both ends: n·axis = (r₀ − r₁)/d.
            let slope = ((self.support(beside) - self.light_support(beside)) / length).clamp(-1.0, 1.0);
            let slope = if slope.is_nan() { -1.0 } else { slope };
            axis * slope + beside * (1.0 - slope * slope).max(0.0).sqrt()
        };
        [
            side(1.0, 0.0),
            side(DIAGONAL, DIAGONAL),
            side(0.0, 1.0),
            side(-DIAGONAL, DIAGONAL),
            side(-1.0, 0.0),
            side(-DIAGONAL, -DIAGONAL),
            side(0.0, -1.0),
            side(DIAGONAL, -DIAGONAL),
            axis,
            -axis,
        ]
    }
}
