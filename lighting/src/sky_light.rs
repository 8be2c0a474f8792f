use crate::gpu::{PLANE_OUTSIDE, PLANE_SKY, PLANES, shape_of};
use crate::{Area, AreaShape, Light, LightError, LightKind, ShownImage, SunLight};
use core::f32::consts::PI;
use glam::{Mat4, Vec3};
use lobe_core::{LightImage, Outline, Receiver, SeenLight, Sphere};
use shading::gpu::GpuText;
use shading::{LightExtent, LightLobes};
use std::sync::Arc;

/// A part of an [`Environment`](crate::Environment): a patch of the sky, or a sun.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum SkyLight {
    /// Part of a cube's side.
    Patch(SkyPatch),
    /// A small and bright spot.
    Sun(SunLight),
}

/// A rectangle so far away that all receivers see it in the same directions.
#[derive(Clone, Debug, PartialEq)]
pub struct SkyPatch {
    /// Unit normal of its plane, away from receivers.
    pub axis: Vec3,
    /// Where its middle is on the plane at distance 1.
    pub center: Vec3,
    /// Half its sides there, at right angles.
    pub sides: [Vec3; 2],
    /// Mean radiance over the rectangle, W·m⁻²·sr⁻¹ per channel.
    pub radiance: Vec3,
    /// Where it is how bright, if not everywhere the same.
    pub image: Option<Arc<LightImage>>,
    /// A sphere around all that blocks and all that is lit.
    pub world: Sphere,
}

impl SkyPatch {
    /// All that blocks is nearer.
    fn distance(&self) -> f32 {
        4.0 * self.world.radius.max(f32::MIN_POSITIVE)
    }

    /// Its corners relative to any receiver.
    #[must_use]
    pub fn corners(&self) -> [Vec3; 4] {
        let [u, v] = self.sides;
        [-u - v, u - v, u + v, v - u].map(|side| (self.center + side) * self.distance())
    }

    /// The part that it fills of the circle around it.
    #[must_use]
    pub fn roundness(&self) -> f32 {
        let [u, v] = self.sides.map(Vec3::length);
        4.0 * u * v / (PI * (u * u + v * v)).max(f32::MIN_POSITIVE)
    }

    /// Whether another patch shows the same, in whatever world.
    pub(crate) fn shows_same(&self, other: &Self) -> bool {
        let image = match (&self.image, &other.image) {
            (Some(one), Some(two)) => Arc::ptr_eq(one, two),
            (one, two) => one.is_none() && two.is_none(),
        };
        image
            && (self.axis, self.center, self.sides, self.radiance)
                == (other.axis, other.center, other.sides, other.radiance)
    }

    /// As all receivers see it.
    fn seen(&self) -> Option<Outline> {
        let outline = Outline::new(&self.corners(), self.axis)?.with_roundness(self.roundness());
        Some(outline.with_sides(self.sides.map(|side| side * self.distance())))
    }
}

impl LightLobes for SkyLight {
    fn bounds(&self) -> Sphere {
        match self {
            Self::Sun(sun) => sun.bounds(),
            Self::Patch(patch) => self.bounds_from(&patch.world),
        }
    }

    fn bounds_from(&self, receivers: &Sphere) -> Sphere {
        match self {
            Self::Sun(sun) => sun.bounds_from(receivers),
            Self::Patch(patch) => {
                let [u, v] = patch.sides;
                let (center, distance) = (receivers.center + patch.center * patch.distance(), patch.distance());
                // A window in it is turned as it is, and not larger.
                Sphere { center, radius: (u + v).length() * distance * 1.000_1 + receivers.radius }
            }
        }
    }

    fn extent(&self) -> Option<LightExtent> {
        match self {
            Self::Sun(sun) => sun.extent(),
            Self::Patch(patch) => {
                let sides = patch.sides.map(|side| side * patch.distance());
                let beside = (Outline::BEYOND - 1.0) * (sides[0] + sides[1]).length();
                // Receivers see it in the same directions, each around itself.
                Some(LightExtent { sides, margin: beside + patch.world.radius, is_beyond_all: true })
            }
        }
    }

    fn image(&self) -> Option<&LightImage> {
        match self {
            Self::Sun(_) => None,
            Self::Patch(patch) => patch.image.as_deref(),
        }
    }

    fn seen_from(&self, at: &Receiver) -> SeenLight {
        match self {
            Self::Sun(sun) => sun.seen_from(at),
            Self::Patch(patch) => SeenLight::of_outline(patch.seen(), patch.center * patch.distance(), patch.radiance),
        }
    }
}

impl LightKind for SkyLight {
    fn name(&self) -> &'static str {
        "environment"
    }

    fn validate(&self) -> Result<(), LightError> {
        match self {
            Self::Sun(sun) => sun.validate(),
            // Its shape was checked when it was made.
            Self::Patch(_) => LightError::check_bounds(self.bounds()),
        }
    }

    fn full_radiance(&self) -> Vec3 {
        match self {
            Self::Patch(patch) => patch.radiance,
            Self::Sun(sun) => sun.radiance,
        }
    }

    /// An environment stands still.
    fn moved(&self, _: Mat4) -> Light {
        self.clone().into()
    }

    fn area(&self, from: Vec3) -> Option<Area<'_>> {
        let patch = match self {
            Self::Sun(sun) => return sun.area(from),
            Self::Patch(patch) => patch,
        };
        let bounds = self.bounds_from(&Sphere { center: from, radius: 0.0 });
        let middle = bounds.center.as_dvec3() - from.as_dvec3();
        // As far away as the sphere is.
        let distance = middle.length() / patch.center.as_dvec3().length();
        let sides = patch.sides.map(|side| side.as_dvec3() * distance);
        let [u, v] = sides;
        let corners = vec![middle - u - v, middle + u - v, middle + u + v, middle - u + v];
        let area = 4.0 * u.cross(v).length();
        let shape = AreaShape::Polygon { corners, normal: -patch.axis.as_dvec3(), area };
        let shown = patch.image.as_deref().map(|image| ShownImage { image, middle, sides });
        Some(Area { bounds, shape, shown })
    }

    fn world(&self) -> Option<Sphere> {
        match self {
            Self::Sun(sun) => sun.world(),
            Self::Patch(patch) => Some(patch.world),
        }
    }

    fn in_world(&self, world: Sphere) -> Option<Light> {
        Some(match self {
            Self::Sun(sun) => Self::Sun(SunLight { world, ..*sun }).into(),
            Self::Patch(patch) => Self::Patch(SkyPatch { world, ..patch.clone() }).into(),
        })
    }

    fn roundness(&self) -> Option<f32> {
        match self {
            Self::Sun(_) => None,
            Self::Patch(patch) => Some(patch.roundness()),
        }
    }

    fn wgsl(&self) -> Option<GpuText> {
        match self {
            Self::Sun(sun) => sun.wgsl(),
            Self::Patch(_) => Some(PLANES),
        }
    }

    fn gpu_bounds(&self) -> Sphere {
        self.bounds()
    }

    fn gpu_shape(&self) -> Vec<[f32; 4]> {
        match self {
            Self::Sun(sun) => sun.gpu_shape(),
            Self::Patch(patch) => {
                let number = [4.0, 1.0, PLANE_OUTSIDE, PLANE_SKY];
                shape_of(patch.axis.extend(0.0).to_array(), number, &patch.corners())
            }
        }
    }
}
