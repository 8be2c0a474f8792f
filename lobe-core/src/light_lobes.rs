//! An area light: the trait by which receivers ask for its cone, its outline and its lobes.

use crate::{Cone, LightImage, LightTerm, LobesFull, LobesMut, Outline, Receiver, Sphere, Tile, TileLight};
use glam::Vec3;

/// An area light, seen as a uniformly bright cone of directions, or as a uniformly bright convex polygon in such a cone.
///
/// ```
/// use glam::Vec3;
/// use lobe_core::{Cone, LightLobes, LobeBuffer, LobesFull, LobesMut, Lobe, OWN_NONE, Receiver, Sphere, cone_lobe};
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
///     fn cone(&self, _: &Receiver) -> Cone {
///         Cone { axis: self.direction, one_minus_cos: 1.1e-5, distance: f32::INFINITY }
///     }
///     fn radiance(&self, _: &Receiver) -> Vec3 {
///         Vec3::splat(2e4)
///     }
///     fn light_lobes(&self, at: &Receiver, out: &mut LobesMut<'_>) -> Result<(), LobesFull> {
///         let lobe = cone_lobe(&self.cone(at));
///         out.push(Lobe { flux: lobe.flux * self.radiance(at), ..lobe })
///     }
/// }
///
/// let at = Receiver { position: Vec3::ZERO, normal: Vec3::Z, face: Vec3::Z, view: Vec3::Z, object: OWN_NONE };
/// let mut buffer = LobeBuffer::with_capacity(1);
/// Sun { direction: Vec3::Z }.light_lobes(&at, &mut buffer.writer()).unwrap();
/// assert!((buffer.lobes().get(0).flux.x - 1.382).abs() < 1e-3); // 2π·1.1e-5·2e4
/// ```
pub trait LightLobes {
    /// A ball around the light: where the shafts of groups of receivers end. A light at infinity has a far away one, of the angle
    /// under which it is seen.
    fn bounds(&self) -> Sphere;

    /// A ball around what receivers in a ball may ask about: where their shafts end. [`bounds`](Self::bounds) by default; less for a light
    /// at infinity, [`Outline::BEYOND`] times as much for a flat one, whose windows are larger than it.
    fn bounds_from(&self, receivers: &Sphere) -> Sphere {
        let _ = receivers;
        self.bounds()
    }

    /// The cone in which the light is seen from `at`.
    fn cone(&self, at: &Receiver) -> Cone;

    /// Radiance inside the cone, W·m⁻²·sr⁻¹ per channel.
    fn radiance(&self, at: &Receiver) -> Vec3;

    /// The bright part of the cone, where that is not all of it: a flat light has one, and the cone is around it. None by default. A light that
    /// faces away has an empty cone.
    fn outline(&self, at: &Receiver) -> Option<Outline> {
        let _ = at;
        None
    }

    /// How bright the [outline](Self::outline) is where: factors of [`radiance`](Self::radiance), which is then their mean. None, which is
    /// the default, where all of it is as bright. Outlines of a light with an image have [sides](Outline::with_sides).
    fn image(&self) -> Option<&LightImage> {
        None
    }

    /// All but the image. Provided; the same, bit for bit.
    fn term(&self, at: &Receiver) -> LightTerm {
        LightTerm { cone: self.cone(at), radiance: self.radiance(at), outline: self.outline(at) }
    }

    /// Appends lobes of the incident radiance (Eq. 7): here the moment lobe of the cone, whose flux and mean vector
    /// are exact.
    ///
    /// # Errors
    /// [`LobesFull`] when `out` has no room.
    fn light_lobes(&self, at: &Receiver, out: &mut LobesMut<'_>) -> Result<(), LobesFull>;

    /// The light as all receivers of a tile see it. Provided: one [`term`](Self::term) after the other. A kind of light that has
    /// something faster overrides it; the terms are to be the same, bit for bit.
    ///
    /// # Panics
    /// When `at` is not as long as the tile.
    fn tile_light(&self, at: &[Receiver], tile: &Tile, out: &mut TileLight) {
        out.one_by_one(tile, at.iter().map(|at| self.term(at)));
    }
}

impl<L: LightLobes + ?Sized> LightLobes for Box<L> {
    fn bounds(&self) -> Sphere {
        (**self).bounds()
    }
    fn bounds_from(&self, receivers: &Sphere) -> Sphere {
        (**self).bounds_from(receivers)
    }
    fn cone(&self, at: &Receiver) -> Cone {
        (**self).cone(at)
    }
    fn radiance(&self, at: &Receiver) -> Vec3 {
        (**self).radiance(at)
    }
    fn outline(&self, at: &Receiver) -> Option<Outline> {
        (**self).outline(at)
    }
    fn image(&self) -> Option<&LightImage> {
        (**self).image()
    }
    fn term(&self, at: &Receiver) -> LightTerm {
        (**self).term(at)
    }
    fn light_lobes(&self, at: &Receiver, out: &mut LobesMut<'_>) -> Result<(), LobesFull> {
        (**self).light_lobes(at, out)
    }
    fn tile_light(&self, at: &[Receiver], tile: &Tile, out: &mut TileLight) {
        (**self).tile_light(at, tile, out);
    }
}

// Object-safe.
const _: fn(&dyn LightLobes) = |_| {};
