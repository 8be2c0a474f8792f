use glam::Vec3;
use lobe_core::Sphere;

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Smallest corner.
    pub min: Vec3,
    /// Largest corner.
    pub max: Vec3,
}

impl Bounds {
    /// The box that holds nothing; grows with [`with_point`](Self::with_point).
    pub const EMPTY: Self = Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    /// The smallest box that also holds `p`.
    #[must_use]
    pub fn with_point(self, p: Vec3) -> Self {
        Self { min: self.min.min(p), max: self.max.max(p) }
    }

    /// The smallest box that also holds the sphere.
    #[must_use]
    pub fn with_sphere(self, sphere: Sphere) -> Self {
        self.with_point(sphere.center - sphere.radius).with_point(sphere.center + sphere.radius)
    }

    /// The smallest box that holds both.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// True when nothing is inside.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.min.x > self.max.x
    }

    /// The middle; the origin for an empty box.
    #[must_use]
    pub fn center(&self) -> Vec3 {
        if self.is_empty() { Vec3::ZERO } else { 0.5 * self.min + 0.5 * self.max }
    }

    /// Edge lengths; zero for an empty box.
    #[must_use]
    pub fn size(&self) -> Vec3 {
        if self.is_empty() { Vec3::ZERO } else { self.max - self.min }
    }

    /// Distance of a point from the corner that is farthest from it.
    #[must_use]
    pub fn farthest(&self, point: Vec3) -> f32 {
        (point - self.min).abs().max((self.max - point).abs()).length()
    }

    /// Half the diagonal: the radius of the sphere about the centre that holds the box.
    #[must_use]
    pub fn radius(&self) -> f32 {
        0.5 * self.size().length()
    }

    /// That sphere; of radius 0 about the origin for an empty box.
    #[must_use]
    pub fn sphere(&self) -> Sphere {
        Sphere { center: self.center(), radius: self.radius() }
    }

    /// The sphere that lights at infinity are made for, around objects in the box; of radius 1 where there are none.
    #[must_use]
    pub fn world(&self) -> Sphere {
        if self.is_empty() { Sphere { center: Vec3::ZERO, radius: 1.0 } } else { self.sphere() }
    }
}
