use crate::sampling::cosine_power_direction;
use crate::wgsl::ModelWgsl;
use crate::{Factors, Material, MaterialError, Packer};
use core::f32::consts::FRAC_1_PI;
use core::fmt::Debug;
use glam::Vec3;
use lobe_core::Receiver;
use shading::BrdfLobes;

/// A direction drawn in proportion to a reflectance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BrdfSample {
    /// Unit direction, above the receiver's horizon.
    pub direction: Vec3,
    /// Probability density per steradian.
    pub pdf: f32,
}

/// A reflectance as lobes for the integrators, and as `eval`, `sample`, `pdf` for the Monte-Carlo reference.
///
/// ```
/// use brdf::{Brdf, Lambert};
/// use glam::Vec3;
/// use lobe_core::Receiver;
/// let paper = Lambert { albedo: Vec3::splat(0.8) };
/// let at = Receiver::on_surface(Vec3::ZERO, Vec3::Z, Vec3::Z);
/// let drawn = paper.sample(&at, [0.1, 0.2, 0.3]).unwrap();
/// let weight = paper.eval(&at, drawn.direction) / drawn.pdf; // the albedo, for perfect importance sampling
/// assert!((weight.x - 0.8).abs() < 1e-5);
/// ```
pub trait Brdf: BrdfLobes {
    /// `f̃(v) = f_r(v, ω_o)·(n·v)` of Eq. 2, in sr⁻¹; zero where `n·v ≤ 0`.
    fn eval(&self, at: &Receiver, v: Vec3) -> Vec3;

    /// Draws a direction from three uniform numbers in [0, 1); `None` where the drawn direction is below the horizon or
    /// the material reflects nothing. Provided, together with [`pdf`](Self::pdf): in proportion to the cosine. Glossy models converge
    /// faster with something of their own.
    fn sample(&self, at: &Receiver, u: [f32; 3]) -> Option<BrdfSample> {
        let direction = cosine_power_direction(at.normal, 1.0, u[1], u[2]);
        let pdf = Brdf::pdf(self, at, direction);
        (pdf > 0.0).then_some(BrdfSample { direction, pdf })
    }

    /// Density with which [`sample`](Self::sample) draws `v`.
    fn pdf(&self, at: &Receiver, v: Vec3) -> f32 {
        at.normal.dot(v).max(0.0) * FRAC_1_PI
    }
}

/// A reflectance model with all that scenes, renderers and the reference want of it.
///
/// The built-in models are [`Material`]s by a variant of their own, all others by [`Material::Custom`]: a renderer shades both in the same
/// way. A model that has no [`wgsl`](Self::wgsl) is refused on a GPU; one that has no [`scaled`](Self::scaled) is refused under textures.
///
/// ```
/// use brdf::{Brdf, Material, MaterialError, Model};
/// use glam::Vec3;
/// use lobe_core::{BrdfLobe, Lobe, Receiver};
/// use shading::BrdfLobes;
/// use std::sync::Arc;
///
/// /// Reflects back to where the light came from, in a colour.
/// #[derive(Debug)]
/// struct Retro(Vec3);
///
/// impl BrdfLobes for Retro {
///     fn brdf_lobes(&self, at: &Receiver, out: &mut Vec<BrdfLobe>) {
///         out.push(Lobe::new(at.view, 40.0, self.0).times_cosine().into());
///     }
/// }
///
/// impl Brdf for Retro {
///     fn eval(&self, at: &Receiver, v: Vec3) -> Vec3 {
///         self.0 * (at.view.dot(v).max(0.0).powi(40) * at.normal.dot(v).max(0.0))
///     }
/// }
///
/// impl Model for Retro {
///     fn name(&self) -> &'static str {
///         "retro"
///     }
///     fn lobe_count(&self) -> usize {
///         1
///     }
/// }
///
/// let material = Material::Custom(Arc::new(Retro(Vec3::ONE)));
/// assert_eq!((material.name(), material.model().lobe_count()), ("retro", 1));
/// ```
pub trait Model: Brdf + Debug + Send + Sync {
    /// The name in messages and, for a built-in model, in scene files.
    fn name(&self) -> &'static str;

    /// Checks the parameters. Provided: nothing is wrong.
    ///
    /// # Errors
    /// [`MaterialError`] that says what is wrong.
    fn validate(&self) -> Result<(), MaterialError> {
        Ok(())
    }

    /// The most [lobes](BrdfLobes::brdf_lobes) that it has.
    fn lobe_count(&self) -> usize;

    /// The most [cosine lobes](BrdfLobes::cosine_lobes) that it has. Provided: as many.
    fn cosine_lobe_count(&self) -> usize {
        self.lobe_count()
    }

    /// The material with its parameters times factors within [0, 1], as textures give them: valid if this one is. Provided: `None`, a model
    /// without textures.
    fn scaled(&self, by: &Factors) -> Option<Material> {
        let _ = by;
        None
    }

    /// The material as it is at a point of this normal with this tangent. Provided: `None`, a model in which the tangent has no say.
    fn turned(&self, normal: Vec3, tangent: Vec3) -> Option<Material> {
        let _ = (normal, tangent);
        None
    }

    /// The material with a clear coat of this normal, where a normal map turns the base alone. Provided: `None`, a model without a clear coat.
    fn with_clearcoat_normal(&self, normal: Vec3) -> Option<Material> {
        let _ = normal;
        None
    }

    /// The part of the surface's emission that reaches the eye. Provided: all.
    fn lets_out(&self, at: &Receiver) -> f32 {
        let _ = at;
        1.0
    }

    /// The WGSL of its lobes. Provided: `None`, a model that GPUs cannot shade.
    fn wgsl(&self) -> Option<ModelWgsl> {
        None
    }

    /// The WGSL of its cosine lobes. Provided: [`wgsl`](Self::wgsl), of a model without microfacets.
    fn cosine_wgsl(&self) -> Option<ModelWgsl> {
        self.wgsl().filter(|wgsl| !wgsl.has_microfacets)
    }

    /// Writes what its [WGSL](Self::wgsl) reads, and returns the number of lobes, [`lobe_count`](Self::lobe_count) at most. Provided: no words.
    fn pack(&self, out: &mut Packer) -> u32 {
        let _ = out;
        self.lobe_count() as u32
    }

    /// The same of its [cosine lobes](Self::cosine_wgsl). Provided: [`pack`](Self::pack).
    fn cosine_pack(&self, out: &mut Packer) -> u32 {
        self.pack(out)
    }
}

/// The same object: models behind `dyn` have no other equality.
impl PartialEq for dyn Model {
    fn eq(&self, other: &Self) -> bool {
        core::ptr::addr_eq(self, other)
    }
}
