//! Any light as one type.

use crate::{
    AmbientLight, EnclosedLight, FlatLight, LightKind, SkyLight, SkyPatch, SphereLight, SpotLight, SunLight, TubeLight,
};
use glam::{Mat4, Vec3};
use lobe_core::{LightImage, Receiver, SeenLight, Sphere, Tile, TileLight};
use shading::{LightExtent, LightLobes};
use std::sync::Arc;

/// By this part of its radius a sphere that shows a light is inside of it to other lights: a hundred times the rounding of distances that are ten
/// thousand times as long.
const INSIDE: f32 = 2e-3;

/// The enum with a variant for each built-in kind, and its conversions.
macro_rules! lights {
    ($($(#[$doc:meta])* $kind:ident($light:ident),)*) => {
        /// Any light. The built-in kinds have variants of their own; all others are [`Custom`](Self::Custom).
        #[derive(Clone, Debug, PartialEq)]
        #[expect(clippy::large_enum_variant, reason = "a scene has few lights, and they are copied once a frame")]
        #[non_exhaustive]
        pub enum Light {
            $($(#[$doc])* $kind($light),)*
            /// Anybody's kind of light.
            Custom(Arc<dyn LightKind>),
        }

        impl Light {
            /// The light behind the variant.
            #[must_use]
            pub fn kind(&self) -> &dyn LightKind {
                match self {
                    $(Self::$kind(light) => light,)*
                    Self::Custom(light) => &**light,
                }
            }
        }

        $(impl From<$light> for Light {
            fn from(light: $light) -> Self {
                Self::$kind(light)
            }
        })*
    };
}

lights! {
    /// A sphere.
    Sphere(SphereLight),
    /// A rectangle, disc or convex polygon.
    Flat(FlatLight),
    /// A tube.
    Tube(TubeLight),
    /// A light at infinity.
    Sun(SunLight),
    /// A sphere that shines into a cone.
    Spot(SpotLight),
    /// A part of an environment.
    Sky(SkyLight),
    /// The same from everywhere.
    Ambient(AmbientLight),
    /// One inside an object that it does not light.
    Enclosed(EnclosedLight),
}

impl Light {
    /// Whether a sphere's surface is the light's, to a thousandth of its radius: a sphere that makes the light visible hides others, not this one.
    #[must_use]
    pub fn is_shown_by(&self, sphere: &Sphere) -> bool {
        self.sphere().is_some_and(|light| {
            let slack = 1e-3 * light.radius;
            (sphere.radius - light.radius).abs() <= slack && (sphere.center - light.center).length() <= slack
        })
    }

    /// Of a sphere that [shows](Self::is_shown_by) this light, the part that is inside of it, whatever rounding does: it hides other lights.
    #[must_use]
    pub fn inside_of(&self, sphere: &Sphere) -> Option<Sphere> {
        let light = self.sphere().filter(|_| self.is_shown_by(sphere))?;
        let radius = sphere.radius.min(light.radius - sphere.center.distance(light.center));
        Some(Sphere { radius: radius * (1.0 - INSIDE), ..*sphere })
    }

    /// The sphere, to be changed, where it is one that shines to all sides.
    pub const fn as_sphere_mut(&mut self) -> Option<&mut SphereLight> {
        match self {
            Self::Sphere(light) => Some(light),
            _ => None,
        }
    }

    /// The patch of a sky that it is.
    pub(crate) const fn sky_patch(&self) -> Option<&SkyPatch> {
        match self {
            Self::Sky(SkyLight::Patch(patch)) => Some(patch),
            _ => None,
        }
    }

    /// The [name](LightKind::name) of its kind.
    #[must_use]
    pub fn name(&self) -> &'static str {
        self.kind().name()
    }

    /// The [sphere](LightKind::sphere) that it is, for all receivers alike.
    #[must_use]
    pub fn sphere(&self) -> Option<Sphere> {
        self.kind().sphere()
    }

    /// Its [radiance](LightKind::full_radiance), where it shines.
    #[must_use]
    pub fn full_radiance(&self) -> Vec3 {
        self.kind().full_radiance()
    }

    /// The [part that it fills](LightKind::roundness) of the circle around it; none of cones.
    #[must_use]
    pub fn roundness(&self) -> Option<f32> {
        self.kind().roundness()
    }

    /// The [sphere around a scene](LightKind::world) that it is made for; none of lights that have a place.
    #[must_use]
    pub fn world(&self) -> Option<Sphere> {
        self.kind().world()
    }

    /// Makes such a light one for another sphere; others stay.
    pub fn set_world(&mut self, world: Sphere) {
        if let Some(light) = self.kind().in_world(world) {
            *self = light;
        }
    }

    /// [Distance](LightKind::distance_to) of a point from the surface that emits; none for lights at infinity and those without a surface.
    ///
    /// ```
    /// use glam::Vec3;
    /// use lighting::{Light, SphereLight};
    /// use lobe_core::Sphere;
    /// let light: Light = SphereLight::new(Sphere { center: Vec3::Y, radius: 0.5 }, Vec3::ONE).into();
    /// assert_eq!(light.distance_to(Vec3::ZERO), Some(0.5));
    /// ```
    #[must_use]
    pub fn distance_to(&self, point: Vec3) -> Option<f32> {
        self.kind().distance_to(point)
    }

    /// The same light [somewhere else](LightKind::moved).
    #[must_use]
    pub fn moved(&self, placement: Mat4) -> Self {
        self.kind().moved(placement)
    }
}

impl LightLobes for Light {
    fn bounds(&self) -> Sphere {
        self.kind().bounds()
    }
    fn bounds_from(&self, receivers: &Sphere) -> Sphere {
        self.kind().bounds_from(receivers)
    }
    fn extent(&self) -> Option<LightExtent> {
        self.kind().extent()
    }
    fn seen_from(&self, at: &Receiver) -> SeenLight {
        self.kind().seen_from(at)
    }
    fn has_shadows(&self) -> bool {
        self.kind().has_shadows()
    }

    fn image(&self) -> Option<&LightImage> {
        self.kind().image()
    }
    fn tile_light(&self, at: &[Receiver], tile: &Tile, out: &mut TileLight) {
        self.kind().tile_light(at, tile, out);
    }
}
