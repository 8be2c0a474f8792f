//! Any of the built-in lights as one type, and one of them inside an object that it does not light.

use crate::{AmbientLight, FlatLight, SkyLight, SphereLight, SpotLight, SunLight, TubeLight};
use glam::{Mat4, Vec3};
use lobe_core::{LightImage, LightLobes, Receiver, SeenLight, Sphere, Tile, TileLight};

/// The built-in kinds of lights.
#[derive(Clone, Debug, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "a scene has few lights, and they are copied once a frame")]
#[non_exhaustive]
pub enum Light {
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

macro_rules! each {
    ($self:expr, $light:ident => $value:expr) => {
        match $self {
            Light::Sphere($light) => $value,
            Light::Flat($light) => $value,
            Light::Tube($light) => $value,
            Light::Sun($light) => $value,
            Light::Spot($light) => $value,
            Light::Sky($light) => $value,
            Light::Ambient($light) => $value,
            Light::Enclosed($light) => $value,
        }
    };
}

impl Light {
    /// Its radiance, where it shines.
    #[must_use]
    pub fn full_radiance(&self) -> Vec3 {
        match self {
            Self::Sphere(light) => light.radiance,
            Self::Flat(light) => light.radiance,
            Self::Tube(light) => light.radiance,
            Self::Sun(light) => light.radiance,
            Self::Spot(light) => light.light.radiance,
            Self::Sky(light) => light.full_radiance(),
            Self::Ambient(light) => light.radiance,
            Self::Enclosed(light) => light.light.full_radiance(),
        }
    }

    /// The sphere that it is, for all receivers alike; none where it is none.
    #[must_use]
    pub fn sphere(&self) -> Option<Sphere> {
        match self {
            Self::Sphere(light) => Some(light.sphere),
            Self::Spot(light) => Some(light.light.sphere),
            Self::Enclosed(light) => light.light.sphere(),
            _ => None,
        }
    }

    /// Whether a sphere's surface is the light's, to a thousandth of its radius: a sphere that makes the light visible does not hide it.
    #[must_use]
    pub fn is_shown_by(&self, sphere: &Sphere) -> bool {
        self.sphere().is_some_and(|light| {
            let slack = 1e-3 * light.radius;
            (sphere.radius - light.radius).abs() <= slack && (sphere.center - light.center).length() <= slack
        })
    }

    /// The sphere, to be changed, where it is one that shines to all sides.
    pub const fn as_sphere_mut(&mut self) -> Option<&mut SphereLight> {
        match self {
            Self::Sphere(light) => Some(light),
            _ => None,
        }
    }

    /// The same light somewhere else. Turns and shifts only.
    #[must_use]
    pub fn moved(&self, placement: Mat4) -> Self {
        each!(self, light => light.moved(placement).into())
    }

    /// Its kind, in a word, for messages.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Sphere(_) => "sphere",
            Self::Flat(_) => "flat",
            Self::Tube(_) => "tube",
            Self::Sun(_) => "sun",
            Self::Spot(_) => "spot",
            Self::Sky(_) => "environment",
            Self::Ambient(_) => "ambient",
            Self::Enclosed(light) => light.light.kind(),
        }
    }
}

impl LightLobes for Light {
    fn bounds(&self) -> Sphere {
        each!(self, light => light.bounds())
    }
    fn bounds_from(&self, receivers: &Sphere) -> Sphere {
        each!(self, light => light.bounds_from(receivers))
    }
    fn seen_from(&self, at: &Receiver) -> SeenLight {
        each!(self, light => light.seen_from(at))
    }
    fn image(&self) -> Option<&LightImage> {
        each!(self, light => light.image())
    }
    fn tile_light(&self, at: &[Receiver], tile: &Tile, out: &mut TileLight) {
        each!(self, light => light.tile_light(at, tile, out));
    }
}

macro_rules! from {
    ($($kind:ident($light:ident)),*) => {
        $(impl From<$light> for Light {
            fn from(light: $light) -> Self {
                Self::$kind(light)
            }
        })*
    };
}

from!(
    Sphere(SphereLight),
    Flat(FlatLight),
    Tube(TubeLight),
    Sun(SunLight),
    Spot(SpotLight),
    Sky(SkyLight),
    Ambient(AmbientLight),
    Enclosed(EnclosedLight)
);

/// A light inside an object whose surface it stands for: it does not light that object.
///
/// A sphere in place of a faceted mesh is above its surface here and below it there; what that surface got of it would be noise.
///
/// ```
/// use glam::Vec3;
/// use lighting::{EnclosedLight, SphereLight};
/// use lobe_core::{LightLobes, Receiver, Sphere};
/// let sphere = SphereLight::new(Sphere { center: Vec3::ZERO, radius: 1.0 }, Vec3::ONE);
/// let light = EnclosedLight { light: Box::new(sphere.into()), object: 3 };
/// let at = Receiver::on_surface(Vec3::Z * 0.99, Vec3::Z, Vec3::Z).on_object(3);
/// assert_eq!(light.radiance(&at), Vec3::ZERO);
/// assert_eq!(light.radiance(&Receiver { object: 2, ..at }), Vec3::ONE);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct EnclosedLight {
    /// The light.
    pub light: Box<Light>,
    /// The number of the object, as receivers have it.
    pub object: u32,
}

impl EnclosedLight {
    /// The same light somewhere else. Turns and shifts only.
    #[must_use]
    pub fn moved(&self, placement: Mat4) -> Self {
        Self { light: Box::new(self.light.moved(placement)), ..*self }
    }
}

impl LightLobes for EnclosedLight {
    fn bounds(&self) -> Sphere {
        self.light.bounds()
    }

    fn bounds_from(&self, receivers: &Sphere) -> Sphere {
        self.light.bounds_from(receivers)
    }

    fn seen_from(&self, at: &Receiver) -> SeenLight {
        let seen = self.light.seen_from(at);
        if at.object == self.object { SeenLight { radiance: Vec3::ZERO, ..seen } } else { seen }
    }

    fn image(&self) -> Option<&LightImage> {
        self.light.image()
    }
}
