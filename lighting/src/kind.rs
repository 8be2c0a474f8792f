use crate::{Area, Light, LightError};
use core::fmt::Debug;
use glam::{Mat4, Vec3};
use lobe_core::{Outline, Sphere};
use shading::LightLobes;
use shading::gpu::GpuText;

/// A kind of light with all that scenes, renderers and the reference want of it.
///
/// The built-in kinds are [`Light`]s by a variant of their own, all others by [`Light::Custom`]: a renderer takes both in the same way. A
/// kind that has no [`wgsl`](Self::wgsl) is refused on a GPU.
///
/// ```
/// use glam::{Mat4, Vec3};
/// use lighting::{Area, Light, LightKind};
/// use lobe_core::{Cone, Receiver, SeenLight, Sphere};
/// use shading::LightLobes;
/// use std::sync::Arc;
///
/// /// A sphere whose radiance falls with height.
/// #[derive(Clone, Debug)]
/// struct Glow(Sphere);
///
/// impl LightLobes for Glow {
///     fn bounds(&self) -> Sphere {
///         self.0
///     }
///     fn seen_from(&self, at: &Receiver) -> SeenLight {
///         SeenLight::of_cone(Cone::of_sphere(at.position, self.0), self.full_radiance() * (-at.position.y).exp().min(1.0))
///     }
/// }
///
/// impl LightKind for Glow {
///     fn name(&self) -> &'static str {
///         "glow"
///     }
///     fn full_radiance(&self) -> Vec3 {
///         Vec3::ONE
///     }
///     fn moved(&self, placement: Mat4) -> Light {
///         let center = placement.transform_point3(self.0.center);
///         Light::Custom(Arc::new(Self(Sphere { center, ..self.0 })))
///     }
///     fn area(&self, _: Vec3) -> Option<Area<'_>> {
///         Some(Area::sphere(self.0))
///     }
/// }
///
/// let light = Light::Custom(Arc::new(Glow(Sphere { center: Vec3::Y, radius: 0.1 })));
/// assert_eq!(light.name(), "glow");
/// ```
pub trait LightKind: LightLobes + Debug + Send + Sync {
    /// The name in messages and of its kernels.
    fn name(&self) -> &'static str;

    /// Checks where it is and how large. Provided: that its [bounds](LightLobes::bounds) are finite.
    ///
    /// # Errors
    /// [`LightError`] that says what is wrong.
    fn validate(&self) -> Result<(), LightError> {
        LightError::check_bounds(self.bounds())
    }

    /// Its radiance where it shines, W·m⁻²·sr⁻¹ per channel: of one that shows an image the mean.
    fn full_radiance(&self) -> Vec3;

    /// The sphere that it is, for all receivers alike: what shadow maps, the paper's method and objects that show a light want to know.
    /// Provided: none.
    fn sphere(&self) -> Option<Sphere> {
        None
    }

    /// The same light somewhere else. Turns and shifts only.
    fn moved(&self, placement: Mat4) -> Light;

    /// The surface that a receiver at a point sees, for the reference; `None` where the light faces away.
    fn area(&self, from: Vec3) -> Option<Area<'_>>;

    /// The sphere around all that blocks and is lit, of a light that is farther away than all of it or everywhere. Provided: `None`, a light
    /// that has a place.
    fn world(&self) -> Option<Sphere> {
        None
    }

    /// Such a light for another [`world`](Self::world). Provided: `None`.
    fn in_world(&self, world: Sphere) -> Option<Light> {
        let _ = world;
        None
    }

    /// Distance of a point from the surface that emits; `None` for lights at infinity and those without a surface. Provided: that of the
    /// [sphere](Self::sphere).
    fn distance_to(&self, point: Vec3) -> Option<f32> {
        self.sphere().map(|sphere| (point.distance(sphere.center) - sphere.radius).abs())
    }

    /// Of a light that may have an [outline](LightLobes::outline) its [roundness](Outline::roundness), by which masks are made finer.
    /// Provided: none, a light that is always a cone.
    fn roundness(&self) -> Option<f32> {
        None
    }

    /// Name and text of its WGSL ([`GpuLight::WGSL`](shading::gpu::GpuLight::WGSL) says what that defines). Provided: `None`, a light that
    /// GPUs cannot shade with.
    fn wgsl(&self) -> Option<GpuText> {
        None
    }

    /// A sphere around the light and, of one with an outline, around windows on it: `frame.light` of its WGSL. Provided.
    fn gpu_bounds(&self) -> Sphere {
        match self.roundness() {
            Some(_) => Outline::sphere_around(self.bounds()),
            None => self.bounds(),
        }
    }

    /// The first rows of `frame.shape`, which its WGSL reads, 26 at most. Provided: none.
    fn gpu_shape(&self) -> Vec<[f32; 4]> {
        Vec::new()
    }
}

/// The same object: kinds behind `dyn` have no other equality.
impl PartialEq for dyn LightKind {
    fn eq(&self, other: &Self) -> bool {
        core::ptr::addr_eq(self, other)
    }
}
