//! The sphere around a scene that some lights are made for.

use crate::{Light, SkyLight};
use lobe_core::Sphere;

impl Light {
    /// The sphere around all that blocks and is lit, of a light that is farther away than all of it or everywhere: suns, parts of an
    /// environment, ambient light. None for lights that have a place.
    #[must_use]
    pub const fn world(&self) -> Option<Sphere> {
        match self {
            Self::Sun(sun) | Self::Sky(SkyLight::Sun(sun)) => Some(sun.world),
            Self::Sky(SkyLight::Patch(patch)) => Some(patch.world),
            Self::Ambient(ambient) => Some(ambient.world),
            _ => None,
        }
    }

    /// Makes such a light one for another sphere; others stay.
    pub const fn set_world(&mut self, world: Sphere) {
        match self {
            Self::Sun(sun) | Self::Sky(SkyLight::Sun(sun)) => sun.world = world,
            Self::Sky(SkyLight::Patch(patch)) => patch.world = world,
            Self::Ambient(ambient) => ambient.world = world,
            _ => {}
        }
    }
}
