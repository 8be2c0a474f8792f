//! The surfaces of lights in f64, for a reference that draws points on them.

use core::fmt::Debug;
use glam::{DVec3, Vec3};
use lobe_core::{LightImage, Sphere};
use std::sync::Arc;

/// The surface of a light as one receiver sees it. Points are relative to the receiver, but for the sphere's.
#[derive(Clone, Debug)]
pub struct Area<'l> {
    /// A sphere around the surface, in the world; of a sphere of light it is the surface.
    pub bounds: Sphere,
    /// Its shape.
    pub shape: AreaShape,
    /// The image that a rectangle shows.
    pub shown: Option<ShownImage<'l>>,
}

/// An image on a rectangle, from its middle along two half sides.
#[derive(Clone, Copy, Debug)]
pub struct ShownImage<'l> {
    /// The image: factors of the radiance.
    pub image: &'l LightImage,
    /// The middle of the rectangle.
    pub middle: DVec3,
    /// Half its sides.
    pub sides: [DVec3; 2],
}

/// The shape of a light's surface.
#[derive(Clone, Debug)]
pub enum AreaShape {
    /// The sphere of the bounds.
    Sphere,
    /// A convex polygon.
    Polygon {
        /// Its corners, at least three.
        corners: Vec<DVec3>,
        /// Unit normal toward the receiver.
        normal: DVec3,
        /// Its area.
        area: f64,
    },
    /// A disc.
    Disc {
        /// Its middle.
        center: DVec3,
        /// Unit normal toward the receiver.
        normal: DVec3,
        /// Its radius.
        radius: f64,
    },
    /// A capsule.
    Capsule {
        /// The middle of one end.
        end: DVec3,
        /// The way to the middle of the other.
        along: DVec3,
        /// Its radius.
        radius: f64,
    },
    /// Any other.
    Custom(Arc<dyn SampledArea>),
}

/// A point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AreaPoint {
    /// Where it is, relative to the receiver.
    pub position: DVec3,
    /// The unit normal.
    pub normal: DVec3,
    /// One over the density per area with which it is drawn: of a surface that is sampled evenly its area.
    pub area: f64,
}

/// A surface that is sampled by area.
pub trait SampledArea: Debug + Send + Sync {
    /// A point for two numbers in [0, 1).
    fn sample(&self, u: f64, v: f64) -> Option<AreaPoint>;

    /// The first point that a ray from the receiver meets in a unit direction.
    fn hit(&self, direction: DVec3) -> Option<AreaPoint>;
}

impl Area<'_> {
    /// A sphere of light.
    #[must_use]
    pub const fn sphere(sphere: Sphere) -> Self {
        Self { bounds: sphere, shape: AreaShape::Sphere, shown: None }
    }

    /// Whether it is the sphere of the bounds.
    #[must_use]
    pub const fn is_sphere(&self) -> bool {
        matches!(self.shape, AreaShape::Sphere)
    }

    /// Any surface, inside of a sphere.
    #[must_use]
    pub fn custom(bounds: Sphere, surface: Arc<dyn SampledArea>) -> Self {
        Self { bounds, shape: AreaShape::Custom(surface), shown: None }
    }
}

impl AreaShape {
    /// A convex polygon in the world, of three corners or more, whose unit normal faces a receiver at `from`.
    #[must_use]
    pub fn polygon(corners: &[Vec3], normal: DVec3, from: Vec3) -> Self {
        let corners: Vec<DVec3> = corners.iter().map(|p| p.as_dvec3() - from.as_dvec3()).collect();
        let first = corners[0];
        let twice: DVec3 = corners[1..].windows(2).map(|p| (p[0] - first).cross(p[1] - first)).sum();
        Self::Polygon { area: 0.5 * twice.length(), corners, normal }
    }
}
