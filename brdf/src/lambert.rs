use crate::error::check_coefficient;
use crate::sampling::{density, draw};
use crate::shape::Diffuse;
use crate::term::Term;
use crate::wgsl::{MATERIAL, ModelWgsl};
use crate::{Brdf, BrdfSample, Factors, Material, MaterialError, Model, Packer};
use core::f32::consts::FRAC_1_PI;
use glam::Vec3;
use lobe_core::wgsl::Piece;
use lobe_core::{BrdfLobe, Lobe, Receiver};
use shading::BrdfLobes;

/// An ideally diffuse surface: `f̃(v) = ρ/π·max(n·v, 0)` (Eq. 25 with `kd = ρ/π`).
///
/// One lobe of exponent exactly 1 whose axis is exactly the receiver's normal.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lambert {
    /// Albedo ρ: the fraction of light reflected, per channel. Above 1 the surface creates energy.
    pub albedo: Vec3,
}

impl Lambert {
    pub(crate) fn lobes(&self, at: &Receiver) -> impl Iterator<Item = Lobe> + Clone + use<> {
        self.term(0).and_then(|term| term.lobe(at)).into_iter()
    }

    pub(crate) fn term(&self, place: usize) -> Option<Term<'static>> {
        (place == 0).then_some(Term::Diffuse(Diffuse(self.albedo)))
    }
}

impl BrdfLobes for Lambert {
    fn brdf_lobes(&self, at: &Receiver, out: &mut Vec<BrdfLobe>) {
        out.extend(self.lobes(at).map(BrdfLobe::Cosine));
    }
}

impl Brdf for Lambert {
    fn eval(&self, at: &Receiver, v: Vec3) -> Vec3 {
        self.albedo * (FRAC_1_PI * at.normal.dot(v).max(0.0))
    }

    fn sample(&self, at: &Receiver, u: [f32; 3]) -> Option<BrdfSample> {
        draw(self.lobes(at), at.normal, u)
    }

    fn pdf(&self, at: &Receiver, v: Vec3) -> f32 {
        density(self.lobes(at), at.normal, v)
    }
}

static WGSL: Piece = Piece::new(include_str!("lambert.wgsl")).needs(&[&MATERIAL]);

/// The albedo is finite and not negative.
impl Model for Lambert {
    fn name(&self) -> &'static str {
        "lambert"
    }

    fn validate(&self) -> Result<(), MaterialError> {
        check_coefficient("albedo", self.albedo)
    }

    fn lobe_count(&self) -> usize {
        1
    }

    fn scaled(&self, by: &Factors) -> Option<Material> {
        Some(Self { albedo: self.albedo * by.color }.into())
    }

    fn wgsl(&self) -> Option<ModelWgsl> {
        Some(ModelWgsl::new("lambert", &WGSL))
    }

    fn pack(&self, out: &mut Packer) -> u32 {
        out.push_diffuse(self.albedo)
    }
}
