//! An area light: the trait that says how receivers see it.

use crate::LightExtent;
use glam::Vec3;
use lobe_core::{Cone, LightImage, LobeWriter, Outline, Receiver, SeenLight, Sphere, Tile, TileLight};

/// An area light, seen as a uniformly bright cone of directions, or as a bright outline (a convex polygon or a disc) in such a cone.
///
/// ```
/// use glam::Vec3;
/// use lobe_core::{Cone, LobeBuffer, Receiver, SeenLight, Sphere};
/// use shading::LightLobes;
///
/// /// A sun of half-angle 0.27°.
/// struct Sun {
///     direction: Vec3,
/// }
///
/// impl LightLobes for Sun {
///     fn bounds(&self) -> Sphere {
///         Sphere { center: self.direction * 1e9, radius: 4.7e6 }
///     }
///     fn seen_from(&self, _: &Receiver) -> SeenLight {
///         let cone = Cone { axis: self.direction, one_minus_cos: 1.1e-5, distance: f32::INFINITY };
///         SeenLight::of_cone(cone, Vec3::splat(2e4))
///     }
/// }
///
/// let at = Receiver::on_surface(Vec3::ZERO, Vec3::Z, Vec3::Z);
/// let mut buffer = LobeBuffer::default();
/// Sun { direction: Vec3::Z }.light_lobes(&at, &mut buffer.writer());
/// assert!((buffer.lobes().get(0).flux.x - 1.382).abs() < 1e-3); // 2π·1.1e-5·2e4
/// ```
pub trait LightLobes {
    /// A sphere around the light: the shafts of groups of receivers end there. A light at infinity has a far away one, of the angle
    /// under which it is seen.
    fn bounds(&self) -> Sphere;

    /// A sphere around all that receivers in a sphere may ask about: their shafts end there. [`bounds`](Self::bounds) by default; less for a light
    /// at infinity, [`Outline::BEYOND`](Outline::BEYOND) times as much for a flat one, beside which blockers count as far.
    fn bounds_from(&self, receivers: &Sphere) -> Sphere {
        let _ = receivers;
        self.bounds()
    }

    /// Where the light is in that sphere, about its middle, if that is known better: as far beside the light as blockers count. Provided:
    /// `None`.
    fn extent(&self) -> Option<LightExtent> {
        None
    }

    /// The light as a receiver sees it: its cone, its radiance, and the bright outline inside the cone where that is not all of
    /// it. A light that faces away has an empty cone.
    fn seen_from(&self, at: &Receiver) -> SeenLight;

    /// The cone in which the light is seen from `at`. Provided.
    fn cone(&self, at: &Receiver) -> Cone {
        self.seen_from(at).cone
    }

    /// Radiance inside the cone, W·m⁻²·sr⁻¹ per channel. Provided.
    fn radiance(&self, at: &Receiver) -> Vec3 {
        self.seen_from(at).radiance
    }

    /// The bright part of the cone, where that is not all of it. Provided.
    fn outline(&self, at: &Receiver) -> Option<Outline> {
        self.seen_from(at).outline
    }

    /// The image that the light's outline shows: factors of its radiance, which is then their mean. None, the default, for a
    /// light of uniform radiance. Outlines of a light with an image have [sides](Outline::with_sides).
    fn image(&self) -> Option<&LightImage> {
        None
    }

    /// Whether objects hide it. Provided: they do.
    fn has_shadows(&self) -> bool {
        true
    }

    /// Appends lobes of the incident radiance (Eq. 7). Provided: the moment lobe of what is seen, whose flux and mean vector
    /// are exact.
    fn light_lobes(&self, at: &Receiver, out: &mut LobeWriter<'_>) {
        out.push(self.seen_from(at).lobe());
    }

    /// The light as all receivers of a tile see it. Provided: one [`seen_from`](Self::seen_from) after the other. A kind of light that has
    /// something faster overrides it; the results are to be the same, bit for bit.
    ///
    /// # Panics
    /// When `at` is not as long as the tile.
    fn tile_light(&self, at: &[Receiver], tile: &Tile, out: &mut TileLight) {
        out.one_by_one(tile, at.iter().map(|at| self.seen_from(at)));
    }
}

impl<L: LightLobes + ?Sized> LightLobes for Box<L> {
    fn bounds(&self) -> Sphere {
        (**self).bounds()
    }
    fn bounds_from(&self, receivers: &Sphere) -> Sphere {
        (**self).bounds_from(receivers)
    }
    fn extent(&self) -> Option<LightExtent> {
        (**self).extent()
    }
    fn seen_from(&self, at: &Receiver) -> SeenLight {
        (**self).seen_from(at)
    }
    fn image(&self) -> Option<&LightImage> {
        (**self).image()
    }
    fn light_lobes(&self, at: &Receiver, out: &mut LobeWriter<'_>) {
        (**self).light_lobes(at, out);
    }
    fn tile_light(&self, at: &[Receiver], tile: &Tile, out: &mut TileLight) {
        (**self).tile_light(at, tile, out);
    }
}

// Object-safe.
const _: fn(&dyn LightLobes) = |_| {};
